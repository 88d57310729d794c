//! A label's text, made plain and parted into words.

/// Whether a word is one of a list.
pub(super) fn is_in(list: &str, word: &str) -> bool {
    list.split(' ').any(|known| known == word)
}

pub(super) fn starts(word: &str, prefixes: &[&str]) -> bool {
    prefixes.iter().any(|prefix| word.starts_with(prefix))
}

/// Text in lower case, without accents and marks of powers and with plain minus signs.
pub(super) fn plain(text: &str) -> String {
    plain_but_signs(&text.replace(['^', '{', '}', '*'], ""))
}

/// The same with all signs.
pub(super) fn plain_but_signs(text: &str) -> String {
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
pub(super) struct Token<'a> {
    pub(super) word: &'a str,
    pub(super) before: &'a str,
    pub(super) after: &'a str,
}

pub(super) fn tokens(text: &str) -> Vec<Token<'_>> {
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
