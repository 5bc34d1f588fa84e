//! Boundary representations as STEP files (AP214): what any program with a B-rep kernel opens.

use std::fmt::Write;

use glam::{DVec3, DVec4};

use crate::error::{Error, Place, Result};
use crate::parametric::basis::Knots;
use crate::parametric::brep::{Brep, Face};
use crate::parametric::curve::Curve;
use crate::parametric::frame::Frame;
use crate::parametric::nurbs::{NurbsCurve, NurbsSurface};
use crate::parametric::surface::Surface;
use crate::spatial::Aabb;

/// What readers may take for one point, as a share of the model's size: edges lie on their faces to about this.
const ACCURACY: f64 = 1e-8;

/// A model as the text of a STEP file. Coordinates are written as they are, in `unit`: one of m, dm, cm, mm, um, in, ft.
///
/// Bodies become solids (with voids where they have several shells) or shells, with their names, faces with names and
/// colors. There are no parameter curves, as readers find parameters again, and no date: the same model gives the same
/// bytes.
///
/// *Errors*: [`Error::Input`] for an unknown unit, and for a surface that STEP has no exact form for, with its face's name.
pub fn write_step(brep: &Brep, name: &str, unit: &str) -> Result<String> {
    let mut w = Writer { text: String::new(), next: 1 };
    let points = brep.edges.iter().flat_map(|e| e.curve.pieces(e.range).into_iter().map(|t| e.curve.at(t)));
    let size = Aabb::around(brep.vertices.iter().copied().chain(points)).diagonal();
    let context = w.context(unit, size)?;
    let vertices: Vec<u64> = brep
        .vertices
        .iter()
        .map(|p| {
            let p = w.point(*p);
            w.put(&format!("VERTEX_POINT('',#{p})"))
        })
        .collect();
    let edges: Vec<u64> = brep
        .edges
        .iter()
        .map(|e| {
            let curve = w.curve(&e.curve);
            let [a, b] = e.ends.map(|v| vertices[v as usize]);
            w.put(&format!("EDGE_CURVE('',#{a},#{b},#{curve},.T.)"))
        })
        .collect();
    let mut faces = Vec::with_capacity(brep.faces.len());
    for f in &brep.faces {
        faces.push(w.face(f, &edges).map_err(|e| Error::input(Place::Unknown, format!("face {}: {e}", f.name)))?);
    }
    let mut items = Vec::new();
    for body in &brep.bodies {
        let shells = shells(brep, &body.faces);
        let kind = if body.solid { "CLOSED_SHELL" } else { "OPEN_SHELL" };
        let list: Vec<u64> = shells
            .iter()
            .map(|s| w.put(&format!("{kind}('',{})", refs(s.iter().map(|f| faces[*f as usize])))))
            .collect();
        let Some((first, rest)) = list.split_first() else { continue };
        let name = text(&body.name);
        items.push(match (body.solid, rest) {
            (false, _) => w.put(&format!("SHELL_BASED_SURFACE_MODEL('{name}',{})", refs(list.iter().copied()))),
            (true, []) => w.put(&format!("MANIFOLD_SOLID_BREP('{name}',#{first})")),
            (true, voids) => {
                let voids: Vec<u64> =
                    voids.iter().map(|s| w.put(&format!("ORIENTED_CLOSED_SHELL('',*,#{s},.T.)"))).collect();
                w.put(&format!("BREP_WITH_VOIDS('{name}',#{first},{})", refs(voids.into_iter())))
            }
        });
    }
    let place = w.placement(&Frame::WORLD);
    let kind = if brep.bodies.iter().all(|b| b.solid) {
        "ADVANCED_BREP_SHAPE_REPRESENTATION"
    } else if brep.bodies.iter().all(|b| !b.solid) {
        "MANIFOLD_SURFACE_SHAPE_REPRESENTATION"
    } else {
        "SHAPE_REPRESENTATION"
    };
    let all = refs([place].into_iter().chain(items));
    let shape = w.put(&format!("{kind}('',{all},#{context})"));
    w.product(name, shape);
    w.colors(brep, &faces, context);
    let head = format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('boundary representation'),'2;1');\n\
         FILE_NAME('{}','1970-01-01T00:00:00',(''),(''),'rvachev {}','rvachev','');\n\
         FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));\nENDSEC;\nDATA;\n",
        text(name),
        env!("CARGO_PKG_VERSION"),
    );
    Ok(format!("{head}{}ENDSEC;\nEND-ISO-10303-21;\n", w.text))
}

