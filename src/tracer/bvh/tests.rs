use super::*;
use crate::geometry::Domain;
use crate::scene::Sides;
use crate::support::random::{Purpose, Source, Stream};
use lanes::{Portable, Work};

fn point(random: &mut Stream) -> DVec3 {
    let ([x, y], [z, _]) = (random.pair(), random.pair());
    DVec3::new(x, y, z) * 2.0 - 1.0
}

/// Soups of triangles, slivers and coplanar neighbours among them, scaled, turned and sheared.
fn bed(random: &mut Stream, extent_um: f64) -> Bed {
    let meshes = (0..3).map(|number| {
        let count = [1, 70, 900][number];
        let mut points = Vec::new();
        for i in 0..count {
            let (at, size) = (point(random), 10_f64.powf(2.0 * random.pair()[0] - 2.5));
            let (b, c) = (at + size * point(random), at + size * point(random));
            points.extend([at, b, if i % 5 == 0 { at + (b - at) * 1.001 + 1e-6 * c } else { c }]);
            if i % 3 == 0 {
                points.extend([c, b, b + c - at]);
            }
        }
        for p in &mut points {
            *p *= extent_um;
        }
        let faces = (0..points.len() as u32 / 3).map(|i| ([3 * i, 3 * i + 1, 3 * i + 2], 0));
        Mesh::new("soup", &points, faces).0
    });
    let meshes: Vec<Mesh> = meshes.collect();
    let placements = (0..40).map(|i| {
        let mut to_scene = DAffine3::from_scale_rotation_translation(
            DVec3::ONE + 0.5 * point(random),
            glam::DQuat::from_scaled_axis(3.0 * point(random)),
            2.0 * extent_um * point(random),
        );
        if i % 4 == 0 {
            to_scene.matrix3.x_axis *= -1.0;
        }
        Placement { mesh: i % 3, to_scene }
    });
    let extent = DVec3::splat(extent_um);
    let domain = Domain::new(-extent, extent, Sides::Open);
    let placements = placements.collect();
    Bed { meshes, placements, repeated: 0, domain, to_sensor: DVec3::Z, materials: 1 }
}

/// Every triangle of every placement, in double precision.
fn every(bed: &Bed, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
    let mut best = Hit::none(t_max);
    for (placement, place) in bed.placements.iter().enumerate() {
        let to_mesh = place.to_scene.inverse();
        let ray = Ray::new(to_mesh.transform_point3(origin), to_mesh.transform_vector3(direction));
        let mesh = &bed.meshes[place.mesh];
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            let corners = corners.map(|i| mesh.vertices[i as usize]);
            let met = ray.meet(|corner, axis| corners[corner][axis].into());
            if let Some(met) = met.filter(|met| met.t < best.t) {
                let (t, weights) = (met.t, met.weights());
                best = Hit { t, placement, triangle, corners, weights };
            }
        }
    }
    best.found()
}

#[test]
fn the_walk_finds_to_the_last_bit_what_testing_every_triangle_finds() {
    for (number, extent_um) in [1e-3, 300.0, 1e6].into_iter().enumerate() {
        let mut random = Source::new(5, Purpose::Result).stream(number as u64);
        let bed = bed(&mut random, extent_um);
        let accelerator = Accelerator::new(&bed);
        let (mut hits, mut near) = (0, None);
        for i in 0..3000 {
            let random = &mut random;
            let mut direction = point(random).normalize();
            let origin = match (i % 4, near) {
                // On a facet, as after a hit.
                (1 | 2, Some(on)) => on,
                // From far away, and along an axis.
                (3, _) => {
                    direction = [DVec3::X, DVec3::Y, -DVec3::Z][i / 4 % 3];
                    extent_um * (point(random) - 1000.0 * direction)
                }
                _ => 2.0 * extent_um * point(random),
            };
            if i % 2 == 0 {
                // At an edge, or at a corner: which side of it the ray passes is for doubles to
                // say.
                let place = &bed.placements[(random.pair()[0] * 40.0) as usize];
                let mesh = &bed.meshes[place.mesh];
                let number = (random.pair()[0] * mesh.triangles.len() as f64) as usize;
                let [a, b, _] =
                    mesh.triangles[number].map(|i| mesh.vertices[i as usize].as_dvec3());
                let share = if i % 8 == 0 { 0.0 } else { random.pair()[0] };
                let at = place.to_scene.transform_point3(a.lerp(b, share));
                direction = (at - origin).normalize();
            }
            let t_max = if i % 5 == 0 { extent_um } else { f64::INFINITY };
            let found = accelerator.closest(origin, direction, t_max);
            let expected = every(&bed, origin, direction, t_max);
            assert_eq!(found, expected, "ray {i} in {extent_um} um");
            for any in [false, true] {
                let found = with_stack(accelerator.stack, |stack| {
                    let accelerator = &accelerator;
                    let search = InBed { accelerator, origin, direction, t_max, any, stack };
                    search.run::<Portable>().found()
                });
                if any {
                    assert_eq!(found.is_some(), expected.is_some(), "any, without vectors");
                } else {
                    assert_eq!(found, expected, "without vectors");
                }
            }
            let any = accelerator.any(origin, direction, t_max);
            assert_eq!(any, expected.is_some(), "any of ray {i} in {extent_um} um");
            hits += usize::from(found.is_some());
            near = found.map(|hit| origin + hit.t * direction).or(near);
        }
        assert!(hits > 1000, "{hits} hits tell little");
    }
}
