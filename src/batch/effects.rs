//! What a factor changes over the cells that are alike in all others, which cells are alike at all, and
//! which of them nobody beats in both risk and duration.
//!
//! Effects are of the lead of each cell: differences to the first level of the factor, cell by cell. Where
//! both cells are of the same people (seed, posture model and body), repetition r is the same in both and
//! the interval is paired; elsewhere it is that of two groups. Cells with one seed share their draws, so that
//! they are averaged repetition by repetition before a spread is taken: the interval is that of these cells,
//! for other repetitions.

use super::manifest::Finished;
use super::matrix::FactorKind;
use super::record::{CellRecord, PathRow};
use crate::ergonomics::{paired_difference, unpaired_difference};
use std::collections::BTreeMap;

/// What the levels of a factor change.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// The factor, by its place in the plan.
    pub factor: usize,
    /// The level that the others are compared with.
    pub against: usize,
    /// The others.
    pub levels: Vec<LevelEffect>,
}

/// What one level changes in expected RULA.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelEffect {
    /// The level.
    pub level: usize,
    /// Pairs of cells that are alike but for this factor and have a path each, and pairs in all.
    pub pairs: [usize; 2],
    /// Whether both cells of every pair are of the same people.
    pub is_paired: bool,
    /// This level minus the one that it is compared with: mean, and ends of the 95 % interval; none
    /// without a pair.
    pub difference: Option<[f64; 3]>,
}

impl LevelEffect {
    /// Whether the interval leaves 0 out.
    pub fn is_clear(&self) -> bool {
        self.difference.is_some_and(|[_, low, high]| low > 0.0 || high < 0.0)
    }
}

/// A cell by its duration and risk, for the worst body of its lead.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The cell.
    pub cell: usize,
    /// Its station.
    pub station: usize,
    /// Duration, s.
    pub duration_s: f64,
    /// Share of the time at RULA action level 3 or above.
    pub risk: f64,
    /// No cell of its station is better in one and as good in the other.
    pub is_on_front: bool,
}

impl Finished {
    /// The row that a cell is known by: its lead, for the body that is worst on it.
    pub fn row(&self, cell: usize) -> Option<&PathRow> {
        worst(&self.records[cell])
    }
}

fn worst(record: &CellRecord) -> Option<&PathRow> {
    let is_worst = |r: &&PathRow| *r.value("is_worst_body") == super::columns::Value::Flag(true);
    record.lead().find(is_worst).or_else(|| record.lead().next())
}

/// Of every factor that varies, except scenarios: these are other work, not another way of doing it.
pub fn main_effects(finished: &Finished) -> Vec<Effect> {
    let plan = &finished.plan;
    let mut index: BTreeMap<&[usize], usize> = BTreeMap::new();
    for (k, cell) in plan.cells.iter().enumerate() {
        index.insert(&cell.levels, k);
    }
    let of = |factor: usize| {
        let used: Vec<usize> = (0..plan.factors[factor].levels.len())
            .filter(|l| plan.cells.iter().any(|c| c.levels[factor] == *l))
            .collect();
        let (&against, others) = used.split_first()?;
        let levels = others.iter().map(|&level| {
            let pairs: Vec<(usize, usize)> = plan
                .cells
                .iter()
                .enumerate()
                .filter(|(_, c)| c.levels[factor] == level)
                .filter_map(|(k, c)| {
                    let mut other = c.levels.clone();
                    other[factor] = against;
                    Some((k, *index.get(&other[..])?))
                })
                .collect();
            level_effect(finished, level, &pairs)
        });
        Some(Effect { factor, against, levels: levels.collect() })
    };
    let varied = plan.varied().into_iter();
    varied.filter(|f| plan.factors[*f].kind != FactorKind::Scenario).filter_map(of).collect()
}

fn level_effect(finished: &Finished, level: usize, pairs: &[(usize, usize)]) -> LevelEffect {
    let rows = |k: usize| finished.records[k].lead().collect::<Vec<_>>();
    let usable: Vec<(usize, usize)> = pairs
        .iter()
        .copied()
        .filter(|(a, b)| finished.row(*a).is_some() && finished.row(*b).is_some())
        .collect();
    // Of each pair the rows of the same people.
    let same = |(a, b): &(usize, usize)| -> Vec<(&PathRow, &PathRow)> {
        let theirs = rows(*b);
        let twin = |r: &&PathRow| theirs.iter().find(|t| t.people == r.people).copied();
        rows(*a).into_iter().filter_map(|r| Some((r, twin(&r)?))).collect()
    };
    let twins: Vec<Vec<(&PathRow, &PathRow)>> = usable.iter().map(same).collect();
    let is_paired = !usable.is_empty() && twins.iter().all(|t| !t.is_empty());
    let matched: Vec<(&PathRow, &PathRow)> = if is_paired {
        twins.into_iter().flatten().collect()
    } else {
        let worst = |(a, b): &(usize, usize)| Some((finished.row(*a)?, finished.row(*b)?));
        usable.iter().filter_map(worst).collect()
    };
    let difference = (!matched.is_empty()).then(|| {
        let (own, theirs): (Vec<&PathRow>, Vec<&PathRow>) = matched.into_iter().unzip();
        if is_paired {
            let (a, b) = averaged_alike(&own, &theirs);
            let d = paired_difference(&a, &b);
            [d.mean, d.low95, d.high95]
        } else {
            let d = unpaired_difference(&averaged(&own), &averaged(&theirs));
            [d.mean, d.low95, d.high95]
        }
    });
    LevelEffect { level, pairs: [usable.len(), pairs.len()], is_paired, difference }
}

