//! Whether a field is needed: its patch alone is traced by the same paths.

use crate::histogram::Histogram;
use crate::scene::Sides;
use crate::support::error::Error;
use crate::table::field::{Alone, Difference};
use crate::table::{Part, Table, Target};
use crate::tracer::Tracer;
use crate::tracer::until::{self, Request};

impl Alone {
    /// Traces the patch alone with as many paths as the field. They take the same random numbers
    /// and are the same paths up to the first side, so that the difference has less noise than
    /// either.
    pub(crate) fn trace(tracer: &Tracer, table: &Table, request: &Request) -> Result<Self, Error> {
        let of = table.paths;
        // As many paths as the field took: it is the field that ends by the time.
        let exactly = Some(Part { first: 0, end: of, of });
        let target = Target { exactly, max_seconds: None, ..request.target };
        let request = Request {
            target,
            resume: None,
            what: "paths of the patch alone",
            save: &|_| Ok(()),
            ..*request
        };
        let at_um = table.stop.reached.widest_at_um;
        let wavelengths_um = table.stop.asked.grid.wavelengths_um();
        let band = wavelengths_um.iter().position(|um| *um == at_um);
        let reflectance = &request.bands[band.expect("it is a band of the grid")];
        let within = |sides| -> Result<Difference, Error> {
            let traced = until::trace(&tracer.within(sides), &request)?;
            // What is not reflected is emitted.
            let less = table.histogram.less_weight(&Histogram::of(&traced.tally), reflectance);
            Ok(Difference::new(less.mean, less.half_width(), at_um))
        };
        Ok(Self { periodic: within(Sides::Periodic)?, mirror: within(Sides::Mirror)? })
    }
}
