//! Programs on a card: its buffers and pipelines.

use crate::card::{Card, CardError};
use crate::programs::{Programs, Weighting};
use crate::shader::{GROUP, Options};
use bytemuck::{Pod, Zeroable};
use graphics_device::PassTimer;
use wgpu::BufferUsages;

/// Programs that a workgroup walks through: enough that its lanes are busy most of the time, few enough that all processors of
/// the card have work to the end.
pub(crate) const SHARE: u32 = 2048;

/// Supports are packed into nine bits a column.
const MAX_DEPTHS: usize = 512;

/// Programs that may always be left: narrow kernels come together.
const LEAST_ROOM: u64 = 1 << 14;

/// One in so many programs may be left to the exact route.
const LEFT: u32 = 32;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct Size {
    pub(crate) programs: u32,
    pub(crate) stride: u32,
    pub(crate) candidates: u32,
    pub(crate) share: u32,
    pub(crate) round: u32,
    pub(crate) capacity: u32,
    pub(crate) groups: u32,
    pub(crate) unused: u32,
}

/// Entry points in the order of the passes: name, round, and the bindings that it uses.
pub(crate) const STAGES: [(&str, usize, &[u32]); 8] = [
    ("moment", 0, &[0, 2, 3, 8]),
    ("newton", 0, &[0, 1, 4, 5, 8, 9]),
    ("certify_all", 0, &[0, 1, 5, 6, 8, 9, 10, 11, 12, 15]),
    ("pivot_coarse", 1, &[0, 1, 5, 8, 9, 11, 12]),
    ("certify_queue", 1, &[0, 1, 5, 6, 8, 9, 10, 11, 12, 15]),
    ("pivot_full", 2, &[0, 1, 5, 8, 9, 11, 12]),
    ("certify_queue", 2, &[0, 1, 5, 6, 8, 9, 10, 11, 12, 15]),
    ("sum", 0, &[0, 7, 9, 10, 12, 13, 14]),
];

/// Programs on a card.
pub struct ResidentPrograms<'c> {
    pub(crate) card: &'c Card,
    pub(crate) size: Size,
    pub(crate) capacity: usize,
    pub(crate) dimensions: usize,
    pub(crate) depths: usize,
    /// By binding.
    pub(crate) buffers: Vec<wgpu::Buffer>,
    pub(crate) sizes: [wgpu::Buffer; 3],
    pub(crate) pipelines: Vec<wgpu::ComputePipeline>,
    pub(crate) groups: Vec<wgpu::BindGroup>,
    pub(crate) timing: Option<PassTimer>,
}

fn packed(support: &[u16]) -> [u32; 2] {
    let at = |r: usize| u32::from(support[r]);
    [at(0) | at(1) << 9 | at(2) << 18, at(3) | at(4) << 9]
}

impl<'c> ResidentPrograms<'c> {
    pub(crate) fn new(
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
        let timing = PassTimer::new(gpu, STAGES.len() as u32);
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
}
