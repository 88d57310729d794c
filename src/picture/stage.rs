//! What stands before the camera, and the pieces of surface that it sees.

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::camera::Camera;
use super::visible::{Body, Scratch, Window};
use crate::error::Error;
use crate::geometry::{Bed, Mesh, Placement};
use crate::interrupt;
use crate::scene::Sides;

/// Rows of a picture that are drawn at a go; fixed, so that the work is cut the same way for any number of
/// threads.
const BAND: usize = 40;

/// Bodies, and a plane without end below them.
pub(crate) struct Stage<'a> {
    /// The bodies, and their mirror images where the sides are mirrors.
    images: Vec<Image<'a>>,
    /// Height, um, and material.
    floor: Option<(f64, u16)>,
}

/// The bodies once, as they stand or seen in the mirrors.
struct Image<'a> {
    bodies: Vec<Body<'a>>,
    /// Least and greatest x and y of what is seen of them, um.
    within: Option<[DVec2; 2]>,
    /// No ray of the camera travels less than this before it sees any of it, um.
    nearest_um: f64,
}

/// What a pixel sees of one facet.
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
        let radii = radii(meshes);
        let bodies = placements.iter().map(|p| body(meshes, &radii, p)).collect();
        Self { images: vec![Image { bodies, within: None, nearest_um: 0.0 }], floor }
    }

    /// A bed as the sensor sees it: through mirror sides its mirror images as well.
    pub fn of_sensor(bed: &'a Bed) -> Self {
        let (min, max) = (bed.domain.min_um, bed.domain.max_um);
        let depth = max.z - min.z;
        let slant = bed.to_sensor.truncate() / bed.to_sensor.z;
        if bed.domain.sides == Sides::Open || slant == DVec2::ZERO {
            return Self::new(&bed.meshes, &bed.placements, bed.domain.floor);
        }
        let size = (max - min).truncate();
        let radii = radii(&bed.meshes);
        // The rays start over the first cell and leave the bed's depth `slant * depth` further on.
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
                    body(&bed.meshes, &radii, &Placement { mesh, to_scene: mirror * to_scene })
                });
                let corner = min.truncate() + DVec2::new(cell[0] as f64, cell[1] as f64) * size;
                let within = Some([corner, corner + size]);
                Image { bodies: bodies.collect(), within, nearest_um }
            })
            .collect();
        images.sort_by(|a, b| a.nearest_um.total_cmp(&b.nearest_um));
        Self { images, floor: bed.domain.floor }
    }

    /// All that casts shadows on what is seen before a distance, um.
    pub fn bodies(&self, farthest_um: f64) -> impl Iterator<Item = &Body<'a>> {
        let near = self.images.iter().take_while(move |image| image.nearest_um <= farthest_um);
        near.flat_map(|image| &image.bodies)
    }

    /// What each pixel sees, by `sub` x `sub` rays.
    pub fn look(
        &self,
        camera: &Camera,
        [width, height]: [usize; 2],
        sub: usize,
    ) -> Result<Vec<Piece>, Error> {
        let to_rays = camera.to_pixels(width * sub, height * sub);
        let bands: Vec<Vec<Piece>> = (0..height.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                if interrupt::requested() {
                    return Err(Error::Interrupted);
                }
                let rows = band * BAND..((band + 1) * BAND).min(height);
                let window = Window { width: width * sub, rows: rows.start * sub..rows.end * sub };
                let seen = self.seen(camera, &to_rays, &window);
                Ok(self.pieces(&seen, &to_rays, &window, sub))
            })
            .collect::<Result<_, _>>()?;
        Ok(bands.concat())
    }

    /// The nearest facet at every ray of a window.
    fn seen(&self, camera: &Camera, to_rays: &DAffine3, window: &Window) -> Vec<Seen> {
        let mut seen = self.floor_seen(to_rays, window);
        let mut scratch = Scratch::new();
        let to_scene = to_rays.inverse();
        let mut first = 0;
        for image in &self.images {
            if image.nearest_um > 0.0 && seen.iter().all(|s| f64::from(s.depth) < image.nearest_um)
            {
                break;
            }
            for (number, body) in image.bodies.iter().enumerate() {
                let of = (first + number) as u32;
                body.draw(to_rays, window, &mut scratch, |at, depth, triangle| {
                    if depth < seen[at].depth
                        && image.within.is_none_or(|[min, max]| {
                            let place = ray(at, window).extend(f64::from(depth));
                            let point = to_scene.transform_point3(place).truncate();
                            point.cmpge(min).all() && point.cmple(max).all()
                        })
                    {
                        seen[at] = Seen { depth, of, triangle };
                    }
                });
            }
            first += image.bodies.len();
        }
        let _ = camera;
        seen
    }

    /// The floor alone: its depth is linear in x and y.
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

    /// The rays of each pixel, put together by the facets that they meet.
    fn pieces(&self, seen: &[Seen], to_rays: &DAffine3, window: &Window, sub: usize) -> Vec<Piece> {
        let to_scene = to_rays.inverse();
        let bodies: Vec<&Body> = self.images.iter().flat_map(|image| &image.bodies).collect();
        let width = window.width / sub;
        let mut pieces = Vec::new();
        let mut met: Vec<(Seen, DVec3, f64)> = Vec::with_capacity(sub * sub);
        for row in 0..window.rows.len() / sub {
            for column in 0..width {
                met.clear();
                for k in 0..sub * sub {
                    let at = (row * sub + k / sub) * window.width + column * sub + k % sub;
                    let this = seen[at];
                    if this.of == NOTHING {
                        continue;
                    }
                    let place = ray(at, window).extend(f64::from(this.depth));
                    match met
                        .iter_mut()
                        .find(|(s, ..)| (s.of, s.triangle) == (this.of, this.triangle))
                    {
                        Some((_, sum, rays)) => (*sum, *rays) = (*sum + place, *rays + 1.0),
                        None => met.push((this, place, 1.0)),
                    }
                }
                let pixel = (window.rows.start / sub + row) * width + column;
                pieces.extend(met.iter().map(|&(Seen { of, triangle, .. }, sum, rays)| {
                    let point = to_scene.transform_point3(sum / rays);
                    let share = (rays / (sub * sub) as f64) as f32;
                    if of == FLOOR {
                        let material = self.floor.expect("it was seen").1;
                        return Piece { pixel, share, point, normal: Vec3::Z, material };
                    }
                    let Body { mesh, to_scene: place, .. } = bodies[of as usize];
                    let towards = to_rays.inverse().matrix3.z_axis;
                    let normal = normal(mesh, triangle as usize, &place.matrix3, towards).as_vec3();
                    Piece {
                        pixel,
                        share,
                        point,
                        normal,
                        material: mesh.materials[triangle as usize],
                    }
                }));
            }
        }
        pieces
    }
}

/// Which facet a ray meets first.
#[derive(Debug, Clone, Copy)]
struct Seen {
    depth: f32,
    /// Number of the body in all images, or one of the two below.
    of: u32,
    triangle: u32,
}

const FLOOR: u32 = u32::MAX - 1;
const NOTHING: u32 = u32::MAX;

/// Where the ray of that number goes through the picture, in units of the distance of rays.
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

fn radii(meshes: &[Mesh]) -> Vec<f32> {
    let radius = |mesh: &Mesh| mesh.vertices.iter().map(|v| v.length()).fold(0.0, f32::max);
    meshes.iter().map(radius).collect()
}

fn body<'a>(meshes: &'a [Mesh], radii: &[f32], placement: &Placement) -> Body<'a> {
    let Placement { mesh, to_scene } = *placement;
    Body { mesh: &meshes[mesh], to_scene, radius_um: radii[mesh] }
}
