//! Made-up motions with known answers.

use super::*;

fn times(duration_s: f64, rate_hz: f64) -> Vec<f64> {
    (0..=(duration_s * rate_hz).round() as usize).map(|i| i as f64 / rate_hz).collect()
}

fn part(time: &[f64], angle: impl Fn(f64) -> f64) -> PartTimeline {
    let angles: Vec<f64> = time.iter().map(|t| angle(*t)).collect();
    Clock::new(time, TimeRules::default()).part(&[&angles])
}

/// Noise without a random generator: two incommensurate hashes, roughly uniform in -1 to 1.
fn noise(t: f64) -> f64 {
    2.0 * ((t * 12_989.8).sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
}

/// At rest, lifted by 40 deg within 1 s, held, let down.
fn lifted(t: f64, hold_s: f64) -> f64 {
    let ramp = |x: f64| 40.0 * x.clamp(0.0, 1.0);
    ramp(t - 3.0) - ramp(t - 4.0 - hold_s)
}

#[test]
fn a_sine_of_five_a_minute_is_repeated_and_never_held() {
    let wave =
        |per_min: f64| move |t: f64| 20.0 * (std::f64::consts::TAU * per_min * t / 60.0).sin();
    let time = times(120.0, 50.0);
    let five = part(&time, wave(5.0));
    assert_eq!((five.movements, five.repeated), (10, Shown::Yes));
    assert!((five.movements_per_min - 5.0).abs() < 0.01);
    assert_eq!(five.held, Shown::No);
    let four = part(&time, wave(4.0));
    assert_eq!((four.movements, four.repeated), (8, Shown::No));
    // Too small to be a movement.
    let small = part(&time, |t| 0.2 * wave(5.0)(t));
    assert_eq!((small.movements, small.repeated), (0, Shown::No));
    assert_eq!(five.rapid_changes, 0);
}

#[test]
fn holds_of_59_and_61_seconds_are_told_apart() {
    for (hold, held) in [(59.0, Shown::No), (61.0, Shown::Yes)] {
        for shake in [0.0, 1.0] {
            let time = times(70.0, 60.0);
            let found = part(&time, |t| lifted(t, hold) + shake * noise(t));
            let longest = found.longest_hold.unwrap();
            assert!((longest.duration_s() - hold).abs() < 0.6, "{hold} {shake}: {longest:?}");
            assert!((longest.from_s - 4.0).abs() < 0.5);
            assert_eq!(found.held, held, "{shake}");
            assert_eq!(found.movements, 1);
        }
    }
}

#[test]
fn a_short_motion_cannot_show_what_takes_a_minute() {
    let time = times(4.0, 100.0);
    let still = part(&time, |_| 30.0);
    assert_eq!((still.held, still.repeated), (Shown::TooShort, Shown::TooShort));
    assert!((still.longest_hold.unwrap().duration_s() - 4.0).abs() < 1e-9);
    // But five movements in half a minute are more than four in a minute.
    let fast = part(&times(30.0, 50.0), |t| 20.0 * (std::f64::consts::TAU * t / 6.0).sin());
    assert_eq!((fast.movements, fast.repeated), (5, Shown::Yes));
}

#[test]
fn a_slow_drift_is_no_hold() {
    // 0.2 deg/s: never fast, but 7.5 deg away after 37.5 s.
    let found = part(&times(150.0, 20.0), |t| 0.2 * t);
    assert_eq!(found.held, Shown::No);
    assert!((found.longest_hold.unwrap().duration_s() - 37.5).abs() < 0.5);
    assert_eq!(found.holds.len(), 4);
}

#[test]
fn nothing_is_claimed_across_a_gap_and_rates_may_vary() {
    let gapped: Vec<f64> =
        times(100.0, 50.0).into_iter().filter(|t| !(40.0..45.0).contains(t)).collect();
    let clock = Clock::new(&gapped, TimeRules::default());
    assert_eq!(clock.gaps(), 1);
    assert!((clock.observed_s - 95.0).abs() < 0.1);
    let still = vec![10.0; gapped.len()];
    let found = clock.part(&[&still]);
    // 40 and 55 s: neither stretch could show a minute.
    assert_eq!((found.held, found.holds.len()), (Shown::TooShort, 2));
    // Frames of two rates: weights follow the steps.
    let mixed: Vec<f64> = (0..100)
        .map(|i| f64::from(i) * 0.1)
        .chain((0..50).map(|i| 10.0 + f64::from(i) * 0.02))
        .collect();
    let clock = Clock::new(&mixed, TimeRules::default());
    assert!((clock.weights_s[10] - 0.1).abs() < 1e-9 && (clock.weights_s[120] - 0.02).abs() < 1e-9);
    assert!((clock.observed_s - 11.07).abs() < 0.05, "{}", clock.observed_s);
}

#[test]
fn several_angles_are_still_only_together() {
    let time = times(100.0, 30.0);
    let still = vec![5.0; time.len()];
    let moving: Vec<f64> = time.iter().map(|t| 20.0 * t.sin()).collect();
    let clock = Clock::new(&time, TimeRules::default());
    assert_eq!(clock.part(&[&still]).held, Shown::Yes);
    assert_eq!(clock.part(&[&still, &moving]).held, Shown::No);
    // 100 s are 15.9 waves; the last one lacks less than a movement's 10 deg.
    assert_eq!(clock.part(&[&still, &moving]).movements, 16);
}

#[test]
fn rapid_large_changes_are_counted_once_each() {
    let time = times(20.0, 100.0);
    let step = |t: f64, at: f64| 60.0 * ((t - at) / 0.6).clamp(0.0, 1.0);
    assert_eq!(part(&time, |t| step(t, 3.0) - step(t, 9.0)).rapid_changes, 2);
    assert_eq!(part(&time, |t| 60.0 * ((t - 3.0) / 2.0).clamp(0.0, 1.0)).rapid_changes, 0);
}

#[test]
fn a_single_frame_or_none_is_no_trouble() {
    let one = Clock::new(&[2.0], TimeRules::default());
    assert_eq!((one.observed_s, one.part(&[&[3.0]]).longest_hold), (1.0, None));
    let none = Clock::new(&[], TimeRules::default());
    assert_eq!(none.part(&[&[]]).held, Shown::TooShort);
}
