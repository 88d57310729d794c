//! Beds whose radiative exchange has a closed form. All of them about 1000 um in size.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec3};
use soilsig::geometry::{Bed, Domain, Mesh, Placement};
use soilsig::scene::Sides;

/// Triangles as they are put together: two-sided surfaces of several materials.
#[derive(Default)]
struct Surface {
    points: Vec<DVec3>,
    faces: Vec<([u32; 3], u16)>,
}

impl Surface {
    fn triangle(&mut self, corners: [DVec3; 3], material: u16) {
        let first = self.points.len() as u32;
        self.points.extend(corners);
        self.faces.push(([first, first + 1, first + 2], material));
    }

    fn quad(&mut self, [a, b, c, d]: [DVec3; 4], material: u16) {
        self.triangle([a, b, c], material);
        self.triangle([a, c, d], material);
    }

    /// The band between two circles about the z axis, given by radius and height; polygons of so
    /// many sides.
    fn band(&mut self, circles: [(f64, f64); 2], sectors: u32, material: u16) {
        for sector in 0..sectors {
            let at = |(radius, z): (f64, f64), sector: u32| {
                let angle = TAU * f64::from(sector % sectors) / f64::from(sectors);
                DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
            };
            let [low, high] = circles;
            self.quad(
                [at(low, sector), at(low, sector + 1), at(high, sector + 1), at(high, sector)],
                material,
            );
        }
    }

    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.faces.iter().map(|(corners, _)| corners.map(|i| self.points[i as usize]))
    }

    fn seen_in(self, domain: Domain, materials: usize) -> Bed {
        let (mesh, middle) = Mesh::new("surface", &self.points, self.faces.into_iter());
        let placements = vec![Placement { mesh: 0, to_scene: DAffine3::from_translation(middle) }];
        Bed { meshes: vec![mesh], placements, repeated: 0, domain, to_sensor: DVec3::Z, materials }
    }
}

/// A square of the sensor's view at a height; what lies beyond it is there all the same.
fn window(half_um: f64, z_um: f64) -> Domain {
    let corner = DVec3::new(half_um, half_um, 0.0);
    let at = DVec3::new(0.0, 0.0, z_um);
    Domain {
        min_um: at - corner,
        max_um: at + corner,
        sides: Sides::Open,
        patches: [1, 1],
        floor: None,
    }
}

/// A part of a profile without end along y and, with its mirror images, along x.
fn profile(width_um: f64, height_um: f64) -> Domain {
    let (min_um, max_um) = (DVec3::NEG_Z, DVec3::new(width_um, 1000.0, height_um));
    Domain { min_um, max_um, sides: Sides::Mirror, patches: [1, 1], floor: None }
}

const RADIUS_UM: f64 = 1000.0;

/// The height below which a share of the sphere's area lies: area goes as height (Archimedes).
fn height_um(share: f64) -> f64 {
    RADIUS_UM * (2.0 * share - 1.0)
}

/// The sphere's circle of latitude at a height.
fn radius_um(z_um: f64) -> f64 {
    (RADIUS_UM * RADIUS_UM - z_um * z_um).max(0.0).sqrt()
}

/// The sphere below a height; material 1 where its share `lower` is, material 0 above.
fn ball_below(rim_um: f64, lower: f64, sectors: u32) -> Surface {
    let rings = sectors * 3 / 4;
    let border = height_um(lower);
    let mut heights: Vec<f64> = (0..=rings)
        .map(|i| -RADIUS_UM * (PI * f64::from(i) / f64::from(rings)).cos())
        .filter(|z| *z < rim_um)
        .chain([rim_um, border])
        .collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    let mut surface = Surface::default();
    for pair in heights.windows(2) {
        let circles = [(radius_um(pair[0]), pair[0]), (radius_um(pair[1]), pair[1])];
        surface.band(circles, sectors, u16::from(pair[1] <= border));
    }
    surface
}

/// A whole ball in the open, seen from the east; material 1 is its eastern half, material 0 the
/// other.
pub fn ball(zenith_deg: f64) -> Bed {
    let mut surface = ball_below(RADIUS_UM, 0.5, 256);
    // Laid on its side: its lower half looks east.
    for point in &mut surface.points {
        *point = DVec3::new(-point.z, point.y, point.x);
    }
    let corner = DVec3::splat(RADIUS_UM);
    let domain = Domain {
        min_um: -corner,
        max_um: corner,
        sides: Sides::Open,
        patches: [1, 1],
        floor: None,
    };
    let zenith = zenith_deg.to_radians();
    Bed { to_sensor: DVec3::new(zenith.sin(), 0.0, zenith.cos()), ..surface.seen_in(domain, 2) }
}

/// What of a cavity is seen.
#[derive(Clone, Copy, PartialEq)]
pub enum Seen {
    /// A spot through the opening's middle.
    Centre,
    /// All of the opening, with a square about it: the collar, of the last material.
    Opening,
}

/// The plane about an opening, wide enough for the square about it: fine at the rim and coarse
/// beyond.
fn add_collar(surface: &mut Surface, radius_um: f64, z_um: f64, sectors: u32, material: u16) {
    surface.band([(radius_um, z_um), (1.03 * radius_um, z_um)], sectors, material);
    // The coarse polygon's inner side lies within the fine band.
    surface.band([(1.02 * radius_um, z_um), (1.5 * radius_um, z_um)], 64, material);
}

