//! Progress on a terminal, and a safe end on Ctrl-C, SIGTERM and SIGHUP.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, Mutex};

/// Set by a signal; the first use installs the handlers. Without them a signal simply kills the program,
/// which is safe as well.
static INTERRUPTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(|| {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in signals() {
        let _ = signal_hook::flag::register(signal, Arc::clone(&flag));
    }
    flag
});

/// Signals that ask for an end. One that the caller has told us to ignore (`nohup`) stays ignored.
#[cfg(unix)]
fn signals() -> impl Iterator<Item = i32> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix("SigIgn:"));
    let ignored = mask.and_then(|m| u64::from_str_radix(m.trim(), 16).ok()).unwrap_or(0);
    [SIGINT, SIGTERM, SIGHUP].into_iter().filter(move |s| ignored & (1 << (s - 1)) == 0)
}

#[cfg(not(unix))]
fn signals() -> impl Iterator<Item = i32> {
    [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM].into_iter()
}

/// A bar for each stage, shown only where somebody watches.
#[derive(Debug)]
pub(super) struct Progress {
    bar: Mutex<(&'static str, ProgressBar)>,
    is_shown: bool,
    template: &'static str,
}

const PLAIN: &str = "{msg:>26} {bar:40} {pos}/{len}";
const WITH_TIME_LEFT: &str = "{msg:>26} {bar:40} {pos}/{len}, {eta} left";

impl Progress {
    /// From now on a signal ends the run at the next item, before anything is written.
    pub(super) fn new() -> Self {
        LazyLock::force(&INTERRUPTED);
        Self {
            bar: Mutex::new(("", ProgressBar::hidden())),
            is_shown: std::io::stderr().is_terminal(),
            template: PLAIN,
        }
    }

    /// The same for items that take about as long each: it says how long the rest will take.
    pub(super) fn with_time_left() -> Self {
        Self { template: WITH_TIME_LEFT, ..Self::new() }
    }

    /// Notes where a stage stands; false once a signal asked for an end.
    pub(super) fn tell(&self, stage: &'static str, done: usize, total: usize) -> bool {
        self.tell_best(stage, done, total, None)
    }

    /// Where work stands that goes on elsewhere, with what is known of it; false where nobody watches.
    pub(super) fn tell_state(&self, state: &str, done: usize, total: usize) -> bool {
        self.tell("cells", done, total);
        if self.is_shown
            && let Ok(bar) = self.bar.lock()
        {
            bar.1.set_message(state.to_owned());
        }
        self.is_shown
    }

    /// The same with the best value that a search has found so far.
    pub(super) fn tell_best(
        &self,
        stage: &'static str,
        done: usize,
        total: usize,
        best: Option<f64>,
    ) -> bool {
        if self.is_shown
            && let Ok(mut bar) = self.bar.lock()
        {
            if bar.0 != stage {
                bar.1.finish_and_clear();
                let style = ProgressStyle::with_template(self.template);
                *bar = (stage, ProgressBar::new(total as u64));
                if let Ok(style) = style {
                    bar.1.set_style(style);
                }
                bar.1.set_message(stage);
            }
            if let Some(best) = best {
                bar.1.set_message(format!("{stage}, best {best:.2}"));
            }
            bar.1.set_position(done as u64);
            if done == total {
                bar.1.finish_and_clear();
            }
        }
        !Self::is_interrupted()
    }

    /// Whether a signal asked for an end.
    pub(super) fn is_interrupted() -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}
