//! The card: its buffers, pipelines and passes.

use crate::shader::{self, CHAIN, GROUP, INVOCATIONS, Options, TOGETHER};
use bytemuck::{Pod, Zeroable};
use graphics_device::{DeviceError, GraphicsDevice};
use moment_problem::lane_simplex::{LaneStarts, ProgramBatch, SpanColumns};
use std::sync::mpsc::{Receiver, channel};
use wgpu::{BufferUsages, Features};

/// Programs that a workgroup walks through: enough that its lanes are busy most of the time, few enough that all processors of
/// the card have work to the end.
const SHARE: u32 = 2048;

/// Supports are packed into nine bits a column.
const MAX_DEPTHS: usize = 512;

/// Programs that may always be left: narrow kernels come together.
const LEAST_ROOM: u64 = 1 << 14;

/// One in so many programs may be left to the exact route.
const LEFT: u32 = 32;

/// Why programs cannot be solved on a card.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CardError {
    /// The device itself.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// It computes in single precision only.
    #[error("{0} has no double precision (SHADER_F64)")]
    NoDoubles(String),
    /// Something does not fit.
    #[error("{what}: {wanted} are more than {most}, which {adapter} has or this crate serves")]
    TooLarge {
        /// What.
        what: &'static str,
        /// How much of it is wanted.
        wanted: u64,
        /// How much there is.
        most: u64,
        /// The adapter's name.
        adapter: String,
    },
    /// More programs than there is room for were left uncertified.
    #[error("{adapter}: {left} of {programs} programs were not certified, room is for {room}")]
    Uncertified {
        /// Programs left.
        left: usize,
        /// All programs.
        programs: usize,
        /// Room for them.
        room: usize,
        /// The adapter's name.
        adapter: String,
    },
}

/// What a program counts for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighting {
    /// What its bound is compared with.
    pub reference: f64,
    /// What |G - reference| is compared with.
    pub control: f64,
    /// Factor in the sums.
    pub count: f64,
}

/// Programs to be kept on a card.
#[derive(Clone, Copy)]
pub struct Programs<'a> {
    /// The programs.
    pub batch: &'a ProgramBatch<'a>,
    /// Their starts.
    pub starts: &'a LaneStarts,
    /// What they count for.
    pub weighting: &'a [Weighting],
    /// Which of them, in which order; `None` for one that counts nothing, which fills up a group.
    pub order: &'a [Option<u32>],
}

/// A program that the card could not certify.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Left {
    /// Which of the candidates.
    pub candidate: u32,
    /// Place in the order of the programs.
    pub program: u32,
    /// Ascending columns of the basis that was found.
    pub support: [u16; 5],
}

/// Sums over a group of [`GROUP`](crate::GROUP) programs, with d = |G - reference| - control.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct GroupSums {
    /// Of count d.
    pub difference: f64,
    /// Of count d^2.
    pub square: f64,
    /// One bound of the group, to be checked; -1 if it was not certified.
    pub sample: f64,
    unused: f64,
}

/// What the card says about a batch of candidates.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Groups of programs.
    pub groups: usize,
    /// By candidate and group of programs, over the certified ones.
    pub sums: Vec<GroupSums>,
    /// Programs that the exact route has to decide, ascending; they are in no sum.
    pub left: Vec<Left>,
}

impl Answer {
    /// Place of the program whose bound is the sample of a group.
    pub fn sampled(&self, candidate: usize, group: usize) -> usize {
        group * GROUP as usize + (group * 97 + candidate * 31) % GROUP as usize
    }
}

/// Time of a stage.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Name of the entry point.
    pub name: &'static str,
    /// Seconds on the card.
    pub seconds: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Size {
    programs: u32,
    stride: u32,
    candidates: u32,
    share: u32,
    round: u32,
    capacity: u32,
    groups: u32,
    unused: u32,
}

/// A device with double precision.
pub struct Card {
    gpu: GraphicsDevice,
    subgroups: bool,
    checked: bool,
}

/// Entry points in the order of the passes: name, round, and the bindings that it uses.
const STAGES: [(&str, usize, &[u32]); 8] = [
    ("moment", 0, &[0, 2, 3, 8]),
    ("newton", 0, &[0, 1, 4, 5, 8, 9]),
    ("certify_all", 0, &[0, 1, 5, 6, 8, 9, 10, 11, 12, 15]),
    ("pivot_coarse", 1, &[0, 1, 5, 8, 9, 11, 12]),
    ("certify_queue", 1, &[0, 1, 5, 6, 8, 9, 10, 11, 12, 15]),
    ("pivot_full", 2, &[0, 1, 5, 8, 9, 11, 12]),
    ("certify_queue", 2, &[0, 1, 5, 6, 8, 9, 10, 11, 12, 15]),
    ("sum", 0, &[0, 7, 9, 10, 12, 13, 14]),
];

