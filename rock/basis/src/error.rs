//! What can go wrong, sorted by who can act on it.

/// A result with chiaro's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// An error that a user can act on. Its display is one sentence that names the file or the
/// setting, the place in it, and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that cannot be used as it is.
    #[error("{path}: {place}{}{why}", if place.is_empty() { "" } else { ": " })]
    Input {
        /// The file's name as the user gave it, or as the scene refers to it.
        path: String,
        /// Where in the file (accessor 3, line 12), or empty.
        place: String,
        /// What is wrong, and what to do about it.
        why: String,
    },
    /// A setting outside its range, or one that contradicts another.
    #[error("{knob} = {got}: expected {range}")]
    Setting {
        /// The setting's name as the user typed it.
        knob: String,
        /// The value as given.
        got: String,
        /// What would be accepted.
        range: String,
    },
    /// More than the budget allows.
    #[error("{what} needs {need}, but the limit is {have}")]
    Limit {
        /// What asked for it, and the remedy.
        what: String,
        /// How much it asked for, with its unit.
        need: String,
        /// How much there is, with its unit.
        have: String,
    },
    /// A file that cannot be written.
    #[error("cannot write {path}: {why}")]
    Output {
        /// The output path.
        path: String,
        /// What the system said, and the remedy.
        why: String,
    },
    /// The user stopped the run.
    #[error("stopped")]
    Cancelled,
}

impl Error {
    /// An [`Error::Input`] from its three parts.
    pub fn input(
        path: impl Into<String>,
        place: impl Into<String>,
        why: impl Into<String>,
    ) -> Self {
        Self::Input { path: path.into(), place: place.into(), why: why.into() }
    }

    /// An [`Error::Setting`] from its three parts.
    pub fn setting(knob: impl Into<String>, got: impl ToString, range: impl Into<String>) -> Self {
        Self::Setting { knob: knob.into(), got: got.to_string(), range: range.into() }
    }

    /// An [`Error::Limit`] from its three parts.
    pub fn limit(
        what: impl Into<String>,
        need: impl Into<String>,
        have: impl Into<String>,
    ) -> Self {
        Self::Limit { what: what.into(), need: need.into(), have: have.into() }
    }

    /// An [`Error::Output`] from its two parts.
    pub fn output(path: impl Into<String>, why: impl ToString) -> Self {
        Self::Output { path: path.into(), why: why.to_string() }
    }
}
