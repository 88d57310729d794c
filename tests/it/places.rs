//! Where results go: devices, pipes, links, folders that another run has, folders that are not
//! there; and what a run needs around it.

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::sys::stat::Mode;
use nix::unistd::{Pid, mkfifo};
use soilsig::support::lock::Lock;

use crate::blender_control::fake::Fake;
use crate::support::{Place, shipped};

fn trace<'a>(scene: &'a str, out: &'a str) -> Vec<&'a str> {
    vec!["trace", scene, "--tolerance", "0.05", "--range", "9-9", "--out", out]
}

/// A table to evaluate, `t.json`.
fn table(place: &Place) {
    place.run(&trace(&shipped("settled_patch.json"), "t.json"), 0);
}

const EVALUATE: [&str; 5] = ["signature", "t.json", "--range", "9-9", "--out"];

#[test]
fn devices_and_pipes_are_written_to_and_stay() {
    let place = Place::new();
    table(&place);
    symlink("/dev/null", place.path("null")).expect("a link");
    let evaluate = |out: &str, status| place.run(&[&EVALUATE[..], &[out]].concat(), status);
    for out in ["/dev/null", "null"] {
        evaluate(out, 0);
        let kind = fs::metadata(place.path(out)).ok();
        assert!(kind.is_none_or(|of| of.file_type().is_char_device()));
        assert!(fs::metadata("/dev/null").expect("there").file_type().is_char_device());
    }
    assert!(place.path("null").is_symlink());
    place.run(&trace(&shipped("settled_patch.json"), "null"), 0);
    assert!(place.path("null").is_symlink() && !place.path("null.partial").exists());
    let (_, said) = evaluate("/dev/full", 1);
    assert!(said.contains("/dev/full") && said.contains("No space left"), "{said}");
    let (out, _) = evaluate("/dev/stdout", 0);
    assert!(out.starts_with("wavelength_um,"), "{out}");

    mkfifo(&place.path("pipe"), Mode::S_IRWXU).expect("a pipe");
    let pipe = place.path("pipe");
    let reader = std::thread::spawn(move || {
        let mut text = String::new();
        File::open(pipe).expect("a pipe").read_to_string(&mut text).expect("text");
        text
    });
    evaluate("pipe", 0);
    assert!(reader.join().expect("read").starts_with("wavelength_um,"));
    let kind = fs::symlink_metadata(place.path("pipe")).expect("there").file_type();
    assert!(kind.is_fifo());
}

#[test]
fn links_are_followed_and_modes_are_kept() {
    let place = Place::new();
    table(&place);
    let evaluate = |out: &str| place.run(&[&EVALUATE[..], &[out]].concat(), 0);
    fs::create_dir(place.path("there")).expect("made");
    symlink("there", place.path("folder")).expect("a link");
    symlink("there/file.csv", place.path("link.csv")).expect("a link");
    let mode = |name: &str| fs::metadata(place.path(name)).expect(name).mode() & 0o777;
    // Through a link that leads nowhere yet, and once more over the file.
    for _ in 0..2 {
        evaluate("link.csv");
        assert!(place.path("link.csv").is_symlink());
        assert!(place.read("there/file.csv").starts_with("wavelength_um,"));
        fs::set_permissions(place.path("there/file.csv"), PermissionsExt::from_mode(0o600))
            .expect("set");
    }
    evaluate("folder/file.csv");
    assert!(place.path("folder").is_symlink());
    assert_eq!(mode("there/file.csv"), 0o600);
    // Another name of the earlier file keeps what it had.
    place.write("one.csv", "earlier");
    fs::hard_link(place.path("one.csv"), place.path("other.csv")).expect("linked");
    evaluate("one.csv");
    assert_eq!(place.read("other.csv"), "earlier");
    // Those of a whole result too.
    let scene = shipped("settled_patch.json");
    let args = ["pipeline", "--scene", &scene, "--range", "9-9", "--out", "folder"];
    place.run(&args, 0);
    fs::set_permissions(place.path("there/signature.csv"), PermissionsExt::from_mode(0o640))
        .expect("set");
    place.run(&args, 0);
    assert_eq!(mode("there/signature.csv"), 0o640);
}

#[test]
fn a_folder_that_another_run_has_is_refused_with_its_process() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let commands: [&[&str]; 3] = [
        &["pipeline", "--scene", &scene, "--range", "9-9", "--out", "r"],
        &["image", &scene, "--pixels", "2x2", "--range", "9-9", "--out", "r"],
        &["export", &scene, "--to", "mitsuba", "r"],
    ];
    let lock = Lock::of(&place.path("r")).expect("free");
    for args in commands {
        let (_, said) = place.run(args, 1);
        let process = format!("process {}", std::process::id());
        assert!(said.contains(&process) && said.contains("another --out"), "{said}");
    }
    drop(lock);
    // The lock of a run that was killed does not block.
    place.write("r/.soilsig-lock", "1\n");
    place.run(commands[0], 0);
    assert!(!place.path("r/.soilsig-lock").exists());
}

