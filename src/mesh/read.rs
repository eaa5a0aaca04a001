//! Reads a mesh file, whichever kind it is, with bounds on what it may hold.

use super::triangles::Mesh;
use super::{dae, gltf, obj, stl};
use crate::files::{InputError, read_bytes, sha256_hex};
use std::path::Path;

/// Largest mesh file, bytes, and most triangles: what is finer has to be exported coarser.
pub(super) const LARGEST_FILE: u64 = 128 << 20;
pub(super) const MOST_TRIANGLES: usize = 2_000_000;

/// A mesh as its file has it.
#[derive(Debug, Clone)]
pub struct MeshFile {
    /// The triangles, in the unit of the file.
    pub mesh: Mesh,
    /// Whether the kind of file says that its unit is the metre.
    pub is_in_metres: bool,
    /// Whether the kind of file has y up, as glTF has.
    pub is_y_up: bool,
    /// SHA-256 of the file, and of the files that it names.
    pub sha256: String,
}

/// What a reader of a kind of file finds.
pub(super) struct Found {
    pub mesh: Mesh,
    pub is_in_metres: bool,
    pub is_y_up: bool,
    /// Contents of further files.
    pub more: Vec<Vec<u8>>,
}

/// Reads STL (binary or text), glTF (`.gltf` or `.glb`), OBJ or COLLADA (`.dae`). Refused: other files, more than 128 MiB or
/// two million triangles, no triangle, a corner that is no finite number.
pub fn read_mesh(path: &Path) -> Result<MeshFile, InputError> {
    let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file);
    if let Some(size) = about.map(|a| a.len()).filter(|l| *l > LARGEST_FILE) {
        let message = format!("is {} MiB large; meshes of at most 128 MiB are read", size >> 20);
        return Err(InputError::new(path, message).remedy(COARSER));
    }
    let bytes = read_bytes(path)?;
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let found = match ending.as_str() {
        "stl" => stl::parse(path, &bytes)?,
        "gltf" | "glb" => gltf::parse(path, &bytes)?,
        "obj" => obj::parse(path, &bytes)?,
        "dae" => dae::parse(path, &bytes)?,
        other => return Err(unknown(path, other)),
    };
    check(path, &found.mesh)?;
    let mut all = bytes;
    found.more.iter().for_each(|m| all.extend_from_slice(m));
    let Found { mesh, is_in_metres, is_y_up, .. } = found;
    Ok(MeshFile { mesh, is_in_metres, is_y_up, sha256: sha256_hex(&all) })
}

pub(super) const COARSER: &str =
    "export the mesh coarser: clearance needs no finer than some millimetres";

/// Refuses one triangle too many.
pub(super) fn refuse_many(path: &Path, count: usize) -> Result<(), InputError> {
    if count <= MOST_TRIANGLES {
        return Ok(());
    }
    let message = format!("has {count} triangles or more; at most {MOST_TRIANGLES} are read");
    Err(InputError::new(path, message).remedy(COARSER))
}

fn unknown(path: &Path, ending: &str) -> InputError {
    let error = match ending {
        "" => InputError::new(path, "has no ending, and meshes are known by it"),
        other => InputError::new(path, format!("is no mesh that ergopath reads (`.{other}`)")),
    };
    error.remedy(match ending {
        "step" | "stp" | "igs" | "iges" | "3mf" | "ply" | "jt" | "sat" | "x_t" => {
            "convert it to STL or glTF first; the guide to scenarios says how"
        }
        _ => "STL, glTF (.gltf, .glb), OBJ and COLLADA (.dae) are read",
    })
}

