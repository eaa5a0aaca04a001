//! Small valid files of every kind, all made up: nobody's recording.

#![allow(dead_code, unreachable_pub, reason = "programs that share this file use parts of it")]

use ergopath::files::CHECKSUM;
use ergopath::planner::{PlanError, Preset, Request, RunResult, load_preset, plan};
use ergopath::report::result_json;
use ergopath::scenario::{Scenario, parse_scenario};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::LazyLock;

pub const BENCH: &str = include_str!("../../../scenarios/bench_pick_and_place.toml");
const RIGID_BODIES: &str = include_str!("../../../models/maps/rigid_bodies.toml");

/// A planner that is done in a moment.
pub const TINY: &str = "schema = \"ergopath/planner/1\"\nname = \"tiny\"\nvias = 1\nnamed_offset_m = 0.1\n\
     sampled_offset_m = 0.1\npopulation = 4\ngenerations = 1\nruns = 1\nbaseline_generations = 1\n\
     steps = 20\nrollouts_first = 2\nrollouts_most = 2\nshortlist = 2\nreported = 2\nrollouts_final = 2\n\
     [objective]\nexpected_rula = 1.0\nexpected_reba = 0.0\ncvar90_rula = 0.0\nexposure_rula_5 = 0.0\n";

/// What one run leaves: its result, and the same run interrupted; without their checksums.
pub struct Ran {
    pub result: String,
    pub unfinished: String,
}

pub static RAN: LazyLock<Ran> = LazyLock::new(|| {
    let scenario = bench();
    let go = |_| true;
    let result = plan(&scenario, &request(), &go).expect("the bench can be planned");
    // Stopped as soon as a search has begun.
    let asked = std::sync::atomic::AtomicUsize::new(0);
    let stop = |_| asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 3;
    let unfinished = match plan(&scenario, &request(), &stop) {
        Err(PlanError::Interrupted(Some(kept))) => kept.text().expect("JSON"),
        other => panic!("not interrupted: {:?}", other.map(|_| ())),
    };
    Ran { result: opened(&json_of(&result)), unfinished: opened(&unfinished) }
});

fn json_of(result: &RunResult) -> String {
    result_json(result).expect("JSON")
}

pub fn bench() -> Scenario {
    parse_scenario(Path::new("bench.toml"), BENCH).expect("the bench is a scenario")
}

pub fn tiny() -> Preset {
    let room = tempfile::tempdir().expect("a folder");
    let file = room.path().join("tiny.toml");
    std::fs::write(&file, TINY).expect("written");
    load_preset(&file.to_string_lossy()).expect("a planner")
}

pub fn request() -> Request {
    let preset = tiny();
    Request { command: String::new(), seed: 1, preset, keeps_rollouts: false, resume: None }
}

/// A file of ours without its checksum, so that changes of it are looked at.
pub fn opened(text: &str) -> String {
    let mut value: serde_json::Value = serde_json::from_str(text).expect("JSON");
    value.as_object_mut().expect("an object").remove(CHECKSUM);
    value.to_string()
}

/// Scores of a motion, by hand.
pub const SUMMARY: &str = r#"{"schema":"ergopath/score/1","source":"a.csv","body":"male_p50","frames":20,"tracks":2,"observed_s":2.0,
"sides":[{"side":"right",
"over_time":{"rula":{"levels":[{"share":0.25},{"share":0.25},{"share":0.25},{"share":0.25}]},
"reba":{"levels":[{"share":0.2},{"share":0.2},{"share":0.2},{"share":0.2},{"share":0.2}]}},
"over_rollouts":null}]}"#;

