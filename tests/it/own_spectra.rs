//! Spectra as instruments, libraries and office programs write them: each is read right or refused.
//!
//! All of them hold a reflectance of .059, .32, .059 at 8, 9, 10 um or the emissivity of that.

use std::fs;

use insta::assert_snapshot;
use soilsig::spectrum::format::{Format, Reading, Unit, read, read_one};
use soilsig::spectrum::{Quantity, Spectrum, SpectrumError, Tabulated, Warning};
use soilsig::support::error::Failure;

use crate::support::{Place, message};

const UM: [f64; 3] = [8.0, 9.0, 10.0];
const REFLECTANCE: [f64; 3] = [0.059, 0.32, 0.059];
const EMISSIVITY: [f64; 3] = [0.941, 0.68, 0.941];

fn one(
    name: &str,
    content: impl AsRef<[u8]>,
    reading: &Reading,
) -> Result<Tabulated, SpectrumError> {
    let place = Place::new();
    place.write(name, content);
    read_one(&place.path(name), reading)
}

fn csv(content: &str) -> Result<Tabulated, SpectrumError> {
    one("s.csv", content, &Reading::default())
}

#[track_caller]
fn is_right(read: Result<Tabulated, SpectrumError>, of: &str) {
    let read = read.unwrap_or_else(|error| panic!("{of}: {error}"));
    for (found, right) in [(&read.wavelength_um, UM), (&read.emissivity, EMISSIVITY)] {
        let is_near = found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(found.len() == 3 && is_near, "{of}: {read:?}");
    }
}

/// Rows of x and value, by what separates them.
fn rows(x: impl Fn(f64) -> f64, values: [f64; 3], separator: &str) -> String {
    let rows = UM.iter().zip(values).map(|(um, value)| format!("{}{separator}{value}\n", x(*um)));
    rows.collect()
}

fn emissivity() -> String {
    rows(|um| um, EMISSIVITY, ",")
}

fn reflectance() -> String {
    rows(|um| um, REFLECTANCE, ",")
}

fn percent(values: [f64; 3]) -> [f64; 3] {
    values.map(|value| (1e5 * value).round() / 1e3)
}

#[test]
fn every_word_for_reflectance_and_emissivity_is_followed() {
    for word in ["R", "Refl.", "Albedo", "DHR", "reflectance", "R\u{e9}flectance", "Reflexionsgrad"]
    {
        is_right(csv(&format!("wavelength_um,{word}\n{}", reflectance())), word);
    }
    for word in ["emissivity", "eps", "\u{3b5}", "Emissivit\u{e4}t", "emittance", "Absorptance"] {
        is_right(csv(&format!("Wavelength (um),{word}\n{}", emissivity())), word);
    }
    for word in ["Emissivity (%)", "emissivity_percent"] {
        let rows = rows(|um| um, percent(EMISSIVITY), ",");
        is_right(csv(&format!("Wavelength (um),{word}\n{rows}")), word);
    }
    for word in
        ["%R", "\"Reflectance, %\"", "Reflectance [percent]", "ReflectancePct", "reflectance_pct"]
    {
        let rows = rows(|um| um, percent(REFLECTANCE), ",");
        is_right(csv(&format!("Wavelength (um),{word}\n{rows}")), word);
    }
}

#[test]
fn what_is_no_emissivity_is_refused_and_quantity_settles_what_is_not_known() {
    let mut told = String::new();
    for word in ["Transm.", "%T", "Transmittance", "TRAN", "Absorbance", "abs"] {
        let error = csv(&format!("um,{word}\n{}", emissivity())).expect_err(word);
        let is_named =
            matches!(error, SpectrumError::Transmission { .. } | SpectrumError::Absorbance { .. });
        assert!(is_named, "{word}: {error}");
        told += &message(&error.to_string().split_once("s.csv").expect("the file").1, error.hint());
    }
    let reading = Reading { quantity: Some(Quantity::Reflectance), ..Reading::default() };
    for word in ["T", "value", "quartz sand", "log(1/R)", "1-R", "reflected radiance", "A"] {
        let text = format!("um,{word}\n{}", reflectance());
        let error = csv(&text).expect_err(word);
        told += &message(&error.to_string().split_once("s.csv").expect("the file").1, error.hint());
        is_right(one("s.csv", &text, &reading), word);
    }
    let percent = format!("um,Reflectance (%)\n{}", reflectance());
    let error = csv(&percent).expect_err("no value is above 1");
    told += &message(&error.to_string().split_once("s.csv").expect("the file").1, error.hint());
    is_right(one("s.csv", &percent, &reading), "a fraction in spite of the heading");
    assert_snapshot!(told);
}

