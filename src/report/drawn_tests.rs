//! Every figure has its curves, its legend and its axes, and they are those of the data.

use super::drawn::{Figure, drawn, is_graph, is_scaled};
use super::figure_paths::{bone_pen, robot_pen};
use super::style::{
    BEST, BLUE, FAINT, INK, MUTED, OWN, Pen, SHIRT, STRAIGHT, Stroke, method_levels, segment_color,
    tint,
};
use super::tests::{feasible, scenario_file};
use super::value_axis::method_color;
use super::view::View;
use super::*;
use crate::ergonomics::ScoringMethod;
use crate::human::SegmentKind;
use crate::planner::{BodyScores, CandidateResult, Moment, look_at_cell};
use crate::posture::Method;
use crate::scenario::read_scenario;
use crate::training::{HeldOutCurves, JointCurves, JointWeight, WeightSpread};

/// The paths that are compared, with their pens.
fn compared<'a>(view: &View<'a>) -> Vec<(Pen, &'a CandidateResult)> {
    let all = [(BEST, view.lead.unwrap()), (STRAIGHT, view.straight.unwrap()), (OWN, view.own[0])];
    assert_eq!(view.own.len(), 1);
    all.to_vec()
}

fn assert_legend(figure: &Figure, pen: Pen, words: &str) {
    let keys = figure.keys_of_line(pen);
    assert!(keys.len() == 1 && keys[0].contains(words), "{words}: {keys:?}");
}

#[test]
fn scores_over_time_show_every_path_with_its_band() {
    let view = View::of(feasible());
    let figure = drawn(|| figure_scores::over_time(&view));
    for (pen, path) in compared(&view) {
        let time_s = &path.path.as_ref().unwrap().time_s;
        let scores = view.scores(path).unwrap();
        let thin = Pen { width: 1.3, ..pen };
        let (means, edges) = (figure.curves(pen), figure.curves(thin));
        assert_eq!((means.len(), edges.len()), (2, 4), "{}", path.id);
        for (k, score) in
            [&scores.rula().distribution, &scores.reba().distribution].into_iter().enumerate()
        {
            assert!(is_graph(means[k], time_s, &score.band.mean), "{}", path.id);
            assert!(is_graph(edges[2 * k], time_s, &score.band.p05), "{}", path.id);
            assert!(is_graph(edges[2 * k + 1], time_s, &score.band.p95), "{}", path.id);
        }
        assert_legend(&figure, pen, if pen == STRAIGHT { "straight" } else { &path.id });
    }
    // The best path's band is filled in both panels; the key of the legend has four corners.
    let bands = figure.areas(BEST.color).into_iter().filter(|a| a.len() > 4).count();
    assert_eq!(bands, 2);
    for level in ScoringMethod::ALL.into_iter().flat_map(method_levels) {
        assert_eq!(figure.says(&format!("level {}: {}", level.number, level.words)), 1);
        assert!(!figure.areas(tint(level.color, 0.28)).is_empty());
    }
    figure.assert_axes(2, &[("time (s)", 2), ("RULA score", 1), ("REBA score", 1)]);
}

/// Width of a filled rectangle.
fn wide(area: &[(f64, f64)]) -> f64 {
    let x = area.iter().map(|p| p.0);
    x.clone().fold(f64::NEG_INFINITY, f64::max) - x.fold(f64::INFINITY, f64::min)
}

#[test]
fn the_bars_of_levels_are_the_shares_of_time() {
    let view = View::of(feasible());
    let figure = drawn(|| figure_scores::levels(&view));
    let whole = 1250.0 - 330.0;
    for level in method_levels(ScoringMethod::Rula) {
        let rows = figure_scores::level_rows(&view);
        let shares = rows.iter().map(|(_, b)| {
            let share = level.share(&b.rula().distribution.exposure);
            // Slivers are left out.
            if share * whole < 0.5 { 0.0 } else { share * whole }
        });
        let drawn: f64 = figure.areas(level.color).iter().map(|a| wide(a)).sum::<f64>();
        // And the key of the legend.
        assert!((drawn - shares.sum::<f64>() - 40.0).abs() < 1e-6, "level {}", level.number);
        assert_eq!(figure.mentions(&format!("level {} (RULA", level.number)), 1);
    }
    for path in &view.reported {
        assert!(figure.mentions(&path.id) > 0, "{}", path.id);
    }
    assert_eq!((figure.says("share (%)"), figure.says("100")), (1, 1));
}

