//! The sensor of a scene file, for `soilsig image`.

use std::path::PathBuf;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FARTHEST_UM;
use super::check::{Checked, need, positive};
use super::grid::WAVELENGTHS_UM;

/// Most pixels along a side of the focal plane.
const MOST_PIXELS: u32 = 16_384;

/// An imaging sensor. The scene's `view` gives its direction.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Columns and lines of the focal plane, 1 to 16384 each.
    pub pixels: [u32; 2],
    /// How rays reach the focal plane. Default: parallel rays across the domain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optics: Option<Optics>,
    /// Spectral bands, at least one. Default: the single wavelengths of the command line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bands: Option<Vec<SensorBands>>,
    /// Noise of the detectors. Default: no noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
}

/// How rays reach the focal plane. The line of sight goes through the centre of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Optics {
    /// Parallel rays across a rectangle perpendicular to the line of sight.
    Orthographic {
        /// Width of the rectangle, um, above 0 to 1e9. Pixels are square.
        width_um: f64,
    },
    /// Rays through one point, the pinhole.
    Pinhole {
        /// Distance of the pinhole from the centre of the domain, um, above 0 to 1e9. It must be
        /// above the bed.
        distance_um: f64,
        /// Angle from the left to the right edge of the view, degrees, above 0 to 120. Pixels are
        /// square.
        field_of_view_deg: f64,
    },
}

/// One or more spectral bands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SensorBands {
    /// A band with a constant response within its width. With width 0 it is one wavelength.
    Box {
        /// Centre, um. The band must be within 0.01 to 10000 um.
        centre_um: f64,
        /// Full width, um, from 0 to below the centre.
        width_um: f64,
    },
    /// A band with a Gaussian response.
    Gaussian {
        /// Centre, um.
        centre_um: f64,
        /// Full width at half maximum, um, above 0. The response is followed to 1.83 times this on
        /// either side, which must be within 0.01 to 10000 um.
        fwhm_um: f64,
    },
    /// A band with its response in a file, relative to the scene file. The columns are wavelength
    /// (um) and response (0 to 1).
    File(PathBuf),
    /// Equally spaced Gaussian bands.
    Grid {
        /// Centre of the first band, um, from 0.01.
        from_um: f64,
        /// Centre of the last band, um, up to 10000.
        to_um: f64,
        /// Distance between the centres, um, from 1e-6.
        step_um: f64,
        /// Full width at half maximum of each band, um, above 0.
        fwhm_um: f64,
    },
}

/// Normally distributed noise of the detectors, independent in each pixel and band. It is given as
/// a radiance or as a temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Noise-equivalent radiance (NEdL): one standard deviation, W m-2 sr-1 um-1, 0 or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nedl_w_m2_sr_um: Option<f64>,
    /// Noise-equivalent temperature difference (NEdT) of a black body at the scene's temperature,
    /// K, 0 or more. Give this or `nedl_w_m2_sr_um`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nedt_k: Option<f64>,
    /// Random seed of the noise, 0 to 2^64 - 1.
    pub seed: u64,
}

/// A Gaussian response falls to 1e-4 of its maximum at so many of its full widths from the centre.
const GAUSSIAN_REACH: f64 = 1.823;

/// Checks that bands from a first to a last centre reach no farther than wavelengths may.
fn within_wavelengths([first, last]: [f64; 2], half_um: f64, at: &str) -> Checked {
    let [from, to] = [first - half_um, last + half_um];
    let [least, most] = WAVELENGTHS_UM;
    need(from >= least && to <= most, at, || {
        format!("the response reaches from {from} to {to} um, beyond {least} to {most} um")
    })
}

impl Sensor {
    pub(super) fn check(&self) -> Checked {
        need(
            self.pixels.iter().all(|side| (1..=MOST_PIXELS).contains(side)),
            "sensor.pixels",
            || format!("{:?} are not within 1 to {MOST_PIXELS} a side", self.pixels),
        )?;
        let up_to = |most: f64, value: f64, key: &str| {
            need(value > 0.0 && value <= most, &format!("sensor.optics.{key}"), || {
                format!("{value} is not above 0 and at most {most}")
            })
        };
        match self.optics {
            None => {}
            Some(Optics::Orthographic { width_um }) => {
                up_to(FARTHEST_UM, width_um, "orthographic.width_um")?;
            }
            Some(Optics::Pinhole { distance_um, field_of_view_deg }) => {
                up_to(FARTHEST_UM, distance_um, "pinhole.distance_um")?;
                up_to(120.0, field_of_view_deg, "pinhole.field_of_view_deg")?;
            }
        }
        if let Some(bands) = &self.bands {
            need(!bands.is_empty(), "sensor.bands", || {
                "the list is empty: leave it out to use the wavelengths of the command line".into()
            })?;
            for (i, band) in bands.iter().enumerate() {
                let at = |key: &str| format!("sensor.bands[{i}].{key}");
                match *band {
                    SensorBands::Box { centre_um, width_um } => {
                        positive(centre_um, &at("box.centre_um"))?;
                        need(width_um >= 0.0 && width_um < centre_um, &at("box.width_um"), || {
                            format!("{width_um} is not from 0 to below the centre")
                        })?;
                        within_wavelengths([centre_um; 2], width_um / 2.0, &at("box"))?;
                    }
                    SensorBands::Gaussian { centre_um, fwhm_um } => {
                        positive(centre_um, &at("gaussian.centre_um"))?;
                        positive(fwhm_um, &at("gaussian.fwhm_um"))?;
                        let half_um = GAUSSIAN_REACH * fwhm_um;
                        within_wavelengths([centre_um; 2], half_um, &at("gaussian"))?;
                    }
                    SensorBands::File(_) => {}
                    SensorBands::Grid { from_um, to_um, step_um, fwhm_um } => {
                        crate::scene::Grid::new(from_um, to_um, step_um)
                            .map_err(|problem| (at("grid"), problem))?;
                        positive(fwhm_um, &at("grid.fwhm_um"))?;
                        let half_um = GAUSSIAN_REACH * fwhm_um;
                        within_wavelengths([from_um, to_um], half_um, &at("grid"))?;
                    }
                }
            }
        }
        let Some(noise) = self.noise else { return Ok(()) };
        need(noise.nedl_w_m2_sr_um.is_some() != noise.nedt_k.is_some(), "sensor.noise", || {
            "give either nedl_w_m2_sr_um or nedt_k".into()
        })?;
        let level = noise.nedl_w_m2_sr_um.or(noise.nedt_k).unwrap_or_default();
        need(level.is_finite() && level >= 0.0, "sensor.noise", || {
            format!("{level} is not a finite number of 0 or more")
        })
    }
}
