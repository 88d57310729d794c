//! Sky and atmosphere from the output of MODTRAN and libRadtran. The files are made here, of black
//! skies: what comes out is Planck's law by wavelength, what goes in is Planck's law by wavenumber.

use std::f64::consts::PI;
use std::fs;

use crate::support::{Place, shipped};

/// Radiance of a black body, W cm-2 sr-1 per cm-1, at a wavenumber in cm-1.
fn planck_by_wavenumber(wavenumber: f64, kelvin: f64) -> f64 {
    // 2 h c^2 in W cm2 sr-1, and h c / k in cm K.
    let (first, second) = (1.191_042_972e-12, 1.438_776_877);
    first * wavenumber.powi(3) / ((second * wavenumber / kelvin).exp() - 1.0)
}

const BANDS: [&str; 4] = ["--range", "8-13", "--step", "1"];
/// Lines of 20 cm-1 lie between bands.
const BETWEEN: f64 = 2e-3;

/// A traced patch.
fn traced() -> Place {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let trace = ["trace", &scene, "--out", "t.json", "--tolerance", "0.05"];
    place.run(&[&trace[..], &BANDS].concat(), 0);
    place
}

/// A column of the signature, by a sky or an atmosphere.
fn column(place: &Place, options: &[&str], name: &str) -> Vec<f64> {
    let args = [&["signature", "t.json", "--out", "s.csv"][..], options, &BANDS].concat();
    place.run(&args, 0);
    let csv = fs::read_to_string(place.path("s.csv")).expect("written");
    let mut lines = csv.lines();
    let at = lines.next().and_then(|line| line.split(',').position(|known| known == name));
    let at = at.unwrap_or_else(|| panic!("no column {name}"));
    let number = |line: &str| line.split(',').nth(at).and_then(|field| field.parse().ok());
    lines.map(|line| number(line).expect("a number")).collect()
}

fn close(found: &[f64], wanted: &[f64], relative: f64) {
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() < relative * wanted.abs(), "{found} {wanted}");
    }
}

const MODTRAN_4: &str = "  FREQ   TOT TRANS  PTH THRML  THRML SCT  SURF EMIS   SOL SCAT  SING SCAT  \
                         GRND RFLT  DRCT RFLT  TOTAL RAD  REF SOL  SOL@OBS   DEPTH";
const MODTRAN_5: &str = "   FREQ   TOT_TRANS   PTH_THRML   THRML_SCT  SURF_EMIS    SOL_SCAT   \
                         SING_SCAT   GRND_RFLT  DRCT_RFLT   TOTAL_RAD    REF_SOL   SOL@OBS    DEPTH";

/// A tape7 of a grey atmosphere of 250 K and transmittance 0.8, in which the sun scatters as much
/// again as `scattered` of its emission. Thermal runs leave the columns of the sun blank.
fn tape7(heading: &str, scattered: Option<f64>) -> String {
    let cards = "TF  2    3    1    0    0    0    0\n    1    0    0   0.0  T  \n";
    let mut text = format!("{cards}{heading}\n");
    let ends: Vec<usize> = {
        let mut joined = heading.to_owned();
        for name in [
            "TOT TRANS",
            "PTH THRML",
            "THRML SCT",
            "SURF EMIS",
            "SOL SCAT",
            "SING SCAT",
            "GRND RFLT",
            "DRCT RFLT",
            "TOTAL RAD",
            "REF SOL",
        ] {
            joined = joined.replace(name, &name.replace(' ', "_"));
        }
        let words = joined.split_whitespace();
        words.map(|word| joined.find(word).expect("it is there") + word.len()).collect()
    };
    for step in 0..=40 {
        let wavenumber = 700.0 + 20.0 * f64::from(step);
        let thermal = 0.2 * planck_by_wavenumber(wavenumber, 250.0);
        let sun = scattered.map(|share| share * thermal);
        let exponent = |x: f64| format!("{x:.4E}").replace("E-", "E-0");
        let total = exponent(thermal + sun.unwrap_or(0.0));
        let of_sun = sun.map_or_else(String::new, exponent);
        let fields = [
            format!("{wavenumber:.1}"),
            "0.8000".into(),
            exponent(thermal),
            String::new(),
            exponent(0.0),
            of_sun.clone(),
            of_sun,
            exponent(0.0),
            String::new(),
            total,
            String::new(),
            String::new(),
            "0.223".into(),
        ];
        let mut line = String::new();
        for (field, &end) in fields.iter().zip(&ends) {
            line += &format!("{field:>width$}", width = end.saturating_sub(line.len()));
        }
        text += &(line + "\n");
    }
    text + " -9999.\n"
}

