//! What the whole body does along a path, in words.

use super::number::percent;
use super::setting::size;
use crate::ergonomics::{PeopleSpread, PerMethod, ScoringMethod};
use crate::planner::{
    BodyScores, BodyStrain, MethodScores, ModeShare, Moved, OfSize, Spread, StepsTaken, WorstOff,
};

fn band(s: &Spread, digits: usize, unit: &str) -> String {
    format!("{:.digits$} {unit} (90 % band {:.digits$} to {:.digits$})", s.median, s.p05, s.p95)
}

/// So many of ten.
fn of_ten(share: f64) -> String {
    format!("{:.0}", 10.0 * share)
}

/// How often people bend their back, and how often their knees.
fn ways(straighter: &ModeShare, bent: &ModeShare) -> String {
    let recorded = |m: &ModeShare| {
        format!("recorded: trunk at {:.0}, knees at {:.0} deg", m.trunk_deg, m.knees_deg)
    };
    let [movements, people] = bent.movements;
    let near = match bent.movements_near {
        near if near < 1.0 => "none".to_owned(),
        near => format!("about {near:.0}"),
    };
    format!(
        "in {} of 10 repetitions with bent knees ({}), in {} with straighter knees ({}). The recordings \
         would allow {} to {} of 10 with bent knees: {near} of their {movements} low movements ({people} \
         {}) put the hand down near here. They show what people did, not why",
        of_ten(bent.of_repetitions),
        recorded(bent),
        of_ten(straighter.of_repetitions),
        recorded(straighter),
        of_ten(bent.share_90[0]),
        of_ten(bent.share_90[1]),
        if people == 1 { "person" } else { "people" },
    )
}

/// How the feet are set anew.
fn steps(s: &StepsTaken) -> String {
    let elsewhere = if s.elsewhere_share > 0.0 {
        format!(", and in {} they start elsewhere than at worker.at_m", percent(s.elsewhere_share))
    } else {
        String::new()
    };
    format!(
        "in {} of repetitions the feet are set anew, {:.0} to {:.0} times and {} in all{elsewhere}. Where people \
         stand is learned from {} movements of {} people; half a second for a step and its longest stride are assumed",
        percent(s.share),
        s.number.p05,
        s.number.p95,
        band(&s.way_m, 2, "m"),
        s.movements,
        s.people
    )
}

/// How people differ, by the scores of all methods; none where nobody repeats.
fn people(scores: &PerMethod<MethodScores>) -> Option<String> {
    let of = |m: ScoringMethod| {
        let PeopleSpread { between_sd, between_sd_high, within_sd, .. } =
            scores[m].people.as_ref()?;
        Some(format!(
            "{} {between_sd:.2} (up to {between_sd_high:.2}) and {within_sd:.2}",
            m.name()
        ))
    };
    let spreads: Vec<String> = ScoringMethod::ALL.into_iter().filter_map(of).collect();
    let rula = &scores[ScoringMethod::Rula];
    let PeopleSpread { persons, at_high, .. } = rula.people.as_ref()?;
    let each = rula.by_rollout.len() as f64 / *persons as f64;
    Some(format!(
        "{persons} people are drawn who move as recorded people do, with {each:.0} repetitions each. Standard deviation of \
         people's own means, and of the repetitions of one person: {}. {:.0} of {persons} people are at RULA action level 3 or \
         above for half a second or more in at least half of their repetitions",
        spreads.join("; "),
        at_high * *persons as f64,
    ))
}

/// Rank correlation below which nothing is said to go with stature: with 32 people chance alone passes it one time
/// in twenty.
const GOES_WITH: f64 = 0.35;

/// Whether the tall or the short are worse off, and what of the spread goes with size.
fn of_size(of: &OfSize) -> String {
    let OfSize { with_stature: correlation, split } = *of;
    let what = if correlation.abs() < GOES_WITH {
        "neither the tall nor the short are clearly worse off"
    } else if correlation > 0.0 {
        "the taller a person, the worse"
    } else {
        "the shorter a person, the worse"
    };
    format!(
        "{what} (rank correlation of people's mean RULA with stature {correlation:.2}). Of the standard deviation between \
         people, {:.2} go with stature, mass and sex, and {:.2} with their ways of moving (the two add as squares)",
        split.size_sd, split.way_sd
    )
}

/// Who is worst off, and how this person moves.
fn worst_off(w: &WorstOff) -> String {
    let departs = |(moved, by): &(Moved, f64)| {
        let more = if *by > 0.0 { "more" } else { "less" };
        let what = match moved {
            Moved::Trunk => "bends the trunk",
            Moved::UpperArm => "raises the upper arm",
            Moved::Elbow => "bends the elbow",
            Moved::Neck => "bends the neck",
            Moved::Knees => "bends the knees",
        };
        format!("{what} {:.0} deg {more}", by.abs())
    };
    let how = match &w.departs[..] {
        [] => "moves much as the others do".to_owned(),
        all => {
            let all: Vec<String> = all.iter().map(departs).collect();
            format!("{} than people do on average", all.join(", "))
        }
    };
    let who = w.size.as_ref().map_or_else(String::new, |s| format!(" ({})", size(s)));
    format!("person {} of them{who}, with a mean RULA of {:.2}: {how}", w.person, w.score)
}

