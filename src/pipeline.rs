//! From a scene to its signature, in stages: drop, trace, signature, picture.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::beds::Order;
use crate::blender;
use crate::budget::{Budget, Origin};
use crate::cache::{Cache, Made};
use crate::course::Course;
use crate::error::Error;
use crate::ingest;
use crate::library::{self, Library};
use crate::output;
use crate::packings::HowMany;
use crate::picture;
use crate::plan::{PILOT, Plan};
use crate::progress::Step;
use crate::radiometry::Assumed;
use crate::random;
use crate::record::{self, Output, Record, Stage};
use crate::report;
use crate::scene::{Collision, Packing, Placed, Scene, SceneGeometry, Sides};
use crate::shipped::{self, COVERAGES};
use crate::signature::{self, Band, Grid};
use crate::spectrum;
use crate::stop::Target;
use crate::table::Table;
use crate::trace;
use crate::tracer::Tracer;
use crate::words;

/// Files of a drop that hold times of day or durations and so differ from run to run.
const NOT_REPRODUCIBLE: [&str; 2] = ["blender.log", "drop.json"];

/// What is to be run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A shipped scene by its coverage: `full`, `less`, `sparse`, `bare`; `all` of them; or the share of the
    /// grains' silhouettes to be covered with fines, 0 to 1.
    Coverage(String),
    /// A scene file, packing or placed.
    Scene(PathBuf),
}

/// Everything that a run depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// The scene.
    pub source: Source,
    /// The user's grains, in place of the shapes that are their size classes.
    #[serde(default)]
    pub grains: Option<PathBuf>,
    /// In place of the scene's seeds, of packing and rays both.
    pub seed: Option<u64>,
    /// How many packings are dropped.
    pub packings: HowMany,
    /// Particles of the field that each packing is to be a patch of; `None` for the packing within mirror sides.
    pub field: Option<f64>,
    /// Half-width of the 95 % interval that every band is to reach: of several packings their mean.
    pub tolerance: f64,
    /// Most paths for a packing.
    pub max_paths: u64,
    /// Longest that the trace of a packing may take, seconds.
    #[serde(default)]
    pub max_seconds: Option<f64>,
    /// The bands.
    pub grid: Grid,
    /// Whether the settled patch is exported flat as well.
    pub patch_obj: bool,
    /// The Blender to use.
    pub blender: Option<PathBuf>,
    /// Longest that Blender may take, seconds.
    pub blender_timeout_s: u64,
}

