//! From a scene to its signature, in stages: drop, trace, signature, picture.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::blender::{self, Blender, Event, Job, SCRIPTS};
use crate::cache::Cache;
use crate::error::Error;
use crate::ingest;
use crate::output;
use crate::picture;
use crate::progress::Step;
use crate::record::{self, Output, Record, Stage};
use crate::report;
use crate::scene::{Packing, Scene, SceneGeometry, SpectrumSource};
use crate::signature::{self, Band, Grid};
use crate::stop::Target;
use crate::table::Table;
use crate::trace;
use crate::tracer::Tracer;

/// The shipped scenes, most covered first: the order of the paper's Fig. 6.
pub const COVERAGES: [(&str, &str); 4] = [
    ("full", include_str!("../scenes/full.json")),
    ("less", include_str!("../scenes/less.json")),
    ("sparse", include_str!("../scenes/sparse.json")),
    ("bare", include_str!("../scenes/bare.json")),
];

/// Files of a drop that hold times of day or durations and so differ from run to run.
const NOT_REPRODUCIBLE: [&str; 2] = ["blender.log", "drop.json"];

/// What is to be run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A shipped scene by its coverage: `full`, `less`, `sparse`, `bare`; or `all` of them.
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
    /// In place of the scene's seeds, of packing and rays both.
    pub seed: Option<u64>,
    /// Half-width of the 95 % interval that every band is to reach.
    pub tolerance: f64,
    /// Most paths.
    pub max_paths: u64,
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
                let mut run = Run { options, out, below: name, cache, record: &mut record };
                curves.push(run.scene(scene, Path::new(name))?);
            }
            let mut run = Run { options, out, below: "", cache, record: &mut record };
            run.draw_all(&curves)?;
        }
        Source::Coverage(name) => {
            let (_, text) = COVERAGES.iter().find(|(known, _)| known == name).ok_or_else(|| {
                let known: Vec<_> = COVERAGES.iter().map(|(known, _)| *known).collect();
                Error::Coverage { wanted: name.clone(), known: known.join(", ") }
            })?;
            let path = PathBuf::from(format!("scenes/{name}.json"));
            let scene = Scene::parse(text, &path)?;
            record.versions.insert(path.display().to_string(), sha256_of(text));
            Run { options, out, below: "", cache, record: &mut record }.scene(scene, &path)?;
        }
        Source::Scene(path) => {
            let scene = Scene::read(path)?;
            record.inputs.insert(path.display().to_string(), output::sha256_hex(path)?);
            Run { options, out, below: "", cache, record: &mut record }.scene(scene, path)?;
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
}

