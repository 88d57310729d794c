//! The words by which files name a unit of wavelength and a quantity.

mod text;
mod unit;
mod vocabulary;

#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use crate::spectrum::Quantity;
use text::{Token, is_in, plain, plain_but_signs, starts, tokens};
use vocabulary::{
    ABSORBANCE, ABSORBANCE_SYMBOLS, BESIDE, DENIALS, EMISSIVITY, EMISSIVITY_SYMBOLS, ERRORS,
    FOREIGN, NEUTRAL, OTHER, OTHERS, REFLECTANCE, REFLECTANCE_SYMBOLS, SAMPLES, TRANSMISSION,
    TRANSMISSION_SYMBOLS, WAVELENGTHS, WAVENUMBERS,
};

pub use unit::Unit;

/// What a label says of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Said {
    Quantity(Quantity),
    /// No emissivity follows from it.
    Transmission,
    /// It may be of a transmittance or of a reflectance.
    Absorbance,
    /// Emissivity and reflectance, or one of them with a word that changes it.
    Unclear,
}

/// What a column's heading says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    /// Wavelengths, in this unit if it is said.
    Wavelength(Option<Unit>),
    Values(Said),
    /// Errors of the values.
    Errors,
    Unknown,
}

/// Bytes of the longest label; what is longer is prose.
const LONGEST_LABEL: usize = 1000;

/// What the heading of a column says.
pub(super) fn column(text: &str) -> Column {
    let plain = plain(text);
    let tokens = tokens(&plain);
    let known = |token: &Token| {
        token.unit().is_some() || is_in(WAVELENGTHS, token.word) || starts(token.word, &WAVENUMBERS)
    };
    // A factor, as in 10^3 cm-1.
    let is_multiple =
        |token: &Token| token.before.trim_end().ends_with(|c: char| c.is_ascii_digit());
    if tokens.iter().any(|token| token.unit().is_some() && is_multiple(token)) {
        return Column::Unknown;
    }
    // "in" at the end is an inch.
    let is_inch = |t: &Token| t.word == "in" && !t.after.contains(char::is_alphabetic);
    let is_neutral = |t: &Token| is_in(NEUTRAL, t.word) && !is_inch(t) || t.word == "mu";
    if tokens.iter().any(known) && tokens.iter().all(|token| known(token) || is_neutral(token))
        || matches!(tokens[..], [Token { word: "x", .. }])
    {
        return Column::Wavelength(Unit::named(text));
    }
    if tokens.iter().any(|token| is_error(token.word)) {
        return Column::Errors;
    }
    said(text, true).map_or(Column::Unknown, Column::Values)
}

/// The unit of a column of wavelengths, micrometres if it names none; `None` of other columns.
pub(in crate::spectrum) fn wavelength_unit(heading: &str) -> Option<Unit> {
    match column(heading) {
        Column::Wavelength(unit) => Some(unit.unwrap_or(Unit::Micrometre)),
        _ => None,
    }
}

/// Whether a line of prose speaks of wavelengths or wavenumbers.
pub(super) fn has_wavelength(text: &str) -> bool {
    let text = plain(text);
    tokens(&text)
        .iter()
        .any(|token| is_in(WAVELENGTHS, token.word) || starts(token.word, &WAVENUMBERS))
}

