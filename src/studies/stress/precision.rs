//! Lengths, and what numbers of so many digits hold of them.

use glam::DVec3;
use serde_json::{Value, json};

use super::scenes::{Shape, Stage, at_9_um, scene};
use super::{Row, Setting, Swept};
use crate::support::error::Error;
use crate::support::monitor::Unwatched;
use crate::table::Target;

/// Emissivity of the opening of a cubic pit whose walls have .5, seen from above, as the tool gives it for the pit of a
/// millimetre at the origin with the same rays.
fn pit_of_a_millimetre(setting: &Setting) -> Result<f64, Error> {
    let pit = Shape::pit(DVec3::ONE, "rock", "rock");
    let mut scene = scene(&[("rock", 0.5)]);
    scene["geometry"]["placed"]["prototypes"][0]["unit_um"] = json!(1e3);
    let outcome = Stage::new(setting, scene, &pit).run()?;
    Ok(outcome.bands[0].emissivity.mean)
}

/// Emissivity of the opening of an endless groove seen from above, of facets of .5, as the tool gives it at a length that it is
/// at home with.
pub(super) fn groove(depth: f64) -> Result<f64, Error> {
    let (scene, slab) = groove_scene(depth, 1000.0);
    let files = vec![("mesh.obj", slab.obj().into_bytes())];
    let outcome =
        Stage { scene, files, grid: at_9_um(), target: Target::of(5e-4), monitor: &Unwatched }
            .run()?;
    Ok(outcome.bands[0].emissivity.mean)
}

/// A groove of 100 um in a slab so many times as long either way; the sensor looks at the middle of its opening.
pub(super) fn groove_scene(depth: f64, long: f64) -> (Value, Shape) {
    let profile = [(-1.0, 0.0), (0.0, 0.0), (0.0, -depth), (1.0, -depth), (1.0, 0.0), (2.0, 0.0)];
    let mut slab = Shape::default();
    for y in [-long, long] {
        slab.points.extend(profile.map(|(x, z)| 100.0 * DVec3::new(x, y, z)));
    }
    for i in 0..5 {
        slab.face(&[i, i + 1, i + 7, i + 6], "rock");
    }
    let mut scene = scene(&[("rock", 0.5)]);
    scene["geometry"]["placed"]["domain"] =
        json!({"min_um": [0, -100], "max_um": [100, 100], "sides": "open"});
    (scene, slab)
}

/// Walls of a groove in the sides of the domain, or a little within them.
pub(super) fn facet_in_side(setting: &Setting) -> Result<Row, Error> {
    let truth = groove(2.0)?;
    let mut points = Vec::new();
    for within_um in setting.of(&[0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2]) {
        let (mut scene, slab) = groove_scene(2.0, 3.0);
        scene["geometry"]["placed"]["domain"] = json!({
            "min_um": [-within_um, -100], "max_um": [100.0 + within_um, 100], "sides": "mirror"
        });
        let outcome = Stage::new(setting, scene, &slab).run()?;
        points.push(outcome.point(within_um, truth, "in a side of the domain"));
    }
    Ok(Row {
        name: "facet_in_side",
        title: "Facets in a side of the domain (mirrors)",
        swept: Swept { name: "walls of a groove within the sides by, um", log: true },
        error: "emissivity of the groove's opening, less that between open sides",
        does: "warns; put the side before or behind such facets",
        points,
        left_out: None,
    })
}

/// A cubic pit whose file is in another unit.
pub(super) fn units(setting: &Setting) -> Result<Row, Error> {
    let pit = Shape::pit(DVec3::ONE, "rock", "rock");
    let truth = pit_of_a_millimetre(setting)?;
    let mut points = Vec::new();
    for power in
        setting.of(&[-42, -35, -25, -20, -15, -10, -6, -3, 0, 1, 2, 3, 4, 6, 8, 9, 12, 20, 40])
    {
        let unit_um = 10f64.powi(power);
        let mut scene = scene(&[("rock", 0.5)]);
        scene["geometry"]["placed"]["prototypes"][0]["unit_um"] = json!(unit_um);
        let outcome = Stage::new(setting, scene, &pit).run()?;
        points.push(outcome.point(unit_um, truth, "below the wavelength"));
    }
    Ok(Row {
        name: "units",
        title: "The scene's unit",
        swept: Swept { name: "length of a cubic pit, um", log: true },
        error: "emissivity less that of a pit of a millimetre, same rays",
        does: "below the wavelength warns that rays do not hold; from a kilometre on refuses, status 3",
        points,
        left_out: None,
    })
}

/// A cubic pit of 100 um whose glTF file, of single precision, has it far from its origin.
pub(super) fn distance_in_file(setting: &Setting) -> Result<Row, Error> {
    let truth = pit_of_a_millimetre(setting)?;
    let mut points = Vec::new();
    for power in setting.of(&[0, 1, 2, 3, 4, 5, 6, 7, 8]) {
        let far = 10f64.powi(power);
        let mut pit = Shape::pit(DVec3::ONE, "rock", "rock");
        for point in &mut pit.points {
            // No round number, which singles would hold anywhere.
            *point = 0.37 * (*point + far * DVec3::new(0.9, -0.7, 0.8));
        }
        let mut scene = scene(&[("rock", 0.5)]);
        scene["geometry"]["placed"]["prototypes"][0] =
            json!({"name": "mesh", "file": "mesh.gltf", "up": "z", "unit_um": 100.0 / 0.37});
        let files = pit.gltf();
        let stage = Stage {
            scene,
            files,
            grid: at_9_um(),
            target: setting.target(),
            monitor: setting.monitor,
        };
        points.push(stage.run()?.point(far, truth, "too fine for coordinates"));
    }
    Ok(Row {
        name: "distance_in_file",
        title: "A glTF mesh far from its file's origin",
        swept: Swept { name: "distance, in lengths of a cubic pit of 100 um", log: true },
        error: "emissivity less that of the pit at the origin, same rays",
        does: "warns by how much the file's coordinates are rounded; from a kilometre on refuses, status 3",
        points,
        left_out: None,
    })
}

