//! A browser tab as the tests need it: what it complains of and asks the network for is recorded.

use base64::Engine;
use headless_chrome::browser::{LaunchOptions, default_executable};
use headless_chrome::protocol::cdp::types::Event;
use headless_chrome::protocol::cdp::{Emulation, Network, Page};
use headless_chrome::{Browser, Tab};
use serde::de::DeserializeOwned;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How long a loaded machine may take for anything.
const PATIENCE: Duration = Duration::from_secs(90);

/// An open page.
pub(crate) struct Session {
    tab: Arc<Tab>,
    /// Console errors and exceptions.
    pub(crate) complaints: Arc<Mutex<Vec<String>>>,
    /// Addresses asked for.
    pub(crate) requests: Arc<Mutex<Vec<String>>>,
    // Dropped last: this ends the browser.
    _browser: Browser,
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

impl Session {
    /// A browser with nothing to reach but files; none where there is no browser.
    pub(crate) fn start(profile: &Path) -> Option<Self> {
        let executable = default_executable().ok()?;
        let arguments = [
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--disable-quic",
            "--no-first-run",
            "--disable-component-update",
            "--disable-domain-reliability",
            "--no-default-browser-check",
            // Nothing is found by name, so that a request could only fail.
            "--host-resolver-rules=MAP * ~NOTFOUND",
        ];
        let options = LaunchOptions {
            headless: true,
            sandbox: false,
            enable_gpu: true,
            window_size: Some((1440, 900)),
            path: Some(executable),
            user_data_dir: Some(profile.to_path_buf()),
            args: arguments.iter().map(OsStr::new).collect(),
            idle_browser_timeout: Duration::from_mins(10),
            ..LaunchOptions::default()
        };
        let browser = Browser::new(options).unwrap();
        let tab = browser.new_tab().unwrap();
        tab.set_default_timeout(PATIENCE);
        let (complaints, requests) = (Arc::default(), Arc::default());
        let session = Self { tab, complaints, requests, _browser: browser };
        session.listen();
        Some(session)
    }

    fn listen(&self) {
        self.tab.enable_log().unwrap();
        self.tab.enable_runtime().unwrap();
        self.tab
            .call_method(Network::Enable {
                max_total_buffer_size: None,
                max_resource_buffer_size: None,
                max_post_data_size: None,
                report_direct_socket_traffic: None,
                enable_durable_messages: None,
            })
            .unwrap();
        let (complaints, requests) = (self.complaints.clone(), self.requests.clone());
        let note = move |event: &Event| {
            let complain = |what: String| complaints.lock().unwrap().push(what);
            match event {
                Event::RuntimeExceptionThrown(e) => complain(format!("{:?}", e.params)),
                Event::LogEntryAdded(e) => {
                    let entry = format!("{:?}", e.params.entry);
                    if entry.contains("level: Error") {
                        complain(entry);
                    }
                }
                Event::RuntimeConsoleAPICalled(e) => {
                    let call = format!("{:?}", e.params);
                    if call.contains("Type: Error") {
                        complain(call);
                    }
                }
                Event::NetworkRequestWillBeSent(e) => {
                    requests.lock().unwrap().push(e.params.request.url.clone());
                }
                _ => {}
            }
        };
        self.tab.add_event_listener(Arc::new(note)).unwrap();
    }

    /// Opens a file and waits until it is loaded.
    pub(crate) fn open(&self, file: &Path) {
        self.tab.navigate_to(&format!("file://{}", file.display())).unwrap();
        self.tab.wait_until_navigated().unwrap();
    }

    /// The value of an expression.
    pub(crate) fn get<T: DeserializeOwned>(&self, expression: &str) -> T {
        let text = format!("(async () => JSON.stringify(await ({expression})) ?? 'null')()");
        let value = self.tab.evaluate(&text, true).unwrap().value;
        let value = value.unwrap_or_else(|| panic!("`{expression}` gave nothing"));
        serde_json::from_str(value.as_str().unwrap())
            .unwrap_or_else(|e| panic!("{expression}: {value}: {e}"))
    }

    /// Runs statements.
    pub(crate) fn run(&self, statements: &str) {
        let _: bool = self.get(&format!("(async () => {{ {statements}; return true; }})()"));
    }

    /// Waits until an expression is true.
    pub(crate) fn wait(&self, expression: &str) {
        let until = Instant::now() + PATIENCE;
        while !self.get::<bool>(&format!("!!({expression})")) {
            assert!(
                Instant::now() < until,
                "never true: {expression}; {:?}",
                self.complaints.lock().unwrap()
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Clicks in the middle of an element, as a mouse does.
    pub(crate) fn click(&self, selector: &str) {
        self.run(&format!(
            "document.querySelector({selector:?}).scrollIntoView({{ block: 'center' }})"
        ));
        self.tab.find_element(selector).unwrap().click().unwrap();
    }

    /// Presses a key.
    pub(crate) fn press(&self, key: &str) {
        self.tab.press_key(key).unwrap();
    }

    /// Width and height of the window, px.
    pub(crate) fn resize(&self, width: u32, height: u32) {
        self.tab
            .call_method(Emulation::SetDeviceMetricsOverride {
                width,
                height,
                device_scale_factor: 1.0,
                mobile: false,
                scale: None,
                screen_width: None,
                screen_height: None,
                position_x: None,
                position_y: None,
                dont_set_visible_size: None,
                screen_orientation: None,
                viewport: None,
                display_feature: None,
                device_posture: None,
            })
            .unwrap();
    }

    /// "screen" or "print".
    pub(crate) fn media(&self, media: &str) {
        let media = Some(media.to_owned());
        self.tab.call_method(Emulation::SetEmulatedMedia { media, features: None }).unwrap();
    }

    /// Scripts of pages run, or do not.
    pub(crate) fn scripts(&self, run: bool) {
        self.tab.call_method(Emulation::SetScriptExecutionDisabled { value: !run }).unwrap();
    }

    /// The page as PDF.
    pub(crate) fn pdf(&self) -> Vec<u8> {
        self.tab.print_to_pdf(None).unwrap()
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
        let picture = self.tab.call_method(Page::CaptureScreenshot {
            format: Some(Page::CaptureScreenshotFormatOption::Png),
            clip: Some(Page::Viewport { x, y, width, height, scale }),
            quality: None,
            from_surface: Some(true),
            capture_beyond_viewport: Some(is_beyond),
            optimize_for_speed: None,
        });
        base64::engine::general_purpose::STANDARD.decode(picture.unwrap().data).unwrap()
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
}
