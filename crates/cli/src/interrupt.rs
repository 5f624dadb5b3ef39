//! Ctrl-C as a wish: long work ends soon and keeps what it has. Pressed again, it is an order. Whoever ends the program in
//! the way of `kill`, as systems do with work that has taken too long, means the same.
//!
//! Before there is anything to keep, the first one is an order too.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::say;

/// The exit code of who was interrupted, as shells have it.
pub(crate) const EXIT_CODE: u8 = 130;

/// How long it may take until an interruption is noticed. Nobody sees a delay that is shorter.
const BEAT: Duration = Duration::from_millis(30);

/// How long nobody wonders whether an interruption was noticed.
const PATIENCE: Duration = Duration::from_secs(1);

/// Whether someone has interrupted.
#[derive(Default)]
pub(crate) struct Interrupt {
    is_asked: Arc<AtomicBool>,
}

impl Interrupt {
    /// From now on, the first signal is remembered, and the second one ends the program at once.
    pub(crate) fn listen() -> io::Result<Self> {
        let is_asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: at the first signal, what ends the program finds that none came before.
            flag::register_conditional_shutdown(signal, EXIT_CODE.into(), Arc::clone(&is_asked))?;
            flag::register(signal, Arc::clone(&is_asked))?;
        }
        Ok(Self { is_asked })
    }

    /// Whether it is time to end and to keep what there is.
    pub(crate) fn is_asked(&self) -> bool {
        self.is_asked.load(Ordering::Relaxed)
    }

    /// Does work of which nothing can be kept: an interruption ends the program.
    pub(crate) fn or_end<T>(&self, work: impl FnOnce() -> T) -> T {
        let end = || {
            say("interrupted before the first ray; nothing was written");
            std::process::exit(EXIT_CODE.into());
        };
        self.watched(Duration::ZERO, end, work)
    }

    /// Does work that ends soon after an interruption. Says so if that is not as soon as one would think.
    pub(crate) fn or_soon<T>(&self, work: impl FnOnce() -> T) -> T {
        let promise =
            || say("interrupted; ends with the pixels that are under way, or at once if interrupted again");
        self.watched(PATIENCE, promise, work)
    }

    /// Does work, and something else if it has not ended so long after an interruption.
    fn watched<T>(&self, patience: Duration, then: impl FnOnce() + Send, work: impl FnOnce() -> T) -> T {
        std::thread::scope(|scope| {
            let (done, is_done) = channel::<()>();
            scope.spawn(move || {
                let mut asked = None;
                while is_done.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
                    let mut since = || *asked.get_or_insert_with(Instant::now);
                    if self.is_asked() && since().elapsed() >= patience {
                        return then();
                    }
                }
            });
            // Dropped when the work is done, or has panicked.
            let _done = done;
            work()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_longer_than_patience_is_spoken_of() {
        for (is_asked, patience, expected) in
            [(true, Duration::ZERO, true), (true, Duration::MAX, false), (false, Duration::ZERO, false)]
        {
            let interrupt = Interrupt { is_asked: Arc::new(AtomicBool::new(is_asked)) };
            let is_said = AtomicBool::new(false);
            let say = || is_said.store(true, Ordering::Relaxed);
            // Work that ends when it is spoken of, or when it is clear that it is not.
            let work = || {
                let start = Instant::now();
                while !is_said.load(Ordering::Relaxed) && (expected || start.elapsed() < 5 * BEAT) {
                    std::thread::sleep(BEAT / 10);
                }
                7
            };
            assert_eq!(interrupt.watched(patience, say, work), 7);
            assert_eq!(is_said.load(Ordering::Relaxed), expected);
        }
    }
}
