//! Progress on a terminal, and a safe end on Ctrl-C.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
static HANDLER: Once = Once::new();

/// A bar for each stage, shown only where somebody watches.
#[derive(Debug)]
pub(super) struct Progress {
    bar: Mutex<(&'static str, ProgressBar)>,
    is_shown: bool,
}

impl Progress {
    /// From now on Ctrl-C ends the run at the next item, before anything is written.
    pub(super) fn new() -> Self {
        HANDLER.call_once(|| {
            // Without a handler Ctrl-C simply kills the program, which is safe as well.
            let _ = ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed));
        });
        Self {
            bar: Mutex::new(("", ProgressBar::hidden())),
            is_shown: std::io::stderr().is_terminal(),
        }
    }

    /// Notes where a stage stands; false after Ctrl-C.
    pub(super) fn tell(&self, stage: &'static str, done: usize, total: usize) -> bool {
        self.tell_best(stage, done, total, None)
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
                let style = ProgressStyle::with_template("{msg:>26} {bar:40} {pos}/{len}");
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

    /// Whether Ctrl-C was pressed.
    pub(super) fn is_interrupted() -> bool {
        INTERRUPTED.load(Ordering::Relaxed)
    }
}
