//! Whether a mesh is one whole convex body that faces outward, and if not, what is wrong and where.
//!
//! `blender_scripts/soilsig_blender/model/mesh_faults.py` asks the same inside Blender, where the faces at fault
//! can be selected; here no Blender is needed.

use std::collections::BTreeMap;

use glam::DVec3;

/// A corner may stand so far before the plane of a face, as a share of the extent: what is less is levelled
/// when the hull is taken.
const HOLLOW: f64 = 2e-3;
/// By so much of the extent coordinates may be rounded, which tilts the planes of slender triangles.
const ROUNDING: f64 = 1e-6;

/// A mesh of flat faces, um.
#[derive(Debug, Clone, Default)]
pub(crate) struct Solid {
    /// The corners.
    pub vertices: Vec<DVec3>,
    /// Corners of each face.
    pub faces: Vec<Vec<usize>>,
}

/// A triangle and the face that it is of.
struct Triangle {
    corners: [usize; 3],
    face: usize,
}

impl Solid {
    /// Volume, um3; negative if it faces inward.
    pub(crate) fn volume_um3(&self) -> f64 {
        let of = |t: &Triangle| {
            let [a, b, c] = self.points(t);
            a.dot(b.cross(c)) / 6.0
        };
        self.triangles().iter().map(of).sum()
    }

    /// The first thing that is wrong, with the place; `None` for a sound body.
    pub(crate) fn fault(&self) -> Option<String> {
        let triangles = self.triangles();
        if triangles.is_empty() {
            return Some("it has no faces".into());
        }
        self.flat_face(&triangles)
            .or_else(|| self.edge_fault())
            .or_else(|| self.pieces(&triangles))
            .or_else(|| {
                (self.volume_um3() <= 0.0)
                    .then(|| "it is turned inside out: its faces look inward".into())
            })
            .or_else(|| self.through_itself(&triangles))
            .or_else(|| self.hollow(&triangles))
    }

    fn triangles(&self) -> Vec<Triangle> {
        let fan = |(face, loops): (usize, &Vec<usize>)| {
            let corners = loops.clone();
            (2..corners.len())
                .map(move |i| Triangle { corners: [corners[0], corners[i - 1], corners[i]], face })
        };
        self.faces.iter().enumerate().flat_map(fan).collect()
    }

    fn points(&self, triangle: &Triangle) -> [DVec3; 3] {
        triangle.corners.map(|i| self.vertices[i])
    }

    fn extent(&self) -> f64 {
        let min = self.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let max = self.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (max - min).max_element()
    }

    /// A face by its number in the file, from 1, and its middle.
    fn place(&self, face: usize) -> String {
        let corners = &self.faces[face];
        let middle =
            corners.iter().map(|&i| self.vertices[i]).sum::<DVec3>() / corners.len() as f64;
        format!("face {} near ({:.4}, {:.4}, {:.4}) um", face + 1, middle.x, middle.y, middle.z)
    }

    fn flat_face(&self, triangles: &[Triangle]) -> Option<String> {
        let mut areas = vec![0.0; self.faces.len()];
        for triangle in triangles {
            let [a, b, c] = self.points(triangle);
            areas[triangle.face] += (b - a).cross(c - a).length();
        }
        let least = 1e-12 * self.extent().powi(2);
        let flat = areas.iter().position(|&area| area.is_nan() || area <= least)?;
        Some(format!("{} has no area", self.place(flat)))
    }

    /// Every edge must be run along once in each direction.
    fn edge_fault(&self) -> Option<String> {
        let mut edges: BTreeMap<(usize, usize), Vec<(bool, usize)>> = BTreeMap::new();
        for (face, corners) in self.faces.iter().enumerate() {
            for (i, &a) in corners.iter().enumerate() {
                let b = corners[(i + 1) % corners.len()];
                edges.entry((a.min(b), a.max(b))).or_default().push((a < b, face));
            }
        }
        let wrong = |words: &str, holds: fn(&[(bool, usize)]) -> bool| {
            let mut at = edges.values().filter(|faces| holds(faces));
            let first = at.next()?[0].1;
            Some(format!("{words} ({} edges, the first at {})", 1 + at.count(), self.place(first)))
        };
        wrong("it is open: edges have a face on one side only", |faces| faces.len() == 1)
            .or_else(|| wrong("more than two faces meet at an edge", |faces| faces.len() > 2))
            .or_else(|| {
                wrong("neighbouring faces look to opposite sides", |faces| {
                    faces.len() == 2 && faces[0].0 == faces[1].0
                })
            })
    }

