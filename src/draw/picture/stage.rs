//! The bodies before the camera, and the pieces of surface that it sees.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::camera::Camera;
use super::visible::{Body, Scratch, Shape, Window};
use crate::geometry::{Bed, Mesh, Placement};
use crate::scene::Sides;
use crate::support::monitor::{Interrupted, Monitor};

/// Rows that are drawn together. A body in several bands is drawn for each.
const BAND: usize = 160;

/// Bodies over an endless floor.
pub(crate) struct Stage<'a> {
    /// The bodies, and their mirror images where the sides are mirrors.
    images: Vec<Image<'a>>,
    /// Height, um, and material.
    floor: Option<(f64, u16)>,
}

/// The bodies or one of their mirror images.
struct Image<'a> {
    bodies: Vec<Body<'a>>,
    /// Least and greatest x and y of their visible part, um.
    within: Option<[DVec2; 2]>,
    /// Least distance from the camera, um.
    nearest_um: f64,
}

/// The part of a facet that a pixel sees.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub pixel: usize,
    /// Share of the pixel.
    pub share: f32,
    pub point: DVec3,
    pub normal: Vec3,
    pub material: u16,
}

impl<'a> Stage<'a> {
    /// Meshes in their places over a floor.
    pub fn new(meshes: &'a [Mesh], placements: &[Placement], floor: Option<(f64, u16)>) -> Self {
        let shapes: Vec<_> = meshes.iter().map(Shape::new).collect();
        let bodies = placements.iter().map(|p| body(&shapes, p)).collect();
        Self { images: vec![Image { bodies, within: None, nearest_um: 0.0 }], floor }
    }

    /// A bed as the sensor sees it, with its images in mirror sides.
    pub fn of_sensor(bed: &'a Bed) -> Self {
        let (min, max) = (bed.domain.min_um, bed.domain.max_um);
        let depth = max.z - min.z;
        let slant = bed.to_sensor.truncate() / bed.to_sensor.z;
        if bed.domain.sides == Sides::Open || slant == DVec2::ZERO {
            return Self::new(&bed.meshes, &bed.placements, bed.domain.floor);
        }
        let size = (max - min).truncate();
        let shapes: Vec<_> = bed.meshes.iter().map(Shape::new).collect();
        // Rays start over the first cell and leave the bed `slant * depth` further on.
        let cells = |axis: usize| {
            let reach = -slant[axis] * depth / size[axis];
            reach.min(0.0).floor() as i64..=(1.0 + reach.max(0.0)).ceil() as i64 - 1
        };
        let mut images: Vec<Image> = cells(0)
            .flat_map(|i| cells(1).map(move |j| [i, j]))
            .map(|cell| {
                let mut mirror = DAffine3::IDENTITY;
                let mut nearest_um: f64 = 0.0;
                for axis in 0..2 {
                    let number = cell[axis] as f64;
                    let turned = cell[axis] % 2 != 0;
                    mirror.matrix3.col_mut(axis)[axis] = if turned { -1.0 } else { 1.0 };
                    mirror.translation[axis] =
                        number * size[axis] + if turned { min[axis] + max[axis] } else { 0.0 };
                    let on_the_way = (number.abs() - 1.0).max(0.0) * size[axis];
                    if on_the_way > 0.0 {
                        nearest_um = nearest_um.max(on_the_way / bed.to_sensor[axis].abs());
                    }
                }
                let bodies = bed.placements.iter().map(|placement| {
                    let Placement { mesh, to_scene } = *placement;
                    body(&shapes, &Placement { mesh, to_scene: mirror * to_scene })
                });
                let corner = min.truncate() + DVec2::new(cell[0] as f64, cell[1] as f64) * size;
                let within = Some([corner, corner + size]);
                Image { bodies: bodies.collect(), within, nearest_um }
            })
            .collect();
        images.sort_by(|a, b| a.nearest_um.total_cmp(&b.nearest_um));
        Self { images, floor: bed.domain.floor }
    }

