//! What a model of whole people says of a pelvis that was not recorded.
//!
//! The place of the hand goes with the pelvis, and is as unknown. So the people's postures count as a mixture
//! over the places `x` at which the model was learned, each with the usual posture `m(x)` there and one covariance
//! `S` about it: with the wider one of low hands the places were told apart worse, on the five recorded people.
//! Of what is unknown (`a`) it expects, given what is known (`b`):
//!
//! ```text
//! a = G b + sum_x r_x (m_a(x) - G m_b(x))      G = S_ab S_bb^-1,  r_x ~ N(b; m_b(x), S_bb), sums to 1
//! ```
//! What stays unknown is told by one Gaussian of all postures, `U = S_aa - S_ab S_bb^-1 S_ba`: the mixture takes
//! the one place that fits for the true one, and is too sure of itself. `U` is added to the covariances of a model
//! that is learned of filled postures; so is that of velocities and noise, scaled to these people by what is known.

use super::adapt::{rest, slopes};
use super::model::PostureModel;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Share of its trace that is added to a covariance that need not be of full rank.
const FLOOR: f64 = 1e-9;

/// Fills the unknown coordinates of postures.
#[derive(Debug, Clone)]
pub struct Filling {
    split: Split,
    /// `G`, and `S_bb` factored as `L L^T`.
    gain: DMatrix<f64>,
    root: Cholesky<f64, Dyn>,
    /// Of each place: `L^-1 m_b`, and `m_a - G m_b`.
    places: Vec<(DVector<f64>, DVector<f64>)>,
}

/// Which coordinates of a posture are known.
#[derive(Debug, Clone)]
struct Split {
    known: Vec<usize>,
    unknown: Vec<usize>,
}

impl Split {
    fn new(unknown: &[usize], n: usize) -> Self {
        let known = (0..n).filter(|i| !unknown.contains(i)).collect();
        Self { known, unknown: unknown.to_vec() }
    }

    /// `S_ab S_bb^-1` and `S_aa - S_ab S_bb^-1 S_ba` of a covariance of all coordinates.
    fn conditioned(&self, all: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let order: Vec<usize> = self.known.iter().chain(&self.unknown).copied().collect();
        let turned = DMatrix::from_fn(order.len(), order.len(), |r, c| all[(order[r], order[c])]);
        let gain = slopes(&turned, self.known.len())?;
        let left = rest(&turned, self.known.len(), &gain);
        Some((gain, left))
    }
}

fn picked(which: &[usize], all: &DVector<f64>) -> DVector<f64> {
    DVector::from_fn(which.len(), |i, _| all[which[i]])
}

impl Filling {
    /// By a model of whole people, of the coordinates `unknown`; none where a covariance of it is singular.
    pub fn new(whole: &PostureModel, unknown: &[usize]) -> Option<Self> {
        let postures = &whole.postures;
        let split = Split::new(unknown, whole.joints.len());
        let (usual, spread) = match &whole.law.attraction {
            Some(attraction) => {
                let about = postures.about_usual.as_ref().unwrap_or(&postures.covariance);
                (attraction.where_learned(), about)
            }
            None => (vec![postures.mean.clone()], &postures.covariance),
        };
        let (gain, _) = split.conditioned(spread)?;
        let b = &split.known;
        let root = DMatrix::from_fn(b.len(), b.len(), |r, c| spread[(b[r], b[c])]).cholesky()?;
        let place = |m: &DVector<f64>| {
            let known = picked(&split.known, m);
            let offset = picked(&split.unknown, m) - &gain * &known;
            Some((root.l_dirty().solve_lower_triangular(&known)?, offset))
        };
        let places: Option<Vec<_>> = usual.iter().map(place).collect();
        Some(Self { places: places?, split, gain, root })
    }

    /// A posture (n; leg lengths, rad) with its unknown coordinates filled in; none where it is not finite.
    pub fn fill(&self, q: &DVector<f64>) -> Option<DVector<f64>> {
        let b = picked(&self.split.known, q);
        let white = self.root.l_dirty().solve_lower_triangular(&b)?;
        let log_share = |at: &DVector<f64>| -0.5 * (&white - at).norm_squared();
        let most =
            self.places.iter().map(|(at, _)| log_share(at)).fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut total) = (DVector::zeros(self.split.unknown.len()), 0.0);
        for (at, offset) in &self.places {
            let share = (log_share(at) - most).exp();
            sum += offset * share;
            total += share;
        }
        let expected = &self.gain * b + sum / total;
        let mut whole = q.clone();
        for (i, value) in self.split.unknown.iter().zip(&expected) {
            whole[*i] = *value;
        }
        whole.iter().all(|v| v.is_finite()).then_some(whole)
    }
}

/// Coordinates of recorded postures that were filled in.
#[derive(Debug, Clone)]
pub struct Unrecorded {
    /// Which.
    pub coordinates: Vec<usize>,
    /// Share of the postures that were filled.
    pub share: f64,
}

impl PostureModel {
    /// What is not known of some coordinates of a posture when the others are: a covariance (leg lengths, rad); none
    /// where that of all is singular.
    pub fn unknown_of(&self, coordinates: &[usize]) -> Option<DMatrix<f64>> {
        Some(Split::new(coordinates, self.joints.len()).conditioned(&self.postures.covariance)?.1)
    }