/// Name of the figure that tells who is worst off.
pub const WORST_OFF: &str = "worst off";

/// Name and sentence of each figure of a body.
pub fn lines(b: &BodyScores) -> Vec<(&'static str, String)> {
    let people = people(&b.scores).map(|sentence| ("people", sentence));
    let worst = b.worst_off.as_ref().map(|w| (WORST_OFF, worst_off(w)));
    let size = b.of_size.as_ref().map(|of| ("body size", of_size(of)));
    let strain = b.strain.as_ref().map_or_else(Vec::new, of_strain);
    people.into_iter().chain(worst).chain(size).chain(strain).collect()
}

fn of_strain(s: &BodyStrain) -> Vec<(&'static str, String)> {
    let mut all = vec![("trunk", format!("bends to {}", band(&s.trunk_flexion_deg, 0, "deg")))];
    if let (Some(knees), Some(bent)) = (&s.knee_flexion_deg, s.bent_knees_share) {
        let sentence = format!(
            "bend to {}; beyond 60 deg in {} of repetitions",
            band(knees, 0, "deg"),
            percent(bent)
        );
        all.push(("knees", sentence));
    }
    if let [straighter, bent] = &s.modes[..] {
        all.push(("ways", ways(straighter, bent)));
    }
    if let (Some(margin), Some(heels)) = (&s.balance_margin_m, s.raised_heels_share) {
        let cm = Spread {
            median: 100.0 * margin.median,
            p05: 100.0 * margin.p05,
            p95: 100.0 * margin.p95,
        };
        let sentence = format!(
            "the centre of mass stays at least {} inside the feet; heels rise in {} of repetitions",
            band(&cm, 0, "cm"),
            percent(heels)
        );
        all.push(("balance", sentence));
    }
    if let Some(taken) = &s.steps {
        all.push(("steps", steps(taken)));
    }
    all.push((
        "low back",
        format!(
            "static moment about L5/S1, body and load, without acceleration: peak {}, mean {:.0} N m",
            band(&s.l5s1_peak_nm, 0, "N m"),
            s.l5s1_mean_nm.median
        ),
    ));
    if let Some(f) = &s.furniture {
        let cm = |m: f64| format!("{:.0} cm", 100.0 * m.abs());
        let nearest = if f.distance_m.median < 0.0 { "inside by" } else { "at least" };
        let sentence = format!(
            "the body but the leading forearm and hand: {nearest} {} in the median repetition ({} and `{}` come nearest, at {:.2} s); \
             deeper inside than {} in {} of repetitions",
            cm(f.distance_m.median),
            f.body_part,
            f.obstacle,
            f.time_s,
            cm(f.soft_m),
            percent(f.share_inside)
        );
        all.push(("furniture", sentence));
    }
    if let Some(lift) = &s.niosh {
        let index = lift.lifting_index.map_or_else(
            || "no load is acceptable".to_owned(),
            |i| format!("lifting index {i:.2}"),
        );
        let notes: Vec<String> =
            lift.notes.iter().map(crate::ergonomics::LiftNote::words).collect();
        let mut sentence = format!(
            "NIOSH for both hands, up to 8 hours: recommended limit {:.1} kg, {index}",
            lift.recommended_kg
        );
        if !notes.is_empty() {
            sentence = format!("{}. {sentence}", notes.join(" ").trim_end_matches('.'));
        }
        all.push(("lifting", sentence));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_told_with_how_sure_they_are() {
        let mode =
            |trunk_deg: f64, knees_deg: f64, of_repetitions: f64, share_90: [f64; 2]| ModeShare {
                trunk_deg,
                knees_deg,
                share: of_repetitions,
                share_90,
                of_repetitions,
                movements_near: 8.6,
                movements: [32, 5],
            };
        let straighter = mode(109.0, 64.0, 0.6, [0.42, 0.78]);
        let bent = mode(69.0, 132.0, 0.4, [0.22, 0.58]);
        let text = ways(&straighter, &bent);
        let wanted = "in 4 of 10 repetitions with bent knees (recorded: trunk at 69, knees at 132 deg), \
                      in 6 with straighter knees";
        assert!(text.starts_with(wanted), "{text}");
        assert!(text.contains("2 to 6 of 10 with bent knees: about 9 of their 32"), "{text}");
        let nowhere = ModeShare { movements_near: 0.2, ..bent };
        assert!(ways(&straighter, &nowhere).contains("none of their 32"));
    }
}
