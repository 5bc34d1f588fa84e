//! Pieces in memory and as files.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use rustc_hash::FxHashMap;
use sha2::{Digest, Sha256};

use super::super::history::{Proof, UnprovedPlace};
use super::plan::BrickPlan;
use crate::error::{Error, Place, Result};
use crate::implicit::{EndKey, Unproved};
use crate::io::write_atomic;

/// What files of pieces begin with.
const MAGIC: [u8; 8] = *b"RVBRICK1";

/// Surfaces a node may lie on.
pub(super) const MOST_ON: usize = 4;

/// Nothing there.
pub(super) const NONE: u32 = u32::MAX;

/// What a node is called in all pieces: three points of the grid and two leaves, or the piece and the number it was made with.
pub(super) type NodeId = EndKey;

/// What a node made in a round is called.
pub(super) fn made_in(round: usize, brick: u32, node: u32) -> NodeId {
    [u64::MAX, (round as u64) << 32 | u64::from(brick), u64::from(node), 0]
}

/// Whether a node is one of the grid's, not yet remeshed.
pub(super) fn is_raw(id: &NodeId) -> bool {
    id[0] != u64::MAX
}

/// Some of the surface, as one brick of one round left it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Piece {
    pub(super) nodes: Vec<DVec3>,
    /// The leaves each node lies on; [`NONE`] where there are fewer.
    pub(super) on: Vec<[u32; MOST_ON]>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The leaf of each triangle.
    pub(super) leaves: Vec<u32>,
    /// The face of each triangle.
    pub(super) faces: Vec<u32>,
    /// Whether a triangle is handed on to the next round.
    pub(super) handed: Vec<bool>,
    /// Nodes that other pieces know, ascending, and what they are called there.
    pub(super) known: Vec<(u32, NodeId)>,
    /// What was shown of the arrangement (first round).
    pub(super) proof: Proof,
}

/// Which piece of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Which {
    pub(super) round: usize,
    pub(super) brick: u32,
}

impl Which {
    /// The file of the piece in a plan's folder.
    pub(super) fn path(self, folder: &Path) -> PathBuf {
        folder.join(format!("round{}", self.round + 1)).join(format!("{:06}.piece", self.brick))
    }

    pub(super) fn name(self) -> String {
        format!("brick {} of round {}", self.brick, self.round + 1)
    }
}

/// Bytes in order.
struct Writer(Vec<u8>);

impl Writer {
    fn u32(&mut self, x: u32) {
        self.0.extend(x.to_le_bytes());
    }

    fn u64(&mut self, x: u64) {
        self.0.extend(x.to_le_bytes());
    }

    fn point(&mut self, p: [f64; 3]) {
        p.iter().for_each(|x| self.0.extend(x.to_le_bytes()));
    }
}

/// Bytes to be read; nothing is read beyond their end.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn point(&mut self) -> Option<[f64; 3]> {
        let mut p = [0.0; 3];
        for x in &mut p {
            *x = f64::from_le_bytes(self.take()?);
        }
        Some(p)
    }

    /// A number of things of so many bytes each, all of which must be there.
    fn count(&mut self, bytes: usize) -> Option<usize> {
        let n = usize::try_from(self.u64()?).ok()?;
        (n.checked_mul(bytes)? <= self.0.len()).then_some(n)
    }
}

const REASONS: [Unproved; 4] = [Unproved::Bent, Unproved::Touching, Unproved::Dependent, Unproved::Crowded];

impl Piece {
    /// The bytes of its file: a header, the lists, and the SHA-256 of all before.
    pub(super) fn bytes(&self, plan: &BrickPlan, which: Which) -> Vec<u8> {
        let mut w = Writer(MAGIC.to_vec());
        w.0.extend(plan.digest());
        w.u32(which.round as u32);
        w.u32(which.brick);
        w.u64(self.nodes.len() as u64);
        self.nodes.iter().for_each(|p| w.point(p.to_array()));
        self.on.iter().flatten().for_each(|l| w.u32(*l));
        w.u64(self.triangles.len() as u64);
        self.triangles.iter().flatten().for_each(|v| w.u32(*v));
        self.leaves.iter().chain(&self.faces).for_each(|x| w.u32(*x));
        w.0.extend(self.handed.iter().map(|h| u8::from(*h)));
        w.u64(self.known.len() as u64);
        for (v, id) in &self.known {
            w.u32(*v);
            id.iter().for_each(|x| w.u64(*x));
        }
        let Proof { cells, unproved, astray, places } = &self.proof;
        [*cells, *unproved, *astray, places.len()].iter().for_each(|n| w.u64(*n as u64));
        for p in places {
            w.point(p.at);
            w.u32(REASONS.iter().position(|r| *r == p.reason).unwrap_or(0) as u32);
        }
        let digest = Sha256::digest(&w.0);
        w.0.extend(digest);
        w.0
    }

