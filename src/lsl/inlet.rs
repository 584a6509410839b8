//! A stream of another device. In: a predicate. Out: samples with the device's own time stamps, how far its clock is from this
//! machine's, and that it is gone.

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

/// Streams that are looked at, at most.
const MOST_STREAMS: usize = 256;
/// Samples that one call reads, at most.
const MOST_SAMPLES: usize = 1024;
/// So long the library keeps samples for us, seconds.
const BUFFERED_S: i32 = 360;
/// What a stream has to say before it is read, it says within this time, seconds.
const ANSWER_S: f64 = 5.0;
/// Longest piece of a wait for an answer, seconds: the end of the program is heard between two.
const PIECE_S: f64 = 0.2;
/// Longest piece of a search for a stream, seconds. A search that begins anew asks all devices again.
const FIND_S: f64 = 0.5;
/// Bytes of texts after which a call returns what it has: a sample may hold a megabyte.
const MOST_TEXT_BYTES: usize = 8 << 20;

/// Samples, oldest first.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleChunk {
    /// When each was taken, seconds by the clock of the device's computer.
    pub stamps_s: Vec<f64>,
    /// Its values: of all channels of the first, then of the second, and so on.
    pub values: SampleValues,
}

/// Values of samples.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleValues {
    /// Numbers; whole ones are exact up to 2^53.
    Numbers(Vec<f64>),
    /// Texts.
    Texts(Vec<String>),
}

/// How far a device's clock is from this machine's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClockOffset {
    /// When it was measured, seconds on this machine's clock.
    pub measured_lsl_s: f64,
    /// To be added to the device's time stamps, seconds.
    pub offset_s: f64,
    /// It is wrong by this at most: the whole time of the exchange by which it was measured, seconds.
    pub uncertainty_s: f64,
}

/// A stream that is being read.
pub struct Inlet {
    library: &'static Library,
    handle: Handle,
    found: FoundStream,
    numbers: Vec<f64>,
    stamps: Vec<f64>,
}

// SAFETY: the library guards an inlet by itself; this is used by one thread at a time.
unsafe impl Send for Inlet {}

/// Every stream that answers within `wait_s` seconds.
///
/// # Errors
/// The library is not here, or refuses.
pub fn resolve_all(wait_s: f64) -> Result<Vec<FoundStream>, LslError> {
    let library = library::open()?;
    let mut handles = [ptr::null_mut(); MOST_STREAMS];
    // SAFETY: room for as many as it is told.
    let count = unsafe { (library.resolve_all)(handles.as_mut_ptr(), MOST_STREAMS as u32, wait_s) };
    let infos = taken(library, &handles, count, "the search for streams")?;
    // One device that describes itself wrongly hides no other.
    Ok(infos
        .iter()
        .filter_map(|info| FoundStream::parse(&info.xml()).map_err(|why| log::warn!("{why}")).ok())
        .collect())
}

/// The first stream with this predicate (XPath on its description, such as `name='eyes' and type='Gaze'`) that answers within
/// `wait_s` seconds, read from now on; gives up when `ends` says so.
///
/// # Errors
/// The library is not here, the predicate is none, or no such stream is there: then the error lists those that are.
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
    // Short: the streams of this network have answered meanwhile if they ever do.
    let seen = resolve_all(1.0)?.iter().map(FoundStream::words).collect();
    Err(LslError::NotFound { predicate: predicate.into(), seconds: wait_s, seen })
}

/// The same without looking in between; `None` where there is no such stream.
///
/// # Errors
/// The library is not here, or the predicate is none; the stream that is there does not answer.
pub fn find(predicate: &str, wait_s: f64, ends: &dyn Fn() -> bool) -> Result<Option<Inlet>, LslError> {
    let library = library::open()?;
    let mut handles = [ptr::null_mut(); 1];
    let words = c_text(predicate);
    // SAFETY: room for as many as it is told; the text is valid for the call.
    let count = unsafe { (library.resolve_by_predicate)(handles.as_mut_ptr(), 1, words.as_ptr(), 1, wait_s) };
    let infos = taken(library, &handles, count, &format!("the predicate {predicate}"))?;
    infos.first().map(|info| Inlet::open(info, ends)).transpose()
}

/// Asks for an answer of a stream for `wait_s` seconds at most, in short pieces, until `ends` says that nobody wants it any more.
/// Returns the answer with the library's number of its error.
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
        // lsl_timeout_error: asked again, the library goes on where it was.
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
    /// Reads a stream from now on. It does not come back by itself when it is gone: whoever reads it has to know of the gap.
    fn open(info: &Info, ends: &dyn Fn() -> bool) -> Result<Self, LslError> {
        let library = info.library;
        let name = FoundStream::parse(&info.xml())?.name;
        // SAFETY: the description is copied.
        let handle = unsafe { (library.create_inlet)(info.handle, BUFFERED_S, 0, 0) };
        if handle.is_null() {
            return Err(library.refused(&format!("to read {name}")));
        }
        let mut inlet =
            Self { library, handle, found: FoundStream::default(), numbers: Vec::new(), stamps: Vec::new() };
        let handle = inlet.handle;
        // SAFETY: the handle is valid; the description that comes is ours.
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

    /// What the stream says of itself.
    pub fn stream(&self) -> &FoundStream {
        &self.found
    }

    /// The samples that have come, 1024 at most; does not wait.
    ///
    /// # Errors
    /// The stream is gone.
    pub fn pull(&mut self) -> Result<SampleChunk, LslError> {
        if self.found.is_text() { self.pull_texts() } else { self.pull_numbers() }
    }

    fn pull_numbers(&mut self) -> Result<SampleChunk, LslError> {
        let (mut code, channels) = (0, self.found.channels.len().max(1));
        let [values, samples] = [self.numbers.len(), self.stamps.len()].map(|length| length as c_ulong);
        // SAFETY: both have room for as many as it is told.
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
            // SAFETY: room for a text of each channel; those that come are ours until they are given back.
            let stamp: c_double =
                unsafe { (self.library.pull_texts)(self.handle, texts.as_mut_ptr(), count, 0.0, &mut code) };
            if code != 0 && !stamps_s.is_empty() {
                // What came before is not lost with the stream: the next call says that it is gone.
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

    /// How far the device's clock is from this machine's, now; waits for it for `wait_s` seconds at most, the first time.
    ///
    /// # Errors
    /// The device does not answer, or is gone.
    pub fn clock_offset(&mut self, wait_s: f64, ends: &dyn Fn() -> bool) -> Result<ClockOffset, LslError> {
        let (mut remote_s, mut uncertainty_s) = (0.0, 0.0);
        // SAFETY: the places are valid for the call.
        let (offset_s, code) = answered(wait_s, ends, |wait_s, code| unsafe {
            (self.library.time_correction)(self.handle, &mut remote_s, &mut uncertainty_s, wait_s, code)
        })?;
        self.library.check(code, &self.found.name, "the clock")?;
        Ok(ClockOffset { measured_lsl_s: remote_s + offset_s, offset_s, uncertainty_s })
    }
}

impl Drop for Inlet {
    fn drop(&mut self) {
        // SAFETY: made by the library and given back once.
        unsafe { (self.library.destroy_inlet)(self.handle) }
    }
}
