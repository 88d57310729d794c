//! The scene that represents the soil best: its recipe, bed, picture and signature.

use std::path::{Path, PathBuf};

use super::beds::{Settled, Source};
use super::estimation::{Estimation, Observed};
use super::facets::FacetModel;
use super::result::Best;
use super::soil::{COVER, LEVEL, MEDIUM, On, SECOND};
use super::{Options, summary};
use crate::pipeline::{self, HowMany};
use crate::scene::{Component, Constants, Grid, Inverted, Scene, SceneGeometry, SpectrumSource};
use crate::signature;
use crate::support::error::Error;
use crate::support::output;
use crate::table::Table;

/// The recipe and the folder of the best scene, below the result's folder.
const RECIPE: &str = "best_recipe.json";
const FOLDER: &str = "best";

/// Half-width of the 95 % interval of the best scene's signature.
const TOLERANCE: f64 = 0.005;

/// Distance of its bands, um.
const STEP_UM: f64 = 0.01;

/// The best scene, dropped and traced.
pub struct Found {
    table: PathBuf,
}

/// Writes the recipe of the best scene and runs the pipeline on it.
pub fn drop(options: &Options, source: &Source, best: &[f64]) -> Result<(Settled, Found), Error> {
    let cover = best[COVER];
    let recipe = options.out.join(RECIPE);
    let mut scene = source.covered(cover);
    "best".clone_into(&mut scene.name);
    scene.description = Some(format!(
        "The soil of {}: {:.0} % of the grains' silhouettes are fines",
        options.spectrum.file_name().unwrap_or_default().to_string_lossy(),
        100.0 * cover,
    ));
    stand_alone(&mut scene);
    let grains = grains(&scene);
    for material in &mut scene.materials {
        let is_grain = grains.contains(&material.name);
        let has_second = match options.on {
            On::All => true,
            On::Grains => is_grain,
            On::Fines => !is_grain,
        };
        let mut own = vec![(1.0, facets(options.facets, &material.spectrum, is_grain))];
        if is_grain {
            let medium = SpectrumSource::Builtin("quartz_medium".into());
            own[0].0 -= best[MEDIUM];
            own.push((best[MEDIUM], facets(options.facets, &medium, true)));
        }
        let share = if has_second { best[SECOND] } else { 0.0 };
        material.spectrum = mixed(own, share, options.second.as_ref(), best[LEVEL]);
    }
    let text = serde_json::to_string_pretty(&scene).expect("plain data");
    output::bytes(&recipe, (text + "\n").as_bytes())?;
    let um = options.seen.um();
    let round = |um: f64, to: fn(f64) -> f64| to(um / STEP_UM) * STEP_UM;
    let (from, to) = (round(um[0], f64::ceil), round(um[um.len() - 1], f64::floor));
    let grid = Grid::new(from, to, STEP_UM).expect("the bands are wavelengths");
    let run = pipeline::Options {
        source: pipeline::Source::Scene(std::path::absolute(&recipe).unwrap_or(recipe)),
        set: Vec::new(),
        facets: None,
        grains: None,
        seed: None,
        packings: HowMany::Number(1),
        field: None,
        tolerance: Some(TOLERANCE),
        max_paths: 1 << 26,
        max_seconds: None,
        grid,
        patch_obj: false,
        blender: options.blender.clone(),
        blender_timeout_s: options.time_limit.as_secs(),
    };
    let out = options.out.join(FOLDER);
    pipeline::run(&run, options.command.clone(), &out, options.cache, options.monitor)?;
    let bed = Settled::read(Scene::read(&out.join("scene.json"))?, false)?;
    Ok((bed, Found { table: out.join("table.json") }))
}

/// Facets of several kinds with a share of the second component. Mirrors are left as they are: a
/// mix is Lambertian.
fn mixed(
    own: Vec<(f64, SpectrumSource)>,
    share: f64,
    second: Option<&SpectrumSource>,
    level: f64,
) -> SpectrumSource {
    if matches!(own[0].1, SpectrumSource::Fresnel(_)) {
        return own.into_iter().next().expect("facets have a spectrum").1;
    }
    let second = second.cloned().unwrap_or(SpectrumSource::Constant(level));
    let mut all: Vec<Component> = (own.into_iter().map(|(of, own)| ((1.0 - share) * of, own)))
        .chain([(share, second)])
        .filter(|(share, _)| *share >= LEAST_SHARE)
        .map(|(share, spectrum)| Component { share, spectrum })
        .collect();
    if all.len() == 1 { all.remove(0).spectrum } else { SpectrumSource::Mix(all) }
}

/// The least share of a component that a mix names.
const LEAST_SHARE: f64 = 1e-4;

/// Names files by their full paths, so that the recipe can lie in another folder.
fn stand_alone(scene: &mut Scene) {
    let folder = scene.folder().to_owned();
    let absolute = |path: &Path| {
        let path = folder.join(path);
        std::path::absolute(&path).unwrap_or(path)
    };
    for file in scene.files_mut() {
        *file.path = absolute(file.path);
    }
    if let SceneGeometry::Packing(packing) = &mut scene.geometry
        && let Some(library) = &mut packing.library
    {
        *library = absolute(library);
    }
}

/// The materials of the grains' bodies.
fn grains(scene: &Scene) -> Vec<String> {
    match &scene.geometry {
        SceneGeometry::Packing(packing) => {
            packing.grains.iter().map(|class| class.material.clone()).collect()
        }
        SceneGeometry::Placed(_) => Vec::new(),
    }
}

/// The source of facets of a kind, for the powder that a source names.
fn facets(model: FacetModel, of: &SpectrumSource, is_grain: bool) -> SpectrumSource {
    let powder = match of {
        SpectrumSource::Inverted(inverted) => (*inverted.spectrum).clone(),
        other => other.clone(),
    };
    match model {
        FacetModel::Library => powder,
        FacetModel::Fresnel if is_grain => {
            SpectrumSource::Fresnel(Constants::Shipped("quartz".into()))
        }
        FacetModel::Inverted | FacetModel::Fresnel => match powder {
            SpectrumSource::Fresnel(_)
            | SpectrumSource::Refractive(_)
            | SpectrumSource::Auto(_)
            | SpectrumSource::Mix(_) => powder,
            powder => {
                let (spectrum, pure_bed) = (Box::new(powder), Vec::new());
                SpectrumSource::Inverted(Inverted { spectrum, pure_bed })
            }
        },
    }
}

impl Found {
    /// How the best scene's own signature compares with what was measured, and with the fit. Its
    /// bed has the cover that is given.
    pub fn compared(
        &self,
        cover: f64,
        observed: &Observed,
        found: &Estimation,
    ) -> Result<Best, Error> {
        let table = Table::read(&self.table)?;
        let curves = signature::curves(std::slice::from_ref(&table), &observed.um)?;
        let residuals = summary::residuals(observed, found);
        let n = observed.um.len() as f64;
        let mean = |of: &dyn Fn(usize) -> f64| (0..observed.um.len()).map(of).sum::<f64>() / n;
        let off = |i: usize| observed.bands[i] - curves[0][i];
        Ok(Best {
            recipe: RECIPE.into(),
            cover,
            rms: mean(&|i| off(i).powi(2)).sqrt(),
            bias: mean(&|i| off(i) - residuals[i]),
        })
    }
}
