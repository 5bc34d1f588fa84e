//! Who lies across which edge.

use super::{EditMesh, NONE, next};
use crate::error::{Error, Place, Result};

impl EditMesh {
    /// Finds the opposite of every half-edge among those that start at its target.
    pub(super) fn match_opposites(&mut self) -> Result<()> {
        /// Around nodes with more half-edges than this the one asked for is looked for by halving.
        const MANY: usize = 16;
        let mut starts = vec![0u32; self.points.len() + 2];
        self.corners.iter().for_each(|&v| starts[v as usize + 2] += 1);
        for v in 0..self.points.len() {
            starts[v + 2] += starts[v + 1];
        }
        // Targets and half-edges, by origin.
        let mut at = vec![(NONE, NONE); self.corners.len()];
        for (h, &v) in self.corners.iter().enumerate() {
            let fill = &mut starts[v as usize + 1];
            at[*fill as usize] = (self.corners[next(h as u32) as usize], h as u32);
            *fill += 1;
        }
        let range = |v: u32| starts[v as usize] as usize..starts[v as usize + 1] as usize;
        for v in (0..self.points.len() as u32).filter(|&v| range(v).len() > MANY) {
            at[range(v)].sort_unstable();
        }
        // The first half-edge from one node to another, and whether there are more.
        let to = |v: u32, target: u32| {
            let list = &at[range(v)];
            let from = if list.len() > MANY { list.partition_point(|x| x.0 < target) } else { 0 };
            let near = list[from..].iter().take_while(|x| list.len() <= MANY || x.0 == target);
            let mut equal = near.filter(|x| x.0 == target).map(|x| x.1);
            (equal.next(), equal.next())
        };
        for h in 0..self.corners.len() as u32 {
            let (a, b) = (self.corners[h as usize], self.corners[next(h) as usize]);
            if to(a, b).1 == Some(h) {
                let message = "an edge is used twice in one direction: not an oriented manifold";
                return Err(Error::input(Place::Item(format!("triangle {}", h / 3)), message));
            }
            if let (Some(o), _) = to(b, a) {
                self.opposite[h as usize] = o;
            }
            let v = a as usize;
            if self.out[v] == NONE || self.opposite[h as usize] == NONE {
                self.out[v] = h;
            }
        }
        Ok(())
    }
}
