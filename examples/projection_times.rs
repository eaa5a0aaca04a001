//! How long the projection of `ErgoBench`'s candidates takes: medians over 60 random paths.
//!
//! ```text
//! cargo run --release --example projection_times
//! ```
//! Six workstations (seed 1000), ten whitened paths of random pace each, T = 100, one core: the program for the TCP's
//! positions among the obstacles, and the whole loop with the Panda's inverse kinematics and rows.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program says what it found")]

use ergopath::ergobench::{Family, draw};
use ergopath::math::stream::{Purpose, normals, stream};
use ergopath::path::{
    Arm, Followed, Pace, Projection, ProjectionSettings, Scene, ViaSpace, project_for_arm,
    project_within, reference_path,
};
use ergopath::robot::{FollowSettings, start_postures};
use ergopath::scenario::read_scenario;
use std::time::Instant;

const PATHS: u32 = 10;
const SEED: u64 = 1000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let room = tempfile::tempdir()?;
    let (mut program, mut whole, mut with_rows) = (Vec::new(), Vec::new(), Vec::new());
    let (mut no_path, mut no_motion) = (0, 0);
    for family in Family::ALL.into_iter().filter(|f| !f.is_whole()) {
        let mut rng = stream(SEED, Purpose::Simulation, 20, family as u32 * 1000);
        let station = draw(family, 0, &mut rng);
        let file = room.path().join("scenario.toml");
        std::fs::write(&file, station.scenario("male_p50", "demo_operator", SEED))?;
        let s = read_scenario(&file)?;
        let settings = ProjectionSettings { steps: 100, ..Default::default() };
        let follow = FollowSettings { seed: SEED, ..FollowSettings::default() };
        let starts = start_postures(&s.robot, &s.start, &follow).postures;
        let scene = Scene { obstacles: &s.obstacles, ..Scene::default() };
        let Some(space) = ViaSpace::new(3, &s.start, &s.goal, 0.15) else { continue };
        for k in 0..PATHS {
            // Via-points and pace as the default planner draws them.
            let x = normals(&mut stream(SEED, Purpose::Search, 0, k), space.dimension() + 3);
            let (vias, pace) = x.split_at(space.dimension());
            let mut candidate = space.decode("c", vias);
            candidate.pace = Some(Pace::of_white(pace, 1.0));
            let path = reference_path(&candidate, &s.start, &s.goal, s.duration_s, 100)?;
            let from = Instant::now();
            let projection = project_within(&path, &s.limits, &scene, &settings);
            program.push(from.elapsed().as_secs_f64());
            no_path += usize::from(!matches!(projection, Projection::Feasible { .. }));
            let arm = Arm { robot: &s.robot, starts: &starts, settings: &follow };
            let from = Instant::now();
            let followed = project_for_arm(&path, &s.limits, &scene, &settings, &arm);
            let took = from.elapsed().as_secs_f64();
            whole.push(took);
            match followed {
                Followed::Feasible { passes: 0, .. } => {}
                Followed::Feasible { .. } => with_rows.push(took),
                _ => no_motion += 1,
            }
        }
    }
    println!("{} paths; {no_path} without a path, {no_motion} the arm cannot follow", whole.len());
    for (name, times) in [
        ("positions among obstacles", &mut program),
        ("with the robot", &mut whole),
        ("of these, with robot rows", &mut with_rows),
    ] {
        times.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let last = times.len().saturating_sub(1);
            times.get((share * last as f64).round() as usize).map_or(f64::NAN, |t| 1e3 * t)
        };
        let (median, p90, most) = (at(0.5), at(0.9), at(1.0));
        println!(
            "{name:28} n {:3}  median {median:7.2} ms  p90 {p90:7.2} ms  largest {most:7.2} ms",
            times.len()
        );
    }
    Ok(())
}
