//! The page of `ergopath watch` in a real browser: it changes when the file is saved, shows an error with
//! line and caret above the last report, and goes on when that is mended.

use crate::driver::Session;
use crate::skips;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Ended with the test.
struct Watch(Child);

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

const HEADING: &str =
    "document.getElementById('report').contentDocument?.querySelector('header h1')?.textContent";

#[test]
fn the_page_of_a_watched_file_follows_it() {
    let room = tempfile::tempdir().unwrap();
    let Some(page) = Session::start(&room.path().join("profile")) else {
        skips::skip("chromium to open the page in");
        return;
    };
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/bench_pick_and_place.toml");
    let text = std::fs::read_to_string(shipped).unwrap();
    let name = text.lines().find(|l| l.starts_with("name = ")).unwrap();
    let named = |new: &str| text.replace(name, &format!("name = \"{new}\""));
    let cell = room.path().join("cell.toml");
    std::fs::write(&cell, named("First")).unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_ergopath"))
        .arg("watch")
        .arg(&cell)
        .args(["--port", "0"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut watch = Watch(child);
    let mut said = BufReader::new(watch.0.stdout.take().unwrap()).lines();
    let address = said.next().unwrap().unwrap();
    std::thread::spawn(move || said.for_each(drop));

    page.resize(1440, 900);
    page.visit(&address);
    page.wait("document.querySelector('#watch progress')");
    page.wait("document.querySelector('#cell img').naturalWidth > 500");
    page.keep("watch_planning");
    page.wait("document.title === 'planned: cell.toml'");
    page.wait(&format!("{HEADING} === 'First'"));
    let ready = "document.getElementById('report').contentDocument?.getElementById('scene-box')?.dataset.ready";
    page.wait(ready);
    // The report is as high as it is, so that the page has one scroll bar.
    let [frame, inner]: [f64; 2] = page.get(
        "[document.getElementById('report').clientHeight, \
         document.getElementById('report').contentDocument.documentElement.scrollHeight]",
    );
    assert!(frame > 2000.0 && (frame - inner).abs() < 2.0, "{frame} {inner}");
    page.keep("watch_planned");

    std::fs::write(&cell, named("Second")).unwrap();
    page.wait("document.getElementById('watch').textContent.includes('an earlier save')");
    page.wait(&format!("{HEADING} === 'Second' && document.title.startsWith('planned')"));

    std::fs::write(&cell, named("Third").replace("duration_s", "durations")).unwrap();
    page.wait("document.title === 'error: cell.toml'");
    let error: String = page.get("document.querySelector('#watch pre').textContent");
    assert!(error.contains("durations") && error.contains("╰"), "{error}");
    let heading: String = page.get(HEADING);
    assert_eq!(heading, "Second");
    for width in [1440, 800] {
        page.resize(width, 900);
        let wide: u32 = page.get("document.documentElement.scrollWidth");
        assert!(wide <= width, "{wide} px of {width}");
        page.keep(&format!("watch_error_{width}"));
    }

    std::fs::write(&cell, named("Fourth")).unwrap();
    page.wait(&format!("{HEADING} === 'Fourth' && document.title.startsWith('planned')"));
    assert_eq!(page.complaints().join("\n"), "");
    let leaving = |url: &String| !["data:", "blob:", &address].iter().any(|s| url.starts_with(*s));
    let left: Vec<String> = page.requests().into_iter().filter(leaving).collect();
    assert_eq!(left, Vec::<String>::new(), "requests left the page");

    drop(watch);
    page.wait("!document.getElementById('gone').hidden");
}
