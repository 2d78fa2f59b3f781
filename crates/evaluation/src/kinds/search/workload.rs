//! What every candidate is judged on: distinct kernels and the fragments that need a linear program.

use super::block::{Block, Entry, block_of};
use super::settings::{SearchExperiment, SearchReference};
use crate::error::EvaluationError;
use crate::fragments::{Lit, LoadedScene, ReferenceRecord, ViewRecord, chosen, reference_records};
use crate::statistics::{NOTHING, Running};
use applications::{Application, BiasSetting, HardShadow, truths};
use moment_problem::fast_simplex::{FastFragment, FunctionTable, SupportDistribution, snap};
use moment_problem::lane_simplex::FunctionSpan;
use moment_problem::{Basis, BasisFunction};
use rayon::prelude::*;
use scenes::LightView;
use sha2::{Digest, Sha256};
use shadow_filtering::{DepthMap, Kernel, Receiver, Technique};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Fragments that are prepared at a time; bounds the memory for what is not kept.
const CHUNK: usize = 16_384;

/// All blocks, and what the kernels' depths lie on.
pub(crate) struct Workload {
    pub(crate) table: FunctionTable,
    pub(crate) span: FunctionSpan,
    /// Functions of the family; the table has more where power moments are not among them.
    pub(crate) members: usize,
    /// Index into the table of z^(k+1).
    pub(crate) powers: Vec<usize>,
    /// Indices into the table of sines and cosines of 2 pi z, 4 pi z, ..., as many as the largest candidates need.
    pub(crate) waves: Vec<usize>,
    pub(crate) blocks: Vec<Block>,
    pub(crate) views: Vec<ViewRecord>,
    pub(crate) marks: Vec<MarkErrors>,
    pub(crate) references: Vec<ReferenceRecord>,
}

/// A closed form on the whole sample, by view.
pub(crate) struct MarkErrors {
    pub(crate) name: String,
    /// |G - F| with depths where they are.
    pub(crate) exact: Vec<Running>,
    /// |G - F| with depths moved to the support.
    pub(crate) moved: Vec<Running>,
    /// The difference, moved minus exact.
    pub(crate) difference: Vec<Running>,
}

/// One fragment of the sample.
struct Sampled {
    kernel: SupportDistribution,
    step: u16,
    mass_before: f64,
    reference: f64,
    /// By mark: exact, moved.
    marks: Vec<(f64, f64)>,
}

impl Workload {
    /// Programs of all blocks, on all views.
    pub(crate) fn prepare(experiment: &SearchExperiment) -> Result<Self, EvaluationError> {
        let mut techniques = Vec::new();
        for mark in &experiment.mark {
            if let Some(method) = &mark.method {
                techniques.push(method.build().map_err(|error| mark.failure(error))?);
            }
        }
        let mut builder = Builder {
            experiment,
            kernel: experiment.scenery.filter()?,
            techniques,
            known: vec![Known::default(); experiment.blocks],
            blocks: std::iter::repeat_with(Block::default).take(experiment.blocks).collect(),
            views: Vec::new(),
            marks: Vec::new(),
            references: Vec::new(),
        };
        let named = experiment.mark.iter().map(|mark| mark.name.as_str());
        builder.marks.extend(named.chain([NOTHING]).map(|name| MarkErrors {
            name: name.to_owned(),
            exact: Vec::new(),
            moved: Vec::new(),
            difference: Vec::new(),
        }));
        for scene in &LoadedScene::load_all(&experiment.scenery.scenes, &experiment.scenery.views)? {
            for light in &scene.lights {
                builder.view(scene, light)?;
            }
        }
        let blocks = builder.blocks.into_iter().map(Block::sorted).collect();
        let without = Self::without_scenes(experiment, blocks, builder.views, None)?;
        Ok(Self { marks: builder.marks, references: builder.references, ..without })
    }

    /// With blocks that were prepared before, and without what only tables need. `sampled` is the family on the support, where
    /// it has been computed.
    pub(crate) fn without_scenes(
        experiment: &SearchExperiment,
        blocks: Vec<Block>,
        views: Vec<ViewRecord>,
        sampled: Option<(FunctionTable, FunctionSpan)>,
    ) -> Result<Self, EvaluationError> {
        let mut functions = experiment.functions()?;
        let members = functions.len();
        let largest = experiment.orders.iter().copied().max().unwrap_or(1);
        let mut places = |basis: Basis| -> Vec<usize> {
            let mut places = Vec::new();
            for function in basis.functions() {
                let place = functions.iter().position(|other| other == function).unwrap_or(functions.len());
                if place == functions.len() {
                    functions.push(BasisFunction::clone(function));
                }
                places.push(place);
            }
            places
        };
        let powers = places(Basis::power(largest));
        let waves = places(Basis::trigonometric(largest.div_ceil(2)));
        let (table, span) = match sampled {
            Some(sampled) => sampled,
            None => {
                let depths = FunctionTable::uniform_depths(experiment.cells);
                let table = FunctionTable::new(&functions, &depths)
                    .map_err(|error| EvaluationError::Value(error.to_string()))?;
                let span = FunctionSpan::new(&table);
                (table, span)
            }
        };
        Ok(Self {
            table,
            span,
            members,
            powers,
            waves,
            blocks,
            views,
            marks: Vec::new(),
            references: Vec::new(),
        })
    }

