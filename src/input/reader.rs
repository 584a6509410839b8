//! Reading of wheels, independent of the operating system. In: a [`WheelPort`]. Out: [`WheelMessage`] in a channel. One
//! turn finds a wheel or waits briefly for its events. A wheel that cannot be read is lost, and the reader looks for it
//! again.

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

/// Interval between searches while there is no wheel.
const LOOK_AGAIN: Duration = Duration::from_millis(500);

/// Access to the wheels of an operating system.
pub trait WheelPort: Send + 'static {
    /// Handle of an open wheel.
    type Wheel;

    /// Looks for a wheel and opens it. `report` takes messages for people; the same message may be repeated.
    fn find(&mut self, report: &mut dyn FnMut(String)) -> Option<(FoundWheel, Self::Wheel)>;

    /// Sets the profile that is used from the next wheel on.
    fn prefer(&mut self, profile: WheelProfile);

    /// Waits up to 0.1 s for events and adds them to `messages`.
    ///
    /// # Errors
    /// The wheel is gone.
    fn read(&mut self, wheel: &mut Self::Wheel, messages: &mut Vec<WheelMessage>) -> io::Result<()>;
}

/// Finds, reads and loses wheels.
pub struct WheelReader<P: WheelPort> {
    port: P,
    wheel: Option<P::Wheel>,
    to: Sender<WheelMessage>,
    /// Messages that were sent already; each is sent once until a wheel is found.
    reported: Vec<String>,
}

impl<P: WheelPort> WheelReader<P> {
    /// Returns a reader and the channel of its messages.
    pub fn new(port: P) -> (Self, Receiver<WheelMessage>) {
        let (to, messages) = mpsc::channel();
        (Self { port, wheel: None, to, reported: Vec::new() }, messages)
    }

    /// Sets the profile and releases the wheel, so that it is found again with this profile.
    pub fn prefer(&mut self, profile: WheelProfile) {
        self.port.prefer(profile);
        self.wheel = None;
    }

    /// Runs one turn. Returns false if there is no wheel, so that the caller can wait.
    pub fn turn(&mut self) -> bool {
        let Self { port, wheel, to, reported } = self;
        let Some(open) = wheel else {
            let found = port.find(&mut |text| {
                if !reported.contains(&text) {
                    let _ = to.send(WheelMessage::Trouble(text.clone()));
                    reported.push(text);
                }
            });
            if let Some((found, open)) = found {
                reported.clear();
                let _ = to.send(WheelMessage::Connected(Box::new(found)));
                *wheel = Some(open);
            }
            return wheel.is_some();
        };
        let mut messages = Vec::new();
        let read = port.read(open, &mut messages);
        for message in messages {
            let _ = to.send(message);
        }
        if read.is_err() {
            *wheel = None;
            let _ = to.send(WheelMessage::Lost);
        }
        true
    }
}

/// Thread that reads a wheel; dropping it ends the thread.
pub struct ReadingThread {
    stop: Arc<AtomicBool>,
    /// New profile for the thread to apply.
    learnt: Arc<Mutex<Option<WheelProfile>>>,
    thread: Option<JoinHandle<()>>,
}

impl ReadingThread {
    /// Starts the reading thread.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub fn start<P: WheelPort>(port: P) -> io::Result<(Self, Receiver<WheelMessage>)>
    where
        P::Wheel: Send,
    {
        let (mut reader, messages) = WheelReader::new(port);
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
                    // In short waits, so that the program can end without delay.
                    for _ in 0..10 {
                        if !flag.load(Ordering::Relaxed) {
                            std::thread::sleep(LOOK_AGAIN / 10);
                        }
                    }
                }
            }
        })?;
        Ok((Self { stop, learnt, thread: Some(thread) }, messages))
    }

    /// Reopens the wheel with this profile; the thread applies it at its next turn.
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
