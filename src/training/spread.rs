//! Residuals of laws that have not seen the frame, the person's postures and the pull towards them.
//!
//! ```text
//! r = qdot - mean          mean by the law (and pull) learned without the frame's trial or block
//! ```
//! For rollouts the mean includes the pull.
//!
//! ```text
//! about the usual posture, of people: (1 - s) A + s B by the height of the hand, nearer to their diagonals as far as
//!           people who were left out ask for
//! postures: mean, (1 - a) C + a diag C + floor^2,  a = 0.1; floor 1 deg, or of several people what varies less
//!           as much as it does: a degree's worth of the hips is 1.5 cm, and those of upright people stay within one
//! ```

use super::dataset::{Dataset, Fold, Frame, at_most, sparse};
use super::methods::{Law, learn_laws, singular};
use super::settings::{PullRule, TrainSettings};
use super::way::{rounded, rounded_lowness};
use crate::files::InputError;
use crate::math::dense::Factor;
use crate::math::{Pose, Vec3, stats};
use crate::posture::{
    Attraction, LowPostures, Lowness, Method, Origin, Population, PostureDistribution, Pull,
    gaussian_99,
};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;

pub(super) use super::noise_fit::autocorrelation_time;

/// Significant digits kept of the many postures of several people: far below what a recording knows.
const POSTURE_DIGITS: i32 = 6;
/// Share of the diagonal in the posture covariance, and its floor, rad.
const POSTURE_SHRINKAGE: f64 = 0.1;
const POSTURE_FLOOR_RAD: f64 = std::f64::consts::PI / 180.0;
const LEAST_POSTURE_FLOOR_RAD: f64 = 0.1 * POSTURE_FLOOR_RAD;

/// Most that can be a person's own: repetitions of nobody are alike.
const MOST_OWN: f64 = 0.95;

/// How many times the variance of postures is as large where hands are low, in between (see [`Lowness`]).
const RATIOS: [f64; 4] = [1.0, 8.0, 32.0, 128.0];
/// By how much more covariances about usual postures of people are shrunk to their diagonals: few people tell the
/// narrow directions of a covariance too narrow.
const MORE_SHRUNK: [f64; 5] = [0.0, 0.2, 0.4, 0.6, 0.8];

/// What is left of a frame's joint velocity.
#[derive(Debug, Clone)]
pub struct Residual<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// qdot minus the expected joint velocity, n, rad/s.
    pub value: DVector<f64>,
    /// Factor by which the spread there exceeds the noise, for what a process does not know, n.
    pub growth: DVector<f64>,
}

/// Of some things those in whose frame both feet stand, as they do in a plan; all where there are too few of them.
pub(super) fn planted_of<T: Clone>(all: &[T], frame: impl Fn(&T) -> &Frame) -> Vec<T> {
    /// Share of the frames.
    const FEWEST: f64 = 0.2;
    let planted: Vec<T> = all.iter().filter(|t| !frame(t).is_stepping).cloned().collect();
    if (planted.len() as f64) < FEWEST * all.len() as f64 { all.to_vec() } else { planted }
}

/// The same of frames.
fn planted<'a>(frames: &[&'a Frame]) -> Vec<&'a Frame> {
    planted_of(frames, |f| f)
}

/// The pull of the settings towards the postures of these frames; none when it is switched off.
pub fn learn_attraction(
    dataset: &Dataset,
    frames: &[&Frame],
    settings: &TrainSettings,
) -> Option<Attraction> {
    let pull = match settings.pull_for(dataset.person.is_some()) {
        PullRule::PerMetre => Pull::Metre { length_m: settings.attraction_length_m },
        PullRule::PerSecond => Pull::Second { rate_per_s: settings.attraction_rate_per_s },
        PullRule::None => return None,
    };
    let people: BTreeSet<usize> = frames.iter().map(|f| f.person).collect();
    let kept =
        at_most(&sparse(&planted(frames)), settings.attraction_postures * people.len().max(1));
    let hands: Vec<Pose> = kept.iter().map(|f| f.hand).collect();
    let mut rows: Vec<_> = kept.iter().map(|f| f.q.transpose()).collect();
    if dataset.is_of_people() {
        for row in &mut rows {
            row.apply(|v| *v = rounded(*v, POSTURE_DIGITS));
        }
        let origins = kept.iter().map(|f| Origin { person: f.person, movement: f.trial }).collect();
        return Some(Attraction::of_people(
            &hands,
            DMatrix::from_rows(&rows),
            origins,
            dataset.coupling.stature_m(),
            (pull, settings.place_length, settings.attraction_noise),
            dataset.low_places().map(rounded_lowness),
        ));
    }
    Some(Attraction::fit(
        &hands,
        DMatrix::from_rows(&rows),
        dataset.coupling.stature_m(),
        pull,
        settings.attraction_length,
        settings.attraction_noise,
    ))
}

