//! Shapes and texts, written as SVG.

use std::fmt::{self, Display, Write};

/// The carried font first, then what browsers have.
const FONT_FAMILY: &str = "Ubuntu, 'DejaVu Sans', Arial, sans-serif";

/// A point of the drawing: x to the right, y downwards, in SVG user units.
pub(crate) type Point = (f64, f64);

/// Which end of a text its point is.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing under way. `style` is always a list of SVG attributes.
pub(crate) struct Svg {
    text: String,
}

impl Svg {
    /// A white page; `title` is what screen readers say.
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        let mut svg = Self::clear(width, height, title);
        svg.rectangle((0.0, 0.0), (width, height), "fill='#ffffff'");
        svg
    }

    /// A page without colour, to lie over a picture.
    pub(crate) fn clear(width: f64, height: f64, title: &str) -> Self {
        let mut svg = Self { text: String::new() };
        let (w, h) = (Number(width), Number(height));
        svg.push(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" role=\"img\" font-family=\"{FONT_FAMILY}\" fill=\"#1a1a1a\">"
        ));
        svg.push(format_args!("<title>{}</title>", Escaped(title)));
        svg
    }

    pub(crate) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    pub(crate) fn rectangle(&mut self, (x, y): Point, (width, height): Point, style: &str) {
        let [x, y, width, height] = [x, y, width, height].map(Number);
        self.push(format_args!(
            "<rect x='{x}' y='{y}' width='{width}' height='{height}' {style}/>"
        ));
    }

    pub(crate) fn circle(&mut self, (x, y): Point, radius: f64, style: &str) {
        let [x, y, radius] = [x, y, radius].map(Number);
        self.push(format_args!("<circle cx='{x}' cy='{y}' r='{radius}' {style}/>"));
    }

    pub(crate) fn line(&mut self, points: &[Point], style: &str) {
        self.push(format_args!("<polyline points='{}' fill='none' {style}/>", Points(points)));
    }

    pub(crate) fn area(&mut self, points: &[Point], style: &str) {
        self.push(format_args!("<polygon points='{}' {style}/>", Points(points)));
    }

    pub(crate) fn text(&mut self, at: Point, anchor: Anchor, size: f64, content: &str) {
        self.styled_text(at, anchor, size, content, "");
    }

    pub(crate) fn styled_text(
        &mut self,
        (x, y): Point,
        anchor: Anchor,
        size: f64,
        content: &str,
        style: &str,
    ) {
        let [x, y, size] = [x, y, size].map(Number);
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.push(format_args!(
            "<text x='{x}' y='{y}' font-size='{size}' text-anchor='{anchor}' {style}>{}</text>",
            Escaped(content)
        ));
    }

    /// Text that runs upwards, centred at a point.
    pub(crate) fn upright_text(&mut self, (x, y): Point, size: f64, content: &str) {
        let turn = format!("transform='rotate(-90 {} {})'", Number(x), Number(y));
        self.styled_text((x, y), Anchor::Middle, size, content, &turn);
    }

    fn push(&mut self, element: fmt::Arguments) {
        writeln!(self.text, "{element}").expect("a String takes all");
    }
}

/// Width of a text, rather too large than too small: in `DejaVu Sans`, the widest of the fonts.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let ems = |c: char| match c {
        'i' | 'j' | 'l' => 0.28,
        ' ' | '.' | ',' | ':' | ';' | '\'' | '-' | '/' | '|' | 'f' | 't' | '(' | ')' | 'I' => 0.38,
        'm' | 'w' | 'M' | 'W' | '%' => 0.96,
        c if c.is_ascii_lowercase() || c.is_ascii_digit() => 0.62,
        c if c.is_ascii() => 0.74,
        '–' | 'µ' => 0.6,
        _ => 1.0,
    };
    text.chars().map(ems).sum::<f64>() * size
}

/// Breaks a text between words into lines no wider than `width`; a longer word is cut.
pub(crate) fn wrapped(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        if let Some(line) = lines.last_mut()
            && text_width(line, size) + text_width(" ", size) + text_width(word, size) <= width
        {
            *line += " ";
            *line += word;
        } else {
            lines.push(shortened(word, size, width));
        }
    }
    lines
}

/// The text, or as much of its beginning as `width` holds and an ellipsis.
pub(crate) fn shortened(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut short = text.to_owned();
    while short.pop().is_some() && text_width(&short, size) + size > width {}
    short + "…"
}

/// A coordinate: two digits are a hundredth of a pixel.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        // Adding zero turns -0 into 0.
        write!(f, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}

struct Points<'a>(&'a [Point]);

impl Display for Points<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (i, &(x, y)) in self.0.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}{},{}", Number(x), Number(y))?;
        }
        Ok(())
    }
}

/// Text as XML takes it; control characters, which XML has no way to write, become spaces.
struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => f.write_char(' '),
            c => f.write_char(c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(Escaped("a<b & \"c\"\u{1}\n>").to_string(), "a&lt;b &amp; \"c\"  &gt;");
    }

    #[test]
    fn numbers_are_short_and_have_no_negative_zero() {
        assert_eq!(Number(-0.001).to_string(), "0");
        assert_eq!(Number(12.346).to_string(), "12.35");
        assert_eq!(Number(300.0).to_string(), "300");
    }

    #[test]
    fn lines_hold_every_word_and_keep_the_width() {
        let text = "one two three four five six seven eight nine ten";
        let lines = wrapped(text, 10.0, 100.0);
        assert!(lines.len() > 1 && lines.iter().all(|l| text_width(l, 10.0) <= 100.0));
        assert_eq!(lines.join(" "), text);
        assert!(wrapped("", 10.0, 100.0).is_empty());
    }

    #[test]
    fn a_long_word_is_cut() {
        let cut = shortened(&"µ".repeat(500), 10.0, 100.0);
        assert!(cut.ends_with('…') && text_width(&cut, 10.0) <= 100.0, "{cut}");
        assert_eq!(shortened("short", 10.0, 100.0), "short");
    }
}
