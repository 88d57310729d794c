//! What is recorded of each path.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// Bins of the cosine between a ray and the facet's normal, where a reflectance depends on it.
pub const COSINES: u16 = 64;

/// Bins of the zenith angle of escape, where the sky's radiance depends on it: one degree each.
pub const ZENITHS: u16 = 90;

/// Parts of a path: at the first hit this many directions are tried, and each that meets the sky
/// brings one part there. More parts cost more rays than they save (docs/notes/tracer.md).
pub const PARTS: u64 = 5;

/// Parts of a path at one node, where light is traced apart at each: its weight is counted in them.
pub const WEIGHTS: u64 = 1 << 24;

/// What is recorded of each path: the least that the scene needs.
///
/// Where grains refract, the way of a path depends on the wavelength. It is then traced apart at
/// several wavelengths, the *nodes*, and what is recorded is the weight that it brings to the sky.
/// Symbols are the nodes, and one more for the floor: a state is a node and the hits on the floor,
/// whose reflectance the weight leaves out.
///
/// A hit is recorded as its *symbol*: the material, its layer of temperature and the bin of the
/// cosine. Without order and cosines a state is the number of hits on each material. Otherwise it
/// lists the symbols of all hits, in their order or sorted. The zenith bin, if recorded, ends the state of an escaped path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Kept {
    /// The order of hits: needed where materials differ in temperature.
    pub order: bool,
    /// Bins of the cosine of each hit; 1 where no reflectance depends on it.
    pub cosines: u16,
    /// Bins of the zenith angle of escape; 1 where the sky is isotropic.
    pub zeniths: u16,
    /// Wavelengths at which paths are traced apart; 0 where one path serves all bands.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub nodes: u16,
    /// Layers of temperature of each material: depths, in shade and in the sun; 0 where a material
    /// has one temperature.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub layers: u16,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(number: &u16) -> bool {
    *number == 0
}

impl Kept {
    /// Numbers of hits: enough for one temperature, an isotropic sky and reflectances that do not
    /// depend on the angle.
    pub const PLAIN: Self = Self { order: false, cosines: 1, zeniths: 1, nodes: 0, layers: 0 };

    /// Whether a state lists the hits, rather than counting those on each material.
    pub fn lists(self) -> bool {
        self.order || self.cosines > 1 || self.nodes > 0
    }

    /// Parts of a path.
    pub fn parts(self) -> u64 {
        if self.nodes > 0 { u64::from(self.nodes) * WEIGHTS } else { PARTS }
    }

    /// Number of symbols.
    pub fn symbols(self, materials: usize) -> usize {
        if self.nodes > 0 { usize::from(self.nodes) + 1 } else { materials * self.of_material() }
    }

    /// Number of symbols of a material: its layers, each with all bins of cosines.
    pub fn of_material(self) -> usize {
        usize::from(self.layers.max(1)) * usize::from(self.cosines)
    }

    /// The symbols of hits on a material; with nodes those on the floor, of whatever material.
    pub fn symbols_of(self, material: usize) -> Range<usize> {
        if self.nodes > 0 {
            usize::from(self.nodes)..usize::from(self.nodes) + 1
        } else {
            material * self.of_material()..(material + 1) * self.of_material()
        }
    }

    /// Splits the state of an escaped path into its hits and the bin of its zenith angle.
    pub fn split(self, state: &[u16]) -> (&[u16], usize) {
        match state.split_last() {
            Some((&bin, hits)) if self.zeniths > 1 => (hits, bin.into()),
            _ => (state, 0),
        }
    }
}
