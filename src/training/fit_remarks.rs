//! What a person should know about a fit, in words.

use super::chain::Chain;
use super::fit_report::FitReport;
use super::targets::{Targets, segment_names};
use crate::human::Side;
use crate::math::Vec3;
use crate::recording::{Recording, Remark};
use nalgebra::DVector;

/// Share of frames with a joint at a limit that is worth a note.
const AT_LIMIT_SHARE: f64 = 0.02;
/// Middle Euler angle of the shoulder beyond which rates of its neighbours grow, deg.
const MIDDLE_ANGLE_DEG: f64 = 70.0;
/// A filter overshoot up to this is a hair, deg.
const HAIR_DEG: f64 = 0.5;
/// Offset between recorded and model hand that suggests a body of the wrong size, mm.
const LARGE_OFFSET_MM: f64 = 60.0;

/// One sentence each.
pub(super) fn remarks(
    report: &FitReport,
    recording: &Recording,
    chain: &Chain,
    side: Side,
    targets: &Targets,
    postures: &[DVector<f64>],
) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let missing: Vec<String> =
        segment_names(side).into_iter().filter(|n| !targets.segments.contains(n)).collect();
    if !missing.is_empty() {
        let text = format!(
            "not recorded: {}; the joints between their neighbours share the turn as people usually do",
            missing.join(", ")
        );
        remarks.push(Remark::new("not recorded segments", text).of_size(missing.len() as f64));
    }
    if report.frames_at_limit_share > AT_LIMIT_SHARE {
        let listed: Vec<String> = report
            .joints_at_limit
            .iter()
            .map(|(name, share)| format!("{name} {:.0} %", 100.0 * share))
            .collect();
        let text = format!(
            "in {:.0} % of the frames something presses on a limit ({}): the person or the \
             measurement goes further than this body may, even with a slack of {} deg",
            100.0 * report.frames_at_limit_share,
            listed.join(", "),
            report.settings.limit_slack_deg
        );
        remarks.push(Remark::new("limits", text).of_size(report.frames_at_limit_share));
    }
    if !report.beyond_range.is_empty() {
        let listed: Vec<String> = report
            .beyond_range
            .iter()
            .map(|b| {
                let share = match 100.0 * b.frames_share {
                    share if share < 1.0 => "less than 1 %".to_owned(),
                    share => format!("{share:.0} %"),
                };
                format!("{} by up to {:.1} deg in {share} of the frames", b.joint, b.largest_deg)
            })
            .collect();
        let text = format!(
            "recorded beyond the body's range: {}; what is learned and judged here goes as far, but \
             plans for a body keep its range",
            listed.join(", ")
        );
        remarks.push(
            Remark::new("range", text)
                .of_size(report.beyond_range.iter().map(|b| b.largest_deg).fold(0.0, f64::max)),
        );
    }
    if report.frames_projected > 0 {
        let hair = if report.largest_overshoot_deg <= HAIR_DEG {
            "a hair, put back"
        } else {
            "put back; more than a hair, so rates near the limit are uncertain"
        };
        let text = format!(
            "the filter carried {} frames across a limit, by at most {:.2} deg: {hair}",
            report.frames_projected, report.largest_overshoot_deg
        );
        remarks.push(Remark::new("overshoot", text).of_size(report.largest_overshoot_deg));
    }
    if report.cutoff_hz >= 0.25 * recording.rate_hz {
        let text = format!(
            "not filtered: the cut-off of {} Hz is too near the frame rate of {} Hz",
            report.cutoff_hz, recording.rate_hz
        );
        remarks.push(Remark::new("filter", text));
    }
    let middle = format!("j{}Shoulder_X", side.prefix());
    if let Some(c) = chain.linkage.joints().iter().position(|j| j.name == middle) {
        let largest = postures.iter().map(|q| q[c].abs()).fold(0.0, f64::max).to_degrees();
        if largest > MIDDLE_ANGLE_DEG {
            let text = format!(
                "{middle} reaches {largest:.0} deg: beyond {MIDDLE_ANGLE_DEG} deg the other two \
                 shoulder angles change fast for small movements"
            );
            remarks.push(Remark::new("shoulder", text).of_size(largest));
        }
    }
    let offset = Vec3::from(report.pelvis_offset_mm).norm();
    if offset > LARGE_OFFSET_MM {
        let hint = report.stature_hint_m.map_or_else(String::new, |s| {
            format!("; by its arm the person is {s:.2} m tall, the body {:.2} m", chain.stature_m)
        });
        let text = format!(
            "the recorded hand is {offset:.0} mm away from the model's on average (pelvis origin, \
             trunk and shoulder breadth differ){hint}"
        );
        remarks.push(Remark::new("offset of the hand", text).of_size(offset));
    }
    remarks
}
