//! From a soil to the packing that Blender carries out.

use std::collections::BTreeMap;

use super::counts::{self, Wanted};
use super::shares::{ComponentShares, DustShares, SizeClass, SoilShares};
use super::{DustKind, DustOn, Soil, SoilComponent};
use crate::scene::packing::{Cover, Drop, Dust, FineClass, Fines, GrainClass, Packing};
use crate::scene::sizes::Sizes;
use crate::support::math;

/// Least number of grains, where a soil states none: that of the shipped scenes.
const GRAINS: u32 = 72;

/// Density where a soil states none: quartz, g cm-3.
const QUARTZ_G_CM3: f64 = 2.65;
/// Most size classes of a component, and of a kind of dust.
const MOST_CLASSES: [u32; 2] = [8, 4];

/// Dressed grains modelled of each size class.
const VARIANTS: u32 = 2;

/// Cross-sections of all dusty grains, as a share of the tray's area: between the 1.81 of the
/// shipped dusty scenes and the 1.91 of the bare one, which are about three grains deep.
const LAYERS_OF_SECTIONS: f64 = 1.85;

/// Width of the rim that is not looked at, as a share of the largest diameter.
const CROP: f64 = 0.7;

/// The tray is wider than this many of the largest dusty diameter.
const NARROWEST: f64 = 4.0;

/// Tray and rim are multiples of this, um.
const STEP_UM: f64 = 10.0;

/// A component's size class among all.
struct Class<'a> {
    component: &'a SoilComponent,
    name: String,
    diameter_um: f64,
}

impl Soil {
    /// The packing that Blender carries out, and what it reaches of the shares. The soil is
    /// checked.
    ///
    /// # Errors
    /// No number of grains reaches the shares: the place in the scene file and the problem.
    pub fn resolve(&self) -> Result<(Packing, SoilShares), (String, String)> {
        let classes: Vec<Class> = self.components.iter().flat_map(SoilComponent::classes).collect();
        let wanted: Vec<Wanted> = classes.iter().map(|class| self.wanted(class)).collect();
        let least = self.grains.unwrap_or(GRAINS);
        let counts = counts::choose(&wanted, least).map_err(|rarest| {
            let Class { component, name, diameter_um } = &classes[rarest];
            let number = self.components.iter().position(|c| c.name == component.name);
            (
                format!("geometry.soil.components[{}].size_um", number.unwrap_or(0)),
                format!(
                    "{} grains are too few for one of {diameter_um:.4} um ({name}): narrow the \
                     sizes, state the finest part as dust, or raise geometry.soil.grains",
                    counts::most(least)
                ),
            )
        })?;
        let fines = self.fine_classes();
        let side = tray_um(&wanted, &counts);
        let widest = classes.iter().map(|class| class.diameter_um).fold(0.0, f64::max);
        let grains: Vec<GrainClass> =
            classes.iter().zip(&counts).map(|(class, &count)| self.grain(class, count)).collect();
        let bare = |grain: &&GrainClass| grain.fines.is_none() && !grain.fine_shares.is_empty();
        if let Some(grain) = grains.iter().find(bare) {
            let problem = "the dust is less than one fine on a grain: raise its mass_ratio, or give \
                           the kind a smaller size_um";
            return Err((format!("geometry.soil.components ({})", grain.name), problem.into()));
        }
        let packing = Packing {
            soil: Some(Box::new(self.clone())),
            seed: self.seed,
            library: self.library.clone(),
            grains,
            fines,
            dust: self.seating.clone(),
            variants: VARIANTS,
            tray_um: [side; 2],
            crop_um: (CROP * widest / STEP_UM).round() * STEP_UM,
            floor_material: self.floor_material.clone().unwrap_or_else(|| {
                self.components.first().map_or(String::new(), |first| first.material.clone())
            }),
            drop: self.drop.clone(),
        };
        let shares = self.shares(&packing, &wanted, &counts);
        Ok((packing, shares))
    }

    /// A packing of this soil that is still to be resolved.
    pub(in crate::scene) fn unresolved(self) -> Packing {
        Packing {
            seed: self.seed,
            library: None,
            grains: Vec::new(),
            fines: Vec::new(),
            dust: Dust::default(),
            variants: VARIANTS,
            tray_um: [0.0; 2],
            crop_um: 0.0,
            floor_material: String::new(),
            drop: Drop::default(),
            soil: Some(Box::new(self)),
        }
    }

    /// Whether shares are of the volume.
    fn by_volume(&self) -> bool {
        self.components.iter().any(|component| component.volume_share.is_some())
    }

