//! Faces of the finished mesh that are meshed anew at sizes of their own.

use clap::Args;
use rvachev::pipeline::{Meshed, SizeRequest};
use rvachev::{Result, Run};

/// Which faces, and how.
#[derive(Debug, Default, Args)]
pub struct Anew {
    /// Once the mesh is made, mesh this face anew with edges of this size, a length or a share of the mesh's diagonal; all other
    /// faces stay as they are, and so does its border; may be given more than once
    #[arg(long, value_name = "NAME=SIZE", value_parser = wish)]
    pub remesh: Vec<FaceWish>,
}

/// A face and the size of its edges.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceWish {
    name: String,
    size: SizeRequest,
}

fn wish(s: &str) -> Result<FaceWish, String> {
    // Names may hold the sign, sizes do not.
    let (name, size) = s.rsplit_once('=').ok_or_else(|| format!("{s:?} is not NAME=SIZE"))?;
    let size = size.parse().map_err(|e: rvachev::Error| e.to_string())?;
    Ok(FaceWish { name: name.to_string(), size })
}

impl Anew {
    /// Meshes the faces anew, in the order they were given. Errors: see [`Meshed::remesh_face`].
    pub(super) fn apply(&self, made: &mut Meshed, run: &Run) -> Result<()> {
        let diagonal = made.mesh.bounds().diagonal();
        self.remesh.iter().try_for_each(|w| made.remesh_face(&w.name, w.size.length(diagonal), run))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_sign_parts_name_and_size() {
        let of = |name: &str, size| Ok(FaceWish { name: name.into(), size });
        assert_eq!(wish("top=0.5"), of("top", SizeRequest::Length(0.5)));
        assert_eq!(wish("a=b.side 2=1%"), of("a=b.side 2", SizeRequest::Share(0.01)));
        for bad in ["top", "top=", "top=0", "top=-1", "top=x"] {
            assert!(wish(bad).is_err(), "{bad}");
        }
    }
}
