//! Bare grains of every shape: their descriptors, asked and reached, and their picture.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::blender::{self, BlenderError, Event, Job};
use crate::draw::plot::{self, Row, Solid};
use crate::geometry::ingest::obj::ObjFile;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::lock::Lock;
use crate::support::monitor::{Monitor, Step};
use crate::support::output;

/// The grains to model.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Seed of the shapes. The seed of a shipped scene gives the scene's bodies.
    pub seed: u64,
    /// Bodies of each shape.
    pub variants: u32,
    /// The Blender to use.
    pub blender: Option<PathBuf>,
    /// Time limit of Blender, seconds.
    pub blender_timeout_s: u64,
}

/// `grains.json`: every shape and its bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// Version of the format: 1.
    pub soilsig_grains: u32,
    /// Seed of the shapes.
    pub seed: u64,
    /// Blender, its Python and numpy.
    pub versions: BTreeMap<String, String>,
    /// Greatest distance of a body's descriptors from those asked for.
    pub tolerance: Descriptors,
    /// Standard deviation of the Gaussian that smooths the curvature along a silhouette, as a share
    /// of its perimeter.
    pub roundness_resolution: f64,
    /// The shapes.
    pub shapes: Vec<Shape>,
}

/// A shape of `blender_scripts/soilsig_blender/model/shapes.py`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// Its name in scene files.
    pub name: String,
    /// Diameter of the sphere of the bodies' volume, um.
    pub diameter_um: f64,
    /// The descriptors asked for.
    pub asked: Descriptors,
    /// The variants.
    pub bodies: Vec<Body>,
}

/// One modelled body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Its name in `grains.obj`.
    pub name: String,
    /// Its descriptors.
    pub reached: Descriptors,
    /// Powers' class of its roundness.
    pub roundness_class: String,
    /// Feret diameters L, I and S, um.
    pub feret_um: [f64; 3],
    /// Volume, um3.
    pub volume_um3: f64,
    /// Planar facets.
    pub facets: u32,
    /// Triangles of those facets.
    pub triangles: u32,
    /// The checks that it passed: closed, outward, convex.
    pub checks: Vec<String>,
}

/// Descriptors of a shape by the definitions of the sand-grain literature (docs/physics/beds.md).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Descriptors {
    /// I/L.
    pub elongation: f64,
    /// S/I.
    pub flatness: f64,
    /// Wadell's: surface of the sphere of equal volume over that of the body.
    pub sphericity: f64,
    /// Wadell's: mean radius of a silhouette's corners over that of its largest inscribed circle.
    pub roundness: f64,
}

impl Descriptors {
    /// The descriptors with their names.
    pub fn named(&self) -> [(&'static str, f64); 4] {
        [
            ("elongation I/L", self.elongation),
            ("flatness S/I", self.flatness),
            ("sphericity", self.sphericity),
            ("roundness", self.roundness),
        ]
    }
}

impl Shape {
    /// Mean, least and greatest of each descriptor over the bodies, as in [`Descriptors::named`].
    pub fn reached(&self) -> [[f64; 3]; 4] {
        std::array::from_fn(|i| {
            let values = self.bodies.iter().map(|body| body.reached.named()[i].1);
            let mean = values.clone().sum::<f64>() / self.bodies.len() as f64;
            [mean, values.clone().fold(f64::MAX, f64::min), values.fold(f64::MIN, f64::max)]
        })
    }

