//! Where a robot is in a posture: TCP, stick figure, capsules around its links, and what follows
//! from them: clearance and distance from singular postures.

use super::clearance::Obstacle;
use super::collide::random_posture;
use super::description::{Robot, tips};
use super::link_shapes::{Known, LinkCapsule};
use crate::kinematics::{Frames, JointKind, Linkage, LinkageError, Model, Shape};
use crate::math::{Pose, Vec3};
use nalgebra::{Matrix3, Matrix6, Matrix6xX};
use serde::{Deserialize, Serialize};

/// Length by which a rotation counts as a displacement, m: about half a forearm.
pub(super) const ROTATION_SCALE_M: f64 = 0.3;

/// Joints before the TCP whose links may be the wrist, and how far from the TCP a wrist reaches at
/// most, m: a hand that holds the tool and its forearm are beside it.
const WRIST_JOINTS: usize = 3;
const WRIST_REACH_M: f64 = 0.32;
/// Postures by which that is found.
const WRIST_SAMPLES: u32 = 200;
const WRIST_BLOCK: u32 = 1 << 22;

/// Keeps joint rates finite in singular postures, m^2.
const RATE_DAMPING: f64 = 1e-6;

/// A capsule fixed to a link: all points within `radius` of the segment from `a` to `b`.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub(super) link: String,
    /// Tip of the skeleton that is this link's frame.
    tip: usize,
    a: Vec3,
    b: Vec3,
    pub(super) radius: f64,
    pub(super) is_moving: bool,
    /// Rigid body that the link belongs to: 0 the base, else one more than the index of the moving
    /// joint above it; and the body that this one hangs on.
    pub(super) body: usize,
    pub(super) parent: usize,
    /// True when one of the last joints before the TCP moves it.
    pub(super) is_late: bool,
    /// True when it is late and never far from the TCP; set by [`mark_wrist`].
    is_wrist: bool,
    pub(super) known: Known,
}

#[cfg(test)]
impl Part {
    /// The capsule in the frame of its link.
    pub(super) fn ends(&self) -> LinkCapsule {
        (self.a, self.b, self.radius)
    }
}

/// A capsule around a link of a robot in some posture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule<'r> {
    /// Name of the link.
    pub link: &'r str,
    /// One end of the axis in the world, m.
    pub a: Vec3,
    /// The other end, m.
    pub b: Vec3,
    /// Radius, m.
    pub radius: f64,
    /// False for a link that no joint moves.
    pub is_moving: bool,
}

/// The smallest distance between a robot and obstacles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Nearest {
    /// Distance, m; zero or below when touching.
    pub distance_m: f64,
    /// Link of the robot.
    pub link: String,
    /// Name of the obstacle.
    pub obstacle: String,
}

/// The skeleton (tip 0 the TCP, then the frames of the moving joints, then the links with shapes)
/// and the capsules on it: those of simple shapes, and `more` by link. Links that do not hang below the
/// base are left out.
pub(super) fn parts(
    model: &Model,
    base: &str,
    tcp: &str,
    more: &[Vec<(LinkCapsule, Known)>],
) -> Result<(Linkage, Vec<Part>), LinkageError> {
    let chain = Linkage::chain(model, base, tcp)?;
    let child = |name: &str| {
        let joint = model.joints.iter().find(|j| j.name == name);
        joint.map(|j| model.links[j.child].name.as_str())
    };
    let mut names = vec![tcp];
    names.extend(chain.joints().iter().filter_map(|j| child(&j.name)));
    let late: Vec<&str> =
        chain.joints().iter().rev().take(WRIST_JOINTS).map(|j| j.name.as_str()).collect();
    let mut parts = Vec::new();
    for (link, more) in model.links.iter().zip(more) {
        if link.shapes.is_empty() && more.is_empty() {
            continue;
        }
        let Ok(to_link) = Linkage::chain(model, base, &link.name) else { continue };
        let simple = link.shapes.iter().map(|(x, s)| capsule(x, s));
        let own: Vec<LinkCapsule> = simple.chain(more.iter().map(|(c, _)| *c)).collect();
        for (i, &(a, b, radius)) in own.iter().enumerate() {
            // The end balls that standard URDF needs are part of the capsule already.
            let is_end = |&(c, d, r): &LinkCapsule| {
                c != d && (r - radius).abs() < 1e-9 && (c - a).norm().min((d - a).norm()) < 1e-6
            };
            if a == b && own.iter().enumerate().any(|(k, other)| k != i && is_end(other)) {
                continue;
            }
            let (name, tip, is_moving) = (link.name.clone(), names.len(), to_link.dof() > 0);
            let (body, parent) = bodies(model, base, &link.name);
            let is_late = to_link.joints().iter().any(|j| late.contains(&j.name.as_str()));
            let is_wrist = false;
            let more = i.checked_sub(link.shapes.len()).and_then(|i| more.get(i));
            let known = more.map_or(Known::Given, |(_, known)| *known);
            parts.push(Part {
                link: name,
                tip,
                a,
                b,
                radius,
                is_moving,
                body,
                parent,
                is_late,
                is_wrist,
                known,
            });
        }
        names.push(&link.name);
    }
    Ok((Linkage::new(model, base, &tips(names))?, parts))
}

