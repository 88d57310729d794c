//! A signature as CSV.

use std::path::Path;

use super::{Band, retrieve};
use crate::histogram::Estimate;
use crate::radiometry::{Assumed, Temperature};
use crate::support::csv::{Csv, decimals};
use crate::support::output::{self, OutputError};

/// Headings of a signature's CSV file.
pub const COLUMNS: [&str; 24] = [
    "wavelength_um",
    "emissivity",
    "emissivity_standard_error",
    "emissivity_half_width_95",
    "emissivity_standard_error_rays",
    "emissivity_sd_packings",
    "l_emitted_w_m2_sr_um",
    "l_reflected_w_m2_sr_um",
    "l_target_w_m2_sr_um",
    "l_emitted_standard_error_w_m2_sr_um",
    "l_reflected_standard_error_w_m2_sr_um",
    "l_target_standard_error_w_m2_sr_um",
    "l_blackbody_w_m2_sr_um",
    "l_downwelling_w_m2_sr_um",
    "l_sensor_w_m2_sr_um",
    "l_sensor_standard_error_w_m2_sr_um",
    "brightness_temperature_k",
    "brightness_temperature_standard_error_k",
    "amplification",
    "emissivity_eq2",
    "emissivity_eq2_standard_error",
    "emissivity_eq3",
    "emissivity_eq3_standard_error",
    "valid",
];

/// A signature as CSV, with what Eq. 2 and 3 give of it for a target of that temperature. What is not known, and bands
/// that are masked, have empty fields.
pub fn csv_text(bands: &[Band], temperature: Temperature, assumed: Assumed) -> String {
    let mut csv = Csv::new(&COLUMNS);
    for (b, retrieved) in bands.iter().zip(retrieve(bands, temperature, assumed)) {
        let e = b.emissivity;
        let both = |of: Estimate| [Some(of.mean), Some(of.standard_error)];
        let [sensor, sensor_error] = b.path.map_or([None; 2], |_| both(b.l_sensor()));
        let brightness = b.measured().brightness_temperature();
        let eq3 = b.emissivity_eq3(temperature);
        let numbers = [
            Some(e.mean),
            Some(e.standard_error),
            Some(e.half_width),
            Some(e.rays_standard_error),
            // Of a single packing the spread is not known.
            e.spread,
            Some(b.l_emitted.mean),
            Some(b.l_reflected.mean),
            Some(b.l_target.mean),
            Some(b.l_emitted.standard_error),
            Some(b.l_reflected.standard_error),
            Some(b.l_target.standard_error),
            Some(b.l_blackbody),
            Some(b.l_downwelling),
            sensor,
            sensor_error,
            brightness.map(|t| t.k),
            brightness.map(|t| t.error_k),
            Some(retrieved.amplification),
            retrieved.emissivity.map(|[e, _]| e),
            retrieved.emissivity.map(|[_, error]| error),
            Some(eq3[0]),
            Some(eq3[1]),
        ];
        let (um, valid) = (b.wavelength_um.to_string(), u8::from(b.valid).to_string());
        csv.row([um].into_iter().chain(numbers.map(decimals)).chain([valid]));
    }
    csv.text()
}

/// Writes a signature as [CSV](csv_text).
pub fn write_csv(
    bands: &[Band],
    temperature: Temperature,
    assumed: Assumed,
    path: &Path,
) -> Result<(), OutputError> {
    output::bytes(path, csv_text(bands, temperature, assumed).as_bytes())
}