#[test]
fn a_word_or_sign_that_changes_a_quantity_makes_it_unclear() {
    let reading = Reading { quantity: Some(Quantity::Reflectance), ..Reading::default() };
    for word in [
        "F(R)",
        "delta R",
        "\u{394}R",
        "R_T",
        "R^-1",
        "R/R0",
        "sqrt(R)",
        "R offset",
        "R-Rmin",
        "R+T",
        "reflectance + 0.1",
        "Reflectance minus mean",
        "residual reflectance",
        "scaled reflectance",
        "inverse reflectance",
        "attenuated total reflectance",
        "Reflectance (arb. units)",
        "reflectance a.u.",
        "100-R (%)",
        "100 - reflectance (%)",
        "reflectance loss (%)",
        "emissivity contrast",
        "stacked emissivity",
        "relative emissivity",
        "complement of the emissivity",
        "d(emissivity)/d\u{3bb}",
        "emissivity x 1000",
        "emissivity*1000",
        "emissivity \u{d7} 10000",
        "reflectance (x10000)",
        "reflectance [1e-3]",
        "reflectance (10^-2)",
        "reflectance (0-100)",
        "reflectance (\u{2030})",
        "reflectance (sr^-1)",
        "non-reflectance",
        "reflectance deficit",
        "half reflectance",
        "reflectance - 0.1",
        "R^2",
        "reflectance/pi",
        "reflectance quality",
        "reflectance \u{b1}",
        "ReflectanceRank",
        "K-M reflectance",
        "quartz1-reflectance",
    ] {
        let text = format!("um,{word}\n{}", reflectance());
        assert!(csv(&text).is_err(), "{word}");
        is_right(one("s.csv", &text, &reading), word);
    }
    for word in [
        "R (-)",
        "R [1]",
        "R_dh",
        "mean R",
        "spectral reflectance",
        "diffuse reflectance",
        "reflectance of roots",
        "quartz sand reflectance",
        "Reflectance (soil, dry)",
        "reflectance, sample 1-b",
        "Reflectance / 1",
        "Reflectance (0-1)",
        "Reflectance 2020-10-12",
        "directional-hemispherical reflectance",
        "reflectance [fraction]",
        "y: reflectance",
    ] {
        is_right(csv(&format!("um,\"{word}\"\n{}", reflectance())), word);
    }
    for prose in [
        "# scaled reflectance\n",
        "# reflectance, continuum removed\n",
        "# 1 - reflectance\n",
        "# values are 1-emissivity\n",
        "# y = 100 % - reflectance\n",
        "# radiance of the sample\n",
        "# not a reflectance\n",
        "# non-reflectance\n",
        "# standard deviation of the reflectance\n",
        "# reflectance uncertainty (1 sigma)\n",
        "# optical depth\n",
        "# wavl,k\n",
    ] {
        assert!(csv(&format!("{prose}{}", reflectance())).is_err(), "{prose}");
    }
    for prose in ["# Sample 1 - reflectance\n", "# sand no. 100 - Reflectance\n"] {
        is_right(csv(&format!("{prose}{}", reflectance())), prose);
    }
    let below = format!("{}# values are transmittance\n", emissivity());
    assert!(csv(&below).is_err(), "a comment below the numbers");
}

