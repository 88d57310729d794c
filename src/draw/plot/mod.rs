//! Charts as SVG, PNG and PDF.
//!
//! The SVG is written here, so that the same chart gives the same bytes everywhere. The PNG is the
//! SVG rendered with a font that the program contains, so that it does not depend on the machine.

mod atlas;
pub(crate) mod axis;
mod bodies;
mod curve;
mod emissivity;
mod fit;
pub(crate) mod label;
pub(crate) mod legend;
mod marks;
pub(crate) mod page;
mod panels;
mod pdf;
mod raster;
pub(crate) mod svg;

use crate::support::error::Failure;

pub use atlas::{Mark, Panel, atlas_svg};
pub use bodies::{Row, Solid, bodies_svg};
pub use curve::Curve;
pub use emissivity::{Chart, emissivity_svg};
pub use fit::{Drawn, FitChart, fit_svg, posterior_svg};
pub use panels::{Drawing, Series, SmallChart, SmallCharts, small_charts_svg};
pub use pdf::pdf;
pub use raster::png;
pub(crate) use raster::{layer, pack};

/// Pixels of a PNG in one unit of the chart.
pub const PIXELS_PER_UNIT: f32 = 2.0;

/// A chart cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// There is nothing to draw.
    #[error("a chart needs a curve with at least one point")]
    Empty,
    /// A curve cannot be drawn.
    #[error("curve '{label}': {problem}")]
    Curve {
        /// The curve's label.
        label: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The text is not SVG.
    #[error("cannot render the chart: {0}")]
    Svg(#[from] resvg::usvg::Error),
    /// The picture is too large or has no size.
    #[error("cannot make a picture of {width} x {height} pixels: a side has 1 to {most}")]
    Size {
        /// Width asked for, pixels.
        width: f32,
        /// Height asked for, pixels.
        height: f32,
        /// The most pixels of a side.
        most: f32,
    },
}

impl Failure for PlotError {
    fn hint(&self) -> Option<String> {
        matches!(self, Self::Size { .. }).then(|| "ask for another resolution".into())
    }
}