    /// The bodies nearer than a distance, um.
    pub fn bodies(&self, farthest_um: f64) -> impl Iterator<Item = &Body<'a>> {
        let near = self.images.iter().take_while(move |image| image.nearest_um <= farthest_um);
        near.flat_map(|image| &image.bodies)
    }

    /// The pieces that each pixel sees with `sub` x `sub` rays.
    pub fn look(
        &self,
        camera: &Camera,
        [width, height]: [usize; 2],
        sub: usize,
        monitor: &dyn Monitor,
    ) -> Result<Vec<Piece>, Interrupted> {
        let to_rays = camera.to_pixels(width * sub, height * sub);
        let bands: Vec<Vec<Piece>> = (0..height.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                monitor.check()?;
                let rows = band * BAND..((band + 1) * BAND).min(height);
                let window = Window { width: width * sub, rows: rows.start * sub..rows.end * sub };
                let seen = self.seen(&to_rays, &window);
                Ok(self.pieces(&seen, &to_rays, &window, sub))
            })
            .collect::<Result<_, _>>()?;
        Ok(bands.concat())
    }

    /// The nearest facet at every ray of a window.
    fn seen(&self, to_rays: &DAffine3, window: &Window) -> Vec<Seen> {
        let mut seen = self.floor_seen(to_rays, window);
        let mut scratch = Scratch::new();
        let to_scene = to_rays.inverse();
        let is_within = |at: usize, depth: f32, image: &Image| {
            image.within.is_none_or(|[min, max]| {
                let place = ray(at, window).extend(f64::from(depth));
                let point = to_scene.transform_point3(place).truncate();
                point.cmpge(min).all() && point.cmple(max).all()
            })
        };
        let mut first = 0;
        for image in &self.images {
            if image.nearest_um > 0.0 && seen.iter().all(|s| f64::from(s.depth) < image.nearest_um)
            {
                break;
            }
            for (number, body) in image.bodies.iter().enumerate() {
                let of = (first + number) as u32;
                body.draw(to_rays, window, &mut scratch, |span| {
                    let rays = &mut seen[span.first..span.first + span.pixels];
                    let mut depth = span.depth;
                    for (i, ray) in rays.iter_mut().enumerate() {
                        if depth < ray.depth && is_within(span.first + i, depth, image) {
                            *ray = Seen { depth, of, triangle: span.triangle };
                        }
                        depth += span.slope;
                    }
                });
            }
            first += image.bodies.len();
        }
        seen
    }

    /// The floor alone.
    fn floor_seen(&self, to_rays: &DAffine3, window: &Window) -> Vec<Seen> {
        let nothing = Seen { depth: f32::INFINITY, of: NOTHING, triangle: 0 };
        let rays = window.width * window.rows.len();
        let to_scene = to_rays.inverse();
        let Some((z_um, _)) = self.floor else { return vec![nothing; rays] };
        if to_scene.matrix3.z_axis.z >= -1e-9 {
            return vec![nothing; rays];
        }
        let floor = |at| {
            let start = to_scene.transform_point3(ray(at, window).extend(0.0));
            let depth = (z_um - start.z) / to_scene.matrix3.z_axis.z;
            Seen { depth: depth as f32, of: FLOOR, triangle: 0 }
        };
        (0..rays).map(floor).collect()
    }

    /// Groups the rays of each pixel by the facets that they meet.
    fn pieces(&self, seen: &[Seen], to_rays: &DAffine3, window: &Window, sub: usize) -> Vec<Piece> {
        let to_scene = to_rays.inverse();
        let bodies: Vec<&Body> = self.images.iter().flat_map(|image| &image.bodies).collect();
        let width = window.width / sub;
        let mut pieces = Vec::with_capacity(seen.len() / 2);
        let mut met: Vec<(Seen, DVec3, f64)> = Vec::with_capacity(sub * sub);
        for pixel in 0..seen.len() / (sub * sub) {
            let (row, column) = (pixel / width, pixel % width);
            met.clear();
            for y in row * sub..(row + 1) * sub {
                for x in column * sub..(column + 1) * sub {
                    let this = seen[y * window.width + x];
                    if this.of == NOTHING {
                        continue;
                    }
                    let place = DVec3::new(x as f64, y as f64, f64::from(this.depth));
                    let known = met.iter_mut().find(|(s, ..)| s.facet() == this.facet());
                    match known {
                        Some((_, sum, rays)) => (*sum, *rays) = (*sum + place, *rays + 1.0),
                        None => met.push((this, place, 1.0)),
                    }
                }
            }
            let first = DVec3::new(0.5, window.rows.start as f64 + 0.5, 0.0);
            pieces.extend(met.iter().map(|&(Seen { of, triangle, .. }, sum, rays)| {
                let (normal, material) = if of == FLOOR {
                    (Vec3::Z, self.floor.expect("it was seen").1)
                } else {
                    let Body { shape, to_scene: place } = bodies[of as usize];
                    let mesh = shape.mesh;
                    let away = to_scene.matrix3.z_axis;
                    let normal = normal(mesh, triangle as usize, &place.matrix3, away);
                    (normal.as_vec3(), mesh.materials[triangle as usize])
                };
                Piece {
                    pixel: window.rows.start / sub * width + pixel,
                    share: (rays / (sub * sub) as f64) as f32,
                    point: to_scene.transform_point3(sum / rays + first),
                    normal,
                    material,
                }
            }));
        }
        pieces
    }
}

