//! The program as a user meets it: what it writes, what it says, how it ends.
#![allow(clippy::unwrap_used, reason = "a test may panic, also in its own functions")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn chiaro(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_chiaro"))
        .current_dir(folder)
        .args(args)
        .output()
        .expect("the program starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with a cube in it.
fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("cube.obj"), CUBE).unwrap();
    dir
}

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Files in a folder and below, hidden ones too.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(f) = folders.pop() {
        for entry in std::fs::read_dir(f).unwrap().map(|e| e.unwrap().path()) {
            if entry.is_dir() { folders.push(entry) } else { found.push(entry) }
        }
    }
    found.sort();
    found
}

#[test]
fn a_picture_is_the_same_for_any_number_of_threads() {
    let dir = folder();
    for threads in ["1", "2", "5"] {
        let name = format!("{threads}.png");
        let args =
            ["binary", "cube.obj", "-o", &name, "--size", "160x120", "--threads", threads, "-q"];
        let output = chiaro(dir.path(), &args);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(output.stderr.is_empty() && output.stdout.is_empty());
    }
    let bytes = |n: &str| std::fs::read(dir.path().join(n)).unwrap();
    assert_eq!(bytes("1.png"), bytes("2.png"));
    assert_eq!(bytes("1.png"), bytes("5.png"));
}

/// 4-connected white pieces of a bitmap whose rows are whole bytes, 1 for black.
fn white_pieces(rows: &[u8], width: usize, height: usize) -> usize {
    let black = |i: usize| rows[i / width * width / 8 + i % width / 8] >> (7 - i % width % 8) & 1;
    let mut left: Vec<bool> = (0..width * height).map(|i| black(i) == 0).collect();
    let mut pieces = 0;
    while let Some(first) = left.iter().position(|l| *l) {
        pieces += 1;
        let mut open = vec![first];
        while let Some(i) = open.pop() {
            if std::mem::take(&mut left[i]) {
                let (x, y) = (i % width, i / width);
                open.extend((x > 0).then(|| i - 1));
                open.extend((x + 1 < width).then(|| i + 1));
                open.extend((y > 0).then(|| i - width));
                open.extend((y + 1 < height).then(|| i + width));
            }
        }
    }
    pieces
}

#[test]
fn a_stencil_is_one_piece_and_says_what_it_cost() {
    let dir = folder();
    let with = |extra: &[&str]| {
        let start = ["binary", "cube.obj", "--size", "200x160", "--paper", "A4", "--json", "-"];
        chiaro(dir.path(), &[&start[..], extra].concat())
    };
    for file in ["a.png", "a.svg", "a.pbm", "a.tif"] {
        let output = with(&["--stencil", "4mm", "--smallest-part", "5mm", "-o", file]);
        assert!(output.status.success(), "{}", stderr(&output));
        let record: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(record["counts"]["bridges"].as_u64().is_some());
        assert!(record["counts"]["stencil_energy"].as_f64().unwrap().is_finite());
        assert_eq!(record["settings"]["stencil"]["bridge"], 4.0);
    }
    let ring = ["binary", "demo:bumpy-torus", "--size", "200x160", "--paper", "A4", "--json", "-"];
    let output = chiaro(dir.path(), &[&ring[..], &["--stencil", "4mm", "-o", "ring.pbm"]].concat());
    let record: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(record["counts"]["bridges"].as_u64().unwrap() > 0, "the hole of a ring is held");
    let bitmap = std::fs::read(dir.path().join("ring.pbm")).unwrap();
    assert_eq!(white_pieces(&bitmap[bitmap.len() - 25 * 160..], 200, 160), 1);
    let svg = std::fs::read_to_string(dir.path().join("a.svg")).unwrap();
    assert!(svg.contains("holes") && !svg.contains("<rect"));
    let thin = with(&["--stencil", "0.1mm", "-o", "b.png"]);
    assert_eq!(thin.status.code(), Some(1));
    assert!(stderr(&thin).contains("or a larger --size"), "{}", stderr(&thin));
    assert!(!dir.path().join("b.png").exists());
    let many = with(&["--stencil", "4mm", "--set", "palette=4", "-o", "b.pbm"]);
    assert!(many.status.success(), "{}", stderr(&many));
    let record: serde_json::Value = serde_json::from_slice(&many.stdout).unwrap();
    assert_eq!(record["counts"]["stencils"], 3, "the lightest is the paper");
    assert!(record["counts"]["stencil_energy"].as_f64().unwrap().is_finite());
    assert!(!dir.path().join("b.pbm").exists(), "each sheet is a file");
    for sheet in ["b-1.pbm", "b-2.pbm", "b-3.pbm"] {
        let bitmap = std::fs::read(dir.path().join(sheet)).unwrap();
        assert_eq!(white_pieces(&bitmap[bitmap.len() - 25 * 160..], 200, 160), 1, "{sheet}");
    }
}

