//! The words by which files name a unit of wavelength and a quantity.

use crate::spectrum::Quantity;

/// The unit of a file's wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Unit {
    /// Micrometres
    #[cfg_attr(feature = "cli", value(name = "um"))]
    Micrometre,
    /// Nanometres
    #[cfg_attr(feature = "cli", value(name = "nm"))]
    Nanometre,
    /// Angstroms
    Angstrom,
    /// Millimetres
    #[cfg_attr(feature = "cli", value(name = "mm"))]
    Millimetre,
    /// Metres
    #[cfg_attr(feature = "cli", value(name = "m"))]
    Metre,
    /// Wavenumbers, cm-1
    #[cfg_attr(feature = "cli", value(name = "cm-1"))]
    Wavenumber,
    /// Wavenumbers, um-1
    #[cfg_attr(feature = "cli", value(name = "um-1"))]
    PerMicrometre,
    /// Wavenumbers, m-1
    #[cfg_attr(feature = "cli", value(name = "m-1"))]
    PerMetre,
    /// Frequencies, THz
    #[cfg_attr(feature = "cli", value(name = "THz"))]
    Terahertz,
    /// Energies of a photon, eV
    #[cfg_attr(feature = "cli", value(name = "eV"))]
    Electronvolt,
}

/// Speed of light, um THz (exact).
const C_UM_THZ: f64 = 299.792_458;
/// Planck constant times the speed of light, um eV (CODATA 2019, exact: here all digits that hold).
const HC_UM_EV: f64 = 1.239_841_984_332_002_6;

impl Unit {
    /// The unit that a heading or label names, if it names one.
    pub(crate) fn named(text: &str) -> Option<Self> {
        let text = plain(text);
        let tokens = tokens(&text);
        let units = tokens.iter().enumerate().filter_map(|(i, token)| match token.word {
            _ if starts(token.word, &WAVENUMBERS) => Some(Self::Wavenumber),
            // mu m, as LaTeX has it.
            "m" if i > 0 && tokens[i - 1].word == "mu" => Some(Self::Micrometre),
            _ => token.unit(),
        });
        // A unit says more than the word wavenumber.
        let units: Vec<Self> = units.collect();
        units.iter().copied().find(|unit| *unit != Self::Wavenumber).or(units.first().copied())
    }

    /// A wavelength in um.
    pub(crate) fn um(self, value: f64) -> f64 {
        match self {
            Self::Micrometre => value,
            Self::Nanometre => value / 1e3,
            Self::Angstrom => value / 1e4,
            Self::Millimetre => value * 1e3,
            Self::Metre => value * 1e6,
            Self::Wavenumber => 1e4 / value,
            Self::PerMicrometre => 1.0 / value,
            Self::PerMetre => 1e6 / value,
            Self::Terahertz => C_UM_THZ / value,
            Self::Electronvolt => HC_UM_EV / value,
        }
    }
}

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

const WAVELENGTHS: &str = "\
    wavelength wavelengths wave wl wvl wvls wav lambda lam \u{3bb} wellenlange wellenlangen \
    wellenlaenge longueur longitud lunghezza comprimento \
    wavl wavelen wvlen wlen";
const WAVENUMBERS: [&str; 4] = ["wavenumber", "wellenzahl", "kayser", "wavenum"];
/// Words beside a wavelength that say nothing of its unit.
const NEUTRAL: &str = "\
    nu \u{3bd} x s d of in the de di onde onda ondes air vacuum band channel centre center \
    central mean axis units unit frequency energy photon";

