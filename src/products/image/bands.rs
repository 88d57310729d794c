//! The bands of an image, and the wavelengths at which it is evaluated for them.

use std::path::Path;

use crate::scene::{Grid, Sensor, SensorBands};
use crate::spectrum::bands::Band;
use crate::spectrum::resample::Response;
use crate::support::error::Error;

pub(super) use crate::spectrum::bands::Bands;

/// The sensor's bands, else the wavelengths of the grid. Files are relative to `folder`.
pub(super) fn bands(sensor: Option<&Sensor>, folder: &Path, grid: &Grid) -> Result<Bands, Error> {
    let bands = match sensor.and_then(|sensor| sensor.bands.as_ref()) {
        None => grid.wavelengths_um().into_iter().map(Band::At).collect(),
        Some(bands) => of_sensor(bands, folder)?,
    };
    Ok(Bands::new(&bands)?)
}

fn of_sensor(bands: &[SensorBands], folder: &Path) -> Result<Vec<Band>, Error> {
    let mut all = Vec::new();
    for band in bands {
        match *band {
            SensorBands::Box { centre_um, width_um: 0.0 } => all.push(Band::At(centre_um)),
            SensorBands::Box { centre_um, width_um } => {
                let (from_um, to_um) = (centre_um - width_um / 2.0, centre_um + width_um / 2.0);
                all.push(Band::Over(Response::boxed(from_um, to_um), width_um));
            }
            SensorBands::Gaussian { centre_um, fwhm_um } => {
                all.push(Band::Over(Response::gaussian(centre_um, fwhm_um), fwhm_um));
            }
            SensorBands::File(ref file) => {
                let response = Response::read(&folder.join(file))?;
                let width_um = response.width_um();
                all.push(Band::Over(response, width_um));
            }
            SensorBands::Grid { from_um, to_um, step_um, fwhm_um } => {
                let grid = Grid::new(from_um, to_um, step_um).expect("the scene was checked");
                let band = |centre_um| Band::Over(Response::gaussian(centre_um, fwhm_um), fwhm_um);
                all.extend(grid.wavelengths_um().into_iter().map(band));
            }
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(bands: Vec<SensorBands>) -> Bands {
        let sensor = Sensor { pixels: [1, 1], bands: Some(bands), ..Sensor::default() };
        super::bands(Some(&sensor), Path::new(""), &Grid::PAPER).expect("sound bands")
    }

    #[test]
    fn bands_that_take_too_many_wavelengths_are_refused_before_they_are_made() {
        for (centre_um, width_um) in [(500.0, 900.0), (5e8, 9e8)] {
            let bands = Some(vec![SensorBands::Box { centre_um, width_um }]);
            let sensor = Sensor { pixels: [1, 1], bands, ..Sensor::default() };
            assert!(super::bands(Some(&sensor), Path::new(""), &Grid::PAPER).is_err());
        }
    }

    /// Means of um squared, which are known exactly.
    #[test]
    fn bands_weigh_a_curve_as_their_responses_ask() {
        let all = of(vec![
            SensorBands::Box { centre_um: 9.0, width_um: 0.5 },
            SensorBands::Gaussian { centre_um: 10.3, fwhm_um: 0.2 },
            SensorBands::Box { centre_um: 8.9371, width_um: 0.0 },
            SensorBands::Box { centre_um: 8.9371, width_um: 1e-7 },
            SensorBands::Grid { from_um: 8.0, to_um: 12.0, step_um: 0.5, fwhm_um: 0.03 },
        ]);
        assert_eq!(all.centres_um.len(), 13);
        let curve: Vec<f64> = all.nodes_um.iter().map(|um| um * um).collect();
        let sigma = |fwhm_um: f64| fwhm_um / (8.0 * std::f64::consts::LN_2).sqrt();
        let exact = [
            81.0 + 0.25 / 12.0,
            10.3 * 10.3 + sigma(0.2).powi(2),
            8.9371 * 8.9371,
            8.9371 * 8.9371,
        ];
        for (band, exact) in exact.into_iter().enumerate() {
            let mean = all.mean(band, &curve);
            // The Gaussian ends at 1e-4 of its maximum.
            assert!((mean - exact).abs() < 2e-5, "band {band}: {mean}, exact {exact}");
            let sum: f64 = all.weights[band].iter().map(|(_, weight)| weight).sum();
            assert!(
                (sum - 1.0).abs() < 1e-12 && (all.centres_um[band].powi(2) - exact).abs() < 0.1
            );
        }
        assert_eq!(all.centres_um[..3], [9.0, 10.3, 8.9371], "without errors of rounding");
        assert_eq!(all.widths_um[..5], [0.5, 0.2, 0.0, 1e-7, 0.03]);
        assert_eq!(all.weights[2].len(), 1, "a box of no width is a point");
        assert_eq!(all.nodes_um[all.weights[2][0].0], 8.9371);
        assert_eq!(all.nearest(10.06), 8, "that of the grid at 10");
    }
}
