//! Which joint of a skeleton begins which segment, by the joints' names and by what hangs on what.
//!
//! Names count without the case of letters, signs, numbers and what stands before a colon:
//! `mixamorig:RightForeArm`, `r_forearm` and `RForeArm` are one. The names of programs that count
//! segments (`RightUpperArm`) and of those that count joints (`RightShoulder`, `RightElbow`) are both
//! known. The joints of the spine are found by what hangs on them.

use super::skeleton::Skeleton;
use crate::recording::lines::{Fault, shown};

const KNOWN: &str = "joints are known by names such as Hips, Spine, Neck, Head, RightShoulder, RightArm, \
                     RightForeArm, RightHand, RightUpLeg, RightLeg, RightFoot, RightToeBase, and Left the \
                     same; rename them, or export them so";

/// Names of a part of a limb, the surest first.
const UPPER_ARM: &[&str] =
    &["upperarm", "uparm", "arm", "shldr", "shldrbend", "humerus", "shoulder"];
const SHOULDER: &[&str] = &["collar", "collarbone", "clavicle", "shoulder"];
const FORE_ARM: &[&str] = &["forearm", "lowerarm", "lowarm", "forearmbend", "radius", "elbow"];
const HAND: &[&str] = &["hand", "wrist"];
const LOWER_LEG: &[&str] = &["lowerleg", "lowleg", "shin", "calf", "tibia", "knee", "leg"];
const UPPER_LEG: &[&str] = &["upperleg", "upleg", "thigh", "thighbend", "femur", "hip", "leg"];
const FOOT: &[&str] = &["ankle", "foot"];
const TOE: &[&str] = &["toebase", "toe", "toes", "ball", "foot"];
const PELVIS: &[&str] = &["hips", "hip", "pelvis"];
const NECK: &[&str] = &["neck", "lowerneck"];

/// Which side of the body a joint belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Right,
    Left,
}

impl Side {
    /// As in the names of segments.
    pub(super) fn prefix(self) -> &'static str {
        match self {
            Self::Right => "Right",
            Self::Left => "Left",
        }
    }
}

/// The joints of the limbs of one side.
#[derive(Debug, Clone, Default)]
pub(super) struct Limbs {
    pub shoulder: Option<usize>,
    pub upper_arm: usize,
    pub fore_arm: Option<usize>,
    pub hand: Option<usize>,
    pub upper_leg: Option<usize>,
    pub lower_leg: Option<usize>,
    pub foot: Option<usize>,
    pub toe: Option<usize>,
}

/// The joints at which the segments of a person begin.
#[derive(Debug, Clone)]
pub(super) struct Joints {
    pub pelvis: usize,
    /// From the pelvis up; the arms hang on the last one.
    pub spine: Vec<usize>,
    /// The first and the last joint of the neck.
    pub neck: Option<[usize; 2]>,
    pub head: Option<usize>,
    pub right: Limbs,
    pub left: Limbs,
}

impl Joints {
    /// # Errors
    /// Where there is no pelvis, no upper arm on one side, or no joint between pelvis and arms.
    pub(super) fn new(skeleton: &Skeleton) -> Result<Self, Fault> {
        let names: Vec<Name> = skeleton.joints.iter().map(|j| Name::of(&j.name)).collect();
        let finder = Finder { skeleton, names };
        let (right, left) = (finder.limbs(Side::Right)?, finder.limbs(Side::Left)?);
        let pelvis = finder.pelvis(&right, &left).ok_or_else(|| missing("Hips"))?;
        let spine = finder.spine(pelvis, &right, &left)?;
        let trunk = spine.last().copied().unwrap_or(pelvis);
        let head = finder.below(trunk, None, &["head"]);
        let neck = finder.neck(trunk, head);
        let right = finder.hanging(&right, pelvis, trunk);
        let left = finder.hanging(&left, pelvis, trunk);
        Ok(Self { pelvis, spine, neck, head, right, left })
    }

    /// The joint on which the arms hang.
    pub(super) fn trunk(&self) -> usize {
        self.spine.last().copied().unwrap_or(self.pelvis)
    }

