//! Why a path is refused or marked, as facts; `words` puts them into English.

use crate::path::{Change, Check, End, NoPath};
use crate::posture::Hold;
use crate::robot::{JointMargin, LimitKind, NoMotion, Violation};
use serde::{Deserialize, Serialize};
use std::mem::{Discriminant, discriminant};

/// What refuses a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RefusedBy {
    /// The limits of the path.
    Path,
    /// The robot.
    Robot,
    /// An obstacle that a link touches.
    Obstacle,
    /// The worker's reach.
    Worker,
    /// The distance to the person.
    Person,
}

/// Why a path cannot be used, or what the user's own breaks. Lengths in m, times in s, angles in rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "refusal", rename_all = "snake_case")]
pub enum Refusal {
    /// There is no such path.
    Path(NoPath),
    /// A limit of the path is broken.
    Limit(Check),
    /// The robot cannot follow.
    Robot(NoMotion),
    /// The robot cannot even start.
    Start {
        /// Distance of the nearest posture from the start; none if no posture was found.
        residual_m: Option<f64>,
        /// Its angle from it.
        residual_rad: Option<f64>,
    },
    /// A joint breaks a limit between the points of the trajectory, as a controller would run them.
    BetweenKnots(JointMargin),
    /// A joint breaks a limit.
    JointLimit(Violation),
    /// A link touches an obstacle.
    Obstacle {
        /// The link.
        link: String,
        /// The obstacle.
        obstacle: String,
        /// How deep; 0 is a touch.
        depth_m: f64,
    },
    /// No repetition of a body follows to the end.
    Worker {
        /// The body.
        body: String,
        /// When the first hand is lost.
        from_s: f64,
    },
    /// The robot comes too near to a person in too many repetitions.
    Person {
        /// Whose body.
        body: String,
        /// Link of the robot where it is nearest.
        link: String,
        /// Body part there.
        body_part: String,
        /// Share of repetitions nearer than the margin.
        share_below: f64,
        /// Share that may be.
        share_allowed: f64,
        /// The margin.
        margin_m: f64,
        /// 5th percentile of the least distance over repetitions.
        p05_m: f64,
    },
}

/// What makes refusals of one kind: the same reason about the same things, whatever the numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RefusalKind<'a> {
    refusal: Discriminant<Refusal>,
    path: Option<Discriminant<NoPath>>,
    motion: Option<Discriminant<NoMotion>>,
    limit: Option<LimitKind>,
    end: Option<End>,
    about: Vec<&'a str>,
}

impl Refusal {
    /// What refuses the path.
    pub fn by(&self) -> RefusedBy {
        match self {
            Self::Path(_) | Self::Limit(_) => RefusedBy::Path,
            Self::Robot(_) | Self::Start { .. } | Self::BetweenKnots(_) | Self::JointLimit(_) => {
                RefusedBy::Robot
            }
            Self::Obstacle { .. } => RefusedBy::Obstacle,
            Self::Worker { .. } => RefusedBy::Worker,
            Self::Person { .. } => RefusedBy::Person,
        }
    }

    /// What makes it equal in kind to others.
    pub fn kind(&self) -> RefusalKind<'_> {
        let mut kind = RefusalKind {
            refusal: discriminant(self),
            path: None,
            motion: None,
            limit: None,
            end: None,
            about: Vec::new(),
        };
        match self {
            Self::Path(why) => kind.tell_path(why),
            Self::Robot(why) => kind.tell_motion(why),
            Self::JointLimit(v) => kind.tell_violation(v),
            Self::BetweenKnots(margin) => kind.about.push(&margin.joint),
            Self::Obstacle { link, obstacle, .. } => kind.about.extend([link.as_str(), obstacle]),
            Self::Worker { body, .. } => kind.about.push(body),
            Self::Person { body, link, body_part, .. } => {
                kind.about.extend([body.as_str(), link, body_part]);
            }
            Self::Limit(_) | Self::Start { .. } => {}
        }
        kind
    }
}

