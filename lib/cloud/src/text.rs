//! Parsing shared by the text formats: byte order marks, lines, words and numbers.

/// A text that is not in ASCII or UTF-8.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("it is in UTF-16")]
pub struct Utf16;

/// Skips UTF-8's byte order mark, which Windows editors write before the first line.
///
/// # Errors
/// [`Utf16`] where the mark is that of UTF-16.
pub fn without_mark(bytes: &[u8]) -> Result<&[u8], Utf16> {
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        return Err(Utf16);
    }
    Ok(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes))
}

/// Iterator over lines, each trimmed of white space.
#[derive(Debug, Clone)]
pub struct Lines<'a> {
    rest: &'a [u8],
    /// The byte that ends a line: line feed, or carriage return as on old Macs.
    end: u8,
    taken: usize,
}

impl<'a> Lines<'a> {
    /// Lines of a text, all of which end like the first one.
    pub fn new(bytes: &'a [u8]) -> Self {
        let ends = |window: &&[u8]| window[0] == b'\n' || window[0] == b'\r';
        let first = bytes.windows(2).find(ends);
        let end = match first {
            Some([b'\r', after]) if *after != b'\n' => b'\r',
            _ => b'\n',
        };
        Self {
            rest: bytes,
            end,
            taken: 0,
        }
    }

    /// Number of lines taken so far, which is the number of the last one, from 1.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// The bytes after the last line taken.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let end = self.rest.iter().position(|&byte| byte == self.end);
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        self.taken += 1;
        Some(line.trim_ascii())
    }
}

/// The words of a line; invalid UTF-8 is replaced.
pub fn words(line: &[u8]) -> Vec<String> {
    let words = line.split(u8::is_ascii_whitespace);
    words
        .filter(|word| !word.is_empty())
        .map(|word| String::from_utf8_lossy(word).into_owned())
        .collect()
}

/// Words between white space, wherever the lines end.
#[derive(Debug, Clone)]
pub struct Tokens<'a> {
    rest: &'a [u8],
}

impl<'a> Tokens<'a> {
    /// The words of a whole text.
    pub fn new(text: &'a [u8]) -> Self {
        Self { rest: text }
    }
}

/// Whether a byte separates words: white space, DOS's end-of-file mark (26) and C's terminating 0.
fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0B | 0x0C | 0x1A | 0)
}

impl<'a> Iterator for Tokens<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let start = self.rest.iter().position(|&byte| !is_space(byte))?;
        let rest = &self.rest[start..];
        let end = rest.iter().position(|&byte| is_space(byte));
        let (token, rest) = rest.split_at(end.unwrap_or(rest.len()));
        self.rest = rest;
        Some(token)
    }
}

/// Parses a number as programs print it, including `nan`, `-nan(ind)`, `-inf` and `1.#QNAN0`.
///
/// # Errors
/// The token is no number; the text names it.
pub fn number(token: &[u8]) -> Result<f32, String> {
    let text = String::from_utf8_lossy(token);
    if let Ok(number) = text.parse() {
        return Ok(number);
    }
    let lower = text.to_ascii_lowercase();
    let (sign, unsigned) = match lower.strip_prefix('-') {
        Some(unsigned) => (-1.0, unsigned),
        None => (1.0, lower.strip_prefix('+').unwrap_or(&lower)),
    };
    if unsigned.starts_with("inf") || unsigned.starts_with("1.#inf") {
        Ok(sign * f32::INFINITY)
    } else if ["nan", "1.#ind", "1.#qnan", "1.#snan"]
        .iter()
        .any(|name| unsigned.starts_with(name))
    {
        Ok(f32::NAN)
    } else if unsigned.replace(',', ".").parse::<f32>().is_ok() {
        Err(format!("{text:?} has a decimal comma"))
    } else {
        let short: String = text.chars().take(40).collect();
        Err(format!("{short:?} is no number"))
    }
}

/// Parses an integer, also one written like `3.0`.
///
/// # Errors
/// The token is no number, or has a fraction.
pub fn whole(token: &[u8]) -> Result<i64, String> {
    let text = String::from_utf8_lossy(token);
    if let Ok(whole) = text.parse() {
        return Ok(whole);
    }
    number(token)?;
    // Double precision represents every index that a file can have.
    let value: f64 = text.parse().unwrap_or(f64::NAN);
    if value.fract() == 0.0 && value.abs() < 1e15 {
        Ok(value as i64)
    } else {
        Err(format!("{text:?} is no whole number"))
    }
}