#[test]
fn body_parts_have_bars_for_both_paths() {
    let view = View::of(feasible());
    let figure = drawn(|| figure_scores::parts(&view));
    let of =
        |c: &CandidateResult| -> Vec<BodyScores> { view.scores(c).cloned().into_iter().collect() };
    for (color, path) in [(BLUE, view.lead), (tint(MUTED, 0.35), view.straight)] {
        let bodies = of(path.unwrap());
        let parts = &bodies[0].rula().parts;
        let bars = figure.areas(color);
        // One is the key of the legend.
        assert_eq!(bars.len(), 2 * parts.len() + 1);
        let widths = |bars: &[&[(f64, f64)]]| bars.iter().map(|b| wide(b)).collect::<Vec<_>>();
        let means: Vec<f64> = parts.iter().map(|p| p.mean).collect();
        let drives: Vec<f64> = parts.iter().map(|p| p.drives).collect();
        assert!(is_scaled(&widths(&bars[1..=parts.len()]), &means, 1.0));
        assert!(is_scaled(&widths(&bars[parts.len() + 1..]), &drives, 1.0));
        for part in parts {
            assert_eq!(figure.says(&part.part), 1);
        }
    }
    assert_eq!((figure.mentions("best path"), figure.mentions("straight path")), (1, 1));
    assert_eq!((figure.says("step score"), figure.says("0")), (1, 2));
}

#[test]
fn the_map_of_parts_has_a_field_for_every_moment() {
    let view = View::of(feasible());
    let figure = drawn(|| figure_heat::heat(&view).map(Option::unwrap));
    let parts = &view.scores(view.lead.unwrap()).unwrap().rula().parts;
    let fields: usize = parts.iter().map(|p| p.over_time.len()).sum();
    let areas = figure.0.iter().filter(|m| matches!(m, drawn::Mark::Area(..))).count();
    // And seven of the scale.
    assert_eq!(areas, fields + 7);
    for part in parts {
        assert_eq!(figure.says(&part.part), 1);
    }
    assert_eq!((figure.says("time (s)"), figure.says("step score")), (1, 1));
}

#[test]
fn postures_are_whole_and_have_their_angles() {
    let result = feasible();
    let figure = drawn(|| figure_postures::postures(&View::of(result)).map(Option::unwrap));
    let bones: usize = result.moments.iter().map(|m| m.bones.len()).sum();
    assert!(bones > 20 * result.moments.len() && !result.moments.is_empty());
    assert_eq!(figure.lines(figure_postures::BONE).len(), bones);
    assert_eq!(figure.discs(INK).len(), bones);
    // Every piece of the mannequin; a shoe is flat where it meets the floor.
    for kind in SegmentKind::ALL {
        let color = segment_color(kind).unwrap_or(SHIRT);
        let of = |m: &Moment| {
            let kinds = m.mannequin.capsules.iter().filter_map(|c| c.kind);
            kinds.filter(|k| segment_color(*k).unwrap_or(SHIRT) == color).count()
        };
        let pieces: usize = result.moments.iter().map(of).sum();
        assert_eq!(figure.areas(color).len(), pieces, "{kind:?}");
    }
    for shoe in figure.areas(segment_color(SegmentKind::Foot).unwrap()) {
        let lowest = shoe.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        assert!(shoe.iter().filter(|p| lowest - p.1 < 0.5).count() > 10);
    }
    for moment in &result.moments {
        assert!(figure.mentions(&format!("RULA {}, REBA {}", moment.rula, moment.reba)) > 0);
        for (name, _) in &moment.angles_deg {
            assert!(figure.says(name) > 0, "{name}");
        }
    }
}

