//! The arrangement of linear functions in one tetrahedron, and the boundary of a Boolean of them.
//!
//! Nothing but signs goes in: of values at the four corners, and of small determinants of them. A point of the arrangement is
//! known by the edge, face or inside of the tetrahedron it lies in and by the leaves that vanish there, so neighbors that see
//! the same values on a common face see the same points, segments and sides on it.

use super::exact::{MOST, Matrix, positive};

/// No leaf.
const NONE: u8 = u8::MAX;

/// A point: the corners of the face of the tetrahedron that it lies inside of, by bits, and the leaves that vanish there, by
/// their places in the list, ascending: one less than corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Vertex {
    pub(super) corners: u8,
    pub(super) leaves: [u8; 3],
}

/// What an edge of a polygon lies on: the face of the tetrahedron across from corner 0 to 3, or leaf `n - 4`.
type Carrier = u8;

/// A convex piece of a leaf's zero set.
#[derive(Debug, Clone)]
struct Polygon {
    /// Each with the carrier of the edge to the next.
    corners: Vec<(Vertex, Carrier)>,
    /// By leaf of the list, whether it is positive there.
    sides: Vec<bool>,
}

/// A part of the boundary on one leaf: outside is to the right of its plane seen with the loop turning counterclockwise.
#[derive(Debug, Clone)]
pub(super) struct Facet {
    /// The place of the leaf in the list.
    pub(super) leaf: u8,
    /// Whether the leaf's positive side is inside.
    pub(super) plus: bool,
    /// What it is of.
    pub(super) named: Named,
    /// Loops of one connected part; the first need not be the outer one.
    pub(super) loops: Vec<Vec<Vertex>>,
}

/// What a piece of the boundary is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Named {
    /// The leaf's number: that of a twin where this makes the boundary.
    pub(super) leaf: u32,
    /// The face it is of.
    pub(super) face: u32,
}

/// A Boolean of the leaves in a tetrahedron, asked with the sides of them by their places in the list.
pub(super) struct Boolean<'a> {
    /// Whether inside is there.
    pub(super) inside: &'a dyn Fn(&[bool]) -> bool,
    /// What a leaf makes beside these sides of the others.
    pub(super) named: &'a dyn Fn(u8, &[bool]) -> Named,
}

/// What a piece of the boundary is of: pieces of one owner side by side are one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Owner {
    leaf: u8,
    plus: bool,
    named: Named,
}

/// Leaves that change sign in a tetrahedron.
pub(super) struct Crossed<'a> {
    /// Their numbers, ascending.
    pub(super) leaves: &'a [u32],
    /// Their values at the corners; corners 1, 2, 3 turn counterclockwise seen from corner 0's other side.
    pub(super) values: &'a [[f64; 4]],
}

/// The corners of each face, a bit each: all but the one across.
const FACES: [u8; 4] = [0b1110, 0b1101, 0b1011, 0b0111];

