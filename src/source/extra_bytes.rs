//! The list of extra bytes (VLR «LASF_Spec» 4): 192 bytes per dimension. LAS 1.5 says that there is only
//! one list; earlier files have several.

use super::bytes::{text, u64_at};
use crate::scene::{ExtraDimension, ExtraKind, Number};

/// User id and record id of the list.
pub const USER_ID: &str = "LASF_Spec";
pub const RECORD_ID: u16 = 4;

/// Bytes per dimension.
const ENTRY: usize = 192;

/// Parses the lists of a file: one, or several that continue each other. What they say beyond a
/// record's `extra_bytes` is left out, what they leave out stays without a meaning, and either is said
/// in the warnings.
pub fn parse(lists: &[Vec<u8>], extra_bytes: usize, warnings: &mut Vec<String>) -> Vec<ExtraDimension> {
    let mut dimensions: Vec<ExtraDimension> = Vec::new();
    let mut at = 0;
    for list in lists.iter().filter(|list| list.len() % ENTRY != 0) {
        warnings.push(format!("extra bytes: expected entries of {ENTRY} bytes, found a list of {}", list.len()));
    }
    for (number, entry) in lists.iter().flat_map(|list| list.as_chunks::<ENTRY>().0).enumerate() {
        let Some(dimension) = dimension(entry, at) else {
            warnings.push(format!(
                "extra bytes: expected type 0 to 30 of dimension {number} «{}», found {}: it and what follows is left out",
                text(&entry[4..36]),
                entry[2]
            ));
            return dimensions;
        };
        let end = at + dimension.bytes();
        if end > extra_bytes {
            warnings.push(format!(
                "extra bytes: dimension {number} «{}» ends at byte {end} of the {extra_bytes} that a record has: \
                 it and what follows is left out",
                dimension.name
            ));
            return dimensions;
        }
        at = end;
        dimensions.push(dimension);
    }
    if at < extra_bytes && !dimensions.is_empty() {
        warnings.push(format!("extra bytes: the list explains {at} of the {extra_bytes} that a record has"));
    }
    dimensions
}

