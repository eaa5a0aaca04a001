//! A browser tab as the tests need it: what it complains of and asks the network for is recorded.
//!
//! It speaks the browser's own protocol (that of its developer tools) over two pipes: JSON texts, each
//! ended by a zero byte. The browser expects them as its descriptors 3 and 4, which a shell arranges.

use base64::Engine;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::cell::{Cell, RefCell};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How long a loaded machine may take for anything.
const PATIENCE: Duration = Duration::from_secs(90);

/// Names under which the browser may be installed.
const BROWSERS: [&str; 4] =
    ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome"];

const ARGUMENTS: [&str; 24] = [
    "--headless=new",
    "--no-sandbox",
    "--remote-debugging-pipe",
    "--window-size=1440,900",
    "--hide-scrollbars",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-dev-shm-usage",
    "--disable-domain-reliability",
    "--disable-extensions",
    "--disable-renderer-backgrounding",
    "--disable-sync",
    "--force-color-profile=srgb",
    "--metrics-recording-only",
    "--no-default-browser-check",
    // Nothing but this machine is found, so that any other request could only fail.
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1",
];

/// An open page.
pub(crate) struct Session {
    browser: Child,
    orders: RefCell<ChildStdin>,
    answers: Receiver<Value>,
    last: Cell<u64>,
    tab: String,
    seen: Arc<Seen>,
}

/// What the page did by itself.
#[derive(Default)]
struct Seen {
    /// Console errors and exceptions.
    complaints: Mutex<Vec<String>>,
    /// Addresses asked for.
    requests: Mutex<Vec<String>>,
    loads: Mutex<usize>,
}

/// Colours of a picture, row by row.
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) rgb: Vec<[u8; 3]>,
}

impl Picture {
    /// Share of the pixels in which two pictures of one size differ.
    pub(crate) fn difference(&self, other: &Self) -> f64 {
        assert_eq!(self.rgb.len(), other.rgb.len());
        let far = |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).any(|(x, y)| x.abs_diff(*y) > 12);
        let differing = self.rgb.iter().zip(&other.rgb).filter(|(a, b)| far(a, b)).count();
        differing as f64 / self.rgb.len() as f64
    }
}

impl Seen {
    fn note(&self, event: &Value) {
        let about = &event["params"];
        let complain = || self.complaints.lock().unwrap().push(about.to_string());
        match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => complain(),
            Some("Log.entryAdded") if about["entry"]["level"] == "error" => complain(),
            Some("Runtime.consoleAPICalled") if about["type"] == "error" => complain(),
            Some("Network.requestWillBeSent") => {
                let url = about["request"]["url"].as_str().unwrap().to_owned();
                self.requests.lock().unwrap().push(url);
            }
            Some("Page.loadEventFired") => *self.loads.lock().unwrap() += 1,
            _ => {}
        }
    }

    /// Passes answers on and notes events, until the browser ends.
    fn listen(&self, from: impl Read, answers: &Sender<Value>) {
        for text in BufReader::new(from).split(0) {
            let Ok(message) = serde_json::from_slice::<Value>(&text.unwrap()) else { return };
            if message["id"].is_null() {
                self.note(&message);
            } else if answers.send(message).is_err() {
                return;
            }
        }
    }
}

/// The browser's program, if there is one.
fn program() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let all = std::env::split_paths(&path).flat_map(|d| BROWSERS.map(|name| d.join(name)));
    all.into_iter().find(|p| p.is_file())
}

