//! A grain authored in Blender's real window, under Xvfb: from an SEM image to the library, and
//! from there through the pipeline to a signature. Debian's Blender 3.4 alone: bpy has no window.

use std::env;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use insta::assert_snapshot;
use serde_json::Value;

use crate::support::{Place, Tool, real_blenders, tool, with_script};

/// A display of its own, ended with the test.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn start(xvfb: &Path) -> Self {
        let mut server = Command::new(xvfb)
            .args(["-displayfd", "1", "-screen", "0", "1280x1100x24", "+extension", "GLX"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let out = server.stdout.take().expect("it is piped");
        BufReader::new(out).read_line(&mut number).expect("it says its number");
        Self { server, name: format!(":{}", number.trim()) }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The program there, for a Blender without preferences of the user's, and no way to them.
fn soilsig(place: &Place, args: &[&str], display: Option<&Display>) -> assert_cmd::Command {
    let mut command = place.soilsig(args);
    command.env("HOME", place.folder()).env("LIBGL_ALWAYS_SOFTWARE", "1");
    if let Some(display) = display {
        command.env("DISPLAY", &display.name);
    }
    command
}

#[test]
fn a_grain_is_authored_in_the_window_and_goes_through_to_a_signature() {
    let (Some(xvfb), Some(blender)) = (tool(Tool::Window), tool(Tool::Blender)) else { return };
    let place = Place::new();
    let at = |name: &str| place.path(name);
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::copy(here.join("tests/window/drive.py"), at("drive.py")).expect("copied");
    // Debian's Blender has numpy for this one.
    let drawn = Command::new("/usr/bin/python3")
        .arg(here.join("scripts/sem_image.py"))
        .arg(at("sem.png"))
        .status();
    assert!(drawn.expect("python3 starts").success());

    let display = Display::start(&xvfb);
    let opened = soilsig(&place, &["blender", "--gui", "--grains", "grains"], Some(&display))
        .arg("--blender")
        .arg(&blender)
        .args(["--", "--factory-startup", "--window-geometry", "0", "0", "1280", "1100"])
        .args(["--python", "drive.py"])
        .output()
        .expect("it runs");
    let errors = String::from_utf8_lossy(&opened.stderr);
    assert!(opened.status.success(), "{errors}");
    let report = fs::read_to_string(at("report.json")).expect("the driver ended");
    if let Some(kept) = env::var_os("SOILSIG_TEST_WINDOW_PICTURES") {
        for entry in fs::read_dir(place.folder()).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|ending| ending == "png") {
                let name = path.file_name().expect("a file");
                fs::copy(&path, Path::new(&kept).join(name)).expect("copied");
            }
        }
    }
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["passed"], true, "{report:#}");
    let step = |name: &str| {
        let steps = report["steps"].as_array().expect("steps");
        steps.iter().find(|step| step["step"] == name).cloned().expect(name)
    };
    assert_eq!(step("image")["um_per_pixel"], 0.8);
    assert!(step("traced")["overlap"].as_f64().expect("a share") >= 0.9, "{report:#}");
    assert!(step("checked")["report"].as_str().expect("words").contains("diameter 500.0 um"));
    assert!(step("dressed")["cover"].as_str().expect("words").starts_with("400 fines"));
    assert_eq!(step("undone_and_redone")["vertices_as_before"], true);
    assert!(step("dropped")["objects"].as_u64().expect("a number") > 16);
    assert_eq!(step("refused")["mode"], "EDIT");
    assert!(step("refused")["selected"].as_u64().expect("a number") > 0, "{report:#}");
    assert_eq!((&report["refused_to_save"], &report["kept"]), (&true.into(), &true.into()));

    let run = |args: &[&str]| {
        let output = soilsig(&place, args, None).output().expect("it runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{args:?}: {errors}");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    assert_eq!(run(&["grains", "check", "grains"]).lines().count(), 1);
    let blender = blender.to_str().expect("UTF-8");
    let args = ["pipeline", "--scene", "grains/bed.json", "--blender", blender];
    run(&[&args[..], &["--out", "bed", "--packings", "1", "--range", "8-12"]].concat());
    let curve = fs::read_to_string(at("bed/signature.csv")).expect("written");
    assert_eq!(curve.lines().count(), 402, "a heading and a row for each band");
}

#[test]
fn the_addon_installs_from_its_zip_as_the_preferences_do_it() {
    for blender in real_blenders() {
        let place = Place::new();
        let zip = place.path("soilsig.zip");
        place.run(&["blender", "--addon-zip", "soilsig.zip"], 0);
        let mut command = with_script(&blender, "tests/window/install.py");
        // Another home: the preferences of whoever runs this stay as they are.
        command.env("HOME", place.folder()).arg("--").arg(&zip);
        let output = command.output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(said.contains("installed, used and disabled"), "{}: {said}", blender.display());
        assert!(output.status.success(), "{said}");
    }
}

#[test]
fn what_has_no_window_says_so() {
    for blender in real_blenders() {
        let place = Place::new();
        let mut command = soilsig(&place, &["blender", "--gui", "--blender"], None);
        command.arg(&blender).env_remove("DISPLAY");
        let output = command.env_remove("WAYLAND_DISPLAY").output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(10), "{said}");
        let kind = if blender.ends_with("blender") { "executable" } else { "module" };
        let said = said.replace(&blender.display().to_string(), "[blender]");
        assert_snapshot!(format!("no_window_of_the_{kind}"), said);
    }
}
