//! Shipped optical constants against other measurements and the laws of optics, and features in the
//! words of the mineral that is seen.

use num_complex::Complex64;
use serde_json::{Value, json};
use soilsig::spectrum::features::{Features, Windows, features};
use soilsig::spectrum::optics::{Axis, Crystal, unpolarised_reflectance};
use soilsig::spectrum::{Spectrum, all, crystal};
use soilsig::table::{Table, feature_windows};

use crate::support::Place;

const MINERALS: [&str; 7] = [
    "quartz",
    "quartz_zeidler",
    "quartz_spitzer_kleinman",
    "calcite",
    "corundum",
    "forsterite",
    "hematite",
];

fn mineral(name: &str) -> &'static Crystal {
    crystal(name).expect("shipped")
}

fn axes(name: &str) -> Vec<&'static Axis> {
    mineral(name).axes.each().into_iter().map(|(_, axis)| axis).collect()
}

/// The first wavelength of some, um, at which a quantity changes its sign.
fn crossing(from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
    let um = |i: u32| from + (to - from) * f64::from(i) / 4000.0;
    let found = (0..4000).find(|&i| of(um(i)) * of(um(i + 1)) <= 0.0);
    um(found.expect("it crosses"))
}

/// The wavelength at which a quantity is largest, um.
fn largest(from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
    let um = (0..=4000).map(|i| from + (to - from) * f64::from(i) / 4000.0);
    um.max_by(|a, b| of(*a).total_cmp(&of(*b))).expect("some")
}

/// Where n = 1.
fn christiansen(axis: &Axis, from: f64, to: f64) -> f64 {
    crossing(from, to, |um| axis.index(um).re - 1.0)
}

fn normal(axis: &Axis, um: f64) -> f64 {
    unpolarised_reflectance(axis.dielectric(um), 1.0)
}

#[test]
fn calcite_and_corundum_have_the_points_of_other_measurements() {
    // Querry (1987) by another method: n = 1 of corundum at 9.62 and 9.80 um.
    for (axis, um) in axes("corundum").into_iter().zip([9.62, 9.80]) {
        let found = christiansen(axis, um - 0.3, um + 0.3);
        assert!((found - um).abs() < 0.06, "{found} {um}");
    }
    // The carbonate ion's modes 2 and 4 at 11.3-11.4 and 14.0-14.1 um.
    let calcite = axes("calcite");
    assert!((largest(10.5, 12.0, |um| normal(calcite[1], um)) - 11.35).abs() < 0.1);
    assert!((largest(13.5, 14.5, |um| normal(calcite[0], um)) - 14.05).abs() < 0.05);
}

/// The constants are by Suto et al. (2006). Another crystal and fit, in the four-parameter form: De
/// La Pierre et al., J. Comput. Chem. 34, 1476 (2013).
#[test]
fn forsterite_has_the_christiansen_points_and_bands_of_another_crystal() {
    let forsterite = axes("forsterite");
    for (axis, um) in forsterite.iter().zip([8.677, 9.487, 9.281]) {
        let found = christiansen(axis, um - 0.4, um + 0.4);
        assert!((found - um).abs() < 0.05, "{found} {um}");
    }
    // Transverse modes: the imaginary part of the dielectric function is largest there.
    for (axis, modes) in [(0, &[978.5, 959.9][..]), (1, &[872.9, 838.6]), (2, &[874.4])] {
        for mode in modes {
            let um = 1e4 / mode;
            let imaginary = |um: f64| forsterite[axis].dielectric(um).im;
            let found = largest(um - 0.09, um + 0.09, imaginary);
            assert!((1e4 / found - mode).abs() < 3.0, "{axis}: {} {mode}", 1e4 / found);
        }
    }
    let stone = |um: f64| mineral("forsterite").reflectance(um, 1.0);
    for (from, to, um) in [(9.6, 10.3, 10.085), (10.35, 11.0, 10.409), (11.8, 12.1, 11.913)] {
        let found = largest(from, to, stone);
        assert!((found - um).abs() < 0.04, "{found} {um}");
    }
}

/// Rows of the tables that had no part in finding the parameters: um, n, k. From 10 um on the tables
/// round wavelengths of whole wavenumbers.
#[test]
fn the_parameters_of_forsterite_return_rows_of_their_tables() {
    let rows: [&[[f64; 3]]; 3] = [
        &[[8.41, 1.1384, 0.00874], [9.55, 0.06849, 0.95944], [1e4 / 966.0, 2.8529, 1.16029]],
        &[[9.25, 1.1029, 0.00746], [1e4 / 924.0, 0.0491, 1.30922], [1e4 / 853.0, 2.7639, 0.3034]],
        &[[9.75, 0.71625, 0.02641], [1e4 / 924.0, 0.082, 1.80036], [1e4 / 870.0, 7.2118, 2.0825]],
    ];
    for (axis, rows) in axes("forsterite").into_iter().zip(rows) {
        for &[um, n, k] in rows {
            let index = axis.index(um);
            let missed = (index - Complex64::new(n, k)).norm();
            assert!(missed < 0.006 * index.norm() + 0.001, "{um}: {index}, table {n} {k}");
        }
    }
}

