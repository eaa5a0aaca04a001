//! Standard output, and whether anything that was printed there is lost.

use std::fmt::Arguments;
use std::io::{self, Write as _};
use std::sync::Mutex;

/// The first failure of a print.
static LOST: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints.
pub(super) fn print(text: Arguments) {
    note(io::stdout().write_fmt(text));
}

/// Prints bytes as they are.
pub(super) fn print_bytes(bytes: &[u8]) {
    note(io::stdout().write_all(bytes));
}

/// Why something that was printed did not arrive; none where all did, or where the reader has gone
/// (`| head`), which is no fault.
pub(super) fn lost() -> Option<String> {
    note(io::stdout().flush());
    LOST.lock().ok()?.as_ref().map(ToString::to_string)
}

fn note(result: io::Result<()>) {
    if let Err(e) = result
        && e.kind() != io::ErrorKind::BrokenPipe
        && let Ok(mut lost) = LOST.lock()
    {
        lost.get_or_insert(e);
    }
}
