//! The pictures of an image.

use std::collections::BTreeSet;
use std::path::Path;

use super::Asked;
use super::bands::Bands;
use super::pixel::Pixel;
use super::quicklook::Look;
use crate::radiometry::{brightness_temperature_k, planck};
use crate::support::error::Error;
use crate::support::output;

/// What the pictures show, pixel by pixel.
pub(super) struct Shown<'a> {
    bands: &'a Bands,
    temperature_k: f64,
    /// Bands of red, green and blue.
    colours: [usize; 3],
    /// Bands that are shown as brightness temperature.
    bands_shown: Vec<usize>,
    /// Apparent emissivity (Eq. 3) in the bands of the colours.
    channels: [Vec<f32>; 3],
    brightness_k: Vec<Vec<f32>>,
    materials: Vec<f32>,
    hits: Vec<f32>,
}

impl<'a> Shown<'a> {
    pub(super) fn new(asked: &Asked, bands: &'a Bands, temperature_k: f64) -> Self {
        let ends = bands.centres_um.iter().fold([f64::INFINITY, 0.0], |[least, most], &um| {
            [f64::min(least, um), f64::max(most, um)]
        });
        let at = |share: f64| ends[0] + share * (ends[1] - ends[0]);
        let colours_um = asked.false_colour_um.unwrap_or([at(5.0 / 6.0), at(0.5), at(1.0 / 6.0)]);
        let mut bands_shown: Vec<usize> =
            asked.show_um.iter().map(|&um| bands.nearest(um)).collect();
        bands_shown.dedup();
        Self {
            bands,
            temperature_k,
            colours: colours_um.map(|um| bands.nearest(um)),
            channels: [const { Vec::new() }; 3],
            brightness_k: vec![Vec::new(); bands_shown.len()],
            bands_shown,
            materials: Vec::new(),
            hits: Vec::new(),
        }
    }

    /// Keeps the next pixel's numbers.
    pub(super) fn keep(&mut self, pixel: &Pixel) {
        let l = |band: usize| f64::from(pixel.cubes[0][band]);
        for (channel, &band) in self.channels.iter_mut().zip(&self.colours) {
            let l_blackbody = planck(self.bands.centres_um[band], self.temperature_k);
            channel.push((l(band) / l_blackbody) as f32);
        }
        for (values, &band) in self.brightness_k.iter_mut().zip(&self.bands_shown) {
            let kelvin = brightness_temperature_k(self.bands.centres_um[band], l(band));
            values.push(kelvin.map_or(f32::NAN, |kelvin| kelvin as f32));
        }
        self.materials.push(pixel.maps[0]);
        self.hits.push(pixel.maps[1]);
    }

    pub(super) fn write(
        &self,
        title: &str,
        columns: usize,
        materials: &[String],
        out: &Path,
    ) -> Result<(), Error> {
        let look = Look { columns, title };
        let centre = |band: usize| self.bands.centres_um[band];
        let names = self.colours.map(|band| format!("{:.2} um", centre(band)));
        look.false_colour(&self.channels, &names, &output::within(out, "false_colour.png")?)?;
        // As many decimals as tell the bands apart.
        let named = |places: usize| -> BTreeSet<String> {
            self.bands_shown.iter().map(|&band| format!("{:.places$}", centre(band))).collect()
        };
        let places =
            (2..9).find(|&places| named(places).len() == self.bands_shown.len()).unwrap_or(9);
        for (values, &band) in self.brightness_k.iter().zip(&self.bands_shown) {
            let um = centre(band);
            let what = format!("brightness temperature at {um:.places$} um");
            let file = output::within(out, &format!("brightness_{um:.places$}um.png"))?;
            look.scaled(values, &what, "K", 1, &file)?;
        }
        look.materials(&self.materials, materials, &output::within(out, "materials.png")?)?;
        look.scaled(
            &self.hits,
            "mean number of hits of a path",
            "",
            2,
            &output::within(out, "hits.png")?,
        )
    }
}
