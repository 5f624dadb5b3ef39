//! The order of a best-first search: what may be best is looked at first.

/// Orders the entries of a [`BinaryHeap`](std::collections::BinaryHeap): the largest bound first, and of equal ones the
/// one with the largest number, which was found last, if they have numbers.
macro_rules! best_first {
    ($Entry:ty: $bound:ident $(, $number:ident)?) => {
        impl Ord for $Entry {
            #[inline]
            fn cmp(&self, other: &Self) -> std::cmp::Ordering {
                self.$bound.total_cmp(&other.$bound)$(.then(self.$number.cmp(&other.$number)))?
            }
        }

        impl PartialOrd for $Entry {
            #[inline]
            fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
                Some(self.cmp(other))
            }
        }

        impl PartialEq for $Entry {
            fn eq(&self, other: &Self) -> bool {
                self.cmp(other).is_eq()
            }
        }

        impl Eq for $Entry {}
    };
}

pub(crate) use best_first;
