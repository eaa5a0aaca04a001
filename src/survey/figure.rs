//! A posed body as capsules, for drawings.

use super::{Surveyor, posed_whole};
use crate::human::{Body, Segment, Skeleton};
use crate::kinematics::Shape;
use crate::math::{Pose, Vec3};
use nalgebra::{DVector, Point3};

/// The capsules of the segments of a body.
#[derive(Debug, Clone, Default)]
pub(super) struct Flesh {
    /// Segment and the ends of the axis in its frame, m.
    parts: Vec<(Segment, [Vec3; 2])>,
    radii_m: Vec<f64>,
}

impl Flesh {
    /// The capsules that a body's file gives its segments.
    pub(super) fn of(body: &Body, skeleton: &Skeleton) -> Self {
        let mut flesh = Self::default();
        for link in &body.model.links {
            for (pose, shape) in &link.shapes {
                let Shape::Capsule { radius, length } = *shape else { continue };
                let end = |z: f64| (pose * Point3::new(0.0, 0.0, z)).coords;
                flesh
                    .parts
                    .push((skeleton.segment(&link.name), [end(-0.5 * length), end(0.5 * length)]));
                flesh.radii_m.push(radius);
            }
        }
        flesh
    }
}

/// A body whose postures can be drawn as capsules.
#[derive(Debug, Clone, Copy)]
pub struct Figure<'a> {
    surveyor: &'a Surveyor,
}

impl Surveyor {
    /// The body as capsules.
    pub fn figure(&self) -> Figure<'_> {
        Figure { surveyor: self }
    }
}

impl Figure<'_> {
    /// Radii of the capsules, m.
    pub fn radii_m(&self) -> &[f64] {
        &self.surveyor.flesh.radii_m
    }

    /// Both ends of every capsule's axis in the world (m), for a pelvis there and the joints of the
    /// coupled chain (rad).
    pub fn place(&self, pelvis: &Pose, q: &DVector<f64>) -> Vec<Vec3> {
        let Surveyor { whole, side, is_seated, flesh, .. } = self.surveyor;
        let posed = posed_whole(whole, *side, *is_seated, q);
        let end =
            |segment: Segment, p: &Vec3| (pelvis * posed.at(segment) * Point3::from(*p)).coords;
        flesh.parts.iter().flat_map(|&(s, [a, b])| [end(s, &a), end(s, &b)]).collect()
    }
}
