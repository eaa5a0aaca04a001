//! The law of the head against five recorded people, where they are at hand.

#![allow(clippy::print_stdout, reason = "says the figures it judges")]

use crate::human::{Head, Side};
use crate::math::{Pose, Vec3, stats};
use crate::recording;
use crate::skips::shared;
use crate::survey::{HeadDraw, NeckRule, Sight};
use std::collections::{BTreeMap, BTreeSet};

/// One posture: flexion and turn of the head as recorded, and by each rule (deg).
struct Seen {
    person: String,
    task: String,
    /// Height of the hand in lengths of the leg, inclination of the thorax and flexion of a knee (deg).
    hand: f64,
    inclination: f64,
    knee: f64,
    recorded: [f64; 2],
    rules: [[f64; 2]; 3],
}

const RULES: [NeckRule; 3] = [NeckRule::Predicted, NeckRule::Neutral, NeckRule::Gaze];

/// Every fifteenth of a second of all motions.
fn seen() -> Option<Vec<Seen>> {
    let folder = shared("recordings/hdm05")?;
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|x| x == "amc"));
    paths.sort();
    let mut all = Vec::new();
    let degrees = |h: Head| [h.flexion.to_degrees(), h.turn.to_degrees()];
    for path in paths {
        let r = recording::read(&path, None).unwrap();
        let words: Vec<String> = r.source.split('_').map(str::to_owned).collect();
        let leg = r.length_m("RightUpperLeg").unwrap() + r.length_m("RightLowerLeg").unwrap();
        for frame in (0..r.frames()).step_by(8) {
            let at = |name: &str| r.segment(name).unwrap().position[frame];
            let turn = |name: &str| r.segment(name).unwrap().rotation[frame];
            let thorax = Pose::from_parts(at("T8").into(), turn("T8"));
            let inclination = (turn("T8") * Vec3::y()).angle(&Vec3::z());
            let sight = Sight::new(
                &thorax.rotation.to_rotation_matrix(),
                &at("Head"),
                &at("RightHand"),
                inclination,
            );
            let mean = HeadDraw::mean(Some(Side::Right));
            let [hip, knee, foot] = ["RightUpperLeg", "RightLowerLeg", "RightFoot"].map(at);
            all.push(Seen {
                person: words[1].clone(),
                task: words[2].clone(),
                hand: at("RightHand").z / leg,
                inclination: inclination.to_degrees(),
                knee: (knee - hip).angle(&(foot - knee)).to_degrees(),
                recorded: degrees(Head::of(&(turn("T8").inverse() * turn("Head")))),
                rules: RULES.map(|rule| degrees(sight.head(rule, &mean))),
            });
        }
    }
    Some(from_upright(all))
}

/// Recorded heads from each person's own neutral: the median of the most upright postures.
fn from_upright(mut all: Vec<Seen>) -> Vec<Seen> {
    let people: BTreeSet<String> = all.iter().map(|s| s.person.clone()).collect();
    for person in people {
        let of = || all.iter().filter(|s| s.person == person);
        let leans: Vec<f64> = of().map(|s| s.inclination).collect();
        let least = stats::quantile(&leans, 0.15);
        let upright = || of().filter(|s| s.inclination < least && s.knee < 45.0);
        let neutral = [0, 1]
            .map(|k| stats::quantile(&upright().map(|s| s.recorded[k]).collect::<Vec<_>>(), 0.5));
        for s in all.iter_mut().filter(|s| s.person == person) {
            s.recorded[0] -= neutral[0];
            s.recorded[1] -= neutral[1];
        }
    }
    all
}

/// Mean of a value over postures, each person and task alike.
fn mean(seen: &[&Seen], value: impl Fn(&Seen) -> f64) -> f64 {
    let mut groups: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    for s in seen {
        groups.entry((&s.person, &s.task)).or_default().push(value(s));
    }
    stats::mean(&groups.values().map(|v| stats::mean(v)).collect::<Vec<_>>())
}

#[test]
fn the_head_is_predicted_nearer_than_by_either_rule() {
    let Some(all) = seen() else { return };
    let led: Vec<&Seen> = all.iter().filter(|s| !s.task.starts_with("squat")).collect();
    let rms =
        |k: usize, rule: usize| mean(&led, |s| (s.recorded[k] - s.rules[rule][k]).powi(2)).sqrt();
    let flexion = [0, 1, 2].map(|rule| rms(0, rule));
    let turn = [0, 1, 2].map(|rule| rms(1, rule));
    println!("rms of flexion {flexion:.1?}, of turn {turn:.1?}: predicted, in line, to the hand");
    assert!(flexion[0] < 14.0 && flexion[0] + 2.0 < flexion[1] && flexion[1] < flexion[2]);
    assert!(turn[0] < 14.0 && turn[0] + 2.0 < turn[1]);
    // Where a bench is: upright, with the hand between hip and shoulder.
    let bench: Vec<&Seen> = (led.iter().copied())
        .filter(|s| (1.0..1.6).contains(&s.hand) && s.inclination < 25.0)
        .collect();
    let [recorded, predicted] = [mean(&bench, |s| s.recorded[0]), mean(&bench, |s| s.rules[0][0])];
    println!("flexion at a bench: recorded {recorded:.1}, predicted {predicted:.1} deg");
    assert!(bench.len() > 300 && (recorded - predicted).abs() < 5.0);
}
