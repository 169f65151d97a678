//! Slots of air in memory: arrays for a caller are ordered by stable ids, the engine's own by slots.

/// Stable id of the particle in each slot of air.
///
/// Air lies in memory in the order of cells, so that neighbours in the box are near one another there too, and a step
/// may give each particle another slot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slots(pub(crate) Vec<u32>);

impl Slots {
    /// Rows in the order of ids, from rows in the order of slots.
    #[must_use]
    pub fn by_id<T: Copy + Default>(&self, rows: impl IntoIterator<Item = T>) -> Vec<T> {
        let mut sorted = vec![T::default(); self.0.len()];
        for (id, row) in self.0.iter().zip(rows) {
            // A driver that works has no id beyond the last.
            if let Some(place) = sorted.get_mut(*id as usize) {
                *place = row;
            }
        }
        sorted
    }

    /// Rows in the order of slots, from rows in the order of ids.
    #[must_use]
    pub fn by_slot<T: Copy + Default>(&self, rows: &[T]) -> Vec<T> {
        self.0.iter().map(|id| rows.get(*id as usize).copied().unwrap_or_default()).collect()
    }

    /// The id of the particle in each slot.
    #[must_use]
    pub fn ids(&self) -> &[u32] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::Slots;

    /// Rows go to the slots of their ids and come back.
    #[test]
    fn rows_go_to_their_slots_and_back() {
        let slots = Slots(vec![2, 0, 3, 1]);
        let rows = ['a', 'b', 'c', 'd'];
        assert_eq!(slots.by_slot(&rows), ['c', 'a', 'd', 'b']);
        assert_eq!(slots.by_id(slots.by_slot(&rows)), rows);
    }
}
