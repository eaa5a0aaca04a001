//! The robots that ship with ergopath: URDF for kinematics and shape, TOML for the rest.

use super::description::{Brake, Robot};
use crate::files::{InputError, Memo, parse_toml, suggest};
use serde::Deserialize;
use std::path::Path;

/// Names and files of the presets.
macro_rules! shipped {
    ($($name:literal),+) => {
        /// Names that [`Robot::preset`] knows.
        pub const PRESETS: [&str; [$($name),+].len()] = [$($name),+];

        /// URDF and TOML of a preset.
        fn files(name: &str) -> Option<[&'static str; 2]> {
            match name {
                $($name => Some([
                    include_str!(concat!("../../models/robot/", $name, ".urdf")),
                    include_str!(concat!("../../models/robot/", $name, ".toml")),
                ]),)+
                _ => None,
            }
        }
    };
}
shipped!("panda", "fr3", "ur3e", "ur5e", "ur10e", "ur20", "crb15000", "crx10ial");

const SCHEMA: &str = "ergopath/robot/1";

/// The TOML beside a preset's URDF.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Extra {
    schema: String,
    name: String,
    base: String,
    tcp: String,
    acceleration_rad_s2: Vec<f64>,
    acceleration_assumed: bool,
    #[serde(default)]
    brake: Vec<BrakeRow>,
    home_rad: Vec<f64>,
    assumed: Vec<String>,
    sources: Vec<String>,
}

/// Position-dependent speed of one joint, in the order of the joints.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BrakeRow {
    offset_rad_s: f64,
    c_rad_s2: f64,
    lower_rad: f64,
    upper_rad: f64,
}

/// The preset with this name.
pub(super) fn load(name: &str) -> Result<Robot, InputError> {
    static KNOWN: Memo<Robot> = Memo::new();
    KNOWN.of(&[name], || load_anew(name))
}

fn load_anew(name: &str) -> Result<Robot, InputError> {
    let Some([urdf, toml]) = files(name) else {
        let remedy = suggest(name, PRESETS)
            .unwrap_or_else(|| format!("known presets: {}", PRESETS.join(", ")));
        let error = InputError::new("robot", format!("there is no preset `{name}`"));
        return Err(error.remedy(remedy));
    };
    let folder = Path::new("models/robot");
    let toml_path = folder.join(format!("{name}.toml"));
    let extra: Extra = parse_toml(&toml_path, toml)?;
    let robot =
        Robot::from_text(&folder.join(format!("{name}.urdf")), urdf, &extra.base, &extra.tcp)?;
    complete(robot, extra, &toml_path)
}

/// Adds to the robot what its URDF does not hold.
fn complete(mut robot: Robot, extra: Extra, path: &Path) -> Result<Robot, InputError> {
    let n = robot.dof();
    if extra.schema != SCHEMA {
        let message = format!("schema is `{}`, not `{SCHEMA}`", extra.schema);
        return Err(InputError::new(path, message));
    }
    if extra.home_rad.len() != n || extra.acceleration_rad_s2.len() != n {
        let message = format!("home_rad and acceleration_rad_s2 need {n} values, one a joint");
        return Err(InputError::new(path, message));
    }
    let limits = robot.limits.lower.iter().zip(&robot.limits.upper);
    if extra.home_rad.iter().zip(limits).any(|(q, (l, u))| !(l..=u).contains(&q)) {
        return Err(InputError::new(path, "home_rad is outside the joint limits"));
    }
    if !extra.brake.is_empty() {
        if extra.brake.len() != n {
            let message = format!("brake needs {n} rows, one a joint, or none");
            return Err(InputError::new(path, message));
        }
        let brake = |b: &BrakeRow| {
            let (offset, c) = (b.offset_rad_s, b.c_rad_s2);
            Some(Brake { offset, c, upper: b.upper_rad, lower: b.lower_rad })
        };
        robot.limits.brakes = extra.brake.iter().map(brake).collect();
    }
    robot.name = extra.name;
    robot.home = extra.home_rad;
    robot.limits.acceleration = extra.acceleration_rad_s2;
    robot.limits.acceleration_assumed = vec![extra.acceleration_assumed; n];
    robot.declared = extra.assumed;
    robot.sources = extra.sources;
    // Links without mass are on purpose here.
    robot.notes.clear();
    Ok(robot)
}

#[cfg(test)]
mod tests {
    use super::super::body::tcp_pose;
    use super::*;
    use crate::kinematics::{Frames, Linkage, read_urdf};
    use crate::math::stream::{Purpose, stream};
    use crate::math::{Pose, Vec3};
    use nalgebra::{Matrix4, UnitQuaternion};
    use rand::RngExt;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    fn rot_x(angle: f64) -> Matrix4<f64> {
        let (s, c) = angle.sin_cos();
        Matrix4::new(1., 0., 0., 0., 0., c, -s, 0., 0., s, c, 0., 0., 0., 0., 1.)
    }

