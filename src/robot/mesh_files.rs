//! Where the mesh of a link is: the file that an address in a URDF names.
//!
//! ```text
//! package://NAME/rest   rest below a folder NAME, or below the folder itself, going up from the URDF
//! model://NAME/rest     the same
//! file:///place         there
//! place                 from the URDF's folder
//! ```

use std::path::{Component, Path, PathBuf};

/// Folders above a URDF's that are looked in.
const FOLDERS_UP: usize = 8;

/// The mesh file that an address in a URDF names, if it is there.
pub(super) fn find(urdf: &Path, address: &str) -> Option<PathBuf> {
    places(urdf, address).into_iter().find(|place| place.is_file())
}

/// Where the file may be, the likeliest first.
fn places(urdf: &Path, address: &str) -> Vec<PathBuf> {
    let folder = urdf.parent().unwrap_or(Path::new(""));
    let in_package = address.strip_prefix("package://").or(address.strip_prefix("model://"));
    if let Some(rest) = in_package {
        return from_package(folder, rest);
    }
    // As xacro leaves it in a description that was expanded in part: file://$(find NAME)/rest.
    let plain = address.strip_prefix("file://").unwrap_or(address);
    if let Some((name, rest)) = plain.strip_prefix("$(find").and_then(|r| r.split_once(')')) {
        return from_package(folder, &format!("{}{rest}", name.trim_start()));
    }
    if plain.contains("://") {
        return Vec::new();
    }
    vec![folder.join(plain)]
}

fn from_package(folder: &Path, rest: &str) -> Vec<PathBuf> {
    let below = rest.split_once('/').map_or("", |(_, below)| below);
    // An address leads down only.
    let is_down = |p: &str| Path::new(p).components().all(|c| matches!(c, Component::Normal(_)));
    if below.is_empty() || !is_down(rest) {
        return Vec::new();
    }
    // An empty path has no parents to go up through.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let up: Vec<&Path> = whole.ancestors().take(FOLDERS_UP + 1).collect();
    let named = up.iter().map(|f| f.join(rest));
    // The package's folder may have another name, as an unpacked archive's has.
    named.chain(up.iter().map(|f| f.join(below))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_followed_as_far_as_the_folders_go() {
        let room = tempfile::tempdir().unwrap();
        let package = room.path().join("arm_description");
        for folder in ["urdf", "meshes/collision"] {
            std::fs::create_dir_all(package.join(folder)).unwrap();
        }
        let (urdf, mesh) = (package.join("urdf/arm.urdf"), package.join("meshes/collision/a.stl"));
        std::fs::write(&mesh, "").unwrap();
        let found = |address: &str| find(&urdf, address).is_some();
        assert!(found("package://arm_description/meshes/collision/a.stl"));
        assert!(found("model://arm_description/meshes/collision/a.stl"));
        assert!(found("file://$(find arm_description)/meshes/collision/a.stl"));
        assert!(found("../meshes/collision/a.stl"));
        assert!(found(&format!("file://{}", mesh.display())));
        assert!(found("package://another_name/meshes/collision/a.stl"), "a renamed folder");
        assert!(!found("package://arm_description/meshes/collision/b.stl"));
        assert!(!found("package://arm_description/../../a.stl"));
        assert!(!found("https://example.org/a.stl"));
        assert!(!found(""), "a folder is no mesh");
    }
}
