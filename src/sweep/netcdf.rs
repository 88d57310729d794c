//! The results of a study as NetCDF: the axes are dimensions and coordinates.

use netcdf3::Version;

use super::points::Points;
use super::results::{PointResult, Results, shown};
use super::study::Study;
use crate::support::netcdf::{FILL, NetCdf, WAVELENGTH};

/// Larger variables are left out: this format holds them up to 4 GB, and programs read them whole.
const MOST_NUMBERS: usize = 200_000_000;

const SEED: &str = "seed";

/// The emissivity over all axes, as the bytes of a file; `None` if it would be too large.
pub(super) fn bytes(
    study: &Study,
    points: &Points,
    results: &Results,
    um: &[f64],
) -> Option<Vec<u8>> {
    let numbers = points.len() * um.len();
    (numbers <= MOST_NUMBERS).then(|| {
        let with_beds = study.seeds.len() > 1 && numbers * study.seeds.len() <= MOST_NUMBERS;
        let mut file = NetCdf::default();
        file.text("Conventions", "CF-1.11");
        file.text("title", study.title());
        file.text("source", concat!("soilsig ", env!("CARGO_PKG_VERSION")));
        axes(&mut file, study, points, um, with_beds);
        variables(&mut file, study, points, results, with_beds);
        file.bytes(Version::Offset64Bit)
    })
}

/// The dimensions with their coordinates.
fn axes(file: &mut NetCdf, study: &Study, points: &Points, um: &[f64], with_beds: bool) {
    for dimension in &points.dimensions {
        file.dimension(&dimension.name, dimension.len);
    }
    if with_beds {
        let seeds = study.seeds.iter().map(|&seed| seed as f64).collect();
        file.dimension(SEED, study.seeds.len());
        file.variable(SEED, &[SEED], &[("long_name", "seed of the bed")], seeds);
    }
    file.dimension(WAVELENGTH, um.len());
    let attributes = [("standard_name", "radiation_wavelength"), ("units", "um")];
    file.variable(WAVELENGTH, &[WAVELENGTH], &attributes, um.into());
    // An axis of numbers is a coordinate. Of others the number of the place is, with the words.
    for dimension in &points.dimensions {
        for &axis in &dimension.axes {
            let (name, places) = (&study.axes[axis].name, &points.axes[axis]);
            let numbers: Option<Vec<f64>> = places.iter().map(|p| p.value.as_f64()).collect();
            let words = numbers.is_none();
            let numbers = numbers.unwrap_or_else(|| (0..places.len()).map(|i| i as f64).collect());
            let key = study.axes[axis].key.all().join(" ");
            file.variable(name, &[&dimension.name], &[("long_name", &key)], numbers.clone());
            if words {
                let words: Vec<String> = places.iter().map(|p| shown(&p.value)).collect();
                file.attribute(name, "flag_meanings", &flags(&words));
                file.numbers(name, "flag_values", numbers);
            }
        }
    }
}

/// The emissivity, its errors, and the numbers of beds.
fn variables(
    file: &mut NetCdf,
    study: &Study,
    points: &Points,
    results: &Results,
    with_beds: bool,
) {
    let axes: Vec<&str> = points.dimensions.iter().map(|d| &*d.name).collect();
    let others = points.dimensions.iter().filter(|d| d.axes.len() > 1 || d.name == "sample");
    let others: Vec<&str> =
        others.flat_map(|d| &d.axes).map(|&axis| &*study.axes[axis].name).collect();
    let bands = study.bands.wavelengths_um().len();
    let mut add =
        |name: &str, meaning, own: &[&str], width, of: &dyn Fn(&PointResult) -> Vec<f64>| {
            let of_point =
                |point: &Option<PointResult>| point.as_ref().map_or_else(|| vec![FILL; width], of);
            let values = results.points.iter().flat_map(of_point).collect();
            let attributes = [("long_name", meaning), ("units", "1")];
            file.variable(name, &[&axes, own].concat(), &attributes, values);
            file.numbers(name, "_FillValue", vec![FILL]);
            if name == "emissivity" {
                file.attribute(name, "ancillary_variables", "emissivity_half_width_95 beds");
            }
            if !others.is_empty() {
                file.attribute(name, "coordinates", &others.join(" "));
            }
        };
    let meaning = "emissivity towards the sensor, the mean of all beds of the point";
    add("emissivity", meaning, &[WAVELENGTH], bands, &|point| point.emissivity.clone());
    let (name, meaning) = ("emissivity_half_width_95", "its total half-width at 95 %");
    add(name, meaning, &[WAVELENGTH], bands, &|point| point.half_width_95.clone());
    add("beds", "finished beds of the point", &[], 1, &|point| vec![point.beds as f64]);
    if with_beds {
        let of_bed = |bed: &Option<Vec<f64>>| bed.clone().unwrap_or_else(|| vec![FILL; bands]);
        let of = |point: &PointResult| point.of_beds.iter().flat_map(of_bed).collect();
        let meaning = "emissivity towards the sensor of each bed";
        let width = bands * study.seeds.len();
        add("emissivity_of_bed", meaning, &[SEED, WAVELENGTH], width, &of);
    }
}

/// Words as CF lists them: divided by blanks, each without one.
fn flags(words: &[String]) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-+@".contains(c) { c } else { '_' };
    let words: Vec<String> = words.iter().map(|word| word.chars().map(plain).collect()).collect();
    words.join(" ")
}
