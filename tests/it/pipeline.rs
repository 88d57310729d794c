//! The whole way, with real Blenders.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use soilsig::scene::Scene;

use crate::support::{
    HOME, Place, SmallBed, Tool, a_blender, real_blenders, shipped, tool, trace_file, with_script,
};

/// A signature's columns, by heading.
fn columns(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).expect("a CSV file");
    let headings: Vec<String> =
        reader.headers().expect("headings").iter().map(str::to_owned).collect();
    let mut columns: BTreeMap<String, Vec<f64>> =
        headings.iter().map(|heading| (heading.clone(), Vec::new())).collect();
    for row in reader.records() {
        for (heading, field) in headings.iter().zip(row.expect("a row").iter()) {
            // Of a single packing the spread is not known.
            let value = if field.is_empty() { f64::NAN } else { field.parse().expect("a number") };
            columns.get_mut(heading).expect("known").push(value);
        }
    }
    columns
}

struct Curve {
    um: Vec<f64>,
    emissivity: Vec<f64>,
    error: Vec<f64>,
}

impl Curve {
    fn read(path: &Path) -> Self {
        let mut columns = columns(path);
        let mut take = |heading: &str| columns.remove(heading).expect("the column");
        Self {
            um: take("wavelength_um"),
            emissivity: take("emissivity"),
            error: take("emissivity_standard_error"),
        }
    }

    /// Mean level of a window, and the mean of the standard errors in it: bands share their paths,
    /// so that the mean is no surer than a band.
    fn level(&self, from: f64, to: f64) -> (f64, f64) {
        let inside: Vec<usize> =
            (0..self.um.len()).filter(|&i| self.um[i] >= from && self.um[i] <= to).collect();
        let mean =
            |values: &[f64]| inside.iter().map(|&i| values[i]).sum::<f64>() / inside.len() as f64;
        (mean(&self.emissivity), mean(&self.error))
    }

    fn extreme(&self, from: f64, to: f64, sign: f64) -> usize {
        (0..self.um.len())
            .filter(|&i| self.um[i] >= from && self.um[i] <= to)
            .max_by(|&i, &j| (sign * self.emissivity[i]).total_cmp(&(sign * self.emissivity[j])))
            .expect("bands in the window")
    }

    /// Peak less the mean of the two troughs, and its standard error at most.
    fn contrast(&self) -> (f64, f64) {
        let at = [
            self.extreme(8.0, 8.62, -1.0),
            self.extreme(8.55, 8.7, 1.0),
            self.extreme(8.65, 9.5, -1.0),
        ];
        let [a, peak, b] = at.map(|i| self.emissivity[i]);
        let [ea, ep, eb] = at.map(|i| self.error[i]);
        (peak - f64::midpoint(a, b), ep + f64::midpoint(ea, eb))
    }
}

/// That the values fall from each to the next by more than three of their standard errors.
fn assert_falling(what: &str, values: &[(f64, f64)]) {
    for pair in values.windows(2) {
        let error = pair[0].1.hypot(pair[1].1);
        assert!(pair[0].0 - pair[1].0 > 3.0 * error, "{what}: {values:?}");
    }
}

