//! Hypoelasticity in the rotated frame of Flanagan and Taylor [P 4.45-4.57], and plasticity of von Mises in it.
//!
//! Between the committed gradient F0 and F1: l = (F1 - F0) (F0/2 + F1/2)^-1, d and w its parts;
//! p = -1/2 e:w, z_i = e_ikj d_jm v_mk, q = p + (tr v I - v)^-1 z, Omega_ij = e_ikj q_k, |Omega| = |q|,
//! Q = I + sin|Omega|/|Omega| Omega + (1 - cos|Omega|)/|Omega|^2 Omega^2, R <- Q R, v <- v + l v - v Omega,
//! e = R^T d R, s <- s + 2 G dev e + K tr e I, P = J R s R^T F^-T. A step of time is in none of these.
//!
//! The published update turns by |Omega| where the increment turns by 2 atan(|Omega|/2), and lets v grow with the
//! square of the turn: a body that spins loses its frame. Two things keep it. An increment that is a turn but for a
//! thousandth ([`SPIN`]) is taken as the turn that it is, with v = F R^T; and where v R has strayed from F by a tenth
//! ([`STRAYED`]) both start anew from F's polar decomposition.
//!
//! J2: where q = sqrt(3/2)|dev s| is above Y + H a, dev s shrinks by 1 - 3 G da/q with da = (q - Y - H a)/(3 G + H).

use super::Law;
use crate::tensor::{
    Tensor, Vector, add_outer, applied, contracted, determinant, difference, eigen, identity,
    inverse, product, read, scaled, sum, symmetric, trace, transposed, zero,
};

/// Yield stress in uniaxial tension and hardening modulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plastic {
    pub(crate) yield_stress: f64,
    pub(crate) hardening: f64,
}

/// What a material remembers. All is 0 at rest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Memory {
    /// F - I
    pub(crate) gradient: Tensor<3>,
    /// R - I
    rotation: Tensor<3>,
    /// v - I
    stretch: Tensor<3>,
    /// Cauchy stress in the rotated frame.
    stress: Tensor<3>,
    /// Work of the stress per reference volume.
    work: f64,
    /// Part of it that is not given back.
    pub(crate) dissipated: f64,
    /// a
    pub(crate) equivalent: f64,
    /// In the rotated frame.
    pub(crate) plastic_strain: Tensor<3>,
}

/// |d| over |w| below which an increment is a turn.
pub(super) const SPIN: f64 = 1e-3;

/// |v R - F| over |F|.
pub(super) const STRAYED: f64 = 0.1;

/// Numbers in which it is kept.
pub(crate) const NUMBERS: usize = 48;

impl Memory {
    pub(crate) fn read(numbers: &[f64]) -> Self {
        let tensor = |from: usize| read(&numbers[from..]);
        Self {
            gradient: tensor(0),
            rotation: tensor(9),
            stretch: tensor(18),
            stress: tensor(27),
            plastic_strain: tensor(36),
            work: numbers[45],
            dissipated: numbers[46],
            equivalent: numbers[47],
        }
    }

    pub(crate) fn write(&self, numbers: &mut [f64]) {
        let tensors =
            [&self.gradient, &self.rotation, &self.stretch, &self.stress, &self.plastic_strain];
        for (numbers, tensor) in numbers.chunks_exact_mut(9).zip(tensors) {
            numbers.copy_from_slice(tensor.as_flattened());
        }
        numbers[45..NUMBERS].copy_from_slice(&[self.work, self.dissipated, self.equivalent]);
    }

    /// Energy that the material would give back.
    pub(crate) fn elastic(&self) -> f64 {
        self.work - self.dissipated
    }

    /// P = J R s R^T F^-T; not a number where the body is turned inside out.
    pub(crate) fn first_piola_stress(&self) -> Tensor<3> {
        if self.stress == zero() {
            return zero();
        }
        let (full, rotation) = (plus_one(&self.gradient), plus_one(&self.rotation));
        let jacobian = determinant(&full);
        let jacobian = if jacobian > 0.0 { jacobian } else { f64::NAN };
        let turned = product(&product(&rotation, &self.stress), &transposed(&rotation));
        scaled(&product(&turned, &transposed(&inverse(&full))), jacobian)
    }

