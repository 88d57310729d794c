//! Wall time of the pipeline and its stages: medians over several runs of the program.
//! `make bench` prints the table of docs/measurements/stages.md.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use serde_json::Value;

/// Runs of the whole pipeline.
const RUNS: usize = 5;
/// Runs of stages that take less than a second.
const SHORT_RUNS: usize = 20;

/// Wall time in seconds, and what the program printed.
fn timed(folder: &Path, args: &[&str]) -> (f64, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
    command.args(args).current_dir(folder).env("SOILSIG_CACHE", folder.join("cache"));
    let started = Instant::now();
    let output = command.output().expect("it starts");
    let seconds = started.elapsed().as_secs_f64();
    // 4: the tolerance was not reached; the table counts these runs.
    let done = output.status.success() || output.status.code() == Some(4);
    assert!(done, "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    (seconds, String::from_utf8(output.stdout).expect("UTF-8"))
}

fn row(what: &str, mut seconds: Vec<f64>, asked: &str) {
    seconds.sort_by(f64::total_cmp);
    let (least, most) = (seconds[0], seconds[seconds.len() - 1]);
    let median = seconds[seconds.len() / 2];
    println!("| {what} | {median:.3} | {least:.3}-{most:.3} | {} | {asked} |", seconds.len());
}

fn main() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    println!("| what | median, s | range, s | runs | asked |\n|---|---|---|---|---|");

    let version = || timed(folder, &["--version"]).0;
    row("start of the program (`--version`)", (0..SHORT_RUNS).map(|_| version()).collect(), "0.05");

    let anew = ["pipeline", "--coverage", "sparse", "--no-cache", "--json"];
    let runs: Vec<(f64, Value)> = (0..RUNS).map(|_| recorded(folder, &anew)).collect();
    row("`pipeline --coverage sparse`, from nothing", runs.iter().map(|r| r.0).collect(), "25");
    for stage in ["drop", "trace", "signature", "picture"] {
        let seconds = runs.iter().map(|r| stage_seconds(&r.1, stage)).collect();
        row(&format!("- its stage {stage}"), seconds, "");
    }

    let cached = ["pipeline", "--coverage", "sparse", "--out", "cached"];
    timed(folder, &cached);
    let again = (0..RUNS).map(|_| timed(folder, &cached).0).collect();
    row("the same with a warm cache", again, "1");

    let trace = ["trace", "cached/scene.json", "--out", "table.json"];
    let traced = (0..RUNS).map(|_| timed(folder, &trace).0).collect();
    row("`trace` alone to .005, meshes read and trees built", traced, "2");

    for (packings, tolerance, asked) in [("4", "0.01", "15"), ("7", "0.005", "40")] {
        let runs: Vec<(f64, Value)> = (1..=RUNS)
            .map(|seed| {
                let seed = seed.to_string();
                let several = ["--packings", packings, "--tolerance", tolerance, "--seed", &seed];
                recorded(folder, &[&anew[..], &several].concat())
            })
            .collect();
        let reached = runs.iter().filter(|r| r.1["reached"]["sparse"]["tolerance_reached"] == true);
        let what = format!(
            "`--packings {packings} --tolerance {tolerance}`, seeds 1 to {RUNS}, reached by {}",
            reached.count()
        );
        row(&what, runs.iter().map(|r| r.0).collect(), asked);
    }

    for (coverage, grains, asked) in
        [("sparse", 30, "4"), ("sparse", 60, "9"), ("full", 60, "20"), ("sparse", 250, "60")]
    {
        let scene = of_grains(folder, coverage, grains);
        let args = ["pipeline", "--scene", &scene, "--no-cache", "--packings", "1", "--json"];
        let runs = (0..RUNS).map(|_| stage_seconds(&recorded(folder, &args).1, "drop")).collect();
        row(&format!("{coverage}, {grains} grains, from the start to the export"), runs, asked);
    }
}

/// Wall time and the record of a run.
fn recorded(folder: &Path, args: &[&str]) -> (f64, Value) {
    let (seconds, text) = timed(folder, args);
    (seconds, serde_json::from_str(&text).expect("JSON"))
}

fn stage_seconds(record: &Value, stage: &str) -> f64 {
    let stages = record["stages"].as_array().expect("stages").iter();
    let seconds = stages.filter(|s| s["name"] == stage).map(|s| s["seconds"].as_f64());
    seconds.sum::<Option<f64>>().expect("a time")
}

/// A shipped scene with another number of grains, in a tray of proportional area.
fn of_grains(folder: &Path, coverage: &str, grains: u64) -> String {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{coverage}.json"));
    let text = std::fs::read_to_string(shipped).expect("a shipped scene");
    let mut scene: Value = serde_json::from_str(&text).expect("JSON");
    let packing = &mut scene["geometry"]["packing"];
    let (mut before, mut left) = (0, grains);
    let classes = packing["grains"].as_array_mut().expect("classes");
    for (i, class) in classes.iter_mut().enumerate() {
        before += class["count"].as_u64().expect("a count");
        let share = left / (3 - i as u64);
        class["count"] = share.into();
        left -= share;
    }
    for side in packing["tray_um"].as_array_mut().expect("two sides") {
        let scale = (grains as f64 / before as f64).sqrt();
        *side = (side.as_f64().expect("a length") * scale).round().into();
    }
    let path = folder.join(format!("{coverage}_{grains}.json"));
    std::fs::write(&path, scene.to_string()).expect("written");
    path.display().to_string()
}
