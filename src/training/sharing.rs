//! How the spine's joints share the turn of the trunk where a recording does not tell them apart.

use crate::human::{PostureLimits, SPINE_SHARES, Side};
use crate::kinematics::Linkage;
use nalgebra::{DMatrix, DVector};

const SPINE: [&str; 4] = ["jL5S1", "jL4L3", "jL1T12", "jT9T8"];

/// Hessian (for sd 1) of the pull that splits the trunk's turn over the spine joints, per axis
///
/// ```text
/// sum over j of (q_j - share_j * total)^2 / (4 share_j)
/// ```
/// and holds the girdle near zero where it was not recorded. With the shares as variances a part of
/// the trunk that was recorded by itself (pelvis to L3, say) is split in the same proportions.
pub(super) fn sharing(
    linkage: &Linkage,
    limits: &PostureLimits,
    side: Side,
    recorded: &[String],
) -> DMatrix<f64> {
    let n = linkage.dof();
    let column = |name: &str| linkage.joints().iter().position(|j| j.name == name);
    let mut hessian = DMatrix::zeros(n, n);
    for axis in ["Z", "X", "Y"] {
        let columns: Vec<usize> =
            SPINE.iter().filter_map(|j| column(&format!("{j}_{axis}"))).collect();
        let raw: Vec<f64> = if axis == "Z" {
            SPINE_SHARES.to_vec()
        } else {
            columns.iter().map(|&c| limits.upper[c] - limits.lower[c]).collect()
        };
        let total: f64 = raw.iter().take(columns.len()).sum();
        for (j, &c) in columns.iter().enumerate() {
            let mut row = DVector::zeros(n);
            for &other in &columns {
                row[other] -= raw[j] / total;
            }
            row[c] += 1.0;
            hessian.ger(0.25 * total / raw[j], &row, &row, 1.0);
        }
    }
    let girdle = format!("{}Shoulder", side.prefix());
    if !recorded.contains(&girdle) {
        for axis in ["Z", "X", "Y"] {
            if let Some(c) = column(&format!("j{}C7Shoulder_{axis}", side.prefix())) {
                hessian[(c, c)] += 1.0;
            }
        }
    }
    hessian
}
