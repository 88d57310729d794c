//! The tracer against closed forms of radiative exchange.

#[path = "support/scenes.rs"]
mod scenes;

use std::fmt::Write as _;
use std::fs;

use soilsig::radiance;
use soilsig::scene::Sky;
use soilsig::signature;
use soilsig::table::Table;
use tempfile::TempDir;

/// A scene in a folder of its own.
struct Case {
    folder: TempDir,
}

impl Case {
    /// An .obj file and a scene about it; `placed` is the JSON of `geometry.placed`, `emissivities` those
    /// of the materials `m0`, `m1`, ...
    fn new(obj: &str, placed: &str, emissivities: &[f64]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("mesh.obj"), obj).expect("written");
        let materials: Vec<String> = emissivities
            .iter()
            .enumerate()
            .map(|(i, e)| format!(r#"{{"name": "m{i}", "spectrum": {{"constant": {e}}}}}"#))
            .collect();
        let scene = format!(
            r#"{{"soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300,
                 "view": {{"zenith_deg": 0}}, "materials": [{}],
                 "geometry": {{"placed": {placed}}}}}"#,
            materials.join(",")
        );
        fs::write(folder.path().join("scene.json"), scene).expect("written");
        Self { folder }
    }

    fn seen_from(self, zenith_deg: f64) -> Self {
        let path = self.folder.path().join("scene.json");
        let text = fs::read_to_string(&path).expect("written above");
        let view = format!(r#""view": {{"zenith_deg": {zenith_deg}}}"#);
        let text = text.replace(r#""view": {"zenith_deg": 0}"#, &view);
        assert!(text.contains(&view));
        fs::write(&path, text).expect("written");
        self
    }

    /// The scene's table, traced until the half-width is `tolerance`.
    fn trace(&self, tolerance: f64) -> Table {
        scenes::trace_file(&self.folder.path().join("scene.json"), 1, tolerance)
    }
}

const ALONE: &str = r#"{"prototypes": [{"name": "mesh", "file": "mesh.obj"}]}"#;

/// A sphere of radius 1000 um open above the height at which a share `open` of its area is missing;
/// material m1 below the height at which a share `lower` of its area lies, m0 above.
fn sphere(open: f64, lower: f64) -> String {
    let (rings, sectors) = (192, 256);
    let height = |share: f64| 1000.0 * (2.0 * share - 1.0); // Archimedes: area goes as height
    let mut heights: Vec<f64> = (0..=rings)
        .map(|i| -1000.0 * (std::f64::consts::PI * f64::from(i) / f64::from(rings)).cos())
        .filter(|z| *z < height(1.0 - open))
        .collect();
    heights.extend([height(1.0 - open), height(lower)]);
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    let mut text = String::new();
    for z in &heights {
        for sector in 0..sectors {
            let angle = std::f64::consts::TAU * f64::from(sector) / f64::from(sectors);
            let r = (1e6 - z * z).max(0.0).sqrt();
            writeln!(text, "v {} {} {z}", r * angle.cos(), r * angle.sin()).expect("text");
        }
    }
    for (ring, pair) in heights.windows(2).enumerate() {
        let material = if pair[1] <= height(lower) { "m1" } else { "m0" };
        writeln!(text, "usemtl {material}").expect("text");
        for sector in 0..sectors {
            let at = |ring: usize, sector: i32| ring as i32 * sectors + sector % sectors + 1;
            let (a, b) = (at(ring, sector), at(ring, sector + 1));
            let (c, d) = (at(ring + 1, sector), at(ring + 1, sector + 1));
            writeln!(text, "f {a} {b} {d}\nf {a} {d} {c}").expect("text");
        }
    }
    text
}

/// Looking down through the opening of a sphere, at its lower part.
fn sphere_case(open: f64, lower: f64, emissivities: &[f64]) -> Case {
    let placed = r#"{"prototypes": [{"name": "mesh", "file": "mesh.obj"}],
        "domain": {"min_um": [-100, -100], "max_um": [100, 100], "sides": "open"}}"#;
    Case::new(&sphere(open, lower), placed, emissivities)
}

