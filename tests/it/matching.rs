//! From a signature back to the soil, on a bed that needs no Blender.

use std::ops::Range;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use serde_json::Value;
use soilsig::histogram::kept::Kept;
use soilsig::inverse::beds::{self, Settled, Traced};
use soilsig::inverse::estimation::{Fitting, Model, Observed, Parameter};
use soilsig::inverse::facets::FacetModel;
use soilsig::inverse::soil::{COVER, LARGE, LEVEL, MEDIUM, On, Role, SECOND, Second, Soil};
use soilsig::inverse::thinning::{self, Fines, Paths};
use soilsig::radiometry::planck;
use soilsig::scene::{Scene, shipped as recipes};
use soilsig::support::cache::Cache;
use soilsig::support::math;
use soilsig::support::monitor::Unwatched;
use soilsig::table::materials::reflectances;
use soilsig::table::{Prepared, TableMaterial};
use soilsig::tracer::Tracer;
use soilsig::tracer::rules::{Facet, TracingRules};

use crate::support::{Noise, Place, a_blender, shipped, shipped_path};

const SEED: u64 = 7;

fn patch() -> Scene {
    Scene::read(&shipped_path("settled_patch.json")).expect("a shipped scene")
}

fn um() -> Vec<f64> {
    (0..60).map(|i| 7.6 + 0.1 * f64::from(i)).collect()
}

fn materials(facets: FacetModel) -> Vec<TableMaterial> {
    let all = Prepared::new(patch(), &um()).expect("its spectra").materials;
    facets.of(&all, |number| all[number].name == "coarse").expect("shipped constants")
}

fn bands(facets: FacetModel) -> Vec<Vec<f64>> {
    let materials = materials(facets);
    let spectra: Vec<_> = materials.iter().map(|m| &m.spectrum).collect();
    reflectances(&spectra, Kept::PLAIN, &um()).expect("in range")
}

/// Beds traced with facets of a kind.
fn trace(beds: &[Settled], facets: FacetModel, cache: &Cache) -> Traced {
    beds::trace(beds, &materials(facets), &bands(facets), SEED, cache, &Unwatched).expect("traced")
}

/// The shipped patch, thinned in steps and traced.
fn traced(facets: FacetModel) -> &'static Traced {
    static ALL: [OnceLock<Traced>; 2] = [OnceLock::new(), OnceLock::new()];
    ALL[usize::from(facets == FacetModel::Fresnel)].get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = Cache::new(folder.path().to_owned());
        let bed = Settled::read(patch(), true).expect("its meshes");
        trace(&[bed], facets, &cache)
    })
}

fn parameter(name: &str, prior: f64, sd: f64, bounds: [f64; 2]) -> Parameter {
    let (name, unit) = (name.to_owned(), String::new());
    Parameter { name, unit, prior, prior_standard_deviation: sd, bounds }
}

fn soil(facets: FacetModel, on: On, second: Option<Vec<f64>>) -> Soil {
    soil_of(traced(facets), facets, on, second)
}

fn soil_of(traced: &Traced, facets: FacetModel, on: On, second: Option<Vec<f64>>) -> Soil {
    let Traced { full, fresh, roles, large_share } = traced;
    let covers = Soil::covers(full);
    let parameters = vec![
        parameter("cover", 0.5 * covers[1], 0.5, covers),
        parameter("second", 0.3, 0.3, [0.0, 0.95]),
        parameter("level", 0.95, 0.02, [0.8, 1.0]),
        parameter("large_fines", *large_share, 0.0, [0.0, 0.6]),
        parameter("medium_grains", 0.0, 0.0, [0.0, 1.0]),
    ];
    let second = Second { emissivity: second, on };
    let (full, fresh) = (full.clone(), fresh.clone());
    let materials = materials(facets);
    let medium = facets.medium(&materials[1].spectrum).expect("shipped");
    Soil::new(&um(), parameters, second, (&materials, roles), medium.as_ref(), full, fresh)
        .expect("in range")
}