impl Card {
    /// The best adapter. `checked`: shaders check every index at run time, for tests; otherwise they rely on what the shader
    /// proves.
    ///
    /// # Errors
    /// [`CardError::Device`] without an adapter, [`CardError::NoDoubles`] for one without double precision.
    pub fn open(checked: bool) -> Result<Self, CardError> {
        Self::with(checked, true)
    }

    /// The same, without counting in subgroups unless they are wanted.
    ///
    /// # Errors
    /// As [`Card::open`].
    pub fn with(checked: bool, subgroups: bool) -> Result<Self, CardError> {
        let wanted = Features::SHADER_F64 | Features::SUBGROUP | Features::TIMESTAMP_QUERY;
        let gpu = GraphicsDevice::open_whole(wanted)?;
        let features = gpu.device.features();
        if !features.contains(Features::SHADER_F64) {
            return Err(CardError::NoDoubles(gpu.name.to_string()));
        }
        let subgroups = subgroups && features.contains(Features::SUBGROUP);
        Ok(Self { gpu, subgroups, checked })
    }

    /// What it runs on.
    pub fn name(&self) -> String {
        self.gpu.name.to_string()
    }

    /// Whether the adapter runs on the CPU.
    pub fn is_software(&self) -> bool {
        self.gpu.software
    }

    fn module(&self, options: Options) -> wgpu::ShaderModule {
        let source = shader::source(options);
        if self.checked {
            return self.gpu.shader(&source);
        }
        let source = wgpu::ShaderSource::Wgsl(source.into());
        let descriptor = wgpu::ShaderModuleDescriptor { label: None, source };
        // SAFETY: columns are kept in 0..depths where they arise, and every loop over them ends; buffer indices are below
        // programs, candidates and stride, for which the buffers were made. The checked module is compared in tests.
        unsafe {
            self.gpu.device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked())
        }
    }

    /// Puts programs on the card, with room for so many candidates at a time. Programs that are `shared` with lend their room
    /// for what lies between the stages, if it is large enough: work follows work on a card.
    ///
    /// # Errors
    /// [`CardError::TooLarge`] where memory or the size of a binding does not suffice, [`CardError::Device`] where the device
    /// fails.
    ///
    /// # Panics
    /// If the order names a program that does not exist, or the starts are for another rank than five.
    pub fn upload(
        &self,
        programs: Programs<'_>,
        candidates: usize,
        shared: Option<&ResidentPrograms<'_>>,
    ) -> Result<ResidentPrograms<'_>, CardError> {
        self.gpu.watched(|| ResidentPrograms::new(self, programs, candidates, shared))
    }
}

/// Programs on a card.
pub struct ResidentPrograms<'c> {
    card: &'c Card,
    size: Size,
    capacity: usize,
    dimensions: usize,
    depths: usize,
    /// By binding.
    buffers: Vec<wgpu::Buffer>,
    sizes: [wgpu::Buffer; 3],
    pipelines: Vec<wgpu::ComputePipeline>,
    groups: Vec<wgpu::BindGroup>,
    timing: Option<(wgpu::QuerySet, wgpu::Buffer)>,
}

/// Work that was handed to the card.
pub struct Submitted {
    staging: [wgpu::Buffer; 3],
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
    timing: Option<wgpu::Buffer>,
    candidates: usize,
    index: wgpu::SubmissionIndex,
}

fn packed(support: &[u16]) -> [u32; 2] {
    let at = |r: usize| u32::from(support[r]);
    [at(0) | at(1) << 9 | at(2) << 18, at(3) | at(4) << 9]
}

fn unpacked(packed: [u32; 2]) -> [u16; 5] {
    let [low, high] = packed;
    [low, low >> 9, low >> 18, high, high >> 9].map(|bits| (bits & 511) as u16)
}

