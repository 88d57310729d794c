//! From a scene to its signature, in stages: drop, trace, signature, picture.

mod bring;
mod error;
mod folder;
pub mod inputs;
mod options;
pub mod page;
mod planned;
pub mod record;
mod result;
mod results;
mod soil;

use std::path::Path;
use std::time::SystemTime;

use sha2::{Digest, Sha256};

use crate::beds::own_grains::{self, OwnGrains};
use crate::geometry::ingest::Sources;
use crate::pipeline::folder::Folder;
use crate::pipeline::page::Told;
use crate::pipeline::planned::Dropped;
use crate::pipeline::record::Record;
use crate::scene::shipped::{self, COVERAGES};
use crate::scene::{Scene, SceneGeometry};
use crate::spectrum;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::lock::Lock;
use crate::support::monitor::Monitor;
use crate::support::{output, scratch};
use crate::table::Prepared;
use crate::tracer::Tracer;

pub(crate) use bring::{Settled, file_text};
pub use error::PipelineError;
pub(crate) use options::target_of;
pub use options::{Auto, HowMany, MOST_SECONDS, Options, Source, TOLERANCE};
pub(crate) use results::{TABLE, program};

/// Runs the pipeline; all files go below `out`, which no other run may write to meanwhile.
///
/// The files are put into their places when all of them are there, `run.json` last: where it is, the
/// result is whole. A run that fails leaves an earlier result as it was; one that succeeds removes
/// the files that only the earlier one had.
pub fn run(
    options: &Options,
    command: Vec<String>,
    out: &Path,
    cache: &Cache,
    monitor: &dyn Monitor,
) -> Result<Record, Error> {
    let started = SystemTime::now();
    let _lock = Lock::of(out)?;
    scratch::clear_temporary();
    let new = result::begin(out)?;
    let earlier = Record::read(&out.join(RUN)).ok();
    let mut record = Record::new(command, options);
    let mut results = Vec::new();
    let scenes = scenes(options, &mut record)?;
    let several = scenes.len() > 1;
    if let Source::Coverage(_) = options.source {
        let mut folder = Folder { out, new: new.path(), below: "", record: &mut record, monitor };
        for scene in of_source(&options.source, folder.record)? {
            folder.write(&format!("{}/{}.json", inputs::INPUTS, scene.name), file_text(&scene))?;
        }
    }
    for scene in scenes {
        let name = scene.name.clone();
        let below = if several { &*name } else { "" };
        let folder = Folder { out, new: new.path(), below, record: &mut record, monitor };
        results.push(Run::new(options, cache, folder).scene(scene)?);
    }
    let folder = Folder { out, new: new.path(), below: "", record: &mut record, monitor };
    let mut run = Run::new(options, cache, folder);
    if several {
        run.draw_all(&results)?;
        run.page_of_all(&results)?;
    }
    run.folder.copy_inputs()?;
    run.folder.write_crate(started)?;
    result::put(&record, earlier.as_ref(), &new, out)?;
    Ok(record)
}

/// The record's file.
pub const RUN: &str = "run.json";

/// The scenes of a run, with all that its options replace in them.
fn scenes(options: &Options, record: &mut Record) -> Result<Vec<Scene>, Error> {
    let changed = |scene: Scene| {
        let mut scene = scene.changed(&options.set)?;
        if let Some(facets) = options.facets {
            facets.apply(&mut scene);
        }
        Ok(scene)
    };
    of_source(&options.source, record)?.into_iter().map(changed).collect()
}

/// The scenes of a source, recorded with their SHA-256.
fn of_source(source: &Source, record: &mut Record) -> Result<Vec<Scene>, Error> {
    let mut parse = |name: &str, text: &str| {
        let path = format!("scenes/{name}.json");
        let scene = Scene::parse(text, Path::new(&path));
        record.versions.insert(path, output::hex(&Sha256::digest(text)));
        scene
    };
    Ok(match source {
        Source::Coverage(name) if name == "all" => {
            COVERAGES.iter().map(|(name, text)| parse(name, text)).collect::<Result<_, _>>()?
        }
        Source::Coverage(name) => {
            let share = name.parse().ok().filter(|share| (0.0..=1.0).contains(share));
            vec![match (shipped::text(name), share) {
                (Some(text), _) => parse(name, text)?,
                (None, Some(share)) => {
                    let file = format!("scenes/{name}.json").into();
                    Scene { file, ..shipped::with_cover(share) }
                }
                (None, None) => {
                    let known = COVERAGES.map(|(known, _)| known).join(", ");
                    return Err(PipelineError::Coverage { wanted: name.clone(), known }.into());
                }
            }]
        }
        Source::Scene(path) => {
            let scene = Scene::read(path)?;
            record.inputs.insert(path.display().to_string(), output::sha256_hex(path)?);
            vec![scene]
        }
    })
}

