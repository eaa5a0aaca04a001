//! The text of a BVH file, checked: a skeleton and its values frame by frame.

use super::skeleton::{Channel, Joint, Skeleton};
use crate::math::Vec3;
use crate::recording::lines::{Fault, Line, lines, number, shown};

const AGAIN: &str = "copy or export the file again";
const ALONE: &str = "export each person on their own, without props";
/// Highest rate (Hz) that a frame time may stand for.
const HIGHEST_RATE_HZ: f64 = 10_000.0;
/// Rates (Hz) at which people are recorded.
const USUAL_RATES_HZ: [f64; 14] =
    [24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 150.0, 200.0, 240.0, 250.0, 300.0];

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    pub skeleton: Skeleton,
    /// Values of every frame, T x dof: lengths in the file's unit, angles in rad.
    pub frames: Vec<Vec<f64>>,
    /// Time from frame to frame as the file has it, s.
    pub frame_time_s: f64,
    /// Frames per second that this time stands for, Hz.
    pub rate_hz: f64,
}

/// Reads a file to its end.
pub(super) fn parse(text: &str) -> Result<Motion, Fault> {
    let mut lines = lines(text.trim_start_matches('\u{feff}'));
    match lines.next() {
        Some(line) if line.first.eq_ignore_ascii_case("HIERARCHY") => {}
        Some(line) => {
            let message = format!("begins with `{}`, not with HIERARCHY", shown(line.first));
            return Err(line.fault(message, "is it a .bvh file?"));
        }
        None => return Err(Fault::whole("is empty", AGAIN)),
    }
    let mut skeleton = hierarchy(&mut lines)?;
    let (count_line, count) = frame_count(&mut lines)?;
    let (frame_time_s, rate_hz) = frame_time(&mut lines)?;
    let dof = skeleton.dof();
    let frames = lines.map(|line| row(&line, dof)).collect::<Result<Vec<_>, _>>()?;
    if frames.len() != count {
        let message = format!("`Frames:` says {count}, but {} follow", frames.len());
        return Err(Fault::at(count_line, message, AGAIN));
    }
    if frames.is_empty() {
        return Err(Fault::at(count_line, "holds no frames", AGAIN));
    }
    for joint in &mut skeleton.joints {
        let far = frames.iter().map(|f| joint.shift(f)).fold(0.0, f64::max);
        joint.is_shift = far < 0.5 * joint.offset.norm();
    }
    let frames = in_radians(frames, &skeleton);
    Ok(Motion { skeleton, frames, frame_time_s, rate_hz })
}

/// A joint between its braces.
struct Open {
    joint: usize,
    line: usize,
    has_offset: bool,
}

/// The joints while they are being read.
#[derive(Default)]
struct Parser {
    joints: Vec<Joint>,
    open: Vec<Open>,
    /// Name and line of a joint whose brace is still to come; no name of an end.
    announced: Option<(Option<String>, usize)>,
    dof: usize,
}

/// Reads to the word MOTION.
fn hierarchy<'a>(lines: &mut impl Iterator<Item = Line<'a>>) -> Result<Skeleton, Fault> {
    let mut parser = Parser::default();
    for mut line in lines {
        if line.first.eq_ignore_ascii_case("MOTION") {
            return parser.finish(&line);
        }
        parser.read(&mut line)?;
    }
    Err(Fault::whole("ends before the word MOTION", AGAIN))
}

impl Parser {
    fn read(&mut self, line: &mut Line) -> Result<(), Fault> {
        if self.announced.is_some() && line.first != "{" {
            return Err(line.fault(format!("`{}` comes before a brace", shown(line.first)), AGAIN));
        }
        match line.first.to_ascii_uppercase().as_str() {
            "ROOT" if !self.joints.is_empty() => {
                Err(line.fault("a second ROOT begins here", ALONE))
            }
            "JOINT" | "END" if self.open.is_empty() => {
                Err(line.fault(format!("`{}` stands outside of a ROOT", line.first), AGAIN))
            }
            "ROOT" | "JOINT" | "END" => self.announce(line),
            "{" => self.begin(line),
            "}" => self.end(line),
            "OFFSET" => {
                let offset = Vec3::from(line.three(AGAIN)?);
                let i = self.innermost(line)?.joint;
                self.joints[i].offset = offset;
                Ok(())
            }
            "CHANNELS" => {
                let channels = channels(line)?;
                let i = self.innermost(line)?.joint;
                let joint = &mut self.joints[i];
                if !joint.channels.is_empty() {
                    return Err(line.fault("the channels of a joint are given twice", AGAIN));
                }
                joint.first = self.dof;
                self.dof += channels.len();
                joint.channels = channels;
                Ok(())
            }
            _ => {
                let message = format!("`{}` is not known in a skeleton", shown(line.first));
                Err(line.fault(message, AGAIN))
            }
        }
    }