/// The rigid body of a link and the one that it hangs on, as in [`Part::body`].
fn bodies(model: &Model, base: &str, link: &str) -> (usize, usize) {
    let mut above = Vec::new();
    let mut at = model.link_index(link);
    while let Some(l) = at.filter(|&l| model.links[l].name != base) {
        let Some(j) = model.links[l].parent_joint else { break };
        if model.joints[j].kind != JointKind::Fixed {
            above.push(j + 1);
        }
        at = Some(model.joints[j].parent);
    }
    (above.first().copied().unwrap_or(0), above.get(1).copied().unwrap_or(0))
}

/// Ends and radius of a capsule that holds a shape.
fn capsule(pose: &Pose, shape: &Shape) -> (Vec3, Vec3, f64) {
    let (half, radius) = match *shape {
        Shape::Capsule { radius, length } => (Vec3::z() * (0.5 * length), radius),
        Shape::Sphere { radius } => (Vec3::zeros(), radius),
        Shape::Cuboid { size } => {
            let long = size.imax();
            let mut half = Vec3::zeros();
            half[long] = 0.5 * size[long];
            (half, 0.5 * (size.norm_squared() - size[long].powi(2)).sqrt())
        }
    };
    let middle = pose.translation.vector;
    let half = pose.rotation * half;
    (middle - half, middle + half, radius)
}

/// Pose of the TCP in the world for the posture `q` (n values).
///
/// # Panics
/// When `q` is shorter than the number of joints, as everything in this file.
pub fn tcp_pose(robot: &Robot, q: &[f64]) -> Pose {
    let mut frames = Frames::default();
    robot.linkage.forward(q, &mut frames);
    robot.base * robot.linkage.tip_pose(&frames, 0)
}

/// One capsule of an arm, wherever it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmPart<'r> {
    /// Name of the link.
    pub link: &'r str,
    /// Radius, m.
    pub radius: f64,
    /// True for the wrist and what it carries: what one of the last three joints before the TCP moves
    /// and what is never farther than 0.32 m from the TCP.
    pub is_wrist: bool,
}

/// The capsules of an arm, in the order of [`arm_places`].
pub fn arm_parts(robot: &Robot) -> Vec<ArmPart<'_>> {
    let parts = robot.parts.iter();
    parts.map(|p| ArmPart { link: &p.link, radius: p.radius, is_wrist: p.is_wrist }).collect()
}

/// Ends of the capsules' axes in the world (m) in each of some postures.
pub fn arm_places<'q>(
    robot: &Robot,
    postures: impl IntoIterator<Item = &'q Vec<f64>>,
) -> Vec<Vec<[Vec3; 2]>> {
    let mut placer = Placer::new(robot);
    let place = |q: &Vec<f64>| {
        placer.place(q);
        placer.ends.clone()
    };
    postures.into_iter().map(place).collect()
}

/// Poses of the TCP in the world along a joint path (K postures of n values).
pub fn tcp_poses(robot: &Robot, q: &[Vec<f64>]) -> Vec<Pose> {
    q.iter().map(|q| tcp_pose(robot, q)).collect()
}

fn skeleton_frames(robot: &Robot, q: &[f64]) -> Frames {
    let mut all = q[..robot.dof()].to_vec();
    all.extend(&robot.held);
    let mut frames = Frames::default();
    robot.skeleton.forward(&all, &mut frames);
    frames
}

