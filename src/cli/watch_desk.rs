//! What the page of `watch` shows now: written by the work, read by the server.

use crate::planner::Step;
use crate::report::{Watched, WatchedCheck, WatchedPhase, watch_status};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The state of the page. Every change has a new number, by which a browser knows what it has.
#[derive(Debug)]
pub(super) struct Desk {
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    version: u64,
    watched: Watched,
    cell: Option<Arc<Vec<u8>>>,
    report: Option<Arc<Vec<u8>>>,
    /// Files that were read or looked for, and that nobody has taken yet.
    files: Vec<PathBuf>,
}

impl Desk {
    pub(super) fn new(scenario: String) -> Self {
        let state = State {
            version: 1,
            watched: Watched::new(scenario),
            cell: None,
            report: None,
            files: Vec::new(),
        };
        Self { state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        let mut state = self.state();
        change(&mut state);
        state.version += 1;
    }

    /// Something was saved and is read.
    pub(super) fn reading(&self) {
        self.change(|s| {
            s.watched.phase = WatchedPhase::Reading;
            s.watched.is_current = false;
        });
    }

    /// The cell was looked at; its picture as PNG.
    pub(super) fn checked(&self, check: WatchedCheck, cell: Vec<u8>) {
        self.change(|s| {
            s.watched.check = Some(check);
            s.watched.cell += 1;
            s.cell = Some(Arc::new(cell));
        });
    }

    /// Where the planning stands.
    pub(super) fn planning(&self, step: &Step) {
        let Step { stage, done, total, best } = *step;
        self.change(|s| s.watched.phase = WatchedPhase::Planning { stage, done, total, best });
    }

    /// The report of what is saved now.
    pub(super) fn planned(&self, page: Vec<u8>) {
        self.change(|s| {
            s.watched.phase = WatchedPhase::Done;
            s.watched.is_current = true;
            s.watched.report += 1;
            s.report = Some(Arc::new(page));
        });
    }

    /// What was saved cannot be planned, or what was planned cannot be written.
    pub(super) fn failed(&self, text: String) {
        self.change(|s| s.watched.phase = WatchedPhase::Failed { text });
    }

    /// More files on which the page depends.
    pub(super) fn note_files(&self, files: Vec<PathBuf>) {
        self.state().files.extend(files);
    }

    pub(super) fn take_files(&self) -> Vec<PathBuf> {
        std::mem::take(&mut self.state().files)
    }

    /// The state as the page's script takes it.
    pub(super) fn status(&self) -> serde_json::Value {
        let state = self.state();
        serde_json::json!({
            "version": state.version,
            "report": state.watched.report,
            "title": state.watched.title(),
            "html": watch_status(&state.watched),
        })
    }

    pub(super) fn version(&self) -> u64 {
        self.state().version
    }

    /// Name of the scenario.
    pub(super) fn scenario(&self) -> String {
        self.state().watched.scenario.clone()
    }

    /// The picture of the cell, PNG.
    pub(super) fn cell(&self) -> Option<Arc<Vec<u8>>> {
        self.state().cell.clone()
    }

    /// The last report that was made.
    pub(super) fn report(&self) -> Option<Arc<Vec<u8>>> {
        self.state().report.clone()
    }
}