    fn announce(&mut self, line: &mut Line) -> Result<(), Fault> {
        // Some programs put spaces into names.
        let mut words: Vec<&str> = line.rest.by_ref().collect();
        let has_brace = words.last() == Some(&"{");
        if has_brace {
            words.pop();
        }
        let is_end = line.first.eq_ignore_ascii_case("END");
        let name = (!is_end).then(|| words.join(" "));
        if name.as_ref().is_some_and(String::is_empty) {
            return Err(line.fault("a joint has no name", AGAIN));
        }
        self.announced = Some((name, line.number));
        if has_brace { self.begin(line) } else { Ok(()) }
    }

    fn begin(&mut self, line: &Line) -> Result<(), Fault> {
        let Some((name, number)) = self.announced.take() else {
            return Err(line.fault("a brace opens without a joint", AGAIN));
        };
        let joint = self.joints.len();
        self.joints.push(Joint {
            name: name.unwrap_or_default(),
            parent: self.open.last().map(|o| o.joint),
            offset: Vec3::zeros(),
            channels: Vec::new(),
            first: 0,
            is_shift: false,
        });
        self.open.push(Open { joint, line: number, has_offset: false });
        Ok(())
    }

    fn end(&mut self, line: &Line) -> Result<(), Fault> {
        let Some(open) = self.open.pop() else {
            return Err(line.fault("a brace closes that never opened", AGAIN));
        };
        if !open.has_offset {
            return Err(Fault::at(open.line, "the joint that begins here has no OFFSET", AGAIN));
        }
        Ok(())
    }

    /// The joint between whose braces a line stands; it has been given its offset by now.
    fn innermost(&mut self, line: &Line) -> Result<&Open, Fault> {
        match self.open.last_mut() {
            Some(open) => {
                open.has_offset = true;
                Ok(open)
            }
            None => Err(line.fault(format!("`{}` stands outside of a joint", line.first), AGAIN)),
        }
    }

    fn finish(self, line: &Line) -> Result<Skeleton, Fault> {
        if let Some(open) = self.open.last() {
            let message = "the joint that begins here has no closing brace before MOTION";
            return Err(Fault::at(open.line, message, AGAIN));
        }
        if self.joints.is_empty() {
            return Err(line.fault("MOTION comes before any ROOT", AGAIN));
        }
        Ok(Skeleton { joints: self.joints })
    }
}

/// The channels that a line counts and lists.
fn channels(line: &mut Line) -> Result<Vec<Channel>, Fault> {
    let count = line.rest.next().and_then(|word| word.parse::<usize>().ok());
    let mut found = Vec::new();
    while let Some(word) = line.rest.next() {
        let lower = word.to_ascii_lowercase();
        let axis = ["x", "y", "z"].iter().position(|axis| lower.starts_with(axis));
        let channel = match (axis, lower.get(1..)) {
            (Some(axis), Some("position")) => Channel::Move(axis),
            (Some(axis), Some("rotation")) => Channel::Turn(axis),
            _ => {
                let message = format!("the channel `{}` is not known", shown(word));
                return Err(line.fault(
                    message,
                    "known are Xposition to Zposition and Xrotation to Zrotation",
                ));
            }
        };
        if found.contains(&channel) {
            return Err(line.fault(format!("`{}` is listed twice", shown(word)), AGAIN));
        }
        found.push(channel);
    }
    if count != Some(found.len()) {
        let message =
            format!("CHANNELS does not begin with the count of its {} channels", found.len());
        return Err(line.fault(message, AGAIN));
    }
    Ok(found)
}

