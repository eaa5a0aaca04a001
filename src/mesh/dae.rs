//! COLLADA: the meshes of the scene, placed by its nodes, in the unit that the file gives (metre where it gives
//! none). Which axis is up counts for obstacles only: robot descriptions take the axes as they are.

use super::read::{Found, refuse_many};
use super::triangles::Mesh;
use crate::files::InputError;
use crate::math::Vec3;
use nalgebra::{Matrix4, Point3, Rotation3, Unit};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;
use std::path::Path;

/// Largest file: as a tree it takes some ten times its size.
const LARGEST_BYTES: usize = 32 << 20;
/// Nodes within nodes, and nodes in all.
const MOST_DEEP: usize = 64;
const MOST_NODES: usize = 100_000;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Found, InputError> {
    if bytes.len() > LARGEST_BYTES {
        return Err(refusal(path, "is larger than 32 MiB"));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| refusal(path, "is not UTF-8 text"))?;
    let document = Document::parse(text)
        .map_err(|e| refusal(path, &format!("is not well-formed XML: {e}")))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(refusal(path, &format!("is no COLLADA but `{}`", root.tag_name().name())));
    }
    let asset = child(root, "asset");
    let unit = asset.and_then(|a| child(a, "unit")?.attribute("meter")?.trim().parse().ok());
    let up = asset.and_then(|a| child(a, "up_axis")?.text()).map_or("Y_UP", str::trim);
    let with_id = root.descendants().filter_map(|n| Some((n.attribute("id")?, n)));
    let mut reader = Reader { path, by_id: with_id.collect(), nodes: 0, mesh: Mesh::default() };
    let scale = Matrix4::new_scaling(unit.filter(|u: &f64| *u > 0.0).unwrap_or(1.0));
    let scene = child(root, "scene").and_then(|s| child(s, "instance_visual_scene"));
    let scene = scene.and_then(|s| reader.target(s.attribute("url")?));
    let scene = scene.or_else(|| child(child(root, "library_visual_scenes")?, "visual_scene"));
    let Some(scene) = scene else { return Err(refusal(path, "has no scene")) };
    for node in children(scene, "node") {
        reader.node(node, &scale, 0)?;
    }
    let is_y_up = up == "Y_UP";
    Ok(Found { mesh: reader.mesh, is_in_metres: true, is_y_up, more: Vec::new() })
}

fn refusal(path: &Path, message: &str) -> InputError {
    InputError::new(path, message).remedy("export the mesh as STL or glTF")
}

fn children<'a, 'i: 'a>(
    node: Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |n| n.is_element() && n.tag_name().name() == name)
}

fn child<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

fn numbers(node: Node) -> Vec<f64> {
    let text = node.text().unwrap_or_default();
    text.split_ascii_whitespace().map_while(|w| w.parse().ok()).collect()
}

struct Reader<'p, 'a, 'i> {
    path: &'p Path,
    by_id: BTreeMap<&'a str, Node<'a, 'i>>,
    nodes: usize,
    mesh: Mesh,
}

impl<'a, 'i: 'a> Reader<'_, 'a, 'i> {
    fn target(&self, url: &str) -> Option<Node<'a, 'i>> {
        self.by_id.get(url.strip_prefix('#')?).copied()
    }

