//! Frames: the state of a run as plain f32 arrays in world coordinates.

use windswept_scene::Pose;

/// The state at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// Steps since the start.
    pub step: u64,
    /// Time since the start \[s\].
    pub time: f64,
    /// The strands.
    pub hair: HairFrame,
    /// The air particles; empty without any.
    pub air: AirFrame,
    /// Pose of each of the scene's bodies, in their order; empty where it is not known, as in a film.
    pub bodies: Vec<Pose>,
}

/// Strands: points root to tip, one after the other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HairFrame {
    /// First point of each strand, and the number of points: strands + 1.
    pub offsets: Vec<u32>,
    /// Number of each strand in the groom file that it comes from; empty if strands come from no file, where a strand's
    /// number is its index.
    pub ids: Vec<u32>,
    /// Position of each point \[m\].
    pub positions: Vec<[f32; 3]>,
    /// Velocity of each point \[m/s\].
    pub velocities: Vec<[f32; 3]>,
    /// Orientation of each segment: the rotation (x, y, z, w) from material frame to world. A strand of n points has n
    /// - 1.
    pub orientations: Vec<[f32; 4]>,
    /// Frame that clamps the root of each strand (x, y, z, w); empty where it is not known.
    pub root_frames: Vec<[f32; 4]>,
    /// Radius of a fibre at each point \[m\]; empty where it is not known.
    pub radius: Vec<f32>,
    /// Hairs that each strand stands for; empty where it is not known.
    pub fibres: Vec<f32>,
    /// Group of each strand: that of its groom file, or the index of its `[[hair]]`; empty where it is not known.
    pub groups: Vec<u32>,
    /// Place of each root in the texture of what it grows on, as its groom file has it; empty where no file has them.
    pub root_uvs: Vec<[f32; 2]>,
    /// Whether each strand is simulated, else it is a follower; empty where all are simulated.
    pub guides: Vec<bool>,
}

/// Air particles in the order of their stable ids.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AirFrame {
    /// Position of each particle \[m\], wrapped into the box.
    pub positions: Vec<[f32; 3]>,
    /// Velocity of each particle \[m/s\].
    pub velocities: Vec<[f32; 3]>,
    /// Vorticity |curl v| at each particle \[1/s\]; empty unless asked for.
    pub vorticity: Vec<f32>,
    /// Energy ½ |û|² of the first band at each particle \[m²/s²\]; empty unless asked for.
    pub band_energy: Vec<f32>,
}
