//! Radiance as others bring it: ENVI images in all their ways, tables of office programs, numbers at
//! the edge of what is a number.

use std::fs;

use insta::assert_snapshot;
use soilsig::products::cube::Cube;
use soilsig::radiometry::planck;

use crate::support::{Place, shipped};

const UM: [f64; 5] = [8.0, 8.5, 9.0, 9.5, 10.0];
const EMISSIVITY: [f32; 5] = [0.9, 0.8, 0.7, 0.8, 0.9];

/// Writes an image of 3 x 2 pixels at 300 K, with a header of further lines.
fn write_image(place: &Place, data: &str, header: &str, more: &str) {
    let l = UM.iter().zip(EMISSIVITY).flat_map(|(um, e)| [(e * planck(*um, 300.0) as f32); 6]);
    fs::write(place.path(data), l.flat_map(f32::to_le_bytes).collect::<Vec<_>>()).expect("written");
    let text = format!(
        "ENVI\nsamples = 3\nlines = 2\nbands = 5\ndata type = 4\ninterleave = bsq\n\
         byte order = 0\nwavelength units = Micrometers\n{more}\n"
    );
    place.write(header, text);
}

/// Retrieves it; returns the emissivity and what was said.
fn retrieved(place: &Place, file: &str, more: &[&str]) -> (Cube, String) {
    let args = [&["retrieve", file, "--temperature", "300", "--out", "e.img"][..], more].concat();
    let (_, said) = place.run(&args, 0);
    (Cube::read(&place.path("e.img")).expect("an image"), said)
}

const WAVELENGTHS: &str = "wavelength = {8, 8.5, 9, 9.5, 10}";

#[test]
fn envi_images_are_found_and_read_as_other_programs_write_them() {
    for (data, header, named) in [
        ("s.img", "s.hdr", "s.img"),
        ("SCENE.IMG", "SCENE.HDR", "SCENE.IMG"),
        ("SCENE.IMG", "SCENE.HDR", "SCENE.HDR"),
        ("Scene.dat", "Scene.dat.HDR", "Scene.dat"),
        ("f1.rdn", "f1.hdr", "f1.hdr"),
        ("f1_rdn_ort", "f1_rdn_ort.hdr", "f1_rdn_ort.hdr"),
        ("f1.cube", "f1.hdr", "f1.hdr"),
    ] {
        let place = Place::new();
        write_image(&place, data, header, WAVELENGTHS);
        let (e, _) = retrieved(&place, named, &[]);
        assert!((e.spectrum(1, 2)[2] - 0.7).abs() < 1e-6, "{named}");
    }
    for more in [
        "data units = W m-2 sr-1 um-1\nwavelength = {8, 8.5, 9, 9.5, 10}",
        "z plot titles = {Wavelength (um), W/(m^2 sr micron)}\nwavelength = {8, 8.5, 9, 9.5, 10}",
        "data gain values = {1, 1, 1, 1, 1}\nwavelength = {8, 8.5, 9, 9.5, 10}",
        "wavelength = {8, 8.5, 9, 9.5, 10}\nheader offset = 0.0 ; bytes",
        "wavelength =\n{8, 8.5, 9, 9.5, 10}\nbbl =",
        "wavelength = {\n; centres\n8,\n8.5, 9, 9.5,\n10\n}",
        "description = {by {a tool},\n lines = 99}\nwavelength = {8, 8.5, 9, 9.5, 10}",
        "wavelength = {8, 8.5, 9, 9.5, 10}\ninterleave = \"bsq\"",
        "WAVELENGTH = {8, 8.5, 9, 9.5, 10}\nbbl = {1.0, 1.0, 1.0, 1.0, 1.0}",
    ] {
        let place = Place::new();
        write_image(&place, "s.img", "s.hdr", more);
        let (e, said) = retrieved(&place, "s.img", &[]);
        let off = e.spectrum(0, 0).iter().zip(EMISSIVITY).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(off && !said.contains("left out"), "{more}: {said}");
        place.write("s.hdr", place.read("s.hdr").replace('\n', "\r"));
        retrieved(&place, "s.img", &[]);
    }
    let mut told = String::new();
    for more in [
        "data units = microW/cm2/sr/um",
        "radiance units = mW m-2 sr-1 um-1",
        "z plot titles = {Wavelength, Radiance (W m-2 sr-1 nm-1)}",
        "units = microflicks",
        "data gain values = {2, 2, 2, 2, 2}",
        "file compression = 1",
        "major frame offsets = {16, 0}",
    ] {
        let place = Place::new();
        write_image(&place, "s.img", "s.hdr", &format!("{WAVELENGTHS}\n{more}"));
        let args = ["retrieve", "s.img", "--temperature", "300", "--out", "e.img"];
        told += &place.refused(&args, 3);
    }
    let place = Place::new();
    let in_nm = "wavelength = {8000, 8500, 9000, 9500, 10000}";
    write_image(&place, "s.img", "s.hdr", in_nm);
    told += &place.refused(&["retrieve", "s.img", "--temperature", "300", "--out", "e.img"], 3);
    assert_snapshot!(told);
}

