//! How much the emissivity of a bed changes with that of its facets.

use rayon::prelude::*;

use crate::histogram::Shares;
use crate::signature::Levels;
use crate::support::error::Error;
use crate::table::{ChangeError, Table};

/// The derivative of the bed's emissivity in each band with respect to the emissivity of the facets
/// of each material, by material and band. It is exact: the weight of a path is the product of the
/// reflectances of its hits.
///
/// # Errors
/// A spectrum does not cover a wavelength; or paths that were traced through grains, which say
/// nothing of other spectra.
///
/// # Panics
/// Without a table.
pub fn jacobian(packings: &[Table], wavelengths_um: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
    let table = &packings[0];
    if table.nodes.is_some() {
        return Err(ChangeError::Refractive(table.scene.clone()).into());
    }
    let histograms: Vec<_> = packings.iter().map(|table| &table.histogram).collect();
    let shares = Shares::of(&histograms);
    let mixture = shares.mixture(&Levels::of(packings).weights());
    let of_material = table.histogram.kept.of_material();
    let symbols = table.materials.len() * of_material;
    let direction = |material: usize| -> Vec<f64> {
        (0..symbols).map(|symbol| f64::from(u8::from(symbol / of_material == material))).collect()
    };
    let directions: Vec<Vec<f64>> = (0..table.materials.len()).map(direction).collect();
    let directions: Vec<&[f64]> = directions.iter().map(Vec::as_slice).collect();
    let slopes = |rho: &Vec<f64>| shares.weight(&[&mixture], rho, &directions).slopes;
    let by_band: Vec<Vec<f64>> =
        table.reflectances(wavelengths_um)?.par_iter().map(slopes).collect();
    let of = |material: usize| by_band.iter().map(|slopes| slopes[material]).collect();
    Ok((0..table.materials.len()).map(of).collect())
}