impl Run<'_> {
    fn scene(&mut self, mut scene: Scene, path: &Path) -> Result<(Table, Vec<Band>), Error> {
        if let Some(seed) = self.options.seed {
            scene.seed = seed;
            if let SceneGeometry::Packing(packing) = &mut scene.geometry {
                packing.seed = seed;
            }
        }
        // Whatever is wrong with the spectra is known before Blender is started.
        let wavelengths_um = self.options.grid.wavelengths_um();
        let materials = trace::materials(&scene, path)?;
        trace::bands(&materials, &wavelengths_um, path)?;
        for material in &scene.materials {
            if let SpectrumSource::File(file) = &material.spectrum {
                let file = path.parent().unwrap_or(Path::new("")).join(file);
                let sum = output::sha256_hex(&file)?;
                self.record.inputs.insert(file.display().to_string(), sum);
            }
        }
        self.record.seeds.insert(self.key("rays"), scene.seed);
        let (scene, path) = match scene.geometry.clone() {
            SceneGeometry::Packing(packing) => {
                self.record.seeds.insert(self.key("packing"), packing.seed);
                self.drop(&scene, &packing, path)?
            }
            SceneGeometry::Placed(_) => {
                for file in ingest::files(&scene, path)? {
                    let sum = output::sha256_hex(&file)?;
                    self.record.inputs.insert(file.display().to_string(), sum);
                }
                (scene, path.to_owned())
            }
        };
        // Loaded only if a stage needs it: a run that finds everything in the cache does not.
        let mut tracer = None;
        let table = self.trace(&scene, &path, &wavelengths_um, &mut tracer)?;
        let bands = self.signature(&scene, &table, &wavelengths_um)?;
        self.picture(&scene, &path, &table, &mut tracer)?;
        self.record.reached.insert(scene.name.clone(), report::reached(&table, &bands));
        Ok((table, bands))
    }

    /// A name in the record, told apart where there are several scenes.
    fn key(&self, name: &str) -> String {
        if self.below.is_empty() { name.to_owned() } else { format!("{}/{name}", self.below) }
    }

    /// Where a file of this scene goes.
    fn place(&self, file: &str) -> PathBuf {
        self.out.join(self.below).join(file)
    }

    /// From here on the folder holds parts of this run: an earlier record no longer speaks for it.
    fn begin_to_write(&self) -> Result<(), Error> {
        Ok(output::remove(&self.out.join("run.json"))?)
    }

    /// Notes a file that was written.
    fn wrote(&mut self, file: &str) -> Result<(), Error> {
        let sha256 = output::sha256_hex(&self.place(file))?;
        let reproducible = !NOT_REPRODUCIBLE.contains(&file);
        self.record.outputs.insert(self.key(file), Output { sha256, reproducible });
        Ok(())
    }

    fn stage(&mut self, name: &str, seconds: f64, cached: bool) {
        self.record.stages.push(Stage { name: self.key(name), seconds, cached });
    }

    /// Blender's part: the bed as placed geometry, with the scene's own materials and view.
    fn drop(
        &mut self,
        scene: &Scene,
        packing: &Packing,
        path: &Path,
    ) -> Result<(Scene, PathBuf), Error> {
        let step = Step::new(&self.key("drop"));
        let blender = blender::find(self.options.blender.as_deref(), self.cache.root())?;
        if let Some(warning) = blender.warning() {
            step.say(&format!("warning: {warning}"));
        }
        for (name, version) in [
            ("blender", blender.version.to_string()),
            ("python", blender.python.clone()),
            ("numpy", blender.numpy.clone()),
        ] {
            self.record.versions.insert(name.into(), version);
        }
        let scripts = Sha256::digest(serde_json::to_vec(SCRIPTS).expect("plain data"));
        self.record.versions.insert("scripts".into(), output::hex(&scripts));
        let materials: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
        let made_from = (
            packing,
            materials,
            &blender.version,
            &blender.python,
            &blender.numpy,
            output::hex(&scripts),
            self.options.patch_obj,
        );
        let log = self.place("blender.log");
        let made = self.cache.stage("drop", &made_from, |folder| {
            drop_in_blender(&blender, scene, self.options, folder, &log, &step)
        })?;
        self.begin_to_write()?;
        for file in made.files.iter().filter(|file| *file != "scene.json") {
            output::copy(&made.folder.join(file), &self.place(file))?;
            self.wrote(file)?;
        }
        let placed = Scene::read(&made.folder.join("scene.json"))?;
        let mut placed = Scene { geometry: placed.geometry, ..scene.clone() };
        self.bring_spectra(&mut placed, path)?;
        let place = self.place("scene.json");
        let mut text = serde_json::to_string_pretty(&placed).expect("plain data");
        text.push('\n');
        output::bytes(&place, text.as_bytes())?;
        self.wrote("scene.json")?;
        let seconds = step.done(if made.cached { "from the cache" } else { "Blender" });
        self.stage("drop", seconds, made.cached);
        Ok((placed, place))
    }

    /// Copies the spectra that a scene names beside the placed scene, so that it can stand alone.
    fn bring_spectra(&mut self, scene: &mut Scene, path: &Path) -> Result<(), Error> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        for (number, material) in scene.materials.iter_mut().enumerate() {
            if let SpectrumSource::File(file) = &mut material.spectrum {
                let from = folder.join(&file);
                let file_name = file.file_name().unwrap_or_default().to_string_lossy();
                let name = format!("spectrum_{number}_{file_name}");
                output::copy(&from, &self.place(&name))?;
                self.wrote(&name)?;
                *file = name.into();
            }
        }
        Ok(())
    }

    fn trace(
        &mut self,
        scene: &Scene,
        path: &Path,
        wavelengths_um: &[f64],
        tracer: &mut Option<Tracer>,
    ) -> Result<Table, Error> {
        let step = Step::new(&self.key("trace"));
        let sum = trace::scene_sha256(scene, path)?;
        let spectra = trace::materials(scene, path)?;
        let target =
            Target { tolerance: self.options.tolerance, max_paths: self.options.max_paths };
        let made_from = (program(), &sum, scene.seed, &spectra, &self.options.grid, &target);
        let made = self.cache.stage("trace", &made_from, |folder| {
            let tracer = ready(tracer, scene, path)?;
            let table = trace::trace(tracer, scene, path, wavelengths_um, target, &|done, of| {
                step.at(done, of, "paths");
            })?;
            Ok(table.write(&folder.join("table.json"))?)
        })?;
        self.begin_to_write()?;
        output::copy(&made.folder.join("table.json"), &self.place("table.json"))?;
        self.wrote("table.json")?;
        let table = Table::read(&self.place("table.json"))?;
        let note =
            if made.cached { "from the cache".into() } else { format!("{} paths", table.paths) };
        let seconds = step.done(&note);
        self.stage("trace", seconds, made.cached);
        Ok(table)
    }

    fn signature(
        &mut self,
        scene: &Scene,
        table: &Table,
        wavelengths_um: &[f64],
    ) -> Result<Vec<Band>, Error> {
        let step = Step::new(&self.key("signature"));
        let bands = signature::evaluate(table, wavelengths_um)?;
        signature::write_csv(&bands, &self.place("signature.csv"))?;
        self.wrote("signature.csv")?;
        let title = scene.description.as_ref().unwrap_or(&scene.name);
        let chart = report::chart(title, &[(table, &bands)], &self.record.versions);
        report::draw(&chart, &self.place("signature"))?;
        self.wrote("signature.svg")?;
        self.wrote("signature.png")?;
        let seconds = step.done(&format!("{} bands", bands.len()));
        self.stage("signature", seconds, false);
        Ok(bands)
    }

    fn picture(
        &mut self,
        scene: &Scene,
        path: &Path,
        table: &Table,
        tracer: &mut Option<Tracer>,
    ) -> Result<(), Error> {
        let step = Step::new(&self.key("picture"));
        let made_from = (program(), &table.scene_sha256);
        let made = self.cache.stage("picture", &made_from, |folder| {
            picture::write(ready(tracer, scene, path)?, &folder.join("patch.png"))
        })?;
        output::copy(&made.folder.join("patch.png"), &self.place("patch.png"))?;
        self.wrote("patch.png")?;
        let seconds = step.done(if made.cached { "from the cache" } else { "" });
        self.stage("picture", seconds, made.cached);
        Ok(())
    }

    /// All coverages in one chart: the paper's Fig. 6.
    fn draw_all(&mut self, curves: &[(Table, Vec<Band>)]) -> Result<(), Error> {
        let curves: Vec<_> = curves.iter().map(|(table, bands)| (table, &bands[..])).collect();
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

/// Runs `drop.py`; its files, and Blender's log, are in `folder` afterwards. While it runs, and if it
/// fails, the log is at `log`.
fn drop_in_blender(
    blender: &Blender,
    scene: &Scene,
    options: &Options,
    folder: &Path,
    log: &Path,
    step: &Step,
) -> Result<(), Error> {
    let recipe = tempfile::tempdir()
        .map_err(|source| output::OutputError { path: std::env::temp_dir(), source })?;
    let input = recipe.path().join("scene.json");
    output::bytes(&input, &serde_json::to_vec(scene).expect("plain data"))?;
    let mut args: Vec<OsString> = vec!["--scene".into(), input.into()];
    if options.patch_obj {
        args.push("--patch-obj".into());
    }
    let time_limit = Duration::from_secs(options.blender_timeout_s);
    let job = Job { script: "drop.py", args, out: folder, log, time_limit };
    blender.run(&job, &mut |event| match event {
        Event::Progress { stage, done, total } => step.at(*done, *total, stage),
        Event::Warning { message } => step.say(&format!("warning: {message}")),
        _ => {}
    })?;
    Ok(output::copy(log, &folder.join("blender.log"))?)
}
