//! Polygons into triangles.

use earcut::Earcut;
use glam::DVec3;

use crate::geometry::cross;

/// A triangle lower than this share of its longest side has no area to speak of. Programs write six
/// decimals.
const SLIVER: f64 = 1e-5;

/// What the triangles' areas may differ from the polygon's, relative.
const SAME_AREA: f64 = 1e-6;

/// A polygon as triangles; none if it has no area. `None` if it crosses itself.
///
/// A convex polygon is a fan about its first corner, or about another one that leaves no triangle
/// without area. Ears are clipped from others, in the plane across the axis nearest the normal.
pub(crate) fn triangles(corners: &[u32], points: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let polygon: Vec<DVec3> = corners.iter().map(|&i| points[i as usize]).collect();
    let cut = cut(&polygon)?;
    Some(cut.into_iter().map(|triangle| triangle.map(|i| corners[i])).collect())
}

fn cut(polygon: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let count = polygon.len();
    let area = |triangle: &[usize; 3]| cross(triangle.map(|i| polygon[i]));
    let first = fan(count, 0);
    if count == 3 {
        return Some(first);
    }
    let whole: DVec3 = first.iter().map(area).sum();
    let longest_squared =
        polygon.iter().map(|p| p.distance_squared(polygon[0])).fold(0.0, f64::max);
    let sliver = SLIVER * longest_squared;
    // Every corner must turn the same way, not only those of the fan.
    let turns = |least: f64| {
        let turn = |i| area(&[i, (i + 1) % count, (i + 2) % count]).dot(whole);
        whole != DVec3::ZERO && (0..count).all(|i| turn(i) >= least)
    };
    if turns(-sliver * whole.length()) {
        // A corner within a side: a fan about the wrong corner would pass it by.
        let is_full = |of: &Vec<[usize; 3]>| {
            let is_full = |triangle| is_no_sliver(polygon, triangle, whole);
            of.iter().all(is_full)
        };
        if let Some(full) = (0..count.min(64)).map(|start| fan(count, start)).find(is_full) {
            return Some(full);
        }
    }
    let same_way = |triangle| area(triangle).dot(whole) >= 0.0;
    if first.iter().all(same_way) && turns(-1e-9 * whole.length_squared()) {
        return Some(first);
    }
    let clipped = clip(polygon, whole);
    let total: f64 = first.iter().map(|triangle| area(triangle).length()).sum();
    if clipped.is_none() && total <= sliver { Some(Vec::new()) } else { clipped }
}

/// Triangles about one corner.
fn fan(corners: usize, start: usize) -> Vec<[usize; 3]> {
    let at = |k: usize| (start + k) % corners;
    (2..corners).map(|k| [start, at(k - 1), at(k)]).collect()
}

/// Whether a triangle has an area to speak of, and faces as the polygon does.
fn is_no_sliver(polygon: &[DVec3], triangle: &[usize; 3], whole: DVec3) -> bool {
    let [a, b, c] = triangle.map(|i| polygon[i]);
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    let area = cross([a, b, c]);
    area.dot(whole) > 0.0 && area.length() > SLIVER * longest
}

/// A polygon as triangles, by clipping ears. `None` if they do not cover it.
fn clip(polygon: &[DVec3], whole: DVec3) -> Option<Vec<[usize; 3]>> {
    let up = (0..3).max_by(|&i, &j| whole[i].abs().total_cmp(&whole[j].abs()))?;
    let (across, along) = ((up + 1) % 3, (up + 2) % 3);
    let turn = whole[up].signum();
    let flat: Vec<[f64; 2]> = polygon.iter().map(|p| [p[across], turn * p[along]]).collect();
    let area = |[a, b, c]: [usize; 3]| {
        let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(|i| flat[i]);
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    };
    let wanted = whole[up].abs();
    if wanted == 0.0 || !whole.is_finite() {
        return None;
    }
    let mut indices: Vec<usize> = Vec::new();
    Earcut::new().earcut(flat.iter().copied(), &[], &mut indices);
    let facing = |[a, b, c]: [usize; 3]| if area([a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] };
    let triangles: Vec<_> = indices.as_chunks().0.iter().copied().map(facing).collect();
    let covered: f64 = triangles.iter().copied().map(area).sum();
    ((covered - wanted).abs() <= SAME_AREA * wanted).then_some(triangles)
}