const EMISSIVITY: [&str; 9] = [
    "emissivi",
    "emisivi",
    "emissiti",
    "emittan",
    "absorptan",
    "epsilon",
    "emmissi",
    "emisivit",
    "emissionsgrad",
];
const EMISSIVITY_SYMBOLS: &str = "emiss emis eps \u{3b5} \u{3f5} varepsilon";
const REFLECTANCE: [&str; 14] = [
    "reflectan",
    "reflectiv",
    "reflectiviti",
    "reflektivit",
    "reflexionsgrad",
    "riflettivi",
    "reflectio",
    "reflecten",
    "reflectie",
    "refletan",
    "reflekt",
    "reflex",
    "riflett",
    "albedo",
];
const REFLECTANCE_SYMBOLS: &str = "refl r dhr hdr drf hdrf hhr dhrf rho \u{3c1}";
const TRANSMISSION: [&str; 5] = ["transm", "transitt", "trasm", "durchlass", "transparen"];
const TRANSMISSION_SYMBOLS: &str = "tran trans tau";
const ABSORBANCE: [&str; 4] = ["absorb", "absorpti", "extinc", "extinktion"];
const ABSORBANCE_SYMBOLS: &str = "abs od";
/// Words that make another quantity of emissivity or reflectance.
const OTHER: &str = "\
    anomaly arb arbitrary atr attenuated brdf change coefficient complement complementary \
    contrast counts cr delta depth difference digital gradient hull imaginary inverse inverted \
    ln log log10 loss minus negative noise offset phase plus product pseudo ratio reciprocal \
    rescaled residual rms root scaled scattering shifted slope snr sqrt squared sr stacked sum \
    times variance";
/// Beginnings of such words.
const OTHERS: [&str; 10] = [
    "continuum",
    "cumulativ",
    "deriv",
    "detrend",
    "integrated",
    "kubelka",
    "munk",
    "normalis",
    "normaliz",
    "removed",
];
/// Other quantities that a line of prose may name.
const FOREIGN: [&str; 7] = [
    "dielectric",
    "imaginary",
    "optical constant",
    "optical depth",
    "optical thickness",
    "permittivity",
    "refractive",
];
/// Words that deny what stands behind them.
const DENIALS: &str = "non not no un anti without kein keine";
/// Words that may stand beside a quantity in a label. All others may change it.
const BESIDE: &str = "\
    apparent absolute average avg band biconical bidirectional channel conical data dh diffuse \
    dimensionless dir directional effective em facet factor fraction fractional h hd hem \
    hemispherical hemispherique hemispherisch hemispherischer in lab laboratory lambda \
    measured mean median nadir normal relative smoothed spectral spectrale spectrum spektral \
    spektrale spektraler espectral spettrale surface the thermal tir to total unit unitless \
    units value values wl y \u{3bb}";
/// Words of what was measured.
const SAMPLES: &str = "\
    albite alunite andesite anorthite basalt calcite clay coarse corundum desert dolomite dry dune \
    feldspar fine fines forsterite glass grain grains granite gypsum hematite ice kaolinite \
    limestone loam medium mineral montmorillonite olivine plagioclase powder pyroxene quartz \
    quartzite regolith rock sample sand sandstone sandy silica silt snow soil vegetation water wet";
const ERRORS: &str = "std stdev stddev sd sigma error errors err uncertainty unc deviation se";

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
        !is_plain_label(text)
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
    tokens.iter().filter(|token| starts(token.word, &quantity)).any(|token| {
        ["%", "percent", "pct", "inpercent", "in%"].iter().any(|percent| {
            squeezed.contains(&format!("{}{percent}", token.word))
                || squeezed.contains(&format!("{percent}{}", token.word))
        })
    })
}

fn is_percent_word(word: &str) -> bool {
    starts(word, &["percent", "pct", "prozent", "pourcent", "porcent"])
}

/// Whether a word is one of a list.
fn is_in(list: &str, word: &str) -> bool {
    list.split(' ').any(|known| known == word)
}

fn starts(word: &str, prefixes: &[&str]) -> bool {
    prefixes.iter().any(|prefix| word.starts_with(prefix))
}

/// Text in lower case, without accents and marks of powers and with plain minus signs.
fn plain(text: &str) -> String {
    plain_but_signs(&text.replace(['^', '{', '}', '*'], ""))
}

