//! The NIOSH equation: worked examples, closed forms, limits, and the ends of a hand path.

use super::*;
use crate::math::Vec3;
use approx::assert_relative_eq;

fn point(horizontal_cm: f64, vertical_cm: f64, asymmetry_deg: f64) -> LiftPoint {
    LiftPoint { horizontal_cm, vertical_cm, asymmetry_deg }
}

/// The manual's inch formulas are its metric ones at 2.5 cm to the inch (10 in = 25 cm, 30 in = 75
/// cm), so that its worksheets in inches can be followed exactly.
fn inches(h: f64, v: f64, a: f64) -> LiftPoint {
    point(2.5 * h, 2.5 * v, a)
}

fn task(
    load_kg: f64,
    lifts_per_min: f64,
    duration: LiftDuration,
    coupling: LiftCoupling,
) -> LiftTask {
    LiftTask { load_kg, lifts_per_min, duration, coupling, control_at_destination: true }
}

fn values(m: &LiftMultipliers) -> [f64; 6] {
    [m.horizontal, m.vertical, m.distance, m.asymmetry, m.frequency, m.coupling]
}

/// Half a unit of the second decimal, and a little for the two rows (22 and 23 in) that table 1
/// rounds up although the formula gives 0.4545 and 0.4348.
const PRINTED: f64 = 0.0055;

fn printed(limit: &LiftLimit, multipliers: [f64; 6], rwl_lb: f64) {
    for (ours, printed) in values(&limit.multipliers).iter().zip(multipliers) {
        assert!((ours - printed).abs() < PRINTED, "{:?} {multipliers:?}", limit.multipliers);
    }
    // The worksheets multiply the rounded multipliers.
    let by_hand = 51.0 * multipliers.iter().product::<f64>();
    assert!((by_hand - rwl_lb).abs() < 0.051, "{by_hand} {rwl_lb}");
    // Six factors rounded to two decimals: about 1 % each at worst.
    let lb = limit.recommended_kg / 23.0 * 51.0;
    assert!((lb - rwl_lb).abs() < 0.02 * rwl_lb, "{lb} {rwl_lb}");
}

/// Applications Manual, example 4, package inspection (figure 14, p. 46): the printed multipliers and
/// limits; H at the destination and the load (26 lb) are recalled.
#[test]
fn example_4_of_the_manual() {
    let lift = assess_lift(
        inches(10.0, 22.0, 0.0),
        inches(20.0, 59.0, 0.0),
        &task(26.0 * 23.0 / 51.0, 3.0, LiftDuration::Short, LiftCoupling::Fair),
        &[],
    );
    printed(&lift.origin, [1.0, 0.94, 0.87, 1.0, 0.88, 0.95], 34.9);
    printed(&lift.destination, [0.5, 0.78, 0.87, 1.0, 0.88, 1.0], 15.2);
    assert_eq!(lift.recommended_kg, lift.destination.recommended_kg);
    // At full precision 34.8 and 15.3 lb, the manual's own warning on rounding (p. 29).
    let lb = |l: &LiftLimit| (l.recommended_kg / 23.0 * 510.0).round() / 10.0;
    assert_eq!((lb(&lift.origin), lb(&lift.destination)), (34.8, 15.3));
    assert!((lift.lifting_index.unwrap() - 1.7).abs() < 0.05, "{lift:?}");
}

/// Applications Manual, example 1, loading punch press stock; numbers recalled, not read: they are
/// consistent with each other and with the formulas.
#[test]
fn example_1_of_the_manual() {
    let lift = assess_lift(
        inches(23.0, 15.0, 0.0),
        inches(23.0, 63.0, 0.0),
        &task(44.0 * 23.0 / 51.0, 0.1, LiftDuration::Short, LiftCoupling::Fair),
        &[],
    );
    printed(&lift.origin, [0.44, 0.89, 0.86, 1.0, 1.0, 0.95], 16.3);
    printed(&lift.destination, [0.44, 0.75, 0.86, 1.0, 1.0, 1.0], 14.5);
    assert!((lift.lifting_index.unwrap() - 3.0).abs() < 0.1, "{lift:?}");
}

