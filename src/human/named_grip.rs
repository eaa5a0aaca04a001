//! How a hand is turned that holds on in one of the usual ways, as the worker sees it.
//!
//! Directions are the worker's: x ahead, y to the left, z up. The hand's axes are those of the grip
//! links: z along what is held, towards the thumb, y towards the wrist, `x = y cross z`, which is out of
//! the palm on the right and out of the back of the hand on the left. The left hand is the mirror image
//! of the right one.

use super::side::Side;
use crate::math::Vec3;
use crate::math::pose::rotation_from_axes;
use nalgebra::UnitQuaternion;

/// A usual way to hold on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedGrip {
    /// On a bar across the front, from above.
    PalmDownBar,
    /// On a bar across the front, from below.
    PalmUpBar,
    /// On an upright bar, the thumb up.
    VerticalHandle,
    /// On a bar that runs ahead, from above, the arm hanging: as a suitcase is held.
    SuitcaseHandle,
    /// On a bar across the front above the head.
    OverheadBar,
    /// Flat on the side of a box, the fingers ahead and a little down.
    BoxSide,
    /// Between thumb and fingers, which come from above and behind.
    PinchFromAbove,
}

impl NamedGrip {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::PalmDownBar,
        Self::PalmUpBar,
        Self::VerticalHandle,
        Self::SuitcaseHandle,
        Self::OverheadBar,
        Self::BoxSide,
        Self::PinchFromAbove,
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PalmDownBar => "palm_down_bar",
            Self::PalmUpBar => "palm_up_bar",
            Self::VerticalHandle => "vertical_handle",
            Self::SuitcaseHandle => "suitcase_handle",
            Self::OverheadBar => "overhead_bar",
            Self::BoxSide => "box_side",
            Self::PinchFromAbove => "pinch_from_above",
        }
    }

    /// All names.
    pub fn names() -> [&'static str; Self::ALL.len()] {
        Self::ALL.map(Self::name)
    }

    /// The grip with this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|g| g.name() == name)
    }

    /// Where thumb and wrist of the right hand are.
    fn right(self) -> (Vec3, Vec3) {
        let (ahead, left, up) = (Vec3::x(), Vec3::y(), Vec3::z());
        match self {
            Self::PalmDownBar => (left, -ahead),
            Self::PalmUpBar => (-left, -ahead),
            Self::VerticalHandle => (up, -ahead),
            Self::SuitcaseHandle => (ahead, up),
            // The forearm comes from behind and below, at half a right angle.
            Self::OverheadBar => (left, -ahead - up),
            // The fingers 30 deg below the horizontal.
            Self::BoxSide => (3f64.sqrt() * up + ahead, -3f64.sqrt() * ahead + up),
            Self::PinchFromAbove => (left, up - ahead),
        }
    }

    /// Orientation of the hand in the worker's directions.
    pub fn turn(self, side: Side) -> UnitQuaternion<f64> {
        let (thumb, wrist) = self.right();
        let (thumb, wrist) = match side {
            Side::Right => (thumb, wrist),
            Side::Left => (mirrored(thumb), mirrored(wrist)),
        };
        let (z, y) = (thumb.normalize(), wrist.normalize());
        rotation_from_axes(y.cross(&z), y, z)
    }
}

/// A direction of the right side on the left one.
fn mirrored(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, -direction.y, direction.z)
}

/// Out of the palm of a hand whose frame is turned like that.
pub fn palm(side: Side, turn: &UnitQuaternion<f64>) -> Vec3 {
    let x = turn * Vec3::x();
    match side {
        Side::Right => x,
        Side::Left => -x,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::mirrored_pose;
    use crate::math::Pose;
    use approx::assert_relative_eq;

    /// What a grip's name says: where the palm of the right hand faces, where the thumb is, where the wrist.
    #[test]
    fn hands_are_turned_as_their_names_say() {
        let (ahead, left, up) = (Vec3::x(), Vec3::y(), Vec3::z());
        let (s, c) = (0.5, 0.75f64.sqrt());
        let half = 0.5f64.sqrt();
        let said = [
            (NamedGrip::PalmDownBar, -up, left, -ahead),
            (NamedGrip::PalmUpBar, up, -left, -ahead),
            (NamedGrip::VerticalHandle, left, up, -ahead),
            (NamedGrip::SuitcaseHandle, left, ahead, up),
            (NamedGrip::OverheadBar, half * (ahead - up), left, -half * (ahead + up)),
            (NamedGrip::BoxSide, left, c * up + s * ahead, s * up - c * ahead),
            (NamedGrip::PinchFromAbove, -half * (ahead + up), left, half * (up - ahead)),
        ];
        assert_eq!(said.map(|s| s.0), NamedGrip::ALL);
        for (grip, faces, thumb, wrist) in said {
            let turn = grip.turn(Side::Right);
            assert_relative_eq!(palm(Side::Right, &turn), faces, epsilon = 1e-12);
            assert_relative_eq!(turn * Vec3::z(), thumb, epsilon = 1e-12);
            assert_relative_eq!(turn * Vec3::y(), wrist, epsilon = 1e-12);
            assert_eq!(NamedGrip::by_name(grip.name()), Some(grip));
        }
    }

    #[test]
    fn the_left_hand_is_the_mirror_image_of_the_right() {
        // The worker's directions in the rest frame of a body: forward, up, right.
        let rest = rotation_from_axes(Vec3::x(), -Vec3::z(), Vec3::y());
        let hand = |grip: NamedGrip, side| {
            let turn = rest * grip.turn(side);
            Pose::from_parts(Vec3::zeros().into(), turn)
        };
        for grip in NamedGrip::ALL {
            let (right, left) = (hand(grip, Side::Right), hand(grip, Side::Left));
            assert!(mirrored_pose(&right).rotation.angle_to(&left.rotation) < 1e-12, "{grip:?}");
            let palms = [Side::Right, Side::Left].map(|s| palm(s, &grip.turn(s)));
            assert_relative_eq!(mirrored(palms[0]), palms[1], epsilon = 1e-12);
        }
    }
}