type BySeed<'a> = BTreeMap<i64, Vec<&'a [f64]>>;

fn by_seed<'a>(rows: impl Iterator<Item = (&'a PathRow, &'a [f64])>) -> BySeed<'a> {
    let mut all = BySeed::new();
    for (row, values) in rows {
        let seed = row.number("run_seed").map_or(0, |s| s as i64);
        all.entry(seed).or_default().push(values);
    }
    all
}

/// Means over the rows of one seed, repetition by repetition; one seed after the other.
fn averaged(rows: &[&PathRow]) -> Vec<f64> {
    means(&by_seed(rows.iter().map(|r| (*r, &r.rula[..]))))
}

/// The same of rows that are paired: of each pair as many repetitions as both have.
fn averaged_alike(a: &[&PathRow], b: &[&PathRow]) -> (Vec<f64>, Vec<f64>) {
    let common = |k: usize| a[k].rula.len().min(b[k].rula.len());
    let cut = |rows: &[&PathRow]| -> Vec<f64> {
        // The seed is that of both.
        let rows = rows.iter().enumerate().map(|(k, r)| (a[k], &r.rula[..common(k)]));
        let mut all: BTreeMap<i64, Vec<Vec<f64>>> = BTreeMap::new();
        for (row, values) in rows {
            let seed = row.number("run_seed").map_or(0, |s| s as i64);
            all.entry(seed).or_default().push(values.to_vec());
        }
        let borrowed =
            all.iter().map(|(s, v)| (*s, v.iter().map(Vec::as_slice).collect())).collect();
        means(&borrowed)
    };
    (cut(a), cut(b))
}

fn means(all: &BySeed) -> Vec<f64> {
    let of = |values: &Vec<&[f64]>| {
        let n = values.iter().map(|v| v.len()).min().unwrap_or(0);
        let mean = |r: usize| values.iter().map(|v| v[r]).sum::<f64>() / values.len() as f64;
        (0..n).map(mean).collect::<Vec<_>>()
    };
    all.values().flat_map(of).collect()
}

/// Every cell that has a path, by duration and risk.
pub fn front(finished: &Finished) -> Vec<Point> {
    let mut points: Vec<Point> = (0..finished.records.len())
        .filter_map(|cell| {
            let row = finished.row(cell)?;
            Some(Point {
                cell,
                station: finished.plan.cells[cell].station,
                duration_s: row.number("duration_s")?,
                risk: row.number("time_share_rula_ge_5")?,
                is_on_front: false,
            })
        })
        .collect();
    mark_front(&mut points);
    points
}

