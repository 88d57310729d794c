//! Grain sizes of a soil as sieves and laboratories state them: distributions of mass.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

use super::check::{Checked, need, positive, within};
use crate::support::math;

/// Neighbouring size classes differ by about this factor, a little more than the fourth root of 2
/// of a sieve series.
const RATIO: f64 = 1.25;

/// Widest lognormal distribution, standard deviation of the logarithm.
const MOST_SIGMA: f64 = 2.0;

/// Diameters of the grains of a component or of the fines of a kind, um.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(
    untagged,
    expecting = "size_um is a diameter, {\"range\": [from, to]}, {\"lognormal\": {\"median\": um, \"sigma\": s}}, {\"passing\": [[um, percent], ...]} or {\"retained\": [[um, percent], ...]}"
)]
pub enum Sizes {
    /// All have this diameter, um.
    One(#[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))] f64),
    /// They are distributed.
    Many(Distribution),
}

/// A distribution of diameters by mass. Between two sieves it is even in the logarithm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// Between two sieves: the smallest and the largest diameter, um.
    Range([f64; 2]),
    /// A normal distribution of the logarithm of the diameter.
    Lognormal(Lognormal),
    /// A sieve table of what passes: openings, um, each with the percentage of the mass that passes
    /// it, in any order; from 0 to 100 %.
    Passing(Vec<[f64; 2]>),
    /// A sieve table of what stays: openings, um, each with the percentage of the mass that it holds
    /// back, in any order; together 100 %, on the widest 0.
    Retained(Vec<[f64; 2]>),
}

/// A lognormal distribution of diameters by mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Lognormal {
    /// The diameter below which half of the mass is, um.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub median: f64,
    /// Standard deviation of the natural logarithm of the diameter, above 0, at most 2.
    #[cfg_attr(
        feature = "schema",
        schemars(range(max = MOST_SIGMA), extend("exclusiveMinimum" = 0))
    )]
    pub sigma: f64,
}

impl Sizes {
    pub(super) fn check(&self, place: &str) -> Checked {
        match self {
            Self::One(um) => positive(*um, place),
            Self::Many(Distribution::Range([from, to])) => {
                let place = format!("{place}.range");
                positive(*from, &place)?;
                positive(*to, &place)?;
                need(from < to, &place, || {
                    format!("{from} um is not below {to} um: the smaller diameter comes first")
                })
            }
            Self::Many(Distribution::Lognormal(Lognormal { median, sigma })) => {
                positive(*median, &format!("{place}.lognormal.median"))?;
                let place = format!("{place}.lognormal.sigma");
                positive(*sigma, &place)?;
                within(*sigma, 0.0..=MOST_SIGMA, &place)
            }
            Self::Many(Distribution::Passing(rows)) => {
                check_passing(&sorted(rows), &format!("{place}.passing"))
            }
            Self::Many(Distribution::Retained(rows)) => {
                check_retained(&sorted(rows), &format!("{place}.retained"))
            }
        }
    }

    /// The diameter below which a share of the mass is, um. The sizes are checked.
    pub fn quantile_um(&self, share: f64) -> f64 {
        match self {
            Self::One(um) => *um,
            Self::Many(Distribution::Lognormal(Lognormal { median, sigma })) => {
                let z = Normal::standard().inverse_cdf(share);
                median * math::exp(sigma * (z * 1e9).round() / 1e9)
            }
            Self::Many(Distribution::Range([from, to])) => {
                within_table(&[[*from, 0.0], [*to, 100.0]], share)
            }
            Self::Many(Distribution::Passing(rows)) => within_table(&sorted(rows), share),
            Self::Many(Distribution::Retained(rows)) => {
                within_table(&passing(&sorted(rows)), share)
            }
        }
    }

