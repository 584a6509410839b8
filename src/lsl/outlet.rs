//! A stream of this program. In: samples with the time at which they were taken. Out: whoever listens gets them, in threads of the
//! library's: a push hands a sample over and never waits for the network.

use super::{
    ChannelFormat, LslError, OutletInterface, StreamDescription,
    library::{Handle, Library, c_text},
};
use std::ffi::{CString, c_char};

/// So long the library keeps samples for a listener that is slow, seconds.
const BUFFERED_S: i32 = 360;

/// A stream that others can hear for as long as this lives.
pub struct Outlet {
    library: &'static Library,
    handle: Handle,
    description: StreamDescription,
}

// SAFETY: the library guards an outlet by itself ("all functions of an outlet are thread-safe"); this is used by one thread at a
// time.
unsafe impl Send for Outlet {}

impl Outlet {
    /// Opens a stream that is heard on `interface`.
    ///
    /// # Errors
    /// The library is not here, or refuses; the stream cannot be kept on the interface.
    pub fn open(description: StreamDescription, interface: &OutletInterface) -> Result<Self, LslError> {
        let info = description.info()?;
        interface.confine(|| {
            // SAFETY: the description is copied.
            let handle = unsafe { (info.library.create_outlet)(info.handle, 0, BUFFERED_S) };
            if handle.is_null() {
                return Err(info.library.refused(&format!("the stream {}", description.name)));
            }
            Ok(Self { library: info.library, handle, description })
        })
    }

    /// What it says of itself.
    pub fn description(&self) -> &StreamDescription {
        &self.description
    }

    /// True while somebody listens.
    pub fn is_heard(&self) -> bool {
        // SAFETY: the handle is valid while `self` lives.
        unsafe { (self.library.have_consumers)(self.handle) != 0 }
    }

    /// Hands over a sample of numbers, one for each channel, taken at `stamp_s` on the clock of [`super::local_clock_s`].
    ///
    /// # Errors
    /// It has another number of values than the stream has channels, the stream is one of texts, or the library refuses.
    pub fn push(&self, values: &[f64], stamp_s: f64) -> Result<(), LslError> {
        self.fits(values.len(), ChannelFormat::Numbers)?;
        // SAFETY: as many values as channels.
        let code = unsafe { (self.library.push_numbers)(self.handle, values.as_ptr(), stamp_s, 1) };
        self.library.check(code, &self.description.name, "a sample")
    }

    /// The same of texts.
    ///
    /// # Errors
    /// As [`Outlet::push`].
    pub fn push_texts(&self, values: &[&str], stamp_s: f64) -> Result<(), LslError> {
        self.fits(values.len(), ChannelFormat::Texts)?;
        let owned: Vec<CString> = values.iter().map(|value| c_text(value)).collect();
        let pointers: Vec<*const c_char> = owned.iter().map(|value| value.as_ptr()).collect();
        // SAFETY: as many texts as channels, valid for the call, which copies them.
        let code = unsafe { (self.library.push_texts)(self.handle, pointers.as_ptr(), stamp_s, 1) };
        self.library.check(code, &self.description.name, "a sample")
    }

    /// The library reads as many values as the stream has channels, whatever it is handed.
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
        // SAFETY: made by the library and given back once.
        unsafe { (self.library.destroy_outlet)(self.handle) }
    }
}
