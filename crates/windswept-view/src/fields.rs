//! Values that hair and air are coloured by.

use glam::{DVec3, Vec3};
use windswept::{Frame, HairLoads};

/// Colours from the lowest value to the highest, sRGB: dark enough at one end and saturated enough at the other to
/// stand out from the grey behind them.
pub(crate) const RAMP: [[u8; 3]; 5] = [[38, 28, 92], [44, 92, 190], [40, 170, 150], [238, 190, 50], [206, 34, 28]];

/// Part of the values that the last colour's value is above: a few fast points would leave one colour for all others.
const COVERED: f64 = 0.99;
/// Part that a range which became too large keeps from picture to picture.
const KEPT: f32 = 0.97;

/// What strands are coloured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum HairColour {
    /// The colours of hair.
    #[default]
    Hair,
    /// Speed of each point.
    Speed,
    /// Drag on each point.
    Drag,
    /// Change of each segment's length.
    Length,
}

/// How air is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum AirLook {
    /// Not at all.
    #[default]
    Hidden,
    /// As points.
    Points,
    /// As arrows along the velocity.
    Arrows,
}

/// What air is coloured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum AirColour {
    /// Speed.
    #[default]
    Speed,
    /// Vorticity |curl v|.
    Vorticity,
}

impl HairColour {
    pub(crate) const ALL: [Self; 4] = [Self::Hair, Self::Speed, Self::Drag, Self::Length];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Hair => "hair",
            Self::Speed => "speed",
            Self::Drag => "drag",
            Self::Length => "length error",
        }
    }

    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Hair => "",
            Self::Speed => "m/s",
            Self::Drag => "µN",
            Self::Length => "%",
        }
    }

    /// The value of each hair point in [`Self::unit`]; none where hair has its own colours, or the drag is not known.
    pub(crate) fn values(self, frame: &Frame, loads: Option<&HairLoads>, rest: &[f64]) -> Vec<f32> {
        match self {
            Self::Hair => Vec::new(),
            Self::Speed => frame.hair.velocities.iter().copied().map(length).collect(),
            Self::Drag => {
                loads.map_or(Vec::new(), |loads| loads.drag.iter().map(|&force| 1e6 * length(force)).collect())
            }
            Self::Length => length_errors(frame, rest).into_iter().map(|error| 100.0 * error).collect(),
        }
    }
}

impl AirColour {
    pub(crate) const ALL: [Self; 2] = [Self::Speed, Self::Vorticity];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Vorticity => "vorticity",
        }
    }

    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Vorticity => "1/s",
        }
    }

    /// The value of each air particle in [`Self::unit`]; none where the frame does not have it.
    pub(crate) fn values(self, frame: &Frame) -> Vec<f32> {
        match self {
            Self::Speed => frame.air.velocities.iter().copied().map(length).collect(),
            Self::Vorticity => frame.air.vorticity.clone(),
        }
    }
}

impl AirLook {
    pub(crate) const ALL: [Self; 3] = [Self::Hidden, Self::Points, Self::Arrows];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Hidden => "none",
            Self::Points => "points",
            Self::Arrows => "arrows",
        }
    }
}

/// Change of length of the segment that ends at each point, over its rest length; that of a strand's first segment at
/// its root too. `rest`: lengths of all segments \[m\].
fn length_errors(frame: &Frame, rest: &[f64]) -> Vec<f32> {
    let now = segment_lengths(frame);
    let error = |segment: usize| Some((now.get(segment)? / rest.get(segment)? - 1.0).abs() as f32);
    let of_strand = |(strand, ends): (usize, &[u32])| {
        let (first, last) = (ends[0] as usize, ends[1] as usize);
        // Each strand before has a segment less than it has points.
        (first..last).map(move |point| error(point.max(first + 1) - 1 - strand).unwrap_or_default()).collect::<Vec<_>>()
    };
    frame.hair.offsets.windows(2).enumerate().flat_map(of_strand).collect()
}

/// Lengths of all segments in a frame \[m\].
pub(crate) fn segment_lengths(frame: &Frame) -> Vec<f64> {
    let hair = &frame.hair;
    let of_strand = |ends: &[u32]| hair.positions[ends[0] as usize..ends[1] as usize].windows(2);
    let between = |ends: &[[f32; 3]]| {
        let [a, b] = [ends[0], ends[1]].map(|x| DVec3::from_array(x.map(f64::from)));
        a.distance(b)
    };
    hair.offsets.windows(2).flat_map(of_strand).map(between).collect()
}

pub(crate) fn length(v: [f32; 3]) -> f32 {
    Vec3::from_array(v).length()
}

/// The value of the last colour; the first colour's is 0. It rises at once and falls slowly, so that no picture
/// flickers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Range(pub(crate) f32);

impl Range {
    /// Follows these values.
    pub(crate) fn follow(&mut self, values: &[f32]) {
        let mut finite: Vec<f32> = values.iter().copied().filter(|value| value.is_finite()).collect();
        if finite.is_empty() {
            return;
        }
        let place = ((finite.len() - 1) as f64 * COVERED) as usize;
        let (_, &mut high, _) = finite.select_nth_unstable_by(place, f32::total_cmp);
        self.0 = high.max(KEPT * self.0);
    }
}

#[cfg(test)]
mod tests {
    use windswept::HairFrame;

    use super::*;

    fn frame() -> Frame {
        let hair = HairFrame {
            offsets: vec![0, 3, 5],
            positions: vec![[0.0; 3], [0.0, 0.011, 0.0], [0.0, 0.021, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0095]],
            velocities: vec![[3.0, 4.0, 0.0], [0.0; 3], [0.0; 3], [0.0; 3], [0.0, 0.0, 2.0]],
            ..HairFrame::default()
        };
        Frame { hair, ..Frame::default() }
    }

    /// Each point has the speed of its velocity, and the length error of its own strand's segment.
    #[test]
    fn values_are_those_of_points_and_segments() {
        let frame = frame();
        assert_eq!(HairColour::Speed.values(&frame, None, &[]), [5.0, 0.0, 0.0, 0.0, 2.0]);
        let errors = HairColour::Length.values(&frame, None, &[0.01, 0.01, 0.01]);
        for (error, expected) in errors.iter().zip([10.0, 10.0, 0.0, 5.0, 5.0]) {
            assert!((error - expected).abs() < 1e-3, "{errors:?}");
        }
        let loads = HairLoads { drag: vec![[0.0, 3e-6, 4e-6]; 5], ..HairLoads::default() };
        assert!(HairColour::Drag.values(&frame, Some(&loads), &[]).iter().all(|drag| (drag - 5.0).abs() < 1e-5));
        assert!(HairColour::Drag.values(&frame, None, &[]).is_empty());
        assert_eq!(segment_lengths(&frame).len(), 3);
    }

    /// A range covers all but the outliers, rises at once, falls slowly, and is finite.
    #[test]
    fn a_range_follows() {
        let mut range = Range::default();
        let mut values = vec![1.0; 999];
        values.push(1e6);
        range.follow(&values);
        assert_eq!(range, Range(1.0));
        range.follow(&[0.5, f32::NAN]);
        assert_eq!(range, Range(0.97));
        range.follow(&[]);
        assert_eq!(range, Range(0.97));
    }
}
