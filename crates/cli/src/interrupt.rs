//! Ctrl-C as a wish: long work ends soon and keeps what it has. Pressed again, it is an order.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::SIGINT;
use signal_hook::flag;

/// The exit code of who was interrupted, as shells have it.
pub(crate) const EXIT_CODE: u8 = 130;

/// From now on, the first Ctrl-C turns this true, and the second one ends the program at once.
pub(crate) fn listen() -> io::Result<Arc<AtomicBool>> {
    let is_asked = Arc::new(AtomicBool::new(false));
    // In this order: at the first signal, what ends the program finds that none came before.
    flag::register_conditional_shutdown(SIGINT, EXIT_CODE.into(), Arc::clone(&is_asked))?;
    flag::register(SIGINT, Arc::clone(&is_asked))?;
    Ok(is_asked)
}
