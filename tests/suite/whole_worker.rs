//! What must hold in every movement of a whole person, whatever the place, the body, the hands.

use ergopath::human::{
    Body, Coupled, Hands, Legs, PRESETS, Pelvis, Side, Stance, mirrored_pose, pelvis_in_rest,
};
use ergopath::math::pose::interpolate;
use ergopath::math::stream::{Purpose, stream};
use ergopath::math::{Pose, Vec3};
use ergopath::posture::{
    Coupling, Grips, HandPath, Hold, PostureModel, Sampler, Sampling, StartRule, natural_grip,
    roll_out, simulated_whole_operator, start_postures,
};
use ergopath::survey::{HeadDraw, Surveyor};
use nalgebra::DVector;
use proptest::prelude::*;
use std::path::Path;
use std::sync::LazyLock;

const STANDING: Stance = Stance::Standing { shoe_m: 0.03 };
const SEATED: Stance = Stance::Seated { seat_height_m: 0.45, footrest_m: 0.0 };

/// Bodies with the whole simulated operator in each.
static PEOPLE: LazyLock<Vec<(Body, PostureModel)>> = LazyLock::new(|| {
    let of = |(name, _): &(&str, _)| {
        let body = Body::load(name, Path::new(".")).unwrap();
        let model = simulated_whole_operator(&body, Side::Right).unwrap();
        (body, model)
    };
    PRESETS.iter().map(of).collect()
});

/// A grip at a height over the hips, a distance ahead and to the own side, over stature.
fn grip(stature_m: f64, [up, ahead, aside]: [f64; 3]) -> Pose {
    let at = Vec3::new(ahead, up, aside) * stature_m;
    Pose::from_parts(at.into(), natural_grip(up))
}

/// Both hands on a part: the second mirrors the first.
fn both(first: Pose) -> Grips {
    Grips { first, second: Some(mirrored_pose(&first)) }
}

struct Walked {
    coupling: Coupling,
    legs: Legs,
    surveyor: Surveyor,
    leg_m: f64,
    pelvis: Pelvis,
    /// Of each repetition the postures that were reached, and the largest residual, m.
    repetitions: Vec<(Vec<DVector<f64>>, f64)>,
}

fn walk(person: usize, hands: Hands, stance: Stance, ends: [Grips; 2], load_kg: f64) -> Walked {
    let (body, model) = &PEOPLE[person];
    let pelvis = if stance == STANDING { Pelvis::Moves } else { Pelvis::Turns };
    let coupled = Coupled { hands, pelvis };
    let model = model.adapted(pelvis, hands == Hands::Both).unwrap();
    let holds = vec![Hold::FreeRoll; hands.sides().len()];
    let coupling = Coupling::of_person(body, coupled, &holds, (stance, load_kg)).unwrap();
    let time: Vec<f64> = (0..=60).map(|i| f64::from(i) / 15.0).collect();
    let path: Vec<Grips> = (0..=60)
        .map(|i| ends[0].zip(&ends[1], |a, b| interpolate(a, b, f64::from(i) / 60.0)))
        .collect();
    let rule = StartRule::Sampled;
    let starts = start_postures(&coupling, &model.postures, &rule, path[0], (1, 0), 0..3);
    let hand = HandPath::new(&coupling, &model.law, time, path);
    let sampler = Sampler::new(&model.law, Sampling::Pathwise).unwrap();
    let one = |(r, start): (usize, &ergopath::posture::Start)| {
        let draw = sampler.draw(&mut stream(1, Purpose::Posture, 9, r as u32), &hand);
        let rollout = roll_out(&coupling, &model.law, &hand, start, Some(&draw));
        let end = rollout.reach_exceeded_at.unwrap_or(rollout.q.len());
        (rollout.q[..end].to_vec(), rollout.max_residual_m)
    };
    let repetitions = starts.iter().enumerate().map(one).collect();
    let rest = body.pelvis_pose([0.0, 0.0], 0.0, stance);
    Walked {
        repetitions,
        legs: Legs::new(body, stance).unwrap(),
        surveyor: Surveyor::new(body, coupled, rest, (stance, load_kg)).unwrap(),
        leg_m: body.leg_m(),
        coupling,
        pelvis,
    }
}

