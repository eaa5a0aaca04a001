//! What `validate` says.

use crate::math::stats::{mean, quantile};
use crate::training::people::{
    FEATURES, LeftOut, MovementScore, PersonScore, Predictor, StandingScore,
};
use crate::words::number::percent;
use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Value, json};

const PREDICTORS: &str = "  \
  RMS error over time against the recording, mean over movements. full-w is what `train` learns,
  diagonal-w the same with a diagonal W, plain-ik the plain pseudo-inverse without usual postures.
  The last three need not reach the hand: regression is the usual posture at its place,
  nearest-neighbour the posture of the recorded hand closest to it, mean-posture one posture for all.
  The fitted body, made to follow the recording itself, is as close as its joints allow.";

const BANDS: &str = "  \
  Share of the recorded frames inside the band. The band knows only the path of the hand and the size
  of the body, as in a plan. Below 90 % it is too narrow: people differ more than it says.";

fn movements(found: &LeftOut) -> Vec<&MovementScore> {
    found.people.iter().flat_map(|p| &p.movements).collect()
}

/// Mean over movements of the rms of a feature by a predictor.
fn rms(movements: &[&MovementScore], predictor: Predictor, feature: usize) -> f64 {
    let of = |m: &&MovementScore| {
        let found = m.predictors.iter().find(|p| p.predictor == predictor);
        found.map_or(f64::NAN, |p| p.rms[feature])
    };
    mean(&movements.iter().map(of).collect::<Vec<_>>())
}

/// Whether a predictor was there to be judged.
fn is_known(movements: &[&MovementScore], predictor: Predictor) -> bool {
    movements.iter().any(|m| m.predictors.iter().any(|p| p.predictor == predictor))
}

/// Mean coverage (50 or 90 %) of a feature over the frames of movements.
fn coverage(movements: &[&MovementScore], feature: usize, level: usize) -> f64 {
    let frames: usize = movements.iter().map(|m| m.frames).sum();
    let inside: f64 =
        movements.iter().map(|m| m.frames as f64 * m.bands.features[feature].coverage[level]).sum();
    inside / frames.max(1) as f64
}

fn pooled(movements: &[&MovementScore], level: usize) -> f64 {
    mean(&(0..FEATURES.len()).map(|f| coverage(movements, f, level)).collect::<Vec<_>>())
}

/// The lowest coverage of a feature of a person.
fn worst(found: &LeftOut, level: usize) -> f64 {
    let people = found.people.iter().map(|p| p.movements.iter().collect::<Vec<_>>());
    people
        .flat_map(|own| (0..FEATURES.len()).map(move |f| coverage(&own, f, level)))
        .fold(f64::INFINITY, f64::min)
}

/// Mean rms of the angles.
fn angle_error(movements: &[&MovementScore], predictor: Predictor) -> f64 {
    mean(&(1..FEATURES.len()).map(|f| rms(movements, predictor, f)).collect::<Vec<_>>())
}

/// `judged`: the name of the saved model that was judged; none where each person was left out.
pub(super) fn as_json(found: &LeftOut, judged: Option<&str>) -> Value {
    let all = movements(found);
    let by_person = |predictor: Predictor| -> Vec<f64> {
        let of = |p: &PersonScore| angle_error(&p.movements.iter().collect::<Vec<_>>(), predictor);
        found.people.iter().map(of).collect()
    };
    let error = |predictor: Predictor| json!({"median": quantile(&by_person(predictor), 0.5), "people": by_person(predictor)});
    let baselines: Vec<Value> = Predictor::ALL[1..]
        .iter()
        .filter(|p| is_known(&all, **p))
        .map(|p| json!({"name": p.name(), "posture_error_deg": error(*p)}))
        .collect();
    json!({
        "schema": "ergopath/validation/1",
        "model": judged,
        "persons": found.people,
        "posture_error_deg": error(Predictor::FullW),
        "coverage50": {"pooled": pooled(&all, 0), "worst": worst(found, 0)},
        "coverage90": {"pooled": pooled(&all, 1), "worst": worst(found, 1)},
        "energy_score_deg": mean(&all.iter().map(|m| m.bands.energy_deg).collect::<Vec<_>>()),
        "energy_score_one_law_deg": mean(&all.iter().map(|m| m.one_law.energy_deg).collect::<Vec<_>>()),
        "ended_share": mean(&all.iter().map(|m| m.bands.ended_share).collect::<Vec<_>>()),
        "standing": standing(found).map(|(rms_m, inside_90)| json!({"rms_m": rms_m, "inside90": inside_90})),
        "baselines": baselines,
    })
}

