//! Which optional keys a scenario leaves out, and what holds then.

use super::held::usual_hold;
use crate::human::NamedGrip;
use crate::posture::Hold;
use toml::{Table, Value};

/// Table (empty: the top), key, and what holds without it. Limits of the TCP are listed by
/// [`super::Scenario::assumed_limits`].
const OPTIONAL: [(&str, &str, &str); 21] = [
    ("", "seed", "0"),
    ("", "score_profile", "vignais2017"),
    ("", "workspace", "none: the TCP may go anywhere within the other limits"),
    ("", "obstacle", "none: nothing to run into"),
    ("worker", "hands", "right"),
    ("worker", "stance", "standing"),
    ("worker", "shoe_m", "0.03 m"),
    ("worker", "start_posture", "sampled from the person's own"),
    ("worker", "pelvis", "moves as predicted"),
    ("worker", "steps", "none: the feet stay where they are"),
    ("worker", "neck", "as recorded people hold it, given trunk and hand"),
    ("worker", "other_arm", "predicted: it hangs under its shoulder"),
    ("worker", "trunk_supported", "no"),
    ("worker", "arm_supported", "no"),
    ("task", "part_mass_kg", "0 kg"),
    ("task", "human_load_share", "1: the worker carries all of the part"),
    ("task", "extra_load_kg", "0 kg"),
    ("task", "cycles_per_min", "not known: muscle use is shown for both cases"),
    ("task", "hold_s", "not known: muscle use is shown for both cases"),
    ("task", "shock", "no"),
    ("task", "coupling", "good"),
];

/// "key = what holds" for every optional key that the text of a scenario leaves out.
pub fn defaults_in_force(text: &str) -> Vec<String> {
    let Ok(file) = text.parse::<Table>() else { return Vec::new() };
    let has = |table: &str, key: &str| match table {
        "" => file.contains_key(key),
        _ => file.get(table).and_then(|t| t.get(key)).is_some(),
    };
    let is_seated = file.get("worker").and_then(|w| w.get("stance")?.as_str()) == Some("seated");
    let optional = OPTIONAL
        .iter()
        .filter(|(table, key, _)| !has(table, key))
        // Who sits, sits with or without shoes.
        .filter(|(_, key, _)| !is_seated || !["shoe_m", "steps"].contains(key))
        .filter(|(_, key, _)| !has("worker", "side") || *key != "hands")
        .map(|(table, key, words)| {
            let dot = if table.is_empty() { "" } else { "." };
            format!("{table}{dot}{key}: {words}")
        });
    optional.chain(usual_holds(&file)).collect()
}

/// The holds that follow from the names of grips.
fn usual_holds(file: &Table) -> Vec<String> {
    let grip = file.get("grip");
    let of_hand = |side: &str| grip.and_then(|g| g.get(side));
    let tables = [("grip", grip), ("grip.right", of_hand("right")), ("grip.left", of_hand("left"))];
    let usual = |(key, table): (&str, Option<&Value>)| {
        let table = table.filter(|t| t.get("hold").is_none())?;
        let name = table.get("grip")?.as_str()?;
        let hold = match usual_hold(NamedGrip::by_name(name)?) {
            Hold::Rigid => "rigid",
            _ => "free_roll",
        };
        Some(format!("{key}.hold: {hold}, as usual for `{name}`"))
    };
    tables.into_iter().filter_map(usual).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ergonomics::Profile;
    use crate::scenario::file::{OtherArm, PelvisFile, StanceFile};
    use crate::scenario::scenario_schema;
    use crate::survey::NeckRule;

    #[test]
    fn every_key_is_one_of_the_format_and_optional() {
        let schema = scenario_schema();
        for (table, key, _) in OPTIONAL {
            let place = match table {
                "" => schema.clone(),
                "worker" => schema["definitions"]["WorkerFile"].clone(),
                _ => schema["definitions"]["TaskFile"].clone(),
            };
            assert!(place["properties"].get(key).is_some(), "{table} {key}");
            let required = place["required"].as_array().cloned().unwrap_or_default();
            assert!(!required.iter().any(|r| r == key), "{table} {key}");
        }
        let profile = OPTIONAL.iter().find(|o| o.1 == "score_profile").unwrap();
        assert_eq!(profile.2, Profile::default().name);
    }

    #[test]
    fn what_is_said_to_hold_holds() {
        let said = |key: &str| OPTIONAL.iter().find(|o| o.1 == key).unwrap().2;
        assert_eq!(NeckRule::default(), NeckRule::Predicted);
        assert!(said("neck").starts_with("as recorded people hold it"));
        assert_eq!(OtherArm::default(), OtherArm::Predicted);
        assert!(said("other_arm").starts_with("predicted"));
        assert_eq!(PelvisFile::default(), PelvisFile::Predicted);
        assert_eq!(said("pelvis"), "moves as predicted");
        assert!(matches!(StanceFile::default(), StanceFile::Standing));
        assert_eq!(said("stance"), "standing");
    }

    #[test]
    fn what_is_given_is_not_listed() {
        let all = defaults_in_force("seed = 3\n[worker]\nstance = \"seated\"\n");
        assert!(!all.iter().any(|l| l.starts_with("seed") || l.contains("stance")));
        assert!(!all.iter().any(|l| l.contains("shoe_m")));
        assert!(all.contains(&"worker.hands: right".to_owned()), "{all:?}");
        let all = defaults_in_force("[grip]\ngrip = \"pinch_from_above\"\n");
        let hold = "grip.hold: rigid, as usual for `pinch_from_above`".to_owned();
        assert!(all.contains(&hold), "{all:?}");
        let both = "[grip.right]\ngrip = \"box_side\"\nhold = \"point\"\n[grip.left]\ngrip = \"box_side\"\n";
        let all = defaults_in_force(both);
        let holds: Vec<&String> = all.iter().filter(|l| l.contains("hold: ")).collect();
        assert!(holds.contains(&&"grip.left.hold: free_roll, as usual for `box_side`".to_owned()));
        assert!(!holds.iter().any(|l| l.starts_with("grip.right")), "{holds:?}");
    }
}
