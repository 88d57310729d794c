//! Eq. 2 and the weights of paths, where they fail.

use std::fmt::Write as _;

use glam::DVec3;
use serde_json::json;

use super::shape::{Shape, within_opening};
use super::stage::{Outcome, Stage, scene, set_domain};
use super::{Measured, Point, Setting};
use crate::products::retrieve::{self, Known, Sky, Target};
use crate::radiometry::{Assumed, Retrieved, Temperature};
use crate::scene::Grid;
use crate::signature::Band;
use crate::support::error::Error;
use crate::support::output;
use crate::support::scratch::Scratch;

/// The error at 9 um of `soilsig retrieve` under a grey sky for an assumed temperature of the
/// target. The radiance is .1 % too high, and its standard error is .1 %. A masked band has no
/// error.
fn retrieved(bands: &[Band], sky_k: f64, assumed_k: f64) -> Result<Measured, Error> {
    let folder = Scratch::temporary()?;
    let path = folder.path().join("radiance.csv");
    let mut text =
        "wavelength_um,radiance_w_m2_sr_um,radiance_standard_error_w_m2_sr_um\n".to_owned();
    for band in bands {
        let l = band.l_target.mean;
        let _ = writeln!(text, "{},{:e},{:e}", band.wavelength_um, l * 1.001, l * 1e-3);
    }
    output::scratch(&path, text)?;
    let known = Known {
        sky: Sky::Grey(sky_k),
        atmosphere: None,
        target: Target::Given(Temperature { k: assumed_k, error_k: 0.0 }),
        assumed: Assumed { pure_quartz: true, ..Assumed::EXACT },
    };
    let spectrum = retrieve::spectrum(&path, None, &known)?;
    let said = spectrum.in_words(&known).lines().map(str::to_owned).collect();
    let at = bands.iter().position(|band| band.wavelength_um == 9.0).expect("9 um is a band");
    let found = spectrum.retrieved[at].emissivity;
    Ok(Measured {
        error: found.map(|[e, _]| (e - bands[at].emissivity.mean).abs()),
        // Two-sided 95 % of a normal distribution.
        claimed: found.map_or(f64::NAN, |[_, error]| 1.96 * error),
        said,
        status: 0,
    })
}

/// A flat plate of emissivity .6.
pub(super) fn sky_nears_target(setting: &Setting) -> Result<Vec<Point>, Error> {
    let plate = Shape::plate(0.0, 1e3, "rock");
    let skies_k = [
        100.0, 150.0, 200.0, 220.0, 240.0, 250.0, 260.0, 265.0, 270.0, 275.0, 280.0, 285.0, 290.0,
        295.0, 298.0, 299.0, 300.0, 301.0, 302.0, 305.0, 310.0, 315.0, 320.0, 330.0, 340.0,
    ];
    setting.sweep(&skies_k, "it amplifies errors", |sky_k| {
        let mut scene = scene(&[("rock", 0.6)]);
        scene["sky_temperature_k"] = json!(sky_k);
        retrieved(&setting.run(scene, &plate)?.bands, sky_k, 300.0)
    })
}

/// A plate of coarse quartz under a sky of 270 K.
pub(super) fn target_temperature(setting: &Setting) -> Result<Vec<Point>, Error> {
    let mut scene = scene(&[("quartz", 0.0)]);
    scene["sky_temperature_k"] = json!(270.0);
    scene["materials"][0]["spectrum"] = json!({"builtin": "quartz_coarse"});
    let mut stage = Stage::new(setting, scene, &Shape::plate(0.0, 1e3, "quartz"));
    stage.grid = Grid::new(7.3, 12.0, 0.02).expect("a grid");
    let bands = stage.run()?.bands;
    let wrong_k = [-10.0, -5.0, -2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
    setting.sweep(&wrong_k, "where the emissivity of quartz is nearly 1", |wrong_k| {
        retrieved(&bands, 270.0, 300.0 + wrong_k)
    })
}

const NOT_EXACT: &str = "Eq. 2 is not exact";

/// The error of Eq. 2 at 300 K.
fn by_eq_2(outcome: Outcome) -> Measured {
    let band = &outcome.bands[0];
    let temperature = Temperature { k: 300.0, error_k: 0.0 };
    let found = Retrieved::new(&band.measured(), temperature, Assumed::EXACT).emissivity;
    let error = found.map(|[e, _]| (e - band.emissivity.mean).abs());
    outcome.with_error(error)
}

/// A pit whose floor and walls differ in temperature.
pub(super) fn two_temperatures(setting: &Setting) -> Result<Vec<Point>, Error> {
    let pit = Shape::pit(DVec3::splat(1e3), "floor", "walls");
    let warmer_k = [0.0, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0];
    setting.sweep(&warmer_k, NOT_EXACT, |warmer_k| {
        let mut scene = scene(&[("floor", 0.6), ("walls", 0.6)]);
        scene["materials"][1]["temperature_k"] = json!(300.0 + warmer_k);
        Ok(by_eq_2(setting.run(scene, &pit)?))
    })
}

/// A pit under a sky that is warmer towards the horizon.
pub(super) fn sky_by_zenith(setting: &Setting) -> Result<Vec<Point>, Error> {
    let pit = Shape::pit(DVec3::splat(1e3), "rock", "rock");
    let warmer_k = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0];
    setting.sweep(&warmer_k, NOT_EXACT, |warmer_k| {
        let mut scene = scene(&[("rock", 0.3)]);
        scene["sky_temperature_k"] = json!([
            {"zenith_deg": 0, "temperature_k": 220.0},
            {"zenith_deg": 90, "temperature_k": 220.0 + warmer_k}
        ]);
        Ok(by_eq_2(setting.run(scene, &pit)?))
    })
}

/// The opening of a spherical cavity of radius 500 um, seen from above, and its closed form.
pub(super) fn cavity<'a>(
    setting: &Setting<'a>,
    open: f64,
    around: usize,
    e: f64,
) -> (Stage<'a>, f64) {
    let cavity = Shape::cavity(open, around, "wall").scaled(500.0);
    let mut scene = scene(&[("wall", e)]);
    let half = 500.0 * within_opening(open);
    set_domain(&mut scene, [-half; 2], [half; 2], "open");
    let closed_form = if e > 0.0 { e / (e * (1.0 - open) + open) } else { 0.0 };
    (Stage::new(setting, scene, &cavity), closed_form)
}

/// An almost closed cavity whose wall turns white: paths cannot escape.
pub(super) fn white_cavity(setting: &Setting) -> Result<Vec<Point>, Error> {
    let around = if setting.quick { 64 } else { 96 };
    let reflectances = [0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 1.0];
    setting.sweep(&reflectances, "reflectances are near 1", |reflectance| {
        let (mut stage, closed_form) = cavity(setting, 0.02, around, 1.0 - reflectance);
        stage.target.max_paths = 1 << 14;
        Ok(stage.run()?.against(closed_form))
    })
}
