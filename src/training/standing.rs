//! Where several recorded people stood for the place of their hand.
//!
//! Of every movement the far end counts: the tenth of its frames in which the hand is farthest from where it
//! hangs. There people stood as they chose to; on the way they were still walking up.
//!
//! ```text
//! place = at + by_height y + r           least squares over all movements
//! of_movements   covariance of r about the person's mean, N - P degrees of freedom
//! of_people      covariance of these means less what the movements explain of it, not below zero
//! ```

use super::dataset::{Dataset, Frame};
use super::way::rounded;
use crate::math::stats::quantile;
use crate::posture::StandingPlace;
use nalgebra::{DVector, Matrix2, Vector2};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Share of the frames that are the far end of a movement.
const FARTHEST: f64 = 0.1;
/// Fewest people and movements of each that tell a standing place from a habit.
const FEWEST_PEOPLE: usize = 2;
const FEWEST_EACH: usize = 4;
/// Share of the movements that are within what people let the hand go.
const USUAL: f64 = 0.95;
/// Significant digits that are kept.
const DIGITS: i32 = 6;

/// The far end of one movement, over stature.
struct FarEnd {
    person: usize,
    height: f64,
    place: Vector2<f64>,
}

/// The standing place of whole people; none where the pelvis rests, or of too few people or movements.
pub(super) fn learn_standing(dataset: &Dataset) -> Option<StandingPlace> {
    dataset.measurer.as_ref().filter(|_| dataset.is_of_people())?;
    fitted(&far_ends(dataset))
}

/// Where somebody who was left out stood, and where the others would have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StandingScore {
    /// Root mean square of the difference ahead and to the right, m.
    pub rms_m: [f64; 2],
    /// Share of the movements within what the others say of 90 %.
    pub inside_90: f64,
}

/// Judges a standing place on another person's movements.
pub(super) fn judge_standing(place: &StandingPlace, own: &Dataset) -> StandingScore {
    let stature_m = own.coupling.stature_m();
    let ends = far_ends(own);
    let offs: Vec<_> = ends.iter().map(|e| place.off(e.place, e.height)).collect();
    let count = offs.len().max(1) as f64;
    let rms = |i: usize| {
        stature_m * (offs.iter().map(|(off, _)| off[i].powi(2)).sum::<f64>() / count).sqrt()
    };
    let inside = offs.iter().filter(|(_, inside)| *inside).count() as f64;
    StandingScore { rms_m: [rms(0), rms(1)], inside_90: inside / count }
}

/// The standing place of one worker whose movements were seen: the posterior of what is the worker's own.
pub(super) fn adapt_standing(place: &StandingPlace, own: &Dataset) -> StandingPlace {
    let ends = far_ends(own);
    let offs = ends.iter().map(|e| place.off(e.place, e.height).0);
    let count = ends.len().max(1) as f64;
    let [people, movements] = [place.of_people, place.of_movements]
        .map(|rows| Matrix2::new(rows[0][0], rows[0][1], rows[1][0], rows[1][1]));
    let Some(inverse) = (people + movements / count).try_inverse() else { return place.clone() };
    let gain = people * inverse;
    let shift = gain * offs.sum::<Vector2<f64>>() / count;
    let left = not_negative(people - gain * people);
    let short = |v: f64| rounded(v, DIGITS);
    StandingPlace {
        at: [place.at[0] + shift.x, place.at[1] + shift.y].map(short),
        of_people: [[left.m11, left.m12], [left.m12, left.m22]].map(|r| r.map(short)),
        ..place.clone()
    }
}

fn far_ends(dataset: &Dataset) -> Vec<FarEnd> {
    let stature_m = dataset.coupling.stature_m();
    let zero = DVector::zeros(dataset.coupling.dof());
    let hanging = dataset.coupling.observe(&zero, &mut crate::kinematics::Frames::default());
    let hanging = hanging.grips.first.translation.vector;
    let mut trials: BTreeMap<usize, Vec<&Frame>> = BTreeMap::new();
    for frame in &dataset.frames {
        trials.entry(frame.trial).or_default().push(frame);
    }
    let end = |frames: Vec<&Frame>| {
        let away = |f: &Frame| (f.hand.translation.vector - hanging).norm();
        let mut sorted = frames;
        sorted.sort_by(|a, b| away(b).total_cmp(&away(a)));
        let count = ((FARTHEST * sorted.len() as f64).ceil() as usize).max(1);
        let sum: crate::math::Vec3 =
            sorted.iter().take(count).map(|f| f.hand.translation.vector).sum();
        let at = sum / (count as f64 * stature_m);
        FarEnd { person: sorted[0].person, height: at.y, place: Vector2::new(at.x, at.z) }
    };
    trials.into_values().map(end).collect()
}

