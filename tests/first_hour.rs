//! docs/guide/first-hour.md is run: its commands, its files, what they print; the page's sections are those that it names.

use std::os::unix::fs::symlink;
use std::thread;
use whole_chain::document::Document;
use whole_chain::scenario::root;
use whole_chain::{document, generated};

const DOCUMENT: &str = "docs/guide/first-hour.md";
/// What the tests have: the program, and an environment with the packages of `tests/python/requirements.txt`.
const PROVIDED: [&str; 4] = [
    "cargo build --release",
    "export PATH=$PWD/target/release:$PATH",
    "python3 -m venv .venv && .venv/bin/pip install ./python fmpy==0.3.32",
    ". .venv/bin/activate",
];

/// Titles of the sections of a page.
fn titles(page: &str) -> Vec<String> {
    let parts = page.split("<h2><span>").skip(1);
    let title =
        |part: &str| part.split_once("</span> ")?.1.split_once("</h2>").map(|(title, _)| title.to_owned());
    parts.filter_map(title).collect()
}

/// The first column of the table with this heading.
fn column(text: &str, heading: &str) -> Vec<String> {
    let rows = text.lines().skip_while(|line| !line.starts_with(heading)).skip(2);
    let rows = rows.take_while(|line| line.starts_with('|'));
    rows.filter_map(|line| line.split('|').nth(1)).map(|cell| cell.trim().to_owned()).collect()
}

#[test]
fn the_first_hour_is_as_it_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    for linked in ["examples", "scenes"] {
        symlink(root().join(linked), folder.path().join(linked)).expect("a link");
    }
    let sections = document::sections(DOCUMENT);
    let titles_of: Vec<&str> = sections.iter().map(|(title, _)| &**title).collect();
    assert_eq!(titles_of.len(), 10, "{titles_of:?}");
    let commands: usize = sections.iter().map(|(_, section)| section.commands()).sum();
    assert!(commands >= 30, "{commands} commands were found");
    let run = |numbers: &[usize]| {
        for number in numbers {
            let (_, section): &(String, Document) = &sections[*number];
            section.run(folder.path(), &PROVIDED);
        }
    };
    // As the document says: 5, 6 and 7 need the first two alone.
    for together in [&[&[0, 1, 2][..], &[3]][..], &[&[4, 5], &[6], &[7], &[8, 9]]] {
        thread::scope(|scope| together.iter().for_each(|numbers| drop(scope.spawn(|| run(numbers)))));
    }
    let read = |path: &str| std::fs::read_to_string(folder.path().join(path)).expect("it was written");
    let text = document::text(DOCUMENT);
    let shown = titles(&read("runs/first/report.html"));
    let mut rest = shown.iter();
    for named in column(&text, "| section of the page |") {
        assert!(
            rest.any(|title| *title == named),
            "`{named}` is no section of the page, or not there: {shown:?}"
        );
    }
    for (page, words) in [
        (
            "runs/mine/report.html",
            &["What is not modelled", "Largest principal stress", "Checks", "✗ failed"][..],
        ),
        ("runs/mine/report-reduced.html", &["Differences in the inputs"]),
        ("series/report.html", &["no curve"]),
    ] {
        let page_text = read(page);
        for words in words {
            assert!(
                text.contains(words) && page_text.contains(words),
                "{page} or {DOCUMENT} lacks `{words}`"
            );
        }
    }
    generated::whole("docs/figures/my-dam.svg", &read("my-dam/section.svg"));
}
