//! What is known about a robot arm: kinematics, limits, place in the world and shape.

use super::body::{Part, mark_wrist};
use super::check::LimitKind;
use super::collide::SelfPairs;
use super::link_shapes::{AssumedShapes, LinkShapes, MissingMesh};
use crate::files::{InputError, read_text, sha256_hex, suggest};
use crate::kinematics::{Linkage, LinkageError, Model, Tip, parse_urdf};
use crate::math::Pose;
use crate::physical::{ROBOT_ACCELERATION, ROBOT_SPEED, SLIDE_M, TURN_RAD};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Stand-ins where a file gives no limit: turning joints (rad), sliding joints (m).
const STAND_IN_VELOCITY: (f64, f64) = (PI / 2.0, 0.25);
const STAND_IN_ACCELERATION: (f64, f64) = (PI, 1.0);

/// Something about a robot that is a stand-in or from memory.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "assumed", rename_all = "snake_case")]
pub enum Assumed {
    /// As the description of a preset says.
    Declared {
        /// In a sentence.
        text: String,
    },
    /// Limits of joints.
    Limits {
        /// The robot.
        robot: String,
        /// Which limits.
        of: LimitKind,
        /// Names of the joints.
        joints: Vec<String>,
    },
}

/// A remark about a robot's description.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "note", rename_all = "snake_case")]
pub enum RobotNote {
    /// What was odd about the file, as its reader says.
    File {
        /// In a sentence.
        text: String,
    },
    /// Links whose capsules were fitted to their meshes, and hold them.
    FittedCapsules {
        /// Their names.
        links: Vec<String>,
        /// Meshes that were read.
        meshes: usize,
        /// Capsules that were made of them.
        capsules: usize,
    },
    /// Links whose shape is not known, and which stand as capsules of an assumed radius.
    AssumedCapsules {
        /// Their names.
        links: Vec<String>,
        /// The radius, m.
        radius_m: f64,
        /// Meshes that would tell.
        missing: Vec<MissingMesh>,
    },
}

/// Limits of the n joints from base to TCP; all vectors have length n.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Lower position limit, rad or m; minus infinity for a joint without end.
    pub lower: Vec<f64>,
    /// Upper position limit, rad or m; infinity for a joint without end.
    pub upper: Vec<f64>,
    /// Largest speed, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Largest acceleration, rad/s^2 or m/s^2.
    pub acceleration: Vec<f64>,
    /// Where the velocity limit is a stand-in.
    pub velocity_assumed: Vec<bool>,
    /// Where the acceleration limit is a stand-in.
    pub acceleration_assumed: Vec<bool>,
    /// How the speed falls towards the ends of the range, for joints whose maker says so.
    pub brakes: Vec<Option<Brake>>,
}

/// A speed limit that depends on the position, so that the joint can still stop before its end:
/// `|v| <= max(0, -offset + sqrt(c (end - q)))` towards an end, and never above the joint's own limit
/// (libfranka, `rate_limiting.h` of the Franka Research 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brake {
    /// rad/s.
    pub offset: f64,
    /// c: twice the deceleration, rad/s^2.
    pub c: f64,
    /// Upper end, rad.
    pub upper: f64,
    /// Lower end, rad.
    pub lower: f64,
}

impl Limits {
    /// Largest speed of a joint at a position, in the direction of `rate`; rad/s or m/s.
    pub fn velocity_at(&self, joint: usize, at: f64, rate: f64) -> f64 {
        let most = self.velocity[joint];
        let Some(brake) = &self.brakes[joint] else { return most };
        let way = if rate >= 0.0 { brake.upper - at } else { at - brake.lower };
        most.min((-brake.offset + (brake.c * way).max(0.0).sqrt()).max(0.0))
    }

    /// Middle of the position range; `None` for a joint without end.
    pub fn middle(&self, joint: usize) -> Option<f64> {
        let middle = 0.5 * (self.lower[joint] + self.upper[joint]);
        (self.lower[joint].is_finite() && self.upper[joint].is_finite()).then_some(middle)
    }
}

