//! Evaluates one bounce table with other spectra and another temperature, without tracing again.
//!
//! `cargo run --release --example own_spectrum`

use soilsig::spectrum::Tabulated;
use soilsig::{Grid, Request, Scene, Spectrum, Target, Unwatched, evaluate, trace};

fn main() -> Result<(), soilsig::Error> {
    let scene = Scene::read("scenes/settled_patch.json".as_ref())?;
    let grid = Grid::new(8.0, 12.0, 1.0).expect("a grid of bands");
    let wavelengths_um = grid.wavelengths_um();
    let mut table = trace(scene, Request::new(&grid, Target::of(0.01)), &Unwatched)?;
    let as_shipped = evaluate(std::slice::from_ref(&table), &wavelengths_um)?;

    let grey = Tabulated::new("grey dust", &[(7.0, 0.95), (14.0, 0.93)])?;
    for material in table.materials.iter_mut().filter(|material| material.name == "fine") {
        material.spectrum = Spectrum::Tabulated(grey.clone());
    }
    table.temperature_k = 310.0;
    let dusted = evaluate(&[table], &wavelengths_um)?;

    println!("um  shipped dust  grey dust  radiance at 310 K, W m-2 sr-1 um-1");
    for (a, b) in as_shipped.iter().zip(&dusted) {
        let (um, l) = (a.wavelength_um, b.l_target.mean);
        println!("{um:<3} {:.4}        {:.4}     {l:.3}", a.emissivity.mean, b.emissivity.mean);
    }
    Ok(())
}
