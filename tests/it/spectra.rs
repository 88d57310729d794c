//! Spectra of the user's own: what is read, refused, warned about, and written back the same.

use std::fs;
use std::path::PathBuf;

use insta::assert_snapshot;
use soilsig::spectrum::format::{Reading, read, read_one, write};
use soilsig::spectrum::resample::{Response, resampling_error};
use soilsig::spectrum::{Quantity, Spectrum, SpectrumError, Tabulated, Warning};
use soilsig::support::error::Failure;
use soilsig::support::file_error::FileError;

use crate::support::{Place, message, told};

/// A file in the form of the ECOSTRESS library, of numbers made up here.
struct Ecostress {
    measurement: &'static str,
    y_units: &'static str,
    rows: Vec<String>,
}

impl Default for Ecostress {
    fn default() -> Self {
        Self {
            measurement: "Directional (10 Degree) Hemispherical Reflectance",
            y_units: "Y Units:Reflectance (percent)",
            rows: ["14.0\t5.25", " 10.0\t 20.0", "7.0\t0.0"].map(Into::into).to_vec(),
        }
    }
}

impl Ecostress {
    fn text(&self) -> String {
        let count = self.rows.len();
        let header = format!(
            "Name: Made up\nType: Mineral\nClass: None\nSubclass: None\nParticle Size: Fine\nSample No.: X-1\n\
             Owner: Nobody\nWavelength Range: TIR\nOrigin: N/A\nCollection Date: N/A\n\
             Description: 50 \u{b5}m: a test\nMeasurement: {}\nFirst Column: X\nSecond Column: Y\n\
             X Units: Wavelength (micrometers)\n{}\nFirst X Value: 14\nLast X Value:  7\n\
             Number of X Values: {count}\nAdditional Information: none\n\n",
            self.measurement, self.y_units,
        );
        (header + &self.rows.join("\n") + "\n").replace('\n', "\r\n")
    }

    fn read(&self) -> Result<Tabulated, SpectrumError> {
        // Latin-1, as some files of the library are.
        let latin_1: Vec<u8> = self.text().chars().map(|c| c as u8).collect();
        one("spectrum.txt", &latin_1, &Reading::default())
    }
}

fn one(name: &str, content: &[u8], reading: &Reading) -> Result<Tabulated, SpectrumError> {
    let place = Place::new();
    fs::write(place.path(name), content).expect("written");
    read_one(&place.path(name), reading)
}

#[test]
fn ecostress_text_is_read_in_either_order_percent_by_kirchhoff_and_in_latin_1() {
    let spectrum = Ecostress::default().read().expect("a spectrum");
    assert_eq!(spectrum.wavelength_um, [7.0, 10.0, 14.0]);
    assert_eq!(spectrum.emissivity, [1.0, 0.8, 1.0 - 5.25 / 100.0]);
    assert_eq!(spectrum.name.as_deref(), Some("Made up Fine X-1"));
    assert!(spectrum.warnings.is_empty());
    let mut ascending = Ecostress::default();
    ascending.rows.reverse();
    assert_eq!(ascending.read().expect("a spectrum"), spectrum);
    for y_units in ["Y Units: Reflectance (percent)", "Y Units: Reflectence (percent)"] {
        let spelt = Ecostress { y_units, ..Ecostress::default() };
        assert_eq!(spelt.read().expect("a spectrum"), spectrum, "{y_units}");
    }
}

#[test]
fn transmission_is_refused_wherever_and_however_it_is_spelt() {
    for spelling in ["Transmittance", "Transmittence", "Transittance", "Transmission"] {
        let y_units = format!("Y Units: {spelling} (percent)").leak();
        for file in [
            Ecostress { y_units, ..Ecostress::default() },
            Ecostress { measurement: spelling, ..Ecostress::default() },
        ] {
            assert!(matches!(file.read(), Err(SpectrumError::Transmission { .. })), "{spelling}");
        }
        let csv = format!("um,{spelling}\n8,0.2\n9,0.3\n");
        let read = one("x.csv", csv.as_bytes(), &Reading::default());
        assert!(matches!(read, Err(SpectrumError::Transmission { .. })), "{spelling}");
    }
}

