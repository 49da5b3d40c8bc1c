//! Progress on stderr.

use std::io::Write as _;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Writes a line to stderr. If nobody can read it any more, the work goes on.
pub fn to_stderr(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Shows what takes long, unless told to be quiet. On a terminal as a bar, elsewhere as plain lines.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    quiet: bool,
}

impl Progress {
    /// `quiet` shows nothing.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// A line about what happens now.
    pub fn say(&self, message: &str) {
        if !self.quiet {
            to_stderr(message);
        }
    }

    /// A bar over `length` units of work; it clears itself when dropped.
    pub fn bar(&self, what: &str, length: u64) -> ProgressBar {
        let target = if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(length), target);
        if let Ok(style) = ProgressStyle::with_template("  {msg} {wide_bar} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        bar.enable_steady_tick(Duration::from_millis(250));
        bar.with_finish(indicatif::ProgressFinish::AndClear)
    }
}
