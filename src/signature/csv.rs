//! A signature as CSV.

use super::{Band, retrieve};
use crate::histogram::Estimate;
use crate::radiometry::{Assumed, Retrieved, Temperature};
use crate::support::csv::{Csv, decimals};

/// A band with all that its row is made of.
struct Row<'a> {
    band: &'a Band,
    emissivity: Estimate,
    /// Only behind an atmosphere.
    l_sensor: Option<Estimate>,
    brightness: Option<Temperature>,
    eq2: Retrieved,
    eq3: [f64; 2],
}

/// A heading and its value; what is not known, and what Eq. 2 gives of masked bands, is empty.
type Column = (&'static str, fn(&Row) -> Option<f64>);

/// The columns between `wavelength_um` and `valid`.
const COLUMNS: [Column; 22] = [
    ("emissivity", |r| Some(r.emissivity.mean)),
    ("emissivity_standard_error", |r| Some(r.emissivity.standard_error)),
    ("emissivity_half_width_95", |r| Some(r.emissivity.half_width)),
    ("emissivity_standard_error_rays", |r| Some(r.emissivity.rays_standard_error)),
    ("emissivity_sd_packings", |r| r.emissivity.spread),
    ("l_emitted_w_m2_sr_um", |r| Some(r.band.l_emitted.mean)),
    ("l_reflected_w_m2_sr_um", |r| Some(r.band.l_reflected.mean)),
    ("l_target_w_m2_sr_um", |r| Some(r.band.l_target.mean)),
    ("l_emitted_standard_error_w_m2_sr_um", |r| Some(r.band.l_emitted.standard_error)),
    ("l_reflected_standard_error_w_m2_sr_um", |r| Some(r.band.l_reflected.standard_error)),
    ("l_target_standard_error_w_m2_sr_um", |r| Some(r.band.l_target.standard_error)),
    ("l_blackbody_w_m2_sr_um", |r| Some(r.band.l_blackbody)),
    ("l_downwelling_w_m2_sr_um", |r| Some(r.band.l_downwelling)),
    ("l_sensor_w_m2_sr_um", |r| r.l_sensor.map(|l| l.mean)),
    ("l_sensor_standard_error_w_m2_sr_um", |r| r.l_sensor.map(|l| l.standard_error)),
    ("brightness_temperature_k", |r| r.brightness.map(|t| t.k)),
    ("brightness_temperature_standard_error_k", |r| r.brightness.map(|t| t.error_k)),
    ("amplification", |r| Some(r.eq2.amplification)),
    ("emissivity_eq2", |r| r.eq2.emissivity.map(|[e, _]| e)),
    ("emissivity_eq2_standard_error", |r| r.eq2.emissivity.map(|[_, error]| error)),
    ("emissivity_eq3", |r| Some(r.eq3[0])),
    ("emissivity_eq3_standard_error", |r| Some(r.eq3[1])),
];

/// A signature as CSV, with the results of Eq. 2 and 3 for a target of that temperature.
pub fn csv_text(bands: &[Band], temperature: Temperature, assumed: Assumed) -> String {
    let headings = COLUMNS.iter().map(|(heading, _)| *heading);
    let headings: Vec<&str> =
        ["wavelength_um"].into_iter().chain(headings).chain(["valid"]).collect();
    let mut csv = Csv::new(&headings);
    for (band, eq2) in bands.iter().zip(retrieve(bands, temperature, assumed)) {
        let row = Row {
            band,
            emissivity: band.emissivity,
            l_sensor: band.path.map(|_| band.l_sensor()),
            brightness: band.measured().brightness_temperature(),
            eq2,
            eq3: band.emissivity_eq3(temperature),
        };
        let (um, valid) = (band.wavelength_um.to_string(), u8::from(band.valid).to_string());
        let numbers = COLUMNS.iter().map(|(_, value)| decimals(value(&row)));
        csv.row([um].into_iter().chain(numbers).chain([valid]));
    }
    csv.text()
}
