//! The files of a match.

use std::path::Path;

use super::estimation::{Estimation, Observed};
use super::result::{Match, Quantity};
use super::{summary, words};
use crate::draw::plot::{self, Curve, Drawn, FitChart};
use crate::spectrum::features::Windows;
use crate::support::csv::{Csv, decimals};
use crate::support::error::Error;
use crate::support::math;
use crate::support::output;

/// Standard deviations of a 95 % interval.
const SIGMAS_95: f64 = 1.96;

/// The columns of `match.csv`, with their meanings.
pub const COLUMNS: [(&str, &str); 7] = [
    ("wavelength_um", "Wavelength, um."),
    (
        "measured",
        "Emissivity measured. Of radiance it is (L - l_downwelling) / (B(T) - l_downwelling), with the first temperature T.",
    ),
    ("measured_standard_error", "Its standard error."),
    ("fitted", "The same by the best fit."),
    ("fitted_standard_error", "Its standard error by the posterior of the parameters."),
    ("residual", "Measured less fitted."),
    (
        "known_standard_error",
        "Standard error of the residual without the discrepancy: measurement, beds, spectra.",
    ),
];

/// Writes all files; `match.json` last.
pub fn write(
    result: &Match,
    observed: &Observed,
    found: &Estimation,
    out: &Path,
) -> Result<(), Error> {
    let residual = summary::residuals(observed, found);
    let of_fit = fit_errors(found);
    let known: Vec<f64> = found.known.diagonal().iter().map(|v| v.sqrt()).collect();
    let headings = COLUMNS.map(|(heading, _)| heading);
    let mut csv = Csv::new(&headings);
    let fitted = &found.evaluated.bands;
    for i in 0..observed.um.len() {
        let numbers =
            [observed.bands[i], observed.errors[i], fitted[i], of_fit[i], residual[i], known[i]];
        csv.row([observed.um[i].to_string()].into_iter().chain(numbers.map(decimals)));
    }
    output::bytes(&out.join("match.csv"), csv.text().as_bytes())?;
    let discrepancy = result.answer.discrepancy.deviations(fitted);
    let both = known.iter().zip(discrepancy);
    let expected = both.map(|(known, of)| SIGMAS_95 * math::hypot(*known, of)).collect();
    let curve = |label: &str, values: &[f64], errors: &[f64]| Curve {
        label: label.into(),
        wavelength_um: observed.um.clone(),
        emissivity: values.to_vec(),
        half_width: errors.iter().map(|error| SIGMAS_95 * error).collect(),
        of_rays: Vec::new(),
        windows: Windows::default(),
    };
    let quantity = match result.observed {
        Quantity::Emissivity => "Emissivity",
        Quantity::Radiance => "Radiance by Eq. 2",
    };
    let chart = FitChart {
        title: format!("{}: measured and fitted", result.spectrum),
        caption: words::answer(result)
            .lines()
            .map(str::to_owned)
            .chain([
                "Shaded: 95 % intervals; below, where 95 % of the residuals are expected.".into()
            ])
            .chain([format!("soilsig {}, seed {}", result.soilsig, result.seed)])
            .collect(),
        quantity: quantity.into(),
        curves: vec![
            curve("measured", &observed.bands, &observed.errors),
            curve(&result.answer.model, fitted, &of_fit),
        ],
        residual,
        expected,
    };
    draw(&plot::fit_svg(&chart)?, &out.join("match"))?;
    let drawn: Vec<Drawn> = (result.answer.parameters.iter().enumerate())
        .filter(|(_, fitted)| fitted.parameter.prior_standard_deviation > 0.0)
        .map(|(place, fitted)| Drawn {
            name: words::name(fitted).to_owned(),
            draws: found.draws.iter().map(|draw| draw[place]).collect(),
            best: fitted.best,
        })
        .collect();
    let title = format!("{}: posterior", result.spectrum);
    draw(&plot::posterior_svg(&title, &drawn), &out.join("posterior"))?;
    output::bytes(&out.join("match.txt"), words::page(result).as_bytes())?;
    let text = serde_json::to_string_pretty(result).expect("plain data");
    Ok(output::bytes(&out.join("match.json"), (text + "\n").as_bytes())?)
}

/// A chart as SVG and as PNG.
fn draw(svg: &str, stem: &Path) -> Result<(), Error> {
    output::bytes(&stem.with_extension("svg"), svg.as_bytes())?;
    let png = plot::png(svg, plot::PIXELS_PER_UNIT)?;
    Ok(output::bytes(&stem.with_extension("png"), &png)?)
}

/// The standard error of each fitted band, by the draws of the parameters and its derivatives.
fn fit_errors(found: &Estimation) -> Vec<f64> {
    let (n, p) = (found.draws.len() as f64, found.best.len());
    let mean: Vec<f64> =
        (0..p).map(|i| found.draws.iter().map(|draw| draw[i]).sum::<f64>() / n).collect();
    let slopes = &found.evaluated.slopes;
    let of = |band: usize| {
        let off = |draw: &Vec<f64>| -> f64 {
            (0..p).map(|i| slopes[i][band] * (draw[i] - mean[i])).sum()
        };
        (found.draws.iter().map(|draw| off(draw).powi(2)).sum::<f64>() / n).sqrt()
    };
    (0..found.evaluated.bands.len()).map(of).collect()
}
