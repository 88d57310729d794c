//! A trace in parts, elsewhere or at another time, is byte for byte the trace in one go; and what
//! limits a trace is said.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use insta::assert_snapshot;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;

use crate::support::{Place, shipped, shipped_json};

fn trace(place: &Place, out: &str, more: &[&str]) {
    let patch = shipped("settled_patch.json");
    place.run(&[&["trace", &patch, "--out", out], more].concat(), 0);
}

#[test]
fn shards_merge_into_the_table_of_one_run() {
    let place = Place::new();
    trace(&place, "whole.json", &["--paths", "20000"]);
    for (shard, threads) in [("1/3", "1"), ("2/3", "2"), ("3/3", "16")] {
        let out = format!("{}.json", &shard[..1]);
        trace(&place, &out, &["--paths", "20000", "--shard", shard, "--threads", threads]);
    }
    let paths = |name: &str| place.json(name)["paths"].as_u64().expect("a number");
    let parts = [paths("1.json"), paths("2.json"), paths("3.json")];
    assert_eq!(parts.iter().sum::<u64>(), 20_000);
    assert!(parts.iter().all(|part| part.abs_diff(6667) < 1024), "{parts:?}");
    place.run(&["merge", "3.json", "1.json", "2.json", "--out", "merged.json"], 0);
    let bytes = |name: &str| fs::read(place.path(name)).expect("written");
    assert!(bytes("merged.json") == bytes("whole.json"));
    place.run(&["merge", "whole.json", "--out", "again.json"], 0);
    assert!(bytes("again.json") == bytes("whole.json"));
}

#[test]
fn tables_that_are_no_parts_of_one_trace_are_refused() {
    let place = Place::new();
    let shard = |out: &str, shard: &str, more: &[&str]| {
        trace(&place, out, &[&["--paths", "4096", "--shard", shard], more].concat());
    };
    shard("1.json", "1/3", &[]);
    shard("2.json", "2/3", &[]);
    shard("3.json", "3/3", &[]);
    let refused = |tables: &[&str]| {
        let said = place.refused(&[&["merge", "--out", "m.json"], tables].concat(), 3);
        assert!(!place.path("m.json").exists());
        said
    };
    let mut said = [
        &["1.json", "3.json"][..],
        &["1.json", "2.json"],
        &["2.json", "3.json"],
        &["1.json", "2.json", "1.json", "3.json"],
    ]
    .map(refused)
    .concat();
    for more in [["--seed", "2"], ["--tolerance", "0.01"], ["--range", "8-9"]] {
        shard("other.json", "2/3", &more);
        said += &format!("{more:?}\n{}", refused(&["1.json", "other.json", "3.json"]));
    }
    trace(&place, "longer.json", &["--paths", "8192", "--shard", "2/3"]);
    said += &refused(&["1.json", "longer.json", "3.json"]);
    let mut oblique = shipped_json("settled_patch.json");
    oblique["view"]["zenith_deg"] = 9.into();
    place.write("s.json", oblique.to_string());
    place.run(&["trace", "s.json", "--out", "v.json", "--paths", "4096", "--shard", "2/3"], 0);
    said += &refused(&["1.json", "v.json", "3.json"]);
    let mut plain = place.json("2.json");
    plain.as_object_mut().expect("a table").remove("cells");
    place.write("plain.json", plain.to_string());
    said += &refused(&["1.json", "plain.json", "3.json"]);
    said += &place.refused(&["signature", "1.json", "2.json"], 3);
    for wrong in ["0/3", "4/3", "x/3", "3"] {
        let args = ["trace", "s.json", "--out", "w.json", "--paths", "99", "--shard", wrong];
        said += &place.refused(&args, 2);
    }
    said += &place.refused(&["trace", "s.json", "--out", "w.json", "--shard", "1/3"], 2);
    assert_snapshot!(said);
}

#[test]
fn an_unknown_key_anywhere_in_a_table_is_refused() {
    let place = Place::new();
    trace(&place, "t.json", &["--paths", "1024"]);
    let table = place.json("t.json");
    let mut objects = vec![String::new()];
    let mut at = 0;
    while at < objects.len() {
        let found = table.pointer(&objects[at]).expect("it is in there");
        let children: Vec<(String, &Value)> = match found {
            Value::Object(keys) => keys.iter().map(|(key, value)| (key.clone(), value)).collect(),
            Value::Array(items) => {
                items.iter().enumerate().map(|(i, item)| (i.to_string(), item)).collect()
            }
            _ => Vec::new(),
        };
        let nested = children.into_iter().filter(|(_, value)| !value.is_number());
        let pointers: Vec<String> =
            nested.map(|(key, _)| format!("{}/{}", objects[at], key.replace('/', "~1"))).collect();
        objects.extend(pointers);
        at += 1;
    }
    // The keys of coverage are names.
    objects.retain(|pointer| {
        table.pointer(pointer).is_some_and(Value::is_object) && !pointer.starts_with("/coverage")
    });
    assert!(objects.iter().any(|pointer| pointer == "/stop"), "{objects:?}");
    for pointer in objects {
        let mut wrong = table.clone();
        wrong.pointer_mut(&pointer).expect("it is in there")["tolerence"] = 9.into();
        place.write("wrong.json", wrong.to_string());
        let said = place.refused(&["signature", "wrong.json"], 3);
        assert!(said.contains("wrong.json"), "{pointer}: {said}");
    }
}

