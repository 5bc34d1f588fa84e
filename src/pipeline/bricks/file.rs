//! Pieces in memory and as files.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use rustc_hash::FxHashMap;
use sha2::{Digest, Sha256};

use super::super::history::{Proof, UnprovedPlace};
use super::bytes::{ByteReader, ByteWriter};
use super::plan::BrickPlan;
use crate::error::{Error, Place};
use crate::implicit::{EndKey, Unproved};
use crate::io::write_atomic;
pub(super) use crate::numeric::NONE;

type Result<T, E = Error> = std::result::Result<T, E>;

/// What files of pieces begin with.
const MAGIC: [u8; 8] = *b"RVBRICK2";

/// Surfaces a node may lie on.
pub(super) const MOST_ON: usize = 4;

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
pub(super) struct BrickPiece {
    /// Nodes of the triangles that stay.
    pub(super) nodes: Vec<DVec3>,
    /// The triangles that stay.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The face of each triangle.
    pub(super) faces: Vec<u32>,
    /// Nodes that other pieces know, ascending, and what they are called there.
    pub(super) known: Vec<(u32, NodeId)>,
    /// What is handed on, by the bricks of the next round, ascending.
    pub(super) handed: Vec<Handed>,
    /// What was shown of the arrangement (first round).
    pub(super) proof: Proof,
}

/// Triangles for one brick of the next round.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Handed {
    /// The brick.
    pub(super) to: u32,
    pub(super) nodes: Vec<DVec3>,
    /// The leaves each node lies on; [`NONE`] where there are fewer.
    pub(super) on: Vec<[u32; MOST_ON]>,
    /// What each node is called.
    pub(super) ids: Vec<NodeId>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The leaf of each triangle.
    pub(super) leaves: Vec<u32>,
    /// The face of each triangle.
    pub(super) faces: Vec<u32>,
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

/// Where a section of a piece's file is, and the SHA-256 of its bytes.
struct FileSection {
    /// The brick it is for; [`NONE`] for what stays.
    to: u32,
    offset: u64,
    length: u64,
    digest: [u8; 32],
}

/// Bytes of a section in the index.
const SECTION: usize = 4 + 8 + 8 + 32;

/// Bytes before the index: what files begin with, the plan's digest, round, brick, how many sections there are.
const HEAD: usize = 8 + 32 + 4 + 4 + 8;

/// Bytes of a file that are read at once to have its index: with room for the 27 bricks a piece may hand something to.
const FIRST: u64 = 2048;

/// Why a file is no good.
pub(super) type Bad = &'static str;

/// It ends before what its head announces.
const CUT: Bad = "it is cut short";
/// Digests or lengths do not fit what is there.
const DAMAGED: Bad = "it is damaged, or cut short";
/// What is read is whole and makes no sense.
const UNFIT: Bad = "its lists do not fit together";

/// Reasons by the numbers they have in a file; no number may ever change.
const REASONS: [Unproved; 4] = [Unproved::Bent, Unproved::Touching, Unproved::Dependent, Unproved::Crowded];

/// How many bytes the head and the index of a file take, with their digest, by its first bytes.
fn index_length(head: &[u8]) -> Result<usize, Bad> {
    let count = head.get(HEAD - 8..HEAD).and_then(|b| b.try_into().ok()).map(u64::from_le_bytes).ok_or(CUT)?;
    let length = usize::try_from(count).ok().and_then(|n| n.checked_mul(SECTION));
    length.and_then(|n| n.checked_add(HEAD + 32)).ok_or(DAMAGED)
}

/// The sections of a file that begins with these bytes, of a plan by its digest. Each begins where the one before ends.
fn index(head: &[u8], plan: &[u8; 32], which: Which) -> Result<Vec<FileSection>, Bad> {
    let head = head.get(..index_length(head)?).ok_or(DAMAGED)?;
    let (body, digest) = head.split_last_chunk::<32>().ok_or(CUT)?;
    if Sha256::digest(body)[..] != digest[..] {
        return Err(DAMAGED);
    }
    let mut r = ByteReader(body);
    let header = (r.take::<8>(), r.take::<32>(), r.u32(), r.u32(), r.u64());
    if header.0 != Some(MAGIC) {
        return Err("it is no piece of a mesh");
    }
    if header.1 != Some(*plan) {
        return Err("it belongs to another plan");
    }
    if (header.2, header.3) != (Some(which.round as u32), Some(which.brick)) {
        return Err("it is another brick's");
    }
    let mut sections: Vec<FileSection> = Vec::new();
    let mut end = head.len() as u64;
    while !r.0.is_empty() {
        let mut section = || Some(FileSection { to: r.u32()?, offset: r.u64()?, length: r.u64()?, digest: r.take()? });
        let section = section().filter(|s| s.offset == end).ok_or(UNFIT)?;
        end = end.checked_add(section.length).ok_or(UNFIT)?;
        sections.push(section);
    }
    Ok(sections)
}

