//! The device: a serial port, raw, 8 bits, no parity, 1 stop bit. In: bytes with the time of their event. Out: they are written by a
//! thread of their own, at once; when each was written.

use super::{TriggerCodes, TriggerError, TriggerSettings, WrittenTrigger};
use std::{
    sync::mpsc::{self, Receiver, Sender},
    thread::JoinHandle,
};

/// Speeds, bits a second.
pub(super) const BAUDS: [u32; 8] = [9_600, 19_200, 38_400, 57_600, 115_200, 230_400, 460_800, 921_600];

/// A device that triggers go to. Dropped, it writes what is due and a last 0.
pub struct TriggerPort {
    codes: TriggerCodes,
    due: Option<Sender<WrittenTrigger>>,
    written: Receiver<WrittenTrigger>,
    /// Triggers that were due and are not told of yet.
    waiting: usize,
    thread: Option<JoinHandle<()>>,
}

impl TriggerPort {
    /// Opens the device and sets its lines to 0 where they are to return there.
    ///
    /// # Errors
    /// It cannot be opened, or is no serial port.
    pub fn open(settings: &TriggerSettings) -> Result<Self, TriggerError> {
        let device = system::open(settings)?;
        let (due, to_write) = mpsc::channel::<WrittenTrigger>();
        let (told, written) = mpsc::channel();
        let pulse_s = settings.return_to_zero_ms / 1e3;
        let write = move || {
            for trigger in to_write {
                let _ = told.send(system::write(&device, trigger));
                if pulse_s > 0.0 {
                    std::thread::sleep(std::time::Duration::from_secs_f64(pulse_s));
                    system::zero(&device);
                }
            }
        };
        let thread = std::thread::Builder::new().name("triggers".into()).spawn(write).map_err(TriggerError::Thread)?;
        Ok(Self { codes: settings.codes, due: Some(due), written, waiting: 0, thread: Some(thread) })
    }

    /// An event has happened at `due_s` on the clock of [`crate::lsl::local_clock_s`]: its byte is written, if it has one. Does not
    /// wait.
    pub fn event(&mut self, event: &str, due_s: f64) {
        if let (Some(code), Some(due)) = (self.codes.of(event), &self.due) {
            // The thread lives as long as this does.
            let sent = due.send(WrittenTrigger { event: event.into(), code, due_s, written_s: None, why: None });
            self.waiting += usize::from(sent.is_ok());
        }
    }

    /// What was written since the last call.
    pub fn take_written(&mut self) -> Vec<WrittenTrigger> {
        let written: Vec<_> = self.written.try_iter().collect();
        self.waiting -= written.len();
        written
    }

    /// The same, when all that is due was written.
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
    //! Serial ports as Linux has them.

    use super::{TriggerError, TriggerSettings, WrittenTrigger};
    use crate::lsl::local_clock_s;
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
        // Without waiting for a modem's carrier, and never as the terminal of this program.
        let flags = nix::libc::O_NOCTTY | nix::libc::O_NONBLOCK;
        let file =
            OpenOptions::new().read(true).write(true).custom_flags(flags).open(&settings.device).map_err(fault)?;
        let mut port = tcgetattr(&file).map_err(|_| fault(Error::other("it is no serial port")))?;
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

    /// A device that is gone has said so at the byte before.
    pub fn zero(mut device: &File) {
        let _ = device.write_all(&[0]);
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    //! Other systems: no triggers.

    use super::{TriggerError, TriggerSettings, WrittenTrigger};

    pub fn open(_: &TriggerSettings) -> Result<(), TriggerError> {
        Err(TriggerError::System)
    }

    pub fn write(_: &(), trigger: WrittenTrigger) -> WrittenTrigger {
        trigger
    }

    pub fn zero(_: &()) {}
}