    fn rot_z(angle: f64) -> Matrix4<f64> {
        let (s, c) = angle.sin_cos();
        Matrix4::new(c, -s, 0., 0., s, c, 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.)
    }

    fn shift(x: f64, z: f64) -> Matrix4<f64> {
        Matrix4::new_translation(&Vec3::new(x, 0.0, z))
    }

    /// Craig's convention: `Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(q_i) Tz(d_i)`.
    fn panda_by_table(q: &[f64]) -> Matrix4<f64> {
        let table = [
            (0.0, 0.333, 0.0),
            (0.0, 0.0, -FRAC_PI_2),
            (0.0, 0.316, FRAC_PI_2),
            (0.0825, 0.0, FRAC_PI_2),
            (-0.0825, 0.384, -FRAC_PI_2),
            (0.0, 0.0, FRAC_PI_2),
            (0.088, 0.0, FRAC_PI_2),
        ];
        let arm = table.iter().zip(q).fold(rot_z(0.0), |t, (&(a, d, alpha), &q)| {
            t * rot_x(alpha) * shift(a, 0.0) * rot_z(q) * shift(0.0, d)
        });
        arm * shift(0.0, 0.107) * rot_z(-FRAC_PI_4) * shift(0.0, 0.1034)
    }

    /// Standard convention: `Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i)`, under ROS's forward `base_link`.
    fn ur_by_table(table: [(f64, f64, f64); 6], q: &[f64]) -> Matrix4<f64> {
        table.iter().zip(q).fold(rot_z(PI), |t, (&(a, d, alpha), &q)| {
            t * rot_z(q) * shift(0.0, d) * shift(a, 0.0) * rot_x(alpha)
        })
    }

    fn ur10e_by_table(q: &[f64]) -> Matrix4<f64> {
        let table = [
            (0.0, 0.1807, FRAC_PI_2),
            (-0.6127, 0.0, 0.0),
            (-0.57155, 0.0, 0.0),
            (0.0, 0.17415, FRAC_PI_2),
            (0.0, 0.11985, -FRAC_PI_2),
            (0.0, 0.11655, 0.0),
        ];
        ur_by_table(table, q)
    }

    fn ur3e_by_table(q: &[f64]) -> Matrix4<f64> {
        let table = [
            (0.0, 0.15185, FRAC_PI_2),
            (-0.24355, 0.0, 0.0),
            (-0.2132, 0.0, 0.0),
            (0.0, 0.13105, FRAC_PI_2),
            (0.0, 0.08535, -FRAC_PI_2),
            (0.0, 0.0921, 0.0),
        ];
        ur_by_table(table, q)
    }

    fn ur20_by_table(q: &[f64]) -> Matrix4<f64> {
        let table = [
            (0.0, 0.2363, FRAC_PI_2),
            (-0.862, 0.0, 0.0),
            (-0.7287, 0.0, 0.0),
            (0.0, 0.201, FRAC_PI_2),
            (0.0, 0.1593, -FRAC_PI_2),
            (0.0, 0.1543, 0.0),
        ];
        ur_by_table(table, q)
    }

    /// Product of turns about the axes as they lie at zero, each with a point on it.
    fn by_axes(axes: &[([f64; 3], [f64; 3]); 6], zero: Matrix4<f64>, q: &[f64]) -> Matrix4<f64> {
        let turn = |(axis, point): &([f64; 3], [f64; 3]), q: f64| {
            let to = Matrix4::new_translation(&Vec3::from(*point));
            let back = Matrix4::new_translation(&-Vec3::from(*point));
            to * Matrix4::new_rotation(Vec3::from(*axis) * q) * back
        };
        axes.iter().zip(q).fold(rot_z(0.0), |t, (axis, q)| t * turn(axis, *q)) * zero
    }

    fn crb15000_by_axes(q: &[f64]) -> Matrix4<f64> {
        let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let axes = [
            (z, [0.0; 3]),
            (y, [0.0, 0.0, 0.265]),
            (y, [0.0, 0.0, 0.709]),
            (x, [0.0, 0.0, 0.819]),
            (y, [0.47, 0.0, 0.819]),
            (x, [0.0, 0.0, 0.899]),
        ];
        let zero =
            Matrix4::new(0., 0., 1., 0.571, 0., 1., 0., 0., -1., 0., 0., 0.899, 0., 0., 0., 1.);
        by_axes(&axes, zero, q)
    }

