//! Optical constants of crystals.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::fresnel::{hemispherical_mean, unpolarised_reflectance};
use crate::spectrum::features::Windows;
use crate::support::file_error::FileError;
use crate::support::linear::interpolate;

use crate::support::math;

/// One damped harmonic oscillator of a dielectric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oscillator {
    /// Resonance wavenumber, cm-1.
    pub v0_per_cm: f64,
    /// Strength, dimensionless.
    pub strength: f64,
    /// Damping as a fraction of the resonance wavenumber.
    pub damping: f64,
}

/// One pair of modes in the four-parameter form of a dielectric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// Wavenumber of the transverse optical mode, cm-1.
    pub to_per_cm: f64,
    /// Its damping, cm-1.
    pub to_damping_per_cm: f64,
    /// Wavenumber of the longitudinal optical mode, cm-1.
    pub lo_per_cm: f64,
    /// Its damping, cm-1.
    pub lo_damping_per_cm: f64,
}

/// Complex refractive indices n + ik by wavelength, with straight lines between rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Indices {
    /// Wavelengths, um, ascending.
    pub wavelength_um: Vec<f64>,
    /// Their real parts.
    pub n: Vec<f64>,
    /// Their imaginary parts, 0 or more.
    pub k: Vec<f64>,
}

/// The dielectric function along one axis of a crystal, at v = 1e4 / wavelength in cm-1:
///
/// eps = eps_inf prod (LO^2 - v^2 - i gLO v) / (TO^2 - v^2 - i gTO v) + sum S v0^2 / (v0^2 - v^2 -
/// i g v0 v)
///
/// Published sets of constants have either factors or oscillators. In their place a table of
/// indices may stand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Dielectric constant far above the resonances; 0 where there is a table.
    #[serde(default)]
    pub eps_inf: f64,
    /// The factors of the product.
    #[serde(default)]
    pub factors: Vec<Factor>,
    /// The terms of the sum.
    #[serde(default)]
    pub oscillators: Vec<Oscillator>,
    /// The indices themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<Indices>,
}

impl Axis {
    /// The complex dielectric function at a wavelength in um.
    pub fn dielectric(&self, wavelength_um: f64) -> Complex64 {
        if let Some(Indices { wavelength_um: um, n, k }) = &self.table {
            let index = [n, k].map(|part| interpolate(um, part, wavelength_um));
            let index = Complex64::new(index[0], index[1]);
            return index * index;
        }
        let v = 1e4 / wavelength_um;
        let resonance =
            |v0: f64, damping_per_cm: f64| Complex64::new(v0 * v0 - v * v, -damping_per_cm * v);
        let product: Complex64 = self
            .factors
            .iter()
            .map(|f| {
                resonance(f.lo_per_cm, f.lo_damping_per_cm)
                    / resonance(f.to_per_cm, f.to_damping_per_cm)
            })
            .product();
        let sum: Complex64 = self
            .oscillators
            .iter()
            .map(|o| {
                o.strength * o.v0_per_cm * o.v0_per_cm
                    / resonance(o.v0_per_cm, o.damping * o.v0_per_cm)
            })
            .sum();
        self.eps_inf * product + sum
    }

    /// The complex refractive index n + ik at a wavelength in um.
    pub fn index(&self, wavelength_um: f64) -> Complex64 {
        math::sqrt(self.dielectric(wavelength_um))
    }

    /// What is wrong with it over a range of wavelengths, um, if anything is.
    fn problem(&self, [from, to]: [f64; 2]) -> Option<String> {
        let has_resonances = !self.factors.is_empty() || !self.oscillators.is_empty();
        match &self.table {
            Some(_) if self.eps_inf != 0.0 || has_resonances => {
                return Some("an axis has resonances or a table, not both".into());
            }
            None if self.eps_inf <= 0.0 => {
                return Some("an axis needs eps_inf above 0, or a table".into());
            }
            Some(Indices { wavelength_um: um, n, k }) => {
                let ascends = um.len() > 1 && um.windows(2).all(|pair| pair[0] < pair[1]);
                if !ascends || n.len() != um.len() || k.len() != um.len() {
                    return Some(
                        "a table has ascending wavelength_um, two or more, and as many n and k"
                            .into(),
                    );
                }
                if from < um[0] || to > um[um.len() - 1] {
                    return Some(format!("a table does not hold all of {from} to {to} um"));
                }
                if !n.iter().chain(k).all(|part| *part >= 0.0) {
                    return Some("n or k is below 0".into());
                }
            }
            None => {}
        }
        // A passive medium absorbs: the four-parameter form does not ensure it.
        (0..=PROBES).find_map(|i| {
            let um = from + (to - from) * f64::from(i) / f64::from(PROBES);
            let eps = self.dielectric(um);
            let passive = eps.is_finite() && eps.im >= 0.0;
            (!passive).then(|| format!("the dielectric function has gain at {um:.3} um: {eps:.4}"))
        })
    }
}

/// Wavelengths at which a dielectric function is tested.
const PROBES: u32 = 1000;

/// Optical constants of a crystal, from a file of `spectra/` or of the user's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "CrystalFile", into = "CrystalFile")]
pub struct Crystal {
    /// The crystal and the kind of constants.
    pub title: String,
    /// Their source.
    pub citation: String,
    /// Range of wavelengths in which they hold, um.
    pub range_um: [f64; 2],
    /// Where emissivity curves of the mineral have their features.
    pub features: Option<Windows>,
    /// The dielectric function along its axes.
    pub axes: Axes,
}