/// The head and the index of a piece's file.
struct Opened<'a> {
    file: File,
    path: &'a Path,
    which: Which,
    /// Bytes of the file: nothing is asked for beyond its end, whatever it claims.
    size: u64,
    sections: Vec<FileSection>,
}

impl<'a> Opened<'a> {
    /// Opens a file of a plan, which is known by its digest; none if there is no such file.
    ///
    /// Errors: a file that cannot be read, is longer or shorter than its index says, has a damaged index, or is of another plan or brick.
    fn new(path: &'a Path, plan: &[u8; 32], which: Which) -> Result<Option<Self>> {
        let file = match File::open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Error::io("read", path, e)),
        };
        let size = file.metadata().map_err(|e| Error::io("read", path, e))?.len();
        let mut opened = Self { file, path, which, size, sections: Vec::new() };
        // Most indices are in the first bytes, so that one reading does.
        let mut head = opened.read(0, size.min(FIRST))?;
        let length = index_length(&head).map_err(|what| bad(what, which, path))? as u64;
        if length > head.len() as u64 {
            head = opened.read(0, length)?;
        }
        opened.sections = index(&head, plan, which).map_err(|what| bad(what, which, path))?;
        let end = opened.sections.last().map_or(length, |s| s.offset + s.length);
        if end != size {
            return Err(bad(DAMAGED, which, path));
        }
        Ok(Some(opened))
    }

    fn read(&mut self, from: u64, length: u64) -> Result<Vec<u8>> {
        if from.checked_add(length).is_none_or(|end| end > self.size) {
            return Err(bad(DAMAGED, self.which, self.path));
        }
        let mut bytes = vec![0; length as usize];
        let read = self.file.seek(SeekFrom::Start(from)).and_then(|_| self.file.read_exact(&mut bytes));
        read.map(|()| bytes).map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => bad(CUT, self.which, self.path),
            _ => Error::io("read", self.path, e),
        })
    }
}

impl FileSection {
    /// The bytes of a section where they are as they were written.
    fn checked<'b>(&self, bytes: &'b [u8]) -> Result<&'b [u8], Bad> {
        if Sha256::digest(bytes)[..] == self.digest[..] { Ok(bytes) } else { Err(DAMAGED) }
    }

    /// Its bytes in those of the file.
    fn of<'b>(&self, file: &'b [u8]) -> Result<&'b [u8], Bad> {
        let end = self.offset.checked_add(self.length).ok_or(UNFIT)?;
        let place = usize::try_from(self.offset).ok().zip(usize::try_from(end).ok()).ok_or(UNFIT)?;
        self.checked(file.get(place.0..place.1).ok_or(DAMAGED)?)
    }
}

impl BrickPiece {
    /// The bytes of its file: an index with the digest of each section, the section of what stays, and one for each brick that
    /// something is handed on to.
    fn bytes(&self, plan: &[u8; 32], which: Which) -> Vec<u8> {
        let sections: Vec<(u32, Vec<u8>)> =
            std::iter::once((NONE, self.body())).chain(self.handed.iter().map(|h| (h.to, h.body()))).collect();
        let mut w = ByteWriter(MAGIC.to_vec());
        w.0.extend(plan);
        w.u32(which.round as u32);
        w.u32(which.brick);
        w.u64(sections.len() as u64);
        let mut offset = (HEAD + 32 + SECTION * sections.len()) as u64;
        for (to, body) in &sections {
            w.u32(*to);
            w.u64(offset);
            w.u64(body.len() as u64);
            w.0.extend(Sha256::digest(body));
            offset += body.len() as u64;
        }
        let digest = Sha256::digest(&w.0);
        w.0.extend(digest);
        sections.iter().for_each(|(_, body)| w.0.extend(body));
        w.0
    }

