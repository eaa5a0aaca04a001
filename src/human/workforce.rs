//! Bodies of a workforce: men and women of many sizes, and of other proportions than the mean.
//!
//! ```text
//! stature    normal by sex                                 (mean, standard deviation: ANSUR II)
//! mass       stature^2 times a lognormal index             (so that mass has the survey's standard deviation)
//! fractions  mean by sex + standard deviation of the survey times a normal number
//! ```
//! Assumed: that the mass index goes with nothing else; that arm segments and shoulder breadth have the common
//! correlation with which the survey's span comes out ([`WITH_ARMS`]); that the heights of cervicale and acromion
//! go together, as both are stature less head and neck; and the spread of the legs' share, which the shared tables
//! do not hold ([`LEGS_SD`]). Statures are levels spread evenly, not drawn, so that few bodies already have the
//! survey's mean and spread, and the same people work in every run.

use super::body::Body;
use super::proportions::{BodySize, Proportions, Sex, proportions};
use crate::files::InputError;
use crate::math::stream::{Purpose, normals, stream};
use statrs::distribution::{ContinuousCDF, Normal};

/// The name under which a scenario asks for a workforce.
pub const POPULATION: &str = "population";
/// That of its mean body.
const ALL: &str = "the population";

/// What the survey says of one sex (ANSUR II, 2012): means and standard deviations.
struct Survey {
    stature_m: [f64; 2],
    mass_kg: [f64; 2],
    /// Standard deviations of fractions of stature.
    acromial: f64,
    cervicale: f64,
    biacromial: f64,
    upper_arm: f64,
    forearm: f64,
    hand: f64,
}

const fn survey(sex: Sex) -> Survey {
    match sex {
        Sex::Male => Survey {
            stature_m: [1.7562, 0.0686],
            mass_kg: [85.5, 14.2],
            acromial: 0.0096,
            cervicale: 0.0066,
            biacromial: 0.0098,
            upper_arm: 0.0061,
            forearm: 0.0061,
            hand: 0.0042,
        },
        Sex::Female => Survey {
            stature_m: [1.6285, 0.0642],
            mass_kg: [67.8, 11.0],
            acromial: 0.0087,
            cervicale: 0.0068,
            biacromial: 0.0096,
            upper_arm: 0.0065,
            forearm: 0.0068,
            hand: 0.0047,
        },
    }
}

/// Correlation of the fractions of upper arm, forearm, hand and shoulder breadth: with it the span, twice the arm
/// and the breadth, has the standard deviation of the survey (0.0274 of stature, men).
const WITH_ARMS: f64 = 0.21;
/// Standard deviation of the hip's height over stature: the survey's standard deviation of the height itself leaves
/// 0.020 for the fraction were it independent of stature; of the heights of acromion and cervicale 0.55 of such a
/// figure is found.
const LEGS_SD: f64 = 0.011;
/// The golden ratio's fractional part: its multiples spread evenly between 0 and 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The mean body of a workforce and `count` bodies of it: any first of them are spread about as
/// evenly as all are.
///
/// # Errors
/// Never for a share of women between 0 and 1.
pub fn workforce(women: f64, count: usize) -> Result<(Body, Vec<Body>), InputError> {
    let mut of_sex = [0usize; 2];
    let one = |i: usize| {
        // The share is kept by any first of them, to one person.
        let women_before = |i: usize| (women * i as f64 + 0.5).floor() as usize;
        let is_woman = women_before(i + 1) > women_before(i);
        let sex = if is_woman { Sex::Female } else { Sex::Male };
        let nth = &mut of_sex[usize::from(is_woman)];
        let level = (0.5 + GOLDEN * *nth as f64).fract();
        *nth += 1;
        let z = normals(&mut stream(0, Purpose::Body, 0, i as u32), 8);
        let (size, shape) = drawn(sex, level, &z);
        let called = if is_woman { "woman" } else { "man" };
        let name = format!("{called} {} of {:.2} m", i + 1, size.stature_m);
        Body::of_proportions(&name, size, &shape)
    };
    let members: Vec<Body> = (0..count).map(one).collect::<Result<_, _>>()?;
    let [men, women_mean] = [Sex::Male, Sex::Female].map(survey);
    let between = |of: fn(&Survey) -> f64| women * of(&women_mean) + (1.0 - women) * of(&men);
    let size = BodySize {
        sex: if women > 0.5 { Sex::Female } else { Sex::Male },
        stature_m: rounded(between(|s| s.stature_m[0]), 1e-3),
        mass_kg: rounded(between(|s| s.mass_kg[0]), 0.1),
    };
    Ok((Body::of_size(ALL, size)?, members))
}

