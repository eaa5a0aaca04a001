//! Moved thresholds: against thresholds moved by hand, and monotone over many postures.

use super::*;
use crate::ergonomics::ScoringMethod;
use crate::ergonomics::{reba, rula};

fn shift(stricter_deg: f64) -> ThresholdShift {
    ThresholdShift { stricter_deg, part: None }
}

/// Postures over the whole range, in odd steps so that none lies on a threshold.
fn postures() -> Vec<(TrunkNeckAngles, ArmAngles)> {
    (0..400)
        .map(|i| {
            let at = |step: f64, low: f64, high: f64| {
                low + (f64::from(i) * step + 0.137).rem_euclid(high - low)
            };
            let body = TrunkNeckAngles {
                trunk_flex_deg: at(7.31, -30.0, 90.0),
                trunk_side_deg: at(3.17, -30.0, 30.0),
                trunk_twist_deg: at(5.71, -40.0, 40.0),
                neck_flex_deg: at(11.3, -30.0, 50.0),
                neck_side_deg: at(2.93, -30.0, 30.0),
                neck_twist_deg: at(6.37, -60.0, 60.0),
            };
            let (flexion, abduction) = (at(13.7, -50.0, 120.0), at(4.19, -30.0, 90.0));
            let arm = ArmAngles {
                upper_arm_flex_deg: flexion,
                upper_arm_abduction_deg: abduction,
                upper_arm_elevation_deg: flexion.hypot(abduction),
                girdle_elevation_deg: at(1.73, -5.0, 20.0),
                elbow_flex_deg: at(9.43, 0.0, 150.0),
                wrist_flex_deg: at(8.11, -60.0, 60.0),
                wrist_deviation_deg: at(3.79, -30.0, 30.0),
                wrist_twist_deg: at(12.1, -90.0, 90.0),
                wrist_lateral_m: 0.2,
                wrist_beyond_shoulder_m: 0.0,
            };
            (body, arm)
        })
        .collect()
}

fn scored(shift: &ThresholdShift, posture: &(TrunkNeckAngles, ArmAngles)) -> (u8, u8) {
    let (profile, task) = (Profile::default(), TaskInputs::default());
    let sheet = shift.worksheet(&posture.0, &posture.1, &task, &profile);
    (rula(&sheet, &profile).grand, reba(&sheet, &profile).total)
}

fn expected(shift: &ThresholdShift) -> PerMethod<f64> {
    let all = postures();
    let n = all.len() as f64;
    let (mut rula, mut reba) = (0.0, 0.0);
    for posture in &all {
        let (r, b) = scored(shift, posture);
        rula += f64::from(r) / n;
        reba += f64::from(b) / n;
    }
    PerMethod::of(|m| if m == ScoringMethod::Rula { rula } else { reba })
}

#[test]
fn a_moved_angle_is_a_moved_threshold() {
    let profile = Profile::default();
    let class = |angle: f64, by: f64| {
        let sheet = Worksheet {
            elbow_flex_deg: angle,
            trunk_flex_deg: angle,
            upper_arm_flex_deg: angle,
            ..Worksheet::default()
        };
        let s = rula(&shift(by).classed(&sheet), &profile);
        (s.upper_arm, s.lower_arm, s.trunk)
    };
    // Upper arm 20, 45, 90; elbow 60 to 100; trunk 5, 20, 60: each by hand at +-5 deg.
    assert_eq!([class(41.0, 0.0), class(41.0, 5.0), class(41.0, -5.0)].map(|c| c.0), [2, 3, 2]);
    assert_eq!([class(47.0, 0.0), class(47.0, 5.0), class(47.0, -5.0)].map(|c| c.0), [3, 3, 2]);
    assert_eq!([class(-22.0, 0.0), class(-22.0, -5.0)].map(|c| c.0), [2, 1]);
    assert_eq!([class(62.0, 0.0), class(62.0, 5.0)].map(|c| c.1), [1, 2]);
    assert_eq!([class(103.0, 0.0), class(103.0, -5.0)].map(|c| c.1), [2, 1]);
    assert_eq!([class(57.0, 0.0), class(57.0, 5.0), class(63.0, -5.0)].map(|c| c.2), [3, 4, 3]);
    assert_eq!([class(2.0, 0.0), class(2.0, 5.0), class(0.0, 5.0)].map(|c| c.2), [1, 2, 1]);
}

#[test]
fn flags_move_with_their_profile() {
    let (body, task, profile) = (
        TrunkNeckAngles {
            trunk_twist_deg: -7.0,
            neck_side_deg: 13.0,
            ..TrunkNeckAngles::default()
        },
        TaskInputs::default(),
        Profile::default(),
    );
    let flags = |by: f64| {
        let s = shift(by).worksheet(&body, &ArmAngles::default(), &task, &profile);
        (s.trunk_twisted, s.neck_side)
    };
    assert_eq!(
        [flags(0.0), flags(5.0), flags(-5.0)],
        [(false, true), (true, true), (false, false)]
    );
}

#[test]
fn no_move_changes_nothing_and_stricter_never_scores_lower() {
    let (profile, task) = (Profile::default(), TaskInputs::default());
    for posture in postures() {
        let plain = worksheet(&posture.0, &posture.1, &task, &profile);
        assert_eq!(ThresholdShift::NONE.worksheet(&posture.0, &posture.1, &task, &profile), plain);
        let all = [-10.0, -5.0, 0.0, 5.0, 10.0].map(|by| scored(&shift(by), &posture));
        assert!(
            all.windows(2).all(|w| w[0].0 <= w[1].0 && w[0].1 <= w[1].1),
            "{posture:?} {all:?}"
        );
    }
}

#[test]
fn bands_hold_the_official_score_and_lie_within_the_band_of_all_parts() {
    let found = threshold_sensitivity(THRESHOLD_MOVE_DEG, expected);
    assert_eq!(found.bands.len(), 7);
    let all = found.bands[0];
    assert!(
        all.laxer[ScoringMethod::Rula] < found.official[ScoringMethod::Rula]
            && found.official[ScoringMethod::Rula] < all.stricter[ScoringMethod::Rula]
    );
    for band in &found.bands {
        assert!(
            band.laxer[ScoringMethod::Rula] <= found.official[ScoringMethod::Rula]
                && found.official[ScoringMethod::Rula] <= band.stricter[ScoringMethod::Rula]
        );
        assert!(
            band.laxer[ScoringMethod::Reba] <= found.official[ScoringMethod::Reba]
                && found.official[ScoringMethod::Reba] <= band.stricter[ScoringMethod::Reba]
        );
        assert!(
            all.laxer[ScoringMethod::Reba] <= band.laxer[ScoringMethod::Reba]
                && band.stricter[ScoringMethod::Reba] <= all.stricter[ScoringMethod::Reba]
        );
    }
    // Knees are straight here: their thresholds do not matter.
    let legs = found.bands[6];
    assert_eq!((legs.part, legs.laxer), (Some(BodyPart::Legs), legs.stricter));
}

#[test]
fn what_is_not_a_number_stays_so() {
    let sheet = Worksheet { trunk_flex_deg: f64::NAN, ..Worksheet::default() };
    assert!(shift(5.0).classed(&sheet).trunk_flex_deg.is_nan());
}
