//! How much memory this process has needed, where the system tells (Linux).

use std::fs;

/// Most memory that this process has held at once, MiB; none where the system does not tell.
pub fn peak_memory_mib() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kib / 1024.0)
}

/// Begins the peak anew at what is held now. Where that is not possible the peak stays that of the
/// whole run.
pub fn restart_peak_memory() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn a_large_block_shows_in_the_peak() {
        restart_peak_memory();
        let before = peak_memory_mib().unwrap();
        let block = vec![1u8; 64 << 20];
        assert!(block.iter().step_by(4096).all(|b| *b == 1));
        assert!(peak_memory_mib().unwrap() > before + 32.0);
    }
}
