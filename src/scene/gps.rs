//! GPS times as people read them.

use serde::Serialize;

/// What the numbers of a file's GPS times count.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GpsClock {
    /// Seconds of the GPS week, which begins on Sunday.
    #[default]
    Week,
    /// Seconds since the beginning of GPS time (1980-01-06), less so many: 10⁹ in "adjusted standard" time, or what the
    /// header of LAS 1.5 says.
    Standard { offset_secs: u64 },
}

/// Seconds of Unix time at the beginning of GPS time.
const GPS_EPOCH: i64 = 315_964_800;
/// Days of Unix time whose midnight follows a leap second, since then (IERS Bulletin C; none after 2017 until now).
const LEAP_DAYS: [i64; 18] =
    [4199, 4564, 4929, 5660, 6574, 7305, 7670, 8217, 8582, 8947, 9496, 10043, 10592, 13149, 14245, 15522, 16617, 17167];
const DAY: i64 = 86_400;
const MICROS: i64 = 1_000_000;
/// Beyond these (the years 1980 to 9999) a number is no date.
const LAST: i64 = 250_000_000_000;

impl GpsClock {
    /// The clock of "adjusted standard" time, the usual one.
    pub const ADJUSTED: GpsClock = GpsClock::Standard { offset_secs: 1_000_000_000 };

    /// A time in words, to the microsecond: `2021-04-18 01:40:05.114093 UTC`, or `Thu 12:00:00.5 GPS` of a week that
    /// nobody knows. `None` for what is no such time.
    ///
    /// ```
    /// use firstlight::scene::GpsClock;
    ///
    /// assert_eq!(GpsClock::ADJUSTED.text(302_745_223.114_093).unwrap(), "2021-04-18 01:40:05.114093 UTC");
    /// assert_eq!(GpsClock::Week.text(388_800.5).unwrap(), "Thu 12:00:00.5 GPS");
    /// ```
    pub fn text(self, seconds: f64) -> Option<String> {
        // Beyond, whole microseconds do not fit their numbers.
        let micros = Some((seconds * MICROS as f64).round()).filter(|micros| micros.abs() < 9e17)? as i64;
        match self {
            GpsClock::Week => {
                const DAYS: [&str; 7] = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];
                let day = DAYS.get(usize::try_from(micros.div_euclid(DAY * MICROS)).ok()?)?;
                Some(format!("{day} {} GPS", time_of_day(micros % (DAY * MICROS), false)))
            }
            GpsClock::Standard { offset_secs } => {
                // The offset is whole: only the file's own number is rounded.
                let offset = i64::try_from(offset_secs).ok().filter(|&offset| offset < LAST)?;
                let micros = Some(micros + offset * MICROS).filter(|micros| (0..LAST * MICROS).contains(micros))?;
                let (unix, is_leap) = utc(micros);
                let (days, of_day) = (unix.div_euclid(DAY * MICROS), unix.rem_euclid(DAY * MICROS));
                let [year, month, day] = civil(days);
                Some(format!("{year:04}-{month:02}-{day:02} {} UTC", time_of_day(of_day, is_leap)))
            }
        }
    }

    /// What its words are times of, behind "GPS time, ".
    pub fn name(self) -> &'static str {
        match self {
            GpsClock::Week => "of the week",
            GpsClock::Standard { .. } => "UTC",
        }
    }

    /// The unit of the numbers, and what they count from.
    pub fn unit(self) -> &'static str {
        match self {
            GpsClock::Week => "s of the GPS week",
            GpsClock::ADJUSTED => "s, adjusted standard GPS time",
            GpsClock::Standard { .. } => "s, standard GPS time less the header's offset",
        }
    }
}

/// Microseconds of Unix time, and whether they are those of a leap second: it is told by the second before, which has
/// the same date.
fn utc(gps_micros: i64) -> (i64, bool) {
    let mut leaps = 0;
    for day in LEAP_DAYS {
        let begins = (day * DAY - GPS_EPOCH + leaps) * MICROS;
        if gps_micros < begins {
            break;
        }
        if gps_micros < begins + MICROS {
            return (gps_micros + (GPS_EPOCH - leaps - 1) * MICROS, true);
        }
        leaps += 1;
    }
    (gps_micros + (GPS_EPOCH - leaps) * MICROS, false)
}

