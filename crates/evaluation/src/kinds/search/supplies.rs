//! What shards of a search are given: the programs of a block and the controls on it, which take longer to make than a shard of
//! the candidates takes.

use super::block::{Block, Entry};
use super::settings::SearchExperiment;
use super::sweep::{Control, Sweep};
use super::workload::Workload;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::ViewRecord;
use crate::provenance::sha256;
use crate::shards::{self, Raw, Task};
use moment_problem::fast_simplex::{FastFragment, FunctionTable, SupportDistribution};
use moment_problem::lane_simplex::FunctionSpan;
use serde::{Deserialize, Serialize};

/// Name of what all rounds need.
const ALL: &str = "search";

/// What selections need of all blocks.
#[derive(Deserialize, Serialize)]
struct Common {
    digest: String,
    /// The family on the support, whose values in double-double take longer than a small shard.
    table: FunctionTable,
    span: FunctionSpan,
    views: Vec<ViewRecord>,
    /// By block and view.
    sampled: Vec<Vec<u32>>,
    idle: Vec<Vec<f64>>,
}

/// A block in the order in which it is worked on.
#[derive(Deserialize, Serialize)]
struct Supply<C> {
    /// By kernel: number of depths.
    lengths: Raw<u16>,
    /// Indices into the support and weights, kernel after kernel.
    indices: Raw<u16>,
    weights: Raw<f64>,
    /// By fragment.
    kernels: Raw<u32>,
    steps: Raw<u16>,
    masses: Raw<f64>,
    views: Raw<u16>,
    counts: Raw<u32>,
    references: Raw<f64>,
    /// Of the kernels, as the solver takes them.
    coordinates: Raw<f64>,
    /// By order.
    controls: Vec<C>,
}

fn name(block: usize) -> String {
    format!("{ALL}-block-{block}")
}

/// Controls by order and block, and coordinates of kernels by block.
pub(super) type Solved = (Vec<Vec<Control>>, Vec<Vec<f64>>);

/// What a task works with: everything, or what was supplied to it.
pub(super) struct Given {
    pub(super) workload: Workload,
    /// None where controls are to be solved.
    pub(super) solved: Option<Solved>,
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
                let (workload, solved) = self.supplied(common, supply)?;
                return Ok(Given { workload, solved: Some(solved), inputs });
            }
        }
        let workload = Workload::prepare(self)?;
        let inputs = inputs(&workload.digest());
        Ok(Given { workload, solved: None, inputs })
    }

    /// Blocks without programs, but for the one that was supplied.
    fn supplied(
        &self,
        common: Common,
        supply: Option<(usize, Supply<Control>)>,
    ) -> Result<(Workload, Solved), EvaluationError> {
        let blocks = common.sampled.into_iter().zip(common.idle);
        let mut blocks: Vec<Block> =
            blocks.map(|(sampled, idle)| Block { sampled, idle, ..Block::default() }).collect();
        let mut controls: Vec<Vec<Control>> =
            self.orders.iter().map(|_| blocks.iter().map(|_| Control::default()).collect()).collect();
        let mut coordinates = vec![Vec::new(); blocks.len()];
        if let Some((number, supply)) = supply
            && let Some(block) = blocks.get_mut(number)
        {
            let mut scratch = Vec::new();
            let mut depths = supply.indices.0.iter().zip(&supply.weights.0);
            let cells = self.cells;
            let kernel = |&length: &u16| {
                let depths = depths.by_ref().take(length.into());
                let depths = depths.map(|(&index, &weight)| (f64::from(index) / cells as f64, weight));
                SupportDistribution::snapped(depths, cells, &mut scratch)
            };
            block.kernels = supply.lengths.0.iter().map(kernel).collect();
            let fragments = supply.kernels.0.iter().zip(&supply.steps.0).zip(&supply.masses.0);
            let fragment = |((&kernel, &step), &mass_before)| FastFragment { kernel, step, mass_before };
            block.fragments = fragments.map(fragment).collect();
            let entries = supply.views.0.iter().zip(&supply.counts.0).zip(&supply.references.0);
            let entry = |((&view, &count), &reference)| Entry { view, count, reference };
            block.entries = entries.map(entry).collect();
            coordinates[number] = supply.coordinates.0;
            for (of_order, control) in controls.iter_mut().zip(supply.controls) {
                of_order[number] = control;
            }
        }
        let sampled = Some((common.table, common.span));
        let workload = Workload::without_scenes(self, blocks, common.views, sampled)?;
        Ok((workload, (controls, coordinates)))
    }

    /// Writes down what later tasks need, before the first round.
    pub(super) fn supply(&self, context: &RunContext<'_>, sweep: &Sweep<'_>) -> Result<(), EvaluationError> {
        let workload = sweep.workload;
        let all = Common {
            digest: workload.digest(),
            table: workload.table.clone(),
            span: workload.span.clone(),
            views: workload.views.clone(),
            sampled: workload.blocks.iter().map(|block| block.sampled.clone()).collect(),
            idle: workload.blocks.iter().map(|block| block.idle.clone()).collect(),
        };
        for (number, block) in workload.blocks.iter().enumerate() {
            let kernels = || block.kernels.iter();
            let (fragments, entries) = (|| block.fragments.iter(), || block.entries.iter());
            let coordinates =
                sweep.batch(number).map_or_else(Vec::new, |batch| batch.all_coordinates().to_vec());
            let content = Supply {
                lengths: Raw(kernels().map(|kernel| kernel.indices().len() as u16).collect()),
                indices: Raw(kernels().flat_map(SupportDistribution::indices).copied().collect()),
                weights: Raw(kernels().flat_map(SupportDistribution::weights).copied().collect()),
                kernels: Raw(fragments().map(|fragment| fragment.kernel).collect()),
                steps: Raw(fragments().map(|fragment| fragment.step).collect()),
                masses: Raw(fragments().map(|fragment| fragment.mass_before).collect()),
                views: Raw(entries().map(|entry| entry.view).collect()),
                counts: Raw(entries().map(|entry| entry.count).collect()),
                references: Raw(entries().map(|entry| entry.reference).collect()),
                coordinates: Raw(coordinates),
                controls: sweep.controls.iter().filter_map(|of_order| of_order.get(number)).collect(),
            };
            shards::supply(context, &name(number), &content)?;
        }
        // Last: whoever finds it finds the others.
        shards::supply(context, ALL, &all)
    }
}
