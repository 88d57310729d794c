//! One job in Blender: what counts as done, and what becomes of every way to fail.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use insta::assert_snapshot;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use soilsig::blender::{Blender, BlenderError, Event, Job, Kind, Search, Version};
use soilsig::cli::interrupt;
use soilsig::cli::terminal::Terminal;
use soilsig::support::error::{Failure, Status};
use soilsig::support::monitor::Unwatched;

use super::fake::Fake;
use crate::support::{message, real_blenders};

const DONE: &str = r#"echo '@soilsig {"event":"done","files":["bed.obj"]}'"#;

/// What a run left behind.
struct Run {
    result: Result<Vec<String>, BlenderError>,
    events: Vec<Event>,
    log: String,
}

fn blender_at(path: &Path) -> Blender {
    Blender {
        kind: Kind::Executable,
        path: path.to_owned(),
        version: Version { major: 3, minor: 4, patch: 1 },
        python: "3.11.2".into(),
        numpy: "1.24.2".into(),
    }
}

fn run_within(fake: &Fake, time_limit: Duration, on_event: &mut dyn FnMut(&Event)) -> Run {
    let out = fake.folder.path().join("out");
    fs::create_dir_all(&out).unwrap();
    let log = fake.folder.path().join("logs/blender.log");
    let args = vec!["--scene".into(), "scene.json".into()];
    let job = Job { script: "any.py", args, out: &out, log: &log, time_limit, monitor: &Unwatched };
    let mut events = Vec::new();
    let result = blender_at(&fake.path).run(&job, &mut |event| {
        on_event(event);
        events.push(event.clone());
    });
    let log = fs::read(log).map_or(String::new(), |log| String::from_utf8_lossy(&log).into_owned());
    Run { result, events, log }
}

fn run(body: &str) -> Run {
    run_within(&Fake::blender(body), Duration::from_secs(60), &mut |_| ())
}

#[track_caller]
fn failed(body: &str, status: Status) -> String {
    let error = run(body).result.unwrap_err();
    assert_eq!(error.status(), status, "{error}");
    message(&error, error.hint())
}

#[test]
fn a_job_is_done_with_its_last_word_and_its_files() {
    let run = run(&format!(
        r#"echo '@soilsig {{"event":"progress","stage":"drop","done":1,"total":2}}'
        echo 'Saved "bed.blend"'; echo 'a complaint' >&2
        echo '@soilsig {{"event":"warning","message":"creeping"}}'
        echo v > "$out/bed.obj"; {DONE}; printf '\nBlender quit'"#
    ));
    assert_eq!(run.result.unwrap(), ["bed.obj"]);
    assert_eq!(run.events.len(), 3);
    assert_eq!(run.events[1], Event::Warning { message: "creeping".into() });
    assert_eq!(run.events[0], Event::Progress { stage: "drop".into(), done: 1, total: 2 });
    for words in ["--python-exit-code", "--scene", "Saved \"bed.blend\"", "a complaint", "quit"] {
        assert!(run.log.contains(words), "no {words} in the log:\n{}", run.log);
    }
    assert!(!run.log.contains("@soilsig"), "{}", run.log);
}

#[test]
fn the_exit_code_is_asked_for_before_the_script_is_named() {
    let fake = Fake::blender(&format!(
        "printf '%s\\n' \"$@\" > \"$here/args\"; echo v > \"$out/bed.obj\"; {DONE}"
    ));
    run_within(&fake, Duration::from_secs(60), &mut |_| ()).result.unwrap();
    let args = fake.note("args");
    let at = |word: &str| args.lines().position(|line| line == word).expect(word);
    assert!(at("--python-exit-code") < at("--python"), "{args}");
    assert!(at("--python") < at("--") && at("--") < at("--scene"), "{args}");
}