#[test]
fn runs_that_race_for_a_folder_and_a_cache_do_not_mix() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let start = |out: &str, seed: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
        command.args(["pipeline", "--scene", &scene, "--range", "9-9", "--tolerance", "0.05"]);
        command.args(["--out", out, "--seed", seed]).current_dir(place.folder());
        command.env("SOILSIG_CACHE", place.path("cache"));
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts")
    };
    let ended = |run: std::process::Child| {
        let output = run.wait_with_output().expect("it ends");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    for _ in 0..3 {
        let runs = [start("r", "5"), start("r", "6")].map(ended);
        let won = runs.iter().filter(|(status, _)| *status == Some(0)).count();
        for (status, said) in &runs {
            let refused = *status == Some(1) && said.contains("another run writes");
            assert!(*status == Some(0) || refused, "{status:?} {said}");
        }
        assert!(won > 0);
        crate::support::found(&place.path("r"));
    }
    fs::remove_dir_all(place.path("cache")).expect("removed");
    for (status, said) in [start("a", "5"), start("b", "5")].map(ended) {
        assert_eq!(status, Some(0), "{said}");
    }
    assert_eq!(place.read("a/table.json"), place.read("b/table.json"));
}

#[test]
fn a_standard_error_that_cannot_be_written_costs_no_result() {
    let place = Place::new();
    let full = || File::options().write(true).open("/dev/full").expect("always full");
    let scene = shipped("settled_patch.json");
    let run = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_soilsig"));
        command.args(args).current_dir(place.folder()).env("SOILSIG_CACHE", place.path("cache"));
        command.stdout(Stdio::null()).stderr(full()).status().expect("it runs").code()
    };
    assert_eq!(run(&trace(&scene, "t.json")), Some(0));
    assert_eq!(run(&[&EVALUATE[..], &["s.csv"]].concat()), Some(0));
    assert_eq!(run(&["pipeline", "--scene", &scene, "--range", "9-9", "--out", "r"]), Some(0));
    assert_eq!(run(&["trace", "gone.json", "--out", "t.json"]), Some(3));
    assert!(place.path("t.json").exists() && place.path("s.csv").exists());
}

#[test]
fn a_signal_is_heard_while_a_read_waits() {
    let place = Place::new();
    let scene = fs::read_to_string(shipped("settled_patch.json")).expect("shipped");
    let mut scene: serde_json::Value = serde_json::from_str(&scene).expect("JSON");
    scene["geometry"]["placed"]["prototypes"][0]["file"] = "pipe.obj".into();
    place.write("scene.json", scene.to_string());
    for pipe in ["pipe.obj", "table.json"] {
        mkfifo(&place.path(pipe), Mode::S_IRWXU).expect("a pipe");
    }
    let commands: [&[&str]; 2] =
        [&["trace", "scene.json", "--out", "t.json"], &["merge", "table.json", "--out", "m.json"]];
    for args in commands {
        for signal in [Signal::SIGTERM, Signal::SIGINT] {
            let mut run = Command::new(env!("CARGO_BIN_EXE_soilsig"))
                .args(args)
                .current_dir(place.folder())
                .stderr(Stdio::null())
                .spawn()
                .expect("it starts");
            std::thread::sleep(Duration::from_millis(300));
            kill(Pid::from_raw(run.id().cast_signed()), signal).expect("it lives");
            let asked = Instant::now();
            assert_eq!(run.wait().expect("it ends").code(), Some(130), "{args:?}");
            assert!(asked.elapsed() < Duration::from_secs(10), "{args:?}");
        }
    }
}

#[test]
fn a_folder_where_a_file_is_and_a_file_where_a_folder_is_are_named() {
    let place = Place::new();
    table(&place);
    fs::create_dir(place.path("folder")).expect("made");
    place.write("file", "mine");
    for (out, hint) in [("folder", "name a file in"), ("file/s.csv", "is no folder")] {
        let told = place.run(&[&EVALUATE[..], &[out]].concat(), 1).1;
        assert!(told.contains(out) && told.contains(hint), "{told}");
    }
    let scene = shipped("settled_patch.json");
    let image = ["image", &scene, "--range", "9-10", "--pixels", "2x2", "--out", "file"];
    let told = place.run(&image, 1).1;
    assert!(told.contains("is no folder"), "{told}");
    assert_eq!(place.read("file"), "mine");
}

#[test]
fn a_missing_folder_for_temporary_files_is_named() {
    let place = Place::new();
    let fake = Fake::blender("exit 1");
    let scene = shipped("small.json");
    let args = ["pipeline", "--scene", &scene, "--out", "r"];
    place.write("file", "");
    let file = place.path("file").display().to_string();
    for folder in ["/no/such/folder", "not/there", &file] {
        let mut command = place.soilsig_with(&fake.path, &args);
        let output = command.env("TMPDIR", folder).output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("TMPDIR") && said.contains(folder), "{said}");
    }
}

