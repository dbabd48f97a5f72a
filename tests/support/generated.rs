//! Files of the project that are made from its code: compared, or with `INSTA_UPDATE=always` written again.

use crate::scenario::root;

/// Holds that `file`, a path within the project, is `text`.
pub fn whole(file: &str, text: &str) {
    let path = root().join(file);
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        std::fs::write(&path, text).unwrap_or_else(|e| panic!("{file}: {e}"));
    }
    let found = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
    let line = found.lines().zip(text.lines()).position(|(found, made)| found != made);
    let line = line.unwrap_or(found.lines().count().min(text.lines().count()));
    let (is, wanted) = (found.lines().nth(line).unwrap_or(""), text.lines().nth(line).unwrap_or(""));
    assert!(
        found == text,
        "{file}:{} is not what the code says; INSTA_UPDATE=always writes it again\n  is  {is}\n  not {wanted}",
        line + 1
    );
}

/// The same for the part of `file` between the marks `<!-- name: begin -->` and `<!-- name: end -->`.
pub fn part(file: &str, name: &str, text: &str) {
    let found = std::fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    let [begin, end] = ["begin", "end"].map(|side| format!("<!-- {name}: {side} -->"));
    let (before, rest) = found.split_once(&begin).unwrap_or_else(|| panic!("{file} has no mark {begin}"));
    let (_, after) = rest.split_once(&end).unwrap_or_else(|| panic!("{file} has no mark {end}"));
    whole(file, &format!("{before}{begin}\n\n{}\n\n{end}{after}", text.trim()));
}
