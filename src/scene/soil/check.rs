//! The bounds of a soil: what is refused, with its place and the remedy.

use super::{DustKind, DustOn, MOST_G_CM3, Soil, SoilComponent};
use crate::scene::check::{Checked, at_most, need, positive, unique, within};
use crate::scene::packing_check::{MOST, MOST_SEED};
use crate::scene::{Material, known};
use crate::support::statistics::SHARES_ROUNDING;

/// Longest name: size classes are called NAME-DIAMETER, their dressed grains NAME-DIAMETER_NUMBER.
const LONGEST_NAME: usize = 30;

fn at(key: &str) -> String {
    format!("geometry.soil.{key}")
}

impl Soil {
    /// What is wrong with it, in a scene of these materials.
    pub(in crate::scene) fn check(&self, materials: &[Material]) -> Checked {
        at_most(self.seed, MOST_SEED, &at("seed"))?;
        within(self.grains.unwrap_or(1), 1..=MOST, &at("grains"))?;
        let porosity = self.porosity.unwrap_or(0.5);
        need(porosity > 0.0 && porosity < 1.0, &at("porosity"), || {
            format!("{porosity} is not between 0 and 1: write 40 % as 0.4")
        })?;
        need(!self.components.is_empty(), &at("components"), || {
            "there must be at least one".into()
        })?;
        let names = self.components.iter().map(|c| c.name.as_str());
        unique(names.chain(self.dust.iter().map(|kind| kind.name.as_str())), &at("components"))?;
        for (i, component) in self.components.iter().enumerate() {
            self.check_component(component, &at(&format!("components[{i}]")), materials)?;
        }
        for (i, kind) in self.dust.iter().enumerate() {
            check_kind(kind, &at(&format!("dust[{i}]")), materials)?;
        }
        if let Some(floor) = &self.floor_material {
            known(materials, floor, &at("floor_material"))?;
        }
        self.check_shares()
    }

    fn check_shares(&self) -> Checked {
        let by_mass = self.components.iter().filter(|c| c.mass_share.is_some()).count();
        let by_volume = self.components.iter().filter(|c| c.volume_share.is_some()).count();
        let all = self.components.len();
        need([(all, 0), (0, all)].contains(&(by_mass, by_volume)), &at("components"), || {
            "give all components a mass_share, or all a volume_share".into()
        })?;
        let sum: f64 = self.components.iter().map(SoilComponent::share).sum();
        need((sum - 1.0).abs() <= SHARES_ROUNDING, &at("components"), || {
            let remedy = if (sum - 100.0).abs() < 0.1 {
                "write percentages as shares, 0.7 for 70 %"
            } else {
                "change them so that they make 1"
            };
            let shown = (sum * 1e9).round() / 1e9;
            format!("the shares make {shown}, not 1: {remedy}")
        })
    }

    fn check_component(
        &self,
        component: &SoilComponent,
        place: &str,
        materials: &[Material],
    ) -> Checked {
        let at = |key: &str| format!("{place}.{key}");
        check_name(&component.name, &at("name"))?;
        known(materials, &component.material, &at("material"))?;
        for (share, key) in
            [(component.mass_share, "mass_share"), (component.volume_share, "volume_share")]
        {
            if let Some(share) = share {
                positive(share, &at(key))?;
            }
        }
        component.size_um.check(&at("size_um"))?;
        density(component.density_g_cm3, &at("density_g_cm3"))?;
        unique(component.dust.iter().map(|on| on.kind.as_str()), &at("dust"))?;
        for (i, on) in component.dust.iter().enumerate() {
            self.check_dust(on, &at(&format!("dust[{i}]")))?;
        }
        let by_cover = component.dust.iter().filter(|on| on.cover.is_some()).count();
        need([0, component.dust.len()].contains(&by_cover), &at("dust"), || {
            "give all dust of a component a cover, or all a mass_ratio".into()
        })?;
        let cover: f64 = component.dust.iter().filter_map(|on| on.cover).sum();
        need(cover <= 1.0, &at("dust"), || {
            format!("the covers make {cover}, more than the whole silhouette")
        })
    }

    fn check_dust(&self, on: &DustOn, place: &str) -> Checked {
        need(self.dust.iter().any(|kind| kind.name == on.kind), &format!("{place}.kind"), || {
            let kinds: Vec<&str> = self.dust.iter().map(|kind| kind.name.as_str()).collect();
            let there = match &kinds[..] {
                [] => "geometry.soil.dust has no kind".into(),
                kinds => format!("geometry.soil.dust has {}", kinds.join(", ")),
            };
            format!("there is no kind of dust {:?}; {there}", on.kind)
        })?;
        match (on.cover, on.mass_ratio) {
            (Some(cover), None) => {
                let place = format!("{place}.cover");
                positive(cover, &place)?;
                within(cover, 0.0..=1.0, &place)
            }
            (None, Some(ratio)) => positive(ratio, &format!("{place}.mass_ratio")),
            _ => need(false, place, || "give it a cover or a mass_ratio, one of them".into()),
        }
    }
}

fn check_kind(kind: &DustKind, place: &str, materials: &[Material]) -> Checked {
    let at = |key: &str| format!("{place}.{key}");
    check_name(&kind.name, &at("name"))?;
    known(materials, &kind.material, &at("material"))?;
    kind.size_um.check(&at("size_um"))?;
    density(kind.density_g_cm3, &at("density_g_cm3"))
}

/// Greater numbers are kilograms per cubic metre.
fn density(density: Option<f64>, place: &str) -> Checked {
    let Some(density) = density else { return Ok(()) };
    positive(density, place)?;
    need(density <= MOST_G_CM3, place, || {
        format!("{density} is above {MOST_G_CM3}: write g cm-3, as 2.65 for quartz")
    })
}

fn check_name(name: &str, place: &str) -> Checked {
    let breaks = |c: char| c.is_whitespace() || c.is_control() || c == '#';
    let is_short = (1..=LONGEST_NAME).contains(&name.chars().count());
    need(is_short && !name.contains(breaks), place, || {
        format!("{name:?} is not 1 to {LONGEST_NAME} characters without white space or '#'")
    })
}
