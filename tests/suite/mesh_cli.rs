//! Obstacles and robots from CAD, as a user meets them.

use crate::common::{ergopath, plan, workplace};
use ergopath::scenario::read_scenario;
use std::path::Path;

/// A box as binary STL, in the numbers given.
fn stl(boxes: &[([f32; 3], [f32; 3])]) -> Vec<u8> {
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut bytes = vec![b' '; 80];
    bytes.extend((12 * boxes.len() as u32).to_le_bytes());
    for (low, high) in boxes {
        for f in faces {
            for t in [[f[0], f[1], f[2]], [f[0], f[2], f[3]]] {
                bytes.extend([0u8; 12]);
                for corner in t {
                    for axis in 0..3 {
                        let v = if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
                        bytes.extend(v.to_le_bytes());
                    }
                }
                bytes.extend([0u8; 2]);
            }
        }
    }
    bytes
}

/// The bench of the shipped cell, in millimetres about its middle.
fn bench() -> Vec<u8> {
    stl(&[([-400.0, -800.0, -360.0], [400.0, 800.0, 360.0])])
}

/// The small workplace with its bench replaced by what `obstacle` says.
fn with_obstacle(file: &Path, obstacle: &str) {
    let text = std::fs::read_to_string(file).unwrap();
    let (before, rest) = text.split_once("[[obstacle]]").unwrap();
    let (_, after) = rest.split_once("[task]").unwrap();
    std::fs::write(
        file,
        format!("{before}[[obstacle]]\nname = \"bench\"\n{obstacle}\n[task]{after}"),
    )
    .unwrap();
}

const MESH: &str =
    "shape = \"mesh\"\nfile = \"bench.stl\"\nunits = \"mm\"\nposition_m = [0.75, 0.0, 0.36]\n";

#[test]
fn a_mesh_of_a_box_is_that_box() {
    let (room, simple) = workplace();
    let file = room.path().join("mesh.toml");
    std::fs::copy(&simple, &file).unwrap();
    std::fs::write(room.path().join("bench.stl"), bench()).unwrap();
    with_obstacle(&file, MESH);
    let [simple, mesh] = [&simple, &file].map(|f| read_scenario(f).unwrap());
    assert_eq!((mesh.meshes.len(), mesh.obstacles.len()), (1, 1));
    for i in 0..300 {
        let at = |n: i32| f64::from(n) / 10.0 - 0.5;
        let p = nalgebra::Vector3::new(at(i % 21), at(i % 17), at(i % 13));
        let [a, b] = [&simple, &mesh].map(|s| s.obstacles[0].1.signed_distance(&p));
        assert!((a - b).abs() < 3e-4, "{p}: {a} and {b}");
    }
}

/// A corner of two plates that no mirror or turn maps on to itself.
fn corner(side: f32) -> Vec<u8> {
    let plate = |low: [f32; 3], high: [f32; 3]| {
        let ([_, a, _], [_, b, _]) = (low, high);
        let (a, b) = (side * a, side * b);
        ([low[0], a.min(b), low[2]], [high[0], a.max(b), high[2]])
    };
    stl(&[
        plate([0.0, 0.0, 0.0], [600.0, 400.0, 30.0]),
        plate([0.0, 0.0, 40.0], [40.0, 400.0, 500.0]),
    ])
}

