//! Emissivity of a facet against wavelength, and where it comes from.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::optics::{PowderForm, PowderParameters, UniaxialCrystal};
use crate::scene::SpectrumSource;

/// A spectrum cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SpectrumError {
    /// The file cannot be read.
    #[error("cannot read the spectrum {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a spectrum.
    #[error("{}, line {line}: {problem}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong there.
        problem: String,
    },
    /// There is no shipped spectrum of that name.
    #[error("there is no shipped spectrum {0:?}")]
    Unknown(String),
    /// There is no shipped set of optical constants of that name.
    #[error("there are no shipped optical constants {0:?}")]
    UnknownConstants(String),
    /// The spectrum does not hold the wavelength wanted.
    #[error("the spectrum of {of} holds {}-{} um, and {wanted_um} um is wanted", held_um[0], held_um[1])]
    Range {
        /// The file or the name of the spectrum.
        of: String,
        /// The wavelength wanted, um.
        wanted_um: f64,
        /// Least and greatest wavelength held, um.
        held_um: [f64; 2],
    },
}

impl SpectrumError {
    /// What the user can do about it.
    pub fn hint(&self) -> Option<String> {
        Some(match self {
            Self::Unknown(_) => format!("there are {}", BUILTIN.map(|(name, _)| name).join(", ")),
            Self::UnknownConstants(_) => format!("there are {}", QUARTZ_SETS.join(" and ")),
            Self::Form { .. } => "a spectrum is a CSV file of two columns, wavelength in um and \
                                  emissivity from 0 to 1; one heading line may come first"
                .into(),
            Self::Range { held_um, .. } => {
                format!("ask for a range within it: --range {}-{}", held_um[0], held_um[1])
            }
            Self::Read { .. } => return None,
        })
    }
}

const BUILTIN: [(&str, &str); 3] = [
    ("quartz_fine", include_str!("../../spectra/quartz_fine.json")),
    ("quartz_medium", include_str!("../../spectra/quartz_medium.json")),
    ("quartz_coarse", include_str!("../../spectra/quartz_coarse.json")),
];

/// Names of the shipped sets of optical constants of crystalline quartz, the better one first.
pub const QUARTZ_SETS: [&str; 2] = ["quartz", "quartz_spitzer_kleinman"];

/// A shipped set of optical constants by name.
pub fn crystal(name: &str) -> Result<&'static UniaxialCrystal, SpectrumError> {
    static SETS: LazyLock<[UniaxialCrystal; 2]> = LazyLock::new(|| {
        [
            include_str!("../../spectra/quartz.json"),
            include_str!("../../spectra/quartz_spitzer_kleinman.json"),
        ]
        .map(|text| serde_json::from_str(text).expect("the shipped constants are read by a test"))
    });
    QUARTZ_SETS
        .iter()
        .position(|known| *known == name)
        .map(|set| &SETS[set])
        .ok_or_else(|| SpectrumError::UnknownConstants(name.to_owned()))
}

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
}

/// A spectrum as points, wavelengths ascending.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tabulated {
    /// The file that the points come from.
    pub file: String,
    /// Wavelengths, um, ascending, at least two.
    pub wavelength_um: Vec<f64>,
    /// Emissivity at each, 0 to 1.
    pub emissivity: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Stored {
    Constant(f64),
    Builtin(String),
    Tabulated(Tabulated),
    Fresnel(String),
}

impl From<Spectrum> for Stored {
    fn from(spectrum: Spectrum) -> Self {
        match spectrum {
            Spectrum::Constant(value) => Self::Constant(value),
            Spectrum::Builtin(name, _) => Self::Builtin(name),
            Spectrum::Tabulated(points) => Self::Tabulated(points),
            Spectrum::Fresnel(name, _) => Self::Fresnel(name),
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
            Self::Tabulated(points) => write!(f, "{}", points.file),
            Self::Fresnel(name, crystal) => {
                write!(f, "{name}, {}, specular facets (Fresnel)", crystal.title)
            }
        }
    }
}

impl Spectrum {
    /// Gets the spectrum that a scene names; files are relative to `folder`.
    pub fn resolve(source: &SpectrumSource, folder: &Path) -> Result<Self, SpectrumError> {
        match source {
            SpectrumSource::Builtin(name) => Self::builtin(name),
            SpectrumSource::Constant(value) => Ok(Self::Constant(*value)),
            SpectrumSource::File(path) => read_csv(&folder.join(path)).map(Self::Tabulated),
            SpectrumSource::Fresnel(name) => Self::fresnel(name),
        }
    }

    /// Facets that reflect specularly by shipped optical constants.
    pub fn fresnel(constants: &str) -> Result<Self, SpectrumError> {
        Ok(Self::Fresnel(constants.to_owned(), crystal(constants)?))
    }

