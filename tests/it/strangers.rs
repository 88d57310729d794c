//! Files of strangers: records, caches, result folders and names that were made to do harm.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;

use serde_json::{Value, json};
use soilsig::blender::Search;
use soilsig::support::monitor::Unwatched;
use soilsig::support::output;

use crate::blender_control::fake::Fake;
use crate::support::{Place, executable, shipped, shipped_json};

/// A result of the shipped patch in `r`, and its record.
fn result(place: &Place) -> Value {
    let scene = shipped("settled_patch.json");
    let args = ["pipeline", "--scene", &scene, "--out", "r", "--tolerance", "0.05"];
    place.run(&[&args[..], &["--range", "9-9"]].concat(), 0);
    place.json("r/run.json")
}

/// A script that leaves a trace where it is started.
fn trap(place: &Place) -> String {
    let path = place.path("trap.sh");
    executable(&path, &format!("echo \"$0\" >> '{}'", place.path("sprung").display()));
    path.display().to_string()
}

fn is_sprung(place: &Place) -> bool {
    place.path("sprung").exists()
}

#[test]
fn a_record_does_not_choose_the_program_that_replays_it() {
    let place = Place::new();
    let mut record = result(&place);
    record["options"]["blender"] = trap(&place).into();
    record["options"]["source"] = json!({"scene": shipped("small.json")});
    record["inputs"] = json!({});
    place.write("run.json", record.to_string());
    let mut command = place.soilsig(&["replay", "run.json"]);
    let output = command.env("SOILSIG_BLENDER", "/nowhere/blender").output().expect("it runs");
    assert_eq!(output.status.code(), Some(10), "{output:?}");
    assert!(!is_sprung(&place));
    // What the user names is started.
    let trap = trap(&place);
    place.run(&["replay", "run.json", "--blender", &trap], 10);
    assert!(is_sprung(&place));
}

#[test]
fn a_list_of_known_blenders_does_not_choose_the_program() {
    let place = Place::new();
    let fake = Fake::blender("exit 1");
    let cache = place.path("cache");
    let find = || {
        let search = Search::new(Some(&fake.path), &cache);
        search.find(&Unwatched).expect("it is there").path
    };
    assert_eq!(find(), fake.path);
    assert_eq!((find(), fake.starts()), (fake.path.clone(), 1), "it is remembered");
    let list = cache.join("blenders.json");
    let text = fs::read_to_string(&list).expect("written");
    let path = format!("\"path\": \"{}\"", fake.path.display());
    let (stamp, blender) = text.rsplit_once(&path).expect("the path of the Blender");
    let text = format!("{stamp}\"path\": \"{}\"{blender}", trap(&place));
    fs::write(&list, text).expect("written");
    assert_eq!(find(), fake.path);
    assert!(!is_sprung(&place));
    assert_eq!(fake.starts(), 2, "it was asked again");
    // A folder that others may write to is not believed either.
    fs::set_permissions(&cache, PermissionsExt::from_mode(0o777)).expect("set");
    assert_eq!((find(), fake.starts()), (fake.path.clone(), 3));
}

#[test]
fn a_record_deletes_only_what_a_run_wrote_there() {
    let place = Place::new();
    let record = result(&place);
    fs::create_dir(place.path("home")).expect("made");
    let written = [
        // Outside, by a link and by its path; names that no run writes; another content.
        ("home/table.json", "lnk/table.json", true),
        ("home/budget.csv", "../home/budget.csv", true),
        ("r/thesis.txt", "thesis.txt", true),
        ("r/.profile", ".profile", true),
        ("r/scene.glb", "scene.glb", false),
    ];
    symlink(place.path("home"), place.path("r/lnk")).expect("a link");
    let mut record = record;
    for (file, name, is_right) in written {
        place.write(file, "mine");
        let sum = if is_right {
            output::sha256_hex(&place.path(file)).expect("read")
        } else {
            "0".repeat(64)
        };
        record["outputs"][name] = json!({"sha256": sum, "reproducible": true});
    }
    // What a run wrote and this one does not.
    fs::create_dir_all(place.path("r/packings/2")).expect("made");
    place.write("r/packings/2/table.json", "old");
    let sum = output::sha256_hex(&place.path("r/packings/2/table.json")).expect("read");
    record["outputs"]["packings/2/table.json"] = json!({"sha256": sum, "reproducible": true});
    place.write("r/run.json", record.to_string());
    result(&place);
    for (file, ..) in written {
        assert_eq!(place.read(file), "mine", "{file}");
    }
    assert!(!place.path("r/packings").exists());
}

