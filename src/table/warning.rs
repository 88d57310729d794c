//! Warnings about a bed or a result that can still be given: cause and remedy.

use serde::{Deserialize, Serialize};

/// Something that may make a result wrong by more than its interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Warning {
    /// Facets are finer than the mesh's coordinates resolve.
    #[error(
        "{:.0} % of the facets of {mesh} are too fine for coordinates that are rounded by \
         {rounding_um:.1e} um: make small parts prototypes of their own, about their own origin",
        100.0 * share
    )]
    TooFine {
        /// The mesh.
        mesh: String,
        /// Share of its facets.
        share: f64,
        /// Rounding of its coordinates, um.
        rounding_um: f64,
    },
    /// A solid has holes.
    #[error(
        "{mesh} is closed but for {edges} of {of} edges, which belong to one facet only. Rays enter \
         it there: mend it if it is to be a solid"
    )]
    Holes {
        /// The mesh.
        mesh: String,
        /// Edges of a single facet.
        edges: usize,
        /// All edges.
        of: usize,
    },
    /// Facets stand for a surface that is curved by its normals.
    #[error(
        "{mesh} stands for a curved surface, from which its facets turn away by {angle_deg:.1} \
         degrees on average: subdivide it"
    )]
    Coarse {
        /// The mesh.
        mesh: String,
        /// Mean angle between facets and normals, degrees.
        angle_deg: f64,
    },
    /// A body is smaller than the wavelength.
    #[error(
        "{mesh} is {size_um:.2e} um long, shorter than the wavelength of {wavelength_um} um. Ray \
         optics does not hold there: check its unit"
    )]
    SmallerThanWaves {
        /// The mesh.
        mesh: String,
        /// Its length, um.
        size_um: f64,
        /// The longest wavelength, um.
        wavelength_um: f64,
    },
    /// Meshes stand where they stand already.
    #[error(
        "{placements} placed meshes stand exactly where the same mesh stands already. They count \
         once: look for doubled objects in the file"
    )]
    Repeated {
        /// How many are left out.
        placements: usize,
    },
    /// Solids pass through each other.
    #[error(
        "solids pass through each other: {:.1} % of the facets lie within another solid. Rays see \
         the outermost surface",
        100.0 * share
    )]
    Overlap {
        /// Share of the facets that lie within another solid.
        share: f64,
    },
    /// Facets lie in a side of the domain.
    #[error(
        "facets of {mesh} lie in a side of the domain, where rays may pass on either side of them: \
         move the side"
    )]
    InSide {
        /// The mesh.
        mesh: String,
    },
    /// The patch is narrow for its bodies.
    #[error(
        "the patch is only {widths:.1} times as wide as its largest body, so others like it differ \
         much: make it wider"
    )]
    NarrowPatch {
        /// Its shorter side in lengths of the largest body.
        widths: f64,
    },
    /// The bed is so shallow that its floor shows.
    #[error(
        "the floor shows: a band changes by {effect:.4} between a black and a white floor; make the \
         bed deeper"
    )]
    Floor {
        /// Greatest change of a band between a black and a white floor.
        effect: f64,
    },
    /// Straight lines between the points of a spectrum miss the curve.
    #[error(
        "the points of {spectrum} are too far apart: straight lines between them miss the curve by \
         about {error:.3} near {at_um} um"
    )]
    Undersampled {
        /// The spectrum's file.
        spectrum: String,
        /// Estimate of the error.
        error: f64,
        /// Where, um.
        at_um: f64,
    },
    /// Near grazing incidence reflectance changes much within one bin of cosines.
    #[error(
        "seen from {zenith_deg} degrees, facets that lie flat are known to {error:.3} only: half of \
         the change of their reflectance within one bin of cosines"
    )]
    GrazingBins {
        /// The view, degrees from nadir.
        zenith_deg: f64,
        /// Half of the change within the bin of the view.
        error: f64,
    },
    /// Mirrors show the sky, whose radiance is taken in bins of its zenith angle.
    #[error(
        "seen from {zenith_deg} degrees, mirrors that lie flat are known to {error:.3} of a black \
         body's radiance only: half of the sky's change over one degree of zenith angle"
    )]
    ZenithBins {
        /// The view, degrees from nadir.
        zenith_deg: f64,
        /// Half of the sky's change from the bin of the view to the next, as a share of a black
        /// body's radiance.
        error: f64,
    },
}