    /// The highest joint that there is.
    pub(super) fn top(&self) -> usize {
        self.head.or(self.neck.map(|[neck, _]| neck)).unwrap_or(self.trunk())
    }

    /// The limbs of one side.
    pub(super) fn limbs(&self, side: Side) -> &Limbs {
        match side {
            Side::Right => &self.right,
            Side::Left => &self.left,
        }
    }
}

fn missing(example: &str) -> Fault {
    Fault::whole(format!("has no joint such as `{example}`"), KNOWN)
}

/// A joint's name as it counts.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Name {
    side: Option<Side>,
    /// Small letters only.
    part: String,
}

impl Name {
    fn of(name: &str) -> Self {
        let words = words(name.rsplit(':').next().unwrap_or_default());
        let mut side = None;
        let mut part = String::new();
        for word in &words {
            match (side, word.as_str()) {
                (None, "right" | "r") => side = Some(Side::Right),
                (None, "left" | "l") => side = Some(Side::Left),
                // What rigs are called.
                (_, "bip" | "mixamorig" | "character") => {}
                _ => part += word,
            }
        }
        let known = |part: &str| {
            [UPPER_ARM, SHOULDER, FORE_ARM, HAND, LOWER_LEG, UPPER_LEG, FOOT, TOE]
                .iter()
                .any(|names| names.contains(&part))
        };
        if side.is_none() {
            for (letters, of) in [
                ("right", Side::Right),
                ("left", Side::Left),
                ("r", Side::Right),
                ("l", Side::Left),
            ] {
                if let Some(rest) = part.strip_prefix(letters).filter(|rest| known(rest)) {
                    return Self { side: Some(of), part: rest.to_owned() };
                }
            }
        }
        Self { side, part }
    }
}

/// Runs of letters, cut before a capital that begins a word, in small letters.
fn words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (i, letter) in letters.iter().enumerate() {
        let is_before = |next: Option<&char>| next.is_some_and(|n| n.is_lowercase());
        let is_after = i > 0 && letters[i - 1].is_lowercase();
        let begins = letter.is_uppercase() && (is_after || is_before(letters.get(i + 1)));
        if begins || !letter.is_alphabetic() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| letter.is_alphabetic()) {
            word.extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

struct Finder<'a> {
    skeleton: &'a Skeleton,
    names: Vec<Name>,
}

