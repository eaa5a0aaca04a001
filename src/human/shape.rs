//! How a body looks: tapered pieces with rounded ends, for pictures only.
//!
//! Joint centres are those of the body; thicknesses are round shares of stature, made wider or narrower
//! with the body's mass. Clearance never reads them: its capsules ([`Envelope`](super::Envelope)) hold
//! the body's mass instead.

use super::body::{Body, Stance};
use super::side::{Coupled, Side};
use super::skeleton::{Head, Segment, Skeleton};
use crate::files::InputError;
use crate::math::{Pose, Vec3};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// Mass over cubed stature at which the table's thicknesses hold, kg/m^3 (the 50th percentiles).
const MEAN_MASS: f64 = 15.5;

/// Half the thickness of seats and footrests.
const PLATE: f64 = 0.012;

/// What a piece of a mannequin belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SegmentKind {
    /// Head with nose, and neck.
    Head,
    /// Crown and back of the head.
    Hair,
    /// From the waist to the shoulders.
    Trunk,
    /// Below the waist.
    Pelvis,
    /// Shoulder to elbow.
    UpperArm,
    /// Elbow to wrist.
    Forearm,
    /// Palm, fingers and thumb.
    Hand,
    /// Hip to knee.
    Thigh,
    /// Knee to ankle.
    Shank,
    /// A shoe: its axis lies on the sole, and nothing of it lies on the far side of the axis.
    Foot,
    /// What a seated person sits and rests the feet on.
    Stool,
}

impl SegmentKind {
    /// From head to foot, and what carries.
    pub const ALL: [Self; 11] = [
        Self::Head,
        Self::Hair,
        Self::Trunk,
        Self::Pelvis,
        Self::UpperArm,
        Self::Forearm,
        Self::Hand,
        Self::Thigh,
        Self::Shank,
        Self::Foot,
        Self::Stool,
    ];
}

/// Radii of a cross-section that is no circle, in the direction of a point.
#[derive(Debug, Clone, PartialEq)]
pub struct WideSection {
    /// Index of the point towards which it is measured, for each end.
    pub toward: [usize; 2],
    /// Radius in that direction at each end, m.
    pub radii_m: [f64; 2],
}

/// A tapered piece between two points of a mannequin, rounded at both ends.
#[derive(Debug, Clone, PartialEq)]
pub struct MannequinPiece {
    /// What it belongs to.
    pub kind: SegmentKind,
    /// Indices of its points, the proximal one first.
    pub ends: [usize; 2],
    /// Radius at each end, m.
    pub radii_m: [f64; 2],
    /// The other radii of a section that is no circle.
    pub wide: Option<WideSection>,
}

/// The shape of one body with its hands on the robot.
#[derive(Debug, Clone)]
pub struct Mannequin {
    skeleton: Skeleton,
    points: Vec<Place>,
    pieces: Vec<MannequinPiece>,
}

/// A point in the frame of a segment, or in the rest frame, m.
type Place = (Option<Segment>, Vec3);

impl Mannequin {
    /// For a body whose coupled hands hold on to the robot.
    ///
    /// # Errors
    /// Never for a body that loaded.
    pub fn new(body: &Body, coupled: Coupled, stance: Stance) -> Result<Self, InputError> {
        let skeleton = Skeleton::new(body, coupled, stance, true)?;
        let mut figure = Figure::new(&skeleton, body);
        let neck = figure.trunk()?;
        figure.head()?;
        for side in [Side::Right, Side::Left] {
            figure.arm(side, neck, coupled.hands.hold(side))?;
            figure.leg(side)?;
        }
        if let Stance::Seated { seat_height_m, footrest_m } = stance {
            figure.stool(body.floor_m(stance), seat_height_m, footrest_m);
        }
        let Figure { points, pieces, .. } = figure;
        Ok(Self { skeleton, points, pieces })
    }

    /// The pieces, with points in the order of [`Mannequin::place`].
    pub fn pieces(&self) -> &[MannequinPiece] {
        &self.pieces
    }

    /// The points in the world (m), for the rest frame there, the joints of the coupled chain (rad, leg
    /// lengths) and the head.
    ///
    /// # Panics
    /// When `q` has not as many values as the coupled chain has joints.
    pub fn place(&self, rest: &Pose, q: &[f64], head: Head) -> Vec<Vec3> {
        let all = self.skeleton.whole(q, head);
        let posed = self.skeleton.pose(&all);
        let place = |(segment, at): &Place| {
            let frame = segment.map_or(*rest, |s| rest * posed.at(s));
            frame.transform_point(&Point3::from(*at)).coords
        };
        self.points.iter().map(place).collect()
    }
}

