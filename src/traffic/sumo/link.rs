//! A connection to a SUMO that runs elsewhere. In: messages of [`super::wire`]. Out: whole answers, or why there are none:
//! nobody listens, it is silent, it is not SUMO, it is gone. Every wait has an end: the time-out, or
//! [`interrupt`](crate::traffic::interrupt).

use super::wire::{self, Message, Reply, WireFault};
use crate::traffic::{TrafficError, is_interrupted};
use std::{
    io::{ErrorKind, Read, Write},
    net::{TcpStream, ToSocketAddrs},
    sync::mpsc::{self, RecvTimeoutError},
    time::{Duration, Instant},
};

/// A wait looks this often whether it was interrupted.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// What does not answer as SUMO does gets so long to say what it is.
const NAME_YOURSELF: Duration = Duration::from_millis(500);
/// The longest message that SUMO sends us: states of 1,000 cars are 100 kB.
const LONGEST: usize = 16 << 20;
/// The same for its version, the first that it says.
const LONGEST_VERSION: usize = 4096;

/// A connection.
pub(super) struct Link {
    stream: TcpStream,
    /// `host:port`, as the person wrote it.
    pub address: String,
    timeout: Duration,
    /// What was received and not used yet.
    input: Vec<u8>,
    /// The wait that is set for the socket.
    waits: Duration,
    /// What is waited for, and until when.
    what: String,
    until: Instant,
}

impl Link {
    /// Connects.
    ///
    /// # Errors
    /// Nobody listens, no answer in time, an interruption.
    pub fn open(host: &str, port: u16, timeout: Duration) -> Result<Self, TrafficError> {
        let address = if host.contains(':') { format!("[{host}]:{port}") } else { format!("{host}:{port}") };
        let what = "the connection".to_owned();
        let until = now() + timeout;
        let (told, connected) = mpsc::channel();
        let target = (host.to_owned(), port);
        // A thread of its own: neither looking up a name nor connecting can be interrupted. It ends with the system's
        // own time-out at the latest, and nobody waits for it.
        std::thread::spawn(move || drop(told.send(connect(target, timeout))));
        let stream = loop {
            match connected.recv_timeout(LOOK_EVERY) {
                Ok(Ok(stream)) => break stream,
                Ok(Err(error)) if !matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {
                    return Err(TrafficError::Unreachable { address, why: error.to_string() });
                }
                Err(RecvTimeoutError::Timeout) if is_interrupted() => return Err(TrafficError::Interrupted),
                Err(RecvTimeoutError::Timeout) if now() < until => {}
                _ => return Err(TrafficError::Silent { address, what, seconds: timeout.as_secs_f64() }),
            }
        };
        let link = Self { stream, address, timeout, input: Vec::new(), waits: Duration::ZERO, what, until };
        link.stream.set_nodelay(true).map_err(|error| link.lost(&error))?;
        link.stream.set_write_timeout(Some(LOOK_EVERY)).map_err(|error| link.lost(&error))?;
        Ok(link)
    }

    /// Asks for SUMO's version: number of the protocol and name. Who listens may be no SUMO at all, and is told from one
    /// here.
    ///
    /// # Errors
    /// It is silent, gone, or not SUMO.
    pub fn version(&mut self) -> Result<(i32, String), TrafficError> {
        let (_, bytes) = Message::of(wire::GET_VERSION, |_| ()).finish();
        // Some servers speak first: SSH, mail. What they say is kept for the message.
        let asked = self.send(&bytes, "its version");
        let found = asked.and_then(|()| {
            loop {
                if !self.looks_like_version() {
                    break Err(self.not_sumo());
                }
                match self.poll(LOOK_EVERY) {
                    Ok(true) => break self.message(),
                    Ok(false) => {}
                    Err(error) => break Err(error),
                }
            }
        });
        match found {
            Ok(reply) => {
                let parsed = (|| {
                    let mut reply = Reply(&reply);
                    reply.status(wire::GET_VERSION)?;
                    reply.command(wire::GET_VERSION)?;
                    Ok((reply.i32()?, reply.text()?.to_owned()))
                })();
                parsed.map_err(|_: WireFault| self.not_sumo())
            }
            Err(TrafficError::Silent { address, what, seconds }) => {
                // It cannot become worse: whoever waits for a line of text answers this one.
                let _ = self.stream.write_all(b"GET / HTTP/1.0\r\n\r\n");
                self.until = now() + NAME_YOURSELF;
                while self.input.len() < 64 && matches!(self.poll(LOOK_EVERY), Ok(false)) {}
                if self.input.is_empty() {
                    return Err(TrafficError::Silent { address, what, seconds });
                }
                Err(self.not_sumo())
            }
            // Some servers answer and hang up at once.
            Err(TrafficError::Lost { .. }) if !self.looks_like_version() => Err(self.not_sumo()),
            Err(error) => Err(error),
        }
    }

    /// False if what came so far cannot be the answer with SUMO's version.
    fn looks_like_version(&self) -> bool {
        self.length().is_none_or(|length| (5..=LONGEST_VERSION).contains(&length))
    }

