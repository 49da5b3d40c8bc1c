//! The end by a signal, or with the process that started this one: at once, with whole files and a word on how to go on.

use std::io::{IsTerminal as _, Read as _};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{flag, low_level};

use crate::files::{self, OutputFolder};
use crate::measure::Journal;
use crate::progress;

/// How often it is looked whether a signal has come.
const PATIENCE: Duration = Duration::from_millis(50);

/// Where what is measured is kept.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    /// The folder of results.
    pub(super) folder: Arc<OutputFolder>,
    /// Whether it was named, so that the same command finds it again.
    pub(super) named: bool,
}

/// The signal that has come; 0 if none has.
static SIGNAL: AtomicUsize = AtomicUsize::new(0);

/// Whether who works looks for signals by itself.
static TAKEN_OVER: AtomicBool = AtomicBool::new(false);

/// What is to be said at the end.
static KEPT: Mutex<Option<Kept>> = Mutex::new(None);

/// What is waited for.
static WAITS: Mutex<Option<String>> = Mutex::new(None);

/// How the line begins that tells of a wait that was ended.
pub(super) const WAITED: &str = "stopped while it waited";

/// Ends this process from now on when SIGINT or SIGTERM comes; with `until_stdin_ends` also when standard input ends, a pipe that the
/// process which started this one holds as long as it lives.
pub(super) fn watch(until_stdin_ends: bool) {
    for number in [SIGINT, SIGTERM] {
        // Where it cannot be caught it ends the process as it always does.
        let _ = flag::register_usize(number, &SIGNAL, number as usize);
    }
    thread::spawn(|| {
        loop {
            thread::sleep(PATIENCE);
            let number = SIGNAL.load(Ordering::SeqCst);
            if number != 0 && !TAKEN_OVER.load(Ordering::SeqCst) {
                end(number);
            }
        }
    });
    if until_stdin_ends {
        thread::spawn(|| {
            let mut stdin = std::io::stdin().lock();
            while stdin.read(&mut [0; 64]).is_ok_and(|read| read > 0) {}
            SIGNAL.store(SIGTERM as usize, Ordering::SeqCst);
        });
    }
}

/// Sets what is kept if the process ends now.
pub(super) fn keeps(kept: Option<Kept>) {
    *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = kept;
}

/// Sets what is waited for; nothing is any more with `None`.
pub(super) fn waits(what: Option<String>) {
    *WAITS.lock().unwrap_or_else(PoisonError::into_inner) = what;
}

/// From now on who works asks by [`asked`] whether to end.
pub(super) fn take_over() {
    TAKEN_OVER.store(true, Ordering::SeqCst);
}

/// Whether a signal has come.
pub(super) fn asked() -> bool {
    SIGNAL.load(Ordering::SeqCst) != 0
}

/// The signal that has come, if one has; the next one ends the process at once again.
pub(super) fn hand_back() -> Option<usize> {
    let number = SIGNAL.swap(0, Ordering::SeqCst);
    TAKEN_OVER.store(false, Ordering::SeqCst);
    (number != 0).then_some(number)
}

/// Ends the process as a signal does, with a word on what is kept.
pub(super) fn end(number: usize) -> ! {
    let _whole = files::stop_writing();
    // A bar has left its line open.
    let open = if std::io::stderr().is_terminal() { "\n" } else { "" };
    if let Some(what) = WAITS.lock().unwrap_or_else(PoisonError::into_inner).take() {
        progress::to_stderr(&format!("{open}{WAITED}: {what}"));
    }
    // Held until the end: to close the folder would wait for those that write.
    let kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(kept) = &*kept {
        progress::to_stderr(&format!("{open}{}", leave(kept)));
    }
    // Destructors of drivers would run beside their own threads on any other way out.
    let _ = low_level::emulate_default_handler(number as i32);
    low_level::exit(1)
}

/// Takes away what is of no use, and says what is kept.
fn leave(kept: &Kept) -> String {
    if Journal::holds_in(&kept.folder) {
        return kept_line(&kept.folder, kept.named);
    }
    Journal::take_away(&kept.folder);
    kept.folder.abandon();
    format!("stopped before any interleaved set had ended: nothing is kept in {}", kept.folder.path().display())
}

/// How to go on.
pub(super) fn kept_line(folder: &OutputFolder, named: bool) -> String {
    let folder = folder.path().display();
    let out = if named { String::new() } else { format!("--out {folder} ") };
    format!("stopped; what was measured is kept in {folder}: go on with {out}--resume")
}
