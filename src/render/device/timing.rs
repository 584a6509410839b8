//! Time of each pass on the device, by timestamps where the adapter has them. In: a pass's begin and end. Out:
//! milliseconds, a few frames late; drawing never waits for them.

use std::cell::Cell;
use std::sync::{
    Arc,
    atomic::{AtomicU8, Ordering},
};

/// Passes that are timed, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimedPass {
    /// All shadow maps drawn in this frame.
    Shadow,
    /// Picture of the main camera.
    Main,
    /// Pictures of the mirrors.
    Mirror,
    /// Halos, tone curve and placement of the mirrors.
    ToneMap,
    /// Dial and experimenter's panel.
    Overlay,
}

/// Times of the passes on the device, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTimes {
    /// All shadow maps drawn in that frame.
    pub shadow_ms: f32,
    /// Picture of the main camera.
    pub main_ms: f32,
    /// Pictures of the mirrors.
    pub mirror_ms: f32,
    /// Halos, tone curve and placement of the mirrors.
    pub tonemap_ms: f32,
    /// Whole picture, from the begin of its first pass to the end of its last one, with dial and panel.
    pub picture_ms: f32,
}

const PASSES: usize = 5;
const STAMPS: u32 = 2 * PASSES as u32;
const BYTES: u64 = PASSES as u64 * wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT;
/// Number of 8-byte stamps between two passes in the buffer.
const STRIDE: usize = wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT as usize / 8;

const IDLE: u8 = 0;
const WAITING: u8 = 1;
const READY: u8 = 2;

/// Timestamps of one renderer.
#[derive(Debug)]
pub struct PassTimings {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    state: Arc<AtomicU8>,
    ms_per_tick: f64,
    written: [Cell<bool>; PASSES],
    timed: [bool; PASSES],
    latest: Option<PassTimes>,
}

impl PassTimings {
    /// Creates the timestamps; `None` if the adapter has none.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Self> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |usage| {
            let label = Some("timestamps");
            device.create_buffer(&wgpu::BufferDescriptor { label, size: BYTES, usage, mapped_at_creation: false })
        };
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: STAMPS,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            readable: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            state: Arc::new(AtomicU8::new(IDLE)),
            ms_per_tick: f64::from(queue.get_timestamp_period()) * 1e-6,
            written: Default::default(),
            timed: [false; PASSES],
            latest: None,
        })
    }

    /// Returns the places of the stamps of a pass. Several passes may be timed as one: `begins` is true for the first, `ends` for the
    /// last of them; `None` for the passes between.
    pub fn stamps(&self, pass: TimedPass, [begins, ends]: [bool; 2]) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.written[pass as usize].set(true);
        (begins || ends).then_some(wgpu::RenderPassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: begins.then_some(2 * pass as u32),
            end_of_pass_write_index: ends.then_some(2 * pass as u32 + 1),
        })
    }

    /// Takes the stamps of an earlier frame if they have arrived, and starts the copy of this frame's if the buffer is
    /// free.
    pub fn collect(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.take();
        if self.state.load(Ordering::Acquire) == IDLE {
            // Only stamps written in this frame may be resolved. A resolve starts at a multiple of 256 bytes.
            for pass in (0..PASSES as u32).filter(|&pass| self.written[pass as usize].get()) {
                let place = u64::from(pass) * wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT;
                encoder.resolve_query_set(&self.queries, 2 * pass..2 * pass + 2, &self.resolved, place);
            }
            self.timed = self.written.each_ref().map(Cell::get);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, BYTES);
            let state = self.state.clone();
            encoder.map_buffer_on_submit(&self.readable, wgpu::MapMode::Read, .., move |result| {
                state.store(if result.is_ok() { READY } else { IDLE }, Ordering::Release);
            });
            self.state.store(WAITING, Ordering::Release);
        }
        self.written = Default::default();
    }

    /// Takes the times that have arrived since the last call; `None` if none have. Once the device has finished a frame, they are that
    /// frame's.
    pub fn take(&mut self) -> Option<PassTimes> {
        if self.state.load(Ordering::Acquire) != READY {
            return None;
        }
        let read = self.readable.get_mapped_range(..).ok().map(|bytes| self.times(bytemuck::cast_slice(&bytes)));
        self.readable.unmap();
        self.state.store(IDLE, Ordering::Release);
        self.latest = read.or(self.latest);
        read
    }

    /// Converts the stamps of a frame.
    fn times(&self, stamps: &[u64]) -> PassTimes {
        let ms = |begin: u64, end: u64| (end.saturating_sub(begin) as f64 * self.ms_per_tick) as f32;
        let bounds = |pass: usize| (stamps[STRIDE * pass], stamps[STRIDE * pass + 1]);
        let of = |pass: TimedPass| {
            let (begin, end) = bounds(pass as usize);
            if self.timed[pass as usize] { ms(begin, end) } else { 0.0 }
        };
        let timed = || (0..PASSES).filter(|pass| self.timed[*pass]).map(bounds);
        let begin = timed().map(|(begin, _)| begin).min().unwrap_or(0);
        let end = timed().map(|(_, end)| end).max().unwrap_or(0);
        PassTimes {
            shadow_ms: of(TimedPass::Shadow),
            main_ms: of(TimedPass::Main),
            mirror_ms: of(TimedPass::Mirror),
            tonemap_ms: of(TimedPass::ToneMap),
            picture_ms: ms(begin, end),
        }
    }

    /// Returns the latest times that have arrived.
    pub fn latest(&self) -> Option<PassTimes> {
        self.latest
    }
}
