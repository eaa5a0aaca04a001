//! `ergopath watch`: the page follows what is saved, shows what is wrong in it, and is for this machine only.

use crate::common::{assert_refused, ergopath, files, workplace};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How long a loaded machine may take for a plan.
const PATIENCE: Duration = Duration::from_mins(3);

/// A running `watch`; killed where the test ends early.
struct Watch {
    child: Child,
    port: u16,
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Watch {
    fn start(scenario: &Path, more: &[&str]) -> Self {
        let tiny = scenario.with_file_name("tiny.toml");
        let mut child = Command::new(env!("CARGO_BIN_EXE_ergopath"))
            .arg("watch")
            .arg(scenario)
            .args(["--port", "0", "--planner"])
            .arg(tiny)
            .args(more)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let first = lines.next().unwrap().unwrap();
        let port = first.strip_prefix("http://127.0.0.1:").and_then(|p| p.strip_suffix('/'));
        let port = port.unwrap_or_else(|| panic!("{first}")).parse().unwrap();
        // What it says later is read, so that the pipe never fills.
        std::thread::spawn(move || lines.for_each(drop));
        Self { child, port }
    }

    /// Code, headers and body of an answer.
    fn ask(&self, method: &str, path: &str, host: &str) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
        write!(stream, "{method} {path} HTTP/1.0\r\n{host}\r\n").unwrap();
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        let end = all.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(all[..end].to_vec()).unwrap();
        let code = head.split(' ').nth(1).unwrap().parse().unwrap();
        (code, head, all[end + 4..].to_vec())
    }

    fn get(&self, path: &str) -> (u16, String, Vec<u8>) {
        self.ask("GET", path, &format!("Host: 127.0.0.1:{}\r\n", self.port))
    }

    /// The state as soon as it is as wanted.
    fn until(&self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        let mut version = 0;
        loop {
            let (code, _, body) = self.get(&format!("/state?since={version}"));
            assert_eq!(code, 200);
            let state: Value = serde_json::from_slice(&body).unwrap();
            if wanted(&state) {
                return state;
            }
            assert!(Instant::now() < end, "never {what}: {state}");
            version = state["version"].as_u64().unwrap();
        }
    }

    fn planned(&self, report: u64) -> Value {
        self.until("planned", |s| {
            s["report"] == report && s["title"].as_str().unwrap().starts_with("planned")
        })
    }

    fn report(&self) -> String {
        String::from_utf8(self.get("/report").2).unwrap()
    }
}

fn html(state: &Value) -> &str {
    state["html"].as_str().unwrap()
}

#[test]
fn the_page_follows_what_is_saved() {
    let (room, scenario) = workplace();
    let before = files(room.path());
    let text = std::fs::read_to_string(&scenario).unwrap();
    let watch = Watch::start(&scenario, &[]);
    let (code, head, page) = watch.get("/");
    assert!(code == 200 && head.contains("Content-Security-Policy: default-src 'none'"), "{head}");
    assert!(String::from_utf8(page).unwrap().contains("bench.toml"));
    watch.until("planning", |s| html(s).contains("Planning: "));
    assert!(html(&watch.planned(1)).contains("that of what was saved last"));
    assert!(watch.report().contains("<html") && !watch.report().contains("Renamed bench"));
    assert_eq!(watch.get("/cell.png").2[..4], *b"\x89PNG");
    // Nothing is written.
    assert_eq!(files(room.path()), before);

    // Saved by renaming another file over it, as many editors do.
    let name = text.lines().find(|l| l.starts_with("name = ")).unwrap().to_owned();
    let renamed = text.replace(&name, "name = \"Renamed bench\"");
    let beside = room.path().join("bench.toml~");
    std::fs::write(&beside, &renamed).unwrap();
    std::fs::rename(&beside, &scenario).unwrap();
    let state = watch.until("an old report", |s| html(s).contains("an earlier save"));
    assert!(state["report"] == 1, "{state}");
    watch.planned(2);
    assert!(watch.report().contains("Renamed bench"));

    // Broken: line and caret, and the last report stays.
    std::fs::write(&scenario, renamed.replace("duration_s", "duration_<b>s")).unwrap();
    let state = watch.until("an error", |s| s["title"].as_str().unwrap().starts_with("error"));
    let shown = html(&state);
    let line = renamed.lines().position(|l| l.contains("duration_s")).unwrap() + 1;
    assert!(shown.contains(&format!("bench.toml:{line}:")), "{shown}");
    assert!(shown.contains("here") && shown.contains("╰"), "{shown}");
    assert!(shown.contains("duration_&lt;b&gt;s") && !shown.contains("<b>"), "{shown}");
    assert!(shown.contains("an earlier save") && watch.report().contains("Renamed bench"));

    // Mended by deleting it and making it anew.
    std::fs::remove_file(&scenario).unwrap();
    std::fs::write(&scenario, &text).unwrap();
    watch.planned(3);
    assert!(!watch.report().contains("Renamed bench"));

    // A file that the scenario names.
    let model = room.path().join("operator.json");
    let model_text = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&model, format!("{model_text}\n")).unwrap();
    watch.planned(4);
}

