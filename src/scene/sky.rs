//! The sky of a scene file.

use std::path::PathBuf;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::temperature;
use crate::support::linear::locate;

/// Temperature of the sky, K, 1 to 10000: one number, or a list by zenith angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(
    untagged,
    expecting = "sky_temperature_k is a number, or a list of {\"zenith_deg\": degrees, \"temperature_k\": K}"
)]
pub enum Sky {
    /// The same temperature in all directions, K.
    Isotropic(f64),
    /// Temperature by zenith angle, ascending from 0 to 90 degrees, linear between the points.
    ByZenith(Vec<SkyPoint>),
}

/// Temperature of the sky at a zenith angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SkyPoint {
    /// Angle from the vertical, degrees, 0 to 90.
    pub zenith_deg: f64,
    /// Temperature there, K, 1 to 10000.
    pub temperature_k: f64,
}

/// A CSV file with the radiance of the sky by wavelength, relative to the scene file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SkyRadiance {
    /// The same radiance in all directions: columns `wavelength_um` and
    /// `l_downwelling_w_m2_sr_um`.
    Isotropic(PathBuf),
    /// Radiance by zenith angle: also a column `zenith_deg`, from 0 to 90.
    ByZenith(PathBuf),
}

impl SkyRadiance {
    /// The file.
    pub fn file(&self) -> &PathBuf {
        match self {
            Self::Isotropic(file) | Self::ByZenith(file) => file,
        }
    }

    pub(super) fn file_mut(&mut self) -> &mut PathBuf {
        match self {
            Self::Isotropic(file) | Self::ByZenith(file) => file,
        }
    }
}

impl Sky {
    /// The temperature at a zenith angle from 0 to 90 degrees, K.
    pub fn temperature_k(&self, zenith_deg: f64) -> f64 {
        match self {
            Self::Isotropic(kelvin) => *kelvin,
            Self::ByZenith(points) => locate(points, |point| point.zenith_deg, zenith_deg)
                .value(|i| points[i].temperature_k),
        }
    }

    /// What is wrong with it, if anything.
    pub fn problem(&self) -> Option<String> {
        let bad = |kelvin: f64| temperature(kelvin, "").err().map(|(_, problem)| problem);
        match self {
            Self::Isotropic(kelvin) => bad(*kelvin),
            Self::ByZenith(points) => {
                let zenith = |point: Option<&SkyPoint>| point.map(|point| point.zenith_deg);
                let ascends = points.is_sorted_by(|a, b| a.zenith_deg < b.zenith_deg);
                if !ascends
                    || zenith(points.first()) != Some(0.0)
                    || zenith(points.last()) != Some(90.0)
                {
                    return Some("the zenith angles do not ascend from 0 to 90 degrees".into());
                }
                points.iter().find_map(|point| bad(point.temperature_k))
            }
        }
    }
}
