//! The first layer: scanner channel, returns, X and Y, and which other fields change. All other layers
//! take their contexts from here.

use super::super::{coder::Coder, integer::IntegerDecoder, median::StreamingMedian};
use super::contexts::{Entry, Facts, Lazy, made, models_bytes, put_i32};
use super::stream::Part;
use super::tables::{RETURN_LEVEL, RETURN_MAP};

/// Models and last values of a scanner channel.
struct Channel {
    x: i32,
    y: i32,
    /// Return number and, shifted by 4, number of returns.
    returns: u8,
    time_changed: bool,
    changes: [Lazy; 8],
    channel: Lazy,
    number_of_returns: [Lazy; 16],
    return_number: [Lazy; 16],
    return_number_same_time: Lazy,
    dx: IntegerDecoder,
    dy: IntegerDecoder,
    /// By return class and by whether the time changed.
    dx_medians: [StreamingMedian; 12],
    dy_medians: [StreamingMedian; 12],
}

impl Channel {
    fn new(x: i32, y: i32, returns: u8) -> Channel {
        Channel {
            x,
            y,
            returns,
            time_changed: false,
            changes: [const { None }; 8],
            channel: None,
            number_of_returns: [const { None }; 16],
            return_number: [const { None }; 16],
            return_number_same_time: None,
            dx: IntegerDecoder::new(32, 2),
            dy: IntegerDecoder::new(32, 22),
            dx_medians: [StreamingMedian::NEW; 12],
            dy_medians: [StreamingMedian::NEW; 12],
        }
    }

    /// Which values change with this point: a bit each for return number (2), number of returns, scan
    /// angle, time, point source and channel.
    #[inline]
    fn changes(&mut self, coder: &mut Coder, bytes: &[u8]) -> u32 {
        let (number, returns) = (self.returns & 15, self.returns >> 4);
        let context =
            usize::from(number == 1) | usize::from(number >= returns) << 1 | usize::from(self.time_changed) << 2;
        coder.symbol(bytes, made(&mut self.changes[context], 128))
    }

    #[inline]
    fn decode(&mut self, coder: &mut Coder, bytes: &[u8], changes: u32) -> Facts {
        let (last_number, last_returns) = (self.returns & 15, self.returns >> 4);
        let time_changed = changes & 16 != 0;
        let mut returns = last_returns;
        if changes & 4 != 0 {
            let model = made(&mut self.number_of_returns[usize::from(last_returns)], 16);
            returns = coder.symbol(bytes, model) as u8 & 15;
        }
        let number = match changes & 3 {
            0 => last_number,
            1 => (last_number + 1) & 15,
            2 => (last_number + 15) & 15,
            _ if time_changed => {
                coder.symbol(bytes, made(&mut self.return_number[usize::from(last_number)], 16)) as u8 & 15
            }
            _ => (last_number + 2 + coder.symbol(bytes, made(&mut self.return_number_same_time, 13)) as u8) & 15,
        };
        self.returns = returns << 4 | number;
        self.time_changed = time_changed;

        let (n, r) = (usize::from(returns), usize::from(number));
        let class = usize::from(RETURN_MAP[n][r]) << 1 | usize::from(time_changed);
        let single = u32::from(returns == 1);
        let median = &mut self.dx_medians[class];
        let dx = self.dx.decode(coder, bytes, median.get(), single);
        median.add(dx);
        self.x = self.x.wrapping_add(dx);

        let bits = self.dx.k();
        let median = &mut self.dy_medians[class];
        let dy = self.dy.decode(coder, bytes, median.get(), bits.min(20) & !1 | single);
        median.add(dy);
        self.y = self.y.wrapping_add(dy);

        let bits = (bits + self.dy.k()) / 2;
        Facts::new(changes, number == 1, number >= returns, RETURN_LEVEL[n][r], bits.min(18) & !1 | single)
    }

    fn memory_bytes(&self) -> usize {
        let models = self.changes.iter().chain(&self.number_of_returns).chain(&self.return_number);
        let models = models.chain([&self.channel, &self.return_number_same_time]);
        models_bytes(models) + self.dx.memory_bytes() + self.dy.memory_bytes()
    }
}

/// The decoder of the first layer.
pub struct Position {
    channels: [Option<Box<Channel>>; 4],
    current: u8,
    items: ItemContexts,
}

impl Position {
    /// Starts with a chunk's first record. `version` (3 or 4) says how items follow the channel.
    pub fn new(first: &[u8], version: u16) -> Position {
        let i32_at = |at: usize| i32::from_le_bytes([first[at], first[at + 1], first[at + 2], first[at + 3]]);
        let current = first[15] >> 4 & 3;
        let mut channels = [const { None }; 4];
        channels[usize::from(current)] = Some(Box::new(Channel::new(i32_at(0), i32_at(4), first[14])));
        Position { channels, current, items: ItemContexts::new(current, version) }
    }

    /// Decodes the next point's X, Y, returns and channel into its record.
    #[inline(always)]
    pub fn step(&mut self, coder: &mut Coder, bytes: &[u8], record: &mut [u8]) -> Facts {
        let mut entry = Entry { context: self.current, last: self.current, from: None };
        let mut channel =
            self.channels[usize::from(self.current & 3)].get_or_insert_with(|| Box::new(Channel::new(0, 0, 0)));
        let changes = channel.changes(coder, bytes);
        let switched = changes & 64 != 0;
        if switched {
            let step = coder.symbol(bytes, made(&mut channel.channel, 3));
            let next = (self.current + step as u8 + 1) & 3;
            let (x, y, returns) = (channel.x, channel.y, channel.returns);
            let slot = &mut self.channels[usize::from(next)];
            entry = Entry { context: next, last: next, from: slot.is_none().then_some(self.current) };
            channel = slot.get_or_insert_with(|| Box::new(Channel::new(x, y, returns)));
            self.current = next;
        }
        let facts = channel.decode(coder, bytes, changes);
        put_i32(record, 0, channel.x);
        put_i32(record, 4, channel.y);
        record[14] = channel.returns;
        record[15] = record[15] & !0x30 | self.current << 4;
        facts.with_entries(entry, self.items.next(self.current, switched))
    }
}

impl Part for Position {
    /// Four symbols, and for X and Y two symbols and 23 raw bits each.
    const MOST_BYTES: usize = 4 * 2 + 2 * (2 * 2 + 3);

    fn memory_bytes(&self) -> usize {
        self.channels.iter().flatten().map(|c| size_of::<Channel>() + c.memory_bytes()).sum()
    }
}

/// Which context the other items (colours, extra bytes, wave packets) use.
///
/// Version 4: the scanner channel's, for models and for the last value. Version 3 has two oddities of
/// LASzip that files depend on: the context is 0 unless the channel changed at this very point, and a
/// context that is entered again starts from the last value of the one that is left, and replaces that.
struct ItemContexts {
    version: u16,
    context: u8,
    used: [bool; 4],
}

impl ItemContexts {
    fn new(channel: u8, version: u16) -> ItemContexts {
        let mut used = [false; 4];
        used[usize::from(channel & 3)] = true;
        ItemContexts { version, context: channel, used }
    }

    #[inline(always)]
    fn next(&mut self, channel: u8, switched: bool) -> Entry {
        let context = if self.version == 3 && !switched { 0 } else { channel };
        let left = self.context;
        if context == left {
            return Entry { context, last: context, from: None };
        }
        self.context = context;
        let used = std::mem::replace(&mut self.used[usize::from(context & 3)], true);
        let last = if used && self.version == 3 { left } else { context };
        Entry { context, last, from: (!used).then_some(left) }
    }
}
