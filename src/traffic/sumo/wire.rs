//! Messages of TraCI, SUMO's protocol over a socket, as bytes. In: commands with their numbers and texts. Out: a message to
//! send; or from a message received: statuses, numbers and texts, never read beyond its end. Big-endian; a message is
//! its length and commands, each of them its own length, its number and its content. Numbers are those of SUMO's
//! `TraCIConstants.h`, version 22 of the protocol.

/// Why an answer is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum WireFault {
    /// SUMO refused the command and says why.
    Refused(String),
    /// What came is no answer to what was asked.
    Garbled,
}

/// Commands.
pub(super) const GET_VERSION: u8 = 0x00;
pub(super) const LOAD: u8 = 0x01;
pub(super) const STEP: u8 = 0x02;
pub(super) const SET_ORDER: u8 = 0x03;
pub(super) const CLOSE: u8 = 0x7F;
pub(super) const GET_LANE: u8 = 0xA3;
pub(super) const GET_VEHICLE: u8 = 0xA4;
pub(super) const GET_SIMULATION: u8 = 0xAB;
pub(super) const SET_LANE: u8 = 0xC3;
pub(super) const SET_VEHICLE: u8 = 0xC4;
pub(super) const SET_TYPE: u8 = 0xC5;
pub(super) const SET_ROUTE: u8 = 0xC6;
pub(super) const SUBSCRIBE_VEHICLE: u8 = 0xD4;
/// An answer to a getter or a subscription has the command's number and this.
pub(super) const ANSWER: u8 = 0x10;

/// Variables.
pub(super) const OPTION: u8 = 0x32;
pub(super) const DISALLOWED: u8 = 0x35;
pub(super) const PREVIOUS_SPEED: u8 = 0x3C;
pub(super) const SPEED: u8 = 0x40;
pub(super) const MAX_SPEED: u8 = 0x41;
pub(super) const POSITION: u8 = 0x42;
pub(super) const ANGLE: u8 = 0x43;
pub(super) const LENGTH: u8 = 0x44;
pub(super) const ACCEL: u8 = 0x46;
pub(super) const DECEL: u8 = 0x47;
pub(super) const TAU: u8 = 0x48;
pub(super) const MIN_GAP: u8 = 0x4C;
pub(super) const WIDTH: u8 = 0x4D;
pub(super) const LANE_ID: u8 = 0x51;
pub(super) const LANE_POSITION: u8 = 0x56;
pub(super) const MOVE_TO: u8 = 0x5C;
pub(super) const SPEED_FACTOR: u8 = 0x5E;
pub(super) const SPEED_DEVIATION: u8 = 0x5F;
pub(super) const EMERGENCY_DECEL: u8 = 0x7B;
pub(super) const APPARENT_DECEL: u8 = 0x7C;
pub(super) const ADD: u8 = 0x80;
pub(super) const ADD_FULL: u8 = 0x85;
pub(super) const COPY: u8 = 0x88;
pub(super) const SPEED_MODE: u8 = 0xB3;
pub(super) const MOVE_TO_XY: u8 = 0xB4;
pub(super) const LANE_CHANGE_MODE: u8 = 0xB6;

/// Types of values.
const POSITION_2D: u8 = 0x01;
const BYTE: u8 = 0x08;
const INTEGER: u8 = 0x09;
const DOUBLE: u8 = 0x0B;
const STRING: u8 = 0x0C;
const STRING_LIST: u8 = 0x0E;
const COMPOUND: u8 = 0x0F;

/// "No value" where a number has to be.
pub(super) const INVALID_DOUBLE: f64 = -1_073_741_824.0;

/// A message being written.
#[derive(Debug)]
pub(super) struct Message {
    bytes: Vec<u8>,
    /// The commands in it, for the statuses of the answer.
    commands: Vec<u8>,
}

impl Message {
    pub fn new() -> Self {
        Self { bytes: vec![0; 4], commands: Vec::new() }
    }

    /// A message of one command.
    pub fn of(command: u8, fill: impl FnOnce(&mut Content)) -> Self {
        let mut message = Self::new();
        message.add(command, fill);
        message
    }

    /// One command more.
    pub fn add(&mut self, command: u8, fill: impl FnOnce(&mut Content)) {
        let start = self.bytes.len();
        // The long form of a command's length, which is right for every length.
        self.bytes.extend_from_slice(&[0, 0, 0, 0, 0, command]);
        fill(&mut Content(&mut self.bytes));
        let length = self.bytes.len() - start;
        self.bytes[start + 1..start + 5].copy_from_slice(&length_field(length));
        self.commands.push(command);
    }

    /// True if it holds no command.
    pub fn is_empty(&self) -> bool {
        self.commands.is_empty()
    }

    /// Its commands, and the bytes to send.
    pub fn finish(mut self) -> (Vec<u8>, Vec<u8>) {
        let length = length_field(self.bytes.len());
        self.bytes[..4].copy_from_slice(&length);
        (self.commands, self.bytes)
    }
}

/// A length as the protocol has it. A message of ours is at most a route of a million metres: some MB.
fn length_field(length: usize) -> [u8; 4] {
    u32::try_from(length).unwrap_or(u32::MAX).to_be_bytes()
}

/// The content of a command being written; values say their type first.
pub(super) struct Content<'a>(&'a mut Vec<u8>);

