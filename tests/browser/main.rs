//! The page of a run in a real browser: it needs no network, moves, follows its controls, sorts its
//! tables, prints whole and can be read without scripts.
//!
//! Needs Chromium (Debian: `apt-get install chromium`); without it the test says loudly that it is
//! skipped. `ERGOPATH_SCREENSHOTS=folder` keeps the pictures that it takes.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

mod driver;
#[path = "../suite/skips.rs"]
mod skips;
mod watch;

use driver::Session;
use serde_json::Value;
use std::io::Write;
use std::path::Path;

const READY: &str = "document.getElementById('scene-box').dataset.ready";

/// Plans for two bodies and opens the report.
#[test]
fn the_page_of_a_run_works_in_a_browser() {
    let room = tempfile::tempdir().unwrap();
    let Some(page) = Session::start(&room.path().join("profile")) else {
        skips::skip("chromium to open the page in");
        return;
    };
    let out = room.path().join("out");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_cmd::Command::new(env!("CARGO_BIN_EXE_ergopath"))
        .current_dir(root)
        .args(["plan", "scenarios/hand_over.toml", "--planner", "quick", "--one-page", "-o"])
        .arg(&out)
        .assert()
        .success();
    let report = out.join("report.html");
    let text = std::fs::read_to_string(out.join("result.json")).unwrap();
    let result: Value = serde_json::from_str(&text).unwrap();
    let size = std::fs::metadata(&report).unwrap().len();
    assert!(size < 8_000_000, "the page has {size} bytes");

    page.resize(1440, 900);
    page.open(&report);
    page.wait(READY);
    starts_soon(&page);
    the_scene_is_drawn_and_stands_still(&page);
    the_words_are_those_of_the_result(&page, &result);
    it_plays_and_is_scrubbed(&page);
    the_controls_change_the_picture(&page);
    tables_sort(&page);
    texts_have_contrast(&page);
    for width in [1440, 800] {
        the_first_screen_decides(&page, width);
        nothing_is_wider_than_the_window(&page, width);
        keep_pictures(&page, width);
    }
    print_cuts_nothing(&page);
    one_page_is_one_page(&page, &out.join("one_page.html"));
    page.open(&report);
    assert_eq!(page.complaints().join("\n"), "");

    it_can_be_read_without_scripts(&page, &report);
    let leaving = |url: &String| !["file:", "data:", "blob:"].iter().any(|s| url.starts_with(s));
    let left: Vec<String> = page.requests().into_iter().filter(leaving).collect();
    assert_eq!(left, Vec::<String>::new(), "requests left the page");
    assert!(!page.requests().is_empty(), "the page itself is a request");
}

/// The page can be read within 2 s, and moves soon after; a machine that builds beside it is slower.
fn starts_soon(page: &Session) {
    let painted: f64 =
        page.get("performance.getEntriesByName('first-contentful-paint')[0].startTime");
    let ready: f64 = page.get(&format!("Number({READY})"));
    let _ = writeln!(std::io::stderr(), "painted after {painted:.0} ms, scene after {ready:.0} ms");
    assert!(painted < ready && painted < 10_000.0 && ready < 30_000.0, "{painted} {ready}");
}

fn the_scene_is_drawn_and_stands_still(page: &Session) {
    let picture = page.picture("#scene-plot");
    let is_inked = |p: &&[u8; 3]| p.iter().any(|v| v.abs_diff(255) > 40);
    let inked = picture.rgb.iter().filter(is_inked).count() as f64 / picture.rgb.len() as f64;
    assert!(picture.width > 700 && inked > 0.03, "{} px wide, {inked} inked", picture.width);
    std::thread::sleep(std::time::Duration::from_millis(600));
    // Nothing moves unasked.
    assert!(picture.difference(&page.picture("#scene-plot")) < 1e-4);
    // Person, ghosts and robot: points of the meshes lie where the result has the people.
    let meshes: Vec<[f64; 2]> =
        page.get("document.getElementById('scene-plot').data.slice(0, 3).map((d) => [Math.min(...d.z), Math.max(...d.z)])");
    let [ghosts, person, robot] = meshes[..] else { panic!("{meshes:?}") };
    assert!(person[0] > -0.05 && person[0] < 0.1, "feet at {person:?}");
    assert!(person[1] > 1.4 && person[1] < 1.9, "crown at {person:?}");
    assert!(ghosts[1] > 1.3 && robot[1] > 0.3, "{meshes:?}");
}

fn scrub(page: &Session, frame: u32) {
    page.run(&format!(
        "const s = document.getElementById('scene-frame'); s.value = {frame}; s.dispatchEvent(new Event('input'))"
    ));
}

