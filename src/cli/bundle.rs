//! `soilsig bundle`: a result as one file, to be made again elsewhere.

use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use serde_json::Value;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::arguments::utf8_path;
use super::{Context, Outcome};
use crate::pipeline::Source;
use crate::pipeline::inputs;
use crate::pipeline::record::Record;
use crate::scene::{Change, Scene, SceneGeometry};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::output;
use crate::support::ro_crate;
use crate::sweep::record::{SWEEP, Sweep};

/// Packs a result with all that it was made of into one zip file
///
/// `soilsig replay` makes the result again from it, on another machine, and compares every file.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a result of `soilsig pipeline` or `soilsig sweep`
    #[arg(value_parser = utf8_path())]
    result: PathBuf,
    /// File to write [default: NAME-OF-THE-FOLDER.zip]
    #[arg(long, short, value_name = "FILE.zip", value_parser = utf8_path())]
    out: Option<PathBuf>,
}

fn wrong(path: &Path, problem: impl Into<Box<str>>, hint: &'static str) -> Error {
    FileError::wrong(path, problem).with_hint(hint).into()
}

/// The record of a result.
#[allow(clippy::large_enum_variant, reason = "a program holds one")]
pub enum Recorded {
    /// Of the pipeline.
    Run(Record),
    /// Of a sweep.
    Sweep(Box<Sweep>),
}

impl Recorded {
    /// The record in a folder, and its file.
    pub fn of(folder: &Path) -> Result<(Self, PathBuf), Error> {
        let sweep = folder.join(SWEEP);
        if sweep.is_file() {
            return Ok((Self::Sweep(Box::new(Sweep::read(&sweep)?)), sweep));
        }
        let run = folder.join(crate::pipeline::RUN);
        Ok((Self::Run(Record::read(&run)?), run))
    }
}

/// Most bytes of what a bundle unpacks to: others may have made it.
const MOST_BYTES: u64 = 50_000_000_000;

pub fn run(args: &Args, context: &Context) -> Outcome {
    let folder = &args.result;
    let (record, file) = Recorded::of(folder)?;
    let (read, written, versions) = match &record {
        Recorded::Run(record) => (&record.inputs, &record.outputs, &record.versions),
        Recorded::Sweep(record) => (&record.inputs, &record.outputs, &record.versions),
    };
    if !read.is_empty() && !inputs::are_whole(read, folder) {
        let problem = "its copies of the inputs are missing or were changed";
        return Err(wrong(folder, problem, "run it again with this version"));
    }
    stands_alone(&record, folder)?;
    let mut names: Vec<String> = written
        .iter()
        .filter(|(name, output)| output.reproducible || *name == "report.html")
        .map(|(name, _)| name.clone())
        .collect();
    names.extend(inputs::places(read.keys()).into_values());
    names.extend([ro_crate::FILE.to_owned(), name_of(&file)]);
    names.sort_unstable();
    names.dedup();
    let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.clone());
    let stem = name_of(&absolute);
    let out = args.out.clone().unwrap_or_else(|| format!("{stem}.zip").into());
    output::keeps(names.iter().map(|name| folder.join(name)), [&out])?;
    let partial = output::Beside::new(&out)?;
    let failed = |error: ZipError| partial.error(error.into());
    let mut zip = ZipWriter::new(partial.handle()?);
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .large_file(true);
    for name in &names {
        let path = output::within(folder, name)?;
        let mut file = std::fs::File::open(&path).map_err(FileError::read(&path))?;
        zip.start_file(name.as_str(), options).map_err(failed)?;
        std::io::copy(&mut file, &mut zip).map_err(|error| partial.error(error))?;
    }
    zip.finish().map_err(failed)?;
    partial.done()?;
    let mut text = format!("{} files in {}\n", names.len(), out.display());
    if let Some(blender) = versions.get("blender") {
        let of = |name: &str| versions.get(name).map_or("?", String::as_str);
        text += &format!(
            "the same beds need Blender {blender} with Python {} and numpy {}\n",
            of("python"),
            of("numpy")
        );
    }
    context.print(&text)?;
    Ok(None)
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Refuses a scene that names files by places of this machine.
fn stands_alone(record: &Recorded, folder: &Path) -> Result<(), Error> {
    let (source, read, set) = match record {
        Recorded::Run(record) => (&record.options.source, &record.inputs, &record.options.set[..]),
        Recorded::Sweep(record) => (&record.study.source, &record.inputs, &record.study.set[..]),
    };
    let mut named = Vec::new();
    let mut at = folder.to_owned();
    if let Source::Scene(path) = source {
        let path = match record {
            Recorded::Run(_) => path.clone(),
            Recorded::Sweep(record) => {
                named.push(path.clone());
                record.study_file.parent().unwrap_or(Path::new("")).join(path)
            }
        };
        at = inputs::copied(&path, read, folder);
        let facets = |change: &&Change| change.key() != "facets";
        let set: Vec<Change> = set.iter().filter(facets).cloned().collect();
        let mut scene = Scene::read(&at)?.changed(&set)?;
        named.extend(scene.files_mut().iter().map(|file| file.path.clone()));
        match &scene.geometry {
            SceneGeometry::Packing(packing) => named.extend(packing.library.clone()),
            SceneGeometry::Placed(placed) => {
                named.extend(placed.prototypes.iter().map(|prototype| prototype.file.clone()));
            }
        }
    }
    if let Recorded::Sweep(record) = record {
        texts(&serde_json::to_value(&record.study.axes).expect("plain data"), &mut named);
    }
    match named.iter().find(|path| path.is_absolute()) {
        None => Ok(()),
        Some(file) => {
            let problem = format!("the scene names {}, a place of this machine", file.display());
            Err(wrong(&at, problem, "name it relative to the scene file, and run it again"))
        }
    }
}