/// A published class exercise in metric units: 12 kg, three lifts a minute for 45 min, from 55 to 150
/// cm at 25 cm, fair coupling: RWL 15.7 kg. (Its index of 0.76 is of rounded multipliers.)
#[test]
fn a_metric_exercise() {
    let lift = assess_lift(
        point(25.0, 55.0, 0.0),
        point(25.0, 150.0, 0.0),
        &LiftTask {
            control_at_destination: false,
            ..task(12.0, 3.0, LiftDuration::Short, LiftCoupling::Fair)
        },
        &[],
    );
    assert!((lift.recommended_kg - 15.7).abs() < 0.05, "{lift:?}");
    let exact = 23.0 * 0.94 * (0.82 + 4.5 / 95.0) * 0.88 * 0.95;
    assert_relative_eq!(lift.lifting_index.unwrap(), 12.0 / exact, epsilon = 1e-12);
    assert!(lift.notes.is_empty(), "{:?}", lift.notes);
}

#[test]
fn multipliers_in_closed_form() {
    assert_eq!(horizontal_multiplier(50.0), 0.5);
    assert_relative_eq!(vertical_multiplier(0.0), 0.775);
    assert_relative_eq!(vertical_multiplier(175.0), 0.7);
    assert_relative_eq!(distance_multiplier(25.0), 1.0);
    assert_relative_eq!(distance_multiplier(100.0), 0.865);
    assert_relative_eq!(asymmetry_multiplier(135.0), 0.568);
    assert_relative_eq!(asymmetry_multiplier(-30.0), asymmetry_multiplier(30.0));
    let all = [LiftCoupling::Good, LiftCoupling::Fair, LiftCoupling::Poor];
    let low = all.map(|c| coupling_multiplier(c, false));
    let high = all.map(|c| coupling_multiplier(c, true));
    assert_eq!((low, high), ([1.0, 0.95, 0.9], [1.0, 1.0, 0.9]));
}

#[test]
fn outside_the_limits_the_multiplier_is_zero() {
    assert_eq!(
        [horizontal_multiplier(63.0) > 0.0, horizontal_multiplier(63.1) > 0.0],
        [true, false]
    );
    assert_eq!([vertical_multiplier(175.0) > 0.0, vertical_multiplier(175.1) > 0.0], [true, false]);
    assert_eq!([distance_multiplier(175.0) > 0.0, distance_multiplier(175.1) > 0.0], [true, false]);
    assert_eq!(
        [asymmetry_multiplier(135.0) > 0.0, asymmetry_multiplier(135.1) > 0.0],
        [true, false]
    );
    assert_eq!(vertical_multiplier(-1.0), 0.0);
    for f in [horizontal_multiplier, vertical_multiplier, distance_multiplier, asymmetry_multiplier]
    {
        assert_eq!(f(f64::NAN), 0.0);
    }
    assert_eq!(frequency_multiplier(f64::NAN, LiftDuration::Short, true), 0.0);
}

#[test]
fn the_frequency_table_has_its_ends_and_is_linear_between() {
    use LiftDuration::{Long, Moderate, Short};
    for (duration, last_low, last_high) in
        [(Short, 12.0, 15.0), (Moderate, 10.0, 12.0), (Long, 8.0, 10.0)]
    {
        for (is_high, last) in [(false, last_low), (true, last_high)] {
            assert!(frequency_multiplier(last, duration, is_high) > 0.0);
            assert_eq!(frequency_multiplier(last + 0.1, duration, is_high), 0.0);
        }
        let rising: Vec<f64> =
            (0..50).map(|i| frequency_multiplier(f64::from(i) * 0.2, duration, true)).collect();
        assert!(rising.windows(2).all(|w| w[0] >= w[1]), "{duration:?}");
    }
    assert_eq!(frequency_multiplier(0.0, Short, false), 1.0);
    // Example 7 of the manual interpolates at 2.4 lifts a minute.
    assert_relative_eq!(
        frequency_multiplier(2.4, Short, false),
        0.91 - 0.4 * 0.03,
        epsilon = 1e-12
    );
    assert_relative_eq!(frequency_multiplier(7.5, Long, true), 0.2, epsilon = 1e-12);
    assert_eq!(frequency_multiplier(11.0, Moderate, true), 0.23);
}