    /// What came instead of SUMO's version, as far as it is text, on one line.
    fn not_sumo(&self) -> TrafficError {
        let text = String::from_utf8_lossy(&self.input);
        let line = text.lines().next().unwrap_or_default();
        let said = line.chars().take(80).flat_map(char::escape_default).collect();
        TrafficError::NotSumo { address: self.address.clone(), said }
    }

    /// Sends bytes and says what is waited for from now on.
    ///
    /// # Errors
    /// It takes nothing in time, or is gone.
    pub fn send(&mut self, mut bytes: &[u8], what: &str) -> Result<(), TrafficError> {
        self.until = now() + self.timeout;
        self.what.clear();
        self.what.push_str(what);
        while !bytes.is_empty() {
            match self.stream.write(bytes) {
                Ok(0) => return Err(self.lost(&ErrorKind::WriteZero.into())),
                Ok(count) => bytes = &bytes[count..],
                Err(error) => self.still_waits(&error)?,
            }
        }
        Ok(())
    }

    /// The next whole message; waits for it.
    ///
    /// # Errors
    /// It does not come in time, or SUMO is gone.
    pub fn receive(&mut self) -> Result<Vec<u8>, TrafficError> {
        while !self.poll(LOOK_EVERY)? {}
        self.message()
    }

    /// True if a whole message is here; waits for it for `patience` at most.
    ///
    /// # Errors
    /// The time-out has passed, SUMO is gone, or the program was interrupted.
    pub fn poll(&mut self, patience: Duration) -> Result<bool, TrafficError> {
        let begun = now();
        loop {
            if self.length().is_some_and(|length| self.input.len() >= length) {
                return Ok(true);
            }
            self.wait_at_most(LOOK_EVERY.min(patience).max(Duration::from_millis(1)))?;
            let mut chunk = [0; 16 << 10];
            match self.stream.read(&mut chunk) {
                Ok(0) => return Err(self.lost(&ErrorKind::UnexpectedEof.into())),
                Ok(count) => self.input.extend_from_slice(&chunk[..count]),
                Err(error) => {
                    self.still_waits(&error)?;
                    if begun.elapsed() >= patience {
                        return Ok(false);
                    }
                }
            }
        }
    }

    /// Takes the message that is here.
    fn message(&mut self) -> Result<Vec<u8>, TrafficError> {
        let length = self.length().filter(|length| (5..=LONGEST).contains(length)).ok_or_else(|| self.garbled())?;
        let rest = self.input.split_off(length);
        let mut message = std::mem::replace(&mut self.input, rest);
        message.drain(..4);
        Ok(message)
    }

    /// The length of the message that comes, once that is here; no more than [`LONGEST`] and a byte.
    fn length(&self) -> Option<usize> {
        let length = u32::from_be_bytes(self.input.get(..4)?.try_into().ok()?);
        Some(usize::try_from(length).unwrap_or(usize::MAX).clamp(4, LONGEST + 1))
    }

    fn wait_at_most(&mut self, time: Duration) -> Result<(), TrafficError> {
        if time != self.waits {
            self.stream.set_read_timeout(Some(time)).map_err(|error| self.lost(&error))?;
            self.waits = time;
        }
        Ok(())
    }

    /// Goes on waiting where `error` says no more than that nothing has come yet.
    fn still_waits(&self, error: &std::io::Error) -> Result<(), TrafficError> {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {}
            _ => return Err(self.lost(error)),
        }
        if is_interrupted() {
            return Err(TrafficError::Interrupted);
        }
        if now() >= self.until {
            let (address, what) = (self.address.clone(), self.what.clone());
            return Err(TrafficError::Silent { address, what, seconds: self.timeout.as_secs_f64() });
        }
        Ok(())
    }

    fn lost(&self, error: &std::io::Error) -> TrafficError {
        let why = match error.kind() {
            ErrorKind::UnexpectedEof => "it has closed the connection".to_owned(),
            _ => error.to_string(),
        };
        TrafficError::Lost { address: self.address.clone(), what: self.what.clone(), why }
    }

    /// What came is no answer.
    pub fn garbled(&self) -> TrafficError {
        let why = "what came is no answer to that".to_owned();
        TrafficError::Lost { address: self.address.clone(), what: self.what.clone(), why }
    }

    /// Ends a SUMO that answers; one that does not is left alone.
    pub fn close(&mut self) {
        let (_, bytes) = Message::of(wire::CLOSE, |_| ()).finish();
        self.timeout = NAME_YOURSELF;
        // There is nobody left to tell of a failure.
        let _ = self.send(&bytes, "its end").and_then(|()| self.receive());
    }
}

fn connect(target: (String, u16), timeout: Duration) -> std::io::Result<TcpStream> {
    let mut last = std::io::Error::new(ErrorKind::NotFound, "the name has no address");
    for address in target.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, timeout) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

#[allow(
    clippy::disallowed_methods,
    reason = "a time-out for another program is a matter of wall time, not of simulation"
)]
fn now() -> Instant {
    Instant::now()
}
