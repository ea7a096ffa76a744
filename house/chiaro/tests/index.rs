//! Triangle counts of real files, stored and drawn, against the table that comes with them.

use chiaro::{Options, Project, info};
use chiaro_basis::Run;
use std::path::Path;

/// Path, triangles stored, and triangles drawn where the table tells them apart.
type Row = (String, u64, Option<u64>);

fn row(line: &str) -> Option<Row> {
    let cells: Vec<&str> = line.split('|').map(str::trim).collect();
    let file = cells.get(1)?;
    let read = [".gltf", ".glb", ".obj", ".ply"].iter().any(|e| file.ends_with(e));
    // Compressed files are refused by name.
    if !read || file.contains("/compressed/") {
        return None;
    }
    let number = |text: &str| text.split_whitespace().next()?.trim_matches(')').parse().ok();
    let counts = cells.get(5)?;
    let drawn = counts.split_once("as drawn ").and_then(|(_, n)| number(n));
    Some(((*file).to_owned(), number(counts)?, drawn))
}

#[test]
fn files_hold_and_draw_the_triangles_of_the_index() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let Ok(index) = std::fs::read_to_string(data.join("INDEX.md")) else {
        return println!("skipped: ../shared/data/INDEX.md is absent");
    };
    for (file, stored, drawn) in index.lines().filter_map(row) {
        let path = data.join(&file);
        if !path.is_file() {
            println!("skipped: {file} is absent");
            continue;
        }
        let run = Run::default();
        let project = Project::open(&path.to_string_lossy(), Options::default(), &run).unwrap();
        let counts = info::info(&project, &run).unwrap().counts;
        assert_eq!(counts["triangles"], stored, "{file}");
        if let Some(drawn) = drawn {
            assert_eq!(counts["triangles_drawn"], drawn, "{file}: drawn");
        }
    }
}
