//! A property along a strand, `hair.stiffness`: pairs of a part of the length and a factor there.

use serde::{Deserialize, Serialize};
use toml_edit::Value as Toml;

use crate::{
    declare::{Leaf, leaves, number},
    document::Datum,
    keys::Kind,
    motion::phase,
};

/// A factor along a strand: linear between pairs of a part of the length from the root, 0 to 1, and the factor there;
/// before the first pair and after the last it is theirs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile(pub Vec<[f64; 2]>);

impl Profile {
    /// The factor, `part` of the length from the root.
    #[must_use]
    pub fn at(&self, part: f64) -> f64 {
        let (before, way) = phase(&self.0, |[at, _]| *at, part);
        match self.0.get(before..) {
            Some([[_, from], [_, to], ..]) => from + way * (to - from),
            Some([[_, only]]) => *only,
            _ => 1.0,
        }
    }
}

impl<const N: usize> From<[[f64; 2]; N]> for Profile {
    fn from(pairs: [[f64; 2]; N]) -> Self {
        Self(pairs.into())
    }
}

impl Leaf for Profile {
    fn take(datum: &Datum) -> Option<Self> {
        if let Datum::Pairs(pairs) = datum { Some(Self(pairs.clone())) } else { None }
    }

    fn toml(&self) -> Toml {
        Toml::from_iter(self.0.iter().map(|pair| Toml::from_iter(pair.map(number))))
    }

    fn fits(&self, kind: Kind) -> bool {
        let within = self.0.iter().all(|[at, factor]| (0.0..=1.0).contains(at) && kind.holds(*factor) && *factor > 0.0);
        !self.0.is_empty() && within && self.0.is_sorted_by(|a, b| a[0] < b[0])
    }
}

leaves!(Profile);