/// The facet that a ray meets first.
#[derive(Debug, Clone, Copy)]
struct Seen {
    depth: f32,
    /// Number of the body in all images, or FLOOR or NOTHING.
    of: u32,
    triangle: u32,
}

impl Seen {
    fn facet(&self) -> (u32, u32) {
        (self.of, self.triangle)
    }
}

const FLOOR: u32 = u32::MAX - 1;
const NOTHING: u32 = u32::MAX;

/// Place of a ray in the picture, in units of the distance between rays.
fn ray(at: usize, window: &Window) -> DVec2 {
    let (x, y) = (at % window.width, window.rows.start + at / window.width);
    DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
}

/// The facet's normal on the camera's side.
fn normal(mesh: &Mesh, triangle: usize, turn: &DMat3, line_of_sight: DVec3) -> DVec3 {
    let [a, b, c] = mesh.triangles[triangle].map(|i| *turn * mesh.vertices[i as usize].as_dvec3());
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal.dot(line_of_sight) > 0.0 { -normal } else { normal }
}

fn body<'a>(shapes: &[Arc<Shape<'a>>], placement: &Placement) -> Body<'a> {
    let Placement { mesh, to_scene } = *placement;
    Body { shape: Arc::clone(&shapes[mesh]), to_scene }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry;
    use crate::geometry::ingest;
    use crate::scene::Scene;
    use crate::scene::View;
    use crate::support::monitor::Unwatched;
    use crate::tracer::Tracer;
    use crate::tracer::footprint::Footprint;

    /// The depth buffer and the ray tracer are independent.
    #[test]
    fn the_sensors_view_is_what_the_tracer_sees_from_above_and_through_the_mirrors() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/settled_patch.json");
        let scene = Scene::read(path.as_ref()).unwrap();
        for (zenith_deg, azimuth_deg) in [(0.0, 0.0), (35.0, 200.0), (70.0, 60.0)] {
            let mut bed = ingest::load(&scene).unwrap();
            bed.to_sensor = geometry::to_sensor(View { zenith_deg, azimuth_deg });
            let Footprint { corner, right, up } = Footprint::new(&bed.domain, bed.to_sensor);
            let camera = Camera { corner, right, up, to_eye: bed.to_sensor };
            let pieces = Stage::of_sensor(&bed).look(&camera, [200, 200], 1, &Unwatched).unwrap();
            let mut seen = vec![None; 200 * 200];
            for piece in pieces {
                let cosine = piece.normal.as_dvec3().dot(camera.to_eye);
                seen[piece.pixel] = Some((piece.material, cosine));
            }
            let tracer = Tracer::new(bed);
            let differ = seen.iter().enumerate().filter(|(pixel, seen)| {
                let place = |i: usize| (i as f64 + 0.5) / 200.0;
                let traced = tracer.first_hit([place(pixel % 200), 1.0 - place(pixel / 200)]);
                match (traced, seen) {
                    // At a mirror the tracer reflects the ray, not the facet.
                    (Some(hit), Some((material, y))) => {
                        hit.material != *material
                            || (zenith_deg == 0.0 && (hit.cosine - y).abs() > 1e-3)
                    }
                    (traced, seen) => traced.is_some() || seen.is_some(),
                }
            });
            let differ = differ.count();
            // Rays on an edge may see either facet.
            assert!(differ <= 40, "{differ} of 40000 from {zenith_deg}");
        }
    }
}
