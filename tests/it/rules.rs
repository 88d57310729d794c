//! What a scene may ask beyond one temperature, an isotropic sky and Lambertian facets, against
//! values that are known.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::{f64, fs};

use soilsig::histogram::Histogram;
use soilsig::histogram::kept::Kept;
use soilsig::radiometry::planck;
use soilsig::scene::{Grid, Scene};
use soilsig::signature::{self, Band};
use soilsig::spectrum::Spectrum;
use soilsig::support::monitor::Unwatched;
use soilsig::support::random::Purpose;
use soilsig::table::{Prepared, Table, Target};
use soilsig::tracer::rules::TracingRules;
use soilsig::tracer::trace::{self, Request};
use tempfile::TempDir;

/// A level plate.
const PLATE: &str = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nusemtl m0\nf 1 2 3 4\n";
/// A square trough with walls of one material and a floor of another.
const TROUGH: &str = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nv 0 0 400\nv 500 0 400\n\
    v 500 500 400\nv 0 500 400\nusemtl m0\nf 1 2 3 4\nusemtl m1\nf 1 2 6 5\nf 2 3 7 6\n\
    f 3 4 8 7\nf 4 1 5 8\n";
/// A ridge turned over: two facets at right angles, open upward.
const GROOVE: &str = "v 0 0 0\nv 0 500 0\nv 300 0 300\nv 300 500 300\nv -300 0 300\nv -300 500 300\nusemtl m0\n\
    f 1 3 4 2\nf 1 2 6 5\n";

struct Case {
    folder: TempDir,
}

impl Case {
    fn new(obj: &str, zenith_deg: f64, scene_keys: &str, materials: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("mesh.obj"), obj).expect("written");
        let mut list = String::new();
        for (i, keys) in materials.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            write!(list, r#"{comma}{{"name": "m{i}", {keys}}}"#).expect("text");
        }
        let scene = format!(
            r#"{{"soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300, {scene_keys}
                 "view": {{"zenith_deg": {zenith_deg}}}, "materials": [{list}],
                 "geometry": {{"placed": {{"prototypes": [{{"name": "mesh", "file": "mesh.obj"}}],
                 "domain": {{"min_um": [0, 0], "max_um": [500, 500], "sides": "open"}}}}}}}}"#
        );
        fs::write(folder.path().join("scene.json"), scene).expect("written");
        Self { folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("scene.json")
    }

    fn trace(&self, tolerance: f64) -> Table {
        let scene = Scene::read(&self.path()).expect("the scene is sound");
        let tracer = trace::tracer(&scene).expect("its meshes are sound");
        let grid = Grid::new(9.0, 9.0, 0.01).expect("a grid");
        let target = Target::of(tolerance);
        trace::trace(
            &tracer,
            &Prepared::new(scene.clone(), &grid.wavelengths_um()).expect("spectra"),
            Request::new(&grid, target),
            &Unwatched,
        )
        .expect("traced")
    }
}

fn band(table: &Table) -> Band {
    signature::evaluate(std::slice::from_ref(table), &[9.0]).expect("the spectra hold 9 um")[0]
}

fn assert_radiance(band: &Band, exact: f64, besides: f64) {
    let (l, error) = (band.l_target.mean, band.l_target.standard_error);
    assert!((l - exact).abs() < 3.0 * error + besides, "{l} +- {error}, exact {exact}");
}

