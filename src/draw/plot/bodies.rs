//! A picture of convex bodies: a row for each kind, with three views and the variants.

use glam::{DMat3, DVec3};

use super::axis::round_below;
use super::svg::{Anchor, Point, Svg};

/// A convex polyhedron about the origin. Length, breadth and thickness lie along x, y and z.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Corners, um.
    pub vertices_um: Vec<DVec3>,
    /// Corners of each facet, counter-clockwise seen from outside.
    pub facets: Vec<Vec<usize>>,
}

/// One kind of body.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Lines of text below the name.
    pub lines: Vec<String>,
    /// Its variants, at least one. The first has three views, the others one along the thickness.
    pub solids: Vec<Solid>,
}

/// Most variants beside the first.
const MOST_OTHERS: usize = 3;

/// Views of a body, with the axes to the right, upwards and to the viewer.
const VIEWS: [(&str, [DVec3; 3]); 3] = [
    ("along S", [DVec3::X, DVec3::Y, DVec3::Z]),
    ("along I", [DVec3::Z, DVec3::X, DVec3::Y]),
    ("along L", [DVec3::Y, DVec3::Z, DVec3::X]),
];

const CELL: f64 = 150.0;
const LABELS: f64 = 190.0;
const HEADING: f64 = 34.0;
const EDGE: f64 = 16.0;
/// Share of a cell that the longest body of a row fills.
const FILLED: f64 = 0.9;

/// Light from the upper left, behind the viewer. Axes run to the right, upwards and to the viewer.
const LIGHT: DVec3 = DVec3::new(-0.53, 0.57, 0.63);
/// Brightness of a facet turned away from the light. It rises with the cosine, without a shadow, so
/// that every facet differs from its neighbours.
const DARKEST: f64 = 0.15;
const COLOUR: [f64; 3] = [244.0, 233.0, 212.0];

/// The picture as SVG. Every row has its own scale and scale bar.
pub fn bodies_svg(title: &str, rows: &[Row]) -> String {
    let others = rows.iter().map(|row| row.solids.len().saturating_sub(1)).max().unwrap_or(0);
    let columns = VIEWS.len() + others.min(MOST_OTHERS);
    let width = 2.0 * EDGE + LABELS + columns as f64 * CELL;
    let height = 2.0 * EDGE + 2.0 * HEADING + rows.len() as f64 * CELL;
    let mut svg = Svg::new(width, height, title);
    svg.text((EDGE, EDGE + 14.0), Anchor::Start, 15.0, title);
    let middle = |column: usize| EDGE + LABELS + (column as f64 + 0.5) * CELL;
    let headings = VIEWS.map(|(name, _)| name.to_owned()).into_iter();
    for (column, heading) in
        headings.chain((1..).map(|n| format!("variant {n}, along S"))).take(columns).enumerate()
    {
        let at = (middle(column), EDGE + HEADING + 18.0);
        svg.text(at, Anchor::Middle, 12.0, &heading);
    }
    for (number, row) in rows.iter().enumerate() {
        let top = EDGE + 2.0 * HEADING + number as f64 * CELL;
        let scale = FILLED * CELL / row.solids.iter().map(length_um).fold(1e-9, f64::max);
        labels(&mut svg, row, top, scale);
        for column in 0..columns {
            let (solid, axes) = match VIEWS.get(column) {
                Some((_, axes)) => (row.solids.first(), *axes),
                None => (row.solids.get(column - VIEWS.len() + 1), VIEWS[0].1),
            };
            if let Some(solid) = solid {
                draw(&mut svg, solid, axes, (middle(column), top + CELL / 2.0), scale);
            }
        }
    }
    svg.finish()
}

fn length_um(solid: &Solid) -> f64 {
    let x = solid.vertices_um.iter().map(|v| v.x);
    x.clone().fold(f64::MIN, f64::max) - x.fold(f64::MAX, f64::min)
}

fn labels(svg: &mut Svg, row: &Row, top: f64, scale: f64) {
    let mut y = top + 30.0;
    svg.text((EDGE, y), Anchor::Start, 14.0, &row.name);
    for line in &row.lines {
        y += 17.0;
        svg.text((EDGE, y), Anchor::Start, 11.0, line);
    }
    let bar_um = round_below(0.4 * CELL / scale);
    let (left, right, y) = (EDGE, EDGE + bar_um * scale, y + 20.0);
    svg.line(&[(left, y), (right, y)], "stroke='#1a1a1a' stroke-width='2'");
    let text = format!("{bar_um} µm");
    svg.text((right + 6.0, y + 4.0), Anchor::Start, 11.0, &text);
}

