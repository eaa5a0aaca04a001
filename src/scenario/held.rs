//! How the hand holds the tool, and from that where tool and hand are at start and goal.
//!
//! A named grip says how the hand is turned at the start, as the worker sees it; with the tool's
//! orientation there that gives its constant pose in the frame of the TCP. Where the grip is given in that
//! frame itself, a `bar_along` of the start turns the tool instead.

use super::check::Scenario;
use super::file::{Direction, GripFile, HandGripFile, TcpFile};
use super::orientation::{About, Turned};
use super::source::Source;
use crate::files::{InputError, suggest};
use crate::human::{Hands, NamedGrip, Side};
use crate::math::{Pose, Vec3};
use crate::posture::Hold;
use nalgebra::UnitQuaternion;
use toml::Spanned;

/// Farthest that `bar_along` may turn a named grip, deg.
const MOST_TURNED_DEG: f64 = 60.0;

/// The other hand where both hold on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondHand {
    /// Its grip in the frame of the leading hand's grip.
    pub between: Pose,
    /// What the robot prescribes of it.
    pub hold: Hold,
}

/// The tool in the hand, or in both.
#[derive(Debug)]
pub(super) struct Held {
    /// Pose of the leading hand's grip in the frame of the TCP.
    pub grip: Pose,
    pub hold: Hold,
    pub second_hand: Option<SecondHand>,
    /// TCP at the start, world.
    pub start: Pose,
    /// Where the worker looks.
    ahead: Vec3,
    is_named: bool,
}

impl Scenario {
    /// Where the hands are, world, with the TCP at a pose; the leading one first.
    pub fn hands_at(&self, tcp: &Pose) -> Vec<(Side, Pose)> {
        let first = tcp * self.grip;
        let sides = self.worker.hands.sides().iter().copied();
        let poses = [Some(first), self.second_hand.map(|s| first * s.between)];
        sides.zip(poses.into_iter().flatten()).collect()
    }
}

/// One hand as the file has it.
struct HandFile<'a> {
    side: Side,
    file: &'a HandGripFile,
    key: &'static str,
    name: Option<NamedGrip>,
}

