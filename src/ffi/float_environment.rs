//! The floating-point environment (traps, rounding, flushing of subnormal numbers, sticky flags).
//!
//! A host may have it in any state: gfortran's `-ffpe-trap` and `-ffast-math` change it for the
//! whole process. Compiled Rust, and the promise of equal bits, assume the default. So the boundary
//! puts the host's aside, sets the default, and gives the host's back bit by bit on every exit.

/// What the host had in force on this thread.
#[derive(Clone, Copy)]
pub(crate) struct FloatEnvironment(registers::Saved);

impl FloatEnvironment {
    /// Saves what is in force and sets the default: to nearest, no traps, subnormal numbers kept.
    pub(crate) fn enter_default() -> Self {
        let saved = registers::save_and_mask();
        registers::set_default();
        Self(saved)
    }

    /// Puts the saved environment back, sticky flags included: those raised since are forgotten.
    ///
    /// From here to the host's own code no floating-point operation of ours may run.
    pub(crate) fn restore(&self) {
        registers::restore(&self.0);
    }
}

#[cfg(target_arch = "x86_64")]
mod registers {
    use std::arch::asm;

    static DEFAULT_CONTROL: u16 = 0x037F;
    static DEFAULT_MXCSR: u32 = 0x1F80;

    #[derive(Clone, Copy)]
    pub(super) struct Saved {
        /// The 28 bytes of `fnstenv`: control, status, tags, and where the last exception was.
        x87: [u32; 7],
        mxcsr: u32,
    }

    /// The x87 unit is left with its traps masked: that is how `fnstenv` works.
    pub(super) fn save_and_mask() -> Saved {
        let mut saved = Saved { x87: [0; 7], mxcsr: 0 };
        // SAFETY: the two instructions write 28 and 4 bytes, which `saved` has room for. Neither
        // waits for pending exceptions, so that one of the host's cannot fire here.
        unsafe {
            asm!(
                "fnstenv [{x87}]",
                "stmxcsr [{mxcsr}]",
                x87 = in(reg) &raw mut saved.x87,
                mxcsr = in(reg) &raw mut saved.mxcsr,
                options(nostack, preserves_flags),
            );
        }
        saved
    }

    pub(super) fn set_default() {
        // SAFETY: reads 2 and 4 bytes of constants. It brings the registers into the state that
        // compiled Rust assumes; `fnclex` first, since `fldcw` waits for pending exceptions.
        unsafe {
            asm!(
                "fnclex",
                "fldcw [{control}]",
                "ldmxcsr [{mxcsr}]",
                control = in(reg) &raw const DEFAULT_CONTROL,
                mxcsr = in(reg) &raw const DEFAULT_MXCSR,
                options(nostack, readonly, preserves_flags),
            );
        }
    }

    pub(super) fn restore(saved: &Saved) {
        // SAFETY: reads 28 and 4 bytes that `save_and_mask` wrote, so no reserved bit is set. The
        // state is the host's own, and the host's code is what runs next.
        unsafe {
            asm!(
                "fldenv [{x87}]",
                "ldmxcsr [{mxcsr}]",
                x87 = in(reg) &raw const saved.x87,
                mxcsr = in(reg) &raw const saved.mxcsr,
                options(nostack, readonly, preserves_flags),
            );
        }
    }

    /// Rounding up, traps for zero, invalid and overflow, subnormal numbers flushed, the inexact
    /// flag up, and an x87 division by zero that has not fired yet.
    #[cfg(test)]
    pub(super) fn hostile() -> Saved {
        Saved { x87: [0xFFFF_0B72, 0xFFFF_80A4, 0xFFFF_FFFF, 0, 0, 0, 0], mxcsr: 0xD960 }
    }

    #[cfg(test)]
    pub(super) fn words(saved: &Saved) -> [u64; 3] {
        let low = |word: u32| u64::from(word & 0xFFFF);
        [low(saved.x87[0]), low(saved.x87[1]), u64::from(saved.mxcsr)]
    }
}

#[cfg(target_arch = "aarch64")]
mod registers {
    use std::arch::asm;

    #[derive(Clone, Copy)]
    pub(super) struct Saved {
        control: u64,
        status: u64,
    }

    pub(super) fn save_and_mask() -> Saved {
        let (control, status);
        // SAFETY: reads two registers.
        unsafe {
            asm!(
                "mrs {control}, fpcr",
                "mrs {status}, fpsr",
                control = out(reg) control,
                status = out(reg) status,
                options(nostack, preserves_flags),
            );
        }
        Saved { control, status }
    }

    pub(super) fn set_default() {
        restore(&Saved { control: 0, status: 0 });
    }

    pub(super) fn restore(saved: &Saved) {
        // SAFETY: the values are the default, which compiled Rust assumes, or the host's own, and
        // then the host's code is what runs next.
        unsafe {
            asm!(
                "msr fpcr, {control}",
                "msr fpsr, {status}",
                control = in(reg) saved.control,
                status = in(reg) saved.status,
                options(nostack, preserves_flags),
            );
        }
    }

    /// Rounding up, subnormal numbers flushed, the inexact flag up; many cores have no traps.
    #[cfg(test)]
    pub(super) fn hostile() -> Saved {
        Saved { control: 0x0140_0000, status: 0x10 }
    }

    #[cfg(test)]
    pub(super) fn words(saved: &Saved) -> [u64; 3] {
        [saved.control, saved.status, 0]
    }
}

/// Elsewhere nothing is known about the registers, and nothing is changed.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod registers {
    #[derive(Clone, Copy)]
    pub(super) struct Saved;

    pub(super) fn save_and_mask() -> Saved {
        Saved
    }

    pub(super) fn set_default() {}

    pub(super) fn restore(_: &Saved) {}

    #[cfg(test)]
    pub(super) fn hostile() -> Saved {
        Saved
    }

    #[cfg(test)]
    pub(super) fn words(_: &Saved) -> [u64; 3] {
        [0; 3]
    }
}

#[cfg(test)]
impl FloatEnvironment {
    /// An environment in which ordinary arithmetic traps.
    pub(crate) fn hostile() -> Self {
        Self(registers::hostile())
    }

    /// The control and status words, for comparison.
    pub(crate) fn words(&self) -> [u64; 3] {
        registers::words(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hint::black_box;

    #[test]
    fn a_hostile_environment_is_put_aside_and_comes_back_bit_by_bit() {
        FloatEnvironment::hostile().restore();
        let host = FloatEnvironment::enter_default();
        let (zero, one) = (black_box(0.0_f64), black_box(1.0_f64));
        let invalid = black_box(zero / zero);
        let infinite = black_box(one / zero);
        let sum = black_box(one + black_box(f64::EPSILON / 4.0));
        let subnormal = black_box(f64::MIN_POSITIVE / black_box(2.0));
        raise_x87_invalid();
        host.restore();
        let after = FloatEnvironment::enter_default();

        assert_eq!(host.words(), FloatEnvironment::hostile().words());
        assert_eq!(after.words(), host.words());
        assert!(invalid.is_nan() && infinite.is_infinite());
        assert_eq!(sum, 1.0, "rounding is not to nearest");
        assert!(subnormal > 0.0, "subnormal numbers are flushed");
    }

    /// Some routines of the C library still use the x87 unit.
    fn raise_x87_invalid() {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: what is pushed is popped, and the default environment, in force here, traps not.
        unsafe {
            std::arch::asm!("fldz", "fldz", "fdivp", "fstp st(0)", out("st(0)") _, out("st(1)") _);
        }
    }
}