/// An arm of seven parts with every kind of joint and shape that a file may hold.
pub const ARM: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <link name="base"><inertial><origin xyz="0 0 0.1"/><mass value="2.0"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <collision><origin xyz="0 0 0.05" rpy="0 0 0"/><geometry><cylinder radius="0.06" length="0.1"/></geometry></collision></link>
  <link name="l1"><collision><geometry><box size="0.1 0.1 0.2"/></geometry></collision></link>
  <link name="l2"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="l3"><collision><geometry><mesh filename="part.stl" scale="0.001 0.001 0.001"/></geometry></collision></link>
  <link name="l4"/>
  <link name="l5"><visual><geometry><capsule radius="0.04" length="0.1"/></geometry></visual></link>
  <link name="l6"/>
  <link name="finger"/>
  <link name="tcp"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0.2" rpy="0 0 0"/><axis xyz="0 0 1"/><limit lower="-2.9" upper="2.9" effort="80" velocity="2.0"/></joint>
  <joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0 0.05 0.2" rpy="-1.5708 0 0"/><axis xyz="0 0 1"/><limit lower="-1.8" upper="1.8" effort="80" velocity="2.0"/></joint>
  <joint name="j3" type="continuous"><parent link="l2"/><child link="l3"/><origin xyz="0 -0.3 0" rpy="1.5708 0 0"/><axis xyz="0 0 1"/><limit effort="80" velocity="2.0"/></joint>
  <joint name="j4" type="prismatic"><parent link="l3"/><child link="l4"/><origin xyz="0.08 0 0" rpy="1.5708 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="80" velocity="1.0"/></joint>
  <joint name="j5" type="revolute"><parent link="l4"/><child link="l5"/><origin xyz="0 0.3 0" rpy="-1.5708 0 0"/><axis xyz="0 1 0"/><limit lower="-2.8" upper="2.8" effort="12" velocity="2.6"/></joint>
  <joint name="j6" type="revolute"><parent link="l5"/><child link="l6"/><origin xyz="0 0 0.1" rpy="1.5708 0 0"/><axis xyz="0 0 1"/><limit lower="-0.1" upper="3.7" effort="12" velocity="2.6"/></joint>
  <joint name="j_finger" type="prismatic"><parent link="l6"/><child link="finger"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.2"/><mimic joint="j4" multiplier="0.1" offset="0.0"/></joint>
  <joint name="j_tcp" type="fixed"><parent link="l6"/><child link="tcp"/><origin xyz="0 0 0.1" rpy="0 0 0"/></joint>
</robot>
"#;

/// Made-up map from markers.
pub const MAP: &str = r#"schema = "ergopath/map/1"
[map]
up = "z"
longest_gap_s = 0.2
unit = "mm"
rate_hz = 50
[segment.Pelvis]
joint = ["RASI", "LASI"]
offset_mm = [-50, -60, 0]
right = ["LASI", "RASI"]
ahead = ["SACR", ["RASI", "LASI"]]
[segment.T8]
joint = "T10"
up = ["T10", "C7"]
right = "as Pelvis"
[segment.RightUpperArm]
joint = "RSHO"
end = "joint of RightForeArm"
right = "as RightForeArm"
[segment.RightForeArm]
joint = "RELB"
offset_along = { direction = { hinge = ["RSHO", "RELB", "RWRI"] }, mm = -10 }
end = "RWRI"
right = { hinge = ["RSHO", "RELB", "RWRI"] }
[segment.RightHand]
joint = "RWRI"
up = "as RightForeArm"
right = "as RightForeArm"
turn_deg = [0, 0, 5]
"#;

pub const MARKERS: [&str; 8] = ["RASI", "LASI", "SACR", "T10", "C7", "RSHO", "RELB", "RWRI"];

/// Places (mm) of the markers: somebody who stands and raises a forearm.
fn places(i: usize) -> [[f64; 3]; 8] {
    let bend = 1.2 - 0.8 * (0.1 * i as f64).cos();
    let wrist = [260.0 * bend.sin(), -200.0, 1100.0 - 260.0 * bend.cos()];
    let [r, l, s] = [[100.0, -120.0, 1000.0], [100.0, 120.0, 1000.0], [-100.0, 0.0, 1000.0]];
    let (t10, c7, sho) = ([0.0, 0.0, 1300.0], [0.0, 0.0, 1500.0], [0.0, -200.0, 1400.0]);
    [r, l, s, t10, c7, sho, [0.0, -200.0, 1100.0], wrist]
}

