//! The sequences of operators that methods are made of, each with the reasons for its order.

use super::grammar::Sequence;
#[cfg(doc)]
use super::{improve, improve_with};

/// See [`cut_sequence`].
const CUT: &str = "collapse-tiny flip-angles (R_all flip-angles)*2 \
    (cut survey (collapse flip-angles densify flip-angles R_edge R_regular)*2)*2 \
    (flip-angles R_regular)*2 flip-angles survey (degenerate relax flip-angles)*3 settle survey";

/// See [`paper_sequence`].
const PAPER: &str = "R_all*2 N*10 N1 degenerate classify (R_regular R_edge)*5 densify survey";

/// See [`operators_sequence`].
const OPERATORS: &str = "collapse-tiny flip-angles (R_all flip-angles)*2 N*5 \
    (N1 flip-normals degenerate flip-angles)*3 survey densify flip-angles (N1 degenerate flip-angles)*2 survey \
    (classify R_edge R_regular flip-angles degenerate)*5 survey";

/// A sequence known to be right: a test reads each.
fn known(text: &str) -> Sequence {
    text.parse().unwrap_or_default()
}

/// Our own sequence, which [`improve`] runs unless told otherwise. Its order was found by measuring on the cube with two crossing
/// holes (axis-aligned and turned), a turned cube and a cube with a spherical notch, at 16 to 97 cells per side:
///
/// 1. `collapse-tiny`, `flip-angles`, then twice `R_all` and `flip-angles`. Slivers of the extraction have meaningless
///    normals; an edge cut at a crease lands in the wrong order exactly where the triangle's normal is more than a right
///    angle off. Without this, ten of a few hundred triangles at creases turn over; one pass is not enough, three
///    are no better than two. Collapsing slivers (`degenerate`) instead is worse: large steps across creases.
/// 2. `cut`: all creases become edges. `N1` before it, the paper's way to creases, was measured and left out: it takes half
///    as long again, and nodes it puts *near* a curved crease leave no room for the exact ones (5 of 8 corners found
///    against 8 of 8).
/// 3. Four rounds of `collapse`, `flip-angles`, `densify`, `flip-angles`, `R_edge`, `R_regular`: edges of the wanted
///    length, good angles. After the second a `cut` repairs creases at which the first nodes had no room to move. Two
///    more passes of `R_regular` and `flip-angles` follow. Without these the 5 % angle is 37.5 instead of 39 degrees; two
///    passes in every round cost 150 ms more at 64 cells for the same.
/// 4. Three times `degenerate`, `relax`, `flip-angles`: the worst triangles, one by one. Once leaves the smallest angle
///    near 29 degrees, three times at 35.
/// 5. `settle`, `survey`: exact creases (to 1e-9 of the size), and the labels of the final triangles.
pub fn cut_sequence() -> Sequence {
    known(CUT)
}

/// What \[LIS14\] prints, its misprints corrected: `R_all` prepares, then its operators in the order of their equations, each as
/// often as it takes to come to rest, `N1` once as the paper has it, and needles that `N1` made are removed. No edge is
/// flipped, so chamfers stay; it is here to be studied. Every move is [guarded](super::guard), and [`improve_with`] runs
/// it again around faults: that the paper does not have.
pub fn paper_sequence() -> Sequence {
    known(PAPER)
}

/// The complex of \[LIS14\]: all its operators, in an order that was found by measuring on the cube with two crossing holes, a
/// cube and a cube with a spherical notch, along the axes and turned, at 24 to 64 cells per side.
///
/// 1. `collapse-tiny`, then `R_all` twice, with flips for angles between: `N1` needs triangles whose normals mean something.
///    Without `R_all` recall on the turned cube is 0.961 instead of 1, and angles below a degree stay.
/// 2. `N` five times. It turns triangles towards the surface; creases hardly need it (with and without, recall on the cube with
///    holes is 1.000 and 0.998 along the axes, 0.998 and 0.999 turned).
/// 3. Three rounds of `N1`, `flip-normals`, `degenerate`, `flip-angles`. `N1` puts two rows of nodes on one crease: edges
///    between faces become edges along the crease by flips that lower the normal deviation (5), and needles between the
///    rows are removed, but not the edges just made, which are marked. Without `flip-normals` recall falls to 0.991 on the turned cube with holes, and angles of 8 degrees stay.
///    Two rounds do as well as three at 32 cells.
/// 4. `densify` before smoothing: new nodes on marked edges lie on the crease. `N1` twice more takes in what the longer edges
///    cut off.
/// 5. Five rounds of classes, `R_edge`, `R_regular`, flips and removal of needles: angles. No angle stays below 20 degrees there.
pub fn operators_sequence() -> Sequence {
    known(OPERATORS)
}