#[test]
fn an_interrupted_trace_goes_on_where_it_was() {
    let place = Place::new();
    let paths = ["--paths", "600000"];
    let patch = shipped("settled_patch.json");
    let args = [&["trace", &patch, "--out", "t.json"], &paths[..]].concat();
    let interrupt_after = |time: Duration| {
        let mut running = Command::new(env!("CARGO_BIN_EXE_soilsig"))
            .args(&args)
            .current_dir(place.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        sleep(time);
        kill(Pid::from_raw(running.id().cast_signed()), Signal::SIGINT).expect("sent");
        assert_eq!(running.wait().expect("it ends").code(), Some(130));
        assert!(!place.path("t.json").exists(), "nothing half done has its name");
    };
    // Long enough for a part of it on any machine, as short as this one allows.
    let partial = place.path("t.json.partial");
    let mut tries = 1..50;
    while !partial.exists() {
        interrupt_after(Duration::from_millis(200) * tries.next().expect("a part was done"));
    }
    let done = place.json("t.json.partial")["paths"].as_u64().expect("a number");
    assert!(0 < done && done < 600_000, "{done}");
    // A mark that only a trace that goes on from there can bring into its result.
    let text = fs::read_to_string(&partial).expect("written");
    let marked = text.replace(r#""escaped_downward": 0"#, r#""escaped_downward": 7"#);
    assert_ne!(marked, text);
    fs::write(&partial, marked).expect("written");
    trace(&place, "t.json", &paths);
    assert!(!partial.exists());
    trace(&place, "whole.json", &paths);
    let read = |name: &str| fs::read_to_string(place.path(name)).expect("written");
    let found = read("t.json").replace(r#""escaped_downward": 7"#, r#""escaped_downward": 0"#);
    assert_ne!(found, read("t.json"), "it began anew");
    assert!(found == read("whole.json"));
}

#[test]
fn what_another_trace_left_is_not_taken() {
    let place = Place::new();
    trace(&place, "t.json", &["--paths", "4096", "--seed", "2"]);
    fs::rename(place.path("t.json"), place.path("u.json.partial")).expect("renamed");
    trace(&place, "u.json", &["--paths", "4096"]);
    trace(&place, "v.json", &["--paths", "4096"]);
    let bytes = |name: &str| fs::read(place.path(name)).expect("written");
    assert!(bytes("u.json") == bytes("v.json"));
    // Nor what a longer one left, or one that was to end by itself.
    for other in [&["--paths", "9000"][..], &["--max-paths", "4096"]] {
        let patch = shipped("settled_patch.json");
        let args = [&["trace", &patch, "--out", "t.json"], other].concat();
        place.soilsig(&args).output().expect("it runs");
        fs::rename(place.path("t.json"), place.path("w.json.partial")).expect("renamed");
        trace(&place, "w.json", &["--paths", "4096"]);
        assert!(bytes("u.json") == bytes("w.json"), "{other:?}");
    }
    fs::write(place.path("v.json.partial"), "{\"half\":").expect("written");
    trace(&place, "v.json", &["--paths", "4096"]);
    assert!(bytes("u.json") == bytes("v.json"));
}

#[test]
fn limits_on_paths_and_time_leave_a_result_that_says_so() {
    let place = Place::new();
    let patch = shipped("settled_patch.json");
    let mut said = String::new();
    for (limit, ended_by) in
        [(["--max-paths", "10000"], "max_paths"), (["--max-seconds", "0.3"], "max_seconds")]
    {
        let args = ["trace", &patch, "--out", "t.json", "--tolerance", "0.0002"];
        let args = [&args[..], &limit].concat();
        let (out, _) = place.run(&args, 4);
        let stop = place.json("t.json")["stop"].clone();
        assert_eq!(stop["ended_by"], ended_by);
        let half_width = stop["half_width"].as_f64().expect("a number");
        assert!(out.contains(&format!("{half_width:.4}")), "{out}");
        assert!(half_width > 0.0002 && half_width < 0.1, "{half_width}");
        let remedy = out.lines().find(|line| line.contains(limit[0])).expect("a remedy");
        // The rest depends on the speed of the machine.
        let (remedy, _) = remedy.split_once(" gives ").expect("a forecast");
        said += &format!("{remedy}\n");
    }
    assert_snapshot!(said);
}

/// Paths that all weigh the same are no proof that others would: what none of n saw may still have
/// a share of 3 / n.
#[test]
fn no_spread_is_not_taken_for_certainty() {
    let place = Place::new();
    fs::write(place.path("plate.obj"), "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nf 1 2 3 4\n")
        .expect("written");
    fs::write(
        place.path("plate.json"),
        r#"{"soilsig_scene": 1, "name": "plate", "seed": 1, "temperature_k": 300,
            "view": {"zenith_deg": 0},
            "materials": [{"name": "a", "spectrum": {"constant": 0.7}}], "geometry": {"placed":
            {"prototypes": [{"name": "p", "file": "plate.obj", "material": "a"}]}}}"#,
    )
    .expect("written");
    for (tolerance, least) in [("0.01", 8192), ("0.0001", 30_000)] {
        place.run(&["trace", "plate.json", "--out", "t.json", "--tolerance", tolerance], 0);
        let table = place.json("t.json");
        assert!(table["stop"]["half_width"].as_f64().expect("a number") < 1e-9);
        assert!(table["paths"].as_u64().expect("a number") >= least, "{tolerance}");
    }
    let few = ["--tolerance", "0.0001", "--max-paths", "20000"];
    place.run(&[&["trace", "plate.json", "--out", "t.json"], &few[..]].concat(), 4);
}
