//! Binary glTF 2.0, written only: one mesh with a primitive and a material for each face that has triangles.
//!
//! Vertices are of one face each. A sharp edge within a face parts them, too, so shading is smooth up to every sharp edge:
//! those the mesh is said to have, and those that turn by more than 30 degrees.

mod vertices;

use std::io::Write;

use serde_json::{Value, json};

use super::WriteOptions;
use super::atomic::write_failed;
use super::regions::Grouping;
use crate::error::{Error, Result};
use crate::mesh::{MeshView, TriMesh, face_colors};
use crate::run::Run;

use vertices::{FacePatch, VertexNumbers};

/// The magic number of the file,
const MAGIC: &[u8; 4] = b"glTF";
/// the types of its two chunks, of text
const JSON: &[u8; 4] = b"JSON";
/// and of numbers,
const BIN: &[u8; 4] = b"BIN\0";
/// and the version of the format.
const VERSION: u32 = 2;
/// Bytes of the file's header,
const HEADER: usize = 12;
/// and of that of a chunk.
const CHUNK_HEADER: usize = 8;
/// Bytes of three numbers, be they coordinates or corners.
const THREE: usize = 12;

/// OpenGL's number of whole numbers of 32 bits,
const UNSIGNED_INT: u32 = 5125;
/// of floating-point ones,
const FLOAT: u32 = 5126;
/// of a view that holds vertices,
const ARRAY_BUFFER: u32 = 34962;
/// of one that holds corners,
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// and of lists of triangles.
const TRIANGLES: u32 = 4;

/// Writes a mesh; the coordinates are its own, and the node above it turns and scales them.
pub(super) fn write(out: &mut dyn Write, mesh: &dyn MeshView, options: &WriteOptions, run: &Run) -> Result<()> {
    let mesh = TriMesh::from_view(mesh);
    let scale = options.unit.as_deref().map(meters).transpose()?;
    check_nodes(&mesh)?;
    // Before anything is numbered by `u32`.
    check_length(THREE * mesh.triangles.len())?;
    let corners = VertexNumbers::new(&mesh, &options.seams, run)?;
    let colors = face_colors(&mesh);
    let mut file = File::default();
    for patch in corners.patches(&mesh, run)? {
        run.check()?;
        let face = patch.face as usize;
        file.material(&mesh.faces[face], colors[face], corners.closed);
        file.primitive(&patch);
    }
    let document = file.document(&mesh, options, scale);
    let mut text = serde_json::to_vec(&document).map_err(|e| Error::Failed(format!("cannot write JSON: {e}")))?;
    text.resize(text.len().next_multiple_of(4), b' ');
    // Arrays of four bytes a number need no padding.
    let binary = file.positions.len() + file.normals.len() + file.indices.len();
    let length = check_length(HEADER + 2 * CHUNK_HEADER + text.len() + binary)?;
    let mut put = |bytes: &[u8]| out.write_all(bytes).map_err(write_failed);
    put(MAGIC)?;
    put(&VERSION.to_le_bytes())?;
    put(&length.to_le_bytes())?;
    put(&(text.len() as u32).to_le_bytes())?;
    put(JSON)?;
    put(&text)?;
    put(&(binary as u32).to_le_bytes())?;
    put(BIN)?;
    [file.positions, file.normals, file.indices].iter().try_for_each(|part| put(part))
}

/// A file tells its length in 32 bits.
fn check_length(length: usize) -> Result<u32> {
    let what = "binary glTF holds less than 4 GiB, and the mesh takes more; write another format";
    u32::try_from(length).map_err(|_| Error::Failed(what.into()))
}

fn check_nodes(mesh: &TriMesh) -> Result<()> {
    match mesh.nodes.iter().position(|p| !p.as_vec3().is_finite()) {
        Some(v) => Err(Error::Failed(format!(
            "binary glTF stores coordinates as f32, which cannot hold node {v} at {}; write another format",
            mesh.nodes[v]
        ))),
        None => Ok(()),
    }
}

/// How long a unit is in meters.
fn meters(unit: &str) -> Result<f64> {
    Ok(match unit {
        "um" => 1e-6,
        "mm" => 1e-3,
        "cm" => 1e-2,
        "dm" => 1e-1,
        "m" => 1.0,
        "in" => 0.0254,
        "ft" => 0.3048,
        other => return Err(Error::Failed(format!("binary glTF is in meters, and the unit {other:?} is not known"))),
    })
}

