//! Count, prefix sums, scatter and sort on the GPU, band of rows by band of rows.

use std::sync::OnceLock;
use std::time::Instant;

use graphics_device::{DeviceError, GraphicsDevice};
use wgpu::BufferUsages as Usage;

use super::compute_shader::ComputeShader;
use super::work_items::{GpuTriangle, Item, gpu_triangles, items, most_fragments};
use super::{FRAGMENTS, SCAN, SORT};
use crate::stack::assemble::{Band, Key};
use crate::stack::memory::Budget;
use crate::stack::prepare::PreparedTriangles;
use crate::{RenderError, StageTimes};

/// Sizes of the pieces into which work is cut, so that every binding stays within its limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChunkSizes {
    pub triangles: usize,
    pub items: usize,
    pub texels: u32,
    pub fragments: u64,
}

impl ChunkSizes {
    /// Pieces for bindings of at most `bytes` bytes; at least one of everything.
    pub fn for_bindings(bytes: u64) -> Self {
        let of = |size: usize| (bytes / size as u64).clamp(1, 1 << 24);
        Self {
            triangles: of(size_of::<GpuTriangle>()) as usize,
            // More would need more workgroups than a dispatch has.
            items: of(size_of::<Item>()).min(1 << 21) as usize,
            // Counters, starts and keys grow together: bands of a thirty-second rarely have to be halved.
            texels: of(32 * size_of::<u32>()) as u32,
            fragments: of(size_of::<Key>()),
        }
    }
}

/// WGSL modules and the entry points that are run, in the order of [`ABuffer`]'s fields.
pub(super) const KERNELS: [(&str, &str); 6] = [
    (FRAGMENTS, "count"),
    (FRAGMENTS, "scatter"),
    (SCAN, "scan_blocks"),
    (SCAN, "scan_sums"),
    (SCAN, "add_sums"),
    (SORT, "sort"),
];

/// The A-buffer's shaders, compiled.
pub(crate) struct ABuffer {
    gpu: &'static GraphicsDevice,
    count: ComputeShader,
    scatter: ComputeShader,
    scan_blocks: ComputeShader,
    scan_sums: ComputeShader,
    add_sums: ComputeShader,
    sort: ComputeShader,
}

impl ABuffer {
    /// On the device of this process; compiled on the first call.
    pub fn shared() -> Result<&'static Self, DeviceError> {
        static SHARED: OnceLock<Result<ABuffer, DeviceError>> = OnceLock::new();
        let compile = || {
            let gpu = GraphicsDevice::shared()?;
            gpu.watched(|| Self::new(gpu))
        };
        SHARED.get_or_init(compile).as_ref().map_err(Clone::clone)
    }

    fn new(gpu: &'static GraphicsDevice) -> Result<Self, DeviceError> {
        let [count, scatter, scan_blocks, scan_sums, add_sums, sort] =
            KERNELS.map(|(source, name)| ComputeShader::new(gpu, source, name));
        Ok(Self {
            gpu,
            count: count?,
            scatter: scatter?,
            scan_blocks: scan_blocks?,
            scan_sums: scan_sums?,
            add_sums: add_sums?,
            sort: sort?,
        })
    }

    /// Sorted fragments of the whole map.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device fails or lacks memory, the errors of `budget` for too many fragments.
    pub fn extract(
        &self,
        prepared: &PreparedTriangles,
        budget: &Budget,
        sizes: ChunkSizes,
        times: &mut StageTimes,
    ) -> Result<Vec<Band>, RenderError> {
        self.gpu.watched(|| Extraction::new(self, prepared, budget, sizes).run(times))
    }
}

/// Triangles on the device.
struct Chunk {
    first: usize,
    end: usize,
    triangles: wgpu::Buffer,
    mask_planes: wgpu::Buffer,
    weights: wgpu::Buffer,
}

/// Rectangles of one chunk on the device.
struct Batch<'a> {
    chunk: &'a Chunk,
    items: wgpu::Buffer,
    count: u32,
    params: wgpu::Buffer,
}