#[test]
fn durations() {
    let of = LiftDuration::from_hours;
    assert_eq!(of(1.0), Some(LiftDuration::Short));
    assert_eq!(of(1.5), Some(LiftDuration::Moderate));
    assert_eq!(of(8.0), Some(LiftDuration::Long));
    assert_eq!((of(8.1), of(-1.0), of(f64::NAN)), (None, None, None));
}

#[test]
fn what_is_bent_or_outside_is_said() {
    let one = task(10.0, 20.0, LiftDuration::Long, LiftCoupling::Good);
    let lift = assess_lift(
        point(10.0, 80.0, 0.0),
        point(70.0, 90.0, 140.0),
        &one,
        &[LiftCondition::OneHanded],
    );
    assert_eq!((lift.recommended_kg, lift.lifting_index), (0.0, None));
    assert_eq!(
        lift.notes,
        [
            LiftNote::NotApplicable(LiftCondition::OneHanded),
            LiftNote::NearCountsAs25(10.0),
            LiftNote::TooFar(70.0),
            LiftNote::TooAsymmetric(140.0),
            LiftNote::ShortCountsAs25(10.0),
            LiftNote::TooFrequent(20.0),
        ]
    );
    assert!(lift.notes[0].words().contains("does not apply: one hand"));
    // Without control at the destination its reach does not count.
    let lift = assess_lift(
        point(30.0, 80.0, 0.0),
        point(70.0, 90.0, 0.0),
        &LiftTask { control_at_destination: false, lifts_per_min: 1.0, ..one },
        &[],
    );
    assert!(lift.recommended_kg > 0.0 && lift.destination.recommended_kg == 0.0);
}

#[test]
fn a_path_gives_its_two_ends() {
    let time: Vec<f64> = (0..=20).map(|i| 0.1 * f64::from(i)).collect();
    // From straight ahead at 0.5 m, 0.4 m high, to the left at 0.3 m, 1.0 m high, over 1.2 m.
    let hand: Vec<Vec3> = (0..=20)
        .map(|i| {
            let s = f64::from(i) / 20.0;
            let turn = s * std::f64::consts::FRAC_PI_2;
            let r = 0.5 - 0.2 * s;
            let z = if s < 0.5 { 0.4 + 1.6 * s } else { 1.2 - 0.4 * (s - 0.5) };
            Vec3::new(2.0 + r * turn.cos(), 1.0 + r * turn.sin(), z)
        })
        .collect();
    let (ankles, facing) = (Vec3::new(2.0, 1.0, 0.1), Vec3::new(3.0, 0.0, 5.0));
    let lift = lift_from_path(&time, &hand, &ankles, &facing).unwrap();
    let near = |p: LiftPoint, h: f64, v: f64, a: f64| {
        assert_relative_eq!(p.horizontal_cm, h, epsilon = 1e-9);
        assert_relative_eq!(p.vertical_cm, v, epsilon = 1e-9);
        assert_relative_eq!(p.asymmetry_deg, a, epsilon = 1e-9);
    };
    near(lift.origin, 50.0, 40.0, 0.0);
    near(lift.destination, 30.0, 100.0, 90.0);
    assert_relative_eq!(lift.beyond_ends_cm, 20.0, epsilon = 1e-9);
    assert_eq!(lift.note(), Some(LiftNote::PassesBeyondEnds(lift.beyond_ends_cm)));
    assert_eq!(lift.condition(), None);
    let fast: Vec<f64> = time.iter().map(|t| 0.2 * t).collect();
    let lift = lift_from_path(&fast, &hand, &ankles, &facing).unwrap();
    assert_eq!(lift.condition(), Some(LiftCondition::HighSpeed));
    assert_eq!(lift_from_path(&time[1..], &hand, &ankles, &facing), None);
    assert_eq!(lift_from_path(&[], &[], &ankles, &facing), None);
}

#[test]
fn mirrored_lifts_and_hands_above_the_ankles() {
    let ends = |y: f64| {
        let hand = [Vec3::new(0.3, y, 0.5), Vec3::new(0.0, 0.0, 1.0)];
        lift_from_path(&[0.0, 1.0], &hand, &Vec3::zeros(), &Vec3::x()).unwrap()
    };
    assert_eq!(ends(0.2), ends(-0.2));
    assert_eq!(ends(0.2).destination.asymmetry_deg, 0.0);
}
