//! Error against time, both in powers of ten: a colour for each level of the model.

use std::collections::HashSet;

use crate::draw::plot::PlotError;
use crate::draw::plot::legend::{Legend, Pen};
use crate::draw::plot::svg::{Anchor, Point, Svg, text_width, wrapped};
use crate::studies::chart::{Setting, Trade};
use crate::support::statistics::T_95;

const WIDTH: f64 = 760.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 740.0;
const PLOT_HEIGHT: f64 = 400.0;
const TITLE_SIZE: f64 = 16.0;
const AXIS_SIZE: f64 = 13.5;
const TICK_SIZE: f64 = 12.0;
const NOTE_SIZE: f64 = 11.0;
const CAPTION_SIZE: f64 = 10.5;
const BESIDE: &str = "Squares: measured elsewhere, each level against a reference of its own; the line and the ring leave them out.";

/// A scale by powers of ten.
struct Decades {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Decades {
    /// Holds all values, with a little room at both ends.
    fn new(values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Option<Self> {
        let logs = values.filter(|value| *value > 0.0).map(f64::log10);
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let room = 0.05 * (high - low).max(1.0);
        low.is_finite().then_some(Self { low: low - room, high: high + room, from, to })
    }

    /// What is not above 0 is put at the lower end.
    fn place(&self, value: f64) -> f64 {
        let log = value.log10().max(self.low);
        self.from + (self.to - self.from) * (log - self.low) / (self.high - self.low)
    }

    /// Powers of ten with a label, and 2 to 9 times them without.
    fn ticks(&self) -> Vec<(f64, Option<String>)> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        decades
            .flat_map(|power| (1..10).map(move |digit| (power, digit)))
            .map(|(power, digit)| {
                let value = f64::from(digit) * 10f64.powi(power);
                (value, (digit == 1).then(|| format!("{}", 10f64.powi(power))))
            })
            .filter(|(value, _)| (self.low..=self.high).contains(&value.log10()))
            .collect()
    }
}

/// Draws the settings of a scene: the error in the worst band against CPU time.
///
/// # Errors
/// No setting.
pub(crate) fn trade_svg(trade: &Trade, tolerance: f64, machine: &str) -> Result<String, PlotError> {
    // A level measured elsewhere may have the name of one that was measured here.
    let level = |s: &Setting| (s.level.clone(), s.elsewhere.is_some());
    let mut levels: Vec<(String, bool)> = trade.settings.iter().map(level).collect();
    let mut known = HashSet::new();
    levels.retain(|level| known.insert(level.clone()));
    let title = format!("Error against time: {}", trade.scene);
    let floor = trade.reference.worst_floor();
    let target = tolerance / T_95;
    let fewest = trade.settings.iter().map(|s| s.repeats).min().ok_or(PlotError::Empty)?;
    let beside = levels.iter().any(|(_, elsewhere)| *elsewhere);
    let caption = [
        format!(
            "Each point is the root mean square over {fewest} runs or more, in the band where it is greatest, against {}. \
             Hollow: more than half of the error over all bands is bias, which no further paths or beds lessen. Line: what nothing beats. \
             Ring: the cheapest within ±{tolerance} at 95 %.",
            trade.reference.made_of
        ),
        if beside { BESIDE.to_owned() } else { String::new() },
        machine.to_owned(),
    ];
    let caption: Vec<String> =
        caption.iter().flat_map(|line| wrapped(line, CAPTION_SIZE, RIGHT - LEFT)).collect();
    let legend = Legend::new(levels.iter().map(|(name, _)| name.as_str()), (LEFT, RIGHT));
    let legend_top = 40.0;
    let top = legend_top + legend.height() + 14.0;
    let bottom = top + PLOT_HEIGHT;
    let caption_top = bottom + 52.0;
    let height = caption_top + 15.0 * caption.len() as f64 + 8.0;

    let times = trade.settings.iter().map(|s| s.took.cpu_s);
    let errors = trade.settings.iter().map(|s| s.worst).chain([target, floor]);
    let x = Decades::new(times, (LEFT, RIGHT)).ok_or(PlotError::Empty)?;
    let y = Decades::new(errors, (bottom, top)).ok_or(PlotError::Empty)?;
    let at = |s: &Setting| (x.place(s.took.cpu_s), y.place(s.worst));

    let mut svg = Svg::new(WIDTH, height, &title);
    svg.text((LEFT, 26.0), Anchor::Start, TITLE_SIZE, &title);
    legend.draw(&mut svg, legend_top, false);
    for (value, label) in x.ticks() {
        let place = x.place(value);
        let grid = if label.is_some() { "#d4d4d4" } else { "#efefef" };
        svg.line(&[(place, top), (place, bottom)], &format!("stroke='{grid}'"));
        if let Some(label) = label {
            svg.text((place, bottom + 18.0), Anchor::Middle, TICK_SIZE, &label);
        }
    }
    for (value, label) in y.ticks() {
        let place = y.place(value);
        let grid = if label.is_some() { "#d4d4d4" } else { "#efefef" };
        svg.line(&[(LEFT, place), (RIGHT, place)], &format!("stroke='{grid}'"));
        if let Some(label) = label {
            svg.text((LEFT - 8.0, place + 4.0), Anchor::End, TICK_SIZE, &label);
        }
    }
    svg.rectangle(
        (LEFT, y.place(floor)),
        (RIGHT - LEFT, bottom - y.place(floor)),
        "fill='#888888' fill-opacity='0.18'",
    );
    note(&mut svg, (LEFT + 6.0, y.place(floor) + 13.0), "below what the reference can tell");
    let line = [(LEFT, y.place(target)), (RIGHT, y.place(target))];
    svg.line(&line, "stroke='#1a1a1a' stroke-width='1.2' stroke-dasharray='6 4'");
    let text = format!("±{tolerance} at 95 %");
    note(&mut svg, (LEFT + 6.0, y.place(target) - 5.0), &text);

    let front: Vec<Point> = trade.front().into_iter().map(at).collect();
    svg.line(&front, "stroke='#1a1a1a' stroke-width='5' stroke-opacity='0.13'");
    for (number, of) in levels.iter().enumerate() {
        let pen = Pen::of(number);
        let of_level = || trade.settings.iter().filter(|s| level(s) == *of);
        svg.line(&of_level().map(at).collect::<Vec<_>>(), &pen.line());
        for setting in of_level() {
            let biased = setting.bias > 0.5 * setting.rms;
            let fill = if biased { "#ffffff" } else { pen.colour };
            let style = format!("fill='{fill}' stroke='{}' stroke-width='1.4'", pen.colour);
            let (px, py) = at(setting);
            if setting.elsewhere.is_some() {
                svg.rectangle((px - 3.6, py - 3.6), (7.2, 7.2), &style);
            } else {
                svg.circle((px, py), 3.6, &style);
            }
        }
    }
    if let Some(chosen) = trade.chosen(tolerance) {
        svg.circle(at(chosen), 9.0, "fill='none' stroke='#1a1a1a' stroke-width='1.8'");
        let (px, py) = at(chosen);
        let text = format!("{}, {}", chosen.level, chosen.setting);
        let right = px + 14.0 + text_width(&text, NOTE_SIZE) > RIGHT;
        let left = if right { px - 14.0 - text_width(&text, NOTE_SIZE) } else { px + 14.0 };
        note(&mut svg, (left, py + 16.0), &text);
    }
    svg.rectangle((LEFT, top), (RIGHT - LEFT, bottom - top), "fill='none' stroke='#1a1a1a'");
    let middle = f64::midpoint(LEFT, RIGHT);
    svg.text((middle, bottom + 40.0), Anchor::Middle, AXIS_SIZE, "CPU time, seconds");
    svg.upright_text(
        (22.0, f64::midpoint(top, bottom)),
        AXIS_SIZE,
        "Error of the emissivity in the worst band (root mean square)",
    );
    for (i, line) in caption.iter().enumerate() {
        let place = (LEFT, caption_top + 10.0 + 15.0 * i as f64);
        svg.styled_text(place, Anchor::Start, CAPTION_SIZE, line, "fill='#555555'");
    }
    Ok(svg.finish())
}

/// A remark on a white ground.
fn note(svg: &mut Svg, (x, y): Point, text: &str) {
    let size = (text_width(text, NOTE_SIZE) + 4.0, NOTE_SIZE + 3.0);
    svg.rectangle((x - 2.0, y - NOTE_SIZE), size, "fill='#ffffff' fill-opacity='0.75'");
    svg.text((x, y), Anchor::Start, NOTE_SIZE, text);
}