/// A cubic pit of 100 um that is placed far from the scene's origin.
pub(super) fn distance_of_instance(setting: &Setting) -> Result<Row, Error> {
    let pit = Shape::pit(DVec3::ONE, "rock", "rock");
    let truth = pit_of_a_millimetre(setting)?;
    let mut points = Vec::new();
    for far_um in setting.of(&[0.0, 1e3, 1e5, 1e6, 1e7, 1e8, 5e8, 9.9e8, 1e9, 1e10, 1e12]) {
        let mut scene = scene(&[("rock", 0.5)]);
        scene["geometry"]["placed"]["instances"] = json!([{
            "prototype": "mesh",
            "transform": [100, 0, 0, far_um, 0, 100, 0, -far_um, 0, 0, 100, far_um]
        }]);
        let outcome = Stage::new(setting, scene, &pit).run()?;
        points.push(outcome.point(far_um, truth, "below 1e9"));
    }
    Ok(Row {
        name: "distance_of_instance",
        title: "An instance far from the scene's origin",
        swept: Swept { name: "distance of a cubic pit of 100 um, um", log: true },
        error: "emissivity less that of the pit at the origin, same rays",
        does: "holds as far as a kilometre, and refuses what is beyond, status 3",
        points,
        left_out: None,
    })
}

/// A groove as deep as wide near the end of a slab a metre long, all of it one mesh.
pub(super) fn detail(setting: &Setting) -> Result<Row, Error> {
    let truth = groove(1.0)?;
    let mut points = Vec::new();
    for width_um in setting.of(&[1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3]) {
        let (from, half, long) = (4.3e5, 5e5, 2e3 * width_um);
        let to = from + width_um;
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let profile =
            [(-half, 0.0), (from, 0.0), (from, -width_um), (to, -width_um), (to, 0.0), (half, 0.0)];
        let mut slab = Shape::default();
        for y in [-long, long] {
            slab.points.extend(profile.map(|(x, z)| at(x, y, z)));
        }
        for i in 0..5 {
            slab.face(&[i, i + 1, i + 7, i + 6], "rock");
        }
        let mut scene = scene(&[("rock", 0.5)]);
        // The sensor looks at the middle of the groove's opening.
        scene["geometry"]["placed"]["domain"] = json!({
            "min_um": [from, -width_um], "max_um": [to, width_um], "sides": "open"
        });
        let outcome = Stage::new(setting, scene, &slab).run()?;
        points.push(outcome.point(width_um, truth, "too fine for coordinates"));
    }
    Ok(Row {
        name: "detail",
        title: "Fine detail at the rim of a mesh a metre wide",
        swept: Swept { name: "width and depth of a groove, um", log: true },
        error: "emissivity of the groove's opening, less that of a groove of 100 um about the origin",
        does: "warns by how much coordinates are rounded (.03 um here), and what to do",
        points,
        left_out: None,
    })
}

/// A convex block whose top and bottom are cut into strips, one of them narrow.
pub(super) fn slivers(setting: &Setting) -> Result<Row, Error> {
    let mut points = Vec::new();
    for share in setting.of(&[1e-16, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 1e-2]) {
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
        let outcome = Stage::new(setting, scene(&[("rock", 0.5)]), &block).run()?;
        points.push(outcome.point(share, 0.5, "too fine for coordinates"));
    }
    Ok(Row {
        name: "slivers",
        title: "Slivers and facets without area",
        swept: Swept { name: "width of a strip as a share of its block", log: true },
        error: "emissivity of the convex block, less that of its facets, .5",
        does: "leaves out facets without area, and loses no ray; warns where strips are lost in rounding",
        points,
        left_out: None,
    })
}

/// Two blocks with a slot between them; the sensor looks into the slot, twice as deep as wide.
pub(super) fn gap(setting: &Setting) -> Result<Row, Error> {
    let truth = groove(2.0)?;
    let deep = |gap_um: f64| 2.0 * gap_um;
    let block = Shape::block(DVec3::new(-1.0, -1.0, -1.0), DVec3::ONE, "rock");
    let mut points = Vec::new();
    for gap_um in setting.of(&[1e-12, 1e-11, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 10.0, 100.0]) {
        let mut scene = scene(&[("rock", 0.5), ("floor", 0.5)]);
        let place = |x: f64| json!({"prototype": "mesh", "transform": [500, 0, 0, x, 0, 500, 0, 0, 0, 0, deep(gap_um) / 2.0, -deep(gap_um) / 2.0]});
        let half = gap_um / 2.0;
        scene["geometry"]["placed"]["instances"] =
            json!([place(-500.0 - half), place(500.0 + half)]);
        scene["geometry"]["placed"]["domain"] = json!({
            "min_um": [-half, -half], "max_um": [half, half], "sides": "open",
            "floor": {"z_um": -deep(gap_um), "material": "floor"}
        });
        let outcome = Stage::new(setting, scene, &block).run()?;
        points.push(outcome.point(gap_um, truth, "solids overlap"));
    }
    Ok(Row {
        name: "gap",
        title: "A gap between two solids of a millimetre",
        swept: Swept { name: "width of the gap, twice as deep, um", log: true },
        error: "emissivity of the gap's opening, less that of an endless groove of 100 um",
        does: "keeps gaps down to 1e-10 um, where coordinates end; counts paths that come to be inside a solid",
        points,
        left_out: None,
    })
}