/// A body at a level of stature, with what else is drawn of it (standard normal).
fn drawn(sex: Sex, level: f64, z: &[f64]) -> (BodySize, Proportions) {
    let s = survey(sex);
    let [mean, sd] = s.stature_m;
    let stature_m = mean + sd * Normal::standard().inverse_cdf(level.clamp(0.005, 0.995));
    // mass = index * stature^2, independent: the squares of their coefficients of variation add up, nearly.
    let [mass, mass_sd] = s.mass_kg;
    let of_stature = 2.0 * sd / mean;
    let cv = ((mass_sd / mass).powi(2) - of_stature.powi(2)).sqrt();
    let log_sd = (1.0 + cv * cv).ln().sqrt();
    let index = mass / (mean * mean + sd * sd) * (log_sd * z[0] - 0.5 * log_sd * log_sd).exp();
    let size = BodySize {
        sex,
        stature_m: rounded(stature_m, 1e-3),
        mass_kg: rounded(index * stature_m * stature_m, 0.1),
    };
    let with_arms = |own: f64| WITH_ARMS.sqrt() * z[1] + (1.0 - WITH_ARMS).sqrt() * own;
    let p = proportions(sex);
    let hip_height = p.hip_height + LEGS_SD * z[7];
    let shape = Proportions {
        hip_height,
        // Thigh and shank share what legs have more or less.
        knee_height: p.knee_height * hip_height / p.hip_height,
        shoulder_height: p.shoulder_height + s.acromial * z[6],
        c7_height: p.c7_height + s.cervicale * z[6],
        shoulder_half_breadth: p.shoulder_half_breadth + 0.5 * s.biacromial * with_arms(z[2]),
        upper_arm: p.upper_arm + s.upper_arm * with_arms(z[3]),
        forearm: p.forearm + s.forearm * with_arms(z[4]),
        hand: p.hand + s.hand * with_arms(z[5]),
        foot: p.foot,
        sitting_height: p.sitting_height - LEGS_SD * z[7],
    };
    (size, shape)
}

fn rounded(value: f64, to: f64) -> f64 {
    (value / to).round() * to
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::{mean, quantile, std_dev};

    #[test]
    fn a_workforce_has_the_statures_and_masses_of_the_survey() {
        let of = |women: f64| workforce(women, 400).unwrap().1;
        // Percentiles 5, 50, 95 that the survey reports (m, kg); its tall women are 6 mm taller than normal ones.
        for (women, stature, mass) in [
            (0.0, [1.648, 1.755, 1.870], [64.4, 84.6, 110.7]),
            (1.0, [1.525, 1.626, 1.740], [51.3, 66.8, 87.1]),
        ] {
            let all = of(women);
            let statures: Vec<f64> = all.iter().map(|b| b.size.stature_m).collect();
            let masses: Vec<f64> = all.iter().map(|b| b.size.mass_kg).collect();
            for (p, (h, m)) in [0.05, 0.5, 0.95].into_iter().zip(stature.into_iter().zip(mass)) {
                assert!((quantile(&statures, p) - h).abs() < 0.008, "{women} {p}: {h}");
                assert!((quantile(&masses, p) / m - 1.0).abs() < 0.04, "{women} {p}: {m}");
            }
        }
    }

    #[test]
    fn spans_differ_as_the_survey_says() {
        let span = |i: u32| {
            let z = normals(&mut stream(1, Purpose::Body, 0, i), 8);
            let p = drawn(Sex::Male, 0.5, &z).1;
            2.0 * (p.upper_arm + p.forearm + p.hand + p.shoulder_half_breadth)
        };
        let spans: Vec<f64> = (0..4000).map(span).collect();
        assert!((std_dev(&spans) - 0.0274).abs() < 0.001, "{}", std_dev(&spans));
    }

    #[test]
    fn few_bodies_are_spread_like_many_and_always_the_same() {
        let (mean_body, all) = workforce(0.25, 32).unwrap();
        let women = |n: usize| all[..n].iter().filter(|b| b.size.sex == Sex::Female).count();
        assert_eq!((women(8), women(16), women(32)), (2, 4, 8));
        let statures =
            |n: usize| -> Vec<f64> { all[..n].iter().map(|b| b.size.stature_m).collect() };
        let expected = 0.25 * 1.6285 + 0.75 * 1.7562;
        assert!((mean(&statures(8)) - expected).abs() < 0.025);
        assert!((mean(&statures(32)) - expected).abs() < 0.01);
        assert!((mean_body.size.stature_m - expected).abs() < 1e-3);
        assert_eq!(workforce(0.25, 12).unwrap().1[..], all[..12]);
        // Nobody has the proportions of the mean.
        let hips = |b: &Body| b.standing_pelvis_height_m / b.size.stature_m;
        assert!(std_dev(&all.iter().map(hips).collect::<Vec<f64>>()) > 0.007);
    }
}
