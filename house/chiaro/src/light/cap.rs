//! `--memory SIZE`: rendering in little memory.
//!
//! 1. Before surfels are made, what they and their tree will take is added to what the process
//!    holds; too much is one sentence with the remedy: `--bake`, whose file is mapped, or fewer surfels.
//! 2. While a mapped tree is read, its pages count as memory of the process. Near the cap they are given back:
//!    the system keeps what it can spare and reads the rest from the disk again. Whoever reads looks
//!    once in [`TOUCHES`] places.
//! 3. A peak above the cap is told, and never hidden.
//!
//! Where the system does not say what a process holds (anything but Linux), mapped pages are left to
//! it, and the cap holds for what is estimated alone.

use crate::record::resident_bytes;
use chiaro_basis::{Error, Result};
use chiaro_pbgi::LightKnobs;
use memmap2::Mmap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The share of the cap at which pages are given back.
const FULL: f64 = 0.8;
/// Places of a map that are read between two looks at the memory that is held.
pub(crate) const TOUCHES: u32 = 256;
/// Bytes of a surfel that is lit in full, with its place in the sparse tree and in grids; bytes of a
/// surfel of a batch on its way into the tree; bytes of one in a coded tree: measured, rounded up.
const SPARSE_BYTES: u64 = 420;
const BATCH_BYTES: u64 = 260;
const CODED_BYTES: u64 = 12;
const EXACT_BYTES: u64 = 420;
/// Cells along the curve, while batches are made.
const CELLS: u64 = 16 << 20;

/// A cap on memory.
#[derive(Clone)]
pub(crate) struct Cap {
    bytes: u64,
    state: Arc<State>,
}

#[derive(Default)]
struct State {
    given_back: AtomicU64,
    map: Mutex<Weak<Mmap>>,
}

impl Cap {
    /// A cap of so many bytes.
    pub(crate) fn new(bytes: u64) -> Self {
        Self { bytes, state: Arc::default() }
    }

    /// Pages of this map are given back from now on.
    pub(crate) fn keeps(&self, map: &Arc<Mmap>) {
        *self.state.map.lock().unwrap_or_else(PoisonError::into_inner) = Arc::downgrade(map);
    }

    /// Gives pages back where too much is held.
    pub(crate) fn relieve(&self) {
        if resident_bytes() as f64 > FULL * self.bytes as f64 {
            self.state.give_back();
        }
    }

    /// How often pages were given back.
    pub(crate) fn given_back(&self) -> u64 {
        self.state.given_back.load(Ordering::Relaxed)
    }

    /// The cap.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Whether the surfels and the tree of a frame fit. `in_file`: the tree is mapped; `there`: it
    /// need not be made.
    pub(crate) fn check(&self, knobs: &LightKnobs, in_file: bool, there: bool) -> Result<()> {
        // Pages of a map can go whenever they must.
        self.state.give_back();
        let held = resident_bytes();
        let surfels = u64::from(knobs.surfels);
        let sparse = u64::from(knobs.kept_surfels()) * SPARSE_BYTES;
        let need = if knobs.is_compact() {
            let batch = surfels.min(2 * u64::from(chiaro_pbgi::stream::BATCH)) * BATCH_BYTES;
            let making = if there { 0 } else { batch + CELLS };
            held + sparse + making + if in_file { 0 } else { surfels * CODED_BYTES }
        } else {
            held + surfels * EXACT_BYTES
        };
        if need <= self.bytes {
            return Ok(());
        }
        let remedy = match (knobs.is_compact(), in_file) {
            (false, _) => "--set tree=compact or fewer surfels",
            (true, false) => "--bake FILE, whose tree is mapped, or fewer surfels",
            (true, true) => "more memory or fewer surfels",
        };
        let (need, have) = (shown(need), format!("{}; {remedy}", shown(self.bytes)));
        Err(Error::limit("--memory", need, have))
    }
}