/// A robot arm between a base link and a tool centre point (TCP).
///
/// `home` and all vectors in `limits` have as many values as `linkage` has joints; keep it so.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Preset name, or the name in the URDF.
    pub name: String,
    /// The chain from base link to TCP; its first tip is the TCP.
    pub linkage: Linkage,
    /// Joint limits.
    pub limits: Limits,
    /// Posture from which inverse kinematics starts, rad or m.
    pub home: Vec<f64>,
    /// World from base link.
    pub base: Pose,
    /// Remarks about the description.
    pub notes: Vec<RobotNote>,
    /// Where the numbers come from.
    pub sources: Vec<String>,
    pub(super) declared: Vec<String>,
    pub(super) skeleton: Linkage,
    /// Positions of the skeleton's joints that are not between base and TCP.
    pub(super) held: Vec<f64>,
    pub(super) parts: Vec<Part>,
    /// Links that stand as capsules of an assumed radius.
    pub(super) assumed_shapes: Option<AssumedShapes>,
    /// Name and SHA-256 of the description, where it is a file of the user's.
    pub(super) own_file: Option<(String, String)>,
    /// (address, SHA-256) of the meshes to which capsules were fitted.
    pub(super) meshes: Vec<(String, String)>,
    pub(super) self_pairs: SelfPairs,
    pub(super) file: PathBuf,
}

impl Robot {
    /// A robot that ships with ergopath: one of [`super::PRESETS`].
    pub fn preset(name: &str) -> Result<Self, InputError> {
        super::preset::load(name)
    }

    /// Reads a URDF file; `base` and `tcp` are names of links, `base` above `tcp`.
    ///
    /// The robot stands in the world's origin. Limits of velocity and acceleration that the file does
    /// not give are stand-ins until set.
    pub fn from_urdf(path: &Path, base: &str, tcp: &str) -> Result<Self, InputError> {
        let text = read_text(path)?;
        let mut robot = Self::from_text(path, &text, base, tcp)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        robot.own_file = Some((name, sha256_hex(text.as_bytes())));
        Ok(robot)
    }

    pub(super) fn from_text(
        path: &Path,
        text: &str,
        base: &str,
        tcp: &str,
    ) -> Result<Self, InputError> {
        let model = parse_urdf(path, text)?;
        let wrong = |e: LinkageError| match e {
            LinkageError::UnknownLink { name, hint } => {
                let error = InputError::new(path, format!("there is no link `{name}`"));
                error.remedy(hint.unwrap_or_else(|| link_names(&model)))
            }
            other => InputError::new(path, other.to_string()),
        };
        let linkage = Linkage::chain(&model, base, tcp).map_err(wrong)?;
        if linkage.dof() == 0 {
            return Err(InputError::new(
                path,
                format!("no joint moves between `{base}` and `{tcp}`"),
            )
            .remedy("base is the link that stands still, tcp the tool at the other end"));
        }
        check_limits(path, &linkage)?;
        let shapes = LinkShapes::of(path, &model, base, &linkage);
        let (skeleton, parts) =
            super::body::parts(&model, base, tcp, &shapes.capsules).map_err(wrong)?;
        let held = skeleton.joints()[linkage.dof()..].iter();
        let held = held.map(|j| 0.0f64.max(j.lower).min(j.upper)).collect();
        let limits = limits_of(&linkage);
        let middle = |i| limits.middle(i).unwrap_or(0.0);
        let home = (0..linkage.dof()).map(middle).collect();
        let odd = model.warnings.iter().chain(&linkage.warnings).cloned();
        let mut notes: Vec<RobotNote> = odd.map(|text| RobotNote::File { text }).collect();
        notes.extend(shapes.notes);
        let mut robot = Self {
            name: model.name.clone(),
            linkage,
            limits,
            home,
            base: Pose::identity(),
            notes,
            sources: vec![format!("URDF `{}`", model.name)],
            declared: Vec::new(),
            skeleton,
            held,
            parts,
            assumed_shapes: shapes.assumed,
            own_file: None,
            meshes: shapes.files,
            self_pairs: SelfPairs::default(),
            file: path.to_owned(),
        };
        robot.self_pairs = SelfPairs::find(&robot);
        mark_wrist(&mut robot);
        Ok(robot)
    }

