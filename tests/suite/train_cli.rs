//! `ergopath train` from outside: the shipped demonstration again, and what it refuses.

use crate::common::{ergopath, short_demonstration};
use assert_cmd::Command;
use ergopath::posture::load_model;
use serde_json::Value;
use std::path::{Path, PathBuf};

const DEMONSTRATION: &str = "scenarios/demonstrations/simulated_operator.csv";
const SHIPPED: &str = "models/posture/demo_operator.json";

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn train(recording: &Path, model: &Path) -> Command {
    let mut command = ergopath();
    command.arg("train").arg(recording).args(["--body", "female_p50", "-o"]).arg(model);
    command
}

/// Equal but for the rounding of another processor.
fn close(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
            (x - y).abs() <= 1e-6 * x.abs().max(y.abs()).max(1e-3)
        }
        (Value::Array(x), Value::Array(y)) => {
            x.len() == y.len() && x.iter().zip(y).all(|(x, y)| close(x, y))
        }
        (Value::Object(x), Value::Object(y)) => {
            x.len() == y.len()
                && x.iter().all(|(key, v)| y.get(key).is_some_and(|other| close(v, other)))
        }
        _ => a == b,
    }
}

#[test]
fn the_shipped_model_is_trained_again_from_the_shipped_movements() {
    let room = tempfile::tempdir().unwrap();
    let (model, data) = (room.path().join("m.json"), room.path().join("d.csv"));
    let figures = room.path().join("figures");
    let run = train(&project(DEMONSTRATION), &model)
        .args(["--name", "demo operator (simulated)", "--export"])
        .arg(&data)
        .arg("--figures")
        .arg(&figures)
        .assert()
        .success();
    let shown = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    for word in
        ["plain-ik", "w-ik", "full-w", "mi-nsgp", "relative RMSE", "by joint group", "simulated"]
    {
        assert!(shown.contains(word), "{word} is missing from\n{shown}");
    }
    let (own, shipped) = (
        std::fs::read_to_string(&model).unwrap(),
        std::fs::read_to_string(project(SHIPPED)).unwrap(),
    );
    if own != shipped {
        // Another processor may round sums of products in another way.
        println!("bytes differ; comparing numbers");
        let [own, shipped] = [&own, &shipped].map(|t| serde_json::from_str::<Value>(t).unwrap());
        assert!(close(&own, &shipped), "the shipped model is not the one that its movements make");
    }
    assert!(shipped.len() < 300_000);
    let lines = std::fs::read_to_string(&data).unwrap();
    assert!(lines.starts_with("q0,q1,") && lines.lines().next().unwrap().ends_with("train,traj"));
    // The guide shows the pictures of this command.
    assert_eq!(names(&figures), ["held_out.png", "weights.png"]);
    for name in names(&figures) {
        assert!(shown.contains(figures.join(&name).to_str().unwrap()), "{name} in\n{shown}");
        let own = Picture::read(&figures.join(&name));
        let of_guide = Picture::read(&project("docs/pictures").join(format!("training_{name}")));
        let unlike = own.unlike(&of_guide);
        assert!(unlike <= UNLIKE, "{name}: {unlike} pixels have no like in the guide's picture");
    }
    assert_eq!(room.path().read_dir().unwrap().count(), 3);
}

/// The names in a folder, in order.
fn names(folder: &Path) -> Vec<String> {
    let all = folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    // The list of what ergopath wrote lies beside it.
    let mut names: Vec<String> = all.filter(|name| !name.starts_with('.')).collect();
    names.sort();
    names
}

/// Pixels that may be unlike: none are on the processor that drew the guide's pictures. A number on an
/// axis has more, a curve twenty times as many.
const UNLIKE: usize = 40;

#[derive(Clone)]
struct Picture {
    width: usize,
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let rgb = bytes.chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
        Self { width: info.width as usize, rgb }
    }

    /// Pixels of either picture that have none of about their colour within 2 px in the other, so that
    /// an edge may move by rounding but nothing may be missing or too much.
    fn unlike(&self, other: &Self) -> usize {
        assert_eq!((self.width, self.rgb.len()), (other.width, other.rgb.len()));
        self.without_like(other) + other.without_like(self)
    }

    fn without_like(&self, other: &Self) -> usize {
        let (width, height) = (self.width, self.rgb.len() / self.width);
        let is_like = |a: [u8; 3], b: [u8; 3]| a.iter().zip(&b).all(|(x, y)| x.abs_diff(*y) <= 40);
        let around = |at: usize, size: usize| at.saturating_sub(2)..(at + 3).min(size);
        let is_found = |i: usize| {
            let (x, y) = (i % width, i / width);
            is_like(self.rgb[i], other.rgb[i])
                || around(y, height).any(|v| {
                    around(x, width).any(|u| is_like(self.rgb[i], other.rgb[v * width + u]))
                })
        };
        (0..self.rgb.len()).filter(|i| !is_found(*i)).count()
    }
}

