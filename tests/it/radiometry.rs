//! The chain from temperatures, sky and atmosphere to radiance and back, through scene files and
//! the program.

use std::fmt::Write as _;
use std::fs;

use insta::assert_snapshot;
use soilsig::products::cube::Cube;
use soilsig::radiometry::{Assumed, brightness_temperature_k, planck};
use soilsig::scene::{Grid, Scene};
use soilsig::signature::{self, Band};
use soilsig::support::monitor::Unwatched;
use soilsig::table::{Prepared, Table, Target};
use soilsig::tracer::trace::{self, Request};

use crate::support::{Place, shipped, told};

const PLATE: &str = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nusemtl m\nf 1 2 3 4\n";
const TROUGH: &str = "v 0 0 0\nv 500 0 0\nv 500 500 0\nv 0 500 0\nv 0 0 400\nv 500 0 400\n\
    v 500 500 400\nv 0 500 400\nusemtl m\nf 1 2 3 4\nusemtl n\nf 1 2 6 5\nf 2 3 7 6\n\
    f 3 4 8 7\nf 4 1 5 8\n";

/// A scene at 300 K with an emissivity for each material and further keys.
fn write_scene(place: &Place, obj: &str, emissivity: [f64; 2], keys: &str) {
    fs::write(place.path("mesh.obj"), obj).expect("written");
    let [m, n] = emissivity;
    let scene = format!(
        r#"{{"soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300, {keys}
             "view": {{"zenith_deg": 0}}, "materials": [
             {{"name": "m", "spectrum": {{"constant": {m}}}}}, {{"name": "n", "spectrum": {{"constant": {n}}}}}],
             "geometry": {{"placed": {{"prototypes": [{{"name": "mesh", "file": "mesh.obj"}}]}}}}}}"#
    );
    fs::write(place.path("scene.json"), scene).expect("written");
}

fn grid() -> Grid {
    Grid::new(8.0, 12.0, 0.5).expect("a grid")
}

fn traced(place: &Place) -> Table {
    let path = place.path("scene.json");
    let scene = Scene::read(&path).expect("the scene is sound");
    let tracer = trace::tracer(&scene).expect("its meshes are sound");
    trace::trace(
        &tracer,
        &Prepared::new(scene.clone(), &grid().wavelengths_um()).expect("spectra"),
        Request::new(&grid(), Target::of(0.02)),
        &Unwatched,
    )
    .expect("traced")
}

fn evaluated(table: &Table) -> Vec<Band> {
    signature::evaluate(std::slice::from_ref(table), &grid().wavelengths_um()).expect("evaluated")
}

/// A sky file on the bands of the grid.
fn write_sky(place: &Place, l_sky: impl Fn(f64) -> f64) {
    let mut text = String::from("# made for a test\nwavelength_um,l_downwelling_w_m2_sr_um\n");
    for um in grid().wavelengths_um() {
        writeln!(text, "{um},{:e}", l_sky(um)).expect("text");
    }
    fs::write(place.path("sky.csv"), text).expect("written");
}

/// The same at each of some zenith angles, times what each makes of it; in reverse order.
fn write_sky_by_zenith(place: &Place, l_sky: impl Fn(f64) -> f64, by: impl Fn(f64) -> f64) {
    let mut text = String::from("zenith_deg,wavelength_um,l_downwelling_w_cm2_sr_um\n");
    for zenith in [90.0, 60.0, 30.0, 0.0] {
        for um in grid().wavelengths_um().iter().rev() {
            writeln!(text, "{zenith},{um},{:e}", by(zenith) * l_sky(*um) / 1e4).expect("text");
        }
    }
    fs::write(place.path("sky.csv"), text).expect("written");
}

const FILE: &str = r#""sky_radiance": {"isotropic": "sky.csv"},"#;
const FILE_BY_ZENITH: &str = r#""sky_radiance": {"by_zenith": "sky.csv"},"#;