#[test]
fn events_arrive_while_the_job_runs() {
    let fake = Fake::blender(&format!(
        r#"echo '@soilsig {{"event":"warning","message":"waiting"}}'
        until [ -e "$here/heard" ]; do sleep 0.02; done; echo v > "$out/bed.obj"; {DONE}"#
    ));
    let heard = fake.folder.path().join("heard");
    let run = run_within(&fake, Duration::from_secs(60), &mut |event| {
        if matches!(event, Event::Warning { .. }) {
            fs::write(&heard, "").unwrap();
        }
    });
    run.result.unwrap();
}

#[test]
fn garbage_is_logged_and_does_no_harm() {
    let run = run(&format!(
        r#"echo '@soilsig {{"event":"done","files":['; echo '@soilsig nonsense'
        echo '@soilsig {{"event":"sung"}}'; printf '\377\376\000\n'
        head -c 300000 /dev/zero | tr '\000' 'x'; echo
        echo v > "$out/bed.obj"; printf 'Fra:1 '; {DONE}"#
    ));
    assert_eq!(run.result.unwrap(), ["bed.obj"]);
    assert!(run.log.contains("@soilsig nonsense") && run.log.contains("Fra:1"));
}

#[test]
fn an_error_of_the_script_is_passed_on_with_its_remedy() {
    let report = |kind: &str| {
        format!(
            r#"echo '@soilsig {{"event":"error","kind":"{kind}","message":"the tale","hint":"the cure"}}'; exit 13"#
        )
    };
    let mut told = String::new();
    for (kinds, status) in [
        (&["scene", "internal", "of_tomorrow"][..], Status::BlenderScript),
        (&["not_settled", "escaped", "overlap", "sunk", "floating", "nan"], Status::BlenderRefused),
        (&["numpy"], Status::BlenderNumpy),
        (&["version"], Status::BlenderVersion),
    ] {
        for kind in kinds {
            told += &format!("{kind}: {}", failed(&report(kind), status));
        }
    }
    assert_snapshot!(told);
}

#[test]
fn a_traceback_is_told_by_its_last_line_wherever_it_was_printed() {
    let [out, err] = [1, 2].map(|stream| {
        let body = format!(
            "{{ echo 'Traceback (most recent call last):'; echo '  File \"x.py\", line 1'
            echo 'KeyError: 7'; echo; echo 'Error: script failed, exiting.'; }} >&{stream}; exit 13"
        );
        failed(&body, Status::BlenderScript)
    });
    assert_eq!(out, err);
    assert_snapshot!(out + &failed("exit 3", Status::BlenderScript));
}

#[test]
fn exit_status_0_alone_is_no_success() {
    let unfinished = failed("echo v > \"$out/bed.obj\"", Status::BlenderScript);
    let missing = failed(DONE, Status::BlenderScript);
    let empty = failed(&format!(": > \"$out/bed.obj\"; {DONE}"), Status::BlenderScript);
    let folder = failed(&format!("mkdir \"$out/bed.obj\"; {DONE}"), Status::BlenderScript);
    assert_eq!([&empty, &folder], [&missing; 2]);
    let done_but = format!("echo v > \"$out/bed.obj\"; {DONE}; exit 1");
    let done_but = failed(&done_but, Status::BlenderScript);
    let in_vain = format!(
        r#"echo v > "$out/bed.obj"; {DONE}; echo '@soilsig {{"event":"error","kind":"nan","message":"m"}}'"#
    );
    let in_vain = failed(&in_vain, Status::BlenderRefused);
    assert_snapshot!([unfinished, missing, done_but, in_vain].concat());
}

#[test]
fn a_crash_is_told_by_its_signal() {
    let crashed = |tail: &str| {
        failed(&format!("echo v > \"$out/bed.obj\"; {DONE}; {tail}"), Status::BlenderCrash)
    };
    let told = [
        crashed("kill -SEGV $$"),
        crashed("kill -KILL $$"),
        // A wrapper script around the crash.
        crashed("sh -c 'kill -ABRT $$'; exit $?"),
    ];
    assert_snapshot!(told.concat());
}

