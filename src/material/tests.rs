//! Laws in lanes against the same laws asked one by one.

use super::{DISSIPATED, Deformation, Law, MEMORY, Settle, record_width};
use crate::kernel::elastic::{ElasticLaw, LaneLaw};
use crate::kernel::simd::{Kernel, Lanes, Simd, SimdLevel};
use crate::model::Model;
use crate::tensor::{
    Tensor, contracted, difference, identity, inverse, product, read, resized, scaled, sum,
};

/// Numbers between -1 and 1 in no order.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        2.0 * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64) - 1.0
    }

    fn gradient<const D: usize>(&mut self, size: f64) -> Tensor<D> {
        std::array::from_fn(|_| std::array::from_fn(|_| size * self.next()))
    }
}

fn law(material: &str, plane: Option<&str>, poissons_ratio: f64) -> Law {
    let mut model = Model::new("correspondence").unwrap();
    model.choose("material", material).unwrap();
    for (key, value) in [("youngs_modulus", 3.0), ("poissons_ratio", poissons_ratio)] {
        model.set(key, value).unwrap();
    }
    if material == "j2_plastic" {
        model.set("yield_stress", 3e-3).unwrap();
        model.set("hardening_modulus", 0.5).unwrap();
    }
    if let Some(plane) = plane {
        model.choose("plane", plane).unwrap();
    }
    Law::new(&model, if plane.is_some() { 2 } else { 3 }).unwrap()
}

/// Asks eight laws at eight gradients.
struct Ask<'a, const D: usize> {
    laws: &'a [ElasticLaw; 8],
    gradients: &'a [Tensor<D>; 8],
    weight: f64,
}

/// Energy and stress, eight times.
type Answers<const D: usize> = [(f64, Tensor<D>); 8];

fn answers<S: Simd, const D: usize>(
    found: &mut Answers<D>,
    first: usize,
    (energy, stress): (S::Lanes, [[S::Lanes; D]; D]),
) {
    let values = |lanes: S::Lanes| {
        let mut values = [0.0; 8];
        lanes.store(&mut values);
        values
    };
    for lane in 0..S::WIDTH {
        found[first + lane] =
            (values(energy)[lane], stress.map(|row| row.map(|at| values(at)[lane])));
    }
}

impl<const D: usize> Kernel for Ask<'_, D> {
    type Output = (Answers<D>, Answers<D>);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let (mut each, mut first) = ([(0.0, [[0.0; D]; D]); 8], [(0.0, [[0.0; D]; D]); 8]);
        for lane in (0..8).step_by(S::WIDTH) {
            let gradient: [[S::Lanes; D]; D] = std::array::from_fn(|row| {
                std::array::from_fn(|column| simd.each(|k| self.gradients[lane + k][row][column]))
            });
            let laws: [ElasticLaw; 8] = std::array::from_fn(|k| self.laws[(lane + k) % 8]);
            answers::<S, D>(&mut each, lane, ElasticLaw::of_each(simd, &laws, &gradient));
            let weighted = self.laws[0].weighted(simd, simd.splat(self.weight), &gradient);
            answers::<S, D>(&mut first, lane, weighted);
        }
        (each, first)
    }
}

/// Compares answers at gradients of a size on every level; whether any deformation was one that laws do not bear.
fn compare<const D: usize>(laws: [Law; 3], size: f64) -> bool {
    let mut random = Random(7);
    let mut refused = false;
    for level in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        for _ in 0..300 {
            let gradients: [Tensor<D>; 8] = std::array::from_fn(|_| random.gradient(size));
            let of: [&Law; 8] = std::array::from_fn(|lane| &laws[lane % 3]);
            let in_lanes = of.map(|law| law.in_lanes(D).unwrap());
            let weight = 0.3;
            let ask = Ask { laws: &in_lanes, gradients: &gradients, weight };
            let (each, first) = level.run(ask);
            for lane in 0..8 {
                let deformation = Deformation::whole(&gradients[lane]);
                for (found, law, weight) in
                    [(each[lane], of[lane], 1.0), (first[lane], of[0], weight)]
                {
                    let expected = law.answer(&deformation);
                    let stress = expected.stress.as_flattened();
                    if stress.iter().any(|value| value.is_nan()) {
                        refused = true;
                        assert!(found.0.is_nan() && found.1.as_flattened()[0].is_nan());
                        continue;
                    }
                    // One by one, Neo-Hooke's law inverts C = F^T F.
                    let inverse = inverse(&deformation.full());
                    let lost = 1.0 + contracted(&inverse, &inverse);
                    let (lambda, mu) = law.solid();
                    // And stresses of small strains are differences of large numbers.
                    let rounding = 2e-15 * (lambda + mu) * lost;
                    let allowed = |value: f64| 1e-13 * value.abs() * lost + rounding;
                    let largest = stress.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                    for (found, expected) in found.1.as_flattened().iter().zip(stress) {
                        let error = (found / weight - expected).abs();
                        assert!(error < allowed(largest), "{size}: {error} {law:?}");
                    }
                    let error = (found.0 / weight - expected.energy).abs();
                    assert!(error < allowed(expected.energy), "{error} {law:?}");
                }
            }
        }
    }
    refused
}