    fn wanted(&self, class: &Class) -> Wanted {
        let Class { component, diameter_um, .. } = class;
        let classes = component.size_um.classes_um(MOST_CLASSES[0]).len() as f64;
        let fines = component.dust.iter().filter_map(|on| self.kind(on));
        let finest = |kind: &DustKind| kind.classes().into_iter().map(|(_, um)| um);
        let dust_um = fines.flat_map(finest).fold(0.0, f64::max);
        let density = if self.by_volume() { 1.0 } else { component.density() };
        Wanted {
            component: self.components.iter().position(|c| c.name == component.name).unwrap_or(0),
            share: component.share() / classes,
            of_one: density * diameter_um.powi(3),
            dusty_um: diameter_um + 2.0 * dust_um,
        }
    }

    fn kind(&self, on: &DustOn) -> Option<&DustKind> {
        self.dust.iter().find(|kind| kind.name == on.kind)
    }

    fn fine_classes(&self) -> Vec<FineClass> {
        let used: Vec<&DustKind> = self
            .dust
            .iter()
            .filter(|kind| {
                self.components.iter().any(|c| c.dust.iter().any(|on| on.kind == kind.name))
            })
            .collect();
        let number = used.iter().map(|kind| kind.classes().len()).sum::<usize>() as f64;
        let of = |kind: &&DustKind| {
            let class = |(name, diameter_um): (String, f64)| FineClass {
                name,
                shape: kind.shape.clone(),
                ribs: None,
                diameter_um,
                material: kind.material.clone(),
                // Every component has shares of its own.
                share: 1.0 / number,
            };
            kind.classes().into_iter().map(class).collect::<Vec<_>>()
        };
        used.iter().flat_map(of).collect()
    }

    fn grain(&self, class: &Class, count: u32) -> GrainClass {
        let Class { component, name, diameter_um } = class;
        let numbers = self.numbers(component, *diameter_um);
        let total: f64 = numbers.values().sum();
        let is_by_cover = component.dust.iter().any(|on| on.cover.is_some());
        let fines = if is_by_cover {
            let silhouette = component.dust.iter().filter_map(|on| on.cover).sum();
            Fines::Cover(Cover { silhouette })
        } else {
            Fines::Count(total.round() as u32)
        };
        GrainClass {
            name: name.clone(),
            shape: component.shape.clone(),
            ribs: None,
            diameter_um: *diameter_um,
            material: component.material.clone(),
            count,
            fines,
            fine_shares: numbers.into_iter().map(|(fine, n)| (fine, n / total)).collect(),
        }
    }

    /// Fines of each class on a grain; up to a common factor where dust is stated by its cover.
    /// While fines do not overlap they cover by their cross-sections.
    fn numbers(&self, component: &SoilComponent, grain_um: f64) -> BTreeMap<String, f64> {
        let mut numbers = BTreeMap::new();
        for on in &component.dust {
            let Some(kind) = self.kind(on) else { continue };
            let classes = kind.classes();
            // Classes have equal mass.
            let of_each: Vec<f64> = classes.iter().map(|(_, um)| um.powi(-3)).collect();
            let power = if on.cover.is_some() { 2 } else { 3 };
            let each = classes.iter().zip(&of_each);
            let measure: f64 = each.map(|((_, um), n)| n * um.powi(power)).sum();
            let wanted = on.cover.unwrap_or_else(|| {
                let grain = component.density() * grain_um.powi(3);
                on.mass_ratio.unwrap_or(0.0) * grain / kind.density()
            });
            for ((name, _), n) in classes.into_iter().zip(of_each) {
                numbers.insert(name, wanted * n / measure);
            }
        }
        numbers
    }

    /// What the packing reaches before Blender has dressed its grains.
    fn shares(&self, packing: &Packing, wanted: &[Wanted], counts: &[u32]) -> SoilShares {
        let amounts: Vec<f64> =
            wanted.iter().zip(counts).map(|(w, &n)| f64::from(n) * w.of_one).collect();
        let total: f64 = amounts.iter().sum();
        let component = |(number, component): (usize, &SoilComponent)| {
            let rows = (0..wanted.len()).filter(|&i| wanted[i].component == number);
            let own: f64 = rows.clone().map(|i| amounts[i]).sum();
            let asked: f64 = rows.clone().map(|i| wanted[i].share).sum();
            let size = |i: usize| SizeClass {
                name: packing.grains[i].name.clone(),
                diameter_um: packing.grains[i].diameter_um,
                grains: counts[i],
                asked: wanted[i].share / asked,
                attained: amounts[i] / own,
            };
            ComponentShares {
                name: component.name.clone(),
                asked,
                attained: own / total,
                sizes: rows.map(size).collect(),
                dust: component.dust.iter().filter_map(|on| self.dust_shares(on)).collect(),
            }
        };
        SoilShares {
            by_volume: self.by_volume(),
            grains: counts.iter().sum(),
            tray_um: packing.tray_um,
            crop_um: packing.crop_um,
            asked_porosity: self.porosity,
            porosity: None,
            components: self.components.iter().enumerate().map(component).collect(),
        }
    }

