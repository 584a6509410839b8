//! Stream of another device. In: a predicate. Out: samples with the device's own time stamps, the offset of its clock
//! from this computer's, and an error when the stream is lost.

use super::{
    FoundStream, LslError,
    library::{self, Handle, Library, c_text, text},
    stream::Info,
};
use serde::Serialize;
use std::{
    ffi::{c_char, c_double, c_ulong},
    ptr,
};

/// Largest number of streams in a search.
const MOST_STREAMS: usize = 256;
/// Largest number of samples per call.
const MOST_SAMPLES: usize = 1024;
/// Time for which the library buffers samples, s.
const BUFFERED_S: i32 = 360;
/// Longest wait for a stream's description and for its start, s.
const ANSWER_S: f64 = 5.0;
/// Longest part of a wait for a response, s; between two parts the program can end.
const PIECE_S: f64 = 0.2;
/// Longest part of a search for a stream, s. Each part asks all devices again.
const FIND_S: f64 = 0.5;
/// Size of texts after which a call returns, bytes: a sample may hold a megabyte.
const MOST_TEXT_BYTES: usize = 8 << 20;

/// Consecutive samples, oldest first.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleChunk {
    /// Time stamps of the samples, s on the clock of the device's computer.
    pub stamps_s: Vec<f64>,
    /// Values of all channels of the first sample, then of the second, and so on.
    pub values: SampleValues,
}

/// Values of samples, by format.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleValues {
    /// Numbers; whole numbers are exact up to 2^53.
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

/// Offset of a device's clock from this computer's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockOffset {
    /// Time of the measurement, s on this computer's clock.
    pub measured_lsl_s: f64,
    /// Offset to add to the device's time stamps, s.
    pub offset_s: f64,
    /// Largest error of the offset, s: the duration of the exchange that measured it.
    pub uncertainty_s: f64,
}

/// Stream of another device, open for reading.
pub struct Inlet {
    library: &'static Library,
    handle: Handle,
    found: FoundStream,
    numbers: Vec<f64>,
    stamps: Vec<f64>,
}

// SAFETY: the library synchronises an inlet itself, and one thread at a time uses this value.
unsafe impl Send for Inlet {}

/// Returns every stream that responds within `wait_s` seconds.
///
/// # Errors
/// The library is missing, or refuses.
pub fn resolve_all(wait_s: f64) -> Result<Vec<FoundStream>, LslError> {
    let library = library::open()?;
    let mut handles = [ptr::null_mut(); MOST_STREAMS];
    // SAFETY: the array has room for the given number of handles.
    let count = unsafe { (library.resolve_all)(handles.as_mut_ptr(), MOST_STREAMS as u32, wait_s) };
    let infos = taken(library, &handles, count, "the search for streams")?;
    // A device with an invalid description does not hide the others.
    Ok(infos
        .iter()
        .filter_map(|info| FoundStream::parse(&info.xml()).map_err(|why| log::warn!("{why}")).ok())
        .collect())
}

/// Opens the first stream that matches this predicate (XPath on its description, such as `name='eyes' and type='Gaze'`)
/// and responds within `wait_s` seconds. Gives up when `ends` returns true.
///
/// # Errors
/// The library is missing, the predicate is invalid, or no stream matches; the error then lists the streams that were
/// found.
pub fn resolve(predicate: &str, wait_s: f64, ends: &dyn Fn() -> bool) -> Result<Inlet, LslError> {
    let mut left_s = wait_s;
    while left_s > 0.0 {
        if let Some(inlet) = find(predicate, left_s.min(FIND_S), ends)? {
            return Ok(inlet);
        }
        if ends() {
            return Err(LslError::Interrupted);
        }
        left_s -= FIND_S;
    }
    // A short search is enough: all responding streams of this network have responded by now.
    let seen = resolve_all(1.0)?.iter().map(ToString::to_string).collect();
    Err(LslError::NotFound { predicate: predicate.into(), seconds: wait_s, seen })
}

/// Opens the first stream that matches, in one search without calls of `ends`; `None` if no stream matches.
///
/// # Errors
/// The library is missing, the predicate is invalid, or the stream does not respond.
pub fn find(predicate: &str, wait_s: f64, ends: &dyn Fn() -> bool) -> Result<Option<Inlet>, LslError> {
    let library = library::open()?;
    let mut handles = [ptr::null_mut(); 1];
    let words = c_text(predicate);
    // SAFETY: the array has room for the given number of handles; the text is valid for the call.
    let count = unsafe { (library.resolve_by_predicate)(handles.as_mut_ptr(), 1, words.as_ptr(), 1, wait_s) };
    let infos = taken(library, &handles, count, &format!("the predicate {predicate}"))?;
    infos.first().map(|info| Inlet::open(info, ends)).transpose()
}

/// Waits for a response of a stream for `wait_s` seconds at most, in short parts, until `ends` returns true. Returns
/// the response with the library's error code.
pub(super) fn answered<T>(
    wait_s: f64,
    ends: &dyn Fn() -> bool,
    mut ask: impl FnMut(f64, &mut i32) -> T,
) -> Result<(T, i32), LslError> {
    let mut left_s = wait_s;
    loop {
        let mut code = 0;
        let answer = ask(left_s.min(PIECE_S), &mut code);
        left_s -= PIECE_S;
        // lsl_timeout_error: when asked again, the library continues its wait.
        if code != -1 || left_s <= 0.0 {
            return Ok((answer, code));
        }
        if ends() {
            return Err(LslError::Interrupted);
        }
    }
}