    /// Powers' classes of the bodies without repetition.
    fn classes(&self) -> String {
        let mut classes: Vec<&str> = self.bodies.iter().map(|b| &*b.roundness_class).collect();
        classes.sort_unstable();
        classes.dedup();
        classes.join(", ")
    }
}

impl Report {
    /// The descriptors asked and reached as a table.
    pub fn words(&self) -> String {
        let mut text = format!(
            "{:<11} {:<15} {:>6} {:>6} {:>7} {:>7} {:>7}\n",
            "shape", "descriptor", "asked", "+-", "mean", "least", "most"
        );
        for shape in &self.shapes {
            let asked = shape.asked.named().into_iter().zip(self.tolerance.named());
            let rows = asked.zip(shape.reached()).enumerate();
            for (number, (((descriptor, asked), (_, within)), [mean, least, most])) in rows {
                let name = if number == 0 { shape.name.as_str() } else { "" };
                let is_roundness = descriptor == "roundness";
                let class =
                    if is_roundness { "  ".to_owned() + &shape.classes() } else { String::new() };
                let _ = writeln!(
                    text,
                    "{name:<11} {descriptor:<15} {asked:>6.2} {within:>6.2} {mean:>7.3} \
                     {least:>7.3} {most:>7.3}{class}"
                );
            }
            let range = |of: fn(&Body) -> u32| {
                let counts = || shape.bodies.iter().map(of);
                let [least, most] = [counts().min(), counts().max()].map(Option::unwrap_or_default);
                if least < most { format!("{least}-{most}") } else { least.to_string() }
            };
            let checks = shape.bodies.first().map_or(String::new(), |body| body.checks.join(", "));
            let _ = writeln!(
                text,
                "{:<11} {} bodies, all {checks}; {} facets, {} triangles each",
                "",
                shape.bodies.len(),
                range(|b| b.facets),
                range(|b| b.triangles)
            );
        }
        text
    }
}

/// Models the grains in Blender, measures and draws them. Writes `grains.json`, `.obj`, `.svg` and
/// `.png` into `out`.
///
/// # Errors
/// Blender is missing or fails; the folder cannot be written.
pub fn make(
    options: &Options,
    out: &Path,
    cache: &Cache,
    monitor: &dyn Monitor,
) -> Result<Report, Error> {
    let _lock = Lock::of(out)?;
    let step = Step::new(monitor, "grains");
    let time_limit = Duration::from_secs(options.blender_timeout_s);
    let wanted = options.blender.as_deref();
    let blender = blender::find(wanted, cache.blenders(), time_limit, monitor)?;
    if let Some(warning) = blender.warning() {
        monitor.say(&format!("warning: {warning}"));
    }
    let scripts = blender::scripts_sha256();
    let Options { seed, variants, .. } = options;
    let made_from = (seed, variants, &blender.version, &blender.python, &blender.numpy, scripts);
    let log = out.join("blender.unfinished.log");
    output::remove(&log)?;
    let made = cache.stage("grains", &made_from, |folder| {
        let (seed, variants) = (seed.to_string(), variants.to_string());
        let args = ["--seed", &seed, "--variants", &variants].map(Into::into).to_vec();
        let job = Job { script: "grains.py", args, out: folder, log: &log, time_limit, monitor };
        blender.run(&job, &mut |event| match event {
            Event::Progress { stage, done, total } => monitor.at(*done, *total, stage),
            Event::Warning { message } => monitor.say(&format!("warning: {message}")),
            _ => {}
        })?;
        output::copy(&log, &folder.join("blender.log"))?;
        Ok(output::remove(&log)?)
    })?;
    for file in &made.files {
        output::copy(&made.folder.join(file), &output::within(out, file)?)?;
    }
    let unusable = |problem| BlenderError::Script {
        message: format!("what grains.py wrote cannot be used: {problem}"),
        remedy: None,
        log: log.clone(),
    };
    let report = read(&out.join("grains.json")).map_err(unusable)?;
    let solids = solids(&out.join("grains.obj")).map_err(unusable)?;
    let svg = picture(&report, &solids).map_err(unusable)?;
    output::bytes(&output::within(out, "grains.svg")?, svg.as_bytes())?;
    output::bytes(&output::within(out, "grains.png")?, &plot::png(&svg, plot::PIXELS_PER_UNIT)?)?;
    step.done(if made.cached { "from the cache" } else { "Blender" });
    Ok(report)
}

fn read(path: &Path) -> Result<Report, String> {
    let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
    let report: Report = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    match report.shapes.iter().find(|shape| shape.bodies.is_empty()) {
        Some(shape) => Err(format!("{} has no body", shape.name)),
        None => Ok(report),
    }
}

/// The bodies of `grains.obj` by name.
fn solids(path: &Path) -> Result<BTreeMap<String, Solid>, String> {
    let file = ObjFile::read(path).map_err(|error| error.to_string())?;
    let solid = |name: &str| {
        let (vertices_um, facets) = file.polygons(Some(name));
        (name.to_owned(), Solid { vertices_um, facets })
    };
    Ok(file.objects().into_iter().map(solid).collect())
}

/// The shapes in three views and with their variants, as SVG.
fn picture(report: &Report, solids: &BTreeMap<String, Solid>) -> Result<String, String> {
    let rows = report.shapes.iter().map(|shape| {
        let bodies = shape.bodies.iter().map(|body| {
            let solid = solids.get(&body.name).cloned();
            solid.ok_or_else(|| format!("grains.obj has no {}", body.name))
        });
        let Descriptors { elongation, flatness, sphericity, roundness } = shape.bodies[0].reached;
        let class = &shape.bodies[0].roundness_class;
        Ok(Row {
            name: shape.name.clone(),
            lines: vec![
                format!("I/L {elongation:.2}, S/I {flatness:.2}"),
                format!("sphericity {sphericity:.2}"),
                format!("roundness {roundness:.2}: {class}"),
            ],
            solids: bodies.collect::<Result<_, String>>()?,
        })
    });
    let title = format!("Quartz shapes, seed {}", report.seed);
    Ok(plot::bodies_svg(&title, &rows.collect::<Result<Vec<_>, String>>()?))
}
