//! Figure: the worker, the robot and the cell at one moment of the best path, in three dimensions.

use super::ReportError;
use super::raster::{Canvas, Eye};
use super::sheet::{Anchor, FINER, Sheet, Type, png_over};
use super::solid::Solid;
use super::style::{
    BEST, INK, OBSTACLE, ORANGE, OWN, SHIRT, TITLE, VERMILION, method_levels, segment_color,
};
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::human::{Hands, SegmentKind};
use crate::math::Vec3;
use crate::planner::{CandidateResult, SceneCapsule, SceneMotion, ScenePeople, Track, Walker};
use plotters::style::RGBColor;

const SIZE: (u32, u32) = (1000, 800);
/// Room around what must be seen, m.
const ROOM_M: f64 = 0.06;
/// Radius of the paths' tubes and of the balls at their ends, m.
const TUBE_M: f64 = 0.007;
const BALL_M: f64 = 0.022;
/// Dashes of the straight path, m: drawn, left out.
const DASH_M: (f64, f64) = (0.045, 0.03);
const ROBOT: RGBColor = RGBColor(222, 226, 233);
const GHOST: (RGBColor, f32) = (RGBColor(75, 92, 120), 0.10);
/// From where the eye looks at the worker: forward and to the hand's side, the preferred place first.
const FROM: [[f64; 2]; 6] =
    [[0.75, 1.25], [0.1, 1.45], [0.75, -1.25], [0.1, -1.45], [-0.75, 1.25], [-0.75, -1.25]];
/// How much higher than the worker.
const ABOVE: f64 = 0.55;
/// How much smaller the trials are that choose the side from which the worker is seen best.
const TRIAL: u32 = 8;
/// How much more of the worker another side must show than the first.
const BETTER: f64 = 1.15;

/// A moment of the lead that is shown, and how the person shown scores there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shown {
    /// When, s.
    pub time_s: f64,
    /// RULA of the person shown.
    pub rula: u8,
    /// How many other repetitions are seen through.
    pub ghosts: usize,
}

/// The figure, with the moment that it shows: the one at which RULA is highest on average. None
/// without a scored path.
pub(super) fn still(view: &View) -> Result<Option<(Vec<u8>, Shown)>, ReportError> {
    let Some(moment) = Moment::of(view) else { return Ok(None) };
    let parts = Parts::of(view, &moment);
    let eye = parts.best_eye(view);
    let fine = (SIZE.0 * FINER, SIZE.1 * FINER);
    let mut canvas = Canvas::new(eye(fine), fine);
    parts.draw(&mut canvas);
    let [low, high] = parts.bounds;
    canvas.floor(0.5 * (low + high), 0.9 * (high - low).xy().norm().max(1.0));
    for ghost in &parts.ghosts {
        canvas.veil(ghost, parts.cell.len(), GHOST.0, GHOST.1);
    }
    let small = eye(SIZE);
    let drawn = png_over("still", SIZE, canvas.finish(), |sheet| {
        let setting = &view.result.setting;
        let ends = [("start", setting.start_m), ("goal", setting.goal_m)];
        let at = ends.map(|(_, p)| small.seen(&Vec3::from(p)).0);
        let start_is_low = at[0][1] >= at[1][1];
        for (i, (words, _)) in ends.into_iter().enumerate() {
            let down = if (i == 0) == start_is_low { 1.0 } else { -1.0 };
            label(sheet, words, at[i], down)?;
        }
        Ok(())
    })?;
    let shown = Shown { time_s: moment.time_s, rula: moment.rula, ghosts: parts.ghosts.len() };
    Ok(Some((drawn, shown)))
}

fn label(sheet: &Sheet, words: &str, [x, y]: [f64; 2], down: f64) -> super::sheet::Drawn {
    let inside = |v: f64, end: u32, room: f64| v.clamp(room, f64::from(end) - room);
    let at = (inside(x, SIZE.0, 40.0), inside(y + down * 34.0, SIZE.1, 20.0));
    sheet.label(words, at, Type::bold(TITLE), Anchor::Middle)
}

/// The moment that is shown.
struct Moment<'a> {
    lead: &'a CandidateResult,
    motion: &'a SceneMotion,
    people: &'a ScenePeople,
    typical: &'a Walker,
    /// Index into the moments of the motion.
    index: usize,
    time_s: f64,
    rula: u8,
}

