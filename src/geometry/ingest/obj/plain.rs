//! The text of a .obj file, made plain for tobj.
//!
//! Programs write byte order marks, comments at the ends of lines, lines that go on after a
//! backslash, colours of vertices, normals that nothing needs. tobj is given the statements that
//! make a surface and nothing else.

use std::fmt::Write as _;
use std::path::Path;

use crate::support::file_error::FileError;

/// The statements of a .obj file that make a surface.
pub(super) struct Plain {
    /// One line for each line of the file. `o` has the number of a part instead of a name.
    pub text: String,
    /// What `o`, `g` and `usemtl` said for each run of faces.
    pub parts: Vec<Part>,
}

/// A run of faces of one object and one material.
#[derive(Clone, Default)]
pub(super) struct Part {
    pub object: Name,
    pub material: Name,
}

/// A name as it stands in the file: `#` may belong to it, or begin a comment.
#[derive(Clone, Default)]
pub(super) struct Name(String);

impl Name {
    /// The name; empty if the statement has none.
    ///
    /// A comment begins with a `#` between white space, so that `Material #25` stays whole.
    pub fn most_likely(&self) -> &str {
        let is_comment = |rest: &str| rest[1..].chars().next().is_none_or(is_between_words);
        self.before_comment(is_comment)
    }

    /// The one of its readings that is known, the longest first.
    pub fn known<T>(&self, of: impl Fn(&str) -> Option<T>) -> Option<T> {
        of(&self.0).or_else(|| of(self.most_likely())).or_else(|| of(self.before_comment(|_| true)))
    }

    fn before_comment(&self, is_comment: impl Fn(&str) -> bool) -> &str {
        let Self(text) = self;
        let begins = |&(at, _): &(usize, &str)| {
            text[..at].chars().next_back().is_none_or(is_between_words) && is_comment(&text[at..])
        };
        let end = text.match_indices('#').find(begins).map_or(text.len(), |(at, _)| at);
        text[..end].trim()
    }
}

impl Plain {
    /// Reads text whose lines end with `\n`. As a whole, its faces are one part.
    ///
    /// # Errors
    /// The surface is not made of polygons, is in another file, or a line is torn.
    pub fn new(path: &Path, text: &str, is_whole: bool) -> Result<Self, FileError> {
        let has = |word| text.lines().any(|line| keyword(line).eq_ignore_ascii_case(word));
        let mut writer = Writer {
            // A group within an object is a part of it.
            has_objects: has("o"),
            has_normals: has("vn"),
            normals: 0,
            text: String::with_capacity(text.len()),
            parts: vec![Part::default()],
        };
        // The first normal is for corners without one.
        writer.text.push_str(if writer.has_normals { "o 0\nvn 0 0 0\n" } else { "o 0\n\n" });
        let mut lines = (1..).zip(text.lines());
        let mut statement = String::new();
        while let Some((number, line)) = lines.next() {
            let mut joined = 0;
            statement.clear();
            statement.push_str(part_of_statement(line));
            while statement.ends_with('\\') {
                statement.pop();
                let Some((_, more)) = lines.next() else { break };
                statement.push(' ');
                statement.push_str(part_of_statement(more));
                joined += 1;
            }
            let wrong = |problem: String| FileError::wrong_in_line(path, number, problem);
            writer.statement(statement.trim(), is_whole).map_err(wrong)?;
            writer.text.extend(std::iter::repeat_n('\n', joined + 1));
        }
        Ok(Self { text: writer.text, parts: writer.parts })
    }

    /// Lines of the text before the first line of the file.
    pub const ADDED_LINES: usize = 2;
}

struct Writer {
    has_objects: bool,
    has_normals: bool,
    normals: i64,
    text: String,
    parts: Vec<Part>,
}

