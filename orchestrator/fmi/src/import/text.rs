//! The text of an XML file in the encoding that it declares. The standard allows UTF-8 alone, and tools write others.

/// The text of an XML file: UTF-8 and UTF-16 by their marks, else in the encoding of its declaration. Of any other encoding, ASCII
/// alone can be read.
///
/// **Errors**: why it cannot be read, with what would help.
pub fn decode(bytes: &[u8]) -> Result<String, String> {
    match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => utf8(rest),
        [0xFF, 0xFE, rest @ ..] | rest @ [b'<', 0, ..] => utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] | rest @ [0, b'<', ..] => utf16(rest, u16::from_be_bytes),
        _ if bytes.is_ascii() => utf8(bytes),
        _ => match declared(bytes).as_deref() {
            // What says UTF-16 in single bytes was converted after it was written.
            None | Some("utf-8" | "utf8" | "us-ascii" | "ascii" | "utf-16") => utf8(bytes),
            Some("iso-8859-1" | "iso8859-1" | "latin1" | "latin-1" | "windows-1252" | "cp1252") => {
                Ok(bytes.iter().map(|byte| windows_1252(*byte)).collect())
            }
            Some("iso-8859-15" | "iso8859-15" | "latin9" | "latin-9") => {
                Ok(bytes.iter().map(|byte| iso_8859_15(*byte)).collect())
            }
            Some(other) => Err(format!(
                "its encoding {other:?} is not among those that can be read, UTF-8, UTF-16, ISO-8859-1, ISO-8859-15 and windows-1252; \
                 save it in UTF-8"
            )),
        },
    }
}

/// The encoding that the XML declaration names, in lower case.
fn declared(bytes: &[u8]) -> Option<String> {
    let end = bytes.windows(2).take(1024).position(|two| two == b"?>")?;
    let declaration = std::str::from_utf8(bytes[..end].strip_prefix(b"<?xml")?).ok()?;
    let value = declaration.split_once("encoding")?.1.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
    Some(value[1..].split_once(quote)?.0.trim().to_lowercase())
}

fn utf8(bytes: &[u8]) -> Result<String, String> {
    String::from_utf8(bytes.to_vec()).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count();
        format!(
            "in line {line}, byte {at} of the file, 0x{:02X}, is not UTF-8, as which it is read; save it in UTF-8, or declare its \
             encoding in its first line, <?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>",
            bytes[at]
        )
    })
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, String> {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let text: Result<String, _> = char::decode_utf16(units).collect();
    match text {
        Ok(text) if bytes.len().is_multiple_of(2) => Ok(text),
        _ => Err("its UTF-16 is damaged; save it in UTF-8".to_owned()),
    }
}

/// Also of ISO-8859-1, whose control characters 0x80 to 0x9F no text has: what says so mostly is windows-1252.
fn windows_1252(byte: u8) -> char {
    const FROM_0X80: [char; 32] = [
        '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8D}', 'Ž', '\u{8F}',
        '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9D}', 'ž', 'Ÿ',
    ];
    match byte {
        0x80..=0x9F => FROM_0X80[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

fn iso_8859_15(byte: u8) -> char {
    match byte {
        0xA4 => '€',
        0xA6 => 'Š',
        0xA8 => 'š',
        0xB4 => 'Ž',
        0xB8 => 'ž',
        0xBC => 'Œ',
        0xBD => 'œ',
        0xBE => 'Ÿ',
        _ => char::from(byte),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An XML file that declares `encoding`, with `content` as its bytes.
    fn file(encoding: &str, content: &[u8]) -> Vec<u8> {
        [format!("<?xml version=\"1.0\" encoding='{encoding}'?>\n<a b=\"").as_bytes(), content, b"\"/>"]
            .concat()
    }

    fn content(text: &str) -> &str {
        text.split_once("b=\"").and_then(|(_, rest)| rest.strip_suffix("\"/>")).expect("the content")
    }

    #[test]
    fn each_encoding_gives_the_same_text() {
        let text = "für 20 °C";
        let marked = |mark: &[u8], units: fn(u16) -> [u8; 2]| {
            let whole = String::from_utf8(file("UTF-16", text.as_bytes())).expect("UTF-8");
            let units: Vec<u8> = whole.encode_utf16().flat_map(units).collect();
            [mark, &units].concat()
        };
        let latin = b"f\xFCr 20 \xB0C";
        for bytes in [
            file("utf-8", text.as_bytes()),
            [b"\xEF\xBB\xBF", &*file("UTF-8", text.as_bytes())].concat(),
            file("ISO-8859-1", latin),
            file("iso-8859-15", latin),
            file("Windows-1252", latin),
            // Converted to UTF-8 without its declaration.
            file("utf-16", text.as_bytes()),
            marked(&[0xFF, 0xFE], u16::to_le_bytes),
            marked(&[0xFE, 0xFF], u16::to_be_bytes),
            marked(&[], u16::to_le_bytes),
            marked(&[], u16::to_be_bytes),
        ] {
            let read = decode(&bytes).expect("it is read");
            assert_eq!(content(&read), text, "{bytes:?}");
            assert!(read.starts_with("<?xml"), "no mark is left");
        }
        // No declaration.
        assert_eq!(decode("<a b=\"ü\"/>".as_bytes()).as_deref(), Ok("<a b=\"ü\"/>"));
    }

    /// The tables of the Unicode consortium, `8859-15.TXT` and `CP1252.TXT`, at the places where they differ from ISO-8859-1.
    #[test]
    fn special_characters_are_those_of_the_tables() {
        let read = |encoding: &str, bytes: &[u8]| {
            content(&decode(&file(encoding, bytes)).expect("it is read")).to_owned()
        };
        assert_eq!(read("windows-1252", b"\x80\x8A\x8E\x96\x99\x9F\xA4"), "€ŠŽ–™Ÿ¤");
        assert_eq!(read("iso-8859-15", b"\xA4\xA6\xA8\xB4\xB8\xBC\xBD\xBE"), "€ŠšŽžŒœŸ");
        assert_eq!(read("latin1", b"\xA4\xFF"), "¤ÿ");
    }

    #[test]
    fn what_cannot_be_read_is_named_with_its_place() {
        let said = |bytes: &[u8]| decode(bytes).expect_err("it is refused");
        let undeclared = said(b"<a\nb=\"f\xFCr\"/>");
        assert!(undeclared.starts_with("in line 2, byte 7 of the file, 0xFC, is not UTF-8"), "{undeclared}");
        assert!(undeclared.contains("encoding=\"ISO-8859-1\""), "{undeclared}");
        let unknown = said(&file("Shift_JIS", b"\x83\x5C"));
        assert!(
            unknown.contains("\"shift_jis\" is not among") && unknown.ends_with("save it in UTF-8"),
            "{unknown}"
        );
        // In ASCII all of them are the same.
        assert!(decode(&file("Shift_JIS", b"so")).is_ok());
        assert!(said(b"\xFF\xFE<\0\x00\xD8").contains("its UTF-16 is damaged"));
        assert!(said(b"\xFF\xFE<\0a").contains("its UTF-16 is damaged"));
    }
}
