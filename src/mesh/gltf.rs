//! glTF: `.glb`, or `.gltf` with its data inside or beside it. Metres, y up; nodes place the meshes.

use super::read::{Found, LARGEST_FILE, refuse_many};
use super::triangles::{Mesh, Triangle};
use crate::files::{InputError, read_bytes};
use crate::math::Vec3;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::Source;
use gltf::mesh::{Mode, Primitive};
use gltf::{Gltf, Node, Semantic};
use nalgebra::{Matrix4, Point3};
use std::path::Path;

/// Nodes above a mesh, and nodes in all: a file may say that a node hangs on itself.
const MOST_DEEP: usize = 64;
const MOST_NODES: usize = 100_000;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Found, InputError> {
    let no_gltf = |e: gltf::Error| refusal(path, &format!("is no glTF: {e}"));
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(no_gltf)?;
    let json = document.into_json();
    if !has_its_places(&json) {
        return Err(refusal(path, "is no glTF: a mesh names places that it does not hold"));
    }
    let document = gltf::Document::from_json(json).map_err(no_gltf)?;
    let mut more = Vec::new();
    let buffers = buffers(path, &document, blob, &mut more)?;
    let mut reader = Reader { path, buffers, nodes: 0, mesh: Mesh::default() };
    let scenes = document.default_scene().map_or_else(|| document.scenes().collect(), |s| vec![s]);
    for node in scenes.iter().flat_map(gltf::Scene::nodes) {
        reader.node(&node, &Matrix4::identity(), 0)?;
    }
    Ok(Found { mesh: reader.mesh, is_in_metres: true, is_y_up: true, more })
}

/// Whether the places of all meshes are there; validation looks them up without asking.
fn has_its_places(json: &gltf::json::Root) -> bool {
    let places = gltf::json::validation::Checked::Valid(Semantic::Positions);
    let primitives = json.meshes.iter().flat_map(|m| &m.primitives);
    let named = primitives.filter_map(|p| p.attributes.get(&places));
    named.map(gltf::json::Index::value).all(|i| i < json.accessors.len())
}

fn refusal(path: &Path, message: &str) -> InputError {
    // Of a long list of what is wrong with the JSON, the beginning.
    let line: String = message.lines().next().unwrap_or_default().chars().take(200).collect();
    InputError::new(path, line)
        .remedy("export the mesh again, uncompressed and as one .glb file, or as STL")
}

/// The bytes of the buffers; `more` gets those of other files.
fn buffers(
    path: &Path,
    document: &gltf::Document,
    blob: Option<Vec<u8>>,
    more: &mut Vec<Vec<u8>>,
) -> Result<Vec<Vec<u8>>, InputError> {
    let mut blob = blob;
    let mut all = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            Source::Bin => blob
                .take()
                .ok_or_else(|| refusal(path, "names a binary part that it does not have"))?,
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => {
                    let text = data.split_once(";base64,").map(|(_, text)| text);
                    text.and_then(|t| STANDARD.decode(t).ok())
                        .ok_or_else(|| refusal(path, "holds data that are not base64"))?
                }
                None => beside(path, uri, more)?,
            },
        };
        if bytes.len() < buffer.length() {
            let message =
                format!("is cut short: a buffer has {} of {} bytes", bytes.len(), buffer.length());
            return Err(refusal(path, &message));
        }
        all.push(bytes);
    }
    Ok(all)
}

/// A file beside the mesh.
fn beside(path: &Path, uri: &str, more: &mut Vec<Vec<u8>>) -> Result<Vec<u8>, InputError> {
    let name = uri.replace("%20", " ");
    let is_plain = !name.contains(':') && Path::new(&name).is_relative();
    if !is_plain {
        return Err(refusal(path, &format!("has its data at `{uri}`, which is not beside it")));
    }
    let file = path.parent().unwrap_or(Path::new("")).join(name);
    let length = std::fs::metadata(&file).map_or(0, |m| m.len());
    if length > LARGEST_FILE {
        return Err(refusal(
            &file,
            &format!("is {} MiB large; at most 128 are read", length >> 20),
        ));
    }
    let bytes = read_bytes(&file)?;
    more.push(bytes.clone());
    Ok(bytes)
}

struct Reader<'p> {
    path: &'p Path,
    buffers: Vec<Vec<u8>>,
    nodes: usize,
    mesh: Mesh,
}

