//! What a material does in the directions that a deformation leaves out: across a plate, and where a family
//! does not span the body.
//!
//! Free directions share the stretch at which they have no stress; the direction held across plane strain has
//! stretch 1 and a stress of its own.

use super::{Deformation, Kind, Law, neo_hookean};
use crate::tensor::trace;

/// Stretches and stress across.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Across {
    /// Stretch of the free directions.
    pub(crate) stretch: f64,
    /// Stretch across a plate: 1 in plane strain, in plane stress that of the free directions.
    pub(crate) thickness: f64,
    /// First Piola-Kirchhoff stress across plane strain, elsewhere 0.
    pub(crate) held: f64,
}

impl Law {
    /// What the law has across a deformation; not a number where it has no answer.
    pub(crate) fn across<const D: usize>(&self, deformation: &Deformation<D>) -> Across {
        if deformation.rank == 0 {
            return self.made(1.0, 0.0);
        }
        let free = f64::from(self.free[deformation.rank]);
        let (lambda, mu) = self.solid();
        // lambda (in_plane + free e) + 2 mu e = 0
        let linear = |in_plane: f64| {
            if free > 0.0 { -lambda * in_plane / (free * lambda + 2.0 * mu) } else { 0.0 }
        };
        match self.kind {
            Kind::SaintVenantKirchhoff => {
                let in_plane = 0.5 * trace(&deformation.twice_strain());
                let strain = linear(in_plane);
                self.made((1.0 + 2.0 * strain).sqrt(), lambda * (in_plane + free * strain))
            }
            // A host's law says nothing of what lies across.
            Kind::Host => self.made(1.0, 0.0),
            Kind::SmallStrain | Kind::Hypoelastic(_) => {
                let in_plane = trace(&deformation.gradient);
                let strain = linear(in_plane);
                self.made(1.0 + strain, lambda * (in_plane + free * strain))
            }
            Kind::NeoHookean => {
                let in_plane = neo_hookean::jacobian(deformation).ln();
                let strain = if free > 0.0 {
                    neo_hookean::free_stretch(lambda / mu, in_plane, free)
                } else {
                    0.0
                };
                self.made(strain.exp(), lambda * (in_plane + free * strain))
            }
        }
    }

    /// What bonds have across, which have constants but no law: the logarithmic strain that linear elasticity
    /// gives, positive however far they stretch. `tension`: P : F of the plane; across plane strain linear
    /// elasticity has Poisson's ratio of it.
    pub(crate) fn across_bonds<const D: usize>(
        &self,
        deformation: &Deformation<D>,
        tension: f64,
    ) -> Across {
        if deformation.rank == 0 {
            return self.made(1.0, 0.0);
        }
        let free = f64::from(self.free[deformation.rank]);
        let (lambda, mu) = self.solid();
        let in_plane = neo_hookean::jacobian(deformation).abs().ln();
        let strain = if free > 0.0 { -lambda * in_plane / (free * lambda + 2.0 * mu) } else { 0.0 };
        self.made(strain.exp(), 0.5 * lambda / (lambda + mu) * tension)
    }

    fn made(&self, stretch: f64, held: f64) -> Across {
        if self.is_held_across {
            return Across { stretch, thickness: 1.0, held };
        }
        Across { stretch, thickness: stretch, held: 0.0 }
    }
}
