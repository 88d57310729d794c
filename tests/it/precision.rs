//! Nothing small is lost: gaps, coplanar and narrow facets, in meshes of any size and scenes in any
//! unit.

use std::collections::HashSet;

use glam::{DAffine3, DQuat, DVec3};
use soilsig::geometry::{Bed, Domain, Mesh, Placement, ingest};
use soilsig::histogram::kept::Kept;
use soilsig::histogram::tally::Tally;
use soilsig::scene::{Scene, Sides};
use soilsig::support::random::Purpose;
use soilsig::tracer::Tracer;
use soilsig::tracer::bvh::Accelerator;
use soilsig::tracer::rules::{Facet, TracingRules};

use crate::support::shipped_path;

/// Where the lines of a grid run, as shares of its width: narrow strips among them.
const LINES: [f64; 9] = [0.0, 0.1, 0.100_003, 0.3, 0.37, 0.5, 0.500_003, 0.9, 1.0];

/// A box of those sides about the origin, its top and bottom cut by `LINES`, its sides to match.
/// Without
/// `closed` it has two sides, and a ray may be in it.
fn cut_box(size_um: DVec3, closed: bool) -> Mesh {
    let n = LINES.len() as u32;
    let at = |top: u32, x: u32, y: u32| (top * n + y) * n + x;
    let mut points = Vec::new();
    for z in [-0.5, 0.5] {
        for y in LINES {
            points.extend(LINES.map(|x| DVec3::new(x - 0.5, y - 0.5, z) * size_um));
        }
    }
    let mut faces = Vec::new();
    let mut quad = |[a, b, c, d]: [u32; 4]| faces.extend([([a, b, c], 0), ([a, c, d], 0)]);
    let last = n - 1;
    for i in 0..last {
        for j in 0..last {
            let corners =
                |top| [at(top, i, j), at(top, i + 1, j), at(top, i + 1, j + 1), at(top, i, j + 1)];
            let [a, b, c, d] = corners(0);
            quad([d, c, b, a]);
            quad(corners(1));
        }
        quad([at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0)]);
        quad([at(0, i + 1, last), at(0, i, last), at(1, i, last), at(1, i + 1, last)]);
        quad([at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1)]);
        quad([at(0, last, i), at(0, last, i + 1), at(1, last, i + 1), at(1, last, i)]);
    }
    let (mut mesh, middle) = Mesh::new("box", &points, faces.into_iter());
    // A box a millionth as high as it is wide counts as a sheet.
    assert!((mesh.closed || !closed) && middle == DVec3::ZERO);
    mesh.closed = closed;
    mesh
}

/// A bed in the open, looked at from the top of a box.
fn bed(meshes: Vec<Mesh>, placements: Vec<Placement>, min_um: DVec3, max_um: DVec3) -> Bed {
    let domain = Domain { min_um, max_um, sides: Sides::Open, patches: [1, 1], floor: None };
    Bed { meshes, placements, repeated: 0, domain, to_sensor: DVec3::Z, materials: 1 }
}

fn trace(bed: Bed, most_hits: u16, paths: u64) -> Tally {
    let facets = vec![Facet::LAMBERTIAN; bed.materials];
    let rules = TracingRules { most_hits, ..TracingRules::of_facets(Kept::PLAIN, facets) };
    Tracer::new(bed).trace(&rules, 3, Purpose::Result, 0..paths, &|_| Ok(())).expect("traced")
}

fn placed(mesh: usize, to_scene: DAffine3) -> Placement {
    Placement { mesh, to_scene }
}

#[test]
fn from_between_two_plates_no_path_escapes_however_near_they_are() {
    for extent_um in [1e2, 1e4, 1e6] {
        for gap_um in [0.01, 0.1, 1.0, 0.5 * extent_um] {
            for at_um in [DVec3::ZERO, DVec3::splat(1e6)] {
                let mesh = cut_box(DVec3::new(extent_um, extent_um, gap_um), false);
                // The sensor is in the gap.
                let half = DVec3::new(0.4 * extent_um, 0.4 * extent_um, 0.2 * gap_um);
                let place = placed(0, DAffine3::from_translation(at_um));
                let tally =
                    trace(bed(vec![mesh], vec![place], at_um - half, at_um + half), 64, 2000);
                let case = format!("{gap_um} um between plates of {extent_um} um at {at_um}");
                assert!(
                    tally.by_group.escaped.is_empty() && tally.missed == 0,
                    "{case}: some escape"
                );
                assert_eq!(tally.hits, 64 * 2000, "{case}");
            }
        }
    }
}

#[test]
fn from_a_turned_enclosure_no_path_escapes_at_any_scale() {
    for scale in [1e-3, 1e-1, 1.0, 1e3, 1e6] {
        let mesh = cut_box(DVec3::new(70.0, 90.0, 40.0) * scale, false);
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.9));
        let at_um = DVec3::new(3000.0, -500.0, 77.0) * scale;
        let place = placed(0, DAffine3::from_rotation_translation(turn, at_um));
        let half = DVec3::splat(5.0 * scale);
        let tally = trace(bed(vec![mesh], vec![place], at_um - half, at_um + half), 128, 4000);
        assert!(tally.by_group.escaped.is_empty() && tally.missed == 0, "{scale}: some escape");
        assert_eq!(tally.hits, 128 * 4000);
    }
}

