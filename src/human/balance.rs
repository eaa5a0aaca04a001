//! Whether a standing body is in balance: its centre of mass over its feet.
//!
//! Masses are those of the body's segments; their centres lie where Winter (2009) has them between the
//! joints. What is not predicted hangs or rests where it is drawn: head and neck on the trunk, the other
//! arm under its shoulder. A load is carried in the grips.

use super::body::Body;
use super::legs::{Bending, Legs};
use super::side::{Coupled, Side};
use crate::files::InputError;
use crate::kinematics::{Frames, Linkage};
use crate::math::Vec3;

/// Distance of the centre of mass from the joint above over the segment's length (Winter).
const LIMB: f64 = 0.433;
/// The same of a hand, to its grip.
const HAND: f64 = 0.7;
/// How near the edge of the feet a centre of mass may come, m.
const MARGIN_M: f64 = 0.01;

/// Rise of both heels with which nothing behind the ankles carries, rad.
const RAISED: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// A mass fixed to a tip of the coupled chain.
#[derive(Debug, Clone)]
struct Mass {
    tip: usize,
    kg: f64,
    /// In the tip's frame, m.
    at: Vec3,
    /// Hangs below that point by this, m.
    below_m: f64,
}

/// The masses of a standing body, and its feet.
#[derive(Debug, Clone)]
pub struct Balance {
    masses: Vec<Mass>,
    /// Thigh, shank and foot of one leg, kg.
    leg_kg: [f64; 3],
    total_kg: f64,
    /// Edges of the ground that flat feet enclose.
    support: Vec<Edge>,
    /// How far back heels and ankles are, m.
    heels_and_ankles_m: [f64; 2],
}

/// An edge: outward normal (forward, right) and its distance from the origin of the rest frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    normal: [f64; 2],
    offset_m: f64,
}

/// A linear bound on the joints of a chain: `at + coefficients . change <= upper`, m.
#[derive(Debug, Clone, PartialEq)]
pub struct BalanceRow {
    /// For each column.
    pub coefficients: Vec<f64>,
    /// Value now, m.
    pub at: f64,
    /// Upper bound, m.
    pub upper: f64,
}

impl Balance {
    /// Links that a chain must have as tips, in this order, after its grips.
    pub fn links(coupled: Coupled) -> Vec<String> {
        let mut links = ["Pelvis", "L5", "L3", "T12", "T8"].map(str::to_owned).to_vec();
        for side in coupled.hands.sides() {
            let of = |part: &str| format!("{}{part}", side.prefix());
            links.extend(["Shoulder", "UpperArm", "ForeArm", "Hand"].map(of));
        }
        links
    }

