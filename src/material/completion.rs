//! What becomes of the directions that a family does not span.
//!
//! They turn with those that it spans. Across a sheet (in 2D a line) that is the normal, and a rigid rotation gives
//! exactly that rotation; around a string in 3D the rotation is the least that turns it, for a string does not
//! know its twist; a point without a family has the identity.

use super::Deformation;
use crate::tensor::{
    Tensor, Vector, add_outer, applied, cofactors, difference, dot, identity, scaled, sum, zero,
};

/// R m m^T of the directions m that a deformation leaves out, with the rotation R they take; 0 where it spans all.
pub(crate) fn turned<const D: usize>(deformation: &Deformation<D>) -> Tensor<D> {
    let Deformation { gradient, span, rank } = deformation;
    let missing = difference(&identity(), span);
    if *rank == D {
        return zero();
    }
    if *rank == 0 || *gradient == zero() {
        return missing;
    }
    if *rank + 1 == D {
        let normal = direction(&missing);
        let now = unit(&applied(&cofactors(&deformation.full()), &normal)).unwrap_or(normal);
        let mut turned = zero();
        add_outer(&mut turned, 1.0, &now, &normal);
        turned
    } else {
        let axis = direction(span);
        let now = unit(&applied(&deformation.full(), &axis)).unwrap_or(axis);
        turned_least(&axis, &now, &missing)
    }
}

/// F - I of a deformation, with the directions that the family does not span turned with the others and stretched
/// by `stretch`.
pub(crate) fn completed<const D: usize>(deformation: &Deformation<D>, stretch: f64) -> Tensor<D> {
    let Deformation { gradient, span, rank } = deformation;
    if *rank == D || *rank == 0 || *gradient == zero() {
        return *gradient;
    }
    let missing = difference(&identity(), span);
    sum(gradient, &difference(&scaled(&turned(deformation), stretch), &missing))
}

/// R (I - a a^T) with the least rotation R that takes one direction to another: R m = m - (a + b) (b.m)/(1 + a.b)
/// for m across a.
fn turned_least<const D: usize>(
    from: &Vector<D>,
    to: &Vector<D>,
    missing: &Tensor<D>,
) -> Tensor<D> {
    let rest = 1.0 + dot(from, to);
    if rest <= 1e-15 {
        // Half a turn, about any direction across.
        let about = direction(missing);
        let mut turned = scaled(missing, -1.0);
        add_outer(&mut turned, 2.0, &about, &about);
        return turned;
    }
    let both: Vector<D> = std::array::from_fn(|axis| from[axis] + to[axis]);
    let mut turned = *missing;
    add_outer(&mut turned, -1.0 / rest, &both, &applied(missing, to));
    turned
}

/// A direction that a projector keeps: its largest row.
fn direction<const D: usize>(projector: &Tensor<D>) -> Vector<D> {
    let largest = (1..D)
        .fold(0, |best, row| if projector[row][row] > projector[best][best] { row } else { best });
    unit(&projector[largest]).unwrap_or(projector[largest])
}

fn unit<const D: usize>(vector: &Vector<D>) -> Option<Vector<D>> {
    let length = dot(vector, vector).sqrt();
    (length > 0.0 && length.is_finite()).then(|| vector.map(|component| component / length))
}
