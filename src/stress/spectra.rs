//! Spectra of too few points, and particles that let light through.

use std::fmt::Write as _;

use glam::DVec3;
use serde_json::json;

use super::scenes::{Shape, Stage, scene};
use super::{Point, Row, Setting, Swept};
use crate::error::Error;
use crate::signature::Grid;
use crate::spectrum::Spectrum;

/// A flat plate whose spectrum is read from points of a shipped curve; the largest error within a window.
fn sampled(setting: &Setting, from_um: f64, to_um: f64) -> Result<Vec<Point>, Error> {
    let curve = Spectrum::builtin("quartz_coarse")?;
    let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| 1e3 * p);
    let mut plate = Shape { points: corners.to_vec(), ..Shape::default() };
    plate.face(&[0, 1, 2, 3], "quartz");
    let mut points = Vec::new();
    for step_um in setting.of(&[0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5]) {
        let mut file = "wavelength_um,emissivity\n".to_owned();
        let number = ((14.0 - 7.3) / step_um + 1e-9) as u32;
        for um in (0..=number).map(|i| 7.3 + step_um * f64::from(i)) {
            let _ = writeln!(file, "{um:.4},{:.7}", curve.emissivity((um * 1e4).round() / 1e4)?);
        }
        let mut scene = scene(&[("quartz", 0.0)]);
        scene["materials"][0]["spectrum"] = json!({"file": "quartz.csv"});
        let mut stage = Stage::new(setting, scene, &plate);
        stage.files.push(("quartz.csv", file));
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
