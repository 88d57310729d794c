//! Warm and cold layers: the temperature of facets by depth, and by the sun.

use std::fmt;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::check::{Checked, need, temperature, within};

/// Temperature of all materials without their own: one number, K, 1 to 10000, or layers.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum SceneTemperature {
    /// The same everywhere, K, 1 to 10000.
    Same(f64),
    /// By depth, and by the sun.
    Layers(Layers),
}

/// Temperature by depth below the highest point of the bed, and by the sun.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// Temperatures by depth, ascending, 1 to 1000, with straight lines between. Above the first and
    /// below the last point the temperature is theirs. A skin and a gradient are two points.
    pub depths: Vec<Depth>,
    /// The sun warms what it shines on. Default: no sun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun: Option<Sun>,
}

/// Temperature at a depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Depth {
    /// Depth below the highest point of the bed, um, 0 or more.
    pub depth_um: f64,
    /// Temperature there, K, 1 to 10000.
    pub temperature_k: f64,
}

/// The direction to the sun, and what it does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// Angle from the vertical, degrees, 0 to 89.9.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 89.9)))]
    pub zenith_deg: f64,
    /// Azimuth of the sun, from +x towards +y, degrees. Default: 0.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// By how much places that the sun reaches are warmer than others at their depth, K; below 0
    /// they are colder.
    pub warmer_k: f64,
}

/// Bins of depth: one above the first point, one below the last, and equal ones between.
const DEPTHS: u16 = 32;

/// Most materials where there are layers: a symbol of material, layer and cosine has 16 bits.
const MOST_MATERIALS: usize = 16;

/// Coordinates of meshes are rounded by so much, um.
const ROUNDING_UM: f64 = 1e-3;

/// Most points of depth.
const MOST_DEPTHS: usize = 1000;

