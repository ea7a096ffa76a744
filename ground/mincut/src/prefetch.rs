//! Asks the processor for memory that will be needed soon.
//!
//! A level grows from nodes that lie anywhere in the picture, and each waits for its record and
//! labels to arrive from far memory, while the next ones are known already.

/// Starts to fetch an element of a slice; nothing if there is no such element.
#[inline(always)]
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "there is no safe prefetch; the element exists, and is not read")]
pub(crate) fn prefetch<T>(slice: &[T], index: usize) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    if let Some(element) = slice.get(index) {
        // SAFETY: a prefetch changes nothing that can be seen, and the address is of an element.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(element).cast()) }
    }
}

/// Does nothing where no prefetch is known.
#[inline(always)]
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn prefetch<T>(_: &[T], _: usize) {}
