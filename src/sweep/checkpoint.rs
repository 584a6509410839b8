//! Checkpoint of a run, which any process continues with the same bits. In: the state of a training. Out: bytes that name their run and have
//! the SHA-256 of the state, so that no damaged state and no state of another run is continued.

use super::SweepError;
use crate::{record::sha256, train::CHECKPOINT_BYTES};

/// Store of the checkpoint of one run, and listener to what becomes of it.
pub trait RunCheckpoint {
    /// Returns the stored checkpoint, if there is one.
    ///
    /// # Errors
    /// The store cannot be read.
    fn load(&self) -> Result<Option<Vec<u8>>, SweepError>;

    /// Replaces the stored checkpoint as a whole.
    ///
    /// # Errors
    /// The store cannot be written.
    fn save(&self, checkpoint: &[u8]) -> Result<(), SweepError>;

    /// Reports that the run continues from its checkpoint, or why it does not.
    fn report(&self, text: &str);
}

/// Store that keeps nothing: the run starts anew.
pub struct NoCheckpoint;

impl RunCheckpoint for NoCheckpoint {
    fn load(&self) -> Result<Option<Vec<u8>>, SweepError> {
        Ok(None)
    }

    fn save(&self, _checkpoint: &[u8]) -> Result<(), SweepError> {
        Ok(())
    }

    fn report(&self, _text: &str) {}
}

/// Returns the checkpoint of the run with this fingerprint.
///
/// # Errors
/// The state is larger than a checkpoint may be.
pub(super) fn sealed(run: &str, state: &str) -> Result<Vec<u8>, SweepError> {
    let checkpoint = format!("{run} {}\n{state}", sha256(state.as_bytes())).into_bytes();
    match too_large(&checkpoint) {
        Some(fault) => Err(SweepError::Run(fault)),
        None => Ok(checkpoint),
    }
}

/// Returns the fault of a checkpoint that is too large.
fn too_large(checkpoint: &[u8]) -> Option<String> {
    let size = checkpoint.len() as u64;
    (size > CHECKPOINT_BYTES).then(|| format!("it has {size} bytes; allowed: {CHECKPOINT_BYTES}"))
}

/// Returns the state in a checkpoint.
///
/// # Errors
/// The checkpoint is damaged, too large, or of another run.
pub(super) fn opened<'a>(run: &str, checkpoint: &'a [u8]) -> Result<&'a str, String> {
    if let Some(fault) = too_large(checkpoint) {
        return Err(fault);
    }
    let text = std::str::from_utf8(checkpoint).ok();
    let (head, state) = text.and_then(|text| text.split_once('\n')).ok_or("damaged")?;
    let (of, sum) = head.split_once(' ').ok_or("damaged")?;
    if sum != sha256(state.as_bytes()) {
        return Err("damaged".into());
    }
    if of == run { Ok(state) } else { Err(format!("of another run, {of}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_that_is_cut_changed_or_of_another_run_is_refused() {
        let whole = sealed("0a1b", "{\"speed\": 4.25}\nmore").expect("a small state");
        assert_eq!(opened("0a1b", &whole), Ok("{\"speed\": 4.25}\nmore"));
        assert_eq!(opened("0a1c", &whole), Err("of another run, 0a1b".into()));
        for end in 0..whole.len() {
            assert_eq!(opened("0a1b", &whole[..end]), Err("damaged".into()), "{end}");
        }
        let at = whole.iter().position(|byte| *byte == b'4').expect("a digit");
        let mut changed = whole.clone();
        changed[at] = b'5';
        assert_eq!(opened("0a1b", &changed), Err("damaged".into()));
        assert_eq!(opened("0a1b", &[0xff; 90]), Err("damaged".into()));
        let large = "0".repeat(CHECKPOINT_BYTES as usize + 1);
        assert!(sealed("0a1b", &large).is_err() && opened("0a1b", large.as_bytes()).is_err());
    }
}
