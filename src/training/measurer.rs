//! What of a posture is compared between a recording and a prediction.

use crate::files::InputError;
use crate::human::{Body, Coupled, Legs, Pelvis, Side, Stance, pelvis_in_rest};
use crate::kinematics::{Frames, Linkage};
use crate::math::Vec3;

/// Names of what is compared, in order.
pub const FEATURES: [&str; 5] = ["pelvis height", "trunk", "upper arm", "elbow", "knees"];

/// Height of the hips (leg lengths), inclination of the trunk, elevation of the upper arm from the trunk,
/// flexion of the elbow, and of both knees on average (deg).
pub type Features = [f64; 5];

/// Angle at the middle of three points, 0 for a straight line, deg.
pub(super) fn bend_deg([a, b, c]: [Vec3; 3]) -> f64 {
    (b - a).angle(&(c - b)).to_degrees()
}

/// Tells the same of postures of a body.
#[derive(Debug, Clone)]
pub(super) struct Measurer {
    chain: Linkage,
    pub(super) legs: Legs,
    leg_m: f64,
}

impl Measurer {
    pub(super) fn new(body: &Body, side: Side) -> Result<Self, InputError> {
        let of = |part: &str| format!("{}{part}", side.prefix());
        let names = ["T8".to_owned(), of("UpperArm"), of("ForeArm"), of("Hand")];
        let coupled = Coupled { hands: side.into(), pelvis: Pelvis::Moves };
        let chain = body.chain(coupled, &names.each_ref().map(String::as_str))?;
        let legs = Legs::new(body, Stance::Standing { shoe_m: 0.0 })?;
        Ok(Self { chain, legs, leg_m: body.leg_m() })
    }

    /// A height above the ankles, in leg lengths, in the rest frame, m.
    pub(super) fn height(&self, legs: f64) -> f64 {
        self.legs.between_feet(false).y + legs * self.legs.length_m()
    }

    /// Of a posture (pelvis and joints, n, leg lengths and rad).
    pub(super) fn measure(&self, q: &[f64]) -> Features {
        let mut frames = Frames::default();
        self.chain.forward(q, &mut frames);
        let (_, thorax) = self.chain.tip_frame(&frames, 1);
        let up: Vec3 = thorax.column(1).into_owned();
        let [shoulder, elbow, hand] = [2, 3, 4].map(|tip| self.chain.tip_frame(&frames, tip).0);
        let pelvis = pelvis_in_rest(&q[..6], self.leg_m);
        let knees = self.legs.postures(&pelvis).map(|leg| -leg.knee.to_degrees());
        let hips = (pelvis * nalgebra::Point3::from(self.legs.between_hips())).y;
        let ankles = self.legs.between_feet(false).y;
        [
            (hips - ankles) / self.legs.length_m(),
            up.angle(&Vec3::y()).to_degrees(),
            (elbow - shoulder).angle(&-up).to_degrees(),
            bend_deg([shoulder, elbow, hand]),
            0.5 * (knees[0] + knees[1]),
        ]
    }
}

/// Energy score (deg) of draws of the four angles against what was seen: twice the mean distance less that
/// between the draws, halved (Gneiting and Raftery 2007, eq. 21).
pub(super) fn energy_deg(draws: &[&Features], seen: &Features) -> f64 {
    let away = |a: &Features, b: &Features| -> f64 {
        (1..FEATURES.len()).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
    };
    let count = draws.len() as f64;
    let to_seen: f64 = draws.iter().map(|d| away(d, seen)).sum::<f64>() / count;
    let mut between = 0.0;
    for (i, a) in draws.iter().enumerate() {
        between += draws[..i].iter().map(|b| away(a, b)).sum::<f64>();
    }
    to_seen - between / (count * (count - 1.0))
}