/// The preferred velocity by which an attraction pulls at a frame, n, rad/s.
pub fn pull(attraction: Option<&Attraction>, frame: &Frame, stature_m: f64) -> DVector<f64> {
    attraction.map_or_else(
        || DVector::zeros(frame.q.len()),
        |a| a.pull_velocity(&frame.hand, frame.xdot.as_slice(), &frame.q, stature_m),
    )
}

/// Residuals of each law (outer index as in `laws`) on every test frame of `folds`, relearned
/// without it. With `is_pulled` the attraction is part of the law, also relearned.
///
/// # Errors
/// Where the chain is singular in the data.
pub fn unseen_residuals<'a>(
    dataset: &'a Dataset,
    folds: &[Fold],
    laws: &[Law],
    settings: &TrainSettings,
    is_pulled: bool,
) -> Result<Vec<Vec<Residual<'a>>>, InputError> {
    let methods: Vec<Method> = laws.iter().map(|l| l.method).collect();
    let stature_m = dataset.coupling.stature_m();
    let mut found: Vec<Vec<Residual>> = vec![Vec::new(); laws.len()];
    for fold in folds {
        let train = dataset.select(&fold.train);
        let relearned = learn_laws(&methods, &train, stature_m, settings, Some(laws))?;
        let attraction = if is_pulled { learn_attraction(dataset, &train, settings) } else { None };
        let test = dataset.select(&fold.test);
        let queries: Vec<_> = test.iter().map(|f| f.query()).collect();
        for (residuals, law) in found.iter_mut().zip(&relearned) {
            let posteriors = law.law.posteriors().ok_or_else(singular)?;
            let growth = law.law.growth(&posteriors, &queries);
            for (frame, growth) in test.iter().copied().zip(growth) {
                let pulled = pull(attraction.as_ref(), frame, stature_m);
                let value = &frame.qdot - law.expected(frame, &pulled)?;
                residuals.push(Residual { frame, value, growth });
            }
        }
    }
    Ok(found)
}

