//! Images: what pixels see, how sure they are, and that nothing but the scene and the seed decides
//! it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use insta::assert_snapshot;
use serde_json::{Value, json};
use soilsig::products::cube::Cube;
use soilsig::products::image::{self, Asked, Made};
use soilsig::radiometry::{brightness_temperature_k, planck, planck_derivative};
use soilsig::scene::{Grid, Scene};
use soilsig::support::error::Failure;
use soilsig::support::monitor::Unwatched;
use soilsig::support::output;
use soilsig::table::{Prepared, Target};
use soilsig::tracer::trace::{self, Request};
use tempfile::TempDir;

use crate::support::{message, shipped_json};

const SIDE_UM: f64 = 100.0;

fn grid(from_um: f64, to_um: f64, step_um: f64) -> Grid {
    Grid::new(from_um, to_um, step_um).expect("a grid")
}

fn asked(noise: f64) -> Asked {
    Asked { noise, max_paths: 1 << 12, false_colour_um: None, show_um: vec![9.0] }
}

fn make(scene: &Path, grid: &Grid, asked: &Asked, out: &Path) -> Made {
    let parsed = Scene::read(scene).expect("the scene is sound");
    let tracer = trace::tracer(&parsed).expect("its meshes are sound");
    image::make(&tracer, &parsed, grid, asked, out, &Unwatched).expect("an image")
}

fn cube(out: &Path, name: &str) -> Cube {
    Cube::read(&out.join(format!("{name}.img"))).expect("a cube")
}

fn write(folder: &TempDir, scene: &Value) -> PathBuf {
    let path = folder.path().join("scene.json");
    fs::write(&path, scene.to_string()).expect("written");
    path
}

/// Temperature and emissivity of a panel, line by line from above.
fn panel(line: usize, sample: usize) -> (f64, f64) {
    let number = 4 * line + sample;
    let emissivity = if (line + sample).is_multiple_of(2) { 1.0 } else { 0.9 };
    (250.0 + 100.0 * number as f64 / 15.0, emissivity)
}

/// Four by four panels in a plane, each of a material of its own.
fn panels(folder: &TempDir, sides: &str, sensor: &Value) -> Value {
    let mut obj = String::new();
    let mut materials = Vec::new();
    for line in 0..4 {
        for sample in 0..4 {
            let name = format!("panel_{line}_{sample}");
            let [x, y] = [sample, 3 - line].map(|i| i as f64 * SIDE_UM);
            for [dx, dy] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                let _ = writeln!(obj, "v {} {} 0", x + dx * SIDE_UM, y + dy * SIDE_UM);
            }
            let _ = writeln!(obj, "usemtl {name}\nf -4 -3 -2 -1");
            let (temperature_k, emissivity) = panel(line, sample);
            materials.push(json!({
                "name": name, "spectrum": {"constant": emissivity}, "temperature_k": temperature_k
            }));
        }
    }
    fs::write(folder.path().join("panels.obj"), obj).expect("written");
    let far = 4.0 * SIDE_UM;
    let mut scene = json!({
        "soilsig_scene": 1, "name": "panels", "seed": 1, "temperature_k": 300.0,
        "view": {"zenith_deg": 0.0}, "materials": materials,
        "geometry": {"placed": {
            "prototypes": [{"name": "panels", "file": "panels.obj"}],
            "domain": {"min_um": [0.0, 0.0], "max_um": [far, far], "sides": sides},
        }},
    });
    scene["sensor"] = sensor.clone();
    scene
}

/// One band of an image, line by line.
fn values(cube: &Cube, band: usize) -> &[f32] {
    let size = cube.lines * cube.samples;
    &cube.data[band * size..][..size]
}

