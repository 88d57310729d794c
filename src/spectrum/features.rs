//! The features of an emissivity curve, searched where its mineral has them. Those of quartz tell
//! covered grains from bare ones.
//!
//! A feature is `None` if its search window is outside the curve's range, or has no extremum
//! between its ends. Grey materials have no extrema. Extrema are samples, without interpolation.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::{Spectrum, crystal};
use crate::support::linear::interpolate;

/// Where a mineral has its features: the windows in which they are searched, um. A file of optical
/// constants holds them.
///
/// Crystalline quartz has its extrema at 7.35; 8.50, 8.63 and 8.94; 12.5, 12.65 and 12.8. Cover by
/// fines moves the troughs near 8.5 and 8.9 outwards: to 8.18 and 9.24 for fines alone.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Windows {
    /// The mineral's name.
    pub mineral: String,
    /// The Christiansen maximum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub christiansen_um: Option<[f64; 2]>,
    /// The reststrahlen doublet: trough, peak, trough.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reststrahlen_um: Option<[[f64; 2]; 3]>,
    /// The doublet of quartz near 12 um: trough, peak, trough.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doublet_12_um: Option<[[f64; 2]; 3]>,
    /// Single troughs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub troughs_um: Vec<[f64; 2]>,
    /// What charts shade, by its name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub shaded_um: BTreeMap<String, [f64; 2]>,
}

impl Windows {
    /// Those of quartz.
    pub fn quartz() -> &'static Self {
        let quartz = crystal("quartz").expect("shipped");
        quartz.features.as_ref().expect("a test reads them")
    }

    /// None: of a crystal whose file states no features.
    pub(super) fn none() -> &'static Self {
        static NONE: LazyLock<Windows> = LazyLock::new(Windows::default);
        &NONE
    }

    /// Those of the first spectrum that is known to be of a mineral; of quartz where none is.
    pub fn of<'a>(spectra: impl IntoIterator<Item = &'a Spectrum>) -> &'a Self {
        spectra.into_iter().find_map(Spectrum::windows).unwrap_or_else(|| Self::quartz())
    }

    /// What is wrong with them, if anything is.
    pub(in crate::spectrum) fn problem(&self) -> Option<String> {
        let doublets = self.reststrahlen_um.iter().chain(&self.doublet_12_um).flatten();
        let windows = self.christiansen_um.iter().chain(doublets).chain(&self.troughs_um);
        let wrong = |[from, to]: &&[f64; 2]| !(*from > 0.0 && from < to && to.is_finite());
        let wrong = windows.chain(self.shaded_um.values()).find(wrong);
        wrong.map(|[from, to]| format!("features: {from} to {to} um is not a window"))
    }
}

/// The window of the reststrahlen bands, um: cover by fines raises the emissivity there.
pub const RESTSTRAHLEN_WINDOW_UM: RangeInclusive<f64> = 8.0..=9.5;
/// The window of volume scattering, um: cover by fines lowers the emissivity there.
pub const TRANSPARENCY_WINDOW_UM: RangeInclusive<f64> = 10.0..=12.0;

/// Least height of an extremum above both ends of its window. It is above the rounding of files
/// with six digits and below the faintest Christiansen maximum (2e-4).
const PROMINENCE: f64 = 1e-5;

/// One sample of the curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Extremum {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Emissivity, 0 to 1.
    pub emissivity: f64,
}

/// Two troughs and the peak between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Doublet {
    /// The trough at the shorter wavelength.
    pub short_trough: Extremum,
    /// The maximum between the troughs.
    pub peak: Extremum,
    /// The trough at the longer wavelength.
    pub long_trough: Extremum,
    /// Emissivity of the peak less the mean of the two troughs.
    pub contrast: f64,
}

/// Earlier results were searched where quartz has its features.
#[allow(clippy::unnecessary_wraps, reason = "serde takes a default of the field's type")]
fn quartz() -> Option<String> {
    Some("quartz".into())
}

/// The features of one curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Features {
    /// The mineral in whose windows features were searched; `None` if its file states none.
    #[serde(default = "quartz")]
    pub mineral: Option<String>,
    /// The Christiansen maximum, that of quartz between 7.2 and 7.6 um; `None` if the curve only
    /// rises or falls there, like one that begins at 7.5 um.
    pub christiansen: Option<Extremum>,
    /// The reststrahlen doublet of quartz, 8 to 9.5 um.
    pub reststrahlen: Option<Doublet>,
    /// The doublet of quartz at 12.5 and 12.8 um.
    pub doublet_12_um: Option<Doublet>,
    /// Single troughs of other minerals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub troughs: Vec<Extremum>,
    /// Mean emissivity over 8 to 9.5 um.
    pub mean_8_to_9p5_um: Option<f64>,
    /// Mean emissivity over 10 to 12 um.
    pub mean_10_to_12_um: Option<f64>,
}

