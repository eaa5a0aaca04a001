//! A shift in words.

use super::number::percent;
use super::setting::size;
use crate::ergonomics::{LiftDuration, ScoringMethod};
use crate::human::Hands;
use crate::shift::{
    BodyDose, CompositeRefusal, Dose, LiftRefusal, Order, ShiftNote, ShiftResult, TaskApart,
    TaskKind, Units, WhyApart,
};

/// Minutes as text: hours from 100 min on would hide how they add up.
pub fn minutes(value: f64) -> String {
    match value {
        v if v.is_nan() => "unknown".to_owned(),
        0.0 => "0 min".to_owned(),
        v if v < 0.1 => "<0.1 min".to_owned(),
        v if v < 9.95 => format!("{v:.1} min"),
        v => format!("{v:.0} min"),
    }
}

/// "112 to 140 min".
pub fn range([low, high]: [f64; 2]) -> String {
    let of = |v: f64| if high < 9.95 { format!("{v:.1}") } else { format!("{v:.0}") };
    format!("{} to {} min", of(low), of(high))
}

fn task(result: &ShiftResult, k: usize) -> String {
    result.tasks.get(k).map_or_else(String::new, |t| format!("`{}`", t.name))
}

/// The body that the sentences are about.
pub fn worst_body(result: &ShiftResult) -> Option<&BodyDose> {
    result.bodies.get(result.worst)
}

/// How long at action level 3 or above, of how much.
pub fn headline(result: &ShiftResult) -> String {
    let Some(body) = worst_body(result) else { return String::new() };
    let lead = ScoringMethod::ALL[0];
    let high = &body.methods[lead].high;
    let unscored = match result.time.unscored_min() {
        m if m > 0.0 => {
            format!(" {} of work were not scored and may add to it.", minutes(m))
        }
        _ => String::new(),
    };
    format!(
        "{} action level 3 or above for {} of a shift of {} ({}).{unscored}",
        lead.name(),
        minutes(high.mean_min),
        minutes(result.time.shift_min),
        percent(high.mean_min / result.time.shift_min),
    )
}

/// Over what a band is.
pub fn over(units: Units) -> String {
    match units {
        Units::People(n) => format!("nine of ten people ({n} people, the same in all tasks)"),
        Units::Repetitions(n) => {
            format!(
                "nine of ten repetitions ({n}, the same in all tasks, each as if kept up all shift)"
            )
        }
        Units::Independent => {
            "nine of ten combinations of people or repetitions, which are not the same in all tasks"
                .to_owned()
        }
        Units::Nothing => "no band: every task was measured once".to_owned(),
    }
}

/// The band and the interval of a dose; none where nothing is known of the spread.
pub fn spread(dose: &Dose, units: Units) -> Option<String> {
    let (band, interval) = (dose.band90_min?, dose.interval95_min?);
    Some(format!(
        "{}: {}; 95 % interval of the mean {}",
        super::number::capital(&over(units)),
        range(band),
        range(interval)
    ))
}

/// Which task gives most of it.
pub fn most(result: &ShiftResult) -> Option<String> {
    let body = worst_body(result)?;
    let dose = &body.methods[ScoringMethod::ALL[0]];
    let k = dose.most?;
    let part = dose.tasks.get(k)?;
    let share = result.tasks.get(k)?.minutes / result.time.shift_min;
    if result.tasks.len() == 1 {
        return Some(format!("All time at level 3 or above comes from {}.", task(result, k)));
    }
    Some(format!(
        "{} gives most of the time at level 3 or above: {} ({} of it), with {} of the shift.",
        task(result, k),
        minutes(part.high.mean_min),
        percent(part.share_of_high),
        percent(share),
    ))
}

/// For whom the figures are, and who is worst off.
pub fn whose(result: &ShiftResult) -> Option<String> {
    let body = worst_body(result)?;
    let which = if result.bodies.len() > 1 {
        format!("For the body that is worst off of {}, `{}`", result.bodies.len(), body.body)
    } else if body.body.is_empty() {
        "For one person".to_owned()
    } else {
        format!("For `{}`", body.body)
    };
    let person = body.worst_person.as_ref().map(|w| {
        let who = w.size.as_ref().map_or_else(String::new, |s| format!(" ({})", size(s)));
        format!(
            "; worst off of {} people is person {}{who}, with {}",
            w.of,
            w.person,
            minutes(w.high_min)
        )
    });
    Some(format!("{which}{}.", person.unwrap_or_default()))
}

