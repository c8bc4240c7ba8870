//! Hypoelasticity and its plasticity, as in `hypoelastic`, at eight sites at once.
//!
//! Sweeps over families put gradients into records and leave the law for later ([`Law::defer`]); [`Settle`] then asks it for all
//! sites that wait, wherever they stand. Turns by more than a radian at once, lost frames and what is no number go to the law of
//! single sites.
#![allow(clippy::needless_range_loop)] // an axis goes through several arrays

use super::hypoelastic::{NUMBERS, SPIN, STRAYED};
use super::remember::TRIES;
use super::{DISSIPATED, Deformation, ENERGY, Kind, Law, MEMORY, PENDING};
use crate::families::LANES;
use crate::kernel::elastic::{cofactors, trace};
use crate::kernel::simd::{Kernel, Lanes, Mask, Simd, read_records};
use crate::tensor::{Tensor, read, resized};

/// What a record has at [`PENDING`] while its gradient waits for [`Settle`], and one of a plate in plane stress; 1 waits for a
/// function of the host's.
const DEFERRED: f64 = 2.0;
const DEFERRED_PLATE: f64 = 3.0;

/// Lanes of a tensor in space.
type Lanewise<F> = [[F; 3]; 3];

impl Law {
    /// Puts a deformation into the record `new` for [`Settle`], whatever it holds; gives whether the law is one for it.
    pub(crate) fn defer<const D: usize>(
        &self,
        deformation: &Deformation<D>,
        new: &mut [f64],
    ) -> bool {
        if !matches!(self.kind, Kind::Hypoelastic(_)) || deformation.rank < D {
            return false;
        }
        let gradient: Tensor<3> = resized(&deformation.gradient);
        new[MEMORY..MEMORY + 9].copy_from_slice(gradient.as_flattened());
        new[PENDING] = if self.free[D] > 0 { DEFERRED_PLATE } else { DEFERRED };
        true
    }
}

/// Asks the laws of all sites that wait, each once.
pub(crate) struct Settle<'a, 'l> {
    /// The law of each site.
    pub(crate) law: &'a dyn Fn(usize) -> &'l Law,
    /// Committed records of the sites, and new ones.
    pub(crate) old: &'a [f64],
    pub(crate) new: &'a mut [f64],
    /// Numbers of a record: a multiple of four.
    pub(crate) width: usize,
    pub(crate) flows: bool,
}

impl Kernel for Settle<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let count = self.new.len() / self.width;
        let (mut sites, mut waiting) = ([0; LANES], 0);
        for site in 0..count {
            if self.new[site * self.width + PENDING] < DEFERRED {
                continue;
            }
            sites[waiting] = site;
            waiting += 1;
            if waiting == S::WIDTH {
                self.settle(simd, &sites, waiting);
                waiting = 0;
            }
        }
        if waiting > 0 {
            for lane in waiting..S::WIDTH {
                sites[lane] = sites[0];
            }
            self.settle(simd, &sites, waiting);
        }
    }
}