    /// Number of joints, n.
    pub fn dof(&self) -> usize {
        self.linkage.dof()
    }

    /// Names of the joints, base to TCP.
    pub fn joint_names(&self) -> impl Iterator<Item = &str> {
        self.linkage.joints().iter().map(|j| j.name.as_str())
    }

    /// Everything that is a stand-in or from memory; what has been set since is left out.
    pub fn assumed(&self) -> Vec<Assumed> {
        let declared = self.declared.iter().cloned();
        let mut all: Vec<Assumed> = declared.map(|text| Assumed::Declared { text }).collect();
        for (of, flags) in [
            (LimitKind::Velocity, &self.limits.velocity_assumed),
            (LimitKind::Acceleration, &self.limits.acceleration_assumed),
        ] {
            let assumed = self.joint_names().zip(flags).filter(|(_, f)| **f);
            let joints: Vec<String> = assumed.map(|(name, _)| name.to_owned()).collect();
            if !joints.is_empty() {
                all.push(Assumed::Limits { robot: self.name.clone(), of, joints });
            }
        }
        all
    }

    /// Sets the range of a joint, rad or m, and moves `home` into it. Refused: an unknown joint,
    /// limits that are not finite or not in order.
    pub fn set_position_limit(
        &mut self,
        joint: &str,
        lower: f64,
        upper: f64,
    ) -> Result<(), InputError> {
        let i = self.joint_index(joint)?;
        if !(lower.is_finite() && upper.is_finite() && lower < upper) {
            let message = format!("joint `{joint}`: {lower} to {upper} is no range");
            return Err(InputError::new(&self.file, message).remedy("give lower < upper"));
        }
        let is_sliding = self.linkage.joints()[i].is_prismatic;
        let range = if is_sliding { SLIDE_M } else { TURN_RAD };
        if let Some(beyond) = range.outside([lower, upper]) {
            let message = format!("joint `{joint}`: limit {beyond} is outside {range}");
            return Err(InputError::new(&self.file, message)
                .remedy("limits are in radians, or in metres for a sliding joint"));
        }
        self.limits.lower[i] = lower;
        self.limits.upper[i] = upper;
        self.home[i] = self.home[i].clamp(lower, upper);
        Ok(())
    }

    /// Sets the speed limit of a joint, rad/s or m/s. Refused: an unknown joint, a limit that is
    /// not a positive number.
    pub fn set_velocity_limit(&mut self, joint: &str, limit: f64) -> Result<(), InputError> {
        let i = self.joint_index(joint)?;
        self.limits.velocity[i] = self.positive(joint, "velocity", limit)?;
        self.limits.velocity_assumed[i] = false;
        Ok(())
    }

    /// Sets the acceleration limit of a joint, rad/s^2 or m/s^2. Refused: an unknown joint, a limit
    /// that is not a positive number.
    pub fn set_acceleration_limit(&mut self, joint: &str, limit: f64) -> Result<(), InputError> {
        let i = self.joint_index(joint)?;
        self.limits.acceleration[i] = self.positive(joint, "acceleration", limit)?;
        self.limits.acceleration_assumed[i] = false;
        Ok(())
    }

    /// Column of the joint with this name; the error suggests a similar one.
    pub fn joint_index(&self, joint: &str) -> Result<usize, InputError> {
        self.joint_names().position(|n| n == joint).ok_or_else(|| {
            let names: Vec<&str> = self.joint_names().collect();
            let remedy = suggest(joint, names.iter().copied())
                .unwrap_or_else(|| format!("its joints are: {}", names.join(", ")));
            let message = format!("robot `{}` has no joint `{joint}`", self.name);
            InputError::new(&self.file, message).remedy(remedy)
        })
    }