/// The same with all signs.
fn plain_but_signs(text: &str) -> String {
    let plain = |c: char| match c {
        '\u{e0}'..='\u{e4}' => 'a',
        '\u{e7}' => 'c',
        '\u{e8}'..='\u{eb}' => 'e',
        '\u{ec}'..='\u{ef}' => 'i',
        '\u{f1}' => 'n',
        '\u{f2}'..='\u{f6}' => 'o',
        '\u{f9}'..='\u{fc}' => 'u',
        '\u{207b}' | '\u{2212}' | '\u{2013}' => '-',
        '\u{b9}' => '1',
        '\u{2076}' => '6',
        '\u{2079}' => '9',
        '\u{2070}' => '0',
        '\u{3bc}' => '\u{b5}',
        '$' | '\\' => ' ',
        other => other,
    };
    let mut apart = String::new();
    let mut small = 0;
    for c in text.chars() {
        // The words of ReflectanceError stand apart. meV is one.
        if c.is_uppercase() && small > 2 {
            apart.push(' ');
        }
        small = if c.is_lowercase() { small + 1 } else { 0 };
        apart.push(c);
    }
    let text: String = apart.to_lowercase().chars().map(plain).collect();
    [
        ("wave number", "wavenumber"),
        ("wave-number", "wavenumber"),
        ("wave_number", "wavenumber"),
        ("nombre d'onde", "wavenumber"),
        ("numero de onda", "wavenumber"),
        ("per cent", "percent"),
        ("10-6 m", "um"),
        ("1e-6 m", "um"),
        ("10-9 m", "nm"),
        ("1e-9 m", "nm"),
    ]
    .iter()
    .fold(text, |text, (words, word)| text.replace(words, word))
}

/// A word of a label, with what stands before and after it.
struct Token<'a> {
    word: &'a str,
    before: &'a str,
    after: &'a str,
}

fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut from = 0;
    while let Some(start) = text[from..].find(char::is_alphabetic).map(|at| from + at) {
        let end = text[start..].find(|c: char| !c.is_alphabetic());
        from = end.map_or(text.len(), |end| start + end);
        let (before, after) = (&text[..start], &text[from..]);
        tokens.push(Token { word: &text[start..from], before, after });
    }
    tokens
}