/// Finds the wrist of a robot whose parts are known.
pub(super) fn mark_wrist(robot: &mut Robot) {
    let mut farthest = vec![0.0f64; robot.parts.len()];
    let mut placer = Placer::new(robot);
    for sample in 0..WRIST_SAMPLES {
        let q = random_posture(&robot.limits, 0, WRIST_BLOCK, sample);
        placer.place(&q);
        let tcp = tcp_pose(robot, &q).translation.vector;
        for (far, ends) in farthest.iter_mut().zip(&placer.ends) {
            *far = ends.iter().map(|e| (e - tcp).norm()).fold(*far, f64::max);
        }
    }
    for (part, far) in robot.parts.iter_mut().zip(farthest) {
        part.is_wrist = part.is_late && far <= WRIST_REACH_M;
    }
}

/// Scratch that places the capsules of one robot in many postures.
#[derive(Debug)]
pub(super) struct Placer<'r> {
    pub(super) robot: &'r Robot,
    q: Vec<f64>,
    frames: Frames,
    /// Ends of the axes in the world, m, as many as `robot.parts`.
    pub(super) ends: Vec<[Vec3; 2]>,
}

impl<'r> Placer<'r> {
    pub(super) fn new(robot: &'r Robot) -> Self {
        let mut q = vec![0.0; robot.dof()];
        q.extend(&robot.held);
        let ends = vec![[Vec3::zeros(); 2]; robot.parts.len()];
        Self { robot, q, frames: Frames::default(), ends }
    }

    pub(super) fn place(&mut self, q: &[f64]) {
        let robot = self.robot;
        self.q[..robot.dof()].copy_from_slice(&q[..robot.dof()]);
        robot.skeleton.forward(&self.q, &mut self.frames);
        let turn = robot.base.rotation.to_rotation_matrix();
        let mut last: Option<(usize, Vec3, Matrix3<f64>)> = None;
        for (part, ends) in robot.parts.iter().zip(&mut self.ends) {
            // Capsules of one link follow each other.
            let (p, r) = match last {
                Some((tip, p, r)) if tip == part.tip => (p, r),
                _ => {
                    let (p, r) = robot.skeleton.tip_frame(&self.frames, part.tip);
                    (turn * p + robot.base.translation.vector, turn.matrix() * r)
                }
            };
            last = Some((part.tip, p, r));
            *ends = [p + r * part.a, p + r * part.b];
        }
    }
}

/// Points of a stick figure in the world, m: base, the n joints, TCP.
pub fn stick(robot: &Robot, q: &[f64]) -> Vec<Vec3> {
    let frames = skeleton_frames(robot, q);
    let point = |tip: usize| {
        let (p, _) = robot.skeleton.tip_frame(&frames, tip);
        robot.base.rotation * p + robot.base.translation.vector
    };
    let mut points = vec![robot.base.translation.vector];
    points.extend((1..=robot.dof()).map(point));
    points.push(point(0));
    points
}

/// The capsules around the links in the world. Empty for a URDF without simple collision shapes.
pub fn capsules<'r>(robot: &'r Robot, q: &[f64]) -> Vec<Capsule<'r>> {
    let frames = skeleton_frames(robot, q);
    let place = |part: &'r Part| {
        let (p, r) = robot.skeleton.tip_frame(&frames, part.tip);
        let world = |x: &Vec3| robot.base.rotation * (p + r * x) + robot.base.translation.vector;
        Capsule {
            link: &part.link,
            a: world(&part.a),
            b: world(&part.b),
            radius: part.radius,
            is_moving: part.is_moving,
        }
    };
    robot.parts.iter().map(place).collect()
}

