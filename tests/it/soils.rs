//! Soils by their shares: what they become, what is refused, and what a bed has of them.

use std::path::Path;

use serde_json::{Value, json};
use soilsig::scene::{Scene, SceneGeometry};

use crate::support::{Place, real_blenders};

/// Two minerals, one of them as plates, with two kinds of dust.
fn soil() -> Value {
    json!({
        "seed": 1,
        "grains": 40,
        "components": [
            {"name": "quartz", "material": "quartz", "mass_share": 0.7,
             "size_um": {"range": [500, 700]}, "shape": "subangular",
             "dust": [{"kind": "clay", "cover": 0.2}, {"kind": "silt", "cover": 0.1}]},
            {"name": "gypsum", "material": "gypsum", "mass_share": 0.3, "density_g_cm3": 2.32,
             "size_um": 450, "shape": {"elongation": 0.6, "flatness": 0.4},
             "dust": [{"kind": "silt", "mass_ratio": 0.02}]}
        ],
        "dust": [
            {"name": "clay", "material": "clay", "size_um": 40, "shape": "flake",
             "density_g_cm3": 2.6},
            {"name": "silt", "material": "quartz", "shape": "chip",
             "size_um": {"lognormal": {"median": 60, "sigma": 0.15}}}
        ]
    })
}

fn scene(soil: &Value) -> Value {
    json!({
        "soilsig_scene": 1,
        "name": "sand",
        "seed": 1,
        "temperature_k": 300,
        "view": {"zenith_deg": 0},
        "materials": [
            {"name": "quartz", "spectrum": {"builtin": "quartz_coarse"}},
            {"name": "gypsum", "spectrum": {"constant": 0.9}},
            {"name": "clay", "spectrum": {"constant": 0.95}}
        ],
        "geometry": {"soil": soil}
    })
}

fn parsed(soil: &Value) -> Scene {
    Scene::parse(&scene(soil).to_string(), Path::new("sand.json")).expect("sound")
}

/// The mass of every component by the counts and diameters of the packing alone.
#[test]
fn the_packing_has_the_shares_that_are_stated() {
    let scene = parsed(&soil());
    let SceneGeometry::Packing(packing) = &scene.geometry else { panic!("a packing") };
    let mass = |begin: &str, density: f64| -> f64 {
        let own = packing.grains.iter().filter(|class| class.name.starts_with(begin));
        own.map(|class| density * f64::from(class.count) * class.diameter_um.powi(3)).sum()
    };
    let (quartz, gypsum) = (mass("quartz-", 2.65), mass("gypsum-", 2.32));
    let share = quartz / (quartz + gypsum);
    assert!((share - 0.7).abs() <= 0.01, "{share}");
    let told = scene.soil_shares().expect("a soil");
    assert!((told.components[0].attained - share).abs() < 1e-12);
    assert_eq!(told.grains, packing.grains.iter().map(|class| class.count).sum::<u32>());
    assert!(told.components.iter().all(|c| c.sizes_off() < 0.05), "{told:?}");

    // Dust by mass: its classes together weigh 0.02 of the grain, to the rounding of one fine.
    let plates = packing.grains.iter().find(|class| class.name == "gypsum-450").expect("a class");
    let soilsig::scene::Fines::Count(count) = plates.fines else { panic!("{plates:?}") };
    let silt = packing.fines.iter().filter(|fine| fine.name.starts_with("silt-"));
    let of_one: f64 =
        silt.map(|fine| plates.fine_shares[&fine.name] * fine.diameter_um.powi(3)).sum();
    let wanted = 0.02 * 2.32 * 450.0_f64.powi(3);
    assert!((f64::from(count) * 2.65 * of_one - wanted).abs() <= 2.65 * of_one, "{count}");
    // Classes of a distribution have equal mass: their numbers go by the inverse cube.
    let silt: Vec<_> = packing.fines.iter().filter(|f| f.name.starts_with("silt-")).collect();
    let [a, b] = [silt[0], silt[silt.len() - 1]];
    let numbers = plates.fine_shares[&a.name] / plates.fine_shares[&b.name];
    assert!((numbers / (b.diameter_um / a.diameter_um).powi(3) - 1.0).abs() < 1e-9);
}