#[test]
fn reflectance_that_is_not_hemispherical_is_warned_about() {
    let file = Ecostress { measurement: "Bidirectional reflectance", ..Ecostress::default() };
    let warnings = file.read().expect("a spectrum").warnings;
    assert!(matches!(warnings.as_slice(), [Warning::Bidirectional(_)]));
    let mut said = format!("{}\n\n", warnings[0]);
    let file = Ecostress { measurement: "", ..Ecostress::default() };
    assert_eq!(file.read().expect("a spectrum").warnings, [Warning::GeometryNotStated]);
    let place = Place::new();
    let file = Ecostress { measurement: "Bidirectional reflectance", ..Ecostress::default() };
    fs::write(place.path("bi.txt"), file.text()).expect("written");
    let check = ["spectra", "check", "bi.txt"];
    said += &told(&check, 0, &place.run(&check, 0).0);
    assert_snapshot!(said);
}

#[test]
fn bad_rows_are_refused_by_their_line() {
    let mut told = String::new();
    for row in [
        "9.0\t101.5",
        "9.0\t-0.5",
        "9.0\tNaN",
        "7.0\t3.0",
        "9.0",
        "9.0\tx",
        "NaN\t3.0",
        "-9.0\t3.0",
    ] {
        let mut file = Ecostress::default();
        file.rows.push(row.into());
        match file.read() {
            Err(SpectrumError::File(FileError::Wrong { place, problem, .. })) => {
                assert_eq!(place.as_deref(), Some("line 25"), "{row:?}");
                told += &format!("{row:?}: {problem}\n");
            }
            other => panic!("{row:?} gave {other:?}"),
        }
    }
    let cut = Ecostress::default().text().replace("Values: 3", "Values: 4");
    let error = one("cut.txt", cut.as_bytes(), &Reading::default()).expect_err("cut short");
    let error = error.to_string();
    let (_, of_file) = error.split_once("cut.txt").expect("the file's name");
    told += &format!("cut short: cut.txt{of_file}\n");
    assert_snapshot!(told);
}

#[test]
fn usgs_text_takes_its_wavelengths_from_their_file_and_deleted_channels_leave_a_gap() {
    let place = Place::new();
    let spectrum = place.path("s.txt");
    let wavelengths = place.path("w.txt");
    fs::write(
        &spectrum,
        " splib07a Record=1: Made up BECKa AREF\n 0.25\n -1.2300000e+034\n 0.75\n 0.5\n",
    )
    .expect("written");
    fs::write(&wavelengths, " splib07a Record=2: Wavelengths\n 8.0\n 8.5\n 9.0\n 10\n")
        .expect("written");
    let error = read_one(&spectrum, &Reading::default()).expect_err("no wavelengths");
    let mut told = message(&error, error.hint());
    let reading = Reading { wavelengths: Some(wavelengths.clone()), ..Reading::default() };
    let read = read_one(&spectrum, &reading).expect("a spectrum");
    assert_eq!(read.wavelength_um, [8.0, 9.0, 10.0]);
    assert_eq!(read.emissivity, [0.75, 0.25, 0.5]);
    assert_eq!(read.gaps_um, [[8.0, 9.0]]);
    assert_eq!(read.warnings, [Warning::GeometryNotStated]);
    let read = Spectrum::Tabulated(read);
    assert!(read.emissivity(9.0).is_ok() && read.emissivity(9.5).is_ok());
    let error = read.emissivity(8.5).expect_err("deleted");
    told += &message(&error, error.hint());
    fs::write(&wavelengths, "title\n8.0\n8.5\n9.0\n").expect("written");
    let error = read_one(&spectrum, &reading).expect_err("too few");
    told += &message(&error, error.hint());
    assert_snapshot!(told);
}

#[test]
fn outside_its_range_the_error_names_file_range_wanted_and_range_held() {
    let place = Place::new();
    fs::write(place.path("short.csv"), "8,0.5\n12,0.6\n").expect("written");
    let command =
        ["spectra", "convert", "short.csv", "--range", "7.5-13", "--step", "0.5", "--out", "x.csv"];
    let mut told = place.refused(&command, 3);
    assert!(!place.path("x.csv").exists());
    let spectrum =
        Spectrum::Tabulated(read_one(&place.path("short.csv"), &Reading::default()).expect("one"));
    let error = spectrum.covers([7.5, 13.0]).expect_err("too short");
    told += &message(&error, error.hint());
    assert_snapshot!(told);
}

