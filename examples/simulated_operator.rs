//! Writes the movements of the simulated operator: sixteen made-up reaches as a joint-motion CSV.
//!
//! ```text
//! cargo run --release --example simulated_operator -- OUT.csv [--body female_p50]
//! ```
//! Start and goal are drawn from a work volume in front; the hand goes straight by minimum jerk; the
//! posture is that of [`ergopath::posture::simulated_operator`] with sampled start and noise.

#![allow(clippy::print_stderr, reason = "a program says what went wrong")]

use ergopath::files::{InputError, write_whole};
use ergopath::human::{Body, Side};
use ergopath::math::pose::{interpolate, rotation_from_axes};
use ergopath::math::stream::{Purpose, normals, stream};
use ergopath::math::{Pose, Vec3};
use ergopath::posture::{
    Coupling, HandPath, Hold, PostureModel, Sampler, Sampling, StartRule, roll_out,
    simulated_operator, start_postures,
};
use ergopath::training::motion_text;
use nalgebra::UnitQuaternion;
use rand::RngExt as _;
use std::path::Path;
use std::process::ExitCode;

const REACHES: usize = 16;
const RATE_HZ: f64 = 30.0;
const SEED: u64 = 20;
const SIDE: Side = Side::Right;
/// Shortest distance from start to goal, m.
const SHORTEST_M: f64 = 0.25;
/// Standard deviation of the grip's orientation about each axis, rad: small, because the operator's
/// posture law knows upright bars only.
const TILT_RAD: f64 = 0.05;
/// Draws before the workplace counts as out of reach.
const MOST_DRAWS: u32 = 2000;

const COMMENTS: [&str; 4] = [
    "simulated operator",
    "Sixteen made-up reaches of a made-up person in a body of this program; no person was recorded.",
    "Made by examples/simulated_operator.rs. Angles of the chain from the pelvis to the right grip, rad.",
    "Redundancy: full weight matrix, pull towards a posture law, correlated noise (posture::simulated_operator).",
];

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (out, body) = match words.as_slice() {
        [out] => (out.as_str(), "female_p50"),
        [out, flag, body] if flag == "--body" => (out.as_str(), body.as_str()),
        _ => {
            eprintln!("usage: simulated_operator OUT.csv [--body BODY]");
            return ExitCode::from(2);
        }
    };
    match write(Path::new(out), body) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn write(out: &Path, body: &str) -> Result<(), InputError> {
    let body = Body::load(body, Path::new("."))?;
    let coupling = Coupling::new(&body, SIDE, Hold::Rigid)?;
    let operator = simulated_operator(&body, SIDE)?;
    let mut trials = Vec::new();
    for draw in 0..MOST_DRAWS {
        if let Some(trial) = reach(&coupling, &operator, draw) {
            trials.push(trial);
        }
        if trials.len() == REACHES {
            let joints: Vec<String> = coupling.joints().map(str::to_owned).collect();
            return write_whole(out, motion_text(&COMMENTS, &joints, &trials).as_bytes());
        }
    }
    Err(InputError::new(out, "the simulated operator cannot reach its workplace"))
}

/// Times (s) and postures (rad) of one reach; none when it is too short or out of reach.
fn reach(
    coupling: &Coupling,
    operator: &PostureModel,
    draw: u32,
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let mut rng = stream(SEED, Purpose::Simulation, 0, draw);
    let h = coupling.stature_m();
    let mut hand = || {
        let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let at = Vec3::new(between(0.18, 0.32), between(-0.08, 0.28), between(-0.06, 0.22)) * h;
        let tilt = Vec3::from_vec(normals(&mut rng, 3)) * TILT_RAD;
        // A vertical bar: the thumb up (pelvis y), the wrist behind the grip.
        let upright = rotation_from_axes(-Vec3::z(), -Vec3::x(), Vec3::y());
        Pose::from_parts(at.into(), UnitQuaternion::from_scaled_axis(tilt) * upright)
    };
    let (from, to) = (hand(), hand());
    if (from.translation.vector - to.translation.vector).norm() < SHORTEST_M {
        return None;
    }
    let duration = 1.6 + rng.random::<f64>();
    let count = (duration * RATE_HZ).round() as usize;
    let times: Vec<f64> = (0..=count).map(|i| i as f64 / RATE_HZ).collect();
    let hands: Vec<Pose> = (0..=count)
        .map(|i| {
            let s = i as f64 / count as f64;
            interpolate(&from, &to, s * s * s * (10.0 - 15.0 * s + 6.0 * s * s))
        })
        .collect();
    let starts =
        start_postures(coupling, &operator.postures, &StartRule::Sampled, &from, (SEED, draw), 1);
    let start = starts.first().filter(|s| s.q.is_some() && !s.is_unusual)?;
    let sampler = Sampler::new(&operator.law, Sampling::Pathwise)?;
    let person = sampler.draw(&mut rng, times.len(), 1.0 / RATE_HZ);
    let path = HandPath::new(coupling, &operator.law, times.clone(), hands);
    let rollout = roll_out(coupling, &operator.law, &path, start, Some(&person));
    if rollout.reach_exceeded_at.is_some() {
        return None;
    }
    Some((times, rollout.q.iter().map(|q| q.as_slice().to_vec()).collect()))
}