/// The connected parts of a body's faces; the one with the largest box, which holds the others, first.
fn shells(brep: &Brep, faces: &[u32]) -> Vec<Vec<u32>> {
    let mut of_edge: Vec<Vec<usize>> = vec![Vec::new(); brep.edges.len()];
    for (i, f) in faces.iter().enumerate() {
        for c in brep.faces[*f as usize].loops.iter().flatten() {
            of_edge[c.edge as usize].push(i);
        }
    }
    let mut part = vec![usize::MAX; faces.len()];
    let mut out: Vec<(f64, Vec<u32>)> = Vec::new();
    for start in 0..faces.len() {
        if part[start] != usize::MAX {
            continue;
        }
        part[start] = out.len();
        let (mut stack, mut members, mut bounds) = (vec![start], Vec::new(), Aabb::EMPTY);
        while let Some(i) = stack.pop() {
            members.push(i);
            for c in brep.faces[faces[i] as usize].loops.iter().flatten() {
                let e = &brep.edges[c.edge as usize];
                bounds = bounds.union(&Aabb::around(e.curve.pieces(e.range).into_iter().map(|t| e.curve.at(t))));
                for &j in &of_edge[c.edge as usize] {
                    if part[j] == usize::MAX {
                        part[j] = out.len();
                        stack.push(j);
                    }
                }
            }
        }
        members.sort_unstable();
        out.push((bounds.diagonal(), members.into_iter().map(|i| faces[i]).collect()));
    }
    out.sort_by(|a, b| b.0.total_cmp(&a.0));
    out.into_iter().map(|x| x.1).collect()
}

/// A number as STEP has them: always with a point.
fn real(x: f64) -> String {
    let s = format!("{:?}", if x == 0.0 { 0.0 } else { x });
    match s.split_once('e') {
        Some((m, e)) if m.contains('.') => format!("{m}E{e}"),
        Some((m, e)) => format!("{m}.E{e}"),
        None => s,
    }
}

fn reals(list: impl Iterator<Item = f64>) -> String {
    format!("({})", list.map(real).collect::<Vec<_>>().join(","))
}

fn refs(list: impl Iterator<Item = u64>) -> String {
    format!("({})", list.map(|i| format!("#{i}")).collect::<Vec<_>>().join(","))
}

/// A string between quotes; letters beyond ASCII as ISO 10303-21 has them.
fn text(s: &str) -> String {
    let mut out = String::new();
    for c in s.chars() {
        match c {
            '\'' => out.push_str("''"),
            '\\' => out.push_str("\\\\"),
            ' '..='~' => out.push(c),
            c if c.is_control() => out.push(' '),
            c if (c as u32) < 0x1_0000 => out.push_str(&format!("\\X2\\{:04X}\\X0\\", c as u32)),
            c => out.push_str(&format!("\\X4\\{:08X}\\X0\\", c as u32)),
        }
    }
    out
}

/// Different knots, and how often each counts.
fn knots(k: &Knots) -> (String, String) {
    let mut list: Vec<(f64, usize)> = Vec::new();
    for v in k.values() {
        match list.last_mut() {
            Some(l) if l.0 == *v => l.1 += 1,
            _ => list.push((*v, 1)),
        }
    }
    let counts: Vec<String> = list.iter().map(|k| k.1.to_string()).collect();
    (format!("({})", counts.join(",")), reals(list.iter().map(|k| k.0)))
}

struct Writer {
    text: String,
    next: u64,
}