/// Points and pieces in the making; lengths are shares of stature unless they end in `_m`.
struct Figure<'a> {
    skeleton: &'a Skeleton,
    body: &'a Body,
    /// Thickness over that of the table.
    girth: f64,
    points: Vec<Place>,
    pieces: Vec<MannequinPiece>,
}

impl<'a> Figure<'a> {
    fn new(skeleton: &'a Skeleton, body: &'a Body) -> Self {
        let girth = (body.size.mass_kg / body.size.stature_m.powi(3) / MEAN_MASS).sqrt();
        Self { skeleton, body, girth, points: Vec::new(), pieces: Vec::new() }
    }

    /// A point in the frame of a segment (x forward, y up, z right).
    fn point(&mut self, segment: &str, at: [f64; 3]) -> Result<usize, InputError> {
        let segment = self.skeleton.segment(segment)?;
        self.points.push((Some(segment), Vec3::from(at) * self.body.size.stature_m));
        Ok(self.points.len() - 1)
    }

    /// A round piece.
    fn round(&mut self, kind: SegmentKind, ends: [usize; 2], radii: [f64; 2]) {
        self.piece(kind, ends, radii, None);
    }

    /// A piece with radii `radii` but for `wide`, towards other points.
    fn piece(
        &mut self,
        kind: SegmentKind,
        ends: [usize; 2],
        radii: [f64; 2],
        wide: Option<([usize; 2], [f64; 2])>,
    ) {
        use SegmentKind as K;
        // Skin lies close to the bone where mass does not change.
        let girth = if matches!(kind, K::Head | K::Hair | K::Hand | K::Foot | K::Stool) {
            1.0
        } else {
            self.girth
        };
        let thick = |radii: [f64; 2]| radii.map(|r| r * girth * self.body.size.stature_m);
        let wide = wide.map(|(toward, radii)| WideSection { toward, radii_m: thick(radii) });
        self.pieces.push(MannequinPiece { kind, ends, radii_m: thick(radii), wide });
    }

    /// Pelvis, trunk and neck; gives the point below the neck.
    fn trunk(&mut self) -> Result<usize, InputError> {
        let right_hip = self.point("RightUpperLeg", [0.0; 3])?;
        let right_rib = self.point("T8", [0.0, 0.0, 0.1])?;
        // Depth and breadth by height, from the seat up.
        let levels = [
            ("Pelvis", [-0.005, 0.004, 0.0], right_hip, [0.060, 0.097]),
            ("Pelvis", [-0.002, 0.062, 0.0], right_hip, [0.061, 0.087]),
            ("L3", [0.004, 0.0, 0.0], right_rib, [0.056, 0.081]),
            ("T12", [0.004, 0.0, 0.0], right_rib, [0.059, 0.082]),
            ("T8", [0.002, 0.010, 0.0], right_rib, [0.063, 0.088]),
            ("T8", [-0.002, 0.055, 0.0], right_rib, [0.055, 0.088]),
        ];
        let mut below: Option<(usize, usize, [f64; 2])> = None;
        let mut chest = 0;
        for (i, (segment, at, toward, radii)) in levels.into_iter().enumerate() {
            let point = self.point(segment, at)?;
            if let Some((low, low_toward, [depth, breadth])) = below {
                // The shirt hangs over the trousers.
                let (kind, under) =
                    if i == 1 { (SegmentKind::Pelvis, 0.95) } else { (SegmentKind::Trunk, 1.0) };
                let wide = Some(([low_toward, toward], [breadth, under * radii[1]]));
                self.piece(kind, [low, point], [depth, under * radii[0]], wide);
            }
            below = Some((point, toward, radii));
            chest = point;
        }
        let neck = self.point("Neck", [0.0; 3])?;
        let wide = Some(([right_rib; 2], [0.088, 0.038]));
        self.piece(SegmentKind::Trunk, [chest, neck], [0.055, 0.032], wide);
        let skull = self.point("Head", [0.0; 3])?;
        self.round(SegmentKind::Head, [neck, skull], [0.031, 0.031]);
        Ok(neck)
    }