#[test]
fn laws_in_lanes_answer_as_one_by_one() {
    let kinds = ["neo_hookean", "saint_venant_kirchhoff", "small_strain"];
    let mut refused = false;
    for size in [1e-9, 1e-6, 1e-3, 0.05, 0.3, 0.8, 2.0] {
        for ratio in [0.0, 0.3, 0.49] {
            refused |= compare::<3>(kinds.map(|kind| law(kind, None, ratio)), size);
            for plane in ["strain", "stress"] {
                refused |= compare::<2>(kinds.map(|kind| law(kind, Some(plane), ratio)), size);
            }
        }
        // Different constants in one block, and what grows thicker where it is drawn.
        let ratios = if size > 0.5 { [0.1, 0.2, 0.45] } else { [-0.3, 0.2, 0.45] };
        compare::<3>(ratios.map(|ratio| law(kinds[0], None, ratio)), size);
        compare::<2>(ratios.map(|ratio| law(kinds[0], Some("stress"), ratio)), size);
    }
    assert!(refused);
}

/// A rotation is no strain, however large, and rest no stress to the last bit.
#[test]
fn laws_in_lanes_are_at_rest_where_nothing_is_strained() {
    for level in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        for plane in ["strain", "stress"] {
            let own = law("neo_hookean", Some(plane), 0.3).in_lanes(2).unwrap();
            let turned =
                |angle: f64| [[angle.cos() - 1.0, -angle.sin()], [angle.sin(), angle.cos() - 1.0]];
            let gradients: [Tensor<2>; 8] = std::array::from_fn(|k| turned(k as f64));
            let (found, _) = level.run(Ask { laws: &[own; 8], gradients: &gradients, weight: 1.0 });
            assert_eq!(found[0], (0.0, [[0.0; 2]; 2]));
            for (energy, stress) in found {
                assert!(energy.abs() < 1e-14, "{energy}");
                assert!(
                    stress.as_flattened().iter().all(|value| value.abs() < 1e-14),
                    "{stress:?}"
                );
            }
        }
    }
}

