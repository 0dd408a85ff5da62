//! Orders that are called random, and how random their beginning is.

use super::{
    StabilityError,
    experiment::{Claim, Outcome, Setup},
    picture::{Image, Strip},
    uniformity::{
        STORE, Shuffle, batches_of, shuffled, spectral_peak, z_first_slots, z_neighbours, z_slot_against_arrival,
    },
};
use crate::render::INSERTION_POINTS;

/// Slots whose spectrum is taken.
const SPECTRUM: usize = 4096;
/// Largest value of the periodogram that chance gives: ln(5 · 4,096) + 12, exceeded once in 160,000 orders.
const MOST_PEAK: f64 = 22.0;
/// Chi-square, standard deviations from its mean. Seeds are fixed, so what passes once does so always.
const ACCEPT_Z: f64 = 4.0;
/// What is to be rejected must be beyond doubt.
const REJECT_Z: f64 = 8.0;
/// Classes of the chi-square of the first slots.
const CLASSES: u32 = 64;

/// An order of `total` points, by its first slots.
struct Order {
    name: String,
    total: u32,
    /// Arrivals of the first 1 %.
    first: Vec<u32>,
    picture: Image,
}

impl Order {
    fn new(name: &str, total: u32, arrival: impl Fn(u32) -> u32) -> Order {
        let first: Vec<u32> = (0..total / 100).map(arrival).collect();
        // The points in scan lines, a pixel for 1/128² of them: how the first slots lie on a square scan.
        let mut picture = Image::new([128, 128]);
        let line = f64::from(total).sqrt();
        for &arrival in first.iter().take(SPECTRUM) {
            let (row, column) = ((f64::from(arrival) / line).floor(), f64::from(arrival) % line);
            let at = [column, row].map(|c| (c / line * 128.0) as i64);
            picture.set(at, [255, 214, 120]);
        }
        Order { name: name.into(), total, first, picture }
    }

    fn of_slots(name: &str, slots: &[u32]) -> Order {
        Order::new(name, slots.len() as u32, |slot| slots[slot as usize])
    }
}

/// `base^exponent` modulo `m`.
fn power_mod(base: u64, exponent: u64, m: u64) -> u64 {
    let (mut result, mut square, mut left) = (1 % m, base % m, exponent);
    while left > 0 {
        if left & 1 == 1 {
            result = result * square % m;
        }
        square = square * square % m;
        left >>= 1;
    }
    result
}

/// Slot → arrival after `iterations` perfect out-shuffles of a pool: an even deck is cut in halves that interleave,
/// so that the card at i goes to 2 i modulo (total − 1); the last stays.
fn perfect_shuffle(total: u32, iterations: u64) -> impl Fn(u32) -> u32 {
    let m = u64::from(total - 1);
    // Half of 1: 2 · (m + 1) / 2 = 1 modulo the odd m.
    let back = power_mod(m.div_ceil(2), iterations, m);
    move |slot| if slot == total - 1 { slot } else { (u64::from(slot) * back % m) as u32 }
}

/// Slot → arrival of quadratic residues taken twice modulo a prime that is 3 modulo 4: slots 0, 1, 2, 3 hold the
/// points 0, 1, 16, 81.
fn quadratic_residues(prime: u32) -> impl Fn(u32) -> u32 {
    let permute = move |x: u64| {
        let p = u64::from(prime);
        let residue = x * x % p;
        if x <= p / 2 { residue } else { p - residue }
    };
    move |slot| permute(permute(slot.into())) as u32
}

/// The largest prime up to `n` that is 3 modulo 4.
fn prime_below(n: u32) -> u32 {
    let is_prime = |p: u32| (3_u64..).step_by(2).take_while(|d| d * d <= p.into()).all(|d| u64::from(p) % d != 0);
    (7..=n).rev().find(|&p| p % 4 == 3 && is_prime(p)).unwrap_or(7)
}