/// Numbers that no short decimal holds.
fn curves() -> (Vec<f64>, Vec<(String, Vec<f64>)>) {
    let um: Vec<f64> = (0..50).map(|i| 7.0 + f64::from(i) / 7.0).collect();
    let curve =
        |phase: f64| um.iter().map(|um| (0.5 + 0.5 * (um + phase).sin()).clamp(0.0, 1.0)).collect();
    (um.clone(), vec![("one".into(), curve(0.1)), ("two".into(), curve(0.7))])
}

#[test]
fn what_is_written_reads_back_to_the_last_bit() {
    let place = Place::new();
    let (um, curves) = curves();
    for (name, count) in [("x.csv", 1), ("x.ems", 1), ("y.ems", 2), ("x.sli", 2)] {
        write(&place.path(name), &um, &curves[..count]).expect("written");
        let back = read(&place.path(name), &Reading::default()).expect("read");
        assert_eq!(back.len(), count, "{name}");
        for (back, (_, curve)) in back.iter().zip(&curves) {
            assert_eq!((&back.wavelength_um, &back.emissivity), (&um, curve), "{name}");
            assert!(back.warnings.is_empty(), "{name}");
        }
    }
    let error = write(&place.path("z.csv"), &um, &curves).expect_err("two in one");
    let mut told = message(&error, error.hint());
    let error = read_one(&place.path("x.sli"), &Reading::default()).expect_err("two");
    told += &message(&error, error.hint());
    assert_snapshot!(told);
    let header = fs::read_to_string(place.path("x.hdr")).expect("written");
    assert!(header.contains("\nwavelength units = Micrometers\n") && header.contains("{one, two}"));
    let args = ["spectra", "convert", "x.sli", "--name", "two", "--out", "two.csv"];
    place.run(&args, 0);
    let two = read_one(&place.path("two.csv"), &Reading::default()).expect("read");
    assert_eq!(two.emissivity, curves[1].1);
}