/// The constants are by Querry (1985). Another measurement: Onari, Arai and Kudo, Phys. Rev. B 16,
/// 1717 (1977), transverse and longitudinal modes in cm-1. Both sets have their last longitudinal mode
/// at 662, where the real part of the dielectric function is 0. Without damping they give n where
/// little is absorbed.
#[test]
fn hematite_has_the_modes_and_the_index_of_another_measurement() {
    let modes: [(f64, &[[f64; 2]]); 2] = [
        (7.0, &[[227.0, 230.0], [286.0, 368.0], [437.0, 494.0], [524.0, 662.0]]),
        (6.7, &[[299.0, 414.0], [526.0, 662.0]]),
    ];
    for (axis, (eps_inf, pairs)) in axes("hematite").into_iter().zip(modes) {
        let longitudinal = crossing(14.0, 16.0, |um| axis.dielectric(um).re);
        assert!((1e4 / longitudinal - 662.0).abs() < 6.0, "{}", 1e4 / longitudinal);
        let undamped = |um: f64| {
            let v = 1e4 / um;
            let factor = |[to, lo]: &[f64; 2]| (lo * lo - v * v) / (to * to - v * v);
            (eps_inf * pairs.iter().map(factor).product::<f64>()).sqrt()
        };
        for um in [8.0, 9.0, 10.0, 11.0, 12.0] {
            let n = axis.index(um).re;
            assert!((n / undamped(um) - 1.0).abs() < 0.05, "{um}: {n} {}", undamped(um));
        }
        // Its Christiansen point lies just short of the longitudinal mode.
        let point = christiansen(axis, 13.0, 16.0);
        assert!(point < longitudinal && point > longitudinal - 0.8, "{point} {longitudinal}");
    }
}

/// Of every set: it absorbs and reflects less than all; where it absorbs little the dielectric
/// function rises with frequency, as Kramers and Kronig ask of any passive medium.
#[test]
fn shipped_constants_obey_the_laws_of_optics() {
    let fresnel = all().into_iter().filter(Spectrum::is_angular).count();
    assert_eq!(fresnel, MINERALS.len(), "each set is tested");
    for name in MINERALS {
        let stone = mineral(name);
        let [from, to] = stone.range_um;
        let steps = ((to - from) / 0.01).round() as usize;
        let um = |i: usize| from + (to - from) * i as f64 / steps as f64;
        let mut clear = 0;
        for axis in axes(name) {
            for i in 0..=steps {
                let index = axis.index(um(i));
                assert!(index.im >= 0.0 && index.re > 0.0, "{name} at {}: {index}", um(i));
                assert!(normal(axis, um(i)) < 1.0, "{name} at {}", um(i));
            }
            for i in 1..=steps {
                let [short, long] = [i - 1, i].map(|i| axis.dielectric(um(i)));
                if short.im < 0.05 && long.im < 0.05 {
                    clear += 1;
                    assert!(short.re >= long.re, "{name} at {}: {short} {long}", um(i));
                }
            }
        }
        assert!(clear > 50 || name == "hematite", "{name}: {clear}");
        for i in (0..=steps).step_by(10) {
            let grazing = stone.reflectance(um(i), 0.0);
            assert!((grazing - 1.0).abs() < 1e-12);
            let diffuse = stone.hemispherical_reflectance(um(i));
            assert!(diffuse > 0.0 && diffuse < 1.0, "{name} at {}: {diffuse}", um(i));
        }
        let citation = &stone.citation;
        assert!(citation.contains("19") || citation.contains("20"), "{name}: {citation}");
    }
}

fn found(spectrum: &Spectrum) -> Features {
    let [from, to] = spectrum.range_um().expect("bounded");
    let um: Vec<f64> = (0..=800).map(|i| from + (to - from) * f64::from(i) / 800.0).collect();
    let curve: Vec<f64> = um.iter().map(|&um| spectrum.emissivity(um).expect("in range")).collect();
    features(&um, &curve, Windows::of([spectrum]))
}

