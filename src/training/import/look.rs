//! What a picture of an imported movement shows besides the person: the angles that ergonomists know, and the hand.

use crate::files::InputError;
use crate::human::{Body, Coupled, Pelvis, Side};
use crate::kinematics::Frames;
use crate::math::Vec3;
use crate::training::dataset::Trial;
use crate::training::measurer::{FEATURES, Measurer};

/// Coordinates of a pelvis that moves.
const PELVIS: usize = 6;

/// A movement as a picture shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionLook {
    /// Which joints move.
    pub coupled: Coupled,
    /// Times from the first row, s.
    pub time_s: Vec<f64>,
    /// Pelvis and joints, T x n, rad, leg lengths.
    pub q: Vec<Vec<f64>>,
    /// Name of each angle and its course, deg.
    pub angles_deg: Vec<(&'static str, Vec<f64>)>,
    /// The wrist in the rest frame of the body (x ahead, y up), m.
    pub hand: Vec<Vec3>,
}

impl MotionLook {
    /// Of a movement of a body.
    ///
    /// # Errors
    /// Where the movement is not one of the body.
    pub fn new(body: &Body, side: Side, trial: &Trial) -> Result<Self, InputError> {
        let dof = trial.q.first().map_or(0, Vec::len);
        let of = |pelvis| Coupled { hands: side.into(), pelvis };
        let hand = format!("{}Hand", side.prefix());
        let mut chains = [Pelvis::Rests, Pelvis::Moves].map(of).into_iter();
        let found = chains.find_map(|coupled| {
            let chain = body.chain(coupled, &[&hand]).ok()?;
            (chain.dof() == dof).then_some((coupled, chain))
        });
        let (coupled, chain) = found
            .ok_or_else(|| InputError::fault(&trial.source, "has another chain than its body"))?;
        let mut frames = Frames::default();
        let hand = trial.q.iter().map(|q| {
            chain.forward(q, &mut frames);
            chain.tip_frame(&frames, 1).0
        });
        let hand: Vec<Vec3> = hand.collect();
        let measurer = Measurer::new(body, side)?;
        let is_whole = coupled.pelvis == Pelvis::Moves;
        let features: Vec<_> = trial
            .q
            .iter()
            .map(|q| {
                let still = if is_whole { 0 } else { PELVIS };
                let all: Vec<f64> =
                    std::iter::repeat_n(0.0, still).chain(q.iter().copied()).collect();
                measurer.measure(&all)
            })
            .collect();
        // The first is a height; knees of a pelvis at rest are straight.
        let last = if is_whole { FEATURES.len() } else { FEATURES.len() - 1 };
        let angles_deg =
            (1..last).map(|c| (FEATURES[c], features.iter().map(|f| f[c]).collect())).collect();
        Ok(Self {
            coupled,
            time_s: (0..trial.q.len()).map(|i| i as f64 / trial.rate_hz).collect(),
            q: trial.q.clone(),
            angles_deg,
            hand,
        })
    }
}