    /// A shipped spectrum by name.
    pub fn builtin(name: &str) -> Result<Self, SpectrumError> {
        let (_, text) = BUILTIN
            .iter()
            .find(|(known, _)| *known == name)
            .ok_or_else(|| SpectrumError::Unknown(name.to_owned()))?;
        let parameters: PowderParameters =
            serde_json::from_str(text).expect("the shipped parameters are read by a test");
        Ok(Self::Builtin(
            name.to_owned(),
            Box::new(PowderForm::new(crystal("quartz_spitzer_kleinman")?, parameters)),
        ))
    }

    /// What is wrong with it, if anything: a table may have been written by other hands.
    pub(crate) fn problem(&self) -> Option<String> {
        let outside = |e: &f64| !(0.0..=1.0).contains(e);
        match self {
            Self::Constant(value) if outside(value) => {
                Some(format!("an emissivity of {value} is not within 0 to 1"))
            }
            Self::Tabulated(Tabulated { file, wavelength_um, emissivity }) => {
                let sound = wavelength_um.len() >= 2
                    && wavelength_um.len() == emissivity.len()
                    && wavelength_um.windows(2).all(|pair| pair[0] < pair[1])
                    && !emissivity.iter().any(outside);
                (!sound).then(|| format!("the spectrum of {file} is not one"))
            }
            _ => None,
        }
    }

    /// Least and greatest wavelength that the spectrum holds, um; `None` where there is no bound.
    pub fn range_um(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant(_) => None,
            Self::Builtin(_, form) => Some(form.parameters.range_um),
            Self::Tabulated(points) => {
                Some([points.wavelength_um[0], *points.wavelength_um.last()?])
            }
            Self::Fresnel(_, crystal) => Some(crystal.range_um),
        }
    }

    /// Whether the reflectance depends on the angle of incidence. The facets are specular then, and
    /// Lambertian otherwise.
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

    fn within_range(&self, wavelength_um: f64) -> Result<(), SpectrumError> {
        match self.range_um() {
            Some(held_um) if !(held_um[0]..=held_um[1]).contains(&wavelength_um) => {
                let of = match self {
                    Self::Tabulated(points) => points.file.clone(),
                    Self::Builtin(name, _) | Self::Fresnel(name, _) => name.clone(),
                    Self::Constant(_) => String::new(),
                };
                Err(SpectrumError::Range { of, wanted_um: wavelength_um, held_um })
            }
            _ => Ok(()),
        }
    }
}

impl Tabulated {
    fn interpolate(&self, um: f64) -> f64 {
        let above =
            self.wavelength_um.partition_point(|&x| x < um).clamp(1, self.wavelength_um.len() - 1);
        let (x0, x1) = (self.wavelength_um[above - 1], self.wavelength_um[above]);
        let (y0, y1) = (self.emissivity[above - 1], self.emissivity[above]);
        y0 + (y1 - y0) * (um - x0) / (x1 - x0)
    }
}

fn read_csv(path: &Path) -> Result<Tabulated, SpectrumError> {
    let text = fs::read_to_string(path)
        .map_err(|source| SpectrumError::Read { path: path.to_owned(), source })?;
    let wrong =
        |line: u64, problem: String| SpectrumError::Form { path: path.to_owned(), line, problem };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let mut points: Vec<(f64, f64, u64)> = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|error| {
            wrong(error.position().map_or(0, csv::Position::line), error.to_string())
        })?;
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() != 2 {
            return Err(wrong(line, format!("{} columns where two are wanted", record.len())));
        }
        match (record[0].parse::<f64>(), record[1].parse::<f64>()) {
            (Ok(um), Ok(emissivity)) => {
                if !(um.is_finite() && um > 0.0) {
                    return Err(wrong(line, format!("{um} is not a wavelength in um")));
                }
                if !(0.0..=1.0).contains(&emissivity) {
                    return Err(wrong(
                        line,
                        format!("an emissivity of {emissivity} is not within 0 to 1"),
                    ));
                }
                points.push((um, emissivity, line));
            }
            (Err(_), Err(_)) if row == 0 => {}
            _ => {
                return Err(wrong(
                    line,
                    format!("{:?}, {:?} are not two numbers", &record[0], &record[1]),
                ));
            }
        }
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    if points.len() < 2 {
        return Err(wrong(1, "there must be at least two points".into()));
    }
    if let Some(pair) = points.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(wrong(pair[1].2, format!("the wavelength {} um stands twice", pair[0].0)));
    }
    Ok(Tabulated {
        file: path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        wavelength_um: points.iter().map(|point| point.0).collect(),
        emissivity: points.iter().map(|point| point.1).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn csv(content: &str) -> Result<Tabulated, SpectrumError> {
        let file = tempfile::NamedTempFile::new().expect("temporary file");
        std::fs::write(file.path(), content).expect("written");
        read_csv(file.path())
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
        let mean = crate::optics::hemispherical_mean(at);
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
