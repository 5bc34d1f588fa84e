//! The parts, described once for both programs.

use glam::{DMat3, DVec3, dvec3};

/// A solid as set operations on primitives.
pub enum Shape {
    /// Between two corners.
    Cuboid(DVec3, DVec3),
    /// Center and radius.
    Sphere(DVec3, f64),
    /// Center, unit axis, radius; half the height, infinite without.
    Cylinder(DVec3, DVec3, f64, Option<f64>),
    /// Where `normal . p <= offset`.
    HalfSpace(DVec3, f64),
    /// A sheet of gyroid about the origin: period, and the thickness it about has.
    Gyroid(f64, f64),
    /// Intersection.
    All(Vec<Shape>),
    /// Union.
    Any(Vec<Shape>),
    /// Complement.
    Not(Box<Shape>),
    /// Turned about the origin.
    Turned(DMat3, Box<Shape>),
}

/// A solid and the cube it is meshed in.
pub struct Part {
    pub name: String,
    pub shape: Shape,
    /// Half the side of the cube about the origin that N cells divide.
    pub half: f64,
}

/// Cells do not line up with faces at 1.
const HALF: f64 = 1.237;
/// The same for a cube of side 2 in any position.
const HALF_TURNED: f64 = 1.75;

fn not(shape: Shape) -> Shape {
    Shape::Not(Box::new(shape))
}

fn cuboid(lo: [f64; 3], hi: [f64; 3]) -> Shape {
    Shape::Cuboid(lo.into(), hi.into())
}

/// An infinite cylinder.
fn bore(at: [f64; 3], axis: DVec3, r: f64) -> Shape {
    Shape::Cylinder(at.into(), axis, r, None)
}

/// A cube of side 2 with two crossing holes of radius 0.4.
pub fn cube_with_holes() -> Part {
    Part { name: "cube with holes".into(), shape: cube(), half: HALF }
}

fn cube() -> Shape {
    let holes = [DVec3::X, DVec3::Z].map(|axis| not(bore([0.0; 3], axis, 0.4)));
    Shape::All([cuboid([-1.0; 3], [1.0; 3])].into_iter().chain(holes).collect())
}

/// The same in general position, as in `data/cube_with_holes_rotated.py`.
pub fn rotated_cube_with_holes() -> Part {
    let axis = dvec3(0.30529502354055693, -0.2801478599619021, -0.9101165448227702).normalize();
    let turn = DMat3::from_axis_angle(axis, 179.85594446358624_f64.to_radians());
    Part { name: "rotated cube".into(), shape: Shape::Turned(turn, Box::new(cube())), half: HALF_TURNED }
}

/// A bracket of a dozen primitives: two plates, two bosses, a rib, eight holes.
pub fn bracket() -> Part {
    let boss = |at: [f64; 3], axis, r, half| Shape::Cylinder(at.into(), axis, r, Some(half));
    let rib = Shape::All(vec![
        cuboid([-0.9, -0.06, -0.5], [0.5, 0.06, 0.5]),
        Shape::HalfSpace(dvec3(1.0, 0.0, 1.0).normalize(), -0.95 / 2f64.sqrt()),
    ]);
    let solid = Shape::Any(vec![
        cuboid([-1.0, -0.6, -0.6], [1.0, 0.6, -0.4]),
        cuboid([-1.0, -0.6, -0.6], [-0.8, 0.6, 0.6]),
        boss([0.3, 0.0, -0.335], DVec3::Z, 0.3, 0.165),
        boss([-0.75, 0.0, 0.2], DVec3::X, 0.25, 0.15),
        rib,
    ]);
    let mut holes = vec![bore([0.3, 0.0, 0.0], DVec3::Z, 0.15), bore([0.0, 0.0, 0.2], DVec3::X, 0.12)];
    for x in [0.78, -0.4] {
        holes.extend([0.41, -0.41].map(|y| bore([x, y, 0.0], DVec3::Z, 0.08)));
    }
    holes.extend([0.4, -0.4].map(|y| bore([0.0, y, 0.4], DVec3::X, 0.07)));
    let shape = Shape::All([solid].into_iter().chain(holes.into_iter().map(not)).collect());
    Part { name: "bracket".into(), shape, half: HALF }
}

/// A block cut out of a sheet of gyroid.
pub fn gyroid_block() -> Part {
    let shape = Shape::All(vec![cuboid([-1.0; 3], [1.0; 3]), Shape::Gyroid(2.0, 0.3)]);
    Part { name: "gyroid block".into(), shape, half: HALF }
}

/// A union of `n` small spheres and short cylinders, strewn at random, the same for each call.
pub fn many(n: usize) -> Part {
    let mut random = Random(1);
    let scale = 0.6 / (n as f64).cbrt();
    let solids = (0..n).map(|k| {
        let center = DVec3::from_array(std::array::from_fn(|_| random.between(-0.9, 0.9)));
        let r = scale * random.between(0.5, 1.0);
        let axis = random.direction();
        let half = r * random.between(0.7, 1.5);
        if k % 2 == 0 { Shape::Sphere(center, r) } else { Shape::Cylinder(center, axis, 0.7 * r, Some(half)) }
    });
    Part { name: format!("{n} solids"), shape: Shape::Any(solids.collect()), half: HALF }
}

/// Steele, Lea and Flood's SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform on the sphere: a point of the ball, outward.
    fn direction(&mut self) -> DVec3 {
        loop {
            let p = DVec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)));
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}
