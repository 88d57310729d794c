//! Where a result's uncertainty comes from: each part beside what it stands for, found by another
//! way.

use std::fs;
use std::path::Path;

use insta::assert_snapshot;
use serde_json::{Value, json};
use soilsig::scene::Origin;
use soilsig::scene::{Grid, Scene, SpectrumSource};
use soilsig::signature::budget::{Budget, Share};
use soilsig::signature::evaluate;
use soilsig::spectrum::{PureBed, Spectrum};
use soilsig::support::monitor::Unwatched;
use soilsig::support::statistics::{T_95, quantile_95};
use soilsig::table::{Part, Prepared, Table, Target};
use soilsig::tracer::trace::{self, Request};

use crate::support::{Place, shipped_json};

const CELLS: usize = 16;

/// The settled patch after a change.
fn patch(change: impl FnOnce(&mut Value)) -> Value {
    let mut scene = shipped_json("settled_patch.json");
    change(&mut scene);
    scene
}

/// The lowest grains of the patch alone: the floor is seen between them.
fn shallow(scene: &mut Value) {
    let instances = scene["geometry"]["placed"]["instances"].as_array_mut().expect("a list");
    instances.retain(|instance| instance["transform"][11].as_f64().expect("a number") < 500.0);
}

/// Traces so many paths of a scene, the same for the same seed.
fn traced(place: &Place, scene: &Value, seed: u64, tolerance: f64) -> Table {
    let path = place.path("scene.json");
    fs::write(&path, scene.to_string()).expect("written");
    let mut scene = Scene::read(&path).expect("the scene is sound");
    scene.seed = seed;
    let tracer = trace::tracer(&scene).expect("its meshes are sound");
    let band = Grid::new(9.0, 9.0, 0.01).expect("a grid");
    let exactly = Some(Part::shard(1, 1, 1 << 13));
    let target = Target { exactly, ..Target::of(tolerance) };
    trace::trace(
        &tracer,
        &Prepared::new(scene.clone(), &band.wavelengths_um()).expect("spectra"),
        Request::new(&band, target),
        &Unwatched,
    )
    .expect("traced")
}

fn budget(tables: &[Table], origin: Origin) -> Budget {
    let tables: Vec<Table> = tables.iter().map(|t| Table { origin, ..t.clone() }).collect();
    let tables = &tables[..];
    let bands = evaluate(tables, &[8.2, 9.0, 11.0]).expect("within the spectra's range");
    Budget::new(tables, &bands).expect("evaluated")
}

/// Share and emissivity at 9 um.
fn at_9_um(table: &Table) -> (Share, f64) {
    let tables = std::slice::from_ref(table);
    let bands = evaluate(tables, &[9.0]).expect("within the spectra's range");
    let budget = Budget::new(tables, &bands).expect("evaluated");
    (budget.bands[0], bands[0].emissivity.mean)
}

/// The columns of a CSV file, line by line; empty fields are no numbers.
fn columns(text: &str, names: &[&str]) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let headings = reader.headers().expect("headings").clone();
    let index = |name: &&str| headings.iter().position(|h| h == *name).expect("a column");
    let indices: Vec<usize> = names.iter().map(index).collect();
    let of = |row: csv::StringRecord| {
        indices.iter().map(|&i| row[i].parse().unwrap_or(f64::NAN)).collect()
    };
    reader.records().map(|row| of(row.expect("a row"))).collect()
}

#[test]
fn no_floor_changes_more_than_the_bound_says() {
    let place = Place::new();
    let with_floor = |spectrum: Value| {
        let scene = patch(|scene| {
            shallow(scene);
            scene["materials"][2]["spectrum"] = spectrum;
        });
        // Next to no path is given up.
        traced(&place, &scene, 3, 1e-6)
    };
    let table = with_floor(json!({"builtin": "quartz_fine"}));
    let (share, e) = at_9_um(&table);
    // The same paths on any floor.
    let [white, grey, black] = [0.0, 0.5, 1.0].map(|e| {
        let mut painted = table.clone();
        let constant = serde_json::from_value(json!({"constant": e})).expect("a source");
        painted.materials[2].spectrum = Spectrum::resolve(&constant, Path::new("")).expect("one");
        let painted = at_9_um(&painted);
        // Traced on that floor they are followed to another end.
        let (anew, emissivity) = at_9_um(&with_floor(json!({"constant": e})));
        let both = painted.0.rays.hypot(anew.rays);
        assert!((painted.1 - emissivity).abs() < 1.5 * both, "{} and {emissivity}", painted.1);
        painted.1
    });
    let widest = (black - e).max(e - white);
    assert!(share.floor > 0.02, "the floor is seen: {}", share.floor);
    assert!((share.floor - widest).abs() < 1e-12, "{} and {widest}", share.floor);
    assert!((grey - e).abs() < share.floor && white < grey && grey < black);
    let effect = budget(&[table], Origin::Given).floor_effect.expect("there is a floor");
    assert!(effect >= black - white - 1e-12, "{effect} and {}", black - white);
}

