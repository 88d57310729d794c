//! Eq. 2 and the weights of paths, where they fail.

use glam::DVec3;
use serde_json::json;

use super::scenes::{Shape, Stage, scene};
use super::{Point, Row, Setting, Swept};
use crate::error::Error;
use crate::radiance;
use crate::signature::Band;

/// Emissivity by Eq. 2 of a band's radiance, which a radiometer reads wrong by a share.
fn by_eq_2(band: &Band, wrong: f64) -> f64 {
    let l_target = band.l_target * (1.0 + wrong);
    radiance::emissivity(l_target, band.l_blackbody, band.l_downwelling)
}

/// A flat plate of emissivity .6, whose radiance is read .1 % too high.
pub(super) fn sky_nears_target(setting: &Setting) -> Result<Row, Error> {
    let plate = plate();
    let mut points = Vec::new();
    for sky_k in setting.of(&[
        100.0, 150.0, 200.0, 220.0, 240.0, 250.0, 260.0, 265.0, 270.0, 275.0, 280.0, 285.0, 290.0,
        295.0, 298.0, 299.0, 300.0, 301.0, 302.0, 305.0, 310.0, 315.0, 320.0, 330.0, 340.0,
    ]) {
        let mut scene = scene(&[("rock", 0.6)]);
        scene["sky_temperature_k"] = json!(sky_k);
        let outcome = Stage::new(setting, scene, &plate).run()?;
        // A sky as bright as the target leaves a division of something by nothing.
        let error = (by_eq_2(&outcome.bands[0], 1e-3) - 0.6).abs().min(1e3);
        let said = outcome.said("Eq. 2 amplifies");
        points.push(Point {
            x: sky_k,
            error: Some(error),
            claimed: 0.005,
            said,
            status: outcome.status,
        });
    }
    Ok(Row {
        name: "sky_nears_target",
        title: "Eq. 2 under a sky that nears the target (300 K)",
        swept: Swept { name: "sky, K", log: false },
        error: "emissivity by Eq. 2 of a radiance read .1 % too high, less the plate's .6, at 9 um; .01 is allowed",
        does: "warns with the amplification and the band; emissivity itself does not come from Eq. 2",
        points,
        left_out: None,
    })
}

fn plate() -> Shape {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| 1e3 * p);
    let mut plate = Shape { points: corners.to_vec(), ..Shape::default() };
    plate.face(&[0, 1, 2, 3], "rock");
    plate
}

/// The plate under a sky of 270 K, its temperature taken for another one.
pub(super) fn target_temperature(setting: &Setting) -> Result<Row, Error> {
    let mut points = Vec::new();
    let mut scene = scene(&[("rock", 0.6)]);
    scene["sky_temperature_k"] = json!(270.0);
    let outcome = Stage::new(setting, scene, &plate()).run()?;
    let band = outcome.bands[0];
    for wrong_k in
        setting.of(&[-10.0, -5.0, -2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
    {
        let l_blackbody = radiance::planck(9.0, 300.0 + wrong_k);
        let emissivity = radiance::emissivity(band.l_target, l_blackbody, band.l_downwelling);
        points.push(Point {
            x: wrong_k,
            error: Some((emissivity - 0.6).abs()),
            claimed: 0.005,
            said: None,
            status: 0,
        });
    }
    Ok(Row {
        name: "target_temperature",
        title: "Eq. 2 with a wrong temperature of the target",
        swept: Swept { name: "temperature taken less that of the target, K", log: false },
        error: "emissivity by Eq. 2, less the plate's .6, sky 270 K, at 9 um",
        does: "",
        points,
        left_out: None,
    })
}

/// A pit whose floor and walls differ in temperature.
pub(super) fn two_temperatures(setting: &Setting) -> Result<Row, Error> {
    let pit = Shape::pit(DVec3::splat(1e3), "floor", "walls");
    let mut points = Vec::new();
    for warmer_k in setting.of(&[0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0]) {
        let mut scene = scene(&[("floor", 0.6), ("walls", 0.6)]);
        scene["materials"][1]["temperature_k"] = json!(300.0 + warmer_k);
        let outcome = Stage::new(setting, scene, &pit).run()?;
        let band = &outcome.bands[0];
        let error = (by_eq_2(band, 0.0) - band.emissivity.mean).abs();
        points.push(outcome.with_error(warmer_k, Some(error), "Eq. 2 does not return"));
    }
    Ok(Row {
        name: "two_temperatures",
        title: "Eq. 2 on a pit of two temperatures",
        swept: Swept { name: "walls warmer than the floor by, K", log: false },
        error: "emissivity by Eq. 2 at the scene's temperature, less that of the pit, at 9 um",
        does: "emissivity is counted by paths and stays right; warns with what Eq. 2 would give",
        points,
        left_out: None,
    })
}

/// A pit under a sky that is warmer towards the horizon.
pub(super) fn sky_by_zenith(setting: &Setting) -> Result<Row, Error> {
    let pit = Shape::pit(DVec3::splat(1e3), "rock", "rock");
    let mut points = Vec::new();
    for warmer_k in setting.of(&[0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0]) {
        let mut scene = scene(&[("rock", 0.3)]);
        scene["sky_temperature_k"] = json!([
            {"zenith_deg": 0, "temperature_k": 220.0},
            {"zenith_deg": 90, "temperature_k": 220.0 + warmer_k}
        ]);
        let outcome = Stage::new(setting, scene, &pit).run()?;
        let band = &outcome.bands[0];
        let error = (by_eq_2(band, 0.0) - band.emissivity.mean).abs();
        points.push(outcome.with_error(warmer_k, Some(error), "Eq. 2 does not return"));
    }
    Ok(Row {
        name: "sky_by_zenith",
        title: "Eq. 2 in a pit under a sky by zenith angle (220 K above)",
        swept: Swept { name: "horizon warmer than the zenith by, K", log: false },
        error: "emissivity by Eq. 2 with the sky of a flat surface, less that of the pit, at 9 um",
        does: "emissivity is counted by paths and stays right; warns with what Eq. 2 would give",
        points,
        left_out: None,
    })
}

/// A spherical cavity, all but closed, as its wall turns white: paths are caught for ever.
pub(super) fn white_cavity(setting: &Setting) -> Result<Row, Error> {
    let open = 0.02;
    let cavity = scaled(Shape::cavity(open, if setting.quick { 64 } else { 96 }, "wall"), 1e3);
    let mut points = Vec::new();
    for reflectance in setting.of(&[0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 1.0]) {
        let e: f64 = 1.0 - reflectance;
        let mut stage = Stage::new(setting, scene(&[("wall", e)]), &cavity);
        stage.target.max_paths = 1 << 14;
        let outcome = stage.run()?;
        let closed_form = if e > 0.0 { e / (e * (1.0 - open) + open) } else { 0.0 };
        points.push(outcome.point(reflectance, closed_form, "reflectances are near 1"));
    }
    Ok(Row {
        name: "white_cavity",
        title: "Reflectance towards 1 in a cavity 2 % open",
        swept: Swept { name: "reflectance of the wall", log: false },
        error: "emissivity of the opening, less e / (e (1 - s) + s)",
        does: "counts half of what paths given up after 128 hits may carry, widens the interval by the other half; \
               status 4",
        points,
        left_out: None,
    })
}

fn scaled(mut shape: Shape, scale: f64) -> Shape {
    for point in &mut shape.points {
        *point *= scale;
    }
    shape
}