    /// A hash of everything that candidates are judged on.
    pub(crate) fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for block in &self.blocks {
            for kernel in &block.kernels {
                hash.update((kernel.indices().len() as u64).to_le_bytes());
                kernel.indices().iter().for_each(|j| hash.update(j.to_le_bytes()));
                kernel.weights().iter().for_each(|w| hash.update(w.to_bits().to_le_bytes()));
            }
            for (fragment, entry) in block.fragments.iter().zip(&block.entries) {
                hash.update(fragment.kernel.to_le_bytes());
                hash.update(fragment.step.to_le_bytes());
                hash.update(entry.view.to_le_bytes());
                hash.update(entry.count.to_le_bytes());
                hash.update(entry.reference.to_bits().to_le_bytes());
            }
            block.sampled.iter().for_each(|n| hash.update(n.to_le_bytes()));
            block.idle.iter().for_each(|sum| hash.update(sum.to_bits().to_le_bytes()));
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// Places of kernels and fragments that a block has already.
#[derive(Clone, Default)]
struct Known {
    /// The last kernel of each hash; should two kernels share one, the earlier is no longer found and its copies are kept.
    kernels: HashMap<u64, u32>,
    fragments: HashMap<(u16, u32, u16, u64), u32>,
}

struct Builder<'a> {
    experiment: &'a SearchExperiment,
    kernel: Kernel,
    techniques: Vec<Technique>,
    known: Vec<Known>,
    blocks: Vec<Block>,
    views: Vec<ViewRecord>,
    /// The last is doing nothing.
    marks: Vec<MarkErrors>,
    references: Vec<ReferenceRecord>,
}

impl Builder<'_> {
    fn view(&mut self, scene: &LoadedScene<'_>, light: &LightView) -> Result<(), EvaluationError> {
        let fail = |reason: String| {
            EvaluationError::Value(format!("scene `{}`, view `{}`: {reason}", scene.label, light.name))
        };
        let Lit { map, receivers, texel_depth: unit, .. } =
            scene.lit(light, self.experiment.scenery.size, &self.kernel)?;
        let number = self.views.len();
        let view = u16::try_from(number).map_err(|_| fail("more than 65536 views".to_owned()))?;
        let wanted = self.experiment.sampled();
        let chosen = chosen(receivers.len(), wanted, self.experiment.scenery.seed, number);
        for block in &mut self.blocks {
            block.sampled.push(0);
            block.idle.push(0.0);
        }
        for mark in &mut self.marks {
            mark.exact.push(Running::default());
            mark.moved.push(Running::default());
            mark.difference.push(Running::default());
        }
        let mut active = 0;
        for (chunk, indices) in chosen.chunks(CHUNK).enumerate() {
            let prepare = |scratch: &mut Vec<f64>, &index: &usize| {
                self.prepare(&map, &receivers[index], unit, scratch).map_err(&fail)
            };
            let prepared: Result<Vec<Sampled>, EvaluationError> =
                indices.par_iter().map_init(Vec::new, prepare).collect();
            for (i, sampled) in prepared?.into_iter().enumerate() {
                for (mark, &(exact, moved)) in self.marks.iter_mut().zip(&sampled.marks) {
                    mark.exact[number].add(exact);
                    mark.moved[number].add(moved);
                    mark.difference[number].add(moved - exact);
                }
                active += usize::from(sampled.mass_before > 0.0);
                self.insert(chunk * CHUNK + i, view, sampled);
            }
        }
        let drawn: Vec<Receiver> = chosen.iter().map(|&index| receivers[index]).collect();
        let references = self.reference_records((scene.label, &light.name), (&map, unit), &drawn);
        self.references.extend(references);
        self.views.push(ViewRecord {
            scene: scene.label.to_owned(),
            view: light.name.clone(),
            fragments: receivers.len(),
            sampled: chosen.len(),
            active: Some(active),
            ..ViewRecord::default()
        });
        Ok(())
    }

