//! Results compared by their errors.

use crate::support::{Place, shipped, without_fractions};

#[test]
fn results_agree_within_their_errors_or_differ_with_a_status() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let trace = |out: &str, seed: &str| {
        let args = ["trace", &scene, "--out", out, "--tolerance", "0.02", "--seed", seed];
        place.run(&args, 0);
    };
    trace("a.json", "1");
    trace("b.json", "2");
    let (out, _) = place.run(&["diff", "a.json", "a.json"], 0);
    assert_eq!(out, "a.json and a.json are the same in 651 bands\nthey agree\n");
    let (out, _) = place.run(&["diff", "a.json", "b.json", "--out", "d.csv"], 0);
    assert!(out.contains("of 651 bands agree within the 95 % errors of both"), "{out}");
    let csv = place.read("d.csv");
    assert_eq!(csv.lines().count(), 652);
    assert!(
        csv.starts_with("wavelength_um,emissivity_a,emissivity_b,difference,half_width_95,z\n")
    );
    place.run(&["signature", "a.json", "--out", "a.csv"], 0);
    place.run(&["signature", "a.json", "--spectrum", "coarse=0.95", "--out", "other.csv"], 0);
    // A table and its signature have the same numbers, but for rounding.
    place.run(&["diff", "a.json", "a.csv"], 0);
    let (out, _) = place.run(&["diff", "a.csv", "other.csv"], 5);
    assert!(out.ends_with("they differ\n"), "{out}");
    // Spectra have no errors; they are compared where both have bands.
    place.write("flat.csv", "8,0.9\n12,0.9\n");
    let (out, _) = place.run(&["diff", "a.csv", "flat.csv"], 5);
    assert!(out.contains("401 bands"), "{out}");
    place.run(&["pipeline", "--scene", &scene, "--out", "r", "--tolerance", "0.02"], 0);
    place.run(&["diff", "r", "a.json"], 0);
    place.run(&["diff", "r/run.json", "r/signature.csv"], 0);
    let said = place.refused(&["diff", "r", "."], 3) + &place.failed(&["diff", "r", "gone.csv"]);
    insta::assert_snapshot!(without_fractions(&said));
}

#[test]
fn a_spectrum_beside_a_signature_is_compared_with_it() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    place.run(&["trace", &scene, "--out", "t.json", "--paths", "2048"], 0);
    let grey = ["fine", "coarse", "floor"].map(|name| format!("{name}=1"));
    let mut args = vec!["signature", "t.json", "--beside", "flat.csv", "--plot", "bare.pdf"];
    args.push("--bare-figure");
    for spectrum in &grey {
        args.extend(["--spectrum", spectrum]);
    }
    place.write("flat.csv", "8,0.9\n9,0.8\n10,0.9\n");
    let (_, said) = place.run(&args, 0);
    // 0.1, 0.2, 0.1: the mean of their squares is 0.02.
    let line = "signature less flat.csv: RMS 0.1414, bias +0.1333, worst band +0.2000 at 9 um";
    assert!(said.contains(line), "{said}");
    let pdf = std::fs::read(place.path("bare.pdf")).expect("written");
    assert!(pdf.starts_with(b"%PDF-"));
}