    fn positive(&self, joint: &str, what: &str, limit: f64) -> Result<f64, InputError> {
        let range = if what == "velocity" { ROBOT_SPEED } else { ROBOT_ACCELERATION };
        if limit > 0.0 && range.holds(limit) {
            return Ok(limit);
        }
        let message = if limit > 0.0 {
            format!("joint `{joint}`: {what} limit {limit} is outside {range}")
        } else {
            format!("joint `{joint}`: {what} limit {limit} is not a positive number")
        };
        Err(InputError::new(&self.file, message).remedy("give the limit in rad/s or rad/s^2"))
    }
}

/// Limits of the chain that no robot has: a joint that cannot move, or degrees.
fn check_limits(path: &Path, linkage: &Linkage) -> Result<(), InputError> {
    for j in linkage.joints() {
        let (name, lower, upper) = (&j.name, j.lower, j.upper);
        if lower >= upper {
            let message = format!("joint `{name}` cannot move: its limits are {lower} and {upper}");
            return Err(InputError::new(path, message).remedy(
                "give its lower and upper limit, or make it type=\"fixed\" if it does not move",
            ));
        }
        let most = |v: f64| if v.is_finite() { v.abs() } else { 0.0 };
        let farthest = most(lower).max(most(upper));
        if !j.is_prismatic && !TURN_RAD.holds(farthest) {
            let message = format!(
                "joint `{name}`: limits {lower} to {upper} rad are {:.0} turns. Are they in degrees?",
                farthest / (2.0 * PI)
            );
            return Err(InputError::new(path, message).remedy(
                "give limits in radians, or type=\"continuous\" for a joint that turns without end",
            ));
        }
        if j.is_prismatic && !SLIDE_M.holds(farthest) {
            let message = format!(
                "joint `{name}`: limits {lower} to {upper} m are longer than any slide. Are they in \
                 millimetres?"
            );
            return Err(InputError::new(path, message).remedy("give limits in metres"));
        }
        if j.velocity.is_finite() && !ROBOT_SPEED.holds(j.velocity) {
            let message = format!(
                "joint `{name}`: velocity limit {} is faster than any robot. Is it in degrees or \
                 millimetres a second?",
                j.velocity
            );
            return Err(InputError::new(path, message).remedy("give it in rad/s or m/s"));
        }
    }
    Ok(())
}

fn limits_of(linkage: &Linkage) -> Limits {
    let joints = linkage.joints();
    let pick = |pair: (f64, f64), is_prismatic: bool| if is_prismatic { pair.1 } else { pair.0 };
    Limits {
        lower: joints.iter().map(|j| j.lower).collect(),
        upper: joints.iter().map(|j| j.upper).collect(),
        velocity: joints
            .iter()
            .map(|j| {
                let stand_in = pick(STAND_IN_VELOCITY, j.is_prismatic);
                if j.velocity.is_finite() { j.velocity } else { stand_in }
            })
            .collect(),
        acceleration: joints
            .iter()
            .map(|j| {
                let stand_in = pick(STAND_IN_ACCELERATION, j.is_prismatic);
                if j.acceleration.is_finite() { j.acceleration } else { stand_in }
            })
            .collect(),
        velocity_assumed: joints.iter().map(|j| !j.velocity.is_finite()).collect(),
        acceleration_assumed: joints.iter().map(|j| !j.acceleration.is_finite()).collect(),
        brakes: vec![None; joints.len()],
    }
}

fn link_names(model: &Model) -> String {
    let names: Vec<&str> = model.links.iter().map(|l| l.name.as_str()).collect();
    format!("its links are: {}", names.join(", "))
}

