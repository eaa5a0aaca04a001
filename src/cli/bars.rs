//! Tables and bars on the terminal: plain text, coloured only where somebody watches and wants it.

use comfy_table::{Cell, CellAlignment, Color, Table, presets};
use std::io::IsTerminal;

/// Characters of a bar that stands for all of the time.
const WIDTH: usize = 12;

/// A table without lines. Colours only on a terminal, and not where `NO_COLOR` is set.
pub(super) fn table(header: &[&str], right: &[usize]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header.iter().copied());
    if !wants_colour() {
        table.force_no_tty();
    }
    for column in right {
        if let Some(c) = table.column_mut(*column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// Whether somebody watches who wants more than plain text (<https://no-color.org>).
fn wants_colour() -> bool {
    let is_refused = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    std::io::stdout().is_terminal() && !is_refused
}

/// Text in bold where it is watched.
pub(super) fn bold(text: &str) -> String {
    if wants_colour() { format!("\u{1b}[1m{text}\u{1b}[0m") } else { text.to_owned() }
}

/// A share as a bar of blocks, to an eighth of a character; what is above zero is never empty.
pub(super) fn bar(share: f64) -> String {
    const PARTS: [char; 8] = [' ', '▏', '▎', '▍', '▌', '▋', '▊', '▉'];
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    let eighths = ((share * (WIDTH * 8) as f64).round() as usize).max(usize::from(share > 0.0));
    let mut text = "█".repeat(eighths / 8);
    if eighths % 8 > 0 {
        text.push(PARTS[eighths % 8]);
    }
    text + &"·".repeat(WIDTH - eighths.div_ceil(8))
}

/// The bar of a share of time that nobody wants, coloured by how large it is.
pub(super) fn bad_share(share: f64) -> Cell {
    let color = match share {
        s if s < 0.1 => Color::Green,
        s if s < 0.5 => Color::Yellow,
        _ => Color::Red,
    };
    Cell::new(bar(share)).fg(color)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_share() {
        for share in [0.0, 0.001, 0.4, 0.5, 1.0, 7.0, f64::NAN] {
            assert_eq!(bar(share).chars().count(), WIDTH, "{share}");
        }
        assert_eq!(bar(0.5), "██████······");
        assert_eq!(bar(1.0), "█".repeat(WIDTH));
        assert_eq!(bar(0.001), "▏···········");
        assert_eq!(bar(0.0), "·".repeat(WIDTH));
    }
}
