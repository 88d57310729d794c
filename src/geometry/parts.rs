//! The connected parts of a mesh, and the mesh without some of them.
//!
//! A dusty grain is one mesh: its body is the largest part, its fines are the others.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use super::Mesh;
use super::mesh::{corners, distinct, roots, signed_volume};
use crate::support::math;

/// The connected parts of a mesh, numbered in the order of their first triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// The part of each triangle.
    pub of_triangles: Vec<u32>,
    /// Diameter of the sphere of each part's volume, um; of no meaning for an open part.
    pub diameters_um: Vec<f64>,
    /// The material of each part's first triangle.
    pub materials: Vec<u16>,
}

impl Parts {
    /// The parts of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let roots = roots(&distinct(&mesh.vertices), &mesh.triangles);
        let mut numbers: BTreeMap<u32, u32> = BTreeMap::new();
        let (mut of_triangles, mut materials) = (Vec::new(), Vec::new());
        let mut volumes = Vec::new();
        for (&triangle, &material) in mesh.triangles.iter().zip(&mesh.materials) {
            let next = numbers.len() as u32;
            let part = *numbers.entry(roots[triangle[0] as usize]).or_insert(next);
            if part == next {
                materials.push(material);
                volumes.push(0.0);
            }
            of_triangles.push(part);
            volumes[part as usize] += signed_volume(corners(&mesh.vertices, triangle));
        }
        let diameter = |volume: &f64| math::cbrt(6.0 / PI * volume.abs());
        Self { of_triangles, diameters_um: volumes.iter().map(diameter).collect(), materials }
    }

    /// Number of the largest part: the body of a dusty grain. `None` of a mesh without triangles.
    pub fn largest(&self) -> Option<u32> {
        let size = |part: &u32| self.diameters_um[*part as usize];
        let all = 0..self.diameters_um.len() as u32;
        all.max_by(|a, b| size(a).total_cmp(&size(b)).then(b.cmp(a)))
    }
}

impl Mesh {
    /// The mesh with some of its parts only. Vertices keep their places, so that placements fit.
    #[must_use]
    pub fn with_parts(&self, parts: &Parts, keeps: impl Fn(u32) -> bool) -> Self {
        let kept = parts.of_triangles.iter().map(|&part| keeps(part));
        let of = self.triangles.iter().zip(&self.materials).zip(kept);
        let (triangles, materials): (Vec<[u32; 3]>, Vec<u16>) = of
            .filter(|(_, kept)| *kept)
            .map(|((triangle, material), _)| (triangle, *material))
            .unzip();
        // Vertices that are no longer used would widen the boxes around the mesh.
        let mut places: Vec<Option<u32>> = vec![None; self.vertices.len()];
        let mut vertices = Vec::new();
        let mut place = |vertex: u32| {
            *places[vertex as usize].get_or_insert_with(|| {
                vertices.push(self.vertices[vertex as usize]);
                vertices.len() as u32 - 1
            })
        };
        let triangles: Vec<[u32; 3]> = triangles.into_iter().map(|t| t.map(&mut place)).collect();
        let (name, closed, quality) = (self.name.clone(), self.closed, self.quality.clone());
        let mut mesh =
            Self { name, vertices, triangles, materials, closed, particles: Vec::new(), quality };
        mesh.find_particles();
        mesh
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    /// A large body of material 0 with two small ones of material 1 beside it.
    fn dusty() -> Mesh {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let at = |size: f64, x: f64| corners.map(|p| p * size + DVec3::new(x, 0.0, 0.0));
        let points: Vec<DVec3> = [at(1.0, 50.0), at(9.0, 0.0), at(1.0, 20.0)].concat();
        let faces = (0..3).flat_map(|body| {
            TETRAHEDRON.map(|face| (face.map(|i| i + 4 * body), u16::from(body != 1)))
        });
        Mesh::new("dusty", &points, faces).0
    }

    #[test]
    fn parts_are_found_with_their_size_and_material() {
        let parts = Parts::of(&dusty());
        assert_eq!(parts.of_triangles, [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2]);
        assert_eq!(parts.materials, [1, 0, 1]);
        assert!((parts.diameters_um[1] - 9.0 / math::cbrt(PI)).abs() < 1e-4);
        assert_eq!(parts.largest(), Some(1));
    }

    #[test]
    fn a_mesh_without_a_part_keeps_the_others_in_their_places() {
        let (whole, parts) = (dusty(), Parts::of(&dusty()));
        let thinned = whole.with_parts(&parts, |part| part != 0);
        assert_eq!(thinned.materials, [0, 0, 0, 0, 1, 1, 1, 1]);
        assert_eq!((thinned.vertices.len(), thinned.particles.len()), (8, 2));
        let corners = |mesh: &Mesh, from: usize| -> Vec<[Vec3; 3]> {
            mesh.triangles[from..].iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect()
        };
        assert_eq!(corners(&thinned, 0), corners(&whole, 4));
        assert!(thinned.closed);
    }
}
