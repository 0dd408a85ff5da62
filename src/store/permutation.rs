//! A keyed pseudo-random permutation of `[0, len)` that can be inverted: a Feistel network on the
//! fewest bits that hold `len`, with cycle walking (Black & Rogaway 2002, "Ciphers with Arbitrary
//! Finite Domains", section 4). Twin of `shaders/permutation.wgsl`.

/// Rounds of the network. Over tens of thousands of seeds the slots of 24 points are clearly not
/// uniform with four; with six the slots are, but not yet the distances between points that arrived one
/// after the other (chi-square z = 12 over 20,000 seeds); with eight both are (`tests/shuffle.rs`).
pub const ROUNDS: usize = 8;

/// Which slots an insertion gives to new points. A viewer has one answer; the others are what it is measured
/// against.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SlotOrder {
    /// Uniformly random ones, among all.
    #[default]
    Shuffled,
    /// Those behind the old points, shuffled among the points of the insertion only.
    BatchShuffled,
    /// Those behind the old points, in order of arrival: no shuffle.
    Arrival,
}

/// A bijection of `[0, len)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Permutation {
    len: u32,
    /// Only `[0, domain)` is shuffled; all of it but for measuring other orders.
    domain: u32,
    /// Added to what the shuffle gives, round the end.
    shift: u32,
    /// Bits of the left half before an even round; the right half has the other `bits - left_bits`.
    left_bits: u32,
    right_bits: u32,
    rounds: u32,
    keys: [u32; ROUNDS],
}

impl Permutation {
    /// The permutation of `[0, len)` that `seed` and `index` (of the batch) choose.
    pub fn new(len: u32, seed: u64, index: u64) -> Permutation {
        Permutation::with_rounds(len, seed, index, ROUNDS as u32)
    }

    /// As [`Permutation::new`] with fewer rounds, to show that the uniformity test can fail.
    pub fn with_rounds(len: u32, seed: u64, index: u64, rounds: u32) -> Permutation {
        Permutation::shuffling(len, len, 0, seed, index, rounds)
    }

    /// The permutation of `[0, old + new)` that sends the first `new` numbers where `order` says.
    pub fn in_order(order: SlotOrder, old: u32, new: u32, seed: u64, index: u64) -> Permutation {
        let (domain, shift) = match order {
            SlotOrder::Shuffled => (old + new, 0),
            SlotOrder::BatchShuffled => (new, old),
            SlotOrder::Arrival => (0, old),
        };
        Permutation::shuffling(old + new, domain, shift, seed, index, ROUNDS as u32)
    }

    fn shuffling(len: u32, domain: u32, shift: u32, seed: u64, index: u64, rounds: u32) -> Permutation {
        assert!(rounds as usize <= ROUNDS && rounds.is_multiple_of(2), "an even number of rounds up to {ROUNDS}");
        let bits = (u32::BITS - domain.saturating_sub(1).leading_zeros()).max(2);
        let mut state = split_mix(seed ^ split_mix(index));
        let keys = std::array::from_fn(|_| {
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            (split_mix(state) >> 32) as u32
        });
        Permutation { len, domain, shift, left_bits: bits / 2, right_bits: bits - bits / 2, rounds, keys }
    }

    pub fn len(&self) -> u32 {
        self.len
    }

    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Bits of the left and the right half, and the round keys: what the kernel needs.
    pub fn parts(&self) -> (u32, u32, [u32; ROUNDS]) {
        (self.left_bits, self.right_bits, self.keys)
    }

    /// How many numbers are shuffled, and what is then added to all: what the kernel needs besides.
    pub fn domain_and_shift(&self) -> (u32, u32) {
        (self.domain, self.shift)
    }

    /// Where `i` goes, for `i < len`.
    pub fn apply(&self, i: u32) -> u32 {
        let mut x = i;
        if i < self.domain {
            x = self.encrypt(x);
            while x >= self.domain {
                x = self.encrypt(x);
            }
        }
        // `x + shift` may not fit 32 bits.
        let before_end = self.len - self.shift;
        if x < before_end { x + self.shift } else { x - before_end }
    }

