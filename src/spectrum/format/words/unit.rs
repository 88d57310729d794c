//! The units of wavelengths.

use super::text::{Token, plain, starts, tokens};
use super::vocabulary::WAVENUMBERS;

/// The unit of a file's wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Unit {
    /// Micrometres
    #[cfg_attr(feature = "cli", value(name = "um"))]
    Micrometre,
    /// Nanometres
    #[cfg_attr(feature = "cli", value(name = "nm"))]
    Nanometre,
    /// Angstroms
    Angstrom,
    /// Millimetres
    #[cfg_attr(feature = "cli", value(name = "mm"))]
    Millimetre,
    /// Metres
    #[cfg_attr(feature = "cli", value(name = "m"))]
    Metre,
    /// Wavenumbers, cm-1
    #[cfg_attr(feature = "cli", value(name = "cm-1"))]
    Wavenumber,
    /// Wavenumbers, um-1
    #[cfg_attr(feature = "cli", value(name = "um-1"))]
    PerMicrometre,
    /// Wavenumbers, m-1
    #[cfg_attr(feature = "cli", value(name = "m-1"))]
    PerMetre,
    /// Frequencies, THz
    #[cfg_attr(feature = "cli", value(name = "THz"))]
    Terahertz,
    /// Energies of a photon, eV
    #[cfg_attr(feature = "cli", value(name = "eV"))]
    Electronvolt,
}

/// Speed of light, um THz (exact).
const C_UM_THZ: f64 = 299.792_458;
/// Planck constant times the speed of light, um eV (CODATA 2019, exact: here all digits that hold).
const HC_UM_EV: f64 = 1.239_841_984_332_002_6;

impl Unit {
    /// The unit that a heading or label names, if it names one.
    pub(crate) fn named(text: &str) -> Option<Self> {
        let text = plain(text);
        let tokens = tokens(&text);
        let units = tokens.iter().enumerate().filter_map(|(i, token)| match token.word {
            _ if starts(token.word, &WAVENUMBERS) => Some(Self::Wavenumber),
            // mu m, as LaTeX has it.
            "m" if i > 0 && tokens[i - 1].word == "mu" => Some(Self::Micrometre),
            _ => token.unit(),
        });
        // A unit says more than the word wavenumber.
        let units: Vec<Self> = units.collect();
        units.iter().copied().find(|unit| *unit != Self::Wavenumber).or(units.first().copied())
    }

    /// A wavelength in um.
    pub(crate) fn um(self, value: f64) -> f64 {
        match self {
            Self::Micrometre => value,
            Self::Nanometre => value / 1e3,
            Self::Angstrom => value / 1e4,
            Self::Millimetre => value * 1e3,
            Self::Metre => value * 1e6,
            Self::Wavenumber => 1e4 / value,
            Self::PerMicrometre => 1.0 / value,
            Self::PerMetre => 1e6 / value,
            Self::Terahertz => C_UM_THZ / value,
            Self::Electronvolt => HC_UM_EV / value,
        }
    }
}

impl Token<'_> {
    /// The unit that the word is, if it is one.
    pub(super) fn unit(&self) -> Option<Unit> {
        // um-1, 1/um, and cm.1 as tables of R have it.
        let after = self.after.trim_start();
        let is_power = after.strip_prefix('-').is_some_and(|rest| rest.trim().starts_with('1'))
            || self.before.trim_end().ends_with("1/")
            || self.before.trim_end().ends_with("1 /");
        Some(match self.word {
            "cm" if is_power || after.trim_start_matches(['.', '_']).starts_with('1') => {
                Unit::Wavenumber
            }
            "um" | "\u{b5}m" if is_power => Unit::PerMicrometre,
            "m" if is_power => Unit::PerMetre,
            _ if is_power => return None,
            "um" | "\u{b5}m" | "\u{b5}" => Unit::Micrometre,
            "nm" => Unit::Nanometre,
            "angstrom" | "angstroms" | "\u{e5}" => Unit::Angstrom,
            "mm" => Unit::Millimetre,
            "m" | "meter" | "meters" | "metre" | "metres" => Unit::Metre,
            "thz" | "terahertz" => Unit::Terahertz,
            "ev" => Unit::Electronvolt,
            word if starts(word, &["micromet", "micron", "mikromet", "mikron"]) => Unit::Micrometre,
            word if starts(word, &["nanomet"]) => Unit::Nanometre,
            word if starts(word, &["millimet"]) => Unit::Millimetre,
            _ => return None,
        })
    }
}
