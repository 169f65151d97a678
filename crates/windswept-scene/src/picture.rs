//! How pictures are taken: `[camera]` and `[picture]`.

/// `[camera]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Where it stands \[m\].
    pub eye: [f64; 3],
    /// What it looks at \[m\].
    pub target: [f64; 3],
    /// Vertical field of view \[°\].
    pub fov: f64,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// `[picture]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Picture {
    /// Hairs drawn in all, interpolated from the strands; at least every strand is drawn.
    pub hairs: u32,
    /// How air particles are drawn.
    pub air: AirPicture,
}

/// `picture.air`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AirPicture {
    /// Not at all.
    None,
    /// Coloured by |curl v|.
    Vorticity,
    /// Coloured by ½ |û|² of the first band.
    BandEnergy,
}