#[test]
fn a_tape7_by_wavenumber_is_a_sky_and_an_atmosphere_by_wavelength() {
    let place = traced();
    let grey = column(&place, &["--sky", "250"], "l_downwelling_w_m2_sr_um");
    for (heading, scattered) in [(MODTRAN_4, None), (MODTRAN_5, None), (MODTRAN_5, Some(0.5))] {
        fs::write(place.path("tape7"), tape7(heading, scattered)).expect("written");
        let sky = column(&place, &["--sky", "tape7"], "l_downwelling_w_m2_sr_um");
        let part = 0.2 * (1.0 + scattered.unwrap_or(0.0));
        let wanted: Vec<f64> = grey.iter().map(|l| part * l).collect();
        close(&sky, &wanted, BETWEEN);
        // What reaches the sensor: 0.8 of what leaves the target, and the path.
        let options = ["--sky", "1", "--atmosphere", "tape7"];
        let l_target = column(&place, &options, "l_target_w_m2_sr_um");
        let l_sensor = column(&place, &options, "l_sensor_w_m2_sr_um");
        let path: Vec<f64> = l_sensor.iter().zip(&l_target).map(|(l, own)| l - 0.8 * own).collect();
        close(&path, &wanted, BETWEEN);
    }
}

#[test]
fn output_of_uvspec_with_its_options_in_comments_is_a_sky_and_an_atmosphere() {
    let place = traced();
    let grey = column(&place, &["--sky", "250"], "l_downwelling_w_m2_sr_um");
    // Columns, process, and what stands in the second column: radiance per cm-1 and per nm.
    let by_cm = |wavenumber: f64| 1e4 * planck_by_wavenumber(wavenumber, 250.0);
    let by_nm = |wavenumber: f64| by_cm(wavenumber) * wavenumber.powi(2) / 1e7;
    for (columns, process, of) in [
        ("lambda uu", "", &by_cm as &dyn Fn(f64) -> f64),
        ("lambda uu", "# output_process per_cm-1\n", &by_cm),
        ("lambda uu", "# output_process per_nm\n", &by_nm),
        ("lambda edn", "# output_process per_nm\n", &|x| PI * by_nm(x)),
    ] {
        let row = |step: i32| {
            let wavenumber = 1400.0 - 10.0 * f64::from(step);
            format!("  {:.4}  {:.6e}\n", 1e7 / wavenumber, of(wavenumber))
        };
        let rows: String = (0..=70).map(row).collect();
        let text = format!("#output_user {columns}\n{process}{rows}");
        fs::write(place.path("sky.out"), text).expect("written");
        let sky = column(&place, &["--sky", "sky.out"], "l_downwelling_w_m2_sr_um");
        close(&sky, &grey, BETWEEN);
    }
    let head = "# output_user lambda transmittance uu_path\n# output_process per_nm\n";
    fs::write(place.path("air.out"), format!("{head}7000 0.5 0.001\n14000 0.5 0.001\n"))
        .expect("written");
    let options = ["--atmosphere", "air.out"];
    let l_target = column(&place, &options, "l_target_w_m2_sr_um");
    let l_sensor = column(&place, &options, "l_sensor_w_m2_sr_um");
    for (l, own) in l_sensor.iter().zip(&l_target) {
        assert!((l - 0.5 * own - 1.0).abs() < 1e-6, "{l} {own}");
    }
}

#[test]
fn files_of_these_programs_that_do_not_tell_are_refused_with_the_reason() {
    let place = traced();
    let sound = tape7(MODTRAN_5, None);
    let twice = format!("{sound}{sound}");
    let broken = sound.replacen("0.8000", "0.8x00", 1);
    for (option, text, problem) in [
        ("--sky", "  FREQ  COMBIN    H2O  TRANS\n  700.0 0.1 0.2 0.3\n", "no radiance"),
        ("--sky", &*twice, "several runs"),
        ("--atmosphere", &*broken, "line 4: these are not numbers"),
        (
            "--sky",
            "# output_user lambda uu\n8000 1 2\n",
            "line 2: 3 columns, but output_user names 2",
        ),
        ("--sky", "# output_user lambda eup\n8000 1\n", "none of the columns"),
        ("--sky", "# output_user uu\n1\n", "no column lambda"),
        (
            "--sky",
            "# output_user lambda uu\n# output_process sum\n8000 1\n",
            "sum gives no spectrum",
        ),
        ("--sky", "# output_user lambda uu\n", "no numbers"),
        ("--atmosphere", "# output_user lambda uu\n8000 1\n9000 1\n", "transmittance is missing"),
    ] {
        fs::write(place.path("file"), text).expect("written");
        let (_, said) = place.run(&["signature", "t.json", option, "file"], 3);
        assert!(said.contains(problem), "{text}\n{said}");
    }
}

#[test]
fn the_example_atmosphere_is_what_its_page_says() {
    let place = traced();
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/atmosphere.csv");
    let black = column(&place, &["--sky", "280"], "l_downwelling_w_m2_sr_um");
    let sky = column(&place, &["--sky", file], "l_downwelling_w_m2_sr_um");
    let options = ["--sky", file, "--atmosphere", file];
    let l_target = column(&place, &options, "l_target_w_m2_sr_um");
    let l_sensor = column(&place, &options, "l_sensor_w_m2_sr_um");
    // At 8, 9, 11, 12 and 13 um the file has points.
    for (band, t) in [(0, 0.5_f64), (1, 0.82), (3, 0.87), (4, 0.81), (5, 0.65)] {
        let path = l_sensor[band] - t * l_target[band];
        assert!((path - (1.0 - t) * black[band]).abs() < 1e-4, "{path}");
        assert!((sky[band] - (1.0 - t.powf(1.66)) * black[band]).abs() < 1e-4, "{}", sky[band]);
    }
}
