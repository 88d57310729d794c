//! The data of a page.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use serde_json::{Number, Value};

use super::{Run, answer, details_of, limit_of, notes_of, terminal, typeset, warnings_of};
use crate::report::Reached;
use crate::scene::{Inverted, Sky, SpectrumSource};
use crate::signature::Levels;
use crate::signature::budget::Share;
use crate::spectrum::{self, Spectrum};
use crate::table::Table;

/// A run, as the page's script reads it.
#[derive(Serialize)]
pub(super) struct RunData {
    name: String,
    heading: String,
    pub(super) answer: String,
    limit: Option<String>,
    notes: Vec<String>,
    warnings: Vec<String>,
    details: Vec<String>,
    pub(super) windows: BTreeMap<String, String>,
    pub(super) um: Vec<f64>,
    emissivity: Vec<f64>,
    parts: Parts,
    not_included: BTreeMap<&'static str, String>,
    l_target: Vec<f64>,
    l_downwelling: Vec<f64>,
    temperature_k: f64,
    sky_k: Option<f64>,
    /// Why temperature and sky cannot be changed on the page, if they cannot.
    fixed_radiance: Option<String>,
    table: Option<TableData>,
    /// Why there are no sliders, if there are none.
    no_sliders: Option<String>,
    tables: String,
    pub(super) pictures: Vec<PictureData>,
    light: Option<String>,
    files: Vec<(String, &'static str)>,
    record: Option<Value>,
    link: Option<String>,
}

/// Half-widths in emissivity by band.
#[derive(Serialize)]
struct Parts {
    total: Vec<f64>,
    rays: Vec<f64>,
    beds: Option<Vec<f64>>,
    rim: Option<Vec<f64>>,
    floor: Vec<f64>,
    given_up: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    apart: Option<Vec<f64>>,
}

#[derive(Serialize)]
pub(super) struct PictureData {
    data: String,
    text: String,
}

/// The bounce tables of all beds as one.
#[derive(Serialize)]
struct TableData {
    materials: Vec<MaterialData>,
    /// Parts of all paths.
    all: Number,
    /// Most hits on each material.
    most: Vec<u16>,
    /// Parts of paths, then the hits on each material.
    escaped: Vec<Vec<Number>>,
    given_up: Vec<Vec<Number>>,
}

#[derive(Serialize)]
struct MaterialData {
    name: String,
    spectrum: String,
    emissivity: Vec<f64>,
}

/// A spectrum that the page offers.
#[derive(Serialize)]
pub(super) struct Choice {
    name: String,
    emissivity: Vec<f64>,
}

impl Choice {
    /// The shipped spectra, as they are and inverted, that hold all bands.
    pub(super) fn all(um: &[f64]) -> Vec<Self> {
        let powders = spectrum::all().into_iter().filter(|spectrum| !spectrum.is_angular());
        let of = |library: Spectrum| {
            let name = library.name().to_owned();
            let powder = Box::new(SpectrumSource::Builtin(name.clone()));
            let source = Inverted { spectrum: powder, pure_bed: Vec::new() };
            let inverted =
                Spectrum::resolve(&SpectrumSource::Inverted(source), "".as_ref()).ok()?;
            Some([(name.clone(), library), (format!("inverted:{name}"), inverted)])
        };
        let all: Vec<_> = powders.filter_map(of).flatten().collect();
        let choice = |(name, spectrum): &(String, Spectrum)| {
            Some(Self { name: name.clone(), emissivity: sampled(spectrum, um)? })
        };
        all.iter().filter_map(choice).collect()
    }
}

/// The decimals of a CSV file.
fn decimals(values: impl Iterator<Item = f64>) -> Vec<f64> {
    values.map(|value| (value * 1e7).round() / 1e7).collect()
}

/// A spectrum at all bands, to more decimals than results have.
fn sampled(spectrum: &Spectrum, um: &[f64]) -> Option<Vec<f64>> {
    let at = |&um: &f64| Some((spectrum.emissivity(um).ok()? * 1e9).round() / 1e9);
    um.iter().map(at).collect()
}

fn url(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png))
}

impl RunData {
    /// Of a run; one that is alone on its page has more to show.
    pub(super) fn new(run: &Run, alone: bool) -> Self {
        let table = &run.tables[0];
        let r = &run.report.reached;
        let bands = &run.report.bands;
        let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
        let shares = &run.report.budget.bands;
        let part = |of: fn(&Share) -> f64| decimals(shares.iter().map(of));
        let optional = |of: fn(&Share) -> Option<f64>| {
            shares.iter().map(of).collect::<Option<Vec<f64>>>().map(|all| decimals(all.into_iter()))
        };
        let not_exact = table.eq_2_not_exact();
        let (states, no_sliders) = match TableData::new(run.tables, &um) {
            Ok(states) if alone => (Some(states), None),
            Ok(_) => (None, None),
            Err(why) => (None, Some(why)),
        };
        let pictures = run.pictures.iter().filter(|_| alone);
        Self {
            name: run.name.clone(),
            heading: run.heading.clone(),
            answer: answer(r),
            limit: limit_of(r, run.cost),
            notes: notes_of(r),
            warnings: warnings_of(r),
            details: details_of(r),
            windows: windows(r),
            emissivity: decimals(bands.iter().map(|band| band.emissivity.mean)),
            parts: Parts {
                total: part(|share| share.total),
                rays: part(|share| share.rays),
                beds: optional(|share| share.packings),
                rim: optional(|share| share.rim),
                floor: part(|share| share.floor),
                given_up: part(|share| share.given_up),
                apart: optional(|share| share.apart),
            },
            not_included: not_included(r),
            l_target: decimals(bands.iter().map(|band| band.l_target.mean)),
            l_downwelling: bands.iter().map(|band| band.l_downwelling).collect(),
            temperature_k: table.temperature_k,
            sky_k: match table.sky_temperature_k {
                Some(Sky::Isotropic(k)) => Some(k),
                _ => None,
            },
            fixed_radiance: (!not_exact.is_empty()).then(|| not_exact.join(" and ")),
            table: states,
            no_sliders,
            tables: run.table_files.clone(),
            pictures: pictures
                .map(|picture| PictureData { data: url(&picture.png), text: picture.text.clone() })
                .collect(),
            light: run.light.as_deref().filter(|_| alone).map(url),
            files: run.files.clone(),
            record: run.record.clone().filter(|_| alone),
            link: run.link.clone(),
            um,
        }
    }

