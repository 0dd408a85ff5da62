//! Positioned reads: no shared file position, so that any thread can read anywhere.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    ops::Deref,
    sync::Arc,
};

/// Bytes that a [`RangeReader`] reads ahead at most.
const WINDOW: usize = 256 << 10;

fn read_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<usize> {
    #[cfg(unix)]
    return std::os::unix::fs::FileExt::read_at(file, buffer, offset);
    #[cfg(windows)]
    return std::os::windows::fs::FileExt::seek_read(file, buffer, offset);
}

/// Reads from `offset` until the buffer is full or the file ends; returns the bytes read.
pub fn read_full_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<usize> {
    let mut done = 0;
    while done < buffer.len() {
        match read_at(file, &mut buffer[done..], offset + done as u64) {
            Ok(0) => break,
            Ok(n) => done += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(done)
}

/// Reads `length` bytes from `offset`, fewer if the file ends before; never more than that.
pub fn read_vec_at(file: &File, offset: u64, length: usize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; length];
    let found = read_full_at(file, &mut bytes, offset)?;
    bytes.truncate(found);
    Ok(bytes)
}

/// A stretch of a file as a stream, read through a window, so that memory does not depend on the
/// stretch's length. Reading past its end is an `UnexpectedEof`, whatever follows in the file.
pub struct RangeReader<F = Arc<File>> {
    file: F,
    start: u64,
    end: u64,
    /// File offset of `window[0]`.
    window_at: u64,
    window: Vec<u8>,
    /// Next byte to give, in `window`.
    next: usize,
}

impl<F: Deref<Target = File>> RangeReader<F> {
    pub fn new(file: F, start: u64, end: u64) -> Self {
        RangeReader { file, start, end: end.max(start), window_at: start, window: Vec::new(), next: 0 }
    }

    /// File offset of the next byte.
    pub fn position(&self) -> u64 {
        self.window_at + self.next as u64
    }

    /// Loads the window at the current position.
    fn refill(&mut self) -> io::Result<()> {
        self.window_at = self.position();
        self.next = 0;
        let wanted = self.end.saturating_sub(self.window_at).min(WINDOW as u64) as usize;
        self.window.resize(wanted, 0);
        let found = read_full_at(&self.file, &mut self.window, self.window_at)?;
        self.window.truncate(found);
        Ok(())
    }

    #[cold]
    fn read_across(&mut self, mut out: &mut [u8]) -> io::Result<()> {
        while !out.is_empty() {
            let n = self.read(out)?;
            if n == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            out = &mut out[n..];
        }
        Ok(())
    }
}

impl<F: Deref<Target = File>> Read for RangeReader<F> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.next >= self.window.len() {
            self.refill()?;
        }
        let n = out.len().min(self.window.len() - self.next);
        out[..n].copy_from_slice(&self.window[self.next..self.next + n]);
        self.next += n;
        Ok(n)
    }

    // The decoders read byte by byte; this is their inner loop.
    #[inline]
    fn read_exact(&mut self, out: &mut [u8]) -> io::Result<()> {
        match self.window.get(self.next..self.next + out.len()) {
            Some(bytes) => {
                out.copy_from_slice(bytes);
                self.next += out.len();
                Ok(())
            }
            None => self.read_across(out),
        }
    }
}

impl<F: Deref<Target = File>> Seek for RangeReader<F> {
    /// Positions are relative to the stretch's start.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let target = match to {
            SeekFrom::Start(n) => self.start.checked_add(n),
            SeekFrom::End(n) => self.end.checked_add_signed(n),
            SeekFrom::Current(n) => self.position().checked_add_signed(n),
        };
        let target = target.filter(|&t| t >= self.start).ok_or(io::ErrorKind::InvalidInput)?;
        let in_window = target.checked_sub(self.window_at).filter(|&n| n <= self.window.len() as u64);
        match in_window {
            Some(n) => self.next = n as usize,
            None => {
                self.window_at = target;
                self.window.clear();
                self.next = 0;
            }
        }
        Ok(target - self.start)
    }
}

pub fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

pub fn i32_at(bytes: &[u8], at: usize) -> i32 {
    u32_at(bytes, at) as i32
}

pub fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

/// Text in a fixed field: up to the first NUL, without trailing blanks, unprintable bytes replaced.
pub fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let text = String::from_utf8_lossy(&bytes[..end]);
    text.trim_end().chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn range_reader_gives_exactly_its_stretch() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("bytes");
        let bytes: Vec<u8> = (0..WINDOW * 2 + 1000).map(|i| (i % 251) as u8).collect();
        std::fs::write(&path, &bytes).unwrap();
        let file = File::open(&path).unwrap();

        let (start, end) = (100, bytes.len() as u64 - 100);
        let mut reader = RangeReader::new(&file, start, end);
        let mut all = vec![0; (end - start) as usize];
        for piece in all.chunks_mut(4_099) {
            reader.read_exact(piece).unwrap();
        }
        assert_eq!(all, bytes[start as usize..end as usize]);
        assert_eq!(reader.position(), end);
        assert_eq!(reader.read_exact(&mut [0]).unwrap_err().kind(), io::ErrorKind::UnexpectedEof);

        reader.seek(SeekFrom::Start(5)).unwrap();
        reader.seek(SeekFrom::Current(WINDOW as i64)).unwrap();
        let mut one = [0];
        reader.read_exact(&mut one).unwrap();
        assert_eq!(one[0], bytes[105 + WINDOW]);
        assert!(reader.seek(SeekFrom::Current(i64::MIN)).is_err());
    }
}