/// Smallest distance between the moving links and named obstacles; `None` where there is no
/// obstacle or no capsule. Links that no joint moves do not count: a robot may stand on a table.
pub fn min_clearance(
    robot: &Robot,
    q: &[f64],
    obstacles: &[(String, Obstacle)],
) -> Option<Nearest> {
    let mut best: Option<(f64, &str, &str)> = None;
    for capsule in capsules(robot, q).iter().filter(|c| c.is_moving) {
        for (name, obstacle) in obstacles {
            let middle = obstacle.least_distance(&(0.5 * (capsule.a + capsule.b)));
            // The signed distance changes by at most the way gone.
            let bound = middle - 0.5 * (capsule.b - capsule.a).norm() - capsule.radius;
            if best.is_some_and(|(d, ..)| bound >= d) {
                continue;
            }
            let d = obstacle.distance_to_capsule(&capsule.a, &capsule.b, capsule.radius);
            if best.is_none_or(|(least, ..)| d < least) {
                best = Some((d, capsule.link, name));
            }
        }
    }
    best.map(|(distance_m, link, obstacle)| Nearest {
        distance_m,
        link: link.to_owned(),
        obstacle: obstacle.to_owned(),
    })
}

/// Smallest singular value of the TCP Jacobian, angular rows scaled by 0.3 m; m/rad. Zero in a
/// singular posture, and always for fewer than six joints.
pub fn min_singular_value(robot: &Robot, q: &[f64]) -> f64 {
    let mut frames = Frames::default();
    robot.linkage.forward(q, &mut frames);
    let mut jacobian: Matrix6xX<f64> = robot.linkage.jacobian(&frames, 0);
    jacobian.rows_mut(3, 3).scale_mut(ROTATION_SCALE_M);
    let square: Matrix6<f64> = &jacobian * jacobian.transpose();
    if square.iter().all(|v| v.is_finite()) {
        square.symmetric_eigenvalues().min().max(0.0).sqrt()
    } else {
        0.0
    }
}

