//! One sequence of colours, from pale to dark, that keeps its order in print and for colour-blind eyes.

pub type Colour = [u8; 3];

pub const WHITE: Colour = [255, 255, 255];
pub const INK: Colour = [40, 44, 52];
pub const FAINT_INK: Colour = [118, 124, 134];
/// Lines behind curves, and the curves themselves.
pub const GRID: Colour = [228, 231, 236];
pub const LINES: [Colour; 5] =
    [[190, 60, 40], [35, 100, 170], [215, 150, 30], [40, 44, 52], [70, 150, 90]];
/// For values that are not finite: a hue that the sequence does not pass.
pub const NO_VALUE: Colour = [0, 150, 160];

/// Stations of the sequence at equal distances: lightness, chroma and hue in degrees in the OKLCh space. The lightness falls evenly;
/// the chroma is low at the start so that an intact body recedes, and a crack stands out.
const STATIONS: [[f64; 3]; 7] = [
    [0.905, 0.012, 250.0],
    [0.845, 0.075, 88.0],
    [0.745, 0.140, 66.0],
    [0.625, 0.185, 42.0],
    [0.495, 0.185, 22.0],
    [0.355, 0.135, 355.0],
    [0.215, 0.075, 320.0],
];

/// The colour at `fraction` of the range; beyond 0 and 1 that of the end.
pub fn colour(fraction: f64) -> Colour {
    let position = fraction.clamp(0.0, 1.0) * (STATIONS.len() - 1) as f64;
    let below = (position as usize).min(STATIONS.len() - 2);
    let share = position - below as f64;
    let (low, high) = (lab(STATIONS[below]), lab(STATIONS[below + 1]));
    srgb(std::array::from_fn(|k| low[k] + share * (high[k] - low[k])))
}

fn lab([lightness, chroma, hue]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = hue.to_radians().sin_cos();
    [lightness, chroma * cos, chroma * sin]
}

/// The OKLab colour in the sRGB space of screens, clipped where it lies outside.
fn srgb([lightness, a, b]: [f64; 3]) -> Colour {
    let long = (lightness + 0.3963377774 * a + 0.2158037573 * b).powi(3);
    let medium = (lightness - 0.1055613458 * a - 0.0638541728 * b).powi(3);
    let short = (lightness - 0.0894841775 * a - 1.2914855480 * b).powi(3);
    let linear = [
        4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * medium + 1.7076147010 * short,
    ];
    linear.map(|light| {
        let encoded =
            if light <= 0.0031308 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        (encoded.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}
