//! Where the segments of a posed body are, for scores and drawings.

use super::body::Body;
use super::side::Side;
use crate::files::{InputError, suggest};
use crate::kinematics::{Frames, Linkage, Tip};
use crate::math::Pose;
use nalgebra::Matrix6xX;

const PELVIS: &str = "Pelvis";
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

/// A segment of one skeleton, by its place among the tips; the pelvis is none of them.
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
        let linkage = Linkage::new(&body.model, PELVIS, &tips)
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

    /// The segment of a name; an error that suggests another for one that this skeleton lacks.
    pub fn segment(&self, name: &str) -> Result<Segment, InputError> {
        if name == PELVIS {
            return Ok(Segment(None));
        }
        match self.names.iter().position(|n| n == name) {
            Some(i) => Ok(Segment(Some(i))),
            None => Err(self.unknown(name)),
        }
    }

    fn unknown(&self, name: &str) -> InputError {
        let error = InputError::new(name, "is no segment of this skeleton");
        match suggest(name, self.names.iter().map(String::as_str).chain([PELVIS])) {
            Some(remedy) => error.remedy(remedy),
            None => error,
        }
    }

    /// The bones to draw, as pairs of segments whose origins they join; for a skeleton with legs.
    pub fn bones(&self) -> Result<Vec<[Segment; 2]>, InputError> {
        let pair = |(a, b): &(String, String)| Ok([self.segment(a)?, self.segment(b)?]);
        bones().iter().map(pair).collect()
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
}

/// The same by name.
fn bones() -> Vec<(String, String)> {
    let chain = |names: Vec<String>| -> Vec<(String, String)> {
        names.windows(2).map(|p| (p[0].clone(), p[1].clone())).collect()
    };
    let mut all = Vec::new();
    let mut spine = vec![PELVIS.to_owned()];
    spine.extend(TRUNK.iter().map(|&s| s.to_owned()));
    all.extend(chain(spine));
    for side in ["Right", "Left"] {
        let mut arm = vec!["T8".to_owned()];
        arm.extend(ARM.iter().map(|p| format!("{side}{p}")));
        all.extend(chain(arm));
        let mut leg = vec![PELVIS.to_owned()];
        leg.extend(LEG.iter().map(|p| format!("{side}{p}")));
        all.extend(chain(leg));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_segment_is_refused_and_the_pelvis_is_where_it_is() {
        let body = Body::load("female_p50", std::path::Path::new(".")).unwrap();
        let skeleton = Skeleton::new(&body, Side::Right, true).unwrap();
        let posed = skeleton.pose(&vec![0.0; skeleton.dof()]);
        assert_eq!(posed.at(skeleton.segment("Pelvis").unwrap()), Pose::identity());
        let head = posed.at(skeleton.segment("Head").unwrap()).translation.vector;
        assert!(head.y > 0.4, "{head}");
        let error = skeleton.segment("Haed").unwrap_err();
        let shown = format!("{:?}", miette::Report::new(error));
        assert!(shown.contains("Haed") && shown.contains("did you mean `Head`?"), "{shown}");
        // One without legs has no bones of legs.
        assert_eq!(skeleton.bones().unwrap().len(), 24);
        let upper = Skeleton::new(&body, Side::Right, false).unwrap();
        assert!(upper.segment("RightFoot").is_err() && upper.bones().is_err());
    }
}