#[test]
fn meshes_move_and_mirror_with_the_cell() {
    let (room, scenario) = workplace();
    let text = std::fs::read_to_string(&scenario).unwrap();
    let read = |side: f32, position: [f64; 3], yaw: f64| {
        std::fs::write(&scenario, &text).unwrap();
        std::fs::write(room.path().join("bench.stl"), corner(side)).unwrap();
        let place = format!("position_m = {position:?}\nrpy_deg = [10, 0, {yaw}]\n");
        let file = "shape = \"mesh\"\nfile = \"bench.stl\"\nunits = \"mm\"\n";
        with_obstacle(&scenario, &format!("{file}{place}"));
        let all = read_scenario(&scenario).unwrap().obstacles;
        assert_eq!(all.len(), 2, "two bodies");
        move |p: [f64; 3]| {
            let of = |o: &(String, ergopath::robot::Obstacle)| o.1.signed_distance(&p.into());
            all.iter().map(of).fold(f64::INFINITY, f64::min)
        }
    };
    let here = read(1.0, [0.9, 0.2, 0.1], 20.0);
    // A quarter turn to the left about the origin; and the other side of the plane y = 0, where a roll about
    // x turns the other way.
    let turned = read(1.0, [-0.2, 0.9, 0.1], 110.0);
    for i in 0..200 {
        let at = |n: i32| f64::from(n) / 8.0 - 0.6;
        let [x, y, z] = [at(i % 19), at(i % 17), at(i % 13)];
        let (a, b) = (here([x, y, z]), turned([-y, x, z]));
        assert!((a - b).abs() < 1e-9, "turned: {a} and {b}");
    }
    let level = |side, position, yaw: f64| {
        let found = read(side, position, yaw);
        move |p| found(p)
    };
    let (left, right) = (level(1.0, [0.9, 0.2, 0.1], 0.0), level(-1.0, [0.9, -0.2, 0.1], 0.0));
    for i in 0..200 {
        let at = |n: i32| f64::from(n) / 8.0 - 0.6;
        let [x, y, z] = [at(i % 19), at(i % 17), at(i % 13)];
        // Rolled by 10 deg about x: in the mirror by -10, which the point undoes.
        let (sin, cos) = 20f64.to_radians().sin_cos();
        let (v, w) = (-y + 0.2, z - 0.1);
        let (a, b) =
            (left([x, y, z]), right([x, v * cos - w * sin - 0.2, v * sin + w * cos + 0.1]));
        assert!((a - b).abs() < 1e-6, "mirrored: {a} and {b}");
    }
}

