//! From a scene to its signature, in stages: drop, trace, signature, picture.

mod bring;
mod error;
mod options;
mod planned;
pub mod record;
mod results;

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::beds::own_grains::{self, Library};
use crate::geometry::ingest::Sources;
use crate::pipeline::record::{Output, Record, Stage};
use crate::scene::shipped::{self, COVERAGES};
use crate::scene::{Scene, SceneGeometry};
use crate::signature::Band;
use crate::signature::budget::{Budget, Origin};
use crate::signature::plan::PILOT;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;
use crate::table::Prepared;
use crate::table::Table;
use crate::tracer::Tracer;
use crate::{report, spectrum};

pub use error::PipelineError;
pub use options::{Auto, HowMany, Options, Source};

/// Files of a drop that hold times of day or durations and so differ from run to run.
const NOT_REPRODUCIBLE: [&str; 2] = ["blender.log", "drop.json"];

/// Files of every result.
const WRITTEN: [&str; 7] = [
    "signature.csv",
    "signature.svg",
    "signature.png",
    "budget.csv",
    "table.json",
    "patch.png",
    "run.json",
];

/// Runs the pipeline; all files go below `out`. `run.json` is removed before the first result is written and
/// written last: where it is, the result is whole. A run that fails before it has a result leaves an earlier
/// one alone; one that succeeds removes what the earlier one had and it has not.
pub fn run(
    options: &Options,
    command: Vec<String>,
    out: &Path,
    cache: &Cache,
    monitor: &dyn Monitor,
) -> Result<Record, Error> {
    output::folder(out)?;
    let earlier = Record::read(&out.join("run.json")).ok();
    let mut record = Record {
        soilsig_run: self::record::FORMAT,
        command,
        options: options.clone(),
        versions: BTreeMap::from([("soilsig".into(), env!("CARGO_PKG_VERSION").into())]),
        seeds: BTreeMap::new(),
        inputs: BTreeMap::new(),
        outputs: BTreeMap::new(),
        stages: Vec::new(),
        reached: BTreeMap::new(),
    };
    match &options.source {
        Source::Coverage(name) if name == "all" => {
            let mut curves = Vec::new();
            for (name, text) in COVERAGES {
                let path = format!("scenes/{name}.json");
                let scene = Scene::parse(text, Path::new(&path))?;
                record.versions.insert(path, sha256_of(text));
                let mut run = Run::new(options, out, name, cache, &mut record, monitor);
                curves.push(run.scene(scene)?);
            }
            let mut run = Run::new(options, out, "", cache, &mut record, monitor);
            run.draw_all(&curves)?;
        }
        Source::Coverage(name) => {
            let path = PathBuf::from(format!("scenes/{name}.json"));
            let scene = if let Some(text) = shipped::text(name) {
                record.versions.insert(path.display().to_string(), sha256_of(text));
                Scene::parse(text, &path)?
            } else if let Some(share) = name.parse().ok().filter(|s| (0.0..=1.0).contains(s)) {
                Scene { file: path, ..shipped::with_cover(share) }
            } else {
                let known: Vec<_> = COVERAGES.iter().map(|(known, _)| *known).collect();
                return Err(PipelineError::Coverage {
                    wanted: name.clone(),
                    known: known.join(", "),
                }
                .into());
            };
            Run::new(options, out, "", cache, &mut record, monitor).scene(scene)?;
        }
        Source::Scene(path) => {
            let scene = Scene::read(path)?;
            record.inputs.insert(path.display().to_string(), output::sha256_hex(path)?);
            Run::new(options, out, "", cache, &mut record, monitor).scene(scene)?;
        }
    }
    for file in earlier.iter().flat_map(|earlier| earlier.outputs.keys()) {
        // The record may be by other hands: only plain names below the folder are its files.
        let below = Path::new(file).components().all(|part| matches!(part, Component::Normal(_)));
        let path = out.join(file);
        // A bed of the earlier run may be what this one was asked for.
        let is_input = |path: &Path| {
            let same =
                |input: &String| Path::new(input).canonicalize().ok() == path.canonicalize().ok();
            record.inputs.keys().any(same)
        };
        if below && !record.outputs.contains_key(file) && path.exists() && !is_input(&path) {
            output::remove(&path)?;
        }
    }
    record.write(&out.join("run.json"))?;
    Ok(record)
}

