//! A series of states in time: a `.pvd` collection that names one `.vtu` file for each, numbered beside it.

use std::io::Write;
use std::path::{self, Path, PathBuf};

use crate::error::{Error, Result, argument};
use crate::memory;
use crate::output::vtu::{escaped, replace_file};

/// The collections that one simulation writes.
///
/// A simulation starts each collection anew: entries that an earlier run left in the `.pvd` are not kept.
#[derive(Default)]
pub(crate) struct Series {
    collections: Vec<Collection>,
}

struct Collection {
    /// Absolute, so that `out.pvd` and `./out.pvd` are one collection.
    pvd: PathBuf,
    /// The k-th file holds the state at the k-th time.
    times: Vec<f64>,
}

impl Series {
    /// The file for the next state of the collection `pvd`: `name_000000.vtu` beside `name.pvd`.
    ///
    /// # Errors
    /// [`Error::Argument`] if `pvd` does not end in `.pvd` or its name cannot stand in XML.
    pub(crate) fn next_file(&self, pvd: &Path) -> Result<PathBuf> {
        let stem = stem(pvd)?;
        escaped(stem)?;
        let key = absolute(pvd)?;
        let written = self.collections.iter().find(|collection| collection.pvd == key);
        let index = written.map_or(0, |collection| collection.times.len());
        Ok(pvd.with_file_name(file_name(stem, index)))
    }

    /// Enters the file that [`Series::next_file`] gave, once written, as the state at `time`.
    ///
    /// # Errors
    /// Those of [`Series::next_file`], [`Error::Memory`], and [`Error::Io`] if `pvd` could not be written. The `.pvd` and the series
    /// are then as before.
    pub(crate) fn commit(&mut self, pvd: &Path, time: f64) -> Result<()> {
        let stem = escaped(stem(pvd)?)?;
        let times = self.times(absolute(pvd)?)?;
        memory::push(times, time, "the times of a series of files")?;
        let replaced = replace_file(pvd, |out| {
            writeln!(out, "<?xml version=\"1.0\"?>")?;
            writeln!(out, "<VTKFile type=\"Collection\" version=\"1.0\">")?;
            writeln!(out, "  <Collection>")?;
            for (index, time) in times.iter().enumerate() {
                let file = file_name(&stem, index);
                // The shortest decimal that gives the same number again.
                writeln!(out, "    <DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>")?;
            }
            writeln!(out, "  </Collection>\n</VTKFile>")
        });
        if replaced.is_err() {
            times.pop();
        }
        replaced
    }

    /// The times of the collection `pvd`, begun if there is none yet.
    fn times(&mut self, pvd: PathBuf) -> Result<&mut Vec<f64>> {
        let known = self.collections.iter().position(|collection| collection.pvd == pvd);
        let index = known.unwrap_or(self.collections.len());
        if known.is_none() {
            let collection = Collection { pvd, times: Vec::new() };
            memory::push(&mut self.collections, collection, "the list of file series")?;
        }
        Ok(&mut self.collections[index].times)
    }
}

fn file_name(stem: &str, index: usize) -> String {
    format!("{stem}_{index:06}.vtu")
}

fn stem(pvd: &Path) -> Result<&str> {
    let extension = pvd.extension().and_then(|extension| extension.to_str());
    let stem = pvd.file_stem().and_then(|stem| stem.to_str());
    match (stem, extension) {
        (Some(stem), Some(extension)) if extension.eq_ignore_ascii_case("pvd") => Ok(stem),
        (None, Some(_)) => {
            argument(format!("'pvd_path' is {pvd:?}; its file name must be valid UTF-8"))
        }
        _ => argument(format!(
            "'pvd_path' is '{}'; a series needs one such as 'name.pvd'",
            pvd.display()
        )),
    }
}

fn absolute(pvd: &Path) -> Result<PathBuf> {
    path::absolute(pvd).map_err(|reason| {
        Error::Io(format!("cannot write '{}': making it absolute failed: {reason}", pvd.display()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::vtu::{self, tests::scratch};
    use std::fs;

    fn name(path: &Path) -> &str {
        path.file_name().unwrap().to_str().unwrap()
    }

    #[test]
    fn a_collection_lists_its_files_by_name_with_their_times() {
        let directory = scratch("collection");
        let pvd = directory.join("crack & co.pvd");
        let mut series = Series::default();
        for time in [0.0, 1e-7, 0.1 + 0.2] {
            vtu::write(&series.next_file(&pvd).unwrap(), time, &[], &[]).unwrap();
            series.commit(&pvd, time).unwrap();
        }
        let text = fs::read_to_string(&pvd).unwrap();
        let entries = text.lines().filter(|line| line.contains("<DataSet ")).map(str::trim);
        assert!(entries.eq([
            "<DataSet timestep=\"0.0\" part=\"0\" file=\"crack &amp; co_000000.vtu\"/>",
            "<DataSet timestep=\"1e-7\" part=\"0\" file=\"crack &amp; co_000001.vtu\"/>",
            "<DataSet timestep=\"0.30000000000000004\" part=\"0\" file=\"crack &amp; co_000002.vtu\"/>",
        ]));
        for file in ["crack & co_000000.vtu", "crack & co_000001.vtu", "crack & co_000002.vtu"] {
            assert!(directory.join(file).is_file());
        }
        assert_eq!(fs::read_dir(&directory).unwrap().count(), 4);
    }

    #[test]
    fn collections_count_apart_and_however_their_path_is_spelled() {
        let directory = scratch("apart");
        let mut series = Series::default();
        series.commit(&directory.join("one.pvd"), 0.0).unwrap();
        let spelled = directory.join(".").join("one.pvd");
        assert_eq!(name(&series.next_file(&spelled).unwrap()), "one_000001.vtu");
        assert_eq!(name(&series.next_file(&directory.join("two.pvd")).unwrap()), "two_000000.vtu");
    }

    #[test]
    fn a_commit_that_fails_counts_for_nothing() {
        let directory = scratch("uncommitted");
        let pvd = directory.join("out.pvd");
        let mut series = Series::default();
        fs::create_dir(&pvd).unwrap();
        assert!(matches!(series.commit(&pvd, 0.0), Err(Error::Io(_))));
        assert_eq!(name(&series.next_file(&pvd).unwrap()), "out_000000.vtu");
        fs::remove_dir(&pvd).unwrap();
        series.commit(&pvd, 2.0).unwrap();
        assert_eq!(fs::read_to_string(&pvd).unwrap().matches("<DataSet ").count(), 1);
    }

    #[test]
    fn a_path_that_names_no_collection_is_refused() {
        let mut series = Series::default();
        for path in ["", "out", "out.vtu", ".pvd", "out.pvd/..", "bell\x07.pvd"] {
            assert!(matches!(series.next_file(Path::new(path)), Err(Error::Argument(_))), "{path}");
            assert!(matches!(series.commit(Path::new(path), 0.0), Err(Error::Argument(_))));
        }
    }
}
