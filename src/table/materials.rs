//! The spectra of a scene's materials, and the reflectances that a histogram is evaluated with.

use std::path::{Path, PathBuf};

use crate::histogram::kept::Kept;
use crate::histogram::{Estimate, Histogram, Mean};
use crate::scene::{Component, Constants, ConstantsFile, Inverted, Material, SpectrumSource};
use crate::spectrum::format::{self, Reading};
use crate::spectrum::optics::Crystal;
use crate::spectrum::{Mix, PureBed, Spectrum, SpectrumError, kirchhoff};
use crate::support::error::Failure;
use crate::support::file_error::FileError;
use crate::table::{Table, TableError};

/// The spectrum that a scene names cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ResolveError {
    /// The spectrum itself.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// A table is not that of a pure bed.
    #[error(transparent)]
    PureBed(FileError),
    /// The table of a pure bed cannot be used.
    #[error("pure bed: {0}")]
    PureBedTable(TableError),
}

impl Failure for ResolveError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Spectrum(error) => error.hint(),
            Self::PureBed(_) => Some(
                "trace a bed of one material whose spectrum is a constant, 0.05 say: docs/physics/facets.md"
                    .into(),
            ),
            Self::PureBedTable(error) => error.hint(),
        }
    }
}

/// A material's spectrum is wrong.
#[derive(Debug, thiserror::Error)]
#[error("{}: material {material:?}: {source}", scene.display())]
pub struct MaterialError {
    /// The scene file.
    pub scene: PathBuf,
    /// The material.
    pub material: String,
    /// What is wrong with its spectrum.
    pub source: Box<ResolveError>,
}

impl Failure for MaterialError {
    fn hint(&self) -> Option<String> {
        self.source.hint()
    }
}

/// Cosines within a bin at which a reflectance is taken.
const WITHIN_BIN: u16 = 4;

/// The reflectance of each symbol, by material and within it by layer and cosine, at each wavelength.
pub fn reflectances(
    spectra: &[&Spectrum],
    kept: Kept,
    wavelengths_um: &[f64],
) -> Result<Vec<Vec<f64>>, SpectrumError> {
    if let (Some(&first), Some(&last)) = (wavelengths_um.first(), wavelengths_um.last()) {
        spectra.iter().try_for_each(|spectrum| spectrum.covers([first, last]))?;
    }
    let of = |spectrum: &Spectrum, um: f64, bin: u16| -> Result<f64, SpectrumError> {
        let places = f64::from(kept.cosines) * f64::from(WITHIN_BIN);
        let mut sum = 0.0;
        for place in 0..WITHIN_BIN {
            let cosine = (f64::from(bin * WITHIN_BIN + place) + 0.5) / places;
            sum += spectrum.reflectance_at(um, cosine)?;
        }
        Ok(sum / f64::from(WITHIN_BIN))
    };
    wavelengths_um
        .iter()
        .map(|&um| {
            let mut all = Vec::with_capacity(kept.symbols(spectra.len()));
            for spectrum in spectra {
                let first = all.len();
                if spectrum.is_angular() && kept.cosines > 1 {
                    for bin in 0..kept.cosines {
                        all.push(of(spectrum, um, bin)?);
                    }
                } else {
                    let reflectance = kirchhoff(spectrum.emissivity(um)?);
                    all.resize(all.len() + usize::from(kept.cosines), reflectance);
                }
                // Layers differ in temperature alone.
                for _ in 1..kept.layers {
                    all.extend_from_within(first..first + usize::from(kept.cosines));
                }
            }
            Ok(all)
        })
        .collect()
}

/// The specular share of what a material's facets reflect. The Fresnel equations describe a mirror,
/// unless the scene says otherwise.
pub fn specular(material: &Material, spectrum: &Spectrum) -> f64 {
    material.specular.unwrap_or(if spectrum.is_angular() { 1.0 } else { 0.0 })
}

