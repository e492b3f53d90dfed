//! How a set of files takes the place of an earlier one: staged beside it first, then put in place by renames.
//!
//! A folder that does not exist yet appears by one rename. One that holds nothing but files of the run before is
//! exchanged with the staged folder, where the system can exchange two names at once. A folder with other files in it
//! keeps its place and its files are replaced one by one: each replacement is one rename, the manifest lists the hashes
//! of both runs meanwhile, and any failure puts the earlier files back. A full disk shows while files are staged,
//! before anything is replaced.

use super::manifest::{MANIFEST, Manifest};
use super::place::{At, Staging, at, parent, staging_in};
use crate::input::file;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What is to be put in place.
pub(crate) struct Replacement<'a> {
    /// The folder, links resolved.
    pub target: &'a Path,
    /// Files to write: relative path → bytes.
    pub files: &'a BTreeMap<String, Vec<u8>>,
    /// What the run before wrote.
    pub earlier: &'a Manifest,
    /// Files of the run before that are removed, unchanged ones only.
    pub stale: &'a BTreeSet<String>,
    /// What the folder's manifest lists afterwards.
    pub manifest: &'a Manifest,
}

impl Replacement<'_> {
    /// Puts the files in place.
    pub(crate) fn carry_out(&self) -> At<()> {
        if !self.target.exists() {
            let parent = parent(self.target);
            at(parent, fs::create_dir_all(parent))?;
            let staging = staging_in(parent)?;
            let new = self.stage(staging.path())?;
            return at(self.target, fs::rename(&new, self.target));
        }
        let whole = self.is_alone()? && !holds_working_folder(self.target);
        let staging = Staging::of(self.target)?;
        let new = self.stage(staging.path())?;
        if whole && staging.is_beside() && exchange(&new, self.target).is_ok() {
            self.keep_access_rights(&new)?;
            return self.return_others(&new);
        }
        self.one_by_one(&new, &staging.path().join("old"))
    }

    /// Writes all files and the manifest into `new` of the staging folder.
    fn stage(&self, staging: &Path) -> At<PathBuf> {
        let new = staging.join("new");
        at(&new, fs::create_dir(&new))?;
        let listed = self.manifest.to_json();
        let manifest = (MANIFEST, listed.as_slice());
        let files = self.files.iter().map(|(p, b)| (p.as_str(), b.as_slice()));
        for (path, bytes) in files.chain([manifest]) {
            let file = new.join(path);
            // An error names the place that the file is meant for; the staging folder is gone by then.
            let place = self.target.join(path);
            at(&place, fs::create_dir_all(parent(&file)))?;
            at(&place, write_through(&file, bytes))?;
        }
        Ok(new)
    }

    /// True when the folder holds only files that are replaced or removed.
    fn is_alone(&self) -> At<bool> {
        let goes = |path: &str| self.files.contains_key(path) || self.stale.contains(path);
        let all_go = |path: &str| goes(path) || !self.target.join(path).exists();
        Ok(self.earlier.paths().all(all_go) && self.first_other(self.target)?.is_none())
    }

    /// The folder keeps the access rights that its owner gave the one before.
    fn keep_access_rights(&self, old: &Path) -> At<()> {
        let rights = at(old, fs::metadata(old))?.permissions();
        at(self.target, fs::set_permissions(self.target, rights))
    }

    /// The first entry of a tree that the run before did not write, folders without any of its files included.
    fn first_other(&self, root: &Path) -> At<Option<String>> {
        let mut open = vec![String::new()];
        while let Some(folder) = open.pop() {
            let path = root.join(&folder);
            for entry in at(&path, fs::read_dir(&path))? {
                let entry = at(&path, entry)?;
                let kind = at(&path, entry.file_type())?;
                let Some(name) = entry.file_name().to_str().map(str::to_owned) else {
                    return Ok(Some(entry.file_name().to_string_lossy().into_owned()));
                };
                let relative = match folder.as_str() {
                    "" => name,
                    inside => format!("{inside}/{name}"),
                };
                let inside = format!("{relative}/");
                if kind.is_dir() && self.earlier.paths().any(|p| p.starts_with(&inside)) {
                    open.push(relative);
                } else if !kind.is_file() || !(relative == MANIFEST || self.earlier.lists(&relative)) {
                    return Ok(Some(relative));
                }
            }
        }
        Ok(None)
    }

    /// After the exchange: whatever appeared in the folder since it was looked at goes back into it.
    fn return_others(&self, old: &Path) -> At<()> {
        while let Some(relative) = self.first_other(old)? {
            let back = self.target.join(&relative);
            at(parent(&back), fs::create_dir_all(parent(&back)))?;
            at(&back, fs::rename(old.join(&relative), &back))?;
        }
        Ok(())
    }

    /// Replaces file by file; the earlier files wait as copies in `old`.
    fn one_by_one(&self, new: &Path, old: &Path) -> At<()> {
        at(old, fs::create_dir(old))?;
        let manifest = MANIFEST.to_owned();
        let written: Vec<&String> = self.files.keys().chain([&manifest]).collect();
        for path in written.iter().copied().chain(self.stale) {
            let (from, to) = (self.target.join(path), old.join(path));
            if from.is_file() {
                at(parent(&to), fs::create_dir_all(parent(&to)))?;
                at(&to, copy(&from, &to))?;
            }
        }
        let result = self.exchange_files(new, &written);
        if result.is_err() {
            // Back to what was there; the error that is returned names the file that failed.
            for path in written.iter().copied().chain(self.stale) {
                let (copy, place) = (old.join(path), self.target.join(path));
                let _ = if copy.is_file() { put(&copy, &place) } else { fs::remove_file(&place) };
            }
        }
        self.remove_empty_folders();
        result
    }

    fn exchange_files(&self, new: &Path, written: &[&String]) -> At<()> {
        let mut both = self.manifest.clone();
        both.replacing = self.earlier.replacing.clone();
        both.replacing.extend(self.earlier.files.clone());
        let (listing, place) = (new.join("both"), self.target.join(MANIFEST));
        at(&listing, write_through(&listing, &both.to_json()))?;
        at(&place, fs::rename(&listing, &place))?;
        // The manifest comes last in `written`: from then on only the new hashes count.
        for path in written.iter().filter(|p| p.as_str() != MANIFEST) {
            let place = self.target.join(path);
            at(parent(&place), fs::create_dir_all(parent(&place)))?;
            at(&place, put(&new.join(path), &place))?;
        }
        for path in self.stale {
            let place = self.target.join(path);
            at(&place, fs::remove_file(&place))?;
        }
        at(&place, fs::rename(new.join(MANIFEST), &place))
    }

    /// Folders that held files of the run before and hold nothing any more.
    fn remove_empty_folders(&self) {
        for path in self.stale {
            let mut folder = Path::new(path).parent();
            while let Some(inside) = folder.filter(|f| !f.as_os_str().is_empty()) {
                // Fails on a folder that is not empty, which is then left.
                if fs::remove_dir(self.target.join(inside)).is_err() {
                    break;
                }
                folder = inside.parent();
            }
        }
    }
}

/// Writes a file and waits until the disk has it: a full disk or a quota shows here.
fn write_through(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Renames a file, or copies it where a folder inside the target is another file system.
fn put(from: &Path, to: &Path) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(error) if error.kind() == io::ErrorKind::CrossesDevices => {
            let beside = tempfile::Builder::new().prefix(".muspin-").tempfile_in(parent(to))?;
            copy(from, beside.path())?;
            beside.as_file().sync_all()?;
            beside.persist(to).map_err(|error| error.error)?;
            fs::remove_file(from)
        }
        done => done,
    }
}

/// Copies a file with its access rights.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    let mut earlier = file::open(from, file::WRITTEN)?;
    io::copy(&mut earlier, &mut fs::File::create(to)?)?;
    fs::set_permissions(to, fs::metadata(from)?.permissions())
}

/// A shell that stands in the folder would be left in the exchanged one.
fn holds_working_folder(folder: &Path) -> bool {
    std::env::current_dir().is_ok_and(|here| here.starts_with(folder))
}

/// Exchanges the names of two folders in one step.
#[cfg(target_os = "linux")]
fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

#[cfg(not(target_os = "linux"))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
