//! Meshes, solids, views and patches.

use glam::DVec3;
use serde_json::{Value, json};

use super::counts::first;
use super::equations::cavity;
use super::shape::Shape;
use super::stage::{Outcome, Stage, band_at, scene, set_domain};
use super::{Measured, Point, Setting};
use crate::spectrum::Spectrum;
use crate::support::error::Error;
use crate::support::random::{Purpose, Source};
use crate::table::Target;

/// An instance of the mesh, scaled and shifted.
fn instance(scale: DVec3, at: DVec3) -> Value {
    json!({"prototype": "mesh", "transform": [
        scale.x, 0, 0, at.x, 0, scale.y, 0, at.y, 0, 0, scale.z, at.z
    ]})
}

/// A sphere whose mesh lacks some facets.
pub(super) fn holes(setting: &Setting) -> Result<Vec<Point>, Error> {
    let percents = [0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0];
    setting.sweep(&percents, "closed but for", |percent| {
        let mut sphere = Shape::sphere(4, "rock").scaled(500.0);
        let facets = sphere.faces.len();
        let missing = (percent / 100.0 * facets as f64).ceil() as usize;
        // 7919 is a prime: every facet comes once, and successive ones lie far apart.
        let mut numbers = 0..facets;
        sphere.faces.retain(|_| numbers.next().is_some_and(|i| i * 7919 % facets >= missing));
        Ok(setting.run(scene(&[("rock", 0.5)]), &sphere)?.against(0.5))
    })
}

/// Two spheres that pass through each other.
pub(super) fn overlap(setting: &Setting) -> Result<Vec<Point>, Error> {
    let sphere = Shape::sphere(5, "rock");
    let depths = [0.0, 0.002, 0.005, 0.01, 0.015, 0.03, 0.05, 0.1, 0.2, 0.3, 0.5];
    setting.sweep(&depths, "solids pass through", |depth| {
        let mut scene = scene(&[("rock", 0.5)]);
        let size = DVec3::splat(500.0);
        let aside = (1.0 - depth) * 500.0 * DVec3::X;
        scene["geometry"]["placed"]["instances"] =
            json!([instance(size, -aside), instance(size, aside)]);
        // Each sphere has a cap inside the other one, half as high as the depth.
        let inside = Some(depth / 2.0);
        Ok(Measured { claimed: 0.005, ..setting.run(scene, &sphere)?.with_error(inside) })
    })
}

/// A spherical cavity of few facets, whose file has the normals of the sphere.
pub(super) fn coarse_sphere(setting: &Setting) -> Result<Vec<Point>, Error> {
    let facets = [4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 24.0, 32.0, 48.0, 64.0, 96.0];
    setting.sweep(&facets, "curved surface", |around| {
        let (stage, closed_form) = cavity(setting, 0.1, around as usize, 0.5);
        Ok(stage.run()?.against(closed_form))
    })
}

/// An endless groove as deep as wide, seen along its length: all zenith angles give the same
/// result.
pub(super) fn grazing_view(setting: &Setting) -> Result<Vec<Point>, Error> {
    let (wide, long) = (100.0, 5.0);
    // The slab is longer than the domain, so that no side meets an edge.
    let mut slab = Shape::groove(wide, wide, [-wide, 2.0 * wide], [-long, 2.0 * long]);
    slab.points.iter_mut().for_each(|point| point.x += 0.5 * wide);
    let seen_from = |zenith_deg: f64, target: Target| {
        let mut scene = scene(&[("rock", 0.3)]);
        scene["view"] = json!({"zenith_deg": zenith_deg, "azimuth_deg": 90.0});
        set_domain(&mut scene, [0.0; 2], [2.0 * wide, long], "mirror");
        Stage { target, ..Stage::new(setting, scene, &slab) }.run()
    };
    let truth = seen_from(0.0, Target::of(0.003))?.emissivity();
    let zeniths_deg =
        [0.0, 20.0, 40.0, 60.0, 75.0, 80.0, 85.0, 87.0, 89.0, 89.5, 89.8, 89.87, 89.9];
    setting.sweep(&zeniths_deg, "were given up", |zenith_deg| {
        // A nearly horizontal ray crosses the sides thousands of times.
        let target = Target { exactly: Some(first(512)), ..Target::of(0.05) };
        Ok(seen_from(zenith_deg, target)?.against(truth))
    })
}