impl Walked {
    fn check(&self) -> Result<usize, TestCaseError> {
        let mut reached = 0;
        for (postures, residual) in &self.repetitions {
            prop_assert!(*residual < 1e-3, "hand {} m off", residual);
            for q in postures {
                reached += 1;
                prop_assert!(self.coupling.limits().violation(q.as_slice()) < 1e-8);
                let mut six = [0.0; 6];
                let free = self.pelvis.free();
                six[6 - free..].copy_from_slice(&q.as_slice()[..free]);
                // A leg that is too short is a foot that slides.
                let pelvis = pelvis_in_rest(&six, self.leg_m);
                let (postures, beyond) =
                    (self.legs.postures(&pelvis), self.legs.excess_at(&pelvis));
                prop_assert!(beyond.0 < 1e-3, "{:?}", postures);
                // A degree for what a step bends them on.
                prop_assert!(beyond.1 < 0.0175, "{} rad beyond: {:?}", beyond.1, postures);
                let seen = self.surveyor.measure(q, &HeadDraw::default());
                if let Some(margin) = seen.margin_m {
                    prop_assert!(margin > 0.0, "out of balance by {} m", -margin);
                }
            }
        }
        Ok(reached)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn hand_feet_limits_and_balance_are_kept(
        person in 0usize..4,
        from in (-0.36..0.5f64, 0.18..0.36f64, -0.02..0.2f64),
        to in (-0.36..0.5f64, 0.18..0.36f64, -0.02..0.2f64),
        is_both in any::<bool>(),
        load_kg in 0.0..12.0f64,
    ) {
        let h = PEOPLE[person].0.size.stature_m;
        let of = |(up, ahead, aside): (f64, f64, f64)| {
            let one = grip(h, [up, ahead, if is_both { aside.max(0.09) } else { aside }]);
            if is_both { both(one) } else { one.into() }
        };
        let hands = if is_both { Hands::Both } else { Hands::Right };
        walk(person, hands, STANDING, [of(from), of(to)], load_kg).check()?;
    }
}

#[test]
fn low_high_and_seated_places_are_reached() {
    for person in 0..4 {
        let h = PEOPLE[person].0.size.stature_m;
        let at = |up: f64, ahead: f64| grip(h, [up, ahead, 0.11]);
        let full = 3 * 61;
        let one = |from: Pose, to: Pose| [from.into(), to.into()];
        let low = walk(person, Hands::Right, STANDING, one(at(-0.3, 0.28), at(0.15, 0.25)), 2.0);
        assert_eq!(low.check().unwrap(), full, "low, person {person}");
        let high = walk(person, Hands::Right, STANDING, one(at(0.1, 0.25), at(0.5, 0.22)), 1.0);
        assert_eq!(high.check().unwrap(), full, "high, person {person}");
        let lift = [both(at(-0.28, 0.26)), both(at(0.12, 0.25))];
        let lift = walk(person, Hands::Both, STANDING, lift, 8.0);
        assert_eq!(lift.check().unwrap(), full, "two-handed lift, person {person}");
        let seated = walk(person, Hands::Right, SEATED, one(at(0.05, 0.24), at(0.2, 0.22)), 0.5);
        assert_eq!(seated.check().unwrap(), full, "seated, person {person}");
    }
}

#[test]
fn a_resting_hand_and_resting_feet_hold_the_posture() {
    let h = PEOPLE[1].0.size.stature_m;
    let low = grip(h, [-0.25, 0.28, 0.1]);
    let walked = walk(1, Hands::Right, STANDING, [low.into(), low.into()], 0.0);
    for (postures, _) in &walked.repetitions {
        let moved = (&postures[60] - &postures[0]).amax().to_degrees();
        // What is left is the measured drift of resting joints.
        assert!(moved < 3.0, "{moved} deg in 4 s");
    }
}