const FRAMES: usize = 40;

pub fn trc() -> String {
    let names = MARKERS.join("\t\t\t");
    let axes: String = (1..=8).fold(String::new(), |mut s, i| {
        let _ = write!(s, "\tX{i}\tY{i}\tZ{i}");
        s
    });
    let mut text = format!(
        "PathFileType\t4\t(X/Y/Z)\tann.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\n\
         50.0\t50.0\t{FRAMES}\t8\tmm\t50.0\nFrame#\tTime\t{names}\t\t\n\t{axes}\n\n"
    );
    for i in 0..FRAMES {
        let _ = write!(text, "{}\t{}", i + 1, i as f64 / 50.0);
        places(i).iter().flatten().for_each(|v| {
            let _ = write!(text, "\t{v:.3}");
        });
        text.push('\n');
    }
    text
}

/// The same as a table of points with a gap.
pub fn tsv() -> String {
    let mut text =
        format!("NO_OF_FRAMES\t{FRAMES}\nFREQUENCY\t50\nMARKER_NAMES\t{}\n", MARKERS.join("\t"));
    for i in 0..FRAMES {
        let _ = write!(text, "{i}\t{}", i as f64 / 50.0);
        for (k, place) in places(i).iter().enumerate() {
            for v in place {
                let is_gap = i == 5 && k == 7;
                let _ = if is_gap { write!(text, "\t") } else { write!(text, "\t{v:.3}") };
            }
        }
        text.push('\n');
    }
    text
}

/// The same as C3D, of numbers with a point or of whole numbers.
pub fn c3d(is_float: bool) -> Vec<u8> {
    const BLOCK: usize = 512;
    let record = |name: &str, group: i8, content: &[u8], is_last: bool| -> Vec<u8> {
        let step = if is_last { 0 } else { 2 + content.len() as u16 };
        let head = [&[name.len() as u8, group.cast_unsigned()], name.as_bytes()].concat();
        [&head, &step.to_le_bytes()[..], content].concat()
    };
    let scale: f32 = if is_float { -0.1 } else { 0.1 };
    let mut header = vec![2, 0x50];
    for word in [8, 0, 1, FRAMES as u16, 0] {
        header.extend_from_slice(&word.to_le_bytes());
    }
    header.extend_from_slice(&scale.to_le_bytes());
    for word in [3_u16, 0] {
        header.extend_from_slice(&word.to_le_bytes());
    }
    header.extend_from_slice(&50_f32.to_le_bytes());
    header.resize(BLOCK, 0);
    let mut parameters = vec![1, 0x50, 1, 84];
    parameters.extend(record("POINT", -1, &[0], false));
    parameters.extend(record(
        "RATE",
        1,
        &[&[4, 0][..], &50_f32.to_le_bytes(), &[0]].concat(),
        false,
    ));
    parameters.extend(record("UNITS", 1, &[&[0xFF, 1, 2][..], b"mm", &[0]].concat(), false));
    let labels = MARKERS.map(|m| format!("{m:4}")).concat();
    let labels = [&[0xFF, 2, 4, 8][..], labels.as_bytes(), &[0]].concat();
    parameters.extend(record("LABELS", 1, &labels, true));
    parameters.resize(BLOCK, 0);
    let mut bytes = [header, parameters].concat();
    for i in 0..FRAMES {
        for v in places(i).iter().flat_map(|p| [p[0], p[1], p[2], 0.0]) {
            if is_float {
                bytes.extend((v as f32).to_le_bytes());
            } else {
                bytes.extend(((v / f64::from(scale)).round() as i16).to_le_bytes());
            }
        }
    }
    bytes
}

