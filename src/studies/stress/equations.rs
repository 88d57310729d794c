//! Eq. 2 and the weights of paths, where they fail.

use std::fmt::Write as _;

use glam::DVec3;
use serde_json::json;

use super::scenes::{Shape, Stage, scene, under_the_opening};
use super::{Point, Row, Setting, Swept};
use crate::products::retrieve::{self, Known, Sky, Target};
use crate::radiometry::{Assumed, Retrieved, Temperature};
use crate::scene::Grid;
use crate::signature::Band;
use crate::support::error::Error;
use crate::support::output::{self, OutputError};

/// Radiance of a plate as a radiometer that is good to .1 % reads it: that much too high, with that standard error.
fn file_of_radiance(bands: &[Band]) -> String {
    let mut text =
        "wavelength_um,radiance_w_m2_sr_um,radiance_standard_error_w_m2_sr_um\n".to_owned();
    for band in bands {
        let l = band.l_target.mean;
        let _ = writeln!(text, "{},{:e},{:e}", band.wavelength_um, l * 1.001, l * 1e-3);
    }
    text
}

/// What `soilsig retrieve` makes of it under a grey sky, for a target of that temperature: the error of the emissivity at 9 um
/// and what is claimed for it, unless it is masked, and what is said.
fn retrieved(
    bands: &[Band],
    sky_k: f64,
    taken_for_k: f64,
    words: &str,
) -> Result<(Option<f64>, f64, Option<String>), Error> {
    let file = tempfile::NamedTempFile::new()
        .map_err(|source| OutputError { path: std::env::temp_dir(), source })?;
    output::bytes(file.path(), file_of_radiance(bands).as_bytes())?;
    let known = Known {
        sky: Sky::Grey(sky_k),
        atmosphere: None,
        target: Target::Given(Temperature { k: taken_for_k, error_k: 0.0 }),
        assumed: Assumed::EXACT,
    };
    let spectrum = retrieve::spectrum(file.path(), None, &known)?;
    let said = spectrum.in_words(&known);
    let said = said.lines().find(|line| line.contains(words)).map(str::to_owned);
    let at = bands.iter().position(|band| band.wavelength_um == 9.0).expect("9 um is a band");
    let found = spectrum.retrieved[at].emissivity;
    let error = found.map(|[e, _]| (e - bands[at].emissivity.mean).abs());
    // 95 %, as everywhere.
    Ok((error, found.map_or(f64::NAN, |[_, error]| 1.96 * error), said))
}

fn plate(material: &'static str) -> Shape {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| 1e3 * p);
    let mut plate = Shape { points: corners.to_vec(), ..Shape::default() };
    plate.face(&[0, 1, 2, 3], material);
    plate
}

/// A flat plate of emissivity .6, whose radiance is read .1 % too high.
pub(super) fn sky_nears_target(setting: &Setting) -> Result<Row, Error> {
    let plate = plate("rock");
    let mut points = Vec::new();
    for sky_k in setting.of(&[
        100.0, 150.0, 200.0, 220.0, 240.0, 250.0, 260.0, 265.0, 270.0, 275.0, 280.0, 285.0, 290.0,
        295.0, 298.0, 299.0, 300.0, 301.0, 302.0, 305.0, 310.0, 315.0, 320.0, 330.0, 340.0,
    ]) {
        let mut scene = scene(&[("rock", 0.6)]);
        scene["sky_temperature_k"] = json!(sky_k);
        let outcome = Stage::new(setting, scene, &plate).run()?;
        let (error, claimed, said) =
            retrieved(&outcome.bands, sky_k, 300.0, "Eq. 2 gives no emissivity")?;
        points.push(Point { x: sky_k, error, claimed, said, status: outcome.status });
    }
    Ok(Row {
        name: "sky_nears_target",
        title: "Eq. 2 under a sky that nears the target (300 K) and passes it",
        swept: Swept { name: "sky, K", log: false },
        error: "emissivity by Eq. 2 of a radiance read .1 % too high, with that standard error, less the plate's .6, at 9 um",
        does: "widens the error with the amplification; masks bands beyond 10 times, and names them",
        points,
        left_out: None,
    })
}