    /// What goes to `s`, for `s < len`.
    pub fn invert(&self, s: u32) -> u32 {
        let mut x = if s >= self.shift { s - self.shift } else { s + (self.len - self.shift) };
        if x < self.domain {
            x = self.decrypt(x);
            while x >= self.domain {
                x = self.decrypt(x);
            }
        }
        x
    }

    // The halves differ by a bit where the number of bits is odd; they swap places every round, so
    // after an even number of rounds each is where it began.
    fn encrypt(&self, x: u32) -> u32 {
        let (mut left_bits, mut right_bits) = (self.left_bits, self.right_bits);
        let (mut left, mut right) = (x >> right_bits, x & mask(right_bits));
        for &key in &self.keys[..self.rounds as usize] {
            (left, right) = (right, left ^ (hash(right ^ key) & mask(left_bits)));
            (left_bits, right_bits) = (right_bits, left_bits);
        }
        left << right_bits | right
    }

    fn decrypt(&self, x: u32) -> u32 {
        let (mut left_bits, mut right_bits) = (self.left_bits, self.right_bits);
        let (mut left, mut right) = (x >> right_bits, x & mask(right_bits));
        for &key in self.keys[..self.rounds as usize].iter().rev() {
            (left, right) = (right ^ (hash(left ^ key) & mask(right_bits)), left);
            (left_bits, right_bits) = (right_bits, left_bits);
        }
        left << right_bits | right
    }
}

fn mask(bits: u32) -> u32 {
    (1 << bits) - 1
}

/// `lowbias32` of C. Wellons' hash prospector: two multiplications, no visible bias.
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Finalizer of SplitMix64 (Steele, Lea & Flood 2014).
fn split_mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_a_bijection_and_inverts() {
        for len in [1, 2, 3, 4, 5, 31, 32, 33, 255, 256, 257, 4097, 65_537] {
            for index in 0..3 {
                let p = Permutation::new(len, 7, index);
                let mut seen = vec![false; len as usize];
                for i in 0..len {
                    let s = p.apply(i);
                    assert!(!std::mem::replace(&mut seen[s as usize], true), "len {len}: {s} twice");
                    assert_eq!(p.invert(s), i);
                }
            }
        }
    }

    #[test]
    fn other_orders_send_new_points_behind_the_old() {
        for (old, new) in [(0, 1), (1, 1), (5, 3), (3, 5), (256, 255), (4097, 33), (1, 4097), (u32::MAX - 9, 9)] {
            for order in [SlotOrder::Shuffled, SlotOrder::BatchShuffled, SlotOrder::Arrival] {
                let p = Permutation::in_order(order, old, new, 7, 1);
                let mut slots: Vec<u32> = (0..new).map(|i| p.apply(i)).collect();
                assert!((0..new).all(|i| p.invert(slots[i as usize]) == i), "{order:?} {old} + {new}");
                assert!((old.saturating_sub(3)..old).all(|i| p.apply(p.invert(i)) == i));
                match order {
                    SlotOrder::Shuffled => assert_eq!(p, Permutation::new(old + new, 7, 1)),
                    SlotOrder::Arrival => assert!(slots.iter().copied().eq(old..old + new)),
                    SlotOrder::BatchShuffled => {
                        assert_eq!(slots.is_sorted(), new < 5, "a few may stay in order");
                        slots.sort_unstable();
                        assert!(slots.into_iter().eq(old..old + new));
                    }
                }
            }
        }
    }

    #[test]
    fn the_largest_domain_inverts() {
        let p = Permutation::new(u32::MAX, 1, 2);
        for i in [0, 1, 65_535, 65_536, 1 << 24, 1 << 31, u32::MAX - 1] {
            assert_eq!(p.invert(p.apply(i)), i);
        }
    }
}
