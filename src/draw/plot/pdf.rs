//! Charts as PDF, from their SVG. Texts become outlines, so that no font is needed.

use std::collections::BTreeMap;

use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref};
use resvg::tiny_skia::PathSegment;
use resvg::usvg::{Color, Fill, FillRule, Group, LineCap, LineJoin, Node, Paint, Path, Stroke};

use super::PlotError;
use super::raster::tree;

/// Points of a page in a unit of the SVG: a CSS pixel.
const POINTS: f32 = 0.75;

/// Renders SVG text as a page of PDF. The same text gives the same bytes.
///
/// # Errors
/// The text is not SVG.
pub fn pdf(svg: &str) -> Result<Vec<u8>, PlotError> {
    let tree = tree(svg)?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|units| units * POINTS);
    let [catalog, pages, page_id, content_id] = [1, 2, 3, 4].map(Ref::new);
    let mut page = Page { content: Content::new(), alphas: BTreeMap::new() };
    page.content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, height]);
    page.group(tree.root());
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page_id]).count(1);
    let state = |number: usize| (format!("a{number}"), Ref::new(5 + number as i32));
    let mut of_page = pdf.page(page_id);
    of_page.parent(pages).media_box(Rect::new(0.0, 0.0, width, height)).contents(content_id);
    let mut resources = of_page.resources();
    let mut states = resources.ext_g_states();
    for &number in page.alphas.values() {
        let (name, id) = state(number);
        states.pair(Name(name.as_bytes()), id);
    }
    states.finish();
    resources.finish();
    of_page.finish();
    for (&thousandths, &number) in &page.alphas {
        let alpha = f32::from(thousandths) / 1000.0;
        pdf.ext_graphics(state(number).1).non_stroking_alpha(alpha).stroking_alpha(alpha);
    }
    pdf.stream(content_id, &page.content.finish());
    Ok(pdf.finish())
}

struct Page {
    content: Content,
    /// Numbers of the opacities used, by thousandths.
    alphas: BTreeMap<u16, usize>,
}

impl Page {
    fn group(&mut self, group: &Group) {
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group),
                Node::Path(path) if path.is_visible() => self.path(path),
                Node::Text(text) => self.group(text.flattened()),
                Node::Path(_) | Node::Image(_) => {}
            }
        }
    }

    fn path(&mut self, path: &Path) {
        if let Some(fill) = path.fill() {
            self.filled(path, fill);
        }
        if let Some(stroke) = path.stroke() {
            self.stroked(path, stroke);
        }
    }

    fn filled(&mut self, path: &Path, fill: &Fill) {
        let Some([r, g, b]) = rgb(fill.paint()) else { return };
        self.begin(path, fill.opacity().get());
        self.content.set_fill_rgb(r, g, b);
        self.outline(path);
        match fill.rule() {
            FillRule::NonZero => self.content.fill_nonzero(),
            FillRule::EvenOdd => self.content.fill_even_odd(),
        };
        self.content.restore_state();
    }

    fn stroked(&mut self, path: &Path, stroke: &Stroke) {
        let Some([r, g, b]) = rgb(stroke.paint()) else { return };
        self.begin(path, stroke.opacity().get());
        self.content.set_stroke_rgb(r, g, b).set_line_width(stroke.width().get());
        self.content.set_line_join(match stroke.linejoin() {
            LineJoin::Round => LineJoinStyle::RoundJoin,
            LineJoin::Bevel => LineJoinStyle::BevelJoin,
            LineJoin::Miter | LineJoin::MiterClip => LineJoinStyle::MiterJoin,
        });
        self.content.set_line_cap(match stroke.linecap() {
            LineCap::Butt => LineCapStyle::ButtCap,
            LineCap::Round => LineCapStyle::RoundCap,
            LineCap::Square => LineCapStyle::ProjectingSquareCap,
        });
        if let Some(dashes) = stroke.dasharray() {
            self.content.set_dash_pattern(dashes.iter().copied(), stroke.dashoffset());
        }
        self.outline(path);
        self.content.stroke();
        self.content.restore_state();
    }

    /// Saves the state, takes the place of a path and its opacity.
    fn begin(&mut self, path: &Path, opacity: f32) {
        self.content.save_state();
        let to = path.abs_transform();
        if !to.is_identity() {
            self.content.transform([to.sx, to.ky, to.kx, to.sy, to.tx, to.ty]);
        }
        if opacity < 1.0 {
            let next = self.alphas.len();
            let number = *self.alphas.entry((1000.0 * opacity).round() as u16).or_insert(next);
            self.content.set_parameters(Name(format!("a{number}").as_bytes()));
        }
    }

    fn outline(&mut self, path: &Path) {
        let content = &mut self.content;
        let mut last = (0.0, 0.0);
        for segment in path.data().segments() {
            match segment {
                PathSegment::MoveTo(p) => {
                    content.move_to(p.x, p.y);
                    last = (p.x, p.y);
                }
                PathSegment::LineTo(p) => {
                    content.line_to(p.x, p.y);
                    last = (p.x, p.y);
                }
                PathSegment::QuadTo(c, p) => {
                    // The same curve as a cubic one.
                    let third = |from: f32, to: f32| from + 2.0 / 3.0 * (to - from);
                    let (x1, y1) = (third(last.0, c.x), third(last.1, c.y));
                    let (x2, y2) = (third(p.x, c.x), third(p.y, c.y));
                    content.cubic_to(x1, y1, x2, y2, p.x, p.y);
                    last = (p.x, p.y);
                }
                PathSegment::CubicTo(c, d, p) => {
                    content.cubic_to(c.x, c.y, d.x, d.y, p.x, p.y);
                    last = (p.x, p.y);
                }
                PathSegment::Close => {
                    content.close_path();
                }
            }
        }
    }
}

/// A plain colour, 0 to 1; charts have no others.
fn rgb(paint: &Paint) -> Option<[f32; 3]> {
    let Paint::Color(Color { red, green, blue }) = paint else { return None };
    Some([red, green, blue].map(|level| f32::from(*level) / 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_the_size_of_the_chart_and_its_shapes() {
        let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='80' height='40'>\
                   <polygon points='0,0 10,0 10,10' fill='#ff0000' fill-opacity='0.25'/>\
                   <polyline points='0,0 10,10' fill='none' stroke='#000000'/>\
                   <text x='5' y='20' font-size='10'>µ</text></svg>";
        let bytes = pdf(svg).expect("SVG");
        assert_eq!(bytes, pdf(svg).expect("SVG"));
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.starts_with("%PDF-"));
        for part in ["[0 0 60 30]", "1 0 0 rg", "/a0 gs", "/ca 0.25", "\nS\n", "/Type /Page"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        // The letter is an outline.
        assert!(text.matches(" c\n").count() > 4, "{text}");
        assert!(matches!(pdf("no svg"), Err(PlotError::Svg(_))));
    }
}