impl Reader<'_> {
    fn node(&mut self, node: &Node, above: &Matrix4<f64>, deep: usize) -> Result<(), InputError> {
        self.nodes += 1;
        if deep > MOST_DEEP || self.nodes > MOST_NODES {
            return Err(refusal(self.path, "has nodes without end"));
        }
        let own = node.transform().matrix();
        let pose = above * Matrix4::from_fn(|row, column| f64::from(own[column][row]));
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            self.primitive(&primitive, &pose)?;
        }
        node.children().try_for_each(|child| self.node(&child, &pose, deep + 1))
    }

    fn primitive(&mut self, primitive: &Primitive, pose: &Matrix4<f64>) -> Result<(), InputError> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            // Lines and points are drawings, not bodies.
            return Ok(());
        }
        let Some(positions) = primitive.get(&Semantic::Positions) else { return Ok(()) };
        let corners = self.positions(&positions)?;
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor)?,
            None => (0..corners.len()).collect(),
        };
        let wanted = indices.len();
        refuse_many(self.path, self.mesh.triangles.len() + wanted / 3)?;
        let triples: Vec<[usize; 3]> = match mode {
            Mode::Triangles => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
            Mode::TriangleStrip => indices.windows(3).map(|c| [c[0], c[1], c[2]]).collect(),
            _ => indices.windows(2).skip(1).map(|c| [indices[0], c[0], c[1]]).collect(),
        };
        refuse_many(self.path, self.mesh.triangles.len() + triples.len())?;
        for triple in triples {
            let corner = |i: usize| corners.get(i).map(|c| pose.transform_point(c).coords);
            let [Some(a), Some(b), Some(c)] = triple.map(corner) else {
                let message = format!(
                    "names corner {} of {}",
                    triple[0].max(triple[1]).max(triple[2]),
                    corners.len()
                );
                return Err(refusal(self.path, &message));
            };
            let triangle: Triangle = [a, b, c];
            self.mesh.triangles.push(triangle);
        }
        Ok(())
    }

    fn positions(&self, accessor: &Accessor) -> Result<Vec<Point3<f64>>, InputError> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            return Err(refusal(self.path, "has corners that are not three floats"));
        }
        let number = |at: &[u8]| f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]]));
        let point = |at: &[u8]| Vec3::new(number(at), number(&at[4..]), number(&at[8..])).into();
        self.items(accessor, 12, point)
    }

    fn indices(&self, accessor: &Accessor) -> Result<Vec<usize>, InputError> {
        match accessor.data_type() {
            DataType::U8 => self.items(accessor, 1, |at| usize::from(at[0])),
            DataType::U16 => {
                self.items(accessor, 2, |at| usize::from(u16::from_le_bytes([at[0], at[1]])))
            }
            DataType::U32 => self
                .items(accessor, 4, |at| u32::from_le_bytes([at[0], at[1], at[2], at[3]]) as usize),
            _ => Err(refusal(self.path, "has indices that are not whole numbers")),
        }
    }

    /// The items of an accessor, `size` bytes each.
    fn items<T>(
        &self,
        accessor: &Accessor,
        size: usize,
        item: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, InputError> {
        let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
            return Err(refusal(self.path, "is compressed or sparse"));
        };
        let stride = view.stride().unwrap_or(size).max(size);
        let buffer = self.buffers.get(view.buffer().index()).map_or(&[][..], |b| &b[..]);
        let start = view.offset().checked_add(accessor.offset());
        let bytes = start.and_then(|s| buffer.get(s..)).unwrap_or_default();
        let count = accessor.count();
        // The last item needs no room behind it.
        let needed =
            count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
        if needed.is_none_or(|n| n > bytes.len()) {
            return Err(refusal(self.path, &format!("is cut short: {count} items are not there")));
        }
        Ok((0..count).map(|i| item(&bytes[i * stride..i * stride + size])).collect())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A `.glb` of one mesh; `node` is more JSON of its node.
    pub(in super::super) fn glb(mesh: &Mesh, node: &str) -> Vec<u8> {
        let numbers = mesh.triangles.iter().flatten().flatten();
        let mut data: Vec<u8> = numbers.flat_map(|v| (*v as f32).to_le_bytes()).collect();
        let count = 3 * mesh.triangles.len();
        let places = data.len();
        data.extend((0..count as u32).flat_map(u32::to_le_bytes));
        let (low, high) = mesh.bounds();
        let mut json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{node}}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}},
            {{"bufferView":1,"componentType":5125,"count":{count},"type":"SCALAR"}}],
            "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{places}}},{{"buffer":0,"byteOffset":{places},"byteLength":{}}}],
            "buffers":[{{"byteLength":{}}}]}}"#,
            low.x,
            low.y,
            low.z,
            high.x,
            high.y,
            high.z,
            data.len() - places,
            data.len()
        );
        while !json.len().is_multiple_of(4) {
            json.push(' ');
        }
        let mut bytes = b"glTF".to_vec();
        bytes.extend(2u32.to_le_bytes());
        bytes.extend((28 + json.len() as u32 + data.len() as u32).to_le_bytes());
        bytes.extend((json.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(json.as_bytes());
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(data);
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Mesh, InputError> {
        parse(Path::new("a.glb"), bytes).map(|f| f.mesh)
    }

    #[test]
    fn nodes_place_their_meshes() {
        let mesh = super::super::triangles::tests::cuboid([0.0; 3], [1.0, 2.0, 4.0]);
        assert_eq!(read(&glb(&mesh, "")).unwrap(), mesh);
        let moved = read(&glb(&mesh, r#","translation":[1,0,0],"scale":[2,2,2]"#)).unwrap();
        assert_eq!(moved.bounds(), (Vec3::x(), Vec3::new(3.0, 4.0, 8.0)));
    }

    #[test]
    fn what_cannot_be_read_says_so() {
        let mesh = super::super::triangles::tests::cuboid([0.0; 3], [1.0; 3]);
        let refused = |node: &str| read(&glb(&mesh, node)).unwrap_err().to_string();
        assert!(refused(r#","children":[0]"#).contains("without end"));
        let whole = glb(&mesh, "");
        let text = String::from_utf8_lossy(&whole).into_owned();
        assert!(text.contains("5125"));
        let swapped = |from: &[u8], to: &[u8]| {
            let at = whole.windows(from.len()).position(|w| w == from).unwrap();
            let mut bytes = whole.clone();
            bytes[at..at + to.len()].copy_from_slice(to);
            read(&bytes).unwrap_err().to_string()
        };
        assert!(
            swapped(b"\"count\":36,\"type\":\"SC", b"\"count\":99,\"type\":\"SC")
                .contains("cut short")
        );
        assert!(swapped(b"5125", b"5126").contains("not whole numbers"));
        assert!(swapped(b"\"POSITION\":0", b"\"POSITION\":9").contains("does not hold"));
        assert!(swapped(b"\"accessors\"", b"\"accessorz\"").contains("does not hold"));
        assert!(read(b"glTF").unwrap_err().to_string().contains("is no glTF"));
        assert!(read(b"{}").unwrap_err().to_string().contains("is no glTF"));
    }
}
