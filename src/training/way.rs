//! A law with its postures, as a model holds them: numbers cut to what does not depend on the processor.

use super::dataset::{Dataset, Frame};
use super::methods::Law;
use super::rollout_check::LearnedRepetitions;
use super::settings::TrainSettings;
use super::spread::{learn_about_usual, learn_attraction, learn_postures};
use crate::posture::{
    Clock, Drift, LowNoise, LowPostures, Lowness, Noise, Population, PostureDistribution,
    PostureLaw,
};
use nalgebra::DMatrix;

/// Significant digits kept of learned numbers. Fewer than computed, so that the file does not depend on the
/// rounding of one processor.
const DIGITS: i32 = 9;
/// The same of what a person has of their own, which few people tell.
const POPULATION_DIGITS: i32 = 4;

/// A learned law with its pull and noise, and the postures from which its movements start.
pub(super) fn learn_way(
    dataset: &Dataset,
    law: Law,
    repetitions: &LearnedRepetitions,
    settings: &TrainSettings,
) -> (PostureLaw, PostureDistribution) {
    let all: Vec<&Frame> = dataset.frames.iter().collect();
    let noise = &repetitions.noise;
    // A whole person's postures are too many to be taken together: who bends for the floor does not at a bench.
    let by_place = dataset.measurer.is_some() && repetitions.is_pulled;
    let postures = learn_postures(&all);
    let postures = if by_place { learn_about_usual(dataset, settings, postures) } else { postures };
    let short = |m: DMatrix<f64>| symmetric(&rounded_matrix(&m));
    let attraction =
        if repetitions.is_pulled { learn_attraction(dataset, &all, settings) } else { None };
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
        population: postures.population.map(|own| Population {
            own_share: rounded(own.own_share, POPULATION_DIGITS),
            tail: rounded(own.tail, POPULATION_DIGITS),
            ..own
        }),
    };
    (law, postures)
}

pub(super) fn rounded_lowness(lowness: Lowness) -> Lowness {
    Lowness { from: rounded(lowness.from, DIGITS), to: rounded(lowness.to, DIGITS), ..lowness }
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

    #[test]
    fn rounding_keeps_significant_digits() {
        assert_eq!(rounded(1.234_567_890_123, 5), 1.2346);
        assert_eq!(rounded(-0.000_123_456_7, 3), -0.000_123);
        assert_eq!(rounded(0.0, 3), 0.0);
    }
}