impl<'a> Moment<'a> {
    fn of(view: &View<'a>) -> Option<Self> {
        let lead = view.lead?;
        let motion = view.result.scene.motions.iter().find(|m| m.candidate == lead.id)?;
        let people = motion.people.iter().find(|p| Some(p.body.as_str()) == view.body)?;
        let typical = people.typical.as_ref()?;
        let time_s = &lead.path.as_ref()?.time_s;
        let mean = &view.scores(lead)?.rula().distribution.band.mean;
        let reached = motion.samples.iter().take(typical.rula.len()).enumerate();
        let by_score = reached.filter_map(|(i, &k)| Some((i, *mean.get(k)?, *time_s.get(k)?)));
        // The first of equally high ones.
        let highest = by_score.reduce(|a, b| if b.1 > a.1 + 1e-9 { b } else { a });
        let (index, _, time_s) = highest?;
        let rula = typical.rula[index];
        Some(Self { lead, motion, people, typical, index, time_s, rula })
    }

    /// Points of a track at this moment; none where it ended before.
    fn points(&self, track: &Track, moments: usize) -> Option<Vec<Vec3>> {
        let all = track.points_mm(moments);
        let metres = |p: &[i64; 3]| Vec3::from(p.map(|v| 1e-3 * v as f64));
        Some(all.get(self.index)?.iter().map(metres).collect())
    }
}

/// Solids of one colour that are outlined as a whole.
type Thing = (Vec<Solid>, RGBColor);

/// Everything in the picture.
struct Parts {
    cell: Vec<Thing>,
    worker: Vec<Thing>,
    ghosts: Vec<Vec<Solid>>,
    /// What must be inside the picture.
    points: Vec<Vec3>,
    bounds: [Vec3; 2],
}

impl Parts {
    fn of(view: &View, moment: &Moment) -> Self {
        let setting = &view.result.setting;
        let level = ScoringMethod::Rula.level(moment.rula);
        let levels = method_levels(ScoringMethod::Rula);
        let shirt = levels.iter().find(|l| l.number == level).map_or(SHIRT, |l| l.color);
        let pieces = &moment.people.capsules;
        let body = |w: &Walker| moment.points(&w.track, w.rula.len());
        let worker = body(moment.typical).map_or_else(Vec::new, |p| person(pieces, &p, shirt));
        let ghosts = moment.people.ghosts.iter().filter(|g| g.rollout != moment.typical.rollout);
        let ghosts = ghosts
            .filter_map(body)
            .map(|points| {
                let own = pieces.iter().filter(|c| c.kind != Some(SegmentKind::Stool));
                let there = own.filter(|c| c.fits(points.len()));
                there.map(|c| Solid::veil(c, &points)).collect()
            })
            .collect();
        let mut cell: Vec<Thing> = (view.result.scene.obstacles.iter())
            .map(|o| (vec![Solid::obstacle(&o.shape)], OBSTACLE))
            .collect();
        let first_seen = cell.len();
        if let Some(robot) = &moment.motion.robot
            && let Some(points) = moment.points(&robot.track, moment.motion.samples.len())
        {
            cell.push((solids(robot.capsules.iter(), &points), ROBOT));
        }
        if let Some(straight) = view.straight {
            cell.push((dashes(&tcp(straight)), INK));
        }
        let pen = if view.result.verdict.best.is_some() { BEST } else { OWN };
        cell.push((tube(&tcp(moment.lead)), pen.color));
        for (at, color) in [(setting.start_m, ORANGE), (setting.goal_m, VERMILION)] {
            cell.push((vec![Solid::capsule([Vec3::from(at); 2], BALL_M)], color));
        }
        let must = cell[first_seen..].iter().chain(&worker).flat_map(|(solids, _)| solids);
        let points: Vec<Vec3> = must.flat_map(|s| s.corners.iter().map(|c| c[0])).collect();
        let low = points.iter().copied().reduce(|a, b| a.inf(&b)).unwrap_or_else(Vec3::zeros);
        let high = points.iter().copied().reduce(|a, b| a.sup(&b)).unwrap_or_else(Vec3::zeros);
        Self { cell, worker, ghosts, points, bounds: [low, high] }
    }