/// A color of the screen (sRGB) as the share of light it stands for, to four digits, which is finer than a screen.
fn light([r, g, b]: [f32; 3]) -> [f64; 4] {
    let linear = |c: f32| {
        let c = f64::from(c);
        let share = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        (share * 1e4).round() / 1e4
    };
    [linear(r), linear(g), linear(b), 1.0]
}

/// The parts of a file.
#[derive(Default)]
struct File {
    positions: Vec<u8>,
    normals: Vec<u8>,
    indices: Vec<u8>,
    accessors: Vec<Value>,
    primitives: Vec<Value>,
    materials: Vec<Value>,
}

impl File {
    fn material(&mut self, name: &str, color: [f32; 3], closed: bool) {
        self.materials.push(json!({
            "name": name,
            // An open surface is seen from behind.
            "doubleSided": !closed,
            "pbrMetallicRoughness": { "baseColorFactor": light(color), "metallicFactor": 0.0, "roughnessFactor": 0.8 },
        }));
    }

    fn primitive(&mut self, patch: &FacePatch) {
        let first = self.accessors.len();
        let count = patch.positions.len();
        let [low, high] = patch.bounds();
        self.accessors.push(json!({
            "bufferView": 0, "byteOffset": self.positions.len(), "componentType": FLOAT, "count": count, "type": "VEC3",
            "min": low, "max": high,
        }));
        self.accessors.push(json!({
            "bufferView": 1, "byteOffset": self.normals.len(), "componentType": FLOAT, "count": count, "type": "VEC3",
        }));
        self.accessors.push(json!({
            "bufferView": 2, "byteOffset": self.indices.len(), "componentType": UNSIGNED_INT,
            "count": patch.indices.len(), "type": "SCALAR",
        }));
        self.primitives.push(json!({
            "attributes": { "POSITION": first, "NORMAL": first + 1 },
            "indices": first + 2,
            "material": self.primitives.len(),
            "mode": TRIANGLES,
        }));
        let bytes = |list: &[[f32; 3]]| -> Vec<u8> { list.iter().flatten().flat_map(|x| x.to_le_bytes()).collect() };
        self.positions.extend(bytes(&patch.positions));
        self.normals.extend(bytes(&patch.normals));
        self.indices.extend(patch.indices.iter().flat_map(|v| v.to_le_bytes()));
    }