impl Writer {
    fn put(&mut self, record: &str) -> u64 {
        let id = self.next;
        self.next += 1;
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "#{id}={record};");
        id
    }

    /// Units and accuracy.
    fn context(&mut self, unit: &str, size: f64) -> Result<u64> {
        let si = |prefix: &str| format!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))");
        let length = match unit {
            "m" => self.put(&si("$")),
            "dm" => self.put(&si(".DECI.")),
            "cm" => self.put(&si(".CENTI.")),
            "mm" => self.put(&si(".MILLI.")),
            "um" => self.put(&si(".MICRO.")),
            "in" | "ft" => {
                let (name, mm) = if unit == "in" { ("INCH", 25.4) } else { ("FOOT", 304.8) };
                let base = self.put(&si(".MILLI."));
                let one = self.put(&format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),#{base})", real(mm)));
                let dim = self.put("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)");
                self.put(&format!("(CONVERSION_BASED_UNIT('{name}',#{one})LENGTH_UNIT()NAMED_UNIT(#{dim}))"))
            }
            other => return Err(Error::input(Place::Unknown, format!("STEP files have no unit {other:?}"))),
        };
        let angle = self.put("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
        let solid = self.put("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
        let near = real(ACCURACY * size);
        let accuracy = self.put(&format!(
            "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({near}),#{length},'distance_accuracy_value','')"
        ));
        Ok(self.put(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{accuracy}))\
             GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle},#{solid}))REPRESENTATION_CONTEXT('',''))"
        )))
    }

    fn product(&mut self, name: &str, shape: u64) {
        let name = text(name);
        let app = self.put("APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
        self.put(&format!("APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#{app})"));
        let context = self.put(&format!("PRODUCT_CONTEXT('',#{app},'mechanical')"));
        let product = self.put(&format!("PRODUCT('{name}','{name}','',(#{context}))"));
        self.put(&format!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}))"));
        let formation = self.put(&format!("PRODUCT_DEFINITION_FORMATION('','',#{product})"));
        let stage = self.put(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',#{app},'design')"));
        let definition = self.put(&format!("PRODUCT_DEFINITION('design','',#{formation},#{stage})"));
        let whole = self.put(&format!("PRODUCT_DEFINITION_SHAPE('','',#{definition})"));
        self.put(&format!("SHAPE_DEFINITION_REPRESENTATION(#{whole},#{shape})"));
    }

    fn colors(&mut self, brep: &Brep, faces: &[u64], context: u64) {
        let mut items = Vec::new();
        for (f, id) in brep.faces.iter().zip(faces) {
            let Some([r, g, b]) = f.color else { continue };
            let color = self.put(&format!("COLOUR_RGB('',{},{},{})", real(r), real(g), real(b)));
            let fill = self.put(&format!("FILL_AREA_STYLE_COLOUR('',#{color})"));
            let fill = self.put(&format!("FILL_AREA_STYLE('',(#{fill}))"));
            let fill = self.put(&format!("SURFACE_STYLE_FILL_AREA(#{fill})"));
            let side = self.put(&format!("SURFACE_SIDE_STYLE('',(#{fill}))"));
            let usage = self.put(&format!("SURFACE_STYLE_USAGE(.BOTH.,#{side})"));
            let style = self.put(&format!("PRESENTATION_STYLE_ASSIGNMENT((#{usage}))"));
            items.push(self.put(&format!("STYLED_ITEM('',(#{style}),#{id})")));
        }
        if !items.is_empty() {
            let list = refs(items.into_iter());
            self.put(&format!("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{list},#{context})"));
        }
    }

    fn point(&mut self, p: DVec3) -> u64 {
        let list = reals(p.to_array().into_iter());
        self.put(&format!("CARTESIAN_POINT('',{list})"))
    }

    fn direction(&mut self, d: DVec3) -> u64 {
        let list = reals(d.normalize_or_zero().to_array().into_iter());
        self.put(&format!("DIRECTION('',{list})"))
    }

    fn vector(&mut self, v: DVec3) -> u64 {
        let d = self.direction(v);
        self.put(&format!("VECTOR('',#{d},{})", real(v.length())))
    }

    fn placement(&mut self, f: &Frame) -> u64 {
        let (o, z, x) = (self.point(f.origin), self.direction(f.z()), self.direction(f.axes.x_axis));
        self.put(&format!("AXIS2_PLACEMENT_3D('',#{o},#{z},#{x})"))
    }

    fn curve(&mut self, c: &Curve) -> u64 {
        match c {
            Curve::Line { origin, direction } => {
                let (o, d) = (self.point(*origin), self.vector(*direction));
                self.put(&format!("LINE('',#{o},#{d})"))
            }
            Curve::Ellipse { frame, a, b } if a == b => {
                let f = self.placement(frame);
                self.put(&format!("CIRCLE('',#{f},{})", real(*a)))
            }
            Curve::Ellipse { frame, a, b } => {
                // Readers expect the longer half axis first.
                let turned =
                    Frame { axes: glam::DMat3::from_cols(frame.axes.y_axis, -frame.axes.x_axis, frame.z()), ..*frame };
                let f = self.placement(if a > b { frame } else { &turned });
                self.put(&format!("ELLIPSE('',#{f},{},{})", real(a.max(*b)), real(a.min(*b))))
            }
            Curve::Parabola { frame, focal } => {
                let f = self.placement(frame);
                self.put(&format!("PARABOLA('',#{f},{})", real(*focal)))
            }
            Curve::Hyperbola { frame, a, b } => {
                let f = self.placement(frame);
                self.put(&format!("HYPERBOLA('',#{f},{},{})", real(*a), real(*b)))
            }
            Curve::Nurbs(n) => self.spline(n),
        }
    }

    fn controls(&mut self, points: &[DVec4]) -> Vec<u64> {
        points.iter().map(|p| self.point(p.truncate() / p.w)).collect()
    }

    fn spline(&mut self, n: &NurbsCurve) -> u64 {
        let points = refs(self.controls(n.weighted()).into_iter());
        let (counts, values) = knots(&n.knots);
        let p = n.knots.degree();
        if !n.is_rational() {
            return self.put(&format!(
                "B_SPLINE_CURVE_WITH_KNOTS('',{p},{points},.UNSPECIFIED.,.U.,.U.,{counts},{values},.UNSPECIFIED.)"
            ));
        }
        let weights = reals(n.weighted().iter().map(|p| p.w));
        self.put(&format!(
            "(BOUNDED_CURVE()B_SPLINE_CURVE({p},{points},.UNSPECIFIED.,.U.,.U.)\
             B_SPLINE_CURVE_WITH_KNOTS({counts},{values},.UNSPECIFIED.)CURVE()GEOMETRIC_REPRESENTATION_ITEM()\
             RATIONAL_B_SPLINE_CURVE({weights})REPRESENTATION_ITEM(''))"
        ))
    }

    fn net(&mut self, s: &NurbsSurface) -> u64 {
        let rows: Vec<&[DVec4]> = s.weighted().chunks(s.v.points()).collect();
        let points: Vec<String> = rows.iter().map(|r| refs(self.controls(r).into_iter())).collect();
        let points = points.join(",");
        let ((cu, ku), (cv, kv)) = (knots(&s.u), knots(&s.v));
        let (p, q) = (s.u.degree(), s.v.degree());
        if !s.is_rational() {
            return self.put(&format!(
                "B_SPLINE_SURFACE_WITH_KNOTS('',{p},{q},({points}),.UNSPECIFIED.,.U.,.U.,.U.,{cu},{cv},{ku},{kv},\
                 .UNSPECIFIED.)"
            ));
        }
        let weights: Vec<String> = rows.iter().map(|r| reals(r.iter().map(|p| p.w))).collect();
        self.put(&format!(
            "(BOUNDED_SURFACE()B_SPLINE_SURFACE({p},{q},({points}),.UNSPECIFIED.,.U.,.U.,.U.)\
             B_SPLINE_SURFACE_WITH_KNOTS({cu},{cv},{ku},{kv},.UNSPECIFIED.)GEOMETRIC_REPRESENTATION_ITEM()\
             RATIONAL_B_SPLINE_SURFACE(({}))REPRESENTATION_ITEM('')SURFACE())",
            weights.join(",")
        ))
    }

    fn surface(&mut self, s: &Surface) -> Result<u64> {
        Ok(match s {
            Surface::Plane { frame } => {
                let f = self.placement(frame);
                self.put(&format!("PLANE('',#{f})"))
            }
            Surface::Cylinder { frame, radius } => {
                let f = self.placement(frame);
                self.put(&format!("CYLINDRICAL_SURFACE('',#{f},{})", real(*radius)))
            }
            Surface::Cone { frame, radius, slope } => {
                // STEP's cones grow along their axis.
                let a = frame.axes;
                let turned = Frame { axes: glam::DMat3::from_cols(a.x_axis, -a.y_axis, -a.z_axis), ..*frame };
                let f = self.placement(if *slope > 0.0 { frame } else { &turned });
                self.put(&format!("CONICAL_SURFACE('',#{f},{},{})", real(*radius), real(slope.abs().atan())))
            }
            Surface::Sphere { frame, radius } => {
                let f = self.placement(frame);
                self.put(&format!("SPHERICAL_SURFACE('',#{f},{})", real(*radius)))
            }
            Surface::Torus { frame, major, minor } => {
                let f = self.placement(frame);
                let (r, t) = (real(*major), real(*minor));
                if major < minor {
                    self.put(&format!("DEGENERATE_TOROIDAL_SURFACE('',#{f},{r},{t},.T.)"))
                } else {
                    self.put(&format!("TOROIDAL_SURFACE('',#{f},{r},{t})"))
                }
            }
            Surface::Extrusion { curve, direction } => {
                let (c, d) = (self.curve(curve), self.vector(*direction));
                self.put(&format!("SURFACE_OF_LINEAR_EXTRUSION('',#{c},#{d})"))
            }
            Surface::Revolution { curve, frame } => {
                let (c, o, z) = (self.curve(curve), self.point(frame.origin), self.direction(frame.z()));
                let axis = self.put(&format!("AXIS1_PLACEMENT('',#{o},#{z})"));
                self.put(&format!("SURFACE_OF_REVOLUTION('',#{c},#{axis})"))
            }
            Surface::Nurbs(n) => self.net(n),
            Surface::Offset { base, distance } => {
                let b = self.surface(base)?;
                self.put(&format!("OFFSET_SURFACE('',#{b},{},.F.)", real(*distance)))
            }
            other => self.net(&other.to_nurbs()?),
        })
    }

    fn face(&mut self, f: &Face, edges: &[u64]) -> Result<u64> {
        let surface = self.surface(&f.surface)?;
        let mut bounds = Vec::new();
        for l in &f.loops {
            let list: Vec<u64> = l
                .iter()
                .map(|c| {
                    let sense = if c.forward { "T" } else { "F" };
                    self.put(&format!("ORIENTED_EDGE('',*,*,#{},.{sense}.)", edges[c.edge as usize]))
                })
                .collect();
            let round = self.put(&format!("EDGE_LOOP('',{})", refs(list.into_iter())));
            let kind = if f.loops.len() == 1 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
            bounds.push(self.put(&format!("{kind}('',#{round},.T.)")));
        }
        if bounds.is_empty() {
            // A closed surface: a loop of one vertex, at a pole where there is one.
            let at = f.surface.poles().first().map_or_else(|| f.surface.at(glam::DVec2::ZERO), |p| p.point);
            let p = self.point(at);
            let vertex = self.put(&format!("VERTEX_POINT('',#{p})"));
            let round = self.put(&format!("VERTEX_LOOP('',#{vertex})"));
            bounds.push(self.put(&format!("FACE_BOUND('',#{round},.T.)")));
        }
        let sense = if f.outward { "T" } else { "F" };
        Ok(self.put(&format!("ADVANCED_FACE('{}',{},#{surface},.{sense}.)", text(&f.name), refs(bounds.into_iter()))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::step::parse_step;
    use crate::parametric::build::{
        Axis, Extrusion, Loft, Section, Wire, extrude_edges, loft, revolve_edges, sweep_edges,
    };
    use crate::parametric::mesh::Parametric;
    use crate::parametric::nurbs::SplineEnds;
    use crate::parametric::step::interpret;
    use crate::run::Run;
    use approx::{assert_abs_diff_eq, assert_relative_eq, relative_eq};

    /// One of each: planes and cylinders with a hole, cones, splines, poles, tori, NURBS, a sheet.
    fn models() -> Vec<Brep> {
        let v = DVec3::new;
        let disk = |z: f64, r: f64| Wire::circle(Frame { origin: v(0.0, 0.0, z), ..Frame::WORLD }, r).unwrap();
        let points = [v(0.0, 0.0, 0.0), v(2.0, 0.3, 0.0), v(3.0, 2.0, 0.0), v(1.0, 2.5, 0.0), v(-0.5, 1.0, 0.0)];
        let closed = Wire::spline(&points, SplineEnds::Closed).unwrap();
        let z = Axis { origin: DVec3::ZERO, direction: DVec3::Z };
        let half = Wire::arc(v(0.0, 0.0, -2.0), v(2.0, 0.0, 0.0), v(0.0, 0.0, 2.0)).unwrap();
        let profile = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.5), v(0.7, 0.0, 2.0), v(0.0, 0.0, 3.0)];
        let spindle = Wire::spline(&profile, SplineEnds::Natural).unwrap();
        let tube = Wire::circle(Frame::new(v(3.0, 0.0, 0.0), DVec3::Y, None), 1.0).unwrap();
        let path = Wire::spline(&[DVec3::ZERO, v(0.0, 0.5, 4.0), v(2.0, 3.0, 6.0)], SplineEnds::Natural).unwrap();
        let small = Wire::ellipse(Frame::new(DVec3::ZERO, path.pieces()[0].tangent(0.0), None), 0.3, 0.5).unwrap();
        let grow = |scale| Extrusion { scale, ..Extrusion::new(DVec3::Z, 1.5) };
        let s = [Section::Point(DVec3::ZERO), Section::Wire(disk(1.0, 1.0)), Section::Wire(disk(4.0, 0.6))];
        vec![
            extrude_edges(&[disk(0.0, 2.0), disk(0.0, 1.0)], &grow(1.0)).unwrap(),
            extrude_edges(&[disk(0.0, 2.0), disk(0.0, 1.0)], &grow(0.5)).unwrap(),
            extrude_edges(&[disk(0.0, 2.0)], &grow(2.0)).unwrap(),
            extrude_edges(std::slice::from_ref(&closed), &grow(1.0)).unwrap(),
            extrude_edges(std::slice::from_ref(&closed), &grow(0.3)).unwrap(),
            revolve_edges(&half, &z, 360.0, true).unwrap(),
            revolve_edges(&half, &z, 100.0, true).unwrap(),
            revolve_edges(&spindle, &z, 360.0, true).unwrap(),
            revolve_edges(&spindle, &z, 200.0, true).unwrap(),
            revolve_edges(&tube, &z, 360.0, true).unwrap(),
            loft(&s, &Loft { round: [true, false], ..Loft::default() }).unwrap(),
            sweep_edges(&[small], &path, true).unwrap(),
            revolve_edges(&spindle, &Axis { origin: v(9.0, 0.0, 0.0), ..z }, 360.0, false).unwrap(),
        ]
    }

    #[test]
    fn what_is_written_reads_back_as_it_was() {
        let run = Run::new();
        let measured = |b: &Brep| Parametric::new(b.clone(), &run).unwrap().measure(&run).unwrap();
        for (i, b) in models().into_iter().enumerate() {
            let mut b = b.named("it's a \u{444} \\ part");
            b.faces[0].color = Some([1.0, 0.5, 0.25]);
            let file = write_step(&b, "model", "mm").unwrap();
            let back = interpret(&parse_step(file.as_bytes()).unwrap(), &run).unwrap();
            assert!(back.notes.is_empty(), "{i}: {:?}", back.notes);
            let c = back.brep;
            assert_eq!(
                (b.vertices.len(), b.edges.len(), b.faces.len()),
                (c.vertices.len(), c.edges.len(), c.faces.len())
            );
            assert_eq!(b.bodies[0].solid, c.bodies[0].solid);
            assert_eq!(c.faces[0].color, Some([1.0, 0.5, 0.25]));
            for (f, g) in b.faces.iter().zip(&c.faces) {
                assert_eq!((f.surface.kind(), f.outward, f.loops.len()), (g.surface.kind(), g.outward, g.loops.len()));
            }
            let (m, n) = (measured(&b), measured(&c));
            assert_relative_eq!(m.area(), n.area(), epsilon = 0.0, max_relative = 1e-6);
            assert_abs_diff_eq!(m.volumes[0], n.volumes[0], epsilon = 1e-6 * m.area());
        }
    }

    #[test]
    fn units_are_written_and_unknown_ones_refused() {
        let v = DVec3::new;
        let square = Wire::polygon(&[DVec3::ZERO, v(2.0, 0.0, 0.0), v(2.0, 1.0, 0.0), v(0.0, 1.0, 0.0)]).unwrap();
        let b = extrude_edges(&[square], &Extrusion::new(DVec3::Z, 1.0)).unwrap();
        for (unit, mm) in
            [("m", 1000.0), ("dm", 100.0), ("cm", 10.0), ("mm", 1.0), ("um", 1e-3), ("in", 25.4), ("ft", 304.8)]
        {
            let file = write_step(&b, "box", unit).unwrap();
            let back = interpret(&parse_step(file.as_bytes()).unwrap(), &Run::new()).unwrap().brep;
            let widest = back.vertices.iter().map(|p| p.x).fold(0.0, f64::max);
            assert!(relative_eq!(widest, 2.0 * mm, epsilon = 0.0, max_relative = 1e-12), "{unit}");
        }
        assert!(write_step(&b, "box", "parsec").is_err());
        assert_eq!([real(1.0), real(-2.5e-7), real(1e30), real(-0.0)], ["1.0", "-2.5E-7", "1.E30", "0.0"]);
    }
}