/// The signs that the paper's Fig. 6 shows, from beds that Blender has just made. One packing of
/// each coverage: the error bars are those of the rays, set small, and the signs hold beyond them.
#[test]
fn four_coverages_show_the_signs_of_the_paper() {
    let place = Place::with_shared_cache();
    let Some(blender) = a_blender() else { return };
    let args =
        ["pipeline", "--coverage", "all", "--range", "7.3-14", "--tolerance", "0.0015", "--json"];
    let record = place.run_with(&blender, &[&args[..], &["--packings", "1"]].concat());
    let record: Value = serde_json::from_str(&record).expect("the record");
    let out = place.path("out/all");
    let curves: Vec<Curve> = ["full", "less", "sparse", "bare"]
        .iter()
        .map(|coverage| Curve::read(&out.join(coverage).join("signature.csv")))
        .collect();
    let levels =
        |from, to| -> Vec<(f64, f64)> { curves.iter().map(|c| c.level(from, to)).collect() };
    assert_falling("level in 8-9.5 um", &levels(8.0, 9.5));
    let turned = |values: &[(f64, f64)]| values.iter().rev().copied().collect::<Vec<_>>();
    let contrasts: Vec<_> = curves.iter().map(Curve::contrast).collect();
    assert_falling("contrast, turned round", &turned(&contrasts));
    assert_falling("level in 10-12 um, turned round", &turned(&levels(10.0, 12.0)));
    for curve in &curves {
        let top = curve.extreme(7.3, 14.0, 1.0);
        assert!(curve.um[top] <= 7.5 && curve.emissivity[top] > 0.99, "{} um", curve.um[top]);
    }
    // Troughs move outward as fines rule.
    let bare = &curves[3];
    assert!(
        curves[0].um[curves[0].extreme(8.0, 8.62, -1.0)] < bare.um[bare.extreme(8.0, 8.62, -1.0)]
    );
    for file in
        ["signatures.svg", "signatures.png", "run.json", "bare/scene.blend", "full/scene.glb"]
    {
        assert!(out.join(file).is_file(), "{file}");
    }
    assert_eq!(record["reached"].as_object().expect("scenes").len(), 4);
    for (name, reached) in record["reached"].as_object().expect("scenes") {
        assert!(reached["inside"].as_f64().expect("a share") < 1e-3, "{name}: {reached}");
        assert!(reached["floor_effect"].as_f64().expect("an effect") < 0.005, "{name}: {reached}");
    }
}

/// Every stage of a run that could be found in the cache, by name.
fn cached(record: &Value) -> BTreeMap<&str, bool> {
    let stages = record["stages"].as_array().expect("stages").iter();
    stages
        .map(|stage| (stage["name"].as_str().expect("a name"), stage["cached"] == true))
        .filter(|(name, _)| *name != "signature")
        .collect()
}

#[test]
fn a_second_run_does_not_start_blender() {
    for blender in real_blenders() {
        let bed = SmallBed::of(&blender);
        let [first, second] = &bed.records;
        assert!(cached(first).values().all(|cached| !cached));
        assert!(cached(second).values().all(|cached| *cached));
        assert_eq!(fs::read(bed.place.path("r/blender.log")).expect("still there"), bed.log);
        // Other bands are traced for anew, on the bed that is there.
        let scene = shipped("small.json");
        let run = |more: &[&str]| -> Value {
            let args = ["pipeline", "--scene", &scene, "--out", "other", "--json", "--patch-obj"];
            serde_json::from_str(&bed.place.run_with(&bed.blender, &[&args, more].concat()))
                .expect("the record")
        };
        let other = run(&["--range", "8-9"]);
        assert_eq!((cached(&other)["drop"], cached(&other)["trace"]), (true, false));
        assert_eq!(fs::read(bed.place.path("other/blender.log")).expect("copied"), bed.log);
        let other = run(&["--seed", "2", "--range", "8-9"]);
        assert!(!cached(&other)["drop"], "another seed is another bed");
    }
}

/// Blender makes empty folders there, as `.cache` and `.config/blender`.
#[test]
fn no_file_is_left_in_the_users_home() {
    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("read"));
        let below = |path: PathBuf| if path.is_dir() { files(&path) } else { vec![path] };
        entries.flat_map(|entry| below(entry.path())).collect()
    }
    for blender in real_blenders() {
        let bed = SmallBed::of(&blender);
        assert_eq!(files(&bed.place.path(HOME)), [""; 0].map(PathBuf::from));
    }
}

/// Of a Python with bpy it is asked which interpreter it is: that one is started then.
#[test]
fn not_even_its_version_is_asked_for_a_second_time() {
    let Some(blender) = tool(Tool::Blender) else { return };
    let [first, second] = SmallBed::of(&blender).starts;
    assert_eq!(first, 2, "once to ask what it is, once to drop");
    assert_eq!(second, 2);
}

