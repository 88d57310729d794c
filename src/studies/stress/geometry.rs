//! Meshes, solids, views and patches.

use glam::DVec3;
use serde_json::{Value, json};

use super::scenes::{Outcome, Shape, Stage, scene, under_the_opening};
use super::{Point, Row, Setting, Swept};
use crate::scene::Grid;
use crate::spectrum::Spectrum;
use crate::support::error::Error;
use crate::support::random::{Purpose, Source};
use crate::table::{Part, Target};

/// Exactly so many paths.
fn exactly(paths: u64, tolerance: f64) -> Target {
    Target { exactly: Some(Part { first: 0, end: paths, of: paths }), ..Target::of(tolerance) }
}

/// Scales and shifts that make an instance of a mesh.
fn instance(scale: DVec3, at: DVec3) -> Value {
    json!({"prototype": "mesh", "transform": [
        scale.x, 0, 0, at.x, 0, scale.y, 0, at.y, 0, 0, scale.z, at.z
    ]})
}

/// A sphere from whose mesh facets are missing.
pub(super) fn holes(setting: &Setting) -> Result<Row, Error> {
    let whole = Shape::sphere(4, "rock");
    let facets = whole.faces.len();
    let mut points = Vec::new();
    for percent in setting.of(&[0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0]) {
        let missing = (percent / 100.0 * facets as f64).ceil() as usize;
        // 7919 is a prime: every facet comes once, and neighbours lie far apart.
        let is_missing = |i: usize| i * 7919 % facets < missing;
        let faces = whole.faces.iter().enumerate().filter(|(i, _)| !is_missing(*i));
        let sphere = Shape {
            points: whole.points.iter().map(|p| 500.0 * *p).collect(),
            faces: faces.map(|(_, face)| face.clone()).collect(),
            ..Shape::default()
        };
        let outcome = Stage::new(setting, scene(&[("rock", 0.5)]), &sphere).run()?;
        points.push(outcome.point(percent, 0.5, "closed but for"));
    }
    Ok(Row {
        name: "holes",
        title: "A solid with facets missing",
        swept: Swept { name: "facets of a sphere that are missing, %", log: false },
        error: "emissivity of the sphere, less that of its facets, .5",
        does: "warns with the number of open edges; sheets and pits are left alone",
        points,
        left_out: None,
    })
}

/// Two spheres that pass through each other.
pub(super) fn overlap(setting: &Setting) -> Result<Row, Error> {
    let sphere = Shape::sphere(5, "rock");
    let mut points = Vec::new();
    for depth in setting.of(&[0.0, 0.002, 0.005, 0.01, 0.015, 0.03, 0.05, 0.1, 0.2, 0.3, 0.5]) {
        let mut scene = scene(&[("rock", 0.5)]);
        let size = DVec3::splat(500.0);
        let aside = (1.0 - depth) * 500.0 * DVec3::X;
        scene["geometry"]["placed"]["instances"] =
            json!([instance(size, -aside), instance(size, aside)]);
        let outcome = Stage::new(setting, scene, &sphere).run()?;
        // A cap whose height is half of the depth, of each.
        let within = depth / 2.0;
        let point = outcome.with_error(depth, Some(within), "solids pass through");
        points.push(Point { claimed: 0.005, ..point });
    }
    Ok(Row {
        name: "overlap",
        title: "Solids that pass through each other",
        swept: Swept { name: "depth, in diameters of two spheres", log: false },
        error: "share of the surface that lies within the other sphere (closed form), which the result takes for none; \
                .01 is allowed",
        does: "warns with the share that it finds by probes; rays see what is outermost",
        points,
        left_out: None,
    })
}

/// A spherical cavity of few facets, whose file gives the normals of the sphere.
pub(super) fn coarse_sphere(setting: &Setting) -> Result<Row, Error> {
    let (open, e) = (0.1, 0.5);
    let mut points = Vec::new();
    for around in setting.of(&[4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96]) {
        let mut cavity = Shape::cavity(open, around, "wall");
        for point in &mut cavity.points {
            *point *= 500.0;
        }
        let mut scene = scene(&[("wall", e)]);
        scene["geometry"]["placed"]["domain"] = under_the_opening(open, 500.0);
        let outcome = Stage::new(setting, scene, &cavity).run()?;
        let closed_form = e / (e * (1.0 - open) + open);
        points.push(outcome.point(around as f64, closed_form, "curved surface"));
    }
    Ok(Row {
        name: "coarse_sphere",
        title: "A sphere of few facets",
        swept: Swept { name: "facets around a spherical cavity, 10 % open", log: true },
        error: "emissivity of the opening, less that of the sphere, e / (e (1 - s) + s)",
        does: "warns where the file's normals say that the surface is curved; a mesh without normals is taken at its word",
        points,
        left_out: None,
    })
}

