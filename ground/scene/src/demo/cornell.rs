//! The Cornell box, with the dimensions and reflectances that Cornell measured, scaled so that the
//! room is 2 units high; the blocks' edges are rounded by 4 millimetres.

use super::shape::{Form, block, sheet};
use super::stage::{Stage, placed};
use crate::{Material, MaterialId, Projection, Scene};
use chiaro_basis::math::{DQuat, Vec3, vec3};

/// Scene units a millimetre.
const SCALE: f32 = 2.0 / 548.8;

/// A point of the room from Cornell's millimetres (x left, y up, z into the room).
fn point(x: f32, y: f32, z: f32) -> Vec3 {
    vec3(278.0 - x, y, -z) * SCALE
}

/// The room with its luminaire, seen by Cornell's camera.
pub(super) fn cornell_box() -> Scene {
    let mut stage = Stage::default();
    let white = paint(&mut stage, "white", [0.73, 0.735, 0.729]);
    let red = paint(&mut stage, "red", [0.611, 0.0555, 0.062]);
    let green = paint(&mut stage, "green", [0.117, 0.4125, 0.115]);
    let lamp = stage.push_material(Material {
        name: "lamp".into(),
        base_colour: [0.78, 0.78, 0.78, 1.0],
        emissive: [17.0, 12.0, 4.0],
        double_sided: false,
        ..Material::default()
    });
    let (w, h, d) = (552.8, 548.8, 559.2);
    let mut wall = |name: &str, corners: [[f32; 3]; 4], material| {
        stage.thing(name, None, Default::default(), (quad(corners), material));
    };
    wall("floor", [[w, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, d], [w, 0.0, d]], white);
    wall("ceiling", [[w, h, 0.0], [w, h, d], [0.0, h, d], [0.0, h, 0.0]], white);
    wall("back wall", [[w, 0.0, d], [0.0, 0.0, d], [0.0, h, d], [w, h, d]], white);
    wall("right wall", [[0.0, 0.0, d], [0.0, 0.0, 0.0], [0.0, h, 0.0], [0.0, h, d]], green);
    wall("left wall", [[w, 0.0, 0.0], [w, 0.0, d], [w, h, d], [w, h, 0.0]], red);
    let y = h - 0.5;
    let lit = [[343.0, y, 227.0], [343.0, y, 332.0], [213.0, y, 332.0], [213.0, y, 227.0]];
    wall("luminaire", lit, lamp);
    put_block(
        &mut stage,
        "short block",
        [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0]],
        165.0,
        white,
    );
    put_block(
        &mut stage,
        "tall block",
        [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0]],
        330.0,
        white,
    );
    let fov_y = 2.0 * (0.0125f32 / 0.035).atan();
    let camera = Projection::Perspective { fov_y };
    stage.camera(point(278.0, 273.0, -800.0), point(278.0, 273.0, 0.0), camera, 1.0);
    stage.finish()
}

fn paint(stage: &mut Stage, name: &str, [r, g, b]: [f32; 3]) -> MaterialId {
    stage.push_material(Material {
        name: name.into(),
        base_colour: [r, g, b, 1.0],
        double_sided: false,
        ..Material::default()
    })
}

/// A wall through four corners, counter-clockwise seen from inside the room, in a few pieces.
fn quad(corners: [[f32; 3]; 4]) -> Form {
    let [a, b, c, d] = corners.map(|[x, y, z]| point(x, y, z));
    sheet(16, 16, |u, v| a.lerp(b, u).lerp(d.lerp(c, u), v))
}

/// A block that stands on the floor, given three consecutive corners (x, z) of its base.
fn put_block(
    stage: &mut Stage,
    name: &str,
    base: [[f32; 2]; 3],
    height: f32,
    material: MaterialId,
) {
    let [a, b, c] = base.map(|[x, z]| point(x, 0.0, z));
    let size = vec3(b.distance(c), height * SCALE, a.distance(b));
    let along = c - b;
    let turn = DQuat::from_rotation_y(f64::from((-along.z).atan2(along.x)));
    let centre = 0.5 * (a + c) + vec3(0.0, 0.5 * size.y, 0.0);
    let form = block(size, 4.0 * SCALE, 3);
    stage.thing(name, None, placed(centre.as_dvec3(), turn, 1.0), (form, material));
}