impl State {
    /// Lets the system have the pages of the map.
    #[allow(unsafe_code)]
    fn give_back(&self) {
        let map = self.map.lock().unwrap_or_else(PoisonError::into_inner).upgrade();
        #[cfg(target_os = "linux")]
        if let Some(map) = map {
            // SAFETY: the map is shared, read only and backed by a file: pages that were given back
            // are read from it again, with the same bytes.
            let given = unsafe { map.unchecked_advise(memmap2::UncheckedAdvice::DontNeed) };
            self.given_back.fetch_add(u64::from(given.is_ok()), Ordering::Relaxed);
        }
        #[cfg(not(target_os = "linux"))]
        drop(map);
    }
}

/// Bytes for people.
pub(crate) fn shown(bytes: u64) -> String {
    match bytes as f64 / f64::from(1 << 20) {
        m if m >= 1024.0 => format!("{:.1} GiB", m / 1024.0),
        m => format!("{m:.0} MiB"),
    }
}

/// A size in bytes: a number with KiB, MiB, GiB, kB, MB or GB.
pub fn parse_bytes(option: &str, text: &str) -> Result<u64> {
    const UNITS: [(&str, f64); 8] = [
        ("kib", 1024.0),
        ("mib", 1_048_576.0),
        ("gib", 1_073_741_824.0),
        ("tib", 1_099_511_627_776.0),
        ("kb", 1e3),
        ("mb", 1e6),
        ("gb", 1e9),
        ("tb", 1e12),
    ];
    let lower = text.trim().to_lowercase();
    let unit = UNITS.iter().find_map(|(name, unit)| Some((lower.strip_suffix(name)?, *unit)));
    let number = unit.and_then(|(n, unit)| Some(n.trim().parse::<f64>().ok()? * unit));
    let wrong = || Error::setting(option, text, "a size from 1MiB, as in 512MiB or 2GiB");
    number.filter(|b| (1_048_576.0..=1e18).contains(b)).map(|b| b as u64).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_in_both_kinds_of_units() {
        for (text, bytes) in [("2GiB", 2 << 30), ("512 MiB", 512 << 20), ("1.5gb", 1_500_000_000)] {
            assert_eq!(parse_bytes("--memory", text).unwrap(), bytes);
        }
        for text in ["", "2", "GiB", "-1GiB", "nanGiB", "1kB", "2 apples"] {
            assert!(parse_bytes("--memory", text).is_err(), "{text}");
        }
        assert_eq!((shown(3 << 30).as_str(), shown(5 << 20).as_str()), ("3.0 GiB", "5 MiB"));
    }

    #[test]
    fn what_does_not_fit_is_one_sentence_with_its_remedy() {
        let many = LightKnobs { surfels: 100_000_000, ..LightKnobs::default() };
        let mut coded = many.clone();
        coded.tree = chiaro_pbgi::Storage::Compact;
        let cap = Cap::new(1 << 30);
        let told = |knobs: &LightKnobs, in_file| match cap.check(knobs, in_file, false) {
            Ok(()) => String::new(),
            Err(e) => e.to_string(),
        };
        assert!(told(&many, false).contains("tree=compact"));
        assert!(told(&coded, false).contains("--bake"));
        assert_eq!(told(&coded, true), "");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn pages_are_given_back_and_read_again() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        let bytes: Vec<u8> = (0..1 << 20).map(|i| ((i * 31) >> 3) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        // The whole process is far larger than this cap: pages go all the time.
        let cap = Cap::new(1 << 20);
        let map = crate::light::baked::map(&std::fs::File::open(&path).unwrap()).unwrap();
        cap.keeps(&map);
        for round in 1..=3 {
            assert!(map[..] == bytes[..]);
            cap.relieve();
            assert_eq!(cap.given_back(), round);
        }
        assert!(map[..] == bytes[..]);
        assert!(cap.check(&LightKnobs::default(), true, true).is_err());
        assert_eq!(cap.given_back(), 4, "pages of the map counted as held");
    }
}
