//! The output folder of a run, staged in memory and written whole or not at all.
//!
//! Rules: a file that exists is replaced only if the folder's manifest lists it and it is unchanged since; files of the
//! run before that this run does not write are removed; everything else in the folder stays. A link given as folder is
//! followed. A folder with a measurement in it is never an output folder. Files come in the order of their paths and
//! hold no clock, machine or thread count: same run, same bytes.

use super::atomic::Replacement;
use super::manifest::{MANIFEST, Manifest, is_inside};
use super::pictures::PictureName;
use super::place::{Lock, absolute, parent, try_writing};
use super::plot::{Drawing, Figure, Picture, PictureFormat, PlotError, picture};
use super::tables::Table;
use crate::input::file::{self, FileError};
use crate::input::quote::without_direction_marks;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

/// Why a results folder could not be staged or written.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// A path inside the folder is absolute, climbs out of it, or is empty.
    #[error("'{0}' is not a path inside a results folder")]
    Path(String),
    /// A picture could not be drawn.
    #[error("picture '{0}': {1}")]
    Picture(String, #[source] PlotError),
    /// The target exists and is no folder.
    #[error("'{}' exists and is not a folder", .0.display())]
    NotAFolder(PathBuf),
    /// The target is a link that leads nowhere.
    #[error("'{}' is a link to a folder that does not exist", .0.display())]
    BrokenLink(PathBuf),
    /// The target holds a measurement.
    #[error("'{}' is a measurement folder (it holds measurement.yaml); nothing is written into it", .0.display())]
    Measurement(PathBuf),
    /// A file stands where one would be written, and muspin did not write it.
    #[error("'{}' exists and is not a file that muspin wrote there", .0.display())]
    Foreign(PathBuf),
    /// A file that muspin wrote was changed since.
    #[error("'{}' was changed since muspin wrote it", .0.display())]
    Edited(PathBuf),
    /// A file that the run reads would be replaced or removed.
    #[error("'{}' is read by this run and would be replaced by it", .0.display())]
    Input(PathBuf),
    /// The manifest of the folder cannot be read.
    #[error("'{}' is not a manifest of muspin: {}", .0.display(), .1)]
    Manifest(PathBuf, #[source] io::Error),
    /// The file system refused.
    #[error("'{}': {}", .0.display(), .1)]
    Io(PathBuf, #[source] io::Error),
}

/// Files of a run: relative path with `/` → bytes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResultsFolder {
    files: BTreeMap<String, Vec<u8>>,
    /// What the pictures are drawn from, by their stems.
    drawings: BTreeMap<String, Drawing>,
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
        if !is_inside(path) || path == MANIFEST {
            return Err(ResultsError::Path(path.to_owned()));
        }
        self.files.insert(path.to_owned(), bytes.into());
        Ok(())
    }

    /// Draws a figure and stages `plots/<stem>.svg` and `plots/<stem>.csv`.
    ///
    /// # Errors
    /// [`ResultsError::Picture`] with the reason.
    pub fn add_plot(&mut self, name: impl Into<PictureName>, figure: &Figure) -> Result<(), ResultsError> {
        self.add_drawn(name.into(), picture(figure))
    }

    /// As [`Self::add_plot`] of each figure; they are drawn side by side.
    pub(crate) fn add_plots(&mut self, figures: Vec<(PictureName, Figure)>) -> Result<(), ResultsError> {
        let drawn: Vec<_> = figures.into_par_iter().map(|(name, figure)| (name, picture(&figure))).collect();
        drawn.into_iter().try_for_each(|(name, drawn)| self.add_drawn(name, drawn))
    }

    fn add_drawn(&mut self, name: PictureName, drawn: Result<Picture, PlotError>) -> Result<(), ResultsError> {
        let drawn = drawn.map_err(|source| ResultsError::Picture(name.stem(), source))?;
        self.add_picture(name, drawn)
    }

    /// Stages `plots/<stem>.svg` and `plots/<stem>.csv`.
    pub(crate) fn add_picture(&mut self, name: impl Into<PictureName>, drawn: Picture) -> Result<(), ResultsError> {
        let stem = name.into().stem();
        self.add(&format!("plots/{stem}.svg"), without_direction_marks(&drawn.svg).into_owned())?;
        self.add(&format!("plots/{stem}.csv"), drawn.csv)?;
        self.drawings.extend(drawn.drawing.map(|drawing| (stem, drawing)));
        Ok(())
    }

    /// Puts texts of the staged pictures into other words.
    pub(crate) fn reword_pictures(&mut self, words: fn(&str) -> String) {
        let is_picture = |path: &str| path.starts_with("plots/") && path.ends_with(".svg");
        for (_, bytes) in self.files.iter_mut().filter(|(path, _)| is_picture(path)) {
            *bytes = words(&String::from_utf8_lossy(bytes)).into_bytes();
        }
        // A text stands between the ends of its elements, as in the SVG.
        let word = |text: &str| words(&format!(">{text}<")).trim_matches(['<', '>']).to_owned();
        self.drawings.values_mut().for_each(|drawing| drawing.reword(word));
    }

    /// Stages every picture that stands still in further formats, `plots/<stem>.png` and so on; they are drawn side by
    /// side. The SVG is there already.
    ///
    /// # Errors
    /// [`ResultsError::Picture`] with the reason.
    pub fn add_formats(&mut self, formats: &[PictureFormat]) -> Result<(), ResultsError> {
        let further = [PictureFormat::Png, PictureFormat::Pdf].into_iter().filter(|format| formats.contains(format));
        let wanted: Vec<_> = further.flat_map(|format| self.drawings.iter().map(move |one| (format, one))).collect();
        let drawn = wanted.into_par_iter().map(|(format, (stem, drawing))| {
            let file = drawing.file(format).map_err(|source| ResultsError::Picture(stem.clone(), source))?;
            Ok((format!("plots/{stem}.{}", format.name()), file))
        });
        let drawn: Vec<(String, Vec<u8>)> = drawn.collect::<Result<_, ResultsError>>()?;
        drawn.into_iter().try_for_each(|(path, file)| self.add(&path, file))
    }

    /// Stages a table as CSV.
    pub(crate) fn add_table(&mut self, path: &str, table: &Table) -> Result<(), ResultsError> {
        self.add(path, table.to_csv())
    }

    /// Staged files in the order of their paths.
    pub fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.iter().map(|(path, bytes)| (path.as_str(), bytes.as_slice()))
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

    /// Writes all files and their manifest to `target`.
    ///
    /// # Errors
    /// [`ResultsError`] with the file or folder that must not be touched, or that the file system refused. The target
    /// is as it was.
    pub fn write(&self, target: &Path) -> Result<(), ResultsError> {
        let target = resolve_target(target)?;
        let _lock = lock_target(&target)?;
        let earlier = manifest(&target)?;
        let mut stale = BTreeSet::new();
        for path in list_unchanged(&target, &earlier)? {
            if !self.files.contains_key(path) {
                stale.insert(path.to_owned());
            }
        }
        for (path, bytes) in &self.files {
            is_free(&target, &earlier, path, Some(bytes))?;
        }
        self.replace(&target, &earlier, &stale, Manifest::of(self.files()))
    }

    /// Adds the files to a folder whose other files stay, as `muspin report` does with its page.
    pub(crate) fn write_into(&self, target: &Path) -> Result<(), ResultsError> {
        let target = resolve_target(target)?;
        let _lock = lock_target(&target)?;
        let earlier = manifest(&target)?;
        for (path, bytes) in &self.files {
            let file = target.join(path);
            if earlier.lists(path) && file.exists() && !is_unchanged(&file, path, &earlier)? {
                return Err(ResultsError::Edited(file));
            }
            is_free(&target, &earlier, path, Some(bytes))?;
        }
        let mut listed = Manifest::of(self.files());
        for (path, hash) in &earlier.files {
            listed.files.entry(path.clone()).or_insert(hash.clone());
        }
        listed.replacing = earlier.replacing.clone();
        listed.replacing.retain(|path, _| !self.files.contains_key(path));
        self.replace(&target, &earlier, &BTreeSet::new(), listed)
    }

    fn replace(
        &self,
        target: &Path,
        earlier: &Manifest,
        stale: &BTreeSet<String>,
        manifest: Manifest,
    ) -> Result<(), ResultsError> {
        let replacement = Replacement { target, files: &self.files, earlier, stale, manifest: &manifest };
        replacement.carry_out().map_err(name_refusal)
    }
}