fn fitted(ends: &[FarEnd]) -> Option<StandingPlace> {
    let people: BTreeSet<usize> = ends.iter().map(|e| e.person).collect();
    let own = |p: usize| ends.iter().filter(move |e| e.person == p);
    if people.len() < FEWEST_PEOPLE || people.iter().any(|p| own(*p).count() < FEWEST_EACH) {
        return None;
    }
    let n = ends.len() as f64;
    let height = ends.iter().map(|e| e.height).sum::<f64>() / n;
    let centre: Vector2<f64> = ends.iter().map(|e| e.place).sum::<Vector2<f64>>() / n;
    let spread: f64 = ends.iter().map(|e| (e.height - height).powi(2)).sum();
    // All at one height: the place there is the place everywhere.
    let by_height: Vector2<f64> = if spread > 1e-6 * n {
        ends.iter().map(|e| (e.place - centre) * (e.height - height)).sum::<Vector2<f64>>() / spread
    } else {
        Vector2::zeros()
    };
    let at = centre - by_height * height;
    let residual = |e: &FarEnd| e.place - at - by_height * e.height;
    let means: BTreeMap<usize, Vector2<f64>> = people
        .iter()
        .map(|&p| (p, own(p).map(residual).sum::<Vector2<f64>>() / own(p).count() as f64))
        .collect();
    let about = |e: &FarEnd| residual(e) - means[&e.person];
    let square = |v: Vector2<f64>| v * v.transpose();
    let movements: Matrix2<f64> =
        ends.iter().map(|e| square(about(e))).sum::<Matrix2<f64>>() / (n - people.len() as f64);
    let middle = means.values().sum::<Vector2<f64>>() / people.len() as f64;
    let seen: Matrix2<f64> = means.values().map(|m| square(m - middle)).sum::<Matrix2<f64>>()
        / (people.len() - 1) as f64;
    let chance =
        people.iter().map(|p| 1.0 / own(*p).count() as f64).sum::<f64>() / people.len() as f64;
    let between = not_negative(seen - movements * chance);
    let inverse = movements.try_inverse()?;
    // A movement draws its person's mean towards itself.
    let drawn = |e: &FarEnd| {
        let count = own(e.person).count() as f64;
        count / (count - 1.0)
    };
    let distances: Vec<f64> =
        ends.iter().map(|e| (drawn(e) * (inverse * about(e)).dot(&about(e))).sqrt()).collect();
    let heights: Vec<f64> = ends.iter().map(|e| e.height).collect();
    let short = |v: f64| rounded(v, DIGITS);
    let rows = |m: Matrix2<f64>| [[m.m11, m.m12], [m.m12, m.m22]].map(|r| r.map(short));
    Some(StandingPlace {
        at: [at.x, at.y].map(short),
        by_height: [by_height.x, by_height.y].map(short),
        heights: [quantile(&heights, 0.0), quantile(&heights, 1.0)].map(short),
        of_people: rows(between),
        of_movements: rows(movements),
        farthest: short(quantile(&distances, USUAL)),
        movements: ends.len(),
        people: people.len(),
    })
}

/// The nearest covariance.
fn not_negative(matrix: Matrix2<f64>) -> Matrix2<f64> {
    let eigen = matrix.symmetric_eigen();
    let kept = Matrix2::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0)));
    eigen.eigenvectors * kept * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    fn drawn(people: usize, each: usize) -> Vec<FarEnd> {
        let mut rng = stream(5, Purpose::Simulation, 0, 0);
        let mut ends = Vec::new();
        for person in 0..people {
            let own = normals(&mut rng, 2);
            for i in 0..each {
                let m = normals(&mut rng, 2);
                let height = if i % 2 == 0 { -0.4 } else { 0.5 };
                let ahead = 0.2 + 0.3 * height + 0.05 * own[0] + 0.04 * m[0];
                let right = 0.1 + 0.02 * own[1] + 0.1 * m[1] + 0.05 * m[0];
                ends.push(FarEnd { person, height, place: Vector2::new(ahead, right) });
            }
        }
        ends
    }

    #[test]
    fn what_made_the_places_is_found_again() {
        let found = fitted(&drawn(200, 20)).unwrap();
        let near = |a: f64, b: f64, by: f64| assert!((a - b).abs() < by, "{a} {b}: {found:?}");
        near(found.at[0], 0.2, 0.01);
        near(found.by_height[0], 0.3, 0.01);
        near(found.at[1], 0.1, 0.01);
        near(found.of_people[0][0], 0.0025, 3e-4);
        near(found.of_people[1][1], 0.0004, 1.5e-4);
        near(found.of_movements[0][0], 0.0016, 1e-4);
        near(found.of_movements[1][1], 0.0125, 6e-4);
        near(found.of_movements[0][1], 0.002, 1.5e-4);
        // Root of the 95 % quantile of chi-squared with two degrees of freedom.
        near(found.farthest, 2.448, 0.05);
    }

    #[test]
    fn one_person_or_few_movements_tell_no_standing_place() {
        assert_eq!(fitted(&drawn(1, 40)), None);
        assert_eq!(fitted(&drawn(5, 3)), None);
        assert!(fitted(&drawn(2, 4)).is_some());
    }
}