#[test]
fn a_newer_save_ends_the_planning_under_work() {
    let (room, scenario) = workplace();
    let tiny = std::fs::read_to_string(room.path().join("tiny.toml")).unwrap();
    // Far too much to wait for.
    let slow = tiny.replace("generations = 2", "generations = 500").replace("runs = 1", "runs = 3");
    assert_ne!(slow, tiny);
    std::fs::write(room.path().join("tiny.toml"), slow).unwrap();
    let watch = Watch::start(&scenario, &[]);
    watch.until("planning", |s| html(s).contains("Planning: "));
    let started = Instant::now();
    std::fs::write(room.path().join("tiny.toml"), &tiny).unwrap();
    watch.planned(1);
    assert!(started.elapsed() < PATIENCE);
}

#[test]
fn the_page_is_for_this_machine_and_for_reading() {
    let (room, scenario) = workplace();
    std::fs::write(&scenario, "schema = \"ergopath/scenario/1\"\n").unwrap();
    let watch = Watch::start(&scenario, &[]);
    let port = watch.port;
    for host in [
        String::new(),
        "Host: example.org\r\n".to_owned(),
        format!("Host: example.org:{port}\r\n"),
        format!("Host: 127.0.0.1:{}\r\n", port ^ 1),
        format!("Host: localhost:{port}\r\nHost: example.org\r\n"),
    ] {
        for path in ["/", "/state", "/report", "/cell.png"] {
            let (code, _, body) = watch.ask("GET", path, &host);
            assert_eq!(code, 403, "{host} {path}");
            assert!(!String::from_utf8_lossy(&body).contains("bench"));
        }
    }
    let own = format!("Host: localhost:{port}\r\n");
    assert_eq!(watch.ask("GET", "/", &own).0, 200);
    for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
        assert_eq!(watch.ask(method, "/", &format!("{own}Content-Length: 0\r\n")).0, 405);
    }
    // Nothing is served from the disk.
    for path in ["/bench.toml", "/../bench.toml", "/%2e%2e/etc/passwd", "//etc/passwd", "/report"] {
        assert_eq!(watch.ask("GET", path, &own).0, 404, "{path}");
    }
    drop(watch);
    let missing = room.path().join("missing.toml");
    assert_refused(ergopath().arg("watch").arg(&missing), "no such file");
    let planner = ["--planner", "swift"];
    assert_refused(ergopath().arg("watch").arg(&scenario).args(planner), "swift");
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_it_and_runs_are_written_on_demand() {
    let (room, scenario) = workplace();
    let out = room.path().join("out");
    let mut watch = Watch::start(&scenario, &["-o", out.to_str().unwrap()]);
    watch.planned(1);
    let end = Instant::now() + PATIENCE;
    while !out.join(".ergopath-output.json").exists() {
        assert!(Instant::now() < end, "no folder");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(std::fs::read(out.join("report.html")).unwrap(), watch.get("/report").2);
    let pid = watch.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(watch.child.wait().unwrap().code(), Some(130));
    assert!(!room.path().join("out.unfinished.json").exists());
}
