//! Emissivity of a facet against wavelength, and where it comes from.

mod error;
pub mod features;
pub mod format;
mod mode;
pub mod optics;
mod pure_bed;
pub mod resample;
mod shipped;
mod tabulated;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::spectrum::optics::{PowderForm, UniaxialCrystal};

pub use error::SpectrumError;
pub use mode::{FacetSource, Mode};
pub use pure_bed::PureBed;
pub use shipped::{all, crystal};
pub use tabulated::{Quantity, Tabulated, Warning};

/// Kirchhoff's law for an opaque surface, both ways: emissivity of a reflectance, reflectance of an
/// emissivity. The reflectance is that into, or from, the whole hemisphere.
pub fn kirchhoff(one_of_both: f64) -> f64 {
    1.0 - one_of_both
}

/// Emissivity against wavelength. As JSON it is whole in itself: a table that carries it can be
/// evaluated where the spectrum's file is not at hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "Stored", try_from = "Stored")]
pub enum Spectrum {
    /// The same at every wavelength.
    Constant(f64),
    /// Shipped closed form, by its name.
    Builtin(String, Box<PowderForm>),
    /// Points with straight lines between them.
    Tabulated(Tabulated),
    /// Specular reflection by shipped optical constants, by their name: it depends on the angle.
    Fresnel(String, &'static UniaxialCrystal),
    /// Facets such that a bed of them alone has the emissivity of a powder's spectrum.
    Inverted(Box<Spectrum>, PureBed),
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Stored {
    Constant(f64),
    Builtin(String),
    Tabulated(Tabulated),
    Fresnel(String),
    Inverted { powder: Box<Stored>, pure_bed: PureBed },
}

impl From<Spectrum> for Stored {
    fn from(spectrum: Spectrum) -> Self {
        match spectrum {
            Spectrum::Constant(value) => Self::Constant(value),
            Spectrum::Builtin(name, _) => Self::Builtin(name),
            Spectrum::Tabulated(points) => Self::Tabulated(points),
            Spectrum::Fresnel(name, _) => Self::Fresnel(name),
            Spectrum::Inverted(powder, pure_bed) => {
                Self::Inverted { powder: Box::new((*powder).into()), pure_bed }
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
            Stored::Inverted { powder, pure_bed } => {
                Self::Inverted(Box::new((*powder).try_into()?), pure_bed)
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
            Self::Inverted(powder, _) => write!(f, "inverted: {powder}"),
        }
    }
}

impl Spectrum {
    /// Facets that reflect specularly by shipped optical constants.
    pub fn fresnel(constants: &str) -> Result<Self, SpectrumError> {
        Ok(Self::Fresnel(constants.to_owned(), crystal(constants)?))
    }

    /// A shipped spectrum by name.
    pub fn builtin(name: &str) -> Result<Self, SpectrumError> {
        Ok(Self::Builtin(name.to_owned(), Box::new(shipped::powder(name)?)))
    }

    /// What is wrong with it, if anything: a table may have been written by other hands.
    pub(crate) fn problem(&self) -> Option<String> {
        let outside = |e: &f64| !(0.0..=1.0).contains(e);
        match self {
            Self::Constant(value) if outside(value) => {
                Some(format!("an emissivity of {value} is not within 0 to 1"))
            }
            Self::Tabulated(points) if !points.is_sound() => {
                Some(format!("the spectrum of {} is not one", points.file))
            }
            Self::Inverted(powder, pure_bed) => powder.problem().or_else(|| pure_bed.problem()),
            _ => None,
        }
    }

    /// Least and greatest wavelength that the spectrum holds, um; `None` where there is no bound.
    pub fn range_um(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant(_) => None,
            Self::Builtin(_, form) => Some(form.parameters.range_um),
            Self::Tabulated(points) => Some(points.range_um()),
            Self::Fresnel(_, crystal) => Some(crystal.range_um),
            Self::Inverted(powder, _) => powder.range_um(),
        }
    }

    /// Whether the reflectance depends on the angle of incidence. The facets are specular then, unless the scene says
    /// otherwise, and Lambertian otherwise.
    pub fn is_angular(&self) -> bool {
        matches!(self, Self::Fresnel(..))
    }

    /// Emissivity at a wavelength in um; an error outside the range held, never a guess. Where it
    /// depends on the angle, this is the hemispherical one.
    pub fn emissivity(&self, wavelength_um: f64) -> Result<f64, SpectrumError> {
        self.within_range(wavelength_um)?;
        Ok(match self {
            Self::Constant(value) => *value,
            Self::Builtin(_, form) => form.emissivity(wavelength_um),
            Self::Tabulated(points) => points.interpolate(wavelength_um),
            Self::Fresnel(_, crystal) => {
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
        })
    }

    /// Reflectance of a facet at a wavelength in um, for unpolarised light at a cosine of the angle of
    /// incidence from 0 to 1; the same at every angle unless it [is angular](Self::is_angular). An error
    /// outside the range held.
    pub fn reflectance_at(&self, wavelength_um: f64, cosine: f64) -> Result<f64, SpectrumError> {
        match self {
            Self::Fresnel(_, crystal) => {
                self.within_range(wavelength_um)?;
                Ok(crystal.reflectance(wavelength_um, cosine))
            }
            _ => self.emissivity(wavelength_um).map(kirchhoff),
        }
    }

    /// Whether the spectrum holds all wavelengths from one to another, um.
    pub fn covers(&self, wanted_um: [f64; 2]) -> Result<(), SpectrumError> {
        match self.range_um() {
            Some(held_um) if !(held_um[0] <= wanted_um[0] && wanted_um[1] <= held_um[1]) => {
                let of = match self {
                    Self::Tabulated(points) => &points.file,
                    Self::Inverted(powder, _) => return powder.covers(wanted_um),
                    _ => self.name(),
                };
                Err(SpectrumError::Range { of: of.to_owned(), wanted_um, held_um })
            }
            _ => Ok(()),
        }
    }

    fn within_range(&self, wavelength_um: f64) -> Result<(), SpectrumError> {
        self.covers([wavelength_um; 2])?;
        match self {
            Self::Inverted(powder, _) => powder.within_range(wavelength_um),
            Self::Tabulated(points) => match points.gap_um(wavelength_um) {
                None => Ok(()),
                Some(gap_um) => Err(SpectrumError::Gap {
                    of: points.file.clone(),
                    wanted_um: wavelength_um,
                    gap_um,
                }),
            },
            _ => Ok(()),
        }
    }

    /// Its name, or that of its file.
    pub fn name(&self) -> &str {
        match self {
            Self::Constant(_) => "constant",
            Self::Builtin(name, _) | Self::Fresnel(name, _) => name,
            Self::Tabulated(points) => points.name.as_deref().unwrap_or(&points.file),
            Self::Inverted(powder, _) => powder.name(),
        }
    }

    /// What speaks against it, if anything.
    pub fn warnings(&self) -> &[Warning] {
        match self {
            Self::Tabulated(points) => &points.warnings,
            Self::Inverted(powder, _) => powder.warnings(),
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::format::Reading;
    use super::*;

    fn csv(content: &str) -> Result<Tabulated, SpectrumError> {
        let file = tempfile::NamedTempFile::new().expect("temporary file");
        std::fs::write(file.path(), content).expect("written");
        format::read_one(file.path(), &Reading::default())
    }

    #[test]
    fn a_csv_spectrum_is_read_in_either_order_and_interpolated() {
        for content in ["um,eps\n8,0.2\n10,0.6\n", "10, 0.6\n8, 0.2\n"] {
            let spectrum = Spectrum::Tabulated(csv(content).expect("a spectrum"));
            assert!((spectrum.emissivity(9.0).expect("in range") - 0.4).abs() < 1e-15);
            assert!(spectrum.emissivity(10.0).is_ok());
        }
    }

    #[test]
    fn what_is_wrong_in_a_csv_spectrum_is_named_with_its_line() {
        for (content, line, part) in [
            ("8,0.2\n9,NaN\n", 2, "within 0 to 1"),
            ("8,0.2\n9,35\n", 2, "within 0 to 1"),
            ("8,0.2\nx,0.3\n", 2, "not two numbers"),
            ("8,0.2\n9,0.3,1\n", 2, "3 columns"),
            ("8,0.2\n8,0.3\n", 2, "twice"),
            ("-8,0.2\n8,0.3\n", 1, "not a wavelength"),
            ("um,eps\n8,0.2\n", 1, "at least two"),
        ] {
            match csv(content) {
                Err(SpectrumError::Form { line: at, problem, .. }) => {
                    assert_eq!(at, line, "{content:?}: {problem}");
                    assert!(problem.contains(part), "{content:?}: {problem}");
                }
                other => panic!("{content:?} gave {other:?}"),
            }
        }
    }

    #[test]
    fn outside_its_range_a_spectrum_is_an_error_and_no_guess() {
        let spectrum = Spectrum::builtin("quartz_fine").expect("shipped");
        assert!(spectrum.emissivity(7.3).is_ok() && spectrum.emissivity(14.0).is_ok());
        for um in [7.299, 14.001, f64::NAN] {
            assert!(matches!(spectrum.emissivity(um), Err(SpectrumError::Range { .. })), "{um}");
        }
    }

    #[test]
    fn only_fresnel_facets_reflect_by_angle_and_their_emissivity_is_hemispherical() {
        let fresnel = Spectrum::fresnel("quartz").expect("shipped");
        let at = |cosine| fresnel.reflectance_at(9.0, cosine).expect("in range");
        assert!(fresnel.is_angular() && at(0.0) > at(0.5) && at(0.5) > at(1.0));
        let mean = crate::spectrum::optics::hemispherical_mean(at);
        assert!((fresnel.emissivity(9.0).expect("in range") + mean - 1.0).abs() < 1e-12);
        for um in [6.99, 14.01] {
            for outside in [fresnel.emissivity(um), fresnel.reflectance_at(um, 1.0)] {
                assert!(matches!(outside, Err(SpectrumError::Range { .. })), "{um}");
            }
        }
        let constant = Spectrum::Constant(0.25);
        assert!(!constant.is_angular());
        assert_eq!(constant.reflectance_at(9.0, 0.1).expect("no bound"), 0.75);
        assert!(matches!(Spectrum::fresnel("basalt"), Err(SpectrumError::UnknownConstants(_))));
    }

    #[test]
    fn a_stored_spectrum_reads_back_the_same() {
        let tabulated = csv("8,0.2\n10,0.6\n").expect("a spectrum");
        for spectrum in [
            Spectrum::Constant(0.3),
            Spectrum::builtin("quartz_coarse").expect("shipped"),
            Spectrum::Tabulated(tabulated),
            Spectrum::fresnel("quartz").expect("shipped"),
        ] {
            let text = serde_json::to_string(&spectrum).expect("JSON");
            assert_eq!(serde_json::from_str::<Spectrum>(&text).expect("the same JSON"), spectrum);
        }
    }
}