#[test]
fn fines_and_grains_are_told_apart_by_their_parts() {
    let Traced { roles, large_share, full, .. } = traced(FacetModel::Library);
    // The floor has the spectrum of the fines.
    assert_eq!(roles, &[Role::Fines, Role::Grains, Role::Fines]);
    assert!((0.0..1.0).contains(large_share));
    let covers: Vec<f64> = full[0].steps.iter().map(|step| step.cover).collect();
    assert_eq!(covers[0], 0.0);
    assert!(covers.is_sorted_by(|a, b| a < b), "{covers:?}");
}

/// Each derivative against central differences, with each place of the second component.
#[test]
fn every_derivative_of_the_traced_model_is_that_of_differences() {
    let top = Soil::covers(&traced(FacetModel::Library).full)[1];
    let mineral: Vec<f64> = um().iter().map(|um| 0.9 + 0.05 * math::sin_cos(*um).0).collect();
    for (facets, on, second) in [
        (FacetModel::Library, On::All, None),
        (FacetModel::Inverted, On::Fines, None),
        (FacetModel::Inverted, On::Grains, Some(mineral)),
        (FacetModel::Fresnel, On::All, None),
    ] {
        let has_level = second.is_none();
        let model = soil(facets, on, second);
        let x = [0.43 * top, 0.3, 0.95, 0.15, 0.2];
        let slopes = model.evaluate(&x).slopes;
        for place in [COVER, SECOND, LEVEL, LARGE, MEDIUM] {
            let step = 1e-6;
            let moved = |step: f64| {
                let mut x = x;
                x[place] += step;
                model.evaluate(&x).bands
            };
            let mut largest = 0.0_f64;
            for (band, (up, down)) in moved(step).iter().zip(moved(-step)).enumerate() {
                let differences = (up - down) / (2.0 * step);
                let found = slopes[place][band];
                assert!(
                    (differences - found).abs() < 1e-6 * (1.0 + found.abs()),
                    "{facets:?} {place} {band}: {found} {differences}"
                );
                largest = largest.max(found.abs());
            }
            // The patch has too few fines for their sizes to tell.
            let has_none = place == MEDIUM && facets == FacetModel::Fresnel;
            assert!(
                largest > 1e-3 || place == LARGE || !has_level || has_none,
                "{facets:?} {place}"
            );
        }
    }
}

/// The model between its steps against a plain trace of the bed with as many fines, by other paths.
#[test]
fn the_model_at_a_cover_is_what_a_trace_of_that_bed_gives() {
    let scene = patch();
    let bed = thinning_bed(&scene);
    let fines = Fines::of(bed.bed(), &scene, SEED).expect("it has fines");
    let materials = materials(FacetModel::Library);
    let rules = TracingRules::of_facets(Kept::PLAIN, vec![Facet::LAMBERTIAN; materials.len()]);
    let model = soil(FacetModel::Library, On::All, None);
    let paths = Paths { rules: &rules, seed: SEED + 1, number: 1 << 14 };
    for kept in [0.31, 0.62] {
        let plain = thinning::steps(&bed, &scene, &fines, paths, &[[kept; 2]], &Unwatched);
        let plain = &plain.expect("traced")[0];
        let found =
            model.evaluate(&[plain.cover, 0.0, 0.95, traced(FacetModel::Library).large_share, 0.0]);
        let spectra = bands(FacetModel::Library);
        for (band, rho) in spectra.iter().enumerate() {
            let weight = plain.histogram.weight(rho);
            let off = found.bands[band] - (1.0 - weight.mean);
            // The noise of either trace, and what a cubic misses between two steps.
            let allowed = 4.0 * 2.0_f64.sqrt() * weight.standard_error + 1e-3;
            assert!(off.abs() < allowed, "{kept} {band}: {off} of {allowed}");
        }
    }
}

fn thinning_bed(scene: &Scene) -> Tracer {
    soilsig::tracer::trace::tracer(scene).expect("its meshes")
}