/// A sphere of which a share `open` of the area is missing at the top; material 1 below the height
/// under which a share `lower` of its area lies, material 0 above, material 2 the collar.
///
/// Of an inscribed polyhedron with n sectors and 3 n / 4 rings a share of (pi / n)^2 / 4 or so of
/// the area is missing: the opening's share is larger by that. Emissivities change by at most a
/// quarter of it: 1e-5 for 256 sectors, 4e-5 for 128.
pub fn sphere(open: f64, lower: f64, seen: Seen) -> Bed {
    // One tree for each direction over the opening.
    let sectors = if seen == Seen::Opening { 128 } else { 256 };
    let rim = height_um(1.0 - open);
    let mut surface = ball_below(rim, lower, sectors);
    let half_um = match seen {
        Seen::Centre => 100.0,
        Seen::Opening => radius_um(rim),
    };
    add_collar(&mut surface, radius_um(rim), rim, sectors, 2);
    surface.seen_in(window(half_um, rim), 3)
}

/// A cylinder with a bottom, open at the top, of a depth in radii; material 0, material 1 the
/// collar. The polygon of n = 256 sides has the circle's area; its perimeter is longer by (pi /
/// n)^2 / 6 = 2.5e-5, its emissivity larger by less than a quarter of that.
pub fn cylinder(depth: f64, seen: Seen) -> Bed {
    let sectors = 256;
    let angle = TAU / f64::from(sectors);
    let radius = RADIUS_UM * (angle / angle.sin()).sqrt();
    let top = depth * RADIUS_UM;
    let mut surface = Surface::default();
    let corner = |x: f64, y: f64| 1.1 * radius * DVec3::new(x, y, 0.0);
    surface.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], 0);
    surface.band([(radius, 0.0), (radius, top)], sectors, 0);
    add_collar(&mut surface, radius, top, sectors, 1);
    // The radiosity is even about the centre: over a spot of a 300th of the radius it changes by
    // 1e-5 of itself.
    let half_um = match seen {
        Seen::Centre => RADIUS_UM / 300.0,
        Seen::Opening => radius,
    };
    surface.seen_in(window(half_um, top), 2)
}

/// Two square plates, material 0 below and material 1 above, so wide that less than 1e-5 of what
/// leaves one misses the other; the sensor looks down from between them.
pub fn parallel_plates() -> Bed {
    let half_um = 500.0 * RADIUS_UM;
    let plate = |z: f64| {
        let corner = |x: f64, y: f64| DVec3::new(half_um * x, half_um * y, z);
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
    };
    let mut surface = Surface::default();
    surface.quad(plate(0.0), 0);
    surface.quad(plate(RADIUS_UM), 1);
    surface.seen_in(window(RADIUS_UM, RADIUS_UM / 2.0), 2)
}

/// Which of two concentric spheres is looked at.
#[derive(Clone, Copy)]
pub enum Shell {
    /// The inner one.
    Inner,
    /// The outer one.
    Outer,
}

/// A sphere, material 0, in another, material 1, whose area is larger by 1 / `ratio`, and the
/// sensor between them.
///
/// The facets of both are alike, so the ratio of their areas is that of the spheres.
pub fn concentric_spheres(ratio: f64, seen: Shell) -> Bed {
    let outer = ball_below(RADIUS_UM, 0.0, 128);
    let inner_um = RADIUS_UM * ratio.sqrt();
    // The sensor looks down on the inner one's pole, or past its side.
    let mut domain = window(50.0, f64::midpoint(RADIUS_UM, inner_um));
    if let Shell::Outer = seen {
        let aside = DVec3::X * f64::midpoint(RADIUS_UM, inner_um);
        domain = Domain { min_um: domain.min_um + aside, max_um: domain.max_um + aside, ..domain };
        let down = DVec3::Z * domain.min_um.z;
        domain = Domain { min_um: domain.min_um - down, max_um: domain.max_um - down, ..domain };
    }
    let mut surface = Surface::default();
    for [a, b, c] in outer.triangles() {
        surface.triangle([a, b, c].map(|p| p * ratio.sqrt()), 0);
        surface.triangle([a, b, c], 1);
    }
    // A facet that nothing sees, in the middle: the mesh is no solid, then, and has two sides.
    surface.triangle([DVec3::ZERO, DVec3::X, DVec3::Y], 0);
    surface.seen_in(domain, 2)
}

/// Grooves side by side of an opening angle: one of them, and its mirror images.
pub fn v_grooves(angle_deg: f64) -> Bed {
    let (half_um, height_um) = (RADIUS_UM, RADIUS_UM / (angle_deg / 2.0).to_radians().tan());
    let mut surface = Surface::default();
    for side in [-1.0, 1.0] {
        // From the bottom to a little beyond the mirror, so that nothing slips by.
        let at =
            |share: f64, y: f64| DVec3::new(half_um * (1.0 + side * share), y, share * height_um);
        surface.quad([at(0.0, -10.0), at(1.01, -10.0), at(1.01, 1010.0), at(0.0, 1010.0)], 0);
    }
    surface.seen_in(profile(2.0 * half_um, height_um), 1)
}

/// Grooves side by side of a depth in widths, with walls without thickness between them.
pub fn rectangular_grooves(depth: f64) -> Bed {
    let (width, height) = (RADIUS_UM, depth * RADIUS_UM);
    let mut surface = Surface::default();
    let at = DVec3::new;
    surface.quad(
        [
            at(-10.0, -10.0, 0.0),
            at(width + 10.0, -10.0, 0.0),
            at(width + 10.0, 1010.0, 0.0),
            at(-10.0, 1010.0, 0.0),
        ],
        0,
    );
    let wall = |y, z| at(width / 2.0, y, z);
    surface.quad(
        [wall(-10.0, -10.0), wall(1010.0, -10.0), wall(1010.0, height), wall(-10.0, height)],
        0,
    );
    surface.seen_in(profile(width, height), 1)
}
