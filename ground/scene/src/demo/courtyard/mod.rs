//! A courtyard: arcades on columns round a paved court, a gallery with balustrades above, tiled
//! roofs; a fountain, trees in pots, lanterns, a table with chairs.
//!
//! Metres; the court lies at y = 0, its middle at the origin. The size says how many bays the sides
//! have (size + 3 and size + 1); what repeats is stored once and drawn as copies, so that millions
//! of triangles take little memory. A bay runs along +x from 0 to [`BAY`], the court on its +z side.

mod bay;
mod column;
mod fountain;
mod furniture;
mod roof;
mod tree;

use super::motion::{follow, turning};
use super::shape::{between, block, layers};
use super::stage::{Stage, boxed, mesh, moved, placed};
use crate::{MaterialId, Projection, Scene, Transform};
use chiaro_basis::math::{DQuat, DVec3, Vec3, dvec3, vec2, vec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The length of a bay.
const BAY: f32 = 3.2;
/// From the columns to the back wall.
const DEPTH: f32 = 2.7;
/// Heights: the gallery's floor, where arches spring, the upper floor, the upper beam, the wall.
const FLOOR: f32 = 0.3;
const SPRING: f32 = 3.3;
const UPPER: f32 = 5.35;
const BEAM: f32 = 7.9;
const WALL: f32 = 9.5;

/// What the house is built of.
struct Stuff {
    stone: MaterialId,
    plaster: MaterialId,
    paving: MaterialId,
    tile: MaterialId,
    wood: MaterialId,
    iron: MaterialId,
}

/// Where the bays stand.
struct Plan {
    /// Bays along x and z.
    bays: [usize; 2],
    /// Half the court's length and width.
    half: [f64; 2],
}

/// A side of the court: where its first bay begins, its turn, its number of bays.
struct Side {
    start: DVec3,
    turn: DQuat,
    count: usize,
}

/// The courtyard of a size.
pub(super) fn courtyard(size: u32) -> Scene {
    let mut stage = Stage::default();
    let stuff = Stuff::new(&mut stage);
    let plan = Plan::new(size as usize);
    put_bays(&mut stage, &stuff, &plan);
    put_corners(&mut stage, &stuff, &plan);
    pave(&mut stage, &stuff, &plan);
    roof::put(&mut stage, &stuff, &plan.sides());
    fountain::put(&mut stage, &stuff);
    tree::put(&mut stage, &plan.trees());
    furniture::put(&mut stage, &stuff, plan.at(0.30, 0.34));
    hang_lanterns(&mut stage, &stuff, &plan);
    stage.sun(vec3(0.62, -0.88, -0.50), 4.0);
    let [x, z] = plan.half;
    let projection = Projection::Perspective { fov_y: 52f32.to_radians() };
    let to = dvec3(0.42 * x, 2.75, -0.55 * z).as_vec3();
    stage.camera(plan.eye().as_vec3(), to, projection, 4.0 / 3.0);
    stage.finish()
}

impl Stuff {
    fn new(stage: &mut Stage) -> Self {
        let mottled = |seed: u64, dark: [f32; 3], light: [f32; 3]| {
            move |u: f32, v: f32| {
                let turn = |x: f32| chiaro_basis::math::Vec2::from_angle(std::f32::consts::TAU * x);
                let (a, b) = (turn(u), turn(v));
                let t = 0.5 + 0.5 * layers(seed, vec3(a.x + 2.0 * b.x, a.y + 2.0 * b.y, b.y), 5);
                std::array::from_fn(|k| dark[k] + (light[k] - dark[k]) * t.clamp(0.0, 1.0))
            }
        };
        let plaster = mottled(121, [0.80, 0.64, 0.44], [0.90, 0.78, 0.60]);
        let paving = mottled(122, [0.58, 0.54, 0.48], [0.76, 0.72, 0.65]);
        Self {
            stone: stage.matt("limestone", 0xd9cdb6),
            plaster: stage.painted("plaster", 0.95, [256, 256], plaster),
            paving: stage.painted("paving", 0.85, [256, 256], paving),
            tile: stage.matt("roof tile", 0xb4623f),
            wood: stage.material("wood", 0x5a3d28, 0.7, 0.0),
            iron: stage.material("iron", 0x2b2b2e, 0.5, 0.6),
        }
    }
}

impl Plan {
    fn new(size: usize) -> Self {
        let bays = [size + 3, size + 1];
        Self { bays, half: bays.map(|n| 0.5 * f64::from(BAY) * n as f64) }
    }

    /// The sides: at the back, on the right, in front, on the left.
    fn sides(&self) -> [Side; 4] {
        let [x, z] = self.half;
        let corners = [[-x, -z], [x, -z], [x, z], [-x, z]];
        std::array::from_fn(|k| Side {
            start: dvec3(corners[k][0], 0.0, corners[k][1]),
            turn: DQuat::from_rotation_y(-FRAC_PI_2 * k as f64),
            count: self.bays[k % 2],
        })
    }

    /// A place in the court, in parts of its half sizes.
    fn at(&self, x: f64, z: f64) -> DVec3 {
        dvec3(x * self.half[0], 0.0, z * self.half[1])
    }

    /// Where the camera stands: in a corner, at a man's height.
    fn eye(&self) -> DVec3 {
        dvec3(0.9 - self.half[0], 1.9, self.half[1] - 0.5)
    }

    /// Where trees stand: before the columns, every other bay, not before the camera.
    fn trees(&self) -> Vec<DVec3> {
        let before = |s: &Side| {
            let along = |i: usize| s.place(i, dvec3(0.0, 0.0, 1.35));
            (1..s.count).step_by(2).map(along).collect::<Vec<_>>()
        };
        let free = |p: &DVec3| p.distance(self.eye()) > 3.5;
        self.sides().iter().flat_map(before).filter(free).collect()
    }
}

impl Side {
    /// A point of bay `i` in the world.
    fn place(&self, i: usize, p: DVec3) -> DVec3 {
        self.start + self.turn * (DVec3::X * (f64::from(BAY) * i as f64) + p)
    }

    /// What stands at `p` in bay `i`, facing the court.
    fn stand(&self, i: usize, p: DVec3) -> Transform {
        placed(self.place(i, p), self.turn, 1.0)
    }
}

/// Everything that repeats from bay to bay.
fn put_bays(stage: &mut Stage, stuff: &Stuff, plan: &Plan) {
    let sides = plan.sides();
    let each = |shift: usize| -> Vec<Transform> {
        let of = |s: &Side| (shift..s.count).map(|i| s.stand(i, DVec3::ZERO)).collect::<Vec<_>>();
        sides.iter().flat_map(of).collect()
    };
    let bays = each(0);
    let joints = each(1);
    let stone = bay::front().with(bay::archivolt()).with(bay::cornice()).with(bay::balustrade());
    for (name, form, material) in [
        ("bay", stone, stuff.stone),
        ("vault", bay::vault(BAY, DEPTH), stuff.plaster),
        ("steps", bay::steps(), stuff.stone),
        ("beams", bay::beams(), stuff.wood),
    ] {
        let mesh = stage.mesh(name, [(form, material)]);
        stage.copies(name, mesh, bays.clone());
    }
    let wall = mesh("back", [(bay::wall(BAY), stuff.plaster)]).mapped(boxed(vec2(0.2, 0.2)));
    let wall = stage.push_mesh(wall);
    stage.copies("back", wall, bays.clone());
    let parts = [(bay::frames(), stuff.stone), (bay::leaves(), stuff.wood)];
    let doors = stage.push_mesh(mesh("doors", parts));
    stage.copies("doors", doors, bays);
    let column = stage.mesh("column", [(column::column(), stuff.stone)]);
    stage.copies("column", column, joints.clone());
    let colonnette = stage.mesh("colonnette", [(column::colonnette(), stuff.stone)]);
    stage.copies("colonnette", colonnette, joints);
}

/// Piers at the corners of the court, and the squares of the gallery behind them.
fn put_corners(stage: &mut Stage, stuff: &Stuff, plan: &Plan) {
    let corners: Vec<Transform> = plan.sides().iter().map(|s| s.stand(0, DVec3::ZERO)).collect();
    let pier = stage.mesh("pier", [(column::pier(), stuff.stone)]);
    stage.copies("pier", pier, corners.clone());
    let vault = bay::vault(DEPTH, DEPTH).at(-DEPTH, 0.0, 0.0);
    let vault = stage.mesh("corner vault", [(vault, stuff.plaster)]);
    stage.copies("corner vault", vault, corners.clone());
    let back = bay::wall(DEPTH).at(-DEPTH, 0.0, 0.0);
    let side = bay::wall(DEPTH + 0.3).turned_y(90.0).at(0.0, 0.0, 0.0);
    let walls = back.with(side);
    let walls = mesh("corner back", [(walls, stuff.plaster)]).mapped(boxed(vec2(0.2, 0.2)));
    let walls = stage.push_mesh(walls);
    stage.copies("corner back", walls, corners);
}

/// Flags in the court and along the gallery, none quite level, on the ground.
fn pave(stage: &mut Stage, stuff: &Stuff, plan: &Plan) {
    const FLAG: f64 = 0.8;
    let flag = block(vec3(0.775, 0.16, 0.775), 0.018, 1);
    let flag = mesh("flag", [(flag, stuff.paving)]).mapped(boxed(vec2(0.9, 0.9)));
    let flag = stage.push_mesh(flag);
    let [x, z] = plan.half;
    let (outer_x, outer_z) = (x + f64::from(DEPTH), z + f64::from(DEPTH));
    let mut flags = Vec::new();
    let count = |half: f64| (2.0 * half / FLAG).ceil() as i64;
    let (nx, nz) = (count(outer_x) / 2 + 1, count(outer_z) / 2 + 1);
    for j in -nz..nz {
        for i in -nx..nx {
            let (px, pz) = ((i as f64 + 0.5) * FLAG, (j as f64 + 0.5) * FLAG);
            let inside = px.abs() < x - 0.55 && pz.abs() < z - 0.55;
            let outside = px.abs() > x - 0.2 || pz.abs() > z - 0.2;
            if px.abs() > outer_x || pz.abs() > outer_z || !(inside || outside) {
                continue;
            }
            let seed = (i + 4096) as u64 * 8192 + (j + 4096) as u64;
            let jitter = |k: u64, reach: f32| f64::from(between(123 + k, seed, -reach, reach));
            let tilt = dvec3(jitter(0, 0.006), jitter(1, 0.012), jitter(2, 0.006));
            let y = if inside { 0.0 } else { f64::from(FLOOR) } - 0.08 + jitter(3, 0.006);
            flags.push(placed(dvec3(px, y, pz), DQuat::from_scaled_axis(tilt), 1.0));
        }
    }
    stage.copies("flag", flag, flags);
    let ground = block(vec3(2.0 * outer_x as f32 + 1.0, 0.4, 2.0 * outer_z as f32 + 1.0), 0.02, 1);
    let ground = ground.at(0.0, -0.225, 0.0);
    stage.thing("ground", None, moved(0.0, 0.0, 0.0), (ground, stuff.stone));
}

/// Lanterns on chains in every other arch, swinging a little.
fn hang_lanterns(stage: &mut Stage, stuff: &Stuff, plan: &Plan) {
    let parts = furniture::lantern(stage, stuff);
    let lantern = stage.push_mesh(mesh("lantern", parts));
    for (k, side) in plan.sides().iter().enumerate() {
        for i in (k % 2..side.count).step_by(2) {
            let hook = side.stand(i, dvec3(0.5 * f64::from(BAY), 4.52, 0.0));
            let node = stage.joint("hook", None, hook);
            let lamp = stage.show("lantern", Some(node), moved(0.0, 0.0, 0.0), lantern);
            let start = 0.13 * (i + 3 * k) as f64;
            let wind = follow(|t| 0.06 * (TAU * (t + start)).sin(), 0.8, 0.25);
            stage.animate(lamp, turning(|t| DQuat::from_rotation_x(wind.at(t))));
        }
    }
}

/// A row of points from one to another.
fn row(a: Vec3, b: Vec3, pieces: usize) -> Vec<Vec3> {
    (0..=pieces).map(|k| a.lerp(b, k as f32 / pieces as f32)).collect()
}
