//! Facets of several kinds of patches, mixed by area.

use super::{Spectrum, SpectrumError, Warning};
use crate::support::statistics::SHARES_ROUNDING;

/// Patches of several kinds on each facet.
///
/// Each hit lands on a kind with the probability of its share of the area, whatever the hits before
/// it. So the facet reflects the mean by area, and the mean over paths is exact. It holds where the
/// patches are small against a facet, and where all reflect a path in the same directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Mix {
    name: String,
    components: Vec<(f64, Spectrum)>,
}

impl Mix {
    /// A mix of spectra, each with its share of the area.
    pub fn new(components: Vec<(f64, Spectrum)>) -> Self {
        let names = components.iter().map(|(share, spectrum)| match spectrum {
            Spectrum::Constant(value) => format!("{share} constant {value}"),
            _ => format!("{share} {}", spectrum.name()),
        });
        Self { name: names.collect::<Vec<_>>().join(" + "), components }
    }

    /// Shares and names of the components.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The spectra, each with its share of the area.
    pub fn components(&self) -> &[(f64, Spectrum)] {
        &self.components
    }

    pub(super) fn into_components(self) -> Vec<(f64, Spectrum)> {
        self.components
    }

    /// The mean by area of a number that each spectrum has.
    pub(super) fn mean(
        &self,
        of: impl Fn(&Spectrum) -> Result<f64, SpectrumError>,
    ) -> Result<f64, SpectrumError> {
        self.components
            .iter()
            .try_fold(0.0, |sum, (share, spectrum)| Ok(sum + share * of(spectrum)?))
    }

    /// The range that all components have, um; `None` if all are unbounded.
    pub(super) fn range_um(&self) -> Option<[f64; 2]> {
        let ranges = self.components.iter().filter_map(|(_, spectrum)| spectrum.range_um());
        ranges.reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])])
    }

    pub(super) fn warnings(&self) -> Vec<&Warning> {
        self.components.iter().flat_map(|(_, spectrum)| spectrum.warnings()).collect()
    }

    /// Why it is not a valid mix, if it is not: its table may be of another origin.
    pub(super) fn problem(&self) -> Option<String> {
        let shares = || self.components.iter().map(|(share, _)| *share);
        if !shares().all(|share| share > 0.0)
            || (shares().sum::<f64>() - 1.0).abs() > SHARES_ROUNDING
        {
            return Some(format!("the shares of the mix {} do not add up to 1", self.name));
        }
        let is_lambertian =
            |spectrum: &Spectrum| !spectrum.is_angular() && !matches!(spectrum, Spectrum::Mix(_));
        if !self.components.iter().all(|(_, spectrum)| is_lambertian(spectrum)) {
            return Some(format!("a component of the mix {} is not Lambertian", self.name));
        }
        self.components.iter().find_map(|(_, spectrum)| spectrum.problem())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mix() -> Spectrum {
        let fine = Spectrum::builtin("quartz_fine").expect("shipped");
        Spectrum::Mix(Mix::new(vec![(0.25, fine), (0.75, Spectrum::Constant(0.9))]))
    }

    #[test]
    fn a_mix_has_the_mean_emissivity_by_area_and_the_range_of_all_its_components() {
        let (mix, fine) = (mix(), Spectrum::builtin("quartz_fine").expect("shipped"));
        let of = |spectrum: &Spectrum| spectrum.emissivity(9.0).expect("in range");
        assert!((of(&mix) - 0.25 * of(&fine) - 0.75 * 0.9).abs() < 1e-15);
        assert!((mix.reflectance_at(9.0, 0.1).expect("in range") + of(&mix) - 1.0).abs() < 1e-15);
        assert_eq!(mix.range_um(), fine.range_um());
        assert!(mix.emissivity(14.5).is_err() && mix.covers([8.0, 14.5]).is_err());
        assert!(mix.covers([8.0, 14.0]).is_ok() && !mix.is_angular());
        assert_eq!(mix.name(), "0.25 quartz_fine + 0.75 constant 0.9");
        let error = |of: &Spectrum| of.error(9.0).expect("in range");
        assert!((error(&mix) - 0.25 * error(&fine)).abs() < 1e-15);
    }

    #[test]
    fn a_wrong_mix_is_found() {
        assert_eq!(mix().problem(), None);
        let of = |components| Spectrum::Mix(Mix::new(components)).problem();
        let grey = || Spectrum::Constant(0.5);
        assert!(of(vec![(0.5, grey()), (0.4, grey())]).expect("wrong").contains("add up to 1"));
        assert!(of(vec![(1.5, grey()), (-0.5, grey())]).is_some());
        assert!(of(vec![(1.0, Spectrum::Constant(1.5))]).is_some());
        let mirror = Spectrum::fresnel("quartz").expect("shipped");
        assert!(of(vec![(1.0, mirror)]).expect("wrong").contains("Lambertian"));
    }
}