pub fn shuffles(setup: &Setup) -> Result<Outcome, StabilityError> {
    let pools: [u32; 2] = setup.pick([1 << 19, 600_000], [1 << 25, 30_000_000]);
    let ours_of = |total: u32| shuffled(STORE, &batches_of(INSERTION_POINTS, total), 1);
    let good = Order::of_slots("the store's", &ours_of(pools[1]));
    let mut outcome = Outcome::default();

    // The spectra.
    let spectral = |order: &Order| spectral_peak(&order.first[..SPECTRUM.min(order.first.len())], order.total);
    let quantity = "peak of the spectrum of the first 4,096 slots (1: white)";
    let mut peaks = Vec::new();
    let mut strip = Vec::new();
    for total in pools {
        // Few iterations, many, and those after which a pool of 2^k is as before.
        for iterations in [1, 3, 8, u64::from(total.ilog2()), 40] {
            let name = format!("{iterations} perfect shuffles of {total}");
            let failing = Order::new(&name, total, perfect_shuffle(total, iterations));
            let order = setup.failing(&failing, &good);
            peaks.push(spectral(order));
            if iterations == 8 {
                strip.push((name, failing.picture));
            }
        }
    }
    let least = peaks.iter().copied().fold(f64::INFINITY, f64::min);
    outcome.claims.push(
        Claim::fails(
            "perfect-shuffle iterations",
            &format!("{quantity}, least of ten"),
            least,
            1000.0,
            "multiples of a number: one line in the spectrum",
        )
        .samples(peaks),
    );
    let prime = prime_below(pools[1]);
    let residues = Order::new("quadratic residues", prime, quadratic_residues(prime));
    let order = setup.failing(&residues, &good);
    outcome.claims.push(Claim::fails(
        "quadratic residues, twice",
        quantity,
        spectral(order),
        2.0 * MOST_PEAK,
        "until their squares wrap, the fourth differences of fourth powers are all 24; a sixteenth of them later",
    ));
    // The fourth root of the pool's size: until there, fourth powers do not wrap.
    let corner = f64::from(prime).powf(0.25) as usize - 1;
    let z = z_first_slots(&order.first[..corner], order.total, 8);
    outcome.claims.push(Claim::fails(
        "quadratic residues, twice",
        &format!("chi-square of the first {corner} slots ({:?} …), standard deviations", &order.first[..4]),
        z,
        REJECT_Z,
        "fourth powers that have not wrapped yet: half lie in the first sixteenth of the file, in every file of this size",
    ));

    // Chi-square of the first 1 %.
    let quantity = "chi-square of the first 1 %, standard deviations";
    let z = |order: &Order| z_first_slots(&order.first, order.total, CLASSES);
    let batches = batches_of(INSERTION_POINTS, pools[1]);
    for (shuffle, name) in [(Shuffle::BatchOnly, "each batch shuffled alone"), (Shuffle::Unshuffled, "unshuffled")] {
        let failing = Order::of_slots(name, &shuffled(shuffle, &batches, 1));
        let reason = "the first 1 % of the slots hold the first 1 % of the file";
        outcome.claims.push(Claim::fails(name, quantity, z(setup.failing(&failing, &good)), REJECT_Z, reason));
        strip.push((failing.name, failing.picture));
    }
    // Few points show what few rounds leave; the seeds are many instead.
    let seeds = 40_000;
    let slots = |shuffle| z_slot_against_arrival(shuffle, &batches_of(5, 24), seeds, 24);
    let steps = |shuffle| z_neighbours(shuffle, &[24], seeds / 4, 23, 23);
    let four = setup.failing(Shuffle::Feistel(4), STORE);
    let slots_quantity = format!("chi-square of slot against arrival, 24 points, {seeds} seeds, standard deviations");
    let steps_quantity = format!("chi-square of steps between neighbours, 24 points, {} seeds", seeds / 4);
    let reason = "4 rounds do not mix few bits";
    outcome.claims.push(Claim::fails("Feistel, 4 rounds", &slots_quantity, slots(four), REJECT_Z, reason));
    outcome.claims.push(Claim::fails("Feistel, 4 rounds", &steps_quantity, steps(four), REJECT_Z, reason));

    // This program's.
    let other = Order::of_slots("the store's", &ours_of(pools[0]));
    for ours in [&other, &good] {
        let total = ours.total;
        let failing = Order::new("perfect shuffle", total, perfect_shuffle(total, 8));
        let order = setup.ours(&failing, ours);
        let of = format!("{total} points in insertions of {INSERTION_POINTS}");
        outcome.claims.push(Claim::holds(
            "the store's",
            &format!("peak of the spectrum, {of}"),
            spectral(order),
            MOST_PEAK,
            "chance exceeds it once in 160,000 orders",
        ));
        let z = z(setup.ours(&Order::new("unshuffled", total, |slot| slot), ours)).abs();
        outcome.claims.push(Claim::holds("the store's", &format!("{quantity}, {of}"), z, ACCEPT_Z, "chance"));
    }
    let ours = setup.ours(Shuffle::Feistel(4), STORE);
    outcome.claims.push(Claim::holds("the store's", &slots_quantity, slots(ours).abs(), ACCEPT_Z, "8 rounds"));
    outcome.claims.push(Claim::holds("the store's", &steps_quantity, steps(ours).abs(), ACCEPT_Z, "8 rounds"));
    strip.push((residues.name, residues.picture));
    strip.push((good.name, good.picture));
    let random = shuffled(Shuffle::FisherYates, &[pools[1]], 7);
    strip.push(("truth (Fisher and Yates)".into(), Order::of_slots("", &random).picture));
    let title = "The first 4,096 slots on a square scan in scan lines";
    outcome.pictures.push(Strip { title: title.into(), images: strip });
    outcome.notes.push(
        "Quadratic residues have no key: every scan of the same size has the same order, and points 0 and 1 never \
         move. Their first 1 % as a whole looks random; the regularity shows in their first slots, and in fourth differences."
            .into(),
    );
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perfect_shuffles_are_those_of_cards() {
        let shuffle = |deck: Vec<u32>| {
            let half = deck.len() / 2;
            (0..half).flat_map(|i| [deck[i], deck[half + i]]).collect::<Vec<_>>()
        };
        for total in [2, 8, 10, 52] {
            let mut deck: Vec<u32> = (0..total).collect();
            for iterations in 1..=9 {
                deck = shuffle(deck);
                let arrival = perfect_shuffle(total, iterations);
                assert_eq!((0..total).map(arrival).collect::<Vec<_>>(), deck, "{total}, {iterations}");
            }
        }
        let eight = perfect_shuffle(52, 8);
        assert!((0..52).all(|slot| eight(slot) == slot), "eight out-shuffles restore a deck of 52");
    }

    #[test]
    fn residues_begin_as_published_and_are_a_permutation() {
        let arrival = quadratic_residues(1019);
        assert_eq!([0, 1, 2, 3].map(&arrival), [0, 1, 16, 81]);
        let mut all: Vec<u32> = (0..1019).map(arrival).collect();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..1019));
        assert_eq!((prime_below(1020), prime_below(30_000_000) % 4), (1019, 3));
    }
}