#[test]
fn tables_that_have_two_columns_of_a_name_or_another_unit_are_refused() {
    let place = Place::new();
    place.write("two.csv", "wavelength_um,l_target_w_m2_sr_um,l_target_w_m2_sr_um\n8,8,1\n9,7,1\n");
    place.write("nm.csv", "wavelength_um,l_target_w_m2_sr_um\n8000,8\n9000,7\n");
    for (file, what) in [("two.csv", "two columns"), ("nm.csv", "outside 0.1 to 1000 um")] {
        let said = place.refused(&["retrieve", file, "--temperature", "300"], 3);
        assert!(said.contains(what), "{said}");
    }
}

/// What a header says, and what it holds, must be radiance in W m-2 sr-1 um-1.
#[test]
fn an_image_of_another_quantity_is_refused() {
    let refused = |more: &str| {
        let place = Place::new();
        write_image(&place, "s.img", "s.hdr", &format!("{WAVELENGTHS}\n{more}"));
        place.refused(&["retrieve", "s.img", "--temperature", "300", "--out", "e.img"], 3)
    };
    for unit in ["Kelvin", "K", "degC", "Reflectance", "Emissivity", "DN", "counts", "percent", "%"]
    {
        for key in ["data units", "units"] {
            assert!(refused(&format!("{key} = {unit}")).contains("is needed"), "{unit}");
        }
        let title = format!("z plot titles = {{Wavelength (um), {unit}}}");
        assert!(refused(&title).contains("is needed"), "{unit}");
    }
    for (more, word) in [
        ("file type = ENVI Classification", "a map of classes"),
        ("radiance scale factor = 1000", "radiance scale factor"),
        ("data scale factor = 1000", "data scale factor"),
        ("radiance gain values = {.001, .001, .001, .001, .001}", "radiance gain values"),
        ("add offset = 5", "add offset"),
        ("wavelength = {10, 9.5, 9, 8.5, 8}", "wavelength stands twice"),
        ("samples = 2", "samples stands twice"),
        ("byte order = 1", "byte order stands twice"),
    ] {
        assert!(refused(more).contains(word), "{more}");
    }
    for more in
        ["radiance scale factor = 1", "samples = 3", "data reflectance gain values = {2, 3}"]
    {
        let place = Place::new();
        write_image(&place, "s.img", "s.hdr", &format!("{WAVELENGTHS}\n{more}"));
        retrieved(&place, "s.img", &[]);
    }
    // Two headers of one data file.
    let place = Place::new();
    write_image(&place, "s.img", "s.hdr", WAVELENGTHS);
    place.write("s.img.hdr", place.read("s.hdr"));
    retrieved(&place, "s.img", &[]);
    place.write("s.img.hdr", place.read("s.hdr").replace("9.5", "9.6"));
    let args = ["retrieve", "s.img", "--temperature", "300", "--out", "e.img"];
    assert!(place.refused(&args, 3).contains("another header"));
    retrieved(&place, "s.hdr", &[]);
    // An emissivity is no radiance, though soilsig wrote it.
    let place = Place::new();
    write_image(&place, "s.img", "s.hdr", WAVELENGTHS);
    retrieved(&place, "s.img", &[]);
    let again = ["retrieve", "e.img", "--temperature", "300", "--out", "f.img"];
    assert!(place.refused(&again, 3).contains("emissivity"));
}