#[test]
fn a_plan_among_meshes_draws_them_and_records_their_files() {
    let (room, scenario) = workplace();
    // A table with four legs, whose underside is free.
    let leg = |x: f32, y: f32| ([x, y, 0.0], [x + 60.0, y + 60.0, 680.0]);
    let table = [
        ([0.0, 0.0, 680.0], [800.0, 1600.0, 720.0]),
        leg(0.0, 0.0),
        leg(740.0, 0.0),
        leg(0.0, 1540.0),
        leg(740.0, 1540.0),
    ];
    std::fs::write(room.path().join("bench.stl"), stl(&table)).unwrap();
    with_obstacle(&scenario, &MESH.replace("[0.75, 0.0, 0.36]", "[0.35, -0.8, 0.0]"));
    let found = ergopath().arg("check").arg(&scenario).assert().success();
    let text = String::from_utf8_lossy(&found.get_output().stdout).into_owned();
    assert!(text.contains("obstacle `bench` from bench.stl (60 triangles, in mm)"), "{text}");
    assert!(text.contains("5 convex parts hold it"), "{text}");
    plan(&room, &scenario, "out").assert().success();
    let result = std::fs::read_to_string(room.path().join("out/result.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&result).unwrap();
    let inputs = result["provenance"]["inputs"].as_array().unwrap();
    assert!(inputs.iter().any(|i| i[0] == "bench.stl"), "{inputs:?}");
    assert_eq!(result["setting"]["obstacles"].as_array().unwrap().len(), 1);
    let drawn = &result["scene"]["obstacles"][0];
    assert_eq!(
        (drawn["shape"].as_str(), drawn["triangles"].as_array().unwrap().len()),
        (Some("mesh"), 60)
    );
    let best = result["candidates"].as_array().unwrap().iter().find(|c| c["rank"] == 1).unwrap();
    assert_eq!(best["path"]["clearance"]["nearest"]["obstacle"], "bench");
    let page = std::fs::metadata(room.path().join("out/report.html")).unwrap().len();
    assert!(page < 8_000_000, "{page}");
}

#[test]
fn what_cannot_be_a_mesh_is_refused_with_the_place_and_a_remedy() {
    let (room, scenario) = workplace();
    let text = std::fs::read_to_string(&scenario).unwrap();
    let refused = |name: &str, bytes: &[u8], more: &str| {
        std::fs::write(&scenario, &text).unwrap();
        std::fs::write(room.path().join(name), bytes).unwrap();
        with_obstacle(&scenario, &format!("shape = \"mesh\"\nfile = \"{name}\"\n{more}"));
        let found = ergopath().arg("check").arg(&scenario).assert().failure();
        let output = found.get_output();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!said.contains("panicked"), "{said}");
        assert!(said.contains("bench.toml") && said.contains("help:"), "{said}");
        // Without the frame that the error is shown in.
        said.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ")
    };
    let whole = bench();
    let said = refused("a.stl", &whole, "");
    assert!(said.contains("does not say its unit: in mm it is 0.80 x 1.60 x 0.72 m"), "{said}");
    let said = refused("a.stl", &whole, "units = \"m\"");
    assert!(said.contains("is 1600 m long with units = \"m\": is it in mm?"), "{said}");
    let said = refused("a.stl", &stl(&[([0.0; 3], [1.2, 0.8, 0.7])]), "units = \"mm\"");
    assert!(said.contains("0.00120 m long with units = \"mm\": is it in m?"), "{said}");
    let said = refused("a.stl", &whole[..500], "units = \"mm\"");
    assert!(said.contains("is cut short: it says 12 triangles and holds 8"), "{said}");
    assert!(refused("a.stl", &stl(&[]), "units = \"mm\"").contains("holds no triangle"));
    assert!(refused("a.step", b"ISO-10303-21;", "").contains("convert it to STL or glTF"));
    assert!(refused("a.stl", &whole, "units = \"yd\"").contains("unknown variant"));
    assert!(refused("a.stl", &whole, "unit = \"mm\"").contains("did you mean `units`?"));
    std::fs::remove_file(room.path().join("a.stl")).unwrap();
    std::fs::create_dir(room.path().join("a.stl")).unwrap();
    std::fs::write(&scenario, &text).unwrap();
    with_obstacle(&scenario, "shape = \"mesh\"\nfile = \"a.stl\"\nunits = \"mm\"");
    ergopath().arg("check").arg(&scenario).assert().failure();
}

/// A wall across the arm of a robot whose meshes are not there.
#[test]
fn a_robot_without_its_meshes_is_never_said_to_be_clear() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (room, scenario) = workplace();
    let text = std::fs::read_to_string(&scenario).unwrap();
    let (before, rest) = text.split_once("[robot]").unwrap();
    let (_, after) = rest.split_once("[start]").unwrap();
    std::fs::copy(root.join("docs/cells/mesh_robot.urdf"), room.path().join("robot.urdf")).unwrap();
    let robot = "[robot]\nurdf = \"robot.urdf\"\nbase_link = \"base_link\"\ntcp = \"tool0\"\n\
                 base = { position_m = [1.15, -0.2, 0.75], rpy_deg = [0, 0, 180] }\n\n";
    let bare = format!("{before}{robot}[start]{after}");
    std::fs::write(&scenario, &bare).unwrap();
    let checked = |code: Option<i32>| {
        let found = ergopath().arg("check").arg(&scenario).assert();
        let output = found.get_output();
        if let Some(code) = code {
            assert_eq!(output.status.code(), Some(code), "{output:?}");
        }
        let all = [&output.stdout[..], &output.stderr[..]].concat();
        String::from_utf8_lossy(&all).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let said = checked(None);
    assert!(said.contains("the robot's real shape is not checked"), "{said}");
    assert!(
        said.contains(
            "assumed capsules, 81 mm about the lines from joint to joint, were checked instead"
        ),
        "{said}"
    );
    with_obstacle(
        &scenario,
        "shape = \"box\"\nposition_m = [0.85, -0.1, 1.0]\nsize_m = [0.05, 2.0, 2.0]",
    );
    let said = checked(None);
    assert!(said.contains("obstacle `bench`"), "{said}");
    assert!(!said.contains("all kept"), "{said}");
    let found = plan(&room, &scenario, "out").assert();
    let said = String::from_utf8_lossy(&found.get_output().stdout).into_owned();
    assert!(!said.contains("all kept") || said.contains("assumed capsules"), "{said}");
}
