//! From bytes to text.

use crate::{Diagnostic, Excerpt, Span};

/// The text of a file, which is UTF-8.
///
/// # Errors
/// If it is not: a diagnostic that points at the first wrong byte, and that carries the text with marks in place of what
/// is wrong.
pub fn decode<'a>(file_name: &str, bytes: &'a [u8]) -> Result<&'a str, Box<Diagnostic>> {
    std::str::from_utf8(bytes).map_err(|error| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let start = error.valid_up_to();
        let span = Span { start, end: start + char::REPLACEMENT_CHARACTER.len_utf8() };
        let report = Diagnostic::error(span, "the file is not UTF-8 text")
            .label(format!("the byte {:#04x}", bytes[start]))
            .help("save it as UTF-8; the ASCII forms of all operators work everywhere");
        Box::new(Diagnostic { excerpt: Some(Excerpt { name: file_name.to_owned(), text }), ..report })
    })
}
