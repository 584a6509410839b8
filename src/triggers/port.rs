//! The trigger device: a serial port in raw mode, 8 bits, no parity, 1 stop bit. In: bytes with the time of their event. Out: the bytes,
//! written by a thread without delay; and the time of each.

use super::{TriggerCodes, TriggerError, TriggerSettings, WrittenTrigger};
use std::{
    sync::mpsc::{self, Receiver, Sender},
    thread::JoinHandle,
};

/// Supported baud rates, bit/s.
pub(super) const BAUDS: [u32; 8] = [9_600, 19_200, 38_400, 57_600, 115_200, 230_400, 460_800, 921_600];

/// Device that receives the triggers. When dropped, it writes all pending bytes and, with a return time, a last 0.
pub struct TriggerPort {
    codes: TriggerCodes,
    due: Option<Sender<WrittenTrigger>>,
    written: Receiver<WrittenTrigger>,
    /// Number of triggers that were sent to the thread and not yet returned to the caller.
    waiting: usize,
    thread: Option<JoinHandle<()>>,
}

impl TriggerPort {
    /// Opens the device and sets its lines to 0 if bytes return to 0.
    ///
    /// # Errors
    /// The device cannot be opened, or is not a serial port.
    pub fn open(settings: &TriggerSettings) -> Result<Self, TriggerError> {
        let device = system::open(settings)?;
        let (due, to_write) = mpsc::channel::<WrittenTrigger>();
        let (results, written) = mpsc::channel();
        let pulse_s = settings.return_to_zero_ms / 1e3;
        let write = move || {
            for trigger in to_write {
                let _ = results.send(system::write(&device, trigger));
                if pulse_s > 0.0 {
                    std::thread::sleep(std::time::Duration::from_secs_f64(pulse_s));
                    system::zero(&device);
                }
            }
        };
        let thread = std::thread::Builder::new().name("triggers".into()).spawn(write).map_err(TriggerError::Thread)?;
        Ok(Self { codes: settings.codes, due: Some(due), written, waiting: 0, thread: Some(thread) })
    }

    /// Writes the byte of an event that happened at `due_s` on the clock of [`crate::lsl::local_clock_s`], if the event has one. Does not
    /// wait.
    pub fn event(&mut self, event: &str, due_s: f64) {
        if let (Some(code), Some(due)) = (self.codes.of(event), &self.due) {
            // The thread lives until this port is dropped.
            let sent = due.send(WrittenTrigger { event: event.into(), code, due_s, written_s: None, why: None });
            self.waiting += usize::from(sent.is_ok());
        }
    }

    /// Takes the triggers written since the last call.
    pub fn take_written(&mut self) -> Vec<WrittenTrigger> {
        let written: Vec<_> = self.written.try_iter().collect();
        self.waiting -= written.len();
        written
    }

    /// Waits until all pending triggers are written, and takes them.
    pub fn wait_written(&mut self) -> Vec<WrittenTrigger> {
        let written: Vec<_> = self.written.iter().take(self.waiting).collect();
        self.waiting -= written.len();
        written
    }
}

impl Drop for TriggerPort {
    fn drop(&mut self) {
        self.due = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(target_os = "linux")]
mod system {
    //! Serial ports on Linux.

    use super::{TriggerError, TriggerSettings, WrittenTrigger};
    use crate::lsl::local_clock_s;
    use nix::fcntl::{FcntlArg, OFlag, fcntl};
    use nix::sys::termios::{BaudRate, ControlFlags, SetArg, cfmakeraw, cfsetspeed, tcgetattr, tcsetattr};
    use std::{
        fs::{File, OpenOptions},
        io::{Error, Write},
        os::unix::fs::OpenOptionsExt,
    };

    fn rate(baud: u32) -> BaudRate {
        match baud {
            9_600 => BaudRate::B9600,
            19_200 => BaudRate::B19200,
            38_400 => BaudRate::B38400,
            57_600 => BaudRate::B57600,
            230_400 => BaudRate::B230400,
            460_800 => BaudRate::B460800,
            921_600 => BaudRate::B921600,
            _ => BaudRate::B115200,
        }
    }

    pub fn open(settings: &TriggerSettings) -> Result<File, TriggerError> {
        let fault = |why: Error| TriggerError::Open { device: settings.device.clone(), why };
        // `O_NONBLOCK`: does not wait for a modem's carrier. `O_NOCTTY`: never becomes the controlling terminal.
        let flags = nix::libc::O_NOCTTY | nix::libc::O_NONBLOCK;
        let file =
            OpenOptions::new().read(true).write(true).custom_flags(flags).open(&settings.device).map_err(fault)?;
        // From here on a write waits for room in the buffer, so that no byte is lost.
        fcntl(&file, FcntlArg::F_SETFL(OFlag::O_RDWR)).map_err(|why| fault(why.into()))?;
        let mut port = tcgetattr(&file).map_err(|_| fault(Error::other("it is not a serial port")))?;
        cfmakeraw(&mut port);
        port.control_flags |= ControlFlags::CLOCAL | ControlFlags::CREAD;
        port.control_flags &= !(ControlFlags::CSTOPB | ControlFlags::CRTSCTS);
        cfsetspeed(&mut port, rate(settings.baud)).map_err(|why| fault(why.into()))?;
        tcsetattr(&file, SetArg::TCSANOW, &port).map_err(|why| fault(why.into()))?;
        if settings.return_to_zero_ms > 0.0 {
            (&file).write_all(&[0]).map_err(fault)?;
        }
        Ok(file)
    }

    pub fn write(mut device: &File, trigger: WrittenTrigger) -> WrittenTrigger {
        match device.write_all(&[trigger.code]) {
            Ok(()) => WrittenTrigger { written_s: Some(local_clock_s()), ..trigger },
            Err(why) => WrittenTrigger { why: Some(why.to_string()), ..trigger },
        }
    }

    /// Sets the lines to 0. Errors are ignored, because a lost device was already reported for the byte before.
    pub fn zero(mut device: &File) {
        let _ = device.write_all(&[0]);
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    //! Other systems have no triggers.

    use super::{TriggerError, TriggerSettings, WrittenTrigger};

    pub fn open(_: &TriggerSettings) -> Result<(), TriggerError> {
        Err(TriggerError::System)
    }

    pub fn write(_: &(), trigger: WrittenTrigger) -> WrittenTrigger {
        trigger
    }

    pub fn zero(_: &()) {}
}
