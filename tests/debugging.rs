//! docs/guide/debugging.md is run: every command in its order, its exit status, and what it is said to print.

use std::os::unix::fs::symlink;
use whole_chain::document::Document;
use whole_chain::scenario::root;

#[test]
fn every_command_does_what_the_document_says() {
    let folder = tempfile::tempdir().expect("a folder");
    for linked in ["examples", "scenes"] {
        symlink(root().join(linked), folder.path().join(linked)).expect("a link");
    }
    let document = Document::read("docs/guide/debugging.md");
    assert!(document.commands() >= 25, "{} commands were found", document.commands());
    document.run(folder.path(), &[]);
    assert!(folder.path().join("growth.svg").is_file());
}
