//! A soup remeshed beside the two methods that \[GUO\] is compared with in its paper, built from the same parts: the same
//! model, sizes and nodes on borders, other nodes within the faces.

use super::compare::{Comparison, Row};
use super::discrete::{SoupOptions, discrete_options, length, mesh_soup, prepare};
use super::options::MeshOptions;
use super::report::Report;
use super::soup_patches::patchwork;
use super::soup_sizes::{self, feature_sizes, relaxed, sizing};
use crate::discrete::Discrete;
use crate::error::Result;
use crate::mesh::TriMesh;
use crate::quality::{Against, Expectation, check};
use crate::remesh::{Filling, RemeshTarget, remesh_patchwork};
use crate::render::View;
use crate::run::Run;
use crate::sizing::Wish;

/// Measures the input, two baselines and the mesh of [`mesh_soup`] alike.
///
/// The baselines: `frontal` leaves the nodes where the front puts them, as frontal Delaunay methods do; `poisson` throws them
/// at random, apart from each other. Both end with flips.
///
/// Errors: those of [`mesh_soup`].
pub fn compare_soup(input: &TriMesh, options: &MeshOptions, soup: &SoupOptions, run: &Run) -> Result<Comparison> {
    options.comparable()?;
    let prepared = prepare(input, soup.close, run)?;
    let size = length(options.size, &prepared.mesh);
    let solid = Discrete::new(&prepared.at(size), &discrete_options(soup, size), run)?;
    let (named, sizing) =
        (solid.named(), relaxed(sizing(size, solid.bounds().diagonal(), options), options, soup, &solid));
    let wish = Wish::new(size, solid.bounds().diagonal(), options.asked());
    let sizes = feature_sizes(&solid, &sizing, wish.chord(), &mut Report::of("triangles", size, None));
    let exact = soup_sizes::exact(sizing, options, &solid);
    let mut rows = Vec::new();
    let expected = Expectation { open: !named.defects().is_closed(), touching: false };
    let mut row = |method, stage: &str, mesh: TriMesh| -> Result<()> {
        let check = check(&mesh, expected, Some(Against::new(&solid)), run)?;
        let classes = super::compare::class_counts(&mesh, run)?;
        rows.push(Row { method, stage: stage.into(), check, classes, mesh });
        Ok(())
    };
    row("input", "as understood", named.clone())?;
    for (method, filling) in [("poisson", Filling::Random), ("frontal", Filling::Front)] {
        let nothing = vec![false; solid.mesh.triangle_capacity()];
        let mut work = patchwork(&solid, sizes.clone(), &nothing, 0.0);
        work.policy.filling = filling;
        let target = RemeshTarget { surface: &solid, names: &named };
        row(method, "flips", remesh_patchwork(work, target, &exact, run, None)?.mesh)?;
    }
    let quiet = MeshOptions { measure: false, size: Some(super::SizeRequest::Length(size)), ..options.clone() };
    row("triangles", "mended", mesh_soup(input, &quiet, &SoupOptions { nodes: None, ..soup.clone() }, run)?.mesh)?;
    let m = &solid.mesh;
    let towards = View::default().towards;
    let corners = m.nodes().filter(|&v| m.is_pinned(v)).map(|v| m.point(v));
    let focus = corners.max_by(|a, b| a.dot(towards).total_cmp(&b.dot(towards)));
    Ok(Comparison { size, focus, rows })
}
