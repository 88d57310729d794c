//! A signature as the bands of a sensor see it, with the total uncertainty of each value.
//!
//! Values are means weighted by the band's response. Wavelengths within a band err together, as in
//! the windows of a result.

use super::budget::Budget;
use super::window::{Beds, Window, weights_of_cells};
use super::{Levels, curves, evaluate};
use crate::radiometry::{brightness_temperature_k, planck, planck_derivative};
use crate::spectrum::bands::{Band, Bands};
use crate::spectrum::resample::Response;
use crate::spectrum::sensors::{Sensor, SensorBand};
use crate::support::csv::{Csv, decimals};
use crate::support::error::Error;
use crate::table::Table;

/// One band of a sensor. Half-widths are totals: 95 % intervals with the bounds of the budget.
#[derive(Debug, Clone, PartialEq)]
pub struct InBand {
    /// The sensor.
    pub sensor: String,
    /// The band.
    pub band: String,
    /// Centroid of its response, um.
    pub centre_um: f64,
    /// What it sees; `None` where spectra, sky or atmosphere do not hold the band.
    pub seen: Option<Seen>,
}

/// What a band sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Emissivity and its half-width.
    pub emissivity: [f64; 2],
    /// Radiance at the sensor, W m-2 sr-1 um-1, and its half-width.
    pub l_sensor: [f64; 2],
    /// Temperature of a black body with that radiance in this band, K, and its half-width; `None`
    /// if the radiance is not above 0.
    pub brightness_temperature_k: Option<[f64; 2]>,
    /// Whether the models of all facets hold in the whole band.
    pub valid: bool,
}

/// The columns, with their meanings.
pub(crate) const COLUMNS: [(&str, &str); 10] = [
    ("sensor", "Sensor."),
    ("band", "Name of the band."),
    ("centre_um", "Centroid of the response."),
    ("emissivity", "Emissivity, weighted by the response; empty where spectra miss the band."),
    ("emissivity_half_width_95", "Its total half-width: 95 % interval and bounds of the budget."),
    ("l_sensor_w_m2_sr_um", "Radiance at the sensor, weighted by the response."),
    ("l_sensor_half_width_95_w_m2_sr_um", "Its total half-width."),
    (
        "brightness_temperature_k",
        "Temperature of a black body with this radiance in the band, at the sensor.",
    ),
    ("brightness_temperature_half_width_95_k", "Its total half-width."),
    ("valid", "1 where the models of all facets hold in the whole band, else 0."),
];

/// The bands of a sensor, in its order.
///
/// # Errors
/// Spectra, sky or atmosphere hold none of the bands.
pub fn in_bands(packings: &[Table], sensor: &Sensor) -> Result<Vec<InBand>, Error> {
    let table = &packings[0];
    let holds = |response: &Response| table.lit(&response.span_um());
    let held: Vec<Result<_, Error>> =
        sensor.bands.iter().map(|band| holds(&band.response).map(|_| ())).collect();
    let responses = sensor.bands.iter().zip(&held).filter(|(_, held)| held.is_ok());
    let over = |band: &SensorBand| Band::Over(band.response.clone(), band.response.width_um());
    let responses: Vec<Band> = responses.map(|(band, _)| over(band)).collect();
    let mut seen = if responses.is_empty() {
        // Why the first band is not held.
        held.into_iter().collect::<Result<Vec<()>, Error>>()?;
        return Ok(Vec::new());
    } else {
        seen(packings, &Bands::new(&responses)?)?.into_iter()
    };
    let of_band = |(band, held): (&SensorBand, &Result<_, Error>)| InBand {
        sensor: sensor.name.clone(),
        band: band.name.clone(),
        centre_um: band.response.centre_um(),
        seen: if held.is_ok() { seen.next() } else { None },
    };
    Ok(sensor.bands.iter().zip(&held).map(of_band).collect())
}