impl Held {
    /// From `[grip]` and `[start]`.
    pub(super) fn resolve(
        source: &Source,
        (grip, start): (&GripFile, &Spanned<TcpFile>),
        (hands, facing): (Hands, f64),
    ) -> Result<Self, InputError> {
        let own = grip.own();
        let files = hands_of(source, (grip, &own), hands)?;
        let is_named = files.iter().any(|h| h.name.is_some());
        let worker = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), facing);
        let mut held = Self {
            grip: Pose::identity(),
            hold: Hold::Rigid,
            second_hand: None,
            start: Pose::identity(),
            ahead: worker * Vec3::x(),
            is_named,
        };
        let mut seen = Vec::new();
        let mut turned = Turned::from(start.get_ref());
        if is_named {
            // The bar is the hand's here, and not the tool's.
            turned.bar_along = None;
            let tool = held.turn(source, (start, &turned), "start")?;
            let bar = start.get_ref().bar_along.as_ref();
            let leaning = bar.map(|b| bar_turn(source, b, &files[0], &worker)).transpose()?;
            let tilt = leaning.unwrap_or_default() * worker;
            for hand in &files {
                seen.push(named_pose(source, hand, (&tool, &worker, &tilt))?);
            }
        } else {
            for hand in &files {
                seen.push(own_pose(source, hand)?);
            }
        }
        held.grip = seen[0];
        held.hold = hold_of(source, &files[0])?;
        if let Some(second) = files.get(1) {
            let hold = hold_of(source, second)?;
            held.second_hand = Some(SecondHand { between: seen[0].inverse() * seen[1], hold });
        }
        held.start = held.placed(source, (start, &turned), "start")?;
        Ok(held)
    }

    /// Where the hand, or the middle between both, is in the frame of the TCP.
    fn hand(&self) -> Vec3 {
        let first = self.grip.translation.vector;
        self.second_hand
            .map_or(first, |s| (first + (self.grip * s.between).translation.vector) / 2.0)
    }

    /// The pose of the TCP, world.
    pub(super) fn pose(
        &self,
        source: &Source,
        at: &Spanned<TcpFile>,
        key: &str,
    ) -> Result<Pose, InputError> {
        self.placed(source, (at, &Turned::from(at.get_ref())), key)
    }

    fn placed(
        &self,
        source: &Source,
        (at, turned): (&Spanned<TcpFile>, &Turned),
        key: &str,
    ) -> Result<Pose, InputError> {
        let turn = self.turn(source, (at, turned), key)?;
        let placed = |e: InputError| source.at(at, e);
        let place = match (at.get_ref().position_m, &at.get_ref().hand_at_m) {
            (Some(_), Some(hand)) => {
                return Err(source
                    .error(hand, format!("{key} has both position_m and hand_at_m"))
                    .remedy("keep the place of the TCP or that of the hand: the grip says where the other is"));
            }
            (None, None) => {
                return Err(source
                    .error(at, format!("{key} has no place"))
                    .remedy("give hand_at_m, the place of the hand, or position_m, that of the TCP, in metres"));
            }
            (Some(tcp), None) => {
                source.refuse_far(&format!("{key}.position_m"), &tcp).map_err(placed)?;
                Vec3::from(tcp)
            }
            (None, Some(hand)) => {
                source
                    .refuse_far(&format!("{key}.hand_at_m"), hand.get_ref())
                    .map_err(|e| source.at(hand, e))?;
                Vec3::from(*hand.get_ref()) - turn * self.hand()
            }
        };
        // Rounding errors are no places.
        let place = place.map(|v| if v.abs() < 1e-12 { 0.0 } else { v });
        Ok(Pose::from_parts(place.into(), turn))
    }

    /// How the TCP is turned at a place.
    fn turn(
        &self,
        source: &Source,
        (at, turned): (&Spanned<TcpFile>, &Turned),
        key: &str,
    ) -> Result<UnitQuaternion<f64>, InputError> {
        if let (Some(bar), Some(_)) = (turned.bar_along, turned.x_along) {
            return Err(source
                .error(bar, format!("{key} has both x_along and bar_along"))
                .remedy("keep one: either fixes the turn about pointing"));
        }
        let is_by_bar = turned.rpy_deg.is_none() && turned.quaternion.is_none();
        if let (Some(pointing), Some(bar), true) = (turned.pointing, turned.bar_along, is_by_bar) {
            return self.by_bar(source, (pointing, bar), key);
        }
        let about = match (self.is_named, turned.bar_along) {
            (true, None) => About::Ahead(self.ahead),
            _ => About::Said(
                "bar_along, where the held bar runs, or x_along, where the tool's x axis points",
            ),
        };
        match source.rotation(turned, key, about).map_err(|e| source.beside(at, e))? {
            Some(turn) => Ok(turn),
            None if self.is_named => Err(source
                .error(at, format!("{key} does not say how the tool is turned"))
                .remedy("add pointing, where its z axis points: pointing = [0, 0, -1] is down")),
            None => Ok(UnitQuaternion::identity()),
        }
    }

    /// The turn that lays the held bar as asked. With a named grip it has no direction: of the two turns
    /// the one nearer to the start's counts.
    fn by_bar(
        &self,
        source: &Source,
        directions: (&Direction, &Direction),
        key: &str,
    ) -> Result<UnitQuaternion<f64>, InputError> {
        let bar = self.grip.rotation * Vec3::z();
        let towards = source.along_bar(directions, key, &bar);
        if !self.is_named {
            return towards;
        }
        let away = source.along_bar(directions, key, &-bar);
        let off = |turn: &UnitQuaternion<f64>| turn.angle_to(&self.start.rotation);
        match (towards, away) {
            (Ok(a), Ok(b)) => Ok(if off(&b) < off(&a) { b } else { a }),
            (Ok(one), Err(_)) | (Err(_), Ok(one)) => Ok(one),
            (Err(why), Err(_)) => Err(why),
        }
    }
}

/// The hands that hold on, the leading one first.
fn hands_of<'a>(
    source: &Source,
    (file, own): (&'a GripFile, &'a HandGripFile),
    hands: Hands,
) -> Result<Vec<HandFile<'a>>, InputError> {
    let of = |side, file: &'a HandGripFile, key| {
        let name = file.grip.as_ref().map(|at| named(source, at, key)).transpose()?;
        Ok::<_, InputError>(HandFile { side, file, key, name })
    };
    match (hands, &file.right, &file.left) {
        (Hands::Both, Some(right), Some(left)) => {
            if *own != HandGripFile::default() {
                return Err(source
                    .plain("worker.hands is \"both\", and [grip] has keys of its own")
                    .remedy("keep [grip.right] and [grip.left] only"));
            }
            let both =
                vec![of(Side::Right, right, "grip.right")?, of(Side::Left, left, "grip.left")?];
            if both[0].name.is_some() != both[1].name.is_some() {
                return Err(source
                    .plain("one of [grip.right] and [grip.left] has a named grip, the other has not")
                    .remedy("name the grip of each hand, or give the pose of each in the frame of the TCP"));
            }
            Ok(both)
        }
        (Hands::Both, ..) => Err(source
            .plain("worker.hands is \"both\", but [grip.right] or [grip.left] is missing")
            .remedy("name the grip of each hand, or give the pose of each in the frame of the TCP and its hold")),
        (_, None, None) => Ok(vec![of(hands.lead(), own, "grip")?]),
        _ => Err(source
            .plain("[grip.right] and [grip.left] are for worker.hands = \"both\"")
            .remedy("set worker.hands = \"both\", or give the one hand's pose in [grip]")),
    }
}