    /// After a move to another F - I.
    pub(crate) fn moved(&self, law: &Law, plastic: Option<Plastic>, gradient: &Tensor<3>) -> Self {
        if *gradient == self.gradient {
            return *self;
        }
        let mut next = Self { gradient: *gradient, ..*self };
        let increment = difference(gradient, &self.gradient);
        let midway = plus_one(&scaled(&sum(gradient, &self.gradient), 0.5));
        let rate = product(&increment, &inverse(&midway));
        let (deforming, spinning) = (symmetric(&rate), skew(&rate));
        let stretch = plus_one(&self.stretch);

        // q = p + (tr v I - v)^-1 z
        let twist = product(&deforming, &stretch);
        let spin = axial(&spinning, -0.5);
        let rest = difference(&scaled(&identity(), trace(&stretch)), &stretch);
        let lead = applied(&inverse(&rest), &axial(&transposed(&twist), 1.0));
        let q: Vector<3> = std::array::from_fn(|axis| spin[axis] + lead[axis]);
        let omega: Tensor<3> = [[0.0, -q[2], q[1]], [q[2], 0.0, -q[0]], [-q[1], q[0], 0.0]];
        let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let spins =
            contracted(&deforming, &deforming) <= SPIN * SPIN * contracted(&spinning, &spinning);
        if size > 0.0 {
            let angle = if spins { 2.0 * (0.5 * size).atan() } else { size };
            // 1 - cos x = 2 sin^2 (x/2) keeps its digits.
            let half = (0.5 * angle).sin() / size;
            let turn = sum(
                &scaled(&omega, angle.sin() / size),
                &scaled(&product(&omega, &omega), 2.0 * half * half),
            );
            let turned = sum(&self.rotation, &product(&turn, &self.rotation));
            next.rotation = sum(&turned, &turn);
        }
        if spins {
            next.stretch = next.stretch_of_rotation();
        } else {
            let change = difference(&product(&rate, &stretch), &product(&stretch, &omega));
            next.stretch = sum(&self.stretch, &change);
            next.recover();
        }

        let rotation = plus_one(&next.rotation);
        let strain = product(&transposed(&rotation), &product(&deforming, &rotation));
        let (lambda, mu) = law.solid();
        next.stress = sum(
            &self.stress,
            &sum(&scaled(&strain, 2.0 * mu), &scaled(&identity(), lambda * trace(&strain))),
        );
        if let Some(plastic) = plastic {
            next.flow(plastic, mu, &self.stress);
        }
        let mean = scaled(&sum(&self.first_piola_stress(), &next.first_piola_stress()), 0.5);
        next.work += contracted(&mean, &increment);
        next
    }

    /// v - I that belongs to F and R.
    fn stretch_of_rotation(&self) -> Tensor<3> {
        let (full, rotation) = (plus_one(&self.gradient), plus_one(&self.rotation));
        let product = product(&full, &transposed(&rotation));
        difference(&symmetric(&product), &identity())
    }

    /// Takes R and v from the polar decomposition of F where they have strayed.
    fn recover(&mut self) {
        let full = plus_one(&self.gradient);
        let apart =
            difference(&product(&plus_one(&self.stretch), &plus_one(&self.rotation)), &full);
        let strayed = contracted(&apart, &apart) > STRAYED * STRAYED * contracted(&full, &full);
        if !strayed && apart.as_flattened().iter().all(|value| value.is_finite()) {
            return;
        }
        let (squares, axes) = eigen(&product(&transposed(&full), &full));
        // U^-1 = sum a a^T/stretch
        let mut inverse = zero();
        for (axis, square) in squares.iter().enumerate() {
            let direction: Vector<3> = std::array::from_fn(|row| axes[row][axis]);
            add_outer(&mut inverse, square.powf(-0.5), &direction, &direction);
        }
        self.rotation = difference(&product(&full, &inverse), &identity());
        self.stretch = self.stretch_of_rotation();
    }

    /// Returns the stress to the yield surface.
    fn flow(&mut self, plastic: Plastic, mu: f64, before: &Tensor<3>) {
        let Plastic { yield_stress, hardening } = plastic;
        let pressure = trace(&self.stress) / 3.0;
        let deviator = difference(&self.stress, &scaled(&identity(), pressure));
        let size = (1.5 * contracted(&deviator, &deviator)).sqrt();
        let beyond = size - (yield_stress + hardening * self.equivalent);
        if beyond <= 0.0 || beyond.is_nan() {
            return;
        }
        let amount = beyond / (3.0 * mu + hardening);
        self.equivalent += amount;
        let flowed = scaled(&deviator, 1.5 * amount / size);
        self.plastic_strain = sum(&self.plastic_strain, &flowed);
        self.stress = difference(&self.stress, &scaled(&flowed, 2.0 * mu));
        // By the trapezoid, as the work: what is left of the work is what springs hold. Per reference volume.
        let jacobian = determinant(&plus_one(&self.gradient));
        self.dissipated += 0.5 * jacobian * contracted(&sum(before, &self.stress), &flowed);
    }
}

fn plus_one(tensor: &Tensor<3>) -> Tensor<3> {
    sum(&identity(), tensor)
}

fn skew(tensor: &Tensor<3>) -> Tensor<3> {
    scaled(&difference(tensor, &transposed(tensor)), 0.5)
}

/// factor e_ijk a_jk
fn axial(a: &Tensor<3>, factor: f64) -> Vector<3> {
    [a[1][2] - a[2][1], a[2][0] - a[0][2], a[0][1] - a[1][0]].map(|value| factor * value)
}