#[test]
fn the_total_is_the_sum_of_its_parts() {
    let place = Place::new();
    let scene = patch(shallow);
    // Beds of one recipe differ by more than rays; what they are put together by is the same.
    let tables = [1, 2, 3].map(|seed| traced(&place, &scene, seed, 0.02));
    // Of a bed's cells the spread holds the rays.
    let rho = &tables[0].reflectances(&[9.0]).expect("in range")[0];
    let variances = tables.each_ref().map(|table| {
        let cells = table.cells.as_ref().expect("the target fills the view");
        let of_each: [f64; CELLS] = cells.weight_of_groups(rho);
        let mean = of_each.iter().sum::<f64>() / 16.0;
        of_each.iter().map(|cell| (cell - mean).powi(2)).sum::<f64>() / 15.0
    });
    let of_one = quantile_95(CELLS) * (variances[0] / 16.0).sqrt();
    let of_three = quantile_95(46) * (variances.iter().sum::<f64>() / 144.0).sqrt();
    for (tables, origin, by_cells) in [
        (&tables[..1], Origin::Given, None),
        (&tables[..1], Origin::Drawn, Some(of_one)),
        (&tables[..], Origin::DrawnApart, Some(of_three)),
    ] {
        let bands = evaluate(tables, &[8.2, 9.0, 11.0]).expect("within the spectra's range");
        for (share, band) in budget(tables, origin).bands.iter().zip(&bands) {
            let e = band.emissivity;
            assert!((share.rays - T_95 * e.rays_standard_error).abs() < 1e-15);
            let chance = share.rays.hypot(share.packings.unwrap_or(0.0));
            let apart = share.apart.unwrap_or(0.0);
            let bounds = share.rim.unwrap_or(0.0) + share.floor + share.given_up + apart;
            assert!((share.total - chance - bounds).abs() < 1e-12, "{share:?}");
            assert!(share.given_up > 0.0 && share.given_up == e.trapped);
            let drawn = origin != Origin::Given;
            assert_eq!([share.packings.is_some(), share.rim.is_some()], [drawn; 2]);
            assert_eq!(share.apart.is_some(), origin == Origin::DrawnApart);
            // What is not measured is told beside the total.
            assert_eq!(share.facets.is_some(), drawn);
            if let Some(by_cells) = by_cells.filter(|_| share.wavelength_um == 9.0) {
                let by_spread = e.spread.map_or(0.0, |_| quantile_95(3) * e.standard_error);
                let least = by_cells.max(by_spread).max(share.rays);
                assert!((chance - least).abs() < 1e-12, "{chance} and {least}");
            }
        }
    }
}

/// A plate whose left half is of another material: two columns of cells see the one, two the other.
#[test]
fn a_cell_is_where_in_the_view_a_path_began() {
    let place = Place::new();
    let plate = "v 0 0 0\nv 4 0 0\nv 4 8 0\nv 0 8 0\nv 8 0 0\nv 8 8 0\nusemtl a\nf 1 2 3 4\nusemtl b\nf 2 5 6 3\n";
    fs::write(place.path("plate.obj"), plate).expect("written");
    let scene = |sides: &str| {
        let domain = json!({"min_um": [0, 0], "max_um": [8, 8], "sides": sides});
        let materials = ["a", "b"].map(|name| json!({"name": name, "spectrum": {"constant": 0.5}}));
        json!({"soilsig_scene": 1, "name": "plate", "seed": 1, "temperature_k": 300,
            "view": {"zenith_deg": 0}, "materials": materials, "geometry": {"placed":
            {"prototypes": [{"name": "p", "file": "plate.obj"}], "domain": domain}}})
    };
    for sides in ["mirror", "periodic"] {
        let table = traced(&place, &scene(sides), 1, 0.01);
        let cells: [f64; CELLS] = table.cells.expect("a full view").weight_of_groups(&[0.25, 0.75]);
        let expected = std::array::from_fn(|cell| if cell % 4 < 2 { 0.25 } else { 0.75 });
        assert_eq!(cells, expected, "{sides}");
    }
    // A body in the open does not fill the view: its cells would tell of its outline.
    let open = traced(&place, &scene("open"), 1, 0.01);
    assert!(open.cells.is_none());
    let share = budget(&[open], Origin::Drawn).bands[0];
    assert_eq!((share.packings, share.rim), (None, None));
}