impl Token<'_> {
    /// The unit that the word is, if it is one.
    fn unit(&self) -> Option<Unit> {
        // um-1, 1/um, and cm.1 as tables of R have it.
        let after = self.after.trim_start();
        let is_power = after.strip_prefix('-').is_some_and(|rest| rest.trim().starts_with('1'))
            || self.before.trim_end().ends_with("1/")
            || self.before.trim_end().ends_with("1 /");
        Some(match self.word {
            "cm" if is_power || after.trim_start_matches(['.', '_']).starts_with('1') => {
                Unit::Wavenumber
            }
            "um" | "\u{b5}m" if is_power => Unit::PerMicrometre,
            "m" if is_power => Unit::PerMetre,
            _ if is_power => return None,
            "um" | "\u{b5}m" | "\u{b5}" => Unit::Micrometre,
            "nm" => Unit::Nanometre,
            "angstrom" | "angstroms" | "\u{e5}" => Unit::Angstrom,
            "mm" => Unit::Millimetre,
            "m" | "meter" | "meters" | "metre" | "metres" => Unit::Metre,
            "thz" | "terahertz" => Unit::Terahertz,
            "ev" => Unit::Electronvolt,
            word if starts(word, &["micromet", "micron", "mikromet", "mikron"]) => Unit::Micrometre,
            word if starts(word, &["nanomet"]) => Unit::Nanometre,
            word if starts(word, &["millimet"]) => Unit::Millimetre,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_known_however_a_heading_writes_them() {
        use Unit::{
            Angstrom, Electronvolt, Metre, Micrometre, Nanometre, PerMetre, PerMicrometre,
            Terahertz, Wavenumber,
        };
        for (text, unit) in [
            ("wavelength_um", Micrometre),
            ("Wavelength (\u{b5}m)", Micrometre),
            ("Wellenl\u{e4}nge [\u{3bc}m]", Micrometre),
            ("Wavelength ($\\mu$m)", Micrometre),
            ("microns", Micrometre),
            ("X Units: Wavelength (micrometers)", Micrometre),
            ("Wavelength, nm", Nanometre),
            ("wavelength/nm", Nanometre),
            ("wavelength nm", Nanometre),
            ("WL_NM", Nanometre),
            ("Wavelength.nm.", Nanometre),
            ("nanom\u{e8}tres", Nanometre),
            ("Wavelength (\u{c5})", Angstrom),
            ("wavelength [m]", Metre),
            ("Wavenumber", Wavenumber),
            ("Wave number", Wavenumber),
            ("cm-1", Wavenumber),
            ("Wavenumber (cm^-1)", Wavenumber),
            ("Wellenzahl / cm\u{207b}\u{b9}", Wavenumber),
            ("1/CM", Wavenumber),
            ("Wavenumber..cm.1.", Wavenumber),
            ("wavenumber (m-1)", PerMetre),
            ("wavenumber [1/\u{b5}m]", PerMicrometre),
            ("Frequency (THz)", Terahertz),
            ("Energy (eV)", Electronvolt),
        ] {
            assert_eq!(Unit::named(text), Some(unit), "{text}");
        }
        for text in ["Wavelength", "furlongs", "W/m2/sr", "band", "(cm)"] {
            assert!(!matches!(column(text), Column::Wavelength(Some(_))), "{text}");
        }
        assert!((Unit::Terahertz.um(29.979_245_8) - 10.0).abs() < 1e-12);
        assert!((Unit::Electronvolt.um(0.123_984_198_433_200_26) - 10.0).abs() < 1e-12);
    }

    #[test]
    fn columns_are_known_by_their_headings() {
        use Quantity::{Emissivity, EmissivityPercent, Reflectance, ReflectancePercent};
        for (quantity, texts) in [
            (
                Emissivity,
                &[
                    "emissivity",
                    "eps",
                    "\u{3b5}",
                    "Emissivit\u{e4}t",
                    "emisividad",
                    "spectral \
                  emittance",
                    "absorptance",
                    "em_emissivity",
                ][..],
            ),
            (EmissivityPercent, &["Emissivity (%)", "emissivity_pct", "Emissivit\u{e9} (%)"]),
            (
                Reflectance,
                &[
                    "R",
                    "Refl.",
                    "Albedo",
                    "DHR",
                    "reflectance",
                    "Reflectence",
                    "Reflexionsgrad",
                    "R\u{e9}flectance",
                    "Reflektanz",
                    "hemispherical reflectance factor",
                ],
            ),
            (ReflectancePercent, &["%R", "R (%)", "Reflectance, %", "percent reflectance"]),
        ] {
            for text in texts {
                let said = Column::Values(Said::Quantity(quantity));
                assert_eq!(column(text), said, "{text}");
            }
        }
        for text in ["%T", "Transm.", "Transmittance", "TRAN", "Durchl\u{e4}ssigkeit", "T (%)"] {
            assert_eq!(column(text), Column::Values(Said::Transmission), "{text}");
        }
        for text in ["Absorbance", "Abs.", "ABS", "absorption coefficient", "extinction"] {
            assert_eq!(column(text), Column::Values(Said::Absorbance), "{text}");
        }
        for text in [
            "T",
            "A",
            "value",
            "quartz",
            "Kubelka-Munk",
            "e",
            "y",
            "band",
            "index",
            "wavelength (in)",
            "",
        ] {
            assert_eq!(column(text), Column::Unknown, "{text}");
        }
        for text in [
            "log(1/R)",
            "1-R",
            "1 - emissivity",
            "emissivity - 0.9",
            "0.5*emissivity",
            "reflectance/pi",
            "R2",
            "reflectance dB",
            "reflected radiance",
            "continuum removed reflectance",
            "single scattering albedo",
            "emissivity from reflectance",
            "d reflectance ratio",
            "non-emissivity",
            "not emissivity",
            "emissivity deficit",
            "half emissivity",
            "alpha emissivity",
            "emissivity quality",
            "emissivity range",
            "emissivity \u{b1}",
            "EmissivityRank",
        ] {
            assert_eq!(column(text), Column::Values(Said::Unclear), "{text}");
        }
        assert_eq!(column("EmissivityError"), Column::Errors);
        assert_eq!(column("emissivitystd"), Column::Values(Said::Unclear));
        assert_eq!(column("Std.Dev. of reflectance"), Column::Errors);
        assert_eq!(column("Wavelength"), Column::Wavelength(None));
        assert_eq!(column("longueur d'onde (nm)"), Column::Wavelength(Some(Unit::Nanometre)));
        assert_eq!(column("radiance (W/m2/sr/um)"), Column::Values(Said::Unclear));
    }

    #[test]
    fn prose_is_read_without_symbols_and_percent_only_beside_the_quantity() {
        let quantity = |quantity| Some(Said::Quantity(quantity));
        assert_eq!(said("T. R. Abs measured it", false), None);
        assert_eq!(
            said("reflectance of sand with 5 % moisture", false),
            quantity(Quantity::Reflectance)
        );
        for text in ["Reflectance in percent", "reflectance (%)", "% reflectance"] {
            assert_eq!(said(text, false), quantity(Quantity::ReflectancePercent), "{text}");
        }
    }
}
