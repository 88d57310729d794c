//! The workflow for Snakemake: its results are those of `soilsig sweep`.

use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::slurm::Slurm;
use crate::support::{Place, Tool, tool};

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("made");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).expect("copied");
        }
    }
}

/// The workflow with a small study.
fn workflow() -> Place {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = Place::new();
    copy(&root.join("workflow"), &place.path("workflow"));
    copy(&root.join(".test"), &place.path(".test"));
    fs::create_dir(place.path("scenes")).expect("made");
    for file in ["settled_patch.json", "settled_patch.obj"] {
        fs::copy(root.join("scenes").join(file), place.path("scenes").join(file)).expect("copied");
    }
    place
}

/// Snakemake with a profile, on a program.
fn command(snakemake: &Path, place: &Place, profile: &str, program: &Path) -> Command {
    let mut command = Command::new(snakemake);
    command.args(["--snakefile", "../workflow/Snakefile", "--nocolor", "--workflow-profile"]);
    command.arg(format!("../workflow/profiles/{profile}"));
    command.args(["--config", &format!("soilsig={}", program.display())]);
    command.current_dir(place.path(".test"));
    command.env("SOILSIG_CACHE", place.path("cache")).env("HOME", place.folder());
    command
}

/// The results are those of a sweep in one run.
fn are_those_of_a_sweep(place: &Place) {
    place.run(&["sweep", ".test/study.json", "-o", "plain"], 0);
    for file in ["results.csv", "beds.csv", "results.nc", "chart.svg", "report.html"] {
        let read = |out: &str| fs::read(place.path(out).join(file)).expect(file);
        assert_eq!(read("plain"), read(".test/results"), "{file}");
    }
}

#[test]
fn snakemake_gives_the_bytes_of_a_sweep() {
    let Some(snakemake) = tool(Tool::Snakemake) else { return };
    let place = workflow();
    let program = Path::new(env!("CARGO_BIN_EXE_soilsig"));
    let run = || {
        let mut command = command(&snakemake, &place, "default", program);
        let output = command.args(["--cores", "2"]).output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        said
    };
    run();
    are_those_of_a_sweep(&place);
    let said = run();
    assert!(said.contains("Nothing to be done"), "{said}");
    // A part that was lost is made again, and nothing else.
    for file in ["results.parts/2.done", "results/sweep.json"] {
        fs::remove_file(place.path(".test").join(file)).expect("there");
    }
    let said = run();
    assert!(said.contains("rule part") && !said.contains("part=1"), "{said}");
}

/// Two nodes on this machine. A job that is cancelled while it runs is given again.
#[test]
fn on_slurm_a_cancelled_job_runs_again_and_the_bytes_are_those_of_a_sweep() {
    let Some(snakemake) = tool(Tool::Snakemake) else { return };
    if tool(Tool::Slurm).is_none() {
        return;
    }
    let place = workflow();
    let slurm = Slurm::start();
    // Each job lasts long enough to be met.
    let slow: PathBuf = place.path("slow");
    let program = env!("CARGO_BIN_EXE_soilsig");
    fs::write(&slow, format!("#!/bin/sh\nsleep 1\nexec '{program}' \"$@\"\n")).expect("written");
    fs::set_permissions(&slow, fs::Permissions::from_mode(0o755)).expect("set");
    let mut path: OsString = slurm.bin().into_os_string();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap_or_default());
    let mut command = command(&snakemake, &place, "slurm", &slow);
    // This cluster keeps no accounts.
    command.args(["--slurm-status-command", "squeue", "--slurm-no-account"]);
    command.args(["--slurm-init-seconds-before-status-checks", "4"]);
    let log = fs::File::create(place.path("log")).expect("made");
    command.env("PATH", path).stdout(Stdio::null()).stderr(log);
    let mut running = command.spawn().expect("it starts");
    let until = Instant::now() + Duration::from_secs(900);
    let mut cancelled = None;
    let status = loop {
        if let Some(status) = running.try_wait().expect("it is there") {
            break status;
        }
        if cancelled.is_none() {
            let jobs = slurm.says("squeue", &["-h", "-t", "running", "-o", "%i"]);
            cancelled = jobs.lines().next().map(str::to_owned);
            if let Some(job) = &cancelled {
                slurm.says("scancel", &[job]);
            }
        }
        if Instant::now() > until {
            running.kill().expect("it is there");
        }
        std::thread::sleep(Duration::from_millis(200));
    };
    let said = fs::read_to_string(place.path("log")).expect("written");
    assert!(status.success(), "{said}");
    assert!(cancelled.is_some() && said.contains("Trying to restart job"), "{said}");
    are_those_of_a_sweep(&place);
}
