//! The rigid-body drop in Blender with unsuitable settings of its solver.

use std::path::PathBuf;
use std::sync::Mutex;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Measured, Point, Setting};
use crate::blender;
use crate::pipeline::{self, HowMany, Options, Source};
use crate::scene::Grid;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;
use crate::support::scratch::Scratch;

/// Half of the overlap that is allowed, in mean diameters.
const CLAIMED: f64 = 0.015;

/// Why the rows of this module are left out.
pub(super) fn left_out(setting: &Setting) -> Option<String> {
    if setting.without_blender {
        return Some("Blender was not to be used".into());
    }
    let (cache, limit) = (setting.cache.blenders(), blender::PATIENCE);
    let found = blender::find(setting.blender, cache, limit, setting.monitor);
    found.err().map(|error| format!("no Blender: {error}"))
}

/// Few steps within a frame, at more than twice the shipped gravity.
pub(super) fn bullet_substeps(setting: &Setting) -> Result<Vec<Point>, Error> {
    let xs = [1.0, 2.0, 3.0, 4.0, 6.0, 12.0];
    drops(setting, &xs, 4000.0, |x| json!({"substeps": x as u32, "gravity": 250, "margin": 0}))
}

/// Very small and very large lengths in the units of the solver.
pub(super) fn bullet_scale(setting: &Setting) -> Result<Vec<Point>, Error> {
    let xs = [0.0065, 0.065, 0.65, 6.5, 65.0, 650.0, 6500.0];
    drops(setting, &xs, 1600.0, |x| json!({"scale": x}))
}

/// Very small and very large distances that the solver keeps between hulls.
pub(super) fn bullet_margin(setting: &Setting) -> Result<Vec<Point>, Error> {
    drops(setting, &[0.0, 0.004, 0.04, 0.4, 1.0, 4.0, 40.0], 1600.0, |x| json!({"margin": x}))
}

/// Falls that are too fast for the steps.
pub(super) fn bullet_gravity(setting: &Setting) -> Result<Vec<Point>, Error> {
    let xs = [1.0, 10.0, 98.1, 300.0, 1000.0, 3000.0, 9810.0];
    drops(setting, &xs, 1600.0, |x| json!({"gravity": x, "substeps": 1}))
}

/// Drops a few grains with the solver's settings of each point.
fn drops(
    setting: &Setting,
    xs: &[f64],
    tray_um: f64,
    solver: impl Fn(f64) -> Value + Sync,
) -> Result<Vec<Point>, Error> {
    let xs: Vec<f64> = setting.values(xs).collect();
    xs.par_iter().map(|&x| Ok(drop(setting, tray_um, solver(x))?.at(x, ""))).collect()
}

/// Drops four grains with some fines, and judges the first attempt.
fn drop(setting: &Setting, tray_um: f64, solver: Value) -> Result<Measured, Error> {
    let folder = Scratch::temporary()?;
    let path = folder.path().join("scene.json");
    let mut scene = small_scene(4, 20);
    let packing = &mut scene["geometry"]["packing"];
    packing["tray_um"] = json!([tray_um, tray_um]);
    packing["crop_um"] = json!(0);
    packing["drop"] = solver;
    output::scratch(&path, scene.to_string())?;
    let options = Options {
        grains: None,
        source: Source::Scene(path),
        set: Vec::new(),
        facets: None,
        seed: None,
        packings: HowMany::Number(1),
        field: None,
        tolerance: Some(0.05),
        max_paths: 1 << 14,
        max_seconds: None,
        grid: Grid::new(9.0, 11.0, 1.0).expect("a grid"),
        patch_obj: false,
        blender: setting.blender.map(PathBuf::from),
        blender_timeout_s: 120,
    };
    let (cache, out) = (folder.path().join("cache"), folder.path().join("out"));
    let cache = setting.cache.other_results(cache);
    let monitor = Listening { of: setting.monitor, said: Mutex::default() };
    let refused = |said: String, status| {
        Ok(Measured { error: None, claimed: CLAIMED, said: vec![said], status })
    };
    match pipeline::run(&options, Vec::new(), &out, &cache, &monitor) {
        Err(error) if error.is_interruption() => return Err(error),
        Err(error) => return refused(error.to_string(), error.status() as u8),
        Ok(_) => {}
    }
    let report = std::fs::read(out.join("drop.json")).unwrap_or_default();
    let report: Value = serde_json::from_slice(&report).unwrap_or_default();
    let mut said = monitor.said.into_inner().expect("no panic holds it");
    // If there is a reason, the first attempt failed, and the bed is that of the second.
    if let Some(reason) = report["attempts"][0]["reason"].as_str() {
        said.insert(0, reason.to_owned());
        return Ok(Measured { error: None, claimed: CLAIMED, said, status: 0 });
    }
    let depth = |key: &str| report["checks"]["overlaps"][key].as_f64();
    let depths = ["max_depth_um", "floor_depth_um", "wall_depth_um", "floor_gap_um"].map(depth);
    let deepest = depths.into_iter().flatten().fold(0.0, f64::max);
    let error = deepest / depth("depth_limit_um").unwrap_or(f64::NAN) * 0.02;
    Ok(Measured { error: Some(error), claimed: CLAIMED, said, status: 0 })
}

/// Hears the warnings of a run.
struct Listening<'a> {
    of: &'a dyn Monitor,
    said: Mutex<Vec<String>>,
}

impl Monitor for Listening<'_> {
    fn say(&self, text: &str) {
        let text = text.trim_start_matches("warning: ").to_owned();
        self.said.lock().expect("no panic holds it").push(text);
    }

    fn is_cancelled(&self) -> bool {
        self.of.is_cancelled()
    }
}

/// The shipped small recipe with one class of grains.
pub(super) fn small_scene(grains: u64, fines: u32) -> Value {
    let text = include_str!("../../../scenes/small.json");
    let mut scene: Value = serde_json::from_str(text).expect("JSON");
    let classes = &mut scene["geometry"]["packing"]["grains"];
    let mut class = classes[0].clone();
    class["count"] = json!(grains);
    class["fines"] = json!(fines);
    *classes = json!([class]);
    scene
}
