//! Emissivity back from radiance by Eq. 2, with its error: of quartz dust under a sky of 250 K.
//!
//! `cargo run --release --example retrieval`

use soilsig::Spectrum;
use soilsig::radiometry::{Assumed, Measured, Retrieved, Temperature, l_target, planck};

fn main() -> Result<(), soilsig::Error> {
    let dust = Spectrum::builtin("quartz_fine")?;
    let target = Temperature { k: 300.0, error_k: 0.5 };
    println!("um   emissivity  retrieved");
    for um in [8.5, 9.0, 10.0, 11.0, 12.0] {
        let emissivity = dust.emissivity(um)?;
        let l_downwelling = planck(um, 250.0);
        let l = l_target(emissivity * planck(um, target.k), (1.0 - emissivity) * l_downwelling);
        // A sensor that is good to .2 %.
        let measured = Measured::at_sensor(um, [l, 0.002 * l], l_downwelling, None);
        let retrieved = Retrieved::new(&measured, target, Assumed::EXACT);
        match retrieved.emissivity {
            Some([e, error]) => println!("{um:<4} {emissivity:.4}      {e:.4} +- {error:.4}"),
            None => println!("{um:<4} {emissivity:.4}      masked"),
        }
    }
    Ok(())
}