fn readout(page: &Session) -> [String; 4] {
    page.get("['time', 'own', 'rula', 'reba'].map((n) => document.getElementById(`scene-${n}`).textContent)")
}

/// Time and scores beside the scene, at three frames of two paths.
fn the_words_are_those_of_the_result(page: &Session, result: &Value) {
    let motions = result["scene"]["motions"].as_array().unwrap();
    for (path, frame) in [(0, 0), (0, 57), (1, 99)] {
        page.run(&format!(
            "const s = document.getElementById('scene-path'); s.value = {path}; s.dispatchEvent(new Event('change'))"
        ));
        scrub(page, frame);
        let motion = &motions[path];
        let samples = motion["samples"].as_array().unwrap();
        let k = (f64::from(frame) / 99.0 * (samples.len() - 1) as f64).round() as usize;
        let sample = samples[k].as_u64().unwrap() as usize;
        let candidates = result["candidates"].as_array().unwrap();
        let candidate = candidates.iter().find(|c| c["id"] == motion["candidate"]).unwrap();
        let shown: String = page.get("document.getElementById('scene-body').value");
        let of = |list: &Value| -> Value {
            list.as_array().unwrap().iter().find(|b| b["body"] == shown.as_str()).unwrap().clone()
        };
        let person = &of(&motion["people"])["typical"];
        let scores = of(&candidate["bodies"]);
        let [time, own, rula, reba] = readout(page);
        let seconds = candidate["path"]["time_s"][sample].as_f64().unwrap();
        assert!(time.starts_with(&format!("{seconds:.2} s of ")), "{time}");
        assert!(own.starts_with(&format!("RULA {} (action level ", person["rula"][k])), "{own}");
        assert!(own.ends_with(&format!("REBA {}", person["reba"][k])), "{own}");
        for (words, name) in [(rula, "rula"), (reba, "reba")] {
            let at = |what: &str| scores[name]["band"][what][sample].as_f64().unwrap();
            let (mean, low, high) = (at("mean"), at("p05"), at("p95"));
            assert_eq!(words, format!("{mean:.2} (90 % band {low:.2} to {high:.2})"));
        }
    }
}

fn it_plays_and_is_scrubbed(page: &Session) {
    scrub(page, 0);
    let first = page.picture("#scene-plot");
    scrub(page, 60);
    let later = page.picture("#scene-plot");
    assert!(first.difference(&later) > 2e-3, "{}", first.difference(&later));
    scrub(page, 0);
    assert!(first.difference(&page.picture("#scene-plot")) < 1e-3, "back at the start");
    // By keyboard.
    page.run("document.getElementById('scene-frame').focus()");
    page.press("ArrowRight");
    assert_eq!(page.get::<String>("document.getElementById('scene-frame').value"), "1");

    let frames =
        || page.get::<u32>("Number(document.getElementById('scene-box').dataset.frames || 0)");
    let (before, started) = (frames(), std::time::Instant::now());
    // Noted as it changes: on a loaded machine the end comes before a question does.
    page.run(
        "const r = document.getElementById('scene-readout'); window.noted = []; \
         new MutationObserver(() => noted.push(r.getAttribute('aria-live'))).observe(r, { attributes: true })",
    );
    page.click("#scene-play");
    page.wait("Number(document.getElementById('scene-frame').value) > 20");
    page.wait("document.getElementById('scene-play').textContent === 'Play'");
    let (drawn, seconds) = (frames() - before, started.elapsed().as_secs_f64());
    let _ = writeln!(
        std::io::stderr(),
        "played {drawn} frames in {seconds:.1} s ({:.0} a second, no graphics card)",
        f64::from(drawn) / seconds
    );
    assert!(drawn >= 4, "{drawn} frames");
    assert_eq!(page.get::<String>("document.getElementById('scene-frame').value"), "99");
    assert_eq!(page.get::<Vec<String>>("noted"), ["off", "polite"]);
}

