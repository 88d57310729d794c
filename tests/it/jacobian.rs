//! Derivatives of the emissivity of a bed by that of its facets.

use soilsig::signature::{curves, jacobian::jacobian};
use soilsig::spectrum::Spectrum;
use soilsig::{Grid, Request, Scene, Unwatched, trace};
use soilsig::{Table, Target};

use crate::support::shipped;

/// A trace of the patch under a sky, which may depend on the zenith angle.
fn table(sky: &str) -> Table {
    let path = shipped("settled_patch.json");
    let text = std::fs::read_to_string(&path).expect("it is shipped");
    let text = text.replacen('{', &format!("{{{sky}"), 1);
    let scene = Scene::parse(&text, path.as_ref()).expect("a scene");
    let grid = Grid::new(8.0, 12.0, 1.0).expect("a grid");
    trace(scene, Request::new(&grid, Target::of(0.05)), &Unwatched).expect("a trace")
}

#[test]
fn the_jacobian_is_the_slope_of_the_emissivity() {
    let zenith = r#" "sky_temperature_k": [{"zenith_deg": 0, "temperature_k": 200},
        {"zenith_deg": 90, "temperature_k": 280}],"#;
    for table in [table(""), table(zenith)] {
        let um = [8.0, 10.0, 12.0];
        let mut flat = table;
        for (i, material) in flat.materials.iter_mut().enumerate() {
            material.spectrum = Spectrum::Constant(0.7 + 0.05 * i as f64);
        }
        let found = jacobian(std::slice::from_ref(&flat), &um).expect("spectra cover all");
        assert_eq!(found.len(), flat.materials.len());
        for (i, slopes) in found.iter().enumerate() {
            let moved = |step: f64| {
                let mut table = flat.clone();
                table.materials[i].spectrum = Spectrum::Constant(0.7 + 0.05 * i as f64 + step);
                curves(&[table], &um).expect("spectra cover all").remove(0)
            };
            let (more, less) = (moved(1e-5), moved(-1e-5));
            for band in 0..um.len() {
                let difference = (more[band] - less[band]) / 2e-5;
                assert!((slopes[band] - difference).abs() < 1e-8, "{} {difference}", slopes[band]);
            }
        }
        // Brighter facets make a brighter bed.
        assert!(found.iter().flatten().all(|&slope| slope >= 0.0));
        assert!(found.iter().map(|slopes| slopes[0]).sum::<f64>() > 0.0);
    }
}
