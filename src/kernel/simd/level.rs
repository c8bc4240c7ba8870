//! The levels, which of them the machine has, and the way in.

use super::baseline::Baseline;
use super::{Kernel, Simd};
use crate::error::{Error, Result, argument};
use crate::suggest;

/// A set of vector instructions that the inner loops are compiled for. Results of two levels agree to
/// rounding, and not to the last bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SimdLevel {
    /// What every processor of the kind has: SSE2 on x86-64.
    Baseline,
    /// AVX2 with fused multiply-add.
    Avx2,
    /// AVX-512 with the F, DQ, BW and VL parts.
    Avx512,
}

impl SimdLevel {
    /// All levels, the widest last.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// The name that `PERION_SIMD` knows it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// Whether this machine has it.
    #[cfg(target_arch = "x86_64")]
    pub fn is_available(self) -> bool {
        match self {
            Self::Baseline => true,
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("popcnt")
            }
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512vl")
            }
        }
    }

    /// Whether this machine has it.
    #[cfg(not(target_arch = "x86_64"))]
    pub fn is_available(self) -> bool {
        self == Self::Baseline
    }

    /// The widest level of this machine that is no wider than `most`.
    fn best_up_to(most: Self) -> Self {
        let mut levels = Self::ALL.into_iter().rev();
        levels.find(|level| *level <= most && level.is_available()).unwrap_or(Self::Baseline)
    }

    /// The level of a new simulation: the best of the machine, no wider than `PERION_SIMD` says.
    pub(crate) fn of_environment() -> Result<Self> {
        Self::named(std::env::var_os("PERION_SIMD").map(|text| text.to_string_lossy().into_owned()))
    }

    fn named(most: Option<String>) -> Result<Self> {
        let Some(name) = most.filter(|name| !name.is_empty()) else {
            return Ok(Self::best_up_to(Self::Avx512));
        };
        match Self::ALL.into_iter().find(|level| level.name() == name) {
            Some(most) => Ok(Self::best_up_to(most)),
            None => argument(format!(
                "the environment has PERION_SIMD={name}; it must be 'baseline', 'avx2' or 'avx512'{}",
                suggest::similar(&name, Self::ALL.into_iter().map(Self::name))
            )),
        }
    }

    /// Itself, where this machine has it.
    pub(crate) fn if_available(self) -> Result<Self> {
        if self.is_available() {
            return Ok(self);
        }
        Err(Error::Unsupported(format!("this machine does not have the level '{}'", self.name())))
    }

    /// Runs a kernel on this level, or on the baseline where the machine does not have it.
    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            // SAFETY: the machine has the level.
            Self::Avx512 if self.is_available() => return unsafe { run_avx512(kernel) },
            // SAFETY: the machine has the level.
            Self::Avx2 if self.is_available() => return unsafe { run_avx2(kernel) },
            _ => {}
        }
        run_here(kernel, Baseline)
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,popcnt,avx512f,avx512dq,avx512bw,avx512vl")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    // SAFETY: whoever calls this has found the machine to have the instructions.
    run_here(kernel, unsafe { super::avx512::Avx512::new() })
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,popcnt")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    // SAFETY: whoever calls this has found the machine to have the instructions.
    run_here(kernel, unsafe { super::avx2::Avx2::new() })
}

#[inline(always)]
fn run_here<K: Kernel>(kernel: K, simd: impl Simd) -> K::Output {
    kernel.run(simd)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_caps_the_level_and_unknown_names_are_refused() {
        let named = |name: &str| SimdLevel::named(Some(name.to_owned()));
        assert_eq!(named("baseline").unwrap(), SimdLevel::Baseline);
        assert!(named("avx2").unwrap() <= SimdLevel::Avx2);
        assert_eq!(named("avx512").unwrap(), SimdLevel::named(None).unwrap());
        let error = named("avx3").unwrap_err().to_string();
        assert!(error.contains("PERION_SIMD=avx3") && error.contains("'avx2'"), "{error}");
    }
}