fn seen(packings: &[Table], bands: &Bands) -> Result<Vec<Seen>, Error> {
    let um = &bands.nodes_um;
    let nodes = evaluate(packings, um)?;
    let budget = Budget::new(packings, &nodes)?;
    let curves = curves(packings, um)?;
    let levels = Levels::of(packings);
    let cells = weights_of_cells(packings, &levels, &packings[0].reflectances(um)?);
    let beds = Beds { levels: &levels, curves: &curves, cells: cells.as_deref() };
    // Only of one temperature and under an isotropic sky the error of the emissivity tells that of
    // the radiance.
    let is_linear = packings[0].eq_2_not_exact().is_empty();
    let of_band = |weights: &Vec<(usize, f64)>| {
        let over = |factor: &dyn Fn(usize) -> f64, values: &dyn Fn(usize) -> f64| {
            weights.iter().map(|&(node, share)| share * factor(node) * values(node)).sum::<f64>()
        };
        let total = |factor: &dyn Fn(usize) -> f64| {
            let mean = |values: &dyn Fn(usize) -> f64| Some(over(factor, values));
            let widths =
                |values: &dyn Fn(usize) -> f64| Some(over(&|node| factor(node).abs(), values));
            let span = [weights[0].0, weights[weights.len() - 1].0].map(|node| um[node]);
            Window::of(span, [&mean, &widths], beds, &budget.bands).expect("all nodes are there")
        };
        let window = total(&|_| 1.0);
        let l_mean = over(&|_| 1.0, &|node| nodes[node].l_sensor().mean);
        // What a change of the emissivity does to the radiance at the sensor.
        let contrast = |node: usize| {
            let band = &nodes[node];
            let transmittance = band.path.map_or(1.0, |(transmittance, _)| transmittance);
            transmittance * (band.l_blackbody - band.l_downwelling)
        };
        let by_emissivity = total(&contrast).half_width_95;
        let own = over(&|_| 1.0, &|node| nodes[node].l_sensor().half_width);
        let l_half_width = if is_linear { by_emissivity } else { by_emissivity.max(own) };
        let at = |of: &dyn Fn(f64) -> f64| over(&|_| 1.0, &|node| of(um[node]));
        let centre_um = at(&|um| um);
        let brightness = temperature(centre_um, l_mean, &at);
        Seen {
            emissivity: [window.emissivity, window.half_width_95],
            l_sensor: [l_mean, l_half_width],
            brightness_temperature_k: brightness
                .map(|k| [k, l_half_width / at(&|um| planck_derivative(um, k))]),
            valid: weights.iter().all(|&(node, _)| nodes[node].valid),
        }
    };
    Ok(bands.weights.iter().map(of_band).collect())
}

/// A band's mean of a function of wavelength.
type Mean<'a> = &'a dyn Fn(&dyn Fn(f64) -> f64) -> f64;

/// The temperature of a black body with that radiance in a band, K.
fn temperature(centre_um: f64, l: f64, at: Mean) -> Option<f64> {
    let mut k = brightness_temperature_k(centre_um, l)?;
    // Newton's steps from the temperature of one wavelength, which is near.
    for _ in 0..20 {
        let step = (l - at(&|um| planck(um, k))) / at(&|um| planck_derivative(um, k));
        k += step;
        if step.abs() < 1e-9 * k {
            break;
        }
    }
    Some(k)
}

impl InBand {
    /// The values of the columns behind the names.
    pub(crate) fn numbers(&self) -> [Option<f64>; COLUMNS.len() - 2] {
        let pair = |of: fn(&Seen) -> Option<[f64; 2]>| {
            let pair = self.seen.as_ref().and_then(of);
            [0, 1].map(|i| pair.map(|pair| pair[i]))
        };
        let [emissivity, of_emissivity] = pair(|seen| Some(seen.emissivity));
        let [l, of_l] = pair(|seen| Some(seen.l_sensor));
        let [k, of_k] = pair(|seen| seen.brightness_temperature_k);
        let valid = self.seen.map(|seen| f64::from(u8::from(seen.valid)));
        [Some(self.centre_um), emissivity, of_emissivity, l, of_l, k, of_k, valid]
    }
}

/// The bands of sensors as CSV.
pub fn csv_text(bands: &[InBand]) -> String {
    let mut csv = Csv::new(&COLUMNS.map(|(heading, _)| heading));
    for band in bands {
        let [centre, values @ .., valid] = band.numbers();
        let names = [band.sensor.clone(), band.band.clone()];
        let centre = format!("{:.4}", centre.expect("every band has one"));
        let valid = valid.map_or_else(String::new, |valid| valid.to_string());
        csv.row(names.into_iter().chain([centre]).chain(values.map(decimals)).chain([valid]));
    }
    csv.text()
}
