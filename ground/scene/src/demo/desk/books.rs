//! Books: a row that stands, the last one leaning, and a stack with an apple on it.

use super::super::fruit;
use super::super::shape::{Form, Profile, ball, block, prism};
use super::super::stage::{Stage, boxed, mesh, moved, placed};
use crate::{MaterialId, Mesh};
use chiaro_basis::math::{DMat3, DQuat, DVec3, Vec3, dvec3, vec2, vec3};

/// Width (from spine to fore edge), thickness, height; colour of the cover.
type Book = (Vec3, u32);

const ROW: [Book; 6] = [
    (Vec3::new(1.60, 0.52, 2.30), 0x6b2d2a),
    (Vec3::new(1.45, 0.36, 2.05), 0xd8c9a3),
    (Vec3::new(1.70, 0.66, 2.52), 0x24425c),
    (Vec3::new(1.35, 0.30, 1.90), 0xb7792f),
    (Vec3::new(1.55, 0.48, 2.20), 0x2f3b2c),
    (Vec3::new(1.50, 0.42, 2.12), 0x8c3f3a),
];

const STACK: [Book; 3] = [
    (Vec3::new(2.00, 0.62, 2.75), 0x38506b),
    (Vec3::new(1.75, 0.46, 2.40), 0xc6a15b),
    (Vec3::new(1.55, 0.54, 2.10), 0x5b2b3a),
];

/// What every book is made of besides its cover.
struct Stock {
    pages: MaterialId,
    gold: MaterialId,
}

/// The row at the back, the stack on the right.
pub(super) fn put(stage: &mut Stage) {
    let line = |_: f32, v: f32| {
        let s = 0.82 + 0.12 * (v * 150.0).sin() * (v * 47.0).cos();
        [s, 0.95 * s, 0.83 * s]
    };
    let pages = stage.painted("pages", 0.9, [8, 256], line);
    let stock = Stock { pages, gold: stage.material("gilt", 0xc9a227, 0.35, 1.0) };
    put_row(stage, &stock, vec3(1.85, 0.0, -3.3));
    put_stack(stage, &stock, vec3(5.35, 0.0, -1.55));
}

fn put_row(stage: &mut Stage, stock: &Stock, at: Vec3) {
    let stone = stage.material("stone", 0x77736c, 0.5, 0.0);
    let end = block(vec3(0.5, 1.3, 1.3), 0.06, 3).at(at.x - 0.27, 0.65, at.z + 0.75);
    let end = end.with(ball(14).scaled(0.42, 0.42, 0.42).at(at.x - 0.27, 1.66, at.z + 0.75));
    stage.thing("book end", None, Default::default(), (end, stone));
    // Heights are drawn upwards, spines face the front.
    let standing = DQuat::from_mat3(&DMat3::from_cols(DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y));
    let mut x = f64::from(at.x);
    for (i, book) in ROW.iter().enumerate() {
        let size = book.0.as_dvec3();
        let lean = if i + 1 == ROW.len() { 0.21 } else { 0.0 };
        let foot = dvec3(x + size.z * f64::sin(lean), 0.0, f64::from(at.z) + 0.08 * (i % 3) as f64);
        let turn = DQuat::from_rotation_z(lean);
        let middle = foot + turn * dvec3(0.5 * size.y, 0.5 * size.z, 0.0) + DVec3::Z * 0.5 * size.x;
        let mesh = bound(stage, book, stock);
        let mesh = stage.push_mesh(mesh);
        stage.show("book", None, placed(middle, turn * standing, 1.0), mesh);
        x += size.y + 0.015;
    }
}

fn put_stack(stage: &mut Stage, stock: &Stock, at: Vec3) {
    let mut y = 0.0;
    for (book, turn) in STACK.iter().zip([0.30, -0.12, 0.52]) {
        let middle = dvec3(f64::from(at.x), y + 0.5 * f64::from(book.0.y), f64::from(at.z));
        let mesh = bound(stage, book, stock);
        let mesh = stage.push_mesh(mesh);
        let lying = DQuat::from_rotation_y(turn + std::f64::consts::FRAC_PI_2);
        stage.show("book", None, placed(middle, lying, 1.0), mesh);
        y += f64::from(book.0.y) + 0.004;
    }
    let paints = fruit::Paints::new(stage);
    let apple = fruit::apple(stage, &paints);
    let place = moved(f64::from(at.x) - 0.1, y, f64::from(at.z) + 0.15);
    stage.show("apple", None, place, apple);
}

/// A book about its middle: spine towards -x, head towards +z.
fn bound(stage: &mut Stage, (size, colour): &Book, stock: &Stock) -> Mesh {
    let cover = stage.material(&format!("cover {colour:06x}"), *colour, 0.6, 0.0);
    let board = block(vec3(size.x, 0.07, size.z), 0.03, 2);
    let half = 0.5 * size.y - 0.035;
    let mut covers = board.clone().at(0.0, half, 0.0).with(board.at(0.0, -half, 0.0));
    covers = covers.with(spine(size, size.z, 0.0));
    for k in 0..4 {
        let z = size.z * (0.3 - 0.2 * k as f32);
        covers = covers.with(spine(&(*size + vec3(0.06, 0.03, 0.0)), 0.07, z));
    }
    let inner = vec3(size.x - 0.10, size.y - 0.13, size.z - 0.14);
    let pages = block(inner, 0.02, 2).at(-0.02, 0.0, 0.0);
    let title = block(vec3(0.55 * size.x, 0.02, 0.16 * size.z), 0.008, 1);
    let rule = block(vec3(0.4 * size.x, 0.02, 0.03), 0.008, 1);
    let y = 0.5 * size.y + 0.004;
    let title = title.at(0.1, y, 0.24 * size.z).with(rule.at(0.1, y, -0.3 * size.z));
    mesh("book", [(covers, cover), (pages, stock.pages), (title, stock.gold)])
        .mapped(boxed(vec2(0.6, 0.6)))
}

/// A rounded back of the book's thickness, `length` long, at `z`.
fn spine(size: &Vec3, length: f32, z: f32) -> Form {
    let round = 0.17 * size.y;
    let outline = Profile::rectangle(0.13, size.y, 0.05).refined(0.09);
    let x = 0.5 * size.x - 0.05;
    let bent = prism(&outline, length, 0.02).turned_x(90.0).bent(|p| {
        let s = 2.0 * p.y / size.y;
        vec3(p.x - x - round * (1.0 - s * s), p.y, p.z)
    });
    bent.at(0.0, 0.0, z - 0.5 * length)
}