#[test]
fn percent_that_no_value_or_every_value_gainsays_is_refused_in_every_format() {
    let place = Place::new();
    place.write(
        "s.dx",
        jcamp("MICROMETERS", "% REFLECTANCE", "##XYPOINTS=(XY..XY)\n8,.059\n9,.32\n10,.059"),
    );
    let header =
        "Name: sand\nX Units: Wavelength (micrometers)\nY Units: Reflectance (percent)\n\n";
    place.write("s.txt", format!("{header}{}", rows(|um| um, REFLECTANCE, "\t")));
    for name in ["s.dx", "s.txt"] {
        let error = read_one(&place.path(name), &Reading::default()).expect_err(name);
        assert!(error.to_string().contains("percent"), "{error}");
        let reading = Reading { quantity: Some(Quantity::Reflectance), ..Reading::default() };
        is_right(read_one(&place.path(name), &reading), name);
    }
    let text = format!("um,reflectance\n{}", rows(|um| um, percent(REFLECTANCE), ","));
    let error = csv(&text).expect_err("no fraction");
    assert!(error.hint().is_some_and(|hint| hint.contains("reflectance-percent")), "{error}");
    let reading = Reading { quantity: Some(Quantity::ReflectancePercent), ..Reading::default() };
    is_right(one("s.csv", text, &reading), "as the hint says");
    let words = format!("um,Reflectance (per cent)\n{}", rows(|um| um, percent(REFLECTANCE), ","));
    is_right(csv(&words), "in two words");
}

#[test]
fn a_unit_with_a_factor_is_read_or_refused() {
    for heading in
        ["Wavelength (10^-6 m)", "Wavelength (10\u{207b}\u{2076} m)", "wavelength (1e-6 m)"]
    {
        is_right(csv(&format!("{heading},emissivity\n{}", emissivity())), heading);
    }
    let nm = rows(|um| um * 1e3, EMISSIVITY, ",");
    is_right(csv(&format!("Wavelength (10^-9 m),emissivity\n{nm}")), "1e-9 m");
    for heading in ["10^3 cm-1", "wavelength (100 nm)", "wavelength (0.1 um)"] {
        assert!(csv(&format!("{heading},emissivity\n{}", emissivity())).is_err(), "{heading}");
    }
}

#[test]
fn comments_and_lines_above_the_heading_are_heard() {
    for above in [
        "# quantity: reflectance\nwavelength_um,value\n",
        "# Hemispherical reflectance of sand\n",
        "# wavelength_um,reflectance\n",
        "## y units = Reflectance\n# made of loess\nwavelength,value\n",
        "Sample: loess\nDate: 2020-01-02\nWavelength (um),Reflectance\n",
        "Wavelength,Reflectance\n(um),(0-1)\n",
        "% reflectance of sand with 5 % moisture\n",
        "; reflectance of sand\n",
        "* reflectance\n* by hand\n",
        "! Reflectance spectrum\n! wavelength um\n",
        "Title: sand\nY Units: Reflectance\nX Units: um\n",
        "\"FTIR reflectance\"\n",
    ] {
        is_right(csv(&format!("{above}{}", reflectance())), above);
    }
    for above in ["# wavelengths in nm\nwavelength,emissivity\n", "# x units: nanometers\n"] {
        is_right(csv(&format!("{above}{}", rows(|um| um * 1e3, EMISSIVITY, ","))), above);
    }
    // The last line above the numbers is a key, and no heading of columns.
    let key = "Y Units: Emissivity\nX Units: nm\n";
    is_right(csv(&format!("{key}{}", rows(|um| um * 1e3, EMISSIVITY, "\t"))), key);
    is_right(
        csv(&format!("# wavelength (nm) reflectance\n{}", rows(|um| um * 1e3, REFLECTANCE, " "))),
        "as numpy writes it",
    );
    for above in [
        "# quantity: transmittance\nwavelength_um,value\n",
        "# measured in transmission through a KBr pellet\n",
        "# quantity: brightness\n",
        "# reflectance, from emissivity\n",
        "# made of loess\nwavelength_um,value\n",
        "# wavelength_um,value\n",
        "ENVI ASCII plot\nColumn 1: Wavelength\nColumn 2: Mean\n",
    ] {
        assert!(csv(&format!("{above}{}", emissivity())).is_err(), "{above}");
        let reading = Reading { quantity: Some(Quantity::Emissivity), ..Reading::default() };
        is_right(one("s.csv", format!("{above}{}", emissivity()), &reading), above);
    }
    is_right(csv(&format!("# sample: loess, grains of 75 um\n{}", emissivity())), "prose");
}

