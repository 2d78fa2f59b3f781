//! Progress on standard error, silent where that is no terminal.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};

/// Work that is over sooner than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A progress bar that appears after a second.
pub struct Bar {
    bar: ProgressBar,
    begin: Instant,
}

impl Bar {
    /// A bar that is not shown yet.
    pub fn new(what: &'static str) -> Self {
        let style = ProgressStyle::with_template("{msg} [{bar:40}] {pos}/{len} ({eta} left)");
        let bar = ProgressBar::no_length().with_message(what);
        bar.set_draw_target(indicatif::ProgressDrawTarget::hidden());
        Self {
            bar: bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())),
            begin: Instant::now(),
        }
    }

    /// One more of `total` is done.
    pub fn advance(&self, total: usize) {
        self.bar.set_length(total as u64);
        self.bar.inc(1);
        if self.bar.is_hidden() && self.begin.elapsed() > PATIENCE {
            // indicatif keeps it hidden where standard error is no terminal.
            self.bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