#[test]
fn four_by_four_panels_return_their_brightness_temperatures() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    // Seen by parallel rays, and from a point from where the four panels fill the view.
    let far = 4.0 * SIDE_UM;
    let distance_um = 5.0 * far;
    let angle = 2.0 * (far / 2.0 / distance_um).atan().to_degrees();
    let pinhole = json!({"pinhole": {"distance_um": distance_um, "field_of_view_deg": angle}});
    for (optics, sky_k) in [(Value::Null, None), (Value::Null, Some(270.0)), (pinhole, Some(270.0))]
    {
        let mut sensor = json!({"pixels": [4, 4]});
        if !optics.is_null() {
            sensor["optics"] = optics;
        }
        let mut scene = panels(&folder, "open", &sensor);
        if let Some(sky_k) = sky_k {
            scene["sky_temperature_k"] = json!(sky_k);
        }
        let made = make(&write(&folder, &scene), &grid(8.0, 12.0, 1.0), &asked(0.01), &out);
        assert_eq!((made.pixels, made.bands, made.empty), ([4, 4], 5, 0.0));
        let (radiance, emissivity) = (cube(&out, "radiance"), cube(&out, "emissivity"));
        for line in 0..4 {
            for sample in 0..4 {
                let (temperature_k, eps) = panel(line, sample);
                for (band, &um) in radiance.wavelengths_um.iter().enumerate() {
                    let l = f64::from(radiance.spectrum(line, sample)[band]);
                    let l_sky = sky_k.map_or(0.0, |sky_k| planck(um, sky_k));
                    let exact = eps * planck(um, temperature_k) + (1.0 - eps) * l_sky;
                    let kelvin =
                        [l, exact].map(|l| brightness_temperature_k(um, l).expect("above 0"));
                    // As exact as single precision is.
                    assert!((kelvin[0] - kelvin[1]).abs() < 1e-4, "{um} um: {kelvin:?}");
                    assert!(eps < 1.0 || (kelvin[0] - temperature_k).abs() < 1e-4);
                    assert!(
                        (f64::from(emissivity.spectrum(line, sample)[band]) - eps).abs() < 1e-6
                    );
                }
            }
        }
        let maps = fs::read(out.join("maps.img")).expect("maps");
        let materials: Vec<f32> = maps[..64]
            .chunks_exact(4)
            .map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four")))
            .collect();
        assert_eq!(materials, (0..16_u8).map(f32::from).collect::<Vec<f32>>());
    }
}

/// Half a domain beyond each side the sensor sees the panels in mirrors.
#[test]
fn beyond_mirror_sides_a_wide_view_sees_the_bed_in_mirrors() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    let width = json!({"orthographic": {"width_um": 8.0 * SIDE_UM}});
    let wide = panels(&folder, "mirror", &json!({"pixels": [8, 8], "optics": width}));
    make(&write(&folder, &wide), &grid(9.0, 9.0, 1.0), &asked(0.01), &out);
    let radiance = cube(&out, "radiance");
    let mirrored = |number: usize| [1, 0, 0, 1, 2, 3, 3, 2][number];
    for line in 0..8 {
        for sample in 0..8 {
            let (temperature_k, eps) = panel(mirrored(line), mirrored(sample));
            let exact = (eps * planck(9.0, temperature_k)) as f32;
            let l = radiance.spectrum(line, sample)[0];
            assert!((l / exact - 1.0).abs() < 1e-6, "line {line}, sample {sample}: {l} {exact}");
        }
    }
}

/// The shipped patch with a sensor.
fn patch(folder: &TempDir, sensor: &Value, change: impl FnOnce(&mut Value)) -> PathBuf {
    let mut scene = shipped_json("settled_patch.json");
    scene["sensor"] = sensor.clone();
    change(&mut scene);
    write(folder, &scene)
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count() as f64
}

#[test]
fn the_mean_of_an_image_is_the_emissivity_of_the_table_and_its_noise_is_what_was_asked() {
    const NOISE: f64 = 0.02;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bands = grid(8.0, 12.0, 0.5);
    let images: Vec<(Made, Cube)> = [1, 2]
        .map(|seed| {
            let sensor = json!({"pixels": [32, 32]});
            let path = patch(&folder, &sensor, |scene| scene["seed"] = json!(seed));
            let out = folder.path().join("out");
            (make(&path, &bands, &asked(NOISE), &out), cube(&out, "emissivity"))
        })
        .into();
    let path = folder.path().join("scene.json");
    let scene = Scene::read(&path).expect("a scene");
    let tracer = trace::tracer(&scene).expect("meshes");
    let target = Target::of(0.001);
    let table = trace::trace(
        &tracer,
        &Prepared::new(scene.clone(), &bands.wavelengths_um()).expect("spectra"),
        Request::new(&bands, target),
        &Unwatched,
    )
    .expect("traced");
    let signature = soilsig::signature::evaluate(&[table], &bands.wavelengths_um()).expect("bands");
    let pixels = 32.0_f64 * 32.0;
    let mut widest = 0.0_f64;
    for (band, exact) in signature.iter().enumerate() {
        let of = |image: usize| values(&images[image].1, band).iter().map(|&e| f64::from(e));
        let differences = of(0).zip(of(1)).map(|(a, b)| a - b);
        let realised = (mean(differences.map(|d| d * d)) / 2.0).sqrt();
        widest = widest.max(realised);
        let mean = f64::midpoint(mean(of(0)), mean(of(1)));
        let error = (realised / (2.0 * pixels).sqrt()).hypot(exact.emissivity.standard_error);
        assert!(
            (mean - exact.emissivity.mean).abs() < 3.5 * error + exact.emissivity.trapped + 2e-4,
            "{} um: image {mean}, table {}, standard error {error}",
            exact.wavelength_um,
            exact.emissivity.mean
        );
    }
    // Asked of each pixel in its own widest band; lots of paths are rounded up.
    assert!(widest > 0.4 * NOISE && widest < 1.1 * NOISE, "realised {widest}");
    for (made, _) in &images {
        assert!(made.noise > 0.6 * NOISE && made.noise < 1.1 * NOISE, "stated {}", made.noise);
        assert_eq!(made.capped, 0.0);
    }
}