fn the_controls_change_the_picture(page: &Session) {
    scrub(page, 40);
    let choose = |id: &str, nth: u32| {
        page.run(&format!(
            "const s = document.getElementById('{id}'); s.selectedIndex = {nth}; s.dispatchEvent(new Event('change')); \
             await new Promise((r) => setTimeout(r, 300))"
        ));
        page.picture("#scene-plot")
    };
    let crown = || page.get::<f64>("Math.max(...document.getElementById('scene-plot').data[1].z)");
    choose("scene-path", 0);
    let (small, at_small) = (choose("scene-body", 0), crown());
    let (tall, at_tall) = (choose("scene-body", 1), crown());
    assert!(small.difference(&tall) > 5e-3 && at_tall > at_small + 0.1, "{at_small} {at_tall}");
    let other = choose("scene-path", 1);
    assert!(tall.difference(&other) > 1e-3, "{}", tall.difference(&other));
    page.click("#scene-ghosts");
    let alone = page.picture("#scene-plot");
    assert!(other.difference(&alone) > 5e-4, "{}", other.difference(&alone));
    page.click("#scene-ghosts");
    let mut views = vec![alone];
    for view in ["side", "front", "top", "free"] {
        page.click(&format!("[data-view={view}]"));
        // A scene that is drawn by the processor takes longer than a click.
        page.run("await new Promise((r) => setTimeout(r, 500))");
        views.push(page.picture("#scene-plot"));
        let [.., before, now] = &views[..] else { unreachable!() };
        let difference = before.difference(now);
        assert!(difference > 0.01, "{view}: {difference}");
    }
    page.run("document.getElementById('scene-plot').focus()");
    page.press("ArrowRight");
    assert!(page.picture("#scene-plot").difference(&views[4]) > 0.01, "arrow keys turn the scene");
    page.click("[data-view=free]");
}

/// Picture, sentence, change, bars, caution and what to settle are seen without scrolling.
fn the_first_screen_decides(page: &Session, width: u32) {
    let height = if width > 1000 { 900 } else { 1200 };
    page.resize(width, height);
    let lowest: f64 = page.get(
        "(scrollTo(0, 0), Math.max(...['.seen img', '.headline', '.exposure', '.levelbars', '.caveat', '.settle'] \
           .map((s) => document.querySelector('.decision ' + s).getBoundingClientRect().bottom)))",
    );
    assert!(lowest < f64::from(height), "{lowest} px at {width} px");
    assert_eq!(page.get::<u32>("document.querySelector('.seen img').naturalWidth"), 1000);
    let lines: u32 = page.get(
        "new Set([...document.querySelectorAll('nav.contents a')].map((a) => a.offsetTop)).size",
    );
    assert_eq!(lines, 1, "the navigation is one line");
}

fn one_page_is_one_page(page: &Session, sheet: &Path) {
    page.open(sheet);
    texts_have_contrast(page);
    page.media("print");
    let pdf = page.pdf();
    if let Some(folder) = std::env::var_os("ERGOPATH_SCREENSHOTS") {
        std::fs::write(Path::new(&folder).join("one_page.pdf"), &pdf).unwrap();
    }
    assert_eq!(String::from_utf8_lossy(&pdf).matches("/Type /Page\n").count(), 1);
    page.media("screen");
}

fn tables_sort(page: &Session) {
    let table = "document.querySelector('[aria-label=\"Paths compared\"] table')";
    let column = |n: u32| -> Vec<f64> {
        page.get(&format!("[...{table}.tBodies[0].rows].map((r) => parseFloat(r.cells[{n}].firstChild.textContent))"))
    };
    let heading = "[aria-label=\"Paths compared\"] thead th:nth-child(4) button";
    let before = column(3);
    page.click(heading);
    let up = column(3);
    assert!(up.is_sorted() && up.len() == before.len() && up.len() > 3, "{up:?}");
    assert_eq!(
        page.get::<String>(&format!(
            "{table}.querySelector('[aria-sort]').getAttribute('aria-sort')"
        )),
        "ascending"
    );
    page.press("Enter");
    let down = column(3);
    assert!(down.iter().rev().is_sorted() && down != up, "{down:?}");
    page.click("[aria-label=\"Paths compared\"] thead th:nth-child(1) button");
    assert_eq!(column(3), before, "back in the order of ranks");
}

/// Contrast of every text with the ground below it, as WCAG 2.2 AA asks: 4.5, or 3 for large type.
fn texts_have_contrast(page: &Session) {
    let poor: Vec<String> = page.get(
        "(() => { \
           const rgb = (c) => { const v = c.match(/[\\d.]+/g).map(Number); return v.length > 3 ? v : [...v, 1]; }; \
           const light = (c) => { const [r, g, b] = c.map((v) => { v /= 255; return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); \
             return 0.2126 * r + 0.7152 * g + 0.0722 * b; }; \
           const ground = (e) => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor); if (c[3] === 1) return c.slice(0, 3); } return [255, 255, 255]; }; \
           const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT); const poor = []; \
           for (let n = walk.nextNode(); n; n = walk.nextNode()) { \
             const e = n.parentElement; if (!n.textContent.trim() || !e.checkVisibility() || e.closest('#scene-plot, script, style')) continue; \
             const s = getComputedStyle(e); const [a, b] = [light(rgb(s.color)), light(ground(e))]; \
             const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05); \
             const size = parseFloat(s.fontSize); const large = size >= 24 || (size >= 18.66 && s.fontWeight >= 700); \
             if (ratio < (large ? 3 : 4.5)) poor.push(`${ratio.toFixed(2)} ${n.textContent.trim().slice(0, 40)}`); } \
           return poor; })()",
    );
    assert_eq!(poor, Vec::<String>::new());
}

