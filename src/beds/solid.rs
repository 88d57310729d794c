//! Checks that a mesh is one closed body whose faces point outward and do not cross.
//!
//! `blender_scripts/soilsig_blender/model/mesh_faults.py` has the same checks, for the faces that
//! Blender's window selects. These need no Blender.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

/// How far an edge must pass within a triangle to cross it, as a share of either: less is rounding.
const CROSSING: f64 = 1e-9;

/// A mesh of flat faces, um.
#[derive(Debug, Clone, Default)]
pub(super) struct Solid {
    /// The corners of all faces.
    pub vertices: Vec<DVec3>,
    /// For each face the numbers of its corners.
    pub faces: Vec<Vec<usize>>,
}

/// An edge by its two corners, the lower number first.
type Edge = (usize, usize);

impl Solid {
    /// The volume, um3; negative if the faces point inward.
    pub(super) fn volume_um3(&self) -> f64 {
        let triangles = self.faces.iter().flat_map(|face| self.triangles(face));
        triangles.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    /// The centre of mass, um.
    pub(super) fn centroid(&self) -> DVec3 {
        // About a corner, so that a body far from its origin loses no digits.
        let origin = self.vertices[0];
        let triangles = self.faces.iter().flat_map(|face| self.triangles(face));
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for corners in triangles {
            let [a, b, c] = corners.map(|corner| corner - origin);
            let of = a.dot(b.cross(c)) / 6.0;
            volume += of;
            moment += of * (a + b + c) / 4.0;
        }
        origin + moment / volume
    }

    /// The first fault and its place; `None` for a sound body, which may be hollow.
    pub(super) fn fault(&self) -> Option<String> {
        if self.faces.is_empty() {
            return Some("it has no faces".into());
        }
        let edges = self.edges();
        self.flat_face()
            .or_else(|| self.edge_fault(&edges))
            .or_else(|| self.second_piece(&edges))
            .or_else(|| {
                (self.volume_um3() <= 0.0)
                    .then(|| "it is turned inside out: its faces point inward".into())
            })
            .or_else(|| self.crossing())
    }

    /// The corners of edges that have a face on one side only.
    pub(super) fn open_corners(&self) -> BTreeSet<usize> {
        let edges = self.edges();
        let open = edges.iter().filter(|(_, faces)| faces.len() == 1);
        open.flat_map(|((a, b), _)| [*a, *b]).collect()
    }

    /// A face as triangles about its first corner.
    fn triangles<'a>(&'a self, face: &'a [usize]) -> impl Iterator<Item = [DVec3; 3]> + 'a {
        let pairs = face.windows(2).skip(1);
        pairs.map(|pair| [face[0], pair[0], pair[1]].map(|corner| self.vertices[corner]))
    }

    /// The longest side of the box around the body, um.
    pub(super) fn size(&self) -> f64 {
        let min = self.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let max = self.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (max - min).max_element()
    }

    /// A face in words: its number in the file, from 1, and its middle.
    fn place(&self, face: usize) -> String {
        let corners = &self.faces[face];
        let sum: DVec3 = corners.iter().map(|&corner| self.vertices[corner]).sum();
        let middle = sum / corners.len() as f64;
        format!("face {} near ({:.4}, {:.4}, {:.4}) um", face + 1, middle.x, middle.y, middle.z)
    }

    fn flat_face(&self) -> Option<String> {
        let least = 1e-12 * self.size().powi(2);
        let flat = self.faces.iter().position(|face| {
            let areas = self.triangles(face).map(|[a, b, c]| (b - a).cross(c - a).length());
            let area: f64 = areas.sum();
            area.is_nan() || area <= least
        })?;
        Some(format!("{} has no area", self.place(flat)))
    }

    /// For each edge the faces beside it, and whether they run along it from the lower number.
    fn edges(&self) -> BTreeMap<Edge, Vec<(bool, usize)>> {
        let mut edges: BTreeMap<Edge, Vec<(bool, usize)>> = BTreeMap::new();
        for (number, face) in self.faces.iter().enumerate() {
            for (a, b) in sides(face) {
                edges.entry((a.min(b), a.max(b))).or_default().push((a < b, number));
            }
        }
        edges
    }

    /// Each edge must have two faces that run along it in opposite directions.
    fn edge_fault(&self, edges: &BTreeMap<Edge, Vec<(bool, usize)>>) -> Option<String> {
        type IsFault = fn(&[(bool, usize)]) -> bool;
        let faults: [(&str, IsFault); 3] = [
            ("it is open: edges have a face on one side only", |faces| faces.len() == 1),
            ("more than two faces meet at an edge", |faces| faces.len() > 2),
            ("neighbouring faces look to opposite sides", |faces| faces[0].0 == faces[1].0),
        ];
        faults.iter().find_map(|(words, is_fault)| {
            let mut at = edges.values().filter(|faces| is_fault(faces));
            let first = at.next()?[0].1;
            Some(format!("{words} ({} edges, the first at {})", 1 + at.count(), self.place(first)))
        })
    }

    fn second_piece(&self, edges: &BTreeMap<Edge, Vec<(bool, usize)>>) -> Option<String> {
        let mut reached = vec![false; self.faces.len()];
        let mut next = vec![0];
        while let Some(face) = next.pop() {
            if !std::mem::replace(&mut reached[face], true) {
                let beside = sides(&self.faces[face]).map(|(a, b)| &edges[&(a.min(b), a.max(b))]);
                next.extend(beside.flatten().map(|(_, face)| face));
            }
        }
        let other = self.place(reached.iter().position(|reached| !reached)?);
        Some(format!("it is in several pieces: {other} is not connected to face 1"))
    }

    /// The first face that another passes through, or on which a neighbour lies folded.
    fn crossing(&self) -> Option<String> {
        let numbered = self.faces.iter().enumerate();
        let mut triangles: Vec<Triangle> = numbered
            .flat_map(|(face, loop_)| {
                let fan = loop_.windows(2).skip(1).map(move |pair| [loop_[0], pair[0], pair[1]]);
                fan.map(move |corners| self.triangle(face, corners))
            })
            .collect();
        triangles.sort_by(|one, two| one.low.x.total_cmp(&two.low.x));
        let mut first: Option<usize> = None;
        for (at, one) in triangles.iter().enumerate() {
            for two in triangles[at + 1..].iter().take_while(|two| two.low.x <= one.high.x) {
                let apart = one.high.cmplt(two.low) | two.high.cmplt(one.low);
                if !apart.any() && one.crosses(two) {
                    let face = one.face.min(two.face);
                    first = Some(first.map_or(face, |known| known.min(face)));
                }
            }
        }
        Some(format!("it passes through itself at {}", self.place(first?)))
    }

    fn triangle(&self, face: usize, corners: [usize; 3]) -> Triangle {
        let points = corners.map(|corner| self.vertices[corner]);
        let [a, b, c] = points;
        Triangle { face, corners, points, low: a.min(b).min(c), high: a.max(b).max(c) }
    }
}

/// A triangle of a face, in its box.
struct Triangle {
    face: usize,
    corners: [usize; 3],
    points: [DVec3; 3],
    low: DVec3,
    high: DVec3,
}

impl Triangle {
    /// Whether an edge of one passes through the other, or both lie folded on a common edge. What
    /// lies in one plane does not cross.
    fn crosses(&self, other: &Self) -> bool {
        let shared = self.corners.iter().filter(|corner| other.corners.contains(corner)).count();
        match shared {
            0 | 1 => self.is_pierced_by(other) || other.is_pierced_by(self),
            _ => self.normal().dot(other.normal()) < -1.0 + CROSSING,
        }
    }