/// How joint speeds follow from the TCP's velocity at unchanged angular velocity: one vector for each
/// joint, `qd_i = g_i . v` (rad/m, world axes), by the least joint motion.
pub fn joint_rates(robot: &Robot, q: &[f64]) -> Vec<Vec3> {
    let mut frames = Frames::default();
    robot.linkage.forward(q, &mut frames);
    let mut jacobian: Matrix6xX<f64> = robot.linkage.jacobian(&frames, 0);
    jacobian.rows_mut(3, 3).scale_mut(ROTATION_SCALE_M);
    let square: Matrix6<f64> =
        &jacobian * jacobian.transpose() + Matrix6::from_diagonal_element(RATE_DAMPING);
    let Some(factor) = square.cholesky() else { return vec![Vec3::zeros(); robot.dof()] };
    let of = |column| -> Vec3 {
        let rates: nalgebra::Vector6<f64> = factor.solve(&column);
        robot.base.rotation * Vec3::new(rates[0], rates[1], rates[2])
    };
    jacobian.column_iter().map(|c| of(c.into_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capsules_hold_the_stick_figure() {
        for name in super::super::PRESETS {
            let robot = Robot::preset(name).unwrap();
            let points = stick(&robot, &robot.home);
            assert_eq!(points.len(), robot.dof() + 2);
            let capsules = capsules(&robot, &robot.home);
            assert!(capsules.len() >= robot.dof(), "end balls are dropped, capsules stay");
            assert!(capsules.iter().all(|c| c.a != c.b && (0.02..0.13).contains(&c.radius)));
            assert!(capsules.iter().any(|c| !c.is_moving), "the base stands still");
            // The UR's links run beside the line of joint origins, by up to 0.2 m.
            let limit = match name {
                "panda" | "fr3" => 0.04,
                "ur10e" => 0.14,
                "ur20" => 0.2,
                _ => 0.1,
            };
            for p in &points {
                let far = capsules
                    .iter()
                    .map(|c| Obstacle::Capsule { a: c.a, b: c.b, radius: c.radius })
                    .map(|c| c.signed_distance(p))
                    .fold(f64::INFINITY, f64::min);
                assert!(far < limit, "{name}: {p} lies {far} m outside");
            }
        }
    }

    #[test]
    fn the_base_moves_everything() {
        let mut robot = Robot::preset("panda").unwrap();
        let q = robot.home.clone();
        let (before, tcp) = (stick(&robot, &q), tcp_pose(&robot, &q));
        robot.base = Pose::new(Vec3::new(1.0, 2.0, 0.8), Vec3::new(0.0, 0.0, 1.5));
        let after = stick(&robot, &q);
        for (a, b) in before.iter().zip(&after) {
            assert!((robot.base.transform_point(&(*a).into()).coords - b).norm() < 1e-12);
        }
        let moved = tcp_poses(&robot, std::slice::from_ref(&q))[0];
        assert!((moved.translation.vector - (robot.base * tcp).translation.vector).norm() < 1e-12);
        assert!((after[8] - moved.translation.vector).norm() < 1e-12);
    }

    #[test]
    fn clearance_names_link_and_obstacle() {
        let robot = Robot::preset("panda").unwrap();
        let tcp = tcp_pose(&robot, &robot.home).translation.vector;
        let ball = |z: f64| Obstacle::Sphere { center: tcp + Vec3::z() * z, radius: 0.05 };
        let table = Obstacle::Box {
            pose: Pose::translation(0.0, 0.0, -0.05),
            size: Vec3::new(2.0, 2.0, 0.1),
        };
        let obstacles = [("table".to_owned(), table), ("ball".to_owned(), ball(-0.2))];
        let near = min_clearance(&robot, &robot.home, &obstacles).unwrap();
        assert_eq!((near.obstacle.as_str(), near.link.as_str()), ("table", "panda_link1"));
        let near = min_clearance(&robot, &robot.home, &[("ball".to_owned(), ball(-0.06))]).unwrap();
        assert_eq!((near.obstacle.as_str(), near.link.as_str()), ("ball", "panda_hand"));
        assert!(near.distance_m > -0.05 && near.distance_m < 0.01, "{near:?}");
        assert!(min_clearance(&robot, &robot.home, &[]).is_none());
    }

    #[test]
    fn a_box_is_held_by_its_capsule() {
        let size = Vec3::new(0.1, 0.4, 0.2);
        let (a, b, radius) = capsule(&Pose::identity(), &Shape::Cuboid { size });
        let around = Obstacle::Capsule { a, b, radius };
        assert!(around.signed_distance(&(0.5 * size)) <= 1e-12);
    }

    /// How far the surface of a capsule, shrunk by `margin`, sticks out of others.
    fn sticks_out(of: &[Capsule], capsule: &Capsule, margin: f64) -> f64 {
        let axis = (capsule.b - capsule.a).try_normalize(1e-9).unwrap_or(Vec3::z());
        let side = axis.cross(&Vec3::new(0.3, -0.5, 0.8)).normalize();
        let other = axis.cross(&side);
        let points = (0..=10).flat_map(|i| (0..24).map(move |j| (f64::from(i), f64::from(j))));
        points
            .map(|(i, j)| {
                let (sin, cos) = (j * std::f64::consts::TAU / 24.0).sin_cos();
                let at = capsule.a.lerp(&capsule.b, i / 10.0);
                at + (side * cos + other * sin) * (capsule.radius - margin)
            })
            .chain([capsule.a - axis * (capsule.radius - margin)])
            .chain([capsule.b + axis * (capsule.radius - margin)])
            // Below the shoulder's foot everything is inside the base.
            .filter(|p| p.z > 0.14)
            .map(|p| {
                of.iter()
                    .map(|c| Obstacle::Capsule { a: c.a, b: c.b, radius: c.radius })
                    .map(|c| c.signed_distance(&p))
                    .fold(f64::INFINITY, f64::min)
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn the_panda_s_capsules_cover_the_maker_s() {
        let name = "models/robots/panda_collision.urdf";
        let Some(file) = crate::skips::shared(name) else { return };
        let own = Robot::preset("panda").unwrap();
        let maker = Robot::from_urdf(&file, "panda_link0", "panda_hand_tcp").unwrap();
        let covers = capsules(&own, &own.home);
        // That file seems to add a margin of 0.03 m; not to the fingers, which are closed here.
        for c in capsules(&maker, &own.home).iter().filter(|c| !c.link.contains("finger")) {
            let far = sticks_out(&covers, c, 0.03);
            assert!(far < 0.012, "{} sticks out by {far} m", c.link);
        }
    }

    #[test]
    fn a_straight_arm_is_singular() {
        let robot = Robot::preset("ur5e").unwrap();
        assert!(min_singular_value(&robot, &[0.0; 6]) < 1e-6);
        assert!(min_singular_value(&robot, &robot.home) > 0.05);
        assert!(min_singular_value(&robot, &[f64::NAN; 6]).abs() < 1e-12);
    }
}
