//! A result into its place: all of it, or nothing.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::RUN;
use super::folder::UNFINISHED;
use super::inputs;
use super::page;
use super::record::{Output, Record};
use crate::support::error::Error;
use crate::support::output::{self, OutputError};
use crate::support::ro_crate;
use crate::support::scratch::{self, Scratch};

/// Folder of the replaced files, until all new ones are in their places.
const REPLACED: &str = ".replaced";

/// Files of every result.
pub(super) const EVERY: [&str; 12] = [
    "signature.csv",
    "signature.nc",
    "signature.svg",
    "signature.png",
    "budget.csv",
    "table.json",
    page::PATCH,
    page::LIGHT,
    page::DROP,
    page::PAGE,
    ro_crate::FILE,
    RUN,
];
/// Files that some results have. Copies of a scene's files begin as those of [`COPIES`].
const SOME: [&str; 11] = [
    "signatures.svg",
    "signatures.png",
    "patch.obj",
    "scene.json",
    "scene.glb",
    "scene.blend",
    "frames.json",
    "prototypes.obj",
    "prototypes.mtl",
    "drop.json",
    "blender.log",
];
const COPIES: [&str; 5] = ["spectrum_", "pure_bed_", "sky_", "atmosphere_", "band"];

fn at(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.to_owned();
    move |source| OutputError { path, source }
}

/// The hidden folder in which a result is made. What a killed run left is removed.
pub(super) fn begin(out: &Path) -> Result<Scratch, Error> {
    let new = scratch::beside(out)?;
    for name in output::list(out)? {
        if name.starts_with(UNFINISHED) && Path::new(&name).extension().is_some_and(|e| e == "log")
        {
            output::remove(&out.join(name))?;
        }
    }
    Ok(new)
}

/// Puts the files of a run into their places, the record last. Where one cannot be put there, those
/// before it are taken back.
pub(super) fn put(
    record: &Record,
    earlier: Option<&Record>,
    new: &Scratch,
    out: &Path,
) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(record).expect("plain data") + "\n";
    fs::write(new.path().join(RUN), text).map_err(at(&out.join(RUN)))?;
    // The earlier record goes first: it does not hold for a mixture.
    let names: Vec<&str> =
        [RUN].into_iter().chain(record.outputs.keys().map(String::as_str)).collect();
    let mut folders = BTreeSet::from([out.to_owned()]);
    for name in &names {
        let place = output::within(out, name)?;
        let file = new.path().join(name);
        let ready = || {
            let file = fs::File::open(&file)?;
            if let Ok(earlier) = fs::symlink_metadata(&place) {
                output::keep_mode(&file, &earlier)?;
            }
            file.sync_all()
        };
        ready().map_err(at(&place))?;
        let folder = place.parent().expect("it is in a folder").to_owned();
        output::folder(&folder)?;
        let replaced = new.path().join(REPLACED).join(name);
        output::folder(replaced.parent().expect("it is in a folder"))?;
        folders.insert(folder);
    }
    let _whole = scratch::whole();
    let mut moves = Moves { done: Vec::new(), kept: new.path().join(REPLACED) };
    let mut all = || -> Result<(), OutputError> {
        for name in &names {
            moves.aside(out, name)?;
        }
        for name in names.iter().rev() {
            if *name == RUN {
                // All that it describes must last before it does.
                for folder in &folders {
                    output::sync_folder(folder).map_err(at(folder))?;
                }
            }
            moves.put(&new.path().join(name), &out.join(name))?;
        }
        output::sync_folder(out).map_err(at(out))
    };
    if let Err(error) = all() {
        moves.take_back();
        return Err(error.into());
    }
    for (name, output) in earlier.iter().flat_map(|earlier| &earlier.outputs) {
        if !record.outputs.contains_key(name) {
            forget(out, name, output, record);
        }
    }
    Ok(())
}

/// Files that were moved, so that they can be moved back.
struct Moves {
    /// From where, and where to.
    done: Vec<(PathBuf, PathBuf)>,
    /// Where replaced files are.
    kept: PathBuf,
}

impl Moves {
    fn go(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)?;
        self.done.push((from.to_owned(), to.to_owned()));
        Ok(())
    }

    /// Moves an earlier file out of the way, if there is one.
    fn aside(&mut self, out: &Path, name: &str) -> Result<(), OutputError> {
        let (from, to) = (out.join(name), self.kept.join(name));
        match self.go(&from, &to) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(at(&from)(error)),
            _ => Ok(()),
        }
    }

    fn put(&mut self, from: &Path, to: &Path) -> Result<(), OutputError> {
        self.go(from, to).map_err(at(to))
    }

    fn take_back(&self) {
        for (from, to) in self.done.iter().rev() {
            let _ = fs::rename(to, from);
        }
    }
}

/// Removes a file that an earlier run wrote and this one did not. Others may have written the
/// record: a file goes only if a run could have written it there, no link leads to it, and its
/// content is the recorded one. Those that the run reads stay.
fn forget(out: &Path, name: &str, earlier: &Output, record: &Record) {
    let file_name = name.rsplit('/').next().unwrap_or_default();
    let is_ours = EVERY.iter().chain(&SOME).any(|name| *name == file_name)
        || COPIES.iter().any(|begin| file_name.starts_with(begin))
        || Path::new(name).starts_with(inputs::INPUTS);
    let Ok(path) = output::within(out, name) else { return };
    let (Ok(place), true) = (path.canonicalize(), is_ours) else { return };
    let is_read =
        record.inputs.keys().any(|input| Path::new(input).canonicalize().is_ok_and(|i| i == place));
    if !is_read && output::sha256_hex(&path).is_ok_and(|sum| sum == earlier.sha256) {
        // What cannot be removed is in nobody's way.
        let _ = output::remove(&path);
        let folders = path.ancestors().skip(1).take_while(|folder| *folder != out);
        // Those that are empty now.
        for folder in folders {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}
