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
use ergopath::training::{SimulatedMovements, motion_text};
use std::path::Path;
use std::process::ExitCode;

const REACHES: usize = 16;
const SEED: u64 = 20;
const SIDE: Side = Side::Right;

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
    let movements = SimulatedMovements::new(&body, SIDE, SEED)?;
    let joints = movements.joints();
    let reaches = movements.first(REACHES)?;
    let trials: Vec<_> = reaches.into_iter().map(|r| (r.times_s, r.postures)).collect();
    write_whole(out, motion_text(&COMMENTS, &joints, &trials).as_bytes())
}