/// Texels a workgroup of scan.wgsl sums up.
const SCAN_BLOCK: u32 = 1024;

struct Extraction<'a> {
    shaders: &'a ABuffer,
    prepared: &'a PreparedTriangles,
    budget: &'a Budget,
    sizes: ChunkSizes,
    chunks: Vec<Chunk>,
    mask_bits: wgpu::Buffer,
}

impl<'a> Extraction<'a> {
    fn new(
        shaders: &'a ABuffer,
        prepared: &'a PreparedTriangles,
        budget: &'a Budget,
        sizes: ChunkSizes,
    ) -> Self {
        let gpu = shaders.gpu;
        let all = prepared.triangles.len();
        let chunks = (0..all).step_by(sizes.triangles).map(|first| {
            let end = all.min(first + sizes.triangles);
            let (triangles, planes, weights) = gpu_triangles(prepared, first..end);
            Chunk {
                first,
                end,
                triangles: gpu.buffer_of("triangles", &triangles, Usage::STORAGE),
                mask_planes: gpu.buffer_of("mask planes", &planes, Usage::STORAGE),
                weights: gpu.buffer_of("weights", &weights, Usage::STORAGE),
            }
        });
        let chunks = chunks.collect();
        let mask_bits = gpu.buffer_of("mask bits", &prepared.masks.bits, Usage::STORAGE);
        Self { shaders, prepared, budget, sizes, chunks, mask_bits }
    }

    fn run(&self, times: &mut StageTimes) -> Result<Vec<Band>, RenderError> {
        let (width, height) = (self.prepared.width, self.prepared.height);
        let band_rows = (self.sizes.texels / width).max(1);
        // A stack of row ranges, the next one last; ranges with too many fragments are halved.
        let starts = (0..height).step_by(band_rows as usize).rev();
        let mut waiting: Vec<_> = starts.map(|first| first..height.min(first + band_rows)).collect();
        let (mut bands, mut total) = (Vec::new(), 0);
        while let Some(rows) = waiting.pop() {
            match self.band(rows.clone(), &mut total, times)? {
                Some(band) => bands.push(band),
                None if rows.len() == 1 => {
                    let what = format!("row {} has too many fragments", rows.start);
                    return Err(DeviceError::Unsupported(what).into());
                }
                None => {
                    let middle = rows.start + rows.len() as u32 / 2;
                    waiting.push(middle..rows.end);
                    waiting.push(rows.start..middle);
                }
            }
        }
        Ok(bands)
    }

    /// The fragments of some rows, added to `total`, or `None` if they do not fit into one buffer.
    fn band(
        &self,
        rows: std::ops::Range<u32>,
        total: &mut u64,
        times: &mut StageTimes,
    ) -> Result<Option<Band>, RenderError> {
        let (gpu, shaders) = (self.shaders.gpu, self.shaders);
        let mut since = Instant::now();
        let texels = self.prepared.width * rows.len() as u32;
        let Some(batches) = self.batches(&rows) else { return Ok(None) };
        let bytes = u64::from(texels) * 4;
        let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let counters = gpu.buffer("counters", bytes, usage);
        // Counting shares its bindings with scattering but writes no keys.
        let no_keys = gpu.buffer("no keys", 0, usage);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&counters, 0, None);
        self.visit(&mut encoder, &shaders.count, &batches, &counters, &no_keys)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        times.raster += lap(&mut since);

