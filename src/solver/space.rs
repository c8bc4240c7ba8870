//! Fields of a body as vectors: sums whose bits do not depend on threads.

use crate::error::Result;
use crate::memory;
use crate::workers::{PerPoint, Workers, block_count};

/// Vectors of so many numbers a point.
pub(crate) struct Space<'a> {
    pub(crate) workers: &'a Workers,
    pub(crate) points: usize,
    pub(crate) dimension: usize,
    partial: Vec<f64>,
    purpose: &'static str,
}

impl<'a> Space<'a> {
    pub(crate) fn new(
        workers: &'a Workers,
        points: usize,
        dimension: usize,
        purpose: &'static str,
    ) -> Result<Self> {
        let partial = memory::filled(0.0, block_count(points), purpose)?;
        Ok(Self { workers, points, dimension, partial, purpose })
    }

    pub(crate) fn empty(&self) -> Result<Vec<f64>> {
        memory::filled(0.0, self.points * self.dimension, self.purpose)
    }

    /// sum over the points of `scale` v.w
    pub(crate) fn weighted_dot(
        &mut self,
        v: &[f64],
        w: &[f64],
        scale: impl Fn(usize) -> f64 + Sync,
    ) -> f64 {
        let dimension = self.dimension;
        self.workers.sum(self.points, &mut self.partial, |point| {
            let own = point * dimension..(point + 1) * dimension;
            let product: f64 = v[own.clone()].iter().zip(&w[own]).map(|(v, w)| v * w).sum();
            scale(point) * product
        })
    }

    /// v.w
    pub(crate) fn dot(&mut self, v: &[f64], w: &[f64]) -> f64 {
        self.weighted_dot(v, w, |_| 1.0)
    }

    pub(crate) fn norm(&mut self, v: &[f64]) -> f64 {
        self.dot(v, v).sqrt()
    }

    /// v = own v + factor w
    pub(crate) fn combine(&self, v: &mut [f64], own: f64, factor: f64, w: &[f64]) {
        self.workers.sweep(self.points, PerPoint(v, self.dimension), |range, v| {
            let w = &w[range.start * self.dimension..range.end * self.dimension];
            v.0.iter_mut().zip(w).for_each(|(v, w)| *v = own * *v + factor * w);
        });
    }
}

/// The largest size of a component.
pub(crate) fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}
