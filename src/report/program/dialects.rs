//! The words of each language. Every program begins with comments that say what it is.

use super::Language;
use crate::robot::{JointTrajectory, Move, Moves, Stream};
use std::fmt::Write as _;

/// Largest radius within which a UR controller rounds a corner, m, and its share of the shorter way beside it.
const BLEND_M: f64 = 0.005;
const BLEND_SHARE: f64 = 0.3;
/// No radius below this, m: the controller stops there.
const LEAST_BLEND_M: f64 = 1e-4;

/// What the controller does at the points, in a sentence.
pub(super) fn corners(language: Language) -> &'static str {
    match language {
        Language::UrScript => {
            "the controller rounds each corner within the radius r of its line (m), at most 5 mm; this comes on top"
        }
        Language::Krl => {
            "the controller passes through every point on a spline of its own; its way between them was not checked"
        }
        _ => "the controller rounds each corner within the zone z1 (1 mm); this comes on top",
    }
}

/// A program of moves.
pub(super) fn moves(language: Language, says: &[String], moves: &Moves) -> String {
    match language {
        Language::Krl => krl(says, moves),
        Language::Rapid => rapid(says, moves),
        _ => urscript(says, moves),
    }
}

fn comments(out: &mut String, sign: &str, says: &[String]) {
    for line in says {
        let _ = writeln!(out, "{sign} {line}");
    }
}

fn list(q: &[f64], decimals: usize) -> String {
    let all: Vec<String> = q.iter().map(|v| fixed(*v, decimals)).collect();
    all.join(", ")
}

fn degrees(q: &[f64]) -> Vec<f64> {
    q.iter().map(|v| v.to_degrees()).collect()
}

/// Without a negative zero.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        _ => text,
    }
}

fn urscript(says: &[String], program: &Moves) -> String {
    let mut out = String::new();
    comments(&mut out, "#", says);
    out.push_str("def ergopath_path():\n  # Slowly to the start.\n");
    let _ = writeln!(out, "  movej([{}], a=0.5, v=0.2)", list(&program.start, 6));
    let way = |m: Option<&Move>| match m {
        Some(Move::To { way_m, .. }) => *way_m,
        _ => 0.0,
    };
    for (k, step) in program.moves.iter().enumerate() {
        match step {
            Move::To { q, seconds, way_m } => {
                let shorter = way_m.min(way(program.moves.get(k + 1)));
                let radius = (BLEND_SHARE * shorter).min(BLEND_M);
                let radius = if radius < LEAST_BLEND_M { 0.0 } else { radius };
                let radius = fixed((radius * 1e4).floor() / 1e4, 4);
                let _ = writeln!(out, "  movej([{}], t={seconds:.4}, r={radius})", list(q, 6));
            }
            Move::Rest { seconds } => {
                let _ = writeln!(out, "  sleep({seconds:.4})");
            }
        }
    }
    out.push_str("end\n");
    out
}

fn krl(says: &[String], program: &Moves) -> String {
    let axes = |q: &[f64]| {
        let all: Vec<String> = degrees(q)
            .iter()
            .enumerate()
            .map(|(i, v)| format!("A{} {}", i + 1, fixed(*v, 4)))
            .collect();
        all.join(", ")
    };
    let mut out = String::from("&ACCESS RVP\n&REL 1\nDEF ERGOPATH_PATH()\n");
    comments(&mut out, ";", says);
    out.push_str("BAS(#INITMOV, 0)\n; Slowly to the start.\nBAS(#VEL_PTP, 10)\n");
    let _ = writeln!(out, "PTP {{{}}}", axes(&program.start));
    for run in program.moves.chunk_by(|a, b| matches!((a, b), (Move::To { .. }, Move::To { .. }))) {
        let whole: f64 = run
            .iter()
            .map(|m| match m {
                Move::To { seconds, .. } | Move::Rest { seconds } => *seconds,
            })
            .sum();
        if let [Move::Rest { .. }] = run {
            let _ = writeln!(out, "WAIT SEC {whole:.4}");
            continue;
        }
        out.push_str("PTP_SPLINE\n  TIME_BLOCK START\n");
        for (k, step) in run.iter().enumerate() {
            let Move::To { q, seconds, .. } = step else { continue };
            let _ = writeln!(out, "  SPTP {{{}}}", axes(q));
            let _ = writeln!(out, "  TIME_BLOCK PART = {:.6}", 100.0 * seconds / whole);
            if k + 1 == run.len() {
                let _ = writeln!(out, "  TIME_BLOCK END = {whole:.4}");
            }
        }
        out.push_str("ENDSPLINE\n");
    }
    out.push_str("END\n");
    out
}

fn rapid(says: &[String], program: &Moves) -> String {
    let target =
        |q: &[f64]| format!("[[{}], [9E9, 9E9, 9E9, 9E9, 9E9, 9E9]]", list(&degrees(q), 4));
    let mut out = String::from("MODULE ErgopathPath\n");
    comments(&mut out, "  !", says);
    out.push_str("  PROC ErgopathPath()\n    ! Slowly to the start.\n");
    let _ = writeln!(out, "    MoveAbsJ {} \\NoEOffs, v50, fine, tool0;", target(&program.start));
    for (k, step) in program.moves.iter().enumerate() {
        match step {
            Move::To { q, seconds, .. } => {
                let goes_on = matches!(program.moves.get(k + 1), Some(Move::To { .. }));
                let zone = if goes_on { "z1" } else { "fine" };
                let _ = writeln!(
                    out,
                    "    MoveAbsJ {} \\NoEOffs, v1000 \\T:={seconds:.4}, {zone}, tool0;",
                    target(q)
                );
            }
            Move::Rest { seconds } => {
                let _ = writeln!(out, "    WaitTime {seconds:.4};");
            }
        }
    }
    out.push_str("  ENDPROC\nENDMODULE\n");
    out
}

/// A table of rows.
pub(super) fn rows(says: &[String], stream: &Stream) -> String {
    let mut out = String::new();
    comments(&mut out, "#", says);
    let joints = stream.rows.first().map_or(0, Vec::len);
    out.push_str("time_s");
    for j in 1..=joints {
        let _ = write!(out, ",q{j}_rad");
    }
    out.push('\n');
    for (k, row) in stream.rows.iter().enumerate() {
        let _ = write!(out, "{:.3}", k as f64 * stream.period_s);
        for value in row {
            let _ = write!(out, ",{}", fixed(*value, 9));
        }
        out.push('\n');
    }
    out
}

/// The ROS message as YAML.
pub(super) fn ros(
    says: &[String],
    motion: &JointTrajectory,
) -> Result<String, serde_saphyr::ser::Error> {
    let mut out = String::new();
    comments(&mut out, "#", says);
    out.push_str(&serde_saphyr::to_string(motion)?);
    Ok(out)
}