impl Features {
    /// All extrema, by wavelength.
    pub fn extrema(&self) -> impl Iterator<Item = Extremum> {
        let doublet = |d: Option<Doublet>| {
            d.into_iter().flat_map(|d| [d.short_trough, d.peak, d.long_trough])
        };
        self.christiansen
            .into_iter()
            .chain(doublet(self.reststrahlen))
            .chain(doublet(self.doublet_12_um))
            .chain(self.troughs.iter().copied())
    }
}

/// Finds the features of a curve in the windows of its mineral.
///
/// The wavelengths must ascend and be as many as the emissivities; all numbers must be finite.
/// Otherwise the result means nothing.
pub fn features(wavelength_um: &[f64], emissivity: &[f64], windows: &Windows) -> Features {
    debug_assert_eq!(wavelength_um.len(), emissivity.len());
    debug_assert!(wavelength_um.is_sorted());
    let curve = Curve { wavelength_um, emissivity };
    Features {
        mineral: (!windows.mineral.is_empty()).then(|| windows.mineral.clone()),
        christiansen: windows.christiansen_um.and_then(|window| curve.extremum(window, 1.0)),
        reststrahlen: windows.reststrahlen_um.and_then(|of| curve.doublet(of)),
        doublet_12_um: windows.doublet_12_um.and_then(|of| curve.doublet(of)),
        troughs: windows.troughs_um.iter().filter_map(|at| curve.extremum(*at, -1.0)).collect(),
        mean_8_to_9p5_um: curve.mean(&RESTSTRAHLEN_WINDOW_UM),
        mean_10_to_12_um: curve.mean(&TRANSPARENCY_WINDOW_UM),
    }
}

/// The mean of a curve over a window, um; `None` where the curve does not cover it with three
/// samples.
pub fn window_mean(um: &[f64], values: &[f64], window_um: &RangeInclusive<f64>) -> Option<f64> {
    Curve { wavelength_um: um, emissivity: values }.mean(window_um)
}

#[derive(Clone, Copy)]
struct Curve<'a> {
    wavelength_um: &'a [f64],
    emissivity: &'a [f64],
}