    /// Diameters of size classes of equal mass, um, ascending: in each class that of its middle
    /// by mass. There are `most` at most.
    pub(super) fn classes_um(&self, most: u32) -> Vec<f64> {
        if let Self::One(um) = self {
            return vec![*um];
        }
        let span = math::log(self.quantile_um(0.95) / self.quantile_um(0.05));
        let number = (span / math::log(RATIO)).ceil().clamp(1.0, f64::from(most));
        let middle = |class: u32| (f64::from(class) + 0.5) / number;
        (0..number as u32).map(|class| self.quantile_um(middle(class))).collect()
    }
}

fn sorted(rows: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    rows
}

/// What passes each sieve, of what each holds back.
fn passing(retained: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let total: f64 = retained.iter().map(|row| row[1]).sum();
    let mut below = 0.0;
    let row = |&[um, held]: &[f64; 2]| {
        let row = [um, 100.0 * below / total];
        below += held;
        row
    };
    retained.iter().map(row).collect()
}

fn within_table(passing: &[[f64; 2]], share: f64) -> f64 {
    let percent = 100.0 * share;
    let above = passing.partition_point(|row| row[1] <= percent).clamp(1, passing.len() - 1);
    let [[from, low], [to, high]] = [passing[above - 1], passing[above]];
    let at = (percent - low) / (high - low);
    math::exp(math::log(from) + at * math::log(to / from))
}

fn check_rows(rows: &[[f64; 2]], place: &str) -> Checked {
    need(rows.len() > 1, place, || {
        "a sieve table has two rows at least, [opening in um, percent of the mass]".into()
    })?;
    for [um, percent] in rows {
        positive(*um, place)?;
        within(*percent, 0.0..=100.0, place)?;
    }
    for pair in rows.windows(2) {
        need(pair[0][0] < pair[1][0], place, || {
            format!("the opening {} um stands twice", pair[0][0])
        })?;
    }
    Ok(())
}

fn check_passing(rows: &[[f64; 2]], place: &str) -> Checked {
    check_rows(rows, place)?;
    for pair in rows.windows(2) {
        let [[narrow, less], [wide, more]] = [pair[0], pair[1]];
        need(less <= more, place, || {
            format!(
                "{less} % passes {narrow} um, but only {more} % the wider {wide} um: write what \
                 each sieve holds back as \"retained\""
            )
        })?;
    }
    let ([finest, passes], [widest, all]) = (rows[0], rows[rows.len() - 1]);
    need(all == 100.0, place, || {
        format!(
            "{} % is above {widest} um, of unknown size: add a wider sieve that 100 % passes",
            100.0 - all
        )
    })?;
    need(passes == 0.0, place, || {
        format!(
            "{passes} % is below {finest} um, of unknown size: add the smallest diameter with 0, \
             or state that part as dust"
        )
    })
}

