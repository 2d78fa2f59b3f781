//! What shards of a search are given: the programs of a block and the controls on it, which take longer to make than a shard of
//! the candidates takes.

use super::settings::SearchExperiment;
use super::sweep::{Control, Sweep};
use super::workload::{Block, Entry, Workload};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::ViewRecord;
use crate::provenance::sha256;
use crate::shards::{self, Task};
use moment_problem::fast_simplex::{FastFragment, SupportDistribution};
use serde::{Deserialize, Serialize};

/// Name of what all rounds need.
const ALL: &str = "search";

/// What selections need of all blocks.
#[derive(Deserialize, Serialize)]
struct Common {
    digest: String,
    views: Vec<ViewRecord>,
    /// By block and view.
    sampled: Vec<Vec<u32>>,
    idle: Vec<Vec<f64>>,
}

/// A block in the order in which it is worked on.
#[derive(Deserialize, Serialize)]
struct Supply<C> {
    /// By kernel: number of depths.
    lengths: Vec<u16>,
    /// Indices into the support and weights, kernel after kernel.
    indices: Vec<u16>,
    weights: Vec<f64>,
    /// By fragment: kernel, step, F_Z, view, count, F.
    fragments: Vec<(u32, u16, f64, u16, u32, f64)>,
    /// By order.
    controls: Vec<C>,
}

fn name(block: usize) -> String {
    format!("{ALL}-block-{block}")
}

/// What a task works with: everything, or what was supplied to it.
pub(super) struct Given {
    pub(super) workload: Workload,
    /// By order and block; none where they are to be solved.
    pub(super) controls: Option<Vec<Vec<Control>>>,
    /// Stands for program, experiment and workload.
    pub(super) inputs: String,
}

impl SearchExperiment {
    /// What the task needs, from the folder that shards share where it lies there.
    pub(super) fn given(&self, context: &RunContext<'_>) -> Result<Given, EvaluationError> {
        let inputs = |digest: &str| sha256(format!("{} {digest}", context.identity).as_bytes());
        let wanted = match context.task {
            Task::Part { round, .. } => Some(Some(round)),
            Task::Select { round, .. } if round > 0 => Some(None),
            Task::Select { .. } | Task::Whole | Task::Shard(_) | Task::Merge { .. } | Task::Measure(_) => {
                None
            }
        };
        if let Some(block) = wanted
            && let Some(common) = shards::supplied::<Common>(context, ALL)?
        {
            let inputs = inputs(&common.digest);
            let supply = match block {
                Some(block) => {
                    shards::supplied::<Supply<Control>>(context, &name(block))?.map(|supply| (block, supply))
                }
                None => None,
            };
            if block.is_none() || supply.is_some() {
                let (workload, controls) = self.supplied(common, supply)?;
                return Ok(Given { workload, controls: Some(controls), inputs });
            }
        }
        let workload = Workload::prepare(self)?;
        let inputs = inputs(&workload.digest());
        Ok(Given { workload, controls: None, inputs })
    }

    /// Blocks without programs, but for the one that was supplied.
    fn supplied(
        &self,
        common: Common,
        supply: Option<(usize, Supply<Control>)>,
    ) -> Result<(Workload, Vec<Vec<Control>>), EvaluationError> {
        let blocks = common.sampled.into_iter().zip(common.idle);
        let mut blocks: Vec<Block> =
            blocks.map(|(sampled, idle)| Block { sampled, idle, ..Block::default() }).collect();
        let mut controls: Vec<Vec<Control>> =
            self.orders.iter().map(|_| blocks.iter().map(|_| Control::default()).collect()).collect();
        if let Some((number, Supply { lengths, indices, weights, fragments, controls: solved })) = supply
            && let Some(block) = blocks.get_mut(number)
        {
            let mut scratch = Vec::new();
            let mut depths = indices.iter().zip(&weights);
            let cells = self.cells;
            block.kernels = lengths
                .iter()
                .map(|&length| {
                    let depths = depths.by_ref().take(length.into());
                    let depths = depths.map(|(&index, &weight)| (f64::from(index) / cells as f64, weight));
                    SupportDistribution::snapped(depths, cells, &mut scratch)
                })
                .collect();
            for (kernel, step, mass_before, view, count, reference) in fragments {
                block.fragments.push(FastFragment { kernel, step, mass_before });
                block.entries.push(Entry { view, count, reference });
            }
            for (of_order, control) in controls.iter_mut().zip(solved) {
                of_order[number] = control;
            }
        }
        Ok((Workload::without_scenes(self, blocks, common.views)?, controls))
    }

    /// Writes down what later tasks need, before the first round.
    pub(super) fn supply(&self, context: &RunContext<'_>, sweep: &Sweep<'_>) -> Result<(), EvaluationError> {
        let workload = sweep.workload;
        let all = Common {
            digest: workload.digest(),
            views: workload.views.clone(),
            sampled: workload.blocks.iter().map(|block| block.sampled.clone()).collect(),
            idle: workload.blocks.iter().map(|block| block.idle.clone()).collect(),
        };
        for (number, block) in workload.blocks.iter().enumerate() {
            let kernels = || block.kernels.iter();
            let content = Supply {
                lengths: kernels().map(|kernel| kernel.indices().len() as u16).collect(),
                indices: kernels().flat_map(SupportDistribution::indices).copied().collect(),
                weights: kernels().flat_map(SupportDistribution::weights).copied().collect(),
                fragments: block
                    .fragments
                    .iter()
                    .zip(&block.entries)
                    .map(|(f, e)| (f.kernel, f.step, f.mass_before, e.view, e.count, e.reference))
                    .collect(),
                controls: sweep.controls.iter().filter_map(|of_order| of_order.get(number)).collect(),
            };
            shards::supply(context, &name(number), &content)?;
        }
        // Last: whoever finds it finds the others.
        shards::supply(context, ALL, &all)
    }
}
