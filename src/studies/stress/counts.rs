//! Very small and very large numbers.

use std::path::Path;

use serde_json::{Value, json};

use super::bullet::small_scene;
use super::precision::{groove, groove_scene};
use super::shape::Shape;
use super::stage::{Outcome, Stage, scene};
use super::{Measured, Point, Setting};
use crate::scene::Scene;
use crate::support::error::Error;
use crate::table::{Part, Target};

/// The opening of an endless groove as deep as wide, by few paths.
pub(super) fn few_paths(setting: &Setting) -> Result<Vec<Point>, Error> {
    let truth = groove(setting, 1.0)?;
    let numbers = [1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18].map(|power| f64::from(1 << power));
    setting.sweep(&numbers, "ask for more --paths", |paths| {
        let (scene, slab) = groove_scene(1.0, 1000.0);
        let target = Target { exactly: Some(first(paths as u64)), ..setting.target() };
        Ok(Stage { target, ..Stage::new(setting, scene, &slab) }.run()?.against(truth))
    })
}

/// All paths of a result of so many paths.
pub(super) fn first(paths: u64) -> Part {
    Part { first: 0, end: paths, of: paths }
}

/// A field of spheres on a floor.
pub(super) fn particles_of_field(setting: &Setting) -> Result<Vec<Point>, Error> {
    let sphere = Shape::sphere(3, "grain");
    let with_sides = |sides: Value| {
        let mut scene = scene(&[("grain", 0.3), ("floor", 0.3)]);
        let transform = [100, 0, 0, 120, 0, 100, 0, 120, 0, 0, 100, 100];
        let placed = &mut scene["geometry"]["placed"];
        placed["instances"] = json!([{"prototype": "mesh", "transform": transform}]);
        placed["domain"] = json!({
            "min_um": [0, 0], "max_um": [240, 240], "sides": sides,
            "floor": {"z_um": 0, "material": "floor"}
        });
        setting.run(scene, &sphere)
    };
    let truth = with_sides(json!("periodic"))?.emissivity();
    let numbers = [1.0, 4.0, 1e1, 1e2, 1e3, 1e4, 1e6, 1e8, 1e9, 4e9, 5e9, 1e12, 1e15];
    setting.sweep(&numbers, "the field is needed", |particles| {
        Ok(with_sides(json!({"field": {"particles": particles}}))?.against(truth))
    })
}

/// A plate of the last of many materials.
pub(super) fn materials(setting: &Setting) -> Result<Vec<Point>, Error> {
    let plate = Shape::plate(0.0, 1e3, "last");
    let numbers = [1.0, 1e1, 1e2, 1e3, 1001.0, 1e4, 65_536.0, 65_537.0, 1e5];
    setting.sweep(&numbers, "more than 1000", |number| {
        let others: Vec<String> = (1..number as u32).map(|i| format!("m{i}")).collect();
        let others = others.iter().map(|name| (name.as_str(), 0.9));
        let materials: Vec<_> = others.chain([("last", 0.6)]).collect();
        Ok(setting.run(scene(&materials), &plate)?.against(0.6))
    })
}

/// Recipes of no grain and of too many, which are refused before Blender starts.
pub(super) fn grains_of_recipe(setting: &Setting) -> Result<Vec<Point>, Error> {
    let numbers = [0.0, 1.0, 1e1, 1e3, 1e5, 100_001.0, 1e6, 1e9, 1e10];
    setting.sweep(&numbers, "", |grains| {
        let text = small_scene(grains as u64, 0).to_string();
        Ok(match Scene::parse(&text, Path::new("scene.json")) {
            Ok(_) => Measured { error: Some(0.0), claimed: 0.0, said: Vec::new(), status: 0 },
            Err(error) => Outcome::refused(&error.into(), "").with_error(None),
        })
    })
}
