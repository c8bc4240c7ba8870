use super::*;

/// A small full matrix, preconditioned by its diagonal.
struct Full {
    rows: Vec<Vec<f64>>,
}

impl System for Full {
    fn multiply(&mut self, v: &[f64], product: &mut [f64]) -> Trial<()> {
        for (value, row) in product.iter_mut().zip(&self.rows) {
            *value = row.iter().zip(v).map(|(a, v)| a * v).sum();
        }
        Ok(())
    }

    fn precondition(&mut self, r: &[f64], z: &mut [f64]) {
        for (number, (z, r)) in z.iter_mut().zip(r).enumerate() {
            *z = r / self.rows[number][number].abs();
        }
    }

    fn dot(&mut self, v: &[f64], w: &[f64]) -> f64 {
        v.iter().zip(w).map(|(v, w)| v * w).sum()
    }

    fn combine(&self, v: &mut [f64], own: f64, factor: f64, w: &[f64]) {
        v.iter_mut().zip(w).for_each(|(v, w)| *v = own * *v + factor * w);
    }

    fn empty(&self) -> Result<Vec<f64>> {
        Ok(vec![0.0; self.rows.len()])
    }
}

/// Of 12 rows; `skew` spoils the symmetry, `shift` makes some eigenvalues negative.
fn matrix(skew: f64, shift: f64) -> Full {
    let rows = 12;
    let entry = |row: usize, column: usize| {
        let mixed = ((row.min(column) * 7 + row.max(column) * 3) as f64).sin();
        let turn = skew * (row as f64 - column as f64);
        let diagonal = if row == column { 4.0 + row as f64 - shift } else { 0.0 };
        0.4 * mixed + turn + diagonal
    };
    Full {
        rows: (0..rows).map(|row| (0..rows).map(|column| entry(row, column)).collect()).collect(),
    }
}

fn largest_residual(system: &mut Full, b: &[f64], x: &[f64]) -> f64 {
    let mut product = vec![0.0; b.len()];
    assert!(system.multiply(x, &mut product).is_ok());
    product.iter().zip(b).fold(0.0, |most: f64, (p, b)| most.max((p - b).abs()))
}

const CYCLE: Cycle = Cycle { products: 200, reduction: 1e-12 };

fn right() -> Vec<f64> {
    (0..12).map(|row| (row as f64 + 0.3).cos()).collect()
}

#[test]
fn conjugate_gradients_and_minimal_residuals_solve_what_is_positive() {
    let mut system = matrix(0.0, 0.0);
    let b = right();
    for method in [krylov::conjugate_gradients, krylov::minimal_residuals] {
        let mut x = vec![0.0; 12];
        assert!(matches!(method(&mut system, &b, &mut x, CYCLE), Ok(Left::Solved)));
        assert!(largest_residual(&mut system, &b, &x) < 1e-10);
    }
}

#[test]
fn what_is_indefinite_is_told_by_conjugate_gradients_and_solved_by_minimal_residuals() {
    let mut system = matrix(0.0, 7.3);
    let b = right();
    let mut x = vec![0.0; 12];
    let left = krylov::conjugate_gradients(&mut system, &b, &mut x, CYCLE);
    assert!(matches!(left, Ok(Left::Indefinite)));
    assert!(krylov::minimal_residuals(&mut system, &b, &mut x, CYCLE).is_ok());
    assert!(largest_residual(&mut system, &b, &x) < 1e-9);
}

#[test]
fn generalised_minimal_residuals_solve_what_is_not_symmetric() {
    let mut system = matrix(0.3, 0.0);
    let b = right();
    let mut x = vec![0.0; 12];
    assert!(matches!(gmres::gmres(&mut system, &b, &mut x, CYCLE), Ok(Left::Solved)));
    assert!(largest_residual(&mut system, &b, &x) < 1e-10);
}