impl<'a> RefusalKind<'a> {
    fn tell_path(&mut self, why: &'a NoPath) {
        self.path = Some(discriminant(why));
        match why {
            NoPath::OutsideBox { end, .. } => self.end = Some(*end),
            NoPath::InsideObstacle { end, obstacle: about, .. }
            | NoPath::BeyondReach { end, body: about, .. } => {
                self.end = Some(*end);
                self.about.push(about);
            }
            NoPath::Blocked { obstacle: about, .. } | NoPath::LeavesReach { body: about, .. } => {
                self.about.push(about);
            }
            NoPath::NoMotion { motion } => self.tell_motion(motion),
            NoPath::Input { .. }
            | NoPath::TooShortToTurn { .. }
            | NoPath::TooShort { .. }
            | NoPath::JointsTooSlow
            | NoPath::Contradiction { .. }
            | NoPath::Corridor { .. }
            | NoPath::Unsolved { .. } => {}
        }
    }

    fn tell_motion(&mut self, why: &'a NoMotion) {
        self.motion = Some(discriminant(why));
        match why {
            NoMotion::OutOfReach { at_limits, .. } | NoMotion::Jump { at_limits, .. } => {
                self.about.extend(at_limits.iter().map(|l| l.joint.as_str()));
            }
            NoMotion::OverLimit { violation, .. } => self.tell_violation(violation),
            NoMotion::TouchesItself { nearest } => {
                self.about.extend(nearest.links.iter().map(String::as_str));
            }
            NoMotion::BetweenKnots { joint, of, .. } => {
                self.limit = Some(*of);
                self.about.push(joint);
            }
            NoMotion::Malformed { .. } | NoMotion::NoStart => {}
        }
    }

    fn tell_violation(&mut self, violation: &'a Violation) {
        self.limit = Some(violation.kind);
        self.about.push(&violation.joint);
    }
}

impl From<NoPath> for Refusal {
    fn from(why: NoPath) -> Self {
        match why {
            NoPath::NoMotion { motion } => Self::Robot(motion),
            why => Self::Path(why),
        }
    }
}

/// Whether a path can be used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "state", rename_all = "kebab-case")]
pub enum Status {
    /// All limits are kept.
    Feasible,
    /// The user's own path breaks a limit; it is scored all the same.
    Marked {
        /// One for each limit.
        violations: Vec<Refusal>,
    },
    /// It cannot be used.
    Infeasible {
        /// Why.
        refusal: Refusal,
    },
}

impl Status {
    /// Refuses a path, or marks it if it is the user's own.
    pub(super) fn refuse(&mut self, is_users: bool, refusal: Refusal) {
        match self {
            Self::Marked { violations } => violations.push(refusal),
            status if is_users => *status = Self::Marked { violations: vec![refusal] },
            status => *status = Self::Infeasible { refusal },
        }
    }

    /// What refuses the path, if anything does.
    pub fn refused_by(&self) -> Option<RefusedBy> {
        match self {
            Self::Infeasible { refusal } => Some(refusal.by()),
            Self::Feasible | Self::Marked { .. } => None,
        }
    }
}

/// Refused paths of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RefusedGroup {
    /// The first of them.
    pub first: Refusal,
    /// How many there are.
    pub count: usize,
    /// Whether all are like the first in every number.
    pub all_equal: bool,
}

impl RefusedGroup {
    /// Groups refusals by kind: the most frequent first, of equal ones the earlier.
    pub fn of<'a>(refusals: impl Iterator<Item = &'a Refusal>) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for refusal in refusals {
            match groups.iter_mut().find(|g| g.first.kind() == refusal.kind()) {
                Some(group) => {
                    group.count += 1;
                    group.all_equal &= group.first == *refusal;
                }
                None => {
                    groups.push(Self { first: refusal.clone(), count: 1, all_equal: true });
                }
            }
        }
        groups.sort_by_key(|g| std::cmp::Reverse(g.count));
        groups
    }
}

