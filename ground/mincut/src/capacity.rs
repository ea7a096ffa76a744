//! The integers of the residual graph: `i16` where the capacities fit, `i32` as the fallback.
//!
//! A residual reaches twice its capacity and the pre-pass adds two excesses, so capacities stop at
//! half of the type's range and no sum is ever checked again.

use std::ops::{Add, BitAnd, Neg, Sub};

/// A stored integer.
pub(crate) trait Capacity:
    Copy
    + Send
    + Sync
    + Default
    + Ord
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + BitAnd<Output = Self>
{
    /// The largest storable value.
    const MAX: i32;
    /// The largest capacity.
    const LIMIT: i32 = Self::MAX / 2;

    /// Stores a value that is known to fit.
    fn of(value: i32) -> Self;

    /// The value.
    fn get(self) -> i32;
}

impl Capacity for i16 {
    const MAX: i32 = i16::MAX as i32;

    #[inline(always)]
    fn of(value: i32) -> Self {
        value as i16
    }

    #[inline(always)]
    fn get(self) -> i32 {
        i32::from(self)
    }
}

impl Capacity for i32 {
    const MAX: i32 = i32::MAX;

    #[inline(always)]
    fn of(value: i32) -> Self {
        value
    }

    #[inline(always)]
    fn get(self) -> i32 {
        self
    }
}