/// The best self-test of the chain: the geometry drops out of the retrieval. Where facets are dark
/// paths are given up, and it holds still.
#[test]
fn eq_2_is_eq_3_under_any_isotropic_sky_for_any_geometry() {
    let uneven = |um: f64| 3.0 + 2.9 * (40.0 * um).sin();
    let skies: [(&str, &dyn Fn(f64) -> f64); 5] = [
        ("black", &|_| 0.0),
        ("200 K", &|um| planck(um, 200.0)),
        ("299 K", &|um| planck(um, 299.0)),
        ("warmer than the target", &|um| planck(um, 320.0)),
        ("uneven", &uneven),
    ];
    for (obj, emissivity) in [(PLATE, [0.37, 0.5]), (TROUGH, [0.6, 0.9]), (TROUGH, [0.9, 0.95])] {
        let place = Place::new();
        write_sky(&place, |_| 0.0);
        write_scene(&place, obj, emissivity, FILE);
        let mut table = traced(&place);
        if emissivity[0] == 0.9 {
            assert!(table.histogram.paths_given_up() > 0.0, "paths are to be given up here");
        }
        assert!(table.eq_2_not_exact().is_empty());
        for (name, l_sky) in &skies {
            write_sky(&place, l_sky);
            table.sky_radiance =
                Some(soilsig::radiometry::SkyTable::read(&place.path("sky.csv")).expect("a sky"));
            let assumed = Assumed { amplification_limit: 1e9, ..Assumed::EXACT };
            let bands = evaluated(&table);
            let retrieved = signature::retrieve(&bands, table.temperature(), assumed);
            for (band, retrieved) in bands.iter().zip(&retrieved) {
                let [eq2, error] = retrieved.emissivity.expect("it is told");
                let [eq3, _] = band.emissivity_eq3(table.temperature());
                let rounding = 1e-13 * retrieved.amplification.max(1.0);
                assert!((eq2 - eq3).abs() < rounding, "{name}: {eq2} and {eq3}");
                assert!((eq2 - band.emissivity.mean).abs() < rounding, "{name}");
                let direct = band.emissivity.standard_error;
                assert!((error - direct).abs() <= 1e-9 * direct + rounding, "{name}");
                let sum = band.l_emitted.mean + band.l_reflected.mean;
                assert!((band.l_target.mean / sum - 1.0).abs() < 1e-14, "Eq. 1");
            }
        }
    }
}

