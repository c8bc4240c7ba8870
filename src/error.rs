//! What can go wrong, as one type: the C status and its text follow from it.

use thiserror::Error;

/// A failure of Perion. The text says which argument, which value, which limit, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A value, a count, a name or a combination of them is outside what is allowed.
    #[error("{0}")]
    Argument(String),
    /// The call does not fit the state the object is in.
    #[error("{0}")]
    State(String),
    /// The memory asked for could not be had; the object is unchanged.
    #[error("out of memory: {bytes} bytes for {purpose} could not be had")]
    Memory {
        /// Size of the request that failed.
        bytes: usize,
        /// What the memory was for.
        purpose: &'static str,
    },
    /// A file could not be read or written.
    #[error("{0}")]
    Io(String),
    /// A file was read, but what is in it is not understood; the text names the line, what was expected and what
    /// was found.
    #[error("{0}")]
    Format(String),
    /// A computed quantity is not finite; the text names the point.
    #[error("{0}")]
    Numeric(String),
    /// An iteration did not converge; the state is that of the last completed step.
    #[error("{0}")]
    Convergence(String),
    /// A callback of the host asked to stop.
    #[error("{0}")]
    Interrupted(String),
    /// The request makes sense but is not offered; the text says what is.
    #[error("{0}")]
    Unsupported(String),
    /// A defect of the library.
    #[error("{0}")]
    Internal(String),
}

/// The result of every fallible call.
pub type Result<T> = std::result::Result<T, Error>;

/// Shorthand for [`Error::Argument`], the commonest failure.
pub(crate) fn argument<T>(text: impl Into<String>) -> Result<T> {
    Err(Error::Argument(text.into()))
}

/// Shorthand for [`Error::State`].
pub(crate) fn state<T>(text: impl Into<String>) -> Result<T> {
    Err(Error::State(text.into()))
}
