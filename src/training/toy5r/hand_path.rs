//! Smooth hand paths for the 5R person: overlapping minimum-jerk moves between random places.
//!
//! The minimum-jerk profile s^3 (10 - 15 s + 6 s^2) is that of Flash and Hogan (1985). Moves begin
//! 1.2 s apart and last 1.4 to 1.8 s, so that one runs into the next; their lengths make the hand as
//! fast as the random task velocities of the toy problem (rms 0.24 m/s), without their jumps.

use super::constants::ToyConstants;
use crate::files::InputError;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// Time between the beginnings of two moves, s.
const APART_S: f64 = 1.2;
/// Shortest and longest duration of a move, s.
const DURATION_S: (f64, f64) = (1.4, 1.8);
/// Shortest and longest move, in seconds of the largest task velocity of one component.
const LENGTH_S: (f64, f64) = (0.5, 1.5);
/// How far the hand may leave the middle, in lengths of the stretched chain.
const ROOM: f64 = 0.2;
/// Nearest and farthest place from the base, in lengths of the stretched chain: beyond it the chain
/// is nearly straight, before it nearly folded.
const RING: (f64, f64) = (0.3, 0.85);
/// Step at which a path is judged, s.
const JUDGED_S: f64 = 0.02;
/// Draws of a path before there counts as no room for one.
const MOST_DRAWS: usize = 2000;

/// One move: when it begins, how long it lasts, where it goes.
#[derive(Debug, Clone)]
struct Move {
    begin_s: f64,
    duration_s: f64,
    by: [f64; 2],
}

/// A smooth path of the hand.
#[derive(Debug, Clone)]
pub(super) struct SmoothPath {
    start: [f64; 2],
    moves: Vec<Move>,
}

impl SmoothPath {
    /// Draws a path that begins at `start` and keeps near `middle`, m.
    pub(super) fn draw(
        rng: &mut ChaCha8Rng,
        constants: &ToyConstants,
        (start, middle): ([f64; 2], [f64; 2]),
        duration_s: f64,
    ) -> Result<Self, InputError> {
        let reach = constants.reach_m();
        let is_inside = |p: [f64; 2]| {
            let away = (p[0] - middle[0]).hypot(p[1] - middle[1]);
            let out = p[0].hypot(p[1]);
            away < ROOM * reach && (RING.0 * reach..RING.1 * reach).contains(&out)
        };
        for _ in 0..MOST_DRAWS {
            let path = Self::free(rng, constants.u_max_m_s, start, duration_s);
            let steps = (duration_s / JUDGED_S).ceil() as u32;
            if (0..=steps).all(|k| is_inside(path.at(JUDGED_S * f64::from(k)))) {
                return Ok(path);
            }
        }
        Err(InputError::new("5R trajectories", "there is no room for the hand paths")
            .remedy("lower u_max_m_s, lengthen the links or choose a q0 with bent joints"))
    }

    /// A path that heeds no bounds.
    fn free(rng: &mut ChaCha8Rng, u_max_m_s: f64, start: [f64; 2], duration_s: f64) -> Self {
        // The last move ends with the path.
        let count = (duration_s / APART_S).floor().max(1.0) as u32;
        let moves = (0..count).map(|k| {
            let begin_s = APART_S * f64::from(k);
            let longest = (duration_s - begin_s).min(rng.random_range(DURATION_S.0..=DURATION_S.1));
            let length = u_max_m_s * rng.random_range(LENGTH_S.0..=LENGTH_S.1);
            let (sin, cos) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
            Move { begin_s, duration_s: longest, by: [length * cos, length * sin] }
        });
        Self { start, moves: moves.collect() }
    }

    /// The hand's place at a time, m.
    pub(super) fn at(&self, time_s: f64) -> [f64; 2] {
        self.moves.iter().fold(self.start, |p, m| {
            let s = ((time_s - m.begin_s) / m.duration_s).clamp(0.0, 1.0);
            let share = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
            [p[0] + share * m.by[0], p[1] + share * m.by[1]]
        })
    }
}
