//! Work for candidates: handed to the card, fetched from it.

use crate::card::CardError;
use crate::programs::{Answer, GroupSums, Left, Pass};
use crate::resident::{ResidentPrograms, SHARE, STAGES, Size};
use crate::shader::{CHAIN, GROUP, INVOCATIONS, TOGETHER};
use bytemuck::Pod;
use graphics_device::DeviceError;
use moment_problem::lane_simplex::{ProgramBatch, SpanColumns};
use std::sync::mpsc::{Receiver, channel};
use wgpu::BufferUsages;

/// Work that was handed to the card.
pub struct Submitted {
    staging: [wgpu::Buffer; 3],
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
    timing: Option<wgpu::Buffer>,
    candidates: usize,
    index: wgpu::SubmissionIndex,
}

fn unpacked(packed: [u32; 2]) -> [u16; 5] {
    let [low, high] = packed;
    [low, low >> 9, low >> 18, high, high >> 9].map(|bits| (bits & 511) as u16)
}

impl ResidentPrograms<'_> {
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
            let timestamp_writes = self.timing.as_ref().map(|timer| timer.compute_writes(stage as u32));
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
        let timing = self.timing.as_ref().map(|timer| {
            timer.resolve(&mut encoder, STAGES.len());
            staging(timer.stamps(), 2 * STAGES.len() as u64 * 8, &mut encoder)
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
        if let Some((timer, stamps)) = self.timing.as_ref().zip(submitted.timing.as_ref()) {
            let times = timer.times(&contents::<u64>(stamps)?);
            let named = STAGES.iter().zip(times);
            passes.extend(named.map(|((name, ..), time)| Pass { name, seconds: time.as_secs_f64() }));
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
