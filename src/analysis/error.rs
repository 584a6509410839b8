//! Faults of an analysis. In: messages of the readers. Out: an error whose message is complete.

/// Reason why a folder cannot be analysed.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// Nothing to analyse, or a file that does not have this program's format; the message is complete.
    #[error("{0}")]
    Input(String),
    /// A recording cannot be read.
    #[error(transparent)]
    Record(#[from] crate::record::RecordError),
}
