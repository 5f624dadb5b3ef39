//! What long work shows on a terminal. Elsewhere it would only fill a log, and nothing is shown.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::say;

/// Work that is done sooner shows no bar.
const PATIENCE: Duration = Duration::from_millis(700);

/// How often a spinner moves.
const BEAT: Duration = Duration::from_millis(120);

/// A bar for work whose end is known. It disappears when it is dropped.
pub(crate) struct Bar {
    bar: ProgressBar,
    start: Instant,
}

impl Bar {
    pub(crate) fn new(total: u64) -> Self {
        let style = ProgressStyle::with_template("{percent:>3} % {wide_bar} {elapsed} elapsed, {eta} to go");
        let bar = ProgressBar::with_draw_target(Some(total), target());
        Self { bar: bar.with_style(style.expect("the template is sound")), start: Instant::now() }
    }

    pub(crate) fn show(&self, done: u64) {
        if self.start.elapsed() > PATIENCE {
            self.bar.set_position(done);
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A sign of life for work that is long but says nothing of its end. It disappears when it is dropped.
pub(crate) struct Spinner(ProgressBar);

impl Spinner {
    pub(crate) fn new(message: impl Into<Cow<'static, str>>) -> Self {
        let style = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
        let bar =
            ProgressBar::with_draw_target(None, target()).with_style(style.expect("the template is sound"));
        bar.set_message(message);
        bar.enable_steady_tick(BEAT);
        Self(bar)
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Says that something is done, to who is watching.
pub(crate) fn tell(line: impl Display) {
    if std::io::stderr().is_terminal() {
        say(line);
    }
}

fn target() -> ProgressDrawTarget {
    if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() }
}
