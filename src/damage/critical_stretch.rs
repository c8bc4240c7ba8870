//! Bonds that break for good when their stretch passes a critical value. [P 3.8-3.11]

use crate::error::Result;
use crate::families::{Families, LANES, Property};
use crate::memory;

const PURPOSE: &str = "critical stretches";

/// When a bond breaks: at the smaller of its ends' critical stretches, unless it stands in an
/// interface with its own, or may not break at all.
#[derive(Debug)]
pub(crate) struct BreakRule {
    critical: Critical,
    /// One bit a lane: the bond may break. `None` when all may.
    breakable: Option<Vec<u8>>,
}

#[derive(Debug)]
enum Critical {
    Ends(Property),
    PerBond(Vec<f64>),
}

/// The bonds between two sets of points, and the critical stretch that each point has in them.
pub(crate) struct Interface<'a> {
    /// Bit 0: the point is in the first set; bit 1: in the second.
    pub(crate) sides: &'a [u8],
    /// Critical stretch of a material of the point's kind, for the interface's energy release rate.
    pub(crate) critical: Property,
}

impl BreakRule {
    /// `ends` holds each point's critical stretch, infinite where its material does not break;
    /// `protected` the points that no bond of which may break. `None` when nothing can ever break.
    pub(crate) fn new(
        families: &Families,
        ends: Property,
        interfaces: &[Interface<'_>],
        protected: Option<&[bool]>,
    ) -> Result<Option<Self>> {
        let harmless = match &ends {
            Property::Uniform(critical) => critical.is_infinite(),
            Property::PerPoint(values) => values.iter().all(|critical| critical.is_infinite()),
        };
        if harmless && interfaces.is_empty() {
            return Ok(None);
        }
        let critical = if interfaces.is_empty() {
            Critical::Ends(ends)
        } else {
            Critical::PerBond(per_bond(families, &ends, interfaces)?)
        };
        let breakable = match protected {
            Some(protected) => Some(breakable(families, protected)?),
            None => None,
        };
        Ok(Some(Self { critical, breakable }))
    }

    /// The critical stretch that all bonds share, if they do.
    #[inline(always)]
    pub(crate) fn uniform(&self) -> Option<f64> {
        match self.critical {
            Critical::Ends(Property::Uniform(critical)) => Some(critical),
            _ => None,
        }
    }

    /// That of bonds between points of one model, by one of them; `None` where bonds have their own.
    pub(crate) fn among(&self, point: usize) -> Option<f64> {
        match &self.critical {
            Critical::Ends(ends) => Some(ends.at(point)),
            Critical::PerBond(_) => None,
        }
    }

    /// The critical stretch of a bond.
    #[inline(always)]
    pub(crate) fn threshold(&self, slot: usize, point: usize, neighbor: usize) -> f64 {
        match &self.critical {
            Critical::Ends(ends) => ends.at(point).min(ends.at(neighbor)),
            Critical::PerBond(values) => values[slot],
        }
    }

    /// The lanes of a block that may break.
    #[inline(always)]
    pub(crate) fn breakable(&self, block: usize) -> u8 {
        self.breakable.as_ref().map_or(u8::MAX, |masks| masks[block])
    }

    /// Lets no bond break that has an end among the `protected`.
    pub(crate) fn protect(&mut self, families: &Families, protected: &[bool]) -> Result<()> {
        self.breakable = Some(breakable(families, protected)?);
        Ok(())
    }

    pub(crate) fn bytes(&self) -> usize {
        let critical = match &self.critical {
            Critical::Ends(ends) => ends.bytes(),
            Critical::PerBond(values) => memory::bytes(values),
        };
        critical + self.breakable.as_ref().map_or(0, memory::bytes)
    }
}

/// (l/L)^2 - 1 of a bond that comes close to a stretch, whatever the rounding: of bonds of a fragment that has flown
/// 1e7 of their lengths and turned, too. Both ends must look, or one would keep what the other breaks.
pub(crate) fn close_to(stretch: f64) -> f64 {
    (1.0 - 1e-4) * stretch * (2.0 + stretch) - 1e-14
}

/// Stretch of a bond of a length, from xi and du along each axis; the same bits from both ends.
pub(crate) fn stretch(length: f64, axes: impl Iterator<Item = [f64; 2]>) -> f64 {
    let (mut squared, mut change) = (0.0, 0.0);
    for [reference, moved] in axes {
        let now = reference + moved;
        squared += now * now;
        change += moved * (reference + now);
    }
    change / (length * (length + squared.sqrt()))
}

fn per_bond(
    families: &Families,
    ends: &Property,
    interfaces: &[Interface<'_>],
) -> Result<Vec<f64>> {
    let mut values = memory::filled(f64::INFINITY, families.block_count() * LANES, PURPOSE)?;
    for point in 0..families.offsets.len() - 1 {
        for bond in families.bonds(point) {
            let across = interfaces.iter().rev().find(|interface| {
                let (own, other) = (interface.sides[point], interface.sides[bond.neighbor]);
                (own & 1 != 0 && other & 2 != 0) || (own & 2 != 0 && other & 1 != 0)
            });
            values[bond.slot] = match across {
                // Half of the bond's energy belongs to either end's material.
                Some(interface) => {
                    let square = |point: usize| interface.critical.at(point).powi(-2);
                    (0.5 * (square(point) + square(bond.neighbor))).powf(-0.5)
                }
                None => ends.at(point).min(ends.at(bond.neighbor)),
            };
        }
    }
    Ok(values)
}

fn breakable(families: &Families, protected: &[bool]) -> Result<Vec<u8>> {
    let mut masks = memory::filled(u8::MAX, families.block_count(), PURPOSE)?;
    for point in 0..families.offsets.len() - 1 {
        for bond in families.bonds(point) {
            if protected[point] || protected[bond.neighbor] {
                masks[bond.slot / LANES] &= !(1 << (bond.slot % LANES));
            }
        }
    }
    Ok(masks)
}