#[test]
fn the_same_seed_gives_the_same_bytes_of_every_file() {
    for blender in real_blenders() {
        let bed = SmallBed::of(&blender);
        for file in
            ["prototypes.obj", "patch.obj", "scene.json", "scene.glb", "scene.blend", "blender.log"]
        {
            assert!(bed.place.path("r").join(file).is_file(), "{file}");
        }
        // Replay fails with a status of its own if any byte differs.
        let said = bed.place.run_with(&bed.blender, &["replay", "r/run.json"]);
        for file in ["prototypes.obj", "scene.glb", "table.json", "signature.png"] {
            assert!(said.contains(file), "{said}");
        }
        // Blender's own file holds addresses in memory: it is made again, and not compared.
        assert!(said.contains("scene.blend: "), "{said}");
        assert!(!said.contains("scene.blend: missing"), "{said}");
    }
}

#[test]
fn the_bed_is_what_the_recipe_asks_for() {
    for blender in real_blenders() {
        let bed = SmallBed::of(&blender);
        let report = bed.place.json("r/drop.json");
        let sphere = |diameter_um: f64| std::f64::consts::FRAC_PI_6 * diameter_um.powi(3);
        let prototypes = report["prototypes"].as_array().expect("prototypes");
        for (prototype, (diameter_um, fines)) in
            prototypes.iter().zip([(500.0, 150), (640.0, 180), (853.0, 220)])
        {
            // The grain and its fines, each of the volume of its sphere.
            let volume_um3 = prototype["volume_um3"].as_f64().expect("a volume");
            let asked_um3 = sphere(diameter_um) + f64::from(fines) * sphere(60.0);
            assert!((volume_um3 / asked_um3 - 1.0).abs() < 1e-9, "{prototype}");
            assert_eq!(prototype["fines"]["fine_60"], fines, "{prototype}");
        }
        assert_eq!(report["settle"]["settled"], true);
        let scene = bed.place.json("r/scene.json");
        let instances = scene["geometry"]["placed"]["instances"].as_array().expect("instances");
        assert_eq!(instances.len(), 18);
    }
}

/// Blender's own reader finds the bed of the .obj with its instances in the .glb.
fn assert_blender_opens_the_bed(blender: &Path, out: &Path) {
    let mut command = with_script(blender, "tests/readers/open_glb.py");
    let output = command.arg("--").arg(out.join("scene.glb")).output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout);
    let found = said.lines().find_map(|line| line.strip_prefix("OPENED "));
    let found: Value =
        serde_json::from_str(found.unwrap_or_else(|| panic!("{said}"))).expect("JSON");

    let path = out.join("scene.json");
    let scene = Scene::read(&path).expect("it is sound");
    let tracer = soilsig::tracer::trace::tracer(&scene).expect("its meshes are");
    let bed = tracer.bed();
    assert_eq!(found["triangles"], bed.triangles());
    assert_eq!(found["materials"], serde_json::json!(["coarse", "fine"]));
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in &bed.placements {
        for vertex in &bed.meshes[place.mesh].vertices {
            let point = place.to_scene.transform_point3(vertex.as_dvec3()).to_array();
            for axis in 0..3 {
                min[axis] = min[axis].min(point[axis]);
                max[axis] = max[axis].max(point[axis]);
            }
        }
    }
    for (key, ours) in [("min_um", min), ("max_um", max)] {
        for axis in 0..3 {
            let theirs = found[key][axis].as_f64().expect("a number");
            // Single precision of metres, two to three millimetres from the origin.
            assert!((theirs - ours[axis]).abs() < 0.01, "{key}: {} and {ours:?}", found[key]);
        }
    }
}

/// The .glb is the same bed as the .obj with its instances: the same curve, by other files.
#[test]
fn the_glb_gives_the_signature_of_the_obj() {
    for blender in real_blenders() {
        let bed = SmallBed::of(&blender);
        let out = bed.place.path("r");
        assert_blender_opens_the_bed(&blender, &out);
        let mut scene = bed.place.json("r/scene.json");
        let placed = scene["geometry"]["placed"].as_object_mut().expect("placed");
        placed.remove("instances");
        placed["prototypes"] = serde_json::json!([{"name": "bed", "file": out.join("scene.glb")}]);
        let place = Place::new();
        place.write("glb.json", scene.to_string());
        let (path, other) = (out.join("scene.json"), place.path("glb.json"));
        let [obj, glb] = [(path, 1), (other, 2)].map(|(path, seed)| trace_file(&path, seed, 0.001));
        for rho in [[0.1, 0.4, 0.1], [0.6, 0.6, 0.6]] {
            let (a, b) = (obj.weight(&rho), glb.weight(&rho));
            let error = a.standard_error.hypot(b.standard_error);
            assert!((a.mean - b.mean).abs() < 3.0 * error, "{} and {} +- {error}", a.mean, b.mean);
        }
    }
}

