//! Small charts on one page: error against what is swept, and where the tool speaks.

use super::svg::{Anchor, Point, Svg, shortened, text_width, wrapped};

/// One small chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Heading.
    pub title: String,
    /// What is on the horizontal axis, with its unit.
    pub swept: String,
    /// Whether that axis is logarithmic; 0 is put at its left end then.
    pub log: bool,
    /// The points, ascending.
    pub marks: Vec<Mark>,
    /// Why there are none, if so.
    pub left_out: Option<String>,
}

/// One point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Place on the horizontal axis.
    pub x: f64,
    /// Place on the vertical axis; `None` where there was no result.
    pub error: Option<f64>,
    /// The error that is allowed.
    pub allowed: f64,
    /// Whether something was said of it.
    pub is_said: bool,
    /// Whether the error is more than is allowed.
    pub is_broken: bool,
}

const COLUMNS: usize = 4;
const CELL: (f64, f64) = (318.0, 262.0);
/// The plot within its cell: left, top, right, bottom.
const PLOT: (f64, f64, f64, f64) = (52.0, 52.0, 302.0, 204.0);
const HEAD: f64 = 74.0;
/// Ends of the vertical axis, powers of ten. What is less lies on the lower end.
const POWERS: (f64, f64) = (-5.0, 0.0);
/// Room above the axis for points without a result.
const REFUSED: f64 = 16.0;

const LINE: &str = "#0072b2";
const SAID: &str = "#e69f00";
const BROKEN: &str = "#f6d5c5";
const GREY: &str = "#777777";

/// Draws the panels in rows of four.
pub fn atlas_svg(title: &str, panels: &[Panel]) -> String {
    let rows = panels.len().div_ceil(COLUMNS);
    let width = CELL.0 * COLUMNS as f64 + 12.0;
    let mut svg = Svg::new(width, HEAD + CELL.1 * rows as f64, title);
    svg.text((16.0, 26.0), Anchor::Start, 17.0, title);
    key(&mut svg);
    for (i, panel) in panels.iter().enumerate() {
        let at = ((i % COLUMNS) as f64 * CELL.0 + 6.0, HEAD + (i / COLUMNS) as f64 * CELL.1);
        draw(&mut svg, panel, at);
    }
    svg.finish()
}

fn key(svg: &mut Svg) {
    let (mut x, y) = (16.0, 50.0);
    let mut entry = |sample: &dyn Fn(&mut Svg, f64), words: &str| {
        sample(svg, x);
        svg.text((x + 30.0, y + 4.0), Anchor::Start, 12.5, words);
        x += 30.0 + text_width(words, 12.5) * 0.92 + 16.0;
    };
    entry(
        &|svg, x| {
            svg.line(&[(x, y), (x + 24.0, y)], &format!("stroke='{LINE}' stroke-width='1.6'"));
            dot(svg, (x + 12.0, y), false);
        },
        "error of the result (0 lies at the foot)",
    );
    entry(
        &|svg, x| {
            svg.line(&[(x, y), (x + 24.0, y)], &allowed_style());
        },
        "allowed: twice what the result claims",
    );
    entry(
        &|svg, x| {
            svg.rectangle((x, y - 7.0), (24.0, 14.0), &format!("fill='{BROKEN}'"));
        },
        "the error is beyond that: it breaks",
    );
    entry(&|svg, x| dot(svg, (x + 12.0, y), true), "the tool says so");
    entry(&|svg, x| cross(svg, (x + 12.0, y)), "the tool refuses");
}

fn allowed_style() -> String {
    format!("stroke='{GREY}' stroke-width='1.2' stroke-dasharray='4 3'")
}

fn dot(svg: &mut Svg, at: Point, is_said: bool) {
    let fill = if is_said { SAID } else { "#ffffff" };
    let radius = if is_said { 4.6 } else { 3.0 };
    svg.circle(at, radius, &format!("fill='{fill}' stroke='{LINE}' stroke-width='1.2'"));
}

fn cross(svg: &mut Svg, (x, y): Point) {
    for rise in [-4.0, 4.0] {
        let style = "stroke='#d55e00' stroke-width='2.2'";
        svg.line(&[(x - 4.0, y - rise), (x + 4.0, y + rise)], style);
    }
}

/// The horizontal axis of one panel.
struct Across {
    log: bool,
    low: f64,
    high: f64,
    /// What stands for 0 where the axis is logarithmic.
    zero: f64,
}

impl Across {
    fn new(panel: &Panel) -> Self {
        let xs = || panel.marks.iter().map(|mark| mark.x);
        if !panel.log {
            let (low, high) = xs().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
            return Self { log: false, low, high, zero: 0.0 };
        }
        let positive = xs().filter(|x| *x > 0.0).map(f64::log10);
        let (low, high) = positive.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        let zero = low - (0.12 * (high - low)).max(0.3);
        Self { log: true, low: if xs().any(|x| x == 0.0) { zero } else { low }, high, zero }
    }