#[test]
fn units_are_heard_without_brackets_and_unknown_ones_are_refused() {
    for (heading, unit) in [
        ("wavelength nm", Unit::Nanometre),
        ("wavelength/nm", Unit::Nanometre),
        ("\"Wavelength, nm\"", Unit::Nanometre),
        ("Wavelength (\u{c5})", Unit::Angstrom),
        ("lambda [m]", Unit::Metre),
        ("Wavenumber (cm-1)", Unit::Wavenumber),
        ("Wellenzahl / cm\u{207b}\u{b9}", Unit::Wavenumber),
        ("Frequency (THz)", Unit::Terahertz),
        ("\u{3bd} (cm-1)", Unit::Wavenumber),
        ("nu (1/cm)", Unit::Wavenumber),
    ] {
        let x = |um: f64| match unit {
            Unit::Nanometre => um * 1e3,
            Unit::Angstrom => um * 1e4,
            Unit::Metre => um / 1e6,
            Unit::Wavenumber => 1e4 / um,
            _ => 299.792_458 / um,
        };
        is_right(csv(&format!("{heading},emissivity\n{}", rows(x, EMISSIVITY, ","))), heading);
        let reading = Reading { unit: Some(unit), ..Reading::default() };
        is_right(one("s.csv", rows(x, EMISSIVITY, ","), &reading), "--unit");
    }
    let mut told = String::new();
    for heading in ["band", "Wavelength (furlongs)", "index", "Energy", "wavelength (cm)"] {
        let error = csv(&format!("{heading},emissivity\n{}", emissivity())).expect_err(heading);
        told += &message(&error.to_string().split_once("s.csv").expect("the file").1, error.hint());
    }
    let in_nm = csv(&rows(|um| um * 1e3, EMISSIVITY, ",")).expect("read as um");
    told += &format!("{}\n", in_nm.warnings[0]);
    assert_snapshot!(told);
}

#[test]
fn bars_separate_columns_with_decimal_commas() {
    let text = format!("wavelength_um|emissivity\n{}", rows(|um| um, EMISSIVITY, "|"));
    is_right(csv(&text.replace('.', ",")), "bars");
}

