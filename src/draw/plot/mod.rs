//! Charts, as SVG text and as PNG.
//!
//! A chart is written as SVG by hand: a few shapes and texts, so that every byte is the same on
//! every machine. The PNG is that SVG rendered with a font that the program carries, so that the
//! picture does not depend on the fonts of the machine either.
//!
//! | part | module |
//! |---|---|
//! | shapes and texts to SVG | `svg` |
//! | SVG to PNG, and the font | `raster` |
//! | scales, ticks and their labels | `axis` |
//! | pens, and the names of the curves | `legend` |
//! | places for labels beside a curve | `label` |
//! | the emissivity chart and its curves | `emissivity`, `curve` |
//! | bodies from three sides | `bodies` |
//! | small charts on one page | `atlas` |

mod atlas;
pub(crate) mod axis;
mod bodies;
mod curve;
mod emissivity;
pub(crate) mod label;
pub(crate) mod legend;
mod raster;
pub(crate) mod svg;

use crate::support::error::Failure;

pub use atlas::{Mark, Panel, atlas_svg};
pub use bodies::{Row, Solid, bodies_svg};
pub use curve::Curve;
pub use emissivity::{Chart, emissivity_svg};
pub(crate) use raster::layer;
pub use raster::png;

/// Pixels of a PNG in one unit of the chart.
pub const PIXELS_PER_UNIT: f32 = 2.0;

/// A chart could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// There is nothing to draw.
    #[error("a chart needs a curve with one point at least")]
    Empty,
    /// A curve's columns differ in length.
    #[error(
        "curve '{curve}' has {wavelengths} wavelengths, {emissivities} emissivities and \
         {half_widths} half-widths"
    )]
    Lengths {
        /// The curve's label.
        curve: String,
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of emissivities.
        emissivities: usize,
        /// Number of half-widths.
        half_widths: usize,
    },
    /// A number that cannot be drawn.
    #[error("curve '{curve}', point {point}: the {quantity} is {value}, and must be {expected}")]
    Value {
        /// The curve's label.
        curve: String,
        /// The point, counted from 1.
        point: usize,
        /// What the number is.
        quantity: &'static str,
        /// The number.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// The text is not SVG.
    #[error("cannot render the chart: {0}")]
    Svg(#[from] resvg::usvg::Error),
    /// A picture too large or of no size.
    #[error("a picture of {width} x {height} pixels cannot be made: 1 to {most} a side can")]
    Size {
        /// Width asked for, pixels.
        width: f32,
        /// Height asked for, pixels.
        height: f32,
        /// The most pixels a side.
        most: f32,
    },
    /// The picture could not be packed as PNG.
    #[error("cannot pack the chart as PNG: {0}")]
    Png(#[from] ::png::EncodingError),
}

impl Failure for PlotError {
    fn hint(&self) -> Option<String> {
        match self {
            Self::Size { .. } => Some("ask for another resolution".into()),
            _ => None,
        }
    }
}
