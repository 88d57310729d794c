//! Where facets have their reflectance from: what `inverted` gives back, where `fresnel` does not
//! hold, what is refused, and what a result says of all that.

use std::fs;

use insta::assert_snapshot;
use serde_json::{Value, json};
use soilsig::signature;
use soilsig::spectrum::format::{Reading, read_one};
use soilsig::spectrum::{PureBed, Spectrum, SpectrumError};
use soilsig::table::Table;

use crate::support::{Place, Tool, shipped, shipped_json, told, tool, without_fractions};

/// A closed box, 300 um a side: its mean chord is 4 V / S = 200 um.
const BOX: &str = "v 0 0 0\nv 300 0 0\nv 300 300 0\nv 0 300 0\nv 0 0 300\nv 300 0 300\nv 300 300 300\nv 0 300 300\n\
    usemtl quartz\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const PLATE: &str = "v 0 0 0\nv 300 0 0\nv 300 300 0\nv 0 300 0\nusemtl quartz\nf 1 2 3 4\n";
/// Two facets at right angles, open upward: a ray from above meets both.
const GROOVE: &str = "v 150 0 0\nv 150 300 0\nv 300 0 150\nv 300 300 150\nv 0 0 150\nv 0 300 150\nusemtl quartz\n\
    f 1 3 4 2\nf 1 2 6 5\n";

/// A scene of one mesh and one material.
fn scene(place: &Place, obj: &str, material: &Value) -> String {
    fs::write(place.path("mesh.obj"), obj).expect("written");
    let mut material = material.clone();
    material["name"] = "quartz".into();
    let scene = json!({
        "soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300, "view": {"zenith_deg": 0},
        "materials": [material],
        "geometry": {"placed": {"prototypes": [{"name": "mesh", "file": "mesh.obj"}],
            "domain": {"min_um": [0, 0], "max_um": [300, 300], "sides": "open"}}}
    });
    fs::write(place.path("scene.json"), scene.to_string()).expect("written");
    "scene.json".into()
}

/// The shipped patch, all of one Lambertian material that is nearly white, traced.
fn pure(place: &Place) -> Table {
    let mut scene = shipped_json("settled_patch.json");
    scene["materials"] = json!([{"name": "rock", "spectrum": {"constant": 0.05}}]);
    let placed = &mut scene["geometry"]["placed"];
    placed["domain"]["floor"]["material"] = "rock".into();
    for prototype in placed["prototypes"].as_array_mut().expect("prototypes") {
        prototype["material"] = "rock".into();
    }
    fs::write(place.path("pure_scene.json"), scene.to_string()).expect("written");
    let args =
        ["trace", "pure_scene.json", "--out", "pure.json", "--paths", "20000", "--range", "9-9"];
    place.run(&args, 0);
    Table::read(&place.path("pure.json")).expect("a table")
}

fn emissivity(table: &Table, um: &[f64]) -> Vec<f64> {
    let bands = signature::evaluate(std::slice::from_ref(table), um).expect("within its range");
    bands.iter().map(|band| band.emissivity.mean).collect()
}

#[test]
fn a_pure_bed_of_inverted_facets_returns_the_powders_own_curve_to_rounding() {
    let place = Place::new();
    let mut table = pure(&place);
    let um: Vec<f64> = (730..=1400).map(|i| f64::from(i) / 100.0).collect();
    for powder in ["quartz_fine", "quartz_medium", "quartz_coarse"] {
        let powder = Spectrum::builtin(powder).expect("shipped");
        let bed = PureBed::read(&[place.path("pure.json")]).expect("a pure bed");
        table.materials[0].spectrum = powder.clone();
        let library = emissivity(&table, &um);
        table.materials[0].spectrum = Spectrum::Inverted(Box::new(powder.clone()), bed);
        let inverted = emissivity(&table, &um);
        for (i, &um) in um.iter().enumerate() {
            let own = powder.emissivity(um).expect("in range");
            assert!((inverted[i] - own).abs() < 1e-12, "{um}: {} and {own}", inverted[i]);
            // What `library` does instead: the powder's scattering once more.
            assert!(library[i] > own || own > 1.0 - 1e-6, "{um}: {} and {own}", library[i]);
        }
    }
}

