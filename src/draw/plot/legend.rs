//! Pens of the curves, and the legend that names them.

use super::svg::{Anchor, Svg, shortened, text_width};

/// Okabe and Ito's colours, distinct with every kind of colour vision, without their yellow, which
/// is faint on white.
const COLOURS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"];
/// Further curves have the same colours with these dashes.
const DASHES: [&str; 4] = ["none", "7 3", "2 2.5", "9 3 2 3"];

/// Colour and dashes of one curve.
pub(crate) struct Pen {
    pub colour: &'static str,
    dash: &'static str,
}

impl Pen {
    /// The pen of a curve, by its number in the chart.
    pub(crate) fn of(curve: usize) -> Self {
        Self {
            colour: COLOURS[curve % COLOURS.len()],
            dash: DASHES[curve / COLOURS.len() % DASHES.len()],
        }
    }

    /// SVG attributes of the curve's line.
    pub(crate) fn line(&self) -> String {
        let Self { colour, dash } = self;
        format!(
            "stroke='{colour}' stroke-width='1.6' stroke-dasharray='{dash}' \
             stroke-linejoin='round'"
        )
    }

    /// SVG attributes of the band about the line.
    pub(crate) fn band(&self) -> String {
        format!("fill='{}' fill-opacity='0.25'", self.colour)
    }
}

/// Rows of curve names above the plot.
pub(crate) struct Legend {
    entries: Vec<Entry>,
}

struct Entry {
    curve: usize,
    row: usize,
    left: f64,
    text: String,
}

impl Legend {
    const SIZE: f64 = 12.5;
    const ROW: f64 = 19.0;
    const SAMPLE: f64 = 26.0;
    const GAP: f64 = 18.0;

    /// Sets the labels in rows between two places. A curve without a label is left out.
    pub(crate) fn new<'a>(labels: impl Iterator<Item = &'a str>, (from, to): (f64, f64)) -> Self {
        let sample = Self::SAMPLE + 6.0;
        let (mut row, mut left, mut entries) = (0, from, Vec::new());
        for (curve, label) in labels.enumerate().filter(|(_, label)| !label.is_empty()) {
            let text = shortened(label, Self::SIZE, to - from - sample);
            let width = sample + text_width(&text, Self::SIZE);
            if left > from && left + width > to {
                (row, left) = (row + 1, from);
            }
            entries.push(Entry { curve, row, left, text });
            left += width + Self::GAP;
        }
        Self { entries }
    }

    /// Height of the rows.
    pub(crate) fn height(&self) -> f64 {
        self.entries.last().map_or(0.0, |entry| Self::ROW * (entry.row + 1) as f64)
    }

    /// Draws samples of the lines, those of curves with a band on theirs, and the labels.
    pub(crate) fn draw(&self, svg: &mut Svg, top: f64, with_band: impl Fn(usize) -> bool) {
        for Entry { curve, row, left, text } in &self.entries {
            let baseline = top + 13.0 + Self::ROW * *row as f64;
            let (pen, middle) = (Pen::of(*curve), baseline - 4.3);
            if with_band(*curve) {
                svg.rectangle((*left, middle - 4.0), (Self::SAMPLE, 8.0), &pen.band());
            }
            svg.line(&[(*left, middle), (left + Self::SAMPLE, middle)], &pen.line());
            svg.text((left + Self::SAMPLE + 6.0, baseline), Anchor::Start, Self::SIZE, text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_label_has_its_place_between_the_ends() {
        let labels: Vec<String> = (0..12).map(|i| "x".repeat(3 + 20 * (i % 5))).collect();
        let legend = Legend::new(labels.iter().map(String::as_str), (60.0, 500.0));
        assert_eq!(legend.entries.len(), labels.len());
        for pair in legend.entries.windows(2) {
            let end = pair[0].left + Legend::SAMPLE + text_width(&pair[0].text, Legend::SIZE);
            assert!(end <= 500.0);
            assert!(pair[1].row > pair[0].row || pair[1].left > end);
        }
        assert!(Legend::new(["", ""].into_iter(), (60.0, 500.0)).height() < 1e-12);
    }

    #[test]
    fn pens_differ_for_as_many_curves_as_colours_and_dashes_give() {
        let pens: std::collections::HashSet<String> = (0..28).map(|i| Pen::of(i).line()).collect();
        assert_eq!(pens.len(), 28);
    }
}
