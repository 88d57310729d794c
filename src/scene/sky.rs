//! The sky of a scene file.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::temperature;

/// Temperature of the sky.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Sky {
    /// The same in all directions, kelvin.
    Isotropic(f64),
    /// By zenith angle: points in ascending order from 0 to 90 degrees, with straight lines between them.
    ByZenith(Vec<SkyPoint>),
}

/// Temperature of the sky at a zenith angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkyPoint {
    /// Angle from the vertical, degrees.
    pub zenith_deg: f64,
    /// Temperature, kelvin.
    pub temperature_k: f64,
}

/// A CSV file with the radiance of the sky by wavelength, relative to the scene file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SkyRadiance {
    /// The same in all directions: columns `wavelength_um` and `l_downwelling_w_m2_sr_um`.
    Isotropic(PathBuf),
    /// By zenith angle: a column `zenith_deg` besides, from 0 to 90.
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
    /// The temperature at a zenith angle from 0 to 90 degrees.
    pub fn temperature_k(&self, zenith_deg: f64) -> f64 {
        match self {
            Self::Isotropic(kelvin) => *kelvin,
            Self::ByZenith(points) => {
                let above = points
                    .partition_point(|p| p.zenith_deg < zenith_deg)
                    .clamp(1, points.len() - 1);
                let [a, b] = [points[above - 1], points[above]];
                let share = (zenith_deg - a.zenith_deg) / (b.zenith_deg - a.zenith_deg);
                a.temperature_k + share * (b.temperature_k - a.temperature_k)
            }
        }
    }

    /// What is wrong with it, if anything is.
    pub fn problem(&self) -> Option<String> {
        let bad = |kelvin: &f64| temperature(*kelvin, "").err().map(|(_, problem)| problem);
        match self {
            Self::Isotropic(kelvin) => bad(kelvin),
            Self::ByZenith(points) => {
                let zeniths: Vec<f64> = points.iter().map(|p| p.zenith_deg).collect();
                let whole = zeniths.first() == Some(&0.0) && zeniths.last() == Some(&90.0);
                if !whole || !zeniths.is_sorted_by(|a, b| a < b) {
                    return Some("the zenith angles do not ascend from 0 to 90 degrees".into());
                }
                points.iter().find_map(|p| bad(&p.temperature_k))
            }
        }
    }
}