impl Session {
    /// A browser with nothing to reach but files; none where there is no browser.
    pub(crate) fn start(profile: &Path) -> Option<Self> {
        let mut browser = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1"])
            .arg(program()?)
            .args(ARGUMENTS)
            .arg(format!("--user-data-dir={}", profile.display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, answers) = channel();
        let seen = Arc::<Seen>::default();
        let (from, ear) = (browser.stdout.take().unwrap(), Arc::clone(&seen));
        std::thread::spawn(move || ear.listen(from, &sender));
        let orders = RefCell::new(browser.stdin.take().unwrap());
        let (last, tab) = (Cell::new(0), String::new());
        let mut session = Self { browser, orders, answers, last, tab, seen };
        let target = session.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let id = &target["targetId"];
        let attached =
            session.call("Target.attachToTarget", &json!({ "targetId": id, "flatten": true }));
        attached["sessionId"].as_str().unwrap().clone_into(&mut session.tab);
        for domain in ["Page", "Log", "Runtime", "Network"] {
            session.call(&format!("{domain}.enable"), &json!({}));
        }
        Some(session)
    }

    /// Gives an order and waits for its answer.
    fn call(&self, method: &str, params: &Value) -> Value {
        let id = self.last.get() + 1;
        self.last.set(id);
        let mut order = json!({ "id": id, "method": method, "params": params });
        if !self.tab.is_empty() {
            order["sessionId"] = json!(self.tab);
        }
        let mut orders = self.orders.borrow_mut();
        orders.write_all(format!("{order}\0").as_bytes()).unwrap();
        orders.flush().unwrap();
        let answer = self.answers.recv_timeout(PATIENCE);
        let mut answer = answer.unwrap_or_else(|e| panic!("{method}: {e}"));
        assert!(answer["id"] == id && answer["error"].is_null(), "{method}: {answer}");
        answer["result"].take()
    }

    /// Console errors and exceptions so far.
    pub(crate) fn complaints(&self) -> Vec<String> {
        self.seen.complaints.lock().unwrap().clone()
    }

    /// Addresses asked for so far.
    pub(crate) fn requests(&self) -> Vec<String> {
        self.seen.requests.lock().unwrap().clone()
    }

    /// Opens a file and waits until it is loaded.
    pub(crate) fn open(&self, file: &Path) {
        self.visit(&format!("file://{}", file.display()));
    }

    /// Opens an address and waits until it is loaded.
    pub(crate) fn visit(&self, url: &str) {
        let loads = || *self.seen.loads.lock().unwrap();
        let before = loads();
        self.call("Page.navigate", &json!({ "url": url }));
        let until = Instant::now() + PATIENCE;
        while loads() == before {
            assert!(Instant::now() < until, "{url} is never loaded");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The value of an expression.
    pub(crate) fn get<T: DeserializeOwned>(&self, expression: &str) -> T {
        let text = format!("(async () => JSON.stringify(await ({expression})) ?? 'null')()");
        let order = json!({ "expression": text, "awaitPromise": true, "returnByValue": true });
        let answer = self.call("Runtime.evaluate", &order);
        let value = answer["result"]["value"].as_str();
        let value = value.unwrap_or_else(|| panic!("`{expression}` gave nothing: {answer}"));
        serde_json::from_str(value).unwrap_or_else(|e| panic!("{expression}: {value}: {e}"))
    }

    /// Runs statements.
    pub(crate) fn run(&self, statements: &str) {
        let _: bool = self.get(&format!("(async () => {{ {statements}; return true; }})()"));
    }

    /// Waits until an expression is true.
    pub(crate) fn wait(&self, expression: &str) {
        let until = Instant::now() + PATIENCE;
        while !self.get::<bool>(&format!("!!({expression})")) {
            assert!(Instant::now() < until, "never true: {expression}; {:?}", self.complaints());
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Clicks in the middle of an element, as a mouse does.
    pub(crate) fn click(&self, selector: &str) {
        let [x, y]: [f64; 2] = self.get(&format!(
            "(() => {{ const e = document.querySelector({selector:?}); \
             e.scrollIntoView({{ block: 'center' }}); const r = e.getBoundingClientRect(); \
             return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        ));
        for (kind, button) in
            [("mouseMoved", "none"), ("mousePressed", "left"), ("mouseReleased", "left")]
        {
            let event = json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", &event);
        }
    }

    /// Presses a key: "`ArrowRight`" or "Enter".
    pub(crate) fn press(&self, key: &str) {
        let (number, text) = match key {
            "ArrowRight" => (39, ""),
            "Enter" => (13, "\r"),
            other => panic!("key {other}"),
        };
        let down = if text.is_empty() { "rawKeyDown" } else { "keyDown" };
        for kind in [down, "keyUp"] {
            let mut event =
                json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": number });
            if kind == "keyDown" {
                event["text"] = json!(text);
            }
            self.call("Input.dispatchKeyEvent", &event);
        }
    }

    /// Width and height of the window, px.
    pub(crate) fn resize(&self, width: u32, height: u32) {
        let size =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", &size);
    }

    /// "screen" or "print".
    pub(crate) fn media(&self, media: &str) {
        self.call("Emulation.setEmulatedMedia", &json!({ "media": media }));
    }

    /// Scripts of pages run, or do not.
    pub(crate) fn scripts(&self, run: bool) {
        self.call("Emulation.setScriptExecutionDisabled", &json!({ "value": !run }));
    }

    /// The page as PDF.
    pub(crate) fn pdf(&self) -> Vec<u8> {
        decoded(&self.call("Page.printToPDF", &json!({})))
    }

    /// An element as PNG, made smaller by `scale`; whole even where the window shows a part of it.
    pub(crate) fn png(&self, selector: &str, scale: f64) -> Vec<u8> {
        // Two frames, so that what was asked for is drawn.
        self.run(&format!(
            "document.querySelector({selector:?}).scrollIntoView({{ block: 'center' }}); \
             await new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))"
        ));
        let [x, y, width, height]: [f64; 4] = self.get(&format!(
            "(() => {{ const r = document.querySelector({selector:?}).getBoundingClientRect(); \
             return [r.x + scrollX, r.y + scrollY, r.width, r.height].map(Math.floor); }})()"
        ));
        // Only where it must be: the page is laid out anew for it.
        let is_beyond: bool = self.get(&format!(
            "document.querySelector({selector:?}).getBoundingClientRect().height > innerHeight"
        ));
        let clip = json!({ "x": x, "y": y, "width": width, "height": height, "scale": scale });
        let how = json!({ "format": "png", "clip": clip, "captureBeyondViewport": is_beyond });
        decoded(&self.call("Page.captureScreenshot", &how))
    }

    /// The same as pixels.
    pub(crate) fn picture(&self, selector: &str) -> Picture {
        let bytes = self.png(selector, 1.0);
        let mut reader = png::Decoder::new(bytes.as_slice()).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let step = info.color_type.samples();
        let rgb = bytes[..info.buffer_size()].chunks(step).map(|p| [p[0], p[1], p[2]]).collect();
        Picture { width: info.width as usize, rgb }
    }

    /// Keeps a picture of the window where the tests are asked to.
    pub(crate) fn keep(&self, name: &str) {
        let Some(folder) = std::env::var_os("ERGOPATH_SCREENSHOTS") else { return };
        let shot = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        std::fs::write(Path::new(&folder).join(format!("{name}.png")), decoded(&shot)).unwrap();
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}

/// The file in an answer.
fn decoded(answer: &Value) -> Vec<u8> {
    let text = answer["data"].as_str().unwrap();
    base64::engine::general_purpose::STANDARD.decode(text).unwrap()
}
