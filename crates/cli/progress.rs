//! Progress on standard error, silent where that is no terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Work that is over sooner than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A progress bar that appears after a second.
pub(crate) struct Bar {
    bar: ProgressBar,
    begin: Instant,
}

impl Bar {
    /// A bar that is not shown yet.
    pub(crate) fn new(what: &'static str) -> Self {
        let style = ProgressStyle::with_template("{msg} [{wide_bar}] {pos}/{len} ({eta} left)");
        let bar = ProgressBar::new(0).with_message(what);
        bar.set_draw_target(ProgressDrawTarget::hidden());
        Self {
            bar: bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())),
            begin: Instant::now(),
        }
    }

    /// More work has turned up.
    pub(crate) fn expect(&self, more: usize) {
        self.bar.inc_length(more as u64);
    }

    /// One more is done.
    pub(crate) fn advance(&self) {
        self.bar.inc(1);
        self.appear();
    }

    /// So many of so many are done.
    pub(crate) fn set(&self, done: usize, total: usize) {
        if self.bar.length() != Some(total as u64) {
            // Another stage has begun.
            self.bar.reset();
            self.bar.set_length(total as u64);
        }
        // Threads report out of order.
        self.bar.set_position(self.bar.position().max(done as u64));
        self.appear();
    }

    fn appear(&self) {
        if self.bar.is_hidden() && self.begin.elapsed() > PATIENCE {
            // indicatif keeps it hidden where standard error is no terminal.
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Names the present step of a work whose length nobody knows, after a second and on a terminal only.
pub(crate) struct Spinner {
    bar: ProgressBar,
    /// Dropped to wake the thread that waits for patience to end.
    waiting: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Spinner {
    /// A spinner that is not shown yet.
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        bar.set_draw_target(ProgressDrawTarget::hidden());
        let (waiting, patience) = mpsc::channel::<()>();
        let shown = bar.clone();
        // Without the thread nothing is shown, which harms no result.
        let thread = std::thread::Builder::new().spawn(move || {
            if patience.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(Duration::from_millis(100));
            }
        });
        Self { bar, waiting: Some(waiting), thread: thread.ok() }
    }

    /// The next step begins.
    pub(crate) fn step(&self, what: &'static str) {
        self.bar.set_message(what);
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.waiting = None;
        if let Some(thread) = self.thread.take() {
            // It does nothing that could panic, and there is nothing to do about it if it did.
            let _ = thread.join();
        }
        self.bar.finish_and_clear();
    }
}
