//! What a run will cost, for kinds that can tell.

use serde::Serialize;

/// What a search will cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Candidates of all orders.
    pub candidates: u64,
    /// Linear programs of the first block.
    pub programs: u64,
    /// Linear programs of the later blocks, if one candidate in fifty stays in the race at each.
    pub later_programs: u64,
    /// Programs a second on one thread, measured on some candidates.
    pub programs_per_second: f64,
    /// Threads.
    pub threads: usize,
    /// Hours on these threads.
    pub hours: f64,
    /// Bytes of checkpoint and tables.
    pub disk_bytes: u64,
    /// Bytes of memory of a shard of the largest block.
    pub memory_bytes: u64,
    /// What a graphics processor would take, where one is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub card: Option<CardPrediction>,
}

/// What a search will cost on a graphics processor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CardPrediction {
    /// Adapter and driver.
    pub adapter: String,
    /// Programs a second, those that the CPU decides included, measured on some candidates.
    pub programs_per_second: f64,
    /// Share of the programs that is left to the exact route of the CPU.
    pub exact: f64,
    /// Hours.
    pub hours: f64,
}
