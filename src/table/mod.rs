//! The bounce table: everything that spectra, temperatures and sky need to know of a traced bed.

pub mod cover;
pub mod field;
mod file;
pub mod materials;
pub mod merge;
mod prepared;
pub mod remark;
pub mod stop;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::histogram::tally::{ByCell, Tally};
use crate::histogram::{Histogram, Mean};
use crate::radiometry::{self, Atmosphere, Lit, RadiometryError, SkyTable, Temperature};
use crate::scene::{Sky, View};
use crate::spectrum::{Spectrum, SpectrumError};
use crate::support::error::Error;
use crate::table::cover::Cover;
use crate::table::field::InField;
use crate::table::materials::reflectances;
use crate::table::remark::Remark;

pub use file::TableError;
pub use prepared::Prepared;
pub(crate) use prepared::resolved;
pub use stop::{Ended, Part, Stop, Sureness, Target};

/// The format's version, the value of `soilsig_table`.
pub const FORMAT: u32 = 5;

/// Share of light that may pass straight through a particle of `fresnel` facets along its mean chord: what passes is
/// scattered in the bed and part of it comes back, but facets count it as absorbed.
pub const MOST_TRANSMITTED: f64 = 0.01;

/// Wavelengths that the mean chord of a particle of `fresnel` facets must hold: reflection as from a wide face is that of
/// bodies large against the wavelength.
pub const LEAST_WAVELENGTHS: f64 = 10.0;

/// A traced bed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Version of the format: 5.
    pub soilsig_table: u32,
    /// The scene's name.
    pub scene: String,
    /// SHA-256 of the scene file and its meshes.
    pub scene_sha256: String,
    /// Temperature of the scene, kelvin.
    pub temperature_k: f64,
    /// Temperature of the sky, kelvin, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_temperature_k: Option<Sky>,
    /// Radiance of the sky, if it was given so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_radiance: Option<SkyTable>,
    /// What lies between target and sensor, if anything does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub atmosphere: Option<Atmosphere>,
    /// The direction to the sensor.
    pub view: View,
    /// Seed of the paths.
    pub seed: u64,
    /// Hits after which a path was given up.
    pub max_bounces: u16,
    /// What the counts stand for, in their order.
    pub materials: Vec<TableMaterial>,
    /// Index of the floor's material, if nothing else is made of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor: Option<usize>,
    /// The field that the bed is a patch of, if it is one of a field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub field: Option<InField>,
    /// Why the trace ended where it did.
    pub stop: Stop,
    /// Numbers of the paths traced, from the first to one past the last.
    pub numbers: [u64; 2],
    /// Paths traced.
    pub paths: u64,
    /// Paths that met nothing, which say nothing of the target.
    pub missed: u64,
    /// Parts of paths that left past the target's lower side.
    pub escaped_downward: u64,
    /// Surfaces hit in all.
    pub hits: u64,
    /// Paths given up inside a solid; they are among the trapped.
    pub inside: Vec<Inside>,
    /// What is seen of each prototype.
    pub coverage: BTreeMap<String, Cover>,
    /// What speaks against the bed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<Remark>,
    /// What the paths did.
    pub histogram: Histogram,
    /// The same by cells of the view in place of groups, where the target fills the view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cells: Option<Histogram>,
}

/// A material as the table counts it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableMaterial {
    /// The scene's name of it.
    pub name: String,
    /// Its emissivity, unless `signature` is given another.
    pub spectrum: Spectrum,
    /// Its temperature, kelvin, if it is not the scene's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_k: Option<f64>,
    /// Share of its reflectance that is specular.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub specular: f64,
    /// Mean chord of its particles, um: what light that passes through one has to get through. `None` where none of its
    /// meshes is closed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_chord_um: Option<f64>,
    /// First hits: what of the sensor's view it fills.
    pub first_hits: u64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl TableMaterial {
    /// Without what was counted of it and measured on this one bed.
    fn uncounted(&self) -> Self {
        Self { first_hits: 0, mean_chord_um: None, ..self.clone() }
    }

    /// Whether the model of its facets holds at a wavelength in um: particles must be large against it, and what refracts
    /// into one must not come out again.
    pub fn is_valid(&self, wavelength_um: f64) -> bool {
        match (&self.spectrum, self.mean_chord_um) {
            (Spectrum::Fresnel(_, crystal), Some(chord_um)) => {
                chord_um >= LEAST_WAVELENGTHS * wavelength_um
                    && crystal.transmittance(wavelength_um, chord_um) < MOST_TRANSMITTED
            }
            _ => true,
        }
    }
}