/// The dielectric function along the axes of a crystal.
#[derive(Debug, Clone, PartialEq)]
pub enum Axes {
    /// The same in every direction: cubic crystals, glasses, pressed powders.
    Isotropic(Box<Axis>),
    /// Of a uniaxial crystal: for an electric field across the optic axis, and along it.
    Uniaxial(Box<[Axis; 2]>),
    /// Along three axes at right angles.
    Biaxial(Box<[Axis; 3]>),
}

/// Optical constants as a file has them: `isotropic`, or `ordinary` and `extraordinary`, or
/// `biaxial`.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CrystalFile {
    title: String,
    citation: String,
    range_um: [f64; 2],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    features: Option<Windows>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    isotropic: Option<Axis>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ordinary: Option<Axis>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    extraordinary: Option<Axis>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    biaxial: Option<[Axis; 3]>,
}

impl TryFrom<CrystalFile> for Crystal {
    type Error = String;
    fn try_from(file: CrystalFile) -> Result<Self, String> {
        let CrystalFile { title, citation, range_um, features, .. } = file;
        let CrystalFile { isotropic, ordinary, extraordinary, biaxial, .. } = file;
        let axes = match (isotropic, ordinary, extraordinary, biaxial) {
            (Some(axis), None, None, None) => Axes::Isotropic(axis.into()),
            (None, Some(o), Some(e), None) => Axes::Uniaxial([o, e].into()),
            (None, None, None, Some(axes)) => Axes::Biaxial(axes.into()),
            _ => {
                return Err(
                    "give isotropic, or ordinary and extraordinary, or biaxial: three axes".into(),
                );
            }
        };
        let [from, to] = range_um;
        if !(from >= 0.01 && from < to && to <= 1e4) {
            return Err(format!("range_um {from} to {to} is not a range within 0.01 to 10000 um"));
        }
        let of_axes = axes.each().iter().find_map(|(_, axis)| axis.problem(range_um));
        match of_axes.or_else(|| features.as_ref().and_then(Windows::problem)) {
            Some(problem) => Err(problem),
            None => Ok(Self { title, citation, range_um, features, axes }),
        }
    }
}

impl From<Crystal> for CrystalFile {
    fn from(Crystal { title, citation, range_um, features, axes }: Crystal) -> Self {
        let (mut isotropic, mut ordinary, mut extraordinary, mut biaxial) =
            (None, None, None, None);
        match axes {
            Axes::Isotropic(axis) => isotropic = Some(*axis),
            Axes::Uniaxial(axes) => {
                let [o, e] = *axes;
                (ordinary, extraordinary) = (Some(o), Some(e));
            }
            Axes::Biaxial(axes) => biaxial = Some(*axes),
        }
        Self { title, citation, range_um, features, isotropic, ordinary, extraordinary, biaxial }
    }
}

impl Axes {
    /// The axes, each with its weight for randomly oriented crystals. The weights need not add up
    /// to 1.
    pub fn each(&self) -> Vec<(f64, &Axis)> {
        match self {
            Self::Isotropic(axis) => vec![(1.0, axis)],
            Self::Uniaxial(axes) => vec![(2.0, &axes[0]), (1.0, &axes[1])],
            Self::Biaxial(axes) => axes.iter().map(|axis| (1.0, axis)).collect(),
        }
    }
}

impl Crystal {
    /// Reads a file of optical constants.
    ///
    /// # Errors
    /// The file cannot be read, or is not a valid set of constants.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = fs::read_to_string(path).map_err(FileError::read(path))?;
        serde_json::from_str(&text).map_err(|error| FileError::wrong(path, error.to_string()))
    }

    /// Reflectance of a smooth face for unpolarised light at a cosine of the angle of incidence,
    /// 0 to 1, with randomly oriented crystal axes: (2 Ro + Re) / 3 for a uniaxial crystal, the mean
    /// of three for a biaxial one.
    pub fn reflectance(&self, wavelength_um: f64, cosine: f64) -> f64 {
        self.mean(wavelength_um, |eps| unpolarised_reflectance(eps, cosine))
    }

    /// The same for light from the whole hemisphere.
    pub fn hemispherical_reflectance(&self, wavelength_um: f64) -> f64 {
        self.mean(wavelength_um, |eps| {
            hemispherical_mean(|cosine| unpolarised_reflectance(eps, cosine))
        })
    }

    /// Transmittance of a path within the crystal, um, with randomly oriented axes.
    pub fn transmittance(&self, wavelength_um: f64, path_um: f64) -> f64 {
        self.mean(wavelength_um, |eps| {
            math::exp(-4.0 * PI * math::sqrt(eps).im * path_um / wavelength_um)
        })
    }

    /// Share of diffuse light that goes straight through a ball of this mean chord, um. Its chords
    /// are D mu with the density 2 mu of their cosines, and its mean chord is 2 D / 3.
    pub fn diffuse_transmittance(&self, wavelength_um: f64, mean_chord_um: f64) -> f64 {
        self.mean(wavelength_um, |eps| {
            let diameter_um = 1.5 * mean_chord_um;
            let x = 4.0 * PI * math::sqrt(eps).im * diameter_um / wavelength_um;
            if x < 1e-3 {
                1.0 - 2.0 * x / 3.0
            } else {
                2.0 * (1.0 - math::exp(-x) * (1.0 + x)) / (x * x)
            }
        })
    }

    fn mean(&self, wavelength_um: f64, of: impl Fn(Complex64) -> f64) -> f64 {
        let axes = self.axes.each();
        let sum: f64 =
            axes.iter().map(|(weight, axis)| weight * of(axis.dielectric(wavelength_um))).sum();
        sum / axes.iter().map(|(weight, _)| weight).sum::<f64>()
    }
}

#[cfg(test)]
mod tests;
