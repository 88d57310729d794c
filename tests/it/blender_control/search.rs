//! The search for a Blender: its order, its refusals, its memory.

use std::fs;
use std::path::Path;
use std::time::Duration;

use insta::assert_snapshot;
use soilsig::blender::{Kind, Search, Version};
use soilsig::support::error::{Failure, Status};
use soilsig::support::monitor::Unwatched;
use tempfile::TempDir;

use super::fake::{Fake, probe_with};
use crate::support::{executable, message, real_blenders};

/// A machine with nothing on it but what a test puts there.
struct Machine(TempDir);

impl Machine {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn search(&self) -> Search {
        Search {
            explicit: None,
            variable: None,
            interpreter: None,
            path: Some(self.0.path().join("bin").into()),
            folder: self.0.path().to_owned(),
            cache: self.0.path().join("cache"),
            afresh: false,
            patience: Duration::from_secs(60),
        }
    }

    fn install(&self, name: &str, body: &str) {
        let path = self.0.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        executable(&path, body);
    }

    /// Installs a Python that says that it has `bpy`.
    fn install_bpy(&self, name: &str, version: &str) {
        let path = self.0.path().join(name);
        let answer = format!(r#"{{"interpreter":"{0}","bpy":"{0}"}}"#, path.display());
        let question = format!("case \"$1\" in -c) echo '{answer}'; exit 0;; esac");
        self.install(name, &format!("{question}\n{}", probe_with(version, "\"2.0.0\"")));
    }
}

#[track_caller]
fn refused(search: &Search, status: Status) -> String {
    let error = search.find(&Unwatched).unwrap_err();
    let hint = error.hint().expect("every refusal names its remedy");
    assert_eq!(error.status(), status, "{error}");
    message(&error, Some(hint))
}

#[test]
fn nothing_there_names_every_place() {
    let machine = Machine::new();
    assert_snapshot!(refused(&machine.search(), Status::BlenderMissing));
}

#[test]
fn a_choice_that_fails_is_not_replaced_by_another_blender() {
    let machine = Machine::new();
    machine.install("bin/blender", &probe_with("3.4.1", "\"1.24.2\""));
    assert!(machine.search().find(&Unwatched).is_ok());
    let mut told = String::new();
    for choice in ["/nowhere/blender", "blender-5.9"] {
        let by_flag = Search { explicit: Some(choice.into()), ..machine.search() };
        told += &refused(&by_flag, Status::BlenderMissing);
        let by_variable = Search { variable: Some(choice.into()), ..machine.search() };
        told += &refused(&by_variable, Status::BlenderMissing);
    }
    assert_snapshot!(told);
}

#[test]
fn the_flag_comes_before_the_variable_and_that_before_the_path() {
    let machine = Machine::new();
    for (name, version) in [("bin/blender", "3.4.1"), ("a", "4.5.1"), ("b", "4.5.2")] {
        machine.install(name, &probe_with(version, "\"1.24.2\""));
    }
    let found = |search: Search| search.find(&Unwatched).unwrap().version.to_string();
    assert_eq!(found(machine.search()), "3.4.1");
    let variable = Some(machine.0.path().join("a").into());
    let search = Search { variable, ..machine.search() };
    assert_eq!(found(search.clone()), "4.5.1");
    let explicit = Some(machine.0.path().join("b").into());
    assert_eq!(found(Search { explicit, ..search }), "4.5.2");
}

#[test]
fn a_program_that_is_no_blender_is_refused_with_its_own_words() {
    let mut told = String::new();
    for body in [
        "exit 0",
        "echo 'unknown option --background' >&2; exit 2",
        "echo '@soilsig {\"event\":\"probe\"'",
    ] {
        let fake = Fake::named("true", body);
        let search = Search { explicit: Some(fake.path.clone().into()), ..Machine::new().search() };
        told += &refused(&search, Status::BlenderMissing);
    }
    assert_snapshot!(told);
}

#[test]
fn an_old_blender_is_refused_by_its_version() {
    let too_old_for_the_probe = "echo 'Blender 2.79 (sub 0)'; echo 'SyntaxError: f'; exit 13";
    let mut told = String::new();
    for body in [probe_with("3.3.21", "\"1.24.2\""), too_old_for_the_probe.into()] {
        let fake = Fake::named("blender", &body);
        let search = Search { explicit: Some(fake.path.clone().into()), ..Machine::new().search() };
        told += &refused(&search, Status::BlenderVersion);
    }
    assert_snapshot!(told);
}

#[test]
fn an_untested_blender_will_do_with_a_warning() {
    let machine = Machine::new();
    machine.install("bin/blender", &probe_with("6.0.0", "\"3.0.0\""));
    let warning = machine.search().find(&Unwatched).unwrap().warning().unwrap();
    assert_snapshot!(warning);
    machine.install("bin/blender", &probe_with("4.5.15", "\"3.0.0\""));
    assert_eq!(machine.search().find(&Unwatched).unwrap().warning(), None);
}

#[test]
fn a_blender_without_numpy_is_refused_but_does_not_hide_one_that_has_it() {
    let machine = Machine::new();
    machine.install("bin/blender", &probe_with("3.4.1", "null"));
    assert_snapshot!(refused(&machine.search(), Status::BlenderNumpy));
    machine.install_bpy(".venv/bin/python", "4.5.15");
    let found = machine.search().find(&Unwatched).unwrap();
    assert_eq!((found.kind, found.numpy.as_str()), (Kind::PythonModule, "2.0.0"));
}

#[test]
fn a_python_without_bpy_is_passed_by_unless_it_was_chosen() {
    let machine = Machine::new();
    machine.install("bin/python3", "echo '{\"interpreter\":\"/bin/python3\",\"bpy\":null}'");
    let mut told = refused(&machine.search(), Status::BlenderMissing);
    let chosen = Search { explicit: Some("python3".into()), ..machine.search() };
    told += &refused(&chosen, Status::BlenderMissing);
    assert_snapshot!(told);
    machine.install_bpy("bin/python", "5.0.1");
    assert_eq!(
        machine.search().find(&Unwatched).unwrap().version,
        Version { major: 5, minor: 0, patch: 1 }
    );
}

#[test]
fn a_blender_that_crashes_or_hangs_when_asked_is_named() {
    let fake = Fake::named("blender", "kill -SEGV $$");
    let search = Search { explicit: Some(fake.path.clone().into()), ..Machine::new().search() };
    let mut told = refused(&search, Status::BlenderCrash);
    for name in ["blender", "python3"] {
        let fake = Fake::named(name, "sleep 600");
        let explicit = Some(fake.path.clone().into());
        let patience = Duration::from_millis(300);
        let search = Search { explicit, patience, ..Machine::new().search() };
        told += &refused(&search, Status::BlenderTimeout);
    }
    assert_snapshot!(told);
}

#[test]
fn a_known_blender_is_not_started_again_until_it_changes() {
    let fake = Fake::blender("");
    let machine = Machine::new();
    let search = Search { explicit: Some(fake.path.clone().into()), ..machine.search() };
    let first = search.find(&Unwatched).unwrap();
    assert_eq!(fake.starts(), 1);
    assert_eq!(search.find(&Unwatched).unwrap(), first);
    assert_eq!(fake.starts(), 1);

    let afresh = Search { afresh: true, ..search.clone() };
    assert_eq!(afresh.find(&Unwatched).unwrap(), first);
    assert_eq!(fake.starts(), 2);

    executable(&fake.path, &probe_with("4.5.15", "\"1.26.4\""));
    assert_eq!(search.find(&Unwatched).unwrap().version.to_string(), "4.5.15");

    fs::write(machine.0.path().join("cache/blenders.json"), "damaged").unwrap();
    assert_eq!(search.find(&Unwatched).unwrap().version.to_string(), "4.5.15");
}

#[test]
fn an_upgrade_behind_a_link_is_noticed() {
    let machine = Machine::new();
    for version in ["4.5.1", "4.5.2"] {
        machine.install(&format!("opt/{version}"), &probe_with(version, "\"1.24.2\""));
    }
    let link = machine.0.path().join("blender");
    let search = Search { explicit: Some(link.clone().into()), ..machine.search() };
    for version in ["4.5.1", "4.5.2", "4.5.1"] {
        let _ = fs::remove_file(&link);
        std::os::unix::fs::symlink(Path::new("opt").join(version), &link).unwrap();
        assert_eq!(search.find(&Unwatched).unwrap().version.to_string(), version);
    }
}

#[test]
fn what_was_refused_is_asked_again() {
    let without = probe_with("3.4.1", "null");
    let with = probe_with("3.4.1", "\"1\"");
    let fake = Fake::named("blender", &format!("[ -e \"$here/numpy\" ] || {without}\n{with}"));
    let machine = Machine::new();
    let search = Search { explicit: Some(fake.path.clone().into()), ..machine.search() };
    refused(&search, Status::BlenderNumpy);
    fs::write(fake.folder.path().join("numpy"), "").unwrap();
    assert_eq!(search.find(&Unwatched).unwrap().numpy, "1");
}

#[test]
fn real_blenders_tell_what_they_are() {
    for path in real_blenders() {
        let machine = Machine::new();
        let search = Search { explicit: Some(path.clone().into()), ..machine.search() };
        let blender =
            search.find(&Unwatched).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(blender.version.is_supported(), "{blender:?}");
        assert!(blender.python.starts_with("3."), "{blender:?}");
        assert_eq!(search.find(&Unwatched).unwrap(), blender);
    }
}
