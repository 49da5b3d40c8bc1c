//! Progress on stderr.

use std::io::{self, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle, TermLike};

/// Between the lines of one bar where there is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

/// Writes a line to stderr. If nobody can read it any more, the work goes on.
pub fn to_stderr(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
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

    /// A bar over `length` units of work; it clears itself when dropped. Without a terminal it is a line every ten seconds.
    pub fn bar(&self, what: &str, length: u64) -> ProgressBar {
        let terminal = ProgressDrawTarget::stderr();
        let (target, template) = if self.quiet {
            (ProgressDrawTarget::hidden(), "")
        } else if terminal.is_hidden() {
            let drawn = Mutex::new((String::new(), Instant::now()));
            let lines = Lines { between: BETWEEN_LINES, tell: to_stderr, drawn };
            (ProgressDrawTarget::term_like(Box::new(lines)), LINE)
        } else {
            (terminal, "  {msg} {wide_bar} {pos}/{len} {left}")
        };
        let bar = ProgressBar::with_draw_target(Some(length), target);
        if let Ok(style) = style(template) {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        bar.enable_steady_tick(Duration::from_millis(250));
        bar.with_finish(indicatif::ProgressFinish::AndClear)
    }
}

/// A bar as a line.
const LINE: &str = "  {msg}: {percent} %, about {left} left";

/// A style whose `left` is what is left at the mean pace so far: indicatif's own estimate of few long steps grows without end.
fn style(template: &str) -> Result<ProgressStyle, indicatif::style::TemplateError> {
    let left = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        let share = state.len().unwrap_or(0) as f64 / state.pos().max(1) as f64 - 1.0;
        let _ = write!(out, "{:#}", HumanDuration(state.elapsed().mul_f64(share.max(0.0))));
    };
    Ok(ProgressStyle::with_template(template)?.with_key("left", left))
}

/// What stands for a terminal where there is none: what would be drawn over and over is told as a line now and then.
#[derive(Debug)]
struct Lines {
    between: Duration,
    tell: fn(&str),
    /// What was drawn since the last flush, and when a line was told or, before the first one, when the work began.
    drawn: Mutex<(String, Instant)>,
}

impl TermLike for Lines {
    fn width(&self) -> u16 {
        120
    }

    fn move_cursor_up(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.write_str(text)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        self.drawn.lock().unwrap_or_else(PoisonError::into_inner).0.push_str(text);
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        let mut drawn = self.drawn.lock().unwrap_or_else(PoisonError::into_inner);
        let line = std::mem::take(&mut drawn.0);
        if !line.trim().is_empty() && drawn.1.elapsed() >= self.between {
            drawn.1 = Instant::now();
            (self.tell)(line.trim_end());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static TOLD: Mutex<Vec<String>> = Mutex::new(Vec::new());

    fn note(line: &str) {
        TOLD.lock().unwrap().push(line.to_owned());
    }

    /// Proves that work without a terminal is told in whole lines with its share, and that a line is not told before its time.
    #[test]
    fn without_a_terminal_there_are_lines_now_and_then() {
        for (between, lines) in [(Duration::ZERO, 2), (Duration::from_secs(3600), 0)] {
            TOLD.lock().unwrap().clear();
            let drawn = Mutex::new((String::new(), Instant::now()));
            let target = ProgressDrawTarget::term_like(Box::new(Lines { between, tell: note, drawn }));
            let bar = ProgressBar::with_draw_target(Some(8), target).with_message("ground truth");
            bar.set_style(style(LINE).unwrap());
            for done in [2, 4] {
                bar.set_position(done);
                bar.force_draw();
            }
            let told = TOLD.lock().unwrap().clone();
            let shares = ["  ground truth: 25 %, about ", "  ground truth: 50 %, about "];
            assert!(shares[..lines].iter().all(|share| told.iter().any(|line| line.starts_with(share))), "{told:?}");
            assert!(lines > 0 || told.is_empty(), "{told:?}");
        }
    }
}
