//! A signature in columns, and these as CSV.

use super::budget::{Budget, Share};
use super::{Band, retrieve};
use crate::histogram::Estimate;
use crate::radiometry::{Assumed, Retrieved, Temperature};
use crate::support::csv::{Csv, decimals, radiance};

/// A band with all that its row is made of.
struct Row<'a> {
    band: &'a Band,
    share: &'a Share,
    emissivity: Estimate,
    /// Only behind an atmosphere.
    l_sensor: Option<Estimate>,
    brightness: Option<Temperature>,
    eq2: Retrieved,
    eq3: [f64; 2],
}

/// A heading, its meaning and its value. Unknown values, and Eq. 2 in masked bands, are empty. A
/// column of empty fields alone is left out.
type Column = (&'static str, &'static str, fn(&Row) -> Option<f64>);

/// The columns between `wavelength_um` and `valid`.
const COLUMNS: [Column; 24] = [
    (
        "emissivity",
        "Emissivity towards the sensor, 1 - mean W: a property of the bed, whatever its temperatures.",
        |r| Some(r.emissivity.mean),
    ),
    (
        "emissivity_standard_error",
        "Its standard error; of several beds from the spread between them, of one from its rays.",
        |r| Some(r.emissivity.standard_error),
    ),
    (
        "emissivity_half_width_95",
        "Half-width of its 95 % interval. Paths given up are included; of one bed, the differences between beds are not: see budget.csv.",
        |r| Some(r.emissivity.half_width),
    ),
    (
        "emissivity_total_half_width_95",
        "Its total half-width, with the differences between beds and the bounds of budget.csv.",
        |r| Some(r.share.total),
    ),
    ("emissivity_standard_error_rays", "The part of the standard error that the rays make.", |r| {
        Some(r.emissivity.rays_standard_error)
    }),
    ("emissivity_sd_packings", "Standard deviation between beds; left out for one bed.", |r| {
        r.emissivity.spread
    }),
    ("l_emitted_w_m2_sr_um", "Radiance emitted.", |r| Some(r.band.l_emitted.mean)),
    ("l_reflected_w_m2_sr_um", "Radiance reflected from the sky.", |r| {
        Some(r.band.l_reflected.mean)
    }),
    ("l_target_w_m2_sr_um", "Radiance that leaves the target (Eq. 1).", |r| {
        Some(r.band.l_target.mean)
    }),
    ("l_emitted_standard_error_w_m2_sr_um", "Standard error of l_emitted.", |r| {
        Some(r.band.l_emitted.standard_error)
    }),
    ("l_reflected_standard_error_w_m2_sr_um", "Standard error of l_reflected.", |r| {
        Some(r.band.l_reflected.standard_error)
    }),
    ("l_target_standard_error_w_m2_sr_um", "Standard error of l_target.", |r| {
        Some(r.band.l_target.standard_error)
    }),
    ("l_blackbody_w_m2_sr_um", "Radiance of a black body at the temperature of the scene.", |r| {
        Some(r.band.l_blackbody)
    }),
    (
        "l_downwelling_w_m2_sr_um",
        "Radiance of the sky; of one by zenith angle, as a level Lambertian mirror returns it.",
        |r| Some(r.band.l_downwelling),
    ),
    (
        "l_sensor_w_m2_sr_um",
        "Radiance at the sensor, behind an atmosphere; left out without one.",
        |r| r.l_sensor.map(|l| l.mean),
    ),
    ("l_sensor_standard_error_w_m2_sr_um", "Standard error of l_sensor.", |r| {
        r.l_sensor.map(|l| l.standard_error)
    }),
    ("brightness_temperature_k", "Temperature of a black body with this radiance.", |r| {
        r.brightness.map(|t| t.k)
    }),
    ("brightness_temperature_standard_error_k", "Its standard error.", |r| {
        r.brightness.map(|t| t.error_k)
    }),
    ("amplification", "Factor by which Eq. 2 amplifies errors, B / (B - l_downwelling).", |r| {
        Some(r.eq2.amplification)
    }),
    ("emissivity_eq2", "Emissivity by Eq. 2; empty where the band is masked.", |r| {
        r.eq2.emissivity.map(|[e, _]| e)
    }),
    ("emissivity_eq2_standard_error", "Its standard error.", |r| {
        r.eq2.emissivity.map(|[_, error]| error)
    }),
    ("emissivity_eq3", "Emissivity by Eq. 3, under a cold black sky.", |r| Some(r.eq3[0])),
    ("emissivity_eq3_standard_error", "Its standard error.", |r| Some(r.eq3[1])),
    (
        "refracted",
        "Share of the band for which light through auto facets was followed: 1 all; 0 none, they were opaque. Left out without such facets.",
        |r| r.band.refracted,
    ),
];

/// A column: heading, meaning, and a value for each band.
pub(super) type Values = (&'static str, &'static str, Vec<Option<f64>>);

/// The columns between `wavelength_um` and `valid` that have a value, with the results of Eq. 2 and
/// 3 for a target of that temperature.
pub(super) fn values(
    bands: &[Band],
    budget: &Budget,
    temperature: Temperature,
    assumed: Assumed,
) -> Vec<Values> {
    let retrieved = retrieve(bands, temperature, assumed);
    let row = |((band, share), eq2)| Row {
        band,
        share,
        emissivity: band.emissivity,
        l_sensor: band.path.map(|_| band.l_sensor()),
        brightness: band.measured().brightness_temperature(),
        eq2,
        eq3: band.emissivity_eq3(temperature),
    };
    let rows: Vec<Row> = bands.iter().zip(&budget.bands).zip(retrieved).map(row).collect();
    let column = |(heading, meaning, value): &Column| {
        let values: Vec<_> = rows.iter().map(value).collect();
        values.iter().any(Option::is_some).then_some((*heading, *meaning, values))
    };
    COLUMNS.iter().filter_map(column).collect()
}

/// A signature as CSV, with the results of Eq. 2 and 3 for a target of that temperature.
pub fn csv_text(
    bands: &[Band],
    budget: &Budget,
    temperature: Temperature,
    assumed: Assumed,
) -> String {
    let columns = values(bands, budget, temperature, assumed);
    let headings = columns.iter().map(|(heading, ..)| *heading);
    let headings: Vec<&str> =
        ["wavelength_um"].into_iter().chain(headings).chain(["valid"]).collect();
    let mut csv = Csv::new(&headings);
    for (i, band) in bands.iter().enumerate() {
        let (um, valid) = (band.wavelength_um.to_string(), u8::from(band.valid).to_string());
        let numbers = columns.iter().map(|(heading, _, values)| match values[i] {
            l if heading.starts_with("l_") => radiance(l, band.l_blackbody),
            number => decimals(number),
        });
        csv.row([um].into_iter().chain(numbers).chain([valid]));
    }
    csv.text()
}

/// All headings with their meanings.
pub fn columns() -> Vec<(&'static str, &'static str)> {
    let first = [("wavelength_um", "Wavelength of the band.")];
    let last = [("valid", "1 where the models of all facets hold, else 0.")];
    let others = COLUMNS.iter().map(|(heading, meaning, _)| (*heading, *meaning));
    first.into_iter().chain(others).chain(last).collect()
}
