//! Kinematics against an independent crate and against finite differences, on every URDF at hand.

use crate::skips::shared;
use ergopath::kinematics::{Frames, Linkage, Model, Tip, read_urdf};
use ergopath::math::stream::{Purpose, stream};
use ergopath::math::{Pose, Vec3};
use rand::RngExt;
use std::path::{Path, PathBuf};

/// All URDFs of a folder and its sub-folders.
fn urdfs(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let Ok(entries) = folder.read_dir() else { return found };
    for entry in entries {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(urdfs(&path));
        } else if path.extension().is_some_and(|x| x == "urdf") {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn all_urdfs() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = urdfs(&root.join("models"));
    // The shipped ones are tried in any case.
    for folder in ["models", "toy5r"] {
        found.extend(shared(folder).iter().flat_map(|f| urdfs(f)));
    }
    found
}

fn leaves(model: &Model) -> Vec<&str> {
    let is_parent = |i: usize| model.joints.iter().any(|j| j.parent == i);
    (0..model.links.len())
        .filter(|&i| !is_parent(i))
        .map(|i| model.links[i].name.as_str())
        .collect()
}

fn random_posture(linkage: &Linkage, index: u32) -> Vec<f64> {
    let mut rng = stream(11, Purpose::Simulation, 0, index);
    let draw = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let mut draw = draw;
    linkage.joints().iter().map(|j| draw(j.lower.max(-3.0), j.upper.min(3.0))).collect()
}

#[test]
fn agrees_with_an_independent_implementation() {
    let (mut chains, mut worst) = (0, 0.0f64);
    for file in all_urdfs() {
        let model = read_urdf(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let peer = k::Chain::<f64>::from_urdf_file(&file).unwrap();
        for leaf in leaves(&model) {
            let linkage = Linkage::chain(&model, model.root(), leaf).unwrap();
            let end = peer.find_link(leaf).unwrap();
            let serial = k::SerialChain::from_end(end);
            // The peer counts mimic joints as columns; those chains are left to finite differences.
            if linkage.dof() == 0 || serial.dof() != linkage.dof() {
                continue;
            }
            chains += 1;
            for index in 0..5 {
                let q = random_posture(&linkage, index);
                let mut frames = Frames::default();
                linkage.forward(&q, &mut frames);
                let pose = linkage.tip_pose(&frames, 0);
                let jacobian = linkage.jacobian(&frames, 0);
                serial.set_joint_positions_unchecked(&q);
                serial.update_transforms();
                let other = serial.end_transform();
                let p: Vec<f64> = other.translation.vector.iter().copied().collect();
                let r = other.rotation.to_rotation_matrix();
                for i in 0..3 {
                    worst = worst.max((p[i] - pose.translation.vector[i]).abs());
                    for j in 0..3 {
                        let own = pose.rotation.to_rotation_matrix()[(i, j)];
                        worst = worst.max((r[(i, j)] - own).abs());
                    }
                }
                let other = k::jacobian(&serial);
                for i in 0..6 {
                    for j in 0..linkage.dof() {
                        worst = worst.max((other[(i, j)] - jacobian[(i, j)]).abs());
                    }
                }
                assert!(worst < 1e-9, "{} {leaf}: {worst:e}", file.display());
            }
        }
    }
    eprintln!("{chains} chains, largest difference {worst:.1e}");
}

#[test]
fn jacobians_are_derivatives_of_poses() {
    let h = 1e-6;
    for file in all_urdfs() {
        let model = read_urdf(&file).unwrap();
        let offset = Pose::new(Vec3::new(0.1, -0.2, 0.05), Vec3::new(0.3, 0.2, -0.4));
        let tips: Vec<Tip> = leaves(&model)
            .into_iter()
            .take(4)
            .map(|l| Tip { link: l.to_owned(), offset })
            .collect();
        let linkage = Linkage::new(&model, model.root(), &tips).unwrap();
        let q = random_posture(&linkage, 9);
        let mut frames = Frames::default();
        linkage.forward(&q, &mut frames);
        let stacked = linkage.stacked_jacobian(&frames);
        for column in 0..linkage.dof() {
            let at = |step: f64| {
                let mut moved = q.clone();
                moved[column] += step;
                let mut frames = Frames::default();
                linkage.forward(&moved, &mut frames);
                (0..tips.len()).map(|t| linkage.tip_pose(&frames, t)).collect::<Vec<_>>()
            };
            let (low, high) = (at(-h), at(h));
            for tip in 0..tips.len() {
                let change = ergopath::math::pose::pose_error(&low[tip], &high[tip]) / (2.0 * h);
                for row in 0..6 {
                    let own = stacked[(6 * tip + row, column)];
                    let far = (change[row] - own).abs();
                    assert!(far < 1e-7, "{} column {column} row {row}: {far:e}", file.display());
                }
            }
        }
    }
}

#[test]
fn a_base_below_the_root_gives_poses_in_its_own_frame() {
    let Some(file) = shared("models/robots/panda.urdf") else { return };
    let model = read_urdf(&file).unwrap();
    let whole = Linkage::chain(&model, "panda_link0", "panda_hand_tcp").unwrap();
    let upper = Linkage::chain(&model, "panda_link0", "panda_link3").unwrap();
    let rest = Linkage::chain(&model, "panda_link3", "panda_hand_tcp").unwrap();
    let q = [0.1, 0.2, -0.3, -1.2, 0.5, 1.6, 0.7];
    let pose = |l: &Linkage, q: &[f64]| {
        let mut frames = Frames::default();
        l.forward(q, &mut frames);
        l.tip_pose(&frames, 0)
    };
    let joined = pose(&upper, &q[..3]) * pose(&rest, &q[3..]);
    let direct = pose(&whole, &q);
    assert!((joined.translation.vector - direct.translation.vector).norm() < 1e-12);
    assert!(joined.rotation.angle_to(&direct.rotation) < 1e-9);
    let wrong = Linkage::chain(&model, "panda_link5", "panda_link2").unwrap_err().to_string();
    assert!(wrong.contains("not an ancestor"), "{wrong}");
    let typo = Linkage::chain(&model, "panda_link0", "panda_hand_tpc").unwrap_err().to_string();
    assert!(typo.contains("did you mean `panda_hand_tcp`"), "{typo}");
}