/// `mean r r^T`, n x n.
fn covariance<'a>(residuals: impl IntoIterator<Item = &'a DVector<f64>>) -> DMatrix<f64> {
    let (mut sum, mut count) = (DMatrix::zeros(0, 0), 0);
    for r in residuals {
        if count == 0 {
            sum = DMatrix::zeros(r.len(), r.len());
        }
        sum.ger(1.0, r, r, 1.0);
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// The person's postures as a shrunk Gaussian.
pub fn learn_postures(frames: &[&Frame]) -> PostureDistribution {
    let n = frames.first().map_or(0, |f| f.q.len());
    let mean = frames.iter().fold(DVector::zeros(n), |sum, f| sum + &f.q) / frames.len() as f64;
    let centred: Vec<DVector<f64>> = frames.iter().map(|f| &f.q - &mean).collect();
    PostureDistribution::anywhere(mean, shrunk(covariance(&centred), POSTURE_FLOOR_RAD))
}

/// Nearer to its diagonal by a share.
fn nearer_diagonal(full: &DMatrix<f64>, share: f64) -> DMatrix<f64> {
    full * (1.0 - share) + DMatrix::from_diagonal(&full.diagonal()) * share
}

/// With a floor that is not below `least`, rad.
fn shrunk(full: DMatrix<f64>, least: f64) -> DMatrix<f64> {
    let diagonal = DMatrix::from_diagonal(&full.diagonal());
    let floor =
        diagonal.map_diagonal(|variance| variance.sqrt().clamp(least, POSTURE_FLOOR_RAD).powi(2));
    let floor = DMatrix::from_diagonal(&floor);
    full * (1.0 - POSTURE_SHRINKAGE) + diagonal * POSTURE_SHRINKAGE + floor
}

/// How a posture departs from the usual one at the hand's place, learned without its trial.
struct Departure {
    /// How well the usual posture is known there.
    known: f64,
    /// How low the hand is, and its height (rest frame, over stature).
    low: f64,
    height: f64,
    off: DVector<f64>,
    /// Which movement it is of, and where the hand is, over stature.
    movement: usize,
    place: Vec3,
}

/// Postures with their shrunk covariance about the usual one at the hand's place, learned without the frame's
/// trial (of several people, without the person): each frame counts as far as the usual posture is known there.
/// Where hands are low it is another if that makes what was left out likelier. As they are without a pull or
/// without other trials.
pub(super) fn learn_about_usual(
    dataset: &Dataset,
    settings: &TrainSettings,
    postures: PostureDistribution,
) -> PostureDistribution {
    let spread = about_usual(dataset, settings).map(|(about_usual, low, population)| {
        PostureDistribution { about_usual: Some(about_usual), low, population, ..postures.clone() }
    });
    spread.unwrap_or(postures)
}

type Spread = (DMatrix<f64>, Option<LowPostures>, Option<Population>);

fn about_usual(dataset: &Dataset, settings: &TrainSettings) -> Option<Spread> {
    let stature_m = dataset.coupling.stature_m();
    let lowness = dataset.lowness();
    let mut folds: Vec<Vec<Departure>> = Vec::new();
    for fold in dataset.held_out() {
        let attraction = learn_attraction(dataset, &dataset.select(&fold.train), settings)?;
        let test = sparse(&planted(&dataset.select(&fold.test)));
        let hands: Vec<Pose> = test.iter().map(|f| f.hand).collect();
        let usual = attraction.usual_postures(&hands, stature_m);
        let departures = test.into_iter().zip(usual).map(|(frame, usual)| {
            let off = &frame.q - &usual.posture;
            // Where less is known people are farther off: as far as the regression says.
            let (known, off) = match usual.growth {
                Some(growth) => (1.0, off / growth.sqrt()),
                None => (usual.trust(), off),
            };
            Departure {
                known,
                low: 0.0,
                height: frame.hand.translation.y / stature_m,
                off,
                movement: frame.trial,
                place: frame.hand.translation.vector / stature_m,
            }
        });
        folds.push(departures.collect());
    }
    let least = if dataset.is_of_people() { LEAST_POSTURE_FLOOR_RAD } else { POSTURE_FLOOR_RAD };
    let (low, more) =
        if dataset.is_of_people() { likeliest(&mut folds, lowness, least) } else { (None, 0.0) };
    let all: Vec<&Departure> = folds.iter().flatten().collect();
    let whole = nearer_diagonal(&spread_of(&all, least, |_| 1.0)?, more);
    let (covariance, low) = match low.and_then(|lowness| Some((lowness, by_height(&all, least)?))) {
        Some((lowness, both)) => {
            let [high, about_usual] = both.map(|own| nearer_diagonal(&own, more));
            (high, Some(LowPostures { lowness, about_usual }))
        }
        None => (whole, None),
    };
    let population = if dataset.is_of_people() && folds.len() > 1 {
        let below = low.as_ref().map(|low| &low.about_usual);
        let own_share = own_share(&folds, (&covariance, below), settings.place_length)?;
        let tail = tail(&folds, (low.is_some(), more), least)?;
        Some(Population { own_share, people: folds.len(), tail })
    } else {
        None
    };
    Some((covariance, low, population))
}

/// How many times as far as those of a Gaussian the farthest hundredth of departures that were left out lie from what
/// the others say, at least 1.
fn tail(folds: &[Vec<Departure>], (by_low, more): (bool, f64), least: f64) -> Option<f64> {
    /// Share of the departures that are usual.
    const USUAL: f64 = 0.99;
    let mut distances = Vec::new();
    for (left_out, own) in folds.iter().enumerate() {
        let others = folds.iter().enumerate().filter(|(f, _)| *f != left_out);
        let others: Vec<&Departure> = others.flat_map(|(_, own)| own).collect();
        let both = if by_low {
            by_height(&others, least)?
        } else {
            let whole = spread_of(&others, least, |_| 1.0)?;
            [whole.clone(), whole]
        };
        let [high, low] = both.map(|own| nearer_diagonal(&own, more));
        for d in own {
            let factor = (&high * (1.0 - d.low) + &low * d.low).cholesky()?;
            distances.push(factor.l().solve_lower_triangular(&d.off)?.norm());
        }
    }
    let n = folds.iter().flatten().next()?.off.len();
    Some((stats::quantile(&distances, USUAL) / gaussian_99(n)).max(1.0))
}

/// Share of the variance about the usual posture that other movements of the same person have in common, at
/// places of the hand that are near each other; each fold is one person.
fn own_share(
    folds: &[Vec<Departure>],
    (high, low): (&DMatrix<f64>, Option<&DMatrix<f64>>),
    near: f64,
) -> Option<f64> {
    let white = |d: &Departure| {
        let covariance = low.map_or_else(|| high.clone(), |low| high * (1.0 - d.low) + low * d.low);
        covariance.cholesky()?.l().solve_lower_triangular(&d.off)
    };
    let (mut common, mut pairs) = (0.0, 0.0);
    let (mut square, mut known) = (0.0, 0.0);
    for person in folds {
        let off: Vec<DVector<f64>> = person.iter().map(white).collect::<Option<_>>()?;
        for (i, a) in person.iter().enumerate() {
            square += a.known * off[i].norm_squared();
            known += a.known;
            for (j, b) in person[..i].iter().enumerate().filter(|(_, b)| b.movement != a.movement) {
                let weight = a.known
                    * b.known
                    * (-0.5 * (a.place - b.place).norm_squared() / (near * near)).exp();
                common += weight * off[i].dot(&off[j]);
                pairs += weight;
            }
        }
    }
    let share = (common / pairs) / (square / known);
    Some(if share.is_finite() { share.clamp(0.0, MOST_OWN) } else { 0.0 })
}

/// Shrunk weighted second moment; none where nothing is known.
fn spread_of(
    all: &[&Departure],
    least: f64,
    weight: impl Fn(&Departure) -> f64,
) -> Option<DMatrix<f64>> {
    let n = all.first()?.off.len();
    let (mut sum, mut known) = (DMatrix::zeros(n, n), 0.0);
    for d in all {
        let own = d.known * weight(d);
        sum.ger(own, &d.off, &d.off, 1.0);
        known += own;
    }
    (known > 0.0).then(|| shrunk(sum / known, least))
}

/// Of hands that are not low, and of those that are: the likeliest `A` and `B` where a departure at lowness `s` has
/// the covariance `(1 - s) A + s B`, found by expectation maximisation with a departure as the sum of two of which
/// neither is seen.
fn by_height(all: &[&Departure], least: f64) -> Option<[DMatrix<f64>; 2]> {
    /// From the moments on, which take what lies in between for both.
    const PASSES: usize = 12;
    let mut both = [spread_of(all, least, |d| 1.0 - d.low)?, spread_of(all, least, |d| d.low)?];
    let share = |d: &Departure, part: usize| if part == 0 { 1.0 - d.low } else { d.low };
    for _ in 0..PASSES {
        let n = both[0].nrows();
        let (mut sums, mut known) = ([DMatrix::zeros(n, n), DMatrix::zeros(n, n)], [0.0; 2]);
        for d in all {
            let here = &both[0] * share(d, 0) + &both[1] * share(d, 1);
            let factor = Factor::new(&here)?;
            let white = factor.solve(&DMatrix::from_column_slice(n, 1, d.off.as_slice()));
            for part in 0..2 {
                let share = share(d, part);
                if share == 0.0 {
                    continue;
                }
                // Given the departure: its mean, and what is left of its covariance.
                let mean = &both[part] * white.column(0) * share.sqrt();
                sums[part].ger(d.known, &mean, &mean, 1.0);
                if share < 1.0 {
                    let explained = factor.solve(&both[part]).tr_mul(&both[part]) * share;
                    sums[part] += (&both[part] - explained) * d.known;
                }
                known[part] += d.known;
            }
        }
        for part in 0..2 {
            if known[part] > 0.0 {
                both[part] = shrunk(&sums[part] / known[part], least);
            }
        }
    }
    Some(both)
}

/// How the spread of departures goes by the height of the hand, and by how much more it is shrunk, so that those
/// that were left out are likeliest; with that lowness in each of them. No lowness where they are likelier with the
/// same spread everywhere.
fn likeliest(
    folds: &mut [Vec<Departure>],
    lowness: Option<Lowness>,
    least: f64,
) -> (Option<Lowness>, f64) {
    let mut best = (0.0, None, 0.0);
    let mut consider = |gains: Option<Vec<f64>>, lowness: Option<Lowness>| {
        for (gain, more) in gains.into_iter().flatten().zip(MORE_SHRUNK) {
            if gain > best.0 {
                best = (gain, lowness, more);
            }
        }
    };
    let everywhere = |all: &[&Departure]| spread_of(all, least, |_| 1.0).map(|c| [c.clone(), c]);
    consider(gains(folds, least, everywhere), None);
    for tried in lowness.iter().flat_map(|l| RATIOS.map(|ratio| Lowness { ratio, ..*l })) {
        set_low(folds, tried);
        consider(gains(folds, least, |all| by_height(all, least)), Some(tried));
    }
    if let Some(lowness) = best.1 {
        set_low(folds, lowness);
    }
    (best.1, best.2)
}

fn set_low(folds: &mut [Vec<Departure>], lowness: Lowness) {
    folds.iter_mut().flatten().for_each(|d| d.low = lowness.of(d.height));
}

/// By how much departures that were left out are likelier than with one spread everywhere, in logarithms, where
/// their spreads are what `fit` says of the others, shrunk more and more.
fn gains(
    folds: &[Vec<Departure>],
    least: f64,
    fit: impl Fn(&[&Departure]) -> Option<[DMatrix<f64>; 2]>,
) -> Option<Vec<f64>> {
    let mut gains = vec![0.0; MORE_SHRUNK.len()];
    for (left_out, own) in folds.iter().enumerate() {
        let others = folds.iter().enumerate().filter(|(f, _)| *f != left_out);
        let others: Vec<&Departure> = others.flat_map(|(_, own)| own).collect();
        let whole = spread_of(&others, least, |_| 1.0)?;
        let both = fit(&others)?;
        for (gain, more) in gains.iter_mut().zip(MORE_SHRUNK) {
            let [high, low] = both.each_ref().map(|own| nearer_diagonal(own, more));
            for d in own {
                let here = &high * (1.0 - d.low) + &low * d.low;
                *gain += d.known * (log_density(&here, &d.off)? - log_density(&whole, &d.off)?);
            }
        }
    }
    Some(gains)
}

/// Logarithm of a Gaussian's density about zero, but for a constant.
fn log_density(covariance: &DMatrix<f64>, off: &DVector<f64>) -> Option<f64> {
    let factor = covariance.clone().cholesky()?;
    let white = factor.l().solve_lower_triangular(off)?;
    let log_det: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
    Some(-log_det - 0.5 * white.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};
    use crate::training::dataset::tests::made_up;

    #[test]
    fn postures_of_a_flat_set_are_still_positive_definite() {
        let data = made_up(1, 2.0, 30.0);
        let frames: Vec<&Frame> = data.frames.iter().take(5).collect();
        let postures = learn_postures(&frames);
        assert!(postures.covariance.clone().cholesky().is_some());
        assert!(postures.mahalanobis(&frames[2].q) < 3.0);
    }

    #[test]
    fn spreads_by_height_are_found_where_there_are_two() {
        let folds = |sd_low: f64| -> Vec<Vec<Departure>> {
            let departure = |rng: &mut _, i: usize| {
                let low = f64::from(u8::from(i.is_multiple_of(2)));
                let sd = 0.1 + (sd_low - 0.1) * low;
                let off = DVector::from_vec(crate::math::stream::normals(rng, 3)) * sd;
                let (movement, place) = (i / 20, Vec3::zeros());
                Departure { known: 1.0, low, height: -low, off, movement, place }
            };
            let fold = |f: u64| {
                let mut rng = stream(f, Purpose::Simulation, 3, 0);
                (0..60).map(|i| departure(&mut rng, i)).collect()
            };
            (0..4).map(fold).collect()
        };
        let lowness = Lowness::linear(0.0, -1.0);
        assert_eq!(likeliest(&mut folds(0.1), Some(lowness), POSTURE_FLOOR_RAD).0, None);
        let mut two = folds(0.3);
        // Nothing lies in between that would tell one way there from another.
        let (found, _) = likeliest(&mut two, Some(lowness), POSTURE_FLOOR_RAD);
        assert_eq!(found, Some(lowness));
        let [high, low] =
            by_height(&two.iter().flatten().collect::<Vec<_>>(), POSTURE_FLOOR_RAD).unwrap();
        let floor = POSTURE_FLOOR_RAD.powi(2);
        let sd = |m: &DMatrix<f64>| (m.trace() / 3.0 - floor).sqrt();
        assert!((sd(&high) - 0.1).abs() < 0.01 && (sd(&low) - 0.3).abs() < 0.03);
        // The density of a standard normal, but for its constant.
        let off = DVector::from_vec(vec![1.0, 2.0]);
        let density = log_density(&DMatrix::identity(2, 2), &off).unwrap();
        assert!((density + 2.5).abs() < 1e-12);
    }

    #[test]
    fn a_covariance_of_few_is_shrunk_and_one_of_many_is_not() {
        // Two coordinates that go together, and six that know of nobody.
        let shrunk = |each: usize| {
            let fold = |f: u64| {
                let mut rng = stream(f, Purpose::Simulation, 3, 0);
                let departure = |_| {
                    let z = crate::math::stream::normals(&mut rng, 8);
                    let mut off = DVector::from_vec(z) * 0.1;
                    off[1] = 0.8 * off[0] + 0.6 * off[1];
                    let place = Vec3::zeros();
                    Departure { known: 1.0, low: 0.0, height: 0.0, off, movement: 0, place }
                };
                (0..each).map(departure).collect::<Vec<_>>()
            };
            likeliest(&mut (0..4).map(fold).collect::<Vec<_>>(), None, POSTURE_FLOOR_RAD).1
        };
        assert!(shrunk(4) >= 0.2, "{}", shrunk(4));
        assert_eq!(shrunk(400), 0.0);
    }

    #[test]
    fn the_tail_is_that_of_a_gaussian_or_of_people_who_are_farther_off() {
        // Each of four people is away from the others by so much, in all of their movements.
        let tail_of = |away: f64| {
            let fold = |f: u64| {
                let mut rng = stream(f, Purpose::Simulation, 3, 0);
                let own = DVector::from_vec(crate::math::stream::normals(&mut rng, 6)) * away;
                let departure = |_| {
                    let off = DVector::from_vec(crate::math::stream::normals(&mut rng, 6)) + &own;
                    let place = Vec3::zeros();
                    Departure { known: 1.0, low: 0.0, height: 0.0, off, movement: 0, place }
                };
                (0..500).map(departure).collect::<Vec<_>>()
            };
            let folds: Vec<_> = (0..4).map(fold).collect();
            tail(&folds, (false, 0.0), POSTURE_FLOOR_RAD).unwrap()
        };
        assert!((1.0..1.08).contains(&tail_of(0.0)), "{}", tail_of(0.0));
        assert!(tail_of(3.0) > 1.2, "{}", tail_of(3.0));
    }

    #[test]
    fn how_a_spread_grows_on_the_way_down_is_found() {
        let grown = |ratio: f64| {
            let lowness = Lowness { ratio, ..Lowness::linear(0.0, -1.0) };
            let fold = |f: u64| {
                let mut rng = stream(f, Purpose::Simulation, 3, 0);
                let departure = |i: usize| {
                    let height = -f64::from(u8::try_from(i % 11).unwrap()) / 10.0;
                    let sd = (0.01 + 0.15 * lowness.of(height)).sqrt();
                    let off = DVector::from_vec(crate::math::stream::normals(&mut rng, 3)) * sd;
                    Departure {
                        known: 1.0,
                        low: 0.0,
                        height,
                        off,
                        movement: 0,
                        place: Vec3::zeros(),
                    }
                };
                (0..400).map(departure).collect::<Vec<_>>()
            };
            let mut folds: Vec<_> = (0..4).map(fold).collect();
            let lowness = Some(Lowness::linear(0.0, -1.0));
            likeliest(&mut folds, lowness, POSTURE_FLOOR_RAD).0.unwrap().ratio
        };
        assert_eq!(grown(1.0), 1.0);
        assert!([8.0, 32.0].contains(&grown(16.0)), "{}", grown(16.0));
    }

    #[test]
    fn unseen_residuals_are_those_of_laws_without_the_block() {
        let data = made_up(1, 6.0, 30.0);
        let settings = TrainSettings::default();
        let all: Vec<&Frame> = data.frames.iter().collect();
        let laws = learn_laws(&[Method::FullW], &all, 1.6, &settings, None).unwrap();
        let folds = data.blocks();
        let found = unseen_residuals(&data, &folds, &laws, &settings, true).unwrap();
        assert_eq!(found[0].len(), data.frames.len());
        assert!(found[0].iter().all(|r| (&r.frame.jacobian * &r.value).norm() < 1e-9));
    }
}
