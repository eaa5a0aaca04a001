//! What `validate` says.

use super::validate::Judged;
use crate::ergonomics::{BodyPart, PerMethod, ScoringMethod};
use crate::math::stats::{mean, quantile};
use crate::training::people::{
    AdaptedScore, Agreement, CENTRES, FEATURES, Known, LeftOut, MovementScore, OwnError, Predictor,
    REPETITIONS, coverage,
};
use crate::words::number::{change, percent, score};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Map, Value, json};

const PREDICTORS: &str = "  \
  RMS error over time against the recording, mean over movements. full-w is what `train` learns,
  diagonal-w the same with a diagonal W, plain-ik the plain pseudo-inverse without usual postures.
  The last three need not reach the hand: regression is the usual posture at its place,
  nearest-neighbour the posture of the recorded hand closest to it, mean-posture one posture for all.
  The fitted body, made to follow the recording itself, is as close as its joints allow.";

const BANDS: &str = "  \
  Share of the recorded frames inside the band. The band knows only the path of the hand and the size
  of the body, as in a plan. Below 90 % it is too narrow: people differ more than it says.";

const RISK: &str = "  \
  Mean over movements of the error of the score's mean over time, predicted less recorded on average,
  and Spearman's rank correlation over movements. The first row is what a plan does. The others have no
  chance in them, and from the hand path alone those that follow the hand begin in the usual posture at
  its first place. Both sides are scored with free hands, no load and no muscle use.";

/// The four figures of an agreement.
fn agreed(found: Option<Agreement>) -> Value {
    found.map_or(Value::Null, |a| json!(a))
}

/// `judged`: the saved model that was judged; none where each person was left out.
pub(super) fn as_json(found: &LeftOut, judged: Option<&Judged>) -> Value {
    let error = |predictor: Predictor| {
        let people = found.angle_errors_deg(predictor);
        json!({"median": quantile(&people, 0.5), "people": people})
    };
    let without_chance = |predictor: Predictor| {
        let mut all = json!({
            "name": predictor.name(),
            "posture_error_deg": error(predictor),
            "centres_cm": by_name(&CENTRES, &found.centres_cm(predictor)),
        });
        for method in ScoringMethod::ALL {
            let of = |known: Known| agreed(found.risk_of(method, predictor, known));
            all[method.key()] = of(Known::HandPath);
            all[format!("{}_known_start", method.key())] = of(Known::Start);
        }
        all
    };
    let known = found.predictors();
    let baselines: Vec<Value> =
        known.iter().filter(|p| **p != Predictor::FullW).map(|p| without_chance(*p)).collect();
    let all = found.movements();
    let crps: Vec<f64> = (0..FEATURES.len()).map(|f| found.crps(f)).collect();
    let entered = found
        .entered()
        .into_iter()
        .map(|e| (e.column.to_owned(), json!({"recorded": e.recorded, "predicted": e.predicted})));
    let mut value = json!({
        "schema": "ergopath/validation/1",
        "model": judged.map(|j| &j.name),
        "recordings": judged.map(|j| j.recordings),
        "learned_recordings": judged.map(|j| j.learned),
        "persons": found.people,
        "posture_error_deg": error(Predictor::FullW),
        "centres_cm": by_name(&CENTRES, &found.centres_cm(Predictor::FullW)),
        "coverage50": {"pooled": found.pooled(0), "worst": found.worst(0)},
        "coverage90": {"pooled": found.pooled(1), "worst": found.worst(1)},
        "crps": by_name(&FEATURES, &crps),
        "energy_score_deg": mean(&all.iter().map(|m| m.bands.energy_deg).collect::<Vec<_>>()),
        "energy_score_one_law_deg": mean(&all.iter().map(|m| m.one_law.energy_deg).collect::<Vec<_>>()),
        "ended_share": mean(&all.iter().map(|m| m.bands.ended_share).collect::<Vec<_>>()),
        "standing": found.standing().map(|(rms_m, inside_90)| json!({"rms_m": rms_m, "inside90": inside_90})),
        "entered": entered.collect::<Map<String, Value>>(),
        "adapted": found.adapted,
        "without_chance": without_chance(Predictor::FullW),
        "baselines": baselines,
    });
    for method in ScoringMethod::ALL {
        let mut risk = json!(found.risk(method));
        let with = BodyPart::ALL.map(|part| (part, found.risk_with(method, part)));
        risk["with_recorded"] =
            with.iter().map(|(part, a)| (part.name().to_owned(), json!(a))).collect();
        value[method.key()] = risk;
    }
    value
}

fn by_name(names: &[&str], values: &[f64]) -> Map<String, Value> {
    names.iter().zip(values).map(|(name, value)| ((*name).to_owned(), json!(value))).collect()
}

pub(super) fn print_text(found: &LeftOut, judged: Option<&Judged>) {
    let all = found.movements();
    let people = match found.people.len() {
        1 => "1 person".to_owned(),
        count => format!("{count} people"),
    };
    match judged {
        Some(model) => say!("{people}, {} movements, predicted by {}", all.len(), model.name),
        None => say!("{people} left out one by one, {} movements", all.len()),
    }
    print_postures(found, &all);
    print_bands(found, &all);
    print_risk(found);
    print_rest(found, &all);
    print_adapted(&found.adapted);
}

