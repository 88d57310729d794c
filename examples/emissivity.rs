//! Traces a placed scene and prints its emissivity with what it is uncertain by.
//!
//! `cargo run --release --example emissivity scenes/settled_patch.json`

use soilsig::{Budget, Grid, Monitor, Request, Scene, Target, evaluate, trace};

/// Prints each tenth of the paths. `is_cancelled` could ask a button whether to stop.
struct Percent;

impl Monitor for Percent {
    fn at(&self, done: u64, total: u64, what: &str) {
        eprintln!("{:3} % of the {what}", 100 * done / total);
    }
}

fn main() -> Result<(), soilsig::Error> {
    let file = std::env::args().nth(1).unwrap_or("scenes/settled_patch.json".into());
    let scene = Scene::read(file.as_ref())?;
    let grid = Grid::new(8.0, 12.0, 0.5).expect("a grid of bands");
    let table = trace(scene, Request::new(&grid, Target::of(0.01)), &Percent)?;

    let tables = [table];
    let bands = evaluate(&tables, &grid.wavelengths_um())?;
    let budget = Budget::new(&tables, &bands)?;
    println!("um    emissivity  +- (95 %, all that is known)");
    for (band, share) in bands.iter().zip(&budget.bands) {
        println!("{:<5} {:.4}      {:.4}", band.wavelength_um, band.emissivity.mean, share.total);
    }
    Ok(())
}