/// A groove as deep as wide, without end, seen along its length: from any zenith angle as from above.
pub(super) fn grazing_view(setting: &Setting) -> Result<Row, Error> {
    let (wide, long) = (100.0, 5.0);
    let (min, max) = (-0.5 * wide, 2.5 * wide);
    let profile = [
        (min, 0.0),
        (0.5 * wide, 0.0),
        (0.5 * wide, -wide),
        (1.5 * wide, -wide),
        (1.5 * wide, 0.0),
        (max, 0.0),
    ];
    let mut slab = Shape::default();
    // Longer than the domain, so that no side meets an edge.
    for y in [-long, 2.0 * long] {
        slab.points.extend(profile.map(|(x, z)| DVec3::new(x, y, z)));
    }
    for i in 0..5 {
        slab.face(&[i, i + 1, i + 7, i + 6], "rock");
    }
    let seen_from = |zenith_deg: f64, target: Target| {
        let mut scene = scene(&[("rock", 0.3)]);
        scene["view"] = json!({"zenith_deg": zenith_deg, "azimuth_deg": 90.0});
        scene["geometry"]["placed"]["domain"] =
            json!({"min_um": [0.0, 0.0], "max_um": [2.0 * wide, long], "sides": "mirror"});
        Stage { target, ..Stage::new(setting, scene, &slab) }.run()
    };
    let truth = seen_from(0.0, Target::of(0.003))?.bands[0].emissivity.mean;
    let mut points = Vec::new();
    for zenith_deg in
        setting.of(&[0.0, 20.0, 40.0, 60.0, 75.0, 80.0, 85.0, 87.0, 89.0, 89.5, 89.8, 89.87, 89.9])
    {
        // The sides are crossed thousands of times where the view is level.
        let outcome = seen_from(zenith_deg, exactly(512, 0.05))?;
        points.push(outcome.point(zenith_deg, truth, "were given up"));
    }
    Ok(Row {
        name: "grazing_view",
        title: "Grazing views of a bed within mirrors",
        swept: Swept { name: "view along an endless groove, degrees from nadir", log: false },
        error: "emissivity less that seen from above, to which it is equal; 512 paths",
        does: "gives a ray up after 10,000 sides; what it leaves open widens the interval, with a warning",
        points,
        left_out: None,
    })
}

/// A flat floor of quartz that reflects as a mirror.
pub(super) fn grazing_mirror(setting: &Setting) -> Result<Row, Error> {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| 3e3 * p - 1e3);
    let mut plate = Shape { points: corners.to_vec(), ..Shape::default() };
    plate.face(&[0, 1, 2, 3], "quartz");
    let quartz = Spectrum::fresnel("quartz")?;
    let mut points = Vec::new();
    for zenith_deg in setting.of(&[
        0.0_f64, 30.0, 50.0, 60.0, 70.0, 75.0, 80.0, 83.0, 85.0, 86.0, 87.0, 88.0, 89.0, 89.5, 89.9,
    ]) {
        let mut scene = scene(&[("quartz", 0.0)]);
        scene["materials"][0]["spectrum"] = json!({"fresnel": "quartz"});
        scene["view"]["zenith_deg"] = json!(zenith_deg);
        scene["geometry"]["placed"]["domain"] =
            json!({"min_um": [0.0, 0.0], "max_um": [1e3, 1e3], "sides": "mirror"});
        let mut stage = Stage::new(setting, scene, &plate);
        stage.grid = Grid::new(11.0, 11.0, 1.0).expect("a grid");
        let outcome = stage.run()?;
        let cosine = zenith_deg.to_radians().cos();
        let truth = 1.0 - quartz.reflectance_at(11.0, cosine)?;
        let point = outcome.point(zenith_deg, truth, "bin of cosines");
        points.push(Point { claimed: stage.target.tolerance / 2.0, ..point });
    }
    Ok(Row {
        name: "grazing_mirror",
        title: "Grazing views of a flat floor that mirrors (Fresnel)",
        swept: Swept { name: "view, degrees from nadir", log: false },
        error: "emissivity less 1 - R by Fresnel, at 11 um; the tolerance is allowed",
        does: "warns by how much reflectance changes within the bin of cosines of such facets",
        points,
        left_out: None,
    })
}