/// Draws the facets that face the viewer. Those of a convex body do not hide each other.
fn draw(svg: &mut Svg, solid: &Solid, axes: [DVec3; 3], (x, y): Point, scale: f64) {
    let turn = DMat3::from_cols(axes[0], axes[1], axes[2]).transpose();
    let seen: Vec<DVec3> = solid.vertices_um.iter().map(|&vertex| turn * vertex).collect();
    // The middle of the outline is the middle of the cell, so that long bodies stay in their cells.
    let (min, max) = seen
        .iter()
        .fold((DVec3::MAX, DVec3::MIN), |(min, max), &corner| (min.min(corner), max.max(corner)));
    let middle = min.midpoint(max);
    for facet in &solid.facets {
        let corners: Vec<DVec3> = facet.iter().map(|&corner| seen[corner]).collect();
        let normal = normal(&corners);
        if normal.z <= 0.0 {
            continue;
        }
        let light = DARKEST + (1.0 - DARKEST) * f64::midpoint(1.0, normal.dot(LIGHT));
        let [red, green, blue] = COLOUR.map(|channel| (channel * light).round() as u8);
        let place = |corner: &DVec3| {
            let from_middle = scale * (corner - middle);
            (x + from_middle.x, y - from_middle.y)
        };
        let style = format!(
            "fill='#{red:02x}{green:02x}{blue:02x}' stroke='#2b2118' stroke-opacity='0.55' \
             stroke-width='0.5' stroke-linejoin='round'"
        );
        svg.area(&corners.iter().map(place).collect::<Vec<_>>(), &style);
    }
}

/// Unit normal of a polygon.
fn normal(corners: &[DVec3]) -> DVec3 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.cross(*b)).sum::<DVec3>().normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brick() -> Solid {
        let vertices_um = (0..8)
            .map(|i| {
                let half = [(4, 3.0), (2, 2.0), (1, 1.0)];
                DVec3::from(half.map(|(bit, half)| if i & bit > 0 { half } else { -half }))
            })
            .collect();
        let facets = vec![
            vec![0, 1, 3, 2],
            vec![4, 6, 7, 5],
            vec![0, 4, 5, 1],
            vec![2, 3, 7, 6],
            vec![0, 2, 6, 4],
            vec![1, 5, 7, 3],
        ];
        Solid { vertices_um, facets }
    }

    #[test]
    fn normals_of_a_brick_face_outward() {
        let brick = brick();
        for facet in &brick.facets {
            let corners: Vec<_> = facet.iter().map(|&corner| brick.vertices_um[corner]).collect();
            let normal = normal(&corners);
            assert!(normal.dot(corners[0]) > 0.0, "{facet:?}: {normal:?}");
        }
    }

    #[test]
    fn a_brick_shows_one_side_in_each_view_and_its_lengths_to_scale() {
        let row = Row { name: "brick".into(), lines: Vec::new(), solids: vec![brick()] };
        let svg = bodies_svg("bricks", &[row]);
        let sides: Vec<Vec<Point>> = svg
            .lines()
            .filter_map(|line| line.strip_prefix("<polygon points='"))
            .map(|line| {
                let points = line.split('\'').next().expect("points").split(' ');
                let number = |text: &str| text.parse::<f64>().expect("a number");
                points
                    .map(|point| point.split_once(',').expect("a pair"))
                    .map(|(x, y)| (number(x), number(y)))
                    .collect()
            })
            .collect();
        assert_eq!(sides.len(), 3);
        let size = |side: &[Point], of: fn(&Point) -> f64| {
            side.iter().map(of).fold(f64::MIN, f64::max)
                - side.iter().map(of).fold(f64::MAX, f64::min)
        };
        for (side, wanted) in sides.iter().zip([(6.0, 4.0), (2.0, 6.0), (4.0, 2.0)]) {
            let scale = FILLED * CELL / 6.0;
            assert!((size(side, |p| p.0) - wanted.0 * scale).abs() < 0.02, "{side:?}");
            assert!((size(side, |p| p.1) - wanted.1 * scale).abs() < 0.02, "{side:?}");
        }
    }
}