#[test]
fn numbers_of_an_image_that_are_no_radiance_are_refused_or_warned_of() {
    let place = Place::new();
    write_image(&place, "s.img", "s.hdr", WAVELENGTHS);
    let bytes = fs::read(place.path("s.img")).expect("written");
    let args = ["retrieve", "s.img", "--temperature", "300", "--out", "e.img"];
    let swapped: Vec<u8> = bytes.chunks_exact(4).flat_map(|b| [b[3], b[2], b[1], b[0]]).collect();
    place.write("s.img", swapped);
    let told = place.refused(&args, 3);
    assert!(told.contains("byte order") && told.contains("brighter than any body"), "{told}");
    for mark in [-9999.0_f32, -999.0] {
        place.write("s.img", [&mark.to_le_bytes(), &bytes[4..]].concat());
        assert!(place.refused(&args, 3).contains("data ignore value"), "{mark}");
    }
    let header = place.read("s.hdr");
    place.write("s.hdr", header + "data ignore value = -999\n");
    place.run(&args, 0);
    // In W cm-2 sr-1 um-1, without a word of it.
    let faint =
        bytes.as_chunks().0.iter().flat_map(|b| (f32::from_le_bytes(*b) / 1e4).to_le_bytes());
    place.write("s.img", faint.collect::<Vec<u8>>());
    let (_, said) = place.run(&args, 0);
    assert!(said.contains("may be in another unit"), "{said}");
}

#[test]
fn marks_of_missing_radiances_in_a_table_are_refused() {
    let place = Place::new();
    place.write("r.csv", "wavelength_um,radiance_w_m2_sr_um\n8,7\n9,-9999\n10,8\n");
    let told = place.refused(&["retrieve", "r.csv", "--temperature", "300"], 3);
    assert!(told.contains("line 3") && told.contains("missing"), "{told}");
    let both = "wavelength_um,radiance_w_m2_sr_um,radiance_w_cm2_sr_um\n8,7,1\n9,7,1\n";
    place.write("b.csv", both);
    assert!(place.refused(&["retrieve", "b.csv", "--temperature", "300"], 3).contains("two units"));
}

#[test]
fn bands_that_have_no_result_are_told_with_their_reason() {
    let mut said = String::new();
    for more in [
        "bbl = {1, 1, 1, 0, 1}",
        "bbl = {True, True, True, False, True}",
        "bbl = {1, 1, 1, NaN, 1}",
        "",
        "smile = 1",
    ] {
        let place = Place::new();
        write_image(&place, "s.img", "s.hdr", &format!("{WAVELENGTHS}\n{more}"));
        if more.is_empty() {
            let mut bytes = fs::read(place.path("s.img")).expect("written");
            bytes[72..96].fill(0xff);
            place.write("s.img", bytes);
        }
        let (e, told) = retrieved(&place, "s.img", &[]);
        let gap = e.data[18..24].iter().all(|value| value.is_nan());
        assert_eq!(gap, more != "smile = 1", "{more}");
        assert_eq!(e.is_bad[3], more.starts_with("bbl"), "the result keeps the list");
        said += &format!("{more:?}:\n{told}\n");
    }
    assert_snapshot!(said);
}

/// Numbers of every type, each with a scale factor.
#[test]
fn integers_are_read_as_single_and_double_precision_are() {
    for (data_type, bytes) in [
        (1, (|v| vec![v as u8]) as fn(f64) -> Vec<u8>),
        (2, |v| (v as i16).to_le_bytes().to_vec()),
        (3, |v| (v as i32).to_le_bytes().to_vec()),
        (4, |v| (v as f32).to_le_bytes().to_vec()),
        (5, |v| v.to_le_bytes().to_vec()),
        (12, |v| (v as u16).to_le_bytes().to_vec()),
        (13, |v| (v as u32).to_le_bytes().to_vec()),
        (14, |v| (v as i64).to_le_bytes().to_vec()),
        (15, |v| (v as u64).to_le_bytes().to_vec()),
    ] {
        let place = Place::new();
        place.write("s.img", [7.0, 93.0].map(bytes).concat());
        let header = format!(
            "ENVI\nsamples = 1\nlines = 1\nbands = 2\ndata type = {data_type}\n\
             wavelength units = nm\nwavelength = {{8000, 9000}}\n\
             reflectance scale factor = 10\n"
        );
        place.write("s.hdr", header);
        let cube = Cube::read(&place.path("s.img")).expect("an image");
        assert_eq!((&cube.data[..], &cube.wavelengths_um[..]), (&[0.7, 9.3][..], &[8.0, 9.0][..]));
    }
}