fn sha256_of(text: &str) -> String {
    output::hex(&Sha256::digest(text))
}

/// One scene's way through the stages.
struct Run<'a> {
    options: &'a Options,
    out: &'a Path,
    /// Folder of this scene's files below `out`, if they are not at its top.
    below: &'a str,
    cache: &'a Cache,
    record: &'a mut Record,
    monitor: &'a dyn Monitor,
    /// How many packings are dropped now.
    packings: usize,
}

/// A settled bed, as the tracer takes it.
struct Bed {
    prepared: Prepared,
    /// The bytes of its meshes, once they are read.
    sources: Option<Sources>,
    /// Loaded only if a stage needs it: a run that finds everything in the cache does not.
    tracer: Option<Tracer>,
}

impl Bed {
    /// The bytes of its meshes.
    fn sources(&mut self) -> Result<&Sources, Error> {
        if self.sources.is_none() {
            self.sources = Some(Sources::read(&self.prepared.scene)?);
        }
        Ok(self.sources.as_ref().expect("they were read"))
    }

    /// SHA-256 of its scene file and meshes.
    fn sha256(&mut self) -> Result<String, Error> {
        match self.tracer.as_ref().and_then(Tracer::scene_sha256) {
            Some(sum) => Ok(sum.to_owned()),
            None => Ok(self.sources()?.sha256()?),
        }
    }

    /// Its tracer, made if it is not there.
    fn tracer(&mut self) -> Result<&Tracer, Error> {
        if self.tracer.is_none() {
            self.tracer = Some(Tracer::of(self.sources()?)?);
            self.sources = None;
        }
        Ok(self.tracer.as_ref().expect("it was made"))
    }
}

impl<'a> Run<'a> {
    fn new(
        options: &'a Options,
        out: &'a Path,
        below: &'a str,
        cache: &'a Cache,
        record: &'a mut Record,
        monitor: &'a dyn Monitor,
    ) -> Self {
        let packings = match options.packings {
            HowMany::Number(number) => number,
            HowMany::Planned(_) => PILOT,
        };
        Self { options, out, below, cache, record, monitor, packings }
    }

    fn scene(&mut self, mut scene: Scene) -> Result<(Vec<Table>, Vec<Band>), Error> {
        if let Some(seed) = self.options.seed {
            scene.seed = seed;
            if let SceneGeometry::Packing(packing) = &mut scene.geometry {
                packing.seed = seed;
            }
        }
        let library = self.library(&mut scene)?;
        // Whatever is wrong with the spectra is known before Blender is started.
        let wavelengths_um = self.options.grid.wavelengths_um();
        let prepared = Prepared::new(scene.clone(), &wavelengths_um)?;
        let folder = scene.folder().to_owned();
        for (_, file) in scene.air_files_mut() {
            let file = folder.join(file);
            self.record.inputs.insert(file.display().to_string(), output::sha256_hex(&file)?);
        }
        for material in &mut scene.materials {
            let mut files: Vec<PathBuf> =
                material.spectrum.tables_mut().iter().map(|table| folder.join(table)).collect();
            if let Some(file) = material.spectrum.file_mut() {
                files.extend(spectrum::format::files(&folder.join(file))?);
            }
            for file in files {
                let sum = output::sha256_hex(&file)?;
                self.record.inputs.insert(file.display().to_string(), sum);
            }
        }
        // Before any work is done.
        self.keeps_inputs(&WRITTEN)?;
        self.record.seeds.insert(self.key("rays"), scene.seed);
        let mut beds = match scene.geometry.clone() {
            SceneGeometry::Packing(packing) => {
                self.record.seeds.insert(self.key("packing"), packing.seed);
                match self.options.packings {
                    HowMany::Number(_) => self.drop(&prepared, &packing, library.as_ref())?,
                    HowMany::Planned(_) => Vec::new(),
                }
            }
            SceneGeometry::Placed(_) if self.options.packings != HowMany::Number(1) => {
                return Err(PipelineError::OnePacking { scene: scene.file.clone() }.into());
            }
            SceneGeometry::Placed(_) if self.options.field.is_some() => {
                return Err(PipelineError::FieldOfPlaced { scene: scene.file.clone() }.into());
            }
            SceneGeometry::Placed(_) => {
                let sources = Sources::read(&scene)?;
                for (file, bytes) in sources.files() {
                    let sum = output::hex(&Sha256::digest(bytes));
                    self.record.inputs.insert(file.display().to_string(), sum);
                }
                vec![Bed { prepared: prepared.clone(), sources: Some(sources), tracer: None }]
            }
        };
        let (tables, plan) = match (self.options.packings, &scene.geometry) {
            (HowMany::Planned(_), SceneGeometry::Packing(packing)) => {
                let (planned, tables, plan) = self.planned(&prepared, packing, library.as_ref())?;
                beds = planned;
                (tables, Some(plan))
            }
            _ => (self.trace(&mut beds)?, None),
        };
        let bands = self.signature(&scene, &tables, &wavelengths_um)?;
        let origin = match &scene.geometry {
            SceneGeometry::Packing(_) if plan.is_some_and(|plan| plan.touching) => Origin::Drawn,
            SceneGeometry::Packing(packing) => Origin::of(packing),
            SceneGeometry::Placed(_) => Origin::Given,
        };
        let budget = Budget::new(&tables, &bands, origin)?;
        output::bytes(&self.place("budget.csv"), budget.csv_text().as_bytes())?;
        self.wrote("budget.csv")?;
        self.picture(&mut beds[0], &tables[0])?;
        let mut reached = report::reached(&tables, &bands, &budget, self.options.tolerance);
        if let Some(plan) = plan {
            reached.tolerance_reached = plan.is_whole();
        }
        reached.plan = plan;
        self.record.reached.insert(scene.name, reached);
        Ok((tables, bands))
    }

