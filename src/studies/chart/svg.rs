//! Error against time, both logarithmic, with a colour for each level of the model.

use std::collections::HashSet;

use crate::draw::plot::PlotError;
use crate::draw::plot::axis::Axis;
use crate::draw::plot::label::Area;
use crate::draw::plot::legend::Pen;
use crate::draw::plot::page::{Layout, Page};
use crate::draw::plot::svg::{Anchor, Point, Svg, text_width};
use crate::studies::chart::{Setting, Trade};
use crate::support::statistics::quantile_of;

const NOTE_SIZE: f64 = 11.0;
const GREY: &str = "#777777";
const BESIDE: &str = "Squares: measured elsewhere, each level against its own reference. Grey line \
                      and ring leave them out.";

/// A logarithmic axis that holds all values, with a margin at both ends.
fn decades(values: impl Iterator<Item = f64>, places: (f64, f64)) -> Result<Axis, PlotError> {
    let logs = values.filter(|value| *value > 0.0).map(f64::log10);
    let (low, high) = logs.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    let room = 0.05 * (high - low).max(1.0);
    if low > high {
        return Err(PlotError::Empty);
    }
    Ok(Axis::log((low - room, high + room), places))
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
    // Points of ours that stand alone are grey with letters: so many colours cannot be told apart.
    let of_level = |of: &(String, bool)| {
        let of = of.clone();
        trade.settings.iter().filter(move |s| level(s) == of)
    };
    let (singles, levels): (Vec<_>, Vec<_>) =
        levels.into_iter().partition(|of| !of.1 && of_level(of).count() == 1);
    let letters = || ('a'..='z').cycle();
    let named: Vec<String> =
        letters().zip(&singles).map(|(letter, (name, _))| format!("{letter} {name}")).collect();
    let floor = trade.reference.worst_floor();
    let fewest = trade.settings.iter().map(|s| s.repeats).min().ok_or(PlotError::Empty)?;
    let target = tolerance / quantile_of(fewest as f64);
    let beside = levels.iter().any(|(_, elsewhere)| *elsewhere);
    let caption = [
        format!(
            "Points: root mean square error in the worst band over at least {fewest} runs, against \
             {}. Hollow: more than half of the error over all bands is bias, which more paths or \
             beds do not reduce. Grey line: no other setting is better in both.",
            trade.reference.made_of
        ),
        match trade.chosen(tolerance) {
            Some(_) => format!("Ring: the cheapest setting within ±{tolerance} at 95 %."),
            None => String::new(),
        },
        if singles.is_empty() { String::new() } else { format!("Grey: {}.", named.join(", ")) },
        if beside { BESIDE.to_owned() } else { String::new() },
        machine.to_owned(),
    ];
    let mut page = Page::new(Layout {
        title: &format!("Error against time: {}", trade.scene),
        labels: levels.iter().map(|(name, _)| name.as_str()).collect(),
        bands: Vec::new(),
        plot_height: 400.0,
        above: 14.0,
        caption: &caption,
    });
    let Area { left, top, right, bottom } = page.area;
    let times = trade.settings.iter().map(|s| s.took.cpu_s);
    let errors = trade.settings.iter().map(|s| s.worst).chain([target, floor]);
    let x = decades(times, (left, right))?;
    let y = decades(errors, (bottom, top))?;
    let at = |s: &Setting| (x.place(s.took.cpu_s), y.place(s.worst));
    let of_y = "Error of the emissivity in the worst band (root mean square)";
    page.axes(&x, &y, ["CPU time, seconds", of_y]);
    let svg = &mut page.svg;
    svg.rectangle(
        (left, y.place(floor)),
        (right - left, bottom - y.place(floor)),
        "fill='#888888' fill-opacity='0.18'",
    );
    note(svg, (left + 6.0, y.place(floor) + 13.0), "below the error of the reference");
    let line = [(left, y.place(target)), (right, y.place(target))];
    svg.line(&line, "stroke='#1a1a1a' stroke-width='1.2' stroke-dasharray='6 4'");
    note(svg, (left + 6.0, y.place(target) - 5.0), &format!("±{tolerance} at 95 %"));

    let front: Vec<Point> = trade.front().into_iter().map(at).collect();
    svg.line(&front, "stroke='#1a1a1a' stroke-width='5' stroke-opacity='0.13'");
    let point = |svg: &mut Svg, setting: &Setting, colour: &str| {
        let is_biased = setting.bias > 0.5 * setting.rms;
        let fill = if is_biased { "#ffffff" } else { colour };
        let style = format!("fill='{fill}' stroke='{colour}' stroke-width='1.4'");
        let (px, py) = at(setting);
        if setting.elsewhere.is_some() {
            svg.rectangle((px - 3.6, py - 3.6), (7.2, 7.2), &style);
        } else {
            svg.circle((px, py), 3.6, &style);
        }
    };
    let places: Vec<Point> = trade.settings.iter().map(at).collect();
    for (letter, of) in letters().zip(&singles) {
        for setting in of_level(of) {
            point(svg, setting, GREY);
            let place = beside_point(at(setting), &places);
            let ink = format!("fill='{GREY}'");
            svg.styled_text(place, Anchor::Middle, NOTE_SIZE, &letter.to_string(), &ink);
        }
    }
    for (number, of) in levels.iter().enumerate() {
        let pen = Pen::of(number);
        svg.line(&of_level(of).map(at).collect::<Vec<_>>(), &pen.line());
        for setting in of_level(of) {
            point(svg, setting, pen.colour);
        }
    }
    if let Some(chosen) = trade.chosen(tolerance) {
        svg.circle(at(chosen), 9.0, "fill='none' stroke='#1a1a1a' stroke-width='1.8'");
        let (px, py) = at(chosen);
        let text = format!("{}, {}", chosen.level, chosen.setting);
        let width = text_width(&text, NOTE_SIZE);
        let fits = px + 14.0 + width <= right;
        let from = if fits { px + 14.0 } else { px - 14.0 - width };
        note(svg, (from, py + 16.0), &text);
    }
    Ok(page.svg.finish())
}

/// Where a letter stands beside a point: on the side that is farthest from other points.
fn beside_point((x, y): Point, all: &[Point]) -> Point {
    let room = |&(left, down): &Point| {
        let distance = |(px, py): Point| (px - x - left).hypot(py - y - down);
        let others = all.iter().copied().filter(|&other| other != (x, y));
        others.map(distance).fold(f64::INFINITY, f64::min)
    };
    let sides = [(9.0, 0.0), (-9.0, 0.0), (0.0, -10.0), (0.0, 10.0)];
    let side = sides.into_iter().max_by(|a, b| room(a).total_cmp(&room(b)));
    let (left, down) = side.expect("there are four");
    (x + left, y + down + 4.0)
}

/// A note on a white ground.
fn note(svg: &mut Svg, (x, y): Point, text: &str) {
    let size = (text_width(text, NOTE_SIZE) + 4.0, NOTE_SIZE + 3.0);
    svg.rectangle((x - 2.0, y - NOTE_SIZE), size, "fill='#ffffff' fill-opacity='0.75'");
    svg.text((x, y), Anchor::Start, NOTE_SIZE, text);
}
