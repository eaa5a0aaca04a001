//! Random streams that depend on what is drawn, never on scheduling.
//!
//! A stream is named by (seed, purpose, block, index). Two streams with different names are
//! independent; the same name gives the same numbers with any number of threads.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What the numbers are for; keeps the streams of different purposes apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Start posture, function draw and correlated noise of one rollout. Never the candidate, so
    /// that all candidates meet the same people.
    Posture = 1,
    /// Sampling of candidate paths.
    Search = 2,
    /// Restarts of the robot's inverse kinematics.
    RobotIk = 3,
    /// Simulated operators and other made-up data.
    Simulation = 4,
    /// Resampling for confidence intervals.
    Bootstrap = 5,
    /// What a person has of their own in all repetitions.
    Person = 6,
    /// Which of several ways a person has the habit of, and which a repetition takes.
    Habit = 7,
    /// Of what proportions a body is.
    Body = 8,
}

/// The stream of `index` in `block` for a purpose.
///
/// # Examples
/// ```
/// use ergopath::math::stream::{normals, stream, Purpose};
/// let mut a = stream(7, Purpose::Posture, 0, 3);
/// let mut b = stream(7, Purpose::Posture, 0, 3);
/// assert_eq!(normals(&mut a, 4), normals(&mut b, 4));
/// ```
pub fn stream(seed: u64, purpose: Purpose, block: u32, index: u32) -> ChaCha8Rng {
    // The whole name is the key: no two names share a key, whatever the seed.
    let mut key = [0u8; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8] = purpose as u8;
    key[12..16].copy_from_slice(&block.to_le_bytes());
    key[16..20].copy_from_slice(&index.to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

/// `count` independent standard normal numbers.
pub fn normals(rng: &mut ChaCha8Rng, count: usize) -> Vec<f64> {
    (0..count).map(|_| StandardNormal.sample(rng)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_the_name_makes_another_stream() {
        let draw = |s, p, b, i| normals(&mut stream(s, p, b, i), 3);
        let base = draw(1, Purpose::Posture, 2, 3);
        for other in [
            draw(2, Purpose::Posture, 2, 3),
            draw(1, Purpose::Search, 2, 3),
            draw(1, Purpose::Posture, 3, 3),
            draw(1, Purpose::Posture, 2, 4),
        ] {
            assert_ne!(base, other);
        }
    }
}
