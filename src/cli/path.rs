//! The command that walks over a mesh.

use std::fmt::Write;
use std::path::Path;

use rvachev::mesh::{MeshPath, shortest_path};
use rvachev::{DVec3, Error, Result, io};
use serde_json::json;

use super::arguments::Way;
use super::console::{note, run, say, writable};

/// Points farther from the mesh than this share of its diagonal were hardly meant to be on it.
const BESIDE: f64 = 0.01;

/// The file formats of a way.
#[derive(Clone, Copy)]
enum Ending {
    Vtp,
    Csv,
}

impl Ending {
    fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase().as_str() {
            "vtp" => Ok(Self::Vtp),
            "csv" => Ok(Self::Csv),
            _ => Err(Error::Usage(format!("path writes .vtp and .csv files, not {}", path.display()))),
        }
    }

    fn text(self, way: &MeshPath) -> String {
        match self {
            Self::Csv => rows("x,y,z\n", &way.points, ","),
            Self::Vtp => vtp(way),
        }
    }
}

fn rows(head: &str, points: &[DVec3], between: &str) -> String {
    let mut out = head.to_string();
    for p in points {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{}{between}{}{between}{}", p.x, p.y, p.z);
    }
    out
}

/// One polyline of VTK, with its length as data of the line.
fn vtp(way: &MeshPath) -> String {
    let n = way.points.len();
    let numbers: Vec<String> = (0..n).map(|i| i.to_string()).collect();
    let points = rows("", &way.points, " ");
    format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
         <PolyData>\n\
         <Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"0\" NumberOfLines=\"1\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n\
         <CellData Scalars=\"length\">\n\
         <DataArray type=\"Float64\" Name=\"length\" format=\"ascii\">{}</DataArray>\n\
         </CellData>\n\
         <Points>\n\
         <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n{points}</DataArray>\n\
         </Points>\n\
         <Lines>\n\
         <DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">{}</DataArray>\n\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">{n}</DataArray>\n\
         </Lines>\n\
         </Piece>\n\
         </PolyData>\n\
         </VTKFile>\n",
        way.length,
        numbers.join(" "),
    )
}

pub fn path(a: &Way) -> Result<bool> {
    let ending = a.output.as_deref().map(Ending::of).transpose()?;
    a.output.iter().try_for_each(|p| writable(p))?;
    let run = run(&a.common, "path")?;
    let mesh = io::read(&a.mesh, &run)?;
    let way = shortest_path(&mesh, a.from, a.to, &run).map_err(|e| e.in_file(&a.mesh))?;
    if let (Some(path), Some(ending)) = (&a.output, ending) {
        let text = ending.text(&way);
        io::write_atomic(path, |out| out.write_all(text.as_bytes()).map_err(|e| Error::io("write", path, e)))?;
    }
    drop(run);
    let ends = [(a.from, way.points.first()), (a.to, way.points.last())];
    let reach = BESIDE * mesh.bounds().diagonal();
    let far = |(p, q): &(DVec3, Option<&DVec3>)| q.map(|q| (*p, *q)).filter(|(p, q)| p.distance(*q) > reach);
    let told: Vec<String> = ends
        .iter()
        .filter_map(far)
        .map(|(p, q)| {
            format!("({}, {}, {}) is {} away from the mesh: the nearest point is taken", p.x, p.y, p.z, p.distance(q))
        })
        .collect();
    if !a.common.quiet {
        note("warning", &told);
    }
    if a.json {
        let points: Vec<[f64; 3]> = way.points.iter().map(|p| p.to_array()).collect();
        say(&json!({"length": way.length, "start": points.first(), "end": points.last(), "points": points}).to_string());
    } else {
        say(&format!("{}", way.length));
    }
    Ok(true)
}
