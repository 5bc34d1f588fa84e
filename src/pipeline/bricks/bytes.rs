//! Numbers as bytes, little-endian, and back.

use glam::DVec3;

use super::file::NodeId;

/// Bytes in order.
pub(super) struct ByteWriter(pub(super) Vec<u8>);

impl ByteWriter {
    pub(super) fn u32(&mut self, x: u32) {
        self.0.extend(x.to_le_bytes());
    }

    pub(super) fn u64(&mut self, x: u64) {
        self.0.extend(x.to_le_bytes());
    }

    pub(super) fn point(&mut self, p: [f64; 3]) {
        p.iter().for_each(|x| self.0.extend(x.to_le_bytes()));
    }

    /// A count and as many points.
    pub(super) fn points(&mut self, points: &[DVec3]) {
        self.u64(points.len() as u64);
        points.iter().for_each(|p| self.point(p.to_array()));
    }

    /// A count and as many triangles.
    pub(super) fn triangles(&mut self, triangles: &[[u32; 3]]) {
        self.u64(triangles.len() as u64);
        triangles.iter().flatten().for_each(|v| self.u32(*v));
    }
}

/// Bytes to be read; nothing is read beyond their end.
pub(super) struct ByteReader<'a>(pub(super) &'a [u8]);

impl ByteReader<'_> {
    pub(super) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    pub(super) fn point(&mut self) -> Option<[f64; 3]> {
        let mut p = [0.0; 3];
        for x in &mut p {
            *x = f64::from_le_bytes(self.take()?);
        }
        Some(p)
    }

    pub(super) fn id(&mut self) -> Option<NodeId> {
        Some([self.u64()?, self.u64()?, self.u64()?, self.u64()?])
    }

    /// A number of things of so many bytes each, all of which must be there.
    pub(super) fn count(&mut self, bytes: usize) -> Option<usize> {
        let n = usize::try_from(self.u64()?).ok()?;
        (n.checked_mul(bytes)? <= self.0.len()).then_some(n)
    }

    /// A count and as many points.
    pub(super) fn points(&mut self) -> Option<Vec<DVec3>> {
        (0..self.count(24)?).map(|_| self.point().map(DVec3::from_array)).collect()
    }

    /// A count and as many triangles of so many nodes.
    pub(super) fn triangles(&mut self, nodes: usize) -> Option<Vec<[u32; 3]>> {
        let n = self.count(12)?;
        let all: Option<Vec<[u32; 3]>> = (0..n).map(|_| Some([self.u32()?, self.u32()?, self.u32()?])).collect();
        all.filter(|t| t.iter().flatten().all(|v| (*v as usize) < nodes))
    }

    pub(super) fn numbers(&mut self, count: usize) -> Option<Vec<u32>> {
        (0..count).map(|_| self.u32()).collect()
    }
}
