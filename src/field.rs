//! The bed beyond the sides of its domain: cells that all hold the same patch, each in a turn of its own.
//!
//! A rule gives the turn of every cell: none (copies), that of a mirror image, or one drawn by a hash. So
//! nothing is held for a cell, and a field of any size takes the memory of its patch. A ray is held in the
//! coordinates of the patch for its whole path; crossing a side moves it to where it enters the patch anew.
//! So a place is as precise a metre away as it is in the first cell.
//!
//! Mirror images join without a seam. Other cells do not: what stands in a cell is the patch's solids as far as
//! the cell's sides, and where a side cuts a solid there is a flat face of its material.

use glam::DVec3;

use crate::geometry::{Bed, Domain};
use crate::scene::Sides;
use crate::section::Section;

/// Sides crossed between two hits after which a path is given up as trapped: a level ray through an
/// empty gap could go on for ever.
const MOST_CROSSINGS: u32 = 10_000;

/// Most patches of a field along a side. A place of the sensor's view is drawn with 32 bits along a side: with
/// so many patches 16 are left within one.
pub(crate) const MOST_PATCHES: u32 = 1 << 16;

/// Patches along x and y of a field that has at least so many particles and is as near to a square as it can
/// be; `None` if they are too many, or the patch has none.
pub(crate) fn patches(bed: &Bed, particles: f64) -> Option<[u32; 2]> {
    let size = bed.domain.max_um - bed.domain.min_um;
    let wanted = (particles / bed.particles() as f64).ceil();
    let along_x = (wanted * size.y / size.x).sqrt().round().max(1.0);
    let along_y = (wanted / along_x).ceil();
    let fits = |number: f64| number <= f64::from(MOST_PATCHES);
    (fits(along_x) && fits(along_y)).then_some([along_x as u32, along_y as u32])
}

/// The bed as it goes on beyond the sides of its domain.
pub(crate) struct Field {
    domain: Domain,
    to_sensor: DVec3,
    footprint: Footprint,
    /// Whether x and y of the patch may change places.
    square: bool,
    /// What the sides cut: at the least and the greatest x, then y. None where no seam shows.
    sections: Option<[[Section; 2]; 2]>,
}

/// A ray in the coordinates of the patch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) origin: DVec3,
    /// Of length 1.
    pub(crate) direction: DVec3,
    cell: [i32; 2],
    turn: Turn,
}

/// What a ray meets first; `H` is a hit on a mesh.
pub(crate) enum Meets<H> {
    Mesh(H),
    /// The floor, or a solid that a cell's side cuts. The normal is on the ray's side.
    Plane {
        material: u16,
        point: DVec3,
        normal: DVec3,
    },
    Sky {
        downward: bool,
    },
    Lost,
}

/// How a ray leaves a cell; through a side, with the axis across it.
enum Exit {
    Sky,
    Floor(f64, u16),
    Side(usize),
}

impl Field {
    pub(crate) fn new(bed: &Bed) -> Self {
        let domain = bed.domain.clone();
        let size = domain.max_um - domain.min_um;
        let joined = matches!(domain.sides, Sides::Open | Sides::Mirror);
        let (min, max) = (domain.min_um, domain.max_um);
        let cut = |axis: usize| [min, max].map(|at| Section::new(bed, axis, at[axis]));
        Self {
            to_sensor: bed.to_sensor,
            footprint: Footprint::new(&domain, bed.to_sensor),
            // Sides that differ by no more than rounding are equal.
            square: (size.x - size.y).abs() < 1e-9 * size.x,
            sections: (!joined).then(|| [cut(0), cut(1)]),
            domain,
        }
    }

    /// The sensor's ray at a place of its view, 0 to 1 from the left and from below.
    pub(crate) fn start(&self, place: [f64; 2]) -> Ray {
        let mut cell = [0, 0];
        let mut within = place;
        for axis in 0..2 {
            let patches = self.domain.patches[axis];
            let at = place[axis] * f64::from(patches);
            cell[axis] = (at as i32).min(patches as i32 - 1);
            within[axis] = at - f64::from(cell[axis]);
        }
        let turn = self.turn(cell);
        let direction = turn.to_patch(-self.to_sensor);
        Ray { origin: self.footprint.at(within), direction, cell, turn }
    }