impl Curve<'_> {
    /// The samples within a window, its ends included whatever their rounding.
    fn within(self, window_um: &RangeInclusive<f64>) -> Self {
        let first = self.wavelength_um.partition_point(|&w| w < window_um.start() - 1e-9);
        let end = self.wavelength_um.partition_point(|&w| w <= window_um.end() + 1e-9);
        Self {
            wavelength_um: &self.wavelength_um[first..end],
            emissivity: &self.emissivity[first..end],
        }
    }

    /// The window's highest sample (`sign` 1) or lowest (-1), unless it is the end of a slope.
    fn extremum(self, [from, to]: [f64; 2], sign: f64) -> Option<Extremum> {
        let Self { wavelength_um, emissivity } = self.within(&(from..=to));
        let height = |i: usize| sign * emissivity[i];
        // The first of equals: a reflectance rounded to 0 gives several samples of 1.
        let top = (0..emissivity.len()).min_by(|&i, &j| height(j).total_cmp(&height(i)))?;
        let stands_out = |end: usize| height(top) - height(end) > PROMINENCE;
        (stands_out(0) && stands_out(emissivity.len() - 1))
            .then(|| Extremum { wavelength_um: wavelength_um[top], emissivity: emissivity[top] })
    }

    fn doublet(self, [short, middle, long]: [[f64; 2]; 3]) -> Option<Doublet> {
        let [short_trough, long_trough] = [self.extremum(short, -1.0)?, self.extremum(long, -1.0)?];
        let peak = self.extremum(middle, 1.0)?;
        let in_order = short_trough.wavelength_um < peak.wavelength_um
            && peak.wavelength_um < long_trough.wavelength_um
            && peak.emissivity > short_trough.emissivity.max(long_trough.emissivity);
        let contrast = peak.emissivity - 0.5 * (short_trough.emissivity + long_trough.emissivity);
        in_order.then_some(Doublet { short_trough, peak, long_trough, contrast })
    }

    /// The mean over a window that the curve covers with three samples or more, by trapezia. Steps
    /// may differ, and the window's ends need not be samples.
    fn mean(self, window_um: &RangeInclusive<f64>) -> Option<f64> {
        let (start, end) = (*window_um.start(), *window_um.end());
        let inside = self.within(window_um).wavelength_um;
        let (first, last) = (self.wavelength_um.first()?, self.wavelength_um.last()?);
        if first - 1e-9 > start || last + 1e-9 < end || inside.len() < 3 {
            return None;
        }
        let um: Vec<f64> = [start].iter().chain(inside).chain(&[end]).copied().collect();
        let at = |um| interpolate(self.wavelength_um, self.emissivity, um);
        let areas = um.windows(2).map(|w| 0.5 * (at(w[0]) + at(w[1])) * (w[1] - w[0]));
        Some(areas.sum::<f64>() / (end - start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(from_um: f64, to_um: f64) -> Vec<f64> {
        let steps = ((to_um - from_um) / 0.01).round() as usize;
        (0..=steps).map(|i| from_um + 0.01 * i as f64).collect()
    }

    /// Quartz-like: a slope up to 7.35 um, Gaussian bands of the given centre, width and depth.
    fn quartz(wavelength_um: f64) -> f64 {
        let bands = [(8.48, 0.10, 0.4), (8.97, 0.18, 0.5), (12.5, 0.06, 0.10), (12.8, 0.06, 0.08)];
        let loss: f64 = bands
            .map(|(centre, width, depth)| {
                depth * (-0.5 * ((wavelength_um - centre) / width).powi(2)).exp()
            })
            .iter()
            .sum();
        0.99 - 0.02 * (wavelength_um - 7.35).abs().min(1.0) - loss
    }

    fn features_of(from_um: f64, to_um: f64, curve: impl Fn(f64) -> f64) -> Features {
        let wavelength_um = grid(from_um, to_um);
        let emissivity: Vec<f64> = wavelength_um.iter().map(|&w| curve(w)).collect();
        features(&wavelength_um, &emissivity, Windows::quartz())
    }

    #[test]
    fn finds_every_feature_where_the_curve_was_given_it() {
        let found = features_of(7.0, 14.0, quartz);
        let expected = [7.35, 8.48, 8.65, 8.97, 12.5, 12.65, 12.8];
        let at: Vec<f64> = found.extrema().map(|e| e.wavelength_um).collect();
        assert_eq!(at.len(), expected.len(), "{at:?}");
        for (found, expected) in at.iter().zip(expected) {
            assert!((found - expected).abs() < 0.025, "{found} is not near {expected}");
        }
        for e in found.extrema() {
            assert!((e.emissivity - quartz(e.wavelength_um)).abs() < 1e-15);
        }
        let bands = found.reststrahlen.unwrap();
        let troughs =
            quartz(bands.short_trough.wavelength_um) + quartz(bands.long_trough.wavelength_um);
        assert!((bands.contrast - (bands.peak.emissivity - 0.5 * troughs)).abs() < 1e-12);
        assert!(bands.contrast > 0.1);
    }

    #[test]
    fn christiansen_needs_a_maximum_not_an_edge() {
        assert!(features_of(7.3, 14.0, quartz).christiansen.is_some());
        assert!(features_of(7.5, 14.0, quartz).christiansen.is_none());
        assert!(features_of(7.0, 14.0, |w| 0.9 + 0.01 * (w - 7.0)).christiansen.is_none());
    }

    #[test]
    fn grey_and_sloping_curves_have_means_only() {
        for curve in [|_| 0.8, |w: f64| 0.05 * w, |w: f64| 1.0 - 0.05 * w] {
            let found = features_of(7.0, 14.0, curve);
            assert_eq!(found.extrema().count(), 0);
            assert!((found.mean_8_to_9p5_um.unwrap() - curve(8.75)).abs() < 1e-12);
            assert!((found.mean_10_to_12_um.unwrap() - curve(11.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn means_are_exact_with_uneven_steps() {
        let wavelength_um = [7.0, 7.9, 8.1, 9.0, 9.4, 11.0];
        let emissivity = wavelength_um.map(|w| 0.1 * w);
        let found = features(&wavelength_um, &emissivity, Windows::quartz());
        assert!((found.mean_8_to_9p5_um.unwrap() - 0.875).abs() < 1e-12);
        assert_eq!(found.mean_10_to_12_um, None);
    }

    #[test]
    fn short_curves_and_half_a_doublet_have_no_features() {
        let nothing = features(&[], &[], Windows::quartz());
        for found in [
            features(&[8.6], &[0.5], Windows::quartz()),
            features(&[7.0, 14.0], &[0.5, 0.6], Windows::quartz()),
            features_of(9.0, 9.4, quartz),
        ] {
            assert_eq!(found, nothing);
        }
        assert!(nothing.extrema().count() == 0 && nothing.mean_8_to_9p5_um.is_none());
        let one_trough = features_of(7.0, 14.0, |w| 0.9 - 0.3 * (-(w - 9.0).powi(2) / 0.1).exp());
        assert_eq!(one_trough.reststrahlen, None);
    }
}
