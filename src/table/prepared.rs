//! A scene with the contents of its files except meshes, read once.

use std::borrow::Cow;
use std::sync::Arc;

use super::materials::{MaterialError, ResolveError, reflectances, specular};
use super::{Nodes, TableMaterial};
use crate::histogram::kept::{COSINES, Kept, ZENITHS};
use crate::radiometry::air::{Air, air};
use crate::scene::{Layers, Material, Scene, SpectrumSource};
use crate::spectrum::Spectrum;
use crate::support::error::Error;

/// A scene whose spectra, sky and atmosphere are known and cover the bands.
///
/// Scenes of one recipe differ in geometry and seed only and share the rest.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The scene.
    pub scene: Scene,
    /// The materials with their spectra.
    pub materials: Arc<[TableMaterial]>,
    /// The sky and the atmosphere.
    pub air: Arc<Air>,
    /// The bands, um.
    pub wavelengths_um: Arc<[f64]>,
    /// In each band the reflectance of each symbol of a histogram.
    pub reflectances: Arc<[Vec<f64>]>,
    /// What has to be recorded of each path.
    pub kept: Kept,
    /// The wavelengths at which paths are traced apart, if facets are refractive.
    pub nodes: Option<Nodes>,
}

impl Prepared {
    /// Reads the files that a scene names for spectra, sky and atmosphere.
    ///
    /// # Errors
    /// A file cannot be read or does not cover the bands.
    pub fn new(scene: Scene, wavelengths_um: &[f64]) -> Result<Self, Error> {
        let materials = resolved(&scene)?;
        Self::of(scene, materials, wavelengths_um)
    }

    fn of(
        scene: Scene,
        materials: Vec<TableMaterial>,
        wavelengths_um: &[f64],
    ) -> Result<Self, Error> {
        if let Some(nodes) = Nodes::of(&scene, &materials, wavelengths_um)? {
            return Self::with_nodes(scene, materials, wavelengths_um, nodes);
        }
        let angular = materials.iter().any(|m| m.spectrum.is_angular());
        let kept = Kept {
            order: scene.is_of_temperatures(),
            cosines: if angular { COSINES } else { 1 },
            zeniths: if scene.sky_is_by_zenith() { ZENITHS } else { 1 },
            nodes: 0,
            layers: scene.temperature_k.layers().map_or(0, Layers::count),
        };
        for material in &materials {
            reflectances(&[&material.spectrum], kept, wavelengths_um)
                .map_err(|source| wrong(&scene, &material.name, source.into()))?;
        }
        let spectra: Vec<&Spectrum> = materials.iter().map(|m| &m.spectrum).collect();
        Ok(Self {
            air: air(&scene, wavelengths_um)?.into(),
            reflectances: reflectances(&spectra, kept, wavelengths_um)?.into(),
            wavelengths_um: wavelengths_um.into(),
            materials: materials.into(),
            kept,
            nodes: None,
            scene,
        })
    }

    fn with_nodes(
        scene: Scene,
        materials: Vec<TableMaterial>,
        wavelengths_um: &[f64],
        nodes: Nodes,
    ) -> Result<Self, Error> {
        let ends = [wavelengths_um[0], wavelengths_um[wavelengths_um.len() - 1]];
        for material in &materials {
            let held = material.spectrum.covers(ends);
            held.map_err(|source| wrong(&scene, &material.name, source.into()))?;
            if !material.spectrum.is_refractive() {
                let each = wavelengths_um
                    .iter()
                    .try_for_each(|&um| material.spectrum.emissivity(um).map(|_| ()));
                each.map_err(|source| wrong(&scene, &material.name, source.into()))?;
            }
        }
        Ok(Self {
            air: air(&scene, wavelengths_um)?.into(),
            reflectances: nodes.reflectances(&materials, wavelengths_um)?.into(),
            wavelengths_um: wavelengths_um.into(),
            materials: materials.into(),
            kept: Kept { nodes: nodes.wavelength_um.len() as u16, ..Kept::PLAIN },
            nodes: Some(nodes),
            scene,
        })
    }

    /// Where `auto` facets are opaque, for the mean chord of each material, um: in the bands in which
    /// the smallest grains of a crystal let through at most this share of diffuse light. Facets that
    /// are opaque in all bands become `fresnel` ones.
    ///
    /// # Errors
    /// Those of [`Prepared::new`].
    pub fn decided(&self, chords_um: &[Option<f64>], most: f64) -> Result<Cow<'_, Self>, Error> {
        let Some(nodes) = self.nodes.as_ref().filter(|_| self.materials.iter().any(|m| m.auto))
        else {
            return Ok(Cow::Borrowed(self));
        };
        let mut materials = self.materials.to_vec();
        for (material, chord) in materials.iter_mut().zip(chords_um) {
            material.mean_chord_um = *chord;
        }
        let is_opaque = |um: &f64, scale: f64| {
            let smaller = |m: &TableMaterial| {
                let mean_chord_um = m.mean_chord_um.map(|chord| scale * chord);
                TableMaterial { mean_chord_um, ..m.clone() }.lets_through(*um)
            };
            materials.iter().filter_map(smaller).all(|share| share <= most)
        };
        // Packings of a recipe differ a little in the size of their grains, and all go one way.
        if materials.iter().all(|m| m.auto || !m.spectrum.is_refractive())
            && self.wavelengths_um.iter().all(|um| is_opaque(um, 0.5))
        {
            let materials = self.materials.iter().cloned().map(TableMaterial::opaque).collect();
            return Ok(Cow::Owned(Self::of(self.scene.clone(), materials, &self.wavelengths_um)?));
        }
        let opaque = nodes.wavelength_um.iter().map(|um| is_opaque(um, 1.0)).collect();
        let nodes = Some(Nodes { opaque, ..nodes.clone() });
        Ok(Cow::Owned(Self { nodes, ..self.clone() }))
    }

    /// The same with another scene of the same materials and sky.
    #[must_use]
    pub fn with(&self, scene: Scene) -> Self {
        Self { scene, ..self.clone() }
    }

    /// The spectra of the materials.
    pub fn spectra(&self) -> Vec<&Spectrum> {
        self.materials.iter().map(|m| &m.spectrum).collect()
    }
}

/// The materials of a scene with their spectra.
pub(crate) fn resolved(scene: &Scene) -> Result<Vec<TableMaterial>, MaterialError> {
    let of = |material: &Material| {
        let spectrum = Spectrum::resolve(&material.spectrum, scene.folder())
            .map_err(|source| wrong(scene, &material.name, source))?;
        Ok(TableMaterial {
            name: material.name.clone(),
            specular: specular(material, &spectrum),
            spectrum,
            auto: matches!(material.spectrum, SpectrumSource::Auto(_)),
            temperature_k: material.temperature_k,
            mean_chord_um: None,
            first_hits: 0,
        })
    };
    scene.materials.iter().map(of).collect()
}

fn wrong(scene: &Scene, material: &str, source: ResolveError) -> MaterialError {
    let (file, material) = (scene.file.clone(), material.to_owned());
    MaterialError { scene: file, material, source: Box::new(source) }
}
