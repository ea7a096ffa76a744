//! The concordance names functions and tests that exist.

use std::path::Path;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The (name, file) pairs of a line: `name` in `file`.
fn references(line: &str) -> Vec<(String, String)> {
    let parts: Vec<&str> = line.split('`').collect();
    let mut found = Vec::new();
    for i in (1..parts.len()).step_by(2) {
        if parts.get(i + 1) == Some(&" in ") {
            found.push((parts[i].to_owned(), parts[i + 2].to_owned()));
        }
    }
    found
}

#[test]
fn every_name_in_the_concordance_exists() {
    let text = std::fs::read_to_string(root().join("THESIS.md")).unwrap();
    let references: Vec<_> = text.lines().flat_map(references).collect();
    assert!(references.len() >= 18, "the table was read: {}", references.len());
    for (name, file) in references {
        let source = std::fs::read_to_string(root().join(&file));
        let source = source.unwrap_or_else(|e| panic!("{file}: {e}"));
        let is_there =
            source.contains(&format!("fn {name}(")) || source.contains(&format!("fn {name}<"));
        assert!(is_there, "THESIS.md names {name} in {file}, where it is not");
    }
}
