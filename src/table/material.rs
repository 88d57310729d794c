//! A material as the table counts it.

use serde::{Deserialize, Serialize};

use super::Table;
use crate::spectrum::Spectrum;
use crate::spectrum::features::Windows;

/// Greatest share of light that may pass straight through a particle of `fresnel` facets along its
/// mean chord. What passes is scattered in the bed and partly comes back, but facets count it as
/// absorbed.
pub const MOST_TRANSMITTED: f64 = 0.01;

/// Least mean chord of a particle of `fresnel` facets, in wavelengths. The Fresnel equations
/// describe bodies that are large against the wavelength.
pub const LEAST_WAVELENGTHS: f64 = 10.0;

/// Hemispherical reflectance of `refractive` facets from which they count as reflecting much. A rule
/// of thumb: below it rays describe even fine powders (docs: refraction).
pub const MOST_REFLECTED: f64 = 1.0 / 3.0;

/// Least mean chord of a particle of `refractive` facets that reflect little, in wavelengths.
pub const LEAST_WHERE_CLEAR: f64 = 0.5;

/// Where the mineral that is seen most has its features, of beds of the same materials.
pub fn feature_windows(packings: &[Table]) -> &Windows {
    let materials = &packings[0].materials;
    let seen = |i: &usize| packings.iter().map(|of| of.materials[*i].first_hits).sum::<u64>();
    let mut by_share: Vec<usize> = (0..materials.len()).collect();
    by_share.sort_by_key(|i| std::cmp::Reverse(seen(i)));
    Windows::of(by_share.into_iter().map(|i| &materials[i].spectrum))
}

/// A material as the table counts it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableMaterial {
    /// The scene's name of it.
    pub name: String,
    /// Its emissivity spectrum.
    pub spectrum: Spectrum,
    /// Whether its facets are opaque where its grains let no light through (`auto`). Its spectrum is
    /// `fresnel` if that is so in all bands, else `refractive`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub auto: bool,
    /// Its temperature, kelvin, if it is not the scene's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_k: Option<f64>,
    /// Share of its reflectance that is specular.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub specular: f64,
    /// Mean chord of its particles, um. `None` where none of its meshes is closed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_chord_um: Option<f64>,
    /// First hits: its part of the sensor's view.
    pub first_hits: u64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl TableMaterial {
    /// Share of diffuse light that its grains let through at a wavelength in um. `None` of facets
    /// that are not `auto`.
    pub fn lets_through(&self, wavelength_um: f64) -> Option<f64> {
        let (Spectrum::Refractive(_, crystal) | Spectrum::Fresnel(_, crystal)) = &self.spectrum
        else {
            return None;
        };
        // A mesh without an inside is refused before.
        let chord_um = self.mean_chord_um.unwrap_or(0.0);
        self.auto.then(|| crystal.diffuse_transmittance(wavelength_um, chord_um))
    }

    /// Without what was measured on this one bed.
    pub(super) fn uncounted(&self) -> Self {
        Self { first_hits: 0, mean_chord_um: None, ..self.clone() }
    }

    /// Its facets as opaque ones, if they are `auto`.
    pub(super) fn opaque(self) -> Self {
        match self.spectrum {
            Spectrum::Refractive(name, crystal) if self.auto => {
                Self { spectrum: Spectrum::Fresnel(name, crystal), ..self }
            }
            _ => self,
        }
    }

    /// Whether the model of its facets holds at a wavelength in um. Particles must be large against
    /// it. Light that refracts into one must not come out again, unless the facets are refractive:
    /// then particles whose faces reflect little may be smaller. Small particles whose faces reflect
    /// much are the domain of wave optics.
    pub fn is_valid(&self, wavelength_um: f64) -> bool {
        match (&self.spectrum, self.mean_chord_um) {
            // What opaque `auto` facets let through is in the budget.
            (Spectrum::Fresnel(_, crystal), Some(chord_um)) if !self.auto => {
                chord_um >= LEAST_WAVELENGTHS * wavelength_um
                    && crystal.transmittance(wavelength_um, chord_um) < MOST_TRANSMITTED
            }
            // Where faces reflect little, light passes through grains, and single faces matter less.
            (Spectrum::Refractive(_, crystal) | Spectrum::Fresnel(_, crystal), Some(chord_um)) => {
                chord_um >= LEAST_WAVELENGTHS * wavelength_um
                    || (chord_um >= LEAST_WHERE_CLEAR * wavelength_um
                        && crystal.hemispherical_reflectance(wavelength_um) < MOST_REFLECTED)
            }
            _ => true,
        }
    }
}