#[test]
fn decimal_commas_quotes_and_trailing_separators_are_read() {
    let comma = |text: String| text.replace('.', ",");
    for (of, text) in [
        (
            "semicolons",
            format!(
                "Wellenl\u{e4}nge (\u{b5}m);Emissivit\u{e4}t\n{}",
                comma(rows(|um| um, EMISSIVITY, ";"))
            ),
        ),
        ("no heading", comma(rows(|um| um, EMISSIVITY, ";"))),
        ("tabs", format!("wavelength_um\temissivity\n{}", comma(rows(|um| um, EMISSIVITY, "\t")))),
        ("blanks", comma(rows(|um| um + 0.0, EMISSIVITY, " ")).replace("8 ", "8,0 ")),
        ("quoted commas", "\"8,0\",\"0,941\"\n\"9,0\",\"0,68\"\n\"10,0\",\"0,941\"\n".into()),
        (
            "quotes",
            "\"wavelength_um\",\"emissivity\"\n\"8\",\"0.941\"\n\"9\",\"0.68\"\n\"10\",\
                    \"0.941\"\n"
                .into(),
        ),
        ("trailing", "wavelength_um,emissivity,\n8,0.941,\n9,0.68,\n10,0.941,\n,,\n".into()),
        ("an index", ",wavelength_um,emissivity\n0,8,0.941\n1,9,0.68\n2,10,0.941\n".into()),
        ("errors", "wavelength_um,emissivity,std\n8,0.941,0.1\n9,0.68,0.1\n10,0.941,0.1\n".into()),
        ("another order", "emissivity,wavelength_um\n0.941,8\n0.68,9\n0.941,10\n".into()),
        (
            "blanks beside quotes",
            "\"um\" , \"emissivity\"\n\"8\" , \"0.941\"\n\"9\" , \"0.68\"\n\"10\" , \"0.941\"\n"
                .into(),
        ),
        ("bars", format!("wavelength_um|emissivity\n{}", rows(|um| um, EMISSIVITY, "|"))),
        ("single quotes", "'um','emissivity'\n'8','0.941'\n'9','0.68'\n'10','0.941'\n".into()),
        ("Fortran", "um emissivity\n8.0D+00 9.41D-01\n9.0D+00 0.68\n1.0D+01 0.941\n".into()),
        ("a true minus", "um,emissivity\n8,9.41e\u{2212}1\n9,6.8e\u{2212}1\n10,0.941\n".into()),
        ("the mark of an end", format!("um,emissivity\n{}\u{1a}", emissivity())),
        (
            "both units",
            "cm-1,um,emissivity\n1250,8,0.941\n1111.111111111111,9,0.68\n1000,10,0.941\n".into(),
        ),
    ] {
        is_right(csv(&text), of);
    }
    for missing in ["", "NA", "#N/A", "--", "NaN"] {
        let text = format!("um,emissivity\n7,{missing}\n{}11,{missing}\n", emissivity());
        is_right(csv(&text), missing);
        // No value is made up where one is missing.
        let gap = csv(&format!("um,emissivity\n7,0.5\n7.5,{missing}\n{}", emissivity()));
        let gap = Spectrum::Tabulated(gap.expect(missing)).emissivity(7.5);
        assert!(matches!(gap, Err(SpectrumError::Gap { .. })), "{missing}: {gap:?}");
    }
    let mut told = String::new();
    for text in [
        "7,0000,0,9799\n7,5000,0,9770\n",
        "8,5;0.941\n9;0.68\n",
        "um,emissivity,transmittance\n8,0.5,0.1\n9,0.5,0.1\n",
        "um,sand,loess\n8,0.5,0.1\n9,0.5,0.1\n",
        "um,emissivity\n8,0.5\n9,0.5,0.1\n",
        "8,0.5,0.6\n9,0.5,0.1\n",
        "no numbers\n",
    ] {
        let error = csv(text).expect_err(text);
        told += &message(&error.to_string().split_once("s.csv").expect("the file").1, error.hint());
    }
    assert_snapshot!(told);
}

/// Of files that name no quantity some are known to hold reflectance.
#[test]
fn a_file_that_begins_with_the_number_of_its_lines_must_say_what_its_values_are() {
    let text = format!("3\n{}", rows(|um| um, REFLECTANCE, "  "));
    let error = csv(&text).expect_err("no quantity");
    assert!(error.to_string().contains("counts the 3 lines"), "{error}");
    let reading = Reading { quantity: Some(Quantity::Reflectance), ..Reading::default() };
    is_right(one("s.csv", &text, &reading), "settled");
}

#[test]
fn a_wavelength_that_appears_twice_is_refused_at_the_ends_of_the_range_too() {
    for twice in ["10,0.5\n", "8,0.5\n", "9,0.5\n"] {
        let text = format!("um,emissivity\n{}{twice}", emissivity());
        let reading = Reading { range_um: Some([8.0, 10.0]), ..Reading::default() };
        let error = one("s.csv", text, &reading).expect_err(twice);
        assert!(error.to_string().contains("appears twice"), "{error}");
    }
}

#[test]
fn a_header_that_contradicts_itself_is_refused() {
    let text = "Name: sand\nMeasurement: Emissivity\nX Units: Wavelength (micrometers)\n\
                Y Units: Reflectance (fraction)\n\n8 0.059\n9 0.32\n10 0.059\n";
    let error = one("q.txt", text, &Reading::default()).expect_err("either");
    assert!(error.to_string().contains("Measurement"), "{error}");
    let derived = text.replace("Emissivity", "Directional hemispherical reflectance");
    is_right(one("q.txt", derived, &Reading::default()), "both are reflectance");
}

