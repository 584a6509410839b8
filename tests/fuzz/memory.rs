//! The memory that an input takes. In: every request of the program to the allocator. Out: the largest request and the most
//! that was held at once since the last [`begin`].

use std::{
    alloc::{GlobalAlloc, Layout, System},
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

/// The most that a reader may take for any input, bytes.
pub const MOST: usize = 256 << 20;
/// What no machine should be asked for in a test: the request is refused, and the program aborts as it would without memory.
const REFUSED: usize = 4 << 30;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static LARGEST: AtomicUsize = AtomicUsize::new(0);

/// The system's allocator, with an account.
pub struct Counting;

fn taken(size: usize) {
    LARGEST.fetch_max(size, Relaxed);
    PEAK.fetch_max(HELD.fetch_add(size, Relaxed) + size, Relaxed);
}

// SAFETY: everything is the system's; counting touches numbers alone and asks for no memory itself.
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

/// A new account. Returns what is held already.
pub fn begin() -> usize {
    let held = HELD.load(Relaxed);
    PEAK.store(held, Relaxed);
    LARGEST.store(0, Relaxed);
    held
}

/// The largest request, and the most held at once beyond what was held at the `start`, bytes.
pub fn since(start: usize) -> (usize, usize) {
    (LARGEST.load(Relaxed), PEAK.load(Relaxed).saturating_sub(start))
}
