//! DIRSIG's emissivity file: the number of curves, 91 weights by angle, the curves.

use std::path::Path;

use super::{Quantity, Reading, Tabulated, Unit, columns, number, row, text, wrong};
use crate::spectrum::SpectrumError;
use crate::spectrum::tabulated::Warning;

/// Weights for 0 to 90 degrees.
const WEIGHTS: usize = 91;

/// Reads both forms: curves that begin with `CURVE_BEGIN`, in um, and old ones that begin with
/// their number, in cm-1.
pub(super) fn read(path: &Path, reading: &Reading) -> Result<Vec<Tabulated>, SpectrumError> {
    let text = text(path)?;
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty());
    let ends = || wrong(path, text.lines().count(), "the file is cut short");
    let (at, count) = lines.next().ok_or_else(ends)?;
    let count: usize = count
        .parse()
        .map_err(|_| wrong(path, at, format!("{count:?} is not the number of curves")))?;
    let mut is_weighted = false;
    for _ in 0..WEIGHTS {
        let (i, line) = lines.next().ok_or_else(ends)?;
        is_weighted |= number(path, i, line)? != 1.0;
    }
    let mut curves: Vec<(Unit, Vec<_>)> = Vec::new();
    for (i, line) in lines {
        let fields: Vec<&str> = line.split_whitespace().collect();
        match (fields.as_slice(), curves.last_mut()) {
            (["CURVE_BEGIN"], _) => curves.push((Unit::Micrometre, Vec::new())),
            ([_], _) => curves.push((Unit::Wavenumber, Vec::new())),
            (_, Some((unit, rows))) => rows.push(row(path, i, *unit, &fields)?),
            (_, None) => return Err(wrong(path, i, "a curve must begin with CURVE_BEGIN")),
        }
    }
    if curves.len() != count {
        let problem = format!("{count} curves are announced, {} are there", curves.len());
        return Err(wrong(path, at, problem));
    }
    let is_one = count == 1;
    curves
        .into_iter()
        .enumerate()
        .map(|(i, (unit, rows))| {
            let mut spectrum =
                Tabulated::of_rows(path, rows, Quantity::Emissivity, reading.range_um)?;
            spectrum.name = (!is_one).then(|| (i + 1).to_string());
            spectrum.warnings.extend(is_weighted.then_some(Warning::AngularWeights));
            spectrum.warnings.extend((unit == Unit::Wavenumber).then_some(Warning::Coarse));
            Ok(spectrum)
        })
        .collect()
}

/// The text of a file with some curves.
pub(super) fn text_of(wavelength_um: &[f64], curves: &[(String, Vec<f64>)]) -> String {
    let mut text = format!("{}\n{}", curves.len(), "1.0\n".repeat(WEIGHTS));
    for (_, curve) in curves {
        text += "CURVE_BEGIN\n";
        text += &columns(wavelength_um, curve, ' ');
    }
    text
}
