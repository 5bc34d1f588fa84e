//! Fidget's side: min and max of exact signed distances, meshed by manifold dual contouring with its own compiler.

use fidget::context::Tree;
use fidget::jit::JitFunction;
use fidget::mesh::{Mesh, Octree, Settings};
use fidget::shape::{BoundShape, Shape as FidgetShape};
use glam::{DMat3, DVec3};
use nalgebra::Matrix4;

use crate::part::Shape;

/// Fidget's formula of a solid: negative inside, as it wants it.
pub fn tree(shape: &Shape) -> Tree {
    field(shape, DMat3::IDENTITY)
}

/// Meshes the cube of half side `half` with 2^depth = `n` cells a side.
pub fn mesh(tree: &Tree, half: f64, n: u32) -> Mesh {
    let shape = FidgetShape::<JitFunction>::from(tree.clone());
    let shape: BoundShape<_, f32> = shape.try_into().expect("no variables but x, y and z");
    let settings = Settings {
        depth: n.ilog2() as u8,
        world_to_model: Matrix4::new_scaling(half as f32),
        threads: None,
        ..Default::default()
    };
    let octree = Octree::build(&shape, &settings).expect("nobody cancels");
    octree.walk_dual()
}

fn field(shape: &Shape, turn: DMat3) -> Tree {
    match shape {
        Shape::Cuboid(lo, hi) => {
            let sides = (0..3).flat_map(|i| {
                let n = turn * DVec3::AXES[i];
                [plane(n, hi[i]), plane(-n, -lo[i])]
            });
            fold(sides.collect(), |a, b| a.max(b))
        }
        Shape::Sphere(center, r) => {
            let c = turn * *center;
            let squares = (0..3).map(|i| (axis(i) - constant(c[i])).square());
            fold(squares.collect(), |a, b| a + b).sqrt() - constant(*r)
        }
        Shape::Cylinder(center, axis, r, half) => {
            let (c, a) = (turn * *center, turn * *axis);
            let (u, v) = a.any_orthonormal_pair();
            let side = (plane(u, u.dot(c)).square() + plane(v, v.dot(c)).square()).sqrt() - constant(*r);
            match half {
                Some(h) => side.max(plane(a, a.dot(c) + h).max(plane(-a, h - a.dot(c)))),
                None => side,
            }
        }
        Shape::HalfSpace(normal, offset) => plane(turn * *normal, *offset),
        Shape::Gyroid(period, thickness) => gyroid(*period, *thickness, turn),
        Shape::All(of) => fold(of.iter().map(|s| field(s, turn)).collect(), |a, b| a.max(b)),
        Shape::Any(of) => fold(of.iter().map(|s| field(s, turn)).collect(), |a, b| a.min(b)),
        Shape::Not(of) => -field(of, turn),
        Shape::Turned(by, of) => field(of, turn * *by),
    }
}

/// |g(2 pi p / period)| period / 2 pi - thickness / 2
fn gyroid(period: f64, thickness: f64, turn: DMat3) -> Tree {
    let k = std::f64::consts::TAU / period;
    let angle = DVec3::AXES.map(|a| plane(turn * a, 0.0) * constant(k));
    let terms = (0..3).map(|i| angle[i].sin() * angle[(i + 1) % 3].cos());
    fold(terms.collect(), |a, b| a + b).abs() * constant(1.0 / k) - constant(0.5 * thickness)
}

fn constant(x: f64) -> Tree {
    Tree::constant(x as f32)
}

fn axis(i: usize) -> Tree {
    [Tree::x, Tree::y, Tree::z][i]()
}

/// `normal . p - offset`, without the terms that vanish.
fn plane(normal: DVec3, offset: f64) -> Tree {
    let terms = (0..3).filter(|&i| normal[i].abs() > 1e-15).map(|i| match normal[i] {
        1.0 => axis(i),
        -1.0 => -axis(i),
        n => axis(i) * constant(n),
    });
    fold(terms.collect(), |a, b| a + b) - constant(offset)
}

/// Pairs up until one is left: a balanced tree.
fn fold(mut trees: Vec<Tree>, join: impl Fn(Tree, Tree) -> Tree) -> Tree {
    while trees.len() > 1 {
        let mut rest = trees.into_iter();
        let mut joined = Vec::new();
        while let Some(a) = rest.next() {
            joined.push(match rest.next() {
                Some(b) => join(a, b),
                None => a,
            });
        }
        trees = joined;
    }
    trees.pop().expect("no primitive and no operation is empty")
}
