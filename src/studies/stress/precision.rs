//! Lengths, and the rounding of coordinates.

use glam::DVec3;
use serde_json::{Value, json};

use super::shape::Shape;
use super::stage::{Stage, scene, set_domain};
use super::{Point, Setting};
use crate::support::error::Error;
use crate::table::Target;

const TOO_FINE: &str = "too fine for coordinates";

/// A scene around a cubic pit whose edges have the length of the unit, and the pit.
fn pit(unit_um: f64) -> (Value, Shape) {
    let mut scene = scene(&[("rock", 0.5)]);
    scene["geometry"]["placed"]["prototypes"][0]["unit_um"] = json!(unit_um);
    (scene, Shape::pit(DVec3::ONE, "rock", "rock"))
}

/// Emissivity of the opening of a cubic pit of a millimetre at the origin.
fn pit_of_a_millimetre(setting: &Setting) -> Result<f64, Error> {
    let (scene, pit) = pit(1e3);
    Ok(setting.run(scene, &pit)?.emissivity())
}

/// Emissivity of the opening of an endless groove of 100 um, to .0005.
pub(super) fn groove(setting: &Setting, depth: f64) -> Result<f64, Error> {
    let (scene, slab) = groove_scene(depth, 1000.0);
    let target = Target::of(5e-4);
    Ok(Stage { target, ..Stage::new(setting, scene, &slab) }.run()?.emissivity())
}

/// A groove of 100 um; its depth and its length either way are in units of its width. The sensor
/// sees the middle of its opening.
pub(super) fn groove_scene(depth: f64, long: f64) -> (Value, Shape) {
    let slab = Shape::groove(1.0, depth, [-1.0, 2.0], [-long, long]).scaled(100.0);
    let mut scene = scene(&[("rock", 0.5)]);
    set_domain(&mut scene, [0.0, -100.0], [100.0, 100.0], "open");
    (scene, slab)
}

/// A groove whose walls lie in the sides of the domain, or slightly inside them.
pub(super) fn facet_in_side(setting: &Setting) -> Result<Vec<Point>, Error> {
    let truth = groove(setting, 2.0)?;
    let within_um = [0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
    setting.sweep(&within_um, "in a side of the domain", |within_um| {
        let (mut scene, slab) = groove_scene(2.0, 3.0);
        set_domain(&mut scene, [-within_um, -100.0], [100.0 + within_um, 100.0], "mirror");
        Ok(setting.run(scene, &slab)?.against(truth))
    })
}

/// A cubic pit in other units.
pub(super) fn units(setting: &Setting) -> Result<Vec<Point>, Error> {
    let truth = pit_of_a_millimetre(setting)?;
    let units_um = [
        1e-42, 1e-35, 1e-25, 1e-20, 1e-15, 1e-10, 1e-6, 1e-3, 1.0, 1e1, 1e2, 1e3, 1e4, 1e6, 1e8,
        1e9, 1e12, 1e20, 1e40,
    ];
    setting.sweep(&units_um, "the wavelength of", |unit_um| {
        let (scene, pit) = pit(unit_um);
        Ok(setting.run(scene, &pit)?.against(truth))
    })
}

/// A cubic pit of 100 um far from the origin of its glTF file, which has single precision.
pub(super) fn distance_in_file(setting: &Setting) -> Result<Vec<Point>, Error> {
    let truth = pit_of_a_millimetre(setting)?;
    setting.sweep(&[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8], TOO_FINE, |far| {
        let (mut scene, mut pit) = pit(1.0);
        for point in &mut pit.points {
            // Single precision would hold round numbers at any distance.
            *point = 0.37 * (*point + far * DVec3::new(0.9, -0.7, 0.8));
        }
        scene["geometry"]["placed"]["prototypes"][0] =
            json!({"name": "mesh", "file": "mesh.gltf", "up": "z", "unit_um": 100.0 / 0.37});
        let stage = Stage { files: pit.gltf(), ..Stage::new(setting, scene, &pit) };
        Ok(stage.run()?.against(truth))
    })
}

/// A cubic pit of 100 um placed far from the scene's origin.
pub(super) fn distance_of_instance(setting: &Setting) -> Result<Vec<Point>, Error> {
    let truth = pit_of_a_millimetre(setting)?;
    let far_um = [0.0, 1e3, 1e5, 1e6, 1e7, 1e8, 5e8, 9.9e8, 1e9, 1e10, 1e12];
    setting.sweep(&far_um, "below 1e9", |far_um| {
        let (mut scene, pit) = pit(1.0);
        scene["geometry"]["placed"]["instances"] = json!([{
            "prototype": "mesh",
            "transform": [100, 0, 0, far_um, 0, 100, 0, -far_um, 0, 0, 100, far_um]
        }]);
        Ok(setting.run(scene, &pit)?.against(truth))
    })
}

/// A groove as deep as wide near the end of a slab a metre long, in one mesh.
pub(super) fn detail(setting: &Setting) -> Result<Vec<Point>, Error> {
    let truth = groove(setting, 1.0)?;
    let widths_um = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3];
    setting.sweep(&widths_um, TOO_FINE, |width_um| {
        let (from, half, long) = (4.3e5, 5e5, 2e3 * width_um);
        let ends = [-half - from, half - from];
        let mut slab = Shape::groove(width_um, width_um, ends, [-long, long]);
        slab.points.iter_mut().for_each(|point| point.x += from);
        let mut scene = scene(&[("rock", 0.5)]);
        // The sensor sees the middle of the groove's opening.
        set_domain(&mut scene, [from, -width_um], [from + width_um, width_um], "open");
        Ok(setting.run(scene, &slab)?.against(truth))
    })
}

