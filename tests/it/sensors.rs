//! What sensors see of a bed.

use insta::assert_snapshot;

use crate::support::{Place, shipped};

/// A traced patch in a place of its own.
fn traced() -> Place {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    place.run(&["trace", &scene, "--out", "t.json", "--tolerance", "0.02"], 0);
    place
}

/// The rows of a CSV text by heading.
struct Rows {
    headings: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Rows {
    fn new(csv: &str) -> Self {
        let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = csv.lines();
        Self {
            headings: fields(lines.next().expect("a heading")),
            rows: lines.map(fields).collect(),
        }
    }

    fn text(&self, heading: &str) -> Vec<&str> {
        let at = self.headings.iter().position(|known| known == heading).expect("a column");
        self.rows.iter().map(|row| &*row[at]).collect()
    }

    fn numbers(&self, heading: &str) -> Vec<f64> {
        self.text(heading).iter().map(|field| field.parse().expect("a number")).collect()
    }
}

const WIDTH: &str = "emissivity_half_width_95";
const KELVIN: &str = "brightness_temperature_k";
const RADIANCE: &str = "l_sensor_w_m2_sr_um";

#[test]
fn bands_stand_in_the_order_of_the_sensors_and_a_black_bed_has_its_temperature() {
    let place = traced();
    let black = ["fine", "coarse", "floor"].map(|name| format!("{name}=1"));
    let mut args = vec!["signature", "t.json", "--sensor", "aster,landsat-tirs,hytes"];
    for spectrum in &black {
        args.extend(["--spectrum", spectrum]);
    }
    let (csv, said) = place.run(&args, 0);
    assert!(said.contains("aster: nominal, Yamaguchi"), "{said}");
    let rows = Rows::new(&csv);
    assert_eq!(rows.text("band")[..7], ["10", "11", "12", "13", "14", "10", "11"]);
    assert_eq!(rows.text("sensor")[..7].concat(), "aster".repeat(5) + &"landsat-tirs".repeat(2));
    assert_eq!(rows.rows.len(), 7 + 256);
    for emissivity in rows.numbers("emissivity") {
        assert!((emissivity - 1.0).abs() < 1e-7, "{emissivity}");
    }
    for k in rows.numbers(KELVIN) {
        assert!((k - 300.0).abs() < 1e-5, "{k}");
    }
}

/// The sum over a fine grid, which shares no code with the bands but Planck's law.
#[test]
fn a_band_is_the_mean_of_its_wavelengths_and_its_errors_are_totals() {
    let place = traced();
    let sky = ["--sky", "270", "--temperature", "310"];
    let fine = ["--range", "8.925-9.275", "--step", "0.0005", "--budget", "b.csv"];
    let (csv, _) = place.run(&[&["signature", "t.json"], &sky[..], &fine].concat(), 0);
    let (fine, budget) = (Rows::new(&csv), Rows::new(&place.read("b.csv")));
    let (csv, _) =
        place.run(&[&["signature", "t.json", "--sensor", "aster"], &sky[..]].concat(), 0);
    let bands = Rows::new(&csv);
    let mean = |values: &[f64]| {
        let ends = f64::midpoint(values[0], values[values.len() - 1]);
        (values.iter().sum::<f64>() - ends) / (values.len() - 1) as f64
    };
    let near = |band: f64, fine: f64, within: f64| {
        assert!((band - fine).abs() < within * fine.abs(), "{band} and {fine}");
    };
    near(bands.numbers("emissivity")[2], mean(&fine.numbers("emissivity")), 1e-5);
    near(bands.numbers(RADIANCE)[2], mean(&fine.numbers("l_target_w_m2_sr_um")), 1e-5);
    let total = mean(&budget.numbers("total_half_width_95"));
    near(bands.numbers(WIDTH)[2], total, 0.01);
    // The radiance errs by the emissivity's error times the contrast to the sky.
    let contrast: Vec<f64> = fine
        .numbers("l_blackbody_w_m2_sr_um")
        .iter()
        .zip(fine.numbers("l_downwelling_w_m2_sr_um"))
        .map(|(bed, sky)| bed - sky)
        .collect();
    let l_width = bands.numbers("l_sensor_half_width_95_w_m2_sr_um")[2];
    near(l_width, total * mean(&contrast), 0.01);
    let k_width = bands.numbers("brightness_temperature_half_width_95_k")[2];
    assert!(k_width > 0.0 && k_width < 5.0, "{k_width}");
}

#[test]
fn responses_come_from_files_and_bands_beyond_the_spectra_stay_empty() {
    let place = traced();
    place.write("mine.srf.csv", "wavelength_um,A,B\n8,0,0\n8.5,1,0\n9,0,1\n9.5,0,0\n");
    let sensor = ["--sensor", "mine.srf.csv,modis"];
    place.write("short.csv", "7.4,0.9\n11.5,0.9\n");
    let args =
        [&["signature", "t.json", "--spectrum", "fine=short.csv", "--out", "s.csv"], &sensor[..]];
    let (out, said) = place.run(&args.concat(), 0);
    assert!(out.contains("mine A (8.50 um): emissivity 0."), "{out}");
    assert!(said.contains("left empty, since spectra do not hold them: modis 32"), "{said}");
    let rows = Rows::new(&place.read("s.csv"));
    assert_eq!(rows.text("sensor"), ["mine", "mine", "modis", "modis", "modis", "modis"]);
    assert_eq!(rows.text("emissivity")[5], "");
    assert!(rows.text("valid")[..5].iter().all(|valid| *valid == "1"));
    let mut told = String::new();
    place.write("none.srf.csv", "wavelength_um,A\n2,1\n3,1\n");
    place.write("broken.srf.csv", "8,1\n9,1\n");
    for sensor in ["asta", "none.srf.csv", "broken.srf.csv", "gone.csv"] {
        told += &place.failed(&["signature", "t.json", "--sensor", sensor]);
    }
    assert_snapshot!(told);
}