/// A discrepancy that the fit does not know: a few broad bumps.
fn bumps(um: &[f64], size: f64, random: &mut Noise) -> Vec<f64> {
    let of: Vec<(f64, f64, f64)> = (0..14)
        .map(|i| (7.4 + 0.45 * f64::from(i), 0.3 + 0.1 * random.normal().abs(), random.normal()))
        .collect();
    let at = |um: f64| -> f64 {
        let bump = |(centre, width, height): &(f64, f64, f64)| {
            height * math::exp(-0.5 * ((um - centre) / width).powi(2))
        };
        size * of.iter().map(bump).sum::<f64>()
    };
    um.iter().map(|&um| at(um)).collect()
}

/// Soils of one model with noise and a discrepancy, matched with another: how many of their covers
/// and shares of the second component lie in their 95 % intervals, and the mean standard errors.
fn twins(truths: &Soil, model: &Soil, which: Range<u32>) -> ([u32; 2], [f64; 2]) {
    let um = um();
    let top = model.parameters()[COVER].bounds[1].min(truths.parameters()[COVER].bounds[1]);
    let mut random = Noise(5 + u64::from(which.start));
    let number = which.len() as f64;
    let (mut held, mut errors) = ([0, 0], [0.0; 2]);
    for twin in which {
        let [a, b] = [0.618_034, 0.754_878].map(|step| (f64::from(twin) * step).fract());
        let truth =
            [top * (0.05 + 0.9 * a), 0.05 + 0.5 * b, 0.95, model.parameters()[LARGE].prior, 0.0];
        let off = bumps(&um, 0.008, &mut random);
        let clean = truths.evaluate(&truth).bands;
        let bands = clean.iter().zip(&off).map(|(e, off)| e + off + 0.003 * random.normal());
        let bands: Vec<f64> = bands.collect();
        let observed = Observed { bands, errors: vec![0.003; um.len()], um: um.clone() };
        let found = Fitting::new(model, &observed).run(SEED, None);
        assert!(found.draws.iter().all(|draw| (0.0..=top.max(1.0)).contains(&draw[COVER])));
        for (i, place) in [COVER, SECOND].into_iter().enumerate() {
            let mut draws: Vec<f64> = found.draws.iter().map(|draw| draw[place]).collect();
            draws.sort_by(f64::total_cmp);
            let at = |share: f64| draws[(share * draws.len() as f64) as usize];
            held[i] += u32::from((at(0.025)..=at(0.975)).contains(&truth[place]));
            errors[i] += (at(0.84) - at(0.16)) / 2.0 / number;
        }
    }
    (held, errors)
}

#[test]
fn twins_lie_within_their_intervals() {
    let model = soil(FacetModel::Inverted, On::All, None);
    let (held, _) = twins(&model, &model, 0..16);
    // Of 16 with a probability of .95 each, 12 or fewer are one in a hundred.
    assert!(held.iter().all(|&held| held >= 13), "{held:?}");
}