impl Settle<'_, '_> {
    /// Asks the laws of the first sites, which are `waiting`.
    #[inline(always)]
    fn settle<S: Simd>(&mut self, simd: S, sites: &[usize; LANES], waiting: usize) {
        let mut before = [simd.splat(0.0); NUMBERS];
        let mut now = [simd.splat(0.0); 12];
        for (records, numbers) in [(self.old, &mut before[..]), (&*self.new, &mut now[..])] {
            let mut at = [0; LANES];
            for lane in 0..S::WIDTH {
                at[lane] = (sites[lane] * self.width + MEMORY) / 4;
            }
            read_records(simd, records.as_chunks().0, &at, numbers);
        }
        let (mut constants, mut plates) = ([[0.0; LANES]; 4], 0);
        for lane in 0..S::WIDTH {
            let pending = self.new[sites[lane] * self.width + PENDING];
            plates |= u8::from(pending == DEFERRED_PLATE) << lane;
            let law = (self.law)(sites[lane]);
            let (lambda, mu) = law.solid();
            let (limit, hardening) = match law.kind {
                Kind::Hypoelastic(Some(plastic)) if self.flows => {
                    (plastic.yield_stress, plastic.hardening)
                }
                _ => (f64::INFINITY, 0.0),
            };
            for (constant, value) in constants.iter_mut().zip([lambda, mu, limit, hardening]) {
                constant[lane] = value;
            }
        }
        let [lambda, mu, limit, hardening] = [0, 1, 2, 3].map(|k| simd.load(&constants[k]));
        let (memory, gradient) = (Memory::of(&before), tensor(&now, 0));
        let constants = [lambda, mu, limit, hardening];
        let moved = memory.settled(simd, gradient, simd.mask(plates), constants);
        let mut numbers = [[0.0; LANES]; MEMORY + NUMBERS];
        moved.next.store(&moved.stress, &mut numbers);
        for lane in 0..waiting {
            let own = sites[lane] * self.width..(sites[lane] + 1) * self.width;
            let (old, new) = (&self.old[own.clone()], &mut self.new[own]);
            new[PENDING] = 0.0;
            if moved.strange >> lane & 1 != 0 {
                let (law, gradient) = ((self.law)(sites[lane]), read::<3>(&new[MEMORY..]));
                new.copy_from_slice(old);
                if plates >> lane & 1 != 0 {
                    let plane = Deformation::<2>::whole(&resized(&gradient));
                    law.remember(&plane, old, new, self.flows);
                } else {
                    law.remember(&Deformation::whole(&gradient), old, new, self.flows);
                }
                continue;
            }
            let (known, rest) = new.split_at_mut(MEMORY + NUMBERS);
            for (new, number) in known.iter_mut().zip(&numbers) {
                *new = number[lane];
            }
            // Where a law of the host's keeps more.
            rest.copy_from_slice(&old[MEMORY + NUMBERS..]);
        }
    }
}

/// As [`super::hypoelastic::Memory`].
#[derive(Clone, Copy)]
struct Memory<F> {
    gradient: Lanewise<F>,
    rotation: Lanewise<F>,
    stretch: Lanewise<F>,
    stress: Lanewise<F>,
    plastic_strain: Lanewise<F>,
    work: F,
    dissipated: F,
    equivalent: F,
}

/// What a move leads to.
struct Moved<F> {
    next: Memory<F>,
    /// P
    stress: Lanewise<F>,
    /// Lanes that are for the law of single sites.
    strange: u8,
}

#[inline(always)]
fn tensor<F: Copy>(numbers: &[F], first: usize) -> Lanewise<F> {
    let mut tensor = [[numbers[0]; 3]; 3];
    for row in 0..3 {
        for column in 0..3 {
            tensor[row][column] = numbers[first + 3 * row + column];
        }
    }
    tensor
}

impl<F: Lanes> Memory<F> {
    #[inline(always)]
    fn of(numbers: &[F; NUMBERS]) -> Self {
        Self {
            gradient: tensor(numbers, 0),
            rotation: tensor(numbers, 9),
            stretch: tensor(numbers, 18),
            stress: tensor(numbers, 27),
            plastic_strain: tensor(numbers, 36),
            work: numbers[45],
            dissipated: numbers[46],
            equivalent: numbers[47],
        }
    }

    /// Writes the numbers of a record.
    #[inline(always)]
    fn store(&self, stress: &Lanewise<F>, numbers: &mut [[f64; LANES]; MEMORY + NUMBERS]) {
        let tensors = [
            (0, stress),
            (MEMORY, &self.gradient),
            (MEMORY + 9, &self.rotation),
            (MEMORY + 18, &self.stretch),
            (MEMORY + 27, &self.stress),
            (MEMORY + 36, &self.plastic_strain),
        ];
        for (first, tensor) in tensors {
            for row in 0..3 {
                for column in 0..3 {
                    tensor[row][column].store(&mut numbers[first + 3 * row + column]);
                }
            }
        }
        (self.work - self.dissipated).store(&mut numbers[ENERGY]);
        self.dissipated.store(&mut numbers[DISSIPATED]);
        self.work.store(&mut numbers[MEMORY + 45]);
        self.dissipated.store(&mut numbers[MEMORY + 46]);
        self.equivalent.store(&mut numbers[MEMORY + 47]);
    }

