//! Terminal, page, table and JSON show the same run: every figure that they share is the same, and
//! every sentence of the verdict stands on the page as on the terminal.

use crate::common::ergopath;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Plain words: no marks, no-break spaces as spaces, one space between words.
fn plain(text: &str) -> String {
    let text = text.replace(['`', '\u{a0}'], " ").replace(['\u{2212}'], "-");
    let words: Vec<&str> = text.split_whitespace().collect();
    // A name in code has space around it on the page and marks on the terminal.
    words.join(" ").replace("( ", "(").replace(" )", ")").replace(" ,", ",").replace(" .", ".")
}

/// The text of a page without its scripts and tags; cells of tables are set apart.
fn page_text(html: &str) -> String {
    let mut text = String::new();
    let mut rest = html;
    while let Some(open) = rest.find('<') {
        text.push_str(&rest[..open]);
        rest = &rest[open..];
        let skipped = ["script", "style", "svg"].into_iter().find_map(|tag| {
            let close = format!("</{tag}>");
            rest.starts_with(&format!("<{tag}")).then(|| rest.find(&close).map(|i| i + close.len()))
        });
        let end = skipped.flatten().unwrap_or_else(|| rest.find('>').unwrap() + 1);
        text.push_str(if rest.starts_with("</tr") { "\n" } else { " " });
        rest = &rest[end..];
    }
    text.push_str(rest);
    for (mark, sign) in
        [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")]
    {
        text = text.replace(mark, sign);
    }
    text
}

/// A figure with two decimals, and a share in percent, as a reader would round them.
fn two(value: &Value) -> String {
    format!("{:.2}", value.as_f64().unwrap())
}

fn percent(value: &Value) -> String {
    match 100.0 * value.as_f64().unwrap() {
        0.0 => "0 %".to_owned(),
        p if p < 0.1 => "<0.1 %".to_owned(),
        p if p < 9.95 => format!("{p:.1} %"),
        p if p > 99.5 && p < 100.0 => ">99 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

fn run(scenario: &str, planner: &str) {
    let room = tempfile::tempdir().unwrap();
    let out = room.path().join("out");
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(scenario);
    let mut command = ergopath();
    command.arg("plan").arg(&scenario).args(["--planner", planner]).arg("-o").arg(&out);
    let ran = command.assert().success();
    let terminal = String::from_utf8(ran.get_output().stdout.clone()).unwrap();
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let page = page_text(&read("report.html"));
    let result: Value = serde_json::from_str(&read("result.json")).unwrap();
    sentences_agree(&terminal, &plain(&page));
    figures_agree(&terminal, &page, &result, &out.join("candidates.csv"));
}

/// Sentences of the terminal whose figures the first screen of the page tells in another form.
const RETOLD: [&str; 6] = [
    "Best path: ",
    "No path is clearly better",
    "Assessed: ",
    "Expected ",
    "Assumed, not predicted: ",
    "cycles_per_min and ",
];

/// The shares and the numbers with decimals of a sentence; not the 90 of a 90 % band.
fn figures(words: &str) -> Vec<&str> {
    let all: Vec<&str> = words.split([' ', '(', ')', ',', ';', ':']).collect();
    let is_figure = |(word, next): (&str, &str)| {
        let number = word.trim_end_matches('.');
        number.parse::<f64>().is_ok() && (number.contains('.') || (next == "%" && number != "90"))
    };
    let pairs = all.iter().zip(all.iter().skip(1).chain([&""]));
    pairs.filter(|(a, b)| is_figure((a, b))).map(|(a, _)| a.trim_end_matches('.')).collect()
}

/// All that the terminal says above its table and under its warnings.
fn sentences_agree(terminal: &str, page: &str) {
    let above = terminal.lines().take_while(|l| !l.trim_start().starts_with("rank"));
    let warnings = terminal.lines().skip_while(|l| *l != "Warnings").skip(1);
    let warnings = warnings.take_while(|l| !l.is_empty());
    let mut seen = 0;
    for line in above.chain(warnings) {
        let words = plain(line.trim().trim_start_matches('[').trim_end_matches(']'));
        if RETOLD.iter().any(|start| words.starts_with(start)) {
            let first_screen = page.split("Paths compared").next().unwrap();
            for figure in figures(&words) {
                let told = first_screen.contains(figure);
                assert!(told, "the first screen does not tell {figure} of `{words}`");
            }
            seen += 1;
        } else if !words.is_empty() {
            assert!(page.contains(&words), "the page does not say `{words}`");
            seen += 1;
        }
    }
    assert!(seen > 5, "{terminal}");
}

fn figures_agree(terminal: &str, page: &str, result: &Value, table: &Path) {
    let mut table = csv::Reader::from_path(table).unwrap();
    let rows: Vec<BTreeMap<String, String>> = table.deserialize().map(Result::unwrap).collect();
    let body = result["verdict"]["body"].as_str().unwrap();
    let ranked = result["candidates"].as_array().unwrap().iter().filter(|c| c["rank"].is_number());
    let mut seen = 0;
    for candidate in ranked {
        let id = candidate["id"].as_str().unwrap();
        let scores = candidate["bodies"].as_array().unwrap();
        let scores = scores.iter().find(|b| b["body"] == body).unwrap();
        let (rula, reba) = (&scores["rula"], &scores["reba"]);
        let shared = [
            two(&rula["expected"]),
            format!("{} to {}", two(&rula["p05"]), two(&rula["p95"])),
            percent(&rula["high_band"][0]),
            two(&rula["per_metre"]),
            two(&rula["peak"]),
            two(&reba["expected"]),
            two(&candidate["objective"]),
        ];
        let rank = candidate["rank"].as_u64().unwrap().to_string();
        let mut lines = terminal.lines().map(plain);
        let line = lines.find(|l| {
            let words: Vec<&str> = l.split(' ').collect();
            words[0] == rank && words.contains(&id)
        });
        let line = line.unwrap_or_else(|| panic!("the terminal does not list {id}"));
        let cells = page.lines().map(plain).find(|l| {
            let words: Vec<&str> = l.split(' ').collect();
            words[0] == rank && words.contains(&id) && l.contains("s.e.")
        });
        let cells = cells.unwrap_or_else(|| panic!("the page does not list {id}"));
        for figure in &shared {
            assert!(line.contains(figure.as_str()), "{id}: {figure} is not in `{line}`");
            assert!(cells.contains(figure.as_str()), "{id}: {figure} is not in `{cells}`");
        }
        let row = rows.iter().find(|r| r["id"] == id && r["body"] == body).unwrap();
        for (column, value) in [
            ("expected_rula", &rula["expected"]),
            ("p05_rula", &rula["p05"]),
            ("exposure_rula_5", &rula["high_band"][0]),
            ("rula_per_metre", &rula["per_metre"]),
            ("peak_rula", &rula["peak"]),
            ("expected_reba", &reba["expected"]),
            ("objective", &candidate["objective"]),
        ] {
            let written: f64 = row[column].parse().unwrap();
            assert!((written - value.as_f64().unwrap()).abs() < 1e-12, "{id}, {column}");
        }
        seen += 1;
    }
    assert!(seen > 3, "{seen} paths");
}

#[test]
fn terminal_page_table_and_json_agree() {
    run("bench_pick_and_place.toml", "quick");
}

#[test]
fn they_agree_where_there_are_several_bodies() {
    run("hand_over.toml", "quick");
}