/// All texts in a value, as paths.
fn texts(value: &Value, found: &mut Vec<PathBuf>) {
    match value {
        Value::String(text) => found.push(text.into()),
        Value::Array(list) => list.iter().for_each(|value| texts(value, found)),
        Value::Object(keys) => keys.values().for_each(|value| texts(value, found)),
        _ => {}
    }
}

/// Unpacks a bundle into a folder.
pub fn unpack(bundle: &Path, folder: &Path) -> Result<(), Error> {
    let file = std::fs::File::open(bundle).map_err(FileError::read(bundle))?;
    let not_one =
        |problem: String| wrong(bundle, problem, "name a file that `soilsig bundle` wrote");
    unpacked(file, folder).map_err(|error| match error {
        Unpacked::Zip(error) => not_one(format!("it is not a bundle: {error}")),
        Unpacked::Large => not_one("it unpacks to more than 50 GB".into()),
        Unpacked::Output(error) => error,
    })
}

enum Unpacked {
    Zip(ZipError),
    Large,
    Output(Error),
}

fn unpacked(file: impl Read + Seek, folder: &Path) -> Result<(), Unpacked> {
    let mut zip = ZipArchive::new(file).map_err(Unpacked::Zip)?;
    let mut left = MOST_BYTES;
    for i in 0..zip.len() {
        let mut file = zip.by_index(i).map_err(Unpacked::Zip)?;
        if file.is_dir() {
            continue;
        }
        // No name leads out of the folder.
        let place = output::within(folder, file.name()).map_err(|e| Unpacked::Output(e.into()))?;
        let mut bytes = Vec::new();
        let count = (&mut file).take(left).read_to_end(&mut bytes);
        let count = count.map_err(|error| Unpacked::Zip(error.into()))? as u64;
        if count == left {
            return Err(Unpacked::Large);
        }
        left -= count;
        output::file(&place, |writer| writer.write_all(&bytes))
            .map_err(|error| Unpacked::Output(error.into()))?;
    }
    Ok(())
}