    fn body(&self) -> Vec<u8> {
        let mut w = ByteWriter(Vec::new());
        w.points(&self.nodes);
        w.triangles(&self.triangles);
        self.faces.iter().for_each(|x| w.u32(*x));
        w.u64(self.known.len() as u64);
        for (v, id) in &self.known {
            w.u32(*v);
            id.iter().for_each(|x| w.u64(*x));
        }
        let Proof { cells, unproved, astray, places, .. } = &self.proof;
        [*cells, *unproved, *astray, places.len()].iter().for_each(|n| w.u64(*n as u64));
        for p in places {
            w.point(p.at);
            w.u32(REASONS.iter().position(|r| *r == p.reason).unwrap_or(0) as u32);
        }
        w.0
    }

    fn parse(bytes: &[u8], plan: &[u8; 32], which: Which) -> Result<Self, Bad> {
        let mut piece = None;
        let mut handed = Vec::new();
        let mut end = index_length(bytes)? as u64;
        for section in index(bytes, plan, which)? {
            let body = section.of(bytes)?;
            end = section.offset + section.length;
            if section.to == NONE {
                piece = Some(Self::parse_body(body).ok_or(UNFIT)?);
            } else {
                handed.push(Handed::parse(body, section.to).ok_or(UNFIT)?);
            }
        }
        if end != bytes.len() as u64 {
            return Err(UNFIT);
        }
        Ok(Self { handed, ..piece.ok_or(UNFIT)? })
    }

    fn parse_body(body: &[u8]) -> Option<Self> {
        let mut r = ByteReader(body);
        let mut p = BrickPiece { nodes: r.points()?, ..BrickPiece::default() };
        p.triangles = r.triangles(p.nodes.len())?;
        p.faces = r.numbers(p.triangles.len())?;
        for _ in 0..r.count(36)? {
            p.known.push((r.u32()?, r.id()?));
        }
        let [cells, unproved, astray] = [r.u64()? as usize, r.u64()? as usize, r.u64()? as usize];
        let mut places = Vec::new();
        for _ in 0..r.count(28)? {
            places.push(UnprovedPlace { at: r.point()?, reason: *REASONS.get(r.u32()? as usize)? });
        }
        p.proof = Proof { cells, unproved, astray, places, bricks: Vec::new() };
        r.0.is_empty().then_some(p)
    }
}

impl Handed {
    fn body(&self) -> Vec<u8> {
        let mut w = ByteWriter(Vec::new());
        w.points(&self.nodes);
        self.on.iter().flatten().for_each(|l| w.u32(*l));
        self.ids.iter().flatten().for_each(|x| w.u64(*x));
        w.triangles(&self.triangles);
        self.leaves.iter().chain(&self.faces).for_each(|x| w.u32(*x));
        w.0
    }

    fn parse(body: &[u8], to: u32) -> Option<Self> {
        let mut r = ByteReader(body);
        let mut h = Handed { to, nodes: r.points()?, ..Handed::default() };
        for _ in 0..h.nodes.len() {
            h.on.push([r.u32()?, r.u32()?, r.u32()?, r.u32()?]);
        }
        for _ in 0..h.nodes.len() {
            h.ids.push(r.id()?);
        }
        h.triangles = r.triangles(h.nodes.len())?;
        h.leaves = r.numbers(h.triangles.len())?;
        h.faces = r.numbers(h.triangles.len())?;
        r.0.is_empty().then_some(h)
    }
}

/// The pieces of a plan.
pub(super) struct Store<'a> {
    /// The digest of the plan. Taking it costs as much as the plan is long, so it is not for every piece.
    plan: [u8; 32],
    pieces: PieceStore<'a>,
}

/// Where pieces are.
enum PieceStore<'a> {
    /// In files of the plan's folder.
    Folder(&'a Path),
    /// In memory.
    Memory(Mutex<FxHashMap<Which, Arc<BrickPiece>>>),
}

impl<'a> Store<'a> {
    /// Pieces in files of the plan's folder.
    pub(super) fn folder(plan: &BrickPlan, folder: &'a Path) -> Self {
        Self { plan: plan.digest(), pieces: PieceStore::Folder(folder) }
    }

    /// Pieces in memory, none yet.
    pub(super) fn memory(plan: &BrickPlan) -> Self {
        Self { plan: plan.digest(), pieces: PieceStore::Memory(Mutex::default()) }
    }