        let blocks = texels.div_ceil(SCAN_BLOCK);
        let starts = gpu.buffer("starts", bytes, usage);
        let sums = gpu.buffer("block sums", u64::from(blocks + 1) * 4, usage);
        let params = gpu.buffer_of("scan", &[texels, blocks, 0, 0], Usage::UNIFORM);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let scanned =
            [("params", &params), ("counters", &counters), ("starts", &starts), ("block_sums", &sums)];
        for (kernel, groups) in
            [(&shaders.scan_blocks, blocks), (&shaders.scan_sums, 1), (&shaders.add_sums, blocks)]
        {
            self.dispatch(&mut encoder, kernel, &scanned, [groups, 1])?;
        }
        gpu.queue.submit([encoder.finish()]);
        let fragments = u64::from(gpu.read::<u32>(&sums, u64::from(blocks) * 4, 4)?[0]);
        if fragments > self.sizes.fragments {
            times.group += lap(&mut since);
            return Ok(None);
        }
        *total += fragments;
        self.budget.check(*total)?;

        let keys = gpu.buffer("keys", fragments * 8, usage);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.visit(&mut encoder, &shaders.scatter, &batches, &counters, &keys)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        times.group += lap(&mut since);

        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let sorted = [("params", &params), ("starts", &starts), ("ends", &counters), ("keys", &keys)];
        self.dispatch(&mut encoder, &shaders.sort, &sorted, shaders.sort.groups_of([texels, 1]))?;
        gpu.queue.submit([encoder.finish()]);
        let band = Band {
            starts: gpu.read(&starts, 0, bytes)?,
            // Two little-endian words, triangle then depth, are one key.
            keys: gpu.read::<[u32; 2]>(&keys, 0, fragments * 8)?.into_iter().map(key_of).collect(),
        };
        times.sort += lap(&mut since);
        Ok(Some(band))
    }

    /// Uploads the rectangles of some rows; `None` if their fragments might overflow 32-bit counters.
    fn batches(&self, rows: &std::ops::Range<u32>) -> Option<Vec<Batch<'_>>> {
        let mut batches = Vec::new();
        let mut most = 0;
        for chunk in &self.chunks {
            let list = items(&self.prepared.triangles[chunk.first..chunk.end], rows.clone());
            most += most_fragments(&list);
            if most > u64::from(u32::MAX) {
                return None;
            }
            for part in list.chunks(self.sizes.items) {
                let count = part.len() as u32;
                let in_perspective = u32::from(!self.prepared.weights.is_empty());
                let params =
                    [self.prepared.width, rows.start, count, chunk.first as u32, in_perspective, 0, 0, 0];
                batches.push(Batch {
                    chunk,
                    items: self.shaders.gpu.buffer_of("items", part, Usage::STORAGE),
                    count,
                    params: self.shaders.gpu.buffer_of("batch", &params, Usage::UNIFORM),
                });
            }
        }
        Some(batches)
    }

    /// Runs a shader of fragments.wgsl on all batches.
    fn visit(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        kernel: &ComputeShader,
        batches: &[Batch<'_>],
        counters: &wgpu::Buffer,
        keys: &wgpu::Buffer,
    ) -> Result<(), DeviceError> {
        for batch in batches {
            let buffers = [
                ("params", &batch.params),
                ("triangles", &batch.chunk.triangles),
                ("items", &batch.items),
                ("mask_planes", &batch.chunk.mask_planes),
                ("mask_bits", &self.mask_bits),
                ("counters", counters),
                ("keys", keys),
                ("weights", &batch.chunk.weights),
            ];
            self.dispatch(encoder, kernel, &buffers, kernel.groups_of([batch.count, 1]))?;
        }
        Ok(())
    }

    fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        kernel: &ComputeShader,
        buffers: &[(&str, &wgpu::Buffer)],
        groups: [u32; 2],
    ) -> Result<(), DeviceError> {
        let resources: Vec<_> =
            buffers.iter().map(|(name, buffer)| (*name, buffer.as_entire_binding())).collect();
        kernel.dispatch(self.shaders.gpu, encoder, &resources, groups)
    }
}

fn key_of([triangle, depth]: [u32; 2]) -> Key {
    crate::stack::assemble::key(depth, triangle)
}

fn lap(since: &mut Instant) -> std::time::Duration {
    let now = Instant::now();
    let elapsed = now - *since;
    *since = now;
    elapsed
}