impl Finder<'_> {
    /// The first joint of the surest name.
    fn find(&self, side: Option<Side>, parts: &[&str], but: Option<usize>) -> Option<usize> {
        parts.iter().find_map(|part| {
            let mut names = self.names.iter().enumerate();
            names
                .find(|(i, name)| name.side == side && name.part == *part && Some(*i) != but)
                .map(|(i, _)| i)
        })
    }

    /// The same, if it hangs on another joint.
    fn below(&self, joint: usize, side: Option<Side>, parts: &[&str]) -> Option<usize> {
        self.find(side, parts, None).filter(|j| *j != joint && self.skeleton.hangs_on(*j, joint))
    }

    fn limbs(&self, side: Side) -> Result<Limbs, Fault> {
        let of = |parts: &[&str], but: Option<usize>| self.find(Some(side), parts, but);
        let upper_arm =
            of(UPPER_ARM, None).ok_or_else(|| missing(&format!("{}Arm", side.prefix())))?;
        let lower_leg = of(LOWER_LEG, None);
        let foot = of(FOOT, None);
        Ok(Limbs {
            shoulder: of(SHOULDER, Some(upper_arm)),
            upper_arm,
            fore_arm: of(FORE_ARM, None),
            hand: of(HAND, None),
            upper_leg: of(UPPER_LEG, lower_leg),
            lower_leg,
            foot,
            toe: of(TOE, foot),
        })
    }

    /// The joint called so, or else the one on which the legs hang.
    fn pelvis(&self, right: &Limbs, left: &Limbs) -> Option<usize> {
        let legs = || self.common(right.upper_leg?, left.upper_leg?);
        self.find(None, PELVIS, None).or_else(legs)
    }

    /// The last joint on which both hang.
    fn common(&self, one: usize, other: usize) -> Option<usize> {
        self.skeleton.upwards(one).find(|j| self.skeleton.hangs_on(other, *j))
    }

    /// The joints after the pelvis up to the one on which the arms hang.
    fn spine(&self, pelvis: usize, right: &Limbs, left: &Limbs) -> Result<Vec<usize>, Fault> {
        let arms = self.common(right.upper_arm, left.upper_arm);
        let is_neck = |joint: &usize| NECK.contains(&self.names[*joint].part.as_str());
        let up = arms.into_iter().flat_map(|arms| self.skeleton.upwards(arms));
        let mut spine: Vec<usize> =
            up.skip_while(is_neck).take_while(|joint| *joint != pelvis).collect();
        spine.reverse();
        let name = shown(&self.skeleton.joints[pelvis].name);
        match spine.first() {
            Some(first) if self.skeleton.joints[*first].parent == Some(pelvis) => Ok(spine),
            Some(_) => Err(Fault::whole(format!("the arms do not hang on `{name}`"), KNOWN)),
            None => {
                let message = format!("has no joint between `{name}` and the arms");
                Err(Fault::whole(message, "export the skeleton with a spine"))
            }
        }
    }

    /// The first and the last joint between the trunk and the head; without a head, the neck alone.
    fn neck(&self, trunk: usize, head: Option<usize>) -> Option<[usize; 2]> {
        let Some(head) = head else {
            return self.below(trunk, None, NECK).map(|neck| [neck; 2]);
        };
        let between = self.skeleton.upwards(head).skip(1).take_while(|j| *j != trunk);
        let between: Vec<usize> = between.collect();
        Some([*between.last()?, *between.first()?])
    }

    /// The limbs without what does not hang on the part before it.
    fn hanging(&self, limbs: &Limbs, pelvis: usize, trunk: usize) -> Limbs {
        let on = |joint: Option<usize>, before: Option<usize>| {
            joint.filter(|j| before.is_some_and(|b| *j != b && self.skeleton.hangs_on(*j, b)))
        };
        let shoulder = on(limbs.shoulder, Some(trunk))
            .filter(|shoulder| self.skeleton.hangs_on(limbs.upper_arm, *shoulder));
        let fore_arm = on(limbs.fore_arm, Some(limbs.upper_arm));
        let upper_leg = on(limbs.upper_leg, Some(pelvis));
        let lower_leg = on(limbs.lower_leg, upper_leg);
        let foot = on(limbs.foot, lower_leg);
        Limbs {
            shoulder,
            upper_arm: limbs.upper_arm,
            fore_arm,
            hand: on(limbs.hand, fore_arm),
            upper_leg,
            lower_leg,
            foot,
            toe: on(limbs.toe, foot),
        }
    }
}

/// Whether a joint's name is that of a thumb.
pub(super) fn is_thumb(name: &str) -> bool {
    words(name).iter().any(|word| word == "thumb")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_count_without_signs_numbers_and_rigs() {
        for (name, side, part) in [
            ("RightForeArm", Some(Side::Right), "forearm"),
            ("mixamorig:RightForeArm", Some(Side::Right), "forearm"),
            ("r_forearm", Some(Side::Right), "forearm"),
            ("RForeArm", Some(Side::Right), "forearm"),
            ("rForeArm", Some(Side::Right), "forearm"),
            ("RIGHTFOREARM", Some(Side::Right), "forearm"),
            ("upperarm_l", Some(Side::Left), "upperarm"),
            ("thigh.L", Some(Side::Left), "thigh"),
            ("Bip01 L UpperArm", Some(Side::Left), "upperarm"),
            ("lhumerus", Some(Side::Left), "humerus"),
            ("LHipJoint", Some(Side::Left), "hipjoint"),
            ("Character1_LeftToeBase", Some(Side::Left), "toebase"),
            ("Neck1", None, "neck"),
            ("lowerback", None, "lowerback"),
            ("leg", None, "leg"),
            ("", None, ""),
        ] {
            assert_eq!(Name::of(name), Name { side, part: part.to_owned() }, "{name}");
        }
        assert!(is_thumb("RightHandThumb2") && is_thumb("LThumb") && !is_thumb("RightHand"));
    }
}
