//! A match in words: the answer first.

use super::Warning;
use super::result::{Fit, Fitted, Match};
use super::warning::named;

/// The name of a parameter for people.
pub fn name(fitted: &Fitted) -> &str {
    named(&fitted.parameter.name)
}

/// A parameter with its error: mean and standard deviation of the posterior, and its interval if
/// asked for.
fn parameter(fitted: &Fitted, with_interval: bool) -> String {
    let Fitted { mean, standard_error, parameter, .. } = fitted;
    let decimals = if parameter.unit.is_empty() { 2 } else { 3 };
    let unit =
        if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
    let mut text =
        format!("{} {mean:.decimals$} +- {standard_error:.decimals$}{unit}", name(fitted));
    if with_interval {
        let [low, high] = fitted.interval_95;
        text += &format!(" (95 % {low:.decimals$} to {high:.decimals$})");
    }
    if fitted.degrees_of_freedom < 0.5 {
        text += " (not told by these bands)";
    }
    text
}

/// The fitted parameters in a line.
fn parameters(fit: &Fit, with_intervals: bool) -> String {
    let is_free = |fitted: &&Fitted| fitted.parameter.prior_standard_deviation > 0.0;
    let of = |fitted: &Fitted| parameter(fitted, with_intervals);
    let all: Vec<String> = fit.parameters.iter().filter(is_free).map(of).collect();
    if all.is_empty() { "all parameters are given".into() } else { all.join(", ") }
}

/// The answer in two lines.
pub fn answer(result: &Match) -> String {
    let fit = &result.answer;
    let bad = result.warnings.iter().any(|w| matches!(w, Warning::NoGoodFit { .. }));
    let verdict = if bad { "no good fit: " } else { "" };
    format!("{verdict}{}\n{}\n", parameters(fit, true), quality(fit))
}

fn quality(fit: &Fit) -> String {
    let Fit { rms, discrepancy, known_errors, degrees_of_freedom, .. } = fit;
    format!(
        "RMS {rms:.4}; model discrepancy {:.4} over {} um{}; chi-square with known errors alone \
         {:.0} of {:.0} (p {:.3}); {degrees_of_freedom:.2} degrees of freedom",
        discrepancy.standard_deviation,
        discrepancy.length_um,
        if discrepancy.by_depth { ", by the features' depth" } else { "" },
        known_errors.value,
        known_errors.freedom,
        known_errors.p,
    )
}

/// All of it, on a page.
pub fn page(result: &Match) -> String {
    let Match { second, beds, .. } = result;
    let mut text = format!(
        "{}: {} bands, {:.2}-{:.2} um\n\n{}\n",
        result.spectrum,
        result.bands,
        result.range_um[0],
        result.range_um[1],
        answer(result),
    );
    text += &format!(
        "Second component: {}, on {} facets.\n\nParameters\n",
        second.spectrum,
        second.on.name()
    );
    for fitted in &result.answer.parameters {
        let Fitted { parameter, best, mean, standard_error, .. } = fitted;
        let [low, high] = fitted.interval_95;
        if parameter.prior_standard_deviation == 0.0 {
            text += &format!("  {:13} {best:.4}, given\n", parameter.name);
            continue;
        }
        text += &format!(
            "  {:13} {mean:.4} +- {standard_error:.4}, 95 % {low:.4} to {high:.4}, best fit \
             {best:.4}; prior {:.4} +- {:.4}; {:.2} degrees of freedom{}\n",
            parameter.name,
            parameter.prior,
            parameter.prior_standard_deviation,
            fitted.degrees_of_freedom,
            if fitted.at_bound { "; at its bound" } else { "" },
        );
    }
    text += "\nModels of the same bands\n";
    let all = std::iter::once(&result.answer)
        .chain(&result.other_facets)
        .chain(&result.other_places)
        .chain(&result.linear)
        .chain(&result.halves);
    for fit in all {
        text += &format!(
            "  {:30} RMS {:.4}, ln evidence {:.1}: {}\n",
            fit.model,
            fit.rms,
            fit.ln_evidence,
            parameters(fit, false)
        );
    }
    let list = |values: &[f64]| -> String {
        values.iter().map(|v| format!("{v:.3}")).collect::<Vec<_>>().join(" ")
    };
    text += "\nBeds\n";
    for covers in &beds.thinned {
        text += &format!("  covers of the thinned bed: {}\n", list(covers));
    }
    if !beds.fresh.is_empty() {
        text += &format!(
            "  covers of beds dropped anew: {}\n  their emissivity near 9 um less that of the \
             thinned bed: {}\n",
            list(&beds.fresh),
            list(&beds.fresh_less_thinned)
        );
    }
    text += &format!("  spread of the model by its beds: {:.4}\n", beds.spread);
    if let Some(best) = &result.best {
        text += &format!(
            "\nBest scene\n  {}, cover {:.3}; its own bed misses the measured curve by RMS {:.4}, \
             and the fit by {:+.4} on average\n",
            best.recipe, best.cover, best.rms, best.bias
        );
    }
    if !result.warnings.is_empty() {
        text += "\nWarnings\n";
        for warning in &result.warnings {
            text += &format!("  {warning}\n");
        }
    }
    text
}