/// The words of a line of the header of the frames, which begins with `wanted`, and its value.
fn header<'a>(
    lines: &mut impl Iterator<Item = Line<'a>>,
    wanted: &str,
) -> Result<(usize, String), Fault> {
    let Some(line) = lines.next() else {
        return Err(Fault::whole(format!("ends before `{wanted}:`"), AGAIN));
    };
    let words: Vec<&str> = std::iter::once(line.first).chain(line.rest).collect();
    let text = words.join(" ");
    let (name, value) = text.split_once(':').unwrap_or((&text, ""));
    if name.trim().eq_ignore_ascii_case(wanted) {
        return Ok((line.number, value.trim().to_owned()));
    }
    let message = format!("`{}` stands where `{wanted}:` should", shown(&text));
    Err(Fault::at(line.number, message, AGAIN))
}

/// The line that counts the frames, and their number.
fn frame_count<'a>(lines: &mut impl Iterator<Item = Line<'a>>) -> Result<(usize, usize), Fault> {
    let (line, word) = header(lines, "Frames")?;
    let count = word.parse().map_err(|_| {
        Fault::at(line, format!("`{}` is no number of frames", shown(&word)), AGAIN)
    })?;
    Ok((line, count))
}

/// The time between frames (s) and the rate (Hz) it stands for.
fn frame_time<'a>(lines: &mut impl Iterator<Item = Line<'a>>) -> Result<(f64, f64), Fault> {
    let (line, word) = header(lines, "Frame Time")?;
    let time = number(&word).filter(|time| (1.0 / HIGHEST_RATE_HZ..=10.0).contains(time));
    let time = time.ok_or_else(|| {
        let message = format!("`{}` is no time from frame to frame, s", shown(&word));
        Fault::at(line, message, AGAIN)
    })?;
    Ok((time, rate(&word, time)))
}

/// The rate (Hz) of a time (s): a usual one where the digits written cannot tell the two apart.
fn rate(word: &str, time: f64) -> f64 {
    let is_plain = word.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let decimals = word.split_once('.').map_or("", |(_, digits)| digits).chars();
    // Slightly more than half a unit of the last digit, as that half is rounded itself.
    let half_digit = if is_plain { decimals.fold(0.501, |digit, _| digit / 10.0) } else { 0.0 };
    let off = |rate: &f64| (1.0 / rate - time).abs();
    let nearest = USUAL_RATES_HZ.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.filter(|rate| off(rate) <= half_digit).unwrap_or(1.0 / time)
}

/// The values of a frame.
fn row(line: &Line, dof: usize) -> Result<Vec<f64>, Fault> {
    let words = || std::iter::once(line.first).chain(line.rest.clone());
    let found = words().count();
    if found != dof {
        let message =
            format!("the frame holds {found} values, not {dof} as the skeleton has channels");
        return Err(line.fault(message, AGAIN));
    }
    let value = |(i, word): (usize, &str)| {
        number(word).ok_or_else(|| {
            line.fault(format!("value {}: `{}` is no number", i + 1, shown(word)), AGAIN)
        })
    };
    words().enumerate().map(value).collect()
}

fn in_radians(mut frames: Vec<Vec<f64>>, skeleton: &Skeleton) -> Vec<Vec<f64>> {
    for joint in &skeleton.joints {
        for (i, channel) in (joint.first..).zip(&joint.channels) {
            if matches!(channel, Channel::Turn(_)) {
                for frame in &mut frames {
                    frame[i] = frame[i].to_radians();
                }
            }
        }
    }
    frames
}

#[cfg(test)]
mod tests {
    use super::rate;

    #[test]
    fn a_rate_is_a_usual_one_where_the_digits_allow_it() {
        for (word, wanted) in [
            ("0.016667", 60.0),
            ("0.0083333", 120.0),
            ("0.00833", 120.0),
            ("0.033", 30.0),
            ("0.0333333", 30.0),
            (".01", 100.0),
            ("0.008342", 1.0 / 0.008_342),
            ("0.0142857", 1.0 / 0.014_285_7),
            ("4.1666667e-3", 1.0 / 0.004_166_666_7),
        ] {
            let found = rate(word, word.parse().unwrap());
            assert!((found - wanted).abs() < 1e-9, "{word}: {found}");
        }
    }
}