/// Paths that came to be inside a solid, where two overlap or all but touch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inside {
    /// The solid, by the name of its mesh.
    pub solid: String,
    /// The mesh that the paths had left; `None` for the floor and the sensor.
    pub from: Option<String>,
    /// How many.
    pub paths: u64,
}

impl Table {
    /// The counts of a tally, with everything else that a table holds left to the caller.
    pub fn count(&mut self, tally: &Tally, mesh_names: &[&str]) {
        self.paths = tally.paths;
        self.missed = tally.missed;
        self.escaped_downward = tally.escaped_downward;
        self.hits = tally.hits;
        // Meshes may share a name.
        let mut by_name: BTreeMap<(Option<&str>, &str), u64> = BTreeMap::new();
        for (&(from, solid), &paths) in &tally.inside {
            *by_name.entry((from.map(|mesh| mesh_names[mesh]), mesh_names[solid])).or_default() +=
                paths;
        }
        let inside = |((from, solid), paths): ((Option<&str>, &str), u64)| Inside {
            solid: solid.to_owned(),
            from: from.map(str::to_owned),
            paths,
        };
        self.inside = by_name.into_iter().map(inside).collect();
        self.inside.sort_by(|a, b| {
            b.paths.cmp(&a.paths).then_with(|| (&a.solid, &a.from).cmp(&(&b.solid, &b.from)))
        });
        for (material, &count) in self.materials.iter_mut().zip(&tally.first_hits) {
            material.first_hits = count;
        }
        self.histogram = Histogram::of(tally);
        self.cells = Histogram::by_cell(tally);
    }

    /// The counts as a tally, which more can be added to.
    ///
    /// # Panics
    /// If a mesh that paths were inside of is none of `mesh_names`.
    pub fn tally(&self, mesh_names: &[&str]) -> Tally {
        let number = |name: &str| {
            mesh_names.iter().position(|known| *known == name).expect("the meshes are the same")
        };
        let mut tally = Tally::new(self.materials.len(), self.histogram.kept);
        self.histogram.ungroup(&mut tally.escaped, &mut tally.trapped, &mut tally.ended);
        if let Some(cells) = &self.cells {
            let ByCell { escaped, trapped, ended } = &mut tally.by_cell;
            cells.ungroup(escaped, trapped, ended);
        }
        tally.paths = self.paths;
        tally.missed = self.missed;
        tally.escaped_downward = self.escaped_downward;
        tally.hits = self.hits;
        tally.first_hits = self.materials.iter().map(|m| m.first_hits).collect();
        for inside in &self.inside {
            let meshes = (inside.from.as_deref().map(number), number(&inside.solid));
            *tally.inside.entry(meshes).or_default() += inside.paths;
        }
        tally
    }

    /// Says in `stop` how sure the table is.
    pub fn judge(&mut self) -> Result<(), SpectrumError> {
        let wavelengths_um = self.stop.grid.wavelengths_um();
        let bands = self.reflectances(&wavelengths_um)?;
        let sureness = Sureness::of(&self.histogram, &bands, self.stop.tolerance);
        self.stop.half_width = sureness.weight.half_width();
        self.stop.widest_at_um = wavelengths_um[sureness.widest];
        self.stop.trapped = sureness.weight.trapped;
        self.stop.reached = sureness.reached;
        Ok(())
    }

    /// Whether both hold paths of one trace: the same scene, spectra, rays and rules.
    pub fn is_part_of_same(&self, other: &Self) -> bool {
        self.rules() == other.rules()
    }

    /// In what two tables are not of one trace, by the names of their keys.
    pub fn differs_from(&self, other: &Self) -> Vec<String> {
        let keys = |table: &Self| match serde_json::to_value(table.rules()) {
            Ok(serde_json::Value::Object(keys)) => keys,
            _ => unreachable!("a table is an object"),
        };
        let (mine, theirs) = (keys(self), keys(other));
        let differ = |key: &&String| mine.get(*key) != theirs.get(*key);
        let all: BTreeSet<&String> = mine.keys().chain(theirs.keys()).collect();
        all.into_iter().filter(differ).cloned().collect()
    }