#[test]
fn a_scene_inverts_by_tables_of_its_own_and_its_table_stands_alone() {
    let place = Place::new();
    pure(&place);
    let spectrum = json!({"inverted": {"spectrum": {"constant": 0.6}, "pure_bed": ["pure.json"]}});
    let scene = scene(&place, PLATE, &json!({"spectrum": spectrum}));
    let out = place.run(&["trace", &scene, "--out", "t.json"], 0).0;
    let line = out.lines().find(|line| line.contains("inverted")).expect("what they are");
    assert_snapshot!(without_fractions(line));
    fs::remove_file(place.path("pure.json")).expect("there");
    let plate = Table::read(&place.path("t.json")).expect("a table");
    // A plate is no bed: it shows the facets themselves, darker than the powder.
    let facet = emissivity(&plate, &[9.0])[0];
    assert!(facet < 0.45 && facet > 0.2, "{facet}");
}

#[test]
fn the_shipped_pure_bed_is_one_and_denser_than_a_random_bed_of_spheres() {
    let inverted = |emissivity: f64| {
        let source = json!({"inverted": {"spectrum": {"constant": emissivity}}});
        let source = serde_json::from_value(source).expect("a source");
        Spectrum::resolve(&source, std::path::Path::new("")).expect("shipped")
    };
    let Spectrum::Inverted(_, bed) = inverted(0.5) else { panic!("inverted") };
    let sum: f64 = bed.escaped.iter().chain(&bed.given_up).sum();
    assert!((sum - 1.0).abs() < 1e-9 && bed.standard_error < 0.01, "{sum} {}", bed.standard_error);
    // Random beds of Lambertian spheres, volume fraction .33, from a computation of its own:
    // looser, and so more emissive.
    for (facet, of_spheres) in
        [(0.371, 0.649), (0.5, 0.736), (0.76, 0.883), (0.858, 0.932), (0.95, 0.977)]
    {
        let back = 1.0 - bed.reflectance(1.0 - facet);
        assert!(back > facet + 0.2 * (of_spheres - facet), "{facet}: {back}");
        assert!(
            back < of_spheres && of_spheres - back < 0.08,
            "{facet}: {back}, spheres {of_spheres}"
        );
        let there = inverted(back).emissivity(9.0).expect("no bound");
        assert!((there - facet).abs() < 1e-12, "{facet}: {there}");
    }
    for end in [0.0, 1.0] {
        let facet = inverted(end).emissivity(9.0);
        match facet {
            Ok(facet) => assert!((facet - end).abs() < 1e-9, "{end}: {facet}"),
            // Paths that were given up leave open whether white facets would do.
            Err(SpectrumError::NoFacet { .. }) => assert!(end == 0.0 && !bed.given_up.is_empty()),
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn a_powder_that_no_facet_can_make_is_refused_by_band_and_value() {
    let bed = PureBed {
        title: "made up".into(),
        escaped: vec![0.0, 0.5, 0.1],
        given_up: vec![0.0, 0.0, 0.0, 0.4],
        standard_error: 0.0,
    };
    let of = |emissivity| Spectrum::Inverted(Box::new(Spectrum::Constant(emissivity)), bed.clone());
    assert!(of(0.21).emissivity(9.5).is_ok());
    let error = of(0.19).emissivity(9.5).expect_err("white facets give .8");
    let said = error.to_string();
    assert_snapshot!(said);
}

#[test]
fn what_is_no_pure_bed_or_no_powder_is_refused() {
    let place = Place::new();
    let (mesh, grey) =
        (scene(&place, GROOVE, &json!({"spectrum": {"constant": 0.5}})), "grey.json");
    place.run(&["trace", &mesh, "--out", grey], 0);
    let shiny = scene(&place, GROOVE, &json!({"spectrum": {"constant": 0.5}, "specular": 0.5}));
    place.run(&["trace", &shiny, "--out", "shiny.json"], 0);
    let angular = scene(&place, GROOVE, &json!({"spectrum": {"fresnel": "quartz"}}));
    place.run(&["trace", &angular, "--out", "angular.json"], 0);
    place.run(
        &["trace", &shipped("settled_patch.json"), "--out", "many.json", "--tolerance", "0.05"],
        0,
    );
    let inverted = |spectrum: Value, beds: &[&str]| {
        let source = json!({"inverted": {"spectrum": spectrum, "pure_bed": beds}});
        scene(&place, PLATE, &json!({"spectrum": source}))
    };
    let constant = json!({"constant": 0.6});
    let mut told = String::new();
    for (spectrum, beds) in [
        (&constant, &["many.json"][..]),
        (&constant, &["shiny.json"]),
        (&constant, &["angular.json"]),
        (&constant, &["scene.json"]),
        (&constant, &[grey, grey]),
        (&json!({"fresnel": "quartz"}), &[]),
        (&json!({"inverted": {"spectrum": {"constant": 0.5}}}), &[]),
    ] {
        let scene = inverted(spectrum.clone(), beds);
        told += &format!("{spectrum} by {beds:?}\n");
        told += &place.refused(&["trace", &scene, "--out", "t.json"], 3);
    }
    assert_snapshot!(told);
}

#[test]
fn bands_in_which_fresnel_grains_let_light_through_are_marked() {
    let place = Place::new();
    let quartz = json!({"spectrum": {"fresnel": "quartz"}});
    let scene_file = scene(&place, BOX, &quartz);
    let out = place.run(&["trace", &scene_file, "--out", "t.json"], 0).0;
    let line = out.lines().find(|line| line.contains("fresnel facets")).expect("where they hold");
    assert_snapshot!(line);
    let table = Table::read(&place.path("t.json")).expect("a table");
    let chord_um = table.materials[0].mean_chord_um.expect("a closed box");
    assert!((chord_um - 200.0).abs() < 1e-9, "{chord_um}");
    // exp(-4 pi k chord / wavelength), by the constants' k: .0402 and .0335 at 10 um, .0087 and
    // .0082 at 11 um.
    for (um, valid) in [(9.0, true), (8.6, true), (11.0, false), (11.5, false)] {
        assert_eq!(table.materials[0].is_valid(um), valid, "{um}");
    }
    place.run(&["signature", "t.json", "--out", "s.csv", "--plot", "s.svg"], 0);
    let mut rows = csv::Reader::from_path(place.path("s.csv")).expect("a CSV file");
    let at =
        rows.headers().expect("headings").iter().position(|h| h == "valid").expect("the column");
    let mut marked = 0;
    for row in rows.records() {
        let row = row.expect("a row");
        let um: f64 = row[0].parse().expect("a number");
        assert_eq!(&row[at] == "1", table.materials[0].is_valid(um), "{um}");
        marked += u32::from(&row[at] == "0");
    }
    assert!(marked > 100, "{marked}");
    let chart = fs::read_to_string(place.path("s.svg")).expect("written");
    assert!(chart.contains("Hatched"));
    // Ten times larger it is opaque where it was not.
    let large = BOX.replace("300", "30000");
    fs::write(place.path("mesh.obj"), large).expect("written");
    place.run(&["trace", &scene_file, "--out", "t.json"], 0);
    let table = Table::read(&place.path("t.json")).expect("a table");
    assert!((750..=1400).all(|i| table.materials[0].is_valid(f64::from(i) / 100.0)));
    // Opaque or not, a grain of three wavelengths is no mirror.
    fs::write(place.path("mesh.obj"), BOX.replace("300", "40")).expect("written");
    place.run(&["trace", &scene_file, "--out", "t.json"], 0);
    let table = Table::read(&place.path("t.json")).expect("a table");
    assert!((750..=1400).all(|i| !table.materials[0].is_valid(f64::from(i) / 100.0)));
    // What has no inside is taken for the surface of something thick.
    let plate = scene(&place, PLATE, &quartz);
    let (reached, _) = place.run(&["trace", &plate, "--out", "t.json", "--json"], 0);
    let reached: Value = serde_json::from_str(&reached).expect("JSON");
    assert_eq!(reached["not_valid_um"], json!([]));
    assert_eq!(
        Table::read(&place.path("t.json")).expect("a table").materials[0].mean_chord_um,
        None
    );
}

#[test]
fn the_meaning_of_facets_reaches_the_components_of_a_mix() {
    let place = Place::new();
    let mixed = |spectrum: Value| {
        json!({"spectrum": {"mix": [
            {"share": 0.25, "spectrum": {"constant": 0.9}},
            {"share": 0.75, "spectrum": spectrum},
        ]}})
    };
    let powder = json!({"builtin": "quartz_fine"});
    let inverted = json!({"inverted": {"spectrum": powder}});
    let emissivity = |facets: &str, spectrum: &Value| {
        let scene = scene(&place, PLATE, &mixed(spectrum.clone()));
        let args = ["pipeline", "--scene", &scene, "--facets", facets, "--range", "9-9"];
        place.run(&[&args[..], &["--tolerance", "0.05", "--out", "out"]].concat(), 0);
        let signature = place.read("out/signature.csv");
        let row = signature.lines().last().expect("a band");
        row.split(',').nth(1).expect("emissivity").parse::<f64>().expect("a number")
    };
    let [library, inside] = ["library", "inverted"].map(|facets| emissivity(facets, &powder));
    // A facet of a powder reflects more than a bed of such facets.
    assert!(inside < library - 0.02, "{inside} {library}");
    assert_eq!(emissivity("library", &inverted), library);
    assert_eq!(emissivity("inverted", &inverted), inside);
}

#[test]
fn fresnel_facets_are_specular_unless_the_scene_says_otherwise() {
    let place = Place::new();
    let curve = |specular: Option<f64>| {
        let mut material = json!({"spectrum": {"fresnel": "quartz"}});
        if let Some(share) = specular {
            material["specular"] = share.into();
        }
        let scene = scene(&place, GROOVE, &material);
        place.run(
            &["trace", &scene, "--out", "t.json", "--tolerance", "0.002", "--range", "9-9"],
            0,
        );
        emissivity(&Table::read(&place.path("t.json")).expect("a table"), &[9.0])[0]
    };
    let quartz = Spectrum::fresnel("quartz").expect("shipped");
    let at_45 = quartz.reflectance_at(9.0, 0.5_f64.sqrt()).expect("held");
    assert!((curve(None) - (1.0 - at_45 * at_45)).abs() < 3e-3);
    assert_eq!(curve(None), curve(Some(1.0)));
    // Lambertian facets send half or so past each other: less is absorbed.
    assert!(curve(Some(0.0)) < curve(None) - 0.02);
}

#[test]
fn a_result_says_where_facets_have_their_reflectance_from_and_what_that_means() {
    let place = Place::new();
    let header = "Name: Made up\nParticle Size: Fine\nSample No.: X-1\nMeasurement: Bidirectional reflectance\n\
        X Units: Wavelength (micrometers)\nY Units: Reflectance (percent)\nNumber of X Values: 2\n\
        Additional Information: none\n\n";
    fs::write(place.path("one_way.txt"), format!("{header}7.0\t10\n14.0\t20\n")).expect("written");
    let library = scene(&place, PLATE, &json!({"spectrum": {"file": "one_way.txt"}}));
    let mut said = String::new();
    for args in [
        &["trace", &library, "--out", "t.json"][..],
        &["pipeline", "--scene", &library, "--out", "r"],
    ] {
        let out = place.run(args, 0).0;
        let lines = out.lines().filter(|line| line.contains("quartz")).collect::<Vec<_>>();
        said += &told(args, 0, &lines.join("\n"));
    }
    let record = fs::read_to_string(place.path("r/run.json")).expect("written");
    let record: Value = serde_json::from_str(&record).expect("JSON");
    let facets = &record["reached"]["case"]["facets"]["quartz"];
    assert_eq!(facets["mode"], "library");
    assert_eq!(facets["warnings"].as_array().map(Vec::len), Some(1), "{facets}");
    for (spectrum, mode) in [
        (json!({"builtin": "quartz_fine"}), "library"),
        (json!({"inverted": {"spectrum": {"builtin": "quartz_fine"}}}), "inverted"),
        (json!({"fresnel": "quartz"}), "fresnel"),
        (json!({"constant": 0.9}), "constant"),
        (
            json!({"mix": [{"share": 0.7, "spectrum": {"builtin": "quartz_fine"}},
                {"share": 0.3, "spectrum": {"constant": 0.95}}]}),
            "mix",
        ),
    ] {
        let scene = scene(&place, PLATE, &json!({"spectrum": spectrum}));
        let out = place.run(&["trace", &scene, "--out", "t.json", "--json"], 0).0;
        let reached: Value = serde_json::from_str(&out).expect("JSON");
        let facets = &reached["facets"]["quartz"];
        assert_eq!(facets["mode"], mode);
        said += &format!("{facets:#}\n");
    }
    assert_snapshot!(said);
}

/// Two facets face each other, so that a path meets several patches.
#[test]
fn a_mixed_facet_is_its_mean_by_area_in_the_scene_and_on_the_command_line() {
    let place = Place::new();
    fs::write(place.path("own.csv"), "8,0.2\n10,0.6\n").expect("written");
    let mix = json!({"mix": [{"share": 0.25, "spectrum": {"file": "own.csv"}},
        {"share": 0.75, "spectrum": {"constant": 0.8}}]});
    let scene = scene(&place, GROOVE, &json!({"spectrum": mix}));
    place.run(&["trace", &scene, "--out", "t.json", "--range", "9-9", "--paths", "20000"], 0);
    let table = Table::read(&place.path("t.json")).expect("a table");
    let mixed = emissivity(&table, &[9.0])[0];
    let mut mean = table.clone();
    mean.materials[0].spectrum = Spectrum::Constant(0.25 * 0.4 + 0.75 * 0.8);
    assert!((emissivity(&mean, &[9.0])[0] - mixed).abs() < 1e-12);
    // A bed of patches is not two beds side by side: paths meet patches of both kinds.
    let [more, less] = [0.8, 0.4].map(|of| {
        mean.materials[0].spectrum = Spectrum::Constant(of);
        emissivity(&mean, &[9.0])[0]
    });
    assert!(mixed > 0.75 * more + 0.25 * less + 1e-4, "{mixed} {more} {less}");
    let given = "quartz=mix:0.25*own.csv+0.75*0.8";
    for (out, options) in [("first.csv", &[][..]), ("again.csv", &["--spectrum", given])] {
        let args = ["signature", "t.json", "--range", "9-9", "--out", out];
        place.run(&[&args[..], options].concat(), 0);
    }
    let [again, first] = ["again.csv", "first.csv"].map(|file| place.read(file));
    assert_eq!(again, first);
}

#[test]
fn what_is_no_mix_is_refused_with_its_place() {
    let place = Place::new();
    let grey = json!({"constant": 0.5});
    let mut said = String::new();
    for mix in [
        json!([]),
        json!([{"share": 0.5, "spectrum": grey}, {"share": 0.4, "spectrum": grey}]),
        json!([{"share": 0, "spectrum": grey}, {"share": 1, "spectrum": grey}]),
        json!([{"share": 1, "spectrum": {"fresnel": "quartz"}}]),
        json!([{"share": 1, "spectrum": {"constant": 1.5}}]),
    ] {
        let scene = scene(&place, PLATE, &json!({"spectrum": {"mix": mix}}));
        said += &place.failed(&["trace", &scene, "--out", "t.json"]);
    }
    for given in ["mix:0.5*0.9", "mix:0.9", "mix:0.5*0.9+0.5*fresnel:quartz", "inverted:mix:1*0.9"]
    {
        said += &place.failed(&["spectra", "show", given]);
    }
    assert_snapshot!(said);
}

/// By the library's own files, of which nothing is in the project.
#[test]
fn shipped_fits_keep_their_distance_to_the_measured_powders() {
    let Some(folder) = tool(Tool::Library) else { return };
    for (name, size) in
        [("quartz_fine", "fine"), ("quartz_medium", "medium"), ("quartz_coarse", "coarse")]
    {
        let shipped = Spectrum::builtin(name).expect("shipped");
        let Spectrum::Builtin(_, form) = &shipped else { panic!("a closed form") };
        for (sample, rms) in
            [("ts-1a", form.parameters.rms), ("ts-1b", form.parameters.rms_other_sample)]
        {
            let file = format!(
                "mineral.silicate.tectosilicate.{size}.tir.{sample}.jpl.nicolet.spectrum.txt"
            );
            let measured = read_one(&folder.join(file), &Reading::default());
            let measured = Spectrum::Tabulated(measured.expect("the library's file"));
            let squares: f64 = (730..=1400)
                .map(|i| f64::from(i) / 100.0)
                .map(|um| {
                    shipped.emissivity(um).expect("held") - measured.emissivity(um).expect("held")
                })
                .map(|error| error * error)
                .sum();
            let found = (squares / 671.0).sqrt();
            assert!(
                (found - rms).abs() < 0.05 * rms + 5e-5,
                "{name} {sample}: {found}, said {rms}"
            );
        }
    }
}