impl Content<'_> {
    pub fn raw_u8(&mut self, value: u8) -> &mut Self {
        self.0.push(value);
        self
    }

    pub fn raw_i32(&mut self, value: i32) -> &mut Self {
        self.0.extend_from_slice(&value.to_be_bytes());
        self
    }

    pub fn raw_f64(&mut self, value: f64) -> &mut Self {
        self.0.extend_from_slice(&value.to_be_bytes());
        self
    }

    pub fn raw_text(&mut self, text: &str) -> &mut Self {
        self.0.extend_from_slice(&length_field(text.len()));
        self.0.extend_from_slice(text.as_bytes());
        self
    }

    /// Which variable of which object.
    pub fn variable(&mut self, variable: u8, id: &str) -> &mut Self {
        self.raw_u8(variable).raw_text(id)
    }

    pub fn double(&mut self, value: f64) -> &mut Self {
        self.raw_u8(DOUBLE).raw_f64(value)
    }

    pub fn integer(&mut self, value: i32) -> &mut Self {
        self.raw_u8(INTEGER).raw_i32(value)
    }

    pub fn byte(&mut self, value: u8) -> &mut Self {
        self.raw_u8(BYTE).raw_u8(value)
    }

    pub fn text(&mut self, text: &str) -> &mut Self {
        self.raw_u8(STRING).raw_text(text)
    }

    pub fn texts(&mut self, texts: &[String]) -> &mut Self {
        self.raw_u8(STRING_LIST).0.extend_from_slice(&length_field(texts.len()));
        texts.iter().fold(self, |content, text| content.raw_text(text))
    }

    /// So many values follow, which are one.
    pub fn compound(&mut self, values: i32) -> &mut Self {
        self.raw_u8(COMPOUND).raw_i32(values)
    }
}

/// A message received, without its length, as far as it was not read yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reply<'a>(pub &'a [u8]);

impl<'a> Reply<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], WireFault> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(WireFault::Garbled)?;
        self.0 = rest;
        Ok(taken)
    }

    pub fn u8(&mut self) -> Result<u8, WireFault> {
        Ok(self.take(1)?[0])
    }

    pub fn i32(&mut self) -> Result<i32, WireFault> {
        self.take(4)?.try_into().map(i32::from_be_bytes).map_err(|_| WireFault::Garbled)
    }

    fn f64(&mut self) -> Result<f64, WireFault> {
        self.take(8)?.try_into().map(f64::from_be_bytes).map_err(|_| WireFault::Garbled)
    }

    pub fn text(&mut self) -> Result<&'a str, WireFault> {
        let length = usize::try_from(self.i32()?).map_err(|_| WireFault::Garbled)?;
        std::str::from_utf8(self.take(length)?).map_err(|_| WireFault::Garbled)
    }

    fn typed(&mut self, kind: u8) -> Result<(), WireFault> {
        if self.u8()? == kind { Ok(()) } else { Err(WireFault::Garbled) }
    }

    pub fn double(&mut self) -> Result<f64, WireFault> {
        self.typed(DOUBLE)?;
        self.f64()
    }

    pub fn string(&mut self) -> Result<&'a str, WireFault> {
        self.typed(STRING)?;
        self.text()
    }

    pub fn position(&mut self) -> Result<[f64; 2], WireFault> {
        self.typed(POSITION_2D)?;
        Ok([self.f64()?, self.f64()?])
    }

    /// The begin of the next command in it, which has to be this one.
    pub fn command(&mut self, command: u8) -> Result<(), WireFault> {
        if self.u8()? == 0 {
            self.i32()?;
        }
        self.typed(command)
    }

    /// What SUMO says to a command.
    pub fn status(&mut self, command: u8) -> Result<(), WireFault> {
        self.command(command)?;
        let result = self.u8()?;
        let text = self.text()?;
        if result == 0 { Ok(()) } else { Err(WireFault::Refused(text.to_owned())) }
    }

    /// True if all was read.
    pub fn is_read(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_command_is_written_as_sumo_reads_it() {
        let (commands, bytes) = Message::of(SET_ORDER, |content| {
            content.raw_i32(1);
        })
        .finish();
        assert_eq!(commands, [SET_ORDER]);
        // Length of the message; 0 and length of the command; its number; the order.
        assert_eq!(bytes, [0, 0, 0, 14, 0, 0, 0, 0, 10, 3, 0, 0, 0, 1]);
    }

    #[test]
    fn a_version_is_read_from_the_bytes_that_sumo_sends() {
        let bytes = b"\x07\x00\x00\x00\x00\x00\x00\x15\x00\x00\x00\x00\x16\x00\x00\x00\x0bSUMO 1.28.0";
        let mut reply = Reply(bytes);
        reply.status(GET_VERSION).unwrap();
        reply.command(GET_VERSION).unwrap();
        assert_eq!((reply.i32().unwrap(), reply.text().unwrap()), (22, "SUMO 1.28.0"));
        assert!(reply.is_read());
    }

    proptest! {
        /// What a stranger sends is read to its end at most, and never trusted for a length.
        #[test]
        fn no_bytes_bring_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
            let _ = Reply(&bytes).status(STEP);
            let _ = Reply(&bytes).text();
            let _ = Reply(&bytes).string();
            let _ = Reply(&bytes).double();
            let _ = Reply(&bytes).position();
        }
    }
}
