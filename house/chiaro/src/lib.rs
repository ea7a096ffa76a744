//! Scenes and knobs to jobs and files: the facade of chiaro.