impl Writer {
    fn statement(&mut self, statement: &str, is_whole: bool) -> Result<(), String> {
        let word = keyword(statement);
        let rest = statement[word.len()..].trim();
        match &*word.to_ascii_lowercase() {
            // What follows the coordinates is a weight or a colour.
            "v" => self.words("v", rest.split_whitespace().take(3)),
            "vn" => {
                let mut normal = [0.0; 3];
                for (value, word) in normal.iter_mut().zip(rest.split_whitespace()) {
                    *value =
                        word.parse().ok().filter(|value: &f64| value.is_finite()).unwrap_or(0.0);
                }
                let [x, y, z] = normal;
                self.normals += 1;
                let _ = write!(self.text, "vn {x} {y} {z}");
            }
            "f" | "fo" => self.face(rest)?,
            "o" => self.begin(|part| part.object = Name(rest.to_owned()), is_whole),
            "g" if !self.has_objects => {
                self.begin(|part| part.object = Name(rest.to_owned()), is_whole);
            }
            "usemtl" => self.begin(|part| part.material = Name(rest.to_owned()), is_whole),
            "surf" | "bsp" | "bzp" => {
                return Err(format!("{word:?} is a curved surface: only polygons are read"));
            }
            "call" => return Err(format!("it takes in another file, {rest:?}")),
            other => {
                let number = other.strip_prefix(['v', 'f']).unwrap_or(other);
                if number.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
                    return Err(format!("{word:?} is not a keyword: the line seems to be torn"));
                }
            }
        }
        Ok(())
    }

    fn words<'a>(&mut self, keyword: &str, words: impl Iterator<Item = &'a str>) {
        self.text.push_str(keyword);
        words.for_each(|word| self.text.extend([" ", word]));
    }

    /// A face; with fewer than three corners it is none.
    fn face(&mut self, corners: &str) -> Result<(), String> {
        if corners.split_whitespace().nth(2).is_none() {
            let is_index = |word: &&str| {
                word.split('/').next().is_some_and(|index| index.parse::<i64>().is_ok())
            };
            let wrong = corners.split_whitespace().find(|word| !is_index(word));
            return wrong.map_or(Ok(()), |word| Err(format!("{word:?} is not a vertex of a face")));
        }
        self.text.push('f');
        for corner in corners.split_whitespace() {
            let mut indices = corner.split('/');
            self.text.extend([" ", indices.next().unwrap_or_default()]);
            if self.has_normals {
                let of = |normal: &str| match normal.parse::<i64>() {
                    Ok(index) if (1..=self.normals).contains(&index) => Some(index + 1),
                    Ok(index) if (-self.normals..0).contains(&index) => {
                        Some(self.normals + index + 2)
                    }
                    _ => None,
                };
                let normal = indices.nth(1).and_then(of).unwrap_or(1);
                let _ = write!(self.text, "//{normal}");
            }
        }
        Ok(())
    }

    fn begin(&mut self, change: impl FnOnce(&mut Part), is_whole: bool) {
        if is_whole {
            return;
        }
        let mut part = self.parts.last().cloned().unwrap_or_default();
        change(&mut part);
        let _ = write!(self.text, "o {}", self.parts.len());
        self.parts.push(part);
    }
}

/// White space, or a byte order mark, which stays where files were joined.
fn is_between_words(c: char) -> bool {
    c.is_whitespace() || c == '\u{feff}'
}

fn keyword(line: &str) -> &str {
    line.trim_start_matches(is_between_words).split(is_between_words).next().unwrap_or_default()
}

/// A line without its comment; nothing of a line that says nothing about the surface. What stays may
/// end with a backslash: then the statement goes on in the next line. A path may end with one too.
fn part_of_statement(line: &str) -> &str {
    let line = line.trim_matches(is_between_words);
    match keyword(line) {
        word if word.starts_with('#') || word.eq_ignore_ascii_case("mtllib") => "",
        word if ["o", "g", "usemtl"].iter().any(|name| word.eq_ignore_ascii_case(name)) => {
            // A name may hold a #, but what looks like a comment does not go on.
            if line.contains('#') { line.trim_end_matches('\\') } else { line }
        }
        _ => {
            // Some programs write numbers that are not finite as 1.#IND or 1.#QNAN.
            let is_comment = |&(at, _): &(usize, &str)| {
                let is_number = line[at + 1..].starts_with(['I', 'Q', 'S']);
                !(line[..at].ends_with("1.") && is_number)
            };
            let end = line.match_indices('#').find(is_comment).map_or(line.len(), |(at, _)| at);
            line[..end].trim_end()
        }
    }
}
