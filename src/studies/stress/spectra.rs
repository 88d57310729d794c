//! Spectra of too few points, and particles that let light through.

use glam::DVec3;
use serde_json::json;

use super::scenes::{Shape, Stage, scene};
use super::{Point, Row, Setting, Swept};
use crate::scene::Grid;
use crate::spectrum::optics::hemispherical_mean;
use crate::spectrum::{Spectrum, crystal};
use crate::support::csv::{Csv, decimals};
use crate::support::error::Error;

/// A flat plate whose spectrum is read from points of a shipped curve; the largest error within a window.
fn sampled(setting: &Setting, from_um: f64, to_um: f64) -> Result<Vec<Point>, Error> {
    let curve = Spectrum::builtin("quartz_coarse")?;
    let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| 1e3 * p);
    let mut plate = Shape { points: corners.to_vec(), ..Shape::default() };
    plate.face(&[0, 1, 2, 3], "quartz");
    let mut points = Vec::new();
    for step_um in setting.of(&[0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5]) {
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
        let point = outcome.with_error(step_um, Some(worst), "too far apart");
        points.push(Point { claimed: stage.target.tolerance / 2.0, ..point });
    }
    Ok(points)
}

const ERROR: &str = "largest error of emissivity in steps of .01 um, against the curve that the points were taken from; \
                     the tolerance is allowed";
const DOES: &str = "judges by how a point differs from the straight line between its neighbours; warns with the error \
                    and the place";

/// The edge between the Christiansen maximum and the reststrahlen bands.
pub(super) fn christiansen_sampling(setting: &Setting) -> Result<Row, Error> {
    Ok(Row {
        name: "christiansen_sampling",
        title: "Points of a spectrum too far apart: Christiansen edge",
        swept: Swept { name: "step of the spectrum's points, 7.3-7.9 um, um", log: true },
        error: ERROR,
        does: DOES,
        points: sampled(setting, 7.3, 7.9)?,
        left_out: None,
    })
}

/// The reststrahlen doublet.
pub(super) fn reststrahlen_sampling(setting: &Setting) -> Result<Row, Error> {
    Ok(Row {
        name: "reststrahlen_sampling",
        title: "Points of a spectrum too far apart: reststrahlen bands",
        swept: Swept { name: "step of the spectrum's points, 8-9.5 um, um", log: true },
        error: ERROR,
        does: DOES,
        points: sampled(setting, 8.0, 9.5)?,
        left_out: None,
    })
}

/// Spheres of quartz, from those that light goes through to those that swallow it.
///
/// Every hit within a sphere is at the angle of the first, so that what is absorbed of a ray is
/// (1 - R) (1 - t) / (1 - R t), t being what one chord lets through.
pub(super) fn not_opaque(setting: &Setting) -> Result<Row, Error> {
    const UM: f64 = 11.0;
    let quartz = crystal("quartz")?;
    let refraction = quartz.ordinary.index(UM).re;
    let absorbed = |diameter_um: f64| {
        hemispherical_mean(|cosine| {
            let sine = (1.0 - cosine * cosine).sqrt();
            let chord_um = diameter_um * (1.0 - (sine / refraction).powi(2)).max(0.0).sqrt();
            let r = quartz.reflectance(UM, cosine);
            let t = quartz.transmittance(UM, chord_um);
            (1.0 - r) * (1.0 - t) / (1.0 - r * t)
        })
    };
    let mut points = Vec::new();
    for diameter_um in setting.of(&[
        5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0, 125.0, 150.0, 175.0, 200.0, 250.0, 300.0, 500.0,
        1000.0, 3000.0,
    ]) {
        let mut sphere = Shape::sphere(4, "quartz");
        for point in &mut sphere.points {
            *point *= diameter_um / 2.0;
        }
        let mut scene = scene(&[("quartz", 0.0)]);
        scene["materials"][0]["spectrum"] = json!({"fresnel": "quartz"});
        let mut stage = Stage::new(setting, scene, &sphere);
        stage.grid = Grid::new(UM, UM, 1.0).expect("a grid");
        let outcome = stage.run()?;
        let point = outcome.point(diameter_um, absorbed(diameter_um), "do not hold at");
        points.push(Point { claimed: stage.target.tolerance / 2.0, ..point });
    }
    Ok(Row {
        name: "not_opaque",
        title: "Particles that let light through (Fresnel facets)",
        swept: Swept { name: "diameter of a sphere of quartz, um", log: true },
        error: "emissivity less the closed form with what goes through and is reflected within, at 11 um; the tolerance is \
                allowed",
        does: "marks the bands as not valid in the CSV and the chart, and names them",
        points,
        left_out: None,
    })
}