    /// The user's grains of a packing; those of `--grains` take the place of the shapes that they are of.
    fn library(&mut self, scene: &mut Scene) -> Result<Option<Library>, Error> {
        let folder = scene.folder().to_owned();
        let SceneGeometry::Packing(packing) = &mut scene.geometry else {
            return match self.options.grains {
                Some(_) => Err(PipelineError::GrainsOfPlaced { scene: scene.file.clone() }.into()),
                None => Ok(None),
            };
        };
        if let Some(folder) = &self.options.grains {
            own_grains::stand_in(packing, folder)?;
        }
        let library = Library::of(packing, &folder)?;
        for file in library.iter().flat_map(Library::files) {
            let sum = output::sha256_hex(&file)?;
            self.record.inputs.insert(file.display().to_string(), sum);
        }
        Ok(library)
    }

    /// A name in the record, told apart where there are several scenes.
    fn key(&self, name: &str) -> String {
        if self.below.is_empty() { name.to_owned() } else { format!("{}/{name}", self.below) }
    }

    /// Where a file of this scene goes.
    fn place(&self, file: &str) -> PathBuf {
        self.out.join(self.below).join(file)
    }

    /// A file of one packing, by its path below the scene's folder.
    fn of_packing(&self, packing: usize, file: &str) -> String {
        match self.packings {
            1 => file.to_owned(),
            _ => format!("packings/{}/{file}", packing + 1),
        }
    }

    /// From here on the folder holds parts of this run: an earlier record no longer speaks for it.
    fn begin_to_write(&self) -> Result<(), Error> {
        Ok(output::remove(&self.out.join("run.json"))?)
    }

    /// Refuses to write these files over what the run reads.
    fn keeps_inputs(&self, files: &[&str]) -> Result<(), Error> {
        let written = files.iter().map(|file| self.place(file));
        Ok(output::keeps(self.record.inputs.keys(), written)?)
    }

    /// Notes a file that was written.
    fn wrote(&mut self, file: &str) -> Result<(), Error> {
        let sha256 = output::sha256_hex(&self.place(file))?;
        let name = Path::new(file).file_name().unwrap_or_default().to_string_lossy();
        let reproducible = !NOT_REPRODUCIBLE.contains(&&*name);
        self.record.outputs.insert(self.key(file), Output { sha256, reproducible });
        Ok(())
    }

    fn stage(&mut self, name: &str, seconds: f64, cached: bool) {
        self.record.stages.push(Stage { name: self.key(name), seconds, cached });
    }
}
