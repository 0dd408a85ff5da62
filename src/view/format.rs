//! Numbers as a reader wants them.

/// e.g. "512", "12.3 k", "4.29 G".
pub fn count(n: u64) -> String {
    for (unit, suffix) in [(1_000_000_000, "G"), (1_000_000, "M"), (1_000, "k")] {
        // 999,950 is 1.00 M rather than 1000 k.
        if n >= unit - unit / 2000 {
            let value = n as f64 / unit as f64;
            let digits = if value < 9.995 { 2 } else { usize::from(value < 99.95) };
            return format!("{value:.digits$} {suffix}");
        }
    }
    n.to_string()
}

/// e.g. "800 µs", "12.3 ms", "4.5 s", "3 min 20 s".
pub fn duration(secs: f64) -> String {
    match secs {
        s if s < 0.001 => format!("{:.0} µs", s * 1e6),
        s if s < 0.1 => format!("{:.1} ms", s * 1e3),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 60.0 => format!("{s:.1} s"),
        s => format!("{:.0} min {:.0} s", (s / 60.0).floor(), s % 60.0),
    }
}

/// e.g. "512 B", "3.00 MiB", "1.50 GiB".
pub fn bytes(n: u64) -> String {
    for (shift, unit) in [(30, "GiB"), (20, "MiB"), (10, "KiB")] {
        if n >= 1 << shift {
            let value = n as f64 / (1_u64 << shift) as f64;
            let digits = if value < 9.995 { 2 } else { usize::from(value < 99.95) };
            return format!("{value:.digits$} {unit}");
        }
    }
    format!("{n} B")
}

/// Rounded down, so that only all of it is 100 %.
pub fn percent(part: u64, whole: u64) -> String {
    if whole == 0 {
        return "–".into();
    }
    format!("{} %", (u128::from(part) * 100 / u128::from(whole)).min(100))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts() {
        let expected = [
            (0, "0"),
            (999, "999"),
            (1_000, "1.00 k"),
            (12_345, "12.3 k"),
            (999_499, "999 k"),
            (999_999, "1.00 M"),
            (300_000_000, "300 M"),
            (4_294_967_295, "4.29 G"),
        ];
        for (n, text) in expected {
            assert_eq!(count(n), text);
        }
    }

    #[test]
    fn sizes_in_bytes() {
        for (n, text) in
            [(0, "0 B"), (1023, "1023 B"), (1536, "1.50 KiB"), (3 << 20, "3.00 MiB"), (80 << 30, "80.0 GiB")]
        {
            assert_eq!(bytes(n), text);
        }
    }

    #[test]
    fn durations() {
        for (secs, text) in
            [(0.0, "0 µs"), (0.0123, "12.3 ms"), (0.25, "250 ms"), (4.52, "4.5 s"), (200.0, "3 min 20 s")]
        {
            assert_eq!(duration(secs), text);
        }
    }

    #[test]
    fn hundred_per_cent_means_all() {
        assert_eq!(percent(999_999, 1_000_000), "99 %");
        assert_eq!(percent(7, 7), "100 %");
        assert_eq!(percent(8, 7), "100 %");
        assert_eq!(percent(0, 0), "–");
    }
}