    fn pieces(&self, triangles: &[Triangle]) -> Option<String> {
        let mut part: Vec<usize> = (0..self.vertices.len()).collect();
        for Triangle { corners: [a, b, c], .. } in triangles {
            let a = root(&mut part, *a);
            for other in [b, c] {
                let other = root(&mut part, *other);
                part[other] = a;
            }
        }
        let first = root(&mut part, triangles[0].corners[0]);
        let other = triangles.iter().find(|t| root(&mut part, t.corners[0]) != first)?;
        Some(format!(
            "it is in several pieces: {} does not hang together with face 1",
            self.place(other.face)
        ))
    }

    fn through_itself(&self, triangles: &[Triangle]) -> Option<String> {
        let boxes: Vec<(DVec3, DVec3)> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = self.points(t);
                (a.min(b).min(c), a.max(b).max(c))
            })
            .collect();
        for (i, one) in triangles.iter().enumerate() {
            for (j, two) in triangles.iter().enumerate().skip(i + 1) {
                // The triangles of one face lie in a plane: rounding may fold them, no more.
                let meet = one.face != two.face
                    && boxes[i].0.cmple(boxes[j].1).all()
                    && boxes[j].0.cmple(boxes[i].1).all();
                if meet && self.cross(one, two) {
                    let (one, two) = (self.place(one.face), self.place(two.face));
                    return Some(format!("it passes through itself: {one} and {two} cross"));
                }
            }
        }
        None
    }

    /// Whether two triangles cross elsewhere than at corners that they share.
    fn cross(&self, one: &Triangle, two: &Triangle) -> bool {
        let shared = one.corners.iter().filter(|i| two.corners.contains(i)).count();
        if shared >= 2 {
            let normal = |t| {
                let [a, b, c] = self.points(t);
                (b - a).cross(c - a).normalize_or_zero()
            };
            return shared == 2 && normal(one).dot(normal(two)) < -1.0 + 1e-9;
        }
        [(one, two), (two, one)].into_iter().any(|(a, b)| {
            (0..3).any(|i| {
                let (tail, head) = (a.corners[i], a.corners[(i + 1) % 3]);
                !b.corners.contains(&tail)
                    && !b.corners.contains(&head)
                    && pierces(self.vertices[tail], self.vertices[head], self.points(b))
            })
        })
    }

    /// The corner that stands farthest before the plane of a face.
    fn hollow(&self, triangles: &[Triangle]) -> Option<String> {
        let extent = self.extent();
        let mut worst = (0.0, 0);
        for triangle in triangles {
            let [a, b, c] = self.points(triangle);
            let normal = (b - a).cross(c - a);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let narrow = normal.length() / longest;
            let allowed =
                HOLLOW * extent + ROUNDING * extent * extent / narrow.max(f64::MIN_POSITIVE);
            let normal = normal.normalize_or_zero();
            let before = self.vertices.iter().map(|v| (*v - a).dot(normal)).fold(0.0_f64, f64::max);
            if before > allowed && before > worst.0 {
                worst = (before, triangle.face);
            }
        }
        (worst.0 > 0.0).then(|| {
            format!(
                "it is not convex: a corner stands {:.3} um before the plane of {}",
                worst.0,
                self.place(worst.1)
            )
        })
    }
}

/// The corner that stands for all that hang together with one.
fn root(part: &mut [usize], mut at: usize) -> usize {
    while part[at] != at {
        part[at] = part[part[at]];
        at = part[at];
    }
    at
}

/// Whether a segment crosses the inside of a triangle.
fn pierces(tail: DVec3, head: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let (along, u, v, s) = (head - tail, b - a, c - a, tail - a);
    let p = along.cross(v);
    let det = u.dot(p);
    if det.abs() <= 1e-9 * along.length() * u.cross(v).length() {
        return false;
    }
    let q = s.cross(u);
    let (x, y, t) = (s.dot(p) / det, along.dot(q) / det, v.dot(q) / det);
    x.min(y).min(1.0 - x - y).min(t).min(1.0 - t) > 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of side 100 about the origin, of triangles facing outward, its corners by bits.
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
    fn a_sound_body_has_no_fault_and_its_volume() {
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
        // The corner opposite goes out through the far face.
        let through = fault(|s| s.vertices[7] = DVec3::new(-20.0, -20.0, -90.0));
        assert!(through.contains("passes through itself"), "{through}");
        let two = fault(|s| {
            let other = cube();
            s.vertices.extend(other.vertices.iter().map(|v| *v + 200.0));
            s.faces.extend(other.faces.iter().map(|f| f.iter().map(|i| i + 8).collect()));
        });
        assert!(two.contains("several pieces: face 13"), "{two}");
    }

    #[test]
    fn rounding_and_slender_triangles_are_no_hollow() {
        let mut solid = cube();
        // A point on an edge, hardly off it, makes two slivers.
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