    /// For a body with a chain whose tips are its grips and [`links`](Self::links), and a load (kg) in
    /// the grips together.
    ///
    /// # Errors
    /// Never for a body that loaded.
    pub fn new(
        body: &Body,
        coupled: Coupled,
        (chain, legs): (&Linkage, &Legs),
        load_kg: f64,
    ) -> Result<Self, InputError> {
        let grips = coupled.hands.sides().len();
        let names = Self::links(coupled);
        let place = |name: &str| names.iter().position(|n| n == name).map_or(0, |i| grips + i);
        let upright = Upright::new(body)?;
        let mut masses = Vec::new();
        let mut add = |tip: usize, kg: f64, at: Vec3, below_m: f64| {
            masses.push(Mass { tip, kg, at, below_m });
        };
        let spine = ["Pelvis", "L5", "L3", "T12", "T8", "Neck"];
        for pair in spine.windows(2) {
            let half = if pair[0] == "Pelvis" { 0.0 } else { 0.5 };
            add(
                place(pair[0]),
                body.segment_kg(pair[0]),
                upright.way(pair[0], pair[1]) * half,
                0.0,
            );
        }
        let t8 = place("T8");
        for part in ["Neck", "Head"] {
            let up = Vec3::y() * if part == "Head" { 0.06 * body.size.stature_m } else { 0.02 };
            add(t8, body.segment_kg(part), upright.way("T8", part) + up, 0.0);
        }
        for side in [Side::Right, Side::Left] {
            let of = |part: &str| format!("{}{part}", side.prefix());
            let kg = |part: &str| body.segment_kg(&of(part));
            let way = |from: &str, to: &str| upright.way(&of(from), &of(to));
            let [girdle, upper, fore] =
                [way("Shoulder", "UpperArm"), way("UpperArm", "ForeArm"), way("ForeArm", "Hand")];
            let hand = way("Hand", "Grip");
            if coupled.hands.hold(side) {
                add(place(&of("Shoulder")), kg("Shoulder"), girdle * 0.5, 0.0);
                add(place(&of("UpperArm")), kg("UpperArm"), upper * LIMB, 0.0);
                add(place(&of("ForeArm")), kg("ForeArm"), fore * LIMB, 0.0);
                add(place(&of("Hand")), kg("Hand"), hand * HAND, 0.0);
            } else {
                let root = upright.way("T8", &of("Shoulder"));
                add(t8, kg("Shoulder"), root + girdle * 0.5, 0.0);
                let (u, f) = (upper.norm(), fore.norm());
                let shoulder = root + girdle;
                add(t8, kg("UpperArm"), shoulder, LIMB * u);
                add(t8, kg("ForeArm"), shoulder, u + LIMB * f);
                add(t8, kg("Hand"), shoulder, u + f + HAND * hand.norm());
            }
        }
        for grip in 0..grips {
            add(grip, load_kg / grips as f64, Vec3::zeros(), 0.0);
        }
        debug_assert!(masses.iter().all(|m| m.tip < chain.tips().count()));
        let leg_kg = [
            body.segment_kg("RightUpperLeg"),
            body.segment_kg("RightLowerLeg"),
            body.segment_kg("RightFoot") + body.segment_kg("RightToe"),
        ];
        let total_kg = masses.iter().map(|m| m.kg).sum::<f64>() + 2.0 * leg_kg.iter().sum::<f64>();
        let (support, heels_and_ankles_m) = (edges(&legs.soles()), legs.heels_and_ankles_m());
        Ok(Self { masses, leg_kg, total_kg, support, heels_and_ankles_m })
    }

    /// Centre of mass in the rest frame, m.
    pub fn centre(
        &self,
        (chain, frames): (&Linkage, &Frames),
        (legs, bending): (&Legs, &Bending),
    ) -> Vec3 {
        let mut sum = Vec3::zeros();
        for m in &self.masses {
            let (p, r) = chain.tip_frame(frames, m.tip);
            sum += m.kg * (p + r * m.at - Vec3::y() * m.below_m);
        }
        for [hip, knee, ankle, ball] in legs.centres(bending) {
            let [thigh, shank, foot] = self.leg_kg;
            sum += thigh * hip.lerp(&knee, LIMB)
                + shank * knee.lerp(&ankle, LIMB)
                + foot * ankle.lerp(&ball, 0.5);
        }
        sum / self.total_kg
    }

    /// Horizontal lever of everything above L5/S1, and of the load, about L5/S1, times its mass, kg m.
    ///
    /// For a chain whose tips are its grips and [`links`](Self::links).
    pub fn lever_kg_m(&self, chain: &Linkage, frames: &Frames) -> f64 {
        let pelvis = self.masses[0].tip;
        let (joint, _) = chain.tip_frame(frames, pelvis + 1);
        let mut sum = Vec3::zeros();
        for m in self.masses.iter().filter(|m| m.tip != pelvis) {
            let (p, r) = chain.tip_frame(frames, m.tip);
            sum += m.kg * (p + r * m.at - joint);
        }
        sum.x.hypot(sum.z)
    }

    /// How far the centre of mass is inside the ground that the feet enclose, m; negative outside. Where
    /// the heels rise (rad), the ground that carries soon ends at the ankles: behind them nobody was recorded
    /// in squats (HDM05, 5 % within 2 cm ahead of the ankles).
    pub fn margin_m(&self, centre: &Vec3, heel: f64) -> f64 {
        self.edges(heel).map(|e| e.inside_m(centre)).fold(f64::INFINITY, f64::min)
    }

