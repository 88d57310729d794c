//! The solids of a bed cut by a vertical plane.
//!
//! All in double precision. Two triangles that share an edge cut it in the same point to the last
//! bit, so the outline of a solid has no gap.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::geometry::{Bed, Placement};

/// Strips of the plane, so that few pieces of outline are tested for a point.
const STRIPS: usize = 1024;

/// The part of a plane that lies within solids.
pub(crate) struct Cut {
    least_um: f64,
    strips_per_um: f64,
    /// The pieces of outline that reach into each strip.
    strips: Vec<Vec<Piece>>,
}

/// A piece of a solid's outline, from one triangle. The solid is below it where it runs towards
/// greater coordinates, above it where it runs back.
#[derive(Clone, Copy)]
struct Piece {
    /// Coordinate along the plane and height, um.
    ends: [DVec2; 2],
    material: u16,
}

impl Cut {
    /// The bed's closed meshes cut by the plane on which the coordinate `axis`, 0 or 1, is `at_um`,
    /// within the domain.
    pub(crate) fn new(bed: &Bed, axis: usize, at_um: f64) -> Self {
        let along = 1 - axis;
        let (least, most) = (bed.domain.min_um[along], bed.domain.max_um[along]);
        let mut cut = Self {
            least_um: least,
            strips_per_um: STRIPS as f64 / (most - least),
            strips: vec![Vec::new(); STRIPS],
        };
        let closed: Vec<&Placement> =
            bed.placements.iter().filter(|place| bed.meshes[place.mesh].closed).collect();
        let pieces: Vec<Vec<Piece>> =
            closed.par_iter().map(|place| pieces(bed, place, axis, at_um)).collect();
        for piece in pieces.into_iter().flatten() {
            let [a, b] = piece.ends.map(|end| end.x);
            if a.max(b) >= least && a.min(b) <= most {
                for strip in cut.strip(a.min(b))..=cut.strip(a.max(b)) {
                    cut.strips[strip].push(piece);
                }
            }
        }
        cut
    }

    fn strip(&self, along_um: f64) -> usize {
        (((along_um - self.least_um) * self.strips_per_um) as usize).min(STRIPS - 1)
    }

    /// The material of the solid that a point of the plane lies in, if any.
    ///
    /// A ray straight up from the point leaves that solid once more than it enters it. Where solids
    /// of several materials overlap, the one left first counts.
    pub(crate) fn material(&self, along_um: f64, z_um: f64) -> Option<u16> {
        let mut passed: Vec<(f64, u16, i32)> = Vec::new();
        for Piece { ends: [a, b], material } in &self.strips[self.strip(along_um)] {
            // One end belongs to the piece, the other to the next, so that a corner counts once.
            if (a.x <= along_um) != (b.x <= along_um) {
                let height = a.y + (along_um - a.x) / (b.x - a.x) * (b.y - a.y);
                if height > z_um {
                    passed.push((height, *material, if b.x > a.x { 1 } else { -1 }));
                }
            }
        }
        let left = |of: Option<u16>| -> i32 {
            let counts = |m: u16| of.is_none_or(|of| of == m);
            passed.iter().filter(|(_, m, _)| counts(*m)).map(|(.., times)| times).sum()
        };
        if left(None) <= 0 {
            return None;
        }
        // A solid of several materials may be entered through one and left through another.
        let own = |material: u16| left(Some(material)) > 0;
        let outward = passed.iter().filter(|(.., times)| *times > 0);
        outward
            .min_by(|a, b| (!own(a.1), a.0).partial_cmp(&(!own(b.1), b.0)).expect("numbers"))
            .map(|(_, material, _)| *material)
    }
}