fn named(source: &Source, at: &Spanned<String>, key: &str) -> Result<NamedGrip, InputError> {
    let name = at.get_ref();
    NamedGrip::by_name(name).ok_or_else(|| {
        let known = NamedGrip::names();
        let help = suggest(name, known).unwrap_or_else(|| format!("grips: {}", known.join(", ")));
        source.error(at, format!("{key}.grip = \"{name}\" is not known")).remedy(help)
    })
}

/// What the robot prescribes of a hand with a named grip: on a bar it can turn about that, what is pinched
/// turns it along.
pub(super) fn usual_hold(grip: NamedGrip) -> Hold {
    match grip {
        NamedGrip::PinchFromAbove => Hold::Rigid,
        _ => Hold::FreeRoll,
    }
}

/// What the robot prescribes of a hand.
fn hold_of(source: &Source, hand: &HandFile) -> Result<Hold, InputError> {
    hand.file.hold.or(hand.name.map(usual_hold)).ok_or_else(|| {
        source
            .plain(format!("{}.hold is missing", hand.key))
            .remedy("use \"rigid\", \"free_roll\" or \"point\", or name the grip: grip = \"vertical_handle\"")
    })
}

/// A grip in the frame of the TCP, as the file gives it.
fn own_pose(source: &Source, hand: &HandFile) -> Result<Pose, InputError> {
    let key = hand.key;
    if let Some(at) = &hand.file.from_tcp_m {
        return Err(source
            .error(at, format!("{key}.from_tcp_m goes with a named grip only"))
            .remedy("give position_m in the frame of the TCP, or name the grip"));
    }
    let position = hand.file.position_m.unwrap_or_default();
    source.refuse_off_tool(&format!("{key}.position_m"), &position)?;
    let about =
        About::Said("x_along: out of the palm of a right hand, out of the back of a left one");
    let turn = source.rotation(&Turned::from(hand.file), key, about)?;
    Ok(Pose::from_parts(Vec3::from(position).into(), turn.unwrap_or_default()))
}

/// A named grip in the frame of the TCP, from how the tool, the worker and the hand's bar are turned at the
/// start.
fn named_pose(
    source: &Source,
    hand: &HandFile,
    (tool, worker, tilt): (&UnitQuaternion<f64>, &UnitQuaternion<f64>, &UnitQuaternion<f64>),
) -> Result<Pose, InputError> {
    let (key, file) = (hand.key, hand.file);
    let (Some(name), Some(at)) = (hand.name, &file.grip) else { return own_pose(source, hand) };
    if !Turned::from(file).is_empty() {
        return Err(source
            .error(at, format!("{key} has a named grip and an orientation"))
            .remedy("keep one: the name says how the hand is turned"));
    }
    let place = match (file.position_m, &file.from_tcp_m) {
        (Some(_), Some(from)) => {
            return Err(source
                .error(from, format!("{key} has both position_m and from_tcp_m"))
                .remedy("keep one of them: both say where the hand is from the TCP"));
        }
        (position, None) => {
            let position = position.unwrap_or_default();
            source.refuse_off_tool(&format!("{key}.position_m"), &position)?;
            Vec3::from(position)
        }
        (None, Some(from)) => {
            source
                .refuse_off_tool(&format!("{key}.from_tcp_m"), from.get_ref())
                .map_err(|e| source.at(from, e))?;
            tool.inverse() * (worker * Vec3::from(*from.get_ref()))
        }
    };
    Ok(Pose::from_parts(place.into(), tool.inverse() * (tilt * name.turn(hand.side))))
}

/// The shortest turn that lays the bar of a named grip along a direction, one way or the other.
fn bar_turn(
    source: &Source,
    along: &Direction,
    hand: &HandFile,
    worker: &UnitQuaternion<f64>,
) -> Result<UnitQuaternion<f64>, InputError> {
    let asked = source.direction(along, "start.bar_along")?;
    let Some(name) = hand.name else { return Ok(UnitQuaternion::identity()) };
    let usual = worker * (name.turn(hand.side) * Vec3::z());
    let asked = if usual.dot(&asked) < 0.0 { -asked } else { asked };
    let angle = usual.angle(&asked).to_degrees();
    if angle > MOST_TURNED_DEG {
        let message = format!(
            "start.bar_along is {angle:.0} deg from the bar of `{}`, at most {MOST_TURNED_DEG} are possible",
            name.name()
        );
        return Err(source
            .error(along, message)
            .remedy(format!("take another grip: {}", NamedGrip::names().join(", "))));
    }
    Ok(UnitQuaternion::rotation_between(&usual, &asked).unwrap_or_default())
}

#[cfg(test)]
mod tests;