#[test]
fn the_record_has_its_keys() {
    let dir = folder();
    let args = ["binary", "cube.obj", "-o", "a.pbm", "--size", "96x96", "--json", "-", "-q"];
    let output = chiaro(dir.path(), &args);
    let record: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for key in [
        "command",
        "version",
        "settings",
        "seed",
        "threads",
        "outputs",
        "stages",
        "peak_bytes",
        "warnings",
        "counts",
    ] {
        assert!(!record[key].is_null(), "{key}");
    }
    for key in [
        "pixels",
        "nodes",
        "flow",
        "cut",
        "white_fraction",
        "components",
        "islands_under_30px",
        "island_energy",
        "boundary_px",
        "feature_share",
        "feature_share_by_chance",
    ] {
        assert!(record["counts"][key].is_number(), "{key}");
    }
    assert_eq!(record["counts"]["flow"], record["counts"]["cut"]);
    assert_eq!(record["counts"]["islands_under_30px"], 0);
    assert_eq!(record["settings"]["global"], 0.35);
}

#[test]
fn info_counts_what_is_stored() {
    let dir = folder();
    let output = chiaro(dir.path(), &["info", "cube.obj", "--json", "-", "-q"]);
    let record: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(record["counts"]["triangles"], 12);
    assert_eq!(record["counts"]["triangles_drawn"], 12);
    assert_eq!(record["counts"]["vertices"], 8);
}

#[test]
fn a_film_resumes_with_what_is_missing_or_damaged() {
    let dir = folder();
    let film = |extra: &[&str]| {
        let mut args = vec![
            "binary",
            "cube.obj",
            "-o",
            "film/####.png",
            "--turntable",
            "--size",
            "64x48",
            "--shot",
            "1-4",
            "-q",
        ];
        args.extend(extra);
        let output = chiaro(dir.path(), &args);
        assert!(output.status.success(), "{}", stderr(&output));
    };
    let frame = |n: u32| dir.path().join(format!("film/{n:04}.png"));
    film(&["--frames", "1-4"]);
    let whole: Vec<Vec<u8>> = (1..=4).map(|n| std::fs::read(frame(n)).unwrap()).collect();
    assert!(whole[0] != whole[1], "the turntable turns");
    let untouched = std::fs::metadata(frame(2)).unwrap().modified().unwrap();
    std::fs::remove_file(frame(3)).unwrap();
    std::fs::write(frame(4), b"half").unwrap();
    film(&["--frames", "1-4"]);
    for n in 1..=4 {
        assert_eq!(std::fs::read(frame(n)).unwrap(), whole[n as usize - 1], "frame {n}");
    }
    assert_eq!(std::fs::metadata(frame(2)).unwrap().modified().unwrap(), untouched);
    // A part of the shot has the bytes of the whole.
    std::fs::remove_dir_all(dir.path().join("film")).unwrap();
    film(&["--frames", "3"]);
    assert_eq!(std::fs::read(frame(3)).unwrap(), whole[2]);
    // Other settings make the frame anew.
    film(&["--frames", "3", "--set", "global=0.9"]);
    assert_ne!(std::fs::read(frame(3)).unwrap(), whole[2]);
}

