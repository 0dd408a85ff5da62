//! What a measurement ran on.

use std::fs;

use serde::Serialize;

/// The machine, as far as the system tells without special rights; null where it does not.
#[derive(Debug, Clone, Serialize)]
pub struct Machine {
    pub processor: String,
    /// Threads that the program may run at once.
    pub cores: usize,
    pub memory_bytes: Option<u64>,
    /// Name and version of the system and its kernel.
    pub system: String,
    /// Processes that wanted to run, averaged over the minute before the measurement (Linux). Well
    /// above zero: others were at work, and times are noisy.
    pub load_before: Option<f64>,
    /// The same after it; the measurement's own work is in it.
    pub load_after: Option<f64>,
}

impl Machine {
    /// Looks now.
    pub fn find() -> Machine {
        let file = |path| fs::read_to_string(path).unwrap_or_default();
        // Elsewhere than on Linux these take system calls, and those take `unsafe`.
        let processor = value_of(&file("/proc/cpuinfo"), "model name", ':');
        let memory = value_of(&file("/proc/meminfo"), "MemTotal", ':');
        let kibibytes = memory.and_then(|text| text.strip_suffix("kB")?.trim().parse::<u64>().ok());
        let name = value_of(&file("/etc/os-release"), "PRETTY_NAME", '=');
        let kernel = file("/proc/sys/kernel/osrelease");
        let system = format!("{} {}", name.as_deref().unwrap_or(std::env::consts::OS), kernel.trim());
        Machine {
            processor: processor.unwrap_or_else(|| std::env::consts::ARCH.into()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            memory_bytes: kibibytes.map(|n| n * 1024),
            system: system.trim_end().into(),
            load_before: load(),
            load_after: None,
        }
    }

    /// Says that the measurement is over.
    pub fn finish(&mut self) {
        self.load_after = load();
    }
}

fn load() -> Option<f64> {
    fs::read_to_string("/proc/loadavg").ok()?.split(' ').next()?.parse().ok()
}

/// Seconds of processor time that this process has used so far, all threads together; Linux counts them
/// in hundredths. They tell more than the clock on a machine that is busy with other work.
pub fn processor_secs() -> Option<f64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name is in brackets and may hold anything; fields 14 and 15 are ticks in user code
    // and in the system's, of which a second has 100 on every machine that Linux shows to programs.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / 100.0)
}

/// The first line `key: value`, without quotes.
fn value_of(text: &str, key: &str, separator: char) -> Option<String> {
    text.lines().find_map(|line| {
        let (name, value) = line.split_once(separator)?;
        (name.trim() == key).then(|| value.trim().trim_matches('"').to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_by_their_whole_key() {
        let text = "model\t\t: 17\nmodel name\t: Some CPU @ 2 GHz\nmodel name\t: another\n";
        assert_eq!(value_of(text, "model name", ':').as_deref(), Some("Some CPU @ 2 GHz"));
        assert_eq!(value_of("NAME=x\nPRETTY_NAME=\"Debian 12\"\n", "PRETTY_NAME", '=').as_deref(), Some("Debian 12"));
        assert_eq!(value_of(text, "name", ':'), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn work_takes_processor_time() {
        // Other tests run in this process too: only a lower bound can be told.
        let (begun, before) = (std::time::Instant::now(), processor_secs().unwrap());
        let mut x = 1u64;
        while begun.elapsed().as_millis() < 10_000 && processor_secs().unwrap() < before + 0.05 {
            (0..1000).for_each(|i| x = std::hint::black_box(x.wrapping_mul(31) ^ i));
        }
        assert!(processor_secs().unwrap() >= before + 0.05);
        assert!(before < 1e6, "hundredths, not ticks");
    }

    #[test]
    fn there_is_a_core_and_a_name() {
        let machine = Machine::find();
        assert!(machine.cores > 0 && !machine.processor.is_empty() && !machine.system.is_empty());
    }
}
