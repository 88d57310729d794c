//! Whether a field is needed: what its patch alone, within mirror sides, gives in its place.

use serde::{Deserialize, Serialize};

use crate::course::Course;
use crate::error::Error;
use crate::geometry::Bed;
use crate::histogram::Histogram;
use crate::packings;
use crate::scene::Sides;
use crate::stop::{self, Part, Target, Watch};
use crate::table::Table;
use crate::tracer::Tracer;

/// The field that was traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InField {
    /// Patches along x and y.
    pub patches: [u32; 2],
    /// Particles of one patch.
    pub particles_of_patch: u64,
    /// Particles in all.
    pub particles: u64,
    /// Length of the field along x and y, um.
    pub size_um: [f64; 2],
    /// What the patch alone gives; `None` of a part of a trace.
    pub alone: Option<Alone>,
}

/// What the patch alone, within mirror sides, differs by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Alone {
    /// Its emissivity less that of the field, in the band where the field is least sure.
    pub difference: f64,
    /// Half-width of its 95 % interval: the noise of the rays; of several packings the spread between them.
    pub half_width: f64,
    /// The band, um.
    pub at_um: f64,
    /// Whether the difference is within its interval of 0: then the field is not needed.
    pub same: bool,
}

impl InField {
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

    /// The first packing's field, with what all packings alone differ by.
    pub fn mean(packings: &[Table]) -> Option<Self> {
        let first = packings[0].field.clone()?;
        let alone: Option<Vec<Alone>> =
            packings.iter().map(|table| table.field.as_ref()?.alone).collect();
        let Some(alone) = alone else { return Some(first) };
        let differences: Vec<f64> = alone.iter().map(|a| a.difference).collect();
        let difference = differences.iter().sum::<f64>() / differences.len() as f64;
        let half_width = packings::half_width(&differences).unwrap_or(alone[0].half_width);
        let alone = Alone::new(difference, half_width, alone[0].at_um);
        Some(Self { alone: Some(alone), ..first })
    }
}

impl Alone {
    fn new(difference: f64, half_width: f64, at_um: f64) -> Self {
        Self { difference, half_width, at_um, same: difference.abs() <= half_width }
    }

    /// Traces the patch alone with as many paths as the field, which take the same random numbers: until they
    /// come to a side they are the same paths, so that the difference has less noise than either.
    pub(crate) fn trace(
        tracer: &Tracer,
        course: &Course,
        table: &Table,
        bands: &[Vec<f64>],
        target: Target,
    ) -> Result<Self, Error> {
        let of = table.paths;
        let target = Target { exactly: Some(Part { first: 0, end: of, of }), ..target };
        let watch = Watch { progress: &|_, _| (), keep: &|_| Ok(()) };
        let alone = tracer.within(Sides::Mirror);
        let traced = stop::trace(&alone, course, table.seed, bands, target, None, &watch)?;
        let at_um = table.stop.widest_at_um;
        let band = table.stop.grid.wavelengths_um().iter().position(|um| *um == at_um);
        let reflectance = &bands[band.expect("it is a band of the grid")];
        // What is not reflected is emitted.
        let difference = table.histogram.less_weight(&Histogram::of(&traced.tally), reflectance);
        Ok(Self::new(difference.mean, difference.half_width(), at_um))
    }
}
