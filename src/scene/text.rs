//! Lines of OBJ and MTL files.

use crate::error::Error;
use std::borrow::Cow;
use std::path::Path;

/// Bytes as text. What is not UTF-8 is taken for Latin-1, as old exporters write names: every byte has its
/// own letter, so that names that differ stay different.
pub fn decode(mut bytes: Vec<u8>) -> String {
    if bytes.starts_with("\u{feff}".as_bytes()) {
        bytes.drain(..3);
    }
    String::from_utf8(bytes).unwrap_or_else(|e| e.as_bytes().iter().map(|&b| b as char).collect())
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
