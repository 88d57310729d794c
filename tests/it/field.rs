//! Beds that go on beyond the sides of their domain.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;

use insta::assert_snapshot;
use soilsig::geometry::ingest;
use soilsig::histogram::kept::Kept;
use soilsig::scene::{Grid, Scene, Sides};
use soilsig::support::error::Failure;
use soilsig::support::monitor::Monitor;
use soilsig::support::random::Purpose;
use soilsig::table::field::FieldSummary;
use soilsig::table::{Prepared, StopReason, Table, Target};
use soilsig::tracer::rules::{Facet, TracingRules};
use soilsig::tracer::trace::Request;
use soilsig::tracer::{Tracer, trace};
use tempfile::TempDir;

use crate::support::{emissivity, message, shipped_json, trace_file};

/// A scene of an .obj file with materials m0, m1, ... of the given emissivities.
fn scene(obj: &str, instances: &str, domain: &str, emissivities: &[f64]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("mesh.obj"), obj).expect("written");
    let material = |(i, e)| format!(r#"{{"name": "m{i}", "spectrum": {{"constant": {e}}}}}"#);
    let materials: Vec<String> = emissivities.iter().enumerate().map(material).collect();
    let text = format!(
        r#"{{"soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300,
             "view": {{"zenith_deg": 0}}, "materials": [{}], "geometry": {{"placed": {{
             "prototypes": [{{"name": "mesh", "file": "mesh.obj"}}],
             "instances": [{instances}], "domain": {domain}}}}}}}"#,
        materials.join(",")
    );
    let path = folder.path().join("scene.json");
    fs::write(&path, text).expect("written");
    (folder, path)
}

fn assert_alike(one: &Table, other: &Table) {
    let ((a, ea), (b, eb)) = (emissivity(one), emissivity(other));
    assert!((a - b).abs() < 3.0 * ea.hypot(eb), "{a} +- {ea} and {b} +- {eb}");
    assert!(ea.hypot(eb) < 0.002, "the comparison is sharp");
}

/// A box with its least corner in the origin.
fn block(x: f64, y: f64, z: f64) -> String {
    format!(
        "v 0 0 0\nv {x} 0 0\nv {x} {y} 0\nv 0 {y} 0\nv 0 0 {z}\nv {x} 0 {z}\nv {x} {y} {z}\nv 0 {y} {z}\n\
         usemtl m0\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
    )
}

fn at(x: f64, y: f64) -> String {
    format!(r#"{{"prototype": "mesh", "transform": [1,0,0,{x}, 0,1,0,{y}, 0,0,1,0]}}"#)
}

fn domain(max: [f64; 2], sides: &str) -> String {
    let [x, y] = max;
    format!(
        r#"{{"min_um": [0, 0], "max_um": [{x}, {y}], "sides": {sides},
             "floor": {{"z_um": 0, "material": "m1"}}}}"#
    )
}

const PERIODIC: &str = r#""periodic""#;

#[test]
fn a_field_of_a_plate_has_the_emissivity_of_the_plate() {
    let plate = "v 0 0 0\nv 300 0 0\nv 300 200 0\nv 0 200 0\nusemtl m0\nf 1 2 3 4\n";
    let domain =
        r#"{"min_um": [0, 0], "max_um": [300, 200], "sides": {"field": {"particles": 1e6}}}"#;
    let (_folder, path) = scene(plate, &at(0.0, 0.0), domain, &[0.37]);
    let table = trace_file(&path, 1, 0.005);
    let (value, error) = emissivity(&table);
    assert!((value - 0.37).abs() < 1e-12 && error < 1e-9, "{value} +- {error}");
    assert_eq!((table.missed, table.hits), (0, table.paths));
    let field = table.field.expect("it is one");
    assert_eq!((field.patches, field.particles), ([816, 1226], 816 * 1226));
    let alone = field.alone.expect("compared");
    assert!(alone.periodic.same && alone.mirror.same);
}