impl<'de> Deserialize<'de> for SceneTemperature {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = SceneTemperature;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a temperature in K, or layers: an object with depths")
            }
            fn visit_f64<E>(self, kelvin: f64) -> Result<Self::Value, E> {
                Ok(SceneTemperature::Same(kelvin))
            }
            fn visit_u64<E>(self, kelvin: u64) -> Result<Self::Value, E> {
                Ok(SceneTemperature::Same(kelvin as f64))
            }
            fn visit_i64<E>(self, kelvin: i64) -> Result<Self::Value, E> {
                Ok(SceneTemperature::Same(kelvin as f64))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                Layers::deserialize(MapAccessDeserializer::new(map)).map(SceneTemperature::Layers)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl SceneTemperature {
    /// The temperature that Eq. 2 and charts take, K: of layers that of the first depth in shade.
    pub fn kelvin(&self) -> f64 {
        match self {
            Self::Same(kelvin) => *kelvin,
            Self::Layers(layers) => layers.depths[0].temperature_k,
        }
    }

    /// The layers, if they differ in temperature.
    pub fn layers(&self) -> Option<&Layers> {
        match self {
            Self::Layers(layers) if layers.count() > 1 => Some(layers),
            Self::Same(_) | Self::Layers(_) => None,
        }
    }

    pub(super) fn check(&self, materials: usize) -> Checked {
        match self {
            Self::Same(kelvin) => temperature(*kelvin, "temperature_k"),
            Self::Layers(layers) => {
                if let Some((place, problem)) = layers.problem() {
                    return Err((format!("temperature_k.{place}"), problem));
                }
                let fits = layers.count() == 1 || materials <= MOST_MATERIALS;
                need(fits, "temperature_k", || {
                    format!("layers take at most {MOST_MATERIALS} materials, not {materials}")
                })
            }
        }
    }
}

impl Layers {
    /// What is wrong with them and where, if anything is.
    pub fn problem(&self) -> Option<(String, String)> {
        self.check().err()
    }

    fn check(&self) -> Checked {
        within(self.depths.len(), 1..=MOST_DEPTHS, "depths")?;
        for (i, of) in self.depths.iter().enumerate() {
            let place = format!("depths[{i}]");
            need(of.depth_um.is_finite() && of.depth_um >= 0.0, &place, || {
                format!("a depth of {} um is not 0 or more", of.depth_um)
            })?;
            temperature(of.temperature_k, &place)?;
        }
        let ascends = self.depths.is_sorted_by(|a, b| a.depth_um < b.depth_um);
        need(ascends, "depths", || "the depths do not ascend".into())?;
        if let Some(sun) = &self.sun {
            within(sun.zenith_deg, 0.0..=89.9, "sun.zenith_deg")?;
            need(sun.azimuth_deg.is_finite(), "sun.azimuth_deg", || {
                "it is not a finite number".into()
            })?;
            for of in &self.depths {
                temperature(of.temperature_k + sun.warmer_k, "sun.warmer_k")?;
            }
        }
        Ok(())
    }

    fn depth_bins(&self) -> u16 {
        let first = self.depths[0].temperature_k;
        if self.depths.iter().all(|of| of.temperature_k == first) { 1 } else { DEPTHS }
    }

    /// The sun, if it changes anything.
    pub fn sun(&self) -> Option<Sun> {
        self.sun.filter(|sun| sun.warmer_k != 0.0)
    }

    /// Number of layers: bins of depth in shade, then in the sun.
    pub fn count(&self) -> u16 {
        self.depth_bins() * if self.sun().is_some() { 2 } else { 1 }
    }

    /// The layer of a place at a depth, um, in shade or in the sun.
    pub fn layer(&self, depth_um: f64, in_sun: bool) -> u16 {
        let bins = self.depth_bins();
        let [first, last] = self.ends_um();
        let bin = if bins == 1 || depth_um <= first + ROUNDING_UM {
            0
        } else if depth_um >= last - ROUNDING_UM {
            bins - 1
        } else {
            let between = f64::from(bins - 2);
            1 + ((depth_um - first) / (last - first) * between).min(between - 1.0) as u16
        };
        bin + if in_sun { bins } else { 0 }
    }

    /// The temperature of a layer, K: at the middle of its depths.
    pub fn temperature_k(&self, layer: u16) -> f64 {
        let bins = self.depth_bins();
        let [first, last] = self.ends_um();
        let depth_um = match layer % bins {
            0 => first,
            bin if bin == bins - 1 => last,
            bin => first + (f64::from(bin) - 0.5) / f64::from(bins - 2) * (last - first),
        };
        let warmer_k = self.sun().filter(|_| layer >= bins).map_or(0.0, |sun| sun.warmer_k);
        let points = &self.depths;
        let at = crate::support::linear::locate(points, |point| point.depth_um, depth_um);
        at.value(|i| points[i].temperature_k) + warmer_k
    }

    fn ends_um(&self) -> [f64; 2] {
        [self.depths[0].depth_um, self.depths[self.depths.len() - 1].depth_um]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(text: &str) -> Layers {
        let read: SceneTemperature = serde_json::from_str(text).expect("layers");
        let SceneTemperature::Layers(layers) = read else { panic!("layers") };
        layers
    }

    #[test]
    fn a_layer_has_the_temperature_of_its_depth() {
        let skin = layers(
            r#"{"depths": [{"depth_um": 100, "temperature_k": 320},
                           {"depth_um": 400, "temperature_k": 290}],
                "sun": {"zenith_deg": 30, "warmer_k": 5}}"#,
        );
        assert_eq!(skin.count(), 64);
        for (depth_um, kelvin) in [(0.0, 320.0), (100.0, 320.0), (400.0, 290.0), (1e6, 290.0)] {
            for (in_sun, more) in [(false, 0.0), (true, 5.0)] {
                assert_eq!(skin.temperature_k(skin.layer(depth_um, in_sun)), kelvin + more);
            }
        }
        // Between the points it is that of the middle of its bin, 10 um deep.
        for i in 0..300 {
            let depth_um = 100.5 + f64::from(i);
            let found = skin.temperature_k(skin.layer(depth_um, false));
            let exact = 320.0 - 0.1 * (depth_um - 100.0);
            assert!((found - exact).abs() <= 0.5 + 1e-9, "{depth_um}: {found} {exact}");
        }
    }

    #[test]
    fn layers_of_one_temperature_are_none() {
        for text in [
            r#"{"depths": [{"depth_um": 0, "temperature_k": 300}]}"#,
            r#"{"depths": [{"depth_um": 0, "temperature_k": 300},
                           {"depth_um": 9, "temperature_k": 300}],
                "sun": {"zenith_deg": 0, "warmer_k": 0}}"#,
        ] {
            assert_eq!(layers(text).count(), 1);
            let read: SceneTemperature = serde_json::from_str(text).expect("layers");
            assert!(read.layers().is_none() && read.kelvin() == 300.0);
        }
        assert_eq!(serde_json::from_str::<SceneTemperature>("300").expect("K").kelvin(), 300.0);
    }
}