    /// After a move to another F - I, which plates stretch across until they have no stress there, as in `remember`.
    #[inline(always)]
    fn settled<S: Simd<Lanes = F, Mask = F::Mask>>(
        &self,
        simd: S,
        mut gradient: Lanewise<F>,
        plates: S::Mask,
        constants: [F; 4],
    ) -> Moved<F> {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let [lambda, mu, ..] = constants;
        let elastic = lambda + mu + mu;
        let mut stretch = self.gradient[2][2] + one;
        let (mut last, mut at, mut rigid) = (zero, zero, elastic);
        let (mut active, mut strange, mut tries) = (plates, 0, 0);
        loop {
            gradient[2][2] = (stretch - one).or(plates, gradient[2][2]);
            let mut moved = self.moved(simd, &gradient, constants);
            strange |= moved.strange & (active.bits() | !plates.bits());
            let now = moved.stress[2][2];
            if tries > 0 {
                // The secant; back to the elastic slope where it is none.
                let secant = (now - last) / (stretch - at);
                rigid = secant.or(secant.above(elastic * simd.splat(1e-3)), elastic);
            }
            let step = (zero - now) / rigid;
            active = active & step.max(zero - step).above(simd.splat(1e-16));
            if active.bits() == 0 || tries == TRIES {
                moved.strange = strange;
                return moved;
            }
            (last, at) = (now, stretch);
            stretch = (stretch + step).or(active, stretch);
            tries += 1;
        }
    }