/// What is refused names the link, and nothing is written through it.
#[test]
fn no_link_inside_a_result_is_written_through() {
    let place = Place::new();
    place.write("mine", "mine");
    let scene = shipped("settled_patch.json");
    let commands: [(&[&str], &str); 3] = [
        (&["pipeline", "--scene", &scene, "--range", "9-9", "--out"], "signature.csv"),
        (&["image", &scene, "--pixels", "4x4", "--range", "9-9", "--out"], "radiance.img"),
        (&["export", &scene, "--to", "mitsuba"], "scene.xml"),
    ];
    for (number, (args, file)) in commands.into_iter().enumerate() {
        let out = format!("out{number}");
        fs::create_dir(place.path(&out)).expect("made");
        symlink(place.path("mine"), place.path(&out).join(file)).expect("a link");
        let (_, said) = place.run(&[args, &[&out]].concat(), 1);
        assert!(said.contains(file) && said.contains("link"), "{said}");
        assert_eq!(place.read("mine"), "mine");
    }
}

#[test]
fn a_cache_of_others_is_refused() {
    let place = Place::new();
    result(&place);
    let scene = shipped("settled_patch.json");
    let args = ["pipeline", "--scene", &scene, "--out", "r", "--range", "9-9"];
    let set = |mode| {
        fs::set_permissions(place.path("cache"), PermissionsExt::from_mode(mode)).expect("set");
    };
    let made = fs::metadata(place.path("cache")).expect("there").permissions().mode();
    assert_eq!(made & 0o777, 0o700);
    for mode in [0o777, 0o775, 0o1777] {
        set(mode);
        let (_, said) = place.run(&args, 1);
        assert!(said.contains("others may write") && said.contains("--no-cache"), "{said}");
        place.run(&[&args[..], &["--no-cache"]].concat(), 0);
    }
    set(0o700);
    fs::set_permissions(place.folder(), PermissionsExt::from_mode(0o777)).expect("set");
    let (_, said) = place.run(&args, 1);
    assert!(said.contains("others may write to"), "{said}");
    fs::set_permissions(place.folder(), PermissionsExt::from_mode(0o700)).expect("set");
    // Root alone can give a folder away.
    if nix::unistd::geteuid().is_root() {
        std::os::unix::fs::chown(place.path("cache"), Some(12_345), None).expect("root may");
        let (_, said) = place.run(&args, 1);
        assert!(said.contains("belongs to another user (uid 12345)"), "{said}");
    }
}

#[test]
fn a_record_by_another_hand_is_refused_by_its_key() {
    let place = Place::new();
    let record = result(&place);
    for (key, value) in [
        ("packings", json!(0)),
        ("packings", json!(-1)),
        ("packings", json!(1_000_000)),
        ("blender_timeout_s", json!(u64::MAX)),
        ("blender_timeout_s", json!(0)),
        ("max_seconds", json!(-1.0)),
        ("max_paths", json!(0)),
        ("field", json!(1e300)),
        ("tolerance", json!(1.0)),
    ] {
        let mut record = record.clone();
        record["options"][key] = value;
        place.write("run.json", record.to_string());
        let (_, said) = place.run(&["replay", "run.json"], 3);
        assert!(said.contains(key), "{said}");
    }
    // Beyond what a clock can tell: no limit.
    let mut record = record;
    record["options"]["max_seconds"] = json!(1e300);
    place.write("run.json", record.to_string());
    place.run(&["replay", "run.json"], 0);
}

#[test]
fn an_input_of_a_record_that_is_no_file_is_not_read() {
    let place = Place::new();
    let mut record = result(&place);
    record["inputs"]["/dev/zero"] = "0".repeat(64).into();
    place.write("run.json", record.to_string());
    let (_, said) = place.run(&["replay", "run.json"], 1);
    assert!(said.contains("/dev/zero") && said.contains("not a file"), "{said}");
}

/// Formats have a greatest width.
#[test]
fn a_name_of_any_length_is_printed() {
    let place = Place::new();
    let mut scene = shipped_json("settled_patch.json");
    scene["name"] = "n".repeat(100_000).into();
    place.write("settled_patch.obj", fs::read(shipped("settled_patch.obj")).expect("shipped"));
    place.write("scene.json", scene.to_string());
    place.run(&["trace", "scene.json", "--out", "t.json", "--paths", "256"], 0);
}

#[test]
fn names_of_strangers_do_not_steer_the_terminal() {
    let place = Place::new();
    let name = "\u{1b}]0;owned\u{7}\u{1b}[2J\nerror: none\r\u{202e}";
    let mut record = result(&place);
    record["outputs"][name] = record["outputs"]["table.json"].clone();
    place.write("run.json", record.to_string());
    let (out, err) = place.run(&["replay", "run.json"], 5);
    let mut scene: Value =
        serde_json::from_str(&fs::read_to_string(shipped("settled_patch.json")).expect("shipped"))
            .expect("JSON");
    scene["materials"][0]["name"] = name.into();
    place.write("scene.json", scene.to_string());
    let (_, refused) = place.run(&["trace", "scene.json", "--out", "t.json"], 3);
    for said in [&out, &err, &refused] {
        assert!(!said.contains(['\u{1b}', '\u{7}', '\r', '\u{202e}']), "{said:?}");
        assert!(!said.contains("\nerror: none"), "{said:?}");
    }
    assert!(out.contains("\\u001b]0;owned"), "{out}");
    assert!(Path::new(&place.path("t.json")).symlink_metadata().is_err());
}