#[test]
fn the_spread_and_the_bodies_have_a_row_each() {
    let view = View::of(feasible());
    let boxes = drawn(|| figure_population::distributions(&view));
    assert_boxes(&boxes, view.reported.len(), view.reported[0].bodies[0].rula().by_rollout.len());
    let bodies = drawn(|| figure_population::population(&view).map(Option::unwrap));
    let lead = &view.lead.unwrap().bodies;
    assert_eq!(bodies.discs(BLUE).len(), 2 * lead.len());
    for body in lead {
        assert_eq!(bodies.says(&body.body), 2);
    }
    let dots: Vec<f64> = bodies.discs(BLUE).iter().map(|d| d.0).collect();
    let values: Vec<f64> = lead.iter().map(|b| b.rula().distribution.expected).collect();
    assert!(is_scaled(&dots[..lead.len()], &values, 1.0));
}

/// Box, median, two whiskers with caps and all points of each method.
fn assert_boxes(figure: &Figure, methods: usize, points: usize) {
    let medians = Pen { color: INK, width: 3.5, stroke: Stroke::Solid };
    assert_eq!(figure.lines(medians).len(), methods);
    for i in 0..methods {
        let pen = Pen { color: method_color(i), width: 2.0, stroke: Stroke::Solid };
        assert_eq!(figure.lines(pen).len(), 5, "outline, whiskers and caps of {i}");
        assert_eq!(figure.areas(tint(pen.color, 0.25)).len(), 1, "box {i}");
        assert_eq!(figure.discs(pen.color).len(), points, "points of {i}");
    }
    assert_eq!(figure.mentions("box: quartiles and median"), 1);
}

#[test]
fn box_plots_have_every_method() {
    let values = |from: f64| (0..9).map(|k| from + 0.1 * f64::from(k)).collect::<Vec<_>>();
    let panel = BoxPanel {
        title: "Log-likelihood".to_owned(),
        unit: "nats".to_owned(),
        is_error: false,
        methods: vec![("GP".into(), values(1.0)), ("NsGP".into(), values(2.0))],
    };
    let figure = drawn(|| box_plots(&[panel]));
    assert_boxes(&figure, 2, 9);
    assert_eq!(
        (figure.says("GP"), figure.says("NsGP"), figure.says("Log-likelihood (nats)")),
        (1, 1, 1)
    );
}

#[test]
fn paths_are_drawn_from_three_sides_with_person_and_robot() {
    let view = View::of(feasible());
    let figure = drawn(|| figure_paths::paths(&view));
    for (pen, path) in compared(&view) {
        let tcp = &path.path.as_ref().unwrap().tcp;
        let curves = figure.curves(pen);
        assert_eq!(curves.len(), 3, "{}", path.id);
        let of = |axis: usize| tcp.iter().map(|t| t[axis]).collect::<Vec<_>>();
        // The worker looks along x.
        for (curve, x, y) in [(curves[0], 0, 2), (curves[1], 1, 2), (curves[2], 0, 1)] {
            assert!(is_graph(curve, &of(x), &of(y)), "{}", path.id);
        }
        assert_legend(&figure, pen, if pen == STRAIGHT { "straight" } else { &path.id });
    }
    let poses: Vec<_> =
        view.lead.unwrap().poses.iter().filter(|p| Some(p.body.as_str()) == view.body).collect();
    for (pose, is_later) in [(poses[0], false), (poses[poses.len() - 1], true)] {
        // Each with its key in the legend.
        assert_eq!(figure.lines(bone_pen(is_later)).len(), 3 * pose.bones.len() + 1);
        assert_eq!(figure.curves(robot_pen(is_later)).len(), 3);
        assert_eq!(figure.keys_of_line(robot_pen(is_later)).len(), 1);
    }
    assert!(!figure.areas(FAINT).is_empty() && figure.mentions("obstacle") == 1);
    let words = [("start", 3), ("goal", 3), ("height z (m)", 2), ("x (m)", 1), ("y (m)", 1)];
    figure.assert_axes(3, &words);
}