#[test]
fn every_byte_is_the_same_for_one_and_two_threads() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let sensor = json!({
        "pixels": [9, 11], "noise": {"nedt_k": 0.1, "seed": 3},
        "optics": {"pinhole": {"distance_um": 20000.0, "field_of_view_deg": 8.0}},
    });
    let path = patch(&folder, &sensor, |scene| {
        scene["view"] = json!({"zenith_deg": 30.0, "azimuth_deg": 20.0});
        scene["materials"][0]["temperature_k"] = json!(305.0);
    });
    let files = [1, 2].map(|threads| {
        let out = folder.path().join(format!("threads_{threads}"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| make(&path, &grid(8.0, 12.0, 1.0), &asked(0.05), &out));
        let names = output::list(&out).expect("files");
        let bytes = |name: &String| fs::read(out.join(name)).expect("a file");
        names.iter().map(|name| (name.clone(), bytes(name))).collect::<BTreeMap<_, _>>()
    });
    assert_eq!(files[0].len(), 13, "{:?}", files[0].keys());
    for (name, bytes) in &files[0] {
        assert!(files[1][name] == *bytes, "{name} differs");
    }
}

#[test]
fn a_box_of_no_width_is_a_wavelength_and_a_narrow_one_nearly_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    let cubes = [None, Some(0.0), Some(1e-6)].map(|width_um| {
        let mut sensor = json!({"pixels": [5, 5]});
        if let Some(width_um) = width_um {
            let bands = [8.613, 9.113, 9.613];
            let bands = bands.map(|um| json!({"box": {"centre_um": um, "width_um": width_um}}));
            sensor["bands"] = json!(bands);
        }
        make(&patch(&folder, &sensor, |_| ()), &grid(8.613, 9.613, 0.5), &asked(0.05), &out);
        ["radiance", "emissivity"].map(|name| cube(&out, name))
    });
    assert_eq!(cubes[0], cubes[1]);
    for (point, narrow) in cubes[0].iter().zip(&cubes[2]) {
        for (a, b) in point.data.iter().zip(&narrow.data) {
            assert!((a - b).abs() < 1e-5 * a.abs(), "{a} {b}");
        }
    }
}

#[test]
fn the_sensors_noise_is_what_the_scene_asks_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    let bands = grid(8.0, 12.0, 1.0);
    let black = |noise: Value| {
        let mut sensor = json!({"pixels": [48, 48]});
        if !noise.is_null() {
            sensor["noise"] = noise;
        }
        let mut scene = panels(&folder, "open", &sensor);
        for material in scene["materials"].as_array_mut().expect("a list") {
            material["spectrum"] = json!({"constant": 1.0});
            material["temperature_k"] = json!(300.0);
        }
        make(&write(&folder, &scene), &bands, &asked(0.05), &out);
        ["radiance", "radiance_standard_error", "emissivity"].map(|name| cube(&out, name))
    };
    let clean = black(Value::Null);
    let slope = |um: f64| planck_derivative(um, 300.0);
    let cases: [(Value, &dyn Fn(f64) -> f64); 2] = [
        (json!({"nedl_w_m2_sr_um": 0.03, "seed": 5}), &|_| 0.03),
        (json!({"nedt_k": 0.2, "seed": 5}), &|um| 0.2 * slope(um)),
    ];
    for (noise, nedl) in cases {
        let noisy = black(noise);
        assert_eq!(noisy[2], clean[2], "the bed has no noise of the sensor");
        for (band, &um) in clean[0].wavelengths_um.iter().enumerate() {
            let pairs = values(&noisy[0], band).iter().zip(values(&clean[0], band));
            let differences = pairs.map(|(a, b)| f64::from(a - b));
            let number = differences.clone().count() as f64;
            let offset = mean(differences.clone());
            let realised = (mean(differences.map(|d| d * d)) - offset * offset).sqrt();
            let asked = nedl(um);
            // Four standard errors of a standard deviation, and of a mean.
            assert!(
                (realised / asked - 1.0).abs() < 4.0 / (2.0 * number).sqrt(),
                "{realised} {asked}"
            );
            assert!(offset.abs() < 4.0 * asked / number.sqrt(), "{um} um: off by {offset}");
            let stated = f64::from(values(&noisy[1], band)[7]);
            assert!((stated / asked - 1.0).abs() < 1e-6, "black panels have no noise of rays");
        }
    }
}

