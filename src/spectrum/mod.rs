//! Emissivity of a facet by wavelength, and its sources.

pub(crate) mod bands;
mod error;
pub mod features;
pub mod format;
mod mix;
mod mode;
pub mod optics;
mod pure_bed;
pub mod resample;
pub mod sensors;
mod shipped;
mod tabulated;

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::spectrum::features::Windows;
use crate::spectrum::optics::{Crystal, PowderForm};
use crate::support::linear::{OutOfRange, interpolate};

pub use error::SpectrumError;
pub use mix::Mix;
pub use mode::{FacetSource, Mode};
pub use pure_bed::PureBed;
pub use shipped::{all, crystal};
pub use tabulated::{Quantity, Tabulated, Warning};

/// Kirchhoff's law for an opaque surface: the emissivity for a reflectance, or the reflectance for
/// an emissivity, 0 to 1. The reflectance is hemispherical.
pub fn kirchhoff(emissivity_or_reflectance: f64) -> f64 {
    1.0 - emissivity_or_reflectance
}

/// Emissivity by wavelength. Its JSON is complete: a table with it can be evaluated without the
/// spectrum's file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "Stored", try_from = "Stored")]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f64),
    /// A shipped closed form, with its name.
    Builtin(String, Box<PowderForm>),
    /// Points with straight lines between them.
    Tabulated(Tabulated),
    /// Specular facets by optical constants, with their name. Their reflectance depends on the angle
    /// of incidence.
    Fresnel(String, Arc<Crystal>),
    /// Facets through which light passes, by optical constants, with their name. What is said of them
    /// without a bed is their reflectance from outside.
    Refractive(String, Arc<Crystal>),
    /// The facets of a powder: a bed of them alone has the emissivity of the powder's spectrum.
    Inverted(Box<Spectrum>, PureBed),
    /// Patches of several kinds on each facet.
    Mix(Mix),
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Stored {
    Constant(f64),
    Builtin(String),
    Tabulated(Tabulated),
    Fresnel(String),
    Crystal(Box<Crystal>),
    Refractive(String),
    RefractiveCrystal(Box<Crystal>),
    Inverted { powder: Box<Stored>, pure_bed: PureBed },
    Mix(Vec<StoredComponent>),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredComponent {
    share: f64,
    spectrum: Stored,
}

impl From<Spectrum> for Stored {
    fn from(spectrum: Spectrum) -> Self {
        match spectrum {
            Spectrum::Constant(value) => Self::Constant(value),
            Spectrum::Builtin(name, _) => Self::Builtin(name),
            Spectrum::Tabulated(points) => Self::Tabulated(points),
            Spectrum::Fresnel(name, of) => match crystal(&name) {
                Ok(shipped) if *shipped == *of => Self::Fresnel(name),
                _ => Self::Crystal(Box::new(Arc::unwrap_or_clone(of))),
            },
            Spectrum::Refractive(name, of) => match crystal(&name) {
                Ok(shipped) if *shipped == *of => Self::Refractive(name),
                _ => Self::RefractiveCrystal(Box::new(Arc::unwrap_or_clone(of))),
            },
            Spectrum::Inverted(powder, pure_bed) => {
                Self::Inverted { powder: Box::new((*powder).into()), pure_bed }
            }
            Spectrum::Mix(mix) => {
                let stored =
                    |(share, of): (f64, Spectrum)| StoredComponent { share, spectrum: of.into() };
                Self::Mix(mix.into_components().into_iter().map(stored).collect())
            }
        }
    }
}

impl TryFrom<Stored> for Spectrum {
    type Error = SpectrumError;
    fn try_from(stored: Stored) -> Result<Self, SpectrumError> {
        Ok(match stored {
            Stored::Constant(value) => Self::Constant(value),
            Stored::Builtin(name) => Self::builtin(&name)?,
            Stored::Tabulated(points) => Self::Tabulated(points),
            Stored::Fresnel(name) => Self::fresnel(&name)?,
            Stored::Crystal(crystal) => Self::of_crystal(*crystal),
            Stored::Refractive(name) => Self::refractive(&name)?,
            Stored::RefractiveCrystal(crystal) => Self::into_crystal(*crystal),
            Stored::Inverted { powder, pure_bed } => {
                Self::Inverted(Box::new((*powder).try_into()?), pure_bed)
            }
            Stored::Mix(components) => {
                let read = |of: StoredComponent| Ok((of.share, of.spectrum.try_into()?));
                let components = components.into_iter().map(read);
                Self::Mix(Mix::new(components.collect::<Result<_, SpectrumError>>()?))
            }
        })
    }
}

impl fmt::Display for Spectrum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(value) => write!(f, "{value} at every wavelength"),
            Self::Builtin(name, form) => {
                let p = &form.parameters;
                write!(
                    f,
                    "{name}, {} (RMS {} over {}-{} um)",
                    p.title, p.rms, p.range_um[0], p.range_um[1]
                )
            }
            Self::Tabulated(points) => {
                f.write_str(&points.file)?;
                points
                    .warnings
                    .iter()
                    .try_for_each(|warning| write!(f, " ({})", warning.in_short()))
            }
            Self::Fresnel(name, crystal) => {
                write!(f, "{name}, {}, Fresnel facets", crystal.title)
            }
            Self::Refractive(name, crystal) => {
                write!(f, "{name}, {}, refractive facets", crystal.title)
            }
            Self::Inverted(powder, _) => write!(f, "inverted: {powder}"),
            Self::Mix(mix) => write!(f, "by area {}", mix.name()),
        }
    }
}

