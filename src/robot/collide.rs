//! Does the arm touch itself, and how near does it come to itself and to obstacles?
//!
//! Two links are compared when they belong to different rigid bodies that no single joint connects. As
//! capsules are fatter than links, some of these pairs overlap in (nearly) every posture; they are
//! found once by sampling the joint ranges, as set-up assistants do, and left out by name. Neighbours but
//! one that never touch in any sample are kept apart by the joint between them, and left out too. Capsules
//! that were fitted to meshes are fatter still: what touches at home with one of them, where no real arm touches
//! itself, is left out by name as well. Assumed capsules are too coarse to be compared with each other at all.

use super::body::{Part, Placer};
use super::check::RobotMotion;
use super::clearance::Obstacle;
use super::description::{Limits, Robot};
use super::grade::Judge;
use super::link_shapes::Known;
use crate::math::Vec3;
use crate::math::segment::segment_distance;
use crate::math::stream::{Purpose, stream};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Postures sampled, and the share of them in which a pair of links may touch before it counts as
/// touching always.
const SAMPLES: u32 = 500;
const ALWAYS: f64 = 0.95;
/// Block of random numbers, away from those of the start postures.
const BLOCK: u32 = 1 << 20;

/// Where an arm comes nearest to itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SelfNearest {
    /// Signed distance of the two capsules, m; zero or below when touching.
    pub distance_m: f64,
    /// The two links.
    pub links: [String; 2],
    /// When, s; 0 for a single posture.
    pub time_s: f64,
}

/// Pairs of parts that are compared, and pairs of links that are left out because they always touch.
#[derive(Debug, Clone, Default)]
pub(super) struct SelfPairs {
    pub(super) checked: Vec<(usize, usize)>,
    pub(super) left_out: Vec<(String, String)>,
}

/// Signed distance between two placed parts, m.
fn distance(robot: &Robot, ends: &[[Vec3; 2]], (i, j): (usize, usize)) -> f64 {
    let [a, b] = [&ends[i], &ends[j]];
    let between = segment_distance([&a[0], &a[1]], [&b[0], &b[1]]);
    between - robot.parts[i].radius - robot.parts[j].radius
}

/// A lower bound of that distance from balls around the parts; cheap.
fn bound(robot: &Robot, ends: &[[Vec3; 2]], (i, j): (usize, usize)) -> f64 {
    let [a, b] = [&ends[i], &ends[j]];
    let apart = (a[0] + a[1] - b[0] - b[1]).norm();
    0.5 * (apart - (a[1] - a[0]).norm() - (b[1] - b[0]).norm())
        - robot.parts[i].radius
        - robot.parts[j].radius
}

impl SelfPairs {
    /// Finds the pairs of a robot whose pairs are not known yet.
    pub(super) fn find(robot: &Robot) -> Self {
        let parts = &robot.parts;
        let joined = |a: &Part, b: &Part| {
            a.body == b.body
                || (a.parent == b.body && a.body != 0)
                || (b.parent == a.body && b.body != 0)
        };
        let mut all = Vec::new();
        for i in 0..parts.len() {
            let is_vague = |j: usize| [i, j].iter().any(|&p| parts[p].known == Known::Assumed);
            let others =
                (i + 1..parts.len()).filter(|&j| !joined(&parts[i], &parts[j]) && !is_vague(j));
            all.extend(others.map(|j| (i, j)));
        }
        let touching = touching_shares(robot, &all);
        let at_home = touching_at_home(robot, &all);
        let near = |a: &Part, b: &Part| {
            let above = |p: &Part| parts.iter().find(|x| x.body == p.parent).map(|x| x.parent);
            (above(a) == Some(b.body) && a.parent != 0)
                || (above(b) == Some(a.body) && b.parent != 0)
        };
        let is_checked = |&(i, j): &(usize, usize)| {
            let key = (&parts[i].link, &parts[j].link);
            let share = touching.iter().find(|(a, b, _)| (*a, *b) == key).map_or(0.0, |t| t.2);
            let is_free = share < ALWAYS && !at_home.contains(&key);
            is_free && (share > 0.0 || !near(&parts[i], &parts[j]))
        };
        let is_left_out =
            |t: &&(&String, &String, f64)| t.2 >= ALWAYS || at_home.contains(&(t.0, t.1));
        let left_out = touching.iter().filter(is_left_out);
        Self {
            left_out: left_out.map(|(a, b, _)| ((*a).clone(), (*b).clone())).collect(),
            checked: all.iter().copied().filter(is_checked).collect(),
        }
    }
}