#[test]
fn what_spectra_bring_is_what_changed_constants_change() {
    let place = Place::new();
    traced(&place, &patch(shallow), 1, 0.01).write(&place.path("t.json")).expect("written");
    let args = ["signature", "t.json", "--range", "9.03-9.03", "--out", "s.csv"];
    let run = |more: &[&str]| {
        place.run(&[&args[..], more].concat(), 0);
        let csv = fs::read_to_string(place.path("s.csv")).expect("written");
        columns(&csv, &["emissivity"])[0][0]
    };
    run(&["--budget", "b.csv"]);
    let csv = fs::read_to_string(place.path("b.csv")).expect("written");
    let found = columns(&csv, &["spectra_half_width_95"])[0][0];
    let half_of = |name: &str, rms: f64, materials: &[&str]| {
        let e = Spectrum::builtin(name).expect("shipped").emissivity(9.03).expect("in range");
        let changed = [rms, -rms].map(|by| {
            let words: Vec<String> =
                materials.iter().map(|m| format!("--spectrum={m}={}", e + by)).collect();
            run(&words.iter().map(String::as_str).collect::<Vec<_>>())
        });
        (changed[0] - changed[1]) / 2.0
    };
    // As docs/physics/quartz.md has the fits' errors; fines and floor share a spectrum, and err
    // together.
    let coarse = half_of("quartz_coarse", 0.0043, &["coarse"]);
    let fine = half_of("quartz_fine", 0.006, &["fine", "floor"]);
    assert!((found - 1.96 * coarse.hypot(fine)).abs() < 0.02 * found, "{found} {coarse} {fine}");
    let constants = ["coarse", "fine", "floor"].map(|m| format!("--spectrum={m}=0.9"));
    run(&[&constants.each_ref().map(String::as_str)[..], &["--budget", "b.csv"]].concat());
    let csv = fs::read_to_string(place.path("b.csv")).expect("written");
    assert_eq!(columns(&csv, &["spectra_half_width_95"])[0][0], 0.0);
}

/// Of the very bed that its facets were inverted by, the error is that of the powder and of the
/// bed.
#[test]
fn inverted_facets_pass_the_powders_error_on() {
    let place = Place::new();
    let scene = patch(|scene| {
        scene["materials"] = json!([{"name": "a", "spectrum": {"constant": 0.8}}]);
        let placed = &mut scene["geometry"]["placed"];
        for prototype in placed["prototypes"].as_array_mut().expect("a list") {
            prototype["material"] = json!("a");
        }
        placed["domain"]["floor"]["material"] = json!("a");
    });
    let mut table = traced(&place, &scene, 1, 0.001);
    let path = place.path("t.json");
    table.write(&path).expect("written");
    let bed = PureBed::read(&[path]).expect("a pure bed");
    let powder = Spectrum::builtin("quartz_coarse").expect("shipped");
    let error = powder.error(9.0).expect("in range").hypot(bed.standard_error);
    table.materials[0].spectrum = Spectrum::Inverted(Box::new(powder), bed);
    let found = at_9_um(&table).0.spectra / 1.96;
    assert!((found / error - 1.0).abs() < 0.01, "{found} and {error}");
}