#[test]
fn a_soil_by_volume_ignores_densities_and_cover_leaves_the_tray_alone() {
    let mut by_volume = soil();
    for component in by_volume["components"].as_array_mut().expect("a list") {
        component["volume_share"] = component["mass_share"].take();
        component.as_object_mut().expect("keys").remove("mass_share");
    }
    let told = parsed(&by_volume).soil_shares().expect("a soil");
    assert!(told.by_volume);
    by_volume["components"][1]["density_g_cm3"] = json!(9.0);
    assert_eq!(
        parsed(&by_volume).soil_shares().expect("a soil").components[0].sizes,
        told.components[0].sizes
    );

    let trays = [0.05, 0.4, 0.8].map(|cover| {
        let mut soil = soil();
        soil["components"][0]["dust"][0]["cover"] = json!(cover);
        parsed(&soil).soil_shares().expect("a soil").tray_um
    });
    assert!(trays.iter().all(|tray| *tray == trays[0]), "{trays:?}");
}

#[test]
fn the_counts_are_shown_without_blender_and_as_a_scene_of_their_own() {
    let place = Place::new();
    place.write("sand.json", scene(&soil()).to_string());
    let (said, _) = place.run(&["soil", "sand.json"], 0);
    assert!(said.contains(" grains in a tray of "), "{said}");
    assert!(said.contains("gypsum-450"), "{said}");
    assert!(said.contains("quartz: clay is to be 0.2 of its silhouette"), "{said}");
    let told = parsed(&soil()).soil_shares().expect("a soil");
    assert!(said.ends_with(&(told.line() + "\n")), "{said}");

    let (json, _) = place.run(&["soil", "sand.json", "--json"], 0);
    let resolved = Scene::parse(&json, Path::new("packing.json")).expect("a scene file");
    let (SceneGeometry::Packing(one), SceneGeometry::Packing(mut other)) =
        (resolved.geometry, parsed(&soil()).geometry)
    else {
        panic!("packings")
    };
    other.soil = None;
    assert_eq!(one, other);

    let set = "geometry.soil.components.quartz.mass_share=0.6";
    let refused = place.refused(&["soil", "sand.json", "--set", set], 3);
    assert!(refused.contains("the shares make 0.9, not 1"), "{refused}");
    let both = ["soil", "sand.json", "--set", set, "--set"];
    let (changed, _) =
        place.run(&[&both[..], &["geometry.soil.components.gypsum.mass_share=0.4"]].concat(), 0);
    assert!(changed.contains("(asked 60.0"), "{changed}");

    place.write("counts.json", &json);
    let refused = place.refused(&["soil", "counts.json"], 3);
    assert!(refused.contains("it states no soil"), "{refused}");
}

#[test]
fn what_is_wrong_with_a_soil_is_refused_with_its_key_and_the_remedy() {
    let at = |pointer: &str, value: Value| {
        let mut soil = soil();
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        match soil.pointer_mut(parent).expect("it is there") {
            Value::Array(list) => list[key.parse::<usize>().expect("a place")] = value,
            parent => parent[key] = value,
        }
        soil
    };
    let quartz = "/components/0";
    for (pointer, value, words) in [
        ("/mass_share", json!(70), "geometry.soil.components: the shares make 70.3, not 1"),
        ("/mass_share", json!(-0.7), "components[0].mass_share: -0.7 is not above 0"),
        ("/volume_share", json!(0.7), "give all components a mass_share, or all a volume_share"),
        ("/material", json!("mud"), "components[0].material: there is no material \"mud\""),
        ("/name", json!("a b"), "components[0].name: \"a b\" is not 1 to 30"),
        ("/name", json!("clay"), "components: the name \"clay\" appears twice"),
        ("/size_um", json!({"range": [900, 500]}), "size_um.range: 900 um is not below 500"),
        ("/size_um", json!({"range": [20, 2000]}), "components[0].size_um: 400 grains are too few"),
        ("/density_g_cm3", json!(0), "density_g_cm3: 0 is not above 0"),
        ("/density_g_cm3", json!(2650), "density_g_cm3: 2650 is above 25: write g cm-3"),
        ("/dust", json!([{"kind": "loam", "cover": 0.1}]), "no kind of dust \"loam\"; geometry."),
        ("/dust", json!([{"kind": "clay"}]), "dust[0]: give it a cover or a mass_ratio"),
        ("/dust", json!([{"kind": "clay", "cover": 1.2}]), "cover: 1.2 is not within 0 to 1"),
        (
            "/dust",
            json!([{"kind": "clay", "cover": 0.7}, {"kind": "silt", "cover": 0.7}]),
            "the covers make 1.4",
        ),
        (
            "/dust",
            json!([{"kind": "clay", "cover": 0.2}, {"kind": "silt", "mass_ratio": 0.1}]),
            "all dust of a component a cover, or all a mass_ratio",
        ),
        (
            "/dust",
            json!([{"kind": "silt", "mass_ratio": 1e-6}]),
            "less than one fine on a grain: raise its mass_ratio",
        ),
        ("/shape", json!({"elongation": 0.01, "flatness": 1}), "not within 0.1 to 1"),
        ("/shape", json!("pebble"), "a shape is one of flake"),
        ("/counts", json!(3), "unknown field `counts`"),
    ] {
        let soil = at(&format!("{quartz}{pointer}"), value);
        let error = Scene::parse(&scene(&soil).to_string(), Path::new("sand.json"));
        let error = error.expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
        assert!(error.contains("geometry.soil") || error.contains("line"), "{error}");
    }
    for (pointer, value, words) in [
        ("/components", json!([]), "at least one"),
        ("/porosity", json!(40), "geometry.soil.porosity: 40 is not between 0 and 1"),
    ] {
        let refused = Scene::parse(&scene(&at(pointer, value)).to_string(), Path::new("s"));
        assert!(refused.expect_err(words).to_string().contains(words));
    }
}