impl Spectrum {
    /// Specular facets by shipped optical constants.
    pub fn fresnel(constants: &str) -> Result<Self, SpectrumError> {
        Ok(Self::Fresnel(constants.to_owned(), Arc::new(crystal(constants)?.clone())))
    }

    /// Facets that reflect specularly by the optical constants of any crystal.
    pub fn of_crystal(crystal: Crystal) -> Self {
        Self::Fresnel(crystal.title.clone(), Arc::new(crystal))
    }

    /// Facets that let light through, by shipped optical constants.
    pub fn refractive(constants: &str) -> Result<Self, SpectrumError> {
        Ok(Self::Refractive(constants.to_owned(), Arc::new(crystal(constants)?.clone())))
    }

    /// Facets that let light through, by the optical constants of any crystal.
    pub fn into_crystal(crystal: Crystal) -> Self {
        Self::Refractive(crystal.title.clone(), Arc::new(crystal))
    }

    /// Whether light passes through the facets.
    pub fn is_refractive(&self) -> bool {
        matches!(self, Self::Refractive(..))
    }

    /// A shipped spectrum by name.
    pub fn builtin(name: &str) -> Result<Self, SpectrumError> {
        Ok(Self::Builtin(name.to_owned(), Box::new(shipped::powder(name)?)))
    }

    /// Why it is not a valid spectrum, if it is not: its table may be of another origin.
    pub(crate) fn problem(&self) -> Option<String> {
        match self {
            Self::Constant(value) if !(0.0..=1.0).contains(value) => {
                Some(format!("an emissivity of {value} is not within 0 to 1"))
            }
            Self::Tabulated(points) if !points.is_sound() => Some(format!(
                "{} is not a valid spectrum: it needs two or more ascending wavelengths, each with \
                 an emissivity of 0 to 1",
                points.file
            )),
            Self::Inverted(powder, pure_bed) => powder.problem().or_else(|| pure_bed.problem()),
            Self::Mix(mix) => mix.problem(),
            _ => None,
        }
    }