    /// The eye that sees most of the worker: from the hand's side if no other is clearly better.
    fn best_eye(&self, view: &View) -> impl Fn((u32, u32)) -> Eye {
        let [fx, fy] = view.result.setting.facing;
        let hand = if view.result.setting.worker.hands == Hands::Left { 1.0 } else { -1.0 };
        let from = move |[ahead, beside]: [f64; 2]| {
            let left = hand * beside;
            Vec3::new(ahead * fx - left * fy, ahead * fy + left * fx, ABOVE)
        };
        // Room on all sides, whatever the direction.
        let points: Vec<Vec3> = (self.points.iter())
            .flat_map(|p| [-1.0, 1.0].map(|s| p + s * ROOM_M * Vec3::repeat(1.0)))
            .collect();
        let trial = (SIZE.0 / TRIAL, SIZE.1 / TRIAL);
        let mut chosen = (from(FROM[0]), 0.0);
        for place in FROM {
            let direction = from(place);
            let mut canvas = Canvas::new(Eye::fitted(direction, &points, trial), trial);
            let seen = self.draw(&mut canvas) as f64;
            if seen > BETTER * chosen.1 {
                chosen = (direction, seen);
            }
        }
        move |size| Eye::fitted(chosen.0, &points, size)
    }

    /// Draws all solid things; how many pixels show the worker.
    fn draw(&self, canvas: &mut Canvas) -> usize {
        for (solids, color) in &self.cell {
            canvas.thing(solids, *color);
        }
        let before = canvas.things();
        for (solids, color) in &self.worker {
            canvas.thing(solids, *color);
        }
        canvas.visible(before)
    }
}

/// Pieces whose points are there.
fn solids<'a>(pieces: impl Iterator<Item = &'a SceneCapsule>, points: &[Vec3]) -> Vec<Solid> {
    pieces.filter(|c| c.fits(points.len())).map(|c| Solid::piece(c, points)).collect()
}

/// A person as things of one colour each.
fn person(pieces: &[SceneCapsule], points: &[Vec3], shirt: RGBColor) -> Vec<Thing> {
    use SegmentKind as K;
    let groups: [&[K]; 8] = [
        &[K::Stool],
        &[K::Foot],
        &[K::Thigh, K::Shank],
        &[K::Pelvis],
        &[K::Trunk],
        &[K::UpperArm, K::Forearm],
        &[K::Head, K::Hand],
        &[K::Hair],
    ];
    let of = |kinds: &[K]| {
        let own = pieces.iter().filter(|c| kinds.contains(&c.kind.unwrap_or(K::Trunk)));
        (solids(own, points), kinds.first().and_then(|k| segment_color(*k)).unwrap_or(shirt))
    };
    groups.into_iter().map(of).filter(|(solids, _)| !solids.is_empty()).collect()
}

fn tcp(candidate: &CandidateResult) -> Vec<Vec3> {
    let path = candidate.path.iter().flat_map(|p| &p.tcp);
    path.map(|t| Vec3::new(t[0], t[1], t[2])).collect()
}

/// A line through points as a tube.
fn tube(points: &[Vec3]) -> Vec<Solid> {
    let mut kept: Vec<Vec3> = Vec::new();
    for p in points {
        if kept.last().is_none_or(|last| (p - last).norm() > 2.0 * TUBE_M) {
            kept.push(*p);
        }
    }
    kept.windows(2).map(|w| Solid::wire([w[0], w[1]], TUBE_M)).collect()
}

/// The same, dashed by length.
fn dashes(points: &[Vec3]) -> Vec<Solid> {
    let (drawn, gap) = DASH_M;
    let mut solids = Vec::new();
    let mut gone = 0.0;
    for w in points.windows(2) {
        let [a, b] = [w[0], w[1]];
        let length = (b - a).norm();
        let mut from = 0.0;
        while from < length {
            let phase = (gone + from) % (drawn + gap);
            let (is_drawn, left) =
                if phase < drawn { (true, drawn - phase) } else { (false, drawn + gap - phase) };
            let to = (from + left.max(1e-6)).min(length);
            if is_drawn {
                let at = |s: f64| a + (b - a) * (s / length);
                solids.push(Solid::wire([at(from), at(to)], TUBE_M));
            }
            from = to;
        }
        gone += length;
    }
    solids
}
