//! Images of measured radiance: what they hold must be radiance.

use std::path::Path;

use super::{Cube, CubeError};
use crate::radiometry::{BRIGHTEST, MISSING_MARKS};
use crate::support::envi::Header;

/// Words for what is no radiance, and for numbers of a detector.
const OTHER_WORDS: [&str; 13] = [
    "k",
    "kelvin",
    "degc",
    "celsius",
    "temperature",
    "dn",
    "dns",
    "digital",
    "count",
    "counts",
    "percent",
    "photons",
    "electrons",
];
/// Beginnings of such words.
const OTHERS: [&str; 5] = ["reflectan", "emissiv", "transm", "absorb", "albedo"];

impl Cube {
    /// Reads an ENVI image of radiance, or of its standard errors, W m-2 sr-1 um-1; see
    /// [`Cube::read`].
    ///
    /// # Errors
    /// Those of `read`; the header names another quantity; a number that is no radiance.
    pub fn read_radiance(path: &Path) -> Result<Self, CubeError> {
        let header = Header::read(path, &super::envi::ENDINGS)?;
        if let Some(stated) = other_quantity(&header) {
            let problem = format!("it holds {stated:?}, but radiance in W m-2 sr-1 um-1 is needed");
            return Err(header.wrong(problem).into());
        }
        let cube = Self::read(path)?;
        let marks = MISSING_MARKS.map(|mark| mark as f32);
        if let Some(mark) = cube.data.iter().find(|value| marks.contains(value)) {
            let hint = "write the mark into the header, as in `data ignore value = -9999`";
            let problem = format!("its numbers hold {mark}, which marks what is missing");
            return Err(header.wrong(problem).with_hint(hint).into());
        }
        if let Some(l) = cube.data.iter().find(|l| f64::from(l.abs()) > BRIGHTEST) {
            let hint = "look at `data type` and `byte order`, and at the unit of the radiance";
            let problem = format!("{l:e} W m-2 sr-1 um-1 is brighter than any body of 10000 K");
            return Err(header.wrong(problem).with_hint(hint).into());
        }
        Ok(cube)
    }
}

/// What a header says of its numbers, if it is no radiance.
fn other_quantity(header: &Header) -> Option<String> {
    let keys = ["data units", "radiance units", "units"];
    let titles = header.list("z plot titles");
    let title = titles.get(1..).unwrap_or_default().join(" ");
    let mut stated =
        keys.into_iter().filter_map(|key| header.get(key).map(str::to_owned)).chain([title]);
    stated.find(|text| {
        let text = text.to_lowercase();
        let mut words = text.split(|c: char| !c.is_alphabetic());
        text.contains('%')
            || words.any(|word| {
                OTHER_WORDS.contains(&word) || OTHERS.iter().any(|of| word.starts_with(of))
            })
    })
}
