//! What a page tells of a mesh: the report put into lines that lead to their places.

use super::heal::Healed;
use super::mesh::Meshed;
use crate::error::Result;
use crate::page::{PageKind, PageLine, PageText};
use crate::quality::{Check, Expectation, check};
use crate::run::Run;

/// What a page tells of a mesh that was made.
pub fn shown(made: &Meshed, title: &str) -> PageText {
    let r = &made.report;
    let mut text = PageText { title: title.into(), units: r.units.clone(), size: Some(r.size), ..PageText::default() };
    text.lines.extend(r.shortfalls.iter().map(PageLine::of_fault));
    text.lines.extend(r.warnings.iter().map(|w| PageLine::new(PageKind::Warning, w)));
    for proof in r.attempts.iter().filter(|a| a.kept).filter_map(|a| a.proof.as_ref()) {
        for p in &proof.places {
            // The reason as the report writes it.
            let reason = serde_json::to_value(p.reason).ok();
            let reason = reason.as_ref().and_then(|r| r.as_str()).unwrap_or_default();
            let what = format!("not proved by intervals, measured only: surfaces {reason}");
            text.lines.push(PageLine::at(PageKind::Unproved, what, vec![p.at]));
        }
        let more = proof.unproved.saturating_sub(proof.places.len());
        if more > 0 {
            text.lines.push(PageLine::new(PageKind::Unproved, format!("{more} more cells are not proved")));
        }
    }
    for step in &r.ladder {
        let what = format!("face {} did not come out the plain way: {}", step.face, step.why);
        text.lines.push(PageLine::new(PageKind::Note, what));
    }
    text.fact("method", r.method);
    text.fact("size asked for", format!("{:.6}", r.size));
    if let Some(check) = &r.check {
        measured(&mut text, check);
    }
    if let Some(d) = &r.distance {
        text.fact("largest distance to the surface", format!("{:.3e}", d.to_surface));
        text.fact("of edges to the mesh", format!("{:.3e}", d.from_surface));
    }
    text
}

/// What a page tells of a mesh that was healed, which is measured for that.
///
/// # Errors
/// Those of [`check`].
pub fn shown_healed(healed: &Healed, title: &str, run: &Run) -> Result<PageText> {
    let r = &healed.report;
    let mut text = PageText { title: title.into(), ..PageText::default() };
    text.lines.extend(r.shortfalls.iter().map(|s| PageLine::new(PageKind::Shortfall, s)));
    // The report has a line for each repair after one about the whole.
    for (repair, line) in r.repairs.iter().zip(r.to_string().lines().skip(1)) {
        text.lines.push(PageLine::at(PageKind::Repair, line.trim(), vec![repair.place]));
    }
    let check = check(&healed.mesh, Expectation { open: !r.closed, touching: false }, None, run)?;
    text.lines.extend(check.certificate.faults.iter().map(PageLine::of_fault));
    text.fact("area kept", format!("{:.2} %", 100.0 * r.kept));
    measured(&mut text, &check);
    Ok(text)
}

/// Adds the certificate and the figures.
fn measured(text: &mut PageText, check: &Check) {
    let c = &check.certificate;
    text.sound = Some(c.is_sound());
    let says = &mut text.certificate;
    says.push(format!("The mesh is {c}."));
    let yes = |b: bool, what: &str, what_not: &str| if b { what.to_string() } else { what_not.to_string() };
    says.push(yes(check.closed, "It is closed: every edge has two triangles.", "It is open."));
    says.push(yes(check.manifold, "It is a manifold.", "It is not a manifold."));
    says.push(yes(check.oriented, "Neighbors agree on which side is out.", "Neighbors disagree on which side is out."));
    says.push(match check.self_intersections {
        0 => "No triangle intersects another, by exact predicates.".to_string(),
        n => format!("{n} triangles intersect others, by exact predicates."),
    });
    if check.touching > 0 {
        says.push(format!("{} triangles touch other bodies, as was expected.", check.touching));
    }
    says.push(format!(
        "{} triangles have an angle below 30°, {} of them between the part's own edges.",
        c.below_30, c.excused
    ));
    if let Some(d) = &check.deviation {
        says.push(format!(
            "The largest distance measured to the surface is {:.3e}; distances are measured, not bounded.",
            d.max
        ));
    }
    let unexcused = c.below_30.saturating_sub(c.excused);
    if unexcused > 0 {
        let what = format!("{unexcused} triangles with an angle below 30° that no edge of the part asks for");
        text.lines.push(PageLine::at(PageKind::Note, what, c.unexcused_places.clone()));
    }
    let q = &check.quality;
    text.fact("nodes", check.nodes.to_string());
    text.fact("triangles", check.triangles.to_string());
    text.fact("components", check.components.to_string());
    text.fact("Euler characteristic", check.euler.to_string());
    if let Some(genus) = check.genus {
        text.fact("genus", genus.to_string());
    }
    text.fact("area", format!("{:.6}", check.area));
    if let Some(volume) = check.volume {
        text.fact("volume", format!("{volume:.6}"));
    }
    text.fact("smallest angle", format!("{:.2}°", q.min_angle));
    text.fact("5th percentile of smallest angles", format!("{:.2}°", q.p05_angle));
    text.fact("largest angle", format!("{:.2}°", q.max_angle));
    text.fact("mean 2r/R", format!("{:.4}", q.mean_radius_ratio));
    text.fact("smallest angle below 20°", format!("{:.3} %", 100.0 * q.below_20));
    if let Some(d) = &check.deviation {
        text.fact("largest distance", format!("{:.3e}", d.max));
        text.fact("rms distance", format!("{:.3e}", d.rms));
    }
    if let Some(f) = check.features.as_ref().filter(|f| !f.known) {
        text.fact("sharp edges", format!("the true ones are not known, mesh {:.4}", f.length_mesh));
    } else if let Some(f) = &check.features {
        text.fact("sharp edges, recall and precision", format!("{:.3}, {:.3}", f.recall, f.precision));
        text.fact("corners found", format!("{} of {}", f.corners_found, f.corners_true));
    }
}
