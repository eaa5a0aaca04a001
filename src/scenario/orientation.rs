//! An orientation as it is written: angles, a quaternion, or where axes and bar point.

use super::file::{BaseFile, Direction, HandGripFile, TcpFile};
use super::plausible;
use super::source::Source;
use crate::files::InputError;
use crate::math::Vec3;
use crate::math::pose::rotation_from_axes;
use crate::physical::{ANGLE_DEG, DIRECTION};
use nalgebra::{Quaternion, UnitQuaternion};

/// Least length of a direction.
const SHORTEST: f64 = 1e-6;
/// How far two directions may miss the angle that they should have, deg.
const SLACK_DEG: f64 = 1.0;
/// Angle below which a bar lies along the tool's axis, and two directions are one, deg.
const LEAST_ANGLE_DEG: f64 = 10.0;

/// Everything that an orientation may be given by.
#[derive(Debug, Default)]
pub(super) struct Turned<'a> {
    pub rpy_deg: Option<[f64; 3]>,
    pub quaternion: Option<[f64; 4]>,
    pub pointing: Option<&'a Direction>,
    pub x_along: Option<&'a Direction>,
    pub bar_along: Option<&'a Direction>,
}

/// How a pose is turned about the direction that it points in, where its other keys do not say.
#[derive(Debug, Clone, Copy)]
pub(super) enum About<'a> {
    /// It has to be said, by these keys.
    Said(&'a str),
    /// The x axis points this way or, where the pose points along it, up.
    Ahead(Vec3),
}

impl<'a> From<&'a TcpFile> for Turned<'a> {
    fn from(file: &'a TcpFile) -> Self {
        Self {
            rpy_deg: file.rpy_deg,
            quaternion: file.quaternion_wxyz,
            pointing: file.pointing.as_ref(),
            x_along: file.x_along.as_ref(),
            bar_along: file.bar_along.as_ref(),
        }
    }
}

impl<'a> From<&'a HandGripFile> for Turned<'a> {
    fn from(file: &'a HandGripFile) -> Self {
        Self {
            rpy_deg: file.rpy_deg,
            quaternion: file.quaternion_wxyz,
            pointing: file.pointing.as_ref(),
            x_along: file.x_along.as_ref(),
            bar_along: None,
        }
    }
}

impl<'a> From<&'a BaseFile> for Turned<'a> {
    fn from(file: &'a BaseFile) -> Self {
        Self {
            rpy_deg: file.rpy_deg,
            quaternion: file.quaternion_wxyz,
            pointing: file.pointing.as_ref(),
            x_along: file.x_along.as_ref(),
            bar_along: None,
        }
    }
}

impl Turned<'_> {
    /// Whether nothing is given.
    pub(super) fn is_empty(&self) -> bool {
        self.rpy_deg.is_none() && self.quaternion.is_none() && self.direction().is_none()
    }

    /// The first of the directions that are given.
    fn direction(&self) -> Option<(&'static str, &Direction)> {
        let all =
            [("pointing", self.pointing), ("x_along", self.x_along), ("bar_along", self.bar_along)];
        all.into_iter().find_map(|(key, at)| Some((key, at?)))
    }
}

