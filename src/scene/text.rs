//! Lines of OBJ and MTL files.

use crate::error::Error;
use std::borrow::Cow;
use std::path::Path;

/// Bytes as text. What is not UTF-8 is taken for Latin-1, as old exporters write names: every byte has its
/// own letter, so that names that differ stay different.
pub fn decode(bytes: Vec<u8>) -> String {
    let text = String::from_utf8(bytes).unwrap_or_else(|e| e.as_bytes().iter().map(|&b| b as char).collect());
    match text.strip_prefix('\u{feff}') {
        Some(rest) => rest.into(),
        None => text,
    }
}

/// The statements of a text. A backslash at a line's end continues it.
pub struct Statements<'a> {
    text: &'a str,
    /// Bytes read so far.
    pub at: usize,
    line: usize,
}

impl<'a> Statements<'a> {
    pub fn new(text: &'a str) -> Statements<'a> {
        Statements { text, at: 0, line: 0 }
    }

    fn line(&mut self) -> Option<&'a str> {
        let rest = self.text.get(self.at..).filter(|rest| !rest.is_empty())?;
        // Old Macs end lines with a carriage return alone.
        let end = rest.find(['\n', '\r']).unwrap_or(rest.len());
        let two = rest[end..].starts_with("\r\n");
        self.at += (end + if two { 2 } else { 1 }).min(rest.len());
        self.line += 1;
        Some(rest[..end].trim())
    }
}

impl<'a> Iterator for Statements<'a> {
    /// The number of the first line, from 1, and the statement.
    type Item = (usize, Cow<'a, str>);

    fn next(&mut self) -> Option<Self::Item> {
        let mut statement = Cow::Borrowed(self.line()?);
        let number = self.line;
        while let Some(open) = statement.strip_suffix('\\') {
            let mut joined = open.trim_end().to_string();
            joined.push(' ');
            joined += self.line().unwrap_or("");
            statement = Cow::Owned(joined);
        }
        Some((number, statement))
    }
}

/// Keyword and the rest of a statement.
pub fn split(statement: &str) -> (&str, &str) {
    let end = statement.find(char::is_whitespace).unwrap_or(statement.len());
    (&statement[..end], statement[end..].trim())
}

/// Words up to a comment.
pub fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|w| !w.starts_with('#'))
}

/// A name: all that is left, spaces too, but for a comment.
pub fn name(rest: &str) -> &str {
    // A comment follows a blank; '#' inside a word belongs to the name.
    let comment = rest.match_indices('#').map(|(i, _)| i).find(|&i| rest[..i].ends_with(char::is_whitespace) || i == 0);
    rest[..comment.unwrap_or(rest.len())].trim_end()
}

/// A line that does not hold what its keyword promises.
pub fn bad(path: &Path, line: usize, statement: &str, wanted: &str) -> Error {
    let shown: String = statement.chars().take(60).collect();
    Error::Format {
        path: path.into(),
        line: Some(line),
        what: format!("'{shown}' does not hold {wanted}"),
        cure: "correct the line or re-export the scene".into(),
    }
}

/// What a file holds and is not read: each sort once, with its number and first line, in order of appearance.
#[derive(Default)]
pub struct Unread(Vec<(String, usize, usize)>);

impl Unread {
    pub fn add(&mut self, what: &str, line: usize) {
        let what: String = what.chars().take(60).collect();
        // A file of noise must not become a warning of its size.
        let known = |what: &String| self.0.iter().position(|e| &e.0 == what);
        let (what, known) = match known(&what) {
            None if self.0.len() >= 20 => ("other".into(), known(&"other".into())),
            known => (what, known),
        };
        match known {
            Some(i) => self.0[i].1 += 1,
            None => self.0.push((what, 1, line)),
        }
    }

    /// One warning for the file; none where everything was read.
    pub fn warn(&self, path: &Path, warnings: &mut Vec<String>) {
        self.warn_as(path, "not supported and left out", "bake on without, or model it otherwise", warnings);
    }

    /// One warning that says what was done with it.
    pub fn warn_as(&self, path: &Path, done: &str, cure: &str, warnings: &mut Vec<String>) {
        if self.0.is_empty() {
            return;
        }
        let list: Vec<_> = self
            .0
            .iter()
            .map(|(what, n, line)| format!("{what} ({n} time{}, first on line {line})", if *n == 1 { "" } else { "s" }))
            .collect();
        warnings.push(format!("{}: {done}: {}; {cure}", path.display(), list.join(", ")));
    }
}