#[test]
fn a_file_of_plancks_law_is_a_grey_sky_and_the_same_at_all_angles_an_isotropic_one() {
    let place = Place::new();
    for emissivity in [[0.6, 0.9], [0.9, 0.95]] {
        write_scene(&place, TROUGH, emissivity, r#""sky_temperature_k": 260,"#);
        let grey = evaluated(&traced(&place));
        write_sky(&place, |um| planck(um, 260.0));
        write_scene(&place, TROUGH, emissivity, FILE);
        let by_file = evaluated(&traced(&place));
        write_sky_by_zenith(&place, |um| planck(um, 260.0), |_| 1.0);
        write_scene(&place, TROUGH, emissivity, FILE_BY_ZENITH);
        let by_zenith = evaluated(&traced(&place));
        for ((a, b), c) in grey.iter().zip(&by_file).zip(&by_zenith) {
            for other in [b, c] {
                for of in [|b: &Band| b.l_target, |b: &Band| b.l_emitted, |b: &Band| b.l_reflected]
                {
                    let (a, other) = (of(a), of(other));
                    assert!((other.mean / a.mean - 1.0).abs() < 1e-12);
                    assert!((other.standard_error / a.standard_error - 1.0).abs() < 1e-6);
                    assert!((other.trapped - a.trapped).abs() < 1e-12);
                }
                assert!((other.l_downwelling / a.l_downwelling - 1.0).abs() < 1e-12);
            }
        }
    }
}

/// A level plate reflects l_downwelling whatever the sky's angles are, so Eq. 2 holds there; a
/// trough does not.
#[test]
fn under_a_sky_by_zenith_eq_2_is_said_not_to_be_exact_and_is_not() {
    let place = Place::new();
    // The more sky there is near the horizon the less of it gets into a trough.
    write_sky_by_zenith(&place, |um| planck(um, 250.0), |zenith| 1.0 + zenith / 90.0);
    write_scene(&place, TROUGH, [0.6, 0.6], FILE_BY_ZENITH);
    let table = traced(&place);
    let bands = evaluated(&table);
    let retrieved = signature::retrieve(&bands, table.temperature(), Assumed::EXACT);
    let off = |i: usize| retrieved[i].emissivity.expect("told")[0] - bands[i].emissivity.mean;
    assert!((0..bands.len()).all(|i| off(i) < -0.002), "{}", off(0));
    table.write(&place.path("table.json")).expect("written");
    let args = ["signature", "table.json", "--range", "8-12", "--out", "s.csv"];
    assert_snapshot!(told(&args, 0, &place.run(&args, 0).1));
    let with_sky: Vec<&str> = args.into_iter().chain(["--sky", "250"]).collect();
    assert_eq!(place.run(&with_sky, 0).1, "");
}

#[test]
fn where_materials_differ_in_temperature_eq_2_is_said_not_to_be_exact() {
    let place = Place::new();
    write_sky(&place, |_| 0.0);
    write_scene(&place, TROUGH, [0.6, 0.9], FILE);
    let text = fs::read_to_string(place.path("scene.json")).expect("a scene");
    let text = text.replace(r#"{"constant": 0.9}"#, r#"{"constant": 0.9}, "temperature_k": 310"#);
    fs::write(place.path("scene.json"), text).expect("written");
    let args = [
        "trace",
        "scene.json",
        "--out",
        "t.json",
        "--tolerance",
        "0.02",
        "--range",
        "8-12",
        "--verbose",
    ];
    let (out, _) = place.run(&args, 0);
    let lines: Vec<&str> = out.lines().filter(|line| line.contains("Eq. 2")).collect();
    assert!(!lines.is_empty(), "{out}");
    assert_snapshot!(told(
        &args,
        0,
        &lines.join(
            "
"
        )
    ));
}

#[test]
fn files_of_sky_and_atmosphere_that_will_not_do_are_named_before_the_trace() {
    let place = Place::new();
    let air = r#""atmosphere_file": "air.csv","#;
    let sky = "wavelength_um,l_downwelling_w_m2_sr_um\n";
    let both = "wavelength_um,zenith_deg,l_downwelling_w_m2_sr_um\n";
    let atmosphere = "wavelength_um,transmittance,l_path_w_m2_sr_um\n";
    let rows = |heading: &str, rows: &str| format!("{heading}{rows}");
    let mut said = String::new();
    for (keys, file, text) in [
        (FILE, "sky.csv", rows(sky, "8,1\n9,1\n")),
        (air, "air.csv", rows(atmosphere, "9,1,0\n13,1,0\n")),
        (FILE, "sky.csv", rows("um,l\n", "8,1\n12,1\n")),
        (FILE, "sky.csv", rows(sky, "8,1\n9,x\n12,1\n")),
        (FILE, "sky.csv", rows(sky, "8,1\n9,-1\n12,1\n")),
        (FILE, "sky.csv", rows(sky, "8,1\n8,1\n12,1\n")),
        (FILE, "sky.csv", rows(sky, "8,1\n9,1,1\n12,1\n")),
        (FILE, "sky.csv", rows(sky, "")),
        (FILE, "sky.csv", rows(both, "8,0,1\n12,0,1\n8,90,1\n12,90,1\n")),
        (FILE_BY_ZENITH, "sky.csv", rows(sky, "8,1\n12,1\n")),
        (FILE_BY_ZENITH, "sky.csv", rows(both, "8,0,1\n12,0,1\n8,80,1\n12,80,1\n")),
        (FILE_BY_ZENITH, "sky.csv", rows(both, "8,0,1\n12,0,1\n8,90,1\n")),
        (air, "air.csv", rows(atmosphere, "8,1,0\n12,1.2,0\n")),
        (FILE, "none.csv", String::new()),
        (
            r#""sky_temperature_k": 250, "sky_radiance": {"isotropic": "sky.csv"},"#,
            "sky.csv",
            String::new(),
        ),
    ] {
        let _ = fs::remove_file(place.path("sky.csv"));
        fs::write(place.path(file), &text).expect("written");
        write_scene(&place, PLATE, [0.5, 0.5], keys);
        let args = ["trace", "scene.json", "--out", "t.json", "--range", "8-12"];
        said += &format!("{keys} {file}: {text:?}\n{}", place.refused(&args, 3));
        assert!(!place.path("t.json").exists());
    }
    assert_snapshot!(said);
}

/// The columns of a signature by their headings; empty fields are `None`, and so are those of a
/// column that is left out for want of a value.
fn column(text: &str, heading: &str) -> Vec<Option<f64>> {
    let place = text.lines().next().expect("headings").split(',').position(|h| h == heading);
    let field = |line: &str| line.split(',').nth(place?).expect("a field").parse().ok();
    text.lines().skip(1).map(field).collect()
}

#[test]
fn a_signature_is_retrieved_again_from_its_own_file_through_an_atmosphere() {
    let place = Place::new();
    write_sky(&place, |um| planck(um, 270.0) * (0.5 + 0.4 * (30.0 * um).sin()));
    let air = "wavelength_um,transmittance,l_path_w_m2_sr_um\n7,0.5,2\n15,0.9,1\n";
    fs::write(place.path("air.csv"), air).expect("written");
    write_scene(&place, TROUGH, [0.6, 0.9], &format!(r#"{FILE} "atmosphere_file": "air.csv","#));
    traced(&place).write(&place.path("table.json")).expect("written");
    let bands = ["--range", "8-12", "--step", "0.5"];
    let (csv, words) = place.run(&[&["signature", "table.json"][..], &bands].concat(), 0);
    assert_eq!(words, "");
    fs::write(place.path("s.csv"), &csv).expect("written");
    let args = ["retrieve", "s.csv", "--temperature", "300", "--atmosphere", "air.csv"];
    let (back, words) = place.run(&args, 0);
    assert_snapshot!(told(&args, 0, &words));
    for (ours, theirs) in [
        ("emissivity_eq2", "emissivity"),
        ("emissivity_eq2_standard_error", "emissivity_standard_error"),
        ("brightness_temperature_k", "brightness_temperature_k"),
        ("amplification", "amplification"),
    ] {
        for (a, b) in column(&csv, ours).into_iter().zip(column(&back, theirs)) {
            assert!((a.expect("a number") - b.expect("a number")).abs() < 2e-5, "{ours}");
        }
    }
    // The compensation matters: without it the same numbers are another target's.
    let tau = 0.5 + 0.4 * (8.0 - 7.0) / 8.0;
    let sensor = column(&csv, "l_sensor_w_m2_sr_um")[0].expect("a number");
    let target = column(&csv, "l_target_w_m2_sr_um")[0].expect("a number");
    assert!((sensor - (tau * target + 2.0 - 1.0 / 8.0)).abs() < 1e-6);
    // A temperature that is a kelvin too high, and known to be no better.
    let args = [&args[..3], &["301"], &args[4..], &["--temperature-error", "1"]].concat();
    let (off, _) = place.run(&args, 0);
    let (e, error) = (column(&off, "emissivity"), column(&off, "emissivity_standard_error"));
    for ((truth, e), error) in column(&csv, "emissivity").into_iter().zip(e).zip(error) {
        let [truth, e, error] = [truth, e, error].map(|x| x.expect("a number"));
        assert!(e < truth && truth - e < 1.1 * error, "{truth} {e} {error}");
    }
}

#[test]
fn bands_that_tell_nothing_are_named_and_have_no_numbers_in_the_signature() {
    let place = Place::new();
    // As warm as the target from 9 to 10 um.
    write_sky(&place, |um| planck(um, if (9.0..=10.0).contains(&um) { 299.0 } else { 250.0 }));
    write_scene(&place, TROUGH, [0.6, 0.9], FILE);
    traced(&place).write(&place.path("table.json")).expect("written");
    let bands = ["signature", "table.json", "--range", "8-12", "--step", "0.5"];
    let (csv, words) = place.run(&bands, 0);
    assert_snapshot!(told(&bands, 0, &words));
    let told: Vec<bool> = column(&csv, "emissivity_eq2").iter().map(Option::is_some).collect();
    assert_eq!(told, [true, true, false, false, false, true, true, true, true]);
    assert!(column(&csv, "emissivity_eq2_standard_error")[2].is_none());
    assert!(column(&csv, "emissivity").iter().all(Option::is_some));
    let (all, words) = place.run(&[&bands[..], &["--amplification-limit", "100"]].concat(), 0);
    assert!(column(&all, "emissivity_eq2").iter().all(Option::is_some), "{words}");
    let (less, _) = place.run(&[&bands[..], &["--amplification-limit", "1.2"]].concat(), 0);
    assert!(column(&less, "emissivity_eq2").iter().any(Option::is_none));
}

/// Sixteen panels of emissivity 1 and .9 from 250 to 350 K, each a pixel, under a sky at 200 K that
/// one band of five does not let through.
#[test]
fn an_image_of_panels_gives_back_their_temperatures_and_emissivities() {
    let place = Place::new();
    // Out of order, as some instruments have them.
    let um = vec![9.0, 8.0, 10.0, 12.0, 11.0];
    let sky = |um: f64| if um == 11.0 { planck(um, 349.9) } else { planck(um, 200.0) };
    let kelvin = |line: usize, sample: usize| 250.0 + 100.0 / 15.0 * (4 * line + sample) as f64;
    let panel = |sample: usize| if sample.is_multiple_of(2) { 1.0 } else { 0.9 };
    let mut cube = Cube::new(4, 4, um.clone());
    for (line, sample) in (0..16).map(|i| (i / 4, i % 4)) {
        let e = panel(sample);
        let l = |&um: &f64| (e * planck(um, kelvin(line, sample)) + (1.0 - e) * sky(um)) as f32;
        cube.set_spectrum(line, sample, &um.iter().map(l).collect::<Vec<_>>());
    }
    let lost = cube.place(0, 0, 0);
    cube.data[lost] = f32::NAN;
    cube.write(&place.path("panels.img"), "radiance, W m-2 sr-1 um-1").expect("written");
    let mut text = String::from("wavelength_um,l_downwelling_w_m2_sr_um\n");
    for um in [8.0, 9.0, 10.0, 11.0, 12.0] {
        writeln!(text, "{um},{:e}", sky(um)).expect("text");
    }
    fs::write(place.path("sky.csv"), text).expect("written");
    let args =
        ["retrieve", "panels.hdr", "--sky", "sky.csv", "--temperature", "350", "--out", "e.img"];
    let (_, words) = place.run(&args, 0);
    let mut said = told(&args, 0, &words);
    let e = Cube::read(&place.path("e.img")).expect("an image");
    let brightness = Cube::read(&place.path("e_brightness_temperature.img")).expect("an image");
    assert_eq!(e.wavelengths_um, um);
    // The last panel is the one at 350 K.
    for (band, e) in e.spectrum(3, 3).into_iter().enumerate() {
        if um[band] == 11.0 {
            assert!(e.is_nan());
        } else {
            assert!((f64::from(e) - 0.9).abs() < 1e-6, "{} um: {e}", um[band]);
        }
    }
    assert!(e.spectrum(0, 0)[0].is_nan() && !e.spectrum(0, 0)[1].is_nan());
    for (line, sample) in (0..16).map(|i| (i / 4, i % 4)) {
        for (band, t) in brightness.spectrum(line, sample).into_iter().enumerate().skip(1) {
            let (um, e) = (um[band], panel(sample));
            let l = e * planck(um, kelvin(line, sample)) + (1.0 - e) * sky(um);
            let truth = brightness_temperature_k(um, l).expect("it is above 0");
            assert!((f64::from(t) - truth).abs() < 1e-4);
            assert!(e < 1.0 || (f64::from(t) - kelvin(line, sample)).abs() < 1e-4);
        }
    }
    // By the radiance itself: NEM needs three bands within 8 to 12 um, which all pixels but none
    // lack.
    let christiansen = [&args[..4], &["--method", "christiansen", "--out", "t.img"]].concat();
    said += &told(&christiansen, 0, &place.run(&christiansen, 0).1);
    assert_snapshot!(said);
    place.run(&[&args[..4], &["--method", "nem", "--out", "t.img"]].concat(), 0);
    let size = fs::metadata(place.path("t_temperature.img")).expect("written").len();
    assert_eq!(size, 2 * 16 * 4);
}

#[test]
fn what_retrieve_cannot_read_is_named() {
    let place = Place::new();
    fs::write(place.path("l.csv"), "wavelength_um,radiance_w_m2_sr_um\n9,7.1\n10,8\n")
        .expect("written");
    fs::write(place.path("sky.csv"), "wavelength_um,l_downwelling_w_m2_sr_um\n9.5,1\n11,1\n")
        .expect("written");
    fs::write(place.path("n.csv"), "wavelength_um,l\n9,7.1\n").expect("written");
    let mut said = String::new();
    for (args, status) in [
        (&["l.csv"][..], 2),
        (&["l.csv", "--temperature", "0"], 2),
        (&["l.csv", "--temperature", "300", "--sky", "sky.csv"], 3),
        (&["l.csv", "--temperature", "300", "--sky", "0"], 2),
        (&["n.csv", "--temperature", "300"], 3),
        (&["no.csv", "--temperature", "300"], 3),
        (&["l.csv", "--method", "smoothness"], 3),
        (&["l.img", "--temperature", "300"], 2),
    ] {
        said += &place.refused(&[&["retrieve"], args].concat(), status);
    }
    // A temperature far too low is told by emissivities above 1.
    let args = ["retrieve", "l.csv", "--temperature", "250"];
    said += &told(&args, 0, &place.run(&args, 0).1);
    assert_snapshot!(said);
}

#[test]
fn a_run_takes_its_sky_and_atmosphere_along_and_says_what_can_be_had_back() {
    let place = Place::new();
    let text = fs::read_to_string(shipped("settled_patch.json")).expect("a scene");
    let text = text.replace(
        r#""temperature_k": 300.0,"#,
        r#""temperature_k": 300, "sky_radiance": {"isotropic": "air/sky.csv"}, "atmosphere_file": "air/air.csv","#,
    );
    fs::write(place.path("mine.json"), text).expect("written");
    fs::copy(shipped("settled_patch.obj"), place.path("settled_patch.obj")).expect("copied");
    fs::create_dir(place.path("air")).expect("made");
    fs::write(place.path("air/sky.csv"), "wavelength_um,l_downwelling_w_m2_sr_um\n7,2\n15,2\n")
        .expect("written");
    let air = "wavelength_um,transmittance,l_path_w_m2_sr_um\n7,0.5,2\n15,0.9,1\n";
    fs::write(place.path("air/air.csv"), air).expect("written");
    place.run(&["pipeline", "--scene", "mine.json", "--out", "out", "--tolerance", "0.02"], 0);
    let record = fs::read_to_string(place.path("out/run.json")).expect("a record");
    let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
    for file in ["air/sky.csv", "air/air.csv"] {
        let names = record["inputs"].as_object().expect("inputs").keys();
        assert!(names.into_iter().any(|name| name.ends_with(file)), "{file}: {}", record["inputs"]);
    }
    for file in ["out/sky_sky.csv", "out/atmosphere_air.csv"] {
        assert!(!place.path(file).exists(), "a placed scene stays where it is");
    }
    let reached = record["reached"].as_object().expect("a scene").values().next().expect("one");
    let separation = &reached["retrieval"]["separation"];
    let kelvin = separation["nem"]["found"]["temperature_k"].as_f64().expect("it is found");
    assert!((kelvin - 300.0).abs() < 3.0, "{separation}");
    assert_snapshot!(separation["smoothness"]["refused"].as_str().expect("no lines"));
    assert!(reached["retrieval"]["eq_2_difference"].as_f64().expect("told") < 1e-9);
    let csv = fs::read_to_string(place.path("out/signature.csv")).expect("written");
    assert!(column(&csv, "l_sensor_w_m2_sr_um").iter().all(Option::is_some));
    // The file's content is what the trace belongs to, not its name.
    fs::write(place.path("air/sky.csv"), "wavelength_um,l_downwelling_w_m2_sr_um\n7,3\n15,3\n")
        .expect("written");
    place.run(&["pipeline", "--scene", "mine.json", "--out", "out", "--tolerance", "0.02"], 0);
    let other = fs::read_to_string(place.path("out/signature.csv")).expect("written");
    assert_eq!(column(&other, "l_downwelling_w_m2_sr_um")[0], Some(3.0));
}
