//! The radiances of facets, sky and atmosphere in each band of a table's scene.

use super::{Table, TableMaterial};
use crate::radiometry::{self, Lit, RadiometryError, SkyTable, Temperature};
use crate::scene::{Layers, Sky};
use crate::support::error::Error;

impl Table {
    /// The scene's temperature, known exactly.
    pub fn temperature(&self) -> Temperature {
        Temperature { k: self.temperature_k, error_k: 0.0 }
    }

    /// Whether facets differ in temperature though the order of hits or their layers were not
    /// recorded.
    pub fn lacks_order(&self) -> bool {
        let kept = self.histogram.kept;
        if kept.layers != self.layers.as_ref().map_or(0, Layers::count) {
            return true;
        }
        let of = |material: &TableMaterial| material.temperature_k.unwrap_or(self.temperature_k);
        let mut all = self.materials.iter().map(of);
        let first = all.next();
        !kept.order && (kept.layers > 1 || all.any(|k| Some(k) != first))
    }

    /// Why Eq. 2 is not exact with these temperatures and this sky; empty where it is.
    pub fn eq_2_not_exact(&self) -> Vec<String> {
        let own = self.materials.iter().filter_map(|m| m.temperature_k);
        let mut reasons = Vec::new();
        if own.into_iter().any(|k| k != self.temperature_k) {
            reasons.push("materials differ in temperature".into());
        }
        if let Some(layers) = &self.layers {
            let by = if layers.sun().is_some() { "depth or sun" } else { "depth" };
            reasons.push(format!("the temperature depends on {by}"));
        }
        if self.sky_is_by_zenith() {
            reasons.push("the sky depends on the zenith angle".into());
        }
        reasons
    }

    pub(super) fn sky_is_by_zenith(&self) -> bool {
        matches!(self.sky_temperature_k, Some(Sky::ByZenith(_)))
            || self.sky_radiance.as_ref().is_some_and(SkyTable::is_by_zenith)
    }

    /// What each band's radiance depends on besides the histogram.
    ///
    /// # Errors
    /// A spectrum, the sky or the atmosphere does not cover a wavelength.
    pub fn lit(&self, wavelengths_um: &[f64]) -> Result<Vec<Lit>, Error> {
        let reflectances = self.reflectances(wavelengths_um)?;
        let bands = wavelengths_um.iter().zip(reflectances);
        bands.map(|(&um, reflectance)| self.band_lit(um, reflectance)).collect()
    }

    fn band_lit(&self, wavelength_um: f64, reflectance: Vec<f64>) -> Result<Lit, Error> {
        let planck = |temperature_k| radiometry::planck(wavelength_um, temperature_k);
        let own = |m: &TableMaterial| planck(m.temperature_k.unwrap_or(self.temperature_k));
        let in_layers = |m: &TableMaterial| match &self.layers {
            Some(layers) if m.temperature_k.is_none() => {
                (0..layers.count()).map(|layer| planck(layers.temperature_k(layer))).collect()
            }
            layers => vec![own(m); usize::from(layers.as_ref().map_or(1, Layers::count))],
        };
        let zeniths = self.histogram.kept.zeniths;
        let l_sky: Vec<f64> = (0..zeniths)
            .map(|bin| {
                let zenith_deg = (f64::from(bin) + 0.5) / f64::from(zeniths) * 90.0;
                match (&self.sky_radiance, &self.sky_temperature_k) {
                    (Some(sky), _) => sky.l_sky(wavelength_um, zenith_deg),
                    (None, Some(sky)) => Ok(planck(sky.temperature_k(zenith_deg))),
                    (None, None) => Ok(0.0),
                }
            })
            .collect::<Result<_, RadiometryError>>()?;
        Ok(Lit {
            wavelength_um,
            reflectance,
            l_blackbody_of: self.materials.iter().flat_map(in_layers).collect(),
            l_downwelling: radiometry::l_downwelling(&l_sky),
            l_sky,
            l_blackbody: planck(self.temperature_k),
            path: self.atmosphere.as_ref().map(|a| a.at(wavelength_um)).transpose()?,
        })
    }
}
