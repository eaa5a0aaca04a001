//! A BVH file wherever a recording may be given.

use crate::common::ergopath;
use predicates::prelude::*;
use predicates::str::contains;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// An upper body of made-up offsets (cm) whose right arm is raised and lowered: 3 s at 50 Hz.
fn lift(folder: &Path) -> PathBuf {
    let mut text = String::from(
        "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\n\
         CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n\
         JOINT Chest\n{\nOFFSET 0 20 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n\
         JOINT Head\n{\nOFFSET 0 32 0\nEnd Site\n{\nOFFSET 0 15 0\n}\n}\n",
    );
    for (side, sign) in [("Left", 1.0), ("Right", -1.0)] {
        for (joint, x, y) in [
            ("Collar", 3.0, 20.0),
            ("Shoulder", 14.0, 0.0),
            ("Elbow", 28.0, 0.0),
            ("Wrist", 25.0, 0.0),
        ] {
            let _ = writeln!(
                text,
                "JOINT {side}{joint}\n{{\nOFFSET {} {y} 0\nCHANNELS 3 Zrotation Xrotation Yrotation",
                sign * x
            );
        }
        let _ = writeln!(text, "End Site\n{{\nOFFSET {} 0 0\n}}\n}}\n}}\n}}\n}}", sign * 8.0);
    }
    text += "}\n}\nMOTION\nFrames: 150\nFrame Time: 0.02\n";
    for i in 0..150 {
        let raised = 30.0 * (1.0 - (f64::from(i) * 0.08).cos());
        let still = "0 0 0 ".repeat(2);
        let left = "0 0 0 -75 0 0 0 0 0 0 0 0 ";
        // The right arm hangs, comes forwards and bends.
        let right = format!("0 0 0 75 0 {raised} 0 0 {raised} 0 0 0");
        let _ = writeln!(text, "0 95 0 {still}{left}{right}");
    }
    let path = folder.join("lift.bvh");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_bvh_file_is_explained_and_scored() {
    let room = tempfile::tempdir().unwrap();
    let path = lift(room.path());
    ergopath().arg("check").arg(&path).assert().success().stdout(
        contains("a recording (BVH)")
            .and(contains("150 frames at 50 Hz: 3.0 s"))
            .and(contains("lengths taken as cm"))
            .and(contains("no joint for L5, L3, T12, Neck")),
    );
    let out = room.path().join("scored");
    ergopath()
        .args(["score", "--body", "female_p50", "--load-kg", "2", "-o"])
        .arg(&out)
        .arg(&path)
        .assert()
        .success();
    assert!(out.is_dir());
}

#[test]
fn marker_files_and_pickings_are_refused_in_words() {
    let room = tempfile::tempdir().unwrap();
    let markers = room.path().join("lift.c3d");
    std::fs::write(&markers, b"x").unwrap();
    let check = ergopath().arg("check").arg(&markers).assert().code(2);
    check.stderr(contains("holds markers").and(contains("BVH")));
    let path = lift(room.path());
    let score = ergopath()
        .args(["score", "--body", "female_p50", "--person", "ann", "-o"])
        .arg(room.path().join("scored"))
        .arg(&path)
        .assert()
        .code(2);
    score.stderr(contains("leave the person out for .bvh files"));
}