/// One scene's way through the stages.
struct Run<'a> {
    options: &'a Options,
    cache: &'a Cache,
    folder: Folder<'a>,
}

/// A settled bed, as the tracer takes it.
pub(crate) struct Bed {
    prepared: Prepared,
    /// Its folder below that of the scene's result; empty, or ends with a slash.
    below: String,
    /// The bytes of its meshes, once they are read.
    sources: Option<Sources>,
    /// Loaded when a stage needs it: a run that finds everything in the cache does not.
    tracer: Option<Tracer>,
}

impl Bed {
    /// A bed whose files are read when they are needed.
    pub(crate) fn new(prepared: Prepared) -> Self {
        Self { prepared, below: String::new(), sources: None, tracer: None }
    }

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
    fn new(options: &'a Options, cache: &'a Cache, folder: Folder<'a>) -> Self {
        Self { options, cache, folder }
    }

    fn scene(&mut self, mut scene: Scene) -> Result<Told, Error> {
        if let Some(seed) = self.options.seed {
            scene.seed = seed;
            if let SceneGeometry::Packing(packing) = &mut scene.geometry {
                packing.seed = seed;
            }
        }
        let library = self.library(&mut scene)?;
        // Whatever is wrong with the spectra is known before Blender is started.
        let prepared = Prepared::new(scene.clone(), &self.options.grid.wavelengths_um())?;
        for file in scene.files().iter().flat_map(|file| spectrum::format::files(file)) {
            self.folder.reads(&file)?;
        }
        // Before any work is done.
        self.folder.keeps_inputs(&result::EVERY)?;
        let rays = self.folder.key("rays");
        self.folder.record.seeds.insert(rays, scene.seed);
        let Dropped { mut beds, tables, plan, refused } = match &scene.geometry {
            SceneGeometry::Packing(packing) => {
                if let Some(soil) = scene.soil_shares() {
                    self.folder.monitor.say(&soil.line());
                }
                let key = self.folder.key("packing");
                self.folder.record.seeds.insert(key, packing.seed);
                match self.options.packings {
                    HowMany::Planned(_) => self.planned(&prepared, packing, library.as_ref())?,
                    HowMany::Number(number) => {
                        let lot = bring::lot(number);
                        let mut beds = self.drop(&prepared, packing, library.as_ref(), &lot)?;
                        let tables = self.trace(&mut beds, false)?;
                        Dropped::of(beds, tables)
                    }
                }
            }
            SceneGeometry::Placed(_) => {
                let several = matches!(self.options.packings, HowMany::Number(n) if n > 1);
                let options = [
                    ("--packings", "one bed", several),
                    ("--field", "it has its own sides", self.options.field.is_some()),
                ];
                if let Some((option, has, _)) = options.into_iter().find(|(.., asked)| *asked) {
                    return Err(PipelineError::Placed { scene: scene.file, option, has }.into());
                }
                let sources = Sources::read(&scene)?;
                for file in sources.files().keys() {
                    self.folder.reads(file)?;
                }
                let (below, sources) = (String::new(), Some(sources));
                let mut beds = vec![Bed { prepared, below, sources, tracer: None }];
                let tables = self.trace(&mut beds, false)?;
                Dropped::of(beds, tables)
            }
        };
        let mut report = self.signature(&scene, &tables, plan)?;
        report.reached.refused = refused;
        report.reached.soil = self.soil(&scene, &beds)?;
        self.picture(&mut beds[0], &tables[0])?;
        self.folder.record.reached.insert(scene.name.clone(), report.reached.clone());
        let told = Told { scene: scene.name.clone(), tables, report };
        self.page(&scene, &told)?;
        Ok(told)
    }

    /// The user's grains of a packing. Those of `--grains` replace the shapes that they stand for.
    fn library(&mut self, scene: &mut Scene) -> Result<Option<OwnGrains>, Error> {
        let folder = scene.folder().to_owned();
        let SceneGeometry::Packing(packing) = &mut scene.geometry else {
            if self.options.grains.is_none() {
                return Ok(None);
            }
            let (scene, option, has) = (scene.file.clone(), "--grains", "it has its own grains");
            return Err(PipelineError::Placed { scene, option, has }.into());
        };
        if let Some(folder) = &self.options.grains {
            own_grains::replace_shapes(packing, folder)?;
        }
        let library = OwnGrains::of(packing, &folder)?;
        for file in library.iter().flat_map(OwnGrains::files) {
            self.folder.reads(&file)?;
        }
        Ok(library)
    }
}
