//! The workflow for Snakemake: its results are those of `soilsig sweep`.

use std::fs;
use std::path::Path;
use std::process::Command;

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

#[test]
fn snakemake_gives_the_bytes_of_a_sweep() {
    let Some(snakemake) = tool(Tool::Snakemake) else { return };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = Place::new();
    copy(&root.join("workflow"), &place.path("workflow"));
    copy(&root.join(".test"), &place.path(".test"));
    fs::create_dir(place.path("scenes")).expect("made");
    for file in ["settled_patch.json", "settled_patch.obj"] {
        fs::copy(root.join("scenes").join(file), place.path("scenes").join(file)).expect("copied");
    }
    let run = || {
        let mut command = Command::new(&snakemake);
        command.args(["--snakefile", "../workflow/Snakefile", "--cores", "2", "--nocolor"]);
        command.args(["--workflow-profile", "../workflow/profiles/default"]);
        let program = format!("soilsig={}", env!("CARGO_BIN_EXE_soilsig"));
        command.args(["--config", &program]).current_dir(place.path(".test"));
        command.env("SOILSIG_CACHE", place.path("cache")).env("HOME", place.folder());
        let output = command.output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        said
    };
    run();
    place.run(&["sweep", ".test/study.json", "-o", "plain"], 0);
    for file in ["results.csv", "beds.csv", "results.nc", "chart.svg", "report.html"] {
        let read = |out: &str| fs::read(place.path(out).join(file)).expect(file);
        assert_eq!(read("plain"), read(".test/results"), "{file}");
    }
    let said = run();
    assert!(said.contains("Nothing to be done"), "{said}");
    // A part that was lost is made again, and nothing else.
    for file in ["results.parts/2.done", "results/sweep.json"] {
        fs::remove_file(place.path(".test").join(file)).expect("there");
    }
    let said = run();
    assert!(said.contains("rule part") && !said.contains("part=1"), "{said}");
}