/// Checks before a run starts that its output folder can be written: `names` are files that it is sure to write,
/// `inputs` the files and folders that it reads (names of shipped files and paths that do not exist are passed over).
///
/// # Errors
/// [`ResultsError`] with what must not be touched.
pub fn claim(target: &Path, names: &[&str], inputs: &[&str]) -> Result<(), ResultsError> {
    let target = resolve_target(target)?;
    let earlier = manifest(&target)?;
    let written: Vec<PathBuf> = list_unchanged(&target, &earlier)?.into_iter().map(|path| target.join(path)).collect();
    for input in inputs {
        let Ok(read) = std::fs::canonicalize(input) else {
            continue;
        };
        // Of a measurement folder, what lies in a folder below it is read where its list names it.
        let list = file::read_text(&read.join("measurement.yaml"), file::KEYS).unwrap_or_default();
        let is_read = |file: &PathBuf| match file.strip_prefix(&read) {
            Ok(inside) if read.is_dir() && file.parent() != Some(&read) => list.contains(&*inside.to_string_lossy()),
            found => found.is_ok(),
        };
        let hit = written.iter().filter_map(|w| w.canonicalize().ok()).find(is_read);
        if let Some(path) = hit {
            return Err(ResultsError::Input(path));
        }
    }
    for name in names {
        is_free(&target, &earlier, name, None)?;
    }
    try_writing(&target).map_err(name_refusal)
}

