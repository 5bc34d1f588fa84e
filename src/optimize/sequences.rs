//! The sequences of operators that methods are made of, each with the reasons for its order.

use super::grammar::Sequence;
#[cfg(doc)]
use super::{improve, improve_with};

/// See [`cut_sequence`].
const CUT: &str = "collapse-tiny flip-angles (R_all flip-angles)*2 \
    (cut survey (collapse flip-angles densify flip-angles R_edge R_regular)*2)*2 \
    (flip-angles R_regular)*2 flip-angles survey (degenerate relax flip-angles)*3 settle survey";

/// See [`paper_sequence`].
const PAPER: &str = "project R_all*2 N*10 N1*2 classify (R_edge R_regular)*5 densify degenerate N1 survey";

/// See [`operators_sequence`].
const OPERATORS: &str = "project R_all*2 N*10 N1*2 classify (R_edge R_regular)*5 densify degenerate N1 survey";

/// A sequence known to be right: a test reads each.
fn known(text: &str) -> Sequence {
    text.parse().unwrap_or_default()
}

/// The sequence [`improve`] runs unless told otherwise. Its order was found by measuring on the cube with two crossing
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

/// The sequence \[LIS14\] describes, corrected: projection, smoothing, `N`, `N1`, classes by curvature, smoothing by class,
/// densification, `N1` again. No edge is flipped or cut, so chamfers stay; it is here to be compared with. It is not the paper's
/// word for word: every move is [guarded](super::guard), needles are removed, and [`improve_with`] runs it again around faults.
pub fn paper_sequence() -> Sequence {
    known(PAPER)
}

/// The complex of \[LIS14\].
pub fn operators_sequence() -> Sequence {
    known(OPERATORS)
}
