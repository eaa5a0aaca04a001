//! What `ergopath score MOTION` shows on the terminal.

use crate::ergonomics::{LiftNote, PairedDifference, Shown};
use crate::human::Side;
use crate::scenario::Origin;
use crate::scoring::{
    DriverShare, MotionKind, OtherMethods, OverRollouts, OverTime, PartSummary, SideSummary,
    Summary,
};
use crate::words::number::percent;
use comfy_table::{CellAlignment, Table, presets};

pub(super) fn print_text(s: &Summary) {
    let what = match s.kind {
        MotionKind::Recording => "recording".to_owned(),
        MotionKind::JointAngles => format!("joint angles, {} trial(s)", s.tracks),
        MotionKind::Rollouts => format!("{} rollouts", s.tracks),
    };
    let gaps = if s.gaps > 0 { format!(", {} gaps left out", s.gaps) } else { String::new() };
    say!(
        "{}: {what}, {} frames, {:.1} s{gaps}; body {}; profile {}",
        s.source,
        s.frames,
        s.observed_s,
        s.body,
        s.profile.name
    );
    for side in &s.sides {
        say!("\n{} SIDE", side.side.name().to_uppercase());
        if let Some(over) = &side.over_time {
            print_over_time(over);
        }
        if let Some(over) = &side.over_rollouts {
            print_over_rollouts(over);
        }
        if let Some([rula, reba]) = side.if_muscle_use {
            say!(
                "  with muscle use 1 (held > 1 min or > 4 a minute): RULA {rula:.2}, REBA {reba:.2}; above \
                 it is 0. The motion\n  is too short to show which; --hold-s and --cycles-per-min settle it."
            );
        }
        say!("\n{}", indented(&parts(&side.parts)));
        say!(
            "  * held longer than 1 min, or more than 4 movements a minute; - set by a rule, not by the motion"
        );
        print_views(side);
        print_drivers(side);
        print_other_methods(&side.other_methods);
        print_inputs(side);
    }
}

