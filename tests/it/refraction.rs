//! Light through grains, against closed forms, and what is refused.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use insta::assert_snapshot;
use num_complex::Complex64;
use serde_json::{Value, json};
use soilsig::spectrum::optics::{inward, unpolarised_reflectance};
use soilsig::table::Table;

use crate::support::{Place, emissivity, shipped_json, trace_file};

/// Optical constants that are the same at every wavelength.
fn constants(place: &Place, name: &str, index: Complex64) -> Value {
    let Complex64 { re: n, im: k } = index;
    let table = json!({"wavelength_um": [1, 100], "n": [n, n], "k": [k, k]});
    let file = json!({"title": name, "citation": "made up", "range_um": [2, 20],
        "isotropic": {"table": table}});
    place.write(&format!("{name}.json"), file.to_string());
    json!({"refractive": {"file": format!("{name}.json")}})
}

/// A closed box as an object of an .obj file, whose vertices are counted from `first`.
fn cuboid(first: usize, material: &str, [min, max]: [[f64; 3]; 2]) -> String {
    let mut obj = format!("o {material}_{first}\n");
    for i in 0..8 {
        let at = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        obj += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    obj += &format!("usemtl {material}\n");
    for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    {
        obj += &format!("f {}\n", face.map(|i: usize| (i + first).to_string()).join(" "));
    }
    obj
}

/// A slab from one height to another, wider than the domain.
fn slab(first: usize, material: &str, from: f64, to: f64) -> String {
    cuboid(first, material, [[-50.0, -50.0, from], [150.0, 150.0, to]])
}

struct Case {
    materials: Vec<(&'static str, Value)>,
    obj: String,
    zenith_deg: f64,
    floor: Option<f64>,
    sides: Value,
}

impl Case {
    fn new(obj: String, materials: Vec<(&'static str, Value)>) -> Self {
        Self { materials, obj, zenith_deg: 0.0, floor: None, sides: "mirror".into() }
    }

    fn write(&self, place: &Place) -> String {
        place.write("mesh.obj", &self.obj);
        let mut materials: Vec<Value> = self
            .materials
            .iter()
            .map(|(name, spectrum)| json!({"name": name, "spectrum": spectrum}))
            .collect();
        let mut domain = json!({"min_um": [0, 0], "max_um": [100, 100], "sides": self.sides});
        if let Some(floor) = self.floor {
            materials.push(json!({"name": "floor", "spectrum": {"constant": floor}}));
            domain["floor"] = json!({"z_um": -10, "material": "floor"});
        }
        let scene = json!({
            "soilsig_scene": 1, "name": "case", "seed": 1, "temperature_k": 300,
            "view": {"zenith_deg": self.zenith_deg}, "materials": materials,
            "geometry": {"placed": {"prototypes": [{"name": "mesh", "file": "mesh.obj"}],
                "domain": domain}}
        });
        place.write("scene.json", scene.to_string());
        "scene.json".into()
    }

    fn trace(&self, place: &Place, tolerance: f64) -> Table {
        trace_file(&place.path(self.write(place)), 1, tolerance)
    }
}

/// What a slab reflects and lets through of light at 9 um, with all reflections within it. Every hit
/// takes light as unpolarised.
fn of_slab(index: Complex64, thickness_um: f64, zenith_deg: f64) -> [f64; 2] {
    let cosine = zenith_deg.to_radians().cos();
    let r = unpolarised_reflectance(index * index, cosine);
    let within = inward(index * index, cosine).cosine;
    let t = (-4.0 * PI * index.im * thickness_um / 9.0 / within).exp();
    let through = (1.0 - r) * (1.0 - r) * t / (1.0 - r * r * t * t);
    [r + through * r * t, through]
}

#[test]
fn a_slab_reflects_and_absorbs_as_the_fresnel_slab() {
    for (n, k, zenith_deg) in [
        (1.5, 0.004, 0.0),
        (1.5, 0.004, 50.0),
        (3.0, 0.002, 30.0),
        (0.6, 0.01, 20.0),
        (0.3, 2.0, 0.0),
    ] {
        let place = Place::new();
        let index = Complex64::new(n, k);
        let stone = constants(&place, "stone", index);
        let mut case = Case::new(slab(1, "stone", 0.0, 100.0), vec![("stone", stone)]);
        case.zenith_deg = zenith_deg;
        let [reflected, through] = of_slab(index, 100.0, zenith_deg);
        // Without a floor what goes through leaves downward; a black floor keeps it.
        for (floor, expected) in [(None, 1.0 - reflected - through), (Some(1.0), 1.0 - reflected)] {
            case.floor = floor;
            let (found, error) = emissivity(&case.trace(&place, 0.002));
            assert!(
                (found - expected).abs() < 4.0 * error + 2e-4,
                "{index} {zenith_deg} {floor:?}: {found} +- {error}, {expected}"
            );
        }
    }
}

#[test]
fn solids_of_one_medium_join_and_another_medium_of_the_same_index_is_not_seen() {
    let place = Place::new();
    let index = Complex64::new(1.8, 0.003);
    let [one, other] = ["one", "other"].map(|name| constants(&place, name, index));
    let expected = 1.0 - of_slab(index, 100.0, 0.0)[0];
    let materials = || vec![("one", one.clone()), ("other", other.clone())];
    for (name, obj) in [
        ("overlap", slab(1, "one", 0.0, 60.0) + &slab(9, "one", 40.0, 100.0)),
        ("within", slab(1, "one", 0.0, 100.0) + &cuboid(9, "one", [[20.0; 3], [80.0; 3]])),
        ("two media", slab(1, "one", 0.0, 60.0) + &slab(9, "other", 40.0, 100.0)),
        ("one within", slab(1, "one", 0.0, 100.0) + &cuboid(9, "other", [[20.0; 3], [80.0; 3]])),
        ("around it", slab(1, "other", 0.0, 100.0) + &cuboid(9, "one", [[20.0; 3], [80.0; 3]])),
    ] {
        let case = Case { floor: Some(1.0), ..Case::new(obj, materials()) };
        let table = case.trace(&place, 0.002);
        let (found, error) = emissivity(&table);
        assert!(table.inside.is_empty() && table.histogram.paths_given_up() < 1e-9, "{name}");
        assert!((found - expected).abs() < 4.0 * error + 2e-4, "{name}: {found}, {expected}");
    }
}

#[test]
fn rays_of_a_uniaxial_crystal_are_drawn_two_to_one() {
    let place = Place::new();
    let table =
        |n: f64, k: f64| json!({"table": {"wavelength_um": [1, 100], "n": [n, n], "k": [k, k]}});
    let file = json!({"title": "crystal", "citation": "made up", "range_um": [2, 20],
        "ordinary": table(2.5, 0.0), "extraordinary": table(1.2, 0.02)});
    place.write("crystal.json", file.to_string());
    let crystal = json!({"refractive": {"file": "crystal.json"}});
    let case = Case::new(slab(1, "stone", 0.0, 100.0), vec![("stone", crystal)]);
    let of = |n, k| {
        let [reflected, through] = of_slab(Complex64::new(n, k), 100.0, 0.0);
        1.0 - reflected - through
    };
    let (found, error) = emissivity(&case.trace(&place, 0.002));
    let expected = (2.0 * of(2.5, 0.0) + of(1.2, 0.02)) / 3.0;
    assert!((found - expected).abs() < 4.0 * error + 2e-4, "{found} +- {error}, {expected}");
}

/// A ball of 96 by 192 facets.
fn ball(radius: f64) -> String {
    let (rings, parts) = (96, 192);
    let mut obj = "o ball\n".to_owned();
    for ring in 0..=rings {
        let (sine, cosine) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
        for part in 0..parts {
            let (y, x) = (2.0 * PI * f64::from(part) / f64::from(parts)).sin_cos();
            // The poles are single points.
            let sine = if ring == 0 || ring == rings { 0.0 } else { sine };
            let at = [sine * x, sine * y, cosine].map(|c| 50.0 + radius * c);
            obj += &format!("v {} {} {}\n", at[0], at[1], at[2]);
        }
    }
    obj += "usemtl stone\n";
    for ring in 0..rings {
        for part in 0..parts {
            let at = |ring: i32, part: i32| 1 + ring * parts + part % parts;
            let [a, b, c, d] =
                [at(ring, part), at(ring + 1, part), at(ring + 1, part + 1), at(ring, part + 1)];
            obj += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    obj
}

/// Every hit within a ball has the angle of the first, so that the absorbed share is
/// (1 - R) (1 - t) / (1 - R t), with t the transmittance of a chord.
#[test]
fn a_ball_absorbs_as_all_orders_of_its_inner_reflections() {
    for (n, k) in [(1.5, 0.01), (2.5, 0.02), (0.7, 0.02)] {
        let place = Place::new();
        let index = Complex64::new(n, k);
        let case = Case {
            sides: "open".into(),
            ..Case::new(ball(49.0), vec![("stone", constants(&place, "stone", index))])
        };
        let absorbed = |cosine: f64| {
            let r = unpolarised_reflectance(index * index, cosine);
            let chord_um = 2.0 * 49.0 * inward(index * index, cosine).cosine;
            let t = (-4.0 * PI * k * chord_um / 9.0).exp();
            2.0 * cosine * (1.0 - r) * (1.0 - t) / (1.0 - r * t)
        };
        let steps = 4000;
        let middle = |i: i32| (f64::from(i) + 0.5) / f64::from(steps);
        let expected = (0..steps).map(|i| absorbed(middle(i))).sum::<f64>() / f64::from(steps);
        let (found, error) = emissivity(&case.trace(&place, 0.002));
        // Facets of 1.9 degrees turn a ray at each hit, so that its angles are not quite the same.
        assert!((found - expected).abs() < 4.0 * error + 0.004, "{n} {k}: {found}, {expected}");
    }
}

/// The shipped settled patch, all of one medium, over a floor.
fn patch(place: &Place, grains: &Value, floor: f64) -> Table {
    let mut scene = shipped_json("settled_patch.json");
    for material in scene["materials"].as_array_mut().expect("materials") {
        material["spectrum"] = grains.clone();
    }
    scene["materials"][2]["spectrum"] = json!({"constant": floor});
    place.write("patch.json", scene.to_string());
    trace_file(&place.path("patch.json"), 1, 0.004)
}

#[test]
fn a_bed_without_absorption_over_a_white_floor_reflects_all() {
    for n in [0.5, 1.5, 3.0] {
        let place = Place::new();
        let table = patch(&place, &constants(&place, "clear", Complex64::new(n, 0.0)), 0.0);
        let weight = table.weight(&table.reflectances(&[9.0]).expect("in range")[0]);
        let (reflected, open) = (weight.mean, weight.trapped);
        // What was given up is told, and the rest is reflected.
        assert!(open < 0.01, "{n}: {open}");
        assert!(
            (reflected + open - 1.0).abs() < 0.001 + 3.0 * weight.standard_error,
            "{n}: {weight:?}"
        );
    }
}

#[test]
fn grains_of_index_one_are_not_there() {
    let place = Place::new();
    let table = patch(&place, &constants(&place, "nothing", Complex64::new(1.0, 0.0)), 0.3);
    let (found, _) = emissivity(&table);
    assert!((found - 0.3).abs() < 1e-6 && table.histogram.paths_given_up() == 0.0, "{found}");
    // The floor's spectrum can be exchanged: the weights leave it out.
    let mut other = table;
    other.materials[2].spectrum = soilsig::Spectrum::Constant(0.8);
    assert!((emissivity(&other).0 - 0.8).abs() < 1e-6);
}

#[test]
fn opaque_grains_are_the_mirrors_of_fresnel_facets() {
    let place = Place::new();
    let refractive = constants(&place, "opaque", Complex64::new(0.4, 2.5));
    let through = patch(&place, &refractive, 0.9);
    let mirrors = patch(&place, &json!({"fresnel": {"file": "opaque.json"}}), 0.9);
    let ((a, error_a), (b, error_b)) = (emissivity(&through), emissivity(&mirrors));
    assert!((a - b).abs() < 4.0 * error_a.hypot(error_b) + 0.002, "{a} {b}");
    assert!(mirrors.nodes.is_none() && through.nodes.is_some());
}

#[test]
fn a_run_with_refraction_takes_few_wavelengths_and_marks_where_rays_do_not_hold() {
    let place = Place::new();
    let case = blocks(json!({"refractive": "quartz_zeidler"}));
    let scene = case.write(&place);
    let args =
        ["pipeline", "--scene", &scene, "--out", "r", "--step", "0.05", "--tolerance", "0.01"];
    let (out, _) = place.run(&args, 0);
    assert!(!out.contains("bin of cosines"), "paths of nodes have no bins: {out}");
    let table = Table::read(&place.path("r/table.json")).expect("a table");
    let nodes = table.nodes.as_ref().expect("it refracts").wavelength_um.len();
    assert!(nodes > 20 && nodes < 131, "{nodes}");
    let csv = place.read("r/signature.csv");
    let valid = |um: &str| {
        let row = csv.lines().find(|line| line.starts_with(&format!("{um},"))).expect("a row");
        row.ends_with(",1")
    };
    // The mean chord is 27 um: three wavelengths.
    assert!(!valid("8.5") && !valid("9") && valid("7.5") && valid("11"));
    // The same bytes from a table that was read.
    place.run(&["signature", "r/table.json", "--step", "0.05", "--out", "s.csv"], 0);
    assert_eq!(place.read("s.csv"), csv);
    let budget = place.read("r/budget.csv");
    assert!(budget.lines().next().expect("headings").contains("spectral_step"));
}

/// Chords of a ball are D mu with the density 2 mu of their cosines.
#[test]
fn diffuse_light_goes_through_a_ball_as_by_all_of_its_chords() {
    let crystal = soilsig::spectrum::crystal("quartz_zeidler").expect("shipped");
    for (um, chord_um) in [(9.0, 30.0), (11.0, 30.0), (11.0, 300.0), (7.4, 0.01)] {
        let steps = 20_000;
        let middle = |i: i32| (f64::from(i) + 0.5) / f64::from(steps);
        let of = |mu: f64| 2.0 * mu * crystal.transmittance(um, 1.5 * chord_um * mu);
        let exact = (0..steps).map(|i| of(middle(i))).sum::<f64>() / f64::from(steps);
        let found = crystal.diffuse_transmittance(um, chord_um);
        assert!((found - exact).abs() < 1e-5 + 1e-3 * exact, "{um} {chord_um}: {found} {exact}");
    }
}

/// Four blocks of 40 um side by side on a grey floor.
fn blocks(spectrum: Value) -> Case {
    let bed = (0..4).map(|i| {
        let low = [f64::from(i % 2) * 50.0 + 5.0, f64::from(i / 2) * 50.0 + 5.0, 0.0];
        cuboid(1 + 8 * i as usize, "stone", [low, low.map(|x| x + 40.0)])
    });
    Case { floor: Some(0.9), ..Case::new(bed.collect(), vec![("stone", spectrum)]) }
}

/// The columns of a signature or a budget, by heading.
fn columns(csv: &str) -> BTreeMap<String, Vec<f64>> {
    let mut rows = csv.lines().map(|line| line.split(','));
    let headings = rows.next().expect("headings").map(str::to_owned);
    let mut columns: Vec<(String, Vec<f64>)> = headings.map(|heading| (heading, vec![])).collect();
    for row in rows {
        for ((_, column), field) in columns.iter_mut().zip(row) {
            column.push(field.parse().unwrap_or(f64::NAN));
        }
    }
    columns.into_iter().collect()
}

#[test]
fn auto_facets_of_opaque_grains_are_fresnel_ones_byte_for_byte() {
    let place = Place::new();
    constants(&place, "opaque", Complex64::new(0.4, 2.5));
    let [fresnel, auto] = ["fresnel", "auto"].map(|kind| {
        let scene = blocks(json!({kind: {"file": "opaque.json"}})).write(&place);
        let table = format!("{kind}.json");
        let csv = format!("{kind}.csv");
        place.run(&["trace", &scene, "--out", &table, "--tolerance", "0.01"], 0);
        place.run(&["signature", &table, "--out", &csv], 0);
        let table = Table::read(&place.path(table)).expect("a table");
        (table, place.read(&csv))
    });
    assert!(auto.0.nodes.is_none() && auto.0.histogram == fresnel.0.histogram);
    let small = ["--pixels", "2x2", "--range", "9-9", "--noise", "0.1"];
    let scene = blocks(json!({"auto": {"file": "opaque.json"}})).write(&place);
    place.run(&[&["image", &scene, "--out", "i"][..], &small].concat(), 0);
    let scene = blocks(json!({"auto": "quartz_zeidler"})).write(&place);
    let said = place.failed(&["image", &scene, "--out", "j", "--range", "11-11"]);
    assert!(said.contains("images of scenes with refractive facets"), "{said}");
    let of = |csv: &str, without: &[&str]| -> Vec<String> {
        let headings: Vec<&str> = csv.lines().next().expect("headings").split(',').collect();
        let keeps = |line: &str| {
            let cells = line.split(',').zip(&headings).filter(|(_, of)| !without.contains(of));
            cells.map(|(cell, _)| cell).collect::<Vec<_>>().join(",")
        };
        csv.lines().map(keeps).collect()
    };
    // What the decision leaves open is in the total. `fresnel` facets ask for opaque grains of ten
    // wavelengths, and so do `auto` ones.
    let total = "emissivity_total_half_width_95";
    assert_eq!(of(&auto.1, &[total, "refracted"]), of(&fresnel.1, &[total]));
    let (a, b) = (columns(&auto.1), columns(&fresnel.1));
    assert!(a["refracted"].iter().all(|share| *share == 0.0));
    for (wide, narrow) in a[total].iter().zip(&b[total]) {
        assert!(wide > narrow && wide - narrow < 0.002, "{wide} {narrow}");
    }
}

#[test]
fn auto_facets_refract_where_grains_let_light_through_and_the_budget_holds_the_difference() {
    let place = Place::new();
    let [refractive, auto] = ["refractive", "auto"].map(|kind| {
        let scene = blocks(json!({kind: "quartz_zeidler"})).write(&place);
        let bands = ["--range", "7.5-12", "--step", "0.1", "--tolerance", "0.02"];
        let out = format!("{kind}_run");
        place.run(&[&["pipeline", "--scene", &scene, "--out", &out][..], &bands].concat(), 0);
        let table = Table::read(&place.path(format!("{out}/table.json"))).expect("a table");
        let [signature, budget] =
            ["signature", "budget"].map(|name| columns(&place.read(format!("{out}/{name}.csv"))));
        (table, signature, budget)
    });
    let (table, signature, budget) = &auto;
    let opaque = &table.nodes.as_ref().expect("it refracts in some bands").opaque;
    assert!(opaque.contains(&true) && opaque.contains(&false));
    let um = &signature["wavelength_um"];
    let at = |wanted: f64| um.iter().position(|um| (um - wanted).abs() < 1e-9).expect("a band");
    let refracted = &signature["refracted"];
    assert!(refracted[at(9.0)] == 0.0 && refracted[at(11.0)] == 1.0 && refracted[at(7.5)] == 1.0);
    assert!(!refractive.1.contains_key("refracted"));
    // The decision leaves open a fifth of the tolerance at most, and nothing where light is followed.
    let open = |i: usize| budget["given_up"][i] - refractive.2["given_up"][i];
    assert!(open(at(9.0)) > 0.0 && open(at(9.0)) <= 0.004 && open(at(11.0)).abs() < 1e-6);
    for i in 0..um.len() {
        let e = |of: &BTreeMap<String, Vec<f64>>| {
            (of["emissivity"][i], of["emissivity_total_half_width_95"][i])
        };
        let ((a, total_a), (b, total_b)) = (e(signature), e(&refractive.1));
        assert!((a - b).abs() < total_a + total_b, "{} um: {a} {b}", um[i]);
    }
}

#[test]
fn what_cannot_be_traced_with_refraction_is_refused() {
    let place = Place::new();
    let quartz = json!({"refractive": "quartz"});
    let stone = |obj: String| Case::new(obj, vec![("stone", quartz.clone())]);
    let block = || slab(1, "stone", 0.0, 100.0);
    let mut said = String::new();
    let mut refuse = |case: &Case, change: &dyn Fn(&mut Value)| {
        let scene = case.write(&place);
        let mut json: Value = place.json(&scene);
        change(&mut json);
        place.write(&scene, json.to_string());
        said += &place.failed(&["trace", &scene, "--out", "t.json", "--range", "9-9"]);
    };
    let sheet = "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nusemtl stone\nf 1 2 3 4\n";
    refuse(&stone(sheet.into()), &|_| ());
    refuse(&Case { sides: "periodic".into(), ..stone(block()) }, &|_| ());
    refuse(&Case { floor: Some(0.5), ..stone(block()) }, &|json| {
        json["materials"][1]["spectrum"] = quartz.clone();
    });
    refuse(&stone(block()), &|json| json["sky_temperature_k"] = json!([[0, 200], [90, 280]]));
    refuse(&stone(block()), &|json| {
        json["materials"][0]["spectrum"] = json!({"refractive": "basalt"});
    });
    for (name, axes) in [
        ("none", json!({})),
        (
            "gain",
            json!({"isotropic": {"eps_inf": 2, "oscillators":
            [{"v0_per_cm": 1100, "strength": -0.5, "damping": 0.01}]}}),
        ),
        (
            "short",
            json!({"isotropic": {"table": {"wavelength_um": [8, 9], "n": [1, 1], "k": [0, 0]}}}),
        ),
    ] {
        let mut file = json!({"title": name, "citation": "made up", "range_um": [7, 14]});
        for (key, axis) in axes.as_object().expect("axes") {
            file[key] = axis.clone();
        }
        place.write("own.json", file.to_string());
        refuse(&stone(block()), &|json| {
            json["materials"][0]["spectrum"] = json!({"refractive": {"file": "own.json"}});
        });
    }
    let scene = stone(block()).write(&place);
    place.run(&["trace", &scene, "--out", "t.json", "--range", "9-9"], 0);
    said += &place.failed(&["signature", "t.json", "--range", "9-9", "--spectrum", "stone=0.5"]);
    said += &place.failed(&["signature", "t.json", "--range", "10-10"]);
    assert_snapshot!(said);
}
