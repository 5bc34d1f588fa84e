//! What the command does where memory cannot be had: it says so in one line, and ends.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of what was asked for rightly and could not be done.
const FAILED: i32 = 4;

/// The system's allocator. Where it has no memory the command ends: without this the standard library aborts, which looks like a
/// crash.
///
/// Those who ask whether memory can be had (`try_reserve`) get no answer: the command's own code does not ask, and the standard
/// library only does where a file is read whole. It belongs to the command alone; the library leaves allocation to its callers.
pub struct Ending;

// SAFETY: everything is what `System` does, under the conditions its caller keeps; null never comes back, which is allowed.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Ending {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        had(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        had(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        had(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        unsafe { System.dealloc(block, layout) }
    }
}

fn had(block: *mut u8, bytes: usize) -> *mut u8 {
    if block.is_null() { end(bytes) } else { block }
}

/// Nothing here may allocate. Threads that come here at the same time wait in `exit` until the first has ended the process.
#[cold]
fn end(bytes: usize) -> ! {
    static TOLD: AtomicBool = AtomicBool::new(false);
    if !TOLD.swap(true, Ordering::Relaxed) {
        let mut line = [0u8; 160];
        let mut rest = &mut line[..];
        let _ = writeln!(
            rest,
            "error: out of memory: {bytes} bytes more could not be had; longer edges (--size) need less"
        );
        let used = 160 - rest.len();
        let _ = std::io::stderr().write_all(&line[..used]);
    }
    process::exit(FAILED)
}
