//! Writes the movements of the simulated operator as a joint-motion CSV: sixteen made-up reaches of one arm
//! over a pelvis that rests, or thirty of a whole person from the floor to overhead.
//!
//! ```text
//! cargo run --release --example simulated_operator -- OUT.csv [--whole] [--body female_p50]
//! ```
//! Start and goal are drawn from a work volume in front; the hand goes straight by minimum jerk; the
//! posture is that of [`ergopath::posture::simulated_operator`] with sampled start and noise.

#![allow(clippy::print_stderr, reason = "a program says what went wrong")]

use ergopath::files::{InputError, write_whole};
use ergopath::human::{Body, Side};
use ergopath::training::{SimulatedMovements, motion_text};
use std::path::Path;
use std::process::ExitCode;

const REACHES: usize = 16;
const WHOLE_REACHES: usize = 30;
const SEED: u64 = 20;
const SIDE: Side = Side::Right;

const COMMENTS: [&str; 4] = [
    "simulated operator",
    "Sixteen made-up reaches of a made-up person in a body of this program; no person was recorded.",
    "Made by examples/simulated_operator.rs. Angles of the chain from the pelvis to the right grip, rad.",
    "Redundancy: full weight matrix, pull towards a posture law, correlated noise (posture::simulated_operator).",
];

const WHOLE_COMMENTS: [&str; 4] = [
    "simulated operator",
    "Thirty made-up reaches of a made-up person in a body of this program; no person was recorded.",
    "Made by examples/simulated_operator.rs. Pelvis from where it is upright (m, rad), spine and right arm, rad.",
    "Redundancy: as of the operator at rest, with a pelvis that moves (posture::simulated_whole_operator).",
];

fn main() -> ExitCode {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let is_whole = words.iter().any(|w| w == "--whole");
    words.retain(|w| w != "--whole");
    let (out, body) = match words.as_slice() {
        [out] => (out.as_str(), "female_p50"),
        [out, flag, body] if flag == "--body" => (out.as_str(), body.as_str()),
        _ => {
            eprintln!("usage: simulated_operator OUT.csv [--whole] [--body BODY]");
            return ExitCode::from(2);
        }
    };
    match write(Path::new(out), body, is_whole) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn write(out: &Path, body: &str, is_whole: bool) -> Result<(), InputError> {
    let body = Body::load(body, Path::new("."))?;
    let movements = SimulatedMovements::new(&body, SIDE, is_whole, SEED)?;
    let joints = movements.joints();
    let reaches = movements.first(if is_whole { WHOLE_REACHES } else { REACHES })?;
    let trials: Vec<_> = reaches.into_iter().map(|r| (r.times_s, r.postures)).collect();
    let comments = if is_whole { &WHOLE_COMMENTS } else { &COMMENTS };
    write_whole(out, motion_text(comments, (&joints, &body), &trials).as_bytes())
}
