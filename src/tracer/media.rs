//! The media that light of one wavelength passes through, and the facets that it meets.

use std::f64::consts::PI;
use std::sync::Arc;

use num_complex::Complex64;

use crate::spectrum::optics::{Axis, Crystal, inward, outward};
use crate::spectrum::{Spectrum, kirchhoff};
use crate::table::{Nodes, TableMaterial};

/// What light of one wavelength does at the facets of each material.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    pub(super) wavelength_um: f64,
    pub(super) facets: Vec<Kind>,
    pub(super) media: Vec<Medium>,
}

/// The facets of a material at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// Refractive: the number of the medium within.
    Into(usize),
    /// Opaque, with a reflectance that is the same at every angle.
    Even(f64),
    /// Opaque mirrors of a crystal.
    Mirror(Arc<Crystal>),
    /// The floor's, opaque: the weight leaves its reflectance out.
    Floor(f64),
}

/// A medium at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Medium {
    /// One of them is drawn where a path enters a grain.
    axes: Vec<Along>,
}

/// A medium for an electric field along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Along {
    /// Weights of this axis and of those before it, of 1.
    until: f64,
    dielectric: Complex64,
    pub(super) absorbed_per_um: f64,
}

impl Node {
    /// At each node of a scene.
    pub(super) fn of(nodes: &Nodes, materials: &[TableMaterial]) -> Vec<Self> {
        let of = |(i, um): (usize, &f64)| {
            Self::new(nodes, materials, *um, nodes.opaque.get(i) == Some(&true))
        };
        nodes.wavelength_um.iter().enumerate().map(of).collect()
    }

    fn new(nodes: &Nodes, materials: &[TableMaterial], wavelength_um: f64, opaque: bool) -> Self {
        let mut crystals: Vec<&Arc<Crystal>> = Vec::new();
        let facets = materials.iter().enumerate().map(|(i, material)| match &material.spectrum {
            Spectrum::Refractive(_, crystal) if opaque && material.auto => {
                Kind::Mirror(Arc::clone(crystal))
            }
            Spectrum::Refractive(_, crystal) => {
                let known = crystals.iter().position(|known| *known == crystal);
                Kind::Into(known.unwrap_or_else(|| {
                    crystals.push(crystal);
                    crystals.len() - 1
                }))
            }
            Spectrum::Fresnel(_, crystal) => Kind::Mirror(Arc::clone(crystal)),
            other => {
                let emissivity = other.emissivity(wavelength_um);
                let reflectance = kirchhoff(emissivity.expect("the spectrum holds the bands"));
                let is_floor = nodes.floor == Some(i);
                if is_floor { Kind::Floor(reflectance) } else { Kind::Even(reflectance) }
            }
        });
        let facets = facets.collect();
        let media = crystals.iter().map(|crystal| Medium::new(crystal, wavelength_um)).collect();
        Self { wavelength_um, facets, media }
    }
}

impl Medium {
    fn new(crystal: &Crystal, wavelength_um: f64) -> Self {
        let axes = crystal.axes.each();
        let whole: f64 = axes.iter().map(|(weight, _)| weight).sum();
        let mut until = 0.0;
        let along = |(weight, axis): &(f64, &Axis)| {
            until += weight / whole;
            let dielectric = axis.dielectric(wavelength_um);
            let absorbed_per_um = 4.0 * PI * dielectric.sqrt().im / wavelength_um;
            Along { until, dielectric, absorbed_per_um }
        };
        Self { axes: axes.iter().map(along).collect() }
    }

    pub(super) fn drawn(&self, number: f64) -> Along {
        let last = self.axes[self.axes.len() - 1];
        self.axes.iter().copied().find(|along| number < along.until).unwrap_or(last)
    }
}

/// The media that a path is in.
#[derive(Clone, Default)]
pub(super) struct Inside {
    /// Number of a medium, how many solids of it the path is in, and the axis drawn.
    pub(super) media: Vec<(usize, i32, Along)>,
}

impl Inside {
    /// The one that counts: that of the lowest number.
    pub(super) fn medium(&self) -> Option<(usize, Along)> {
        self.media.iter().map(|(number, _, along)| (*number, *along)).min_by_key(|of| of.0)
    }

    /// The path enters a solid.
    pub(super) fn enter(&mut self, number: usize, along: impl FnOnce() -> Along) {
        match self.media.iter_mut().find(|(known, ..)| *known == number) {
            Some((_, solids, _)) => *solids += 1,
            None => self.media.push((number, 1, along())),
        }
    }

    /// The path leaves a solid. Whether it was in one.
    #[must_use]
    pub(super) fn leave(&mut self, number: usize) -> bool {
        let Some(i) = self.media.iter().position(|(known, ..)| *known == number) else {
            return false;
        };
        self.media[i].1 -= 1;
        if self.media[i].1 == 0 {
            self.media.swap_remove(i);
        }
        true
    }
}

/// Reflectance of a face between two media, and the cosine of the refracted ray; `None` where all is
/// reflected. Vacuum is `None`.
///
/// Of two media the one that absorbs less stands for the vacuum, by its real index.
pub(super) fn crossing(
    before: Option<Along>,
    after: Option<Along>,
    cosine: f64,
) -> Option<(f64, f64)> {
    let one = Complex64::new(1.0, 0.0);
    let [from, to] = [before, after].map(|of| of.map_or(one, |along| along.dielectric));
    let is_inward = match (before, after) {
        (None, _) => true,
        (_, None) => false,
        (Some(a), Some(b)) => a.absorbed_per_um <= b.absorbed_per_um,
    };
    let (outer, inner) = if is_inward { (from, to) } else { (to, from) };
    let index = outer.sqrt().re;
    let relative = inner / (index * index);
    let crossing =
        if is_inward { Some(inward(relative, cosine)) } else { outward(relative, cosine) };
    crossing.map(|crossing| (crossing.reflectance, crossing.cosine))
}
