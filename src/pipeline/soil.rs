//! What the beds of a run have of the soil that its scene states.

use std::fs;

use serde::Deserialize;

use super::{Bed, Run};
use crate::scene::{Dressed, Scene, SceneGeometry, SoilShares};
use crate::support::error::Error;
use crate::support::file_error::FileError;

use super::record::RecordError;

/// The part of a `drop.json` that tells of dressed grains and of the bed.
#[derive(Deserialize)]
struct Told {
    prototypes: Vec<Dressed>,
    bed: BedTold,
}

#[derive(Deserialize)]
struct BedTold {
    interior_porosity: Option<f64>,
}

impl Run<'_> {
    /// The shares of the scene's soil with its dust and porosity as the beds have them; `None` if it
    /// states none.
    pub(super) fn soil(&self, scene: &Scene, beds: &[Bed]) -> Result<Option<SoilShares>, Error> {
        let (Some(mut shares), SceneGeometry::Packing(packing)) =
            (scene.soil_shares(), &scene.geometry)
        else {
            return Ok(None);
        };
        let (mut dressed, mut porosities) = (Vec::new(), Vec::new());
        for bed in beds {
            let file = self.folder.place(&format!("{}drop.json", bed.below));
            // Beds that are there as hulls and with fines that touch have one file.
            if !file.is_file() {
                continue;
            }
            let text =
                fs::read(&file).map_err(FileError::read(&file)).map_err(RecordError::from)?;
            let told: Told = serde_json::from_slice(&text)
                .map_err(|error| RecordError::from(FileError::wrong(&file, error.to_string())))?;
            dressed.extend(told.prototypes);
            porosities.extend(told.bed.interior_porosity);
        }
        shares.measure_dust(packing, &dressed);
        shares.measure_porosity(&porosities);
        Ok(Some(shares))
    }
}