/// Layers of bright spheres on a black floor.
pub(super) fn shallow_bed(setting: &Setting) -> Result<Row, Error> {
    let sphere = Shape::sphere(if setting.quick { 2 } else { 3 }, "grain");
    let (radius, cell) = (100.0, 230.0);
    let of_layers = |layers: u32| -> Result<Outcome, Error> {
        let mut instances = Vec::new();
        for layer in 0..layers {
            // Counted from above, so that the layer on top is the same for all.
            let z = radius * (1.0 + 1.7 * f64::from(layers - 1 - layer));
            // Four layers in turn, so that no straight line leads down between the spheres.
            let corners: &[(f64, f64)] = match layer % 4 {
                0 => &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)],
                1 => &[(0.5, 0.5)],
                2 => &[(0.5, 0.0), (0.5, 1.0)],
                _ => &[(0.0, 0.5), (1.0, 0.5)],
            };
            for (x, y) in corners {
                instances.push(instance(DVec3::splat(radius), DVec3::new(x * cell, y * cell, z)));
            }
        }
        let mut scene = scene(&[("grain", 0.3), ("floor", 1.0)]);
        scene["geometry"]["placed"]["instances"] = json!(instances);
        scene["geometry"]["placed"]["domain"] = json!({
            "min_um": [0, 0], "max_um": [cell, cell], "sides": "mirror",
            "floor": {"z_um": 0, "material": "floor"}
        });
        Stage::new(setting, scene, &sphere).run()
    };
    let truth = of_layers(16)?.bands[0].emissivity.mean;
    let mut points = Vec::new();
    for layers in setting.of(&[1, 2, 3, 4, 5, 6, 7, 8, 10, 12]) {
        points.push(of_layers(layers)?.point(f64::from(layers), truth, "the floor shows"));
    }
    Ok(Row {
        name: "shallow_bed",
        title: "A bed so shallow that the floor shows",
        swept: Swept { name: "layers of spheres of emissivity .3 on a black floor", log: false },
        error: "emissivity less that of 16 layers, at 9 um",
        does: "evaluates the bed on a black and a white floor; warns where a band changes by more than the tolerance",
        points,
        left_out: None,
    })
}

/// A patch of few columns of random height, within mirrors.
pub(super) fn narrow_patch(setting: &Setting) -> Result<Row, Error> {
    let column = Shape::block(DVec3::ZERO, DVec3::ONE, "rock");
    let source = Source::new(5, Purpose::Packing);
    let of_columns = |across: u32, draw: u64| -> Result<Outcome, Error> {
        let mut instances = Vec::new();
        for number in 0..across * across {
            let [height, _] = source.stream(draw << 32 | u64::from(number)).pair();
            let size = DVec3::new(100.0, 100.0, 20.0 + 280.0 * height);
            let at =
                100.0 * DVec3::new(f64::from(number % across), f64::from(number / across), 0.0);
            instances.push(instance(size, at));
        }
        let mut scene = scene(&[("rock", 0.3)]);
        scene["geometry"]["placed"]["instances"] = json!(instances);
        let wide = 100.0 * f64::from(across);
        scene["geometry"]["placed"]["domain"] =
            json!({"min_um": [0, 0], "max_um": [wide, wide], "sides": "mirror"});
        Stage::new(setting, scene, &column).run()
    };
    let wide = [90, 91, 92].map(|draw| of_columns(32, draw));
    let mut truth = 0.0;
    for outcome in wide {
        truth += outcome?.bands[0].emissivity.mean / 3.0;
    }
    let draws = if setting.quick { 3 } else { 8 };
    let mut points = Vec::new();
    for across in setting.of(&[1, 2, 3, 4, 6, 8, 12, 16, 24]) {
        let mut squares = 0.0;
        let mut last = None;
        for draw in 0..draws {
            let outcome = of_columns(across, u64::from(across) << 8 | draw)?;
            squares += (outcome.bands[0].emissivity.mean - truth).powi(2) / draws as f64;
            last = Some(outcome);
        }
        let outcome = last.expect("there is one");
        points.push(outcome.with_error(
            f64::from(across),
            Some(squares.sqrt()),
            "packings differ by more",
        ));
    }
    Ok(Row {
        name: "narrow_patch",
        title: "A patch of few grains",
        swept: Swept { name: "columns of random height along a side of the patch", log: true },
        error: "emissivity less that of three patches of 32 x 32, root mean square over patches",
        does: "says of every single packing that its interval is that of the rays; warns below three bodies",
        points,
        left_out: None,
    })
}
