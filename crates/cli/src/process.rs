//! What this process has taken of the machine so far, as the operating system counts it.
//!
//! Linux tells the peak in `/proc/self/status`: `VmHWM` is the most that was ever resident. `getrusage` tells it on more
//! systems, but there it may be that of the program which started this one.

use cpu_time::ProcessTime;
use serde::Serialize;

/// Time and memory of the process.
#[derive(Serialize)]
pub(crate) struct Taken {
    /// Summed over all threads, those that have ended too.
    cpu_seconds: f64,
    /// The most bytes that were resident at once, where the system tells.
    peak_memory: Option<u64>,
}

impl Taken {
    /// Until now.
    pub(crate) fn now() -> Self {
        Self { cpu_seconds: ProcessTime::now().as_duration().as_secs_f64(), peak_memory: peak_memory() }
    }
}

fn peak_memory() -> Option<u64> {
    high_water_mark(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// The bytes of the line `VmHWM:    1234 kB`.
fn high_water_mark(status: &str) -> Option<u64> {
    let number = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().strip_suffix("kB")?;
    number.trim_end().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_found() {
        let status = "Name:\tpcsg\nVmPeak:\t  234567 kB\nVmHWM:\t    5120 kB\nVmRSS:\t    4096 kB\n";
        assert_eq!(high_water_mark(status), Some(5120 * 1024));
        for status in
            ["", "Name:\tpcsg\n", "VmHWM:\t5120\n", "VmHWM:\t-1 kB\n", "VmHWM:\t99999999999999999 kB\n"]
        {
            assert_eq!(high_water_mark(status), None, "{status}");
        }
    }

    #[test]
    fn the_peak_stays_when_the_memory_is_given_back() {
        const HELD: usize = 64 << 20;
        drop(std::hint::black_box(vec![1_u8; HELD]));
        let Taken { cpu_seconds, peak_memory } = Taken::now();
        assert!(cpu_seconds > 0.0);
        assert_eq!(peak_memory.is_some(), cfg!(target_os = "linux"));
        assert!(peak_memory.is_none_or(|peak| peak > HELD as u64), "{peak_memory:?}");
    }
}