/// One entry: reserved (2 bytes), type, options, name (32), unused (4), no data, min, max (3 × 8 each),
/// scale, offset (3 × f64 each), description (32).
fn dimension(entry: &[u8; ENTRY], at: usize) -> Option<ExtraDimension> {
    use ExtraKind as K;
    const KINDS: [ExtraKind; 10] = [K::U8, K::I8, K::U16, K::I16, K::U32, K::I32, K::U64, K::I64, K::F32, K::F64];
    let (kind, elements) = match (usize::from(entry[2]), entry[3]) {
        // The options of this type are its size.
        (0, size) => (K::Bytes(size.into()), 1),
        // 11 to 20 are pairs, 21 to 30 triples.
        (n @ 1..=30, _) => (KINDS[(n - 1) % 10], (n - 1) / 10 + 1),
        _ => return None,
    };
    let said = |bit: u8| !matches!(kind, K::Bytes(_)) && entry[3] & 1 << bit != 0;
    let words = |from: usize| (0..elements).map(move |i| u64_at(entry, from + 8 * i));
    let numbers = |bit, from| {
        // Widened to eight bytes: unsigned, signed or floating, as the type is.
        let number = |bits: u64| match kind {
            K::F32 | K::F64 => Number::Float(f64::from_bits(bits)),
            K::I8 | K::I16 | K::I32 | K::I64 => Number::Signed(bits.cast_signed()),
            _ => Number::Unsigned(bits),
        };
        said(bit).then(|| words(from).map(number).collect())
    };
    let floats = |bit, from| said(bit).then(|| words(from).map(f64::from_bits).collect());
    Some(ExtraDimension {
        name: text(&entry[4..36]),
        description: text(&entry[160..192]),
        at,
        kind,
        elements,
        no_data: numbers(0, 40),
        min: numbers(1, 64),
        max: numbers(2, 88),
        scale: floats(3, 112),
        offset: floats(4, 136),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(kind: u8, options: u8, name: &str, words: &[(usize, u64)]) -> Vec<u8> {
        let mut entry = vec![0; ENTRY];
        (entry[2], entry[3]) = (kind, options);
        entry[4..4 + name.len()].copy_from_slice(name.as_bytes());
        for &(at, word) in words {
            entry[at..at + 8].copy_from_slice(&word.to_le_bytes());
        }
        entry
    }

    fn parsed(list: &[u8], extra_bytes: usize) -> (Vec<ExtraDimension>, String) {
        let mut warnings = Vec::new();
        (parse(&[list.to_vec()], extra_bytes, &mut warnings), warnings.join("; "))
    }

    #[test]
    fn every_type_reads_its_largest_and_smallest_number() {
        let cases: [(u8, usize, Vec<u8>, Number); 10] = [
            (1, 1, vec![255], Number::Unsigned(255)),
            (2, 1, vec![0x80], Number::Signed(-128)),
            (3, 2, vec![255; 2], Number::Unsigned(65_535)),
            (4, 2, vec![0, 0x80], Number::Signed(-32_768)),
            (5, 4, vec![255; 4], Number::Unsigned(u32::MAX.into())),
            (6, 4, vec![255; 4], Number::Signed(-1)),
            (7, 8, vec![255; 8], Number::Unsigned(u64::MAX)),
            (8, 8, vec![0, 0, 0, 0, 0, 0, 0, 0x80], Number::Signed(i64::MIN)),
            (9, 4, 0.1f32.to_le_bytes().to_vec(), Number::Float(0.1f32.into())),
            (10, 8, 0.1f64.to_le_bytes().to_vec(), Number::Float(0.1)),
        ];
        for (kind, size, bytes, expected) in cases {
            for elements in 1..=3 {
                let (found, warnings) = parsed(&entry(kind + 10 * (elements as u8 - 1), 0, "x", &[]), size * elements);
                assert_eq!((found[0].bytes(), warnings.as_str()), (size * elements, ""), "type {kind} × {elements}");
                let extra = bytes.repeat(elements);
                assert_eq!(found[0].number(&extra, elements - 1), Some(expected), "type {kind} × {elements}");
                assert_eq!(found[0].number(&extra, elements), None);
                assert_eq!(found[0].number(&extra[1..], 0), None, "too few bytes");
                assert_eq!(found[0].value_of(&extra, elements - 1), Some(expected.as_f64()));
            }
        }
    }

    #[test]
    fn options_say_which_fields_count() {
        let words = |from| (from, 7u64);
        let mut list = entry(16, 0, "none", &[words(40), words(64), words(88), words(112), words(136)]);
        list.extend(entry(
            14,
            0x1f,
            "all",
            &[
                (40, (-9i64).cast_unsigned()),
                (48, 5),
                (72, 1),
                (96, 2),
                (112, 0.5f64.to_bits()),
                (120, 0.1f64.to_bits()),
                (136, 100f64.to_bits()),
            ],
        ));
        let (found, warnings) = parsed(&list, 12);
        assert_eq!(warnings, "");
        let none = &found[0];
        assert!(none.no_data.is_none() && none.min.is_none() && none.max.is_none());
        assert!(none.scale.is_none() && none.offset.is_none());
        let all = &found[1];
        assert_eq!((all.name.as_str(), all.at, all.type_name().as_str()), ("all", 8, "i16 × 2"));
        assert_eq!(all.no_data, Some(vec![Number::Signed(-9), Number::Signed(5)]));
        assert_eq!(all.min, Some(vec![Number::Signed(0), Number::Signed(1)]));
        let mut extra = [0; 12];
        extra[8..10].copy_from_slice(&3i16.to_le_bytes());
        extra[10..12].copy_from_slice(&3i16.to_le_bytes());
        assert_eq!((all.value(&extra), all.value_of(&extra, 1)), (Some(101.5), Some(3.0 * 0.1)));
        extra[8..10].copy_from_slice(&(-9i16).to_le_bytes());
        assert_eq!((all.value(&extra), all.number(&extra, 0)), (None, Some(Number::Signed(-9))));
    }

    #[test]
    fn not_a_number_can_mean_no_data() {
        let (found, _) = parsed(&entry(9, 1, "x", &[(40, f64::NAN.to_bits())]), 4);
        assert_eq!(found[0].value(&f32::NAN.to_le_bytes()), None);
        assert_eq!(found[0].value(&1f32.to_le_bytes()), Some(1.0));
    }

    #[test]
    fn lists_that_do_not_add_up_are_used_as_far_as_they_do() {
        let mut list = entry(0, 3, "raw", &[]);
        list.extend(entry(3, 0, "two", &[]));
        let (found, warnings) = parsed(&list, 5);
        assert_eq!((found.len(), warnings.as_str()), (2, ""));
        assert_eq!(
            (found[0].number(&[1, 2, 3, 4, 0], 0), found[0].raw(&[1, 2, 3, 4, 0])),
            (None, Some(&[1, 2, 3][..]))
        );
        assert_eq!(found[1].value(&[1, 2, 3, 4, 0]), Some(4.0));

        let (found, warnings) = parsed(&list, 4);
        assert_eq!(found.len(), 1);
        assert!(warnings.contains("dimension 1 «two» ends at byte 5 of the 4 that a record has"), "{warnings}");
        let (found, warnings) = parsed(&list, 9);
        assert_eq!(found.len(), 2);
        assert!(warnings.contains("the list explains 5 of the 9"), "{warnings}");
        let mut wrong = list.clone();
        wrong[2] = 31;
        let (found, warnings) = parsed(&wrong, 5);
        assert!(found.is_empty() && warnings.contains("expected type 0 to 30 of dimension 0 «raw», found 31"));
        let (found, warnings) = parsed(&list[..200], 3);
        assert!(found.len() == 1 && warnings.contains("expected entries of 192 bytes, found a list of 200"));
        // Two lists are one.
        let mut warnings = Vec::new();
        let two = parse(&[list[..192].to_vec(), list[192..].to_vec()], 5, &mut warnings);
        assert_eq!((two, warnings), (parsed(&list, 5).0, Vec::new()));
        assert_eq!(parsed(&[], 3), (Vec::new(), String::new()), "bytes that nobody explains are common");
    }

    proptest::proptest! {
        #[test]
        fn any_list_stays_within_the_record(
            kinds in proptest::collection::vec((0u8..=35, 0u8..=255), 0..9),
            noise in 0u64..,
            extra_bytes in 0usize..40,
        ) {
            let words: Vec<_> = (40..184).step_by(8).map(|at| (at, noise.rotate_left(at as u32))).collect();
            let list: Vec<u8> = kinds.iter().flat_map(|&(kind, options)| entry(kind, options, "x", &words)).collect();
            let (found, _) = parsed(&list, extra_bytes);
            let extra: Vec<u8> = (0..extra_bytes).map(|i| (noise >> (i % 8)) as u8).collect();
            let mut at = 0;
            for dimension in &found {
                proptest::prop_assert_eq!(dimension.at, at);
                at += dimension.bytes();
                proptest::prop_assert_eq!(dimension.raw(&extra).map(<[u8]>::len), Some(dimension.bytes()));
                let typed = !matches!(dimension.kind, ExtraKind::Bytes(_));
                proptest::prop_assert_eq!(dimension.number(&extra, dimension.elements - 1).is_some(), typed);
            }
            proptest::prop_assert!(at <= extra_bytes);
        }
    }
}
