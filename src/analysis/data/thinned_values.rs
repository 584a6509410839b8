//! Evenly spaced values out of many. In: values, one by one. Out: at most so many of them, from the first to the last.

/// Evenly spaced values out of many: half of them are dropped whenever there are too many.
#[derive(Debug)]
pub(crate) struct ThinnedValues<T> {
    /// Values that are kept, in order: the first, and every `stride`-th after it.
    pub values: Vec<T>,
    most: usize,
    seen: usize,
    /// One in so many values is kept.
    stride: usize,
}

impl<T> ThinnedValues<T> {
    /// Starts a list of at most `most` values.
    pub fn new(most: usize) -> Self {
        Self { values: Vec::new(), most: most.max(1), seen: 0, stride: 1 }
    }

    /// Checks whether the next value is kept for now.
    pub fn takes_next(&self) -> bool {
        self.seen.is_multiple_of(self.stride)
    }

    /// Adds the next value.
    pub fn push(&mut self, value: T) {
        if self.takes_next() {
            self.values.push(value);
        }
        self.seen += 1;
        if self.values.len() > self.most {
            let mut keep = [false, true].into_iter().cycle();
            self.values.retain(|_| keep.next() == Some(false));
            self.stride *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_values_are_evenly_spaced_and_never_exceed_the_limit() {
        let mut kept = ThinnedValues::new(100);
        for value in 0..100 {
            kept.push(value);
        }
        assert_eq!(kept.values, (0..100).collect::<Vec<_>>(), "few are kept all");
        for value in 100..1_000_000 {
            kept.push(value);
            assert!(kept.values.len() <= 100);
        }
        let stride = kept.values[1];
        assert!(kept.values.len() > 50 && kept.values.iter().enumerate().all(|(i, value)| *value == i as i32 * stride));
        assert!(kept.values[kept.values.len() - 1] > 1_000_000 - 2 * stride, "to the end");
    }
}