impl Crossed<'_> {
    fn plus(&self, leaf: u8, corner: usize) -> bool {
        self.values[leaf as usize][corner] >= 0.0
    }

    /// Whether a leaf is positive at a point.
    fn side(&self, v: &Vertex, leaf: u8) -> bool {
        let mut rows: Matrix = [[0.0; MOST]; MOST];
        let mut order = [0; MOST];
        let n = v.corners.count_ones() as usize;
        let all = [leaf, v.leaves[0], v.leaves[1], v.leaves[2]];
        for (k, l) in all.iter().take(n).enumerate() {
            order[k] = self.leaves[*l as usize];
            for (to, c) in (0..4).filter(|c| v.corners >> c & 1 == 1).enumerate() {
                rows[k][to] = self.values[*l as usize][c];
            }
        }
        positive(&rows, n, &order[..n])
    }

    /// The zero set of a leaf, counterclockwise seen from its negative side.
    fn zero_set(&self, leaf: u8) -> Polygon {
        /// Even permutations of the corners that bring those of the positive side to the front.
        const ORDERS: [[usize; 4]; 16] = [
            [0, 1, 2, 3],
            [0, 1, 2, 3],
            [1, 0, 3, 2],
            [0, 1, 2, 3],
            [2, 0, 1, 3],
            [0, 2, 3, 1],
            [1, 2, 0, 3],
            [3, 0, 2, 1],
            [3, 0, 2, 1],
            [0, 3, 1, 2],
            [1, 3, 2, 0],
            [2, 0, 1, 3],
            [2, 3, 0, 1],
            [1, 0, 3, 2],
            [0, 1, 2, 3],
            [0, 1, 2, 3],
        ];
        let mask = (0..4).fold(0, |m, c| m | usize::from(self.plus(leaf, c)) << c);
        let [a, b, c, d] = ORDERS[mask];
        let at = |x: usize, y: usize| Vertex { corners: 1 << x | 1 << y, leaves: [leaf, NONE, NONE] };
        let ring: Vec<Vertex> = match mask.count_ones() {
            1 => vec![at(a, b), at(a, c), at(a, d)],
            // `a` alone is negative.
            3 => vec![at(a, b), at(a, d), at(a, c)],
            _ => vec![at(a, c), at(a, d), at(b, d), at(b, c)],
        };
        let n = ring.len();
        let carrier = |k: usize| {
            let both = ring[k].corners | ring[(k + 1) % n].corners;
            FACES.iter().position(|f| *f == both).unwrap_or(0) as Carrier
        };
        let corners = (0..n).map(|k| (ring[k], carrier(k))).collect();
        Polygon { corners, sides: vec![false; self.leaves.len()] }
    }

    /// The pieces a leaf's zero set is cut into by the others.
    fn pieces(&self, leaf: u8) -> Vec<Polygon> {
        let mut all = vec![self.zero_set(leaf)];
        for other in (0..self.leaves.len() as u8).filter(|l| *l != leaf) {
            let mut next = Vec::with_capacity(all.len() + 1);
            for p in all {
                self.split(p, leaf, other, &mut next);
            }
            all = next;
        }
        all
    }

    fn split(&self, mut p: Polygon, leaf: u8, other: u8, out: &mut Vec<Polygon>) {
        let n = p.corners.len();
        let sides: Vec<bool> = p.corners.iter().map(|c| self.side(&c.0, other)).collect();
        let changes: Vec<usize> = (0..n).filter(|k| sides[*k] != sides[(k + 1) % n]).collect();
        let [first, second] = changes[..] else {
            p.sides[other as usize] = sides[0];
            out.push(p);
            return;
        };
        let crossing = |k: usize| {
            let carrier = p.corners[k].1;
            let (corners, mut leaves) = match carrier {
                face @ 0..4 => (FACES[face as usize], [leaf, other, NONE]),
                third => (0b1111, [leaf, other, third - 4]),
            };
            leaves.sort_unstable();
            Vertex { corners, leaves }
        };
        let (x, y) = (crossing(first), crossing(second));
        let own = other + 4;
        // From after the first crossing to the second, and the rest.
        let mut middle = vec![(x, p.corners[first].1)];
        middle.extend_from_slice(&p.corners[first + 1..=second]);
        middle.push((y, own));
        let mut rest = vec![(y, p.corners[second].1)];
        rest.extend_from_slice(&p.corners[second + 1..]);
        rest.extend_from_slice(&p.corners[..=first]);
        rest.push((x, own));
        for (corners, side) in [(middle, sides[second]), (rest, sides[first])] {
            let mut part = Polygon { corners, sides: p.sides.clone() };
            part.sides[other as usize] = side;
            out.push(part);
        }
    }

    /// The boundary of a Boolean.
    pub(super) fn boundary(&self, solid: &Boolean<'_>) -> Vec<Facet> {
        let Boolean { inside, named } = solid;
        if self.leaves.len() == 1 {
            // Nearly always: nothing to cut, nothing to join.
            let plus = inside(&[true]);
            if inside(&[false]) == plus {
                return Vec::new();
            }
            let mut ring: Vec<Vertex> = self.zero_set(0).corners.into_iter().map(|c| c.0).collect();
            if !plus {
                ring.reverse();
            }
            return vec![Facet { leaf: 0, plus, named: named(0, &[true]), loops: vec![ring] }];
        }
        let mut edges: Vec<Directed> = Vec::new();
        let mut count = 0u32;
        let mut owners: Vec<Owner> = Vec::new();
        for leaf in 0..self.leaves.len() as u8 {
            for p in self.pieces(leaf) {
                let mut sides = p.sides.clone();
                sides[leaf as usize] = true;
                let plus = inside(&sides);
                sides[leaf as usize] = false;
                if inside(&sides) == plus {
                    continue;
                }
                let n = p.corners.len();
                for k in 0..n {
                    let (from, carrier) = p.corners[k];
                    let to = p.corners[(k + 1) % n].0;
                    let (from, to) = if plus { (from, to) } else { (to, from) };
                    edges.push(Directed { from, to, carrier, piece: count, gone: false });
                }
                owners.push(Owner { leaf, plus, named: named(leaf, &sides) });
                count += 1;
            }
        }
        if count == 0 {
            return Vec::new();
        }
        // Pieces of one leaf side by side are one.
        let mut joined: Vec<u32> = (0..count).collect();
        let mut seams: Vec<Seam> = Vec::new();
        for i in 0..edges.len() {
            for k in i + 1..edges.len() {
                let (a, b) = (&edges[i], &edges[k]);
                if !a.gone
                    && !b.gone
                    && a.from == b.to
                    && a.to == b.from
                    && owners[a.piece as usize] == owners[b.piece as usize]
                {
                    let (p, q) = (root(&joined, a.piece), root(&joined, b.piece));
                    joined[p.max(q) as usize] = p.min(q);
                    seams.push(Seam { ends: [a.from, a.to], pieces: [a.piece, b.piece] });
                    (edges[i].gone, edges[k].gone) = (true, true);
                }
            }
        }
        let straight = self.straight(&edges, &owners);
        let mut facets: Vec<Facet> = Vec::new();
        let mut of_part: Vec<Option<usize>> = vec![None; count as usize];
        for start in 0..edges.len() {
            if edges[start].gone {
                continue;
            }
            let part = root(&joined, edges[start].piece);
            let mut ring = Vec::new();
            let mut at = start;
            loop {
                edges[at].gone = true;
                if !straight.contains(&edges[at].from) {
                    ring.push(edges[at].from);
                }
                let (to, piece) = (edges[at].to, edges[at].piece);
                let around = fan(&seams, to, piece);
                let follows = |e: &Directed| !e.gone && e.from == to && root(&joined, e.piece) == part;
                let next =
                    (0..edges.len()).filter(|k| follows(&edges[*k])).min_by_key(|k| !around.contains(&edges[*k].piece));
                match next {
                    Some(k) => at = k,
                    None => break,
                }
            }
            let Owner { leaf, plus, named } = owners[part as usize];
            let slot = *of_part[part as usize].get_or_insert_with(|| {
                facets.push(Facet { leaf, plus, named, loops: Vec::new() });
                facets.len() - 1
            });
            if ring.len() >= 3 {
                facets[slot].loops.push(ring);
            }
        }
        facets.retain(|f| !f.loops.is_empty());
        facets
    }

    /// Points that lines only pass: where leaves cross of which one makes no difference there.
    fn straight(&self, edges: &[Directed], owners: &[Owner]) -> Vec<Vertex> {
        let mut known: Vec<(Vertex, bool)> = Vec::new();
        for e in edges.iter().filter(|e| !e.gone) {
            let v = e.from;
            if v.leaves[1] == NONE || known.iter().any(|k| k.0 == v) {
                continue;
            }
            let at = |x: &&Directed| !x.gone && (x.from == v || x.to == v);
            let passes = if v.corners != 0b1111 {
                // On a face of the tetrahedron: both parts of the boundary's line there are of one face.
                let face = FACES.iter().position(|f| *f == v.corners).unwrap_or(0) as Carrier;
                let there = edges.iter().filter(at).filter(|x| x.carrier == face);
                let on: Vec<Owner> = there.map(|x| owners[x.piece as usize]).collect();
                on.len() == 2 && on[0].named == on[1].named
            } else {
                // Inside: no boundary turns there.
                edges.iter().filter(at).filter(|x| x.from == v).all(|x| {
                    edges.iter().filter(at).any(|y| {
                        y.to == v && y.carrier == x.carrier && owners[y.piece as usize] == owners[x.piece as usize]
                    })
                })
            };
            known.push((v, passes));
        }
        known.into_iter().filter(|k| k.1).map(|k| k.0).collect()
    }
}

/// An edge of a piece of the boundary, inside to its left seen from outside.
struct Directed {
    from: Vertex,
    to: Vertex,
    carrier: Carrier,
    piece: u32,
    gone: bool,
}

fn root(joined: &[u32], mut i: u32) -> u32 {
    while joined[i as usize] != i {
        i = joined[i as usize];
    }
    i
}

/// A common edge of two pieces that are joined.
struct Seam {
    ends: [Vertex; 2],
    pieces: [u32; 2],
}

/// The pieces that are joined to one around a point.
fn fan(seams: &[Seam], v: Vertex, piece: u32) -> Vec<u32> {
    let mut found = vec![piece];
    let mut i = 0;
    while i < found.len() {
        for s in seams.iter().filter(|s| s.ends.contains(&v)) {
            for (x, y) in [(0, 1), (1, 0)] {
                if s.pieces[x] == found[i] && !found.contains(&s.pieces[y]) {
                    found.push(s.pieces[y]);
                }
            }
        }
        i += 1;
    }
    found
}