    /// From 0 to 1.
    fn place(&self, x: f64) -> f64 {
        let x = match (self.log, x) {
            (true, 0.0) => self.zero,
            (true, x) => x.log10(),
            (false, x) => x,
        };
        (x - self.low) / (self.high - self.low).max(1e-12)
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        if !self.log {
            let step = super::axis::round_step(self.high - self.low, 6.0);
            let digits = (-step.log10() - 1e-9).ceil().max(0.0) as usize;
            let (first, last) =
                ((self.low / step - 1e-6).ceil(), (self.high / step + 1e-6).floor());
            return (first as i64..=last as i64)
                .map(|i| i as f64 * step + 0.0)
                .map(|x| (x, format!("{x:.digits$}")))
                .collect();
        }
        let low = if self.low == self.zero { self.zero + 1e-9 } else { self.low };
        let (first, last) = ((low - 1e-6).ceil() as i32, (self.high + 1e-6).floor() as i32);
        let step = ((last - first) / 6 + 1).max(1);
        let mut ticks: Vec<(f64, String)> = (first..=last)
            .filter(|power| power.rem_euclid(step) == 0)
            .map(|power| (10f64.powi(power), power_label(power)))
            .collect();
        if self.low == self.zero {
            ticks.insert(0, (0.0, "0".into()));
        }
        ticks
    }
}

fn power_label(power: i32) -> String {
    match power {
        0..=3 => format!("{}", 10_u32.pow(power as u32)),
        -3..=-1 => format!("{}", 10f64.powi(power)),
        _ => format!("1e{power}"),
    }
}

fn draw(svg: &mut Svg, panel: &Panel, (left, top): Point) {
    let (x0, y0, x1, y1) = (left + PLOT.0, top + PLOT.1, left + PLOT.2, top + PLOT.3);
    for (i, line) in wrapped(&panel.title, 13.0, CELL.0 - 14.0).iter().take(2).enumerate() {
        let at = (left + 8.0, top + 16.0 + 16.0 * i as f64);
        svg.styled_text(at, Anchor::Start, 13.0, line, "font-weight='bold'");
    }
    if let Some(reason) = &panel.left_out {
        let reason = format!("left out: {reason}");
        for (i, line) in wrapped(&reason, 12.0, x1 - x0 - 20.0).iter().take(6).enumerate() {
            svg.text((x0 + 10.0, y0 + 30.0 + 16.0 * i as f64), Anchor::Start, 12.0, line);
        }
        svg.rectangle((x0, y0), (x1 - x0, y1 - y0), &format!("fill='none' stroke='{GREY}'"));
        return;
    }
    let across = Across::new(panel);
    // Points at the ends keep off the frame.
    let place = |x: f64| x0 + 9.0 + (x1 - x0 - 18.0) * across.place(x);
    let height = |error: f64| {
        let power = error.max(1e-300).log10().clamp(POWERS.0, POWERS.1);
        y1 - (y1 - y0 - REFUSED) * (power - POWERS.0) / (POWERS.1 - POWERS.0)
    };
    shade(svg, panel, &place, (x0, x1), (y0 + REFUSED, y1));
    svg.rectangle(
        (x0, y0 + REFUSED),
        (x1 - x0, y1 - y0 - REFUSED),
        &format!("fill='none' stroke='{GREY}'"),
    );
    for power in (POWERS.0 as i32)..=(POWERS.1 as i32) {
        let y = height(10f64.powi(power));
        svg.line(&[(x0 - 4.0, y), (x0, y)], &format!("stroke='{GREY}'"));
        svg.text((x0 - 6.0, y + 4.0), Anchor::End, 11.0, &power_label(power));
    }
    for (x, label) in across.ticks() {
        svg.line(&[(place(x), y1), (place(x), y1 + 4.0)], &format!("stroke='{GREY}'"));
        svg.text((place(x), y1 + 16.0), Anchor::Middle, 11.0, &label);
    }
    svg.upright_text((left + 14.0, f64::midpoint(y0 + REFUSED, y1)), 11.5, "error");
    for (i, line) in wrapped(&panel.swept, 11.5, CELL.0 - 24.0).iter().take(2).enumerate() {
        let at = (f64::midpoint(x0, x1), y1 + 32.0 + 13.0 * i as f64);
        svg.text(at, Anchor::Middle, 11.5, &shortened(line, 11.5, CELL.0));
    }
    let given: Vec<(&Mark, f64)> =
        panel.marks.iter().filter_map(|mark| Some((mark, mark.error?))).collect();
    let line = |of: &dyn Fn(&Mark, f64) -> f64| -> Vec<Point> {
        given.iter().map(|(mark, error)| (place(mark.x), height(of(mark, *error)))).collect()
    };
    if given.iter().any(|(mark, _)| mark.allowed > 0.0) {
        svg.line(&line(&|mark, _| mark.allowed), &allowed_style());
    }
    svg.line(&line(&|_, error| error), &format!("stroke='{LINE}' stroke-width='1.6'"));
    for (mark, error) in &given {
        dot(svg, (place(mark.x), height(*error)), mark.is_said);
    }
    for mark in panel.marks.iter().filter(|mark| mark.error.is_none()) {
        cross(svg, (place(mark.x), y0 + REFUSED / 2.0));
    }
}

/// Shades where it breaks, half-way to the neighbours that do not.
fn shade(
    svg: &mut Svg,
    panel: &Panel,
    place: &dyn Fn(f64) -> f64,
    (x0, x1): (f64, f64),
    (top, bottom): (f64, f64),
) {
    for (i, mark) in panel.marks.iter().enumerate().filter(|(_, mark)| mark.is_broken) {
        let half_way = |other: Option<&Mark>, end: f64| {
            other.map_or(end, |other| f64::midpoint(place(mark.x), place(other.x)))
        };
        let from = half_way(i.checked_sub(1).map(|before| &panel.marks[before]), x0);
        let to = half_way(panel.marks.get(i + 1), x1);
        svg.rectangle((from, top), (to - from, bottom - top), &format!("fill='{BROKEN}'"));
        let _ = mark;
    }
}