impl Spectrum {
    /// The spectrum that a scene names; files are relative to `folder`.
    pub fn resolve(source: &SpectrumSource, folder: &Path) -> Result<Self, ResolveError> {
        Ok(match source {
            SpectrumSource::Builtin(name) => Self::builtin(name)?,
            SpectrumSource::Constant(value) => Self::Constant(*value),
            SpectrumSource::File(path) => {
                Self::Tabulated(format::read_one(&folder.join(path), &Reading::default())?)
            }
            SpectrumSource::Fresnel(Constants::Shipped(name)) => Self::fresnel(name)?,
            SpectrumSource::Refractive(Constants::Shipped(name))
            | SpectrumSource::Auto(Constants::Shipped(name)) => Self::refractive(name)?,
            SpectrumSource::Fresnel(Constants::File(ConstantsFile { file })) => {
                Self::of_crystal(Crystal::read(&folder.join(file)).map_err(SpectrumError::from)?)
            }
            SpectrumSource::Refractive(Constants::File(ConstantsFile { file }))
            | SpectrumSource::Auto(Constants::File(ConstantsFile { file })) => {
                Self::into_crystal(Crystal::read(&folder.join(file)).map_err(SpectrumError::from)?)
            }
            SpectrumSource::Inverted(Inverted { spectrum, pure_bed }) => {
                let powder = Box::new(Self::resolve(spectrum, folder)?);
                let tables: Vec<PathBuf> = pure_bed.iter().map(|path| folder.join(path)).collect();
                let pure_bed = if tables.is_empty() {
                    PureBed::shipped().clone()
                } else {
                    PureBed::read(&tables)?
                };
                Self::Inverted(powder, pure_bed)
            }
            SpectrumSource::Mix(components) => {
                let of = |Component { share, spectrum }: &Component| {
                    Ok((*share, Self::resolve(spectrum, folder)?))
                };
                let components = components.iter().map(of).collect::<Result<_, ResolveError>>()?;
                Self::Mix(Mix::new(components))
            }
        })
    }
}

impl PureBed {
    /// Reads the bounce tables of one bed or of several packings of one.
    ///
    /// # Errors
    /// Tables that cannot be read, of more than one material, or of facets that are not Lambertian.
    pub fn read(tables: &[PathBuf]) -> Result<Self, ResolveError> {
        let beds = Table::read_packings(tables).map_err(ResolveError::PureBedTable)?;
        for (table, path) in beds.iter().zip(tables) {
            let problem = if table.materials.len() != 1 {
                let number = table.materials.len();
                format!("a pure bed and its floor have one material, not {number}")
            } else if table.histogram.kept != Kept::PLAIN || table.materials[0].specular != 0.0 {
                "a pure bed has Lambertian facets of one temperature and an isotropic sky".into()
            } else {
                continue;
            };
            return Err(ResolveError::PureBed(FileError::wrong(path, problem)));
        }
        let name = &beds[0].scene;
        let title = match beds.len() {
            1 => format!("{name}, one bed"),
            n => format!("{name}, the mean of {n} packings"),
        };
        let bed = Self::of(title, &beds);
        match bed.problem() {
            Some(problem) => Err(ResolveError::PureBed(FileError::wrong(&tables[0], problem))),
            None => Ok(bed),
        }
    }

    /// The mean of beds of one material.
    fn of(title: String, beds: &[Table]) -> Self {
        let (mut escaped, mut given_up) = (Vec::new(), Vec::new());
        for bed in beds {
            let Histogram { escaped: reached_sky, given_up: left, .. } = &bed.histogram;
            let states = [(&mut escaped, reached_sky), (&mut given_up, left)];
            let all = bed.histogram.paths() * bed.histogram.parts as f64;
            for (shares, of) in states {
                for (state, counts) in of {
                    let hits = usize::from(state[0]);
                    if shares.len() <= hits {
                        shares.resize(hits + 1, 0.0);
                    }
                    let parts: i64 = counts.iter().map(|(_, parts)| parts).sum();
                    shares[hits] += parts as f64 / all / beds.len() as f64;
                }
            }
        }
        let error = |percent: u32| {
            let facet = [f64::from(percent) / 100.0];
            let means: Vec<Mean> = beds.iter().map(|bed| bed.weight(&facet)).collect();
            Estimate::of(&means).standard_error
        };
        let standard_error = (0..=100).map(error).fold(0.0, f64::max);
        Self { title, escaped, given_up, standard_error }
    }
}
