//! The bounds of a study: what is refused, with its place.

use std::collections::BTreeSet;

use super::study::{Axis, Case, FORMAT, Range, Sample, Study};
use crate::histogram::estimate;
use crate::pipeline::Source;

impl Study {
    /// What is wrong, and where.
    pub(super) fn problem(&self) -> Option<(String, String)> {
        let at = |place: &str, problem: &str| Some((place.to_owned(), problem.to_owned()));
        if self.soilsig_study != FORMAT {
            let version = self.soilsig_study;
            let problem = format!("version {version} is not known; this program reads {FORMAT}");
            return at("soilsig_study", &problem);
        }
        if self.source == Source::Coverage("all".into()) {
            return at("source", "name one coverage, and vary the cover by an axis");
        }
        let mut names = BTreeSet::from(["point", "beds", "seed", "sample", "wavelength"]);
        for (i, axis) in self.axes.iter().enumerate() {
            let place = |key: &str| format!("axes[{i}].{key}");
            let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let begins = axis.name.starts_with(|c: char| c.is_ascii_alphabetic());
            if !begins || axis.name.len() > 40 || !axis.name.chars().all(is_plain) {
                let problem = "a name has at most 40 letters, digits and _, a letter first";
                return at(&place("name"), problem);
            }
            if !names.insert(&axis.name) {
                return at(&place("name"), &format!("{:?} is taken", axis.name));
            }
            if let Some((key, problem)) = axis.problem() {
                return at(&place(key), problem);
            }
            let others = self.axes[..i].iter().flat_map(Axis::keys).collect();
            if let Some(key) = axis.keys().intersection(&others).next() {
                return at(&place("key"), &format!("another axis varies {key} too"));
            }
        }
        let sampled = self.axes.iter().any(Axis::is_sampled);
        match self.sample {
            None if sampled => {
                return at("sample", "a range without `number` needs it: a method and points");
            }
            Some(_) if !sampled => return at("sample", "no axis has a range without `number`"),
            Some(Sample { points: 0, .. }) => return at("sample.points", "it must be 1 or more"),
            _ => {}
        }
        let seeds: BTreeSet<u64> = self.seeds.iter().copied().collect();
        if seeds.is_empty() || seeds.len() < self.seeds.len() || seeds.len() > estimate::MOST {
            let problem = format!("give 1 to {} different seeds", estimate::MOST);
            return at("seeds", &problem);
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return at("tolerance", "it must be above 0 and below 1");
        }
        if self.max_paths < 2 {
            return at("max_paths", "it must be 2 or more");
        }
        None
    }
}

impl Axis {
    fn problem(&self) -> Option<(&'static str, &'static str)> {
        let Self { key, values, range, cases, .. } = self;
        let kinds = [values.is_some(), range.is_some(), cases.is_some()];
        if kinds.iter().filter(|given| **given).count() != 1 {
            return Some(("values", "give one of `values`, `range` and `cases`"));
        }
        match (cases.is_some(), key.is_none()) {
            (true, false) => return Some(("key", "cases name their own keys: leave it out")),
            (false, true) => return Some(("key", "name the key that is varied")),
            _ => {}
        }
        if let Some(problem) = range.and_then(|range| range.problem()) {
            return Some(("range", problem));
        }
        if values.as_ref().is_some_and(Vec::is_empty) {
            return Some(("values", "there must be at least one"));
        }
        let names = |cases: &Vec<Case>| -> BTreeSet<String> {
            cases.iter().map(|case| case.name.clone()).collect()
        };
        if cases.as_ref().is_some_and(|cases| cases.is_empty() || names(cases).len() < cases.len())
        {
            return Some(("cases", "there must be at least one, and their names must differ"));
        }
        None
    }
}

impl Range {
    fn problem(&self) -> Option<&'static str> {
        let Self { from, to, number, log, .. } = *self;
        if !(from.is_finite() && to.is_finite() && from < to) {
            Some("`from` must be below `to`")
        } else if log && from <= 0.0 {
            Some("a logarithmic range begins above 0")
        } else if number.is_some_and(|n| n < 2) {
            Some("a range has 2 numbers or more")
        } else {
            None
        }
    }
}