    pub(super) fn parse(bytes: &[u8], plan: &BrickPlan, which: Which) -> std::result::Result<Self, &'static str> {
        let (body, digest) = bytes.split_last_chunk::<32>().ok_or("it is cut short")?;
        if Sha256::digest(body)[..] != digest[..] {
            return Err("it is damaged, or cut short");
        }
        let mut r = Reader(body);
        let header = (r.take::<8>(), r.take::<32>(), r.u32(), r.u32());
        if header.0 != Some(MAGIC) {
            return Err("it is no piece of a mesh");
        }
        if header.1 != Some(plan.digest()) {
            return Err("it belongs to another plan");
        }
        if (header.2, header.3) != (Some(which.round as u32), Some(which.brick)) {
            return Err("it is another brick's");
        }
        Self::lists(&mut r).ok_or("its lists do not fit together")
    }

    fn lists(r: &mut Reader<'_>) -> Option<Self> {
        let mut p = Piece::default();
        let n = r.count(24 + 4 * MOST_ON)?;
        for _ in 0..n {
            p.nodes.push(DVec3::from_array(r.point()?));
        }
        for _ in 0..n {
            let mut on = [NONE; MOST_ON];
            for l in &mut on {
                *l = r.u32()?;
            }
            p.on.push(on);
        }
        let t = r.count(21)?;
        for _ in 0..t {
            let corners = [r.u32()?, r.u32()?, r.u32()?];
            if corners.iter().any(|v| *v as usize >= n) {
                return None;
            }
            p.triangles.push(corners);
        }
        for list in [&mut p.leaves, &mut p.faces] {
            for _ in 0..t {
                list.push(r.u32()?);
            }
        }
        for _ in 0..t {
            p.handed.push(r.take::<1>()? == [1]);
        }
        for _ in 0..r.count(36)? {
            p.known.push((r.u32()?, [r.u64()?, r.u64()?, r.u64()?, r.u64()?]));
        }
        let [cells, unproved, astray] = [r.u64()? as usize, r.u64()? as usize, r.u64()? as usize];
        let mut places = Vec::new();
        for _ in 0..r.count(28)? {
            places.push(UnprovedPlace { at: r.point()?, reason: *REASONS.get(r.u32()? as usize)? });
        }
        p.proof = Proof { cells, unproved, astray, places };
        r.0.is_empty().then_some(p)
    }
}

/// Where the pieces of a plan are.
pub(super) enum Store<'a> {
    /// In files of the plan's folder.
    Folder(&'a Path),
    /// In memory.
    Memory(Mutex<FxHashMap<Which, Arc<Piece>>>),
}

impl Store<'_> {
    /// The folder, or what stands for it in messages.
    pub(super) fn name(&self) -> &Path {
        match self {
            Store::Folder(folder) => folder,
            Store::Memory(_) => Path::new("memory"),
        }
    }

    /// Keeps a piece: all of it or nothing.
    pub(super) fn save(&self, piece: Piece, plan: &BrickPlan, which: Which) -> Result<()> {
        let folder = match self {
            Store::Folder(folder) => folder,
            Store::Memory(pieces) => {
                pieces.lock().unwrap_or_else(PoisonError::into_inner).insert(which, Arc::new(piece));
                return Ok(());
            }
        };
        let path = which.path(folder);
        let to = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(to).map_err(|e| Error::io("create", to, e))?;
        let bytes = piece.bytes(plan, which);
        write_atomic(&path, |out| out.write_all(&bytes).map_err(|e| Error::io("write", &path, e)))
    }

    /// Whether a piece is there, be it good or not.
    pub(super) fn has(&self, which: Which) -> bool {
        match self {
            Store::Folder(folder) => which.path(folder).exists(),
            Store::Memory(pieces) => pieces.lock().unwrap_or_else(PoisonError::into_inner).contains_key(&which),
        }
    }

    /// A piece of a plan; none if it was not made.
    ///
    /// Errors: a file that cannot be read, is damaged, or is of another plan or brick.
    pub(super) fn load(&self, plan: &BrickPlan, which: Which) -> Result<Option<Arc<Piece>>> {
        let folder = match self {
            Store::Folder(folder) => folder,
            Store::Memory(pieces) => {
                return Ok(pieces.lock().unwrap_or_else(PoisonError::into_inner).get(&which).cloned());
            }
        };
        let path = which.path(folder);
        let bytes = match std::fs::read(&path) {
            Ok(b) => b,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Error::io("read", path, e)),
        };
        let bad = |what: &str| {
            Error::input(Place::Unknown, format!("{what}: delete it and make {} again", which.name())).in_file(&path)
        };
        Piece::parse(&bytes, plan, which).map(|p| Some(Arc::new(p))).map_err(bad)
    }
}
