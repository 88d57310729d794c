//! Error against time: what the chart of the shipped patch says of levels whose order is known.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use insta::assert_snapshot;

use crate::support::without_places;

const HEADINGS: &str = "level,setting,repeats,wall_s,cpu_s,rms_error,worst_band_error,bias,\
                        reference_rms,reference_worst_band\n";

fn chart(beside: &Path, out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_soilsig"))
        .args(["chart", "scenes/settled_patch.json", "--quick", "--range", "8-9.5"])
        .args(["--step", "0.05", "--beside"])
        .arg(beside)
        .arg("--out")
        .arg(out)
        .output()
        .expect("it starts")
}

#[test]
fn a_chart_tells_bias_from_noise_and_draws_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let peer = folder.path().join("peer.csv");
    // Better and cheaper than any of ours.
    fs::write(
        &peer,
        format!("{HEADINGS}Peer,64 paths,12,0.0002,0.0001,0.0001,0.0002,0,0.00003,0.00004\n"),
    )
    .expect("written");
    let out = folder.path().join("chart");
    let run = chart(&peer, &out);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let mut rows: HashMap<(String, String), HashMap<String, f64>> = HashMap::new();
    let mut reader = csv::Reader::from_path(out.join("chart.csv")).expect("it is there");
    let heads = reader.headers().expect("headings").clone();
    for record in reader.records() {
        let record = record.expect("a row");
        let numbers = heads.iter().zip(&record).skip(2);
        let numbers =
            numbers.map(|(head, value)| (head.to_owned(), value.parse().expect("a number")));
        rows.insert((record[0].to_owned(), record[1].to_owned()), numbers.collect());
    }
    let of = |level: &str, setting: &str, what: &str| {
        rows[&(level.to_owned(), setting.to_owned())][what]
    };
    assert!(rows.values().all(|row| row["repeats"] >= 10.0));
    let floor = of("as shipped", "4096 paths", "reference_worst_band");
    assert!(of("as shipped", "4096 paths", "bias") < 3.0 * floor, "paths alone have no bias");
    let [few, many] = ["256 paths", "4096 paths"].map(|n| of("as shipped", n, "rms_error"));
    assert!(many < few / 2.5, "{many} is no fourth of {few}");
    // Without the light between facets the troughs are far too deep; a path that ends at its first
    // hits hides some.
    assert!(of("areal mixture", "4096 paths", "bias") > 0.1);
    let [one, two, five] = ["up to 1 hit", "up to 2 hits", "up to 5 hits"]
        .map(|level| of(level, "4096 paths", "rms_error"));
    assert!(five < two.min(one), "{one} {two} {five}");
    assert!(of("open sides", "4096 paths", "bias") > 10.0 * floor, "rays leave at the rim");
    for file in ["chart.svg", "chart.png"] {
        assert!(out.join(file).metadata().expect("it is there").len() > 10_000, "{file}");
    }
    let said = String::from_utf8(run.stdout).expect("UTF-8");
    assert!(said.contains("0.005"), "no choice is named: {said}");
    // What was measured elsewhere is in the file and the picture, and nowhere a choice.
    let row = &rows[&("Peer".to_owned(), "64 paths".to_owned())];
    assert_eq!(
        ["cpu_s", "worst_band_error", "reference_worst_band"].map(|h| row[h]),
        [1e-4, 2e-4, 4e-5]
    );
    let svg = fs::read_to_string(out.join("chart.svg")).expect("it is there");
    assert!(
        svg.contains(">Peer<") && svg.contains("Squares: measured elsewhere"),
        "no peer is drawn"
    );
    assert!(!said.contains("Peer") && !svg.contains("Peer, 64 paths"), "{said}");
}

#[test]
fn a_file_beside_the_chart_that_is_none_of_its_kind_is_refused_before_anything_is_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let peer = folder.path().join("peer.csv");
    let good = "Peer,64 paths,12,1,1,0.1,0.2,0,0,0\n";
    let mut told = String::new();
    for (text, line) in [
        ("time,error\n1,2\n".to_owned(), 1),
        (HEADINGS.to_owned(), 1),
        (format!("{HEADINGS}{good}Peer,128 paths,12,1,1,0.1\n"), 3),
        (format!("{HEADINGS}{good}Peer,128 paths,12,1,1,?,0.2,0,0,0\n"), 3),
        (format!("{HEADINGS}Peer,64 paths,12,1,1,0.1,NaN,0,0,0\n"), 2),
        (format!("{HEADINGS}Peer,64 paths,12,1,0,0.1,0.2,0,0,0\n"), 2),
        (format!("{HEADINGS}Peer,64 paths,0,1,1,0.1,0.2,0,0,0\n"), 2),
        (format!("{HEADINGS},64 paths,12,1,1,0.1,0.2,0,0,0\n"), 2),
    ] {
        fs::write(&peer, &text).expect("written");
        let run = chart(&peer, &folder.path().join("chart"));
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(3), "{text}: {said}");
        assert!(said.contains(&format!("peer.csv, line {line}: ")), "{text}: {said}");
        assert!(!folder.path().join("chart").exists(), "it was measured before");
        told += &format!("{text:?}\n{}\n", without_places(&said));
    }
    assert_snapshot!(told);
}
