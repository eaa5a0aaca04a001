//! What the whole body does along a path, in words.

use super::number::percent;
use crate::planner::{BodyStrain, Spread};

fn band(s: &Spread, digits: usize, unit: &str) -> String {
    format!("{:.digits$} {unit} (90 % band {:.digits$} to {:.digits$})", s.median, s.p05, s.p95)
}

/// Name and sentence of each figure.
pub fn lines(s: &BodyStrain) -> Vec<(&'static str, String)> {
    let mut all = vec![("trunk", format!("bends to {}", band(&s.trunk_flexion_deg, 0, "deg")))];
    if let (Some(knees), Some(bent)) = (&s.knee_flexion_deg, s.bent_knees_share) {
        let sentence = format!(
            "bend to {}; beyond 60 deg in {} of repetitions",
            band(knees, 0, "deg"),
            percent(bent)
        );
        all.push(("knees", sentence));
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