fn emissivity(table: &Table) -> (f64, f64) {
    let one = std::slice::from_ref(table);
    let bands = signature::evaluate(one, &[9.0]).expect("constant spectra");
    (bands[0].emissivity.mean, bands[0].emissivity.standard_error)
}

/// Within three standard errors, and the error of a sphere made of facets: their share of the area
/// that is missing is (pi / n)^2 / 3 or so, below 1e-4 for the sphere here.
fn assert_near(table: &Table, exact: f64, facets: f64) {
    let (value, error) = emissivity(table);
    assert!((value - exact).abs() < 3.0 * error + facets, "{value} +- {error}, exact {exact}");
}

#[test]
fn a_flat_plate_has_the_emissivity_of_its_facets() {
    let plate = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nusemtl m0\nf 1 2 3 4\n";
    let table = Case::new(plate, ALONE, &[0.37]).trace(0.005);
    let (value, error) = emissivity(&table);
    assert!((value - 0.37).abs() < 1e-12 && error < 1e-9, "{value} +- {error}");
    assert_eq!((table.missed, table.hits), (0, table.paths));
}

#[test]
fn a_convex_body_has_the_emissivity_of_its_facets() {
    // A sphere with nothing missing, seen from outside.
    let table = Case::new(&sphere(0.0, 0.0), ALONE, &[0.37]).trace(0.005);
    let (value, _) = emissivity(&table);
    assert!((value - 0.37).abs() < 1e-12, "{value}");
    // The bounding rectangle is wider than the disc by 1 - pi / 4.
    let missed = table.missed as f64 / table.paths as f64;
    assert!((missed - (1.0 - std::f64::consts::FRAC_PI_4)).abs() < 0.01, "{missed}");
}

#[test]
fn a_spherical_cavity_has_its_closed_form() {
    for (e, open, exact) in [
        (0.5, 0.5, 0.666_666_67),
        (0.5, 0.25, 0.8),
        (0.5, 0.1, 0.909_090_91),
        (0.5, 0.01, 0.990_099_01),
        (0.37, 0.5, 0.540_145_99),
        (0.37, 0.1, 0.854_503_46),
    ] {
        let table = sphere_case(open, 0.0, &[e]).trace(0.001);
        assert_eq!(table.missed, 0);
        assert_near(&table, exact, 1e-4);
    }
}

#[test]
fn a_cavity_of_two_materials_has_its_closed_form() {
    // Area fractions .5 and .4 with .1 open: the radiosity of the material that is looked at.
    let upper_seen = sphere_case(0.1, 0.4, &[0.4, 0.8]).trace(0.001);
    assert_near(&upper_seen, 0.967_741_94, 1e-4);
    let turned = sphere_case(0.1, 0.5, &[0.8, 0.4]).trace(0.001);
    assert_near(&turned, 0.903_225_81, 1e-4);
}

#[test]
fn an_isothermal_box_under_a_sky_of_its_own_temperature_looks_black() {
    // An open box: four walls and a floor, of two materials.
    let open_box = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nv 0 0 400\nv 500 0 400\n\
        v 500 500 400\nv 0 500 400\nusemtl m0\nf 1 2 3 4\nusemtl m1\nf 1 2 6 5\nf 2 3 7 6\n\
        f 3 4 8 7\nf 4 1 5 8\n";
    let mut table = Case::new(open_box, ALONE, &[0.6, 0.2]).trace(0.005);
    table.sky_temperature_k = Some(Sky::Isotropic(300.0));
    for um in [7.5, 10.0, 14.0] {
        let one = std::slice::from_ref(&table);
        let band = signature::evaluate(one, &[um]).expect("constant spectra")[0];
        let black = radiance::planck(um, 300.0);
        assert!((band.l_target / black - 1.0).abs() < 1e-12);
        let emissivity = band.emissivity.mean;
        assert!(emissivity > 0.65 && emissivity < 1.0, "it is a cavity: {emissivity}");
    }
}

