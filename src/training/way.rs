//! A law with its postures, as a model holds them: numbers cut to what does not depend on the processor.

use super::dataset::{Dataset, Frame};
use super::methods::Law;
use super::rollout_check::LearnedRepetitions;
use super::settings::TrainSettings;
use super::spread::{learn_about_usual, learn_attraction, learn_postures};
use crate::posture::{
    Clock, Drift, LowNoise, LowPostures, Lowness, Noise, Population, PostureDistribution,
    PostureLaw, Pull,
};
use nalgebra::{DMatrix, DVector};

/// Significant digits kept of learned numbers. Fewer than computed, so that the file does not depend on the
/// rounding of one processor.
const DIGITS: i32 = 9;
/// The same of what a person has of their own, which few people tell.
const POPULATION_DIGITS: i32 = 4;

/// A learned law with its pull and noise, and the postures from which its movements start.
pub(super) fn learn_way(
    dataset: &Dataset,
    law: Law,
    LearnedRepetitions { noise, is_pulled, .. }: &LearnedRepetitions,
    settings: &TrainSettings,
) -> (PostureLaw, PostureDistribution) {
    let all: Vec<&Frame> = dataset.frames.iter().collect();
    // A whole person's postures are too many to be taken together: who bends for the floor does not at a bench.
    let by_place = dataset.measurer.is_some() && *is_pulled;
    let postures = learn_postures(&all);
    let postures = if by_place { learn_about_usual(dataset, settings, postures) } else { postures };
    let short = |m: DMatrix<f64>| symmetric(&rounded_matrix(&m));
    let attraction = if *is_pulled { learn_attraction(dataset, &all, settings) } else { None };
    let noise = &match (&attraction, dataset.is_of_people()) {
        (Some(attraction), true) => no_wider(noise, attraction.pull(), &postures),
        _ => noise.clone(),
    };
    let law = PostureLaw {
        weight: symmetric(&rounded_matrix(&law.law.weight)),
        attraction,
        noise: Noise {
            factor: rounded_matrix(&noise.factor),
            correlation_time_s: rounded(noise.correlation_time_s, DIGITS),
            white_interval_s: rounded(noise.white_interval_s, DIGITS),
            clock: rounded_clock(noise.clock),
            low: noise.low.as_ref().map(|low| LowNoise {
                lowness: rounded_lowness(low.lowness),
                high: low.high.map(|g| rounded(g, DIGITS)),
                low: low.low.map(|g| rounded(g, DIGITS)),
            }),
            ..noise.clone()
        },
        ..law.law
    };
    let postures = PostureDistribution {
        mean: postures.mean.map(|v| rounded(v, DIGITS)),
        covariance: short(postures.covariance),
        about_usual: postures.about_usual.map(short),
        low: postures.low.map(|low| LowPostures {
            lowness: rounded_lowness(low.lowness),
            about_usual: short(low.about_usual),
        }),
        population: postures
            .population
            .map(|own| Population { own_share: rounded(own.own_share, POPULATION_DIGITS), ..own }),
    };
    (law, postures)
}

/// The noise, where hands are not low no larger in any coordinate than lets a long movement spread as postures of
/// people who were left out do: hips stay within a centimetre there, and how unevenly they get from one place to
/// another says less of it. Under a pull by the metre that leaves 1/e after a time T of the clock, a posture spreads
/// by
///
/// ```text
/// sd^2 = |F_i|^2 T^2 (a_b + a_u tau / (T + tau))
/// ```
/// before the hand takes its part of it. Where hands are low the noise is as it was fitted: bands of left-out
/// people were too narrow with less.
pub(in crate::training) fn no_wider(
    noise: &Noise,
    pull: Pull,
    postures: &PostureDistribution,
) -> Noise {
    let (Pull::Metre { length_m }, Clock::Hand { speed_m_s, .. }, Some(about), Some(low)) =
        (pull, noise.clock, &postures.about_usual, &noise.low)
    else {
        return noise.clone();
    };
    let (shares, tau) = (noise.shares, noise.correlation_time_s);
    let back_s = length_m / speed_m_s;
    let held = shares.lasting + shares.correlated * tau / (back_s + tau);
    let high = low.high.map_with_location(|row, _, gain| {
        let most = about[(row, row)].sqrt() / (noise.factor.row(row).norm() * back_s * held.sqrt());
        if most.is_finite() { gain.min(most) } else { gain }
    });
    Noise { low: Some(LowNoise { high, ..low.clone() }), ..noise.clone() }
}

