//! What a bed has of a soil's shares, beside what was asked.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::scene::packing::Packing;

/// The shares of a soil: asked for, and attained by its bed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SoilShares {
    /// Whether shares are of the volume; else of the mass.
    pub by_volume: bool,
    /// Grains of a bed.
    pub grains: u32,
    /// The tray, um.
    pub tray_um: [f64; 2],
    /// Width of the rim of the tray that is not looked at, um.
    pub crop_um: f64,
    /// The porosity asked for, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked_porosity: Option<f64>,
    /// Porosity of the interior, the mean over beds; none before the drop, or of beds too shallow to
    /// have an interior.
    #[serde(default)]
    pub porosity: Option<f64>,
    /// The components.
    pub components: Vec<ComponentShares>,
}

/// A bed's porosity that is further than this from the one asked for is warned of. Beds of one
/// recipe differ by half as much.
const POROSITY_OFF: f64 = 0.02;

/// A component's share of all grains without dust.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ComponentShares {
    /// Its name.
    pub name: String,
    /// The share asked for.
    pub asked: f64,
    /// The share attained.
    pub attained: f64,
    /// Its size classes.
    pub sizes: Vec<SizeClass>,
    /// Its dust, by kind.
    pub dust: Vec<DustShares>,
}

/// A size class of a component. Shares are within the component.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SizeClass {
    /// Name of the class in the packing.
    pub name: String,
    /// Diameter of its grains, um.
    pub diameter_um: f64,
    /// Its grains in a bed.
    pub grains: u32,
    /// The share asked for.
    pub asked: f64,
    /// The share attained.
    pub attained: f64,
}

/// Dust of a kind on a component. What is attained is measured on the dressed grains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DustShares {
    /// The kind.
    pub kind: String,
    /// The share of the silhouette asked for, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked_cover: Option<f64>,
    /// The mass over that of the grain asked for, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked_mass_ratio: Option<f64>,
    /// Share of the silhouette, the mean over grains. A line of sight that meets several fines
    /// counts for the one that was seated first.
    pub cover: Option<f64>,
    /// Mass of the dust over that of the grains.
    pub mass_ratio: Option<f64>,
    /// Its classes of fines in the packing.
    pub classes: Vec<String>,
}

/// A dressed grain, as `drop.json` tells of it.
#[derive(Debug, Clone, Deserialize)]
pub struct Dressed {
    class: String,
    fines: BTreeMap<String, f64>,
    cover: DressedCover,
}

#[derive(Debug, Clone, Deserialize)]
struct DressedCover {
    by_class: BTreeMap<String, f64>,
}

impl SoilShares {
    /// Takes the dust from the dressed grains of one or more beds of a packing.
    pub fn measure_dust(&mut self, packing: &Packing, grains: &[Dressed]) {
        let Some(soil) = &packing.soil else { return };
        for component in &mut self.components {
            // The grains of each size class, as a mean over its variants.
            let of = |class: &SizeClass, value: &dyn Fn(&Dressed) -> f64| {
                let own: Vec<f64> =
                    grains.iter().filter(|g| g.class == class.name).map(value).collect();
                f64::from(class.grains) * own.iter().sum::<f64>() / own.len() as f64
            };
            let sizes = &component.sizes;
            let sum =
                |value: &dyn Fn(&Dressed) -> f64| sizes.iter().map(|c| of(c, value)).sum::<f64>();
            let number: f64 = sizes.iter().map(|class| f64::from(class.grains)).sum();
            let grain_mass: f64 = sizes
                .iter()
                .map(|c| f64::from(c.grains) * soil.grain_mass(&component.name, c.diameter_um))
                .sum();
            for dust in &mut component.dust {
                let over = |of: &BTreeMap<String, f64>, weight: &dyn Fn(&str) -> f64| {
                    let class = |name: &String| of.get(name).map_or(0.0, |x| x * weight(name));
                    dust.classes.iter().map(class).sum::<f64>()
                };
                let cover = sum(&|grain| over(&grain.cover.by_class, &|_| 1.0)) / number;
                let mass = |name: &str| soil.fine_mass(name).unwrap_or(0.0);
                let mass_ratio = sum(&|grain| over(&grain.fines, &mass)) / grain_mass;
                (dust.cover, dust.mass_ratio) = (Some(cover), Some(mass_ratio));
            }
        }
    }

    /// Takes the porosity of the interior of one or more beds.
    pub fn measure_porosity(&mut self, of_beds: &[f64]) {
        let mean = of_beds.iter().sum::<f64>() / of_beds.len() as f64;
        self.porosity = (!of_beds.is_empty()).then_some(mean);
    }

    /// What to say of a porosity that was asked for and is not attained.
    pub fn porosity_warning(&self) -> Option<String> {
        let asked = self.asked_porosity?;
        let Some(attained) = self.porosity else {
            return Some("the bed is too shallow to measure its porosity: raise grains".into());
        };
        let remedy = match attained - asked {
            off if off.abs() <= POROSITY_OFF => return None,
            off if off > 0.0 => {
                "a poured bed cannot be denser; fines that touch take some 0.05 off \
                 (drop.collision hull_then_fines)"
            }
            _ => "a poured bed cannot be looser",
        };
        Some(format!("the porosity is {attained:.3}, asked was {asked}: {remedy}"))
    }

    /// In one line what was attained, and what was asked.
    pub fn line(&self) -> String {
        let of = if self.by_volume { "volume" } else { "mass" };
        let porosity = match (self.porosity, self.asked_porosity) {
            (Some(attained), Some(asked)) => {
                Some(format!("porosity {attained:.3} (asked {asked})"))
            }
            (Some(attained), None) => Some(format!("porosity {attained:.3}")),
            (None, Some(asked)) => Some(format!("porosity is to be {asked}")),
            (None, None) => None,
        };
        let parts = self.components.iter().flat_map(ComponentShares::parts);
        let parts: Vec<String> = parts.chain(porosity).collect();
        format!("soil of {} grains, by {of}: {}", self.grains, parts.join(", "))
    }
}

impl ComponentShares {
    /// The largest deviation of a size class's share.
    pub fn sizes_off(&self) -> f64 {
        self.sizes.iter().map(|class| (class.attained - class.asked).abs()).fold(0.0, f64::max)
    }

    fn parts(&self) -> Vec<String> {
        let Self { name, asked, attained, sizes, dust } = self;
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        let of_sizes = match sizes.len() {
            1 => String::new(),
            classes => format!(", {classes} sizes to {} %", percent(self.sizes_off())),
        };
        let grains =
            format!("{name} {} % (asked {}{of_sizes})", percent(*attained), percent(*asked));
        [grains].into_iter().chain(dust.iter().map(DustShares::words)).collect()
    }
}

impl DustShares {
    /// What was attained, once it is measured, and what was asked.
    pub fn words(&self) -> String {
        let Self { kind, asked_cover, asked_mass_ratio, cover, mass_ratio, .. } = self;
        let (asked, attained, what) = match asked_cover {
            Some(asked) => (*asked, cover, "of its silhouette"),
            None => (asked_mass_ratio.unwrap_or(0.0), mass_ratio, "of its mass"),
        };
        match attained {
            Some(attained) => format!("{kind} is {attained:.4} {what} (asked {asked})"),
            None => format!("{kind} is to be {asked} {what}"),
        }
    }
}
