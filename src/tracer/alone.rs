//! Whether a field is needed: its patch alone is traced by the same paths.

use crate::histogram::Histogram;
use crate::scene::Sides;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::table::field::{Alone, Difference};
use crate::table::{Part, Table, Target};
use crate::tracer::Tracer;
use crate::tracer::rules::TracingRules;
use crate::tracer::until::{self, Watch};

impl Alone {
    /// Traces the patch alone with as many paths as the field, which take the same random numbers: until they
    /// come to a side they are the same paths, so that the difference has less noise than either.
    pub(crate) fn trace(
        tracer: &Tracer,
        rules: &TracingRules,
        table: &Table,
        bands: &[Vec<f64>],
        target: Target,
        monitor: &dyn Monitor,
    ) -> Result<Self, Error> {
        let of = table.paths;
        let target = Target { exactly: Some(Part { first: 0, end: of, of }), ..target };
        let watch = Watch { monitor, what: "paths of the patch alone", keep: &|_| Ok(()) };
        let at_um = table.stop.widest_at_um;
        let band = table.stop.grid.wavelengths_um().iter().position(|um| *um == at_um);
        let reflectance = &bands[band.expect("it is a band of the grid")];
        let within = |sides| -> Result<Difference, Error> {
            let alone = tracer.within(sides);
            let traced = until::trace(&alone, rules, table.seed, bands, target, None, &watch)?;
            // What is not reflected is emitted.
            let less = table.histogram.less_weight(&Histogram::of(&traced.tally), reflectance);
            Ok(Difference::new(less.mean, less.half_width(), at_um))
        };
        Ok(Self { periodic: within(Sides::Periodic)?, mirror: within(Sides::Mirror)? })
    }
}
