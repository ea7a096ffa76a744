//! Trees and books in files: made, used again, shared, killed.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

const SMALL: [&str; 6] = ["--size", "64x48", "--set", "surfels=3000", "--set", "edges=1"];

fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chiaro"));
    command.current_dir(folder).args(["light", "demo:cornell-box"]).args(args).args(SMALL);
    command
}

fn light(folder: &Path, args: &[&str]) -> Output {
    command(folder, args).output().expect("the program runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn record(folder: &Path, name: &str) -> serde_json::Value {
    let bytes = std::fs::read(folder.join(name)).expect("a record");
    serde_json::from_slice(&bytes).expect("a record is JSON")
}

/// The pixels of a PNG as they are packed, without its recipe.
fn pixels(folder: &Path, name: &str) -> Vec<u8> {
    let bytes = std::fs::read(folder.join(name)).expect("a picture");
    let (mut at, mut packed) = (8, Vec::new());
    while at + 8 <= bytes.len() {
        let length = u32::from_be_bytes(std::array::from_fn(|i| bytes[at + i])) as usize;
        if &bytes[at + 4..at + 8] == b"IDAT" {
            packed.extend(&bytes[at + 8..at + 8 + length]);
        }
        at += 12 + length;
    }
    assert!(!packed.is_empty());
    packed
}

#[test]
fn two_renders_share_a_baked_tree_under_a_cap_and_draw_what_the_bake_drew() {
    let dir = tempfile::tempdir().expect("a folder");
    let baked = light(dir.path(), &["--bake", "a.pbgi", "-o", "a.png"]);
    assert!(baked.status.success(), "{}", stderr(&baked));
    let start = |name: &str| -> Child {
        let args = ["--tree", "a.pbgi", "--memory", "1GiB", "-o", name];
        command(dir.path(), &args).stderr(Stdio::piped()).spawn().expect("the program runs")
    };
    for child in [start("b.png"), start("c.png")] {
        let output = child.wait_with_output().expect("it ends");
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let truth = pixels(dir.path(), "a.png");
    assert!(pixels(dir.path(), "b.png") == truth && pixels(dir.path(), "c.png") == truth);
    let little = light(dir.path(), &["--tree", "a.pbgi", "--memory", "1MiB", "-o", "d.png"]);
    assert_eq!(little.status.code(), Some(1));
    assert!(stderr(&little).contains("--memory") && !dir.path().join("d.png").exists());
}

#[test]
fn what_a_tree_was_baked_with_holds_where_nothing_else_is_said() {
    let dir = tempfile::tempdir().expect("a folder");
    let baked = light(dir.path(), &["--set", "bounces=1", "--bake", "a.pbgi", "-o", "a.png"]);
    assert!(baked.status.success(), "{}", stderr(&baked));
    let with = |more: &[&str]| {
        let args = ["--tree", "a.pbgi", "--size", "64x48", "--set", "edges=1", "-o", "b.png"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_chiaro"));
        command.current_dir(dir.path()).args(["light", "demo:cornell-box"]).args(args);
        let output = command.args(["--json", "b.json"]).args(more).output().expect("it runs");
        assert!(output.status.success(), "{}", stderr(&output));
        record(dir.path(), "b.json")
    };
    let own = with(&[]);
    assert_eq!(
        (&own["settings"]["surfels"], &own["settings"]["bounces"]),
        (&3000.into(), &1.into())
    );
    assert_eq!(own["warnings"].as_array().map(Vec::len), Some(0), "{}", own["warnings"]);
    assert!(pixels(dir.path(), "a.png") == pixels(dir.path(), "b.png"));
    let said = with(&["--set", "bounces=2"]);
    assert_eq!(
        (&said["settings"]["surfels"], &said["settings"]["bounces"]),
        (&3000.into(), &2.into())
    );
    assert!(said["warnings"][0].as_str().is_some_and(|w| w.contains("bounces = 1 (here 2)")));
}

#[test]
fn a_book_is_made_once_and_read_then() {
    let dir = tempfile::tempdir().expect("a folder");
    let json = ["--json", "a.json", "--book", "a.book", "-o", "a.png"];
    let made = light(dir.path(), &json);
    assert!(made.status.success(), "{}", stderr(&made));
    let written = std::fs::read(dir.path().join("a.book")).expect("a book");
    let read = light(dir.path(), &["--json", "b.json", "--book", "a.book", "-o", "b.png"]);
    assert!(read.status.success(), "{}", stderr(&read));
    assert_eq!(pixels(dir.path(), "a.png"), pixels(dir.path(), "b.png"));
    assert_eq!(std::fs::read(dir.path().join("a.book")).expect("a book"), written);
    let learned = |name: &str| {
        let record = record(dir.path(), name);
        let stages = record["stages"].as_array().expect("stages").clone();
        stages.iter().any(|s| s["name"] == "book")
    };
    assert!(learned("a.json") && !learned("b.json"));
    std::fs::write(dir.path().join("a.book"), &written[..written.len() / 2]).expect("written");
    let cut = light(dir.path(), &["--book", "a.book", "-o", "c.png"]);
    assert_eq!(cut.status.code(), Some(1));
    assert!(stderr(&cut).contains("a.book"), "{}", stderr(&cut));
}

#[test]
fn smaller_errors_take_larger_codes() {
    let dir = tempfile::tempdir().expect("a folder");
    let bytes = |error: &str| {
        let args = ["--max-error", error, "--json", "a.json", "-o", "a.png"];
        let output = light(dir.path(), &args);
        assert!(output.status.success(), "{}", stderr(&output));
        let counts = record(dir.path(), "a.json")["counts"].clone();
        let found = counts["book_error"].as_f64().expect("an error");
        assert!(found <= error.parse().expect("a number"), "{found}");
        counts["code_bytes"].as_u64().expect("bytes")
    };
    assert!(bytes("0.2") < bytes("0.05"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_bake_that_was_killed_leaves_no_tree_and_the_next_sweeps_what_is_left() {
    let dir = tempfile::tempdir().expect("a folder");
    let parts = || {
        let entries = std::fs::read_dir(dir.path()).expect("a folder").flatten();
        entries.filter(|e| e.file_name().to_string_lossy().ends_with(".part")).count()
    };
    let mut child = Command::new(env!("CARGO_BIN_EXE_chiaro"))
        .current_dir(dir.path())
        .args(["light", "demo:cornell-box", "--size", "64x48", "--set", "surfels=3000000"])
        .args(["--set", "side_rays=0", "--set", "bounces=1", "--bake", "a.pbgi", "-o", "a.png"])
        .stderr(Stdio::null())
        .spawn()
        .expect("the program runs");
    for _ in 0..600 {
        if parts() > 0 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.kill().expect("it is killed");
    child.wait().expect("it ends");
    assert!(parts() == 1 && !dir.path().join("a.pbgi").exists());
    let again = light(dir.path(), &["--bake", "a.pbgi", "-o", "a.png"]);
    assert!(again.status.success(), "{}", stderr(&again));
    assert!(parts() == 0 && dir.path().join("a.pbgi").exists());
}
