//! What changed since it was last looked at: who goes over a mesh again and again need not look where nothing did.

use super::EditMesh;

/// Who keeps track of changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangeReader {
    /// Flips for better shapes.
    Shapes = 1,
    /// Flips for even numbers of triangles around the nodes, too.
    Valences = 2,
    /// Relaxation.
    Places = 4,
    /// Shapes of triangles as the surface has them.
    Facing = 8,
    /// Flips for better shapes of those who look at a part of the mesh, beyond which [`Shapes`](Self::Shapes) sees nothing.
    Focus = 16,
    /// Mending of poor triangles, one by one.
    Mending = 32,
}

impl EditMesh {
    /// Notes that the surroundings of some nodes changed.
    pub(super) fn note(&mut self, nodes: impl IntoIterator<Item = u32>) {
        nodes.into_iter().for_each(|v| self.changed[v as usize] = u8::MAX);
    }

    /// Whether the node moved, or its triangles are others, since the reader [has seen](Self::set_seen) it.
    pub fn is_changed(&self, v: u32, reader: ChangeReader) -> bool {
        self.changed[v as usize] & reader as u8 != 0
    }

    /// The reader has seen the node as it is.
    pub fn set_seen(&mut self, v: u32, reader: ChangeReader) {
        self.changed[v as usize] &= !(reader as u8);
    }

    /// The reader has seen no node.
    pub fn set_none_seen(&mut self, reader: ChangeReader) {
        self.changed.iter_mut().for_each(|c| *c |= reader as u8);
    }

    /// The reader has seen all nodes.
    pub fn set_all_seen(&mut self, reader: ChangeReader) {
        self.changed.iter_mut().for_each(|c| *c &= !(reader as u8));
    }

    /// Nobody has seen any node.
    pub fn set_all_changed(&mut self) {
        self.changed.fill(u8::MAX);
    }

    /// What nobody, or not everybody, has seen of the node.
    pub fn changes(&self, v: u32) -> u8 {
        self.changed[v as usize]
    }

    /// Takes over [`changes`](Self::changes) from a node of another mesh that has the same surroundings.
    pub fn set_changes(&mut self, v: u32, changes: u8) {
        self.changed[v as usize] = changes;
    }
}