#[test]
fn the_error_of_the_radiance_is_that_of_the_image_beside_it() {
    let place = Place::new();
    let scene = shipped("settled_patch.json");
    let bands = ["--range", "8-10", "--step", "1", "--noise", "0.1", "--pixels", "2x2"];
    place.run(&[&["image", &scene, "--out", "."][..], &bands].concat(), 0);
    let (_, said) = retrieved(&place, "radiance.img", &[]);
    assert!(said.contains("the standard error of the radiance is that of radiance_standard_error"));
    let errors = |name: &str| Cube::read(&place.path(name)).expect("an image").data;
    let (found, l) = (errors("e_standard_error.img"), errors("radiance_standard_error.img"));
    assert!(found.iter().all(|error| *error > 0.0));
    // Under a cold black sky it is that of the radiance over that of a black body.
    let first = f64::from(l[0]) / planck(8.0, 300.0);
    assert!((f64::from(found[0]) / first - 1.0).abs() < 1e-5, "{} {first}", found[0]);
    fs::remove_file(place.path("radiance_standard_error.img")).expect("removed");
    let (_, said) = retrieved(&place, "radiance.img", &[]);
    assert!(said.contains("comes without a standard error"), "{said}");
    let (_, said) = retrieved(&place, "radiance.img", &["--radiance-error", "0.01"]);
    assert!(!said.contains("without a standard error"), "{said}");
}

#[test]
fn radiances_at_the_edge_of_numbers_are_no_nan_and_faint_ones_are_not_lost() {
    let place = Place::new();
    place.write("faint.csv", "wavelength_um,radiance_w_m2_sr_um\n9,1e-320\n10,5e-9\n");
    let args = ["retrieve", "faint.csv", "--temperature", "300"];
    let (out, _) = place.run(&args, 0);
    assert!(!out.contains("NaN") && !out.contains("inf"), "{out}");
    let l = planck(4.0, 150.0);
    let text = format!("wavelength_um,radiance_w_m2_sr_um\n4,{:e}\n3,1e-14\n", 0.8 * l);
    place.write("cold.csv", text);
    let (out, _) = place.run(&["retrieve", "cold.csv", "--temperature", "150"], 0);
    let row = out.lines().find(|line| line.starts_with("4,")).expect("a row");
    let fields: Vec<f64> = row.split(',').map(|field| field.parse().expect("a number")).collect();
    assert!((fields[1] / (0.8 * l) - 1.0).abs() < 1e-7 && (fields[8] - 0.8).abs() < 1e-6, "{row}");
    place.write("huge.csv", "wavelength_um,radiance_w_m2_sr_um\n9,9e15\n10,5\n");
    let huge = place.refused(&["retrieve", "huge.csv", "--temperature", "300"], 3);
    assert_snapshot!(huge);
}

/// As office programs write them, and as codes of radiative transfer round them.
#[test]
fn tables_with_other_separators_and_rounded_numbers_are_read() {
    let place = Place::new();
    let right = "wavelength_um,radiance_w_m2_sr_um\n9,6.9\n10,8.5\n";
    place.write("l.csv", right);
    let args = ["retrieve", "l.csv", "--temperature", "300"];
    let (expected, _) = place.run(&args, 0);
    for text in [
        right.replace(',', ";").replace('.', ","),
        right.replace(',', "\t"),
        format!("\u{feff}{}", right.replace('\n', "\r\n")),
        right.replace('\n', "\r"),
    ] {
        place.write("l.csv", &text);
        assert_eq!(place.run(&args, 0).0, expected, "{text:?}");
    }
    place.write("l.csv", "wavelength_um;radiance_w_m2_sr_um\n9;6,9\n10;8.5\n");
    let mixed = place.refused(&args, 3);
    place.write("l.csv", right);
    let air = "wavelength_um,transmittance,l_path_w_m2_sr_um\n9,1.0000001,-1e-9\n10,1,0\n";
    place.write("air.csv", air);
    let through = [&args[..], &["--atmosphere", "air.csv"]].concat();
    assert_eq!(place.run(&through, 0).0, expected, "rounding is no error");
    place.write("air.csv", air.replace("-1e-9", "-0.1"));
    let negative = place.refused(&through, 3);
    assert_snapshot!(mixed + &negative);
}