/// The chart puts other sides around a bed that is loaded already.
#[test]
fn a_bed_within_a_fields_sides_is_that_field() {
    let sides = Sides::Field { particles: 1e5, seed: 3 };
    let keys = [r#""mirror""#, r#"{"field": {"particles": 1e5, "seed": 3}}"#];
    let [of_mirrors, field] = keys.map(|keys| {
        let block = block(120.0, 90.0, 200.0);
        let (_folder, path) =
            scene(&block, &at(60.0, 130.0), &domain([300.0, 260.0], keys), &[0.3, 0.6]);
        let scene = Scene::read(&path).expect("a scene");
        trace::tracer(&scene).expect("a bed")
    });
    let rules = TracingRules::of_facets(Kept::PLAIN, vec![Facet::LAMBERTIAN; 2]);
    let tally = |tracer: &Tracer| {
        tracer.trace(&rules, 1, Purpose::Result, 0..4096, &|_| Ok(())).expect("traced")
    };
    assert_eq!(tally(&of_mirrors.within(sides)), tally(&field));
    assert_ne!(tally(&of_mirrors), tally(&field));
}

#[test]
fn periodic_sides_equal_copies_beside_each_other() {
    let (_a, one) = scene(
        &block(120.0, 90.0, 200.0),
        &at(60.0, 130.0),
        &domain([300.0, 260.0], PERIODIC),
        &[0.3, 0.6],
    );
    let copies: Vec<String> = (0..3)
        .flat_map(|i| {
            (0..2).map(move |j| at(60.0 + 300.0 * f64::from(i), 130.0 + 260.0 * f64::from(j)))
        })
        .collect();
    let (_b, six) = scene(
        &block(120.0, 90.0, 200.0),
        &copies.join(","),
        &domain([900.0, 520.0], PERIODIC),
        &[0.3, 0.6],
    );
    assert_alike(&trace_file(&one, 1, 0.001), &trace_file(&six, 2, 0.001));
}

/// Of a block that reaches over a side the cell has what is within it, closed by a flat face.
#[test]
fn a_solid_that_a_side_cuts_ends_there() {
    // Half of the block is left, once at the side of its cell and once in the middle.
    let (_a, cut) = scene(
        &block(160.0, 100.0, 150.0),
        &at(-80.0, 60.0),
        &domain([250.0, 220.0], PERIODIC),
        &[0.3, 0.6],
    );
    let (_b, whole) = scene(
        &block(80.0, 100.0, 150.0),
        &at(85.0, 60.0),
        &domain([250.0, 220.0], PERIODIC),
        &[0.3, 0.6],
    );
    let (cut, whole) = (trace_file(&cut, 1, 0.001), trace_file(&whole, 2, 0.001));
    assert_alike(&cut, &whole);
    assert_eq!(cut.inside, [], "no ray gets into the block through the side");
}

#[test]
fn a_small_field_loses_at_its_rim_what_a_large_one_keeps() {
    let of = |particles: &str| {
        let sides = format!(r#"{{"field": {{"particles": {particles}}}}}"#);
        let domain = domain([250.0, 250.0], &sides);
        let (_folder, path) =
            scene(&block(90.0, 120.0, 400.0), &at(20.0, 60.0), &domain, &[0.3, 0.6]);
        trace_file(&path, 1, 0.001)
    };
    let (one, many, most) = (of("1"), of("1e6"), of("1e9"));
    let (few, more) = (emissivity(&one).0, emissivity(&many).0);
    assert!(more - few > 0.01, "{few} {more}");
    assert_alike(&many, &most);
}

fn settled(sides: &str) -> (TempDir, PathBuf) {
    let mut scene = shipped_json("settled_patch.json");
    scene["geometry"]["placed"]["domain"]["sides"] = serde_json::from_str(sides).expect("JSON");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.json");
    fs::write(&path, scene.to_string()).expect("written");
    (folder, path)
}

const FIELD: &str = r#"{"field": {"particles": 4.24e8, "seed": 7}}"#;

/// Grains that the sides cut through at random, with fines on them: nothing gets into them.
#[test]
fn no_more_paths_come_to_be_inside_a_solid_than_within_mirrors() {
    let inside = |sides: &str| {
        let (_folder, path) = settled(sides);
        let table = trace_file(&path, 1, 0.002);
        table.inside.iter().map(|inside| inside.paths).sum::<u64>() as f64 / table.paths as f64
    };
    for sides in [FIELD, PERIODIC] {
        let share = inside(sides);
        assert!(share < 5e-4, "{share} in {sides}");
    }
}

#[test]
fn a_field_is_the_same_on_any_number_of_threads() {
    let (_folder, path) = settled(FIELD);
    let tables: Vec<Table> = [1, 2, 5]
        .into_iter()
        .map(|threads| {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| trace_file(&path, 1, 0.01))
        })
        .collect();
    assert!(tables[0].field.as_ref().expect("a field").alone.is_some());
    assert_eq!(tables[0], tables[1]);
    assert_eq!(tables[0], tables[2]);
}

/// Hears when the trace of the field itself has ended.
#[derive(Default)]
struct Watch {
    began: OnceLock<Instant>,
    field_s: OnceLock<f64>,
}

impl Monitor for Watch {
    fn at(&self, _: u64, _: u64, what: &str) {
        let began = self.began.get_or_init(Instant::now);
        if what.contains("alone") {
            self.field_s.get_or_init(|| began.elapsed().as_secs_f64());
        }
    }
}

#[test]
fn a_limit_on_time_holds_for_a_field_and_its_patch_alone() {
    const LIMIT_S: f64 = 6.0;
    let (_folder, path) = settled(FIELD);
    let scene = Scene::read(&path).expect("sound");
    let tracer = trace::tracer(&scene).expect("a bed");
    let grid = Grid::new(9.0, 9.0, 0.1).expect("a grid");
    let prepared = Prepared::new(scene, &grid.wavelengths_um()).expect("spectra");
    let target = Target { max_seconds: Some(LIMIT_S), ..Target::of(1e-5) };
    let watch = Watch::default();
    let table = trace::trace(&tracer, &prepared, Request::new(&grid, target), &watch);
    let table = table.expect("a table");
    assert_eq!(table.stop.reached.reason, StopReason::MaxSeconds);
    assert!(table.field.expect("a field").alone.is_some());
    // The patch alone takes two thirds: as many paths, within two kinds of sides. Other tests run
    // at the same time.
    let field_s = *watch.field_s.get().expect("the patch alone was traced");
    assert!(field_s < 0.6 * LIMIT_S, "{field_s} s of {LIMIT_S} s");
}

#[test]
fn a_field_counts_its_particles() {
    let (_folder, path) = settled(FIELD);
    let bed = ingest::load(&Scene::read(&path).expect("sound")).expect("sound");
    let of_patch = bed.particles();
    // Each dusty grain is one particle and one for each of its fines.
    let placed: usize = bed.placements.iter().map(|p| bed.meshes[p.mesh].particles.len()).sum();
    assert!(of_patch > 100 && (of_patch as usize) < placed, "{of_patch} of {placed}");
    let field = FieldSummary::of(&bed).expect("it is one");
    let [x, y] = field.patches;
    assert_eq!(field.particles, of_patch * u64::from(x) * u64::from(y));
    assert!(field.particles >= 424_000_000 && field.particles < 430_000_000);
}

#[test]
fn keys_of_a_field_that_make_no_sense_are_refused_with_their_place() {
    let parse = |sides: &str| {
        let (_folder, path) = scene("", &at(0.0, 0.0), &domain([9.0, 9.0], sides), &[0.5, 0.5]);
        Scene::read(&path).map_err(|error| message(&error, error.hint()))
    };
    let sound = parse(r#"{"field": {"particles": 87e6}}"#).expect("sound");
    let domain_of = |scene: &Scene| {
        let _path = Path::new("scene.json");
        scene.placed().expect("placed").domain.clone().expect("given").sides
    };
    assert_eq!(domain_of(&sound), Sides::Field { particles: 87e6, seed: 0 });
    let refused = [
        r#"{"field": {"particles": 0}}"#,
        r#"{"field": {"particles": 1e16}}"#,
        r#"{"field": {"particles": -4}}"#,
        r#"{"field": {"patches": 4}}"#,
        r#"{"field": {"particles": 4, "turned": false}}"#,
        r#""field""#,
        r#""endless""#,
    ]
    .map(|sides| format!("{sides}\n{}\n", parse(sides).expect_err(sides)));
    assert_snapshot!(refused.concat());
}

#[test]
fn a_field_that_its_patch_cannot_make_is_refused() {
    let of = |x: f64, particles: &str| {
        let sides = format!(r#"{{"field": {{"particles": {particles}}}}}"#);
        let (_folder, path) = scene(
            &block(90.0, 90.0, 90.0),
            &at(x, 60.0),
            &domain([250.0, 250.0], &sides),
            &[0.5, 0.5],
        );
        ingest::load(&Scene::read(&path).expect("sound")).map(|bed| bed.domain.patches)
    };
    assert_eq!(of(60.0, "9").expect("sound"), [3, 3]);
    let mut told = String::new();
    for (x, particles) in [(60.0, "1e12"), (-80.0, "9")] {
        let error = of(x, particles).expect_err("refused");
        assert!(error.hint().is_some());
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
}