/// The text of a header, and the bands that it names bad.
fn header(out: &Path, name: &str) -> String {
    fs::read_to_string(out.join(format!("{name}.hdr"))).expect("a header")
}

#[test]
fn headers_name_the_bands_with_their_widths_and_no_errors_of_rounding() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    let bands = json!([
        {"box": {"centre_um": 8.65, "width_um": 0.35}},
        {"gaussian": {"centre_um": 9.1, "fwhm_um": 0.1}},
        {"box": {"centre_um": 8.3, "width_um": 0.0}},
    ]);
    let scene = panels(&folder, "open", &json!({"pixels": [2, 2], "bands": bands}));
    let made = make(&write(&folder, &scene), &grid(8.0, 12.0, 1.0), &asked(0.1), &out);
    assert_eq!(made.warnings, Vec::<String>::new());
    let text = header(&out, "radiance");
    for line in [
        "band names = {8.65 um, 9.1 um, 8.3 um}",
        "wavelength = {8.65, 9.1, 8.3}",
        "fwhm = {0.35, 0.1, 0}",
    ] {
        assert!(text.lines().any(|of| of == line), "{text}");
    }
    assert!(!text.contains("bbl"));
}

/// Fine grains measure below ten wavelengths.
#[test]
fn bands_in_which_grains_let_light_through_are_marked_and_warned_of() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    let path = patch(&folder, &json!({"pixels": [2, 2]}), |scene| {
        scene["materials"][0]["spectrum"] = json!({"fresnel": "quartz"});
        scene["materials"][1]["spectrum"] = json!({"fresnel": "quartz"});
    });
    let made = make(&path, &grid(8.0, 12.0, 1.0), &asked(0.2), &out);
    let of_facets: Vec<&String> =
        made.warnings.iter().filter(|text| text.contains("fresnel facets do not hold")).collect();
    assert_eq!(of_facets.len(), 1, "{:?}", made.warnings);
    let bad = cube(&out, "radiance").is_bad;
    assert!(bad.contains(&true), "{bad:?}");
    let text = header(&out, "emissivity");
    assert!(text.lines().any(|line| line.starts_with("bbl = {")), "{text}");
}

#[test]
fn bands_and_sizes_that_no_machine_holds_are_refused_before_the_work() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut told = String::new();
    for bands in [
        json!([{"gaussian": {"centre_um": 9.0, "fwhm_um": 1e18}}]),
        json!([{"box": {"centre_um": 1e9, "width_um": 1.0}}]),
        json!([{"grid": {"from_um": 8.0, "to_um": 9.0, "step_um": 0.1, "fwhm_um": 40.0}}]),
    ] {
        let scene = panels(&folder, "open", &json!({"pixels": [2, 2], "bands": bands}));
        let error = Scene::read(&write(&folder, &scene)).expect_err("too wide");
        told += &message(&error, error.hint());
    }
    fs::write(folder.path().join("wide.csv"), "um,response\n8,1\n1e9,1\n").expect("written");
    let try_to = |sensor: &Value| {
        let path = write(&folder, &panels(&folder, "open", sensor));
        let scene = Scene::read(&path).expect("a scene");
        let tracer = trace::tracer(&scene).expect("meshes");
        let out = folder.path().join("out");
        image::make(&tracer, &scene, &grid(7.5, 14.0, 1e-4), &asked(0.5), &out, &Unwatched)
            .expect_err("too much")
    };
    for bands in
        [json!([{"file": "wide.csv"}]), json!([{"box": {"centre_um": 3000.0, "width_um": 2500.0}}])]
    {
        let error = try_to(&json!({"pixels": [2, 2], "bands": bands}));
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
    let error = try_to(&json!({"pixels": [16384, 16384]})).to_string();
    let task = "an image of 16384 x 16384 pixels in 65001 bands takes 41877";
    assert!(error.starts_with(task) && error.contains("are free"), "{error}");
}

#[test]
fn a_pinhole_within_the_bed_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let optics = json!({"pinhole": {"distance_um": 1.0, "field_of_view_deg": 20.0}});
    let path = patch(&folder, &json!({"pixels": [4, 4], "optics": optics}), |_| ());
    let scene = Scene::read(&path).expect("a scene");
    let tracer = trace::tracer(&scene).expect("meshes");
    let made =
        image::make(&tracer, &scene, &grid(9.0, 9.0, 1.0), &asked(0.1), folder.path(), &Unwatched);
    let error = made.expect_err("it stands in the bed");
    assert_snapshot!(message(&error, error.hint()));
}