/// What kind of result a task is.
pub fn kind(kind: TaskKind) -> &'static str {
    match kind {
        TaskKind::Path => "path of a run",
        TaskKind::Motion => "one motion",
        TaskKind::Sampled => "sampled postures",
    }
}

/// The hands at work.
pub fn hands(hands: Hands) -> &'static str {
    match hands {
        Hands::Right => "right",
        Hands::Left => "left",
        Hands::Both => "both",
    }
}

/// How the tasks follow each other.
pub fn order(order: Option<Order>) -> &'static str {
    match order {
        Some(Order::Mixed) => "the tasks alternate within each quarter of an hour",
        Some(Order::Blocks) => "the tasks follow each other in blocks",
        None => "it is not said how the tasks follow each other",
    }
}

/// Why the lifting equation says nothing of a task.
pub fn lift_refusal(why: LiftRefusal) -> String {
    match why {
        LiftRefusal::Condition(c) => c.why().to_owned(),
        LiftRefusal::NoLoad => "nothing is lifted".to_owned(),
        LiftRefusal::NotARun => "a scored motion does not tell the way of the load".to_owned(),
        LiftRefusal::TooLong => {
            "the working time is above 8 h, for which the equation has no limits".to_owned()
        }
    }
}

/// The same for all reasons: "does not apply because ...".
pub fn lift_refusals(all: &[LiftRefusal]) -> String {
    let parts: Vec<String> = all.iter().map(|r| lift_refusal(*r)).collect();
    format!("does not apply because {}", parts.join(", and "))
}

/// Why there is no composite index.
pub fn composite_refusal(why: CompositeRefusal) -> &'static str {
    match why {
        CompositeRefusal::Blocks => {
            "The composite lifting index does not apply because the tasks follow each other in blocks: its authors made \
             it for tasks that alternate. Each block stands for itself."
        }
        CompositeRefusal::OrderUnknown => {
            "No composite lifting index: it holds only for tasks that alternate within each quarter of an hour. If they do, \
             say `order = \"mixed\"` in the shift file."
        }
    }
}

/// What a lifting index asks for (manual, section 1.4.3).
pub fn index_words(index: f64) -> &'static str {
    match index {
        i if i <= 1.0 => "at or below 1.0, the goal of design",
        i if i <= 3.0 => "above 1.0: a raised risk of low back pain for some of the workforce",
        _ => "above 3.0: a raised risk for nearly all workers",
    }
}

/// The duration class.
pub fn lift_duration(duration: LiftDuration) -> &'static str {
    match duration {
        LiftDuration::Short => "up to 1 h, with as much recovery after it",
        LiftDuration::Moderate => "up to 2 h, with 0.3 of that time for recovery after it",
        LiftDuration::Long => "up to 8 h with the usual breaks",
    }
}

/// The lifting of the shift in sentences; empty where no task has anything to do with lifting.
pub fn lifting(result: &ShiftResult) -> Vec<String> {
    let dose = &result.lifting;
    let mut all = Vec::new();
    if let Some(composite) = &dose.composite {
        let what = if composite.steps.len() > 1 {
            "Composite lifting index (revised NIOSH equation)"
        } else {
            "Lifting index (revised NIOSH equation)"
        };
        all.push(match composite.index {
            Some(i) => format!("{what}: {i:.2}, {}.", index_words(i)),
            None => format!("{what}: no load is acceptable at this place or this often."),
        });
    }
    all.extend(dose.refusal.map(|r| composite_refusal(r).to_owned()));
    for t in &dose.tasks {
        if !t.refused.is_empty() {
            all.push(format!(
                "{}: the lifting equation {}.",
                task(result, t.task),
                lift_refusals(&t.refused)
            ));
        }
    }
    all
}

/// Hand exertions in sentences.
pub fn exertion(result: &ShiftResult) -> Vec<String> {
    let Some(dose) = &result.exertion else { return Vec::new() };
    let of = |value: [f64; 2], text: &dyn Fn(f64) -> String| {
        let [low, high] = value.map(text);
        if low == high { low } else { format!("{low} to {high}") }
    };
    let mut all: Vec<String> = dose
        .hands
        .iter()
        .map(|h| {
            format!(
                "{} hand: cumulative damage {}; in the study behind the tool {} of people with that damage had an injury, \
                 and pain in the last year.",
                super::number::capital(h.side.name()),
                of(h.damage, &|v| format!("{v:.4}")),
                of(h.probability, &percent),
            )
        })
        .collect();
    if !dose.not_rated.is_empty() {
        let names: Vec<String> = dose.not_rated.iter().map(|k| task(result, *k)).collect();
        all.push(format!("Without a rating, and so not counted: {}.", names.join(", ")));
    }
    all
}