    /// Follows a ray to what it meets first, from cell to cell. `closest` gives the nearest hit on a mesh
    /// of the patch within a distance, um.
    pub(crate) fn follow<H>(
        &self,
        ray: &mut Ray,
        closest: impl Fn(&Ray, f64) -> Option<H>,
    ) -> Meets<H> {
        for _ in 0..MOST_CROSSINGS {
            let (t_exit, exit) = self.exit(ray);
            if self.has_patch(ray.cell)
                && let Some(hit) = closest(ray, t_exit)
            {
                return Meets::Mesh(hit);
            }
            ray.origin += t_exit * ray.direction;
            match exit {
                Exit::Sky => return Meets::Sky { downward: ray.direction.z < 0.0 },
                Exit::Floor(z_um, material) => {
                    // The floor is above everything below it by decree: no lift is needed to stay off it.
                    let point = DVec3::new(ray.origin.x, ray.origin.y, z_um);
                    let normal = if ray.direction.z < 0.0 { DVec3::Z } else { -DVec3::Z };
                    return Meets::Plane { material, point, normal };
                }
                Exit::Side(axis) => {
                    let (entered, axis_entered) = self.cross(ray, axis);
                    if let Some(material) = self.cut(&entered, axis_entered) {
                        // The next ray starts in the side and leaves it: it needs no lift either.
                        let mut point = ray.origin;
                        let forward = ray.direction[axis] > 0.0;
                        point[axis] = self.side_um(axis, forward);
                        let mut normal = DVec3::ZERO;
                        normal[axis] = if forward { -1.0 } else { 1.0 };
                        return Meets::Plane { material, point, normal };
                    }
                    *ray = entered;
                }
            }
        }
        Meets::Lost
    }

    /// Where a ray that meets no mesh leaves its cell.
    fn exit(&self, ray: &Ray) -> (f64, Exit) {
        let &Ray { origin, direction, .. } = ray;
        let mut nearest = (f64::INFINITY, Exit::Sky);
        if let Some((z_um, material)) = self.domain.floor {
            let t = (z_um - origin.z) / direction.z;
            if t > 0.0 {
                nearest = (t, Exit::Floor(z_um, material));
            }
        }
        if self.domain.sides == Sides::Open {
            return nearest;
        }
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                continue;
            }
            let at_um = self.side_um(axis, direction[axis] > 0.0);
            let t = ((at_um - origin[axis]) / direction[axis]).max(0.0);
            if t < nearest.0 {
                nearest = (t, if axis == 2 { Exit::Sky } else { Exit::Side(axis) });
            }
        }
        nearest
    }

    fn side_um(&self, axis: usize, greatest: bool) -> f64 {
        if greatest { self.domain.max_um[axis] } else { self.domain.min_um[axis] }
    }

    /// The ray in the cell beyond the side across `axis`, and the axis across that side there.
    fn cross(&self, ray: &Ray, axis: usize) -> (Ray, usize) {
        let Domain { min_um: min, max_um: max, .. } = self.domain;
        let old = ray.turn;
        let across = old.other(axis);
        let forward = (ray.direction[axis] > 0.0) != old.flipped[across];
        let mut cell = ray.cell;
        cell[across] += if forward { 1 } else { -1 };
        let new = self.turn(cell);
        let mut entered = Ray { cell, turn: new, ..*ray };
        for to in 0..2 {
            let over = new.other(to);
            let from = old.other(over);
            let flipped = old.flipped[over] != new.flipped[over];
            let direction = ray.direction[from];
            entered.direction[to] = if flipped { -direction } else { direction };
            entered.origin[to] = if over == across {
                self.side_um(to, entered.direction[to] < 0.0)
            } else if from == to && !flipped {
                ray.origin[to]
            } else {
                let inward = ray.origin[from] - min[from];
                if flipped { max[to] - inward } else { min[to] + inward }
            };
        }
        (entered, new.other(across))
    }

    /// The material of the solid that the side cuts where a ray enters a cell through it.
    fn cut(&self, entered: &Ray, axis: usize) -> Option<u16> {
        let sections = self.sections.as_ref().filter(|_| self.has_patch(entered.cell))?;
        let section = &sections[axis][usize::from(entered.direction[axis] < 0.0)];
        section.material(entered.origin[1 - axis], entered.origin.z)
    }

    /// Whether the patch stands in a cell: beyond a field's rim there is only the floor.
    fn has_patch(&self, cell: [i32; 2]) -> bool {
        match self.domain.sides {
            Sides::Field { .. } => (0..2).all(|axis| {
                u32::try_from(cell[axis]).is_ok_and(|number| number < self.domain.patches[axis])
            }),
            Sides::Open | Sides::Mirror | Sides::Periodic => true,
        }
    }

    /// How the patch stands in a cell.
    fn turn(&self, cell: [i32; 2]) -> Turn {
        match self.domain.sides {
            Sides::Open | Sides::Periodic => Turn::default(),
            Sides::Mirror => {
                Turn { swapped: false, flipped: cell.map(|number| number.rem_euclid(2) == 1) }
            }
            Sides::Field { seed, .. } => Turn::drawn(seed, cell, self.square),
        }
    }
}