/// The quantity that a label names, if it names one; `with_symbols` also R, %T and the like, which
/// may mean anything in prose.
pub(super) fn said(text: &str, with_symbols: bool) -> Option<Said> {
    let plain = plain(text);
    let tokens = tokens(&plain);
    let has = |prefixes: &[&str], symbols: &str| {
        tokens
            .iter()
            .any(|token| starts(token.word, prefixes) || with_symbols && is_in(symbols, token.word))
    };
    let is_percent = is_percent(&plain, &tokens, with_symbols);
    let alone = |symbol: &str| matches!(tokens[..], [Token { word, .. }] if word == symbol);
    if has(&TRANSMISSION, TRANSMISSION_SYMBOLS) || with_symbols && is_percent && alone("t") {
        return Some(Said::Transmission);
    }
    // Absorptance is no absorbance: it is emissivity, by Kirchhoff's law.
    if has(&ABSORBANCE, ABSORBANCE_SYMBOLS) {
        return Some(Said::Absorbance);
    }
    let is_emissivity = has(&EMISSIVITY, EMISSIVITY_SYMBOLS);
    let is_reflectance = has(&REFLECTANCE, REFLECTANCE_SYMBOLS);
    // Reflectance is measured relative to a standard; emissivity is not.
    let is_relative = is_emissivity && tokens.iter().any(|token| token.word == "relative");
    let is_foreign = tokens.iter().any(|token| token.word.contains("radian"))
        || !with_symbols && (has(&OTHERS, "") || FOREIGN.iter().any(|word| plain.contains(word)));
    let is_other = if with_symbols {
        text.len() > LONGEST_LABEL || !is_plain_label(text)
    } else {
        tokens.iter().any(|token| is_in(OTHER, token.word))
            || is_denied(&tokens)
            || is_complement(&plain)
    };
    let quantity = match (is_emissivity, is_reflectance) {
        (false, false) if is_foreign => return Some(Said::Unclear),
        (false, false) => return None,
        (true, true) => return Some(Said::Unclear),
        _ if is_other || is_relative || is_foreign => return Some(Said::Unclear),
        (true, false) if is_percent => Quantity::EmissivityPercent,
        (true, false) => Quantity::Emissivity,
        (false, true) if is_percent => Quantity::ReflectancePercent,
        (false, true) => Quantity::Reflectance,
    };
    Some(Said::Quantity(quantity))
}

/// Whether a label has nothing beside its quantity that may change it: no unknown word, and no
/// sign of arithmetic. What stands behind "of", "for" and "sample" names the sample.
fn is_plain_label(text: &str) -> bool {
    let text = plain_but_signs(text);
    let all = tokens(&text);
    let is_symbol =
        |word: &str| is_in(EMISSIVITY_SYMBOLS, word) || is_in(REFLECTANCE_SYMBOLS, word);
    let is_quantity = |token: &Token| is_symbol(token.word) || is_quantity(token.word);
    let Some(first) = all.iter().position(is_quantity) else { return false };
    let sample = all[first..].iter().find(|t| ["of", "for", "sample"].contains(&t.word));
    let label = sample.map_or(&*text, |token| token.before);
    let is_known = |token: &Token| {
        is_quantity(token)
            && !(is_symbol(token.word) && token.after.starts_with(|c: char| c.is_ascii_digit()))
            || is_percent_word(token.word)
            || is_in(BESIDE, token.word)
            || is_in(SAMPLES, token.word)
    };
    tokens(label).iter().all(is_known)
        && label.char_indices().all(|(at, c)| {
            is_no_arithmetic(c, &label[..at], &label[at + c.len_utf8()..], all[first].before.len())
        })
}

/// Whether a sign in a label is none of arithmetic: as in [-], (0-1), 2020-10-12, / %, and in
/// directional-hemispherical reflectance.
fn is_no_arithmetic(sign: char, before: &str, after: &str, quantity: usize) -> bool {
    let is_digit = |c: &char| c.is_ascii_digit();
    let digits = |chars: &mut dyn Iterator<Item = char>| chars.take_while(is_digit).count();
    let digits = [digits(&mut before.chars().rev()), digits(&mut after.chars())];
    let letters = [before.ends_with(char::is_alphabetic), after.starts_with(char::is_alphabetic)];
    let next = after.trim_start().chars().next();
    match sign {
        '-' => match (digits, letters) {
            ([1, 1], _) => before.ends_with('0') && after.starts_with('1'),
            ([0, 0], [true, true]) => before.len() < quantity,
            ([0, 0], _) => {
                before.trim_end().ends_with(['(', '[', '/'])
                    && !next.is_some_and(char::is_alphanumeric)
            }
            ([before, after], _) => before > 1 && after > 1,
        },
        '/' => {
            digits == [0, 0] && matches!(next, Some('%' | '-' | 'p'))
                || digits[0] == 0 && next == Some('1') && after.trim_start().len() == 1
        }
        '.' => digits[0] == 0 || digits[1] == 0,
        '(' | ')' | '[' | ']' | '{' | '}' | '_' | '%' | ',' | ':' | ';' | '\'' | '"' | '#'
        | '$' | '\\' => true,
        other => other.is_alphabetic() || other.is_ascii_digit() || other.is_whitespace(),
    }
}