fn check_retained(rows: &[[f64; 2]], place: &str) -> Checked {
    check_rows(rows, place)?;
    let total: f64 = rows.iter().map(|row| row[1]).sum();
    need((total - 100.0).abs() <= 0.1, place, || {
        format!(
            "the sieves hold back {total} %, not 100 %: give the pan a row with the smallest \
             diameter, or write what passes each sieve as \"passing\""
        )
    })?;
    let [widest, held] = rows[rows.len() - 1];
    need(held == 0.0, place, || {
        format!(
            "{held} % stays on the widest sieve, {widest} um, of unknown size: add a wider sieve \
             with 0"
        )
    })
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn sizes(value: Value) -> Sizes {
        let sizes: Sizes = serde_json::from_value(value).expect("sizes");
        sizes.check("size_um").expect("sound");
        sizes
    }

    fn assert_near(found: f64, wanted: f64) {
        assert!((found / wanted - 1.0).abs() < 1e-6, "{found} {wanted}");
    }

    /// Quantiles of the normal distribution from tables.
    #[test]
    fn quantiles_of_a_lognormal_are_those_of_its_closed_form() {
        let sizes = sizes(json!({"lognormal": {"median": 600, "sigma": 0.3}}));
        for (share, z) in [
            (0.05, -1.644_853_627),
            (0.158_655_254, -1.0),
            (0.5, 0.0),
            (0.841_344_746, 1.0),
            (0.975, 1.959_963_985),
        ] {
            assert_near(sizes.quantile_um(share), 600.0 * f64::exp(0.3 * z));
        }
        let classes = sizes.classes_um(8);
        assert_eq!(classes.len(), 5, "3.29 sigma in steps of a quarter");
        assert_near(classes[2], 600.0);
        assert_near(classes[0] * classes[4], 600.0 * 600.0);
        assert_near(classes[4], 600.0 * f64::exp(0.3 * 1.281_551_566));
    }

    #[test]
    fn a_range_is_even_in_the_logarithm() {
        let sizes = sizes(json!({"range": [500, 853]}));
        assert_near(sizes.quantile_um(0.5), f64::sqrt(500.0 * 853.0));
        let classes = sizes.classes_um(8);
        assert_eq!(classes.len(), 3);
        assert_near(classes[1] / classes[0], f64::cbrt(853.0 / 500.0));
        assert_eq!(self::sizes(json!(640)).classes_um(8), [640.0]);
    }

    #[test]
    fn a_sieve_table_says_the_same_in_any_order_and_of_what_passes_or_stays() {
        let tables = [
            json!({"passing": [[500, 0], [600, 55], [850, 100]]}),
            json!({"passing": [[850, 100], [500, 0], [600, 55]]}),
            json!({"retained": [[850, 0], [600, 45], [500, 55]]}),
            json!({"retained": [[500, 55], [850, 0], [600, 45]]}),
        ];
        for table in tables {
            let sizes = sizes(table);
            assert_near(sizes.quantile_um(0.55), 600.0);
            assert_near(sizes.quantile_um(0.275), f64::sqrt(500.0 * 600.0));
            assert_near(sizes.quantile_um(0.775), f64::sqrt(600.0 * 850.0));
        }
        // Nothing between two sieves: no diameter lies there.
        let gap = sizes(json!({"passing": [[100, 0], [200, 50], [400, 50], [800, 100]]}));
        assert!(gap.quantile_um(0.49) < 200.0 && gap.quantile_um(0.51) > 400.0);
    }

    #[test]
    fn sizes_that_say_too_little_are_refused_with_the_remedy() {
        for (value, words) in [
            (json!(0), "0 is not above 0"),
            (json!({"range": [853, 500]}), "the smaller diameter comes first"),
            (json!({"range": [-1, 500]}), "-1 is not above 0"),
            (json!({"lognormal": {"median": 600, "sigma": 0}}), "0 is not above 0"),
            (json!({"lognormal": {"median": 600, "sigma": 3}}), "3 is not within 0 to 2"),
            (json!({"passing": [[500, 0]]}), "two rows"),
            (json!({"passing": [[500, 0], [500, 100]]}), "500 um stands twice"),
            (json!({"passing": [[500, 55], [600, 45], [850, 0]]}), "as \"retained\""),
            (json!({"passing": [[500, 0], [850, 98]]}), "add a wider sieve that 100 % passes"),
            (json!({"passing": [[500, 5], [850, 100]]}), "or state that part as dust"),
            (json!({"retained": [[500, 0], [600, 55], [850, 100]]}), "hold back 155 %"),
            (json!({"retained": [[500, 40], [600, 55], [850, 0]]}), "give the pan a row"),
            (json!({"retained": [[500, 40], [600, 60]]}), "add a wider sieve with 0"),
            (json!({"passing": [[500, 0], [850, 101]]}), "not within 0 to 100"),
        ] {
            let sizes: Sizes = serde_json::from_value(value.clone()).expect("a form that is known");
            let (place, problem) = sizes.check("size_um").expect_err("refused");
            assert!(problem.contains(words), "{value}: {place}: {problem}");
            assert!(place.starts_with("size_um"), "{place}");
        }
        let unknown = serde_json::from_value::<Sizes>(json!({"sieve": [[500, 0], [850, 100]]}));
        let error = unknown.expect_err("ambiguous").to_string();
        assert!(error.contains("\"passing\"") && error.contains("\"retained\""), "{error}");
    }
}
