//! Rays into scenes: closest hits, shadows, geometry buffers, appearance channels.
