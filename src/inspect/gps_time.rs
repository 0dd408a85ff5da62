//! What GPS times mean: seconds of a week, or of an epoch, as the header says.

/// What a file's GPS times count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GpsEpoch {
    /// Seconds of the GPS week, which begins on Sunday.
    Week,
    /// Standard GPS time (seconds since 1980-01-06) less so many seconds: 10⁹ of "adjusted standard" time, or what
    /// the header of LAS 1.5 says.
    Standard { offset_secs: u64 },
}

impl GpsEpoch {
    /// By the global encoding of a header, and LAS 1.5's offset in millions of seconds.
    pub fn new(global_encoding: u16, offset: Option<u16>) -> GpsEpoch {
        match (global_encoding & 1, offset.filter(|_| global_encoding & 1 << 6 != 0)) {
            (0, _) => GpsEpoch::Week,
            (_, Some(millions)) => GpsEpoch::Standard { offset_secs: 1_000_000 * u64::from(millions) },
            (_, None) => GpsEpoch::Standard { offset_secs: 1_000_000_000 },
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            GpsEpoch::Week => "s of the GPS week",
            GpsEpoch::Standard { offset_secs: 1_000_000_000 } => "s, adjusted standard GPS time",
            GpsEpoch::Standard { .. } => "s, standard GPS time less the header's offset",
        }
    }

    /// The moment in words, to the microsecond: "2015-03-04 05:06:07.123456 UTC", or "Tuesday 05:06:07.123456 GPS".
    /// `None` if the seconds are none of a week, or of no year from 1980 to 9999.
    pub fn moment(self, secs: f64) -> Option<String> {
        match self {
            GpsEpoch::Week => {
                let micros = (secs * 1e6).round();
                if !(0.0..604_800e6).contains(&micros) {
                    return None;
                }
                let (day, time) = (micros as u64 / DAY_MICROS, micros as u64 % DAY_MICROS);
                const DAYS: [&str; 7] = ["Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"];
                Some(format!("{} {} GPS", DAYS[day as usize], clock(time)))
            }
            GpsEpoch::Standard { offset_secs } => {
                // The offset is whole: only the file's own number is rounded.
                let micros = (secs * 1e6).round();
                if micros.is_nan() || micros.abs() >= 9e17 {
                    return None;
                }
                let micros = i128::from(offset_secs) * 1_000_000 + micros as i128;
                let utc = u64::try_from(micros - i128::from(leap_secs(micros)) * 1_000_000).ok()?;
                let [year, month, day] = date(GPS_EPOCH_DAY + (utc / DAY_MICROS) as i64);
                (year <= 9999).then(|| format!("{year:04}-{month:02}-{day:02} {} UTC", clock(utc % DAY_MICROS)))
            }
        }
    }
}

const DAY_MICROS: u64 = 86_400_000_000;

/// 1980-01-06, in days since 1970-01-01.
const GPS_EPOCH_DAY: i64 = 3_657;

fn clock(micros: u64) -> String {
    let (secs, micros) = (micros / 1_000_000, micros % 1_000_000);
    format!("{:02}:{:02}:{:02}.{micros:06}", secs / 3600, secs / 60 % 60, secs % 60)
}

/// Leap seconds since GPS began, each inserted before the first of a month: year and month. (IERS; none since 2017.)
const LEAPS: [(i64, i64); 18] = [
    (1981, 7),
    (1982, 7),
    (1983, 7),
    (1985, 7),
    (1988, 1),
    (1990, 1),
    (1991, 1),
    (1992, 7),
    (1993, 7),
    (1994, 7),
    (1996, 1),
    (1997, 7),
    (1999, 1),
    (2006, 1),
    (2009, 1),
    (2012, 7),
    (2015, 7),
    (2017, 1),
];

/// Seconds that GPS is ahead of UTC, by microseconds of GPS since 1980-01-06.
fn leap_secs(micros: i128) -> i64 {
    let begun = |(before, (year, month)): (i64, &(i64, i64))| {
        let utc_secs = (days([*year, *month, 1]) - GPS_EPOCH_DAY) * 86_400;
        micros >= i128::from(utc_secs + before + 1) * 1_000_000
    };
    (0..).zip(&LEAPS).filter(|&leap| begun(leap)).count() as i64
}

/// Days since 1970-01-01 of a day in the Gregorian calendar. (Hinnant: years begin in March.)
fn days([year, month, day]: [i64; 3]) -> i64 {
    let year = if month > 2 { year } else { year - 1 };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

/// The inverse of [`days`].
fn date(days: i64) -> [i64; 3] {
    let days = days + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    [era * 400 + year + i64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADJUSTED: GpsEpoch = GpsEpoch::Standard { offset_secs: 1_000_000_000 };
    const STANDARD: GpsEpoch = GpsEpoch::Standard { offset_secs: 0 };

    #[test]
    fn moments_are_those_of_the_almanac() {
        assert_eq!(STANDARD.moment(0.0).unwrap(), "1980-01-06 00:00:00.000000 UTC");
        // GPS second 1,000,000,000 is 2011-09-14 01:46:40 GPS, 15 leap seconds earlier in UTC.
        assert_eq!(ADJUSTED.moment(0.0).unwrap(), "2011-09-14 01:46:25.000000 UTC");
        assert_eq!(STANDARD.moment(1_000_000_000.0).unwrap(), ADJUSTED.moment(0.0).unwrap());
        // 2017-01-01 00:00:00 UTC is GPS second 1,167,264,018; the second before it is a leap second.
        assert_eq!(STANDARD.moment(1_167_264_018.0).unwrap(), "2017-01-01 00:00:00.000000 UTC");
        assert_eq!(STANDARD.moment(1_167_264_016.0).unwrap(), "2016-12-31 23:59:59.000000 UTC");
        assert_eq!(ADJUSTED.moment(245_370_417.058_711).unwrap(), "2019-06-24 00:13:19.058711 UTC");
        assert_eq!(GpsEpoch::Week.moment(2.0 * 86_400.0 + 3_661.5).unwrap(), "Tuesday 01:01:01.500000 GPS");
        for nonsense in [f64::NAN, f64::INFINITY, -1e30, 1e18] {
            assert_eq!((ADJUSTED.moment(nonsense), GpsEpoch::Week.moment(nonsense)), (None, None));
        }
        assert_eq!((GpsEpoch::Week.moment(604_800.0), GpsEpoch::Week.moment(-1.0)), (None, None));
    }

    #[test]
    fn the_header_says_what_is_counted() {
        assert_eq!(GpsEpoch::new(0, None), GpsEpoch::Week);
        assert_eq!(GpsEpoch::new(0b100_0000, Some(1400)), GpsEpoch::Week);
        assert_eq!(GpsEpoch::new(0b1_0001, None), ADJUSTED);
        assert_eq!(GpsEpoch::new(0b1, Some(1400)), ADJUSTED, "without bit 6 the offset means nothing");
        assert_eq!(GpsEpoch::new(0b100_0001, Some(1400)), GpsEpoch::Standard { offset_secs: 1_400_000_000 });
    }

    #[test]
    fn days_and_dates_are_inverse() {
        assert_eq!((days([1970, 1, 1]), days([1980, 1, 6])), (0, GPS_EPOCH_DAY));
        for day in (-1_000_000..1_000_000).step_by(97) {
            assert_eq!(days(date(day)), day);
        }
        assert_eq!((date(days([2000, 2, 29])), date(days([1999, 12, 31]))), ([2000, 2, 29], [1999, 12, 31]));
    }
}