fn time_of_day(micros: i64, is_leap: bool) -> String {
    let seconds = micros / MICROS;
    let second = seconds % 60 + i64::from(is_leap);
    let text = format!("{:02}:{:02}:{second:02}.{:06}", seconds / 3600, seconds / 60 % 60, micros % MICROS);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Year, month and day of a day of Unix time (Hinnant, "chrono-compatible low-level date algorithms").
fn civil(days: i64) -> [i64; 3] {
    let days = days + 719_468;
    let era = days.div_euclid(146_097);
    let of_era = days.rem_euclid(146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let shifted = (5 * of_year + 2) / 153;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    [year + era * 400 + i64::from(month <= 2), month, of_year - (153 * shifted + 2) / 5 + 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADJUSTED: GpsClock = GpsClock::ADJUSTED;

    #[test]
    fn known_times() {
        let plain = GpsClock::Standard { offset_secs: 0 };
        assert_eq!(plain.text(0.0).unwrap(), "1980-01-06 00:00:00 UTC");
        // 10⁹ s: https://en.wikipedia.org/wiki/Global_Positioning_System has 2011-09-14 01:46:25 UTC.
        assert_eq!(ADJUSTED.text(0.0).unwrap(), "2011-09-14 01:46:25 UTC");
        assert_eq!(plain.text(1e9), ADJUSTED.text(0.0));
        // The last leap second: 2017-01-01 00:00:00 UTC is 1,483,228,800 s after 1970, GPS time 1,167,264,018.
        let around = [-2, -1, 0].map(|s| plain.text(1_167_264_018.0 + f64::from(s) + 0.25).unwrap());
        assert_eq!(around, ["2016-12-31 23:59:59.25 UTC", "2016-12-31 23:59:60.25 UTC", "2017-01-01 00:00:00.25 UTC"]);
        assert_eq!(ADJUSTED.text(167_264_017.25).unwrap(), around[1]);
        // The first: 1981-07-01 00:00:00 UTC.
        assert_eq!(plain.text(f64::from(4199 * 86_400 - 315_964_800 + 1)).unwrap(), "1981-07-01 00:00:00 UTC");
        assert_eq!(ADJUSTED.text(-1e9).unwrap(), "1980-01-06 00:00:00 UTC");
        assert_eq!(ADJUSTED.text(245_370_417.058_711).unwrap(), "2019-06-24 00:13:19.058711 UTC");
        assert_eq!(GpsClock::Week.text(2.0 * 86_400.0 + 3_661.5).unwrap(), "Tue 01:01:01.5 GPS");
    }

    #[test]
    fn what_is_no_time_has_no_words() {
        assert_eq!(GpsClock::Week.text(604_800.0), None, "a week has seven days");
        assert_eq!(GpsClock::Week.text(604_799.999_999).unwrap(), "Sat 23:59:59.999999 GPS");
        for wrong in [f64::NAN, f64::INFINITY, -1e10, -1.1e9, 1e18, 1e300, -1e30] {
            assert_eq!((ADJUSTED.text(wrong), GpsClock::Week.text(wrong)), (None, None), "{wrong}");
        }
        assert_eq!(GpsClock::Week.text(-0.5), None);
    }

    #[test]
    fn days_follow_each_other() {
        let mut last = civil(-1000);
        for day in -999..60_000 {
            let next = civil(day);
            let [year, month, of_month] = next;
            let follows = last == [year, month, of_month - 1] || (of_month == 1 && last[2] >= 28);
            assert!(follows && (1..=12).contains(&month) && (1..=31).contains(&of_month), "{last:?} {next:?}");
            last = next;
        }
        assert_eq!((civil(0), civil(11_016), civil(17_167)), ([1970, 1, 1], [2000, 2, 29], [2017, 1, 1]));
    }
}