#[test]
fn a_cache_is_in_a_place_of_the_users_own() {
    let place = Place::new();
    fs::create_dir(place.path("tmp")).expect("made");
    let scene = shipped("settled_patch.json");
    let run = |set: &[(&str, &str)]| {
        let args = ["pipeline", "--scene", &scene, "--out", "r", "--range", "9-9"];
        let mut command = place.soilsig(&args);
        command.env_remove("SOILSIG_CACHE").env_remove("XDG_CACHE_HOME").env_remove("HOME");
        command.env("TMPDIR", place.path("tmp")).envs(set.iter().copied());
        let output = command.output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    // Without a home: for this run, and gone with it.
    run(&[]);
    assert_eq!(fs::read_dir(place.path("tmp")).expect("a folder").count(), 0);
    let home = place.path("home").display().to_string();
    fs::create_dir(&home).expect("made");
    run(&[("XDG_CACHE_HOME", "relative"), ("HOME", &home)]);
    assert!(!place.path("relative").exists() && place.path("home/.cache/soilsig").is_dir());
    let xdg = place.path("xdg").display().to_string();
    run(&[("XDG_CACHE_HOME", &xdg)]);
    assert!(place.path("xdg/soilsig").is_dir());
    run(&[("SOILSIG_CACHE", "here")]);
    assert!(place.path("here").is_dir());
}

/// Wrappers get a cleared environment: the refusal says so.
#[test]
fn a_wrapper_that_lacks_its_environment_is_told_of_it() {
    let place = Place::new();
    let fake = Fake::named("blender", "exec \"${BLENDER_HOME:?is not set}/blender\" \"$@\"");
    let scene = shipped("small.json");
    let mut command = place.soilsig_with(&fake.path, &["pipeline", "--scene", &scene]);
    let output = command.env("BLENDER_HOME", "/usr/bin").output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(10), "{said}");
    for words in ["BLENDER_HOME", "cleared environment", "TMPDIR"] {
        assert!(said.contains(words), "{words} is not in {said}");
    }
}

/// The probe ends with the limit of the user, if that is shorter than its own.
#[test]
fn a_blender_that_does_not_answer_is_ended_at_the_users_limit() {
    let place = Place::new();
    let fake = Fake::named("blender", "sleep 600");
    let scene = shipped("small.json");
    let args = ["pipeline", "--scene", &scene, "--blender-timeout", "1"];
    let began = Instant::now();
    let output = place.soilsig_with(&fake.path, &args).output().expect("it runs");
    assert_eq!(output.status.code(), Some(15), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(began.elapsed() < Duration::from_secs(20));
    std::io::stdout().flush().expect("open");
}

/// A recipe, and a Blender that drops nothing: it notes that it works, and waits.
const WAITS: &str = "echo working > \"$here/working\"; sleep 600";

#[test]
fn an_interrupted_drop_leaves_the_earlier_log() {
    let place = Place::new();
    let fake = Fake::blender(WAITS);
    fs::create_dir(place.path("r")).expect("made");
    place.write("r/blender.log", "of the earlier run");
    place.write("r/run.json", "{}");
    let scene = shipped("small.json");
    let start = || {
        let _ = fs::remove_file(fake.folder.path().join("working"));
        let run = Command::new(env!("CARGO_BIN_EXE_soilsig"))
            .args(["pipeline", "--scene", &scene, "--out", "r"])
            .current_dir(place.folder())
            .env("SOILSIG_CACHE", place.path("cache"))
            .env("SOILSIG_BLENDER", &fake.path)
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let until = Instant::now() + Duration::from_secs(30);
        while !fake.folder.path().join("working").exists() {
            assert!(Instant::now() < until, "the fake did not start");
            std::thread::sleep(Duration::from_millis(20));
        }
        run
    };
    for signal in [Signal::SIGINT, Signal::SIGKILL] {
        let mut run = start();
        // The log of the Blender that works can be read.
        assert!(place.path("r/blender.unfinished.log").exists());
        kill(Pid::from_raw(run.id().cast_signed()), signal).expect("it lives");
        run.wait().expect("it ends");
        assert_eq!(place.read("r/blender.log"), "of the earlier run");
        assert_eq!(place.read("r/run.json"), "{}");
    }
    // The next run clears up, whatever it does.
    place.run(&["pipeline", "--scene", "gone.json", "--out", "r"], 3);
    let left = crate::support::left_over(&[place.path("r")]);
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn a_blender_that_fails_ends_the_others() {
    let place = Place::new();
    // The first to come fails when another works.
    let fake = Fake::blender(
        "if mkdir \"$here/first\" 2>/dev/null; then
             until [ -e \"$here/second\" ]; do sleep 0.02; done
             echo '@soilsig {\"event\":\"error\",\"kind\":\"scene\",\"message\":\"the tale\",\"hint\":null}'
             exit 13
         fi
         echo > \"$here/second\"; sleep 600",
    );
    let scene = shipped("small.json");
    let args = ["pipeline", "--scene", &scene, "--packings", "2", "--threads", "2", "--out", "r"];
    let began = Instant::now();
    let output = place.soilsig_with(&fake.path, &args).output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(13), "{said}");
    assert!(said.contains("the tale"), "{said}");
    assert!(began.elapsed() < Duration::from_secs(60));
}