    fn dust_shares(&self, on: &DustOn) -> Option<DustShares> {
        Some(DustShares {
            kind: on.kind.clone(),
            asked_cover: on.cover,
            asked_mass_ratio: on.mass_ratio,
            cover: None,
            mass_ratio: None,
            classes: self.kind(on)?.classes().into_iter().map(|(name, _)| name).collect(),
        })
    }

    /// Density of the fines of a class, by its name, times the cube of their diameter.
    pub(super) fn fine_mass(&self, class: &str) -> Option<f64> {
        self.dust.iter().find_map(|kind| {
            let (_, um) = kind.classes().into_iter().find(|(name, _)| name == class)?;
            Some(kind.density() * um.powi(3))
        })
    }

    /// Density of a component times the cube of a diameter.
    pub(super) fn grain_mass(&self, component: &str, diameter_um: f64) -> f64 {
        let of = self.components.iter().find(|c| c.name == component);
        of.map_or(QUARTZ_G_CM3, SoilComponent::density) * diameter_um.powi(3)
    }
}

impl SoilComponent {
    pub(super) fn share(&self) -> f64 {
        self.mass_share.or(self.volume_share).unwrap_or(0.0)
    }

    fn density(&self) -> f64 {
        self.density_g_cm3.unwrap_or(QUARTZ_G_CM3)
    }

    fn classes(&self) -> Vec<Class<'_>> {
        let class = |(name, diameter_um)| Class { component: self, name, diameter_um };
        named(&self.name, &self.size_um, MOST_CLASSES[0]).into_iter().map(class).collect()
    }
}

impl DustKind {
    fn density(&self) -> f64 {
        self.density_g_cm3.unwrap_or(QUARTZ_G_CM3)
    }

    /// Names and diameters of its size classes, which have equal mass.
    fn classes(&self) -> Vec<(String, f64)> {
        named(&self.name, &self.size_um, MOST_CLASSES[1])
    }
}

/// Size classes, each named by its diameter to three digits.
fn named(name: &str, sizes: &Sizes, most: u32) -> Vec<(String, f64)> {
    let class = |um: f64| {
        let decimals = (2 - math::log10(um).floor() as i32).max(0) as usize;
        (format!("{name}-{um:.decimals$}"), um)
    };
    sizes.classes_um(most).into_iter().map(class).collect()
}

/// Side of the square tray, um.
fn tray_um(wanted: &[Wanted], counts: &[u32]) -> f64 {
    let sections: f64 =
        wanted.iter().zip(counts).map(|(w, &n)| f64::from(n) * w.dusty_um.powi(2)).sum();
    let widest = wanted.iter().map(|w| w.dusty_um).fold(0.0, f64::max);
    let side = (std::f64::consts::FRAC_PI_4 * sections / LAYERS_OF_SECTIONS).sqrt();
    (side.max(NARROWEST * widest) / STEP_UM).ceil() * STEP_UM
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// The grains of the shipped scenes, 24 of each diameter, by their shares of mass.
    fn shipped(dust: &Value) -> Soil {
        let cubes = [500.0, 640.0, 853.0].map(|um: f64| um.powi(3));
        let total: f64 = cubes.iter().sum();
        let component = |um: u32, cube: f64| {
            json!({"name": format!("grain_{um}"), "material": "coarse", "mass_share": cube / total,
                   "size_um": um, "shape": format!("grain_{um}"), "dust": dust})
        };
        let [a, b, c] = cubes;
        serde_json::from_value(json!({
            "seed": 1,
            "components": [component(500, a), component(640, b), component(853, c)],
            "dust": [{"name": "fine", "material": "fine", "shape": "chip", "size_um": 60}]
        }))
        .expect("a soil")
    }

    #[test]
    fn the_shipped_grains_stated_by_mass_give_the_shipped_counts_and_about_the_shipped_trays() {
        for (dust, shipped_um) in
            [(json!([]), 3700.0), (json!([{"kind": "fine", "cover": 0.6}]), 4300.0)]
        {
            let (packing, shares) = shipped(&dust).resolve().expect("reached");
            assert_eq!(packing.grains.iter().map(|class| class.count).collect::<Vec<_>>(), [24; 3]);
            assert!((packing.tray_um[0] / shipped_um - 1.0).abs() < 0.03, "{:?}", packing.tray_um);
            assert_eq!(packing.crop_um, 600.0);
            assert!(shares.components.iter().all(|c| (c.attained - c.asked).abs() < 1e-12));
        }
    }
}