#[test]
fn two_materials_are_told_apart_by_what_the_sensor_sees_first() {
    let halves = "v 0 0 0\nv 250 0 0\nv 500 0 0\nv 500 500 0\nv 250 500 0\nv 0 500 0\n\
        usemtl m0\nf 1 2 5 6\nusemtl m1\nf 2 3 4 5\n";
    let table = Case::new(halves, ALONE, &[0.9, 0.6]).trace(0.001);
    assert_near(&table, 0.75, 0.0);
    let share = table.materials[0].first_hits as f64 / table.paths as f64;
    assert!((share - 0.5).abs() < 0.01, "{share}");
}

/// A body in the open is seen whole from any side: of a sphere whose eastern half is of one material,
/// (1 + sin z) / 2 is seen from the east at zenith z.
#[test]
fn an_oblique_view_sees_the_whole_body() {
    // The sphere of the cavities, laid on its side: its lower part looks east.
    let lower_is_east = r#"{"prototypes": [{"name": "mesh", "file": "mesh.obj"}],
        "instances": [{"prototype": "mesh", "transform": [0,0,-1,0, 0,1,0,0, 1,0,0,0]}]}"#;
    for zenith_deg in [0.0, 45.0, 60.0_f64] {
        let case = Case::new(&sphere(0.0, 0.5), lower_is_east, &[0.2, 0.9]).seen_from(zenith_deg);
        let table = case.trace(0.002);
        let east = table.materials[1].first_hits as f64 / table.met() as f64;
        let exact = f64::midpoint(1.0, zenith_deg.to_radians().sin());
        let error = (exact * (1.0 - exact) / table.met() as f64).sqrt();
        assert!((east - exact).abs() < 4.0 * error + 1e-4, "{zenith_deg}: {east}, exact {exact}");
    }
}

/// The mirror sides of a domain are the infinite bed of mirror images: a scene and its explicit mirror
/// image beside it give the same answer.
#[test]
fn mirror_sides_equal_explicit_mirror_images() {
    let step = "v 0 0 0\nv 300 0 200\nv 300 400 0\nv 0 400 0\nv 150 100 350\nv 250 300 300\n\
        v 100 250 250\nusemtl m0\nf 1 2 3 4\nusemtl m1\nf 5 6 7\n";
    let placed = |instances: &str, x: f64| {
        format!(
            r#"{{"prototypes": [{{"name": "mesh", "file": "mesh.obj"}}], "instances": [{instances}],
                "domain": {{"min_um": [0, 0], "max_um": [{x}, 400], "sides": "mirror",
                            "floor": {{"z_um": -50, "material": "m0"}}}}}}"#
        )
    };
    let as_it_is = r#"{"prototype": "mesh", "transform": [1,0,0,0, 0,1,0,0, 0,0,1,0]}"#;
    let image = r#"{"prototype": "mesh", "transform": [-1,0,0,600, 0,1,0,0, 0,0,1,0]}"#;
    let one = Case::new(step, &placed(as_it_is, 300.0), &[0.5, 0.2]).trace(0.001);
    let two =
        Case::new(step, &placed(&format!("{as_it_is},{image}"), 600.0), &[0.5, 0.2]).trace(0.001);
    let ((a, ea), (b, eb)) = (emissivity(&one), emissivity(&two));
    assert!((a - b).abs() < 3.0 * ea.hypot(eb), "{a} +- {ea} and {b} +- {eb}");
    let open = placed(as_it_is, 300.0).replace("mirror", "open");
    let (c, ec) = emissivity(&Case::new(step, &open, &[0.5, 0.2]).trace(0.001));
    assert!(a - c > 10.0 * ea.hypot(ec), "open sides lose what mirrors keep: {a} and {c}");
}