    /// The folder of the pieces, unless they are in memory.
    pub(super) fn place(&self) -> Option<&'a Path> {
        match self.pieces {
            PieceStore::Folder(folder) => Some(folder),
            PieceStore::Memory(_) => None,
        }
    }

    /// The folder, or what stands for it in messages.
    pub(super) fn name(&self) -> &Path {
        self.place().unwrap_or(Path::new("memory"))
    }

    /// The file of a piece that the store would hold.
    pub(super) fn bytes(&self, piece: &BrickPiece, which: Which) -> Vec<u8> {
        piece.bytes(&self.plan, which)
    }

    /// A piece of the plan by the bytes of its file.
    pub(super) fn parse(&self, bytes: &[u8], which: Which) -> Result<BrickPiece, Bad> {
        BrickPiece::parse(bytes, &self.plan, which)
    }

    /// Keeps a piece: all of it or nothing.
    pub(super) fn save(&self, piece: BrickPiece, which: Which) -> Result<()> {
        let folder = match &self.pieces {
            PieceStore::Folder(folder) => folder,
            PieceStore::Memory(pieces) => {
                pieces.lock().unwrap_or_else(PoisonError::into_inner).insert(which, Arc::new(piece));
                return Ok(());
            }
        };
        let path = which.path(folder);
        let to = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(to).map_err(|e| Error::io("create", to, e))?;
        let bytes = self.bytes(&piece, which);
        write_atomic(&path, |out| out.write_all(&bytes).map_err(|e| Error::io("write", &path, e)))
    }

    /// Whether a piece is there. Of a file the index is looked at, not what the sections hold.
    ///
    /// Errors: a file that cannot be read, is longer or shorter than its index says, has a damaged index, or is of another plan or brick.
    pub(super) fn has(&self, which: Which) -> Result<bool> {
        match &self.pieces {
            PieceStore::Folder(folder) => Opened::new(&which.path(folder), &self.plan, which).map(|o| o.is_some()),
            PieceStore::Memory(pieces) => {
                Ok(pieces.lock().unwrap_or_else(PoisonError::into_inner).contains_key(&which))
            }
        }
    }

    /// A piece of a plan; none if it was not made.
    ///
    /// Errors: a file that cannot be read, is damaged, or is of another plan or brick.
    pub(super) fn load(&self, which: Which) -> Result<Option<Arc<BrickPiece>>> {
        let folder = match &self.pieces {
            PieceStore::Folder(folder) => folder,
            PieceStore::Memory(pieces) => {
                return Ok(pieces.lock().unwrap_or_else(PoisonError::into_inner).get(&which).cloned());
            }
        };
        let path = which.path(folder);
        let bytes = match std::fs::read(&path) {
            Ok(b) => b,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Error::io("read", path, e)),
        };
        self.parse(&bytes, which).map(|p| Some(Arc::new(p))).map_err(|what| bad(what, which, &path))
    }

    /// What a piece hands on to a brick of the next round, which may be nothing. Of a file no more is read than that.
    ///
    /// Errors: a piece that was not made; a file that cannot be read, is damaged, or is of another plan or brick.
    pub(super) fn handed(&self, from: Which, to: u32) -> Result<Handed> {
        let missing = || {
            let what = format!("{} is missing: make it first", from.name());
            Error::input(Place::Unknown, what).in_file(self.name())
        };
        let Some(folder) = self.place() else {
            let piece = self.load(from)?.ok_or_else(missing)?;
            return Ok(piece.handed.iter().find(|h| h.to == to).cloned().unwrap_or_default());
        };
        let path = from.path(folder);
        let mut opened = Opened::new(&path, &self.plan, from)?.ok_or_else(missing)?;
        let Some(k) = opened.sections.iter().position(|s| s.to == to) else {
            return Ok(Handed::default());
        };
        let body = opened.read(opened.sections[k].offset, opened.sections[k].length)?;
        let bad = |what: Bad| bad(what, from, &path);
        Handed::parse(opened.sections[k].checked(&body).map_err(bad)?, to).ok_or_else(|| bad(UNFIT))
    }
}

fn bad(what: Bad, which: Which, path: &Path) -> Error {
    Error::input(Place::Unknown, format!("{what}: delete it and make {} again", which.name())).in_file(path)
}
