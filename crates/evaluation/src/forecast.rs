//! What an experiment will cost in shards, before anybody begins.

use crate::error::EvaluationError;
use crate::experiment::Experiment;
use crate::experiment::kind::RunContext;
use crate::run::{Backend, pool};
use crate::shards::Task;
use serde::Serialize;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// What shards will cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// What was measured for it, in words.
    pub measured: String,
    /// Rounds.
    pub rounds: usize,
    /// Pieces of the first round.
    pub pieces: u64,
    /// Hours on one core.
    pub core_hours: f64,
    /// Hours of the longest shard of the first round, on the threads of a task.
    pub task_hours: f64,
    /// Bytes of memory of a task.
    pub memory_bytes: u64,
    /// Bytes of all files of all rounds.
    pub disk_bytes: u64,
}

/// Peak of this process's memory, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? << 10)
}

impl Experiment {
    /// What so many shards of so many threads each will cost: measured on some candidates of a search, or on one piece of the
    /// first round, which takes as long as that piece takes.
    ///
    /// # Errors
    /// As [`Experiment::run`]; [`EvaluationError::Value`] for an experiment that cannot be divided.
    pub fn forecast(
        &self,
        shards: usize,
        threads: usize,
        backend: Backend,
    ) -> Result<Forecast, EvaluationError> {
        let (threads, pool) = pool(Some(threads))?;
        let rounds = self.rounds();
        if rounds == 0 {
            return Err(self.refused("dividing into shards"));
        }
        let shards = shards.max(1) as f64;
        if let Some(prediction) = pool.install(|| self.settings.predict(threads, backend)) {
            let p = prediction?;
            let of_all = p.programs as f64 / (p.programs + p.later_programs).max(1) as f64;
            return Ok(Forecast {
                measured: format!("{:.3e} linear programs a second on one thread", p.programs_per_second),
                rounds,
                pieces: p.candidates,
                core_hours: p.hours * threads as f64,
                task_hours: p.hours * of_all / shards,
                memory_bytes: p.memory_bytes,
                disk_bytes: 2 * p.disk_bytes + rounds as u64 * p.memory_bytes / 4,
            });
        }
        let measured = Mutex::new(None);
        let context = RunContext {
            progress: &|_, _| (),
            directory: Path::new("."),
            task: Task::Measure(&measured),
            keeps_findings: false,
            backend,
            identity: String::new(),
            started: Instant::now(),
        };
        pool.install(|| self.settings.run(&context))?;
        let found = measured.into_inner().unwrap_or_else(PoisonError::into_inner);
        let found = found.ok_or_else(|| EvaluationError::Value("there is nothing to divide".to_owned()))?;
        let [cost, most, all] = found.cost.map(|cost| cost as f64);
        let hours = found.seconds / cost.max(1.0) / 3600.0;
        Ok(Forecast {
            measured: format!(
                "one of {} pieces took {:.1} s on {threads} threads",
                found.pieces, found.seconds
            ),
            rounds,
            pieces: found.pieces as u64,
            core_hours: hours * all * threads as f64,
            // A shard has no less than the largest piece.
            task_hours: hours * (all / shards).max(most),
            memory_bytes: peak_memory().unwrap_or(0),
            disk_bytes: (found.bytes * found.pieces) as u64,
        })
    }
}
