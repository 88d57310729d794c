//! The field of a patch, and what the patch alone gives in its place.

use serde::{Deserialize, Serialize};

use crate::geometry::Bed;
use crate::scene::Sides;
use crate::support::statistics;
use crate::table::Table;

/// The field that was traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FieldSummary {
    /// Patches along x and y.
    pub patches: [u32; 2],
    /// Particles of one patch.
    pub particles_of_patch: u64,
    /// Particles of all patches.
    pub particles: u64,
    /// Length of the field along x and y, um.
    pub size_um: [f64; 2],
    /// What the patch alone gives; `None` of a part of a trace.
    pub alone: Option<Alone>,
}

/// What the patch alone gives in place of the field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Alone {
    /// Within periodic sides, whose seams cut solids as those of the field do. If it gives the
    /// same, the field is not needed.
    pub periodic: Difference,
    /// Within mirror sides, which have no seams: the effect of the seams.
    pub mirror: Difference,
}

/// The difference of an emissivity from that of the field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Difference {
    /// It less that of the field, in the band where the field is least precise.
    pub difference: f64,
    /// Half-width of its 95 % interval: the noise of the rays; of several packings the spread
    /// between them.
    pub half_width: f64,
    /// The band, um.
    pub at_um: f64,
    /// Whether its interval contains 0.
    pub same: bool,
}

impl FieldSummary {
    /// The field of a bed, if it is a patch of one.
    pub fn of(bed: &Bed) -> Option<Self> {
        let Sides::Field { .. } = bed.domain.sides else { return None };
        let [x, y] = bed.domain.patches;
        let size = bed.domain.max_um - bed.domain.min_um;
        let particles_of_patch = bed.particles();
        Some(Self {
            patches: [x, y],
            particles_of_patch,
            particles: particles_of_patch * u64::from(x) * u64::from(y),
            size_um: [size.x * f64::from(x), size.y * f64::from(y)],
            alone: None,
        })
    }

    /// The first packing's field, with the mean differences of all packings.
    pub fn mean(packings: &[Table]) -> Option<Self> {
        let first = packings[0].field.clone()?;
        let alone: Option<Vec<Alone>> =
            packings.iter().map(|table| table.field.as_ref()?.alone).collect();
        let mean = |of: fn(&Alone) -> Difference, alone: &[Alone]| {
            let differences: Vec<f64> = alone.iter().map(|a| of(a).difference).collect();
            let difference = differences.iter().sum::<f64>() / differences.len() as f64;
            let one = of(&alone[0]);
            let half_width = statistics::half_width(&differences).unwrap_or(one.half_width);
            Difference::new(difference, half_width, one.at_um)
        };
        let alone = alone.map(|all| Alone {
            periodic: mean(|alone| alone.periodic, &all),
            mirror: mean(|alone| alone.mirror, &all),
        });
        Some(Self { alone, ..first })
    }
}

impl Difference {
    pub(crate) fn new(difference: f64, half_width: f64, at_um: f64) -> Self {
        Self { difference, half_width, at_um, same: difference.abs() <= half_width }
    }
}
