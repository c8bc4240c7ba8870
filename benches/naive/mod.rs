//! The plain loops that one would write first: the yardstick of the machine. Bonds stand one after the other in structs of
//! 24 bytes; forces only, on one thread.

use perion::{Points, Simulation};

use crate::common::{HORIZON, SPACING, YOUNGS_MODULUS, poissons_ratio};

struct Bond {
    neighbor: usize,
    length: f64,
    volume: f64,
}

/// A body for the plain loops.
pub struct Naive {
    offsets: Vec<usize>,
    bonds: Vec<Bond>,
    reference: Vec<[f64; 3]>,
    position: Vec<[f64; 3]>,
    /// Inverse of each point's shape tensor, and P K^-1, where stresses are summed.
    inverse_shape: Vec<[[f64; 3]; 3]>,
    pull: Vec<[[f64; 3]; 3]>,
    pub force: Vec<[f64; 3]>,
}

/// The formulations that there is a plain loop for.
pub const KNOWN: [&str; 2] = ["bond_based", "correspondence"];

impl Naive {
    /// The points in the host's order, row by row.
    pub fn new(points: &Points, displacement: &[f64], simulation: &Simulation) -> Self {
        let (reference, _) = points.coordinates().as_chunks::<3>();
        let (displacement, _) = displacement.as_chunks::<3>();
        let mut lists = vec![Vec::new(); points.count()];
        let keep = |[i, j]: [usize; 2], _, _| {
            lists[i].push(j as u32);
            lists[j].push(i as u32);
        };
        simulation.for_each_bond(keep).unwrap();
        let mut offsets = vec![0];
        let mut bonds = Vec::new();
        for (i, list) in lists.into_iter().enumerate() {
            for j in list {
                let j = j as usize;
                let squared: f64 =
                    (0..3).map(|k| (reference[j][k] - reference[i][k]).powi(2)).sum();
                let volume = points.volumes()[j];
                bonds.push(Bond { neighbor: j, length: squared.sqrt(), volume });
            }
            offsets.push(bonds.len());
        }
        let moved = reference.iter().zip(displacement);
        Self {
            offsets,
            bonds,
            reference: reference.to_vec(),
            position: moved.map(|(x, u)| [0, 1, 2].map(|k| x[k] + u[k])).collect(),
            inverse_shape: Vec::new(),
            pull: Vec::new(),
            force: vec![[0.0; 3]; points.count()],
        }
    }

    pub fn bond_count(&self) -> usize {
        self.bonds.len()
    }

    /// Forces of a formulation that there is a plain loop for.
    pub fn sweep(&mut self, formulation: &str) {
        match formulation {
            "bond_based" => self.springs(),
            _ => self.correspondence(),
        }
    }

    /// One square root and two divisions a bond.
    fn springs(&mut self) {
        let bulk_modulus = YOUNGS_MODULUS / (3.0 * (1.0 - 2.0 * poissons_ratio("bond_based")));
        let constant = 18.0 * bulk_modulus / (std::f64::consts::PI * HORIZON.powi(4));
        for (i, force) in self.force.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            let own = self.position[i];
            for bond in &self.bonds[self.offsets[i]..self.offsets[i + 1]] {
                let other = self.position[bond.neighbor];
                let y = [other[0] - own[0], other[1] - own[1], other[2] - own[2]];
                let now = (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]).sqrt();
                let stretch = (now - bond.length) / bond.length;
                let factor = constant * stretch * bond.volume / now;
                for axis in 0..3 {
                    sum[axis] += factor * y[axis];
                }
            }
            *force = sum;
        }
    }

    /// F, Saint Venant and Kirchhoff's stress, and forces, with every neighbour counting alike.
    fn correspondence(&mut self) {
        if self.inverse_shape.is_empty() {
            self.inverse_shape =
                (0..self.force.len()).map(|i| inverse(self.sum(i, &self.reference))).collect();
            self.pull = vec![[[0.0; 3]; 3]; self.force.len()];
        }
        let ratio = poissons_ratio("correspondence");
        let shear = YOUNGS_MODULUS / (2.0 * (1.0 + ratio));
        let lambda = 2.0 * shear * ratio / (1.0 - 2.0 * ratio);
        for i in 0..self.force.len() {
            let gradient = product(self.sum(i, &self.position), self.inverse_shape[i]);
            let squared = product(transpose(gradient), gradient);
            let unit = |a: usize, b: usize| if a == b { 1.0 } else { 0.0 };
            let strain = tensor(|a, b| 0.5 * (squared[a][b] - unit(a, b)));
            let trace = strain[0][0] + strain[1][1] + strain[2][2];
            let stress = tensor(|a, b| 2.0 * shear * strain[a][b] + lambda * trace * unit(a, b));
            self.pull[i] = product(product(gradient, stress), self.inverse_shape[i]);
        }
        for (i, force) in self.force.iter_mut().enumerate() {
            let mut sum = [0.0; 3];
            let (own, place) = (self.pull[i], self.reference[i]);
            for bond in &self.bonds[self.offsets[i]..self.offsets[i + 1]] {
                let (other, far) = (&self.pull[bond.neighbor], self.reference[bond.neighbor]);
                let xi = [far[0] - place[0], far[1] - place[1], far[2] - place[2]];
                for axis in 0..3 {
                    for along in 0..3 {
                        sum[axis] +=
                            bond.volume * (own[axis][along] + other[axis][along]) * xi[along];
                    }
                }
            }
            *force = sum;
        }
    }

    /// Sum of y xi V over a point's bonds.
    fn sum(&self, i: usize, position: &[[f64; 3]]) -> [[f64; 3]; 3] {
        let mut sum = [[0.0; 3]; 3];
        let (place, own) = (self.reference[i], position[i]);
        for bond in &self.bonds[self.offsets[i]..self.offsets[i + 1]] {
            let (far, other) = (self.reference[bond.neighbor], position[bond.neighbor]);
            for a in 0..3 {
                for b in 0..3 {
                    sum[a][b] += bond.volume * (other[a] - own[a]) * (far[b] - place[b]);
                }
            }
        }
        sum
    }

    /// Largest difference from the forces of a simulation, relative to the largest of them.
    pub fn difference(&self, forces: &[f64]) -> f64 {
        let largest = forces.iter().fold(0.0_f64, |largest, force| largest.max(force.abs()));
        let pairs = self.force.iter().flatten().zip(forces);
        pairs.map(|(plain, force)| (plain - force).abs()).fold(0.0, f64::max) / largest
    }
}

fn tensor(component: impl Fn(usize, usize) -> f64) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| component(a, b)))
}

fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    tensor(|i, j| (0..3).map(|k| a[i][k] * b[k][j]).sum())
}

fn transpose(a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    tensor(|i, j| a[j][i])
}

fn inverse(a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let cofactor = |i: usize, j: usize| {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1]
    };
    let determinant: f64 = (0..3).map(|j| a[0][j] * cofactor(0, j)).sum();
    tensor(|i, j| cofactor(j, i) / determinant)
}

/// Bytes that the plain loop's own bonds take.
pub const BOND_BYTES: usize = size_of::<Bond>();

const _: () = assert!(BOND_BYTES == 24 && SPACING > 0.0);