    /// The rows of reference.csv of a view: F of the fragments drawn, with depths where they are.
    fn reference_records(
        &self,
        place: (&str, &str),
        (map, unit): (&DepthMap, f64),
        receivers: &[Receiver],
    ) -> Vec<ReferenceRecord> {
        let Self { experiment, kernel, .. } = self;
        let (bias, plane_limit) = (experiment.bias, experiment.scenery.plane_limit);
        let application = HardShadow { map, kernel, texel_depth: unit, bias, plane_limit };
        match experiment.reference {
            SearchReference::Plain => reference_records(place, bias.technique, |technique| {
                let biased = HardShadow { bias: BiasSetting { technique, ..bias }, ..application };
                receivers.par_iter().map(|receiver| biased.bounded(receiver)).collect()
            }),
            SearchReference::Plane => reference_records(place, bias.reference, |reference| {
                let biased = HardShadow { bias: BiasSetting { reference, ..bias }, ..application };
                truths(&biased, receivers)
            }),
        }
    }

    fn prepare(
        &self,
        map: &DepthMap,
        receiver: &Receiver,
        unit: f64,
        scratch: &mut Vec<f64>,
    ) -> Result<Sampled, String> {
        let experiment = self.experiment;
        let (bias, plane_limit) = (experiment.bias, experiment.scenery.plane_limit);
        let application = HardShadow { map, kernel: &self.kernel, texel_depth: unit, bias, plane_limit };
        let z = application.compared(receiver);
        let step = snap(z, experiment.cells);
        let taps: Vec<(f64, f64)> = self
            .kernel
            .taps()
            .map(|(i, j, weight)| {
                (f64::from(map.at(receiver.x as isize + i, receiver.y as isize + j)), weight)
            })
            .collect();
        let kernel = SupportDistribution::snapped(taps.iter().copied(), experiment.cells, scratch);
        let mass_before = kernel.cdf(step as u16);
        let (exact, reference) = match experiment.reference {
            SearchReference::Plain => (application.bounded(receiver), mass_before),
            SearchReference::Plane => {
                let plane = application.truth(receiver);
                (plane, plane)
            }
        };
        let grid = step as f64 / experiment.cells as f64;
        let mut marks = Vec::with_capacity(self.techniques.len());
        for technique in &self.techniques {
            let shade = |taps: &mut dyn Iterator<Item = (f64, f64)>, z: f64| {
                let mut filtered = vec![0.0; technique.channels()];
                let mut values = vec![0.0; technique.channels()];
                for (depth, weight) in taps {
                    technique.evaluate(depth, &mut values);
                    filtered.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight * value);
                }
                technique.shade(&filtered, z).map_err(|error| error.to_string())
            };
            let g = shade(&mut taps.iter().copied(), z)?;
            let cell = |&j: &u16| f64::from(j) / experiment.cells as f64;
            let mut moved = kernel.indices().iter().map(cell).zip(kernel.weights().iter().copied());
            let g_moved = shade(&mut moved, grid)?;
            marks.push(((g - exact).abs(), (g_moved - reference).abs()));
        }
        marks.push((exact, reference));
        Ok(Sampled { kernel, step: step as u16, mass_before, reference, marks })
    }

    fn insert(&mut self, position: usize, view: u16, sampled: Sampled) {
        let number = block_of(position, self.experiment.blocks);
        let (block, known) = (&mut self.blocks[number], &mut self.known[number]);
        block.sampled[usize::from(view)] += 1;
        if sampled.mass_before == 0.0 {
            block.idle[usize::from(view)] += sampled.reference;
            return;
        }
        let hash = hash(&sampled.kernel);
        let same = known.kernels.get(&hash).filter(|&&place| block.kernels[place as usize] == sampled.kernel);
        let kernel = same.copied().unwrap_or_else(|| {
            block.kernels.push(sampled.kernel);
            let place = block.kernels.len() as u32 - 1;
            known.kernels.insert(hash, place);
            place
        });
        let key = (view, kernel, sampled.step, sampled.reference.to_bits());
        let place = *known.fragments.entry(key).or_insert_with(|| {
            block.fragments.push(FastFragment {
                kernel,
                step: sampled.step,
                mass_before: sampled.mass_before,
            });
            block.entries.push(Entry { view, count: 0, reference: sampled.reference });
            block.fragments.len() as u32 - 1
        });
        block.entries[place as usize].count += 1;
    }
}

/// The same on every machine and in every run.
fn hash(kernel: &SupportDistribution) -> u64 {
    let mut hasher = DefaultHasher::new();
    kernel.indices().hash(&mut hasher);
    kernel.weights().iter().for_each(|weight| weight.to_bits().hash(&mut hasher));
    hasher.finish()
}
