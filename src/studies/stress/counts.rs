//! Very few and very many of something.

use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use super::precision::{groove, groove_scene};
use super::scenes::{Outcome, Shape, Stage, scene};
use super::{Point, Row, Setting, Swept};
use crate::scene::Scene;
use crate::support::error::Error;
use crate::table::{Part, Target};

/// The opening of an endless groove as deep as wide, by few paths.
pub(super) fn few_paths(setting: &Setting) -> Result<Row, Error> {
    let truth = groove(1.0)?;
    let mut points = Vec::new();
    for power in setting.of(&[1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18]) {
        let (scene, slab) = groove_scene(1.0, 1000.0);
        let paths = 1_u64 << power;
        let exactly = Some(Part { first: 0, end: paths, of: paths });
        let stage = Stage {
            target: Target { exactly, ..setting.target() },
            ..Stage::new(setting, scene, &slab)
        };
        points.push(stage.run()?.point(paths as f64, truth, "ask for more --paths"));
    }
    Ok(Row {
        name: "few_paths",
        title: "Very few paths",
        swept: Swept { name: "paths", log: true },
        error: "emissivity of a groove's opening, less that to .0005",
        does: "widens the interval (one path tells no spread: +-1), and warns that the tolerance was not \
               reached; status 4 unless so many paths were asked for",
        points,
        left_out: None,
    })
}

/// Spheres on a floor, a field of them.
pub(super) fn particles_of_field(setting: &Setting) -> Result<Row, Error> {
    let sphere = Shape::sphere(3, "grain");
    let with_sides = |sides: Value| {
        let mut scene = scene(&[("grain", 0.3), ("floor", 0.3)]);
        scene["geometry"]["placed"]["instances"] = json!([{"prototype": "mesh", "transform": [100, 0, 0, 120, 0, 100, 0, 120, 0, 0, 100, 100]}]);
        scene["geometry"]["placed"]["domain"] = json!({
            "min_um": [0, 0], "max_um": [240, 240], "sides": sides,
            "floor": {"z_um": 0, "material": "floor"}
        });
        Stage::new(setting, scene, &sphere).run()
    };
    let truth = with_sides(json!("periodic"))?.bands[0].emissivity.mean;
    let mut points = Vec::new();
    for particles in
        setting.of(&[1.0, 4.0, 1e1, 1e2, 1e3, 1e4, 1e6, 1e8, 1e9, 4e9, 5e9, 1e12, 1e15])
    {
        let outcome = with_sides(json!({"field": {"particles": particles}}))?;
        points.push(outcome.point(particles, truth, "the field is needed"));
    }
    Ok(Row {
        name: "particles_of_field",
        title: "A field of few and of very many particles",
        swept: Swept { name: "particles", log: true },
        error: "emissivity less that of spheres without end",
        does: "says of a small field that its rim shows; refuses more than 65536 patches along a side, status 3",
        points,
        left_out: None,
    })
}

/// A plate of the last of many materials.
pub(super) fn materials(setting: &Setting) -> Result<Row, Error> {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| 1e3 * p);
    let mut plate = Shape { points: corners.to_vec(), ..Shape::default() };
    plate.face(&[0, 1, 2, 3], "last");
    let mut points = Vec::new();
    for number in setting.of(&[1, 10, 100, 1000, 1001, 10_000, 65_536, 65_537, 100_000]) {
        let mut scene = scene(&[]);
        let others =
            (1..number).map(|i| json!({"name": format!("m{i}"), "spectrum": {"constant": 0.9}}));
        let last = json!({"name": "last", "spectrum": {"constant": 0.6}});
        scene["materials"] = others.chain([last]).collect();
        let outcome = Stage::new(setting, scene, &plate).run()?;
        points.push(outcome.point(f64::from(number), 0.6, "more than 1000"));
    }
    Ok(Row {
        name: "materials",
        title: "Very many materials",
        swept: Swept { name: "materials of a scene", log: true },
        error: "emissivity of a plate of the last of them, less its .6",
        does: "refuses more than 1000, status 3",
        points,
        left_out: None,
    })
}

/// Recipes of no grain and of too many: what is known before Blender is started.
#[expect(clippy::unnecessary_wraps, reason = "as all rows")]
pub(super) fn grains_of_recipe(setting: &Setting) -> Result<Row, Error> {
    let mut points = Vec::new();
    for grains in setting.of(&[
        0_u64,
        1,
        10,
        1000,
        100_000,
        100_001,
        1_000_000,
        1_000_000_000,
        10_000_000_000,
    ]) {
        let mut scene: Value =
            serde_json::from_str(include_str!("../../../scenes/small.json")).expect("JSON");
        let packing = &mut scene["geometry"]["packing"];
        let mut class = packing["grains"][0].clone();
        class["count"] = json!(grains);
        class["fines"] = json!(0);
        packing["grains"] = json!([class]);
        let (error, outcome) = match Scene::parse(&scene.to_string(), Path::new("scene.json")) {
            Ok(_) => (Some(0.0), None),
            Err(error) => (None, Some(Outcome::refused(&error.into()))),
        };
        points.push(Point {
            x: grains as f64,
            error,
            claimed: 0.0,
            said: outcome.as_ref().and_then(|outcome| outcome.said("error: ")),
            status: outcome.map_or(0, |outcome| outcome.status),
        });
    }
    Ok(Row {
        name: "grains_of_recipe",
        title: "A recipe of no grain, and of 10^10",
        swept: Swept { name: "grains of a class, without fines", log: true },
        error: "none: only whether the recipe is taken",
        does: "refuses no grain at all, and more than 100,000, before Blender is started, status 3",
        points,
        left_out: None,
    })
}
