//! GPU timestamps around passes.

use std::time::Duration;

use crate::{DeviceError, GraphicsDevice};

/// Timestamps at the beginning and end of each pass.
pub struct PassTimer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    nanoseconds: f64,
}

impl PassTimer {
    /// For so many passes at most; `None` where the device has no timestamps.
    pub fn new(gpu: &GraphicsDevice, passes: u32) -> Option<Self> {
        if !gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("passes"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * passes,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = gpu.buffer("timestamps", u64::from(2 * passes) * 8, usage);
        Some(Self { queries, resolved, nanoseconds: f64::from(gpu.queue.get_timestamp_period()) })
    }

    /// What to write around pass `pass`.
    pub fn writes(&self, pass: u32) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        }
    }

    /// The same for a compute pass.
    pub fn compute_writes(&self, pass: u32) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * pass),
            end_of_pass_write_index: Some(2 * pass + 1),
        }
    }

    /// For the first of several passes that count as one.
    pub fn begin_only(writes: wgpu::RenderPassTimestampWrites<'_>) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites { end_of_pass_write_index: None, ..writes }
    }

    /// For the last of several passes that count as one.
    pub fn end_only(writes: wgpu::RenderPassTimestampWrites<'_>) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites { beginning_of_pass_write_index: None, ..writes }
    }

    /// [`PassTimer::compute_writes`] for one of `count` passes that count as one; none between the first and the last.
    pub fn compute_part(
        &self,
        pass: u32,
        part: usize,
        count: usize,
    ) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let whole = self.compute_writes(pass);
        let (is_first, is_last) = (part == 0, part + 1 == count);
        (is_first || is_last).then(|| wgpu::ComputePassTimestampWrites {
            beginning_of_pass_write_index: whole.beginning_of_pass_write_index.filter(|_| is_first),
            end_of_pass_write_index: whole.end_of_pass_write_index.filter(|_| is_last),
            ..whole
        })
    }

    /// Makes the timestamps of the first `passes` passes readable, and of no others: a driver may wait for ever for a timestamp that nothing writes.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder, passes: usize) {
        encoder.resolve_query_set(&self.queries, 0..2 * passes as u32, &self.resolved, 0);
    }

    /// Time of each pass, and last that from the first beginning to the last end.
    ///
    /// # Errors
    /// [`DeviceError::Failed`] where reading back fails.
    pub fn read(&self, gpu: &GraphicsDevice, passes: usize) -> Result<Vec<Duration>, DeviceError> {
        let stamps: Vec<u64> = gpu.read(&self.resolved, 0, 2 * passes as u64 * 8)?;
        let whole = stamps.first().zip(stamps.last()).map(|(&first, &last)| self.between(first, last));
        Ok(self.times(&stamps).into_iter().chain(whole).collect())
    }

    /// Where [`PassTimer::resolve`] puts a beginning and an end for each pass: for whoever copies them instead of waiting.
    pub fn stamps(&self) -> &wgpu::Buffer {
        &self.resolved
    }

    /// Time of each pass from the stamps.
    pub fn times(&self, stamps: &[u64]) -> Vec<Duration> {
        stamps.chunks_exact(2).map(|pass| self.between(pass[0], pass[1])).collect()
    }

    fn between(&self, from: u64, to: u64) -> Duration {
        Duration::from_nanos((to.saturating_sub(from) as f64 * self.nanoseconds) as u64)
    }
}