pub fn mvnx() -> String {
    let segments = ["Pelvis", "T8", "RightShoulder", "RightUpperArm", "RightForeArm", "RightHand"];
    let at = |label: &str, p: &str| format!("<point label=\"{label}\"><pos_s>{p}</pos_s></point>");
    let points = |segment: &str| match segment {
        "T8" => at("jRightT4Shoulder", "0 -0.03 0.08"),
        "RightShoulder" => at("jRightT4Shoulder", "0 0 0") + &at("jRightShoulder", "0 -0.14 0"),
        "RightUpperArm" => at("jRightShoulder", "0 0 0") + &at("jRightElbow", "0 -0.3 0"),
        "RightForeArm" => at("jRightElbow", "0 0 0") + &at("jRightWrist", "0 -0.25 0"),
        "RightHand" => at("jRightWrist", "0 0 0"),
        _ => String::new(),
    };
    let listed: String = segments
        .map(|s| {
            format!("<segment label=\"{s}\" id=\"1\"><points>{}</points></segment>\n", points(s))
        })
        .concat();
    let mut frames = String::new();
    for i in -1..8 {
        // Upright, the arm hanging and the elbow bent by some turn about the axis to the left.
        let half = -0.05 * f64::from(i + 1);
        let bent = format!("{} 0 {} 0", half.cos(), half.sin());
        let turns = ["1 0 0 0"; 4].join(" ") + &format!(" {bent} {bent}");
        let places = "0 0 0.95 0 0 1.3 0 0 1.4 0 -0.17 1.4 0 -0.17 1.1 0 -0.17 0.85";
        let kind = if i < 0 { "npose" } else { "normal" };
        let _ = writeln!(
            frames,
            "<frame time=\"{}\" index=\"{i}\" type=\"{kind}\">\n<orientation>{turns}</orientation>\
             <position>{places}</position></frame>",
            i * 10
        );
    }
    format!(
        "<?xml version=\"1.0\"?>\n<mvnx version=\"3\"><comment>made up</comment>\n<subject label=\"a\" frameRate=\"100\" \
         segmentCount=\"{}\">\n<segments>{listed}</segments>\n<frames>{frames}</frames></subject></mvnx>\n",
        segments.len()
    )
}

pub fn bvh() -> String {
    let turns = "CHANNELS 3 Zrotation Xrotation Yrotation";
    let mut text = format!(
        "HIERARCHY\nROOT Hips\n{{\nOFFSET 0 0 0\n\
         CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n\
         JOINT Chest\n{{\nOFFSET 0 20 0\n{turns}\nJOINT Head\n{{\nOFFSET 0 32 0\nEnd Site\n{{\nOFFSET 0 15 0\n}}\n}}\n"
    );
    for (side, sign) in [("Left", 1.0), ("Right", -1.0)] {
        for (joint, x, y) in [
            ("Collar", 3.0, 20.0),
            ("Shoulder", 14.0, 0.0),
            ("Elbow", 28.0, 0.0),
            ("Wrist", 25.0, 0.0),
        ] {
            let _ = writeln!(text, "JOINT {side}{joint}\n{{\nOFFSET {} {y} 0\n{turns}", sign * x);
        }
        let _ = writeln!(text, "End Site\n{{\nOFFSET {} 0 0\n}}\n}}\n}}\n}}\n}}", sign * 8.0);
    }
    let _ = write!(text, "}}\n}}\nMOTION\nFrames: {FRAMES}\nFrame Time: 0.02\n");
    for i in 0..FRAMES {
        let raised = 3.0 * i as f64;
        let arms = format!("0 0 0 -75 0 0 0 0 0 0 0 0 0 0 0 75 0 {raised} 0 0 {raised} 0 0 0");
        let _ = writeln!(text, "0 95 0 0 0 0 0 0 0 {arms}");
    }
    text
}

