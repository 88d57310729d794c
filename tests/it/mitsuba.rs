//! The shipped patch as `soilsig export` writes it, in Mitsuba 3: the same rays from the sensor
//! into the same meshes, by a renderer of others.
//!
//! Sides are open: Mitsuba knows no mirrors that let the sensor in. The sensor sees the domain, and
//! the bed beyond it stands.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};
use soilsig::histogram::kept::Kept;
use soilsig::histogram::{Histogram, Mean};
use soilsig::products::export::{self, To};
use soilsig::scene::Scene;
use soilsig::support::random::Purpose;
use soilsig::tracer::rules::{Facet, TracingRules};
use soilsig::tracer::trace;
use statrs::distribution::{ContinuousCDF as _, StudentsT};
use tempfile::TempDir;

use crate::support::{Tool, shipped_json, tool};

/// Reflectance of fines, grains and floor.
const REFLECTANCES: [[f64; 3]; 6] = [
    [0.1, 0.4, 0.1],
    [0.9, 0.9, 0.9],
    [0.5, 0.5, 0.5],
    [0.05, 0.7, 0.05],
    [0.3, 0.6, 0.3],
    [0.6, 0.1, 0.4],
];

/// Zenith and azimuth angles.
const VIEWS_DEG: [[f64; 2]; 2] = [[0.0, 0.0], [45.0, 30.0]];

/// Renders of each case, and the paths of each.
const SEEDS: u64 = 16;
const PIXELS: u64 = 64;
const SAMPLES: u64 = 4;

/// Paths of ours for each view.
const PATHS: u64 = 1 << 19;

/// Of all comparisons together one in a hundred runs may call a difference where there is none.
const LEVEL: f64 = 0.01;

/// The shipped patch with open sides, seen from there.
fn open_patch(folder: &TempDir, [zenith_deg, azimuth_deg]: [f64; 2]) -> PathBuf {
    let mut scene = shipped_json("settled_patch.json");
    scene["view"] = json!({"zenith_deg": zenith_deg, "azimuth_deg": azimuth_deg});
    let placed = &mut scene["geometry"]["placed"];
    placed["domain"]["sides"] = "open".into();
    let path = folder.path().join("scene.json");
    fs::write(&path, scene.to_string()).expect("written");
    path
}

fn ours(path: &Path) -> Vec<Mean> {
    let scene = Scene::read(path).expect("the scene is sound");
    let tracer = trace::tracer(&scene).expect("its meshes are sound");
    let bands: Vec<Vec<f64>> = REFLECTANCES.iter().map(|rho| rho.to_vec()).collect();
    let rules = TracingRules::of_facets(Kept::PLAIN, vec![Facet::LAMBERTIAN; 3]);
    let rules = rules.ending_below(1e-4, &bands);
    let tally = tracer.trace(&rules, 1, Purpose::Result, 0..PATHS, &|_| Ok(())).expect("traced");
    assert_eq!(tally.missed, 0, "the floor has no end");
    let histogram = Histogram::of(&tally);
    bands.iter().map(|rho| histogram.weight(rho)).collect()
}

/// The mean over each render, for each of the reflectances.
fn theirs(python: &Path, path: &Path) -> Vec<Vec<f64>> {
    let scene = Scene::read(path).expect("the scene is sound");
    let folder = path.with_extension("mitsuba");
    let lost = export::export(&scene, To::Mitsuba, &[8.5, 9.0, 11.0], &folder);
    assert!(!lost.expect("exported").iter().any(|sentence| sentence.contains("sides")));
    let job = json!({
        "scene": folder.join("scene.xml"), "reflectances": REFLECTANCES,
        "pixels": PIXELS, "samples": SAMPLES, "seeds": (1..=SEEDS).collect::<Vec<_>>(),
    });
    let mut child = Command::new(python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/mitsuba/peer.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the Python starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    stdin.write_all(job.to_string().as_bytes()).expect("it reads");
    drop(stdin);
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{}", output.status);
    let lines = String::from_utf8(output.stdout).expect("UTF-8");
    let renders = lines.lines().map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
    let means = |render: &Value| {
        let list = render["means"].as_array()?;
        Some(list.iter().map(|mean| mean.as_f64().expect("a number")).collect())
    };
    renders.filter_map(|render| means(&render)).collect()
}

#[test]
fn the_shipped_patch_agrees_with_mitsuba() {
    let Some(python) = tool(Tool::Mitsuba) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cases = (REFLECTANCES.len() * VIEWS_DEG.len()) as f64;
    // Sidak's level of each comparison; few renders know less of their spread than our groups.
    let level = 1.0 - (1.0 - LEVEL).powf(1.0 / cases);
    let n = SEEDS as f64;
    let student = StudentsT::new(0.0, 1.0, n - 1.0).expect("degrees of freedom");
    let bound = student.inverse_cdf(1.0 - level / 2.0);
    for view_deg in VIEWS_DEG {
        let path = open_patch(&folder, view_deg);
        let renders = theirs(&python, &path);
        assert_eq!(renders.len() as u64, SEEDS);
        for (i, (ours, rho)) in ours(&path).into_iter().zip(REFLECTANCES).enumerate() {
            let mean = renders.iter().map(|render| render[i]).sum::<f64>() / n;
            let squares: f64 = renders.iter().map(|render| (render[i] - mean).powi(2)).sum();
            let error = (squares / (n - 1.0) / n).sqrt().hypot(ours.standard_error);
            let off = (ours.mean - mean) / error;
            println!(
                "{view_deg:?} {rho:?}: {:.5}, Mitsuba {mean:.5} +- {error:.5}: {off:.1}",
                ours.mean
            );
            assert!(error < 1.5e-3 && ours.trapped < 1e-4, "the check would see nothing: {error}");
            assert!(
                (ours.mean - mean).abs() < bound * error + ours.trapped,
                "from {view_deg:?}, rho {rho:?}: {} and Mitsuba's {mean}, {off} standard errors apart",
                ours.mean
            );
        }
    }
}
