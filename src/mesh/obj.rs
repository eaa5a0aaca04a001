//! OBJ: corners and faces; everything else in it is about looks. Its unit is not written in it.

use super::read::{Found, refuse_many};
use super::triangles::Mesh;
use crate::files::InputError;
use crate::math::Vec3;
use std::path::Path;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Found, InputError> {
    let text = String::from_utf8_lossy(bytes);
    let mut corners: Vec<Vec3> = Vec::new();
    let mut mesh = Mesh::default();
    for (row, line) in text.lines().enumerate() {
        let wrong = || {
            let shown: String = line.trim().chars().take(60).collect();
            InputError::new(path, format!("line {}: `{shown}` is not understood", row + 1))
                .remedy("export the mesh again, best as STL or glTF")
        };
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f64> = words.take(3).map_while(|w| w.parse().ok()).collect();
                let [x, y, z] = numbers[..] else { return Err(wrong()) };
                corners.push(Vec3::new(x, y, z));
            }
            Some("f") => {
                // Counted from 1, or backwards from the last.
                let index = |word: &str| -> Option<usize> {
                    let number: isize = word.split('/').next()?.parse().ok()?;
                    let from = if number < 0 { corners.len() } else { usize::MAX };
                    let index = from.wrapping_add_signed(number);
                    (number != 0 && index < corners.len()).then_some(index)
                };
                let face: Option<Vec<usize>> = words.map(index).collect();
                let face = face.filter(|f| f.len() >= 3).ok_or_else(wrong)?;
                refuse_many(path, mesh.triangles.len() + face.len())?;
                let fan = (2..face.len()).map(|i| [face[0], face[i - 1], face[i]]);
                mesh.triangles.extend(fan.map(|t| t.map(|i| corners[i])));
            }
            _ => {}
        }
    }
    Ok(Found { mesh, is_in_metres: false, is_y_up: false, more: Vec::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_fans_of_corners() {
        let text = b"# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1 -1/1\n";
        let found = parse(Path::new("a.obj"), text).ok().unwrap();
        assert_eq!(found.mesh.triangles.len(), 2);
        assert_eq!(found.mesh.triangles[1][2], Vec3::y());
        for bad in ["f 1 2 3", "v 0 0 0\nf 1 1", "v 0 x 0", "v 0 0 0\nf 1 1 -5", "v 0 0 0\nf 1 1 2"]
        {
            assert!(parse(Path::new("a.obj"), bad.as_bytes()).is_err(), "{bad}");
        }
    }
}