fn taken(library: &'static Library, handles: &[Handle], count: i32, what: &str) -> Result<Vec<Info>, LslError> {
    let count = usize::try_from(count).map_err(|_| library.refused(what))?;
    Ok(handles.iter().take(count).map(|handle| Info { library, handle: *handle }).collect())
}

impl Inlet {
    /// Opens a stream for reading. A lost stream is not recovered, because its reader must know of the gap.
    fn open(info: &Info, ends: &dyn Fn() -> bool) -> Result<Self, LslError> {
        let library = info.library;
        let name = FoundStream::parse(&info.xml())?.name;
        // SAFETY: the library copies the description.
        let handle = unsafe { (library.create_inlet)(info.handle, BUFFERED_S, 0, 0) };
        if handle.is_null() {
            return Err(library.refused(&format!("to read {name}")));
        }
        let mut inlet =
            Self { library, handle, found: FoundStream::default(), numbers: Vec::new(), stamps: Vec::new() };
        let handle = inlet.handle;
        // SAFETY: the handle is valid; the returned description is owned here.
        let full = answered(ANSWER_S, ends, |wait_s, code| unsafe { (library.full_info)(handle, wait_s, code) });
        let (full, code) = full?;
        library.check(code, &name, "the description")?;
        if full.is_null() {
            return Err(library.refused(&format!("the description of {name}")));
        }
        inlet.found = FoundStream::parse(&Info { library, handle: full }.xml())?;
        // SAFETY: as above.
        let (_, code) =
            answered(ANSWER_S, ends, |wait_s, code| unsafe { (library.open_stream)(handle, wait_s, code) })?;
        library.check(code, &name, "the samples")?;
        let channels = inlet.found.channels.len().max(1);
        inlet.numbers = vec![0.0; if inlet.found.is_text() { 0 } else { MOST_SAMPLES * channels }];
        inlet.stamps = vec![0.0; MOST_SAMPLES];
        Ok(inlet)
    }

    /// Returns the description of the stream.
    pub fn stream(&self) -> &FoundStream {
        &self.found
    }

    /// Returns the samples that have arrived, 1024 at most; does not wait.
    ///
    /// # Errors
    /// The stream is lost.
    pub fn pull(&mut self) -> Result<SampleChunk, LslError> {
        if self.found.is_text() { self.pull_texts() } else { self.pull_numbers() }
    }

    fn pull_numbers(&mut self) -> Result<SampleChunk, LslError> {
        let (mut code, channels) = (0, self.found.channels.len().max(1));
        let [values, samples] = [self.numbers.len(), self.stamps.len()].map(|length| length as c_ulong);
        // SAFETY: both buffers have room for the given numbers of values.
        let read = unsafe {
            let (numbers, stamps) = (self.numbers.as_mut_ptr(), self.stamps.as_mut_ptr());
            (self.library.pull_numbers)(self.handle, numbers, stamps, values, samples, 0.0, &mut code)
        };
        self.library.check(code, &self.found.name, "samples")?;
        let read = usize::try_from(read).unwrap_or(0).min(self.numbers.len());
        let stamps_s = self.stamps[..read / channels].to_vec();
        Ok(SampleChunk { stamps_s, values: SampleValues::Numbers(self.numbers[..read].to_vec()) })
    }

    fn pull_texts(&mut self) -> Result<SampleChunk, LslError> {
        let channels = self.found.channels.len();
        let (mut stamps_s, mut values, mut bytes) = (Vec::new(), Vec::new(), 0);
        while stamps_s.len() < MOST_SAMPLES && bytes < MOST_TEXT_BYTES {
            let mut texts: Vec<*mut c_char> = vec![ptr::null_mut(); channels];
            let (mut code, count) = (0, i32::try_from(channels).unwrap_or(i32::MAX));
            // SAFETY: there is room for one text per channel; the returned texts are owned here until they are freed.
            let stamp: c_double =
                unsafe { (self.library.pull_texts)(self.handle, texts.as_mut_ptr(), count, 0.0, &mut code) };
            if code != 0 && !stamps_s.is_empty() {
                // Samples from before the loss are returned first; the next call reports the loss.
                break;
            }
            self.library.check(code, &self.found.name, "samples")?;
            if stamp == 0.0 {
                break;
            }
            stamps_s.push(stamp);
            for pointer in texts {
                // SAFETY: as above.
                let value = unsafe { text(pointer) };
                bytes += value.len();
                values.push(value);
                if !pointer.is_null() {
                    unsafe { (self.library.destroy_string)(pointer) };
                }
            }
        }
        Ok(SampleChunk { stamps_s, values: SampleValues::Texts(values) })
    }

    /// Measures the offset of the device's clock from this computer's; the first time it waits for `wait_s` seconds at
    /// most.
    ///
    /// # Errors
    /// The device does not respond, or is lost.
    pub fn clock_offset(&mut self, wait_s: f64, ends: &dyn Fn() -> bool) -> Result<ClockOffset, LslError> {
        let (mut remote_s, mut uncertainty_s) = (0.0, 0.0);
        // SAFETY: the pointers are valid for the call.
        let (offset_s, code) = answered(wait_s, ends, |wait_s, code| unsafe {
            (self.library.time_correction)(self.handle, &mut remote_s, &mut uncertainty_s, wait_s, code)
        })?;
        self.library.check(code, &self.found.name, "the clock")?;
        Ok(ClockOffset { measured_lsl_s: remote_s + offset_s, offset_s, uncertainty_s })
    }
}

impl Drop for Inlet {
    fn drop(&mut self) {
        // SAFETY: created by the library and destroyed once.
        unsafe { (self.library.destroy_inlet)(self.handle) }
    }
}
