//! Runs that are killed, and writes that fail: no half file, no false record, no leftover.
//! `make torture` does the same for longer.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use serde_json::json;

use crate::support::{Found, Place, failing_library, found, killed_after, left_over};

/// A folder with a scene that takes a moment, and a second seed of it.
struct Trial {
    place: Place,
}

impl Trial {
    fn new() -> Self {
        let place = Place::new();
        place.write("pit.obj", PIT);
        place.write("pit.json", scene().to_string());
        fs::create_dir(place.path("tmp")).expect("made");
        Self { place }
    }

    fn command(&self, seed: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
        command.args(["pipeline", "--scene", "pit.json", "--out", "out", "--range", "8-10"]);
        command.args(["--step", "1", "--tolerance", "0.02", "--threads", "1", "--seed", seed]);
        command.current_dir(self.place.folder()).env("SOILSIG_CACHE", self.place.path("cache"));
        command.env("TMPDIR", self.place.path("tmp"));
        command
    }

    fn folders(&self) -> Vec<PathBuf> {
        ["out", "cache", "tmp"].map(|name| self.place.path(name)).into()
    }

    /// Runs to the end, and gives the result.
    fn whole(&self, seed: &str) -> Found {
        let output = self.command(seed).output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        found(&self.place.path("out"))
    }

    /// Nothing of the run before is used.
    fn forget(&self) {
        for folder in ["out", "cache"] {
            let _ = fs::remove_dir_all(self.place.path(folder));
        }
    }

    /// Keeps the result, to begin with it again.
    fn keep(&self) {
        fs::rename(self.place.path("out"), self.place.path("kept")).expect("moved");
    }

    /// The result that was kept, and an empty cache.
    fn begin_again(&self) {
        self.forget();
        // With the copies of its inputs.
        for folder in ["", "inputs"] {
            let to = self.place.path("out").join(folder);
            fs::create_dir(&to).expect("made");
            for entry in fs::read_dir(self.place.path("kept").join(folder)).expect("kept").flatten()
            {
                if entry.path().is_file() {
                    fs::copy(entry.path(), to.join(entry.file_name())).expect("copied");
                }
            }
        }
    }
}

const PIT: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                   usemtl rock\nf 1 2 3 4\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

fn scene() -> serde_json::Value {
    json!({
        "soilsig_scene": 1, "name": "pit", "seed": 1, "temperature_k": 300,
        "view": {"zenith_deg": 0},
        "materials": [{"name": "rock", "spectrum": {"constant": 0.5}}],
        "geometry": {"placed": {
            "prototypes": [{"name": "pit", "file": "pit.obj", "unit_um": 1000}]
        }}
    })
}

#[test]
fn a_killed_run_leaves_no_half_result() {
    let trial = Trial::new();
    let second = trial.whole("2");
    trial.forget();
    let first = trial.whole("1");
    assert_ne!(first, second);
    trial.keep();
    for time in [2, 8, 20, 40, 70, 110, 160, 230, 320, 450] {
        trial.begin_again();
        killed_after(&mut trial.command("2"), Duration::from_millis(time));
        let now = found(&trial.place.path("out"));
        assert!([&first, &second, &Found::Nothing].contains(&&now), "after {time} ms: {now:?}");
        assert_eq!(trial.whole("2"), second, "after {time} ms");
        assert_eq!(left_over(&trial.folders()), [""; 0].map(PathBuf::from), "after {time} ms");
    }
}

#[test]
fn a_write_that_fails_leaves_the_earlier_result_as_it_was() {
    const FULL: &str = "28";
    const BROKEN: &str = "5";
    let trial = Trial::new();
    let second = trial.whole("2");
    trial.forget();
    let first = trial.whole("1");
    trial.keep();
    let mut failed = 0;
    for at in (1..).step_by(11) {
        let mut was_reached = false;
        for with in [FULL, BROKEN] {
            trial.begin_again();
            let mut command = trial.command("2");
            command.env("LD_PRELOAD", failing_library()).env("FAIL_AT", at.to_string());
            command.env("FAIL_WITH", with);
            if with == FULL {
                command.env("FAIL_ON", "1");
            }
            let output = command.output().expect("it runs");
            let said = String::from_utf8_lossy(&output.stderr);
            let now = found(&trial.place.path("out"));
            if output.status.success() {
                assert_eq!(now, second, "write {at}, errno {with}");
            } else {
                was_reached = true;
                failed += 1;
                assert_eq!(output.status.code(), Some(1), "write {at}: {said}");
                assert_eq!(said.matches("error: ").count(), 1, "write {at}: {said}");
                assert!(!said.contains("panicked"), "{said}");
                if with == FULL {
                    // The hint is for the place that is full.
                    let of = ["the cache: ", "the folder for temporary files: "];
                    let setting = match of.map(|place| said.contains(place)) {
                        [true, _] => "SOILSIG_CACHE",
                        [_, true] => "TMPDIR",
                        _ => "--out",
                    };
                    assert!(said.contains("full") && said.contains(setting), "{said}");
                }
                assert_eq!(now, first, "write {at}, errno {with}: {said}");
            }
            let lock = trial.place.path("out/.soilsig-lock");
            assert!(!lock.exists(), "write {at}, errno {with}: {said}");
            assert_eq!(trial.whole("2"), second, "write {at}, errno {with}");
            assert_eq!(left_over(&trial.folders()), [""; 0].map(PathBuf::from), "{said}");
        }
        if !was_reached {
            break;
        }
    }
    assert!(failed > 6, "only {failed} writes were made to fail");
}