    fn crx10ial_by_axes(q: &[f64]) -> Matrix4<f64> {
        let (x, y, z) = ([-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let back = [0.0, -1.0, 0.0];
        let axes = [
            (z, [0.0; 3]),
            (y, [0.0, 0.0, 0.245]),
            (back, [0.0, 0.0, 0.955]),
            (x, [0.0, 0.0, 0.955]),
            (back, [0.54, 0.0, 0.955]),
            (x, [0.0, -0.15, 0.955]),
        ];
        let zero =
            Matrix4::new(0., 0., 1., 0.7, 0., -1., 0., -0.15, 1., 0., 0., 0.955, 0., 0., 0., 1.);
        by_axes(&axes, zero, q)
    }

    fn ur5e_by_table(q: &[f64]) -> Matrix4<f64> {
        let table = [
            (0.0, 0.1625, FRAC_PI_2),
            (-0.425, 0.0, 0.0),
            (-0.3922, 0.0, 0.0),
            (0.0, 0.1333, FRAC_PI_2),
            (0.0, 0.0997, -FRAC_PI_2),
            (0.0, 0.0996, 0.0),
        ];
        ur_by_table(table, q)
    }

    fn difference(own: &Pose, other: &Matrix4<f64>) -> f64 {
        (own.to_homogeneous() - other).abs().max()
    }

    fn postures(robot: &Robot) -> Vec<Vec<f64>> {
        let mut all = vec![robot.home.clone()];
        for index in 0..50 {
            let mut rng = stream(5, Purpose::Simulation, 0, index);
            let range = robot.limits.lower.iter().zip(&robot.limits.upper);
            all.push(range.map(|(l, u)| l + (u - l) * rng.random::<f64>()).collect());
        }
        all
    }

    #[test]
    fn kinematics_follow_the_published_tables() {
        type Table = fn(&[f64]) -> Matrix4<f64>;
        for (name, table) in [
            ("panda", panda_by_table as Table),
            ("fr3", panda_by_table),
            ("ur3e", ur3e_by_table),
            ("ur5e", ur5e_by_table),
            ("ur10e", ur10e_by_table),
            ("ur20", ur20_by_table),
            ("crb15000", crb15000_by_axes),
            ("crx10ial", crx10ial_by_axes),
        ] {
            let robot = Robot::preset(name).unwrap();
            for q in postures(&robot) {
                let far = difference(&tcp_pose(&robot, &q), &table(&q));
                assert!(far < 1e-12, "{name}: {far:e}");
            }
        }
        let panda = Robot::preset("panda").unwrap();
        let home = tcp_pose(&panda, &panda.home);
        let p = home.translation.vector;
        assert!((p - Vec3::new(0.307, 0.0, 0.487)).norm() < 1e-3, "{p}");
        // Gripper down, fingers opening along the world's y.
        let down = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), PI);
        assert!(home.rotation.angle_to(&down) < 1e-6);
        let ur5e = Robot::preset("ur5e").unwrap();
        let home = tcp_pose(&ur5e, &ur5e.home);
        assert!(home.translation.vector.x > 0.3 && (home.rotation * Vec3::z()).z < -0.999_999);
    }

    #[test]
    fn agrees_with_the_maker_s_urdf() {
        // Not every checkout has it; the tables above do not need it.
        let Some(file) = crate::skips::shared("models/robots/panda.urdf") else { return };
        let model = read_urdf(&file).unwrap();
        let other = Linkage::chain(&model, "panda_link0", "panda_hand_tcp").unwrap();
        let robot = Robot::preset("panda").unwrap();
        let mut frames = Frames::default();
        for q in postures(&robot) {
            other.forward(&q, &mut frames);
            let theirs = other.tip_pose(&frames, 0).to_homogeneous();
            assert!(difference(&tcp_pose(&robot, &q), &theirs) < 1e-9);
        }
        for (own, theirs) in robot.linkage.joints().iter().zip(other.joints()) {
            assert_eq!(own, theirs);
        }
    }

    #[test]
    fn the_fr3_slows_down_towards_its_ends() {
        let robot = Robot::preset("fr3").unwrap();
        let l = &robot.limits;
        // In the middle the plain limit, near an end what libfranka's formula gives, outward only.
        assert_eq!(l.velocity_at(1, 0.0, 1.0), 2.62);
        let near = 1.7;
        let by_hand = -0.20 + (5.17f64 * (1.79180 - near)).sqrt();
        assert!((l.velocity_at(1, near, 1.0) - by_hand).abs() < 1e-12 && by_hand < 0.5);
        assert_eq!(l.velocity_at(1, near, -1.0), 2.62);
        assert_eq!(l.velocity_at(1, 1.7918, 1.0), 0.0);
    }

    #[test]
    fn an_unknown_preset_is_suggested() {
        let error = Robot::preset("pandas").unwrap_err();
        assert!(format!("{:?}", miette::Report::new(error)).contains("did you mean `panda`?"));
        for name in PRESETS {
            let robot = Robot::preset(name).unwrap();
            assert_eq!(robot.name, name);
            assert!(!robot.assumed().is_empty() && !robot.sources.is_empty());
            assert!(robot.notes.is_empty());
            // Each stands at home with its tool down, in front, and without touching itself.
            let home = tcp_pose(&robot, &robot.home);
            let is_down = (home.rotation * Vec3::z()).z < -0.999;
            assert!(is_down && home.translation.vector.x > 0.2, "{name}: {home}");
        }
    }
}