/// A flat floor of quartz that reflects like a mirror.
pub(super) fn grazing_mirror(setting: &Setting) -> Result<Vec<Point>, Error> {
    let plate = Shape::plate(-1e3, 3e3, "quartz");
    let quartz = Spectrum::fresnel("quartz")?;
    let zeniths_deg =
        [0.0, 30.0, 50.0, 60.0, 70.0, 75.0, 80.0, 83.0, 85.0, 86.0, 87.0, 88.0, 89.0, 89.5, 89.9];
    setting.sweep(&zeniths_deg, "bin of cosines", |zenith_deg| {
        let mut scene = scene(&[("quartz", 0.0)]);
        scene["materials"][0]["spectrum"] = json!({"fresnel": "quartz"});
        scene["view"]["zenith_deg"] = json!(zenith_deg);
        set_domain(&mut scene, [0.0; 2], [1e3; 2], "mirror");
        let stage = Stage { grid: band_at(11.0), ..Stage::new(setting, scene, &plate) };
        let truth = 1.0 - quartz.reflectance_at(11.0, zenith_deg.to_radians().cos())?;
        let claimed = stage.target.tolerance / 2.0;
        Ok(Measured { claimed, ..stage.run()?.against(truth) })
    })
}

/// Layers of bright spheres on a black floor.
pub(super) fn shallow_bed(setting: &Setting) -> Result<Vec<Point>, Error> {
    let sphere = Shape::sphere(if setting.quick { 2 } else { 3 }, "grain");
    let (radius, cell) = (100.0, 230.0);
    let of_layers = |layers: u32| -> Result<Outcome, Error> {
        let mut instances = Vec::new();
        for layer in 0..layers {
            // Counted from above, so that the top layer is always the same.
            let z = radius * (1.0 + 1.7 * f64::from(layers - 1 - layer));
            // Four kinds of layers, so that no straight line leads down between the spheres.
            let corners: &[(f64, f64)] = match layer % 4 {
                0 => &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)],
                1 => &[(0.5, 0.5)],
                2 => &[(0.5, 0.0), (0.5, 1.0)],
                _ => &[(0.0, 0.5), (1.0, 0.5)],
            };
            let places = corners.iter().map(|(x, y)| DVec3::new(x * cell, y * cell, z));
            instances.extend(places.map(|place| instance(DVec3::splat(radius), place)));
        }
        let mut scene = scene(&[("grain", 0.3), ("floor", 1.0)]);
        set_domain(&mut scene, [0.0; 2], [cell; 2], "mirror");
        let placed = &mut scene["geometry"]["placed"];
        placed["instances"] = json!(instances);
        placed["domain"]["floor"] = json!({"z_um": 0, "material": "floor"});
        setting.run(scene, &sphere)
    };
    let truth = of_layers(16)?.emissivity();
    let numbers = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0];
    setting.sweep(&numbers, "the floor shows", |n| Ok(of_layers(n as u32)?.against(truth)))
}

/// A patch of few columns of random height, within mirrors.
pub(super) fn narrow_patch(setting: &Setting) -> Result<Vec<Point>, Error> {
    let column = Shape::block(DVec3::ZERO, DVec3::ONE, "rock");
    let source = Source::new(5, Purpose::Packing);
    let of_columns = |across: u32, draw: u64| -> Result<Outcome, Error> {
        let columns = (0..across * across).map(|number| {
            let [height, _] = source.stream(draw << 32 | u64::from(number)).pair();
            let size = DVec3::new(100.0, 100.0, 20.0 + 280.0 * height);
            let (x, y) = (number % across, number / across);
            instance(size, 100.0 * DVec3::new(f64::from(x), f64::from(y), 0.0))
        });
        let mut scene = scene(&[("rock", 0.3)]);
        set_domain(&mut scene, [0.0; 2], [100.0 * f64::from(across); 2], "mirror");
        scene["geometry"]["placed"]["instances"] = columns.collect();
        setting.run(scene, &column)
    };
    let mut truth = 0.0;
    for draw in [90, 91, 92] {
        truth += of_columns(32, draw)?.emissivity() / 3.0;
    }
    let draws = if setting.quick { 3 } else { 8 };
    let numbers = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0];
    setting.sweep(&numbers, "packings differ by more", |across| {
        let across = across as u32;
        let drawn = (0..draws).map(|draw| of_columns(across, u64::from(across) << 8 | draw));
        let mut outcomes = drawn.collect::<Result<Vec<_>, _>>()?;
        let squares = outcomes.iter().map(|outcome| (outcome.emissivity() - truth).powi(2));
        let error = (squares.sum::<f64>() / draws as f64).sqrt();
        Ok(outcomes.pop().expect("there are several").with_error(Some(error)))
    })
}