/// What each person's own seconds bring.
fn print_adapted(scores: &[AdaptedScore]) {
    let Some(first) = scores.first() else { return };
    let header = [
        format!("with {} s of the person's own", first.own_s),
        "movements".to_owned(),
        "people: error deg".to_owned(),
        "adapted".to_owned(),
        "own alone".to_owned(),
        "people: energy deg".to_owned(),
        "adapted".to_owned(),
        "own alone".to_owned(),
    ];
    let mut table = table(header.to_vec());
    let figure = |v: Option<f64>| match v.filter(|v| v.is_finite()) {
        Some(v) => format!("{v:.1}"),
        None => "none".to_owned(),
    };
    for s in scores {
        let mut row = vec![s.person.clone(), s.movements.to_string()];
        for of in [|e: OwnError| e.error_deg, |e: OwnError| e.energy_deg] {
            row.extend([Some(s.people), Some(s.adapted), s.own].map(|e| figure(e.map(of))));
        }
        table.add_row(row);
    }
    show(table);
    say!(
        "  On the movements of which nothing was taken. Error: trunk, upper arm, elbow and knees from the recorded first \
         posture, root mean square over time; energy: energy score of repetitions from drawn starts. None: so little does \
         not make a model."
    );
}

fn print_postures(found: &LeftOut, all: &[&MovementScore]) {
    let mut header = vec!["from the recorded first posture".to_owned()];
    let unit = |(i, f): (usize, &&str)| format!("{f} {}", if i == 0 { "cm" } else { "deg" });
    header.extend(FEATURES.iter().enumerate().map(unit));
    header.extend(CENTRES.map(|c| format!("{c} cm")));
    let mut table = table(header);
    for predictor in found.predictors() {
        let mut row = vec![predictor.name().to_owned()];
        row.extend((0..FEATURES.len()).map(|f| format!("{:.1}", found.rms(predictor, f))));
        row.extend(found.centres_cm(predictor).map(|c| format!("{c:.1}")));
        table.add_row(row);
    }
    let fit = |f: usize| mean(&all.iter().map(|m| m.fit_rms[f]).collect::<Vec<_>>());
    let mut row = vec!["(the fitted body itself)".to_owned()];
    row.extend((0..FEATURES.len()).map(|f| format!("{:.1}", fit(f))));
    table.add_row(row);
    show(table);
    say!("{PREDICTORS}");
    say!("  Joint centres, of the side that leads, are held against those of the fitted body.");
}

fn print_bands(found: &LeftOut, all: &[&MovementScore]) {
    let header = std::iter::once("90 % bands of strangers hold").chain(FEATURES);
    let mut table = table(header.map(str::to_owned).collect());
    let held = |name: &str, movements: &[&MovementScore]| {
        let mut row = vec![name.to_owned()];
        row.extend((0..FEATURES.len()).map(|f| percent(coverage(movements, f, 1))));
        row
    };
    for person in &found.people {
        table.add_row(held(&person.person, &person.own()));
    }
    table.add_row(held("all", all));
    let width =
        |f: usize| mean(&all.iter().map(|m| m.bands.features[f].width_90).collect::<Vec<_>>());
    let mut row = vec!["width, cm and deg".to_owned()];
    row.extend((0..FEATURES.len()).map(|f| format!("{:.0}", width(f))));
    table.add_row(row);
    let mut row = vec!["CRPS, cm and deg".to_owned()];
    row.extend((0..FEATURES.len()).map(|f| format!("{:.1}", found.crps(f))));
    table.add_row(row);
    show(table);
    say!("{BANDS}");
}

/// The figures of an agreement in a row.
fn cells(a: Option<Agreement>) -> [String; 3] {
    let Some(a) = a else { return ["–"; 3].map(str::to_owned) };
    [score(a.mae), change(a.bias), a.rank_correlation.map_or_else(|| "–".to_owned(), score)]
}

fn print_risk(found: &LeftOut) {
    let mut header = vec!["from the hand path alone".to_owned()];
    for method in ScoringMethod::ALL {
        header.push(format!("{} error", method.name()));
        header.extend(["bias", "ranks"].map(str::to_owned));
    }
    header.push("RULA error, known start".to_owned());
    let mut table = table(header);
    let own = PerMethod::of(|m| found.risk(m));
    let mut row = vec![format!("full-w, {REPETITIONS} repetitions")];
    row.extend(ScoringMethod::ALL.into_iter().flat_map(|m| cells(Some(own[m].agreement))));
    row.push("–".to_owned());
    table.add_row(row);
    for predictor in found.predictors() {
        let once = if predictor == Predictor::FullW { ", without chance" } else { "" };
        let mut row = vec![format!("{}{once}", predictor.name())];
        for method in ScoringMethod::ALL {
            row.extend(cells(found.risk_of(method, predictor, Known::HandPath)));
        }
        let known = found.risk_of(ScoringMethod::Rula, predictor, Known::Start);
        row.push(if predictor.needs_start() { cells(known)[0].clone() } else { "–".to_owned() });
        table.add_row(row);
    }
    show(table);
    say!("{RISK}");
    for method in ScoringMethod::ALL {
        let with = BodyPart::ALL
            .map(|part| format!("{} {}", part.name(), score(found.risk_with(method, part).mae)));
        say!(
            "\n{} of {} of {} movements is inside the 90 % band (mean width {}), of {} inside the 50 % band; \
             error with one part of the body as recorded: {}",
            method.name(),
            percent(own[method].inside90),
            own[method].movements,
            score(own[method].width90),
            percent(own[method].inside50),
            with.join(", ")
        );
    }
}

fn print_rest(found: &LeftOut, all: &[&MovementScore]) {
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
    if let Some((rms_m, inside)) = found.standing() {
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

fn table(header: Vec<String>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header);
    table
}

/// Numbers to the right.
fn show(mut table: Table) {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("\n{table}");
}