#[test]
fn text_is_read_in_the_encodings_of_office_programs() {
    let text = format!("wavelength_um\temissivity\n{}", rows(|um| um, EMISSIVITY, "\t"));
    let utf_16: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    is_right(one("s.csv", utf_16, &Reading::default()), "UTF-16");
    is_right(one("s.csv", text.replace('\n', "\r"), &Reading::default()), "CR alone");
    for binary in [&b"PK\x03\x04\x14\x00\x06"[..], b"ASD\x00\x00\x01", b"\x00\x04\x01"] {
        let error = one("s.csv", binary, &Reading::default()).expect_err("it is binary");
        assert!(error.to_string().contains("not text"), "{error}");
    }
    let latin_1 = [
        b"Wellenl\xe4nge (\xb5m);Emissivit\xe4t\n",
        &emissivity().replace(',', ";").into_bytes()[..],
    ];
    is_right(one("s.csv", latin_1.concat(), &Reading::default()), "Latin-1");
}

/// A JCAMP-DX file with these units and table.
fn jcamp(x_units: &str, y_units: &str, table: &str) -> String {
    format!(
        "##TITLE=sand $$ made up\n##JCAMP-DX=4.24\n##DATA TYPE=INFRARED SPECTRUM\n\
         ##XUNITS={x_units}\n##YUNITS= {y_units}\n##NPOINTS=3\n{table}\n##END=\n"
    )
}

#[test]
fn jcamp_dx_is_read_in_its_units_plain_and_packed() {
    let points = "##XFACTOR=1\n##YFACTOR=0.001\n##XYPOINTS=(XY..XY)\n";
    let in_um = format!("{points}8, 59; 9, 320\n10 59");
    let read_dx = |text: &str| one("s.dx", text, &Reading::default());
    is_right(read_dx(&jcamp("MICROMETERS", "REFLECTANCE", &in_um)), "points");
    let steps = "##FIRSTX=8\n##LASTX=10\n##XFACTOR=1\n##YFACTOR=0.001\n##XYDATA=(X++(Y..Y))\n";
    for lines in ["8 59 320 59", "8+59+320+59", "8E9C20E9", "8E9K61", "8E9\n9C20\n10E9"] {
        let text = jcamp("MICROMETERS", "REFLECTANCE", &format!("{steps}{lines}"));
        if lines == "8E9K61" {
            // Two points where three are announced.
            assert!(read_dx(&text).is_err());
        } else {
            is_right(read_dx(&text), lines);
        }
    }
    is_right(
        read_dx(&jcamp("MICROMETERS", "REFLECTANCE", &format!("{steps}8E9K61\n9C20k61\n10E9"))),
        "differences, checked by the next line",
    );
    let numbers: String =
        UM.iter().zip(REFLECTANCE).map(|(um, r)| format!("{} {r}\n", 1e4 / um)).collect();
    let table = format!("##FIRSTX=7\n##LASTX=14\n##XYDATA=(X++(Y..Y))\n{numbers}");
    let in_wavenumbers = one("s.jdx", jcamp("1/CM", "REFLECTANCE", &table), &Reading::default());
    is_right(in_wavenumbers, "a point a line in cm-1");
    // The first value is a check of the factor.
    for (first, is_read) in [("0.059", true), ("59", true), ("0.05905", true), ("0.9", false)] {
        let table = format!("##FIRSTY={first}\n{steps}8 59 320 59");
        let found = read_dx(&jcamp("MICROMETERS", "REFLECTANCE", &table));
        assert_eq!(found.is_ok(), is_read, "{first}: {found:?}");
    }
    let mut told = String::new();
    for (x_units, y_units, table) in [
        ("1/CM", "TRANSMITTANCE", "##XYPOINTS=(XY..XY)\n1250 0.9\n1000 0.8\n900 1"),
        ("1/CM", "ABSORBANCE", "##XYPOINTS=(XY..XY)\n1250 0.9\n1000 0.8\n900 1"),
        ("1/CM", "ARBITRARY UNITS", "##XYPOINTS=(XY..XY)\n1250 0.9\n1000 0.8\n900 1"),
        ("SECONDS", "REFLECTANCE", "##XYPOINTS=(XY..XY)\n1250 0.9\n1000 0.8\n900 1"),
        ("1/CM", "REFLECTANCE", "##PEAK TABLE=(XY..XY)\n1250 0.9\n1000 0.8"),
        ("1/CM", "REFLECTANCE", "##XYPOINTS=(XY..XY)\n1250 0.9\n1000 0.8"),
        ("1/CM", "REFLECTANCE", "##FIRSTX=7\n##LASTX=14\n##XYDATA=(X++(Y..Y))\n1250 0.9 0.8 1"),
        ("MICROMETERS", "REFLECTANCE", "##FIRSTX=8\n##LASTX=10\n##XYDATA=(X++(Y..Y))\n8A1J\n9B1A"),
    ] {
        let error = read_dx(&jcamp(x_units, y_units, table)).expect_err(y_units);
        told += &message(&error.to_string().split_once("s.dx").expect("the file").1, error.hint());
    }
    assert_snapshot!(told);
    // A file of several blocks.
    let block = jcamp("MICROMETERS", "REFLECTANCE", &in_um);
    let both = format!("##TITLE=both\n##DATA TYPE=LINK\n##BLOCKS=2\n{block}{block}##END=\n");
    let place = Place::new();
    place.write("both.dx", both);
    assert_eq!(read(&place.path("both.dx"), &Reading::default()).expect("two").len(), 2);
    assert_eq!(Format::of(&place.path("both.dx")).expect("known"), Format::Jcamp);
}