#[test]
fn each_mineral_has_its_features_in_its_own_windows() {
    for (name, of, christiansen_um, troughs_um) in [
        ("calcite", "calcite", 6.13, &[6.9, 11.4, 14.05][..]),
        ("corundum", "corundum", 9.7, &[15.1]),
        ("forsterite", "forsterite", 8.71, &[10.1, 10.45, 11.93]),
        ("hematite", "hematite", 14.24, &[]),
        ("quartz", "quartz", 7.4, &[]),
        ("quartz_zeidler", "quartz", 7.4, &[]),
        ("quartz_spitzer_kleinman", "quartz", 7.35, &[]),
    ] {
        let found = found(&Spectrum::fresnel(name).expect("shipped"));
        assert_eq!(found.mineral.as_deref(), Some(of));
        let point = found.christiansen.expect("a maximum");
        assert!((point.wavelength_um - christiansen_um).abs() < 0.1, "{name}: {point:?}");
        let troughs: Vec<f64> = found.troughs.iter().map(|trough| trough.wavelength_um).collect();
        assert_eq!(troughs.len(), troughs_um.len(), "{name}: {troughs:?}");
        for (trough, um) in troughs.iter().zip(troughs_um) {
            assert!((trough - um).abs() < 0.3, "{name}: {troughs:?}");
        }
        assert_eq!(found.reststrahlen.is_some(), of == "quartz", "{name}");
    }
    let windows = |name: &str| mineral(name).features.as_ref();
    for name in ["quartz_zeidler", "quartz_spitzer_kleinman"] {
        assert_eq!(windows(name), windows("quartz"));
    }
}

/// Two plates side by side, the first 80 % of the domain.
fn plates(place: &Place, [first, second]: [Value; 2]) -> Table {
    place.write(
        "mesh.obj",
        "v 0 0 0\nv 80 0 0\nv 80 100 0\nv 0 100 0\nv 100 0 0\nv 100 100 0\nusemtl a\nf 1 2 3 4\n\
         usemtl b\nf 2 5 6 3\n",
    );
    let scene = json!({
        "soilsig_scene": 1, "name": "plates", "seed": 1, "temperature_k": 300,
        "view": {"zenith_deg": 0},
        "materials": [{"name": "a", "spectrum": first}, {"name": "b", "spectrum": second}],
        "geometry": {"placed": {"prototypes": [{"name": "mesh", "file": "mesh.obj"}],
            "domain": {"min_um": [0, 0], "max_um": [100, 100], "sides": "mirror"}}}
    });
    place.write("scene.json", scene.to_string());
    let args = ["trace", "scene.json", "--out", "t.json", "--paths", "4000"];
    place.run(&args, 0);
    Table::read(&place.path("t.json")).expect("a table")
}

/// Whether a line begins with these words.
fn says(out: &str, words: &str) -> bool {
    out.lines().any(|line| line.trim_start().starts_with(words))
}

#[test]
fn the_mineral_seen_most_names_the_features() {
    let place = Place::new();
    let calcite = || json!({"fresnel": "calcite"});
    let table = plates(&place, [calcite(), json!({"builtin": "quartz_coarse"})]);
    assert_eq!(feature_windows(&[table]).mineral, "calcite");
    let args = ["signature", "t.json", "--verbose", "--out", "s.csv", "--plot", "out.svg"];
    let (out, _) = place.run(&args, 0);
    assert!(says(&out, "calcite: troughs"), "{out}");
    assert!(!says(&out, "quartz: ") && !says(&out, "reststrahlen"), "{out}");
    let svg = place.read("out.svg");
    assert!(svg.contains("extrema of calcite") && !svg.contains("Transparency"), "{svg}");

    let table = plates(&place, [json!({"builtin": "quartz_coarse"}), calcite()]);
    assert_eq!(feature_windows(&[table]).mineral, "quartz");
    let (out, _) = place.run(&args, 0);
    assert!(says(&out, "reststrahlen of quartz: troughs") && !says(&out, "calcite: "), "{out}");
    // What does not say its mineral leaves the word to what does, and is taken for quartz alone.
    let table = plates(&place, [json!({"constant": 0.9}), calcite()]);
    assert_eq!(feature_windows(&[table]).mineral, "calcite");
    let table = plates(&place, [json!({"constant": 0.9}), json!({"constant": 0.8})]);
    assert_eq!(feature_windows(&[table]).mineral, "quartz");
}

#[test]
fn a_file_of_constants_names_its_features_or_has_none() {
    let place = Place::new();
    let mut file = serde_json::to_value(mineral("calcite")).expect("JSON");
    let own = json!({"fresnel": {"file": "own.json"}});
    file["features"]["mineral"] = "aragonite".into();
    place.write("own.json", file.to_string());
    let table = plates(&place, [own.clone(), json!({"constant": 0.9})]);
    assert_eq!(feature_windows(&[table]).mineral, "aragonite");

    file.as_object_mut().expect("an object").remove("features");
    place.write("own.json", file.to_string());
    let table = plates(&place, [own.clone(), json!({"builtin": "quartz_coarse"})]);
    let windows = feature_windows(std::slice::from_ref(&table));
    assert_eq!(windows, &Windows::default());
    let (out, _) = place.run(&["signature", "t.json", "--verbose", "--out", "s.csv"], 0);
    assert!(!out.contains("Christiansen") && !out.contains("reststrahlen"), "{out}");

    file["features"] = json!({"mineral": "aragonite", "troughs_um": [[8, 7]]});
    place.write("own.json", file.to_string());
    let said = place.refused(&["trace", "scene.json", "--out", "t.json"], 3);
    assert!(said.contains("8 to 7 um is not a window"), "{said}");
}
