//! A trace in parts, elsewhere or at another time, is byte for byte the trace in one go; and what limits a trace is
//! said.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;

use crate::support::{Place, shipped};

/// Runs the program, expects that exit status and returns all that it said.
fn run(place: &Place, args: &[&str], status: i32) -> String {
    let output = place.soilsig(args).output().expect("it runs");
    let said =
        [output.stdout, output.stderr].map(|s| String::from_utf8(s).expect("UTF-8")).concat();
    assert_eq!(output.status.code(), Some(status), "{args:?}\n{said}");
    said
}

fn trace(place: &Place, out: &str, more: &[&str]) {
    let patch = shipped("settled_patch.json");
    run(place, &[&["trace", &patch, "--out", out], more].concat(), 0);
}

fn table(place: &Place, name: &str) -> Value {
    let text = fs::read_to_string(place.path(name)).expect("written");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn shards_merge_into_the_table_of_one_run() {
    let place = Place::new();
    trace(&place, "whole.json", &["--paths", "20000"]);
    for (shard, threads) in [("1/3", "1"), ("2/3", "2"), ("3/3", "16")] {
        let out = format!("{}.json", &shard[..1]);
        trace(&place, &out, &["--paths", "20000", "--shard", shard, "--threads", threads]);
    }
    let paths = |name: &str| table(&place, name)["paths"].as_u64().expect("a number");
    let parts = [paths("1.json"), paths("2.json"), paths("3.json")];
    assert_eq!(parts.iter().sum::<u64>(), 20_000);
    assert!(parts.iter().all(|part| part.abs_diff(6667) < 1024), "{parts:?}");
    run(&place, &["merge", "3.json", "1.json", "2.json", "--out", "merged.json"], 0);
    let bytes = |name: &str| fs::read(place.path(name)).expect("written");
    assert!(bytes("merged.json") == bytes("whole.json"));
    run(&place, &["merge", "whole.json", "--out", "again.json"], 0);
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
    let refused = |tables: &[&str], because: &[&str]| {
        let said = run(&place, &[&["merge", "--out", "m.json"], tables].concat(), 3);
        for part in because.iter().chain(&["hint:"]) {
            assert!(said.contains(part), "{tables:?}: {part:?} is not in {said}");
        }
        assert!(!place.path("m.json").exists());
    };
    refused(&["1.json", "3.json"], &["3.json", "paths 1024 to 2560 before it are in none"]);
    refused(&["1.json", "2.json"], &["2.json", "paths 2560 to 4096 after it are in none"]);
    refused(&["2.json", "3.json"], &["2.json", "paths 0 to 1024 before it are in none"]);
    refused(&["1.json", "2.json", "1.json", "3.json"], &["1.json", "are in another part too"]);
    for (more, differs) in [
        (["--seed", "2"], "differ in seed"),
        (["--tolerance", "0.01"], "differ in stop"),
        (["--range", "8-9"], "differ in stop"),
    ] {
        shard("other.json", "2/3", &more);
        refused(&["1.json", "other.json", "3.json"], &["other.json", "1.json", differs]);
    }
    trace(&place, "longer.json", &["--paths", "8192", "--shard", "2/3"]);
    refused(&["1.json", "longer.json", "3.json"], &["part of a trace of 8192 paths"]);
    let patch = fs::read_to_string(shipped("settled_patch.json")).expect("shipped");
    let folder = shipped("");
    let moved = patch.replace(r#""file": ""#, &format!(r#""file": "{folder}"#));
    fs::write(place.path("s.json"), moved.replace(r#""zenith_deg": 0"#, r#""zenith_deg": 9"#))
        .expect("written");
    run(&place, &["trace", "s.json", "--out", "v.json", "--paths", "4096", "--shard", "2/3"], 0);
    refused(&["1.json", "v.json", "3.json"], &["v.json", "scene_sha256", "view"]);
    let without = |text: &str| {
        let mut table: serde_json::Value = serde_json::from_str(text).expect("JSON");
        table.as_object_mut().expect("a table").remove("cells");
        table.to_string()
    };
    let two = fs::read_to_string(place.path("2.json")).expect("written");
    fs::write(place.path("plain.json"), without(&two)).expect("written");
    refused(&["1.json", "plain.json", "3.json"], &["plain.json", "cells of the view"]);
    let said = run(&place, &["signature", "1.json", "2.json"], 3);
    assert!(said.contains("soilsig merge"), "{said}");
    for wrong in ["0/3", "4/3", "x/3", "3"] {
        let args = ["trace", "s.json", "--out", "w.json", "--paths", "99", "--shard", wrong];
        run(&place, &args, 2);
    }
    run(&place, &["trace", "s.json", "--out", "w.json", "--shard", "1/3"], 2);
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
    let done = table(&place, "t.json.partial")["paths"].as_u64().expect("a number");
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
    for (limit, ended_by, remedy) in [
        (["--max-paths", "10000"], "max_paths", "raise --max-paths"),
        (["--max-seconds", "0.3"], "max_seconds", "raise --max-seconds"),
    ] {
        let args = ["trace", &patch, "--out", "t.json", "--tolerance", "0.0002"];
        let started = Instant::now();
        let said = run(&place, &[&args[..], &limit].concat(), 4);
        assert!(said.contains(remedy), "{said}");
        assert!(started.elapsed() < Duration::from_secs(20), "{:?}", started.elapsed());
        let stop = table(&place, "t.json")["stop"].clone();
        assert_eq!(stop["ended_by"], ended_by);
        let half_width = stop["half_width"].as_f64().expect("a number");
        assert!(said.contains(&format!("within {half_width:.4}")), "{said}");
        assert!(half_width > 0.0002 && half_width < 0.1, "{half_width}");
    }
}

/// Paths that all weigh the same are no proof that others would: what none of n saw may still have a share of 3 / n.
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
        run(&place, &["trace", "plate.json", "--out", "t.json", "--tolerance", tolerance], 0);
        let table = table(&place, "t.json");
        assert!(table["stop"]["half_width"].as_f64().expect("a number") < 1e-9);
        assert!(table["paths"].as_u64().expect("a number") >= least, "{tolerance}");
    }
    let few = ["--tolerance", "0.0001", "--max-paths", "20000"];
    run(&place, &[&["trace", "plate.json", "--out", "t.json"], &few[..]].concat(), 4);
}
