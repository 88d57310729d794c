//! Checks that a mesh is one closed convex body whose faces point outward.
//!
//! `blender_scripts/soilsig_blender/model/mesh_faults.py` has the same checks, for the faces that
//! Blender's window selects. These need no Blender.

use std::collections::BTreeMap;

use glam::DVec3;

/// The largest distance of a corner outside the plane of a face, as a share of the body's size.
/// Smaller dents vanish when Blender takes the convex hull.
const DENT: f64 = 2e-3;
/// The rounding of coordinates in a file, as a share of the body's size. It tilts the planes of
/// narrow triangles.
const ROUNDING: f64 = 1e-6;

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

    /// The first fault and its place; `None` for a sound body.
    ///
    /// A convex body cannot cross itself: no further check is needed.
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
            .or_else(|| self.dent())
    }

    /// A face as triangles about its first corner.
    fn triangles<'a>(&'a self, face: &'a [usize]) -> impl Iterator<Item = [DVec3; 3]> + 'a {
        let pairs = face.windows(2).skip(1);
        pairs.map(|pair| [face[0], pair[0], pair[1]].map(|corner| self.vertices[corner]))
    }

    /// The longest side of the box around the body, um.
    fn size(&self) -> f64 {
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

    /// The corner that lies farthest outside the plane of a face.
    fn dent(&self) -> Option<String> {
        let size = self.size();
        let mut worst = (0.0, 0);
        for (number, face) in self.faces.iter().enumerate() {
            for [a, b, c] in self.triangles(face) {
                let normal = (b - a).cross(c - a);
                let longest = (b - a).length().max((c - b).length()).max((a - c).length());
                let narrow = (normal.length() / longest).max(f64::MIN_POSITIVE);
                let allowed = DENT * size + ROUNDING * size * size / narrow;
                let normal = normal.normalize_or_zero();
                let heights = self.vertices.iter().map(|v| (*v - a).dot(normal));
                let outside = heights.fold(0.0_f64, f64::max);
                if outside > allowed && outside > worst.0 {
                    worst = (outside, number);
                }
            }
        }
        let (outside, face) = worst;
        (outside > 0.0).then(|| {
            let face = self.place(face);
            format!("it is not convex: a corner lies {outside:.3} um outside the plane of {face}")
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
        assert!(fault(|s| s.vertices[7] = DVec3::splat(-10.0)).contains("not convex"));
        // The opposite corner passes through the far face.
        let crossing = fault(|s| s.vertices[7] = DVec3::new(-20.0, -20.0, -90.0));
        assert!(crossing.contains("not convex"), "{crossing}");
        let two = fault(|s| {
            let other = cube();
            s.vertices.extend(other.vertices.iter().map(|v| *v + 200.0));
            s.faces.extend(other.faces.iter().map(|f| f.iter().map(|i| i + 8).collect()));
        });
        assert!(two.contains("several pieces: face 13"), "{two}");
    }

    #[test]
    fn rounding_of_narrow_triangles_is_no_dent() {
        let mut solid = cube();
        // A point very close to an edge makes two narrow triangles.
        solid.vertices.push(DVec3::new(0.0, -50.0, -50.0 + 1e-5));
        for face in &mut solid.faces {
            let at = (0..3).find(|&i| {
                let (a, b) = (face[i], face[(i + 1) % 3]);
                (a.min(b), a.max(b)) == (0, 1)
            });
            if let Some(at) = at {
                face.insert(at + 1, 8);
            }
        }
        assert_eq!(solid.fault(), None);
    }
}