/// Bone, parent, from end to end, and the axes about which it turns.
const BONES: [(&str, &str, [f64; 3], &str); 28] = [
    ("lhipjoint", "root", [0.075, -0.1, 0.0], ""),
    ("lfemur", "lhipjoint", [0.0, -0.4, 0.0], "rx ry rz"),
    ("ltibia", "lfemur", [0.0, -0.4, 0.0], "rx"),
    ("lfoot", "ltibia", [0.0, -0.05, 0.12], "rx rz"),
    ("ltoes", "lfoot", [0.0, 0.0, 0.06], "rx"),
    ("rhipjoint", "root", [-0.075, -0.1, 0.0], ""),
    ("rfemur", "rhipjoint", [0.0, -0.4, 0.0], "rx ry rz"),
    ("rtibia", "rfemur", [0.0, -0.4, 0.0], "rx"),
    ("rfoot", "rtibia", [0.0, -0.05, 0.12], "rx rz"),
    ("rtoes", "rfoot", [0.0, 0.0, 0.06], "rx"),
    ("lowerback", "root", [0.0, 0.12, 0.0], "rx ry rz"),
    ("upperback", "lowerback", [0.0, 0.12, 0.0], "rx ry rz"),
    ("thorax", "upperback", [0.0, 0.12, 0.0], "rx ry rz"),
    ("lowerneck", "thorax", [0.0, 0.05, 0.0], "rx ry rz"),
    ("upperneck", "lowerneck", [0.0, 0.05, 0.0], "rx ry rz"),
    ("head", "upperneck", [0.0, 0.1, 0.0], "rx ry rz"),
    ("lclavicle", "thorax", [0.15, 0.0, 0.0], "ry rz"),
    ("lhumerus", "lclavicle", [0.3, 0.0, 0.0], "rx ry rz"),
    ("lradius", "lhumerus", [0.2, 0.0, 0.0], "rx"),
    ("lwrist", "lradius", [0.05, 0.0, 0.0], "ry"),
    ("lhand", "lwrist", [0.08, 0.0, 0.0], "rx rz"),
    ("lthumb", "lwrist", [0.06, 0.0, 0.06], ""),
    ("rclavicle", "thorax", [-0.15, 0.0, 0.0], "ry rz"),
    ("rhumerus", "rclavicle", [-0.3, 0.0, 0.0], "rx ry rz"),
    ("rradius", "rhumerus", [-0.2, 0.0, 0.0], "rx"),
    ("rwrist", "rradius", [-0.05, 0.0, 0.0], "ry"),
    ("rhand", "rwrist", [-0.08, 0.0, 0.0], "rx rz"),
    ("rthumb", "rwrist", [-0.06, 0.0, 0.06], ""),
];

/// The turn about z (deg) of the axes of a bone: an elbow bends about its own.
fn axis_deg(bone: &str) -> f64 {
    match bone {
        "lradius" | "rwrist" => -90.0,
        "rradius" | "lwrist" => 90.0,
        _ => 0.0,
    }
}

pub fn asf() -> String {
    let mut text = String::from(
        ":version 1.10\n:name made\n:units\n  mass 1.0\n  length 0.0254\n  angle deg\n:documentation\n  made up\n\
         :root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  orientation 0 0 0\n:bonedata\n",
    );
    let mut links = String::new();
    for (i, (bone, parent, along, dof)) in BONES.iter().enumerate() {
        let length = along.iter().map(|v| v * v).sum::<f64>().sqrt();
        let [x, y, z] = along.map(|v| v / length);
        let _ = write!(
            text,
            "  begin\n  id {i}\n  name {bone}\n  direction {x} {y} {z}\n  length {length}\n  axis 0 0 {} XYZ\n",
            axis_deg(bone)
        );
        if !dof.is_empty() {
            let limits = dof.split(' ').map(|_| "(-180 180)").collect::<Vec<_>>().join("\n  ");
            let _ = write!(text, "  dof {dof}\n  limits {limits}\n");
        }
        text += "  end\n";
        let _ = writeln!(links, "  {parent} {bone}");
    }
    text + ":hierarchy\n  begin\n" + &links + "  end\n"
}

