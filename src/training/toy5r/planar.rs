//! Kinematics of the planar chain in closed form, and the same chain as URDF.
//!
//! ```text
//! hand = sum_i l_i (cos c_i, sin c_i)      c_i = q_0 + ... + q_i
//! ```

use super::constants::ToyConstants;
use nalgebra::DMatrix;
use std::fmt::Write as _;

/// Number of joints.
pub const JOINTS: usize = 5;

/// Name of the first link of [`planar_urdf`].
pub const BASE: &str = "base";
/// Name of its last link, at the hand.
pub const TIP: &str = "tip";

/// Where each link ends as seen from where it begins, m.
fn link_vectors(links: &[f64; JOINTS], q: &[f64; JOINTS]) -> [[f64; 2]; JOINTS] {
    let mut angle = 0.0;
    std::array::from_fn(|i| {
        angle += q[i];
        [links[i] * angle.cos(), links[i] * angle.sin()]
    })
}

/// The hand's place, m.
pub fn planar_hand(links: &[f64; JOINTS], q: &[f64; JOINTS]) -> [f64; 2] {
    let vectors = link_vectors(links, q);
    [0, 1].map(|k| vectors.iter().map(|v| v[k]).sum())
}

/// Its Jacobian, 2 x 5, m/rad.
pub fn planar_jacobian(links: &[f64; JOINTS], q: &[f64; JOINTS]) -> DMatrix<f64> {
    let vectors = link_vectors(links, q);
    let mut jacobian = DMatrix::zeros(2, JOINTS);
    let (mut x, mut y) = (0.0, 0.0);
    for i in (0..JOINTS).rev() {
        (x, y) = (x + vectors[i][0], y + vectors[i][1]);
        (jacobian[(0, i)], jacobian[(1, i)]) = (-y, x);
    }
    jacobian
}

/// Smallest singular value of a Jacobian of two rows.
pub(super) fn smallest_singular_value(jacobian: &DMatrix<f64>) -> f64 {
    let (a, b) = (jacobian.row(0).norm_squared(), jacobian.row(1).norm_squared());
    let c = jacobian.row(0).dot(&jacobian.row(1));
    let (middle, half) = (0.5 * (a + b), (0.25 * (a - b).powi(2) + c * c).sqrt());
    (middle - half).max(0.0).sqrt()
}

/// The chain as URDF text: links `base`, `link1` to `link5` and `tip`, all joints about z.
pub fn planar_urdf(constants: &ToyConstants) -> String {
    let mut text = String::from("<?xml version=\"1.0\"?>\n<robot name=\"planar_5r\">\n");
    let _ = writeln!(text, "  <link name=\"{BASE}\"/>");
    let (mut parent, mut along) = (BASE.to_owned(), 0.0);
    for (i, length) in constants.links.iter().enumerate() {
        let child = format!("link{}", i + 1);
        let _ = writeln!(
            text,
            "  <link name=\"{child}\"/>\n  <joint name=\"joint{}\" type=\"continuous\">\n    \
             <parent link=\"{parent}\"/>\n    <child link=\"{child}\"/>\n    \
             <origin xyz=\"{along} 0 0\" rpy=\"0 0 0\"/>\n    <axis xyz=\"0 0 1\"/>\n  </joint>",
            i + 1
        );
        (parent, along) = (child, *length);
    }
    let _ = writeln!(
        text,
        "  <link name=\"{TIP}\"/>\n  <joint name=\"hand\" type=\"fixed\">\n    \
         <parent link=\"{parent}\"/>\n    <child link=\"{TIP}\"/>\n    \
         <origin xyz=\"{along} 0 0\" rpy=\"0 0 0\"/>\n  </joint>\n</robot>"
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::{Frames, Linkage, parse_urdf};
    use std::path::Path;

    const POSTURES: [[f64; JOINTS]; 3] =
        [[0.3, -0.8, 1.4, 0.2, -0.5], [0.9, 0.2, 0.5, 0.1, 0.9], [-1.0, 0.0, 1.8, 0.5, 0.4]];

    fn by_linkage(linkage: &Linkage, q: &[f64; JOINTS]) -> (DMatrix<f64>, [f64; 2]) {
        let mut frames = Frames::default();
        linkage.forward(q, &mut frames);
        let hand = linkage.tip_pose(&frames, 0).translation.vector;
        (linkage.stacked_jacobian(&frames).rows(0, 2).into_owned(), [hand.x, hand.y])
    }

    #[test]
    fn closed_form_urdf_and_finite_differences_agree() {
        let constants = ToyConstants { links: [0.5, 0.4, 0.3, 0.2, 0.1], ..Default::default() };
        let model = parse_urdf(Path::new("planar"), &planar_urdf(&constants)).unwrap();
        let linkage = Linkage::chain(&model, BASE, TIP).unwrap();
        for q in POSTURES {
            let (jacobian, hand) = by_linkage(&linkage, &q);
            let own = planar_jacobian(&constants.links, &q);
            assert!((jacobian - &own).norm() < 1e-14);
            let own_hand = planar_hand(&constants.links, &q);
            assert!((hand[0] - own_hand[0]).abs() + (hand[1] - own_hand[1]).abs() < 1e-14);
            for i in 0..JOINTS {
                let moved = |by: f64| {
                    let mut q = q;
                    q[i] += by;
                    by_linkage(&linkage, &q).1
                };
                let (low, high) = (moved(-1e-6), moved(1e-6));
                for k in 0..2 {
                    assert!(((high[k] - low[k]) / 2e-6 - own[(k, i)]).abs() < 1e-9);
                }
            }
            let singular = own.svd(false, false).singular_values.min();
            let closed = smallest_singular_value(&planar_jacobian(&constants.links, &q));
            assert!((singular - closed).abs() < 1e-12);
        }
    }
}
