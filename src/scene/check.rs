//! What values of a scene file must be. A value that is not comes back with its place in the file
//! and the problem.

use std::collections::HashSet;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// The place and the problem, if there is one.
pub(super) type Checked = Result<(), (String, String)>;

pub(super) fn need(holds: bool, place: &str, problem: impl FnOnce() -> String) -> Checked {
    if holds { Ok(()) } else { Err((place.to_owned(), problem())) }
}

pub(super) fn positive(value: f64, place: &str) -> Checked {
    need(value.is_finite() && value > 0.0, place, || format!("{value} is not above 0"))
}

pub(super) fn within<T: Copy + PartialOrd + Display>(
    value: T,
    range: RangeInclusive<T>,
    place: &str,
) -> Checked {
    need(range.contains(&value), place, || {
        format!("{value} is not within {} to {}", range.start(), range.end())
    })
}

pub(super) fn at_most<T: Copy + PartialOrd + Display>(value: T, most: T, place: &str) -> Checked {
    need(value <= most, place, || format!("{value} is more than {most}"))
}

pub(super) fn temperature(kelvin: f64, place: &str) -> Checked {
    need((1.0..=10_000.0).contains(&kelvin), place, || {
        format!("{kelvin} K is not within 1 to 10000 K")
    })
}

pub(super) fn unique<'a>(names: impl Iterator<Item = &'a str>, place: &str) -> Checked {
    let mut seen = HashSet::new();
    for name in names {
        need(seen.insert(name), place, || format!("the name {name:?} stands twice"))?;
    }
    Ok(())
}