impl<'c> ResidentPrograms<'c> {
    fn new(
        card: &'c Card,
        programs: Programs<'_>,
        candidates: usize,
        shared: Option<&ResidentPrograms<'_>>,
    ) -> Result<Self, CardError> {
        let Programs { batch, starts, weighting, order } = programs;
        let gpu = &card.gpu;
        let limits = gpu.device.limits();
        let fits = |what: &'static str, wanted: u64, most: u64| {
            let adapter = gpu.name.to_string();
            if wanted <= most { Ok(()) } else { Err(CardError::TooLarge { what, wanted, most, adapter }) }
        };
        let dimensions = batch.span().dimensions();
        let depths = batch.span().depths();
        let stride = order.len().next_multiple_of(GROUP as usize);
        let groups = stride / GROUP as usize;
        let pairs = stride as u64 * candidates as u64;
        fits("depths of the support", depths as u64, MAX_DEPTHS as u64)?;
        let workgroup = depths * 36 + dimensions * 4 * 32 + 2048;
        fits(
            "bytes of workgroup memory",
            workgroup as u64,
            u64::from(limits.max_compute_workgroup_storage_size),
        )?;
        fits("bytes of moments", pairs * 32, limits.max_storage_buffer_binding_size)?;
        fits(
            "bytes of coordinates",
            (stride * dimensions * 8) as u64,
            limits.max_storage_buffer_binding_size,
        )?;
        fits(
            "groups of programs",
            stride as u64 / 128,
            u64::from(limits.max_compute_workgroups_per_dimension),
        )?;
        let capacity = (pairs / u64::from(LEFT)).max(LEAST_ROOM);
        let mut coordinates = vec![0.0f64; stride * dimensions];
        let mut guesses = vec![[0u32; 4]; stride];
        let (mut steps, mut masses) = (vec![1i32; stride], vec![[0.0f64; 2]; stride]);
        let mut kernels = vec![[u32::MAX; 2]; stride];
        let mut counted = vec![[0.0f64; 4]; stride];
        let first = order.iter().flatten().next().copied();
        for place in 0..stride {
            // What fills up a group is any program that nobody counts, with F = 0.
            let own = order.get(place).copied().flatten();
            let Some(program) = own.or(first) else { continue };
            let program = program as usize;
            for (r, &value) in batch.coordinates(program).iter().enumerate() {
                coordinates[r * stride + place] = value;
            }
            let [low, high] = starts.of(program).map(packed);
            if let Some(depths) = batch.few_depths(program) {
                kernels[place] = packed(&depths);
            }
            guesses[place] = [low[0], low[1], high[0], high[1]];
            steps[place] = i32::from(batch.fragments()[program].step);
            if own.is_some() {
                masses[place] = [batch.fragments()[program].mass_before, batch.norm(program)];
                let Weighting { reference, control, count } = weighting[program];
                counted[place] = [reference, count, control, 0.0];
            }
        }
        let storage = BufferUsages::STORAGE;
        let usage = storage | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let lent = |binding: usize, label: &str, bytes: u64| {
            let theirs =
                shared.map(|shared| &shared.buffers[binding]).filter(|theirs| theirs.size() >= bytes);
            theirs.cloned().unwrap_or_else(|| gpu.buffer(label, bytes, usage))
        };
        let size = Size {
            programs: stride as u32,
            stride: stride as u32,
            candidates: candidates as u32,
            share: SHARE,
            round: 0,
            capacity: capacity as u32,
            groups: groups as u32,
            unused: 0,
        };
        let sizes =
            [0, 1, 2].map(|round| gpu.buffer_of("size", &[Size { round, ..size }], BufferUsages::UNIFORM));
        let all = candidates as u64;
        let buffers = vec![
            sizes[0].clone(),
            lent(1, "columns", all * (2 * depths as u64 + 4) * 16),
            lent(2, "transform", all * dimensions as u64 * 32),
            gpu.buffer_of("coordinates", &coordinates, storage),
            gpu.buffer_of("guesses", &guesses, storage),
            gpu.buffer_of("steps", &steps, storage),
            gpu.buffer_of("masses", &masses, storage),
            gpu.buffer_of("weighting", &counted, storage),
            lent(8, "moments", pairs * 32),
            lent(9, "supports", pairs * 8),
            lent(10, "bounds", pairs * 8),
            lent(11, "queues", pairs * 8),
            lent(12, "counts", (2 * all + 1) * 4),
            lent(13, "rest", capacity * 16),
            lent(14, "sums", all * groups as u64 * 32),
            gpu.buffer_of("kernels", &kernels, storage),
        ];
        let options =
            Options { depths: depths as u32, dimensions: dimensions as u32, subgroups: card.subgroups };
        let module = card.module(options);
        let (mut pipelines, mut bound) = (Vec::new(), Vec::new());
        for (name, round, bindings) in STAGES {
            let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module: &module,
                entry_point: Some(name),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            let entries: Vec<wgpu::BindGroupEntry<'_>> = bindings
                .iter()
                .map(|&binding| {
                    let buffer = if binding == 0 { &sizes[round] } else { &buffers[binding as usize] };
                    wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
                })
                .collect();
            bound.push(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(name),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &entries,
            }));
            pipelines.push(pipeline);
        }
        let timing = gpu.device.features().contains(Features::TIMESTAMP_QUERY).then(|| {
            let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("passes"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * STAGES.len() as u32,
            });
            let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
            (queries, gpu.buffer("timestamps", 2 * STAGES.len() as u64 * 8, usage))
        });
        Ok(Self {
            card,
            size,
            capacity: capacity as usize,
            dimensions,
            depths,
            buffers,
            sizes,
            pipelines,
            groups: bound,
            timing,
        })
    }

    /// Programs with those that fill up groups.
    pub fn stride(&self) -> usize {
        self.size.stride as usize
    }

    /// Solves all programs for candidates of rank five; the answer is fetched with [`ResidentPrograms::finish`].
    ///
    /// # Errors
    /// [`CardError::Device`] where the device fails.
    ///
    /// # Panics
    /// If there are more candidates than there is room for, or none, or one of another rank.
    pub fn submit(
        &self,
        batch: &ProgramBatch<'_>,
        candidates: &[&SpanColumns],
        tolerance: f64,
    ) -> Result<Submitted, CardError> {
        self.card.gpu.watched(|| self.handed_over(batch, candidates, tolerance))
    }

    fn handed_over(
        &self,
        batch: &ProgramBatch<'_>,
        candidates: &[&SpanColumns],
        tolerance: f64,
    ) -> Result<Submitted, CardError> {
        let count = candidates.len();
        assert!((1..=self.size.candidates as usize).contains(&count), "{count} candidates");
        let gpu = &self.card.gpu;
        let (mut columns, mut transform) = (Vec::new(), Vec::new());
        for candidate in candidates {
            assert_eq!(candidate.columns().rank(), 5, "a candidate of another rank");
            columns.extend(candidate.entries().map(|[a, b, ..]| [a, b]));
            columns.extend(candidate.entries().map(|[.., c, d]| [c, d]));
            let chain = CHAIN as usize + self.dimensions.div_ceil(CHAIN as usize);
            let rounding = candidate.rounding(batch, chain);
            let [r0, r1, r2, r3] = rounding.rows;
            columns.extend([
                [r0, r1],
                [r2, r3],
                [rounding.mass, tolerance],
                [rounding.value, rounding.moment],
            ]);
            transform.extend(candidate.transform());
        }
        debug_assert_eq!(columns.len(), count * (2 * self.depths + 4));
        gpu.queue.write_buffer(&self.buffers[1], 0, bytemuck::cast_slice(&columns));
        gpu.queue.write_buffer(&self.buffers[2], 0, bytemuck::cast_slice(&transform));
        for (round, buffer) in self.sizes.iter().enumerate() {
            let size = Size { round: round as u32, candidates: count as u32, ..self.size };
            gpu.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&size));
        }
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_buffer(&self.buffers[12], 0, None);
        let (stride, all) = (self.size.stride, count as u32);
        for (stage, (name, ..)) in STAGES.iter().enumerate() {
            let timestamp_writes =
                self.timing.as_ref().map(|(queries, _)| wgpu::ComputePassTimestampWrites {
                    query_set: queries,
                    beginning_of_pass_write_index: Some(2 * stage as u32),
                    end_of_pass_write_index: Some(2 * stage as u32 + 1),
                });
            let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&self.pipelines[stage]);
            pass.set_bind_group(0, &self.groups[stage], &[]);
            match *name {
                "moment" => pass.dispatch_workgroups(stride.div_ceil(INVOCATIONS), all.div_ceil(TOGETHER), 1),
                "newton" | "pivot_coarse" | "pivot_full" => {
                    pass.dispatch_workgroups(stride.div_ceil(SHARE), all, 1);
                }
                "sum" => pass.dispatch_workgroups(stride / GROUP, all, 1),
                _ => pass.dispatch_workgroups(stride.div_ceil(INVOCATIONS), all, 1),
            }
        }
        let staging = |source: &wgpu::Buffer, bytes: u64, encoder: &mut wgpu::CommandEncoder| {
            let buffer = gpu.buffer("answer", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
            encoder.copy_buffer_to_buffer(source, 0, &buffer, 0, bytes);
            buffer
        };
        let sums = staging(&self.buffers[14], count as u64 * u64::from(self.size.groups) * 32, &mut encoder);
        let counts = staging(&self.buffers[12], (2 * count as u64 + 1) * 4, &mut encoder);
        let rest = staging(&self.buffers[13], self.capacity as u64 * 16, &mut encoder);
        let timing = self.timing.as_ref().map(|(queries, resolved)| {
            encoder.resolve_query_set(queries, 0..2 * STAGES.len() as u32, resolved, 0);
            staging(resolved, 2 * STAGES.len() as u64 * 8, &mut encoder)
        });
        let index = gpu.queue.submit([encoder.finish()]);
        let (sender, mapped) = channel();
        for buffer in [&sums, &counts, &rest].into_iter().chain(&timing) {
            let sender = sender.clone();
            buffer.map_async(wgpu::MapMode::Read, .., move |result| {
                // Nobody waits for an answer that was given up.
                let _ = sender.send(result);
            });
        }
        Ok(Submitted { staging: [sums, counts, rest], mapped, timing, candidates: count, index })
    }

    /// Waits for an answer.
    ///
    /// # Errors
    /// [`CardError::Device`] where the device fails, [`CardError::Uncertified`] where more programs are left than there is room
    /// for.
    pub fn finish(&self, submitted: Submitted) -> Result<(Answer, Vec<Pass>), CardError> {
        self.card.gpu.watched(|| self.fetched(submitted))
    }

    fn fetched(&self, submitted: Submitted) -> Result<(Answer, Vec<Pass>), CardError> {
        let gpu = &self.card.gpu;
        let failed = |error: String| CardError::Device(DeviceError::Failed(error));
        let wait = wgpu::PollType::Wait { submission_index: Some(submitted.index.clone()), timeout: None };
        gpu.device.poll(wait).map_err(|error| failed(error.to_string()))?;
        for _ in 0..3 + usize::from(submitted.timing.is_some()) {
            let result = submitted.mapped.recv().map_err(|error| failed(error.to_string()))?;
            result.map_err(|error| failed(error.to_string()))?;
        }
        let [sums, counts, rest] = &submitted.staging;
        let sums: Vec<GroupSums> = contents(sums)?;
        let counts: Vec<u32> = contents(counts)?;
        let left = counts[2 * submitted.candidates] as usize;
        if left > self.capacity {
            return Err(CardError::Uncertified {
                left,
                programs: self.stride() * submitted.candidates,
                room: self.capacity,
                adapter: gpu.name.to_string(),
            });
        }
        let rest: Vec<[u32; 4]> = contents(rest)?;
        let of = |&[candidate, program, low, high]: &[u32; 4]| Left {
            candidate,
            program,
            support: unpacked([low, high]),
        };
        let mut left: Vec<Left> = rest[..left].iter().map(of).collect();
        left.sort_unstable();
        let mut passes = Vec::new();
        if let Some(timing) = &submitted.timing {
            let stamps: Vec<u64> = contents(timing)?;
            let period = f64::from(gpu.queue.get_timestamp_period()) * 1e-9;
            for ((name, ..), pair) in STAGES.iter().zip(stamps.as_chunks::<2>().0) {
                passes.push(Pass { name, seconds: pair[1].saturating_sub(pair[0]) as f64 * period });
            }
        }
        Ok((Answer { groups: self.size.groups as usize, sums, left }, passes))
    }

    /// The last answer's bounds by candidate and program, -1 for what is left: for comparison, as it is large.
    ///
    /// # Errors
    /// [`CardError::Device`] where reading back fails.
    pub fn bounds(&self, candidate: usize) -> Result<Vec<f64>, CardError> {
        let bytes = self.size.stride as u64 * 8;
        Ok(self.card.gpu.read(&self.buffers[10], candidate as u64 * bytes, bytes)?)
    }
}

fn contents<T: Pod>(buffer: &wgpu::Buffer) -> Result<Vec<T>, CardError> {
    let view = buffer
        .get_mapped_range(..)
        .map_err(|error| CardError::Device(DeviceError::Failed(format!("{error:?}"))))?;
    Ok(bytemuck::pod_collect_to_vec(&view))
}