/// An error of the file system.
fn name_refusal((path, source): (PathBuf, io::Error)) -> ResultsError {
    ResultsError::Io(path, source)
}

/// Keeps other runs out of the folder from before it is looked at until it is written.
fn lock_target(target: &Path) -> Result<Lock, ResultsError> {
    let folder = parent(target);
    std::fs::create_dir_all(folder).map_err(|source| name_refusal((folder.to_owned(), source)))?;
    Lock::beside(target).map_err(name_refusal)
}

/// The folder itself, links followed and `..` resolved.
fn resolve_target(target: &Path) -> Result<PathBuf, ResultsError> {
    let path = target.to_owned();
    let Ok(found) = absolute(target) else {
        return Err(ResultsError::BrokenLink(path));
    };
    if let Some(file) = found.ancestors().find(|part| part.exists()).filter(|part| !part.is_dir()) {
        return Err(ResultsError::NotAFolder(file.to_owned()));
    }
    if found.join("measurement.yaml").exists() {
        return Err(ResultsError::Measurement(path));
    }
    Ok(found)
}

fn manifest(target: &Path) -> Result<Manifest, ResultsError> {
    Manifest::read(target).map_err(|source| ResultsError::Manifest(target.join(MANIFEST), source))
}

/// Listed files that exist; all of them must be as muspin wrote them.
fn list_unchanged<'a>(target: &Path, earlier: &'a Manifest) -> Result<Vec<&'a str>, ResultsError> {
    let mut found = vec![];
    for path in earlier.paths() {
        let file = target.join(path);
        if std::fs::symlink_metadata(&file).is_err() {
            continue;
        }
        if !is_unchanged(&file, path, earlier)? {
            return Err(ResultsError::Edited(file));
        }
        found.push(path);
    }
    Ok(found)
}

fn is_unchanged(place: &Path, path: &str, earlier: &Manifest) -> Result<bool, ResultsError> {
    match file::read_unlinked(place, file::WRITTEN) {
        Ok(bytes) => Ok(earlier.wrote(path, &bytes)),
        Err(FileError::System(source)) => Err(ResultsError::Io(place.to_owned(), source)),
        Err(_) => Ok(false),
    }
}

/// Whether a file may be written: nothing is there, a file of the run before, or the same bytes.
fn is_free(target: &Path, earlier: &Manifest, path: &str, bytes: Option<&[u8]>) -> Result<(), ResultsError> {
    let parts: Vec<&str> = path.split('/').collect();
    for k in 1..parts.len() {
        let folder = target.join(parts[..k].join("/"));
        let taken = std::fs::symlink_metadata(&folder).is_ok_and(|m| !m.is_dir());
        // A file of the run before gives way to a folder of the same name only by hand.
        if taken {
            return Err(ResultsError::Foreign(folder));
        }
    }
    let place = target.join(path);
    let Ok(found) = std::fs::symlink_metadata(&place) else {
        return Ok(());
    };
    let same = || bytes.is_some_and(|b| file::read_unlinked(&place, file::WRITTEN).is_ok_and(|there| there == b));
    if found.is_file() && (earlier.lists(path) || same()) {
        return Ok(());
    }
    Err(ResultsError::Foreign(place))
}