#[test]
fn what_cannot_be_done_is_one_sentence_and_nothing_is_written() {
    let dir = folder();
    let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
    write("empty.obj", "");
    write("points.obj", "v 0 0 0\nv 1 0 0\n");
    write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    write("nan.obj", "v nan nan nan\nv 1 0 0\nv 2 1 0\nf 1 2 3\n");
    write("a.blend", "BLENDER");
    write("junk.glb", "glTF and then nothing of it");
    std::fs::create_dir(dir.path().join("folder.png")).unwrap();
    let before = files(dir.path());
    let cases: [(&[&str], &str); 18] = [
        (&["missing.obj"], "not found"),
        (&["cub.obj"], "did you mean"),
        (&["empty.obj"], "empty"),
        (&["points.obj"], "no geometry"),
        (&["flat.obj"], "no geometry"),
        (&["nan.obj"], "no geometry"),
        (&["a.blend"], "File > Export > glTF 2.0"),
        (&["junk.glb"], "junk.glb"),
        (&["."], "folder"),
        (&["demo:nothing"], "golf-ball"),
        (&["cube.obj", "--size", "0x0"], "--size"),
        (&["cube.obj", "--size", "100000x100000"], "--size"),
        (&["cube.obj", "--frames", "0"], "--frames"),
        (&["cube.obj", "--frames", "1-3"], "pattern"),
        (&["cube.obj", "--style", "inc"], "did you mean ink?"),
        (&["cube.obj", "--set", "globul=1"], "did you mean global?"),
        (&["cube.obj", "--ink", "blakc"], "black"),
        (&["cube.obj", "--camera", "left"], "--camera"),
    ];
    for (args, expected) in cases {
        let mut all = vec!["binary", "-q", "-o", "out.png"];
        all.extend(args);
        let output = chiaro(dir.path(), &all);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{args:?}: {said}");
        assert!(said.contains(expected), "{args:?}: {said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{args:?}: {said}");
        assert_eq!(files(dir.path()), before, "{args:?}");
    }
    let output =
        chiaro(dir.path(), &["binary", "cube.obj", "-o", "folder.png", "-q", "--size", "8x8"]);
    // A folder takes frames of its own.
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(dir.path().join("folder.png/0001.png").is_file());
}

#[test]
fn wrong_usage_ends_with_two() {
    let dir = folder();
    for args in [&["binary"][..], &["binry"], &["binary", "cube.obj", "-o", "a.png", "--nothing"]] {
        assert_eq!(chiaro(dir.path(), args).status.code(), Some(2), "{args:?}");
    }
}

#[test]
fn styles_completions_and_manual_are_printed() {
    let dir = folder();
    let shown = chiaro(dir.path(), &["style", "show", "etched"]).stdout;
    std::fs::write(dir.path().join("mine.toml"), shown).unwrap();
    for style in ["etched", "mine.toml"] {
        let name = format!("{style}.pbm");
        let args = ["binary", "cube.obj", "-o", &name, "--style", style, "--size", "64x64", "-q"];
        assert!(chiaro(dir.path(), &args).status.success());
    }
    let bytes = |n: &str| std::fs::read(dir.path().join(n)).unwrap();
    assert_eq!(bytes("etched.pbm"), bytes("mine.toml.pbm"));
    for args in [&["completions", "bash"][..], &["man"], &["style", "list"], &["--help"]] {
        let output = chiaro(dir.path(), args);
        assert!(output.status.success() && output.stdout.len() > 100, "{args:?}");
    }
}

#[test]
fn a_picture_compares_equal_with_itself() {
    let dir = folder();
    for (name, g) in [("a.png", "global=0.2"), ("b.png", "global=1")] {
        let args = ["binary", "cube.obj", "-o", name, "--size", "64x64", "-q", "--set", g];
        assert!(chiaro(dir.path(), &args).status.success());
    }
    let changed = |a: &str, b: &str| {
        let output = chiaro(dir.path(), &["compare", a, b, "--json", "-", "-q"]);
        let record: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        record["counts"]["changed_pixels"].as_u64().unwrap()
    };
    assert_eq!(changed("a.png", "a.png"), 0);
    assert_eq!(chiaro(dir.path(), &["compare", "a.png", "cube.obj"]).status.code(), Some(1));
}