    /// The table without what its paths counted.
    fn rules(&self) -> Self {
        Self {
            stop: self.stop.asked(),
            numbers: [0, 0],
            paths: 0,
            missed: 0,
            escaped_downward: 0,
            hits: 0,
            inside: Vec::new(),
            coverage: BTreeMap::new(),
            materials: self.materials.iter().map(TableMaterial::uncounted).collect(),
            histogram: Histogram::empty(self.histogram.kept),
            cells: None,
            ..self.clone()
        }
    }

    /// Paths that met the target.
    pub fn met(&self) -> u64 {
        self.paths - self.missed
    }

    /// The reflectance of each symbol of the histogram, by the materials' spectra.
    pub fn reflectances(&self, wavelengths_um: &[f64]) -> Result<Vec<Vec<f64>>, SpectrumError> {
        let spectra: Vec<&Spectrum> = self.materials.iter().map(|m| &m.spectrum).collect();
        reflectances(&spectra, self.histogram.kept, wavelengths_um)
    }

    /// The scene's temperature, as one that is known.
    pub fn temperature(&self) -> Temperature {
        Temperature { k: self.temperature_k, error_k: 0.0 }
    }

    /// Whether materials differ in temperature though the order of hits was not kept, which that needs.
    pub fn lacks_order(&self) -> bool {
        let of = |material: &TableMaterial| material.temperature_k.unwrap_or(self.temperature_k);
        let mut all = self.materials.iter().map(of);
        let first = all.next();
        !self.histogram.kept.order && all.any(|k| Some(k) != first)
    }

    /// Why Eq. 2 is not exact with these temperatures and this sky; empty where it is.
    pub fn eq_2_not_exact(&self) -> Vec<String> {
        let own = self.materials.iter().filter_map(|m| m.temperature_k);
        let mut reasons = Vec::new();
        if own.into_iter().any(|k| k != self.temperature_k) {
            reasons.push("materials differ in temperature".into());
        }
        if self.sky_is_by_zenith() {
            reasons.push("the sky depends on the zenith angle".into());
        }
        reasons
    }

    fn sky_is_by_zenith(&self) -> bool {
        matches!(self.sky_temperature_k, Some(Sky::ByZenith(_)))
            || self.sky_radiance.as_ref().is_some_and(SkyTable::is_by_zenith)
    }

    /// What each band's radiance depends on besides the histogram.
    ///
    /// # Errors
    /// A wavelength that a spectrum, the sky or the atmosphere does not hold.
    pub fn lit(&self, wavelengths_um: &[f64]) -> Result<Vec<Lit>, Error> {
        let reflectances = self.reflectances(wavelengths_um)?;
        let bands = wavelengths_um.iter().zip(reflectances);
        bands.map(|(&um, reflectance)| self.band_lit(um, reflectance)).collect()
    }

    fn band_lit(&self, wavelength_um: f64, reflectance: Vec<f64>) -> Result<Lit, Error> {
        let planck = |temperature_k| radiometry::planck(wavelength_um, temperature_k);
        let own = |m: &TableMaterial| planck(m.temperature_k.unwrap_or(self.temperature_k));
        let zeniths = self.histogram.kept.zeniths;
        let l_sky: Vec<f64> = (0..zeniths)
            .map(|bin| {
                let zenith_deg = (f64::from(bin) + 0.5) / f64::from(zeniths) * 90.0;
                match (&self.sky_radiance, &self.sky_temperature_k) {
                    (Some(sky), _) => sky.l_sky(wavelength_um, zenith_deg),
                    (None, Some(sky)) => Ok(planck(sky.temperature_k(zenith_deg))),
                    (None, None) => Ok(0.0),
                }
            })
            .collect::<Result<_, RadiometryError>>()?;
        Ok(Lit {
            wavelength_um,
            reflectance,
            l_blackbody_of: self.materials.iter().map(own).collect(),
            l_downwelling: radiometry::l_downwelling(&l_sky),
            l_sky,
            l_blackbody: planck(self.temperature_k),
            path: self.atmosphere.as_ref().map(|a| a.at(wavelength_um)).transpose()?,
        })
    }

    /// The mean weight that paths bring to the sky, for a reflectance of each symbol.
    pub fn weight(&self, reflectance: &[f64]) -> Mean {
        self.histogram.weight(reflectance)
    }
}
