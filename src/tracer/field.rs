//! The bed beyond the sides of its domain: cells that all hold the same patch, each turned its own
//! way.
//!
//! A rule gives the turn of every cell: none (copies), that of a mirror image, or a hash. So
//! nothing is stored for a cell, and a field of any size takes the memory of its patch. A ray stays
//! in the coordinates of the patch: crossing a side moves it to where it enters the patch again. So
//! a place is as precise a metre away as in the first cell.
//!
//! Mirror images join without a seam. Other cells do not: a cell holds the patch's solids up to its
//! sides, and where a side cuts a solid there is a flat face of its material.

#[cfg(test)]
mod tests;

use glam::DVec3;

use super::footprint::Footprint;
use super::turn::Turn;
use crate::geometry::cut::Cut;
use crate::geometry::{Bed, Domain, patches};
use crate::scene::Sides;

/// Sides crossed between two hits after which a path is given up: a level ray through an empty gap
/// could go on for ever.
const MOST_CROSSINGS: u32 = 10_000;

/// The bed as it goes on beyond the sides of its domain.
pub(crate) struct Field {
    domain: Domain,
    to_sensor: DVec3,
    footprint: Footprint,
    /// Whether x and y of the patch may be swapped.
    square: bool,
    /// The solids cut by the sides: at the least and the greatest x, then y. `None` without seams.
    cuts: Option<[[Cut; 2]; 2]>,
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

impl Ray {
    /// A ray from a place that this one met, along a direction of the field.
    pub(crate) fn towards(self, origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction: self.turn.to_patch(direction), ..self }
    }
}

/// What a ray meets first. `H` is a hit on a mesh.
pub(crate) enum Meets<H> {
    Mesh(H),
    /// The floor, or a solid that a cell's side cuts. The normal is on the ray's side.
    Plane {
        material: u16,
        point: DVec3,
        normal: DVec3,
    },
    Sky,
    Lost,
}

/// How a ray leaves a cell: of a side the axis across it.
enum Exit {
    Sky,
    Floor(f64, u16),
    Side(usize),
}

impl Field {
    /// The bed within sides, which need not be those of its domain.
    ///
    /// # Panics
    /// If they make a field of too many patches ([`patches`]).
    pub(crate) fn new(bed: &Bed, sides: Sides) -> Self {
        let mut domain = Domain { sides, ..bed.domain.clone() };
        if let Sides::Field { particles, .. } = sides
            && sides != bed.domain.sides
        {
            domain.patches = patches(bed, particles).expect("a field that is not too large");
        }
        let size = domain.max_um - domain.min_um;
        let joined = matches!(domain.sides, Sides::Open | Sides::Mirror);
        let (min, max) = (domain.min_um, domain.max_um);
        let cut = |axis: usize| [min, max].map(|at| Cut::new(bed, axis, at[axis]));
        Self {
            to_sensor: bed.to_sensor,
            footprint: Footprint::new(&domain, bed.to_sensor),
            // Sides that differ by no more than rounding are equal.
            square: (size.x - size.y).abs() < 1e-9 * size.x,
            cuts: (!joined).then(|| [cut(0), cut(1)]),
            domain,
        }
    }

    /// The sensor's ray at a place in its view, 0 to 1 from the left and from below. Of a field it
    /// is a place in a patch, and `of_patch` gives that of the patch in the field.
    pub(crate) fn start(&self, place: [f64; 2], of_patch: impl FnOnce() -> [f64; 2]) -> Ray {
        let mut cell = [0, 0];
        let patches = self.domain.patches;
        if patches != [1, 1] {
            let of_patch = of_patch();
            for axis in 0..2 {
                cell[axis] = (of_patch[axis] * f64::from(patches[axis])) as i32;
            }
        }
        let turn = self.turn(cell);
        let direction = turn.to_patch(-self.to_sensor);
        let place = self.footprint.at(place);
        // From above everything: what stands beyond an open domain may hide a part of it.
        let below_um = (self.domain.max_um.z - place.z).max(0.0);
        Ray { origin: place + below_um / direction.z * direction, direction, cell, turn }
    }

    /// A ray from above, given in the scene's coordinates, where it enters the box of a cell. The
    /// middle patch of a field stands where the domain is. `None` if the ray never comes down.
    pub(crate) fn enter(&self, origin: DVec3, direction: DVec3) -> Option<Ray> {
        let Domain { min_um: min, max_um: max, sides, patches, .. } = self.domain;
        if sides == Sides::Open {
            return Some(Ray { origin, direction, cell: [0, 0], turn: Turn::default() });
        }
        if direction.z >= 0.0 {
            return None;
        }
        let place = origin + (max.z - origin.z).min(0.0) / direction.z * direction;
        let (mut cell, mut inward) = ([0; 2], [0.0; 2]);
        for axis in 0..2 {
            let size = max[axis] - min[axis];
            let number = ((place[axis] - min[axis]) / size).floor();
            cell[axis] = number as i32 + patches[axis] as i32 / 2;
            inward[axis] = (place[axis] - min[axis] - number * size).clamp(0.0, size);
        }
        let turn = self.turn(cell);
        let mut ray = Ray { origin: place, direction: turn.to_patch(direction), cell, turn };
        for axis in 0..2 {
            let over = turn.other(axis);
            ray.origin[axis] = if turn.flipped[over] {
                max[axis] - inward[over]
            } else {
                min[axis] + inward[over]
            };
        }
        Some(ray)
    }

    /// Follows a ray from cell to cell to what it meets first. `closest` gives the nearest hit on a
    /// mesh of the patch within a distance, um.
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
                Exit::Sky => return Meets::Sky,
                Exit::Floor(z_um, material) => {
                    // The floor hides everything below it: the next ray needs no lift.
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

    /// The material of the solid that a side cuts where a ray enters a cell through it.
    fn cut(&self, entered: &Ray, axis: usize) -> Option<u16> {
        let cuts = self.cuts.as_ref().filter(|_| self.has_patch(entered.cell))?;
        let cut = &cuts[axis][usize::from(entered.direction[axis] < 0.0)];
        cut.material(entered.origin[1 - axis], entered.origin.z)
    }

    /// Whether the patch stands in a cell. Beyond a field's rim there is only the floor.
    fn has_patch(&self, cell: [i32; 2]) -> bool {
        match self.domain.sides {
            Sides::Field { .. } => (0..2).all(|axis| {
                u32::try_from(cell[axis]).is_ok_and(|number| number < self.domain.patches[axis])
            }),
            Sides::Open | Sides::Mirror | Sides::Periodic => true,
        }
    }

    /// How the patch is turned in a cell.
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
