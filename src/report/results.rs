//! The results folder of a run, staged in memory and written whole or not at all.
//!
//! Files are written into a temporary folder beside the target; only when every file is there does the target give way and
//! the new folder takes its name. An existing results folder is therefore replaced at the end of a run, never half-way.
//! Files come in the order of their paths and hold no clock, machine or thread count: same run, same bytes.

use super::plot::{Figure, PlotError, picture};
use super::tables::Table;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// Why a results folder could not be staged or written.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// A path inside the folder is absolute, climbs out of it, or is empty.
    #[error("'{path}' is not a path inside a results folder")]
    Path {
        /// The path.
        path: String,
    },
    /// A picture could not be drawn.
    #[error("picture '{stem}': {source}")]
    Picture {
        /// Stem of the files.
        stem: String,
        /// Reason.
        source: PlotError,
    },
    /// The target exists and is something else than a folder muspin may replace.
    #[error("'{}' exists and is not a results folder (no summary.json in it)", .path.display())]
    NotResults {
        /// The target.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("'{}': {source}", .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Reason.
        source: io::Error,
    },
}

/// Files of a run: relative path with `/` → bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ResultsFolder {
    files: BTreeMap<String, Vec<u8>>,
}

impl ResultsFolder {
    /// An empty folder.
    pub fn new() -> Self {
        Self::default()
    }

    /// Stages a file, replacing one of the same path.
    ///
    /// # Errors
    /// [`ResultsError::Path`] for a path that would leave the folder.
    pub fn add(&mut self, path: &str, bytes: impl Into<Vec<u8>>) -> Result<(), ResultsError> {
        let inside = !path.contains('\\')
            && path
                .split('/')
                .all(|part| !part.is_empty() && part != "." && part != "..");
        if !inside {
            return Err(ResultsError::Path {
                path: path.to_owned(),
            });
        }
        self.files.insert(path.to_owned(), bytes.into());
        Ok(())
    }

    /// Stages `plots/<stem>.svg` and `plots/<stem>.csv`.
    ///
    /// # Errors
    /// [`ResultsError::Picture`] with the reason.
    pub fn add_plot(&mut self, stem: &str, figure: &Figure) -> Result<(), ResultsError> {
        let drawn = picture(figure).map_err(|source| ResultsError::Picture {
            stem: stem.to_owned(),
            source,
        })?;
        self.add(&format!("plots/{stem}.svg"), drawn.svg)?;
        self.add(&format!("plots/{stem}.csv"), drawn.csv)
    }

    /// Stages a table as CSV.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn add_table(&mut self, path: &str, table: &Table) -> Result<(), ResultsError> {
        self.add(path, table.to_csv())
    }

    /// Staged files in the order of their paths.
    pub fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files
            .iter()
            .map(|(path, bytes)| (path.as_str(), bytes.as_slice()))
    }

    /// Staged pictures, `plots/*.svg`, as stem and SVG text in the order of the stems.
    pub fn pictures(&self) -> Vec<(String, String)> {
        self.files()
            .filter_map(|(path, bytes)| {
                let stem = path.strip_prefix("plots/")?.strip_suffix(".svg")?;
                Some((stem.to_owned(), String::from_utf8_lossy(bytes).into_owned()))
            })
            .collect()
    }

    /// Writes all files to `target`, which is replaced if it is an earlier results folder or empty.
    ///
    /// # Errors
    /// [`ResultsError::NotResults`] when the target holds something else; [`ResultsError::Io`] with the path.
    /// In both cases the target is as it was.
    pub fn write(&self, target: &Path) -> Result<(), ResultsError> {
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| ResultsError::Io { path, source }
        };
        let replaced = replaceable(target)?;
        let parent = match target.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        std::fs::create_dir_all(parent).map_err(failed(parent))?;
        let staging = tempfile::Builder::new()
            .prefix(".muspin-")
            .tempdir_in(parent)
            .map_err(failed(parent))?;
        let (new, old) = (staging.path().join("new"), staging.path().join("old"));
        std::fs::create_dir(&new).map_err(failed(&new))?;
        for (path, bytes) in &self.files {
            let file = new.join(path);
            if let Some(folder) = file.parent() {
                std::fs::create_dir_all(folder).map_err(failed(folder))?;
            }
            std::fs::write(&file, bytes).map_err(failed(&file))?;
        }
        if replaced {
            std::fs::rename(target, &old).map_err(failed(target))?;
        }
        if let Err(source) = std::fs::rename(&new, target) {
            if replaced {
                // Back to what was there; if even that fails the error below names the target.
                let _ = std::fs::rename(&old, target);
            }
            return Err(failed(target)(source));
        }
        Ok(())
    }
}

/// Whether something stands at the target that a run may replace.
fn replaceable(target: &Path) -> Result<bool, ResultsError> {
    if !target.exists() {
        return Ok(false);
    }
    let is_empty = || std::fs::read_dir(target).is_ok_and(|mut entries| entries.next().is_none());
    if target.is_dir() && (target.join("summary.json").is_file() || is_empty()) {
        Ok(true)
    } else {
        Err(ResultsError::NotResults {
            path: target.to_owned(),
        })
    }
}