/// What sticks out of the window, or is scrolled inside the page.
const WIDER: &str = "(() => { const wide = []; \
   if (document.documentElement.scrollWidth > innerWidth) wide.push('page'); \
   for (const e of document.querySelectorAll('.scroll')) if (e.scrollWidth > e.clientWidth + 1) wide.push(e.getAttribute('aria-label') + ' ' + (e.scrollWidth - e.clientWidth)); \
   for (const e of document.querySelectorAll('main *')) { const r = e.getBoundingClientRect(); \
     if (r.width > 0 && e.checkVisibility() && !e.closest('#scene-plot') && r.right > document.documentElement.clientWidth + 1) wide.push(e.tagName + ' ' + e.textContent.slice(0, 30)); } \
   return wide; })()";

fn nothing_is_wider_than_the_window(page: &Session, width: u32) {
    page.resize(width, 900);
    page.run("await new Promise((r) => setTimeout(r, 500))");
    assert_eq!(page.get::<Vec<String>>(WIDER), Vec::<String>::new(), "at {width} px");
}

/// Reduced pictures of the page and of the scene, where the caller wants them.
fn keep_pictures(page: &Session, width: u32) {
    let Some(folder) = std::env::var_os("ERGOPATH_SCREENSHOTS") else { return };
    let keep =
        |name: &str, bytes: Vec<u8>| std::fs::write(Path::new(&folder).join(name), bytes).unwrap();
    page.run("const s = document.getElementById('scene-path'); s.value = 0; s.dispatchEvent(new Event('change'))");
    scrub(page, 60);
    // A window as tall as the page: nothing is laid out anew while the picture is taken.
    page.resize(width, page.get("document.documentElement.scrollHeight"));
    page.run("await new Promise((r) => setTimeout(r, 1000))");
    keep(&format!("scene_{width}.png"), page.png("#scene", 0.75));
    keep(&format!("verdict_{width}.png"), page.png("#verdict", 0.75));
    keep(&format!("page_{width}.png"), page.png("body", 0.25));
    page.resize(width, 900);
}

fn print_cuts_nothing(page: &Session) {
    // A4 less the margins of the style sheet, at 96 px an inch.
    page.media("print");
    page.resize(703, 1000);
    assert_eq!(page.get::<Vec<String>>(WIDER), Vec::<String>::new(), "in print");
    let seen =
        |id: &str| page.get::<bool>(&format!("document.getElementById('{id}').checkVisibility()"));
    assert!(!seen("scene-box") && seen("verdict") && seen("model"));
    let clipped: Vec<String> = page.get(
        "[...document.querySelectorAll('main *')].filter((e) => e.checkVisibility() && !e.closest('.scene') \
           && getComputedStyle(e).overflow !== 'visible' && (e.scrollHeight > e.clientHeight + 1 || e.scrollWidth > e.clientWidth + 1)) \
           .map((e) => e.className)",
    );
    assert_eq!(clipped, Vec::<String>::new());
    let pdf = page.pdf();
    if let Some(folder) = std::env::var_os("ERGOPATH_SCREENSHOTS") {
        std::fs::write(Path::new(&folder).join("report.pdf"), &pdf).unwrap();
    }
    let pages = String::from_utf8_lossy(&pdf).matches("/Type /Page\n").count();
    assert!(pdf.starts_with(b"%PDF") && (3..=6).contains(&pages), "{pages} pages");
    page.media("screen");
    page.resize(1440, 900);
}

fn it_can_be_read_without_scripts(page: &Session, report: &Path) {
    page.scripts(false);
    page.open(report);
    let text: String = page.get("document.body.innerText");
    for words in [
        "The scene needs scripts",
        "Paths compared",
        "Expected RULA",
        "Posture model and provenance",
    ] {
        assert!(text.contains(words), "{words}");
    }
    assert!(!text.contains("being made"), "no promise that nobody keeps");
    assert!(!page.get::<bool>("document.getElementById('scene-box').checkVisibility()"));
    assert_eq!(page.get::<u32>("document.querySelectorAll('thead button').length"), 0);
    let drawn = "[...document.querySelectorAll('main img')].map((i) => i.naturalWidth)";
    let widths: Vec<u32> = page.get(drawn);
    assert!(widths.len() >= 8 && widths.iter().all(|w| *w > 100), "{widths:?}");
}