/// Of each station from short to long, of equal ones the lower risk first: what is on the front has less risk than
/// all before it, or is the equal of the last that was.
fn mark_front(points: &mut [Point]) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| {
        let (a, b) = (&points[*a], &points[*b]);
        let by_time = a.duration_s.total_cmp(&b.duration_s);
        a.station.cmp(&b.station).then(by_time).then(a.risk.total_cmp(&b.risk))
    });
    let mut last: Option<(usize, f64, f64)> = None;
    for k in order {
        let point = &mut points[k];
        let own = (point.station, point.duration_s, point.risk);
        point.is_on_front =
            last.is_none_or(|l| l.0 != own.0 || own.2 < l.2 || (own.1 == l.1 && own.2 == l.2));
        if point.is_on_front {
            last = Some(own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::columns::{Value, columns};
    use super::super::manifest::{CellPlan, Manifest, PlannedFactor};
    use super::super::record::CellState;
    use super::*;

    /// A plan of so many levels of each factor, with all cells.
    fn plan(factors: &[(&str, FactorKind, usize)]) -> Manifest {
        let mut cells = vec![Vec::new()];
        for (_, _, count) in factors {
            let longer =
                |c: &Vec<usize>| (0..*count).map(|l| [&c[..], &[l]].concat()).collect::<Vec<_>>();
            cells = cells.iter().flat_map(longer).collect();
        }
        let factors = factors.iter().map(|(name, kind, count)| PlannedFactor {
            name: (*name).to_owned(),
            kind: *kind,
            levels: (0..*count).map(|l| l.to_string()).collect(),
            numbers: None,
        });
        let cells = cells.into_iter().map(|levels| CellPlan {
            station: usize::from(levels == [1, 0]),
            levels,
            key: String::new(),
        });
        Manifest::made(factors.collect(), cells.collect())
    }

    /// A cell whose lead has these values, of these people.
    fn record(people: &str, rula: &[f64], numbers: &[(&str, f64)]) -> CellRecord {
        let value = |name: &str| match name {
            "is_lead" | "is_worst_body" => Value::Flag(true),
            _ => numbers.iter().find(|(n, _)| *n == name).map(|(_, v)| *v).into(),
        };
        let values = columns().iter().map(|c| value(c.name)).collect();
        let row = PathRow { values, people: people.to_owned(), rula: rula.to_vec() };
        let mut record = CellRecord::failed("", String::new());
        (record.state, record.rows) = (CellState::Ok, vec![row]);
        record
    }

    #[test]
    fn effects_are_paired_where_the_people_are_the_same() {
        let plan = plan(&[
            ("scenario", FactorKind::Scenario, 1),
            ("layout", FactorKind::Variant, 2),
            ("worker.bodies", FactorKind::Field, 2),
        ]);
        let records = vec![
            record("small", &[4.0, 5.0, 6.0], &[]),
            record("tall", &[5.0, 6.0, 7.0], &[]),
            record("small", &[3.0, 4.1, 5.0], &[]),
            record("tall", &[4.0, 5.1, 6.0], &[]),
        ];
        let effects = main_effects(&Finished { plan, records });
        assert_eq!(effects.len(), 2);
        let layout = &effects[0].levels[0];
        // Of both bodies the differences are -1, -0.9, -1: their mean, and t with 2 degrees of freedom.
        let [mean, low, high] = layout.difference.unwrap();
        let half = 4.302_652_7 * (0.01_f64 / 3.0).sqrt() / 3.0_f64.sqrt();
        assert!((mean + 0.966_666_7).abs() < 1e-6, "{mean}");
        assert!(
            (high - mean - half).abs() < 1e-4 && (mean - low - half).abs() < 1e-4,
            "{low} {high} {half}"
        );
        assert!(layout.is_paired && layout.is_clear() && layout.pairs == [2, 2]);
        let bodies = &effects[1].levels[0];
        assert!(!bodies.is_paired && !bodies.is_clear());
        assert!((bodies.difference.unwrap()[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_cell_without_a_path_takes_its_pair_with_it() {
        let plan = plan(&[
            ("scenario", FactorKind::Scenario, 1),
            ("layout", FactorKind::Variant, 2),
            ("seed", FactorKind::Seed, 2),
        ]);
        let one = |seed: f64, rula: &[f64]| record(&seed.to_string(), rula, &[("run_seed", seed)]);
        let records = vec![
            one(1.0, &[4.0, 5.0]),
            one(2.0, &[4.0, 6.0]),
            CellRecord::failed("", "why".to_owned()),
            one(2.0, &[3.0, 5.0]),
        ];
        let finished = Finished { plan, records };
        let effects = main_effects(&finished);
        assert_eq!((effects[0].levels[0].pairs, effects[0].levels[0].is_paired), ([1, 2], true));
        assert!((effects[0].levels[0].difference.unwrap()[0] + 1.0).abs() < 1e-12);
        assert!(!effects[1].levels[0].is_paired, "other draws");
    }

    #[test]
    fn the_front_is_that_of_a_naive_loop() {
        use crate::math::stream::{Purpose, stream};
        use rand::RngExt;
        let mut rng = stream(7, Purpose::Simulation, 0, 0);
        // Few values, so that many are equal.
        let mut point = |cell| Point {
            cell,
            station: rng.random_range(0..3),
            duration_s: f64::from(rng.random_range(0..8u8)),
            risk: f64::from(rng.random_range(0..8u8)) / 8.0,
            is_on_front: false,
        };
        let mut points: Vec<Point> = (0..200).map(&mut point).collect();
        let beats = |a: &Point, b: &Point| {
            a.station == b.station
                && a.duration_s <= b.duration_s
                && a.risk <= b.risk
                && (a.duration_s < b.duration_s || a.risk < b.risk)
        };
        let naive: Vec<bool> = points.iter().map(|p| !points.iter().any(|o| beats(o, p))).collect();
        mark_front(&mut points);
        assert_eq!(points.iter().map(|p| p.is_on_front).collect::<Vec<_>>(), naive);
        assert!(naive.iter().any(|on| *on) && naive.iter().any(|on| !*on));
    }

    #[test]
    fn scenarios_have_no_effect_and_stations_have_fronts_of_their_own() {
        let plan = plan(&[("scenario", FactorKind::Scenario, 2), ("load", FactorKind::Variant, 2)]);
        let at = |duration: f64, risk: f64| {
            record("a", &[1.0, 2.0], &[("duration_s", duration), ("time_share_rula_ge_5", risk)])
        };
        // The third is a station by itself.
        let records = vec![at(4.0, 0.5), at(4.0, 0.9), at(5.0, 0.9), at(3.0, 0.6)];
        let finished = Finished { plan, records };
        assert!(main_effects(&finished).iter().all(|e| e.factor == 1));
        let on: Vec<bool> = front(&finished).iter().map(|p| p.is_on_front).collect();
        assert_eq!(on, [true, false, true, true]);
    }
}