#[test]
fn any_number_of_size_classes_and_minerals_goes_through() {
    let place = Place::new();
    let Some(blender) = a_blender() else { return };
    let scene = r#"{
      "soilsig_scene": 1, "name": "mixture", "seed": 3, "temperature_k": 310, "sky_temperature_k": 250,
      "view": {"zenith_deg": 30, "azimuth_deg": 45},
      "materials": [{"name": "olivine", "spectrum": {"inverted": {"spectrum": {"constant": 0.9}, "pure_bed": ["pure.json"]}}}, {"name": "quartz", "spectrum": {"file": "q.csv"}},
                    {"name": "clay", "spectrum": {"file": "c.sli"}}, {"name": "floor", "spectrum": {"constant": 0.9}}],
      "geometry": {"packing": {"seed": 3,
        "grains": [{"name": "big", "shape": "worn", "diameter_um": 700, "material": "olivine", "count": 4, "fines": 40},
                   {"name": "middle", "shape": "angular", "diameter_um": 420, "material": "quartz", "count": 8, "fines": 0},
                   {"name": "little", "shape": "chip", "diameter_um": 250, "material": "clay", "count": 12, "fines": 10}],
        "fines": [{"name": "dust", "shape": "flake", "diameter_um": 50, "material": "clay", "share": 0.5},
                  {"name": "grit", "shape": "chip", "diameter_um": 70, "material": "quartz", "share": 0.5}],
        "variants": 2, "tray_um": [1700, 1700], "crop_um": 300, "floor_material": "floor"}}}"#;
    place.write("mixture.json", scene);
    place.write("q.csv", "um,emissivity\n8,0.5\n12,0.9\n");
    // Of a library in two files both belong to the spectrum.
    place.write("c.csv", "8,0.97\n12,0.96\n");
    place.run_with(&blender, &["spectra", "convert", "c.csv", "--out", "c.sli"]);
    // Any bed of one material takes a powder apart; here it is a groove.
    let groove = "v 0 0 0\nv 0 9 0\nv 9 0 9\nv 9 9 9\nv -9 0 9\nv -9 9 9\nf 1 3 4 2\nf 1 2 6 5\n";
    place.write("groove.obj", groove);
    let pure = r#"{"soilsig_scene": 1, "name": "pure", "seed": 1, "temperature_k": 300, "view": {"zenith_deg": 0},
      "materials": [{"name": "m", "spectrum": {"constant": 0.1}}],
      "geometry": {"placed": {"prototypes": [{"name": "groove", "file": "groove.obj", "material": "m"}]}}}"#;
    place.write("pure_scene.json", pure);
    place.run_with(&blender, &["trace", "pure_scene.json", "-o", "pure.json"]);
    let args = ["pipeline", "--scene", "mixture.json", "--out", "r", "--range", "8-12", "--json"];
    let record = place.run_with(&blender, &args);
    let record: Value = serde_json::from_str(&record).expect("the record");
    let seen = record["reached"]["mixture"]["seen_first"].as_object().expect("shares");
    assert_eq!(seen.len(), 4);
    assert!(
        ["olivine", "quartz", "clay"].iter().all(|m| seen[*m].as_f64().expect("a share") > 0.02),
        "{seen:?}"
    );
    // The placed scene stands alone: its spectra were brought along.
    for file in ["q.csv", "c.sli", "c.hdr", "pure.json"] {
        let inputs = record["inputs"].as_object().expect("inputs");
        assert!(inputs.keys().any(|path| path.ends_with(file)), "{file}: {inputs:?}");
        fs::remove_file(place.path(file)).expect("removed");
    }
    place.run_with(&blender, &["trace", "r/scene.json", "-o", "t.json", "--range", "8-12"]);
}