#[test]
fn a_convex_body_of_coplanar_and_narrow_facets_is_met_once() {
    for (extent_um, axis) in
        [(1.0, DVec3::ZERO), (500.0, DVec3::new(0.1, 0.4, 0.2)), (1e6, DVec3::X)]
    {
        let mesh = cut_box(DVec3::new(1.0, 0.7, 0.2) * extent_um, true);
        let turn = DQuat::from_scaled_axis(axis);
        let at_um = DVec3::new(1e4, 2e4, 3e4);
        let placements = vec![placed(0, DAffine3::from_rotation_translation(turn, at_um))];
        let meshes = vec![mesh];
        let (min_um, max_um) = Bed::bounds_um(&meshes, &placements);
        let tally = trace(bed(meshes, placements, min_um, max_um), 128, 100_000);
        assert!(
            tally.inside.is_empty() && tally.by_group.given_up.is_empty(),
            "{extent_um}: some enter it"
        );
        let met = tally.paths - tally.missed;
        assert!(tally.hits == met && met > 50_000, "{extent_um}: {} hits of {met}", tally.hits);
    }
}

/// A fine stands off a host a metre wide, each of a mesh of its own.
#[test]
fn a_gap_between_a_fine_and_its_host_is_kept() {
    for host_um in [1e2, 1e4, 1e6] {
        for gap_um in [0.01, 0.1, 1.0] {
            let meshes = vec![
                cut_box(DVec3::new(host_um, host_um, host_um), true),
                cut_box(DVec3::splat(5.0), true),
            ];
            let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
            let beside = DVec3::new(0.31 * host_um, 0.42 * host_um, 0.5 * host_um + gap_um + 2.5);
            let placements =
                vec![placed(0, turn), placed(1, turn * DAffine3::from_translation(beside))];
            let (min_um, max_um) = Bed::bounds_um(&meshes, &placements);
            let accelerator = Accelerator::new(&bed(meshes, placements, min_um, max_um));
            let up = turn.transform_vector3(DVec3::Z);
            for share in [0.25, 0.5, 0.75] {
                let from = beside + DVec3::new(0.3, -0.4, share * gap_um - gap_um - 2.5);
                let from = turn.transform_point3(from);
                for (direction, placement, t) in [(up, 1, 1.0 - share), (-up, 0, share)] {
                    let hit = accelerator.closest(from, direction, f64::INFINITY).expect("a hit");
                    assert_eq!(hit.placement, placement, "{gap_um} um on {host_um} um");
                    // Vertices are singles in their mesh: half a unit of the host's last place.
                    let error = host_um * 6e-8;
                    assert!((hit.t - t * gap_um).abs() <= error + 1e-6, "{} um", hit.t);
                }
            }
        }
    }
}

/// The settled patch in other units. Vertices are singles, and most would be rounded anew in other
/// units: here they are put on whole micrometres, and the units are such that all of them stay
/// exact. What differs is the tracer's own rounding.
#[test]
fn a_bed_in_other_units_gives_the_same_table() {
    let path = shipped_path("settled_patch.json");
    let patch = ingest::load(&Scene::read(&path).expect("a scene")).expect("meshes");
    let in_units = |scale: f64| {
        let mut bed = patch.clone();
        for vertex in bed.meshes.iter_mut().flat_map(|mesh| &mut mesh.vertices) {
            let scaled = vertex.as_dvec3().round() * scale;
            *vertex = scaled.as_vec3();
            assert_eq!(vertex.as_dvec3(), scaled, "exact");
        }
        for place in &mut bed.placements {
            place.to_scene.translation *= scale;
        }
        bed.domain.min_um *= scale;
        bed.domain.max_um *= scale;
        if let Some((z_um, _)) = &mut bed.domain.floor {
            *z_um *= scale;
        }
        trace(bed, 128, 2000)
    };
    let as_it_is = in_units(1.0);
    assert!(as_it_is.hits > 8000 && !as_it_is.by_group.escaped.is_empty());
    for scale in [125.0 / 2_f64.powi(17), 100.0 / 1024.0, 1e3, 1e6] {
        let other = in_units(scale);
        assert!(other.first_hits == as_it_is.first_hits, "{scale}: the first hits");
        let count = |of: &Tally, state| of.by_group.escaped.get(state).copied().unwrap_or(0);
        let states: HashSet<_> =
            other.by_group.escaped.keys().chain(as_it_is.by_group.escaped.keys()).collect();
        let apart: u64 =
            states.iter().map(|s| count(&other, *s).abs_diff(count(&as_it_is, *s))).sum();
        // A path that differs is missing in one place and too many in another. Doubles round
        // otherwise in other units, and a long path in a narrow gap magnifies that at every hit.
        assert!(apart <= 2 * 4, "{scale}: {} of 2000 paths differ", apart.div_ceil(2));
    }
}