/// The outline that a plane cuts from one mesh.
fn pieces(bed: &Bed, place: &Placement, axis: usize, at_um: f64) -> Vec<Piece> {
    let mesh = &bed.meshes[place.mesh];
    let reach = f64::from(mesh.extent_um()) * 3_f64.sqrt();
    // No vector is stretched by more than the root of the sum of all squares.
    let columns = place.to_scene.matrix3.to_cols_array();
    let stretch = columns.iter().map(|m| m * m).sum::<f64>().sqrt();
    if (place.to_scene.translation[axis] - at_um).abs() > reach * stretch {
        return Vec::new();
    }
    let points: Vec<DVec3> =
        mesh.vertices.iter().map(|v| place.to_scene.transform_point3(v.as_dvec3())).collect();
    let mirrored = (place.handedness() < 0.0) != (axis == 1);
    let mut pieces = Vec::new();
    for (triangle, &material) in mesh.triangles.iter().zip(&mesh.materials) {
        let corners = triangle.map(|i| points[i as usize]);
        let beyond = corners.map(|corner| corner[axis] >= at_um);
        if beyond[0] == beyond[1] && beyond[1] == beyond[2] {
            continue;
        }
        // One edge runs through the plane forward and one back.
        let through = |forward: bool| {
            let edge = (0..3).find(|&i| beyond[i] != forward && beyond[(i + 1) % 3] == forward);
            let i = edge.expect("the corners are on both sides");
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            // Always from the near end, so that the neighbouring triangle finds the same point.
            let (near, far) = if forward { (p, q) } else { (q, p) };
            let point = near + (at_um - near[axis]) / (far[axis] - near[axis]) * (far - near);
            DVec2::new(point[1 - axis], point.z)
        };
        pieces.push(Piece { ends: [!mirrored, mirrored].map(through), material });
    }
    pieces
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat};

    use super::*;
    use crate::geometry::{Domain, Mesh};
    use crate::scene::Sides;

    /// A cube from -1 to 1 of one material.
    fn solid(material: u16) -> Mesh {
        let bit = |i: u32, n: u32| f64::from(2 * (i >> n & 1)) - 1.0;
        let corners: Vec<DVec3> =
            (0..8).map(|i| DVec3::new(bit(i, 0), bit(i, 1), bit(i, 2))).collect();
        let quads: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let mesh = Mesh::new("solid", &corners, faces.map(|face| (face, material))).0;
        assert!(mesh.closed);
        mesh
    }

    /// Cubes turned, stretched, mirrored and overlapping, against their own coordinates.
    #[test]
    fn a_point_is_in_a_solid_if_its_coordinates_say_so_and_of_its_material() {
        let number = |n: i32| f64::from(n * 7919 % 1009) / 1009.0;
        let places: Vec<DAffine3> = (0..40)
            .map(|i| {
                let n = |k: i32| number(40 * k + i + 1);
                let axis = DVec3::new(n(0) - 0.5, n(1) - 0.5, n(2) - 0.5).normalize();
                let mirror = if i % 3 == 0 { -1.0 } else { 1.0 };
                let stretch = DVec3::new(mirror * (4.0 + 9.0 * n(3)), 5.0, 3.0 + 6.0 * n(4));
                let at = DVec3::new(60.0 * n(5), 60.0 * n(6), 30.0 * n(7));
                let turn = DQuat::from_axis_angle(axis, 6.0 * n(8));
                DAffine3::from_scale_rotation_translation(stretch, turn, at)
            })
            .collect();
        let (min, max) = (DVec3::new(0.0, 0.0, -30.0), DVec3::splat(60.0));
        let mut bed = Bed {
            meshes: vec![solid(0), solid(1)],
            placements: (0..40).map(|i| Placement { mesh: i % 2, to_scene: places[i] }).collect(),
            repeated: 0,
            domain: Domain::new(min, max, Sides::Periodic),
            to_sensor: DVec3::Z,
            materials: 2,
        };
        let mut seen = [0; 4];
        for (axis, at_um) in [(0, 0.0), (0, 31.0), (1, 60.0), (1, 17.0)] {
            let cut = Cut::new(&bed, axis, at_um);
            for i in 0..300 {
                for j in 0..300 {
                    let (along, z) = (0.2 * f64::from(i) + 0.05, 0.3 * f64::from(j) - 29.9);
                    let mut point = DVec3::new(along, along, z);
                    point[axis] = at_um;
                    let holds: Vec<usize> = (0..40)
                        .filter(|&i| {
                            let own = places[i].inverse().transform_point3(point);
                            own.abs().max_element() < 1.0
                        })
                        .collect();
                    let found = cut.material(along, z);
                    assert_eq!(found.is_some(), !holds.is_empty(), "{point} in {holds:?}");
                    if let Some(material) = found {
                        assert!(holds.iter().any(|i| i % 2 == usize::from(material)), "{point}");
                    }
                    seen[holds.len().min(3)] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&points| points > 100), "free, in one, in two, in more: {seen:?}");

        bed.meshes.iter_mut().for_each(|mesh| mesh.closed = false);
        let cut = Cut::new(&bed, 0, 31.0);
        assert!(cut.strips.iter().all(Vec::is_empty), "an open mesh is no solid");
    }
}
