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

use super::footprint::Footprint;
use super::turn::Turn;
use crate::geometry::cut::Section;
use crate::geometry::{Bed, Domain, patches};
use crate::scene::Sides;

/// Sides crossed between two hits after which a path is given up as trapped: a level ray through an
/// empty gap could go on for ever.
const MOST_CROSSINGS: u32 = 10_000;

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
    Sky,
    Lost,
}

/// How a ray leaves a cell; through a side, with the axis across it.
enum Exit {
    Sky,
    Floor(f64, u16),
    Side(usize),
}

impl Field {
    /// The bed within sides, which need not be those of its domain.
    ///
    /// # Panics
    /// If they make a field that the bed is too few of the particles of ([`patches`]).
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

    /// The sensor's ray at a place of its view, 0 to 1 from the left and from below; of a field at that
    /// place of a patch, whose place in the field is asked for in the same way.
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
        // From above all there is: beyond an open domain there may stand what hides a part of it.
        let below_um = (self.domain.max_um.z - place.z).max(0.0);
        Ray { origin: place + below_um / direction.z * direction, direction, cell, turn }
    }

    /// A ray from anywhere above, given in the coordinates of the scene, where it comes into the domain's box or into that
    /// of another cell; of a field the middle patch stands where the domain is. `None` if it never comes down.
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
                Exit::Sky => return Meets::Sky,
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

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3, DVec2};

    use super::*;
    use crate::geometry::{MOST_PATCHES, Mesh, Placement};
    use crate::tracer::bvh::Accelerator;
    use crate::tracer::turn::scrambled;

    /// A patch from (10, -20) on with the given meshes.
    fn bed(size: DVec2, sides: Sides, patches: [u32; 2], mesh: Option<Mesh>) -> Bed {
        let corner = DVec2::new(10.0, -20.0);
        let placed = |_: &Mesh| {
            let middle = corner.extend(0.0) + DVec3::new(0.35 * size.x, 0.6 * size.y, 40.0);
            Placement { mesh: 0, to_scene: DAffine3::from_translation(middle) }
        };
        let domain = Domain {
            min_um: corner.extend(0.0),
            max_um: (corner + size).extend(100.0),
            sides,
            patches,
            floor: None,
        };
        let placements = mesh.iter().map(placed).collect();
        let meshes = mesh.into_iter().collect();
        Bed { meshes, placements, domain, to_sensor: DVec3::Z, materials: 1 }
    }

    fn field(seed: u64) -> Sides {
        Sides::Field { particles: 1.0, seed }
    }

    /// From the patch to the scene in which the first cell begins at 0, exactly but for rounding.
    fn to_scene(bed: &Bed, ray: &Ray) -> DAffine3 {
        let Domain { min_um, max_um, .. } = bed.domain;
        let half = (max_um - min_um) / 2.0;
        let cell = DVec3::new(f64::from(ray.cell[0]), f64::from(ray.cell[1]), 0.0);
        let middle = min_um + half;
        let turn = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::Z).to_cols_array_2d().map(|e| {
            // The columns are what becomes of the patch's axes.
            let e = DVec3::from_array(e);
            let mut turned = e;
            for axis in 0..2 {
                let over = ray.turn.other(axis);
                turned[over] = if ray.turn.flipped[over] { -e[axis] } else { e[axis] };
            }
            turned
        });
        let turn = DMat3::from_cols(turn[0], turn[1], turn[2]);
        let to = half * (2.0 * cell + 1.0);
        DAffine3 { matrix3: turn, translation: to.truncate().extend(middle.z) - turn * middle }
    }

    #[test]
    fn every_turn_is_drawn_as_often_and_neighbours_turn_on_their_own() {
        for (square, turns) in [(true, 8), (false, 4)] {
            let mut drawn = std::collections::HashMap::new();
            let (mut alike, cells) = ([0, 0], 200);
            for x in 0..cells {
                for y in 0..cells {
                    let turn = Turn::drawn(7, [x, y], square);
                    let key = (turn.swapped, turn.flipped);
                    *drawn.entry(key).or_insert(0) += 1;
                    alike[0] += i32::from(turn == Turn::drawn(7, [x + 1, y], square));
                    alike[1] += i32::from(turn == Turn::drawn(7, [x, y + 1], square));
                }
            }
            assert_eq!(drawn.len(), turns as usize);
            let mean = f64::from(cells * cells / turns);
            for number in drawn.values().chain(&alike) {
                assert!(
                    (f64::from(*number) - mean).abs() < 5.0 * mean.sqrt(),
                    "{drawn:?} {alike:?}"
                );
            }
        }
        let row = |seed| (0..64).map(move |x| Turn::drawn(seed, [x, 0], true));
        assert!(row(1).ne(row(2)), "another seed, another field");
    }

    /// A box, solid, that is alike in none of the eight turns.
    fn block() -> Mesh {
        let size = DVec3::new(50.0, 22.0, 60.0);
        let corner = |i: u32| {
            let bit = |n: u32| f64::from(i >> n & 1);
            size * DVec3::new(bit(0), bit(1), bit(2)) + DVec3::new(0.0, 7.0 * bit(0) * bit(2), 0.0)
        };
        let corners: Vec<DVec3> = (0..8).map(corner).collect();
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let mesh = Mesh::new("block", &corners, faces.map(|face| (face, 0))).0;
        assert!(mesh.closed && mesh.particles.len() == 1);
        mesh
    }

    #[test]
    fn a_ray_meets_in_a_field_what_it_meets_among_copies_in_the_scene() {
        for (size, patches) in [(DVec2::splat(120.0), [5, 4]), (DVec2::new(150.0, 110.0), [3, 6])] {
            let bed = bed(size, field(3), patches, Some(block()));
            let field = Field::new(&bed, bed.domain.sides);
            let mesh = Accelerator::new(&bed);
            // The same field as placed copies.
            let mut copies = bed.clone();
            copies.placements.clear();
            for x in 0..patches[0] as i32 {
                for y in 0..patches[1] as i32 {
                    let cell = [x, y];
                    let turn = field.turn(cell);
                    let ray = Ray { origin: DVec3::ZERO, direction: DVec3::Z, cell, turn };
                    let there = to_scene(&bed, &ray);
                    let to_scene = there * bed.placements[0].to_scene;
                    copies.placements.push(Placement { mesh: 0, to_scene });
                }
            }
            let all = Accelerator::new(&copies);
            let (mut met, mut crossed) = (0, 0);
            for i in 0..4000 {
                let number = |n: u64| scrambled(i * 8 + n) as f64 / 2_f64.powi(64);
                let mut ray = field.start([number(0), number(1)], || [number(2), number(3)]);
                let around = std::f64::consts::TAU * number(4);
                let level = DVec2::from_angle(around) * (2.0 + 8.0 * number(5));
                ray.direction = level.extend(-1.0).normalize();
                let at_start = to_scene(&bed, &ray);
                let origin = at_start.transform_point3(ray.origin);
                let direction = at_start.matrix3 * ray.direction;
                let start = ray.cell;
                let hit = match field
                    .follow(&mut ray, |r, t| mesh.closest(r.origin, r.direction, t))
                {
                    Meets::Mesh(hit) => {
                        let there = to_scene(&bed, &ray);
                        crossed += u32::from(ray.cell != start);
                        assert!((there.matrix3 * ray.direction - direction).length() < 1e-12);
                        let end = there.transform_point3(ray.origin + hit.t * ray.direction);
                        Some((end - origin).length())
                    }
                    Meets::Sky => None,
                    Meets::Plane { .. } | Meets::Lost => panic!("there is neither floor nor seam"),
                };
                let expected = all.closest(origin, direction, f64::INFINITY).map(|hit| hit.t);
                met += u32::from(hit.is_some());
                match (hit, expected) {
                    (Some(a), Some(b)) => assert!((a - b).abs() < 1e-3, "{a} {b}"),
                    (a, b) => assert!(a.is_none() && b.is_none(), "ray {i}: {a:?} {b:?}"),
                }
            }
            assert!(met > 800 && crossed > 300, "{met} {crossed}");
        }
    }

    #[test]
    fn places_a_metre_away_are_as_exact_as_in_the_first_cell() {
        // Going by (3, 4, 0) / 5 through cells of 999 um all is known in thirds of a micrometre.
        let side = 999_i64;
        for sides in [Sides::Periodic, field(5)] {
            let patches = [2000, 2000];
            let bed = bed(DVec2::splat(side as f64), sides, patches, None);
            let field = Field::new(&bed, sides);
            let mut ray = field.start([0.5, 0.5], || [0.0, 0.0]);
            let start = to_scene(&bed, &ray).transform_point3(ray.origin);
            assert_eq!((start.x, start.y), (499.5, 499.5));
            ray.origin.z = 50.0;
            // The field's direction in the patch of the first cell.
            ray.direction = ray.turn.to_patch(DVec3::new(0.6, 0.8, 0.0));
            let mut crossed = 0;
            while ray.cell[0] < 1001 {
                let (t, exit) = field.exit(&ray);
                let Exit::Side(axis) = exit else { panic!("it goes level") };
                ray.origin += t * ray.direction;
                ray = field.cross(&ray, axis).0;
                crossed += 1;
            }
            assert_eq!(crossed, 1001 + ray.cell[1]);
            // Within its own cell, so that the metre does not blur the comparison.
            let here = Ray { cell: [0, 0], ..ray };
            let place = to_scene(&bed, &here).transform_point3(ray.origin);
            let gone_x_sixths = 6 * 1001 * side - 3 * side;
            let y_eighteenths = 18 * side / 2 + 4 * gone_x_sixths;
            let y = (y_eighteenths % (18 * side)) as f64 / 18.0;
            assert_eq!(i64::from(ray.cell[1]), y_eighteenths / (18 * side));
            assert!(place.x.abs() < 1e-9 && (place.y - y).abs() < 1e-9, "{place} {y}");
        }
    }

    #[test]
    fn beyond_a_fields_rim_there_is_nothing_to_meet() {
        let bed = bed(DVec2::splat(120.0), field(3), [2, 2], Some(block()));
        let field = Field::new(&bed, bed.domain.sides);
        let mut ray = field.start([0.5, 0.5], || [0.0, 0.0]);
        ray.cell = [2, 0];
        ray.direction = ray.turn.to_patch(DVec3::new(1.0, 0.0, 1e-3).normalize());
        ray.origin.z = 40.0;
        let missed = field.follow(&mut ray, |_, _| -> Option<()> { panic!("no patch is there") });
        assert!(matches!(missed, Meets::Sky));
    }

    #[test]
    fn a_field_has_the_particles_asked_for_and_is_nearly_square() {
        let mesh = block();
        let one = bed(DVec2::splat(120.0), field(0), [1, 1], Some(mesh.clone()));
        let wide = bed(DVec2::new(480.0, 120.0), field(0), [1, 1], Some(mesh));
        for wanted in [1.0, 2.0, 12.0, 13.0, 1e4, 1.23e7] {
            for bed in [&one, &wide] {
                let [x, y] = patches(bed, wanted).expect("not too many").map(f64::from);
                assert!(x * y >= wanted && x * (y - 1.0) < wanted);
                let size = bed.domain.max_um - bed.domain.min_um;
                let ratio = x * size.x / (y * size.y);
                assert!(wanted < 1e4 || (ratio - 1.0).abs() < 0.03, "{wanted}: {x} x {y}");
            }
        }
        assert_eq!(patches(&one, 1e10), None, "more than {MOST_PATCHES} a side");
        let empty = bed(DVec2::splat(120.0), field(0), [1, 1], None);
        assert_eq!(patches(&empty, 1.0), None);
    }
}
