//! STL, binary and text. Its unit is not written in it.

use super::read::{Found, refuse_many};
use super::triangles::Mesh;
use crate::files::InputError;
use crate::math::Vec3;
use std::path::Path;

/// Bytes before the triangles of a binary file, and of each triangle: a normal, three corners, two
/// bytes that nobody uses.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;
/// Bytes of a line end that some programs add.
const LINE_END: usize = 2;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Found, InputError> {
    let mesh = if let Some(count) = binary_count(bytes) {
        refuse_many(path, count)?;
        binary(bytes, count)
    } else if is_text(bytes) {
        text(path, &String::from_utf8_lossy(bytes))?
    } else {
        return Err(refusal(path, bytes));
    };
    Ok(Found { mesh, is_in_metres: false, is_y_up: false, more: Vec::new() })
}

/// Number of triangles that a binary file says it has.
fn said(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    Some(u32::from_le_bytes(count) as usize)
}

/// The number of triangles of a binary file, if it has as many bytes as they need. The word "solid" at
/// its beginning says nothing: many programs write it into binary files.
fn binary_count(bytes: &[u8]) -> Option<usize> {
    let count = said(bytes)?;
    let whole = HEADER + count.checked_mul(TRIANGLE)?;
    (whole..=whole + LINE_END).contains(&bytes.len()).then_some(count)
}

fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid") && !bytes.contains(&0)
}

fn refusal(path: &Path, bytes: &[u8]) -> InputError {
    let error = match (bytes.len(), said(bytes)) {
        (0, _) => InputError::new(path, "is empty"),
        (_, None) => InputError::new(path, "is neither binary nor text STL"),
        (length, Some(count)) => {
            let holds = (length - HEADER) / TRIANGLE;
            let what = if holds < count { "is cut short" } else { "is longer than it says" };
            let message = format!("{what}: it says {count} triangles and holds {holds}");
            InputError::new(path, message)
        }
    };
    error.remedy("export the STL file again, or copy it whole")
}

fn binary(bytes: &[u8], count: usize) -> Mesh {
    let number = |at: &[u8]| f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]]));
    let corner = |at: &[u8]| Vec3::new(number(at), number(&at[4..]), number(&at[8..]));
    let triangle = |t: &[u8]| [corner(&t[12..]), corner(&t[24..]), corner(&t[36..])];
    Mesh { triangles: bytes[HEADER..].chunks_exact(TRIANGLE).take(count).map(triangle).collect() }
}

fn text(path: &Path, text: &str) -> Result<Mesh, InputError> {
    let mut mesh = Mesh::default();
    let mut corners: Vec<Vec3> = Vec::new();
    let mut is_ended = false;
    for (row, line) in text.lines().enumerate() {
        let wrong = |what: String| {
            InputError::new(path, format!("line {}: {what}", row + 1))
                .remedy("export the STL file again, best as binary")
        };
        let mut words = line.split_whitespace();
        let Some(first) = words.next() else { continue };
        is_ended = first.eq_ignore_ascii_case("endsolid");
        if first.eq_ignore_ascii_case("vertex") {
            let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).collect();
            let [x, y, z] = numbers[..] else {
                let shown: String = line.trim().chars().take(60).collect();
                return Err(wrong(format!("`{shown}` is no corner of three numbers")));
            };
            corners.push(Vec3::new(x, y, z));
        } else if first.eq_ignore_ascii_case("endfacet") {
            let [a, b, c] = corners[..] else {
                return Err(wrong(format!("a facet has {} corners, not 3", corners.len())));
            };
            mesh.triangles.push([a, b, c]);
            corners.clear();
            refuse_many(path, mesh.triangles.len())?;
        }
    }
    if !is_ended {
        let message =
            format!("is cut short: no `endsolid` after {} triangles", mesh.triangles.len());
        return Err(
            InputError::new(path, message).remedy("export the STL file again, or copy it whole")
        );
    }
    Ok(mesh)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::fmt::Write as _;

    pub(in super::super) fn binary(mesh: &Mesh) -> Vec<u8> {
        let mut bytes = b"solid by a test".to_vec();
        bytes.resize(80, b' ');
        bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
        for triangle in &mesh.triangles {
            bytes.extend([0u8; 12]);
            for v in triangle.iter().flatten() {
                bytes.extend((*v as f32).to_le_bytes());
            }
            bytes.extend([0u8; 2]);
        }
        bytes
    }

    pub(in super::super) fn ascii(mesh: &Mesh) -> String {
        let mut text = "solid by a test\n".to_owned();
        for triangle in &mesh.triangles {
            text += "facet normal 0 0 0\n outer loop\n";
            for c in triangle {
                let _ = writeln!(text, "  vertex {} {} {}", c.x, c.y, c.z);
            }
            text += " endloop\nendfacet\n";
        }
        text + "endsolid\n"
    }
}