/// The pairs of links that touch at home with a capsule that was fitted.
fn touching_at_home<'r>(
    robot: &'r Robot,
    pairs: &[(usize, usize)],
) -> Vec<(&'r String, &'r String)> {
    let mut placer = Placer::new(robot);
    placer.place(&robot.home);
    let touches = |&&(i, j): &&(usize, usize)| {
        (robot.parts[i].known == Known::Fitted || robot.parts[j].known == Known::Fitted)
            && distance(robot, &placer.ends, (i, j)) <= 0.0
    };
    let names = |&(i, j): &(usize, usize)| (&robot.parts[i].link, &robot.parts[j].link);
    pairs.iter().filter(touches).map(names).collect()
}

/// For each pair of links the share of sampled postures in which they touch.
fn touching_shares<'r>(
    robot: &'r Robot,
    pairs: &[(usize, usize)],
) -> Vec<(&'r String, &'r String, f64)> {
    // Parts of one link follow each other, but pairs of links come mixed.
    let mut links: Vec<(&String, &String, u32)> = Vec::new();
    let mut of_pair = Vec::with_capacity(pairs.len());
    for &(i, j) in pairs {
        let key = (&robot.parts[i].link, &robot.parts[j].link);
        let at = links.iter().position(|l| (l.0, l.1) == key).unwrap_or_else(|| {
            links.push((key.0, key.1, 0));
            links.len() - 1
        });
        of_pair.push(at);
    }
    let mut placer = Placer::new(robot);
    for sample in 0..SAMPLES {
        placer.place(&random_posture(&robot.limits, 0, BLOCK, sample));
        let mut touches = vec![false; links.len()];
        for (&pair, &at) in pairs.iter().zip(&of_pair) {
            touches[at] |= !touches[at]
                && bound(robot, &placer.ends, pair) <= 0.0
                && distance(robot, &placer.ends, pair) <= 0.0;
        }
        links.iter_mut().zip(touches).for_each(|(l, t)| l.2 += u32::from(t));
    }
    links.into_iter().map(|(a, b, n)| (a, b, f64::from(n) / f64::from(SAMPLES))).collect()
}

/// A random posture within the limits; joints without end turn within half a turn.
pub(super) fn random_posture(limits: &Limits, seed: u64, block: u32, index: u32) -> Vec<f64> {
    let mut rng = stream(seed, Purpose::RobotIk, block, index);
    let joints = limits.lower.iter().zip(&limits.upper);
    joints
        .map(|(&lower, &upper)| {
            // Beyond half a turn the same poses come again.
            let (low, high) = (lower.max(-PI).min(upper), upper.min(PI).max(lower));
            low + (high - low) * rng.random::<f64>()
        })
        .collect()
}

impl Placer<'_> {
    /// Smallest distance of the arm to itself where the capsules are, and which pair has it, if it is
    /// below `below`.
    pub(super) fn nearest_self(&self, below: f64) -> Option<(f64, (usize, usize))> {
        let mut best: Option<(f64, (usize, usize))> = None;
        for &pair in &self.robot.self_pairs.checked {
            let least = best.map_or(below, |b| b.0);
            if bound(self.robot, &self.ends, pair) < least {
                let d = distance(self.robot, &self.ends, pair);
                if d < least {
                    best = Some((d, pair));
                }
            }
        }
        best
    }

    /// Smallest distance of the moving links to obstacles where the capsules are, with part and
    /// obstacle, if it is below `below`.
    pub(super) fn nearest_obstacle(
        &self,
        obstacles: &[(String, Obstacle)],
        below: f64,
    ) -> Option<(f64, usize, usize)> {
        let mut best: Option<(f64, usize, usize)> = None;
        for (i, (part, [a, b])) in self.robot.parts.iter().zip(&self.ends).enumerate() {
            for (k, (_, obstacle)) in obstacles.iter().enumerate().filter(|_| part.is_moving) {
                let least = best.map_or(below, |b| b.0);
                // The signed distance changes by at most the way gone.
                let middle = obstacle.least_distance(&(0.5 * (a + b)));
                if middle - 0.5 * (b - a).norm() - part.radius < least {
                    let d = obstacle.distance_to_capsule(a, b, part.radius);
                    if d < least {
                        best = Some((d, i, k));
                    }
                }
            }
        }
        best
    }
}

/// Sets what a motion at times (s) lacks, and how near it comes to itself and to obstacles.
pub fn measure_room(
    robot: &Robot,
    time_s: &[f64],
    motion: &mut RobotMotion,
    obstacles: &[(String, Obstacle)],
) {
    Judge::new(robot, obstacles).grade(time_s, motion);
}

