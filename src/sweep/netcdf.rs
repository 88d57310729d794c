//! The results of a study as NetCDF: the axes are dimensions and coordinates.

use netcdf3::{DataSet, FileWriter, Version};

use super::points::Points;
use super::results::{PointResult, Results, shown};
use super::study::Study;
use crate::signature::netcdf::{FILL, Failed, Memory, WAVELENGTH};

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
        written(study, points, results, um, with_beds)
            .expect("names and sizes are valid, and memory does not fail")
    })
}

/// A variable of the emissivity: name, meaning, dimensions after those of the axes, values.
struct Variable<'a> {
    name: &'static str,
    meaning: &'static str,
    dimensions: &'a [&'a str],
    values: Vec<f64>,
}

#[allow(clippy::too_many_lines, reason = "one list of variables")]
fn written(
    study: &Study,
    points: &Points,
    results: &Results,
    um: &[f64],
    with_beds: bool,
) -> Result<Vec<u8>, Failed> {
    let mut set = DataSet::new();
    for (key, text) in [
        ("Conventions", "CF-1.11"),
        ("title", study.title()),
        ("source", concat!("soilsig ", env!("CARGO_PKG_VERSION"))),
    ] {
        set.add_global_attr_string(key, text)?;
    }
    let dims: Vec<&str> = points.dimensions.iter().map(|d| &*d.name).collect();
    for dimension in &points.dimensions {
        set.add_fixed_dim(&dimension.name, dimension.len)?;
    }
    if with_beds {
        set.add_fixed_dim(SEED, study.seeds.len())?;
        set.add_var_f64(SEED, &[SEED])?;
        set.add_var_attr_string(SEED, "long_name", "seed of the bed")?;
    }
    set.add_fixed_dim(WAVELENGTH, um.len())?;
    set.add_var_f64(WAVELENGTH, &[WAVELENGTH])?;
    set.add_var_attr_string(WAVELENGTH, "standard_name", "radiation_wavelength")?;
    set.add_var_attr_string(WAVELENGTH, "units", "um")?;
    // An axis of numbers is a coordinate. Of others the number of the place is, with the words.
    let mut coordinates = Vec::new();
    for dimension in &points.dimensions {
        for &axis in &dimension.axes {
            let (name, places) = (&study.axes[axis].name, &points.axes[axis]);
            let numbers: Option<Vec<f64>> = places.iter().map(|p| p.value.as_f64()).collect();
            set.add_var_f64(name, &[&dimension.name])?;
            set.add_var_attr_string(name, "long_name", study.axes[axis].key.all().join(" "))?;
            if numbers.is_none() {
                let words: Vec<String> = places.iter().map(|p| shown(&p.value)).collect();
                set.add_var_attr_string(name, "flag_meanings", flags(&words))?;
                let values = (0..words.len()).map(|i| i as f64).collect();
                set.add_var_attr_f64(name, "flag_values", values)?;
            }
            let values = numbers.unwrap_or_else(|| (0..places.len()).map(|i| i as f64).collect());
            coordinates.push((name, values));
        }
    }
    let of_points = |of: &dyn Fn(&PointResult) -> Vec<f64>, width: usize| {
        let values = results.points.iter().map(|point| match point {
            Some(point) => of(point),
            None => vec![FILL; width],
        });
        values.flatten().collect::<Vec<f64>>()
    };
    let bands = um.len();
    let mut variables = vec![
        Variable {
            name: "emissivity",
            meaning: "emissivity towards the sensor, the mean of all beds of the point",
            dimensions: &[WAVELENGTH],
            values: of_points(&|point| point.emissivity.clone(), bands),
        },
        Variable {
            name: "emissivity_half_width_95",
            meaning: "its total half-width at 95 %",
            dimensions: &[WAVELENGTH],
            values: of_points(&|point| point.half_width_95.clone(), bands),
        },
        Variable {
            name: "beds",
            meaning: "finished beds of the point",
            dimensions: &[],
            values: of_points(&|point| vec![point.beds as f64], 1),
        },
    ];
    if with_beds {
        let of_beds = |point: &PointResult| {
            let of = |bed: &Option<Vec<f64>>| bed.clone().unwrap_or_else(|| vec![FILL; bands]);
            point.of_beds.iter().flat_map(of).collect()
        };
        variables.push(Variable {
            name: "emissivity_of_bed",
            meaning: "emissivity towards the sensor of each bed",
            dimensions: &[SEED, WAVELENGTH],
            values: of_points(&of_beds, bands * study.seeds.len()),
        });
    }
    for variable in &variables {
        let name = variable.name;
        let of: Vec<&str> =
            dims.iter().copied().chain(variable.dimensions.iter().copied()).collect();
        set.add_var_f64(name, &of)?;
        set.add_var_attr_string(name, "long_name", variable.meaning)?;
        set.add_var_attr_string(name, "units", "1")?;
        set.add_var_attr_f64(name, "_FillValue", vec![FILL])?;
        if name == "emissivity" {
            set.add_var_attr_string(name, "ancillary_variables", "emissivity_half_width_95 beds")?;
        }
        let others = points.dimensions.iter().filter(|d| d.axes.len() > 1 || d.name == "sample");
        let others: Vec<&str> =
            others.flat_map(|d| &d.axes).map(|&axis| &*study.axes[axis].name).collect();
        if !others.is_empty() {
            set.add_var_attr_string(name, "coordinates", others.join(" "))?;
        }
    }
    let memory = Memory::default();
    {
        let mut writer = FileWriter::open_seek_write("results", Box::new(memory.clone()))?;
        writer.set_def(&set, Version::Offset64Bit, 0)?;
        writer.write_var_f64(WAVELENGTH, um)?;
        if with_beds {
            let seeds: Vec<f64> = study.seeds.iter().map(|&seed| seed as f64).collect();
            writer.write_var_f64(SEED, &seeds)?;
        }
        for (name, values) in &coordinates {
            writer.write_var_f64(name, values)?;
        }
        for variable in &variables {
            writer.write_var_f64(variable.name, &variable.values)?;
        }
        writer.close()?;
    }
    Ok(memory.bytes())
}

/// Words as CF lists them: divided by blanks, each without one.
fn flags(words: &[String]) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-+@".contains(c) { c } else { '_' };
    let words: Vec<String> = words.iter().map(|word| word.chars().map(plain).collect()).collect();
    words.join(" ")
}
