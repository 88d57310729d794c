//! What is written is read the same, whatever its numbers are and in whatever order its keys stand.

use std::fs;
use std::path::Path;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use serde_json::{Value, json};
use soilsig::pipeline::record::Record;
use soilsig::products::cube::Cube;
use soilsig::spectrum::format::{self, Reading};
use soilsig::spectrum::optics::Crystal;
use soilsig::{Grid, Request, Scene, Table, Target, Unwatched, trace};

use crate::fuzz::seeds;

fn config(cases: u32) -> Config {
    Config { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..Config::default() }
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Ascending wavelengths, um, and as many values.
fn points(values: impl Strategy<Value = f64>) -> impl Strategy<Value = Vec<(f64, f64)>> {
    vec((1e-4..0.5_f64, values), 2..40).prop_map(|points| {
        let mut at = 6.0;
        let next = |(step, value): (f64, f64)| {
            at += step;
            (at, value)
        };
        points.into_iter().map(next).collect()
    })
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn spectra_are_read_as_they_were_written(
        points in points(prop_oneof![0.0..=1.0_f64, Just(0.0), Just(1.0), 0.0..1e-300_f64]),
        ending in prop_oneof![Just("csv"), Just("sli"), Just("ems")],
    ) {
        let folder = folder();
        let path = folder.path().join(format!("a.{ending}"));
        let (um, values): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        format::write(&path, &um, &[("one".into(), values.clone())]).expect("written");
        let read = format::read_one(&path, &Reading::default()).expect("read");
        prop_assert_eq!(read.wavelength_um, um);
        prop_assert_eq!(read.emissivity, values);
    }

    #[test]
    fn images_are_read_as_they_were_written(
        lines in 1..4_usize,
        samples in 1..5_usize,
        bands in points(any::<f64>()),
        values in vec(prop_oneof![any::<f32>(), Just(f32::NAN), -1.0..400.0_f32], 16 * 40),
    ) {
        let folder = folder();
        let path = folder.path().join("a.img");
        let um: Vec<f64> = bands.iter().map(|(um, _)| *um).collect();
        let mut cube = Cube::new(lines, samples, um);
        let numbers = cube.data.len();
        cube.data.copy_from_slice(&values[..numbers]);
        cube.write(&path, "radiance").expect("written");
        let read = Cube::read(&path).expect("read");
        prop_assert_eq!((read.lines, read.samples), (cube.lines, cube.samples));
        prop_assert_eq!(read.wavelengths_um, cube.wavelengths_um);
        let bits = |data: &[f32]| -> Vec<Option<u32>> {
            data.iter().map(|x| (!x.is_nan()).then_some(x.to_bits())).collect()
        };
        prop_assert_eq!(bits(&read.data), bits(&cube.data));
    }

    #[test]
    fn scenes_and_records_are_read_as_they_were_written(
        seed in any::<u64>(),
        kelvin in 1.0..1e4_f64,
        zenith in 0.0..89.0_f64,
        share in 0.0..=1.0_f64,
        transform in prop::array::uniform12(-1e6..1e6_f64),
        seconds in 0.0..1e9_f64,
        name in "[^\\p{C}\\p{Z}]{1,12}",
    ) {
        let folder = folder();
        let mut scene: Value = serde_json::from_str(&seeds::scene_of(
            r#"{"name": "m", "file": "a.obj", "unit_um": 1000}"#
        )).expect("JSON");
        scene["name"] = name.clone().into();
        scene["seed"] = seed.into();
        scene["temperature_k"] = kelvin.into();
        scene["view"]["zenith_deg"] = zenith.into();
        scene["materials"][0] = json!({"name": name, "temperature_k": kelvin, "specular": share,
                                      "spectrum": {"constant": share}});
        scene["geometry"]["placed"]["instances"] =
            json!([{"prototype": "m", "transform": transform}]);
        let at = Path::new("scene.json");
        if let Ok(scene) = Scene::parse(&scene.to_string(), at) {
            let written = serde_json::to_string_pretty(&scene).expect("JSON");
            prop_assert_eq!(Scene::parse(&written, at).expect("read"), scene);
        } else {
            // Only a transform without volume is no scene.
            prop_assert!(false, "refused: {:?}", Scene::parse(&scene.to_string(), at));
        }

        let mut record: Value = serde_json::from_slice(&seeds::records()[0]).expect("JSON");
        record["seeds"][&name] = seed.into();
        record["stages"][0]["seconds"] = seconds.into();
        record["reached"]["case"]["half_width"] = share.into();
        let path = folder.path().join("run.json");
        fs::write(&path, record.to_string()).expect("written");
        let read = Record::read(&path).expect("read");
        fs::write(&path, serde_json::to_string(&read).expect("JSON")).expect("written");
        let again = Record::read(&path).expect("read");
        prop_assert_eq!(&again.seeds[&name], &seed);
        prop_assert_eq!(again.stages[0].seconds, seconds);
        prop_assert_eq!(again.reached["case"].half_width, share);
    }
}

proptest! {
    #![proptest_config(config(20))]

    #[test]
    fn tables_are_read_as_they_were_written(
        seed in any::<u64>(),
        emissivity in 0.01..1.0_f64,
        kelvin in proptest::option::of(200.0..400.0_f64),
        sky in proptest::option::of(10.0..300.0_f64),
    ) {
        let folder = folder();
        fs::write(folder.path().join("a.obj"), seeds::PIT).expect("written");
        let mut scene: Value = serde_json::from_str(&seeds::scene_of(
            r#"{"name": "m", "file": "a.obj", "unit_um": 1000}"#
        )).expect("JSON");
        scene["seed"] = seed.into();
        let mut rock = json!({"name": "rock", "spectrum": {"constant": emissivity}});
        let other = json!({"name": "other", "spectrum": {"builtin": "quartz_fine"}});
        if let Some(kelvin) = kelvin {
            rock["temperature_k"] = kelvin.into();
        }
        scene["materials"] = json!([rock, other]);
        if let Some(sky) = sky {
            scene["sky_temperature_k"] =
                json!([{"zenith_deg": 0, "temperature_k": sky}, {"zenith_deg": 90, "temperature_k": 300}]);
        }
        let scene_file = folder.path().join("scene.json");
        fs::write(&scene_file, scene.to_string()).expect("written");
        let grid = Grid::new(8.0, 9.0, 0.5).expect("a grid");
        let target = Target { max_paths: 300, ..Target::of(0.2) };
        let scene = Scene::read(&scene_file).expect("a scene");
        let table = trace(scene, Request::new(&grid, target), &Unwatched).expect("a table");
        let path = folder.path().join("table.json");
        table.write(&path).expect("written");
        prop_assert_eq!(Table::read(&path).expect("read"), table);
    }

    #[test]
    fn the_order_of_keys_does_not_matter(order in any::<u64>()) {
        let folder = folder();
        let path = folder.path().join("a.json");
        let shuffled = |input: &[u8]| {
            let value: Value = serde_json::from_slice(input).expect("JSON");
            let mut order = order;
            let mut text = String::new();
            write(&value, &mut order, &mut text);
            fs::write(&path, &text).expect("written");
        };
        for input in seeds::scenes() {
            let json = input.split(|&byte| byte == b'=').next().expect("the first file");
            shuffled(json);
            let read = Scene::read(&path).expect("read");
            let text = std::str::from_utf8(json).expect("text");
            prop_assert_eq!(read, Scene::parse(text, &path).expect("read"));
        }
        for input in seeds::tables() {
            shuffled(&input);
            let read = Table::read(&path).expect("read");
            fs::write(&path, &input).expect("written");
            prop_assert_eq!(read, Table::read(&path).expect("read"));
        }
        for input in seeds::records() {
            let json = |record| serde_json::to_string(&record).expect("JSON");
            shuffled(&input);
            let read = Record::read(&path).expect("read");
            fs::write(&path, &input).expect("written");
            prop_assert_eq!(json(read), json(Record::read(&path).expect("read")));
        }
        for input in seeds::optics() {
            shuffled(&input);
            let read = Crystal::read(&path).expect("read");
            fs::write(&path, &input).expect("written");
            prop_assert_eq!(read, Crystal::read(&path).expect("read"));
        }
    }
}

/// Writes JSON with the keys of each object in an order of chance.
fn write(value: &Value, order: &mut u64, text: &mut String) {
    match value {
        Value::Object(map) => {
            let mut keys: Vec<(u64, &String)> = map
                .keys()
                .map(|key| {
                    *order = order.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    (*order >> 20, key)
                })
                .collect();
            keys.sort_unstable();
            text.push('{');
            for (i, (_, key)) in keys.into_iter().enumerate() {
                *text += if i == 0 { "" } else { ", " };
                *text += &Value::from(key.as_str()).to_string();
                text.push(':');
                write(&map[key], order, text);
            }
            text.push('}');
        }
        Value::Array(items) => {
            text.push('[');
            for (i, item) in items.iter().enumerate() {
                *text += if i == 0 { "" } else { "," };
                write(item, order, text);
            }
            text.push(']');
        }
        other => *text += &other.to_string(),
    }
}
