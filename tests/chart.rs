//! Error against time: what the chart of the shipped patch says of levels whose order is known.

use std::collections::HashMap;

use assert_cmd::Command;

#[test]
fn a_chart_tells_bias_from_noise_and_draws_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("chart");
    let run = Command::new(env!("CARGO_BIN_EXE_soilsig"))
        .args(["chart", "scenes/settled_patch.json", "--quick", "--range", "8-9.5"])
        .args(["--step", "0.05", "--out"])
        .arg(&out)
        .output()
        .expect("it starts");
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
    // Without the light between facets the troughs are far too deep; a path that ends at its first hits hides some.
    assert!(of("areal mixture", "4096 paths", "bias") > 0.1);
    let [one, two, five] = ["up to 1 hit", "up to 2 hits", "up to 5 hits"]
        .map(|level| of(level, "4096 paths", "rms_error"));
    assert!(five < two.min(one), "{one} {two} {five}");
    assert!(of("open sides", "4096 paths", "bias") > 10.0 * floor, "rays leave at the rim");
    for file in ["chart.svg", "chart.png"] {
        assert!(out.join(file).metadata().expect("it is there").len() > 10_000, "{file}");
    }
    let said = String::from_utf8(run.stdout).expect("UTF-8");
    assert!(said.contains("the cheapest within 0.005"), "{said}");
}
