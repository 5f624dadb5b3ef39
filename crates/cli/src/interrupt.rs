//! Ctrl-C as a wish: long work ends soon and keeps what it has. Pressed again, it is an order. Whoever ends the program in
//! the way of `kill`, as systems do with work that has taken too long, means the same.
//!
//! Before there is anything to keep, the first one is an order too.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::say;

/// The exit code of who was interrupted, as shells have it.
pub(crate) const EXIT_CODE: u8 = 130;

/// How long it may take until an interruption is noticed. Nobody sees a delay that is shorter.
const BEAT: Duration = Duration::from_millis(30);

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
        std::thread::scope(|scope| {
            let (done, is_done) = channel::<()>();
            scope.spawn(move || {
                while is_done.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
                    if self.is_asked() {
                        say("interrupted before the first ray; nothing was written");
                        std::process::exit(EXIT_CODE.into());
                    }
                }
            });
            // Dropped when the work is done, or has panicked.
            let _done = done;
            work()
        })
    }
}