/// Why the people of two tasks are not the same.
pub fn apart(result: &ShiftResult, a: &TaskApart) -> String {
    let why = match &a.why {
        WhyApart::Runs(why) => super::pairing::apart(why),
        WhyApart::Counts([x, y]) => format!("{x} and {y} repetitions"),
        WhyApart::Sampled => "sampled postures do not say whose they are".to_owned(),
    };
    format!(
        "{} and {} are not the same people or repetitions ({why}), so they are combined as independent.",
        task(result, a.other),
        task(result, a.task)
    )
}

/// A note in one sentence.
pub fn note(result: &ShiftResult, note: &ShiftNote) -> String {
    let of = |k: &usize| task(result, *k);
    match note {
        ShiftNote::WithoutPause { task } => format!(
            "{}: how often is not given, so the movement is repeated without a pause. Give `cycles` if there are pauses.",
            of(task)
        ),
        ShiftNote::RepeatedMore { task, per_min, scored_per_min } => {
            let scored = scored_per_min
                .map_or_else(|| "no number".to_owned(), |v| format!("{v} cycles a minute"));
            format!(
                "{}: {per_min:.1} times a minute in the shift, but its scenario says {scored}. Above 4 a minute RULA and REBA \
                 add a point, which is missing here: set task.cycles_per_min and make the run again.",
                of(task)
            )
        }
        ShiftNote::RepeatedLess { task, per_min } => format!(
            "{}: {per_min:.1} times a minute in the shift, but it was scored as repeated more than 4 times a minute.",
            of(task)
        ),
        ShiftNote::MeasuredOnce { task, body } => format!(
            "{}: one motion, scored on `{body}`; it counts alike for everybody, and nothing is known of its spread.",
            of(task)
        ),
        ShiftNote::OutOfReach { task, share } => format!(
            "{}: in {} of repetitions the hand cannot follow; they count as the worst score from there.",
            of(task),
            percent(*share)
        ),
        ShiftNote::Beyond { task, share } => {
            format!("{}: {} of the path is beyond the recordings.", of(task), percent(*share))
        }
        ShiftNote::LimitsBroken { task } => {
            format!("{}: the path does not keep all limits; it is scored as it is.", of(task))
        }
        ShiftNote::NoChecksum { task } => format!(
            "{}: the file of its scores carries no checksum: edits of its figures cannot be seen.",
            of(task)
        ),
        ShiftNote::OtherHands => {
            "The tasks are scored for different hands: RULA is of one side of the body in each.".to_owned()
        }
        ShiftNote::OnePerson => {
            "Nobody repeats in these runs (a posture model of one person, or fewer repetitions than people), so bands are over \
             single repetitions: wider than those of whole shifts, in which single movements average out."
                .to_owned()
        }
        ShiftNote::NotScored => {
            "Work between the movements and work that no task names is not scored; it is neither rest nor load here.".to_owned()
        }
        ShiftNote::NoFatigue => {
            "RULA and REBA know no fatigue and no recovery: minutes add up whatever the order of tasks and breaks.".to_owned()
        }
    }
}

/// All notes, with what is not paired.
pub fn notes(result: &ShiftResult) -> Vec<String> {
    let mut all: Vec<String> = result.apart.iter().map(|a| apart(result, a)).collect();
    all.extend(result.notes.iter().map(|n| note(result, n)));
    if !result.left_out.is_empty() {
        let names: Vec<String> = result.left_out.iter().map(|n| format!("`{n}`")).collect();
        all.push(format!("Bodies that not all tasks know are left out: {}.", names.join(", ")));
    }
    all
}

/// What the posture models are not, each once with its tasks.
pub fn caveats(result: &ShiftResult) -> Vec<String> {
    let mut all: Vec<(String, Vec<String>)> = Vec::new();
    for t in &result.tasks {
        let Some(words) = t.caveat.map(|c| super::verdict::caveat(c).into_owned()) else {
            continue;
        };
        let name = format!("`{}`", t.name);
        match all.iter_mut().find(|(w, _)| *w == words) {
            Some((_, names)) => names.push(name),
            None => all.push((words, vec![name])),
        }
    }
    let count = result.tasks.len();
    all.into_iter()
        .map(
            |(words, names)| {
                if names.len() == count { words } else { format!("{}: {words}", names.join(", ")) }
            },
        )
        .collect()
}
