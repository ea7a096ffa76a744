//! [`prefetch`]: asks the processor for memory that will be needed soon.
//!
//! Walks that touch records anywhere in much memory wait for each to arrive, while the next ones are known already.

/// Bytes that are fetched at once.
const LINE: usize = 64;

/// Starts to fetch an element of a slice; nothing if there is no such element.
#[inline(always)]
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "there is no safe prefetch; the element exists, and is not read")]
pub fn prefetch<T>(slice: &[T], index: usize) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    if let Some(element) = slice.get(index) {
        let start = std::ptr::from_ref(element).cast::<i8>();
        for offset in (0..size_of::<T>()).step_by(LINE) {
            // SAFETY: a prefetch changes nothing that can be seen, and the address is within an element.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(offset)) }
        }
    }
}

/// Does nothing where no prefetch is known.
#[inline(always)]
#[cfg(not(target_arch = "x86_64"))]
pub fn prefetch<T>(_: &[T], _: usize) {}
