//! What limits the uncertainty of a result most, and what would narrow it.

use super::Reached;
use super::terminal::{number, span};
use crate::histogram::estimate;
use crate::signature::Window;
use crate::support::math;
use crate::table::StopReason;

/// Wall time of the stages that more beds or rays would repeat, seconds.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// Dropping all beds.
    pub drop_s: f64,
    /// Tracing all beds.
    pub trace_s: f64,
}

impl Cost {
    /// Time for further beds: all of the trace again, and of the drop what the cache does not hold.
    /// A single bed is dropped again with several, since it has files for other programs.
    fn of_packings(self, before: usize, after: usize) -> f64 {
        // As many Blenders run side by side as there are threads.
        let rounds = |beds: usize| beds as f64 / rayon::current_num_threads().min(beds) as f64;
        let dropped = if before == 1 { after } else { after - before };
        self.drop_s * rounds(dropped) / rounds(before) + self.trace_s * after as f64 / before as f64
    }
}

/// A line that names the largest part of the uncertainty and the option that narrows it; `None`
/// where there is no uncertainty.
pub(super) fn line(r: &Reached, cost: Option<Cost>) -> Option<String> {
    let window = r.windows.iter().max_by(|a, b| a.half_width_95.total_cmp(&b.half_width_95))?;
    if r.is_drawn() && window.packings.is_none() {
        return Some(
            "not included: differences between beds, which --packings 4 would measure".into(),
        );
    }
    let of_beds = window.packings.unwrap_or(0.0);
    let rim = window.rim.unwrap_or(0.0);
    let parts =
        [of_beds, window.rays, rim, window.floor, window.given_up, window.apart.unwrap_or(0.0)];
    let (largest, half_width) =
        parts.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).expect("there are six");
    if half_width < 5e-6 {
        return None;
    }
    Some(match largest {
        0 => format!("beds differ most: {}", packings(r, window, cost)),
        1 => format!("rays are the largest part: {}", rays(r, window, cost)),
        2 => "the rim differs from the middle: a wider tray_um with a wider crop_um in the recipe \
              narrows it"
            .into(),
        3 => "the floor shows: a deeper bed, by more grains, narrows it".into(),
        4 => "given-up paths leave most open: a smaller --tolerance follows paths further".into(),
        _ => "hulls keep fines apart: --tolerance in place of --packings drops some beds until their \
              fines touch"
            .into(),
    })
}

/// The packings that halve what the beds differ by, or reach the tolerance if that takes fewer.
fn packings(r: &Reached, window: &Window, cost: Option<Cost>) -> String {
    if r.plan.is_some() {
        return "a smaller --tolerance plans more of them".into();
    }
    let total = window.half_width_95;
    let half = window.with(window.packings.unwrap_or(0.0) / 2.0, window.rays);
    let goal = if total > r.tolerance { half.max(r.tolerance) } else { half };
    // The rays of several beds together are traced to half of the tolerance at most.
    let rays = window.rays.min(r.tolerance / 2.0);
    let by = |n: usize| Some((n, window.with_packings(n, rays)?));
    let more = r.packings + 1..=estimate::MOST;
    match more.filter_map(by).find(|(_, half_width)| *half_width <= goal) {
        None => format!("{} packings do not halve that", estimate::MOST),
        Some((n, half_width)) => {
            let time = cost.map(|cost| cost.of_packings(r.packings, n));
            // Only a run of the pipeline has a cost; others have no such option.
            let command = if cost.is_some() { "" } else { "soilsig pipeline " };
            format!("{command}--packings {n} gives {}", gives(r, window, half_width, time))
        }
    }
}

/// The option that halves the noise of the rays, with four times the paths.
fn rays(r: &Reached, window: &Window, cost: Option<Cost>) -> String {
    let half_width = window.with(window.packings.unwrap_or(0.0), window.rays / 2.0);
    let gives = gives(r, window, half_width, cost.map(|cost| 4.0 * cost.trace_s));
    match r.ended_by {
        StopReason::Paths => format!("--paths {} gives {gives}", 4 * r.paths),
        StopReason::MaxPaths => format!("--max-paths {} gives {gives}", 4 * r.paths),
        StopReason::MaxSeconds => format!("four times --max-seconds gives {gives}"),
        _ => format!("--tolerance {} gives {gives}", two_digits(r.half_width / 2.0)),
    }
}

fn gives(r: &Reached, window: &Window, half_width: f64, seconds: Option<f64>) -> String {
    let several = r.windows.len() > 1;
    let window = if several { format!(" ({})", span(window)) } else { String::new() };
    let time = seconds.map_or(String::new(), |s| format!(" in about {}", duration(s)));
    format!("+- {}{window}{time}", number(half_width, half_width))
}