    /// A head as high as the stature, with nose and hair.
    fn head(&mut self) -> Result<(), InputError> {
        let posed = self.skeleton.pose(&vec![0.0; self.skeleton.dof()]);
        let joint_m = posed.at(self.skeleton.segment("Head")?).translation.vector.y;
        let crown_m = self.body.size.stature_m - self.body.standing_pelvis_height_m - joint_m;
        let crown = crown_m / self.body.size.stature_m;
        let (breadth, depth) = (0.042, 0.053);
        let skull = self.point("Head", [0.010, crown - 0.006 - breadth, 0.0])?;
        let chin = self.point("Head", [0.020, 0.008, 0.0])?;
        let nose = self.point("Head", [0.061, 0.029, 0.0])?;
        let hair = self.point("Head", [-0.002, crown - 0.046, 0.0])?;
        let nape = self.point("Head", [-0.006, 0.030, 0.0])?;
        self.piece(
            SegmentKind::Head,
            [chin, skull],
            [0.030, breadth],
            Some(([nose; 2], [0.036, depth])),
        );
        self.round(SegmentKind::Head, [skull, nose], [0.016, 0.009]);
        self.piece(
            SegmentKind::Hair,
            [nape, hair],
            [0.038, 0.046],
            Some(([nose; 2], [0.038, 0.049])),
        );
        Ok(())
    }

    fn arm(&mut self, side: Side, neck: usize, is_closed: bool) -> Result<(), InputError> {
        let of = |segment: &str| format!("{}{segment}", side.prefix());
        let out = if side == Side::Right { 1.0 } else { -1.0 };
        let shoulder = self.point(&of("UpperArm"), [0.0; 3])?;
        let elbow = self.point(&of("ForeArm"), [0.0; 3])?;
        let wrist = self.point(&of("Hand"), [0.0; 3])?;
        self.round(SegmentKind::Trunk, [neck, shoulder], [0.026, 0.030]);
        self.round(SegmentKind::UpperArm, [shoulder, elbow], [0.034, 0.0235]);
        self.round(SegmentKind::Forearm, [elbow, wrist], [0.0235, 0.0155]);
        let length = self.body.hand_length_m / self.body.size.stature_m;
        let in_hand = |at: [f64; 3]| [at[0] * length, at[1] * length, out * at[2] * length];
        let knuckles = self.point(&of("Hand"), in_hand([0.0, -0.48, 0.0]))?;
        let thumb = self.point(&of("Hand"), in_hand([0.05, -0.50, 0.26]))?;
        // A hand on the robot is closed.
        let tip = if is_closed { [0.22, -0.52, 0.0] } else { [0.14, -0.88, 0.0] };
        let tips = self.point(&of("Hand"), in_hand(tip))?;
        let mut flat = |ends, radii, breadths| {
            self.piece(SegmentKind::Hand, ends, radii, Some(([thumb; 2], breadths)));
        };
        flat([wrist, knuckles], [0.0120, 0.0095], [0.0150, 0.0235]);
        flat([knuckles, tips], [0.0095, 0.0065], [0.0235, 0.0170]);
        self.round(SegmentKind::Hand, [wrist, thumb], [0.0110, 0.0065]);
        Ok(())
    }

    fn leg(&mut self, side: Side) -> Result<(), InputError> {
        let of = |segment: &str| format!("{}{segment}", side.prefix());
        let hip = self.point(&of("UpperLeg"), [0.0; 3])?;
        let knee = self.point(&of("LowerLeg"), [0.0; 3])?;
        let ankle = self.point(&of("Foot"), [0.0; 3])?;
        self.round(SegmentKind::Thigh, [hip, knee], [0.048, 0.032]);
        self.round(SegmentKind::Shank, [knee, ankle], [0.032, 0.021]);
        let shoe = self.skeleton.legs().shoe();
        let stature_m = self.body.size.stature_m;
        let [heel, toe, sole, below] =
            [shoe.heel_m, shoe.toe_m - shoe.ball.x, shoe.sole_m, shoe.sole_m + shoe.ball.y]
                .map(|m| m / stature_m);
        let heel = self.point(&of("Foot"), [heel + 0.018, -sole, 0.0])?;
        // Ball and toes stay on the floor where the heel rises.
        let middle = self.point(&of("Toe"), [0.0, -below, 0.0])?;
        let toe = self.point(&of("Toe"), [toe - 0.020, -below, 0.0])?;
        let rear = Some(([ankle; 2], [0.050, 0.036]));
        self.piece(SegmentKind::Foot, [heel, middle], [0.0220, 0.0275], rear);
        let toes = self.point(&of("Toe"), [0.0; 3])?;
        let front = Some(([toes; 2], [0.036, 0.025]));
        self.piece(SegmentKind::Foot, [middle, toe], [0.0275, 0.0255], front);
        Ok(())
    }