    /// Makes the page smaller by its controls.
    pub(super) fn leave_out_table(&mut self) {
        if self.table.take().is_some() {
            self.light = None;
            self.no_sliders = Some(
                "The bounce table is too large for this page: soilsig signature evaluates it for \
                 other spectra."
                    .into(),
            );
        }
    }
}

/// The mean of each window with its half-width.
fn windows(r: &Reached) -> BTreeMap<String, String> {
    let of = |window: &crate::signature::Window| {
        let [mean, width] = [window.emissivity, window.half_width_95]
            .map(|x| terminal::number(x, window.half_width_95));
        (span(window), format!("{mean} ± {width}"))
    };
    r.windows.iter().map(of).collect()
}

/// The wavelengths of a window, which is its name.
pub(super) fn span(window: &crate::signature::Window) -> String {
    typeset(&terminal::span(window))
}

/// What the total does not hold, in the widest band.
fn not_included(r: &Reached) -> BTreeMap<&'static str, String> {
    let share = &r.budget;
    let up_to = |part: f64| format!("up to {part:.4}");
    let mut parts = BTreeMap::new();
    parts.extend(share.facets.map(|part| ("number of facets of grains", up_to(part))));
    let unknown = match &r.spectra_unknown[..] {
        [] => String::new(),
        names => format!(", unknown for {}", names.join(", ")),
    };
    parts.insert("errors of spectra", format!("{:.4}{unknown}", share.spectra));
    parts.insert("straight lines between bands", format!("{:.4}", share.spectral_step));
    parts
}

/// Parts of paths by the hits on each material.
type Sums = BTreeMap<Vec<u16>, f64>;

impl TableData {
    /// The mean over all beds, or why the page cannot evaluate it.
    fn new(tables: &[Table], um: &[f64]) -> Result<Self, String> {
        let first = &tables[0];
        let (kept, count) = (first.histogram.kept, first.materials.len());
        if kept.nodes > 0 {
            return Err("Light that passes through grains is traced wavelength by wavelength: \
                        other spectra take another trace."
                .into());
        }
        if kept.cosines > 1 {
            return Err("The reflectance of mirrors depends on the angle of each hit, which this \
                        page does not evaluate: soilsig signature does."
                .into());
        }
        let hits = |state: &[u16]| -> Vec<u16> {
            if !kept.lists() {
                return state.into();
            }
            let mut hits = vec![0; count];
            for &symbol in state {
                hits[usize::from(symbol) / kept.of_material()] += 1;
            }
            hits
        };
        let total = |table: &Table| table.histogram.met().iter().sum::<f64>();
        let all = total(first);
        let (mut escaped, mut given_up) = (Sums::new(), Sums::new());
        for (table, weight) in tables.iter().zip(Levels::of(tables).weights()) {
            let weight = all / total(table) * weight;
            let parts = |of: &[(u16, i64)]| weight * of.iter().map(|(_, n)| *n as f64).sum::<f64>();
            for (state, of) in &table.histogram.escaped {
                *escaped.entry(hits(kept.split(state).0)).or_default() += parts(of);
            }
            for (state, of) in &table.histogram.given_up {
                *given_up.entry(hits(state)).or_default() += parts(of);
            }
        }
        let mut most = vec![0; count];
        for state in escaped.keys().chain(given_up.keys()) {
            most.iter_mut().zip(state).for_each(|(most, &n)| *most = n.max(*most));
        }
        let material = |m: &crate::table::TableMaterial| {
            let emissivity = sampled(&m.spectrum, um).ok_or("A spectrum has gaps.")?;
            let spectrum = m.spectrum.name().to_owned();
            Ok::<_, String>(MaterialData { name: m.name.clone(), spectrum, emissivity })
        };
        Ok(Self {
            materials: first.materials.iter().map(material).collect::<Result<_, _>>()?,
            all: number(all),
            most,
            escaped: listed(&escaped),
            given_up: listed(&given_up),
        })
    }
}

fn listed(sums: &Sums) -> Vec<Vec<Number>> {
    let one = |(hits, parts): (&Vec<u16>, &f64)| {
        [number(*parts)].into_iter().chain(hits.iter().map(|&n| n.into())).collect()
    };
    sums.iter().map(one).collect()
}

/// A number, short where it is whole.
fn number(value: f64) -> Number {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        (value as i64).into()
    } else {
        Number::from_f64(value).expect("it is finite")
    }
}