fn rounded_lowness(lowness: Lowness) -> Lowness {
    Lowness { from: rounded(lowness.from, DIGITS), to: rounded(lowness.to, DIGITS) }
}

fn rounded_clock(clock: Clock) -> Clock {
    let short = |v: f64| rounded(v, DIGITS);
    match clock {
        Clock::Hand { speed_m_s, drift: Drift { speed_rad_s, time_s } } => Clock::Hand {
            speed_m_s: short(speed_m_s),
            drift: Drift { speed_rad_s: short(speed_rad_s), time_s: short(time_s) },
        },
        Clock::Seconds { speed_share, speed_rms_m_s } => {
            Clock::Seconds { speed_share, speed_rms_m_s: short(speed_rms_m_s) }
        }
    }
}

/// `value` with a number of significant digits.
pub(super) fn rounded(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    // Through decimal text: the nearest number that prints with so many digits.
    let text = format!("{value:.*e}", digits.unsigned_abs() as usize - 1);
    text.parse().unwrap_or(value)
}

fn rounded_matrix(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    matrix.map(|v| rounded(v, DIGITS))
}

/// The upper triangle decides, so that rounding leaves the matrix symmetric.
fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i.min(j), i.max(j))])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::std_dev;
    use crate::math::stream::{Purpose, stream};
    use crate::posture::NoiseShares;

    #[test]
    fn rounding_keeps_significant_digits() {
        assert_eq!(rounded(1.234_567_890_123, 5), 1.2346);
        assert_eq!(rounded(-0.000_123_456_7, 3), -0.000_123);
        assert_eq!(rounded(0.0, 3), 0.0);
    }

    #[test]
    fn noise_under_a_pull_spreads_postures_no_more_than_was_seen() {
        let lowness = Lowness { from: 0.0, to: -0.2 };
        let alike = LowNoise {
            lowness,
            high: DVector::from_element(2, 0.5),
            low: DVector::from_element(2, 1.5),
        };
        let noise = Noise {
            factor: DMatrix::from_diagonal(&DVector::from_vec(vec![0.9, 0.9])),
            shares: NoiseShares { white: 0.0, correlated: 0.8, lasting: 0.2 },
            clock: Clock::Hand { speed_m_s: 1.5, drift: Drift::NONE },
            low: Some(alike.clone()),
            ..Noise::correlated(DMatrix::zeros(2, 2), 0.07)
        };
        let pull = Pull::Metre { length_m: 0.4 };
        let seen = DMatrix::from_diagonal(&DVector::from_vec(vec![0.02 * 0.02, 1.0]));
        let postures = PostureDistribution {
            about_usual: Some(seen.clone()),
            ..PostureDistribution::anywhere(DVector::zeros(2), seen)
        };
        let narrow = no_wider(&noise, pull, &postures);
        let gains = narrow.low.clone().unwrap();
        // The second coordinate spreads less than was seen, and keeps its noise, as all do where hands are low.
        assert_eq!((gains.high[1], &gains.low), (0.5, &alike.low));
        // The first by as much as was seen: the pull and the noise walked for long.
        let (back_s, dt, steps) = (0.4 / 1.5, 0.005, 400);
        let ends: Vec<f64> = (0..3000)
            .map(|i| {
                let path = narrow.path(&mut stream(1, Purpose::Posture, 0, i), steps + 1, dt);
                let velocity = |k: usize, x: f64| gains.high[0] * path.at(k, 0.5)[0] - x / back_s;
                (0..steps).fold(0.0, |x, k| x + dt * velocity(k, x))
            })
            .collect();
        let ratio = std_dev(&ends) / 0.02;
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
        // Noise that does not go by height stays as it is.
        let plain = Noise { low: None, ..noise };
        assert_eq!(no_wider(&plain, pull, &postures), plain);
    }
}
