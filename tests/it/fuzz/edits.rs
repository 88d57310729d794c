//! Changes of an input that mostly leave its structure: of words, numbers and lines, not of bits.

/// One change: its kind, its place and what is put there. All numbers are valid.
pub type Edit = (u8, u32, u32);

/// What stands in files of all formats, and what most upsets readers.
const WORDS: &[&str] = &[
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "1e999",
    "NaN",
    "inf",
    "-0",
    "0.5",
    "1",
    "2",
    "100",
    "65536",
    "2147483648",
    "4294967296",
    "18446744073709551616",
    "9007199254740993",
    "null",
    "true",
    "{}",
    "[]",
    "[[",
    "]]",
    "{",
    "}",
    "\"",
    "\"\"",
    "\"a\":1,",
    ",",
    ";",
    "\t",
    " ",
    "=",
    ":",
    "#",
    "\\",
    "/",
    "%",
    "\n",
    "\r",
    "\r\n",
    "\n\n",
    "\0",
    "\u{feff}",
    "\u{b5}m",
    "\u{2212}",
    "nm",
    "cm-1",
    "um",
    "hz",
    "percent",
    "reflectance",
    "emissivity",
    "transmittance",
    "absorbance",
    "wavelength",
    "..",
    "/dev/null",
    "a",
    "f",
    "v",
    "o",
    "usemtl",
    "##",
    "(XY..XY)",
    "(X++(Y..Y))",
    "##END=",
    "1,5",
    "1.5.5",
    "+",
    "-",
    "e",
    "0x10",
    "\u{1f600}",
];

/// Bytes of the largest input that one change makes.
const LARGE: usize = 60_000;

/// The input with all changes made, in their order, of at most so many bytes.
pub fn edited(input: &[u8], edits: &[Edit], most: usize) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for &edit in edits {
        bytes = with(bytes, edit);
        bytes.truncate(most);
    }
    bytes
}

fn with(mut bytes: Vec<u8>, (kind, at, what): Edit) -> Vec<u8> {
    let pick = |number: u32, of: usize| number as usize % of.max(1);
    let word = WORDS[pick(what, WORDS.len())].as_bytes();
    match kind % 17 {
        // A word for another, or for one that stands elsewhere in the input.
        0..=4 => {
            let words = words(&bytes);
            let Some(&[from, end]) = words.get(pick(at, words.len())) else { return word.to_vec() };
            let instead = match kind % 17 {
                0..=2 => word.to_vec(),
                3 => {
                    let [from, end] = words[pick(what, words.len())];
                    bytes[from..end].to_vec()
                }
                _ => Vec::new(),
            };
            bytes.splice(from..end, instead);
        }
        5 => {
            let at = pick(at, bytes.len() + 1);
            bytes.splice(at..at, word.iter().copied());
        }
        // Lines: one less, one more often, two exchanged, one that goes on.
        kind @ 6..=10 => {
            let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
            if lines.is_empty() {
                return bytes;
            }
            let (one, other) = (pick(at, lines.len()), pick(what, lines.len()));
            match kind {
                6 => drop(lines.remove(one)),
                7 => lines.insert(other, lines[one]),
                8 => lines.swap(one, other),
                9 => drop(lines.splice(one..one, vec![lines[one]; pick(what, 40)])),
                _ => lines[one] = lines[one].trim_ascii_end(),
            }
            bytes = lines.concat();
        }
        11 => bytes.truncate(pick(at, bytes.len())),
        12 if !bytes.is_empty() => {
            let at = pick(at, bytes.len());
            bytes[at] ^= 1 << (what % 8);
        }
        13 if !bytes.is_empty() => {
            let at = pick(at, bytes.len());
            bytes[at] = what as u8;
        }
        // Brackets within brackets.
        14 => {
            let at = pick(at, bytes.len() + 1);
            let deep = word.repeat(1 + pick(what / 64, 200));
            bytes.splice(at..at, deep);
        }
        // Encodings.
        15 => {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            bytes = match what % 5 {
                0 => text.replace('\n', "\r").into_bytes(),
                1 => text.replace('.', ",").into_bytes(),
                2 => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
                3 => text.replace(',', ";").into_bytes(),
                _ => text.replace([',', ' '], "\t").into_bytes(),
            };
        }
        // As large as files are: what stands between two marks, again and again.
        16 => {
            let mark = b"\n\n,}"[pick(at, 4)];
            let marks: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i] == mark).collect();
            let first = pick(at / 4, marks.len());
            let last = first + 1 + pick(what, 8);
            if let (Some(&from), Some(&end)) = (marks.get(first), marks.get(last)) {
                let block = bytes[from..end].to_vec();
                let times = pick(what / 8, LARGE) / block.len();
                bytes.splice(from..from, block.repeat(times));
            }
        }
        _ => {}
    }
    bytes
}

/// Where words, numbers and single marks stand.
fn words(bytes: &[u8]) -> Vec<[usize; 2]> {
    let is_of_word = |byte: u8| byte.is_ascii_alphanumeric() || b"._+-".contains(&byte);
    let mut words = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let length = bytes[at..].iter().take_while(|&&byte| is_of_word(byte)).count().max(1);
        words.push([at, at + length]);
        at += length;
    }
    words
}