/// Runs the pipeline; all files go below `out`. `run.json` is removed before the first result is written and
/// written last: where it is, the result is whole. A run that fails before it has a result leaves an earlier
/// one alone; one that succeeds removes what the earlier one had and it has not.
pub fn run(
    options: &Options,
    command: Vec<String>,
    out: &Path,
    cache: &Cache,
) -> Result<Record, Error> {
    output::folder(out)?;
    let earlier = Record::read(&out.join("run.json")).ok();
    let mut record = Record {
        soilsig_run: record::FORMAT,
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
                let mut run = Run::new(options, out, name, cache, &mut record);
                curves.push(run.scene(scene, Path::new(name))?);
            }
            let mut run = Run::new(options, out, "", cache, &mut record);
            run.draw_all(&curves)?;
        }
        Source::Coverage(name) => {
            let path = PathBuf::from(format!("scenes/{name}.json"));
            let scene = if let Some(text) = shipped::text(name) {
                record.versions.insert(path.display().to_string(), sha256_of(text));
                Scene::parse(text, &path)?
            } else if let Some(share) = name.parse().ok().filter(|s| (0.0..=1.0).contains(s)) {
                shipped::with_cover(share)
            } else {
                let known: Vec<_> = COVERAGES.iter().map(|(known, _)| *known).collect();
                return Err(Error::Coverage { wanted: name.clone(), known: known.join(", ") });
            };
            Run::new(options, out, "", cache, &mut record).scene(scene, &path)?;
        }
        Source::Scene(path) => {
            let scene = Scene::read(path)?;
            record.inputs.insert(path.display().to_string(), output::sha256_hex(path)?);
            Run::new(options, out, "", cache, &mut record).scene(scene, path)?;
        }
    }
    for file in earlier.iter().flat_map(|earlier| earlier.outputs.keys()) {
        // The record may be by other hands: only plain names below the folder are its files.
        let below = Path::new(file).components().all(|part| matches!(part, Component::Normal(_)));
        if below && !record.outputs.contains_key(file) {
            output::remove(&out.join(file))?;
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
    /// How many packings are dropped now.
    packings: usize,
}

/// A settled bed, as the tracer takes it.
struct Bed {
    scene: Scene,
    path: PathBuf,
    /// Loaded only if a stage needs it: a run that finds everything in the cache does not.
    tracer: Option<Tracer>,
}

impl<'a> Run<'a> {
    fn new(
        options: &'a Options,
        out: &'a Path,
        below: &'a str,
        cache: &'a Cache,
        record: &'a mut Record,
    ) -> Self {
        let packings = match options.packings {
            HowMany::Number(number) => number,
            HowMany::Planned(_) => PILOT,
        };
        Self { options, out, below, cache, record, packings }
    }

    fn scene(&mut self, mut scene: Scene, path: &Path) -> Result<(Vec<Table>, Vec<Band>), Error> {
        if let Some(seed) = self.options.seed {
            scene.seed = seed;
            if let SceneGeometry::Packing(packing) = &mut scene.geometry {
                packing.seed = seed;
            }
        }
        let library = self.library(&mut scene, path)?;
        // Whatever is wrong with the spectra is known before Blender is started.
        let wavelengths_um = self.options.grid.wavelengths_um();
        let materials = trace::materials(&scene, path)?;
        let spectra: Vec<_> = materials.iter().map(|m| &m.spectrum).collect();
        let kept = Course::new(&scene, &spectra).kept;
        trace::bands(&materials, kept, &wavelengths_um, path)?;
        trace::air(&scene, path, &wavelengths_um)?;
        let folder = path.parent().unwrap_or(Path::new(""));
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
        self.record.seeds.insert(self.key("rays"), scene.seed);
        let mut beds = match scene.geometry.clone() {
            SceneGeometry::Packing(packing) => {
                self.record.seeds.insert(self.key("packing"), packing.seed);
                match self.options.packings {
                    HowMany::Number(_) => self.drop(&scene, &packing, library.as_ref(), path)?,
                    HowMany::Planned(_) => Vec::new(),
                }
            }
            SceneGeometry::Placed(_) if self.options.packings != HowMany::Number(1) => {
                return Err(Error::OnePacking { scene: path.to_owned() });
            }
            SceneGeometry::Placed(_) if self.options.field.is_some() => {
                return Err(Error::FieldOfPlaced { scene: path.to_owned() });
            }
            SceneGeometry::Placed(_) => {
                for file in ingest::files(&scene, path)? {
                    let sum = output::sha256_hex(&file)?;
                    self.record.inputs.insert(file.display().to_string(), sum);
                }
                vec![Bed { scene: scene.clone(), path: path.to_owned(), tracer: None }]
            }
        };
        let (tables, plan) = match (self.options.packings, &scene.geometry) {
            (HowMany::Planned(_), SceneGeometry::Packing(packing)) => {
                let (planned, tables, plan) =
                    self.planned(&scene, packing, library.as_ref(), path, &wavelengths_um)?;
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
    fn library(&mut self, scene: &mut Scene, path: &Path) -> Result<Option<Library>, Error> {
        let SceneGeometry::Packing(packing) = &mut scene.geometry else {
            return match self.options.grains {
                Some(_) => Err(Error::GrainsOfPlaced { scene: path.to_owned() }),
                None => Ok(None),
            };
        };
        if let Some(folder) = &self.options.grains {
            library::stand_in(packing, folder)?;
        }
        let library = Library::of(packing, path.parent().unwrap_or(Path::new("")))?;
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

    /// Says in the record that the stages from there on were those of a pilot.
    fn call_pilot(&mut self, begun: usize) {
        for stage in &mut self.record.stages[begun..] {
            if !stage.name.starts_with("pilot ") {
                stage.name.insert_str(0, "pilot ");
            }
        }
    }

    /// As many packings as the tolerance takes, dropped until their fines touch if it takes that.
    fn planned(
        &mut self,
        scene: &Scene,
        packing: &Packing,
        library: Option<&Library>,
        path: &Path,
        wavelengths_um: &[f64],
    ) -> Result<(Vec<Bed>, Vec<Table>, Plan), Error> {
        let tolerance = self.options.tolerance;
        let begun = self.record.stages.len();
        let (mut scene, mut packing) = (scene.clone(), packing.clone());
        let made = |run: &mut Self, scene: &Scene, packing: &Packing| {
            let mut beds = run.drop(scene, packing, library, path)?;
            let tables = run.trace(&mut beds)?;
            Ok::<_, Error>((beds, tables))
        };
        let planned = |tables: &[Table], packing: &Packing| {
            let bands = signature::evaluate(tables, wavelengths_um)?;
            let budget = Budget::new(tables, &bands, Origin::of(packing))?;
            let plan = Plan::new(&bands, &budget, tolerance);
            eprintln!("plan: {}", words::plan(&plan, tolerance));
            Ok::<_, Error>(plan)
        };
        let (mut beds, mut tables) = made(self, &scene, &packing)?;
        let mut plan = planned(&tables, &packing)?;
        if plan.touching {
            self.call_pilot(begun);
            packing.drop.collision = Collision::HullThenFines;
            scene.geometry = SceneGeometry::Packing(packing.clone());
            (beds, tables) = made(self, &scene, &packing)?;
            plan = Plan { touching: true, ..planned(&tables, &packing)? };
        }
        if plan.packings > PILOT {
            self.call_pilot(begun);
            // Those of the pilot come from the cache.
            self.packings = plan.packings;
            (beds, tables) = made(self, &scene, &packing)?;
        }
        Ok((beds, tables, plan))
    }

    /// Blender's part: the beds as placed geometry, with the scene's own materials and view.
    fn drop(
        &mut self,
        scene: &Scene,
        packing: &Packing,
        library: Option<&Library>,
        path: &Path,
    ) -> Result<Vec<Bed>, Error> {
        let step = Step::new(&self.key("drop"));
        let blender = blender::find(self.options.blender.as_deref(), self.cache.blenders())?;
        if let Some(warning) = blender.warning() {
            step.say(&format!("warning: {warning}"));
        }
        for (name, version) in [
            ("blender", blender.version.to_string()),
            ("python", blender.python.clone()),
            ("numpy", blender.numpy.clone()),
            ("scripts", blender::scripts_sha256()),
        ] {
            self.record.versions.insert(name.into(), version);
        }
        let packings = 0..self.packings;
        let seeds: Vec<u64> = packings.map(|i| random::seed_of(packing.seed, i)).collect();
        // For other programs, of one bed: of several, that of the first seed alone has them.
        let mut extra = Vec::new();
        if self.packings == 1 {
            extra.extend(["scene.glb", "scene.blend", "frames.json"]);
        }
        if self.options.patch_obj {
            extra.push("patch.obj");
        }
        let order = Order {
            blender: &blender,
            scene,
            packing,
            library,
            seeds: &seeds,
            of_first: &extra,
            time_limit: Duration::from_secs(self.options.blender_timeout_s),
        };
        let log = |i: usize| self.place(&self.of_packing(i, "blender.log"));
        let made = order.beds(self.cache, &log, &step)?;
        self.begin_to_write()?;
        let mut beds = Vec::new();
        for (i, made) in made.iter().enumerate() {
            beds.push(self.bring_bed(i, made, scene, path)?);
        }
        let cached = made.iter().all(|made| made.cached);
        let seconds = step.done(if cached { "from the cache" } else { "Blender" });
        self.stage("drop", seconds, cached);
        Ok(beds)
    }

    /// Copies a settled bed to its place and gives its scene the spectra, the view and a seed for its rays.
    fn bring_bed(
        &mut self,
        packing: usize,
        made: &Made,
        scene: &Scene,
        path: &Path,
    ) -> Result<Bed, Error> {
        for file in made.files.iter().filter(|file| *file != "scene.json") {
            let name = self.of_packing(packing, file);
            output::copy(&made.folder.join(file), &self.place(&name))?;
            self.wrote(&name)?;
        }
        let placed = Scene::read(&made.folder.join("scene.json"))?;
        let seed = random::seed_of(scene.seed, packing);
        let mut placed = Scene { geometry: placed.geometry, seed, ..scene.clone() };
        if let (Some(particles), SceneGeometry::Placed(Placed { domain: Some(domain), .. })) =
            (self.options.field, &mut placed.geometry)
        {
            domain.sides = Sides::Field { particles, seed: packing as u64 };
        }
        self.bring_spectra(packing, &mut placed, path)?;
        let name = self.of_packing(packing, "scene.json");
        let place = self.place(&name);
        let mut text = serde_json::to_string_pretty(&placed).expect("plain data");
        text.push('\n');
        output::bytes(&place, text.as_bytes())?;
        self.wrote(&name)?;
        Ok(Bed { scene: placed, path: place, tracer: None })
    }

    /// Copies the files that a scene names for spectra, pure beds, sky and atmosphere beside the placed scene, so that it can stand alone.
    fn bring_spectra(
        &mut self,
        packing: usize,
        scene: &mut Scene,
        path: &Path,
    ) -> Result<(), Error> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        for (number, material) in scene.materials.iter_mut().enumerate() {
            if let Some(file) = material.spectrum.file_mut() {
                let named = |file: &Path| {
                    let name = file.file_name().unwrap_or_default().to_string_lossy();
                    format!("spectrum_{number}_{name}")
                };
                for from in spectrum::format::files(&folder.join(&file))? {
                    self.bring(packing, &from, &named(&from))?;
                }
                *file = named(file).into();
            }
            for (bed, table) in material.spectrum.tables_mut().iter_mut().enumerate() {
                // Those of several packings all bear one name.
                let name = format!("pure_bed_{number}_{bed}.json");
                self.bring(packing, &folder.join(&table), &name)?;
                *table = name.into();
            }
        }
        for (kind, file) in scene.air_files_mut() {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let name = format!("{kind}_{name}");
            let place = self.of_packing(packing, &name);
            output::copy(&folder.join(&file), &self.place(&place))?;
            self.wrote(&place)?;
            *file = name.into();
        }
        Ok(())
    }

    /// Copies a file beside the placed scene of a packing.
    fn bring(&mut self, packing: usize, from: &Path, name: &str) -> Result<(), Error> {
        let place = self.of_packing(packing, name);
        output::copy(from, &self.place(&place))?;
        self.wrote(&place)
    }

    /// Every packing into a table of its own. Together their rays are to make no more than half of the
    /// tolerance where there are several packings, whose spread needs the rest.
    fn trace(&mut self, beds: &mut [Bed]) -> Result<Vec<Table>, Error> {
        let step = Step::new(&self.key("trace"));
        let tolerance = match beds.len() {
            1 => self.options.tolerance,
            n => (self.options.tolerance * (n as f64).sqrt() / 2.0).min(0.5),
        };
        let Options { max_paths, max_seconds, .. } = *self.options;
        let target = Target { tolerance, max_paths, max_seconds, exactly: None };
        let (cache, grid, number) = (self.cache, &self.options.grid, beds.len());
        // Side by side, since much of reading a bed is the work of one thread.
        let made: Vec<Made> = beds
            .par_iter_mut()
            .enumerate()
            .map(|(i, bed)| {
                let sum = trace::scene_sha256(&bed.scene, &bed.path)?;
                let spectra = trace::materials(&bed.scene, &bed.path)?;
                let air = trace::air(&bed.scene, &bed.path, &grid.wavelengths_um())?;
                let made_from = (program(), &sum, bed.scene.seed, &spectra, &air, grid, &target);
                let what = if number == 1 { "paths".into() } else { format!("packing {}", i + 1) };
                let made = cache.stage("trace", &made_from, |folder| {
                    let tracer = ready(&mut bed.tracer, &bed.scene, &bed.path)?;
                    let on = |done, of| step.at(done, of, &what);
                    let (scene, path) = (&bed.scene, &bed.path);
                    let table = trace::trace(tracer, scene, path, grid, target, None, &on)?;
                    Ok(table.write(&folder.join("table.json"))?)
                })?;
                if i > 0 {
                    // Only the first is looked at again, for its picture.
                    bed.tracer = None;
                }
                Ok(made)
            })
            .collect::<Result<_, Error>>()?;
        self.begin_to_write()?;
        let mut tables = Vec::new();
        for (i, made) in made.iter().enumerate() {
            let name = self.of_packing(i, "table.json");
            output::copy(&made.folder.join("table.json"), &self.place(&name))?;
            self.wrote(&name)?;
            tables.push(Table::read(&self.place(&name))?);
        }
        let cached = made.iter().all(|made| made.cached);
        let paths: u64 = tables.iter().map(|table| table.paths).sum();
        let note = if cached { "from the cache".into() } else { format!("{paths} paths") };
        let seconds = step.done(&note);
        self.stage("trace", seconds, cached);
        Ok(tables)
    }

    fn signature(
        &mut self,
        scene: &Scene,
        tables: &[Table],
        wavelengths_um: &[f64],
    ) -> Result<Vec<Band>, Error> {
        let step = Step::new(&self.key("signature"));
        let bands = signature::evaluate(tables, wavelengths_um)?;
        let csv = self.place("signature.csv");
        signature::write_csv(&bands, tables[0].temperature(), Assumed::EXACT, &csv)?;
        self.wrote("signature.csv")?;
        let title = scene.description.as_ref().unwrap_or(&scene.name);
        let chart = report::chart(title, &[(tables, &bands)], &self.record.versions);
        report::draw(&chart, &self.place("signature"))?;
        self.wrote("signature.svg")?;
        self.wrote("signature.png")?;
        let seconds = step.done(&format!("{} bands", bands.len()));
        self.stage("signature", seconds, false);
        Ok(bands)
    }

    /// The sensor's view of the first packing.
    fn picture(&mut self, bed: &mut Bed, table: &Table) -> Result<(), Error> {
        let step = Step::new(&self.key("picture"));
        let made_from = (program(), &table.scene_sha256);
        let made = self.cache.stage("picture", &made_from, |folder| {
            let tracer = ready(&mut bed.tracer, &bed.scene, &bed.path)?;
            picture::sensor_view(tracer.bed(), &folder.join("patch.png"))
        })?;
        output::copy(&made.folder.join("patch.png"), &self.place("patch.png"))?;
        self.wrote("patch.png")?;
        let seconds = step.done(if made.cached { "from the cache" } else { "" });
        self.stage("picture", seconds, made.cached);
        Ok(())
    }

    /// All coverages in one chart: the paper's Fig. 6.
    fn draw_all(&mut self, curves: &[(Vec<Table>, Vec<Band>)]) -> Result<(), Error> {
        let curves: Vec<_> =
            curves.iter().map(|(tables, bands)| (&tables[..], &bands[..])).collect();
        let title = "Emissivity of quartz soil by its cover with fines";
        let chart = report::chart(title, &curves, &self.record.versions);
        report::draw(&chart, &self.out.join("signatures"))?;
        self.wrote("signatures.svg")?;
        self.wrote("signatures.png")
    }
}

/// What tells this build of the program from another: what it traced before is not taken for its own.
fn program() -> Option<(u64, Duration)> {
    let file = std::env::current_exe().and_then(std::fs::metadata).ok()?;
    let age = file.modified().ok()?.duration_since(std::time::UNIX_EPOCH).ok()?;
    Some((file.len(), age))
}

fn ready<'a>(
    tracer: &'a mut Option<Tracer>,
    scene: &Scene,
    path: &Path,
) -> Result<&'a Tracer, Error> {
    Ok(match tracer {
        Some(tracer) => tracer,
        None => tracer.insert(trace::tracer(scene, path)?),
    })
}
