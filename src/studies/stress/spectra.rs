//! Spectra of too few points, and particles that are not opaque.

use serde_json::json;

use super::shape::Shape;
use super::stage::{Stage, band_at, scene};
use super::{Measured, Point, Setting};
use crate::scene::Grid;
use crate::spectrum::optics::hemispherical_mean;
use crate::spectrum::{Spectrum, crystal};
use crate::support::csv::{Csv, decimals};
use crate::support::error::Error;

/// The edge between the Christiansen maximum and the reststrahlen bands.
pub(super) fn christiansen_sampling(setting: &Setting) -> Result<Vec<Point>, Error> {
    sampled(setting, 7.3, 7.9)
}

/// The reststrahlen doublet.
pub(super) fn reststrahlen_sampling(setting: &Setting) -> Result<Vec<Point>, Error> {
    sampled(setting, 8.0, 9.5)
}

/// A flat plate whose spectrum is read from points of a shipped curve: its largest error in a
/// range.
fn sampled(setting: &Setting, from_um: f64, to_um: f64) -> Result<Vec<Point>, Error> {
    let curve = Spectrum::builtin("quartz_coarse")?;
    let plate = Shape::plate(0.0, 1e3, "quartz");
    let steps_um = [0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5];
    setting.sweep(&steps_um, "too far apart", |step_um| {
        let mut file = Csv::new(&["wavelength_um", "emissivity"]);
        let number = ((14.0 - 7.3) / step_um + 1e-9) as u32;
        for um in (0..=number).map(|i| 7.3 + step_um * f64::from(i)) {
            let emissivity = curve.emissivity((um * 1e4).round() / 1e4)?;
            file.row([format!("{um:.4}"), decimals(emissivity)]);
        }
        let mut scene = scene(&[("quartz", 0.0)]);
        scene["materials"][0]["spectrum"] = json!({"file": "quartz.csv"});
        let mut stage = Stage::new(setting, scene, &plate);
        stage.files.push(("quartz.csv", file.text().into_bytes()));
        stage.grid = Grid::new(from_um, to_um, 0.01).expect("a grid");
        let outcome = stage.run()?;
        let mut worst = 0.0_f64;
        for band in &outcome.bands {
            worst = worst.max((band.emissivity.mean - curve.emissivity(band.wavelength_um)?).abs());
        }
        let claimed = stage.target.tolerance / 2.0;
        Ok(Measured { claimed, ..outcome.with_error(Some(worst)) })
    })
}

/// Spheres of quartz, from transparent to opaque.
///
/// Every hit inside a sphere has the angle of the first one. So the absorbed share of a ray is
/// (1 - R) (1 - t) / (1 - R t), where t is the transmittance of one chord.
pub(super) fn not_opaque(setting: &Setting) -> Result<Vec<Point>, Error> {
    const UM: f64 = 11.0;
    let quartz = crystal("quartz")?;
    let refraction = quartz.axes.each()[0].1.index(UM).re;
    let absorbed = |diameter_um: f64| {
        hemispherical_mean(|cosine| {
            let sine = (1.0 - cosine * cosine).sqrt();
            let chord_um = diameter_um * (1.0 - (sine / refraction).powi(2)).max(0.0).sqrt();
            let r = quartz.reflectance(UM, cosine);
            let t = quartz.transmittance(UM, chord_um);
            (1.0 - r) * (1.0 - t) / (1.0 - r * t)
        })
    };
    let diameters_um = [
        5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0, 125.0, 150.0, 175.0, 200.0, 250.0, 300.0, 500.0,
        1000.0, 3000.0,
    ];
    setting.sweep(&diameters_um, "do not hold at", |diameter_um| {
        let sphere = Shape::sphere(4, "quartz").scaled(diameter_um / 2.0);
        let mut scene = scene(&[("quartz", 0.0)]);
        scene["materials"][0]["spectrum"] = json!({"fresnel": "quartz"});
        let stage = Stage { grid: band_at(UM), ..Stage::new(setting, scene, &sphere) };
        let claimed = stage.target.tolerance / 2.0;
        Ok(Measured { claimed, ..stage.run()?.against(absorbed(diameter_um)) })
    })
}
