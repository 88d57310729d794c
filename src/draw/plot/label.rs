//! Places of labels: near their point, clear of the curve and of other labels.

use super::svg::Point;
use crate::support::math;

/// Distance from a label to what it must not touch.
const MARGIN: f64 = 3.0;

/// A rectangle of the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Area {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Area {
    fn around((x, y): Point, (width, height): Point) -> Self {
        let (w, h) = (0.5 * width, 0.5 * height);
        Self { left: x - w, top: y - h, right: x + w, bottom: y + h }
    }

    fn holds(&self, other: &Self) -> bool {
        self.left <= other.left
            && other.right <= self.right
            && self.top <= other.top
            && other.bottom <= self.bottom
    }

    fn touches(&self, other: &Self) -> bool {
        self.left - MARGIN < other.right
            && other.left - MARGIN < self.right
            && self.top - MARGIN < other.bottom
            && other.top - MARGIN < self.bottom
    }

    /// The point of the rectangle that is nearest to another point.
    pub(crate) fn nearest(&self, (x, y): Point) -> Point {
        (x.clamp(self.left, self.right), y.clamp(self.top, self.bottom))
    }

    /// Whether a curve of points with ascending x enters the rectangle. Its extreme y decide, since
    /// it takes all values between them.
    fn meets(&self, curve: &[Point]) -> bool {
        let (left, right) = (self.left - MARGIN, self.right + MARGIN);
        let (mut top, mut bottom) = (f64::INFINITY, f64::NEG_INFINITY);
        let pairs = curve.windows(2).map(|pair| (pair[0], pair[1]));
        for ((x0, y0), (x1, y1)) in pairs.filter(|((x0, _), (x1, _))| *x1 >= left && *x0 <= right) {
            for x in [x0.max(left), x1.min(right)] {
                let y = if x1 > x0 { y0 + (y1 - y0) * (x - x0) / (x1 - x0) } else { y1 };
                (top, bottom) = (top.min(y), bottom.max(y));
            }
        }
        top < self.bottom + MARGIN && bottom > self.top - MARGIN
    }
}

/// Finds a place for a label near `point`, inside `page`, preferably above or below the point.
pub(crate) fn place(
    point: Point,
    size: Point,
    above: bool,
    page: &Area,
    curve: &[Point],
    taken: &[Area],
) -> Option<Area> {
    let side = if above { -1.0 } else { 1.0 };
    let places = (-8..=8).flat_map(|column| (-20..=20).map(move |row| (column, row)));
    let candidates = places.filter_map(|(column, row)| {
        let (dx, dy) = (0.18 * size.0 * f64::from(column), 5.0 * f64::from(row));
        let area = Area::around((point.0 + dx, point.1 + dy), size);
        let (x, y) = area.nearest(point);
        let distance = math::hypot(x - point.0, y - point.1);
        let wrong_side = if dy * side > 0.0 { 0.0 } else { 25.0 };
        let cost = distance + 0.2 * dx.abs() + wrong_side;
        let clear = distance >= 5.0
            && page.holds(&area)
            && !taken.iter().any(|other| area.touches(other))
            && !area.meets(curve);
        clear.then_some((cost, area))
    });
    candidates.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, area)| area)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: Area = Area { left: 0.0, top: 0.0, right: 400.0, bottom: 300.0 };

    #[test]
    fn labels_of_close_points_keep_apart_from_each_other_and_from_the_curve() {
        let curve: Vec<Point> =
            (0..=400).map(|x| (f64::from(x), 150.0 + 60.0 * (f64::from(x) / 12.0).sin())).collect();
        let mut taken = Vec::new();
        for &point in curve.iter().skip(180).step_by(10).take(6) {
            let area = place(point, (50.0, 12.0), true, &PAGE, &curve, &taken).unwrap();
            let inside = |&(x, y): &Point| {
                (area.left..=area.right).contains(&x) && (area.top..=area.bottom).contains(&y)
            };
            assert!(!curve.iter().any(inside) && PAGE.holds(&area));
            assert!(!taken.iter().any(|other| area.touches(other)));
            taken.push(area);
        }
    }

    #[test]
    fn the_preferred_side_is_taken_when_free_and_a_full_page_has_no_place() {
        let flat = [(0.0, 150.0), (400.0, 150.0)];
        for above in [true, false] {
            let area = place((200.0, 150.0), (50.0, 12.0), above, &PAGE, &flat, &[]).unwrap();
            assert_eq!(area.bottom < 150.0, above);
        }
        assert_eq!(place((200.0, 150.0), (50.0, 12.0), true, &PAGE, &[], &[PAGE]), None);
    }
}