/// Asks a law of eleven sites in lanes and one by one, in steps of this size; whether records agree, and flow or not.
fn settle_and_compare<const D: usize>(
    material: &str,
    plane: Option<&str>,
    (size, turn): (f64, f64),
    level: SimdLevel,
) -> bool {
    const SITES: usize = 11;
    let laws = [0.1, 0.3].map(|ratio| law(material, plane, ratio));
    let of = |site: usize| &laws[site % 2];
    let width = record_width(Some(45));
    let mut random = Random(11);
    let (mut old, mut flowed) = (vec![0.0; SITES * width], false);
    for step in 0..12 {
        let (mut single, mut lanes) = (old.clone(), old.clone());
        for site in 0..SITES {
            let own = site * width..(site + 1) * width;
            let last: Tensor<3> = read(&old[own.start + MEMORY..]);
            let last: Tensor<D> = resized(&last);
            let (sine, cosine) = (turn * random.next()).sin_cos();
            let mut rotation: Tensor<D> = identity();
            (rotation[0][0], rotation[0][1]) = (cosine, -sine);
            (rotation[1][0], rotation[1][1]) = (sine, cosine);
            let strained = sum(&sum(&identity(), &last), &random.gradient(size));
            let mut gradient = difference(&product(&rotation, &strained), &identity());
            match (step, site) {
                // Some stay as they were, or turn like a rigid body, or are lost.
                (_, 3) if step % 2 == 1 => gradient = last,
                (_, 4) => {
                    let turned = product(&rotation, &sum(&identity(), &last));
                    gradient = difference(&turned, &identity());
                }
                (11, 5) => gradient[0][0] = f64::NAN,
                (11, 6) => gradient = scaled(&identity(), -2.0),
                _ => {}
            }
            let deformation = Deformation::whole(&gradient);
            of(site).remember(&deformation, &old[own.clone()], &mut single[own.clone()], true);
            assert!(of(site).defer(&deformation, &mut lanes[own]));
        }
        level.run(Settle { law: &of, old: &old, new: &mut lanes, width, flows: true });
        for (place, (found, expected)) in lanes.iter().zip(&single).enumerate() {
            let (site, number) = (place / width, place % width);
            let name = format!("{material} {size} {turn} {level:?} {step} {site} {number}");
            if expected.is_nan() {
                assert!(found.is_nan(), "{name}: {found}");
            } else if site == 3 && step % 2 == 1 && number >= MEMORY {
                assert_eq!(found, &old[place], "{name}");
            } else {
                let record = &single[site * width..(site + 1) * width];
                let largest = record.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                assert!((found - expected).abs() <= 1e-12 * largest, "{name}: {found} {expected}");
            }
            flowed |= number == DISSIPATED && *expected > 0.0;
        }
        // On from the same numbers.
        old = single;
    }
    flowed
}

#[test]
fn laws_with_memory_settle_as_one_by_one() {
    for level in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        // Small strains, turns, turns by more than a radian, and frames that are lost.
        for moves in [(1e-4, 0.0), (1e-3, 0.3), (0.05, 0.1), (1e-5, 1.5), (0.4, 0.9)] {
            for material in ["hypoelastic", "j2_plastic"] {
                let flowed = settle_and_compare::<3>(material, None, moves, level);
                assert_eq!(flowed, material == "j2_plastic" && moves.0 > 5e-4, "{moves:?}");
                for plane in ["strain", "stress"] {
                    settle_and_compare::<2>(material, Some(plane), moves, level);
                }
            }
        }
    }
}

/// A plate in plane stress that is drawn beyond all measure, and one that resists nothing across: lambda < 0, far pressed.
#[test]
fn what_lies_across_a_plate_is_found_in_lanes_or_refused_as_one_by_one() {
    let stretched = |along: f64, across: f64| [[along - 1.0, 0.0], [0.0, across - 1.0]];
    for level in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        let answers = |ratio: f64, stretches: [f64; 2]| {
            let law = law("neo_hookean", Some("stress"), ratio);
            let gradient: Tensor<2> = stretched(stretches[0], stretches[1]);
            let laws = [law.in_lanes(2).unwrap(); 8];
            let ask = Ask { laws: &laws, gradients: &[gradient; 8], weight: 1.0 };
            let (energy, stress) = level.run(ask).0[0];
            let expected = law.answer(&Deformation::whole(&gradient));
            [(energy, stress[0][0]), (expected.energy, expected.stress[0][0])]
        };
        for ratio in [0.0, 0.3, 0.49] {
            for stretches in [[30.0, 30.0], [2e4, 2e4], [1e6, 1e6], [1e10, 1.0], [0.01, 0.02]] {
                let [found, expected] = answers(ratio, stretches);
                let name = format!("{level:?} {ratio} {stretches:?}: {found:?} {expected:?}");
                assert!((found.0 - expected.0).abs() < 1e-9 * expected.0.abs(), "{name}");
                assert!((found.1 - expected.1).abs() < 1e-9 * expected.1.abs(), "{name}");
            }
        }
        for (ratio, stretch) in [(-0.3, 0.3), (-0.6, 0.7)] {
            let [found, expected] = answers(ratio, [stretch; 2]);
            assert!(found.0.is_nan() && found.1.is_nan(), "{level:?} {ratio}: {found:?}");
            assert!(expected.0.is_nan() && expected.1.is_nan(), "{ratio}: {expected:?}");
        }
    }
}