#[test]
fn the_least_is_kept_that_serves_the_scene() {
    let kept = |scene_keys: &str, materials: &[&str]| {
        Case::new(TROUGH, 0.0, scene_keys, materials).trace(0.05).histogram.kept
    };
    let grey = r#""spectrum": {"constant": 0.9}"#;
    let warm = r#""spectrum": {"constant": 0.9}, "temperature_k": 310"#;
    let same = r#""spectrum": {"constant": 0.9}, "temperature_k": 300"#;
    let shiny = r#""spectrum": {"constant": 0.9}, "specular": 0.3"#;
    let fresnel = r#""spectrum": {"fresnel": "quartz"}"#;
    let by_zenith = r#""sky_temperature_k": [{"zenith_deg": 0, "temperature_k": 220},
        {"zenith_deg": 90, "temperature_k": 280}],"#;
    assert_eq!(kept("", &[grey, grey]), Kept::PLAIN);
    assert_eq!(kept(r#""sky_temperature_k": 250,"#, &[grey, grey]), Kept::PLAIN);
    assert_eq!(kept("", &[grey, same]), Kept::PLAIN);
    assert_eq!(kept("", &[grey, shiny]), Kept::PLAIN, "a constant share needs no more");
    assert_eq!(kept("", &[grey, warm]), Kept { order: true, ..Kept::PLAIN });
    assert_eq!(kept(by_zenith, &[grey, grey]), Kept { zeniths: 90, ..Kept::PLAIN });
    assert_eq!(kept("", &[grey, fresnel]), Kept { cosines: 64, ..Kept::PLAIN });
    let all = Kept { order: true, cosines: 64, zeniths: 90, ..Kept::PLAIN };
    assert_eq!(kept(by_zenith, &[fresnel, warm]), all);
}

/// Radiances of materials add up: each alone aglow, the other at 1 K, gives its part of the whole.
#[test]
fn each_material_emits_at_its_own_temperature() {
    let spectra = [r#""spectrum": {"constant": 0.6}"#, r#""spectrum": {"constant": 0.3}"#];
    let table = |kelvin: [f64; 2]| {
        let [a, b] = [0, 1].map(|i| format!(r#"{}, "temperature_k": {}"#, spectra[i], kelvin[i]));
        Case::new(TROUGH, 20.0, "", &[&a, &b]).trace(0.003)
    };
    let both = band(&table([280.0, 330.0]));
    let [first, second] = [[280.0, 1.0], [1.0, 330.0]].map(|kelvin| band(&table(kelvin)));
    let sum = first.l_emitted.mean + second.l_emitted.mean;
    assert!((both.l_emitted.mean / sum - 1.0).abs() < 1e-12, "{} and {sum}", both.l_emitted.mean);
    assert!(first.l_emitted.mean > 0.1 * sum && second.l_emitted.mean > 0.1 * sum, "both are seen");
    // Of one temperature it is the plain table's, whose paths are followed to another end.
    let nearly = table([300.0 + 1e-9, 300.0]);
    let plain = Case::new(TROUGH, 20.0, "", &spectra).trace(0.003);
    let of_all = |table: &Table| table.histogram.paths() + table.missed as f64;
    for (table, ended) in [(&nearly, false), (&plain, true)] {
        assert_eq!(!table.histogram.rouletted.is_empty(), ended, "roulette needs one temperature");
        assert_eq!(of_all(table), table.paths as f64);
    }
    let (nearly, plain) = (band(&nearly), band(&plain));
    let (a, b) = (nearly.l_target, plain.l_target);
    let error = a.standard_error.hypot(b.standard_error);
    assert!((a.mean - b.mean).abs() < 3.0 * error, "{a:?} {b:?}");
    let relative = a.standard_error / b.standard_error;
    assert!((relative - 1.0).abs() < 0.2, "{relative}");
}

/// A white plate returns what falls on it: of a sky that depends on the zenith angle its
/// hemispherical mean if it is Lambertian, what comes from the mirrored direction if it is a
/// mirror.
#[test]
fn a_sky_by_zenith_is_seen_where_paths_go() {
    let (zenith_deg, specular) = (50.0, 0.4);
    let keys = r#""sky_temperature_k": [{"zenith_deg": 0, "temperature_k": 200},
        {"zenith_deg": 60, "temperature_k": 230}, {"zenith_deg": 90, "temperature_k": 290}],"#;
    let sky = |zenith_deg: f64| {
        let kelvin = if zenith_deg < 60.0 {
            200.0 + 0.5 * zenith_deg
        } else {
            230.0 + 2.0 * (zenith_deg - 60.0)
        };
        planck(9.0, kelvin)
    };
    // By a quadrature of its own: 2 sin cos over the zenith angle, fine and midpoint.
    let steps = 100_000;
    let hemispherical: f64 = (0..steps)
        .map(|i| {
            let zenith = (f64::from(i) + 0.5) / f64::from(steps) * f64::consts::FRAC_PI_2;
            sky(zenith.to_degrees()) * (2.0 * zenith).sin() * f64::consts::FRAC_PI_2
        })
        .sum::<f64>()
        / f64::from(steps);
    let mirrored = sky(zenith_deg);
    for (share, exact) in [
        (0.0, hemispherical),
        (1.0, mirrored),
        (specular, specular * mirrored + (1.0 - specular) * hemispherical),
    ] {
        let white = format!(r#""spectrum": {{"constant": 0}}, "specular": {share}"#);
        let table = Case::new(PLATE, zenith_deg, keys, &[&white]).trace(0.001);
        let band = band(&table);
        // The sky is taken in the middle of bins of a degree.
        let bins = if share > 0.0 { (sky(50.5) - sky(49.5)).abs() } else { 1e-4 * exact };
        assert_radiance(&band, exact, bins);
        assert!((band.l_downwelling / hemispherical - 1.0).abs() < 1e-4, "{}", band.l_downwelling);
        assert_eq!(band.l_emitted.mean, 0.0);
    }
}

/// In a right-angled groove of mirrors every ray from above meets two facets at 45 degrees.
#[test]
fn fresnel_facets_reflect_by_the_angle_of_each_hit() {
    let fresnel = r#""spectrum": {"fresnel": "quartz"}"#;
    let quartz = Spectrum::resolve(
        &serde_json::from_str(r#"{"fresnel": "quartz"}"#).expect("a source"),
        std::path::Path::new(""),
    )
    .expect("shipped");
    let at = |degrees: f64| quartz.reflectance_at(9.0, degrees.to_radians().cos()).expect("held");
    let groove = band(&Case::new(GROOVE, 0.0, "", &[fresnel]).trace(0.001));
    let exact = 1.0 - at(45.0) * at(45.0);
    assert!((groove.emissivity.mean - exact).abs() < 2e-3, "{} {exact}", groove.emissivity.mean);
    for zenith_deg in [0.0, 40.0, 75.0] {
        let plate = band(&Case::new(PLATE, zenith_deg, "", &[fresnel]).trace(0.001));
        let exact = 1.0 - at(zenith_deg);
        // The cosine is anywhere in its bin.
        let (cosine, bin) = (zenith_deg.to_radians().cos(), 1.0 / 64.0);
        let slope = |to: f64| quartz.reflectance_at(9.0, to.min(1.0)).expect("held");
        let bin = (slope(cosine + bin) - slope(cosine - bin)).abs();
        let e = plate.emissivity.mean;
        assert!((e - exact).abs() <= bin, "{zenith_deg}: {e}, exact {exact}, within {bin}");
    }
    assert!((at(75.0) - at(0.0)).abs() > 0.01, "the angle matters");
}

/// A facet that is a mirror in part sends the same weight to the sky as any other of its
/// reflectance: within a furnace nothing can be told.
#[test]
fn an_isothermal_trough_under_a_sky_of_its_temperature_looks_black_whatever_its_facets() {
    let materials = [
        r#""spectrum": {"constant": 0.4}, "specular": 0.5"#,
        r#""spectrum": {"fresnel": "quartz"}"#,
    ];
    let keys = r#""sky_temperature_k": [{"zenith_deg": 0, "temperature_k": 300},
        {"zenith_deg": 90, "temperature_k": 300}],"#;
    let band = band(&Case::new(TROUGH, 30.0, keys, &materials).trace(0.002));
    let black = planck(9.0, 300.0);
    let open = band.emissivity.trapped * black;
    assert!(
        (band.l_target.mean - black).abs() <= 2.0 * open + 1e-9 * black,
        "{}",
        band.l_target.mean
    );
    assert!(band.emissivity.mean < 0.99, "though it does reflect");
}

/// Roulette ends paths by the spectra that they are traced for, and those that go on stand for them
/// whatever spectra the table is evaluated with.
#[test]
fn what_roulette_ends_others_stand_for() {
    let case = Case::new(TROUGH, 0.0, "", &[r#""spectrum": {"constant": 0.5}"#; 2]);
    let scene = Scene::read(&case.path()).expect("the scene is sound");
    let tracer = trace::tracer(&scene).expect("its meshes are sound");
    let prepared = Prepared::new(scene, &[9.0]).expect("sound");
    let of = |seed: u64, greatest: f64| {
        let rules = TracingRules::new(&prepared).ending_below(0.0, &[vec![greatest; 2]]);
        let paths = 0..1 << 16;
        let traced = tracer.trace(&rules, seed, Purpose::Result, paths.clone(), &|_| Ok(()));
        let histogram = Histogram::of(&traced.expect("traced"));
        assert_eq!(histogram.rouletted.is_empty(), greatest == 1.0);
        assert_eq!(histogram.paths(), paths.end as f64, "what is ended is counted all the same");
        histogram
    };
    let (all, some) = (of(1, 1.0), of(2, 0.15));
    for rho in [[0.15, 0.15], [0.6, 0.3], [0.95, 0.95]] {
        let (all, some) = (all.weight(&rho), some.weight(&rho));
        let error = all.standard_error.hypot(some.standard_error);
        assert!((all.mean - some.mean).abs() <= 4.0 * error, "{rho:?}: {all:?} {some:?}");
        assert!(error < 0.01 * all.mean, "{rho:?}: {error} would see nothing");
    }
}
