//! Reading of wheels, independent of the operating system. In: a [`WheelPort`]. Out: [`WheelMessage`] to whoever polls. One
//! turn finds a wheel or waits a moment for its events; a wheel that fails to be read is lost, and looked for again.

use super::{
    profile::WheelProfile,
    wheel::{FoundWheel, WheelMessage},
};
use std::{
    io,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, Sender},
    },
    thread::JoinHandle,
    time::Duration,
};

/// While there is no wheel, the system is asked so often.
const LOOK_AGAIN: Duration = Duration::from_millis(500);

/// A way to wheels.
pub trait WheelPort: Send + 'static {
    /// An open wheel.
    type Wheel;

    /// Looks for a wheel and opens it. `say` takes what a person has to know, again and again.
    fn find(&mut self, say: &mut dyn FnMut(String)) -> Option<(FoundWheel, Self::Wheel)>;

    /// From the next wheel on, this is its profile.
    fn prefer(&mut self, profile: WheelProfile);

    /// Waits a moment for events, at most a tenth of a second, and adds them to `told`.
    ///
    /// # Errors
    /// The wheel is gone.
    fn read(&mut self, wheel: &mut Self::Wheel, told: &mut Vec<WheelMessage>) -> io::Result<()>;
}

/// Finds, reads, loses.
pub struct WheelReader<P: WheelPort> {
    port: P,
    wheel: Option<P::Wheel>,
    to: Sender<WheelMessage>,
    /// What was said already, so that each is said once until a wheel is found.
    said: Vec<String>,
}

impl<P: WheelPort> WheelReader<P> {
    /// A reader, and where it tells what it reads.
    pub fn new(port: P) -> (Self, Receiver<WheelMessage>) {
        let (to, told) = mpsc::channel();
        (Self { port, wheel: None, to, said: Vec::new() }, told)
    }

    /// Takes this profile from now on: lets the wheel go, to find it again with it.
    pub fn prefer(&mut self, profile: WheelProfile) {
        self.port.prefer(profile);
        self.wheel = None;
    }

    /// One turn. False if there is no wheel, so that there is time to wait.
    pub fn turn(&mut self) -> bool {
        let Self { port, wheel, to, said } = self;
        let Some(open) = wheel else {
            let found = port.find(&mut |text| {
                if !said.contains(&text) {
                    let _ = to.send(WheelMessage::Trouble(text.clone()));
                    said.push(text);
                }
            });
            if let Some((found, open)) = found {
                said.clear();
                let _ = to.send(WheelMessage::Connected(Box::new(found)));
                *wheel = Some(open);
            }
            return wheel.is_some();
        };
        let mut told = Vec::new();
        let read = port.read(open, &mut told);
        for told in told {
            let _ = to.send(told);
        }
        if read.is_err() {
            *wheel = None;
            let _ = to.send(WheelMessage::Lost);
        }
        true
    }
}

/// The reading thread; it ends with this.
pub struct ReadingThread {
    stop: Arc<AtomicBool>,
    /// A profile that was learnt, for the thread to take.
    learnt: Arc<Mutex<Option<WheelProfile>>>,
    thread: Option<JoinHandle<()>>,
}

impl ReadingThread {
    /// Reads on a thread of its own.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start<P: WheelPort>(port: P) -> io::Result<(Self, Receiver<WheelMessage>)>
    where
        P::Wheel: Send,
    {
        let (mut reader, told) = WheelReader::new(port);
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let learnt = Arc::new(Mutex::new(None));
        let waiting = Arc::clone(&learnt);
        let thread = std::thread::Builder::new().name("wheel".into()).spawn(move || {
            while !flag.load(Ordering::Relaxed) {
                if let Some(profile) = waiting.lock().unwrap_or_else(PoisonError::into_inner).take() {
                    reader.prefer(profile);
                }
                if !reader.turn() {
                    // In small pieces, so that the end of the program need not wait.
                    for _ in 0..10 {
                        if !flag.load(Ordering::Relaxed) {
                            std::thread::sleep(LOOK_AGAIN / 10);
                        }
                    }
                }
            }
        })?;
        Ok((Self { stop, learnt, thread: Some(thread) }, told))
    }

    /// The wheel is to be taken anew with this profile; it is found again in a moment.
    pub fn prefer(&self, profile: WheelProfile) {
        *self.learnt.lock().unwrap_or_else(PoisonError::into_inner) = Some(profile);
    }
}

impl Drop for ReadingThread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