    /// After a move to another F - I, with lambda, mu, Y and H.
    #[inline(always)]
    fn moved<S: Simd<Lanes = F>>(
        &self,
        simd: S,
        gradient: &Lanewise<F>,
        [lambda, mu, limit, hardening]: [F; 4],
    ) -> Moved<F> {
        let (zero, one, half) = (simd.splat(0.0), simd.splat(1.0), simd.splat(0.5));
        let increment = each(gradient, &self.gradient, |now, before| now - before);
        let middle = each(gradient, &self.gradient, |now, before| (now + before) * half);
        let middle = plus(&middle, one);
        // l = increment F^-1 at the middle
        let cofactors_there = cofactors(simd, &middle);
        let inverse = one / determinant(&middle, &cofactors_there);
        let rate = times(&product::<F, false, true>(&increment, &cofactors_there), inverse);
        let deforming = each(&rate, &transposed(&rate), |a, b| (a + b) * half);
        let spinning = each(&rate, &transposed(&rate), |a, b| (a - b) * half);
        let stretch = plus(&self.stretch, one);

        // q = p + (tr v I - v)^-1 z
        let twist = product::<F, false, false>(&deforming, &stretch);
        let rest = each(&plus(&[[zero; 3]; 3], trace(&stretch)), &stretch, |a, b| a - b);
        let rest_cofactors = cofactors(simd, &rest);
        let rest_inverse = one / determinant(&rest, &rest_cofactors);
        let z = axial(&twist, zero - one);
        let mut q = axial(&spinning, zero - half);
        for axis in 0..3 {
            let mut lead = rest_cofactors[0][axis] * z[0];
            for other in 1..3 {
                lead = rest_cofactors[other][axis].mul_add(z[other], lead);
            }
            q[axis] = lead.mul_add(rest_inverse, q[axis]);
        }
        let square = q[2].mul_add(q[2], q[1].mul_add(q[1], q[0] * q[0]));
        let omega =
            [[zero, zero - q[2], q[1]], [q[2], zero, zero - q[0]], [zero - q[1], q[0], zero]];
        let least = contracted(&spinning, &spinning) * simd.splat(SPIN * SPIN);
        let deforms = contracted(&deforming, &deforming).above(least);
        // Of a turn: sin x = x/(1 + x^2/4) and 2 sin^2 (x/2) = x^2/2/(1 + x^2/4) of x = 2 atan(|q|/2), over |q| and |q|^2.
        let spun = one / (square * simd.splat(0.25) + one);
        let [sine, versed] = sines(simd, square);
        let (sine, versed) = (sine.or(deforms, spun), versed.or(deforms, spun * half));
        let mut turn = omega;
        for row in 0..3 {
            for column in 0..3 {
                let mut twice = q[row] * q[column];
                if row == column {
                    twice = twice - square;
                }
                turn[row][column] = omega[row][column].mul_add(sine, twice * versed);
            }
        }
        let turned = product::<F, false, false>(&turn, &self.rotation);
        let turned = each(&self.rotation, &turned, |a, b| a + b);
        let mut next = *self;
        next.gradient = *gradient;
        next.rotation = each(&turned, &turn, |a, b| a + b);
        let (full, rotation) = (plus(gradient, one), plus(&next.rotation, one));

        // v, by its rate or from F and R
        let by_rate = each(
            &product::<F, false, false>(&rate, &stretch),
            &product::<F, false, false>(&stretch, &omega),
            |a, b| a - b,
        );
        let by_rate = each(&self.stretch, &by_rate, |a, b| a + b);
        let of_rotation = product::<F, false, true>(&full, &rotation);
        let of_rotation = each(&of_rotation, &transposed(&of_rotation), |a, b| (a + b) * half);
        let of_rotation = plus(&of_rotation, zero - one);
        next.stretch = each(&by_rate, &of_rotation, |a, b| a.or(deforms, b));
        let apart = product::<F, false, false>(&plus(&next.stretch, one), &rotation);
        let apart = each(&apart, &full, |a, b| a - b);
        let near = contracted(&full, &full) * simd.splat(STRAYED * STRAYED);
        let near = near.above(contracted(&apart, &apart));
        let small = simd.splat(LARGEST).above(square);
        let size = contracted(&increment, &increment);
        let known = size.above(simd.splat(-1.0));
        let strange = !((near & small).bits() | !deforms.bits()) | !known.bits();

        let strain = product::<F, true, false>(
            &rotation,
            &product::<F, false, false>(&deforming, &rotation),
        );
        let pressure = lambda * trace(&strain);
        let stress = each(&self.stress, &strain, |a, b| (mu + mu).mul_add(b, a));
        next.stress = plus(&stress, pressure);

        // Back to the yield surface
        let cofactors_now = cofactors(simd, &full);
        let jacobian = determinant(&full, &cofactors_now);
        let deviator = plus(&next.stress, trace(&next.stress) * simd.splat(-1.0 / 3.0));
        let equal = (contracted(&deviator, &deviator) * simd.splat(1.5)).sqrt();
        let beyond = equal - hardening.mul_add(self.equivalent, limit);
        let flows = beyond.above(zero);
        if flows.bits() != 0 {
            let amount = beyond / (mu * simd.splat(3.0) + hardening);
            next.equivalent = self.equivalent + amount.only(flows);
            let share = amount * simd.splat(1.5) / equal;
            let flowed = each(&deviator, &deviator, |a, _| (a * share).only(flows));
            next.plastic_strain = each(&self.plastic_strain, &flowed, |a, b| a + b);
            next.stress = each(&next.stress, &flowed, |a, b| (mu + mu).mul_sub_from(b, a));
            let both = each(&self.stress, &next.stress, |a, b| a + b);
            let lost = jacobian * contracted(&both, &flowed) * half;
            next.dissipated = self.dissipated + lost.only(flows);
        }

        let full_before = plus(&self.gradient, one);
        let cofactors_before = cofactors(simd, &full_before);
        let jacobian_before = determinant(&full_before, &cofactors_before);
        let rotation_before = plus(&self.rotation, one);
        let before =
            piola(simd, &self.stress, &rotation_before, &cofactors_before, jacobian_before);
        let now = piola(simd, &next.stress, &rotation, &cofactors_now, jacobian);
        let both = each(&before, &now, |a, b| a + b);
        next.work = (contracted(&both, &increment)).mul_add(half, self.work);

        // What has not moved is as it was, to the last bit.
        let moves = size.above(zero);
        let choose = |new: &Lanewise<F>, old: &Lanewise<F>| each(new, old, |a, b| a.or(moves, b));
        let next = Self {
            gradient: *gradient,
            rotation: choose(&next.rotation, &self.rotation),
            stretch: choose(&next.stretch, &self.stretch),
            stress: choose(&next.stress, &self.stress),
            plastic_strain: choose(&next.plastic_strain, &self.plastic_strain),
            work: next.work.or(moves, self.work),
            dissipated: next.dissipated.or(moves, self.dissipated),
            equivalent: next.equivalent.or(moves, self.equivalent),
        };
        Moved { next, stress: choose(&now, &before), strange }
    }
}

/// The largest |q|^2 that [`sines`] is good for.
const LARGEST: f64 = 1.0;