#[test]
fn usgs_text_is_told_by_its_title_and_its_transmittance_refused() {
    let place = Place::new();
    place.write("w.txt", " splib07a Record=10: Wavelengths NIC4 Nicolet microns\n 8\n 9\n 10\n");
    let reading = Reading { wavelengths: Some(place.path("w.txt")), ..Reading::default() };
    let values = " 0.059\n 0.32\n 0.059\n";
    for title in ["splib07a Record=5932: Quartz NIC4a AREF", "s07_ASD Record=1: Quartz ASDFRa AREF"]
    {
        is_right(one("s.txt", format!(" {title}\n{values}"), &reading), title);
    }
    let dashes = "-".repeat(52);
    let six = format!(
        "USGS Digital Spectral Library splib06a\nClark and others 2007\n\nwavelength reflectance\n\
         {dashes}\nQuartz GDS74 Sand W1R1Fa AREF\ncopy of splib05a r 1\n 8 0.059 0\n 9 0.32 0.01\n \
         9.5 -1.23e34 0\n 10 0.059 0\n"
    );
    is_right(one("s.txt", &six, &Reading::default()), "version 6");
    let mut told = String::new();
    for title in [
        "splib07a Record=13: Quartz GDS31 thin film 25um NIC4a TRAN",
        "splib07b Record=4021: Kaolinite KGa-1 KBr pellet NIC4bb TRAN",
        "splib07a Record=13: Quartz GDS31 thin film of 25 um TRA",
        "splib07a Record=13: Quartz GDS31 NIC4aTRAN",
        "splib07a Record=13: Quartz GDS31 [TRANS]",
        "splib07a Record=14: Error bars of Quartz NIC4a AREF",
        "splib07a Record=15: Bandpass (FWHM) ASDFR",
        "splib07a Record=16: Quartz NIC4a Absorbance",
        "splib07a Record=16: Quartz NIC4a ABS",
        "splib07a Record=17: Quartz NIC4a EMIS",
        "errorbars for splib07a Record=5932: Quartz NIC4a AREF",
        "splib07a Record=17: Quartz NIC4a Emissivity",
    ] {
        let error = one("s.txt", format!(" {title}\n{values}"), &reading).expect_err(title);
        told += &message(&error.to_string().split_once("s.txt").expect("the file").1, error.hint());
    }
    let error = one("s.txt", six.replace("AREF", "TRAN"), &Reading::default()).expect_err("TRAN");
    told += &message(&error.to_string().split_once("s.txt").expect("the file").1, error.hint());
    assert_snapshot!(told);
}

