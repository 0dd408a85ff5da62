//! The laz crate panics on some damaged input. On decoder threads such a panic is not printed but
//! becomes its chunk's fault.

use std::{
    cell::RefCell,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::Once,
};

/// Threads whose names start so panic silently: their panics are caught and reported.
pub const DECODER_THREAD: &str = "decode-";

thread_local! {
    /// What the last panic on this thread said, and where.
    static LAST_PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs `work`; if it panics, gives the panic's words. What `work` changes may be half done then, and
/// must not be used.
pub fn catch<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| LAST_PANIC.take())
}

/// Keeps decoder threads from printing the panics that are caught and reported anyway; all other
/// threads keep the hook that was there.
pub fn silence_decoder_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if std::thread::current().name().is_some_and(|n| n.starts_with(DECODER_THREAD)) {
                let what = info.payload_as_str().unwrap_or("panic");
                let line = info.location().map(|l| {
                    let file = l.file().rsplit(['/', '\\']).next().unwrap_or_default();
                    format!(" in {file}:{}", l.line())
                });
                LAST_PANIC.set(format!("{what}{}", line.unwrap_or_default()));
            } else {
                before(info);
            }
        }));
    });
}
