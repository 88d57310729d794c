//! `soilsig grains` with real Blenders: what the shapes are asked for is what they measure.

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::Path;

use insta::assert_snapshot;
use soilsig::products::grains::Report;

use crate::support::{
    Place, a_blender, cross, dot, real_blenders, sub, without_numbers, without_places,
};

fn grains(place: &Place, blender: &Path, args: &[&str]) -> Report {
    let report = place.run_with(blender, &[&["grains", "--json"], args].concat());
    serde_json::from_str(&report).expect("the report")
}

/// Corners and facets of an object, and where its corners begin in the file.
type Object = (Vec<[f64; 3]>, Vec<Vec<usize>>);

/// The objects of a .obj, read here so that the program's reader is not its own witness.
fn objects(path: &Path) -> BTreeMap<String, Object> {
    let text = fs::read_to_string(path).expect("written");
    let mut objects: BTreeMap<String, Object> = BTreeMap::new();
    let (mut name, mut before, mut corners) = (String::new(), 0, 0);
    for line in text.lines() {
        let mut words = line.split(' ');
        match words.next() {
            Some("o") => {
                before = corners;
                words.next().expect("a name").clone_into(&mut name);
            }
            Some("v") => {
                let xyz: Vec<f64> = words.map(|word| word.parse().expect("a number")).collect();
                let object = objects.entry(name.clone()).or_default();
                object.0.push(xyz.try_into().expect("three numbers"));
                corners += 1;
            }
            Some("f") => {
                let facet = words.map(|word| word.parse::<usize>().expect("an index") - 1 - before);
                objects.entry(name.clone()).or_default().1.push(facet.collect());
            }
            _ => {}
        }
    }
    objects
}

/// Closed, outward and convex: every edge is run along once each way, and no corner stands before a
/// facet. Returns the sphericity.
fn sphericity_of_sound((corners, facets): &Object) -> f64 {
    let mut edges = HashSet::new();
    let (mut volume, mut surface) = (0.0, 0.0);
    for facet in facets {
        let origin = corners[facet[0]];
        let spokes: Vec<_> =
            facet[1..].iter().map(|&corner| sub(corners[corner], origin)).collect();
        let mut across = [0.0; 3];
        for pair in spokes.windows(2) {
            let fan = cross(pair[0], pair[1]);
            across = std::array::from_fn(|i| across[i] + fan[i]);
        }
        let twice = dot(across, across).sqrt();
        surface += twice / 2.0;
        volume += dot(origin, across) / 6.0;
        let normal = across.map(|x| x / twice);
        for &corner in corners {
            // The file has nine digits of coordinates below a thousand micrometres.
            assert!(dot(normal, sub(corner, origin)) < 1e-3, "a corner before a facet");
        }
        for (i, &corner) in facet.iter().enumerate() {
            assert!(edges.insert((corner, facet[(i + 1) % facet.len()])), "an edge twice");
        }
    }
    assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "an open edge");
    assert_eq!(corners.len() + facets.len(), edges.len() / 2 + 2, "Euler");
    assert!(volume > 0.0);
    std::f64::consts::PI.cbrt() * (6.0 * volume).powi(2).cbrt() / surface
}

#[test]
fn every_shape_reaches_what_is_asked_in_every_blender() {
    let mut reports = Vec::new();
    for blender in real_blenders() {
        let place = Place::new();
        let report = grains(&place, &blender, &["--out", "g"]);
        let names: Vec<&str> = report.shapes.iter().map(|shape| shape.name.as_str()).collect();
        assert_eq!(names, ["flake", "chip", "angular", "subangular", "worn"]);
        let objects = objects(&place.path("g/grains.obj"));
        for shape in &report.shapes {
            assert_eq!(shape.bodies.len(), 4);
            for body in &shape.bodies {
                let within = report.tolerance.named();
                let asked = shape.asked.named();
                for (((what, reached), (_, asked)), (_, within)) in
                    body.reached.named().into_iter().zip(asked).zip(within)
                {
                    assert!((reached - asked).abs() <= within, "{}: {what} {reached}", body.name);
                }
                let sphericity = sphericity_of_sound(&objects[&body.name]);
                assert!((sphericity - body.reached.sphericity).abs() < 1e-5, "{}", body.name);
                let [length, breadth, thickness] = body.feret_um;
                assert!((breadth / length - body.reached.elongation).abs() < 1e-5);
                assert!((thickness / breadth - body.reached.flatness).abs() < 1e-5);
                let sphere_um3 = std::f64::consts::FRAC_PI_6 * shape.diameter_um.powi(3);
                assert!((body.volume_um3 / sphere_um3 - 1.0).abs() < 1e-9);
            }
        }
        reports.push(report);
    }
    for report in reports.iter().skip(1) {
        for (one, other) in reports[0].shapes.iter().zip(&report.shapes) {
            for (one, other) in one.bodies.iter().zip(&other.bodies) {
                assert_eq!(
                    (one.reached, one.facets),
                    (other.reached, other.facets),
                    "{}",
                    one.name
                );
            }
        }
    }
}

#[test]
fn variants_and_seeds_differ_and_the_same_seed_does_not() {
    let place = Place::new();
    let Some(blender) = a_blender() else { return };
    let run = |seed: &str, out: &str| {
        grains(&place, &blender, &["--seed", seed, "--variants", "3", "--out", out]);
        objects(&place.path(out).join("grains.obj"))
    };
    let (one, two) = (run("1", "one"), run("2", "two"));
    // No two of the bodies measure the same: they are not one body turned or scaled.
    let mut seen = HashSet::new();
    for object in one.values().chain(two.values()) {
        assert!(seen.insert((sphericity_of_sound(object) * 1e9) as u64), "two bodies alike");
    }
    assert_eq!(seen.len(), 2 * 5 * 3);
    let args = ["--seed", "1", "--variants", "3", "--out", "again", "--no-cache"];
    grains(&place, &blender, &args);
    for file in ["grains.obj", "grains.json", "grains.svg", "grains.png"] {
        let read = |out: &str| fs::read(place.path(out).join(file)).expect("written");
        assert!(read("one") == read("again"), "{file}");
    }
}

#[test]
fn a_second_run_does_not_start_blender_and_draws_the_same() {
    let place = Place::new();
    let Some(blender) = a_blender() else { return };
    let blender = place.counted(&blender);
    let args = ["grains", "--variants", "1", "--out"];
    let table = place.run_with(&blender, &[&args[..], &["g"]].concat());
    let log = fs::read(place.path("g/blender.log")).expect("written");
    let starts = place.starts();
    place.run_with(&blender, &[&args[..], &["h"]].concat());
    assert_eq!(place.starts(), starts);
    assert_eq!(fs::read(place.path("h/blender.log")).expect("copied"), log);
    let read = |file: &str| fs::read(place.path(file)).expect("written");
    assert!(read("g/grains.png") == read("h/grains.png"));
    assert!(read("g/grains.png").starts_with(b"\x89PNG"));
    assert_snapshot!(without_numbers(&without_places(&table)));
}