/// `make twins`: 200 twins of the model's own beds, of one bed of each cover that the model never
/// saw, and of the mean of seven. The mean is the soil, as far as they tell; one bed has its own
/// chance, which the fit does not count. Each of eight beds is the model once.
#[test]
#[ignore = "takes a quarter of an hour, and a Blender"]
fn two_hundred_twins() {
    const BEDS: usize = 8;
    const EACH: u32 = 200 / BEDS as u32;
    let Some(blender) = a_blender() else { return };
    let text = recipes::text("full").expect("it is shipped");
    let scene = Scene::parse(text, Path::new("full.json")).expect("a scene");
    let cache = Cache::of_user();
    let source = beds::Source {
        scene: &scene,
        is_shipped: true,
        beds: BEDS,
        blender: Some(blender),
        time_limit: Duration::from_secs(600),
        cache: &cache,
        monitor: &Unwatched,
    };
    let facets = FacetModel::Inverted;
    // The beds of each cover follow each other. Each is traced once.
    let all = trace(&source.settle().expect("dropped"), facets, &cache);
    let of = |keeps: &dyn Fn(usize) -> bool| {
        let full = (all.full.iter().enumerate()).filter(|(i, _)| keeps(*i));
        let fresh = (all.fresh.iter().enumerate()).filter(|(i, _)| keeps(i % BEDS));
        let kept = Traced {
            full: full.map(|(_, bed)| bed.clone()).collect(),
            fresh: fresh.map(|(_, bed)| bed.clone()).collect(),
            roles: all.roles.clone(),
            large_share: all.large_share,
        };
        soil_of(&kept, facets, On::All, None)
    };
    let mut sums = [([0, 0], [0.0; 2]); 3];
    for model in 0..BEDS {
        let other = (model + 1) % BEDS;
        let ours = of(&|bed| bed == model);
        let truths = [None, Some(of(&|bed| bed == other)), Some(of(&|bed| bed != model))];
        for (sum, truth) in sums.iter_mut().zip(&truths) {
            let first = model as u32 * EACH;
            let (held, errors) = twins(truth.as_ref().unwrap_or(&ours), &ours, first..first + EACH);
            println!("model {model}: {held:?} of {EACH}, {errors:.3?}");
            for i in 0..2 {
                sum.0[i] += held[i];
                sum.1[i] += errors[i] / BEDS as f64;
            }
        }
    }
    let names =
        ["its own beds", "one bed of each cover that it never saw", "the mean of seven others"];
    for (name, (held, errors)) in names.into_iter().zip(sums) {
        println!(
            "twins of {name}: in their 95 % intervals are {:.1} % of the covers and {:.1} % of the \
             shares; mean standard errors {:.3} and {:.3}",
            f64::from(held[0]) / 2.0,
            f64::from(held[1]) / 2.0,
            errors[0],
            errors[1]
        );
        assert!(held.iter().all(|held| *held >= 180), "{name}: {held:?} of 200");
    }
}

fn signature_of(place: &Place, name: &str, um: &[f64]) {
    let rows: String = um.iter().map(|um| format!("{um},0.9\n")).collect();
    place.write(name, format!("wavelength_um,emissivity\n{rows}"));
}

fn signature(place: &Place, name: &str, emissivity: impl Fn(f64) -> f64) {
    let rows: String = um().iter().map(|um| format!("{um},{}\n", emissivity(*um))).collect();
    place.write(name, format!("wavelength_um,emissivity\n{rows}"));
}

#[test]
fn a_match_writes_its_files_and_gives_the_same_bytes_again() {
    let place = Place::new();
    let model = soil(FacetModel::Inverted, On::All, None);
    let top = Soil::covers(&traced(FacetModel::Inverted).full)[1];
    let curve = model.evaluate(&[0.6 * top, 0.2, 0.95, 0.2, 0.0]).bands;
    let um = um();
    signature(&place, "soil.csv", |at| curve[um.iter().position(|um| *um == at).expect("a band")]);
    let scene = shipped("settled_patch.json");
    let args = ["match", "soil.csv", "--scene", &scene, "--out", "m"];
    let (out, _) = place.run(&args, 0);
    assert!(out.starts_with("cover with fines 0."), "{out}");
    let first = std::fs::read(place.path("m/match.json")).expect("written");
    place.run(&args, 0);
    assert_eq!(first, std::fs::read(place.path("m/match.json")).expect("written"));
    let result: Value = place.json("m/match.json");
    let cover = &result["answer"]["parameters"][0];
    let number = |value: &Value| value.as_f64().expect("a number");
    let off = (number(&cover["best"]) - 0.6 * top).abs();
    assert!(off < 3.0 * number(&cover["standard_error"]), "{cover}");
    let schema = soilsig::cli::schema::of(soilsig::cli::schema::Format::Match);
    assert!(jsonschema::is_valid(&schema, &result));
    let smoothness = &result["answer"]["discrepancy"]["smoothness"];
    assert!(["rough", "smooth"].iter().any(|of| smoothness == of), "{smoothness}");
    for file in
        ["match.csv", "match.svg", "match.png", "posterior.svg", "posterior.png", "match.txt"]
    {
        assert!(place.path("m").join(file).is_file(), "{file}");
    }
}

