//! What a match says of itself: each warning is caused once, on models that take no time.

use nalgebra::DMatrix;
use soilsig::inverse::estimation::{Evaluated, Fitting, Model, Observed, Parameter};
use soilsig::inverse::result::{Fit, Match};
use soilsig::inverse::{Warning, summary};

/// Twelve bands of a function of two parameters, with its derivatives by differences.
struct Plain {
    parameters: Vec<Parameter>,
    at: fn(&[f64], f64) -> f64,
}

fn um() -> Vec<f64> {
    (0..12).map(|i| 8.0 + 0.4 * f64::from(i)).collect()
}

impl Model for Plain {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn evaluate(&self, x: &[f64]) -> Evaluated {
        let bands = |x: &[f64]| -> Vec<f64> { um().iter().map(|um| (self.at)(x, *um)).collect() };
        let slope = |place: usize| -> Vec<f64> {
            let moved = |step: f64| {
                let mut x = x.to_vec();
                x[place] += step;
                bands(&x)
            };
            moved(1e-5).iter().zip(moved(-1e-5)).map(|(up, down)| (up - down) / 2e-5).collect()
        };
        Evaluated { bands: bands(x), slopes: (0..x.len()).map(slope).collect() }
    }

    fn covariance(&self, _: &[f64]) -> DMatrix<f64> {
        DMatrix::zeros(12, 12)
    }
}

/// The report of a fit to what the function gives for a truth, and all that is said of it.
fn said(at: fn(&[f64], f64) -> f64, truth: impl Fn(f64) -> f64) -> (Match, Vec<Warning>) {
    said_beside(at, truth, |_| {})
}

/// The same beside other fits.
fn said_beside(
    at: fn(&[f64], f64) -> f64,
    truth: impl Fn(f64) -> f64,
    beside: impl Fn(&mut Match),
) -> (Match, Vec<Warning>) {
    let parameter = |name: &str| Parameter {
        name: name.into(),
        unit: String::new(),
        prior: 0.1,
        prior_standard_deviation: 1.0,
        bounds: [-1.0, 1.0],
    };
    let model = Plain { parameters: vec![parameter("cover"), parameter("second")], at };
    let bands: Vec<f64> = um().iter().map(|um| truth(*um)).collect();
    let observed = Observed { um: um(), bands, errors: vec![0.002; 12] };
    let found = Fitting::new(&model, &observed).run(3, None);
    let answer = summary::fit(&model, &observed, &found, "plain", None);
    let mut result = Match { answer, ..Match::default() };
    beside(&mut result);
    let warnings = summary::warnings(&result, &observed, &found);
    (result, warnings)
}

/// Two parameters that the bands tell: one tilts the curve, the other is its level.
fn line(x: &[f64], um: f64) -> f64 {
    0.5 + 0.1 * x[0] * (um - 10.2) + 0.2 * x[1]
}

fn words(warnings: &[Warning]) -> String {
    warnings.iter().map(|warning| format!("{warning}\n")).collect()
}

#[test]
fn a_good_fit_has_no_warning() {
    let (_, warnings) = said(line, |um| line(&[0.3, -0.4], um));
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn bands_that_no_parameter_makes_are_named() {
    let spike = |um: f64| line(&[0.3, 0.4], um) + if (um - 9.6).abs() < 0.1 { 0.15 } else { 0.0 };
    let (_, warnings) = said(line, spike);
    let [Warning::NoGoodFit { bands_um, .. }] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(bands_um.contains(&[9.6, 9.6]), "{bands_um:?}");
    assert!(words(&warnings).contains("at 9.6"), "{}", words(&warnings));
}

#[test]
fn a_parameter_at_its_bound_is_named() {
    let (_, warnings) = said(line, |um| line(&[1.4, 0.4], um));
    assert!(
        words(&warnings).contains("the cover with fines at its bound of 1.000"),
        "{}",
        words(&warnings)
    );
}

#[test]
fn parameters_that_do_the_same_are_not_told_apart() {
    let sum = |x: &[f64], um: f64| 0.5 + 0.1 * (x[0] + x[1]) * (um - 10.2);
    let (_, warnings) = said(sum, |um| sum(&[0.2, 0.1], um));
    let apart = warnings.iter().any(|warning| {
        matches!(warning, Warning::Correlated { correlation, .. } if *correlation < -0.95)
    });
    assert!(apart, "{warnings:?}");
    assert!(words(&warnings).contains("--prior cover=VALUE"), "{}", words(&warnings));
}

#[test]
fn a_parameter_without_effect_is_not_told() {
    let (_, warnings) =
        said(|x, um| line(&[x[0], 0.0], um) + 1e-5 * x[1], |um| line(&[0.3, 0.0], um));
    assert!(
        words(&warnings).contains("do not tell the second component: 100 % of its value"),
        "{}",
        words(&warnings)
    );
}

/// The square of a parameter is that of its negative.
#[test]
fn a_minimum_that_is_nearly_as_good_is_named() {
    let square = |x: &[f64], um: f64| line(&[x[0] * x[0], x[1]], um);
    let (result, warnings) = said(square, |um| square(&[0.5, 0.3], um));
    assert!((result.answer.parameters[0].best - 0.5).abs() < 0.02);
    let [Warning::SeveralMinima { cover, .. }] = &warnings[..] else { panic!("{warnings:?}") };
    assert!((cover + 0.5).abs() < 0.02, "{cover}");
}

/// Fits beside the answer that are the answer but for their cover or their residual.
#[test]
fn other_fits_that_speak_against_the_answer_are_named() {
    let truth = |um: f64| line(&[0.3, 0.4], um) + 0.002 * (3.0 * um).sin();
    let moved = |answer: &Fit, errors: f64| {
        let mut fit = Fit { model: "another".into(), ..answer.clone() };
        fit.parameters[0].mean += errors * fit.parameters[0].standard_error;
        fit
    };
    for (errors, expected) in [(1.2, false), (1.6, true)] {
        let (_, warnings) = said_beside(line, truth, |result| {
            result.other_facets = vec![moved(&result.answer, errors)];
        });
        let differ = warnings.iter().any(|w| matches!(w, Warning::ModelsDiffer { .. }));
        assert_eq!(differ, expected, "{warnings:?}");
    }
    for (errors, expected) in [(0.8, false), (1.2, true)] {
        let (_, warnings) = said_beside(line, truth, |result| {
            result.halves = vec![moved(&result.answer, 0.0), moved(&result.answer, errors)];
        });
        let differ = warnings.iter().any(|w| matches!(w, Warning::HalvesDiffer { .. }));
        assert_eq!(differ, expected, "{warnings:?}");
    }
    for (share, expected) in [(1.1, false), (0.9, true)] {
        let (_, warnings) = said_beside(line, truth, |result| {
            result.linear = vec![Fit { rms: share * result.answer.rms, ..result.answer.clone() }];
        });
        let better = warnings.iter().any(|w| matches!(w, Warning::LinearIsBetter { .. }));
        assert_eq!(better, expected, "{warnings:?}");
    }
    let (_, warnings) = said_beside(line, truth, |result| result.answer.effective_draws = 50.0);
    assert!(words(&warnings).contains("50 effective draws"), "{}", words(&warnings));
}