    fn node(
        &mut self,
        node: Node<'a, 'i>,
        above: &Matrix4<f64>,
        deep: usize,
    ) -> Result<(), InputError> {
        self.nodes += 1;
        if deep > MOST_DEEP || self.nodes > MOST_NODES {
            return Err(refusal(self.path, "has nodes without end"));
        }
        let steps = node.children().filter_map(step);
        let pose = steps.fold(*above, |pose, step| pose * step);
        for inner in node.children().filter(Node::is_element) {
            let target = inner.attribute("url").and_then(|u| self.target(u));
            match (inner.tag_name().name(), target) {
                ("node", _) => self.node(inner, &pose, deep + 1)?,
                ("instance_node", Some(target)) => self.node(target, &pose, deep + 1)?,
                ("instance_geometry", Some(target)) => {
                    if let Some(mesh) = child(target, "mesh") {
                        self.geometry(mesh, &pose)?;
                    }
                }
                ("instance_controller", _) => {
                    return Err(refusal(self.path, "has a skin that moves, which is not read"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn geometry(&mut self, mesh: Node<'a, 'i>, pose: &Matrix4<f64>) -> Result<(), InputError> {
        let mut places: BTreeMap<&str, Vec<Vec3>> = BTreeMap::new();
        for kind in ["triangles", "polylist", "polygons", "trifans", "tristrips"] {
            for faces in children(mesh, kind) {
                if kind.starts_with("tri") && kind != "triangles" {
                    return Err(refusal(
                        self.path,
                        &format!("has faces as {kind}, which are not read"),
                    ));
                }
                let vertex =
                    children(faces, "input").find(|i| i.attribute("semantic") == Some("VERTEX"));
                let Some((vertex, source)) = vertex.and_then(|v| Some((v, v.attribute("source")?)))
                else {
                    return Err(refusal(self.path, "has faces without corners"));
                };
                if !places.contains_key(source) {
                    places.insert(source, self.places(source, pose)?);
                }
                self.faces(faces, vertex, &places[source])?;
            }
        }
        Ok(())
    }

    /// The corners of `vertices`, placed.
    fn places(&self, vertices: &str, pose: &Matrix4<f64>) -> Result<Vec<Vec3>, InputError> {
        let found = self.target(vertices).and_then(|v| {
            let position =
                children(v, "input").find(|i| i.attribute("semantic") == Some("POSITION"))?;
            let source = self.target(position.attribute("source")?)?;
            let accessor = child(child(source, "technique_common")?, "accessor");
            let stride = accessor.and_then(|a| a.attribute("stride")?.trim().parse().ok());
            Some((numbers(child(source, "float_array")?), stride.unwrap_or(3usize).max(3)))
        });
        let Some((values, stride)) = found else {
            return Err(refusal(self.path, "has no positions of its corners"));
        };
        let place = |c: &[f64]| pose.transform_point(&Point3::new(c[0], c[1], c[2])).coords;
        Ok(values.chunks_exact(stride).map(place).collect())
    }

    fn faces(&mut self, faces: Node, vertex: Node, places: &[Vec3]) -> Result<(), InputError> {
        let offset = |i: &Node| -> usize {
            i.attribute("offset").and_then(|o| o.trim().parse().ok()).unwrap_or(0)
        };
        let stride =
            children(faces, "input").map(|i| offset(&i)).max().unwrap_or(0).saturating_add(1);
        let at = offset(&vertex);
        let counts: Option<Vec<f64>> = child(faces, "vcount").map(numbers);
        for run in children(faces, "p") {
            let indices: Vec<usize> = numbers(run)
                .chunks(stride)
                .filter_map(|c| c.get(at))
                .map(|v| *v as usize)
                .collect();
            refuse_many(self.path, self.mesh.triangles.len() + indices.len() / 3)?;
            let mut rest = &indices[..];
            let mut sizes = counts.iter().flatten().map(|c| *c as usize);
            let is_polygon = faces.tag_name().name() == "polygons";
            while !rest.is_empty() {
                let size = match (&counts, is_polygon) {
                    (Some(_), _) => sizes.next().unwrap_or(rest.len()),
                    (None, true) => rest.len(),
                    (None, false) => 3,
                };
                let (face, after) = rest.split_at(size.clamp(1, rest.len()));
                rest = after;
                let corner = |i: &usize| places.get(*i).copied();
                let corners: Option<Vec<Vec3>> = face.iter().map(corner).collect();
                let Some(corners) = corners else {
                    return Err(refusal(self.path, "names corners that it does not have"));
                };
                let fan = (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]);
                self.mesh.triangles.extend(fan);
            }
        }
        refuse_many(self.path, self.mesh.triangles.len())
    }
}

/// A transformation of a node; none for other elements.
fn step(node: Node) -> Option<Matrix4<f64>> {
    let v = match node.tag_name().name() {
        "matrix" | "translate" | "rotate" | "scale" => numbers(node),
        _ => return None,
    };
    Some(match (node.tag_name().name(), &v[..]) {
        ("matrix", v) if v.len() == 16 => Matrix4::from_row_slice(v),
        ("translate", [x, y, z]) => Matrix4::new_translation(&Vec3::new(*x, *y, *z)),
        ("scale", [x, y, z]) => Matrix4::new_nonuniform_scaling(&Vec3::new(*x, *y, *z)),
        ("rotate", [x, y, z, angle]) => {
            let axis = Unit::try_new(Vec3::new(*x, *y, *z), 1e-12)?;
            Rotation3::from_axis_angle(&axis, angle.to_radians()).to_homogeneous()
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
      <asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>
      <library_geometries><geometry id="g"><mesh>
        <source id="s"><float_array id="f" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
          <technique_common><accessor source="#f" count="4" stride="3"/></technique_common></source>
        <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
        <polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="1"/>
          <vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist>
      </mesh></geometry></library_geometries>
      <library_visual_scenes><visual_scene id="w"><node id="n"><translate>10 0 0</translate><rotate>0 0 1 90</rotate>
        <instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
      <scene><instance_visual_scene url="#w"/></scene></COLLADA>"##;

    fn read(text: &str) -> Result<Found, InputError> {
        parse(Path::new("a.dae"), text.as_bytes())
    }

    #[test]
    fn unit_and_nodes_place_the_faces() {
        let found = read(SQUARE).ok().unwrap();
        assert_eq!(found.mesh.triangles.len(), 2);
        let (low, high) = found.mesh.bounds();
        assert!((low - Vec3::new(0.09, 0.0, 0.0)).norm() < 1e-12, "{low}");
        assert!((high - Vec3::new(0.10, 0.01, 0.0)).norm() < 1e-12, "{high}");
        assert!(!found.is_y_up && found.is_in_metres);
    }

    #[test]
    fn what_cannot_be_read_says_so() {
        let refused = |from: &str, to: &str| match read(&SQUARE.replace(from, to)) {
            Ok(_) => panic!("{to} was read"),
            Err(e) => e.to_string(),
        };
        assert!(refused("0 0 1 0 2 0 3 0", "0 0 1 0 9 0 3 0").contains("does not have"));
        assert!(refused("COLLADA", "collada").contains("is no COLLADA"));
        assert!(refused("</COLLADA>", "").contains("well-formed"));
        assert!(refused("\"#v\"", "\"#x\"").contains("no positions"));
        assert!(
            refused("<instance_geometry url=\"#g\"/>", "<instance_node url=\"#n\"/>")
                .contains("without end")
        );
        assert!(refused("polylist", "tristrips").contains("not read"));
    }
}