/// A table of a bed that was drawn says so wherever it is evaluated.
#[test]
fn a_single_table_of_a_drawn_bed_knows_that_others_differ() {
    let place = Place::new();
    let said = |origin: Option<&str>| {
        let mut scene = shipped_json("settled_patch.json");
        if let Some(origin) = origin {
            scene["geometry"]["placed"]["origin"] = json!(origin);
        }
        place.write("s.json", scene.to_string());
        let files = ["trace", "s.json", "--out", "t.json", "--tolerance", "0.02"];
        place.run(&files, 0);
        place.run(&["signature", "t.json", "--out", "s.csv"], 0).0
    };
    let half_width = |said: &str| -> f64 {
        said.split("+- ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next())
            .expect("one")
            .parse()
            .expect("a number")
    };
    let (given, drawn) = (said(None), said(Some("drawn")));
    assert!(given.contains("this geometry") && drawn.contains("one bed"), "{given}\n{drawn}");
    assert!(half_width(&drawn) > 2.0 * half_width(&given), "{given}\n{drawn}");
}

#[test]
fn spectra_without_an_error_are_named() {
    let place = Place::new();
    let mut table = traced(&place, &patch(shallow), 1, 0.01);
    assert!(budget(std::slice::from_ref(&table), Origin::Given).spectra_unknown.is_empty());
    fs::write(place.path("own.csv"), "wavelength_um,emissivity\n7,0.8\n15,0.8\n").expect("written");
    let source = SpectrumSource::File(place.path("own.csv"));
    table.materials[1].spectrum = Spectrum::resolve(&source, Path::new("")).expect("a spectrum");
    let budget = budget(std::slice::from_ref(&table), Origin::Given);
    assert_eq!(budget.spectra_unknown, ["coarse"]);
    assert!(budget.bands[0].spectra > 0.0, "those of the fines are known");
    // An inverted file has at least the error of its pure bed.
    let Spectrum::Tabulated(points) = &table.materials[1].spectrum else { panic!("a file") };
    let powder = Box::new(Spectrum::Tabulated(points.clone()));
    let bed = PureBed::shipped().clone();
    let inverted = Spectrum::Inverted(powder, bed.clone());
    assert!(!inverted.has_error());
    assert!(inverted.error(9.0).expect("in range") > bed.standard_error / 2.0);
}

#[test]
fn straight_lines_miss_what_a_grid_of_half_the_step_shows() {
    let place = Place::new();
    traced(&place, &patch(shallow), 1, 0.01).write(&place.path("t.json")).expect("written");
    let args = |step| ["signature", "t.json", "--range", "8-9.2", "--step", step];
    let finer = columns(&place.run(&args("0.1"), 0).0, &["emissivity"]);
    place.run(&[&args("0.2")[..], &["--budget", "b.csv", "--out", "s.csv"]].concat(), 0);
    let csv = fs::read_to_string(place.path("b.csv")).expect("written");
    let steps = columns(&csv, &["wavelength_um", "spectral_step"]);
    assert_eq!((finer.len(), steps.len()), (13, 7));
    let missed = |middle: usize| {
        let at = |i: usize| finer[i][0];
        (at(middle) - f64::midpoint(at(middle - 1), at(middle + 1))).abs()
    };
    for (i, step) in steps.iter().enumerate() {
        let left = if i > 0 { missed(2 * i - 1) } else { 0.0 };
        let right = if i + 1 < steps.len() { missed(2 * i + 1) } else { 0.0 };
        assert!((step[1] - left.max(right)).abs() < 3e-7, "{step:?}: {left} {right}");
    }
    assert!(steps.iter().any(|step| step[1] > 0.005), "{steps:?}");
}

#[test]
fn shards_have_the_cells_of_the_whole() {
    let place = Place::new();
    fs::write(place.path("scene.json"), patch(|_| ()).to_string()).expect("written");
    let trace = |out: &str, more: &[&str]| {
        let args = ["trace", "scene.json", "--paths", "20000", "--out", out];
        place.run(&[&args[..], more].concat(), 0);
    };
    trace("whole.json", &[]);
    for part in ["1", "2", "3"] {
        trace(&format!("{part}.json"), &["--shard", &format!("{part}/3")]);
    }
    place.run(&["merge", "2.json", "3.json", "1.json", "--out", "merged.json"], 0);
    let cells = |name: &str| {
        let text = fs::read_to_string(place.path(name)).expect("written");
        text.split_once("\n  \"cells\": ").expect("it has cells").1.to_owned()
    };
    assert!(cells("merged.json") == cells("whole.json"));
    assert!(cells("1.json") != cells("2.json"));
    let budget = |name: &str| {
        place.run(&["signature", name, "--budget", "b.csv", "--out", "s.csv"], 0);
        fs::read(place.path("b.csv")).expect("written")
    };
    assert!(budget("merged.json") == budget("whole.json"));
}

#[test]
fn cells_that_were_tampered_with_are_refused() {
    let place = Place::new();
    traced(&place, &patch(shallow), 1, 0.01).write(&place.path("t.json")).expect("written");
    let sound = place.json("t.json");
    let refused = |tamper: &dyn Fn(&mut Value)| {
        let mut table = sound.clone();
        tamper(&mut table["cells"]);
        place.write("wrong.json", table.to_string());
        place.refused(&["signature", "wrong.json"], 3)
    };
    let add = |count: &mut Value, by: i64| *count = json!(count.as_i64().expect("whole") + by);
    // As many paths in all, of which some bring other weights.
    let moved = |cells: &mut Value| {
        add(&mut cells["escaped"][0][1][0][1], 5);
        let from = cells["escaped"][1][1].as_array_mut().expect("counts");
        add(from.iter_mut().map(|of| &mut of[1]).find(|n| n.as_i64() > Some(5)).expect("some"), -5);
    };
    let told = [
        refused(&|cells| cells["escaped"][0][1][0][0] = json!(16)),
        refused(&|cells| add(&mut cells["escaped"][0][1][0][1], 5)),
        refused(&moved),
        refused(&|cells| cells["escaped"] = json!([])),
        refused(&|cells| cells["kept"]["order"] = json!(true)),
        refused(&|cells| cells["parts"] = json!(4)),
    ];
    assert_snapshot!(told.concat());
    // Without any they are a table's of before.
    let mut without = sound.clone();
    without.as_object_mut().expect("an object").remove("cells");
    fs::write(place.path("without.json"), without.to_string()).expect("written");
    place.run(&["signature", "without.json"], 0);
}