/// Tips of the skeleton for these links.
pub(super) fn tips<'a>(links: impl IntoIterator<Item = &'a str>) -> Vec<Tip> {
    links.into_iter().map(Tip::link).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic;

    #[test]
    fn limits_are_overridden_by_name_and_no_longer_assumed() {
        let mut robot = Robot::preset("ur5e").unwrap();
        let of_acceleration = |robot: &Robot| {
            let all = robot.assumed().into_iter();
            all.filter(|a| matches!(a, Assumed::Limits { of: LimitKind::Acceleration, .. })).count()
        };
        assert_eq!(of_acceleration(&robot), 1);
        let names: Vec<String> = robot.joint_names().map(str::to_owned).collect();
        for name in &names {
            robot.set_acceleration_limit(name, 5.0).unwrap();
        }
        assert_eq!(of_acceleration(&robot), 0);
        robot.set_velocity_limit("elbow_joint", 1.0).unwrap();
        robot.set_position_limit("elbow_joint", -1.0, 1.0).unwrap();
        assert_eq!((robot.limits.velocity[2], robot.home[2]), (1.0, 1.0));
        let error = robot.set_velocity_limit("elbow_jiont", 1.0).unwrap_err();
        assert_eq!(error.help().unwrap().to_string(), "did you mean `elbow_joint`?");
        assert!(robot.set_velocity_limit("elbow_joint", f64::NAN).is_err());
        assert!(robot.set_position_limit("elbow_joint", 1.0, f64::NAN).is_err());
    }

    #[test]
    fn limits_that_no_robot_has_are_asked_about() {
        let robot = |kind: &str, limit: &str| {
            let text = format!(
                r#"<robot name="one"><link name="base"/><link name="arm"/>
                <joint name="turn" type="{kind}"><parent link="base"/><child link="arm"/>
                <axis xyz="0 0 1"/><limit effort="1" {limit}/></joint></robot>"#
            );
            Robot::from_text(Path::new("one.urdf"), &text, "base", "arm")
        };
        let refused = |kind: &str, limit: &str| robot(kind, limit).unwrap_err().to_string();
        let degrees = refused("revolute", r#"lower="-170" upper="170" velocity="2""#);
        assert!(degrees.contains("`turn`") && degrees.contains("in degrees?"), "{degrees}");
        assert!(refused("revolute", r#"lower="-100" upper="1" velocity="2""#).contains("degrees?"));
        assert!(refused("revolute", r#"lower="0" upper="0" velocity="2""#).contains("cannot move"));
        assert!(refused("revolute", r#"lower="-1" upper="1" velocity="180""#).contains("faster"));
        assert!(refused("prismatic", r#"lower="0" upper="800" velocity="1""#).contains("millim"));
        let good = r#"lower="-6.4" upper="6.4" velocity="3" acceleration="5""#;
        let good = robot("revolute", good).unwrap();
        assert_eq!(
            (good.limits.acceleration[0], good.limits.acceleration_assumed[0]),
            (5.0, false)
        );
    }

    #[test]
    fn a_bare_urdf_gets_stand_ins_that_are_named() {
        let text = r#"<robot name="one"><link name="base"/><link name="arm"/>
            <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/>
            <origin xyz="0 0 1"/><axis xyz="0 0 1"/></joint></robot>"#;
        let robot = Robot::from_text(Path::new("one.urdf"), text, "base", "arm").unwrap();
        let stand_ins =
            |of| Assumed::Limits { robot: "one".to_owned(), of, joints: vec!["turn".to_owned()] };
        let both = [LimitKind::Velocity, LimitKind::Acceleration].map(stand_ins);
        assert_eq!(robot.assumed(), both);
        let error = Robot::from_text(Path::new("one.urdf"), text, "base", "arn").unwrap_err();
        assert_eq!(error.help().unwrap().to_string(), "did you mean `arm`?");
        assert!(Robot::from_text(Path::new("one.urdf"), text, "arm", "arm").is_err());
        assert!(Robot::from_text(Path::new("one.urdf"), text, "arm", "base").is_err());
    }
}