/// Whether a line of prose denies its quantity, or speaks of its errors.
fn is_denied(tokens: &[Token]) -> bool {
    let is_error = |token: &Token| is_error(token.word);
    (0..tokens.len()).filter(|&i| is_quantity(tokens[i].word)).any(|i| {
        let mut before = tokens[..i].iter().rev();
        let before = before.find(|t| !["of", "the", "a", "an", "in"].contains(&t.word));
        before.is_some_and(|token| {
            is_error(token) || is_in(DENIALS, token.word) && !token.after.starts_with('.')
        }) || tokens.get(i + 1).is_some_and(is_error)
    })
}

fn is_error(word: &str) -> bool {
    is_in(ERRORS, word) || word.starts_with("standarddev")
}

/// Whether a word is one for emissivity or reflectance, and nothing is glued to it but percent.
fn is_quantity(word: &str) -> bool {
    let word = word.trim_end_matches("percent").trim_end_matches("pct");
    [&EMISSIVITY[..], &REFLECTANCE].concat().iter().any(|prefix| {
        word.strip_prefix(prefix).is_some_and(|end| {
            end.len() <= 4 && !ERRORS.split(' ').any(|error| end.ends_with(error))
        })
    })
}

/// Whether a line names what is missing to 1 or 100 %, as 1 - emissivity. The number may also be
/// that of a sample.
fn is_complement(plain: &str) -> bool {
    let of = |(at, _): (usize, &str)| {
        let after = plain[at + 1..].trim_start();
        let before = plain[..at].trim_end_matches([' ', '%']);
        let number = ["100", "1"].iter().find_map(|number| before.strip_suffix(number));
        let is_number = number.is_some_and(|before| {
            let is_apart = !before.ends_with(char::is_alphanumeric);
            let before = before.trim_end();
            let word = before.rsplit(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
            is_apart
                && (before.is_empty()
                    || before.ends_with([':', '=', '(', '['])
                    || ["is", "are", "as", "of", "the"].contains(&word))
        });
        is_number && starts(after, &[&EMISSIVITY[..], &REFLECTANCE].concat())
    };
    plain.match_indices('-').any(of)
}

/// Whether the reflectance that a label names is bidirectional.
pub(super) fn is_bidirectional(text: &str) -> bool {
    let text = plain(text);
    ["bidirectional", "bi-directional", "biconical", "bi-conical", "brf"]
        .iter()
        .any(|word| text.contains(word))
}

/// Whether a label gives its quantity in percent. In prose the word must stand beside the quantity.
fn is_percent(plain: &str, tokens: &[Token], anywhere: bool) -> bool {
    if anywhere {
        let is = |token: &Token| {
            is_percent_word(token.word)
                || ["percent", "pct"].iter().any(|p| token.word.ends_with(p))
        };
        return plain.contains('%') || tokens.iter().any(is);
    }
    let squeezed: String = plain.chars().filter(|c| !" ([,:-_".contains(*c)).collect();
    let quantity = [&EMISSIVITY[..], &REFLECTANCE].concat();
    let words = tokens.iter().map(|token| token.word).filter(|word| starts(word, &quantity));
    words.collect::<BTreeSet<_>>().into_iter().any(|word| {
        ["%", "percent", "pct", "inpercent", "in%"].iter().any(|percent| {
            squeezed.contains(&format!("{word}{percent}"))
                || squeezed.contains(&format!("{percent}{word}"))
        })
    })
}

fn is_percent_word(word: &str) -> bool {
    starts(word, &["percent", "pct", "prozent", "pourcent", "porcent"])
}