fn check(path: &Path, mesh: &Mesh) -> Result<(), InputError> {
    if mesh.triangles.is_empty() {
        return Err(InputError::new(path, "holds no triangle")
            .remedy("export the body as a mesh: an assembly without visible parts is empty"));
    }
    let is_odd = |t: &&[crate::math::Vec3; 3]| t.iter().flatten().any(|v| !v.is_finite());
    if let Some(i) = mesh.triangles.iter().position(|t| is_odd(&t)) {
        let corner = mesh.triangles[i].iter().find(|c| c.iter().any(|v| !v.is_finite()));
        let [x, y, z] = corner.map_or([f64::NAN; 3], |c| (*c).into());
        let message =
            format!("triangle {} has a corner at ({x}, {y}, {z}), which is no place", i + 1);
        return Err(InputError::new(path, message).remedy("export the mesh again"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::stl::tests::{ascii, binary};
    use super::super::triangles::tests::cuboid;
    use super::*;
    use miette::Diagnostic;
    use proptest::prelude::*;

    fn read(name: &str, bytes: &[u8]) -> Result<MeshFile, InputError> {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        read_mesh(&file)
    }

    fn refusal(name: &str, bytes: &[u8]) -> String {
        let error = read(name, bytes).unwrap_err();
        let help = error.help().expect("every refusal has a remedy").to_string();
        format!("{error} / {help}")
    }

    #[test]
    fn both_kinds_of_stl_are_one_mesh() {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 4.0]);
        let one = read("a.stl", &binary(&mesh)).unwrap();
        let two = read("a.STL", ascii(&mesh).as_bytes()).unwrap();
        assert_eq!(one.mesh, mesh);
        assert_eq!(two.mesh, mesh);
        assert!(!one.is_in_metres && one.sha256 != two.sha256);
    }

    #[test]
    fn bad_files_are_refused_with_a_remedy() {
        let mesh = cuboid([0.0; 3], [1.0; 3]);
        let whole = binary(&mesh);
        assert!(refusal("a.stl", &whole[..whole.len() - 70]).contains("cut short"));
        assert!(refusal("a.stl", &[7; 40]).contains("neither"));
        assert!(refusal("a.stl", b"").contains("is empty"));
        let text = ascii(&mesh);
        assert!(refusal("a.stl", &text.as_bytes()[..text.len() / 2]).contains("cut short"));
        assert!(refusal("a.stl", binary(&Mesh::default()).as_slice()).contains("no triangle"));
        let mut odd = mesh.clone();
        odd.triangles[3][1].y = f64::NAN;
        assert!(refusal("a.stl", &binary(&odd)).contains("triangle 4 has a corner at"));
        assert!(refusal("a.stl", text.replace("1 1 1", "1 1 x").as_bytes()).contains("line"));
        assert!(refusal("a.step", b"ISO-10303-21").contains("convert it"));
        assert!(refusal("a", b"").contains("no ending"));
        let mut huge = vec![0u8; 84];
        huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(refusal("a.stl", &huge).contains("cut short"));
        let room = tempfile::tempdir().unwrap();
        let folder = room.path().join("a.stl");
        std::fs::create_dir(&folder).unwrap();
        assert!(read_mesh(&folder).unwrap_err().to_string().contains("is a folder"));
        assert!(read_mesh(&room.path().join("no.stl")).is_err());
        let large = room.path().join("large.stl");
        std::fs::File::create(&large).unwrap().set_len(LARGEST_FILE + 1).unwrap();
        assert!(read_mesh(&large).unwrap_err().to_string().contains("128 MiB"));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn no_mutilated_file_panics(cut in 0usize..700, at in 0usize..700, with in prop::collection::vec(any::<u8>(), 0..12)) {
            let mesh = cuboid([0.0; 3], [1.0; 3]);
            let glb = super::super::gltf::tests::glb(&mesh, "");
            for (name, whole) in [("a.stl", binary(&mesh)), ("b.stl", ascii(&mesh).into_bytes()), ("c.glb", glb)] {
                let cut = whole.len().min(whole.len() * cut / 650);
                let at = at.min(cut);
                let mut bytes = whole[..at].to_vec();
                bytes.extend(&with);
                bytes.extend(&whole[at..cut]);
                let _ = read(name, &bytes);
            }
        }
    }
}
