//! Usual postures by place: a coarse grid of the person's own postures, linear in between.
//!
//! No kernel and no features of a learner: height, reach and side of the hand over stature; of two hands
//! of the middle between them. Each grid point has the comfortable posture for a hand there plus a whim of
//! the person's own, so that the map has kinks, and over all places the postures are far from Gaussian.
//! The turn of the hand does not matter. Beyond the grid the posture of its border counts.

use super::{Frame, middle};
use crate::math::Vec3;
use crate::math::stream::{Purpose, normals, stream};
use crate::posture::{Grips, PostureDistribution, StartRule, start_postures};
use nalgebra::{DMatrix, DVector};

/// Grid of the hand's place in the rest frame over stature: up, forward, sideways (outward).
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    up: &'static [f64],
    forward: &'static [f64],
    sideways: &'static [f64],
}

/// What an arm reaches from a pelvis that rests, what one reaches of somebody who bends down, and two.
pub(super) const ARM: Grid = Grid {
    up: &[-0.10, 0.04, 0.18, 0.34],
    forward: &[0.15, 0.23, 0.33],
    sideways: &[-0.10, 0.08, 0.26],
};
pub(super) const WHOLE: Grid = Grid {
    up: &[-0.36, -0.28, -0.19, -0.10, 0.04, 0.18, 0.34],
    forward: &[0.18, 0.26, 0.34],
    ..ARM
};
pub(super) const CRATE: Grid = Grid { sideways: &[-0.10, 0.0, 0.10], ..WHOLE };

/// The usual postures of somebody.
#[derive(Debug, Clone)]
pub(super) struct Places {
    grid: Grid,
    stature_m: f64,
    /// +1 for a right hand, -1 for a left one.
    outward: f64,
    /// Up, then forward, then sideways; n each, rad.
    postures: Vec<DVector<f64>>,
}

impl Places {
    /// About the usual postures of `frame`, from which joints depart as `ease` (n x n) lets them; `whims` (n x r, rad) times r normal numbers is how far each
    /// grid point's posture is from the comfortable one. `None` where most of the grid is out of reach.
    pub(super) fn draw(
        frame: &Frame,
        ease: &DMatrix<f64>,
        whims: &DMatrix<f64>,
        number: u64,
    ) -> Option<Self> {
        let Frame { coupling, usual, contacts, outward, .. } = frame;
        let (stature_m, outward) = (coupling.stature_m(), *outward);
        let grid = contacts.grid();
        let mut found: Vec<(Vec3, Option<DVector<f64>>)> = Vec::new();
        for &up in grid.up {
            for &forward in grid.forward {
                for &sideways in grid.sideways {
                    let at = Vec3::new(forward, up, outward * sideways);
                    let mut rng = stream(number, Purpose::Simulation, 8, found.len() as u32);
                    let z = DVector::from_vec(normals(&mut rng, whims.ncols()));
                    let wish = &usual.mean + whims * z;
                    let near = PostureDistribution::anywhere(wish, ease.clone());
                    let grips = contacts.grips(at * stature_m);
                    let starts =
                        start_postures(coupling, &near, &StartRule::Mean, grips, (0, 0), 0..1);
                    found.push((at, starts.into_iter().next().and_then(|s| s.q)));
                }
            }
        }
        let reached: Vec<(Vec3, DVector<f64>)> =
            found.iter().filter_map(|(at, q)| Some((*at, q.clone()?))).collect();
        if 2 * reached.len() < found.len() {
            return None;
        }
        // Where the hand cannot be held, the posture of the nearest place where it can.
        let nearest = |at: &Vec3| {
            let by = |a: &&(Vec3, DVector<f64>)| (a.0 - at).norm();
            reached.iter().min_by(|a, b| by(a).total_cmp(&by(b))).map(|(_, q)| q.clone())
        };
        let postures: Option<Vec<DVector<f64>>> =
            found.into_iter().map(|(at, q)| q.or_else(|| nearest(&at))).collect();
        Some(Self { grid, stature_m, outward, postures: postures? })
    }

    /// The usual posture with the hands somewhere (rest frame), n, rad.
    pub(super) fn at(&self, grips: &Grips) -> DVector<f64> {
        let place = middle(grips) / self.stature_m;
        let Grid { up, forward, sideways } = self.grid;
        let cells =
            [cell(up, place.y), cell(forward, place.x), cell(sideways, self.outward * place.z)];
        let mut posture = DVector::zeros(self.postures[0].len());
        for corner in 0..8 {
            let (mut share, mut index) = (1.0, 0);
            for (axis, (low, part)) in cells.iter().enumerate() {
                let is_high = corner >> axis & 1;
                share *= if is_high == 1 { *part } else { 1.0 - part };
                index = index * [1, forward.len(), sideways.len()][axis] + low + is_high;
            }
            posture.axpy(share, &self.postures[index], 1.0);
        }
        posture
    }
}

/// The interval of a grid in which a value lies, and where in it, in [0, 1].
fn cell(grid: &[f64], value: f64) -> (usize, f64) {
    let low = (1..grid.len() - 1).rfind(|&i| grid[i] <= value).unwrap_or(0);
    let part = (value - grid[low]) / (grid[low + 1] - grid[low]);
    (low, part.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;

    #[test]
    fn postures_are_linear_between_grid_points_and_constant_beyond() {
        let grid = ARM;
        let count = grid.up.len() * grid.forward.len() * grid.sideways.len();
        let mut index = 0;
        let postures = (0..count).map(|i| DVector::from_element(1, i as f64)).collect();
        let places = Places { grid, stature_m: 2.0, outward: -1.0, postures };
        let at = |up: f64, forward: f64, sideways: f64| {
            let hand = Pose::translation(2.0 * forward, 2.0 * up, -2.0 * sideways);
            places.at(&hand.into())[0]
        };
        for &up in grid.up {
            for &forward in grid.forward {
                for &sideways in grid.sideways {
                    assert!((at(up, forward, sideways) - f64::from(index)).abs() < 1e-9);
                    index += 1;
                }
            }
        }
        let middle = at(0.11, 0.15, 0.08);
        assert!((middle - 0.5 * (at(0.04, 0.15, 0.08) + at(0.18, 0.15, 0.08))).abs() < 1e-9);
        assert!((at(5.0, 0.15, 0.08) - at(0.34, 0.15, 0.08)).abs() < 1e-9);
    }
}
