//! The tray as a floor and the edges of its walls.

use glam::{DAffine3, DVec3};

use super::camera::corners;
use crate::geometry::{Mesh, Placement};

/// Width of an edge, as a share of the tray's longer side.
const EDGE: f64 = 0.006;

/// Adds a floor whose top is at `min.z` and, if `max.z` is higher, the edges of walls up to there.
pub(super) fn add(
    meshes: &mut Vec<Mesh>,
    placements: &mut Vec<Placement>,
    [min, max]: [DVec3; 2],
    material: u16,
) {
    let edge = EDGE * (max - min).truncate().max_element();
    let mut boxes = vec![[
        DVec3::new(min.x - edge, min.y - edge, min.z - 3.0 * edge),
        DVec3::new(max.x + edge, max.y + edge, min.z),
    ]];
    if max.z > min.z {
        let sides = |low: f64, high: f64| [[low - edge, low], [high, high + edge]];
        for x in sides(min.x, max.x) {
            for y in sides(min.y, max.y) {
                boxes.push([DVec3::new(x[0], y[0], min.z), DVec3::new(x[1], y[1], max.z)]);
            }
            boxes.push([DVec3::new(x[0], min.y, max.z - edge), DVec3::new(x[1], max.y, max.z)]);
        }
        for y in sides(min.y, max.y) {
            boxes.push([DVec3::new(min.x, y[0], max.z - edge), DVec3::new(max.x, y[1], max.z)]);
        }
    }
    for [low, high] in boxes {
        let (mesh, middle) = solid_box(low, high, material);
        placements
            .push(Placement { mesh: meshes.len(), to_scene: DAffine3::from_translation(middle) });
        meshes.push(mesh);
    }
}

/// A box as a mesh about its middle, and its middle.
fn solid_box(low: DVec3, high: DVec3, material: u16) -> (Mesh, DVec3) {
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Mesh::new("tray", &corners([low, high]), triangles.map(|triangle| (triangle, material)))
}
