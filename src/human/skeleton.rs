//! Where the segments of a posed body are, for scores and drawings.

use super::body::Body;
use super::side::Side;
use crate::files::InputError;
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::Pose;
use nalgebra::Matrix6xX;

/// Links whose origins are joint centres, in the order of a drawing.
const TRUNK: &[&str] = &["L5", "L3", "T12", "T8", "Neck", "Head"];
const ARM: &[&str] = &["Shoulder", "UpperArm", "ForeArm", "Hand", "Grip"];
const LEG: &[&str] = &["UpperLeg", "LowerLeg", "Foot", "Toe"];

/// All segments of a body as tips of one linkage whose first columns are the coupled arm's chain.
#[derive(Debug, Clone)]
pub struct Skeleton {
    linkage: Linkage,
    names: Vec<String>,
}

/// A segment of one skeleton; the pelvis for a name that it does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segment(Option<usize>);

/// Segment poses of one posture, in the pelvis frame.
#[derive(Debug, Clone)]
pub struct PosedSkeleton<'a> {
    skeleton: &'a Skeleton,
    frames: Frames,
    poses: Vec<Pose>,
}

impl Skeleton {
    /// The skeleton for a coupled side; `with_legs` for drawings, without for scores.
    pub fn new(body: &Body, side: Side, with_legs: bool) -> Result<Self, InputError> {
        let sides = [side, side.other()];
        let limb = |parts: &[&str], s: Side| -> Vec<String> {
            parts.iter().map(|p| format!("{}{p}", s.prefix())).collect()
        };
        // The coupled grip first: it fixes the order of the leading columns.
        let mut names = vec![side.grip().to_owned()];
        names.extend(TRUNK.iter().map(|&s| s.to_owned()));
        for s in sides {
            names.extend(limb(ARM, s));
            if with_legs {
                names.extend(limb(LEG, s));
            }
        }
        let tips: Vec<Tip> = names.iter().map(|n| Tip::link(n)).collect();
        let linkage = Linkage::new(&body.model, "Pelvis", &tips)
            .map_err(|e| InputError::new(&body.name, format!("is no ergopath body: {e}")))?;
        Ok(Self { linkage, names })
    }

    /// Number of joint angles of the whole body.
    pub fn dof(&self) -> usize {
        self.linkage.dof()
    }

    /// Column of a joint.
    pub fn column(&self, joint: &str) -> Option<usize> {
        self.linkage.joints().iter().position(|j| j.name == joint)
    }

    /// The segment of a name.
    pub fn segment(&self, name: &str) -> Segment {
        Segment(self.names.iter().position(|n| n == name))
    }

    /// Poses all segments; `q` holds all columns (rad), the coupled chain first.
    pub fn pose(&self, q: &[f64]) -> PosedSkeleton<'_> {
        let mut frames = Frames::default();
        self.linkage.forward(q, &mut frames);
        let poses = (0..self.names.len()).map(|i| self.linkage.tip_pose(&frames, i)).collect();
        PosedSkeleton { skeleton: self, frames, poses }
    }
}

impl PosedSkeleton<'_> {
    /// Pose of a segment's frame in the pelvis frame, by [`Skeleton::segment`].
    pub fn at(&self, segment: Segment) -> Pose {
        segment.0.map_or_else(Pose::identity, |i| self.poses[i])
    }

    /// Geometric Jacobian of a segment's frame in pelvis axes, 6 x all columns: velocity of its origin
    /// over angular velocity. Zero for the pelvis.
    pub fn jacobian(&self, segment: Segment) -> Matrix6xX<f64> {
        let linkage = &self.skeleton.linkage;
        segment
            .0
            .map_or_else(|| Matrix6xX::zeros(linkage.dof()), |i| linkage.jacobian(&self.frames, i))
    }

    /// Pose of a segment's frame in the pelvis frame; identity for `Pelvis` and unknown names.
    pub fn segment(&self, name: &str) -> Pose {
        self.at(self.skeleton.segment(name))
    }
}

/// The bones to draw, as pairs of segment names whose origins they join.
pub fn bones() -> Vec<(String, String)> {
    let chain = |names: Vec<String>| -> Vec<(String, String)> {
        names.windows(2).map(|p| (p[0].clone(), p[1].clone())).collect()
    };
    let mut all = Vec::new();
    let mut spine = vec!["Pelvis".to_owned()];
    spine.extend(TRUNK.iter().map(|&s| s.to_owned()));
    all.extend(chain(spine));
    for side in ["Right", "Left"] {
        let mut arm = vec!["T8".to_owned()];
        arm.extend(ARM.iter().map(|p| format!("{side}{p}")));
        all.extend(chain(arm));
        let mut leg = vec!["Pelvis".to_owned()];
        leg.extend(LEG.iter().map(|p| format!("{side}{p}")));
        all.extend(chain(leg));
    }
    all
}