    /// A model that was learned of postures some of whose coordinates were filled in by `whole`, with what is not
    /// known of them; none where a matrix of `whole` is singular.
    #[must_use]
    pub fn unsure_of(mut self, filled: &Unrecorded, whole: &Self) -> Option<Self> {
        let Unrecorded { coordinates, share } = filled;
        let split = Split::new(coordinates, whole.joints.len());
        let of_known = |m: &DMatrix<f64>| split.known.iter().map(|&i| m[(i, i)]).sum::<f64>();
        // These people may move faster or slower than the others.
        let of_velocity = |own: &DMatrix<f64>, other: &DMatrix<f64>| {
            let n = other.nrows();
            let floored = other + DMatrix::identity(n, n) * (FLOOR * other.trace());
            let (_, left) = split.conditioned(&floored)?;
            Some(left * (share * of_known(own) / of_known(other)))
        };
        let weight = of_velocity(&self.law.weight, &whole.law.weight)?;
        add(&mut self.law.weight, coordinates, &weight);
        let spread = whole.unknown_of(coordinates)? * *share;
        add(&mut self.postures.covariance, coordinates, &spread);
        if let Some(about) = &mut self.postures.about_usual {
            add(about, coordinates, &spread);
        }
        let square = |model: &Self| &model.law.noise.factor * model.law.noise.factor.transpose();
        let noise = of_velocity(&square(&self), &square(whole))?.cholesky()?.unpack();
        let columns = self.law.noise.factor.ncols();
        let factor = self.law.noise.factor.clone();
        let mut factor = factor.resize_horizontally(columns + noise.ncols(), 0.0);
        for (r, &i) in coordinates.iter().enumerate() {
            for c in 0..noise.ncols() {
                factor[(i, columns + c)] = noise[(r, c)];
            }
        }
        self.law.noise.factor = factor;
        Some(self)
    }
}

/// Adds a covariance of some coordinates to one of all.
fn add(all: &mut DMatrix<f64>, which: &[usize], more: &DMatrix<f64>) {
    for (r, &i) in which.iter().enumerate() {
        for (c, &j) in which.iter().enumerate() {
            all[(i, j)] += more[(r, c)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posture::load_model;
    use std::path::Path;

    /// Where the hips are.
    const PLACE: [usize; 3] = [0, 1, 2];

    fn people() -> PostureModel {
        load_model("people", Path::new(".")).unwrap().0
    }

    #[test]
    fn one_place_is_the_conditioned_gaussian() {
        let mut model = people();
        model.law.attraction = None;
        let filling = Filling::new(&model, &PLACE).unwrap();
        let q = &model.postures.mean + DVector::from_fn(30, |i, _| 0.05 * (i as f64).sin());
        let found = filling.fill(&q).unwrap();
        // By the precision P: a = m_a - P_aa^-1 P_ab (b - m_b), with covariance P_aa^-1.
        let precision = model.postures.covariance.clone().cholesky().unwrap().inverse();
        let own = precision.view((0, 0), (3, 3)).into_owned().cholesky().unwrap();
        let off = (&q - &model.postures.mean).rows_range(3..).into_owned();
        let wanted =
            model.postures.mean.rows(0, 3) - own.solve(&(precision.view((0, 3), (3, 27)) * off));
        assert!((found.rows(0, 3) - wanted).amax() < 1e-9);
        assert_eq!(found.rows_range(3..), q.rows_range(3..));
        let (unknown, inverse) = (model.unknown_of(&PLACE).unwrap(), own.inverse());
        assert!((unknown - &inverse).amax() < 1e-9 * inverse.amax());
    }

    #[test]
    fn places_count_by_how_well_they_explain_what_is_known() {
        let model = people();
        let filling = Filling::new(&model, &PLACE).unwrap();
        let usual = model.law.attraction.as_ref().unwrap().where_learned();
        // The naive mixture of all densities of the known coordinates.
        let spread = model.postures.about_usual.clone().unwrap();
        let of_known = spread.view((3, 3), (27, 27)).into_owned().cholesky().unwrap();
        for row in [3, usual.len() / 2] {
            let mut q = usual[row].clone();
            q[9] += 0.02;
            let (mut sum, mut total) = (DVector::zeros(3), 0.0);
            for m in &usual {
                let off = (&q - m).rows_range(3..).into_owned();
                let solved = of_known.solve(&off);
                let share = (-0.5 * off.dot(&solved)).exp();
                let gain = spread.view((0, 3), (3, 27)) * solved;
                sum += (m.rows(0, 3) + gain) * share;
                total += share;
            }
            let found = filling.fill(&q).unwrap();
            assert!((found.rows(0, 3) - sum / total).amax() < 1e-7);
        }
        assert!(filling.fill(&DVector::from_element(30, f64::NAN)).is_none());
    }

    #[test]
    fn what_is_not_known_is_added_where_it_was_filled_and_nowhere_else() {
        let model = people();
        let filled = Unrecorded { coordinates: PLACE.to_vec(), share: 0.5 };
        let unsure = model.clone().unsure_of(&filled, &model).unwrap();
        let square = |m: &PostureModel| &m.law.noise.factor * m.law.noise.factor.transpose();
        for (before, after, exact) in [
            (&model.law.weight, &unsure.law.weight, true),
            (&model.postures.covariance, &unsure.postures.covariance, true),
            (&square(&model), &square(&unsure), false),
        ] {
            let more = after - before;
            assert!(more.view((3, 0), (27, 30)).amax() < 1e-15);
            let more = more.view((0, 0), (3, 3)).into_owned();
            assert!(more.clone().cholesky().is_some());
            if exact {
                // Of a model of the same people: half of what these leave open.
                let precision = before.clone().cholesky().unwrap().inverse();
                let corner = precision.view((0, 0), (3, 3)).into_owned();
                let open = corner.cholesky().unwrap().inverse() * 0.5;
                assert!((&more - &open).amax() < 1e-4 * open.amax(), "{more} {open}");
            }
        }
    }
}