/// How well the standing places of the people were predicted, all movements alike; none where no model says.
fn standing(found: &LeftOut) -> Option<([f64; 2], f64)> {
    let of = |p: &PersonScore| Some((p.movements.len() as f64, p.standing.clone()?));
    let all: Vec<(f64, StandingScore)> = found.people.iter().filter_map(of).collect();
    let count = Some(all.iter().map(|(n, _)| n).sum::<f64>()).filter(|n| *n > 0.0)?;
    let over = |pick: &dyn Fn(&StandingScore) -> f64| {
        all.iter().map(|(n, s)| n * pick(s)).sum::<f64>() / count
    };
    Some(([0, 1].map(|i| over(&|s| s.rms_m[i].powi(2)).sqrt()), over(&|s| s.inside_90)))
}

pub(super) fn print_text(found: &LeftOut, judged: Option<&str>) {
    let all = movements(found);
    let people = match found.people.len() {
        1 => "1 person".to_owned(),
        count => format!("{count} people"),
    };
    match judged {
        Some(model) => say!("{people}, {} movements, predicted by {model}", all.len()),
        None => say!("{people} left out one by one, {} movements", all.len()),
    }
    let mut header = vec!["from the recorded first posture".to_owned()];
    header.extend(
        FEATURES
            .iter()
            .enumerate()
            .map(|(i, f)| if i == 0 { format!("{f} cm") } else { format!("{f} deg") }),
    );
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(&header);
    for predictor in Predictor::ALL.into_iter().filter(|p| is_known(&all, *p)) {
        let mut row = vec![predictor.name().to_owned()];
        row.extend((0..FEATURES.len()).map(|f| format!("{:.1}", rms(&all, predictor, f))));
        table.add_row(row);
    }
    let fit = |f: usize| mean(&all.iter().map(|m| m.fit_rms[f]).collect::<Vec<_>>());
    let mut row = vec!["(the fitted body itself)".to_owned()];
    row.extend((0..FEATURES.len()).map(|f| format!("{:.1}", fit(f))));
    table.add_row(row);
    right(&mut table);
    say!("\n{table}");
    say!("{PREDICTORS}");
    let mut table = Table::new();
    let header: Vec<&str> =
        std::iter::once("90 % bands of strangers hold").chain(FEATURES).collect();
    table.load_style(presets::NOTHING);
    table.set_header(&header);
    for person in &found.people {
        let own: Vec<&MovementScore> = person.movements.iter().collect();
        let mut row = vec![person.person.clone()];
        row.extend((0..FEATURES.len()).map(|f| percent(coverage(&own, f, 1))));
        table.add_row(row);
    }
    let mut row = vec!["all".to_owned()];
    row.extend((0..FEATURES.len()).map(|f| percent(coverage(&all, f, 1))));
    table.add_row(row);
    let width =
        |f: usize| mean(&all.iter().map(|m| m.bands.features[f].width_90).collect::<Vec<_>>());
    let mut row = vec!["width, cm and deg".to_owned()];
    row.extend((0..FEATURES.len()).map(|f| format!("{:.0}", width(f))));
    table.add_row(row);
    right(&mut table);
    say!("\n{table}");
    say!("{BANDS}");
    let told: Vec<&MovementScore> = all.iter().copied().filter(|m| !m.modes.is_empty()).collect();
    if !told.is_empty() {
        let energy =
            |of: fn(&MovementScore) -> f64| mean(&told.iter().map(|m| of(m)).collect::<Vec<_>>());
        say!(
            "\nstraighter and bent knees are told apart in {} of {} movements: energy score {:.1} deg \
             there, {:.1} deg by one law",
            told.len(),
            all.len(),
            energy(|m| m.bands.energy_deg),
            energy(|m| m.one_law.energy_deg)
        );
    }
    if let Some((rms_m, inside)) = standing(found) {
        say!(
            "\nwhere they stood at the far end of a movement: {:.0} cm ahead and {:.0} cm to the side from where the \
             others would, rms; {} within what the others say of 90 %",
            100.0 * rms_m[0],
            100.0 * rms_m[1],
            percent(inside)
        );
    }
    say!(
        "\nenergy score of the four angles {:.1} deg; repetitions that lost the hand: {}",
        mean(&all.iter().map(|m| m.bands.energy_deg).collect::<Vec<_>>()),
        percent(mean(&all.iter().map(|m| m.bands.ended_share).collect::<Vec<_>>()))
    );
}

fn right(table: &mut Table) {
    for i in 1..=FEATURES.len() {
        if let Some(column) = table.column_mut(i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}