#[test]
fn a_bed_tells_what_it_has_of_the_soil_beside_what_was_asked() {
    let place = Place::new();
    let mut stated = soil();
    (stated["porosity"], stated["grains"]) = (json!(0.3), json!(72));
    place.write("sand.json", scene(&stated).to_string());
    for blender in real_blenders() {
        let args = ["pipeline", "--scene", "sand.json", "--out", "r", "--tolerance", "0.05"];
        let args = [&args[..], &["--packings", "1", "--range", "9-11", "--step", "1"]].concat();
        let said = place.run_with(&blender, &args);
        let run = place.json("r/run.json");
        let soil = &run["reached"]["sand"]["soil"];
        let number = |value: &Value| value.as_f64().expect("a number");
        let [quartz, gypsum] = [&soil["components"][0], &soil["components"][1]];
        assert!((number(&quartz["attained"]) - 0.7).abs() <= 0.01, "{soil:#}");
        // The total of the silhouette is what the dressing measures; its division among kinds
        // goes by cross-sections.
        let [clay, silt] = [0, 1].map(|i| number(&quartz["dust"][i]["cover"]));
        assert!((clay + silt - 0.3).abs() < 0.01, "{soil:#}");
        assert!((clay - 0.2).abs() < 0.03 && (silt - 0.1).abs() < 0.03, "{soil:#}");
        let ratio = number(&gypsum["dust"][0]["mass_ratio"]);
        assert!((ratio - 0.02).abs() < 0.002, "{soil:#}");
        assert!(said.contains("soil of ") && said.contains("clay is 0."), "{said}");
        assert!(place.read("r/report.html").contains("Soil of "), "the page tells it");
        let drop = place.json("r/drop.json");
        // No poured bed is so dense.
        assert_eq!(soil["asked_porosity"], json!(0.3));
        assert_eq!(soil["porosity"], drop["bed"]["interior_porosity"], "{soil:#}");
        assert!(said.contains("warning: the porosity is 0."), "{said}");
        // Cross-checked with what Blender says of its bodies: volumes with their fines.
        let of = |class: &str| {
            let all = drop["prototypes"].as_array().expect("a list");
            all.iter().find(|p| p["class"] == class).expect("it is there").clone()
        };
        let plate = of("gypsum-450");
        assert!((number(&plate["elongation"]["reached"]) - 0.6).abs() < 0.01, "{plate:#}");
        assert!((number(&plate["flatness"]["reached"]) - 0.4).abs() < 0.01, "{plate:#}");
        let bare = std::f64::consts::PI / 6.0 * 450.0_f64.powi(3);
        let dust = number(&plate["volume_um3"]) / bare - 1.0;
        assert!((dust * 2.65 / 2.32 - 0.02).abs() < 0.002, "{dust}");
        assert_eq!(plate["fines"]["clay-40.0"], json!(0), "{plate:#}");
    }
}