#[test]
fn the_cell_is_drawn_from_two_sides_with_its_measures() {
    let (_room, file) = scenario_file("0.5", false);
    let look = look_at_cell(&read_scenario(&file).unwrap()).unwrap();
    let figure = drawn(|| cell_figure(&look));
    for (picture, is_later) in look.pictures.iter().zip([false, true]) {
        assert!(picture.bones.len() > 20);
        // From above, the worker's nose is drawn with the same pen.
        let pen = bone_pen(is_later);
        assert_eq!(figure.lines(pen).len(), 2 * picture.bones.len() + 1 + usize::from(!is_later));
        assert_eq!(figure.curves(robot_pen(is_later)).len(), 2);
        assert_eq!(figure.keys_of_line(robot_pen(is_later)).len(), 1);
    }
    // Heights of start, goal and base; the base is as far from the worker as the start is high.
    for (metres, count) in [("0.95", 2), ("1.25", 1), ("0.75", 1)] {
        assert_eq!(figure.says(metres), count, "{metres} m");
    }
    assert_eq!(figure.mentions("workspace"), 1);
    let words = [("start", 2), ("goal", 2), ("robot base", 2), ("height z (m)", 1), ("x (m)", 1)];
    figure.assert_axes(2, &words);
}

#[test]
fn cells_of_several_runs_have_a_row_each() {
    let runs: Vec<NamedRun> =
        vec![("one".into(), Ok(feasible().clone())), ("two".into(), Ok(feasible().clone()))];
    let compared = Comparison::of(&runs, None);
    let figure = drawn(|| comparison_figure::cells(&compared, &runs).map(Option::unwrap));
    for pen in [BEST, STRAIGHT, OWN] {
        assert_eq!(figure.curves(pen).len(), 4);
    }
    assert_eq!((figure.mentions("one, "), figure.mentions("two, ")), (1, 1));
    figure.assert_axes(4, &[("x (m)", 2), ("y (m)", 2), ("forward (m)", 2), ("height (m)", 2)]);
}

#[test]
fn a_held_out_movement_lies_in_its_bands() {
    let time_s: Vec<f64> = (0..30).map(|k| 0.1 * f64::from(k)).collect();
    let joint = |k: usize| {
        let recorded: Vec<f64> = time_s.iter().map(|t| (t + k as f64).sin()).collect();
        let moved = |by: f64| recorded.iter().map(|v| v + by).collect::<Vec<_>>();
        let quantiles = [-0.3, -0.1, 0.02, 0.1, 0.25].map(moved);
        JointCurves { joint: format!("joint{k}"), recorded, quantiles, held_90: 1.0 }
    };
    let joints: Vec<JointCurves> = (0..6).map(joint).collect();
    let curves = HeldOutCurves {
        method: Method::FullW,
        is_pulled: true,
        rollouts: 100,
        trial: 0,
        time_s: time_s.clone(),
        joints: joints.clone(),
    };
    let whose = Learned { model: "anna", is_simulated: false };
    let figure = drawn(|| held_out_figure(&curves, "a.csv", &whose));
    let recorded = Pen { color: INK, width: 3.0, stroke: Stroke::Solid };
    let median = Pen { color: BLUE, width: 3.0, stroke: Stroke::Dashed };
    for (pen, pick) in [
        (recorded, (|j: &JointCurves| j.recorded.clone()) as fn(&JointCurves) -> Vec<f64>),
        (median, |j| j.quantiles[2].clone()),
    ] {
        let lines = figure.curves(pen);
        assert_eq!(lines.len(), 6);
        for (line, joint) in lines.iter().zip(&joints) {
            assert!(is_graph(line, &time_s, &pick(joint)), "{}", joint.joint);
        }
    }
    for (strength, low, high) in [(0.18, 0, 4), (0.42, 1, 3)] {
        // The first is the key of the legend.
        let areas = figure.areas(tint(BLUE, strength));
        assert_eq!(areas.len(), 7);
        let bands = &areas[1..];
        for (band, joint) in bands.iter().zip(&joints) {
            let (below, above) = band.split_at(time_s.len());
            let above: Vec<_> = above.iter().rev().copied().collect();
            assert!(is_graph(below, &time_s, &joint.quantiles[low]), "{}", joint.joint);
            assert!(is_graph(&above, &time_s, &joint.quantiles[high]), "{}", joint.joint);
        }
    }
    assert_legend(&figure, recorded, "recorded");
    assert_legend(&figure, median, "median");
    assert_eq!((figure.mentions("50 % band of"), figure.mentions("90 % band of")), (1, 1));
    figure.assert_axes(6, &[("time (s)", 6), ("joint angle (deg)", 6)]);
    assert!((0..6).all(|k| figure.says(&format!("joint{k}")) == 1));
    assert_eq!(figure.mentions("recorded and predicted"), 1);
}