    /// Least and greatest wavelength of the spectrum, um; `None` if it is unbounded.
    pub fn range_um(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant(_) => None,
            Self::Builtin(_, form) => Some(form.parameters.range_um),
            Self::Tabulated(points) => Some(points.range_um()),
            Self::Fresnel(_, crystal) | Self::Refractive(_, crystal) => Some(crystal.range_um),
            Self::Inverted(powder, _) => powder.range_um(),
            Self::Mix(mix) => mix.range_um(),
        }
    }

    /// Whether the reflectance depends on the angle of incidence. Such facets are specular and
    /// others Lambertian, unless the scene says otherwise.
    pub fn is_angular(&self) -> bool {
        matches!(self, Self::Fresnel(..) | Self::Refractive(..))
    }

    /// Emissivity at a wavelength in um, 0 to 1. If it depends on the angle, this is the
    /// hemispherical emissivity.
    ///
    /// # Errors
    /// A wavelength outside the range or in a gap, or a powder's emissivity that no facet gives.
    pub fn emissivity(&self, wavelength_um: f64) -> Result<f64, SpectrumError> {
        self.within_range(wavelength_um)?;
        Ok(match self {
            Self::Constant(value) => *value,
            Self::Builtin(_, form) => form.emissivity(wavelength_um),
            Self::Tabulated(points) => {
                interpolate(&points.wavelength_um, &points.emissivity, wavelength_um)
            }
            Self::Fresnel(_, crystal) | Self::Refractive(_, crystal) => {
                kirchhoff(crystal.hemispherical_reflectance(wavelength_um))
            }
            Self::Inverted(powder, pure_bed) => {
                let emissivity = powder.emissivity(wavelength_um)?;
                let reflectance = pure_bed.facet(kirchhoff(emissivity)).ok_or_else(|| {
                    let of = powder.name().to_owned();
                    let least = kirchhoff(pure_bed.reflectance(1.0));
                    SpectrumError::NoFacet { of, wavelength_um, emissivity, least }
                })?;
                kirchhoff(reflectance)
            }
            // Shares that were rounded may add up to a little more than 1.
            Self::Mix(mix) => mix.mean(|spectrum| spectrum.emissivity(wavelength_um))?.min(1.0),
        })
    }

    /// Reflectance of a facet for unpolarised light, 0 to 1, at a wavelength in um and a cosine of
    /// the angle of incidence from 0 to 1. It is the same at every angle unless it [is
    /// angular](Self::is_angular).
    ///
    /// # Errors
    /// As for [`Self::emissivity`].
    pub fn reflectance_at(&self, wavelength_um: f64, cosine: f64) -> Result<f64, SpectrumError> {
        match self {
            Self::Fresnel(_, crystal) | Self::Refractive(_, crystal) => {
                self.within_range(wavelength_um)?;
                Ok(crystal.reflectance(wavelength_um, cosine))
            }
            _ => self.emissivity(wavelength_um).map(kirchhoff),
        }
    }

    /// An error unless the spectrum holds all wavelengths from one to another, um.
    pub fn covers(&self, needed_um: [f64; 2]) -> Result<(), SpectrumError> {
        let of = match self {
            Self::Tabulated(points) => &points.file,
            Self::Inverted(powder, _) => return powder.covers(needed_um),
            Self::Mix(mix) => {
                return mix.components().iter().try_for_each(|(_, of)| of.covers(needed_um));
            }
            _ => self.name(),
        };
        let of = || format!("the spectrum of {of}");
        let check = |held_um| OutOfRange::check(of, needed_um, held_um);
        Ok(self.range_um().map_or(Ok(()), check)?)
    }

    fn within_range(&self, wavelength_um: f64) -> Result<(), SpectrumError> {
        self.covers([wavelength_um; 2])?;
        match self {
            Self::Inverted(powder, _) => powder.within_range(wavelength_um),
            Self::Mix(mix) => {
                mix.components().iter().try_for_each(|(_, of)| of.within_range(wavelength_um))
            }
            Self::Tabulated(points) => points.gap_um(wavelength_um).map_or(Ok(()), |gap_um| {
                let of = points.file.clone();
                Err(SpectrumError::Gap { of, needed_um: wavelength_um, gap_um })
            }),
            _ => Ok(()),
        }
    }

    /// Its name, or the name of its file.
    pub fn name(&self) -> &str {
        match self {
            Self::Constant(_) => "constant",
            Self::Builtin(name, _) | Self::Fresnel(name, _) | Self::Refractive(name, _) => name,
            Self::Tabulated(points) => points.name.as_deref().unwrap_or(&points.file),
            Self::Inverted(powder, _) => powder.name(),
            Self::Mix(mix) => mix.name(),
        }
    }

    /// Where its mineral has its features; `None` of a spectrum that does not say of what it is. Of
    /// a mix its largest share decides.
    pub fn windows(&self) -> Option<&Windows> {
        match self {
            Self::Builtin(_, form) => crystal(&form.parameters.constants).ok()?.features.as_ref(),
            Self::Fresnel(_, crystal) | Self::Refractive(_, crystal) => {
                Some(crystal.features.as_ref().unwrap_or_else(|| Windows::none()))
            }
            Self::Inverted(powder, _) => powder.windows(),
            Self::Mix(mix) => {
                let known = mix
                    .components()
                    .iter()
                    .filter_map(|(share, of)| of.windows().map(|windows| (share, windows)));
                known.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, windows)| windows)
            }
            Self::Constant(_) | Self::Tabulated(_) => None,
        }
    }

    /// Warnings about its values.
    pub fn warnings(&self) -> Vec<&Warning> {
        match self {
            Self::Tabulated(points) => points.warnings.iter().collect(),
            Self::Inverted(powder, _) => powder.warnings(),
            Self::Mix(mix) => mix.warnings(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