    fn normal(&self) -> DVec3 {
        let [a, b, c] = self.points;
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Whether an edge of the other passes through the inside of this one. An edge that ends at a
    /// corner of this one may meet it there.
    fn is_pierced_by(&self, other: &Self) -> bool {
        (0..3).any(|i| {
            let ends = [i, (i + 1) % 3];
            if ends.iter().any(|&end| self.corners.contains(&other.corners[end])) {
                return false;
            }
            let [tail, head] = ends.map(|end| other.points[end]);
            let ([a, b, c], along) = (self.points, head - tail);
            let (u, v, s) = (b - a, c - a, tail - a);
            let (p, q) = (along.cross(v), s.cross(u));
            let det = u.dot(p);
            if det.abs() <= CROSSING * along.length() * u.cross(v).length() {
                return false;
            }
            let (x, y, t) = (s.dot(p) / det, along.dot(q) / det, v.dot(q) / det);
            [x, y, 1.0 - x - y, t, 1.0 - t].into_iter().all(|share| share > CROSSING)
        })
    }
}

/// The sides of a face, from corner to corner.
fn sides(face: &[usize]) -> impl Iterator<Item = (usize, usize)> {
    face.iter().copied().zip(face.iter().copied().cycle().skip(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of side 100 about the origin: outward triangles, corners numbered by bits.
    fn cube() -> Solid {
        let bit = |i: usize, axis: usize| if (i >> axis) & 1 == 1 { 50.0 } else { -50.0 };
        let vertices = (0..8).map(|i| DVec3::new(bit(i, 0), bit(i, 1), bit(i, 2))).collect();
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.iter().flat_map(|[a, b, c, d]| [vec![*a, *b, *c], vec![*a, *c, *d]]);
        Solid { vertices, faces: triangles.collect() }
    }

    fn fault(change: impl FnOnce(&mut Solid)) -> String {
        let mut solid = cube();
        change(&mut solid);
        solid.fault().unwrap_or_default()
    }

    #[test]
    fn a_sound_body_has_no_fault_and_the_right_volume() {
        assert_eq!(fault(|_| ()), "");
        assert!((cube().volume_um3() - 1e6).abs() < 1e-6);
    }

    #[test]
    fn every_kind_of_damage_is_named() {
        assert!(fault(|s| drop(s.faces.pop())).contains("it is open"));
        assert!(fault(|s| s.faces[3].reverse()).contains("opposite sides"));
        assert!(fault(|s| s.faces.iter_mut().for_each(|f| f.reverse())).contains("inside out"));
        assert!(fault(|s| s.faces.push(vec![0, 1, 7])).contains("open"));
        assert!(fault(|s| s.faces.push(vec![0, 0, 1])).contains("no area"));
        assert!(fault(|s| s.faces.clear()).contains("no faces"));
        // The opposite corner passes through the far face.
        let crossing = fault(|s| s.vertices[7] = DVec3::new(-20.0, -20.0, -90.0));
        assert!(crossing.contains("it passes through itself at face"), "{crossing}");
        let two = fault(|s| {
            let other = cube();
            s.vertices.extend(other.vertices.iter().map(|v| *v + 200.0));
            s.faces.extend(other.faces.iter().map(|f| f.iter().map(|i| i + 8).collect()));
        });
        assert!(two.contains("several pieces: face 13"), "{two}");
    }

    #[test]
    fn a_hollow_body_is_sound() {
        assert_eq!(fault(|s| s.vertices[7] = DVec3::splat(-10.0)), "");
    }
}
