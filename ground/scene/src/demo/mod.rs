//! Procedural scenes, built in code.

use crate::Scene;
use chiaro_basis::{Error, Result, nearest};

/// The names of the scenes.
pub fn names() -> &'static [&'static str] {
    &[]
}

/// The scene of that name. [`Error::Setting`] when there is none.
pub fn scene(name: &str) -> Result<Scene> {
    let hint = nearest(name, names().iter().copied()).map(|n| format!("; did you mean {n}?"));
    let range = format!("one of {}{}", names().join(", "), hint.unwrap_or_default());
    Err(Error::setting("demo:", name, range))
}