/// A plate of coarse quartz under a sky of 270 K, its temperature taken for another one.
pub(super) fn target_temperature(setting: &Setting) -> Result<Row, Error> {
    let mut scene = scene(&[("quartz", 0.0)]);
    scene["sky_temperature_k"] = json!(270.0);
    scene["materials"][0]["spectrum"] = json!({"builtin": "quartz_coarse"});
    let mut stage = Stage::new(setting, scene, &plate("quartz"));
    stage.grid = Grid::new(7.3, 12.0, 0.02).expect("a grid");
    let outcome = stage.run()?;
    let mut points = Vec::new();
    for wrong_k in
        setting.of(&[-10.0, -5.0, -2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
    {
        let words = "where quartz is black";
        let (error, claimed, said) = retrieved(&outcome.bands, 270.0, 300.0 + wrong_k, words)?;
        points.push(Point { x: wrong_k, error, claimed, said, status: 0 });
    }
    Ok(Row {
        name: "target_temperature",
        title: "Eq. 2 with a wrong temperature of the target",
        swept: Swept { name: "temperature taken less the target's, K", log: false },
        error: "emissivity of quartz by Eq. 2, its radiance good to .1 %, at 9 um, sky 270 K",
        does: "compares with the brightness temperature at 7.36 um, where quartz is black, and says what it is if it is quartz; \
               counts bands outside 0 to 1",
        points,
        left_out: None,
    })
}

/// What Eq. 2 gives at the scene's temperature, less the emissivity.
fn off_by_eq_2(band: &Band) -> Option<f64> {
    let temperature = Temperature { k: 300.0, error_k: 0.0 };
    let [e, _] = Retrieved::new(&band.measured(), temperature, Assumed::EXACT).emissivity?;
    Some((e - band.emissivity.mean).abs())
}

const NOT_EXACT: &str = "Eq. 2 is not exact";
const STAYS_RIGHT: &str = "emissivity is counted by paths and stays right; says that Eq. 2 is not exact, why, and by how much";

/// A pit whose floor and walls differ in temperature.
pub(super) fn two_temperatures(setting: &Setting) -> Result<Row, Error> {
    let pit = Shape::pit(DVec3::splat(1e3), "floor", "walls");
    let mut points = Vec::new();
    for warmer_k in setting.of(&[0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0]) {
        let mut scene = scene(&[("floor", 0.6), ("walls", 0.6)]);
        scene["materials"][1]["temperature_k"] = json!(300.0 + warmer_k);
        let outcome = Stage::new(setting, scene, &pit).run()?;
        points.push(outcome.with_error(warmer_k, off_by_eq_2(&outcome.bands[0]), NOT_EXACT));
    }
    Ok(Row {
        name: "two_temperatures",
        title: "Eq. 2 on a pit of two temperatures",
        swept: Swept { name: "walls warmer than the floor (300 K) by, K", log: false },
        error: "emissivity by Eq. 2 at 300 K, less that of the pit, at 9 um",
        does: STAYS_RIGHT,
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
        points.push(outcome.with_error(warmer_k, off_by_eq_2(&outcome.bands[0]), NOT_EXACT));
    }
    Ok(Row {
        name: "sky_by_zenith",
        title: "Eq. 2 in a pit under a sky by zenith angle (220 K above)",
        swept: Swept { name: "horizon warmer than the zenith by, K", log: false },
        error: "emissivity by Eq. 2 with the sky of a flat surface, less that of the pit, at 9 um",
        does: STAYS_RIGHT,
        points,
        left_out: None,
    })
}

/// A spherical cavity, all but closed, as its wall turns white: paths are caught for ever.
pub(super) fn white_cavity(setting: &Setting) -> Result<Row, Error> {
    let open = 0.02;
    let mut cavity = Shape::cavity(open, if setting.quick { 64 } else { 96 }, "wall");
    for point in &mut cavity.points {
        *point *= 500.0;
    }
    let mut points = Vec::new();
    for reflectance in setting.of(&[0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 1.0]) {
        let e: f64 = 1.0 - reflectance;
        let mut scene = scene(&[("wall", e)]);
        scene["geometry"]["placed"]["domain"] = under_the_opening(open, 500.0);
        let mut stage = Stage::new(setting, scene, &cavity);
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