    fn edges(&self, heel: f64) -> impl Iterator<Item = Edge> + '_ {
        let [heels, ankles] = self.heels_and_ankles_m;
        let back = heels + (heel / RAISED).min(1.0) * (ankles - heels);
        self.support.iter().copied().chain([Edge { normal: [-1.0, 0.0], offset_m: -back }])
    }

    /// Bounds that keep the centre of mass inside, those of the edges within `near` m of it.
    pub fn rows(
        &self,
        (chain, frames): (&Linkage, &Frames),
        centre: &Vec3,
        (heel, near): (f64, f64),
    ) -> Vec<BalanceRow> {
        let edges = self.edges(heel);
        let close: Vec<Edge> = edges.filter(|e| e.inside_m(centre) < MARGIN_M + near).collect();
        if close.is_empty() {
            return Vec::new();
        }
        let mut moves = vec![Vec3::zeros(); chain.dof()];
        for m in &self.masses {
            let (p, r) = chain.tip_frame(frames, m.tip);
            let at = p + r * m.at;
            chain.add_point_velocity(frames, m.tip, &at, m.kg / self.total_kg, &mut moves);
        }
        // The legs move with the pelvis, the less the lower they are.
        let pelvis = self.masses[0].tip;
        let (at, _) = chain.tip_frame(frames, pelvis);
        let [thigh, shank, _] = self.leg_kg;
        let carried = 2.0 * (thigh * (1.0 - 0.5 * LIMB) + 0.5 * shank * (1.0 - LIMB));
        chain.add_point_velocity(frames, pelvis, &at, carried / self.total_kg, &mut moves);
        let row = |e: Edge| BalanceRow {
            coefficients: moves.iter().map(|v| e.normal[0] * v.x + e.normal[1] * v.z).collect(),
            at: e.along(centre),
            upper: e.offset_m - MARGIN_M,
        };
        close.into_iter().map(row).collect()
    }
}

impl Edge {
    fn along(&self, p: &Vec3) -> f64 {
        self.normal[0] * p.x + self.normal[1] * p.z
    }

    fn inside_m(&self, p: &Vec3) -> f64 {
        self.offset_m - self.along(p)
    }
}

/// Edges of the convex hull of points (Andrew's monotone chain).
fn edges(points: &[[f64; 2]]) -> Vec<Edge> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let cross = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut kept: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while kept.len() > 1 && cross(kept[kept.len() - 2], kept[kept.len() - 1], p) <= 0.0 {
                kept.pop();
            }
            kept.push(p);
        }
        kept
    };
    let lower = half(&mut sorted.iter().copied());
    let upper = half(&mut sorted.iter().rev().copied());
    let ring = lower.windows(2).chain(upper.windows(2));
    // Counter-clockwise: outside is to the right of the way.
    ring.map(|w| {
        let (dx, dz) = (w[1][0] - w[0][0], w[1][1] - w[0][1]);
        let length = dx.hypot(dz);
        let normal = [dz / length, -dx / length];
        Edge { normal, offset_m: normal[0] * w[0][0] + normal[1] * w[0][1] }
    })
    .collect()
}

/// Joint centres of the upright body in the frame of its resting pelvis.
struct Upright {
    names: Vec<String>,
    at: Vec<Vec3>,
}

impl Upright {
    fn new(body: &Body) -> Result<Self, InputError> {
        let mut names =
            ["Pelvis", "L5", "L3", "T12", "T8", "Neck", "Head"].map(str::to_owned).to_vec();
        for side in [Side::Right, Side::Left] {
            let of = |part: &str| format!("{}{part}", side.prefix());
            names.extend(["Shoulder", "UpperArm", "ForeArm", "Hand", "Grip"].map(of));
        }
        let all = body.whole_linkage(&names)?;
        let mut frames = Frames::default();
        all.forward(&vec![0.0; all.dof()], &mut frames);
        let at = (0..names.len()).map(|i| all.tip_frame(&frames, i).0).collect();
        Ok(Self { names, at })
    }

    fn way(&self, from: &str, to: &str) -> Vec3 {
        let at = |name: &str| self.names.iter().position(|n| n == name).map(|i| self.at[i]);
        at(to).unwrap_or_default() - at(from).unwrap_or_default()
    }
}
