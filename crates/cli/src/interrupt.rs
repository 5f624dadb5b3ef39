//! Ctrl-C as a wish: long work ends soon and keeps what it has. Pressed again, it is an order. Whoever ends the program in
//! the way of `kill`, as systems do with work that has taken too long, means the same.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// The exit code of who was interrupted, as shells have it.
pub(crate) const EXIT_CODE: u8 = 130;

/// From now on, the first signal turns this true, and the second one ends the program at once.
pub(crate) fn listen() -> io::Result<Arc<AtomicBool>> {
    let is_asked = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order: at the first signal, what ends the program finds that none came before.
        flag::register_conditional_shutdown(signal, EXIT_CODE.into(), Arc::clone(&is_asked))?;
        flag::register(signal, Arc::clone(&is_asked))?;
    }
    Ok(is_asked)
}
