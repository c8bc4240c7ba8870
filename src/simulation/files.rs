//! Files for ParaView: one state, or a series over time.

use std::path::Path;

use super::kinematics::is_read;
use super::{Field, Simulation};
use crate::error::{Result, argument};
use crate::memory;
use crate::output::vtu::{self, PointArray};

impl Simulation {
    /// Writes the current positions and these fields as a `.vtu` file; an older one is replaced as a
    /// whole.
    ///
    /// # Errors
    /// `Io` when it cannot be written, `Argument` for a field named twice, and as [`Simulation::get`].
    pub fn write_vtk(&self, path: impl AsRef<Path>, fields: &[Field]) -> Result<()> {
        let mut contents = memory::reserved(fields.len(), "fields")?;
        for (place, &field) in fields.iter().enumerate() {
            if fields[..place].contains(&field) {
                return argument(format!("'fields'[{place}]: {} is named twice", field.name()));
            }
        }
        // What is read of deformation and stress comes from one sweep.
        let mut read = memory::reserved(fields.len(), "fields")?;
        read.extend(fields.iter().filter(|&&field| is_read(field)));
        let (dimension, count) = (self.points.dimension(), self.points.count());
        let (mut first, mut of_bonds) = (0, None);
        for &field in fields {
            if !is_read(field) {
                contents.push(self.padded(field)?);
                continue;
            }
            let known = match of_bonds.take() {
                Some(known) => known,
                None => self.kinematics_of(&read)?,
            };
            contents.push(self.pad(field, &known[first..], known.len() / count)?);
            first += field.components(dimension);
            of_bonds = Some(known);
        }
        let positions = self.padded(Field::Position)?;
        let arrays = fields.iter().zip(&contents).map(|(field, values)| PointArray {
            name: field.name(),
            components: field.components(3),
            values,
        });
        let arrays = memory::collected(arrays, "fields")?;
        vtu::write(path.as_ref(), self.time(), &positions, &arrays)
    }

    /// Writes the next `.vtu` of a series beside the `.pvd` file that lists them, and rewrites that.
    ///
    /// # Errors
    /// As [`Simulation::write_vtk`]; `Argument` for a path that does not end in `.pvd`.
    pub fn write_series(&self, pvd: impl AsRef<Path>, fields: &[Field]) -> Result<()> {
        // Set-up may tell the log, and must not do so under the lock.
        self.built()?;
        let mut series = self.series.lock().unwrap_or_else(|poison| poison.into_inner());
        let file = series.next_file(pvd.as_ref())?;
        self.write_vtk(&file, fields)?;
        series.commit(pvd.as_ref(), self.time())
    }

    /// A field in the host's order, with zeros where a body in space has numbers that a plane one has not,
    /// as the file format wants: vectors have 3, tensors 3 rows of 3.
    fn padded(&self, field: Field) -> Result<Vec<f64>> {
        self.pad(field, &self.inner(field)?, field.components(self.points.dimension()))
    }

    /// The same, of a field whose numbers come first among so many a point, in the inner order.
    fn pad(&self, field: Field, inner: &[f64], width: usize) -> Result<Vec<f64>> {
        let (own, stride) = (field.components(self.points.dimension()), field.components(3));
        let mut values = memory::filled(0.0, self.points.count() * stride, "a field")?;
        for (point, values) in values.chunks_exact_mut(stride).enumerate() {
            let from = self.points.order().place(point) * width;
            values[..own].copy_from_slice(&inner[from..from + own]);
        }
        if own == 4 {
            for tensor in values.chunks_exact_mut(stride) {
                let [xx, xy, yx, yy] = [0, 1, 2, 3].map(|place| tensor[place]);
                tensor.copy_from_slice(&[xx, xy, 0.0, yx, yy, 0.0, 0.0, 0.0, 0.0]);
            }
        }
        Ok(values)
    }
}