    /// A stool on the floor, and a plate under raised feet.
    fn stool(&mut self, floor_m: f64, seat_m: f64, footrest_m: f64) {
        let stature_m = self.body.size.stature_m;
        let [floor, seat, footrest] =
            [floor_m, floor_m + seat_m, floor_m + footrest_m].map(|m| m / stature_m);
        self.plate([-0.03, 0.09], seat, 0.11);
        if footrest_m > 0.0 {
            let ankle = self.skeleton.legs().ankles()[0].x / stature_m;
            self.plate([ankle, ankle + 0.09], footrest, 0.10);
        }
        let column = [floor + 0.025, seat - 0.02].map(|y| self.at_rest([0.0, y, 0.0]));
        self.round(SegmentKind::Stool, column, [0.025, 0.012]);
    }

    /// A level plate between two places ahead of the hips.
    fn plate(&mut self, ends: [f64; 2], top: f64, breadth: f64) {
        let y = top - PLATE;
        let aside = ends.map(|x| self.at_rest([x, y, 0.1]));
        let ends = ends.map(|x| self.at_rest([x, y, 0.0]));
        self.piece(SegmentKind::Stool, ends, [PLATE; 2], Some((aside, [breadth; 2])));
    }

    /// A point that does not move with the person.
    fn at_rest(&mut self, at: [f64; 3]) -> usize {
        self.points.push((None, Vec3::from(at) * self.body.size.stature_m));
        self.points.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Hands, Pelvis};
    use SegmentKind as K;

    fn figure(name: &str, stance: Stance) -> (Body, Mannequin, Vec<Vec3>) {
        let body = Body::load(name, std::path::Path::new(".")).unwrap();
        let coupled = Coupled { hands: Hands::Right, pelvis: Pelvis::Rests };
        let mannequin = Mannequin::new(&body, coupled, stance).unwrap();
        let q = vec![0.0; body.chain(coupled, &[]).unwrap().dof()];
        let rest = body.pelvis_pose([0.0, 0.0], 0.0, stance);
        let points = mannequin.place(&rest, &q, Head::default());
        (body, mannequin, points)
    }

    const STANDING: Stance = Stance::Standing { shoe_m: 0.03 };

    #[test]
    fn limbs_taper_and_every_kind_is_there_on_both_sides() {
        for (name, _) in super::super::PRESETS {
            let (_, mannequin, points) = figure(name, STANDING);
            for kind in K::ALL.into_iter().filter(|k| *k != K::Stool) {
                let of_kind = || mannequin.pieces().iter().filter(|p| p.kind == kind);
                assert!(of_kind().count() > 0, "{kind:?}");
                if matches!(kind, K::UpperArm | K::Forearm | K::Thigh | K::Shank) {
                    assert!(of_kind().all(|p| p.radii_m[0] > 1.2 * p.radii_m[1]), "{kind:?}");
                }
                // The other arm hangs: only legs are alike.
                let aside: f64 = of_kind().map(|p| points[p.ends[0]].y).sum();
                let is_alike = aside.abs() < 1e-9 && of_kind().count().is_multiple_of(2);
                assert!(is_alike || !matches!(kind, K::Thigh | K::Shank | K::Foot), "{kind:?}");
            }
        }
    }

    #[test]
    fn soles_lie_on_the_floor_and_the_crown_is_as_high_as_the_person() {
        for (name, size) in super::super::PRESETS {
            for stance in [STANDING, Stance::Seated { seat_height_m: 0.46, footrest_m: 0.0 }] {
                let (_, mannequin, points) = figure(name, stance);
                for foot in mannequin.pieces().iter().filter(|p| p.kind == K::Foot) {
                    let [heel, toe] = foot.ends.map(|e| points[e]);
                    assert!((heel.z - toe.z).abs() < 1e-9 && toe.x - heel.x > 0.03);
                    assert!(stance != STANDING || heel.z.abs() < 0.01, "{name}: {heel}");
                    assert!(heel.z > -0.01, "{name} {stance:?}: {heel}");
                }
                let top = |p: &MannequinPiece| {
                    let [low, high] = [0, 1].map(|e| points[p.ends[e]].z + p.radii_m[e]);
                    low.max(high)
                };
                let crown = mannequin.pieces().iter().map(top).fold(0.0, f64::max);
                let off = crown - size.stature_m - 0.03;
                assert!(stance != STANDING || off.abs() < 0.01, "{name}: {off}");
            }
        }
    }

    #[test]
    fn the_nose_is_where_the_face_is() {
        let (_, mannequin, points) = figure("female_p50", STANDING);
        let ahead = |kind: K| {
            let ends = mannequin.pieces().iter().filter(|p| p.kind == kind).flat_map(|p| p.ends);
            ends.map(|e| points[e].x).fold(f64::NEG_INFINITY, f64::max)
        };
        // The worker looks along x.
        assert!(ahead(K::Head) > ahead(K::Hair) + 0.08 && ahead(K::Foot) > 0.1);
    }
}
