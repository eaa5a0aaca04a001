//! Triangle meshes from CAD, and the simple shapes that hold them.
//!
//! ```text
//! STL, glTF, OBJ, DAE ─ read ─► Mesh (triangles, m) ─ capsules ─► capsules that hold a link of a robot
//!                                    └─ parts ─► Polytopes: convex parts that hold an obstacle
//! ```
//! What is made here is never smaller than the mesh: every triangle lies in one of the shapes, cut at
//! the planes between them where it lies in several.

mod capsules;
mod dae;
mod gltf;
mod obj;
mod parts;
mod polytope;
mod read;
mod split;
mod stl;
mod triangles;

pub use capsules::{FittedCapsule, fit_capsules};
pub use parts::{MOST_PARTS, convex_parts};
pub use polytope::Polytope;
pub use read::{MeshFile, read_mesh};
pub use triangles::{Mesh, Triangle};
