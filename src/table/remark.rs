//! Warnings about a bed or a result that can still be given: cause and remedy.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What speaks against a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Remark {
    /// Facets are finer than the mesh's coordinates tell apart.
    TooFine {
        /// The mesh.
        mesh: String,
        /// Share of its facets.
        share: f64,
        /// What its coordinates are rounded by, um.
        rounding_um: f64,
    },
    /// A solid has holes.
    Holes {
        /// The mesh.
        mesh: String,
        /// Edges of a single facet.
        edges: usize,
        /// Edges in all.
        of: usize,
    },
    /// Facets stand for a surface that the file says to be curved.
    Coarse {
        /// The mesh.
        mesh: String,
        /// Mean angle between facets and normals, degrees.
        angle_deg: f64,
    },
    /// A body is smaller than the waves.
    SmallerThanWaves {
        /// The mesh.
        mesh: String,
        /// Its length, um.
        size_um: f64,
        /// The longest wavelength, um.
        wavelength_um: f64,
    },
    /// Solids pass through each other.
    Overlap {
        /// Share of the facets that lie within another solid.
        share: f64,
    },
    /// Facets lie in a side of the domain.
    InSide {
        /// The mesh.
        mesh: String,
    },
    /// The patch holds few bodies side by side.
    NarrowPatch {
        /// Its shorter side in lengths of the largest body.
        widths: f64,
    },
    /// The bed is so shallow that its floor shows.
    Floor {
        /// Most that a band changes between a black and a white floor.
        effect: f64,
    },
    /// Straight lines between the points of a spectrum miss the curve.
    Undersampled {
        /// The spectrum's file.
        spectrum: String,
        /// By about so much.
        error: f64,
        /// Where, um.
        at_um: f64,
    },
    /// Near grazing incidence reflectance changes much within one bin of cosines.
    GrazingBins {
        /// The view, degrees from nadir.
        zenith_deg: f64,
        /// Half of the change within the bin of the view.
        error: f64,
    },
    /// Mirrors show the sky, whose radiance is taken in bins of its zenith angle.
    ZenithBins {
        /// The view, degrees from nadir.
        zenith_deg: f64,
        /// Half of what the sky changes by from the bin of the view to the next, as a share of a black body's radiance.
        error: f64,
    },
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFine { mesh, share, rounding_um } => write!(
                f,
                "{:.0} % of the facets of {mesh} are too fine for coordinates that are rounded by \
                 {rounding_um:.1e} um: make small parts prototypes of their own, about their own origin",
                100.0 * share
            ),
            Self::Holes { mesh, edges, of } => write!(
                f,
                "{mesh} is closed but for {edges} of {of} edges, which belong to one facet only: rays get \
                 into it; if it is to be a solid, mend it"
            ),
            Self::Coarse { mesh, angle_deg } => write!(
                f,
                "{mesh} stands for a curved surface, and its facets turn away from it by {angle_deg:.1} \
                 degrees on the mean: subdivide it"
            ),
            Self::SmallerThanWaves { mesh, size_um, wavelength_um } => write!(
                f,
                "{mesh} is {size_um:.2e} um long, below the wavelength of {wavelength_um} um: rays do not \
                 hold there; is its unit right?"
            ),
            Self::Overlap { share } => write!(
                f,
                "solids pass through each other: {:.1} % of the facets lie within another solid; rays see \
                 what is outermost",
                100.0 * share
            ),
            Self::InSide { mesh } => write!(
                f,
                "facets of {mesh} lie in a side of the domain, and rays may go either way there: put the side before \
                 or behind them"
            ),
            Self::NarrowPatch { widths } => write!(
                f,
                "the patch is {widths:.1} of its largest bodies wide: patches of that size differ by much; \
                 make it wider, or take the mean of several"
            ),
            Self::Floor { effect } => write!(
                f,
                "the floor shows: between a black and a white one a band changes by {effect:.4}; make the \
                 bed deeper"
            ),
            Self::Undersampled { spectrum, error, at_um } => write!(
                f,
                "the points of {spectrum} are too far apart: straight lines between them miss it by about \
                 {error:.3} near {at_um} um"
            ),
            Self::GrazingBins { zenith_deg, error } => write!(
                f,
                "seen from {zenith_deg} degrees, facets that lie flat are known to {error:.3} only: that is \
                 half of what their reflectance changes by within one bin of cosines"
            ),
            Self::ZenithBins { zenith_deg, error } => write!(
                f,
                "seen from {zenith_deg} degrees, mirrors that lie flat are known to {error:.3} of a black body's radiance \
                 only: that is half of what the sky changes by from one degree of zenith angle to the next"
            ),
        }
    }
}