impl Source<'_> {
    /// The orientation; none where nothing is given. A `bar_along` is not looked at here.
    pub(super) fn rotation(
        &self,
        turned: &Turned,
        key: &str,
        about: About,
    ) -> Result<Option<UnitQuaternion<f64>>, InputError> {
        let angles = match (turned.rpy_deg, turned.quaternion) {
            (Some(_), Some(_)) => {
                return Err(self
                    .plain(format!("{key} has both rpy_deg and quaternion_wxyz"))
                    .remedy("keep one of them"));
            }
            (Some(_), None) => Some("rpy_deg"),
            (None, Some(_)) => Some("quaternion_wxyz"),
            (None, None) => None,
        };
        let direction = turned.direction();
        if let (Some(angles), Some((name, at))) = (angles, direction) {
            return Err(self
                .error(at, format!("{key} has both {angles} and {name}"))
                .remedy("keep the angles or the directions"));
        }
        if let Some(rpy) = turned.rpy_deg {
            return self.angles(rpy, key).map(Some);
        }
        if let Some(quaternion) = turned.quaternion {
            return self.quaternion(quaternion, key).map(Some);
        }
        let Some((name, at)) = direction else { return Ok(None) };
        let Some(pointing) = turned.pointing else {
            return Err(self.error(at, format!("{key} has {name} without pointing")).remedy(
                "add pointing, the direction of the z axis: pointing = [0, 0, -1] is down",
            ));
        };
        let z = self.direction(pointing, &format!("{key}.pointing"))?;
        let x = match (turned.x_along, about) {
            (Some(x_along), _) => self.across(x_along, (pointing, z), key)?,
            (None, About::Ahead(ahead)) => {
                let across = ahead - z * z.dot(&ahead);
                // Within 45 deg of ahead or behind, up is more across.
                let up = Vec3::z() - z * z.z;
                let x = if across.norm_squared() < 0.5 { up } else { across };
                x.normalize()
            }
            (None, About::Said(keys)) => {
                return Err(self
                    .error(pointing, format!("{key}.pointing alone leaves the turn about it open"))
                    .remedy(format!("add {keys}")));
            }
        };
        Ok(Some(rotation_from_axes(x, z.cross(&x), z)))
    }

    /// The orientation for which the tool points and the bar in the tool's frame runs as asked.
    pub(super) fn along_bar(
        &self,
        (pointing, along): (&Direction, &Direction),
        key: &str,
        bar: &Vec3,
    ) -> Result<UnitQuaternion<f64>, InputError> {
        let z = self.direction(pointing, &format!("{key}.pointing"))?;
        let b = self.direction(along, &format!("{key}.bar_along"))?;
        let own = bar.angle(&Vec3::z()).to_degrees();
        if !(LEAST_ANGLE_DEG..=180.0 - LEAST_ANGLE_DEG).contains(&own) {
            return Err(self
                .error(along, format!("{key}.bar_along: the held bar lies along the tool's own axis, so it leaves the turn about that open"))
                .remedy("say where the tool's x axis points: x_along instead of bar_along"));
        }
        let across = b - z * z.dot(&b);
        let given = z.angle(&b).to_degrees();
        if (given - own).abs() > SLACK_DEG {
            let error = self.error(
                along,
                format!(
                    "{key}.bar_along is at {given:.0} deg to pointing, but the held bar at {own:.0} deg to the \
                     tool's axis"
                ),
            );
            return Err(if across.norm() < SHORTEST {
                error.remedy("give a bar_along across pointing")
            } else {
                let (sin, cos) = own.to_radians().sin_cos();
                let nearest = z * cos + across.normalize() * sin;
                error.remedy(format!("the nearest that fits: bar_along = {}", written(&nearest)))
            });
        }
        let axes = |z: Vec3, bar: Vec3| {
            let x = (bar - z * z.dot(&bar)).normalize();
            rotation_from_axes(x, z.cross(&x), z)
        };
        Ok(axes(z, b) * axes(Vec3::z(), *bar).inverse())
    }

    /// A direction of unit length.
    pub(super) fn direction(&self, at: &Direction, key: &str) -> Result<Vec3, InputError> {
        let given = Vec3::from(*at.get_ref());
        let length = given.norm();
        let is_sane = DIRECTION.outside(given.iter().copied()).is_none();
        if is_sane && length > SHORTEST {
            return Ok(given / length);
        }
        let given = at.get_ref();
        Err(self.error(at, format!("{key} = {given:?} is no direction")).remedy(
            "give x, y, z of a direction, such as [0, 0, -1] for down; its length does not count",
        ))
    }

    /// `x_along` at a right angle to the z axis.
    fn across(
        &self,
        x_along: &Direction,
        (pointing, z): (&Direction, Vec3),
        key: &str,
    ) -> Result<Vec3, InputError> {
        let x = self.direction(x_along, &format!("{key}.x_along"))?;
        let angle = z.angle(&x).to_degrees();
        let across = x - z * z.dot(&x);
        if (angle - 90.0).abs() <= SLACK_DEG {
            return Ok(across.normalize());
        }
        let given = pointing.get_ref();
        let is_parallel = !(LEAST_ANGLE_DEG..=180.0 - LEAST_ANGLE_DEG).contains(&angle);
        if is_parallel {
            return Err(self
                .error(x_along, format!("{key}.x_along runs along pointing = {given:?}"))
                .remedy("give a direction across it: x and z axis are at a right angle"));
        }
        let message = format!(
            "{key}.x_along is at {angle:.0} deg to pointing = {given:?}, not at a right angle"
        );
        Err(self
            .error(x_along, message)
            .remedy(format!("the nearest that fits: x_along = {}", written(&across.normalize()))))
    }

    fn angles(&self, rpy: [f64; 3], key: &str) -> Result<UnitQuaternion<f64>, InputError> {
        if ANGLE_DEG.outside(rpy).is_some() {
            let message = format!("{key}.rpy_deg = {rpy:?} is outside {ANGLE_DEG}");
            return Err(self.plain(message).remedy("angles are in degrees, within a turn"));
        }
        self.doubt(plausible::radians(&format!("{key}.rpy_deg"), &rpy));
        let [r, p, y] = rpy.map(f64::to_radians);
        Ok(UnitQuaternion::from_euler_angles(r, p, y))
    }

    fn quaternion(
        &self,
        [w, x, y, z]: [f64; 4],
        key: &str,
    ) -> Result<UnitQuaternion<f64>, InputError> {
        let q = Quaternion::new(w, x, y, z);
        if !(0.99..=1.01).contains(&q.norm()) {
            let message = format!("{key}.quaternion_wxyz has norm {:.4}, not 1", q.norm());
            return Err(self.plain(message).remedy("the scalar part w comes first"));
        }
        Ok(UnitQuaternion::new_normalize(q))
    }
}

/// A direction as it can be typed, with as many digits as keep its angle.
fn written(direction: &Vec3) -> String {
    let part = |v: f64| {
        let rounded = (v * 1e4).round() / 1e4;
        // No minus before a zero.
        if rounded == 0.0 { 0.0 } else { rounded }
    };
    format!("[{}, {}, {}]", part(direction.x), part(direction.y), part(direction.z))
}
