//! Values that are shown or hidden one by one, as clauses of the filter.

use crate::{
    render::{Clause, Filter},
    scene::Attribute,
};

/// Whether the filter shows points of which this attribute has this value.
pub fn is_shown(filter: &Filter, attribute: &Attribute, value: u32) -> bool {
    filter.of(attribute).is_none_or(|clause| clause.holds(value.into()))
}

/// Changes that for one value, and for no other.
pub fn set_shown(filter: &mut Filter, attribute: &Attribute, value: u32, shown: bool) {
    let clause = filter.of(attribute).cloned();
    let ranges: Vec<[f64; 2]> = clause.iter().flat_map(|clause| clause.values.ranges().to_vec()).collect();
    let listed = |number: u32| ranges.iter().any(|[low, high]| (*low..=*high).contains(&f64::from(number)));
    let is_excluding = clause.as_ref().is_none_or(|clause| clause.is_excluding);
    // Values are of 16 bits: an open range ends there.
    let last = ranges.iter().map(|[_, high]| *high).fold(f64::from(value), f64::max).clamp(0.0, 65_535.0);
    let numbers: Vec<u32> =
        (0..=last as u32).filter(|&n| if n == value { shown != is_excluding } else { listed(n) }).collect();
    let clause = match (is_excluding, numbers.is_empty()) {
        (true, true) => None,
        (true, false) => Some(Clause::none_of(attribute.clone(), numbers)),
        (false, _) => Some(Clause::one_of(attribute.clone(), numbers)),
    };
    filter.set(attribute, clause);
}

/// Hides these values, and shows all others.
pub fn hide(filter: &mut Filter, attribute: &Attribute, values: impl IntoIterator<Item = u32>) {
    let values: Vec<u32> = values.into_iter().collect();
    let clause = (!values.is_empty()).then(|| Clause::none_of(attribute.clone(), values));
    filter.set(attribute, clause);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hiding_a_value_hides_no_other() {
        let file = Attribute::File;
        let mut filter = Filter::default();
        let shown = |filter: &Filter| (0..4).map(|i| is_shown(filter, &file, i)).collect::<Vec<_>>();
        set_shown(&mut filter, &file, 2, false);
        assert_eq!(shown(&filter), [true, true, false, true]);
        set_shown(&mut filter, &file, 0, false);
        assert_eq!(shown(&filter), [false, true, false, true]);
        set_shown(&mut filter, &file, 2, true);
        set_shown(&mut filter, &file, 0, true);
        assert!(filter.clauses.is_empty(), "nothing is hidden: {filter:?}");
        // Given on the command line the other way round.
        for typed in ["file=1..", "file=1..2"] {
            let mut filter = Filter { clauses: vec![typed.parse().unwrap()] };
            set_shown(&mut filter, &file, 0, true);
            assert_eq!(shown(&filter)[..3], [true; 3], "{typed}: {filter:?}");
            set_shown(&mut filter, &file, 1, false);
            assert_eq!(shown(&filter)[..3], [true, false, true], "{typed}: {filter:?}");
        }
    }
}
