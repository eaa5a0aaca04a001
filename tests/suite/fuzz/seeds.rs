//! Valid files for each reader, from what ships and what is made up: where fuzzing begins.

#![allow(dead_code, unreachable_pub, reason = "programs that share this file use parts of it")]

use super::made;
use ergopath::ergonomics::Worksheet;
use ergopath::human::{BodySize, Sex, generate};

/// How a file is changed with a sense of what it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Toml,
    Json,
    Xml,
    Yaml,
    /// Words in lines.
    Text,
    /// Cells in lines.
    Table,
    Binary,
}

/// A kind of file, and files of it by name.
pub type Seeds = (Kind, Vec<(&'static str, Vec<u8>)>);

fn texts(kind: Kind, all: Vec<(&'static str, String)>) -> Seeds {
    (kind, all.into_iter().map(|(name, text)| (name, text.into_bytes())).collect())
}

fn one(kind: Kind, name: &'static str, text: String) -> Seeds {
    texts(kind, vec![(name, text)])
}

/// What a reader of this name reads, and files that it accepts.
pub fn seeds(target: &str) -> Seeds {
    let body = || {
        let size = BodySize { sex: Sex::Female, stature_m: 1.63, mass_kg: 66.0 };
        generate("anna", size).expect("a body")
    };
    match target {
        "scenario" => texts(
            Kind::Toml,
            [
                ("rich", made::rich_scenario()),
                ("bench", made::BENCH.to_owned()),
                ("low_bin", include_str!("../../../scenarios/low_bin.toml").to_owned()),
                ("seated", include_str!("../../../scenarios/seated_left.toml").to_owned()),
            ]
            .to_vec(),
        ),
        "scenario_plan" => texts(
            Kind::Toml,
            vec![("rich", made::rich_scenario()), ("bench", made::BENCH.to_owned())],
        ),
        "planner" => texts(
            Kind::Toml,
            vec![
                ("tiny", made::TINY.to_owned()),
                ("tail", include_str!("../../../planners/tail.toml").to_owned()),
            ],
        ),
        "batch" => one(Kind::Toml, "layouts", made::BATCH.to_owned()),
        "shift" => one(Kind::Toml, "day", made::SHIFT.to_owned()),
        "people" => one(Kind::Toml, "two", made::PEOPLE.to_owned()),
        "map" => texts(
            Kind::Toml,
            vec![
                ("made", made::MAP.to_owned()),
                ("opensim", include_str!("../../../models/maps/opensim.toml").to_owned()),
                ("gait", include_str!("../../../models/maps/plug_in_gait.toml").to_owned()),
            ],
        ),
        "gate" => {
            one(Kind::Text, "bounds", "p_rula_ge_5<0.1 and  rula_peak <= 6 AND rank == 1".into())
        }
        "model" => texts(
            Kind::Json,
            vec![
                (
                    "whole",
                    made::opened(include_str!("../../../models/posture/whole_operator.json")),
                ),
                ("demo", made::opened(include_str!("../../../models/posture/demo_operator.json"))),
            ],
        ),
        "result" => one(Kind::Json, "bench", made::RAN.result.clone()),
        "unfinished" => one(Kind::Json, "bench", made::RAN.unfinished.clone()),
        "manifest" => one(Kind::Json, "layouts", made::manifest()),
        "summary" => one(Kind::Json, "motion", made::SUMMARY.to_owned()),
        "body_sheet" => one(Kind::Toml, "anna", body().sheet),
        "body_urdf" => one(Kind::Xml, "anna", body().urdf),
        "robot" => texts(
            Kind::Xml,
            vec![
                ("arm", made::ARM.to_owned()),
                ("ur5e", include_str!("../../../models/robot/ur5e.urdf").to_owned()),
            ],
        ),
        other => of_measured(other),
    }
}

/// Of recordings, tables, trajectories and meshes.
fn of_measured(target: &str) -> Seeds {
    match target {
        "mvnx" => one(Kind::Xml, "made", made::mvnx()),
        "bvh" => one(Kind::Text, "made", made::bvh()),
        "asf" => one(Kind::Text, "made", made::asf()),
        "amc" => one(Kind::Text, "made", made::amc()),
        "c3d" => (Kind::Binary, vec![("floats", made::c3d(true)), ("whole", made::c3d(false))]),
        "trc" => one(Kind::Table, "made", made::trc()),
        "opensim" => one(Kind::Table, "made", made::mot()),
        "points" => one(Kind::Table, "made", made::tsv()),
        "rigid_body" => one(Kind::Table, "chest", made::rigid_body(2)),
        "path_csv" => {
            let decimal = made::tcp_csv().replace(',', ";").replace('.', ",");
            texts(
                Kind::Table,
                vec![("tcp", made::tcp_csv()), ("joints", made::joints_csv()), ("semicolons", decimal)],
            )
        }
        "motion_csv" => {
            let shipped = include_str!("../../../scenarios/demonstrations/simulated_operator.csv");
            // Comments, header and the first moment of the first reach.
            one(Kind::Table, "reach", shipped.lines().take(45).collect::<Vec<_>>().join("\n"))
        }
        "data_csv" => one(Kind::Table, "rows", made::data_csv()),
        "quality_csv" => one(
            Kind::Table,
            "import",
            "motion,file,run,segment,constant_mm,scatter_median_mm,scatter_p95_mm,constant_deg,scatter_median_deg,scatter_p95_deg\n\
             a,a.csv,1,RightHand,1.0,2.0,3.5,0.5,1.0,2.0\na,a.csv,1,T8,1,2,3,0,1,2\n"
                .into(),
        ),
        "worksheets" => {
            let header = Worksheet::COLUMNS.join(",");
            let zeros = vec!["0"; Worksheet::COLUMNS.len()].join(",");
            one(Kind::Table, "two", format!("name,{header}\na,{zeros}\nb,{zeros}\n"))
        }
        "trajectory_json" => one(Kind::Json, "panda", made::trajectory_json()),
        "trajectory_yaml" => one(Kind::Yaml, "panda", made::trajectory_yaml()),
        "stl" => (
            Kind::Binary,
            vec![("binary", made::stl()), ("text", made::stl_text().into_bytes())],
        ),
        "obj" => one(Kind::Text, "box", made::obj()),
        "gltf" => one(Kind::Json, "box", made::gltf()),
        "glb" => (Kind::Binary, vec![("box", made::glb())]),
        "dae" => one(Kind::Xml, "square", made::DAE.to_owned()),
        other => panic!("no seeds for `{other}`"),
    }
}