#[test]
fn envi_libraries_in_single_precision_other_byte_order_units_scale_and_bad_bands() {
    let place = Place::new();
    let values: [f32; 4] = [2000.0, 9999.0, 5000.0, 7500.0];
    let bytes: Vec<u8> =
        [0; 3].into_iter().chain(values.iter().flat_map(|v| v.to_be_bytes())).collect();
    fs::write(place.path("l.sli"), bytes).expect("written");
    let header = |more: &str| {
        format!(
            "ENVI\nsamples = 4\nlines   = 1\nbands = 1\nheader offset = 3\nfile type = ENVI Spectral Library\n\
             data type = 4\nbyte order = 1\nwavelength units = Nanometers\nreflectance scale factor = 10000\n\
             bbl = {{1, 0, 1, 1}}\nwavelength = {{8000,\n 8500,\n 9000, 9500}}\n{more}"
        )
    };
    let put = |text: String| fs::write(place.path("l.sli.hdr"), text).expect("written");
    let path: PathBuf = place.path("l.sli");
    put(header(""));
    let error = read_one(&path, &Reading::default()).expect_err("of what?");
    let mut told = message(&error, error.hint());
    let reading = Reading { quantity: Some(Quantity::Emissivity), ..Reading::default() };
    assert_eq!(
        read_one(&path, &reading).expect("read").emissivity,
        [2000.0, 5000.0, 7500.0].map(|v: f64| v / 10000.0)
    );
    put(header("z plot titles = {Wavelength, Reflectance}\n"));
    let read = read_one(&place.path("l.sli.hdr"), &Reading::default()).expect("read");
    assert_eq!(read.wavelength_um, [8.0, 9.0, 9.5]);
    assert_eq!(read.emissivity, [0.8, 0.5, 0.25]);
    assert_eq!(read.gaps_um, [[8.0, 9.0]]);
    for (from, to) in [
        ("samples = 4", "samples = 5"),
        ("Spectral Library", "Standard"),
        ("data type = 4", "data type = 6"),
        ("Nanometers", "Unknown"),
        ("8000,", ""),
    ] {
        put(header("").replace(from, to));
        let error = read_one(&path, &reading).expect_err(from);
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
}

#[test]
fn dirsigs_old_files_are_read_with_a_warning_and_broken_ones_refused() {
    let weights = "1.0\n".repeat(91);
    let old = format!("1\n{weights}0\n1450 0.9\n1350 0.8\n1250 0.7\n");
    let read = one("old.ems", old.as_bytes(), &Reading::default()).expect("read");
    assert_eq!(read.wavelength_um, [1e4 / 1450.0, 1e4 / 1350.0, 1e4 / 1250.0]);
    assert_eq!(read.emissivity, [0.9, 0.8, 0.7]);
    assert_eq!(read.warnings, [Warning::Coarse]);
    let weighed = format!("1\n0.9\n{}CURVE_BEGIN\n8 0.5\n9 0.6\n", "1.0\n".repeat(90));
    let read = one("w.ems", weighed.as_bytes(), &Reading::default()).expect("read");
    assert_eq!(read.warnings, [Warning::AngularWeights]);
    let mut told = String::new();
    for text in [
        format!("2\n{weights}CURVE_BEGIN\n8 0.5\n9 0.6\n"),
        format!("1\n{weights}8 0.5\n9 0.6\n"),
        format!("1\n{}CURVE_BEGIN\n8 0.5\n9 0.6\n", "1.0\n".repeat(90)),
        "1\n1.0\n".into(),
    ] {
        let error = one("x.ems", text.as_bytes(), &Reading::default()).expect_err(&text);
        told += &message(&error, error.hint());
    }
    assert_snapshot!(told);
}

#[test]
fn a_headings_units_and_quantity_are_followed() {
    for text in [
        "wavelength_um,reflectance\n8,0.25\n10,0.5\n",
        "\u{feff}wavelength (nm);reflectance (%)\r\n8000;25\r\n10000;50\r\n",
        "# a comment\nwavenumber emissivity\n1250 0.75\n1000 0.5\n",
    ] {
        let read = one("x.csv", text.as_bytes(), &Reading::default()).expect("read");
        assert_eq!(read.wavelength_um, [8.0, 10.0], "{text}");
        assert_eq!(read.emissivity, [0.75, 0.5], "{text}");
    }
}

#[test]
fn a_bad_value_outside_the_range_wanted_can_be_left_out() {
    let text = b"2,1.01\n8,0.5\n10,0.75\n12,0.5\n";
    assert!(one("x.csv", text, &Reading::default()).is_err());
    let reading = Reading { range_um: Some([9.0, 11.0]), ..Reading::default() };
    let read = one("x.csv", text, &reading).expect("read");
    assert_eq!(read.wavelength_um, [8.0, 10.0, 12.0], "with the neighbours of the ends");
}

#[test]
fn band_means_are_exact_for_straight_lines_and_the_resampling_error_is_what_is_lost() {
    let bend = one("x.csv", b"8,0.25\n9,0.75\n10,0.25\n", &Reading::default()).expect("read");
    let bend = Spectrum::Tabulated(bend);
    // The tip's mean under a triangle of base 1: 0.75 - 0.5 / 6.
    let at_tip = Response::triangle(9.0, 0.5).band_mean(&bend).expect("within");
    assert!((at_tip - (0.75 - 0.5 / 6.0)).abs() < 1e-14, "{at_tip}");
    let on_slope = Response::triangle(8.5, 0.25).band_mean(&bend).expect("within");
    assert!((on_slope - 0.5).abs() < 1e-14);
    assert!(Response::triangle(8.2, 0.5).band_mean(&bend).is_err());
    let error = resampling_error(&bend, &[8.0, 10.0], &[0.25, 0.25]).expect("within");
    assert_eq!((error.largest, error.at_um), (-0.5, 9.0));
    let place = Place::new();
    fs::write(place.path("x.csv"), "8,0.25\n9,0.75\n10,0.25\n").expect("written");
    fs::write(place.path("band.csv"), "um,response\n8.25,0\n8.5,1\n8.75,0\n").expect("written");
    fs::write(place.path("tip.csv"), "um,response\n8.5,0\n9,1\n9.5,0\n").expect("written");
    let args =
        ["spectra", "convert", "x.csv", "--response", "tip.csv", "band.csv", "--out", "b.csv"];
    let (_, said) = place.run(&args, 0);
    assert_snapshot!(told(&args, 0, &said));
    let bands = read_one(&place.path("b.csv"), &Reading::default()).expect("read");
    assert!(
        (bands.emissivity[0] - 0.5).abs() < 1e-12 && (bands.emissivity[1] - at_tip).abs() < 1e-12
    );
}

#[test]
fn a_unit_in_the_heading_is_heard_wherever_it_stands() {
    for heading in ["Wavelength [nm],Reflectance", "wavelength (nm) reflectance"] {
        let text = format!("{heading}\n8000,0.2\n14000,0.3\n");
        let text = if heading.contains(',') { text } else { text.replace(',', " ") };
        let read = one("x.csv", text.as_bytes(), &Reading::default()).expect(heading);
        assert_eq!((read.wavelength_um, read.emissivity), (vec![8.0, 14.0], vec![0.8, 0.7]));
    }
    let read =
        one("x.csv", b"wavelength,reflectance (percent)\n8,20\n14,30\n", &Reading::default());
    assert_eq!(read.expect("um is the default").emissivity, [0.8, 0.7]);
    let error = one("x.csv", b"wavelength (ly),emissivity\n8,0.2\n9,0.3\n", &Reading::default());
    let error = error.expect_err("light years");
    assert_snapshot!(message(&error, error.hint()));
}

#[test]
fn a_response_may_be_called_a_transmittance_and_a_spectrum_may_not() {
    let place = Place::new();
    fs::write(place.path("b.csv"), "wavelength_um,transmittance\n8,0\n9,1\n10,0\n")
        .expect("written");
    assert_eq!(Response::read(&place.path("b.csv")).expect("a band").centre_um(), 9.0);
    assert!(read_one(&place.path("b.csv"), &Reading::default()).is_err());
}

/// 13.55 + .05 is a little more than 13.6.
#[test]
fn a_slit_may_end_where_the_spectrum_does() {
    let place = Place::new();
    fs::write(place.path("x.csv"), "8.2,0.25\n13.6,0.75\n").expect("written");
    let args =
        ["spectra", "convert", "x.csv", "--step", "0.05", "--width", "0.05", "--out", "o.csv"];
    place.run(&args, 0);
    let read = read_one(&place.path("o.csv"), &Reading::default()).expect("read");
    assert_eq!(read.range_um(), [8.25, 13.55]);
}

#[test]
fn names_of_a_library_stay_with_their_spectra() {
    let place = Place::new();
    let data: Vec<u8> =
        [0.1_f32, 0.1, 0.2, 0.2, 0.3, 0.3].iter().flat_map(|v| v.to_le_bytes()).collect();
    fs::write(place.path("n.sli"), data).expect("written");
    fs::write(
        place.path("n.hdr"),
        "ENVI\nsamples = 2\nlines = 3\nbands = 1\nfile type = ENVI Spectral Library\ndata type = 4\n\
         wavelength units = Micrometers\nz plot titles = {Wavelength, Emissivity}\nwavelength = {8, 9,}\n\
         spectra names = {a, , c}\n",
    )
    .expect("written");
    let read = read(&place.path("n.sli"), &Reading::default()).expect("a library");
    let names: Vec<&str> = read.iter().filter_map(|s| s.name.as_deref()).collect();
    assert_eq!(names, ["a", "2", "c"]);
    assert!((read[2].emissivity[0] - 0.3).abs() < 1e-6);
}

#[test]
fn spectra_are_listed_shown_and_plotted() {
    let place = Place::new();
    assert!(place.run(&["spectra", "list"], 0).0.contains("fresnel:quartz"));
    let (out, _) = place.run(&["spectra", "show", "quartz_fine"], 0);
    assert_snapshot!(out);
    let args = [
        "spectra",
        "plot",
        "quartz_fine",
        "fresnel:quartz",
        "0.9",
        "--range",
        "7.5-13",
        "--out",
        "p.svg",
    ];
    place.run(&args, 0);
    let chart = fs::read_to_string(place.path("p.svg")).expect("written");
    assert!(chart.contains("quartz_fine") && chart.contains("hemispherical"));
}
