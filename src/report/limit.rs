//! What limits the uncertainty of a result most, and what would narrow it.

use super::Reached;
use super::terminal::{number, span};
use crate::histogram::estimate;
use crate::signature::Window;
use crate::table::Ended;

/// Wall time of the stages that more beds or rays would repeat, seconds.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// Dropping all beds.
    pub drop_s: f64,
    /// Tracing all beds.
    pub trace_s: f64,
}

impl Cost {
    /// Time for further beds: all of the trace again, and of the drop what the cache does not hold. A
    /// single bed is dropped again with several, since it has files for other programs.
    fn of_packings(self, before: usize, after: usize) -> f64 {
        // As many Blenders run side by side as there are threads.
        let rounds = |beds: usize| beds as f64 / rayon::current_num_threads().min(beds) as f64;
        let dropped = if before == 1 { after } else { after - before };
        self.drop_s * rounds(dropped) / rounds(before) + self.trace_s * after as f64 / before as f64
    }
}

/// A line that names the largest part of the uncertainty and the option that narrows it; `None` where
/// there is no uncertainty.
pub(super) fn line(r: &Reached, cost: Option<Cost>) -> Option<String> {
    let window = r.windows.iter().max_by(|a, b| a.half_width_95.total_cmp(&b.half_width_95))?;
    if r.is_drawn() && window.packings.is_none() {
        return Some(
            "not included: differences between beds, which --packings 4 would measure".into(),
        );
    }
    let of_beds = window.packings.unwrap_or(0.0);
    let rim = window.rim.unwrap_or(0.0);
    let parts = [of_beds, window.rays, rim, window.floor, window.given_up];
    let (largest, half_width) =
        parts.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).expect("there are five");
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
        _ => "given-up paths leave most open: a smaller --tolerance follows paths further".into(),
    })
}

/// The packings that halve the total, or reach the tolerance if that takes fewer.
fn packings(r: &Reached, window: &Window, cost: Option<Cost>) -> String {
    if r.plan.is_some() {
        return "a smaller --tolerance plans more of them".into();
    }
    let half = window.half_width_95 / 2.0;
    let reached = window.half_width_95 <= r.tolerance;
    let goal = if reached { half } else { half.max(r.tolerance) };
    // The rays of several beds together are traced to half of the tolerance at most.
    let rays = window.rays.min(r.tolerance / 2.0);
    let by = |n: usize| Some((n, window.with_packings(n, rays)?));
    let more = r.packings + 1..=estimate::MOST;
    match more.filter_map(by).find(|(_, half_width)| *half_width <= goal) {
        None => format!("{} packings do not halve that", estimate::MOST),
        Some((n, half_width)) => {
            let time = cost.map(|cost| cost.of_packings(r.packings, n));
            format!("--packings {n} gives {}", gives(r, window, half_width, time))
        }
    }
}

/// The option that halves the noise of the rays, with four times the paths.
fn rays(r: &Reached, window: &Window, cost: Option<Cost>) -> String {
    let half_width = window.half_width_95 - window.rays / 2.0;
    let gives = gives(r, window, half_width, cost.map(|cost| 4.0 * cost.trace_s));
    match r.ended_by {
        Ended::Paths => format!("--paths {} gives {gives}", 4 * r.paths),
        Ended::MaxPaths => format!("--max-paths {} gives {gives}", 4 * r.paths),
        Ended::MaxSeconds => format!("four times --max-seconds gives {gives}"),
        _ => format!("--tolerance {} gives {gives}", two_digits(r.half_width / 2.0)),
    }
}

fn gives(r: &Reached, window: &Window, half_width: f64, seconds: Option<f64>) -> String {
    let mut text = format!("+- {}", number(half_width, half_width));
    if r.windows.len() > 1 {
        text += &format!(" ({})", span(window));
    }
    text + &seconds.map_or(String::new(), |seconds| format!(" in about {}", duration(seconds)))
}

/// Two significant digits, rounded down.
fn two_digits(x: f64) -> f64 {
    let unit = 10f64.powi(1 - x.log10().floor() as i32);
    (x * unit).floor() / unit
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s.max(1.0)),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h", s / 3600.0),
    }
}
