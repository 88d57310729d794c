//! How long the pipeline and its stages take, as the user waits for them: medians over several runs of
//! the program itself. `make bench` prints the table of docs/performance.md.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use serde_json::Value;

/// Runs of the whole pipeline.
const RUNS: usize = 5;
/// Runs of what takes a moment only.
const SHORT_RUNS: usize = 20;

/// Wall time in seconds, and what the program printed.
fn timed(folder: &Path, args: &[&str]) -> (f64, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
    command.args(args).current_dir(folder).env("SOILSIG_CACHE", folder.join("cache"));
    let started = Instant::now();
    let output = command.output().expect("it starts");
    let seconds = started.elapsed().as_secs_f64();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
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
    let runs: Vec<(f64, Value)> = (0..RUNS)
        .map(|_| timed(folder, &anew))
        .map(|(seconds, text)| (seconds, serde_json::from_str(&text).expect("JSON")))
        .collect();
    row("`pipeline --coverage sparse`, from nothing", runs.iter().map(|r| r.0).collect(), "25");
    for stage in ["drop", "trace", "signature", "picture"] {
        let of = |record: &Value| {
            let stages = record["stages"].as_array().expect("stages").iter();
            let seconds = stages.filter(|s| s["name"] == stage).map(|s| s["seconds"].as_f64());
            seconds.sum::<Option<f64>>().expect("a time")
        };
        row(&format!("- its stage {stage}"), runs.iter().map(|r| of(&r.1)).collect(), "");
    }

    let cached = ["pipeline", "--coverage", "sparse", "--out", "cached"];
    timed(folder, &cached);
    let again = (0..RUNS).map(|_| timed(folder, &cached).0).collect();
    row("the same with a warm cache", again, "1");

    let trace = ["trace", "cached/scene.json", "--out", "table.json"];
    let traced = (0..RUNS).map(|_| timed(folder, &trace).0).collect();
    row("`trace` alone to .005, meshes read and trees built", traced, "2");
}