fn table(header: &[&str], right_from: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header);
    for column in right_from..header.len() {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn indented(table: &Table) -> String {
    let text = table.trim_fmt();
    text.lines().map(|l| format!(" {l}")).collect::<Vec<_>>().join("\n")
}

fn print_over_time(over: &OverTime) {
    let mut t = table(&["", "mean", "P5", "P50", "P95", "time at action level"], 1);
    if let Some(c) = t.column_mut(5) {
        c.set_cell_alignment(CellAlignment::Left);
    }
    for (name, f) in [("RULA", &over.rula), ("REBA", &over.reba)] {
        let levels: Vec<String> =
            f.levels.iter().map(|l| format!("{}: {}", l.level, percent(l.share))).collect();
        t.add_row([
            name.to_owned(),
            format!("{:.2}", f.mean),
            format!("{:.0}", f.p05),
            format!("{:.0}", f.p50),
            format!("{:.0}", f.p95),
            levels.join("   "),
        ]);
    }
    say!("{}", indented(&t));
}

fn print_over_rollouts(over: &OverRollouts) {
    let mut t =
        table(&["", "expected", "SE", "90 % band", "CVaR90", "exposure (P for 0.5 s) at level"], 1);
    if let Some(c) = t.column_mut(5) {
        c.set_cell_alignment(CellAlignment::Left);
    }
    for (name, f) in [("RULA", &over.rula), ("REBA", &over.reba)] {
        let d = &f.distribution;
        let levels: Vec<String> = f
            .levels
            .iter()
            .skip(1)
            .map(|(level, _, exposure, p)| {
                format!("{level}+: {} ({})", percent(*exposure), percent(*p))
            })
            .collect();
        t.add_row([
            name.to_owned(),
            format!("{:.2}", d.expected),
            d.standard_error.map_or_else(|| "-".to_owned(), |e| format!("{e:.2}")),
            format!("{:.2} to {:.2}", d.p05, d.p95),
            format!("{:.2}", d.cvar90),
            levels.join("   "),
        ]);
    }
    say!("{}", indented(&t));
    if over.reach_exceeded > 0.0 {
        say!(
            "  reach exceeded in {} of the rollouts; they count as RULA 7, REBA 15 from there on",
            percent(over.reach_exceeded)
        );
    }
}

fn parts(parts: &[PartSummary]) -> Table {
    let header = [
        "body part",
        "angle, deg",
        "P10",
        "P50",
        "P90",
        "peak",
        "RULA step 1, 2, ...",
        "longest hold",
        "moves/min (in all)",
    ];
    let mut t = table(&header, 2);
    if let Some(c) = t.column_mut(6) {
        c.set_cell_alignment(CellAlignment::Left);
    }
    for part in parts {
        for (i, a) in part.angles.iter().enumerate() {
            let once = |text: String| if i == 0 { text } else { String::new() };
            let steps: Vec<String> =
                part.rula_steps.iter().map(|s| format!("{:.0}", 100.0 * s)).collect();
            let steps = if steps.is_empty() { String::new() } else { steps.join(" ") + " %" };
            let hold = if part.held == Shown::Yes { " *" } else { "" };
            let seen = |text: String| if part.is_measured { text } else { "-".to_owned() };
            let moves = if part.repeated == Shown::Yes { " *" } else { "" };
            // Less than a minute says how many, not how often.
            let rate = match part.repeated {
                Shown::TooShort => format!("({})", part.movements),
                _ => format!("{:.1}{moves}", part.movements_per_min),
            };
            t.add_row([
                once(part.part.to_owned()),
                a.angle.to_owned(),
                whole(a.p10),
                whole(a.p50),
                whole(a.p90),
                whole(a.peak),
                once(steps),
                once(seen(format!("{:.1} s{hold}", part.longest_hold_s))),
                once(seen(rate)),
            ]);
        }
    }
    t
}

/// A whole number without a negative zero.
fn whole(value: f64) -> String {
    (value.round() + 0.0).to_string()
}

fn print_views(side: &SideSummary) {
    say!("\n  frames worth a look");
    let mut t = table(&["", "time", "in", "RULA", "REBA", ""], 6);
    for v in &side.views {
        t.add_row([
            v.kind.name().to_owned(),
            format!("{:.2} s", v.time_s),
            v.track.clone(),
            v.rula.to_string(),
            v.reba.to_string(),
            v.why.clone(),
        ]);
    }
    say!("{}", indented(&t));
}

fn print_drivers(side: &SideSummary) {
    say!();
    for (name, drivers) in [("RULA", &side.drivers), ("REBA", &side.reba_drivers)] {
        print_driver_line(name, drivers);
    }
}

fn print_driver_line(name: &str, drivers: &[DriverShare]) {
    let strong: Vec<String> = drivers
        .iter()
        .filter(|d| d.drop >= 0.005)
        .map(|d| format!("{} {:.2}", d.step, d.drop))
        .collect();
    let text = if strong.is_empty() {
        "no single step: relieving one alone would not lower it".to_owned()
    } else {
        strong.join(", ")
    };
    say!("  what drives {name} (drop if the step alone were at its lowest): {text}");
}

fn print_other_methods(o: &OtherMethods) {
    say!("\n  other methods");
    let categories: Vec<String> = o
        .luba
        .categories
        .iter()
        .enumerate()
        .map(|(i, c)| format!("{}: {}", i + 1, percent(*c)))
        .collect();
    say!(
        "    LUBA index {:.1} on average, {} at most; time in category {}",
        o.luba.mean,
        o.luba.largest,
        categories.join("   ")
    );
    let mut t = table(
        &["", "part", "acceptable", "for a time", "conditional", "not recommended", "longest hold"],
        2,
    );
    for (name, parts) in [("ISO 11226", &o.iso_11226), ("EN 1005-4", &o.en_1005_4)] {
        for (i, p) in parts.iter().enumerate() {
            let hold = p.longest.map_or_else(String::new, |h| {
                let over = if p.is_held_too_long() { " too long" } else { "" };
                format!("{:.1} of {:.0} s{over}", h.duration_s, h.allowed_s)
            });
            t.add_row([
                if i == 0 { name.to_owned() } else { String::new() },
                p.part.name().to_owned(),
                percent(p.acceptable),
                percent(p.up_to),
                percent(p.conditional),
                percent(p.not_recommended),
                hold,
            ]);
        }
    }
    say!("{}", indented_once(&t));
    if o.en_1005_4_rate_assumed {
        say!("    EN 1005-4 for twice a minute or more (assumed; --cycles-per-min settles it)");
    }
    say!(
        "    back: spine joints add up to {:.0} deg of rotation ({:.0} deg flexion) on average; trunk \
         inclination {:.0} deg s in all, {:.1} deg on average",
        o.back.rotation_deg,
        o.back.flexion_deg,
        o.back.exposure.integral_deg_s,
        o.back.exposure.mean_deg
    );
    if let Some(lift) = &o.lift {
        let is_outside = lift.notes.iter().any(|n| matches!(n, LiftNote::NotApplicable(_)));
        let scope = if is_outside {
            " (the equation does not apply here; for comparison only)"
        } else {
            ""
        };
        say!(
            "    NIOSH{scope}: recommended weight limit {:.1} kg, lifting index {}",
            lift.recommended_kg,
            lift.lifting_index.map_or_else(
                || "none: no load is acceptable here".to_owned(),
                |l| format!("{l:.2}")
            )
        );
        for note in &lift.notes {
            say!("      {}", note.words());
        }
    }
    say!(
        "    Zones and points are from secondary sources or memory where no paper was at hand (summary.json)."
    );
}

fn indented_once(table: &Table) -> String {
    let text = table.trim_fmt();
    text.lines().map(|l| format!("   {l}")).collect::<Vec<_>>().join("\n")
}

fn print_inputs(side: &SideSummary) {
    say!("  inputs");
    for i in &side.inputs {
        say!("    {:34} {:14} {}", i.input, origin(i.origin), i.value);
    }
}

fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Measured => "measured",
        Origin::Predicted => "predicted",
        Origin::FromTheTask => "from the task",
        Origin::Assumed => "assumed",
        Origin::Unknown => "unknown",
    }
}

pub(super) fn print_paired(a: &Summary, b: &Summary, rows: &[(Side, [PairedDifference; 2])]) {
    say!("{} minus {}, {} pairs of rollouts, 95 % intervals:", a.source, b.source, a.tracks);
    for (side, scores) in rows {
        for (name, d) in ["RULA", "REBA"].iter().zip(scores) {
            let verdict = match (d.clear, d.mean > 0.0) {
                (false, _) => "no clear difference".to_owned(),
                (true, true) => format!("{} is better", b.source),
                (true, false) => format!("{} is better", a.source),
            };
            say!(
                "  {:5} {name}  {:+.2} ({:+.2} to {:+.2})  {verdict}",
                side.name(),
                d.mean,
                d.low95,
                d.high95
            );
        }
    }
}
