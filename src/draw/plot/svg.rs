//! Shapes and texts, written as SVG.

/// The contained font first, then those of browsers.
const FONT_FAMILY: &str = "Ubuntu, 'DejaVu Sans', Arial, sans-serif";

/// A point of the drawing: x to the right, y downwards, in SVG user units.
pub(crate) type Point = (f64, f64);

/// The end of a text that its point is.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing. `style` is always a list of SVG attributes.
pub(crate) struct Svg {
    text: String,
}

impl Svg {
    /// A white page; `title` is for screen readers.
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        let mut svg = Self::clear(width, height, title);
        svg.rectangle((0.0, 0.0), (width, height), "fill='#ffffff'");
        svg
    }

    /// A transparent page, to lie over a picture.
    pub(crate) fn clear(width: f64, height: f64, title: &str) -> Self {
        let [w, h] = [width, height].map(number);
        let title = escaped(title);
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\" role=\"img\" font-family=\"{FONT_FAMILY}\" \
             fill=\"#1a1a1a\">\n<title>{title}</title>\n"
        );
        Self { text }
    }

    pub(crate) fn finish(self) -> String {
        self.text + "</svg>\n"
    }

    pub(crate) fn rectangle(&mut self, (x, y): Point, (width, height): Point, style: &str) {
        let [x, y, width, height] = [x, y, width, height].map(number);
        self.push(&format!("<rect x='{x}' y='{y}' width='{width}' height='{height}' {style}/>"));
    }

    pub(crate) fn circle(&mut self, (x, y): Point, radius: f64, style: &str) {
        let [x, y, radius] = [x, y, radius].map(number);
        self.push(&format!("<circle cx='{x}' cy='{y}' r='{radius}' {style}/>"));
    }

    pub(crate) fn line(&mut self, points: &[Point], style: &str) {
        self.push(&format!("<polyline points='{}' fill='none' {style}/>", listed(points)));
    }

    pub(crate) fn area(&mut self, points: &[Point], style: &str) {
        self.push(&format!("<polygon points='{}' {style}/>", listed(points)));
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
        let [x, y, size] = [x, y, size].map(number);
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let content = escaped(content);
        self.push(&format!(
            "<text x='{x}' y='{y}' font-size='{size}' text-anchor='{anchor}' {style}>\
             {content}</text>"
        ));
    }

    /// Lines below each other, the first at a point.
    pub(crate) fn lines(
        &mut self,
        (x, y): Point,
        anchor: Anchor,
        (size, apart): (f64, f64),
        lines: &[String],
        style: &str,
    ) {
        for (i, line) in lines.iter().enumerate() {
            self.styled_text((x, y + apart * i as f64), anchor, size, line, style);
        }
    }

    /// What lies between two lines.
    pub(crate) fn band(&mut self, mut upper: Vec<Point>, lower: Vec<Point>, style: &str) {
        upper.extend(lower.into_iter().rev());
        self.area(&upper, style);
    }

    /// Text that runs upwards, centred at a point.
    pub(crate) fn upright_text(&mut self, (x, y): Point, size: f64, content: &str) {
        let turn = format!("transform='rotate(-90 {} {})'", number(x), number(y));
        self.styled_text((x, y), Anchor::Middle, size, content, &turn);
    }

    fn push(&mut self, element: &str) {
        self.text += element;
        self.text.push('\n');
    }
}

/// A coordinate to a hundredth of a pixel. Adding zero turns -0 into 0.
fn number(x: f64) -> f64 {
    (x * 100.0).round() / 100.0 + 0.0
}

fn listed(points: &[Point]) -> String {
    let pair = |&(x, y): &Point| format!("{},{}", number(x), number(y));
    points.iter().map(pair).collect::<Vec<_>>().join(" ")
}

/// Text for XML, which cannot hold control characters: they become blanks.
fn escaped(text: &str) -> String {
    let valid = |c: char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    let text: String = text.chars().map(|c| if valid(c) { c } else { ' ' }).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Upper bound of a text's width: in `DejaVu Sans`, the widest of the fonts.
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

/// Breaks a text between words into lines no wider than `width`. A longer word is cut.
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

/// The text, cut with an ellipsis if it is wider than `width`.
pub(crate) fn shortened(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut short = text.to_owned();
    while short.pop().is_some() && text_width(&short, size) + size > width {}
    short + "…"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_numbers_are_short_without_negative_zero() {
        assert_eq!(escaped("a<b & \"c\"\u{1}\n>"), "a&lt;b &amp; \"c\"  &gt;");
        assert_eq!(number(-0.001).to_string(), "0");
        assert_eq!(number(12.346).to_string(), "12.35");
        assert_eq!(number(300.0).to_string(), "300");
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