pub fn amc() -> String {
    let mut text = String::from("#!made up\n:FULLY-SPECIFIED\n:DEGREES\n");
    for i in 0..FRAMES {
        let _ = write!(text, "{}\nroot 0 1 0 0 0 0\n", i + 1);
        for (bone, .., dof) in BONES.iter().filter(|b| !b.3.is_empty()) {
            let values: Vec<String> = dof
                .split(' ')
                .map(|_| if *bone == "rradius" { (3 * i).to_string() } else { "0".into() })
                .collect();
            let _ = writeln!(text, "{bone} {}", values.join(" "));
        }
    }
    text
}

pub fn mot() -> String {
    let columns = [
        "pelvis_tilt",
        "pelvis_list",
        "pelvis_rotation",
        "pelvis_tx",
        "pelvis_ty",
        "pelvis_tz",
        "lumbar_extension",
        "arm_flex_r",
        "arm_add_r",
        "arm_rot_r",
        "elbow_flex_r",
        "pro_sup_r",
        "wrist_flex_r",
        "wrist_dev_r",
    ];
    let mut text = format!(
        "Coordinates\nnRows={FRAMES}\ninDegrees=yes\nendheader\ntime\t{}\n",
        columns.join("\t")
    );
    for i in 0..FRAMES {
        let _ = write!(text, "{}", i as f64 / 50.0);
        for column in columns {
            let v = match column {
                "pelvis_ty" => 1.0,
                "elbow_flex_r" => 20.0 + 3.0 * i as f64,
                _ => 0.0,
            };
            let _ = write!(text, "\t{v}");
        }
        text.push('\n');
    }
    text
}

/// Bodies of the shipped map of rigid bodies.
pub fn rigid_bodies() -> impl Iterator<Item = &'static str> {
    RIGID_BODIES.lines().filter_map(|l| l.strip_prefix("body = \"")?.strip_suffix('"'))
}

/// One rigid body that stands still.
pub fn rigid_body(at: usize) -> String {
    let row = format!("0.1,{:.2},1,0,0,0.7071068,0.7071068\n", 0.1 * at as f64);
    format!("x,y,z,q0,q1,q2,q3\n{}", row.repeat(6))
}

pub fn tcp_csv() -> String {
    let mut text = String::from("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n");
    for i in 0..=20 {
        let t = f64::from(i) / 20.0;
        let s = t * t * (3.0 - 2.0 * t);
        let _ = writeln!(
            text,
            "{},{},{},{},0,1,0,0",
            4.0 * t,
            0.42 + 0.03 * s,
            -0.35 + 0.6 * s,
            0.95 + 0.3 * s
        );
    }
    text
}

pub fn joints_csv() -> String {
    let mut text = String::from("time_s");
    (1..=7).for_each(|j| {
        let _ = write!(text, ",panda_joint{j}_rad");
    });
    for i in 0..=20 {
        let s = 0.01 * f64::from(i);
        let _ = write!(text, "\n{},{s},{},0,{},0,1.8,0.7", 0.2 * f64::from(i), -0.5 + s, -2.2 + s);
    }
    text + "\n"
}

/// A `JointTrajectory` of the Panda as JSON.
pub fn trajectory_json() -> String {
    let names: Vec<String> = (1..=7).map(|j| format!("panda_joint{j}")).collect();
    let points: Vec<serde_json::Value> = (0..6)
        .map(|i| {
            let s = 0.02 * f64::from(i);
            serde_json::json!({
                "positions": [s, -0.5 + s, 0.0, -2.2 + s, 0.0, 1.8, 0.7],
                "velocities": vec![0.0; 7], "accelerations": vec![0.0; 7],
                "time_from_start": {"sec": i / 2, "nanosec": 500_000_000 * (i % 2)},
            })
        })
        .collect();
    serde_json::json!({"joint_names": names, "points": points}).to_string()
}

