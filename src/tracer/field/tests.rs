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
    let max_um = (corner + size).extend(100.0);
    let domain = Domain { patches, ..Domain::new(corner.extend(0.0), max_um, sides) };
    let placements = mesh.iter().map(placed).collect();
    let meshes = mesh.into_iter().collect();
    Bed { meshes, placements, repeated: 0, domain, to_sensor: DVec3::Z, materials: 1 }
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
            let hit = match field.follow(&mut ray, |r, t| mesh.closest(r.origin, r.direction, t)) {
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