    fn document(&mut self, mesh: &TriMesh, options: &WriteOptions, scale: Option<f64>) -> Value {
        let mut extras = json!({});
        if let Some(unit) = &options.unit {
            extras["units"] = json!(unit);
        }
        if options.groups != Grouping::Faces {
            let named = |f: &u32| json!(mesh.faces[*f as usize]);
            let group = |g: &crate::mesh::Group| json!({ "name": g.name, "faces": g.faces.iter().map(named).collect::<Vec<_>>() });
            extras["groups"] = mesh.groups.iter().map(group).collect();
        }
        // A quarter turn about x: what was up along z is up along y.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut node = json!({ "name": "part", "mesh": 0, "rotation": [-half, 0.0, 0.0, half] });
        if let Some(scale) = scale {
            node["scale"] = json!([scale, scale, scale]);
        }
        let [positions, normals, indices] = [&self.positions, &self.normals, &self.indices].map(Vec::len);
        json!({
            "asset": { "version": "2.0", "generator": "rvachev" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [node],
            "meshes": [{ "name": "part", "primitives": std::mem::take(&mut self.primitives), "extras": extras }],
            "materials": std::mem::take(&mut self.materials),
            "accessors": std::mem::take(&mut self.accessors),
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": positions, "byteStride": THREE, "target": ARRAY_BUFFER },
                { "buffer": 0, "byteOffset": positions, "byteLength": normals, "byteStride": THREE, "target": ARRAY_BUFFER },
                { "buffer": 0, "byteOffset": positions + normals, "byteLength": indices, "target": ELEMENT_ARRAY_BUFFER },
            ],
            "buffers": [{ "byteLength": positions + normals + indices }],
        })
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;
    use glam::DVec3;

    use super::super::{Format, encode, read_bytes};
    use super::*;
    use crate::mesh::Group;

    /// A roof of two slopes that turn by 14 degrees: one face folded along its ridge, and a face of one triangle that closes an end.
    fn roof() -> TriMesh {
        let v = DVec3::new;
        let nodes = vec![
            v(0.0, 0.0, 0.0),
            v(2.0, 0.0, 0.0),
            v(0.0, 1.0, 0.125),
            v(2.0, 1.0, 0.125),
            v(0.0, 2.0, 0.0),
            v(2.0, 2.0, 0.0),
            v(9.0, 9.0, 9.0),
        ];
        TriMesh {
            nodes,
            triangles: vec![[0, 1, 3], [0, 3, 2], [0, 2, 4], [2, 3, 5], [2, 5, 4]],
            labels: vec![2, 2, 0, 2, 2],
            faces: vec!["gable \"end\"".into(), "nowhere".into(), "slopes".into()],
            groups: vec![Group { name: "wet".into(), faces: vec![2] }],
        }
    }

    fn bytes_of(mesh: &TriMesh, options: &WriteOptions) -> Vec<u8> {
        let mut bytes = Vec::new();
        encode(&mut bytes, mesh, Format::Glb, options, &Run::new()).unwrap();
        bytes
    }

    fn whole(bytes: &[u8], at: usize) -> usize {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
    }

    /// The document and the buffer of a file whose layout is checked.
    fn opened(bytes: &[u8]) -> (Value, &[u8]) {
        assert_eq!((&bytes[..4], whole(bytes, 4), whole(bytes, 8)), (&b"glTF"[..], 2, bytes.len()));
        let text = whole(bytes, 12);
        assert_eq!((&bytes[16..20], text % 4), (&b"JSON"[..], 0));
        let binary = 20 + text;
        assert_eq!((&bytes[binary + 4..binary + 8], whole(bytes, binary) % 4), (&b"BIN\0"[..], 0));
        assert_eq!(binary + 8 + whole(bytes, binary), bytes.len());
        let document: Value = serde_json::from_slice(&bytes[20..binary]).unwrap();
        assert_eq!(document["buffers"][0]["byteLength"], whole(bytes, binary));
        (document, &bytes[binary + 8..])
    }

    /// The numbers of an accessor, bits as they are.
    fn words(document: &Value, buffer: &[u8], accessor: &Value) -> Vec<u32> {
        let number = |v: &Value| v.as_u64().unwrap() as usize;
        let accessor = &document["accessors"][number(accessor)];
        let view = &document["bufferViews"][number(&accessor["bufferView"])];
        let length = number(&accessor["count"]) * if accessor["type"] == "VEC3" { 3 } else { 1 };
        let own = number(&accessor["byteOffset"]);
        assert!(own + 4 * length <= number(&view["byteLength"]));
        let first = number(&view["byteOffset"]) + own;
        (0..length).map(|k| whole(buffer, first + 4 * k) as u32).collect()
    }

    #[test]
    fn each_face_is_a_primitive_with_its_bounds_and_its_material() {
        let mesh = roof();
        let options = WriteOptions { unit: Some("cm".into()), seams: vec![[3, 2]], ..WriteOptions::default() };
        let bytes = bytes_of(&mesh, &options);
        assert_eq!(bytes, bytes_of(&mesh, &options));
        let (document, buffer) = opened(&bytes);
        let primitives = document["meshes"][0]["primitives"].as_array().unwrap();
        let names: Vec<_> = document["materials"].as_array().unwrap().iter().map(|m| m["name"].clone()).collect();
        assert_eq!((primitives.len(), names), (2, vec![json!("gable \"end\""), json!("slopes")]));
        // The ridge is said to be sharp: its two nodes are there twice.
        for (primitive, [vertices, face]) in primitives.iter().zip([[3, 0], [8, 2]]) {
            let attributes = &primitive["attributes"];
            let reals = |which: &Value| -> Vec<f32> {
                words(&document, buffer, which).into_iter().map(f32::from_bits).collect()
            };
            let (positions, normals) = (reals(&attributes["POSITION"]), reals(&attributes["NORMAL"]));
            assert_eq!((positions.len(), normals.len()), (3 * vertices, 3 * vertices));
            let point = |v: u32| DVec3::from_array([0, 1, 2].map(|k| f64::from(positions[3 * v as usize + k])));
            let own = (0..mesh.triangles.len()).filter(|t| mesh.labels[*t] == face as u32);
            let corners = words(&document, buffer, &primitive["indices"]);
            for (t, corners) in own.zip(corners.chunks_exact(3)) {
                assert_eq!([0, 1, 2].map(|k| point(corners[k])), mesh.corners(t));
                for v in corners {
                    let n = DVec3::from_array([0, 1, 2].map(|k| f64::from(normals[3 * *v as usize + k])));
                    assert!(n.distance(mesh.normal(t)) < 1e-6, "{n} on triangle {t}");
                }
            }
            let accessor = &document["accessors"][attributes["POSITION"].as_u64().unwrap() as usize];
            for k in 0..3 {
                let along = || positions.iter().skip(k).step_by(3).copied();
                assert_eq!(accessor["min"][k], json!(along().fold(f32::INFINITY, f32::min)));
                assert_eq!(accessor["max"][k], json!(along().fold(f32::NEG_INFINITY, f32::max)));
            }
        }
        assert_eq!(document["nodes"][0]["scale"], json!([0.01, 0.01, 0.01]));
        let extras = json!({ "units": "cm", "groups": [{ "name": "wet", "faces": ["slopes"] }] });
        assert_eq!(document["meshes"][0]["extras"], extras);
        assert_eq!(document["materials"][0]["doubleSided"], true);
    }

    #[test]
    fn shading_is_smooth_by_area_where_edges_turn_little() {
        let mut mesh = roof();
        // The second slope is half as long: it weighs less.
        mesh.nodes[4].y = 1.5;
        mesh.nodes[5].y = 1.5;
        let bytes = bytes_of(&mesh, &WriteOptions { groups: Grouping::Faces, ..WriteOptions::default() });
        let (document, buffer) = opened(&bytes);
        let attributes = &document["meshes"][0]["primitives"][1]["attributes"];
        let normals = words(&document, buffer, &attributes["NORMAL"]);
        assert_eq!(normals.len(), 3 * 6);
        // Node 3 is the third corner of the face: two triangles meet there, one of each slope.
        let n = DVec3::from_array([6, 7, 8].map(|k| f64::from(f32::from_bits(normals[k]))));
        let truth = (mesh.area_vector(0) + mesh.area_vector(1) + mesh.area_vector(3)).normalize();
        assert!(n.distance(truth) < 1e-6, "{n}, in truth {truth}");
        assert_eq!(document["meshes"][0]["extras"], json!({}));
        assert!(document["nodes"][0].get("scale").is_none());
        // A steep roof has a ridge without being told, and its nodes are there twice.
        mesh.nodes[2].z = 1.0;
        mesh.nodes[3].z = 1.0;
        let bytes = bytes_of(&mesh, &WriteOptions::default());
        let (document, buffer) = opened(&bytes);
        let attributes = &document["meshes"][0]["primitives"][1]["attributes"];
        assert_eq!(words(&document, buffer, &attributes["NORMAL"]).len(), 3 * 8);
    }

    #[test]
    fn a_flat_triangle_of_no_area_still_has_normals_of_length_one() {
        let mut mesh = roof();
        mesh.nodes[4] = mesh.nodes[0];
        let bytes = bytes_of(&mesh, &WriteOptions::default());
        let (document, buffer) = opened(&bytes);
        let attributes = &document["meshes"][0]["primitives"][0]["attributes"];
        for n in words(&document, buffer, &attributes["NORMAL"]).chunks_exact(3) {
            let length: f32 = n.iter().map(|x| f32::from_bits(*x).powi(2)).sum();
            assert_abs_diff_eq!(length, 1.0, epsilon = 1e-6);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_and_nothing_is_read() {
        let mut mesh = roof();
        let parsec = WriteOptions { unit: Some("parsec".into()), ..WriteOptions::default() };
        let refused = |mesh: &TriMesh, options: &WriteOptions| {
            encode(&mut Vec::new(), mesh, Format::Glb, options, &Run::new()).unwrap_err().to_string()
        };
        assert!(refused(&mesh, &parsec).contains("parsec"));
        mesh.nodes[6].y = 1e39;
        assert!(refused(&mesh, &WriteOptions::default()).contains("node 6"));
        assert!(check_length(u32::MAX as usize).is_ok() && check_length(1 << 32).is_err());
        let error =
            read_bytes(&bytes_of(&roof(), &WriteOptions::default()), Format::Glb, "a.glb".as_ref()).unwrap_err();
        assert!(matches!(error, Error::Usage(_)) && error.to_string().contains("written, not read"), "{error}");
    }
}