/// sin x/x and (1 - cos x)/x^2 of x^2, by their series.
#[inline(always)]
fn sines<S: Simd>(simd: S, square: S::Lanes) -> [S::Lanes; 2] {
    let square = simd.splat(0.0) - square;
    let (mut sine, mut versed) = (simd.splat(1.0), simd.splat(1.0));
    // 1 - x^2/(2 3) (1 - x^2/(4 5) (1 - ...)), and half of 1 - x^2/(3 4) (1 - x^2/(5 6) (1 - ...))
    for term in 1..10 {
        let k = f64::from(2 * (10 - term));
        let one = simd.splat(1.0);
        sine = (sine * square).mul_add(simd.splat(1.0 / (k * (k + 1.0))), one);
        versed = (versed * square).mul_add(simd.splat(1.0 / ((k + 1.0) * (k + 2.0))), one);
    }
    [sine, versed * simd.splat(0.5)]
}

/// P = J R s R^T F^-T = R s R^T cof F; not a number where J is not positive.
#[inline(always)]
fn piola<S: Simd>(
    simd: S,
    stress: &Lanewise<S::Lanes>,
    rotation: &Lanewise<S::Lanes>,
    cofactors: &Lanewise<S::Lanes>,
    jacobian: S::Lanes,
) -> Lanewise<S::Lanes> {
    let turned = product::<_, false, false>(rotation, stress);
    let turned = product::<_, false, true>(&turned, rotation);
    let stands = jacobian.above(simd.splat(0.0));
    let pulled = product::<_, false, false>(&turned, cofactors);
    each(&pulled, &pulled, |a, _| a.or(stands, simd.splat(f64::NAN)))
}

#[inline(always)]
fn each<F: Copy>(a: &Lanewise<F>, b: &Lanewise<F>, of: impl Fn(F, F) -> F) -> Lanewise<F> {
    let mut result = *a;
    for row in 0..3 {
        for column in 0..3 {
            result[row][column] = of(a[row][column], b[row][column]);
        }
    }
    result
}

#[inline(always)]
fn times<F: Lanes>(a: &Lanewise<F>, factor: F) -> Lanewise<F> {
    each(a, a, |a, _| a * factor)
}

/// a + number I
#[inline(always)]
fn plus<F: Lanes>(a: &Lanewise<F>, number: F) -> Lanewise<F> {
    let mut result = *a;
    for axis in 0..3 {
        result[axis][axis] = a[axis][axis] + number;
    }
    result
}

#[inline(always)]
fn transposed<F: Lanes>(a: &Lanewise<F>) -> Lanewise<F> {
    let mut result = *a;
    for row in 0..3 {
        for column in 0..3 {
            result[row][column] = a[column][row];
        }
    }
    result
}

/// A B, with A^T in the place of A, or B^T in that of B.
#[inline(always)]
fn product<F: Lanes, const LEFT: bool, const RIGHT: bool>(
    a: &Lanewise<F>,
    b: &Lanewise<F>,
) -> Lanewise<F> {
    let (a, b) = (if LEFT { transposed(a) } else { *a }, if RIGHT { transposed(b) } else { *b });
    let mut result = a;
    for row in 0..3 {
        for column in 0..3 {
            let sum = a[row][1].mul_add(b[1][column], a[row][0] * b[0][column]);
            result[row][column] = a[row][2].mul_add(b[2][column], sum);
        }
    }
    result
}

/// A : B
#[inline(always)]
fn contracted<F: Lanes>(a: &Lanewise<F>, b: &Lanewise<F>) -> F {
    let mut sum = a[0][0] * b[0][0];
    for k in 1..9 {
        sum = a[k / 3][k % 3].mul_add(b[k / 3][k % 3], sum);
    }
    sum
}

#[inline(always)]
fn determinant<F: Lanes>(a: &Lanewise<F>, cofactors: &Lanewise<F>) -> F {
    let sum = a[0][1].mul_add(cofactors[0][1], a[0][0] * cofactors[0][0]);
    a[0][2].mul_add(cofactors[0][2], sum)
}

/// factor e_ijk a_jk
#[inline(always)]
fn axial<F: Lanes>(a: &Lanewise<F>, factor: F) -> [F; 3] {
    [(a[1][2] - a[2][1]) * factor, (a[2][0] - a[0][2]) * factor, (a[0][1] - a[1][0]) * factor]
}
