//! A smooth displacement u = A s(X), and what body force it needs: -Div P of a Saint Venant-Kirchhoff solid, exactly.

/// First Lame constant, and shear modulus: E = 1, nu = 1/4.
pub const LAMBDA: f64 = 0.4;
pub const MU: f64 = 0.4;

/// Each component is a sine along a direction of its own.
const WAVE: [[f64; 3]; 3] = [[2.0, 1.5, 1.0], [1.0, -2.0, 1.5], [-1.5, 1.0, 2.0]];
const PHASE: [f64; 3] = [0.3, 0.7, 1.1];

type Matrix = [[f64; 3]; 3];

fn phase(component: usize, place: &[f64]) -> f64 {
    PHASE[component] + (0..3).map(|axis| WAVE[component][axis] * place[axis]).sum::<f64>()
}

/// s(X).
pub fn shape(place: &[f64]) -> [f64; 3] {
    std::array::from_fn(|component| phase(component, place).sin())
}

/// Div P under amplitude * s(X). P = F S, S = lambda tr(E) I + 2 mu E and 2 E = F^T F - I; so Div P = F_ac,b S_cb + F_ac S_cb,b.
pub fn divergence(amplitude: f64, place: &[f64]) -> [f64; 3] {
    let (cosines, sines): (Vec<f64>, Vec<f64>) = (0..3)
        .map(|component| phase(component, place))
        .map(|phase| (amplitude * phase.cos(), amplitude * phase.sin()))
        .unzip();
    let unit = |a: usize, b: usize| f64::from(a == b);
    let slope = |a: usize, b: usize| cosines[a] * WAVE[a][b];
    let gradient = |a: usize, b: usize| unit(a, b) + slope(a, b);
    let curvature = |a: usize, b: usize, c: usize| -sines[a] * WAVE[a][b] * WAVE[a][c];
    // From the slope alone: small strains keep their digits.
    let strain: Matrix =
        matrix(|a, b| 0.5 * (slope(a, b) + slope(b, a) + sum(|k| slope(k, a) * slope(k, b))));
    let stress = |strain: &Matrix| -> Matrix {
        let trace = sum(|k| strain[k][k]);
        matrix(|a, b| LAMBDA * trace * unit(a, b) + 2.0 * MU * strain[a][b])
    };
    let second = stress(&strain);
    let mut divergence = [0.0; 3];
    for b in 0..3 {
        let slope_of_strain = matrix(|c, d| {
            0.5 * sum(|k| curvature(k, c, b) * gradient(k, d) + gradient(k, c) * curvature(k, d, b))
        });
        let slope_of_stress = stress(&slope_of_strain);
        for (a, value) in divergence.iter_mut().enumerate() {
            *value +=
                sum(|c| curvature(a, c, b) * second[c][b] + gradient(a, c) * slope_of_stress[c][b]);
        }
    }
    divergence
}

fn matrix(entry: impl Fn(usize, usize) -> f64) -> Matrix {
    std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)))
}

fn sum(term: impl Fn(usize) -> f64) -> f64 {
    (0..3).map(term).sum()
}

/// Div P as a polynomial in the amplitude c: c a_1 + c^2 a_2 + c^3 a_3, in units of `scale`; a_1, a_2 and a_3.
pub fn powers(scale: f64, place: &[f64]) -> [[f64; 3]; 3] {
    let [ahead, back, twice] = [1.0, -1.0, 2.0].map(|c| divergence(c * scale, place));
    let mut powers = [[0.0; 3]; 3];
    for axis in 0..3 {
        let odd = 0.5 * (ahead[axis] - back[axis]);
        let even = 0.5 * (ahead[axis] + back[axis]);
        let cubic = (twice[axis] - 4.0 * even - 2.0 * odd) / 6.0;
        (powers[0][axis], powers[1][axis], powers[2][axis]) = (odd - cubic, even, cubic);
    }
    powers
}