#[test]
fn headers_of_the_aster_library_may_have_values_of_several_lines_and_blank_ones() {
    let rows = "  10.0\t  5.9\n   9.0\t 32.0\n   8.0\t  5.9\n";
    for description in [
        "Pale sand of a beach",
        "Pale sand\nwhich was sieved twice",
        "Pale sand, sieved\ntwice\n\n\n\n",
        "Pale sand\nCollected by: nobody\nSize: 2 mm",
    ] {
        let text = format!(
            "Name: quartz\nType: Mineral\nDescription: {description}\n\
             Measurement: Hemispherical Reflectance\nX Units: Wavelength (micrometers)\n\
             Y Units: Reflectance (percent)\nNumber of X Values: 3\n\n{rows}"
        );
        is_right(one("q.txt", &text, &Reading::default()), description);
        is_right(one("q.txt", text.replace('\n', "\r"), &Reading::default()), "CR alone");
    }
    let turned = "Name: q\nFirst Column: Y\nSecond Column: X\nX Units: Wavelength (micrometers)\n\
                  Y Units: Emissivity\n\n0.941 10\n0.68 9\n0.941 8\n";
    is_right(one("t.txt", turned, &Reading::default()), "values first");
    let text = "Name: basalt\nX Units: Wavelength (micrometers)\nY Units: Emissivity (percent)\n\n\
                8 94.1\n9 68\n10 94.1\n";
    is_right(one("b.txt", text, &Reading::default()), "emissivity in percent");
}

#[test]
fn ranges_outside_are_named_and_ends_off_by_rounding_are_within() {
    let place = Place::new();
    place.write("near.csv", "wavelength_um,emissivity\n1.4,0.9\n2.8,0.8\n");
    let to = ["--range", "8-12", "--step", "1", "--out", "o.csv"];
    let mut told = place.refused(&[&["spectra", "convert", "near.csv"][..], &to].concat(), 3);
    told +=
        &place.refused(&["spectra", "convert", "near.csv", "--range", "8-12", "--out", "o.csv"], 3);
    assert_snapshot!(told);
    place.write("steps.csv", "um,emissivity\n8,0.9\n11.999999999999915,0.8\n");
    place.run(&[&["spectra", "convert", "steps.csv"][..], &to].concat(), 0);
    let back = read_one(&place.path("o.csv"), &Reading::default()).expect("read");
    assert_eq!(back.range_um(), [8.0, 12.0]);
    // Rounding may also take values over their ends.
    let over = csv("um,emissivity\n8,1.0000001\n9,-1e-9\n").expect("read");
    assert_eq!(over.emissivity, [1.0, 0.0]);
}

#[test]
fn the_options_settle_what_a_heading_leaves_open() {
    let place = Place::new();
    place.write("s.csv", format!("x,sand\n{}", rows(|um| um * 1e3, percent(REFLECTANCE), ",")));
    let args = [
        "spectra",
        "convert",
        "s.csv",
        "--quantity",
        "reflectance-percent",
        "--unit",
        "nm",
        "--out",
        "o.csv",
    ];
    place.run(&args, 0);
    is_right(read_one(&place.path("o.csv"), &Reading::default()), "settled");
    let bidirectional = csv(&format!("um,bidirectional reflectance\n{}", reflectance()));
    let warnings = bidirectional.expect("read").warnings;
    assert!(matches!(warnings.as_slice(), [Warning::Bidirectional(_)]));
}

#[test]
fn of_the_curves_of_a_dirsig_file_a_scene_takes_the_mean() {
    let weights = "1.0\n".repeat(91);
    let curves = "CURVE_BEGIN\n8 0.4\n10 0.6\nCURVE_BEGIN\n8 0.6\n9 0.5\n10 0.8\n";
    let place = Place::new();
    fs::write(place.path("s.ems"), format!("2\n{weights}{curves}")).expect("written");
    let mean = read_one(&place.path("s.ems"), &Reading::default()).expect("a mean");
    assert_eq!(mean.wavelength_um, [8.0, 9.0, 10.0]);
    assert!(mean.emissivity.iter().zip([0.5, 0.5, 0.7]).all(|(a, b)| (a - b).abs() < 1e-15));
    assert_eq!(mean.warnings, [Warning::MeanOf(2)]);
    assert_eq!(read(&place.path("s.ems"), &Reading::default()).expect("two").len(), 2);
}
