//! The sensor of a scene file: what `soilsig image` needs to know beyond the direction of the view.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FARTHEST_UM;
use super::check::{Checked, need, positive};

/// Most pixels along a side of the focal plane.
const MOST_PIXELS: u32 = 16_384;

/// An imaging sensor. Where it stands is the scene's `view`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Pixels of the focal plane: columns and lines.
    pub pixels: [u32; 2],
    /// What the focal plane sees; without it, by parallel rays, the domain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optics: Option<Optics>,
    /// Spectral bands; without them the radiance at each wavelength that is asked for on the command line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bands: Option<Vec<SensorBands>>,
    /// Noise of the detectors; without it there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
}

/// How rays come to the focal plane. The line of sight goes through the middle of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Optics {
    /// Parallel rays across a rectangle at right angles to the line of sight.
    Orthographic {
        /// Its width, um; pixels are square.
        width_um: f64,
    },
    /// Rays through one point.
    Pinhole {
        /// Distance of that point from the middle of the domain, um.
        distance_um: f64,
        /// Angle between the left and the right edge of the view, degrees; pixels are square.
        field_of_view_deg: f64,
    },
}

/// One or more spectral bands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SensorBands {
    /// A band that responds alike within its width and not at all outside; of no width, at one wavelength.
    Box {
        /// Middle, um.
        centre_um: f64,
        /// Full width, um.
        width_um: f64,
    },
    /// A band with a Gaussian response.
    Gaussian {
        /// Middle, um.
        centre_um: f64,
        /// Full width at half maximum, um.
        fwhm_um: f64,
    },
    /// A band whose response is in a file of two columns, wavelength in um and response from 0 to 1; relative to the scene
    /// file.
    File(PathBuf),
    /// Gaussian bands at equal distances.
    Grid {
        /// Middle of the first band, um.
        from_um: f64,
        /// Middle of the last band, um.
        to_um: f64,
        /// Distance of their middles, um.
        step_um: f64,
        /// Full width at half maximum of each, um.
        fwhm_um: f64,
    },
}

/// Noise of the detectors, independent in each pixel and band, with a normal distribution. Either as radiance or as
/// temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Noise-equivalent radiance (NEdL), one standard deviation, W m-2 sr-1 um-1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nedl_w_m2_sr_um: Option<f64>,
    /// Noise-equivalent temperature difference (NEdT) of a black body at the scene's temperature, K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nedt_k: Option<f64>,
    /// Seed of the noise.
    pub seed: u64,
}

impl Sensor {
    /// What is wrong with it.
    pub(super) fn check(&self) -> Checked {
        need(
            self.pixels.iter().all(|side| (1..=MOST_PIXELS).contains(side)),
            "sensor.pixels",
            || format!("{:?} are not within 1 to {MOST_PIXELS} a side", self.pixels),
        )?;
        let length = |um: f64, place: &str| {
            need(um > 0.0 && um <= FARTHEST_UM, place, || {
                format!("{um} um is not above 0 and at most {FARTHEST_UM:e}")
            })
        };
        match self.optics {
            None => {}
            Some(Optics::Orthographic { width_um }) => {
                length(width_um, "sensor.optics.orthographic.width_um")?;
            }
            Some(Optics::Pinhole { distance_um, field_of_view_deg }) => {
                length(distance_um, "sensor.optics.pinhole.distance_um")?;
                need(
                    field_of_view_deg > 0.0 && field_of_view_deg <= 120.0,
                    "sensor.optics.pinhole.field_of_view_deg",
                    || format!("{field_of_view_deg} is not above 0 and at most 120"),
                )?;
            }
        }
        if let Some(bands) = &self.bands {
            need(!bands.is_empty(), "sensor.bands", || {
                "the list is empty: leave it out to have the wavelengths of the command line".into()
            })?;
            for (i, band) in bands.iter().enumerate() {
                let at = |key: &str| format!("sensor.bands[{i}].{key}");
                match *band {
                    SensorBands::Box { centre_um, width_um } => {
                        positive(centre_um, &at("box.centre_um"))?;
                        need(width_um >= 0.0 && width_um < centre_um, &at("box.width_um"), || {
                            format!("{width_um} is not at least 0 and below its middle")
                        })?;
                    }
                    SensorBands::Gaussian { centre_um, fwhm_um } => {
                        positive(centre_um, &at("gaussian.centre_um"))?;
                        positive(fwhm_um, &at("gaussian.fwhm_um"))?;
                    }
                    SensorBands::File(_) => {}
                    SensorBands::Grid { from_um, to_um, step_um, fwhm_um } => {
                        crate::scene::Grid::new(from_um, to_um, step_um)
                            .map_err(|problem| (at("grid"), problem))?;
                        positive(fwhm_um, &at("grid.fwhm_um"))?;
                    }
                }
            }
        }
        let Some(noise) = self.noise else { return Ok(()) };
        need(noise.nedl_w_m2_sr_um.is_some() != noise.nedt_k.is_some(), "sensor.noise", || {
            "give one of nedl_w_m2_sr_um and nedt_k".into()
        })?;
        let level = noise.nedl_w_m2_sr_um.or(noise.nedt_k).unwrap_or_default();
        need(level.is_finite() && level >= 0.0, "sensor.noise", || {
            format!("{level} is not a number of at least 0")
        })
    }
}