/// One of the eight symmetries of a square, about the middle of the patch: x and y change places, or not,
/// and then either may be turned over.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Turn {
    swapped: bool,
    /// Of the field's axes.
    flipped: [bool; 2],
}

impl Turn {
    /// The turn of a cell. Of a patch that is not square x and y stay in their places.
    fn drawn(seed: u64, cell: [i32; 2], square: bool) -> Self {
        let [x, y] = cell.map(|number| u64::from(number as u32));
        let bits = scrambled(scrambled(seed) ^ (x << 32 | y));
        let bit = |number: u64| bits >> number & 1 == 1;
        Self { swapped: square && bit(0), flipped: [bit(1), bit(2)] }
    }

    /// The axis of the field that an axis of the patch lies along, or the other way round.
    fn other(self, axis: usize) -> usize {
        if self.swapped { 1 - axis } else { axis }
    }

    /// A direction of the field in the patch.
    fn to_patch(self, direction: DVec3) -> DVec3 {
        let mut turned = direction;
        for axis in 0..2 {
            let over = self.other(axis);
            turned[axis] = if self.flipped[over] { -direction[over] } else { direction[over] };
        }
        turned
    }
}

/// The output function of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): every bit of the result depends on
/// every bit given.
fn scrambled(bits: u64) -> u64 {
    let mut z = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The parallelogram from which the sensor's rays start; of a field that over one patch.
pub(crate) struct Footprint {
    pub(crate) corner: DVec3,
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
}

impl Footprint {
    /// Where the bed goes on beyond its domain, the plan of the domain at its top: any part of the plan
    /// sees the same. In the open a rectangle across the line of sight that covers all of the domain's
    /// box, so that the target is seen whole from any side.
    pub(crate) fn new(domain: &Domain, to_sensor: DVec3) -> Self {
        let (min, max) = (domain.min_um, domain.max_um);
        let size = max - min;
        if domain.sides != Sides::Open {
            let corner = DVec3::new(min.x, min.y, max.z);
            return Self { corner, right: size.x * DVec3::X, up: size.y * DVec3::Y };
        }
        let level = DVec3::Z.cross(to_sensor);
        let right = if level.length() > 1e-9 { level.normalize() } else { DVec3::X };
        let up = to_sensor.cross(right);
        let middle = (min + max) / 2.0;
        // Half the extent of the box along a unit vector.
        let reach = |axis: DVec3| (size.dot(axis.abs())) / 2.0;
        let corner = middle + reach(to_sensor) * to_sensor - reach(right) * right - reach(up) * up;
        Self { corner, right: 2.0 * reach(right) * right, up: 2.0 * reach(up) * up }
    }

    fn at(&self, [u, v]: [f64; 2]) -> DVec3 {
        self.corner + u * self.right + v * self.up
    }
}