/// Radiance of a warm soil under a sky with lines, noise of .02 W m-2 sr-1 um-1.
#[test]
fn radiance_gives_the_soil_and_its_temperature() {
    const KELVIN: f64 = 310.0;
    let place = Place::new();
    let model = soil(FacetModel::Library, On::All, None);
    let top = Soil::covers(&traced(FacetModel::Library).full)[1];
    let truth = [0.5 * top, 0.25, 0.95];
    let curve = model.evaluate(&[truth[0], truth[1], truth[2], 0.2, 0.0]).bands;
    let mut random = Noise(11);
    let (mut sky, mut radiance) = (String::new(), String::new());
    for (um, emissivity) in um().into_iter().zip(curve) {
        let share = 0.3
            + 0.5 * math::exp(-(4.0 * (um - 9.6)).powi(2))
            + 0.15 * math::sin_cos(19.0 * um).0.powi(2);
        let l_downwelling = share * planck(um, 265.0);
        let l_target = emissivity * planck(um, KELVIN) + (1.0 - emissivity) * l_downwelling;
        sky += &format!("{um},{l_downwelling}\n");
        radiance += &format!("{um},{}\n", l_target + 0.02 * random.normal());
    }
    place.write("sky.csv", format!("wavelength_um,l_downwelling_w_m2_sr_um\n{sky}"));
    place.write("seen.csv", format!("wavelength_um,l_target_w_m2_sr_um\n{radiance}"));
    let scene = shipped("settled_patch.json");
    let args = ["match", "seen.csv", "--sky", "sky.csv", "--error", "0.02", "--facets", "library"];
    place.run(&[&args[..], &["--scene", &scene, "--out", "m"]].concat(), 0);
    let result: Value = place.json("m/match.json");
    let number = |value: &Value| value.as_f64().expect("a number");
    for (name, truth) in [("cover", truth[0]), ("second", truth[1]), ("temperature", KELVIN)] {
        let all = result["answer"]["parameters"].as_array().expect("a list");
        let of = all.iter().find(|of| of["name"] == name).expect("fitted");
        let error = number(&of["standard_error"]);
        assert!((number(&of["best"]) - truth).abs() < 3.0 * error, "{of}");
        assert!(error < if name == "temperature" { 0.5 } else { 0.1 }, "{of}");
    }
}

#[test]
fn a_spectrum_that_no_soil_has_is_said_not_to_fit() {
    let place = Place::new();
    signature(
        &place,
        "odd.csv",
        |um| if um < 10.0 { 0.95 } else { 0.6 + 0.1 * math::sin_cos(um).0 },
    );
    let scene = shipped("settled_patch.json");
    let (out, _) = place.run(&["match", "odd.csv", "--scene", &scene, "--out", "m"], 6);
    assert!(out.starts_with("no good fit"), "{out}");
    let result: Value = place.json("m/match.json");
    let kinds: Vec<String> = (result["warnings"].as_array().expect("a list").iter())
        .flat_map(|warning| warning.as_object().expect("an object").keys().cloned())
        .collect();
    assert!(kinds.contains(&"no_good_fit".to_owned()), "{kinds:?}");
}

#[test]
fn wrong_options_are_refused_with_their_reason() {
    let place = Place::new();
    signature(&place, "soil.csv", |_| 0.9);
    let scene = shipped("settled_patch.json");
    // Two bands more than parameters that are fitted.
    signature_of(&place, "few.csv", &[8.3, 9.1, 11.0]);
    let few = ["match", "few.csv", "--scene", &scene, "--out", "m"];
    let (_, error) = place.run(&few, 3);
    assert!(
        error.contains("3 bands in the range are too few for 3 parameters; it takes 5"),
        "{error}"
    );
    for (option, value, says) in [
        ("--prior", "moisture=0.2", "there is no parameter"),
        ("--prior", "cover=2+-0.1", "is not within"),
        ("--range", "7.55-7.75", "too few"),
    ] {
        let args = ["match", "soil.csv", "--scene", &scene, "--out", "m", option, value];
        let (_, error) = place.run(&args, 3);
        assert!(error.contains(says), "{option} {value}: {error}");
    }
    assert!(!Path::new(&place.path("m/match.json")).exists());
}
