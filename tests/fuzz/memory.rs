//! Memory that an input takes. In: every request of the program to the allocator. Out: the largest request, and the most memory held at
//! once, since the last [`begin`].

use std::{
    alloc::{GlobalAlloc, Layout, System},
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

/// Maximum memory of a reader for any input, bytes.
pub const MOST: usize = 256 << 20;
/// Size above which a request is refused, bytes; the program then aborts as it would without memory.
const REFUSED: usize = 4 << 30;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static LARGEST: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, with counters.
pub struct Counting;

fn taken(size: usize) {
    LARGEST.fetch_max(size, Relaxed);
    PEAK.fetch_max(HELD.fetch_add(size, Relaxed) + size, Relaxed);
}

// SAFETY: all memory comes from the system's allocator. Counting changes only numbers and allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        if layout.size() > REFUSED { std::ptr::null_mut() } else { unsafe { System.alloc(layout) } }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        if layout.size() > REFUSED { std::ptr::null_mut() } else { unsafe { System.alloc_zeroed(layout) } }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        HELD.fetch_sub(layout.size(), Relaxed);
        taken(size);
        if size > REFUSED { std::ptr::null_mut() } else { unsafe { System.realloc(pointer, layout, size) } }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// Resets the counters. Returns the memory held already, bytes.
pub fn begin() -> usize {
    let held = HELD.load(Relaxed);
    PEAK.store(held, Relaxed);
    LARGEST.store(0, Relaxed);
    held
}

/// Returns the largest request, and the most memory held at once beyond that held at `start`, bytes.
pub fn since(start: usize) -> (usize, usize) {
    (LARGEST.load(Relaxed), PEAK.load(Relaxed).saturating_sub(start))
}
