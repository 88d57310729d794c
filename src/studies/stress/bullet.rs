//! The rigid-body drop in Blender, with settings that it is not at home with.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::{Point, Row, Setting, Swept};
use crate::blender;
use crate::pipeline::{self, HowMany, Options, Source};
use crate::scene::Grid;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::monitor::Silently;
use crate::support::output::{self, OutputError};

const ERROR: &str = "deepest overlap of grains with each other, floor and walls, or height of the lowest above the floor, \
                     in mean diameters; .03 is allowed";
const DOES: &str = "refuses the bed, says why and drops it once more with safer settings; refused again: status 16";

/// Four grains of one class with some fines, dropped with settings for each point; what came of the first try.
fn drops(
    setting: &Setting,
    xs: &[f64],
    tray_um: f64,
    settings: impl Fn(f64) -> Value + Sync,
) -> Result<(Vec<Point>, Option<String>), Error> {
    if setting.without_blender {
        return Ok((Vec::new(), Some("Blender was not to be used".into())));
    }
    if let Err(error) = blender::find(setting.blender, setting.cache.blenders(), setting.monitor) {
        return Ok((Vec::new(), Some(format!("no Blender: {error}"))));
    }
    let drop = |x: f64| -> Result<Point, Error> {
        let folder = tempfile::tempdir()
            .map_err(|source| OutputError { path: std::env::temp_dir(), source })?;
        let mut scene: Value =
            serde_json::from_str(include_str!("../../../scenes/small.json")).expect("JSON");
        let packing = &mut scene["geometry"]["packing"];
        let mut class = packing["grains"][0].clone();
        class["count"] = json!(4);
        class["fines"] = json!(20);
        packing["grains"] = json!([class]);
        packing["tray_um"] = json!([tray_um, tray_um]);
        packing["crop_um"] = json!(0);
        packing["drop"] = settings(x);
        let path = folder.path().join("scene.json");
        output::bytes(&path, scene.to_string().as_bytes())?;
        let options = Options {
            grains: None,
            source: Source::Scene(path),
            seed: None,
            packings: HowMany::Number(1),
            field: None,
            tolerance: 0.05,
            max_paths: 1 << 14,
            max_seconds: None,
            grid: Grid::new(9.0, 11.0, 1.0).expect("a grid"),
            patch_obj: false,
            blender: setting.blender.map(PathBuf::from),
            blender_timeout_s: 120,
        };
        let cache: Cache = setting.cache.other_results(folder.path().join("cache"));
        let out = folder.path().join("out");
        let (status, said) =
            match pipeline::run(&options, Vec::new(), &out, &cache, &Silently(setting.monitor)) {
                Err(error) if error.is_interruption() => return Err(error),
                Err(error) => (error.status() as u8, Some(error.to_string())),
                Ok(_) => (0, None),
            };
        if said.is_some() {
            return Ok(Point { x, error: None, claimed: 0.015, said, status });
        }
        let report = std::fs::read_to_string(out.join("drop.json")).unwrap_or_default();
        let report: Value = serde_json::from_str(&report).unwrap_or_default();
        // A first try that was no good stands with its reason; the bed is that of the second.
        if let Some(reason) = report["attempts"][0]["reason"].as_str() {
            return Ok(Point {
                x,
                error: None,
                claimed: 0.015,
                said: Some(reason.to_owned()),
                status,
            });
        }
        let depth = |key: &str| report["checks"]["overlaps"][key].as_f64();
        let deepest =
            ["max_depth_um", "floor_depth_um", "wall_depth_um", "floor_gap_um"].map(depth);
        let limit = depth("depth_limit_um").unwrap_or(f64::NAN);
        let error = deepest.into_iter().flatten().fold(0.0, f64::max) / limit * 0.02;
        Ok(Point { x, error: Some(error), claimed: 0.015, said: None, status })
    };
    let mut points = Vec::new();
    // A Blender keeps one core busy.
    for pair in xs.chunks(2) {
        let pair: Vec<Result<Point, Error>> = std::thread::scope(|scope| {
            let running: Vec<_> = pair.iter().map(|&x| scope.spawn(move || drop(x))).collect();
            running.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        for point in pair {
            points.push(point?);
        }
    }
    Ok((points, None))
}

/// Few steps within a frame, under more than twice the shipped gravity.
pub(super) fn substeps(setting: &Setting) -> Result<Row, Error> {
    let xs = setting.of(&[1.0, 2.0, 3.0, 4.0, 6.0, 12.0]);
    let (points, left_out) = drops(
        setting,
        &xs,
        4000.0,
        |x| json!({"substeps": x as u32, "gravity": 250, "margin": 0}),
    )?;
    Ok(Row {
        name: "bullet_substeps",
        title: "Bullet: steps within a frame (gravity 250, no margin)",
        swept: Swept { name: "substeps", log: true },
        error: ERROR,
        does: DOES,
        points,
        left_out,
    })
}

/// Lengths that the solver is not at home with.
pub(super) fn scale(setting: &Setting) -> Result<Row, Error> {
    let xs = setting.of(&[0.0065, 0.065, 0.65, 6.5, 65.0, 650.0, 6500.0]);
    let (points, left_out) = drops(setting, &xs, 1600.0, |x| json!({"scale": x}))?;
    Ok(Row {
        name: "bullet_scale",
        title: "Bullet: length of a grain in its units",
        swept: Swept { name: "scale (6.5 is shipped)", log: true },
        error: ERROR,
        does: DOES,
        points,
        left_out,
    })
}

/// Distances that the solver keeps between hulls.
pub(super) fn margin(setting: &Setting) -> Result<Row, Error> {
    let xs = setting.of(&[0.0, 0.004, 0.04, 0.4, 1.0, 4.0, 40.0]);
    let (points, left_out) = drops(setting, &xs, 1600.0, |x| json!({"margin": x}))?;
    Ok(Row {
        name: "bullet_margin",
        title: "Bullet: margin about the hulls",
        swept: Swept { name: "margin (.04 is shipped, a grain is 6.5)", log: true },
        error: ERROR,
        does: DOES,
        points,
        left_out,
    })
}

/// Falls that are too fast for the steps.
pub(super) fn gravity(setting: &Setting) -> Result<Row, Error> {
    let xs = setting.of(&[1.0, 10.0, 98.1, 300.0, 1000.0, 3000.0, 9810.0]);
    let (points, left_out) = drops(setting, &xs, 1600.0, |x| json!({"gravity": x, "substeps": 1}))?;
    Ok(Row {
        name: "bullet_gravity",
        title: "Bullet: gravity, one step a frame",
        swept: Swept { name: "gravity (98.1 is shipped, with 6 steps)", log: true },
        error: ERROR,
        does: DOES,
        points,
        left_out,
    })
}