/// One curve, one number or one word less than in the guide is seen.
#[test]
fn the_comparison_of_pictures_sees_what_is_missing() {
    let whole = Picture::read(&project("docs/pictures/training_held_out.png"));
    assert_eq!(whole.unlike(&whole), 0);
    // (left, right, top, bottom), px: the first panel, its lowest number, a word of the legend.
    let panel = (121, 559, 197, 495);
    // The dashed median alone: its colour becomes that of the band below.
    let mut without_median = whole.clone();
    let mut painted = 0;
    for y in panel.2..panel.3 {
        for x in panel.0..panel.1 {
            let p = &mut without_median.rgb[y * whole.width + x];
            if p[0] < 40 && p[2] > 140 {
                *p = [148, 195, 223];
                painted += 1;
            }
        }
    }
    assert!(painted > 300, "{painted} pixels of the median");
    for (what, (left, right, top, bottom)) in
        [("a legend's word", (40, 260, 70, 98)), ("the numbers below", (100, 580, 505, 530))]
    {
        let mut less = whole.clone();
        for y in top..bottom {
            less.rgb[y * whole.width + left..y * whole.width + right].fill([255; 3]);
        }
        assert!(less.unlike(&whole) > UNLIKE, "{what}");
    }
    let unlike = without_median.unlike(&whole);
    assert!(unlike > UNLIKE, "only {unlike} pixels without the median");
    // An edge that moves by a pixel is none.
    let mut moved = whole.clone();
    moved.rgb.rotate_right(1);
    assert!(moved.unlike(&whole) <= UNLIKE, "{}", moved.unlike(&whole));
}