/// Where the arm is nearest to itself along postures at times (s); `None` when nothing is checked.
pub fn self_clearance(robot: &Robot, time_s: &[f64], q: &[Vec<f64>]) -> Option<SelfNearest> {
    let mut placer = Placer::new(robot);
    let mut best: Option<(f64, (usize, usize), f64)> = None;
    for (posture, &t) in q.iter().zip(time_s) {
        placer.place(posture);
        if let Some((d, pair)) = placer.nearest_self(best.map_or(f64::INFINITY, |b| b.0)) {
            best = Some((d, pair, t));
        }
    }
    best.map(|(distance_m, (i, j), time_s)| {
        let links = [robot.parts[i].link.clone(), robot.parts[j].link.clone()];
        SelfNearest { distance_m, links, time_s }
    })
}

#[cfg(test)]
mod tests {
    use super::super::body::capsules;
    use super::*;
    use crate::robot::{NotChecked, SelfCheck};

    fn nearest(robot: &Robot, q: &[f64]) -> SelfNearest {
        self_clearance(robot, &[0.0], &[q.to_vec()]).unwrap()
    }

    #[test]
    fn folded_arms_touch_and_home_is_free() {
        for name in super::super::PRESETS {
            let robot = Robot::preset(name).unwrap();
            let free = nearest(&robot, &robot.home);
            assert!(free.distance_m > 0.03, "{name}: {free:?}");
            let folded: &[&[f64]] = match name {
                // Forearm on to the shoulder; hand on to the upper arm.
                _ if robot.dof() == 7 => {
                    &[&[0.0, 1.7, 0.0, -3.0, 0.0, 1.6, 0.8], &[0.0, 0.0, 0.0, -3.0, 0.0, 0.6, 0.8]]
                }
                // Wrist back to the base; forearm down along the upper arm.
                "crb15000" => &[&[0.0, 1.0, 1.48, 0.0, 0.0, 0.0]],
                "crx10ial" => &[&[0.0, 0.0, -1.5, 0.0, 0.0, 0.0]],
                // Forearm back along the upper arm.
                _ => &[&[0.0, -1.57, 2.9, 0.0, 0.0, 0.0], &[0.0, -1.57, 2.9, 1.57, 1.57, 0.0]],
            };
            for q in folded {
                let near = nearest(&robot, q);
                assert!(near.distance_m < -0.05, "{name} {q:?}: {near:?}");
            }
        }
    }

    #[test]
    fn the_smallest_distance_is_that_of_a_plain_loop() {
        for name in super::super::PRESETS {
            let robot = Robot::preset(name).unwrap();
            for sample in 0..40 {
                let q = random_posture(&robot.limits, 3, 0, sample);
                let all = capsules(&robot, &q);
                let of = |&(i, j): &(usize, usize)| {
                    let (a, b): (&super::super::Capsule, _) = (&all[i], &all[j]);
                    let obstacle = Obstacle::Capsule { a: a.a, b: a.b, radius: a.radius };
                    // By golden section instead of the closed form.
                    obstacle.distance_to_capsule(&b.a, &b.b, b.radius)
                };
                let plain = robot.self_pairs.checked.iter().map(of).fold(f64::INFINITY, f64::min);
                let own = nearest(&robot, &q).distance_m;
                assert!((own - plain).abs() < 1e-7, "{name} {sample}: {own} {plain}");
            }
        }
    }

    #[test]
    fn neighbours_and_what_always_touches_are_left_out() {
        let robot = Robot::preset("panda").unwrap();
        let links = |(i, j): &(usize, usize)| [&robot.parts[*i].link, &robot.parts[*j].link];
        let has = |a: &str, b: &str| robot.self_pairs.checked.iter().any(|p| links(p) == [a, b]);
        assert!(has("panda_link1", "panda_hand") && has("panda_link5", "panda_hand"));
        assert!(!has("panda_link1", "panda_link2") && !has("panda_link7", "panda_hand"));
        assert!(!has("panda_link5", "panda_link7") && !has("panda_link1", "panda_link3"));
        let check = robot.self_check();
        let SelfCheck::Checked { pairs: 21, left_out } = &check else { panic!("{check:?}") };
        assert!(left_out.contains(&["panda_link5".to_owned(), "panda_link7".to_owned()]));
    }

    #[test]
    fn a_urdf_without_shapes_says_so() {
        let text = r#"<robot name="one"><link name="base"/><link name="arm"/>
            <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/>
            <origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint></robot>"#;
        let file = std::path::Path::new("one.urdf");
        let robot = Robot::from_text(file, text, "base", "arm").unwrap();
        let why = NotChecked::NoShapes;
        assert_eq!(robot.self_check(), SelfCheck::NotChecked { why });
        assert!(self_clearance(&robot, &[0.0], &[vec![0.0]]).is_none());
    }
}