/// Two significant digits, rounded down, but for what rounding to a double takes away.
fn two_digits(x: f64) -> f64 {
    let unit = 10f64.powi(1 - math::log10(x).floor() as i32);
    (x * unit + 1e-9).floor() / unit
}

/// A time in words.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s.max(1.0)),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;
    use crate::report::terminal::blocks;

    /// A result of one bed, 8-9.5 um, after a change.
    fn reached(change: impl FnOnce(&mut Value)) -> Reached {
        let mut reached = json!({
            "windows": [{
                "from_um": 8, "to_um": 9.5, "emissivity": 0.8321, "half_width_95": 0.0214,
                "rays": 0.002, "packings": 0.0211, "packings_spread": 0.0099, "rim": 0,
                "floor": 0.0002, "given_up": 0,
            }],
            "packings": 1, "half_width": 0.0024, "widest_at_um": 9, "spread": null,
            "rays_share": 1, "trapped_half_width": 0, "packings_wanted": null, "tolerance": 0.005,
            "tolerance_reached": true, "paths": 8192, "seen_first": {"fine": 1}, "coverage": {},
            "missed": 0, "escaped_downward": 0, "trapped": 0,
            "kept": {"order": false, "cosines": 1, "zeniths": 1}, "ended_by": "tolerance",
            "inside": 0, "floor_effect": null,
            "budget": {
                "wavelength_um": 9, "total": 0.02, "rays": 0.002, "packings": 0.02, "rim": 0,
                "floor": 0, "given_up": 0, "apart": null, "facets": 0.004, "spectral_step": 0,
                "spectra": 0,
            },
            "retrieval": {
                "amplification_limit": 10, "masked_um": [], "eq_2_not_exact": [],
                "eq_2_difference": 0, "separation": {},
            },
            "features": {}, "features_half_width": null,
        });
        change(&mut reached);
        serde_json::from_value(reached).expect("a result")
    }

    #[test]
    fn the_first_line_is_the_answer_and_the_second_narrows_it() {
        let cost = Cost { drop_s: 2.0, trace_s: 0.5 };
        let one = reached(|_| {});
        let text = blocks(&[("sparse", &one, Some(cost))], false);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "sparse   emissivity 0.832 +- 0.021 (8-9.5 um), 95 %, one bed");
        // Student's t of five degrees of freedom: 2.571 x .0099 / sqrt 6 = .0104.
        let narrowed = "         beds differ most: --packings 6 gives +- 0.011 in about ";
        assert!(lines[1].starts_with(narrowed), "{text}");
        assert_eq!(lines.len(), 2);
        assert!(blocks(&[("sparse", &one, None)], true).lines().count() > 6);
        // A tolerance within reach ends it earlier.
        let loose = reached(|r| r["tolerance"] = 0.017.into());
        assert!(line(&loose, None).expect("a line").contains("pipeline --packings 4 gives"));
        let planned = reached(|r| {
            let beds = json!({"drops": 6, "pairs": 0});
            r["plan"] = json!({"by": beds, "at_um": 9, "total": 0.02, "bounds": 0, "spread": 0.0099,
                               "spread_of_change": null, "wanted": beds, "next": beds});
        });
        assert!(line(&planned, None).expect("a line").contains("--tolerance plans more"));
    }

    #[test]
    fn the_largest_part_is_named_with_its_own_remedy() {
        for (part, words) in [
            ("rays", "--tolerance 0.0012 gives +- 0.251"),
            ("rim", "crop_um"),
            ("floor", "deeper bed"),
            ("given_up", "smaller --tolerance"),
        ] {
            let said = line(&reached(|r| r["windows"][0][part] = 0.5.into()), None);
            assert!(said.as_ref().is_some_and(|said| said.contains(words)), "{part}: {said:?}");
        }
        let unknown = reached(|r| r["windows"][0]["packings"] = Value::Null);
        assert!(line(&unknown, None).expect("a line").contains("not included"));
        let exact = reached(|r| {
            for part in ["packings", "rays", "rim", "floor", "given_up"] {
                r["windows"][0][part] = 0.into();
            }
        });
        assert_eq!(line(&exact, None), None);
    }

    #[test]
    fn times_and_tolerances_are_short() {
        assert_eq!([0.2, 42.0, 170.0, 9000.0].map(duration), ["1 s", "42 s", "3 min", "2 h"]);
        assert_eq!([0.0119, 0.0012, 0.5].map(two_digits), [0.011, 0.0012, 0.5]);
    }
}