#[test]
fn pictures_are_those_that_the_method_has_and_replace_their_like() {
    let room = tempfile::tempdir().unwrap();
    let data = short_demonstration(room.path());
    let (model, figures) = (room.path().join("m.json"), room.path().join("figures"));
    let with = |method: &str| {
        let mut command = train(&data, &model);
        command.args(["--method", method, "--figures"]).arg(&figures);
        command
    };
    with("w-ik").assert().success();
    assert_eq!(names(&figures), ["held_out.png", "weights.png"]);
    let first = std::fs::read(figures.join("weights.png")).unwrap();
    let run = with("w-ik").arg("--json").assert().success();
    assert!(first == std::fs::read(figures.join("weights.png")).unwrap(), "other bytes");
    let shown: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    let told: Vec<&str> =
        shown["figures"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    assert_eq!(told.len(), 2);
    assert!(told.iter().all(|f| Path::new(f).is_file()), "{told:?}");
    // The weights of before would be those of another model.
    let run = with("plain-ik").assert().success();
    assert_eq!(names(&figures), ["held_out.png"]);
    let shown = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    assert!(shown.contains("no weights.png") && shown.contains("identity"), "{shown}");
}

#[test]
fn pictures_are_written_with_the_model_or_not_at_all() {
    let room = tempfile::tempdir().unwrap();
    let data = short_demonstration(room.path());
    let (model, figures) = (room.path().join("m.json"), room.path().join("figures"));
    let into = |folder: &Path| {
        let mut command = train(&data, &model);
        command.args(["--method", "w-ik", "--figures"]).arg(folder);
        command
    };
    let thesis = room.path().join("thesis");
    std::fs::create_dir(&thesis).unwrap();
    std::fs::write(thesis.join("held_out.png"), "mine").unwrap();
    std::fs::write(thesis.join("robot.png"), "mine").unwrap();
    refused(&mut into(&thesis), "foreign", "not an ergopath output folder", room.path());
    assert_eq!(names(&thesis), ["held_out.png", "robot.png"]);
    refused(&mut into(&data), "file", "is a file, not a folder", room.path());
    // The model cannot be written in the place of a folder: nothing else stays either.
    let mut blocked = train(&data, &thesis);
    blocked.args(["--method", "w-ik", "--figures"]).arg(&figures);
    blocked.arg("--export").arg(room.path().join("d.csv"));
    refused(&mut blocked, "blocked", "is a folder, not a file", room.path());
    assert_eq!(names(room.path()), ["thesis", "three.csv"]);
}

#[test]
fn the_shipped_model_loads_and_says_that_it_is_simulated() {
    let (model, _) = load_model("demo_operator", Path::new(".")).unwrap();
    assert!(model.provenance.simulated);
    assert_eq!(model.name, "demo operator (simulated)");
    assert_eq!(model.joints.len(), 24);
    assert!(model.law.attraction.is_some() && model.law.noise.factor.ncols() > 3);
    let of = |name: &str| model.quality.iter().find(|q| q.method.name() == name).unwrap();
    assert!(of("full-w").relative_rmse < of("plain-ik").relative_rmse);
}

#[test]
fn json_is_for_machines() {
    let room = tempfile::tempdir().unwrap();
    let model = room.path().join("m.json");
    let run = train(&short_demonstration(room.path()), &model)
        .args(["--json", "--method", "mi-nsgp", "--pull", "none"])
        .assert()
        .success();
    let shown: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(shown["quality"].as_array().unwrap().len(), 4);
    assert_eq!(shown["model"]["provenance"]["simulated"], true);
    let (loaded, _) = load_model(model.to_str().unwrap(), Path::new(".")).unwrap();
    assert!(!loaded.law.processes.is_empty() && loaded.law.attraction.is_none());
}

#[test]
fn broken_input_ends_with_one_message_and_no_file() {
    let room = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(project(DEMONSTRATION)).unwrap();
    let row = text.lines().nth(40).unwrap();
    let value = row.split(',').nth(9).unwrap();
    let cases = [
        ("truncated", text[..text.len() / 2 + 7].to_owned(), "is not a table"),
        ("nan", text.replacen(row, &row.replacen(value, "NaN", 1), 1), "not a finite number"),
        ("joint", text.replacen("jL5S1_Z_rad", "jL5S1_Q_rad", 1), "jL5S1_Q_rad"),
        ("limit", text.replacen(row, &row.replacen(value, "3.1", 1), 1), "outside"),
        ("empty", String::new(), "no rows"),
        ("short", text.lines().take(25).collect::<Vec<_>>().join("\n"), "only 20 frames"),
    ];
    for (name, broken, expected) in cases {
        let path = room.path().join(format!("{name}.csv"));
        std::fs::write(&path, broken).unwrap();
        refused(&mut train(&path, &room.path().join("m.json")), name, expected, room.path());
    }
    // A movement that is there twice would be held out and known at once.
    let three = std::fs::read_to_string(short_demonstration(room.path())).unwrap();
    let first = three.lines().filter(|l| l.starts_with("1,"));
    let again = first.map(|l| format!("\n9{}", &l[1..])).collect::<Vec<_>>().concat();
    let copied = room.path().join("copied.csv");
    std::fs::write(&copied, three + &again).unwrap();
    let same = "copied.csv trial 9: holds the same movement as copied.csv trial 1";
    refused(&mut train(&copied, &room.path().join("m.json")), "copied", same, room.path());
    let good = project(DEMONSTRATION);
    let model = room.path().join("m.json");
    refused(&mut train(Path::new("none.csv"), &model), "missing", "no such file", room.path());
    let twice = &mut train(&good, &model);
    refused(twice.arg(&good), "twice", "given twice", room.path());
    let person = &mut train(&good, &model);
    refused(person.args(["--person", "ann"]), "person", "cannot be picked", room.path());
    let mut command = ergopath();
    let body = command.arg("train").arg(&good).args(["--body", "female_50", "-o"]).arg(&model);
    refused(body, "body", "female_p50", room.path());
    let method = &mut train(&good, &model);
    refused(method.args(["--method", "ful-w"]), "method", "full-w", room.path());
}

fn refused(command: &mut Command, name: &str, expected: &str, room: &Path) {
    let run = command.assert().code(2);
    // The message may be wrapped: compare without line breaks and margins.
    let shown = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    let flat: Vec<&str> = shown.split(['\n', '│', ' ']).filter(|w| !w.is_empty()).collect();
    assert!(flat.join(" ").contains(expected), "{name}: {shown}");
    assert!(run.get_output().stdout.is_empty(), "{name}");
    assert!(!room.join("m.json").exists(), "{name}");
}