/// A convex block whose top and bottom are cut into strips, one of them narrow.
pub(super) fn slivers(setting: &Setting) -> Result<Vec<Point>, Error> {
    let shares = [1e-16, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 1e-2];
    setting.sweep(&shares, TOO_FINE, |share| {
        let lines = [0.0, 0.5, 0.5 + share, 1.0];
        let mut block = Shape::default();
        for (y, z) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            block.points.extend(lines.map(|x| 500.0 * DVec3::new(x, y, z)));
        }
        for ring in 0..4 {
            let next = (ring + 1) % 4;
            for i in 0..3 {
                let [a, b] = [4 * ring + i, 4 * next + i];
                block.face(&[a, a + 1, b + 1], "rock");
                block.face(&[a, b + 1, b], "rock");
            }
        }
        block.face(&[0, 4, 8, 12], "rock");
        block.face(&[15, 11, 7, 3], "rock");
        Ok(setting.run(scene(&[("rock", 0.5)]), &block)?.against(0.5))
    })
}

/// Two blocks with a slot between them, twice as deep as wide. The sensor looks into the slot.
pub(super) fn gap(setting: &Setting) -> Result<Vec<Point>, Error> {
    let truth = groove(setting, 2.0)?;
    let block = Shape::block(DVec3::NEG_ONE, DVec3::ONE, "rock");
    let gaps_um = [1e-12, 1e-11, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 10.0, 100.0];
    setting.sweep(&gaps_um, "solids overlap", |gap_um| {
        let mut scene = scene(&[("rock", 0.5), ("floor", 0.5)]);
        let place = |x: f64| {
            json!({
                "prototype": "mesh",
                "transform": [500, 0, 0, x, 0, 500, 0, 0, 0, 0, gap_um, -gap_um]
            })
        };
        let half = gap_um / 2.0;
        set_domain(&mut scene, [-half; 2], [half; 2], "open");
        let placed = &mut scene["geometry"]["placed"];
        placed["instances"] = json!([place(-500.0 - half), place(500.0 + half)]);
        placed["domain"]["floor"] = json!({"z_um": -2.0 * gap_um, "material": "floor"});
        Ok(setting.run(scene, &block)?.against(truth))
    })
}
