//! The report of a mesh as tables: faces, groups, attempts, stages, and how faces came out.

use serde::Serialize;

use super::mesh::Meshed;
use crate::page::PageTable;

/// The tables that [`page::tables`](crate::page::tables) shows below what [`shown`](fn@super::shown) tells. Those without rows are not
/// there.
pub fn report_tables(made: &Meshed) -> Vec<PageTable> {
    let r = &made.report;
    let mut faces = PageTable::new("Faces", &["face", "#triangles", "#area"]);
    let mut groups = PageTable::new("Groups", &["group", "#triangles", "#area"]);
    // Faces are listed first, in the order of the mesh.
    for (i, g) in r.check.iter().flat_map(|c| &c.groups).enumerate() {
        let list = if i < made.mesh.faces.len() { &mut faces } else { &mut groups };
        list.row([g.name.clone(), g.triangles.to_string(), format!("{:.6}", g.area)]);
    }
    let yes = |b: bool| if b { "yes" } else { "no" }.to_string();
    let seconds = |s: Option<f64>| s.map_or_else(String::new, |s| format!("{s:.2}"));
    let columns = ["what", "#size", "#triangles", "#faults", "#not proved", "#seconds", "kept", "why"];
    let mut attempts = PageTable::new("Attempts, in the order of time", &columns);
    for a in &r.attempts {
        let unproved = a.proof.as_ref().map_or_else(String::new, |p| format!("{} of {} cells", p.unproved, p.cells));
        attempts.row([
            word(&a.rung),
            format!("{:.4e}", a.size),
            a.triangles.to_string(),
            a.faults.to_string(),
            unproved,
            seconds(a.seconds),
            yes(a.kept),
            a.why.clone(),
        ]);
    }
    let mut stages = PageTable::new("Stages of the mesh that was kept", &["stage", "#triangles", "#seconds"]);
    for s in &r.stages {
        stages.row([s.name.into(), s.triangles.to_string(), seconds(s.seconds)]);
    }
    let mut ladder = PageTable::new(
        "Faces that did not come out the plain way",
        &["face", "#record", "how it came out", "why the plain way did not do"],
    );
    for f in &r.ladder {
        ladder.row([f.face.clone(), f.source.to_string(), word(&f.rung), f.why.clone()]);
    }
    let mut all = vec![faces, groups, attempts, stages, ladder];
    all.retain(|t| !t.rows.is_empty());
    all
}

/// A value as the report as JSON writes it, with blanks.
fn word(value: &impl Serialize) -> String {
    let value = serde_json::to_value(value).ok();
    value.as_ref().and_then(|v| v.as_str()).unwrap_or_default().replace('_', " ")
}
