//! A picture of convex bodies: each of a few kinds in a row, from three sides and in its variants.

use super::svg::{Anchor, Point, Svg};

/// A convex polyhedron about the origin; its length, breadth and thickness lie along x, y and z.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Corners, um.
    pub vertices_um: Vec<[f64; 3]>,
    /// Corners of each facet, counter-clockwise seen from outside.
    pub facets: Vec<Vec<usize>>,
}

/// One kind of body.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// What is said of it, line by line.
    pub lines: Vec<String>,
    /// Its variants: the first is seen from three sides, the others along their thickness. One at least.
    pub solids: Vec<Solid>,
}

/// Variants that are drawn beside the first.
const MOST_OTHERS: usize = 3;

/// Sides from which a body is seen, with the axes that run rightwards, upwards and to the viewer.
const VIEWS: [(&str, [usize; 3]); 3] =
    [("along S", [0, 1, 2]), ("along I", [2, 0, 1]), ("along L", [1, 2, 0])];

const CELL: f64 = 150.0;
const LABELS: f64 = 190.0;
const HEADING: f64 = 34.0;
const EDGE: f64 = 16.0;
/// Share of a cell that the longest body of a row fills.
const FILLED: f64 = 0.9;

/// Light from the upper left, behind the viewer; x rightwards, y upwards, z to the viewer.
const LIGHT: [f64; 3] = [-0.53, 0.57, 0.63];
/// Brightness of a facet turned away from the light. In between it rises with the cosine, without a shadow, so
/// that every facet stands out from its neighbours.
const DARKEST: f64 = 0.15;
const COLOUR: [f64; 3] = [244.0, 233.0, 212.0];

/// The picture as SVG; every row has a scale, and a bar for it, of its own.
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
    let x = solid.vertices_um.iter().map(|v| v[0]);
    x.clone().fold(f64::MIN, f64::max) - x.fold(f64::MAX, f64::min)
}

fn labels(svg: &mut Svg, row: &Row, top: f64, scale: f64) {
    let mut y = top + 30.0;
    svg.text((EDGE, y), Anchor::Start, 14.0, &row.name);
    for line in &row.lines {
        y += 17.0;
        svg.text((EDGE, y), Anchor::Start, 11.0, line);
    }
    let bar_um = bar_um(0.4 * CELL / scale);
    let (left, right, y) = (EDGE, EDGE + bar_um * scale, y + 20.0);
    svg.line(&[(left, y), (right, y)], "stroke='#1a1a1a' stroke-width='2'");
    let text = format!("{bar_um} µm");
    svg.text((right + 6.0, y + 4.0), Anchor::Start, 11.0, &text);
}

/// The longest of 1, 2 and 5 times a power of ten that is not above this.
fn bar_um(most_um: f64) -> f64 {
    let ten = 10f64.powf(most_um.log10().floor());
    [5.0, 2.0].map(|times| times * ten).into_iter().find(|&um| um <= most_um).unwrap_or(ten)
}

/// The facets that face the viewer; of a convex body none of them hides another.
fn draw(svg: &mut Svg, solid: &Solid, axes: [usize; 3], (x, y): Point, scale: f64) {
    let seen = |corner: usize| axes.map(|axis| solid.vertices_um[corner][axis]);
    // The view's middle is the middle of the outline, so that long bodies stay in their cells.
    let [across, up] = [0, 1].map(|axis| {
        let all = (0..solid.vertices_um.len()).map(|corner| seen(corner)[axis]);
        f64::midpoint(all.clone().fold(f64::MIN, f64::max), all.fold(f64::MAX, f64::min))
    });
    for facet in &solid.facets {
        let normal = normal(&facet.iter().map(|&corner| seen(corner)).collect::<Vec<_>>());
        if normal[2] <= 0.0 {
            continue;
        }
        let lit: f64 = normal.iter().zip(LIGHT).map(|(n, l)| n * l).sum();
        let light = DARKEST + (1.0 - DARKEST) * f64::midpoint(1.0, lit);
        let [red, green, blue] = COLOUR.map(|channel| (channel * light).round() as u8);
        let points: Vec<Point> = facet
            .iter()
            .map(|&corner| {
                let [right, higher, _] = seen(corner);
                (x + (right - across) * scale, y - (higher - up) * scale)
            })
            .collect();
        let fill = format!("#{red:02x}{green:02x}{blue:02x}");
        let style = format!(
            "fill='{fill}' stroke='#2b2118' stroke-opacity='0.55' stroke-width='0.5' \
             stroke-linejoin='round'"
        );
        svg.area(&points, &style);
    }
}

/// Unit normal of a polygon, by Newell's sum over its sides.
fn normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        for (axis, sum) in sum.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += (a[u] - b[u]) * (a[v] + b[v]);
        }
    }
    let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
    sum.map(|x| x / length.max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brick() -> Solid {
        let vertices_um = (0..8)
            .map(|i| [(4, 3.0), (2, 2.0), (1, 1.0)].map(|(b, h)| if i & b > 0 { h } else { -h }))
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
            let outward: f64 = normal.iter().zip(corners[0]).map(|(n, c)| n * c).sum();
            assert!(outward > 0.0, "{facet:?}: {normal:?}");
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

    #[test]
    fn bars_are_round_numbers() {
        assert_eq!([1.0, 4.9, 30.0, 99.0, 700.0].map(bar_um), [1.0, 2.0, 20.0, 50.0, 500.0]);
    }
}
