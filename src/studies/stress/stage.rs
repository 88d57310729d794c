//! Synthetic scenes, and the tool's results and words about them.

use serde_json::{Value, json};

use super::{Point, Setting, Shape};
use crate::report::{Report, ToleranceOf, terminal};
use crate::scene::{Grid, Scene};
use crate::signature::Band;
use crate::support::error::{Error, Status};
use crate::support::monitor::Monitor;
use crate::support::output;
use crate::support::scratch::Scratch;
use crate::table::{Prepared, Table, Target};
use crate::tracer::trace::{self, Request};

/// A scene with its files, and how it is traced.
pub(super) struct Stage<'a> {
    pub scene: Value,
    pub files: Vec<(&'a str, Vec<u8>)>,
    pub grid: Grid,
    pub target: Target,
    pub monitor: &'a dyn Monitor,
}

/// The result of a scene.
pub(super) struct Outcome {
    pub bands: Vec<Band>,
    /// The lines that the tool prints.
    said: Vec<String>,
    status: u8,
}

/// A point of a sweep without its place.
pub(super) struct Measured {
    pub error: Option<f64>,
    pub claimed: f64,
    pub said: Vec<String>,
    pub status: u8,
}

/// A scene around one .obj file, which is the domain, at 300 K under a black sky. Its materials
/// have constant emissivities.
pub(super) fn scene(materials: &[(&str, f64)]) -> Value {
    let materials: Vec<Value> = materials
        .iter()
        .map(|(name, emissivity)| json!({"name": name, "spectrum": {"constant": emissivity}}))
        .collect();
    json!({
        "soilsig_scene": 1, "name": "stress", "seed": 7, "temperature_k": 300,
        "view": {"zenith_deg": 0}, "materials": materials,
        "geometry": {"placed": {"prototypes": [{"name": "mesh", "file": "mesh.obj"}]}}
    })
}

/// Sets the domain of a scene.
pub(super) fn set_domain(scene: &mut Value, min_um: [f64; 2], max_um: [f64; 2], sides: &str) {
    scene["geometry"]["placed"]["domain"] =
        json!({"min_um": min_um, "max_um": max_um, "sides": sides});
}

/// The band at one wavelength.
pub(super) fn band_at(um: f64) -> Grid {
    Grid::new(um, um, 1.0).expect("a grid")
}

impl<'a> Stage<'a> {
    /// A scene around one mesh, traced at 9 um.
    pub(super) fn new(setting: &Setting<'a>, scene: Value, mesh: &Shape) -> Self {
        let files = vec![("mesh.obj", mesh.obj().into_bytes())];
        let (grid, target) = (band_at(9.0), setting.target());
        Self { scene, files, grid, target, monitor: setting.monitor }
    }

    /// Does the work of `soilsig trace` and `soilsig signature` in a temporary folder.
    pub(super) fn run(&self) -> Result<Outcome, Error> {
        let folder = Scratch::temporary()?;
        let path = folder.path().join("scene.json");
        output::scratch(&path, self.scene.to_string())?;
        for (name, text) in &self.files {
            output::scratch(&folder.path().join(name), text)?;
        }
        let traced = || -> Result<Table, Error> {
            let scene = Scene::read(&path)?;
            let tracer = trace::tracer(&scene)?;
            let prepared = Prepared::new(scene, &self.grid.wavelengths_um())?;
            trace::trace(&tracer, &prepared, Request::new(&self.grid, self.target), self.monitor)
        };
        let tables = match traced() {
            Err(error) if error.is_interruption() => return Err(error),
            Err(error) => {
                let folder = format!("{}/", folder.path().display());
                return Ok(Outcome::refused(&error, &folder));
            }
            Ok(table) => [table],
        };
        let um = self.grid.wavelengths_um();
        let report =
            Report::new(&tables, &um, (self.target.tolerance, ToleranceOf::Interval), None)?;
        let Report { bands, reached, .. } = report;
        let said = terminal::blocks(&[("", &reached, None)], true);
        let said = said.lines().map(|line| line.trim().to_owned()).collect();
        let is_done = reached.tolerance_reached || self.target.exactly.is_some();
        let status = if is_done { 0 } else { Status::ToleranceNotReached as u8 };
        Ok(Outcome { bands, said, status })
    }
}

impl Outcome {
    /// An error instead of a result. The folder is cut out of the message.
    pub(super) fn refused(error: &Error, folder: &str) -> Self {
        let said = vec![format!("error: {error}").replace(folder, "")];
        Self { bands: Vec::new(), said, status: error.status() as u8 }
    }

    /// The emissivity of the first band.
    pub(super) fn emissivity(&self) -> f64 {
        self.bands[0].emissivity.mean
    }

    /// The error of the first band's emissivity.
    pub(super) fn against(self, truth: f64) -> Measured {
        let error = self.bands.first().map(|band| (band.emissivity.mean - truth).abs());
        self.with_error(error)
    }

    /// An error that was found otherwise.
    pub(super) fn with_error(self, error: Option<f64>) -> Measured {
        let claimed = self.bands.first().map_or(f64::NAN, |band| band.emissivity.half_width);
        Measured { error, claimed, said: self.said, status: self.status }
    }
}

impl Measured {
    /// The point at a place, with the first line that has some words in it, or the error message.
    pub(super) fn at(self, x: f64, words: &str) -> Point {
        let Self { error, claimed, said, status } = self;
        let is_about = |line: &&String| line.starts_with("error: ") || line.contains(words);
        let line = said.iter().find(is_about);
        let said = line.map(|line| line.trim_start_matches("warning: ").to_owned());
        Point { x, error, claimed, said, status }
    }
}