/// Notes its own id and that of a child, then hangs with it.
const HANG: &str = "echo $$ > \"$here/ids\"; sleep 600 & echo $! >> \"$here/ids\"; wait";

/// The processes that [`HANG`] noted, once both are there.
fn ids(fake: &Fake) -> Vec<i32> {
    let until = Instant::now() + Duration::from_secs(30);
    loop {
        let ids: Vec<i32> = fake.note("ids").lines().filter_map(|line| line.parse().ok()).collect();
        if ids.len() == 2 {
            return ids;
        }
        assert!(Instant::now() < until, "the fake did not start");
        thread::sleep(Duration::from_millis(20));
    }
}

fn lives(id: i32) -> bool {
    // A process that nobody has waited for yet is dead for our purpose.
    fs::read_to_string(format!("/proc/{id}/stat"))
        .is_ok_and(|stat| !stat.rsplit(')').next().unwrap().trim_start().starts_with('Z'))
}

#[track_caller]
fn assert_soon_dead(ids: &[i32]) {
    let until = Instant::now() + Duration::from_secs(10);
    while ids.iter().any(|id| lives(*id)) {
        assert!(Instant::now() < until, "still alive: {ids:?}");
        thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_hang_is_ended_with_all_its_children() {
    let mut told = BTreeSet::new();
    // The second one does not listen to a request.
    for body in [HANG, &format!("trap '' TERM; {HANG}")] {
        let fake = Fake::blender(body);
        let run = run_within(&fake, Duration::from_secs(1), &mut |_| ());
        let error = run.result.unwrap_err();
        assert_eq!(error.status(), Status::BlenderTimeout);
        told.insert(message(&error, error.hint()));
        assert_soon_dead(&ids(&fake));
    }
    assert_eq!(told.len(), 1);
    assert_snapshot!(told.first().unwrap());
}

#[test]
fn a_blender_that_chatters_is_ended_at_its_limit_too() {
    let fake = Fake::blender("while :; do echo x; done");
    let run = run_within(&fake, Duration::from_millis(500), &mut |_| ());
    assert_eq!(run.result.unwrap_err().status(), Status::BlenderTimeout);
}

#[test]
fn a_child_left_behind_neither_holds_the_result_up_nor_stays() {
    let fake = Fake::blender(&format!(
        "echo $$ > \"$here/ids\"; sleep 600 & echo $! >> \"$here/ids\"
        echo v > \"$out/bed.obj\"; {DONE}"
    ));
    // Held up it would come to the limit, long before the child ends.
    run_within(&fake, Duration::from_secs(60), &mut |_| ()).result.unwrap();
    assert_soon_dead(&ids(&fake));
}

/// What a fake may find in its environment; the last three are its shell's.
const ALLOWED: [&str; 13] = [
    "PATH",
    "HOME",
    "LC_ALL",
    "TMPDIR",
    "BLENDER_USER_RESOURCES",
    "PYTHONHASHSEED",
    "PYTHONUNBUFFERED",
    "LD_LIBRARY_PATH",
    "OPENBLAS_CORETYPE",
    "OPENBLAS_L2_SIZE",
    "PWD",
    "SHLVL",
    "_",
];

#[test]
fn blender_gets_a_clean_environment_and_no_input() {
    let fake = Fake::blender(&format!(
        "env > \"$here/env\"; cat > \"$here/input\"; echo v > \"$out/bed.obj\"; {DONE}"
    ));
    run_within(&fake, Duration::from_secs(60), &mut |_| ()).result.unwrap();
    let env = fake.note("env");
    for line in env.lines() {
        let name = line.split('=').next().unwrap();
        assert!(ALLOWED.contains(&name), "{line}");
    }
    assert!(env.lines().any(|line| line == "PATH=/usr/bin:/bin"), "{env}");
    assert!(env::var_os("CARGO_MANIFEST_DIR").is_some(), "the test's own is not clean");
    let scratch = env.lines().find_map(|line| line.strip_prefix("TMPDIR=")).unwrap();
    assert!(!Path::new(scratch).exists(), "{scratch} was left behind");
    assert_eq!(fs::read(fake.folder.path().join("input")).unwrap(), b"");
}

#[test]
fn a_log_that_cannot_be_written_is_an_error_of_files() {
    let fake = Fake::blender(DONE);
    fs::write(fake.folder.path().join("logs"), "in the way").unwrap();
    let error = run_within(&fake, Duration::from_secs(60), &mut |_| ()).result.unwrap_err();
    assert_eq!(error.status(), Status::Files);
    assert_eq!(fake.starts(), 0);
    assert_snapshot!(message(&error, error.hint()));
}

/// Names the fake that a second process of this test is to run.
const ROLE: &str = "SOILSIG_TEST_ROLE";

/// Runs this very test in a second process, which runs the fake; gives what `signal` makes of it.
fn in_a_second_process(test: &str, fake: &Fake, signal: Signal) -> Option<i32> {
    let mut second = Command::new(env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture"])
        .env(ROLE, &fake.path)
        // What a killed process leaves behind goes with the fake.
        .env("TMPDIR", fake.folder.path())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    ids(fake);
    kill(Pid::from_raw(second.id().cast_signed()), signal).unwrap();
    second.wait().unwrap().code()
}

/// The part of the second process: ends with the status of the run.
fn play_the_role() {
    let Some(path) = env::var_os(ROLE).map(PathBuf::from) else { return };
    interrupt::install();
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("blender.log");
    let time_limit = Duration::from_secs(60);
    let job = Job {
        script: "any.py",
        args: Vec::new(),
        out: folder.path(),
        log: &log,
        time_limit,
        monitor: &Terminal::default(),
    };
    let status = blender_at(&path).run(&job, &mut |_| ()).unwrap_err().status();
    drop(folder);
    std::process::exit(status as i32);
}

#[test]
fn an_interrupt_ends_blender() {
    play_the_role();
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let fake = Fake::blender(HANG);
        let status =
            in_a_second_process("blender_control::jobs::an_interrupt_ends_blender", &fake, signal);
        assert_eq!(status, Some(Status::Interrupted as i32));
        assert_soon_dead(&ids(&fake));
    }
}

#[test]
fn blender_does_not_outlive_a_killed_soilsig() {
    play_the_role();
    let fake = Fake::blender(HANG);
    in_a_second_process(
        "blender_control::jobs::blender_does_not_outlive_a_killed_soilsig",
        &fake,
        Signal::SIGKILL,
    );
    let ids = ids(&fake);
    assert_soon_dead(&ids[..1]);
    // What Blender starts itself is beyond the system's help; Blender starts nothing.
    let _ = kill(Pid::from_raw(ids[1]), Signal::SIGKILL);
}

#[test]
fn a_failure_in_a_real_blender_is_told_in_one_line() {
    for path in real_blenders() {
        let folder = tempfile::tempdir().unwrap();
        let blender =
            Search::new(Some(&path), &folder.path().join("cache")).find(&Unwatched).unwrap();
        let log = folder.path().join("blender.log");
        let scene = folder.path().join("nowhere.json");
        for (script, words) in [("drop.py", "nowhere.json"), ("absent.py", "absent.py")] {
            let args = vec!["--scene".into(), scene.clone().into()];
            let time_limit = Duration::from_secs(60);
            let job = Job {
                script,
                args,
                out: folder.path(),
                log: &log,
                time_limit,
                monitor: &Unwatched,
            };
            let error = blender.run(&job, &mut |_| ()).unwrap_err();
            assert_eq!(error.status(), Status::BlenderScript, "{error}");
            assert!(error.to_string().contains(words), "{error}");
            assert_eq!(error.log(), Some(log.as_path()));
            assert!(log.exists());
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
    }
}