pub fn trajectory_yaml() -> String {
    let mut text = String::from(
        "joint_trajectory:\n  header:\n    stamp: {sec: 0, nanosec: 0}\n    frame_id: base\n  joint_names:\n",
    );
    for j in 1..=7 {
        let _ = writeln!(text, "  - panda_joint{j}");
    }
    text += "  points:\n";
    for i in 0..4 {
        let _ = writeln!(
            text,
            "  - positions: [{}, -0.5, 0.0, -2.2, 0.0, 1.8, 0.7]\n    velocities: [0, 0, 0, 0, 0, 0, 0]\n    \
             time_from_start:\n      sec: {i}\n      nanosec: 0",
            0.02 * f64::from(i)
        );
    }
    text + "---\n"
}

/// Six faces of a box of some size, two triangles each.
fn faces() -> Vec<[[f32; 3]; 3]> {
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let corner =
        |c: usize| [0, 1, 2].map(|axis| if c >> axis & 1 == 0 { 0.0 } else { 200.0 + axis as f32 });
    let two = |f: [usize; 4]| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]];
    quads.into_iter().flat_map(two).map(|t| t.map(corner)).collect()
}

pub fn stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((faces().len() as u32).to_le_bytes());
    for face in faces() {
        bytes.extend([0u8; 12]);
        bytes.extend(face.iter().flatten().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0u8; 2]);
    }
    bytes
}

