//! Stream of this program. In: samples with the time at which they were taken. Out: samples for all receivers, sent by
//! threads of the library. A push passes a sample on and never waits for the network.

use super::{
    ChannelFormat, LslError, OutletInterface, StreamDescription,
    library::{Handle, Library, c_text},
};
use std::ffi::{CString, c_char};

/// Time for which the library buffers samples for a slow receiver, s.
const BUFFERED_S: i32 = 360;

/// Stream of this program; dropping it ends the stream.
pub struct Outlet {
    library: &'static Library,
    handle: Handle,
    description: StreamDescription,
}

// SAFETY: the library synchronises an outlet itself ("all functions of an outlet are thread-safe"), and one thread at a
// time uses this value.
unsafe impl Send for Outlet {}

impl Outlet {
    /// Opens a stream that can be received on `interface`.
    ///
    /// # Errors
    /// The library is missing, or refuses; the stream cannot be confined to the interface.
    pub fn open(description: StreamDescription, interface: &OutletInterface) -> Result<Self, LslError> {
        let info = description.info()?;
        interface.confine(|| {
            // SAFETY: the library copies the description.
            let handle = unsafe { (info.library.create_outlet)(info.handle, 0, BUFFERED_S) };
            if handle.is_null() {
                return Err(info.library.refused(&format!("the stream {}", description.name)));
            }
            Ok(Self { library: info.library, handle, description })
        })
    }

    /// Returns the description of the stream.
    pub fn description(&self) -> &StreamDescription {
        &self.description
    }

    /// Checks whether the stream has a receiver.
    pub fn is_heard(&self) -> bool {
        // SAFETY: the handle is valid while `self` lives.
        unsafe { (self.library.have_consumers)(self.handle) != 0 }
    }

    /// Sends a sample of numbers, one for each channel, taken at `stamp_s` on the clock of [`super::local_clock_s`].
    ///
    /// # Errors
    /// The number of values differs from the number of channels, the stream is one of texts, or the library refuses.
    pub fn push(&self, values: &[f64], stamp_s: f64) -> Result<(), LslError> {
        self.fits(values.len(), ChannelFormat::Numbers)?;
        // SAFETY: there are as many values as channels.
        let code = unsafe { (self.library.push_numbers)(self.handle, values.as_ptr(), stamp_s, 1) };
        self.library.check(code, &self.description.name, "a sample")
    }

    /// Sends a sample of texts, one for each channel, taken at `stamp_s`.
    ///
    /// # Errors
    /// The number of texts differs from the number of channels, the stream is one of numbers, or the library refuses.
    pub fn push_texts(&self, values: &[&str], stamp_s: f64) -> Result<(), LslError> {
        self.fits(values.len(), ChannelFormat::Texts)?;
        let owned: Vec<CString> = values.iter().map(|value| c_text(value)).collect();
        let pointers: Vec<*const c_char> = owned.iter().map(|value| value.as_ptr()).collect();
        // SAFETY: there are as many texts as channels, valid for the call, which copies them.
        let code = unsafe { (self.library.push_texts)(self.handle, pointers.as_ptr(), stamp_s, 1) };
        self.library.check(code, &self.description.name, "a sample")
    }

    /// Checks that a sample matches the description: the library reads as many values as the stream has channels.
    fn fits(&self, count: usize, format: ChannelFormat) -> Result<(), LslError> {
        let StreamDescription { name, channels, .. } = &self.description;
        if count == channels.len() && format == self.description.format {
            return Ok(());
        }
        let why =
            format!("{count} values of {format:?} for {} channels of {:?}", channels.len(), self.description.format);
        Err(LslError::Refused { what: format!("a sample of {name}"), why })
    }
}

impl Drop for Outlet {
    fn drop(&mut self) {
        // SAFETY: created by the library and destroyed once.
        unsafe { (self.library.destroy_outlet)(self.handle) }
    }
}
