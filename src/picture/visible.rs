//! Which triangle is seen where: a depth buffer.
//!
//! A picture asks for the first hits of a million parallel rays. Going through the triangles once finds
//! them ten times as fast as following each ray does.

use std::ops::Range;

use glam::{Affine3A, DAffine3, Vec3A};

use crate::geometry::Mesh;

/// A mesh in its place.
#[derive(Debug, Clone)]
pub(crate) struct Body<'a> {
    pub mesh: &'a Mesh,
    /// From the mesh's coordinates to the scene's.
    pub to_scene: DAffine3,
    /// Distance of the farthest vertex from the origin of the mesh, um.
    pub radius_um: f32,
}

/// The part of a picture that is drawn at a go.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    pub width: usize,
    pub rows: Range<usize>,
}

/// Scratch space for a mesh's vertices, kept from one body to the next.
pub(crate) type Scratch = Vec<Vec3A>;

impl Body<'_> {
    /// Calls `put` with place in the window, depth and number for each triangle over the middle of each pixel
    /// that it covers. Closed meshes show their front alone.
    pub fn draw(
        &self,
        to_pixels: &DAffine3,
        window: &Window,
        scratch: &mut Scratch,
        mut put: impl FnMut(usize, f32, u32),
    ) {
        let map = *to_pixels * self.to_scene;
        let (rows, columns) = (map.matrix3.row(1), map.matrix3.row(0));
        let reach = |row: glam::DVec3| row.length() * f64::from(self.radius_um) + 1.0;
        let outside = |at: f64, reach: f64, from: usize, to: usize| {
            at + reach < from as f64 || at - reach > to as f64
        };
        if outside(map.translation.x, reach(columns), 0, window.width)
            || outside(map.translation.y, reach(rows), window.rows.start, window.rows.end)
        {
            return;
        }
        let front = if map.matrix3.determinant() < 0.0 { 1.0 } else { -1.0 };
        // Relative to the window's first row, so that rows are counted from 0.
        let mut local =
            Affine3A::from_mat3_translation(map.matrix3.as_mat3(), map.translation.as_vec3());
        local.translation.y = (map.translation.y - window.rows.start as f64) as f32;
        scratch.clear();
        scratch.extend(self.mesh.vertices.iter().map(|&v| local.transform_point3a(v.into())));
        let bounds = [window.width as f32, window.rows.len() as f32];
        for (number, triangle) in self.mesh.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|i| scratch[i as usize]);
            let (ab, ac) = (b - a, c - a);
            let area = ab.x * ac.y - ab.y * ac.x;
            if area == 0.0 || (self.mesh.closed && area * front < 0.0) {
                continue;
            }
            let (min, max) = (a.min(b).min(c), a.max(b).max(c));
            // Pixels whose middle is between the least and the greatest.
            let first = |low: f32| (low - 0.5).ceil().max(0.0);
            let last = |high: f32, bound: f32| (high - 0.5).floor().min(bound - 1.0);
            let (x0, x1) = (first(min.x), last(max.x, bounds[0]));
            let (y0, y1) = (first(min.y), last(max.y, bounds[1]));
            if x0 > x1 || y0 > y1 {
                continue;
            }
            // Weights of b and c, and the depth, are linear in x and y.
            let turn = 1.0 / area;
            let (bx, by) = (ac.y * turn, -ac.x * turn);
            let (cx, cy) = (-ab.y * turn, ab.x * turn);
            let (px, py) = (x0 + 0.5 - a.x, y0 + 0.5 - a.y);
            let mut row_b = px * bx + py * by;
            let mut row_c = px * cx + py * cy;
            for y in y0 as usize..=y1 as usize {
                let (mut wb, mut wc) = (row_b, row_c);
                let row = y * window.width;
                for x in x0 as usize..=x1 as usize {
                    // A little more than the triangle: no pixel slips between two that share an edge.
                    if wb >= -EDGE && wc >= -EDGE && wb + wc <= 1.0 + EDGE {
                        let depth = (a.z + wb * ab.z + wc * ac.z).clamp(min.z, max.z);
                        put(row + x, depth, number as u32);
                    }
                    wb += bx;
                    wc += cx;
                }
                row_b += by;
                row_c += cy;
            }
        }
    }
}

const EDGE: f32 = 1e-5;