#[test]
fn the_graph_is_dumped_as_arrays_of_the_pictures_shape() {
    let dir = folder();
    let args = ["binary", "cube.obj", "-o", "a.png", "--size", "50x40", "-q", "--dump-graph"];
    let output = chiaro(dir.path(), &[&args[..], &["new/graph", "--json", "a.json"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    for (name, shape, bytes) in [
        ("terminal", "'<i4', 'fortran_order': False, 'shape': (40, 50, 2)", 16_000),
        ("neighbour", "'<i4', 'fortran_order': False, 'shape': (40, 50, 4)", 32_000),
        ("mask", "'|u1', 'fortran_order': False, 'shape': (40, 50)", 2000),
        ("labels", "'|u1', 'fortran_order': False, 'shape': (40, 50)", 2000),
    ] {
        let array = std::fs::read(dir.path().join(format!("new/graph/{name}.npy"))).unwrap();
        assert_eq!(array.len(), 128 + bytes, "{name}");
        assert!(String::from_utf8_lossy(&array[..128]).contains(shape), "{name}");
    }
    let output = chiaro(dir.path(), &[&args[..], &["cube.obj"]].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("cube.obj: is a file"), "{}", stderr(&output));
}

#[test]
fn a_maximum_flow_problem_is_solved_checked_and_written() {
    let dir = folder();
    let text = "p max 4 5\nn 1 s\nn 4 t\na 1 2 7\na 1 3 2\na 2 3 3\na 2 4 4\na 3 4 9\n";
    std::fs::write(dir.path().join("a.max"), text).unwrap();
    let args = ["mincut", "a.max", "--verify", "-q", "-o", "a.sol", "--json", "a.json"];
    let output = chiaro(dir.path(), &args);
    assert!(output.status.success(), "{}", stderr(&output));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("flow     9\ncut      9\ntime"), "{said}");
    let solution = std::fs::read_to_string(dir.path().join("a.sol")).unwrap();
    assert!(solution.starts_with("s 9\nf 1 2 7\n"), "{solution}");
    let record = std::fs::read(dir.path().join("a.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    assert_eq!(record["counts"]["flow"], 9);
    assert_eq!(record["counts"]["verified"], true);
    std::fs::write(dir.path().join("b.max"), text.replace("a 1 3 2", "a 1 9 2")).unwrap();
    let output = chiaro(dir.path(), &["mincut", "b.max", "-q"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("b.max: line 5: "), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn a_watched_scene_is_drawn_again_when_it_changes_and_not_before() {
    let dir = folder();
    let mut child = Command::new(env!("CARGO_BIN_EXE_chiaro"))
        .current_dir(dir.path())
        .args(["binary", "cube.obj", "-o", "cube.png", "--size", "32x32", "--watch", "-q"])
        .args(["--json", "record.json"])
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let (picture, record) = (dir.path().join("cube.png"), dir.path().join("record.json"));
    let wait = |done: &dyn Fn() -> bool| {
        (0..400).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            done()
        })
    };
    assert!(wait(&|| record.exists()), "the first picture");
    let first = std::fs::read(&picture).unwrap();
    let made = |path: &Path| std::fs::metadata(path).unwrap().modified().unwrap();
    let time = made(&record);
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert_eq!(made(&record), time, "its own files do not wake it");
    std::fs::write(dir.path().join("cube.obj"), CUBE.replace("f 1 4 3 2\n", "")).unwrap();
    let redrawn = wait(&|| std::fs::read(&picture).is_ok_and(|p| p != first));
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(redrawn, "the second picture");
}

#[test]
fn a_film_that_was_killed_goes_on_to_the_bytes_of_an_unbroken_one() {
    let dir = folder();
    let film = |name: &'static str| {
        let pattern = format!("{name}/####.png");
        let mut command = Command::new(env!("CARGO_BIN_EXE_chiaro"));
        command.current_dir(dir.path()).args(["binary", "cube.obj", "-q", "-o"]).arg(pattern);
        command.args(["--frames", "1-20", "--turntable", "--size", "96x96"]);
        command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
        command
    };
    let start = std::time::Instant::now();
    assert!(film("whole").status().unwrap().success());
    let whole = start.elapsed();
    let mut unfinished = 0;
    for i in 1..=8u32 {
        let mut child = film("killed").spawn().unwrap();
        std::thread::sleep(whole * i / 9);
        child.kill().unwrap();
        child.wait().unwrap();
        unfinished += u32::from(!dir.path().join("killed/0020.png").exists());
    }
    assert!(unfinished > 0, "no kill came before the end");
    assert!(film("killed").status().unwrap().success());
    for frame in 1..=20 {
        let bytes = |f: &str| std::fs::read(dir.path().join(f).join(format!("{frame:04}.png")));
        assert_eq!(bytes("whole").unwrap(), bytes("killed").unwrap(), "frame {frame}");
    }
}

#[test]
fn lines_over_regions_resume_and_strokes_say_what_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let film = dir.path().join("####.png");
    let film = film.to_str().unwrap();
    let args = ["lines", "demo:peanut", "--style", "comic", "--size", "120x90", "--frames", "1-3"];
    let run = |extra: &[&str]| {
        let output = chiaro(dir.path(), &[&args[..], &["-q", "-o", film], extra].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(&[]);
    let bytes = |n: u32| std::fs::read(dir.path().join(format!("{n:04}.png"))).unwrap();
    let whole = [bytes(1), bytes(2), bytes(3)];
    std::fs::remove_file(dir.path().join("0002.png")).unwrap();
    run(&["--threads", "1"]);
    assert_eq!(whole, [bytes(1), bytes(2), bytes(3)]);
    run(&["--set", "width=9"]);
    assert!(whole[0] != bytes(1), "a knob of the brush changes the picture");

    let svg = dir.path().join("a.svg");
    let said = chiaro(
        dir.path(),
        &["lines", "demo:peanut", "--style", "thorns", "-q", "-o", svg.to_str().unwrap()],
    );
    assert!(said.status.success());
    let text = std::fs::read_to_string(&svg).unwrap();
    for part in ["data-u0=\"", "data-pixels-per-u=\"", "data-mark=\"thorns\"", "id=\"silhouette-"] {
        assert!(text.contains(part), "no {part}");
    }
    let pen = chiaro(
        dir.path(),
        &["lines", "demo:peanut", "--pen", "0.4mm", "-q", "-o", svg.to_str().unwrap()],
    );
    assert!(pen.status.success());
    let text = std::fs::read_to_string(&svg).unwrap();
    assert!(text.contains("stroke-width=\"0.4\"") && !text.contains(" fill=\"#"));
}

#[test]
fn films_of_lines_with_next_to_nothing_in_them_are_films() {
    let dir = folder();
    let wall = "v -90 -90 3\nv 90 -90 3\nv 90 90 3\nv -90 90 3\nf 9 10 11 12\n";
    std::fs::write(dir.path().join("wall.obj"), format!("{CUBE}{wall}")).unwrap();
    let at = |from: &'static str, to: &'static str| ["--from", from, "--look-at", to];
    let (near, far) = (at("0.5,0.5,9", "0.5,0.5,0.5"), at("0.5,0.5,700", "0.5,0.5,0.5"));
    let away = at("0.5,0.5,9", "0.5,0.5,90");
    let all = ["--set", "shortest=0", "--set", "prune=0", "--hidden", "dashed"];
    for method in ["global", "propagate", "diffuse", "arclength"] {
        for texture in ["texture=periodic", "texture=stretched"] {
            let count = |scene: &str, frames: &str, extra: &[&str]| {
                let look = ["--size", "64x48", "--style", "brush", "--set", texture, "-q"];
                let args = ["lines", scene, "--frames", frames, "--method", method, "-o", "o.json"];
                let output = chiaro(dir.path(), &[&args[..], &look, extra].concat());
                assert!(output.status.success(), "{method} {texture}: {}", stderr(&output));
                let text = std::fs::read_to_string(dir.path().join("o.json")).unwrap();
                assert!(!text.contains("NaN") && !text.contains("inf"), "{method} {texture}");
                text.matches("\"type\":").count()
            };
            assert!(count("cube.obj", "1-2", &[]) >= 2, "two frames that stand still");
            assert_eq!(count("wall.obj", "1-3", &near), 0, "everything is hidden");
            assert_eq!(count("cube.obj", "1-3", &away), 0, "nothing is there");
            count("cube.obj", "1-3", &[&far[..], &all].concat());
        }
    }
}

#[test]
fn styles_are_for_lines_or_for_regions() {
    let dir = tempfile::tempdir().unwrap();
    let no = |args: &[&str], hint: &str| {
        let output = chiaro(dir.path(), args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {said}");
        assert!(said.contains(hint), "{args:?}: {said}");
    };
    no(&["lines", "demo:peanut", "-o", "x.png", "--style", "woodcut"], "chiaro binary");
    no(&["binary", "demo:peanut", "-o", "x.png", "--style", "fur"], "chiaro lines");
    no(&["lines", "demo:peanut", "-o", "x.png", "--style", "fuzz"], "one of");
    no(&["lines", "demo:peanut", "-o", "x.png", "--set", "widht=3"], "did you mean width?");
    no(&["lines", "demo:peanut", "-o", "x.png", "--over", "there"], "nothing, binary");
    no(&["lines", "demo:peanut", "-o", "x.png", "--over", "no.png"], "no.png");
    no(&["lines", "demo:cactus", "-o", "x.png", "--without", "spine"], "did you mean spines?");
}

#[test]
fn pictures_of_one_row_or_column_are_drawn() {
    let dir = folder();
    for size in ["1x1", "8000x1", "1x8000"] {
        let args = ["binary", "cube.obj", "-o", "thin.png", "--size", size, "-q"];
        let output = chiaro(dir.path(), &args);
        assert!(output.status.success(), "{size}: {}", stderr(&output));
    }
}

#[test]
fn what_is_read_is_not_written_over() {
    let dir = folder();
    let cube = std::fs::read(dir.path().join("cube.obj")).unwrap();
    chiaro(dir.path(), &["light", "cube.obj", "-o", "env.png", "--size", "16x8", "-q"]);
    let picture = std::fs::read(dir.path().join("env.png")).unwrap();
    let card = "mtllib card.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";
    std::fs::write(dir.path().join("card.obj"), card).unwrap();
    std::fs::write(dir.path().join("card.mtl"), "newmtl a\nmap_Kd env.png\n").unwrap();
    for args in [
        &["light", "cube.obj", "--env", "env.png", "-o", "./env.png"][..],
        &["light", "cube.obj", "-o", "a.png", "--bake", "cube.obj"],
        &["binary", "cube.obj", "-o", "a.png", "--json", "cube.obj"],
        &["lines", "cube.obj", "-o", "cube.obj"],
        &["light", "card.obj", "-o", "env.png"],
        &["lines", "card.obj", "-o", "env.png"],
        &["binary", "card.obj", "-o", "env.png"],
    ] {
        let output = chiaro(dir.path(), args);
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        assert!(stderr(&output).contains("would be written over"), "{}", stderr(&output));
        assert_eq!(stderr(&output).lines().count(), 1, "{}", stderr(&output));
    }
    assert_eq!(std::fs::read(dir.path().join("cube.obj")).unwrap(), cube);
    assert_eq!(std::fs::read(dir.path().join("env.png")).unwrap(), picture);
}

#[cfg(unix)]
#[test]
fn films_in_one_file_are_ours_or_the_encoders() {
    use std::os::unix::fs::PermissionsExt;
    let dir = folder();
    let film = |name: &str, path: &Path| {
        Command::new(env!("CARGO_BIN_EXE_chiaro"))
            .current_dir(dir.path())
            .env("PATH", path)
            .args(["lines", "cube.obj", "-o", name, "--frames", "1-3", "--turntable", "-q"])
            .args(["--size", "33x21"])
            .output()
            .unwrap()
    };
    let tools = dir.path().join("tools");
    std::fs::create_dir(&tools).unwrap();
    assert!(film("a.gif", &tools).status.success());
    assert!(std::fs::read(dir.path().join("a.gif")).unwrap().starts_with(b"GIF89a"));

    let without = film("a.mp4", &tools);
    assert_eq!(without.status.code(), Some(1), "{}", stderr(&without));
    assert!(stderr(&without).contains("no ffmpeg on the PATH"), "{}", stderr(&without));

    // An encoder that keeps the frames as they are, and one that refuses them.
    let encoder = tools.join("ffmpeg");
    let script = |text: &str| {
        std::fs::write(&encoder, text).unwrap();
        std::fs::set_permissions(&encoder, PermissionsExt::from_mode(0o755)).unwrap();
    };
    script("#!/bin/sh\nfor last; do :; done\nexec /bin/cat > \"$last\"\n");
    let with = film("a.mp4", &tools);
    assert!(with.status.success(), "{}", stderr(&with));
    assert_eq!(std::fs::read(dir.path().join("a.mp4")).unwrap().len(), 3 * 33 * 21 * 3);
    script("#!/bin/sh\necho 'no such codec' >&2\nexit 1\n");
    let refused = film("b.webm", &tools);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("no such codec"), "{}", stderr(&refused));
    let names = files(dir.path());
    assert!(names.iter().all(|f| !f.to_string_lossy().contains("b.webm")), "{names:?}");
}