/// What a reader of a run without a feasible path may try, or should know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "hint", rename_all = "snake_case")]
pub enum Hint {
    /// Every place of the path can be reached by the hand, but not turned and led like this.
    HandTurned {
        /// What the robot prescribes now.
        hold: Hold,
    },
    /// The smallest changes, each alone, that would make the straight path (else the first) feasible.
    Changes {
        /// Computed, not tried.
        changes: Vec<Change>,
    },
    /// Of the paths that came too near to a person the one that lacks least.
    NearestToFeasible {
        /// Its id.
        id: String,
        /// How much of the margin is missing.
        missing_m: f64,
    },
    /// How much farther apart robot and person would have to be for the straight path; each was tried.
    Apart {
        /// None if nothing that was tried is enough.
        changes: Vec<Change>,
        /// The largest distance that was tried.
        tried_m: f64,
    },
    /// A body's hand does not get to an end of the movement.
    Unreached {
        /// The body.
        body: String,
        /// Which end.
        end: End,
        /// Start postures that fail.
        failed: usize,
        /// Start postures that were tried.
        tries: usize,
    },
    /// The hand is so low that people would bend their legs.
    NeedsBentLegs,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::Quantity;

    fn blocked(obstacle: &str, by_m: f64) -> Refusal {
        let obstacle = obstacle.to_owned();
        Refusal::Path(NoPath::Blocked { obstacle, at_s: 1.0, by_m, clearance_m: 0.03 })
    }

    fn joint(joint: &str, kind: LimitKind) -> Refusal {
        Refusal::JointLimit(Violation {
            kind,
            joint: joint.to_owned(),
            is_prismatic: false,
            time_s: 1.5,
            value: 2.0,
            limit: 1.0,
            is_assumed: false,
        })
    }

    #[test]
    fn kinds_tell_names_and_limits_apart_but_not_numbers() {
        assert_eq!(blocked("a", 0.01).kind(), blocked("a", 0.02).kind());
        assert_ne!(blocked("a", 0.01).kind(), blocked("b", 0.01).kind());
        let speed = joint("j1", LimitKind::Velocity);
        assert_ne!(speed.kind(), joint("j1", LimitKind::Acceleration).kind());
        assert_ne!(speed.kind(), joint("j2", LimitKind::Velocity).kind());
        assert_ne!(Refusal::Path(NoPath::JointsTooSlow).kind(), blocked("a", 0.0).kind());
    }

    #[test]
    fn groups_come_by_their_size() {
        let all = [blocked("a", 0.01), blocked("b", 0.03), blocked("b", 0.03), blocked("c", 0.1)];
        let groups = RefusedGroup::of(all.iter().chain([&blocked("c", 0.2), &blocked("c", 0.2)]));
        let told: Vec<_> = groups.iter().map(|g| (g.count, g.all_equal)).collect();
        assert_eq!(told, [(3, false), (2, true), (1, true)]);
        assert_eq!(groups[0].first, blocked("c", 0.1));
    }

    #[test]
    fn what_is_written_reads_back() {
        let check = Check { quantity: Quantity::Speed, value: 0.3, limit: 0.25, at_s: 1.0 };
        let margin = JointMargin {
            joint: "j".to_owned(),
            position_margin: None,
            velocity_share: Some(1.2),
            acceleration_share: None,
        };
        let reach = NoMotion::OutOfReach {
            time_s: 2.0,
            residual_m: 0.25,
            residual_rad: 0.5,
            at_limits: vec![crate::robot::AtLimit {
                joint: "j".to_owned(),
                limit: 1.0,
                is_prismatic: false,
            }],
        };
        let all = vec![
            blocked("a", 0.01),
            joint("j1", LimitKind::Position),
            Refusal::Limit(check),
            Refusal::BetweenKnots(margin),
            Refusal::Start { residual_m: Some(0.1), residual_rad: None },
            Refusal::from(NoPath::from(reach)),
            Refusal::Path(crate::trajectory::TrajectoryError::Time(3).into()),
        ];
        let status = Status::Marked { violations: all };
        let text = serde_json::to_string(&status).unwrap();
        assert_eq!(serde_json::from_str::<Status>(&text).unwrap(), status, "{text}");
        let mut status = Status::Feasible;
        status.refuse(false, blocked("a", 0.01));
        assert_eq!(status.refused_by(), Some(RefusedBy::Path));
        let text = serde_json::to_string(&status).unwrap();
        assert!(text.contains(r#""refusal":"path","why":"blocked","obstacle":"a""#), "{text}");
        assert_eq!(serde_json::from_str::<Status>(&text).unwrap(), status);
    }
}