#[test]
fn every_weight_has_its_dot_and_its_interval() {
    let joint = |name: &str, weight: f64| JointWeight {
        joint: name.to_owned(),
        group: "trunk",
        weight,
        interval: Some((0.5 * weight, 2.0 * weight)),
    };
    let weights = [0.2, 1.0, 3.0, 0.7];
    let joints = weights.iter().zip(["a", "b", "c", "d"]).map(|(w, n)| joint(n, *w)).collect();
    let spread = WeightSpread { method: Method::FullW, joints, blocks: 5, trials: 16 };
    let whose = Learned { model: "anna", is_simulated: false };
    let figure = drawn(|| weights_figure(&spread, &whose));
    let dots: Vec<f64> = figure.discs(BLUE).iter().map(|d| d.0).collect();
    assert!(is_scaled(&dots, &weights.map(f64::ln), 1.0), "{dots:?}");
    // A bar with two ends for each.
    let bars = figure.lines(Pen { color: BLUE, width: 2.5, stroke: Stroke::Solid });
    assert_eq!(bars.len(), 3 * weights.len());
    let lows: Vec<f64> = bars.iter().step_by(3).map(|bar| bar[0].0).collect();
    assert!(is_scaled(&lows, &weights.map(|w| (0.5 * w).ln()), 1.0), "{lows:?}");
    // The dashed line stands at 1.
    let one = figure.lines(Pen { color: INK, width: 1.5, stroke: Stroke::Dashed });
    assert!(one.len() == 1 && (one[0][0].0 - dots[1]).abs() < 1e-9, "{one:?}");
    assert!(["a", "b", "c", "d", "trunk"].iter().all(|name| figure.says(name) == 1));
    assert_eq!(figure.mentions("Weight W of each joint"), 1);
    figure.assert_axes(1, &[("diagonal of W over its geometric mean (no unit, logarithmic)", 1)]);
}

#[test]
fn forests_and_growth_show_every_row_and_every_method() {
    let values = [[0.4, 0.3, 0.5], [0.2, 0.1, 0.4]];
    let row = |label: &str, value| ForestRow {
        label: label.to_owned(),
        value: Some(value),
        is_total: false,
    };
    let panel = ForestPanel {
        title: "against the straight path".to_owned(),
        axis: "points".to_owned(),
        reference: 0.0,
        rows: vec![row("bench", values[0]), row("lift", values[1])],
    };
    let figure = drawn(|| forest_plots(&[panel], "dot: mean"));
    let dots: Vec<f64> = figure.discs(BLUE).iter().map(|d| d.0).collect();
    assert!(is_scaled(&dots, &values.map(|v| v[0]), 1.0) && dots.len() == 2);
    assert_eq!(figure.lines(Pen { color: BLUE, width: 2.5, stroke: Stroke::Solid }).len(), 6);
    assert_eq!(figure.lines(Pen { color: INK, width: 2.0, stroke: Stroke::Dashed }).len(), 1);
    for words in ["bench", "lift", "points", "against the straight path", "dot: mean"] {
        assert_eq!(figure.says(words), 1, "{words}");
    }

    let point = |samples: usize| GrowthPoint {
        samples,
        log_likelihood: samples as f64,
        training_s: samples as f64,
    };
    let line = |method: &str| GrowthLine {
        method: method.to_owned(),
        points: [100, 200, 400].map(point).to_vec(),
    };
    let figure = drawn(|| growth_plot(&[line("GP"), line("NsGP")]));
    for (k, method) in ["GP", "NsGP"].into_iter().enumerate() {
        let pen = Pen { color: method_color(k), width: 3.0, stroke: Stroke::Solid };
        assert_eq!(figure.curves(pen).len(), 2, "{method}");
        assert_eq!(figure.discs(pen.color).len(), 6, "{method}");
        assert_eq!(figure.says(method), 2);
    }
    assert_eq!((figure.mentions("log-likelihood"), figure.mentions("Training time")), (1, 1));
}