pub fn stl_text() -> String {
    let mut text = String::from("solid made\n");
    for face in faces() {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in face {
            let _ = writeln!(text, "  vertex {x} {y} {z}");
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid\n"
}

pub fn obj() -> String {
    let mut text = String::from("# made up\no box\n");
    for [x, y, z] in faces().into_iter().flatten() {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for i in 0..faces().len() {
        let _ = writeln!(text, "f {}/1/1 {} {}", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    text + "f -1 -2 -3\n"
}

fn gltf_json(buffer: &str) -> (String, Vec<u8>) {
    let places: Vec<u8> =
        faces().iter().flatten().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let count = 3 * faces().len();
    let mut data = places.clone();
    data.extend((0..count as u32).flat_map(u32::to_le_bytes));
    let (first, rest, all) = (places.len(), data.len() - places.len(), data.len());
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"children":[1],"rotation":[0,0,0,1]}},{{"mesh":0,"translation":[1,0,0],"scale":[0.001,0.001,0.001]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":4}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3","min":[0,0,0],"max":[200,201,202]}},
{{"bufferView":1,"componentType":5125,"count":{count},"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{first}}},{{"buffer":0,"byteOffset":{first},"byteLength":{rest}}}],
"buffers":[{{"byteLength":{all}{buffer}}}]}}"#
    );
    (json, data)
}

pub fn glb() -> Vec<u8> {
    let (mut json, data) = gltf_json("");
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((28 + json.len() as u32 + data.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(data);
    bytes
}

pub fn gltf() -> String {
    use base64::Engine as _;
    let data = base64::engine::general_purpose::STANDARD.encode(gltf_json("").1);
    gltf_json(&format!(r#","uri":"data:application/octet-stream;base64,{data}""#)).0
}

pub const DAE: &str = r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="f" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
<technique_common><accessor source="#f" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="1"/>
<vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_nodes><node id="part"><matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node></library_nodes>
<library_visual_scenes><visual_scene id="w"><node id="n"><translate>10 0 0</translate><rotate>0 0 1 90</rotate><scale>1 1 1</scale>
<instance_geometry url="#g"/><node id="m"><instance_node url="#part"/></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>
"##;

/// A scenario that names files and frees what may be free.
pub fn rich_scenario() -> String {
    let (before, rest) = BENCH.split_once("[[obstacle]]").expect("an obstacle");
    let (obstacle, task) = rest.split_once("[task]").expect("a task");
    format!(
        "{before}[[robot.limit]]\njoint = \"panda_joint2\"\nlower_rad = -1.7\nvelocity_rad_s = 1.5\n\
         [[obstacle]]{obstacle}[[obstacle]]\nname = \"part\"\nshape = \"mesh\"\nfile = \"part.stl\"\nunits = \"mm\"\n\
         position_m = [0.9, 0.5, 0.1]\nrpy_deg = [0, 0, 10]\n[[obstacle]]\nname = \"post\"\nshape = \"cylinder\"\n\
         position_m = [0.9, -0.9, 0.5]\nradius_m = 0.05\nlength_m = 1.0\npointing = [0, 0, 1]\n\
         [[obstacle]]\nname = \"rail\"\nshape = \"capsule\"\nfrom_m = [1.2, -1, 1]\nto_m = [1.2, 1, 1]\nradius_m = 0.03\n\
         [[path]]\nname = \"today\"\nfile = \"today.csv\"\n\
         [[path]]\nname = \"over\"\nvia_m = [[0.45, 0.0, 1.2]]\n\
         [free]\ngoal_box_m = [0.05, 0.05, 0.1]\nstart_yaw_deg = [-20, 20]\n[task]{task}"
    )
}

/// A few rows of a chain of three joints and a place.
pub fn data_csv() -> String {
    let mut text = String::from("traj,q0,q1,q2,xdot0,xdot1,xdot2,qdot0,qdot1,qdot2\n");
    for i in 0..40 {
        let a = 0.02 * f64::from(i);
        let _ = writeln!(text, "{},{a},{},{},0.1,0,{},0.1,0.2,0.05", i / 20, 0.2 + a, -a, 0.01 * a);
    }
    text
}

pub const PEOPLE: &str = "schema = \"ergopath/people/1\"\n[[person]]\nname = \"p1\"\nrecordings = [\"*.tsv\", \"lift.bvh\"]\n\
     map = \"map.toml\"\nside = \"right\"\n[[person]]\nname = \"p2\"\nrecordings = [\"l[a-z]ft.tsv\"]\nbody = \"male_p50\"\n";

pub const SHIFT: &str = "schema = \"ergopath/shift/1\"\n[shift]\nname = \"Day\"\ndescription = \"made up\"\nminutes = 480\norder = \"mixed\"\n\
     [[break]]\nname = \"lunch\"\nminutes = 30\n[[task]]\nname = \"parts\"\nresult = \"run\"\nminutes = 100\ncycles = 100\n\
     omni_res = [2, 4]\nexertions = 2\n[[task]]\nname = \"crates\"\nresult = \"scored\"\nside = \"right\"\nshare = 0.3\n";

pub const BATCH: &str = "schema = \"ergopath/batch/1\"\nname = \"Layouts\"\ndescription = \"made up\"\nmode = \"plan\"\nscenarios = [\"bench.toml\"]\n\
     planners = [\"quick\", \"tiny.toml\"]\nseeds = [1, 2]\n[matrix]\nworker.bodies = [[\"female_p05\"], [\"male_p95\"]]\n\
     motion.duration_s = [4.0, 5.0]\n[variant.layout.as_built]\n[variant.layout.nearer]\nworker.at_m = [0.10, 0.0]\n\
     [[exclude]]\nlayout = \"nearer\"\nseed = 2\n";

/// The plan of the batch.
pub fn manifest() -> String {
    use ergopath::batch::{Jobs, Manifest, read_batch};
    let room = tempfile::tempdir().expect("a folder");
    for (name, text) in [("batch.toml", BATCH), ("bench.toml", BENCH), ("tiny.toml", TINY)] {
        std::fs::write(room.path().join(name), text).expect("written");
    }
    let batch = read_batch(&room.path().join("batch.toml")).expect("a batch");
    let jobs = Jobs::of(&batch).expect("jobs");
    let (_, bytes) = Manifest::of(&batch, &jobs).and_then(|m| m.file()).expect("a plan");
    String::from_utf8(bytes).expect("JSON")
}
