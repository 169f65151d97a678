//! `[[hair]]`: groups of strands, and the fibres that they are made of.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{
    declare::{table, variants, words},
    faults::At,
    groom::RestShape,
    keys::{
        Fallback::{self, Derived, Required, RequiredIf, Value},
        Kind::{self, Bool, Choice, Count, Fraction, Length, NonNegative, Path, Positive, Table, Tables, Text},
    },
    limits::{MAX_HAIR_POINTS, MAX_POINTS_OF_A_STRAND},
    motion::Motion,
    pins::Pin,
    profile::Profile,
    scene::Roots,
    strands::End,
};

/// Poisson's ratios of materials that resist being sheared and being pressed together.
const POISSON: Kind = Kind::Within(-1.0, 0.5);

/// Coulomb's coefficient of friction of hair on hair, where a scene says none.
pub(crate) const FRICTION: f64 = 0.3;

table! {
    /// One `[[hair]]`: a group of strands that share everything.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Hair {
        /// Name of the group, for dotted keys and reports.
        name: String = Text, "", Value(Hair::NAME.to_owned());
        /// Shapes of the strands: drawn, or from a file.
        source as "": HairSource = Table, "", Derived("");
        /// Fibres of the strands.
        fibre as "": Fibre = Table, "", Derived("");
        /// Factor of the stiffness to bend and twist along the strands, linear between its pairs: stiffer roots are
        /// `[[0, 4], [0.3, 1]]`.
        stiffness: Option<Profile> = Kind::Profile, "", Derived("1 from root to tip");
        /// Locks that the hairs gather to which follow the strands, in pictures and films.
        clump: Option<Clump> = Table, "", Derived("they do not gather");
        /// Coulomb's coefficient of friction of the strands on other strands, of a pair the smaller one; two-way only.
        friction: f64 = NonNegative, "", Value(FRICTION);
        /// Hold of the roots: in place and direction, in place, not at all.
        root: End = Choice(End::WORDS), "", Value(End::Clamped);
        /// Hold of the tips, as of the roots; clamped with rods.solver = "direct" only.
        tip: End = Choice(End::WORDS), "", Value(End::Free);
        /// Seed that draws the group's root positions, length variation and curl phase, or the strands of its file that
        /// are simulated.
        seed: Option<u64> = Count(0, u32::MAX), "", Derived("from seed, another one for each group");
        /// Name of the body whose motion the roots take part in.
        body: Option<String> = Text, "", Derived("that of roots.body, else none");
        /// Keyframes of the roots, about the centre of their shape, or about the origin of a groom file; not with a
        /// body.
        motion: Motion = Tables, "", Derived("roots rest, or move as their body");
        /// Places along the strands that are held: at a body, or by a hair tie.
        pins as "pin": Vec<Pin> = Tables, "", Derived("no pins");
    }
}

variants! {
    /// Where the shapes of a group's strands come from.
    #[derive(Debug, Clone, PartialEq)]
    pub enum HairSource {
        /// Helices of one length on a shape.
        Drawn(Drawn) = "strands that are drawn",
        /// Curves of a groom file.
        File(GroomFile) = "a groom file",
    }
}

table! {
    /// Strands that are drawn on a shape.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Drawn {
        /// Number of strands.
        strands: u32 = Count(1, MAX_HAIR_POINTS), "", Required;
        /// Points per strand, root included.
        points: u32 = Count(2, MAX_POINTS_OF_A_STRAND), "", Required;
        /// Length of a strand along its curl.
        length: f64 = Length, "m", Required;
        /// Fraction by which strands are shorter at most, drawn at random.
        length_variation: f64 = Fraction, "", Value(0.0);
        /// Helical rest shape, right-handed about the strand's axis.
        curl: Option<Curl> = Table, "", Derived("straight");
        /// Spread of the helices' phases over the strands, 0 to 1.
        curl_phase: f64 = NonNegative, "turns", Value(1.0);
        /// Shape that the strands are rooted on.
        roots: Roots = Table, "", Required;
    }
}

table! {
    /// A groom file, and how its curves become strands.
    #[derive(Debug, Clone, PartialEq)]
    pub struct GroomFile {
        /// Groom file that the strands come from (.hair, .data, .bin, .npz, .npy, .ply).
        file: String = Path, "", Required;
        /// Metres per unit of the file: 0.01 for centimetres.
        scale: Option<f64> = Positive, "m", RequiredIf("with a groom file that does not say its unit");
        /// Axis of the file that points up, or the axes of the file that become x, y and z; xzy, yxz and zyx mirror.
        up: Up = Choice(Up::WORDS), "", Value(Up::Y);
        /// Whether the shape in the file is the one at rest, from which weight bends the strands, or the one that they
        /// hang in, with their roots clamped.
        rest: RestShape = Choice(RestShape::WORDS), "", Value(RestShape::Hanging);
        /// Whether strands take their radius from the file, where it has one that is a hair's, 15 to 150 µm on average.
        file_radius: bool = Bool, "", Value(true);
        /// Whether the strands that the file marks as guides are those that are simulated; false: as if it marked none.
        file_guides: bool = Bool, "", Value(true);
        /// Points of each strand of a file that does not say where one ends: a .ply without strands, an array (points,
        /// 3).
        points_per_strand: Option<u32> = Count(1, MAX_POINTS_OF_A_STRAND), "", Derived("the file must say");
        /// Number of strands; of a file's guides, or of all its strands, those whose roots are far from one another.
        /// The others follow.
        strands: Option<u32> = Count(1, MAX_HAIR_POINTS), "", Derived("all of the file's guides, or of its strands");
        /// Points per strand, root included; strands of a file are divided anew, evenly along their length.
        points: Option<u32> = Count(2, MAX_POINTS_OF_A_STRAND), "", Derived("the file's");
    }
}

words! {
    /// `hair.up`.
    #[derive(Default)]
    pub enum Up {
        /// Axes stay.
        #[default]
        Y = "y",
        /// A quarter turn about x: (x, z, -y).
        Z = "z",
        /// A quarter turn about z: (-y, x, z).
        X = "x",
        /// A turn: (y, z, x).
        Yzx = "yzx",
        /// A turn: (z, x, y).
        Zxy = "zxy",
        /// A mirror image: (x, z, y).
        Xzy = "xzy",
        /// A mirror image: (y, x, z).
        Yxz = "yxz",
        /// A mirror image: (z, y, x).
        Zyx = "zyx",
    }
}

table! {
    /// Fibres of a strand: side by side, equal and independent.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Fibre, with defaults, checked by Fibre::check {
        /// Radius of a fibre at its root; the semi-major axis, along d2, where the cross-section is an ellipse.
        radius: f64 = Length, "m", Value(4e-5);
        /// Fraction by which the tip's radius is less than the root's.
        taper: f64 = Fraction, "", Value(0.0);
        /// Semi-minor axis, along d1, over semi-major axis of the cross-section; a curl turns about d2 and so bends the
        /// flat way.
        aspect: f64 = Kind::Within(0.0, 1.0), "", Value(1.0);
        /// Density of a fibre.
        density: f64 = Positive, "kg/m³", Value(1320.0);
        /// Fibres that a strand stands for; they scale its mass, stiffness and drag area.
        fibres_per_strand: f64 = Positive, "", Value(1.0);
        /// Elastic moduli of a fibre, or stiffnesses of the strand.
        stiffness as "": Stiffness = Table, "", Derived("");
        /// Mass of every point; the paper's is 1.46e-7.
        point_mass: Option<f64> = Positive, "kg", Derived("half of each adjoining segment's mass");
    }
}

variants! {
    /// Stiffness that bends, twists and stretches a strand back.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub enum Stiffness {
        /// Elastic moduli of a fibre's material; the strand has `fibres_per_strand` times a fibre's stiffness.
        Moduli(Moduli) = "youngs_modulus",
        /// Stiffnesses of the whole strand.
        Direct(StrandStiffness) = "the three stiffnesses",
    }
}

table! {
    /// Elastic moduli of a fibre's material.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Moduli, with defaults {
        /// Young's modulus E of a fibre; not with the three stiffnesses.
        youngs_modulus: f64 = Positive, "Pa", Value(4e9);
        /// Poisson's ratio ν: G = E/(2 (1 + ν)), GA = EA/(2 (1 + ν)).
        poissons_ratio: f64 = POISSON, "", Value(0.38);
    }
}

table! {
    /// Stiffnesses of a whole strand.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct StrandStiffness {
        /// Stretch stiffness EA of the strand; the three stiffnesses go together.
        stretch as "stretch_stiffness": f64 = Positive, "N", Required;
        /// Bend stiffness EI of the strand.
        bend as "bend_stiffness": f64 = Positive, "N m²", Required;
        /// Twist stiffness GJ of the strand.
        twist as "twist_stiffness": f64 = Positive, "N m²", Required;
        /// Poisson's ratio ν: G = E/(2 (1 + ν)), GA = EA/(2 (1 + ν)).
        poissons_ratio: f64 = POISSON, "", Value(0.38);
    }
}

table! {
    /// A right-handed helix about the strand's axis.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Curl {
        /// Radius of the helix.
        radius: f64 = Length, "m", Required;
        /// Advance along the axis per turn.
        pitch: f64 = Length, "m", Required;
    }
}

table! {
    /// Locks: some strands are their centres, and hairs that follow are drawn to the nearest of them.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Clump {
        /// Distance from each centre's root to the next.
        size: f64 = Length, "m", Required;
        /// Part of the way to its centre that a hair's tip is drawn; its root stays, and between them the part grows
        /// with the length.
        strength: f64 = Kind::Within(0.0, 1.0), "", Value(0.8);
        /// Part of the strength that hairs go without at most, drawn at random.
        noise: f64 = Fraction, "", Value(0.0);
    }
}

impl Hair {
    /// Name of a group that says none.
    pub(crate) const NAME: &str = "hair";

    /// Parameters that the strands are drawn by; `None` where they come from a file.
    #[must_use]
    pub fn as_drawn(&self) -> Option<&Drawn> {
        match &self.source {
            HairSource::Drawn(drawn) => Some(drawn),
            HairSource::File(_) => None,
        }
    }

    /// The groom file that the strands come from; `None` where they are drawn.
    #[must_use]
    pub fn as_file(&self) -> Option<&GroomFile> {
        match &self.source {
            HairSource::Drawn(_) => None,
            HairSource::File(file) => Some(file),
        }
    }

    /// A group of this many strands of `points` points, `length` \[m\] long, on `roots`.
    #[must_use]
    pub fn drawn(strands: u32, points: u32, length: f64, roots: Roots) -> Self {
        Self::of(HairSource::Drawn(Drawn {
            strands,
            points,
            length,
            length_variation: 0.0,
            curl: None,
            curl_phase: 1.0,
            roots,
        }))
    }

    /// A group of the strands of a groom file; relative paths start from the current directory.
    #[must_use]
    pub fn from_file(file: impl Into<String>) -> Self {
        Self::of(HairSource::File(GroomFile::new(file)))
    }

    /// The group with this name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// The group with strands that are drawn as helices of this radius and pitch \[m\]; those of a file stay.
    #[must_use]
    pub fn curled(mut self, radius: f64, pitch: f64) -> Self {
        if let HairSource::Drawn(drawn) = &mut self.source {
            drawn.curl = Some(Curl { radius, pitch });
        }
        self
    }

    /// A group named `hair` of these strands, clamped at their roots.
    fn of(source: HairSource) -> Self {
        let (root, tip) = (End::Clamped, End::Free);
        let (name, fibre, motion) = (Self::NAME.to_owned(), Fibre::default(), Motion::default());
        let (stiffness, clump, seed, body, pins) = (None, None, None, None, Vec::new());
        let friction = FRICTION;
        Self { name, source, fibre, stiffness, clump, friction, root, tip, seed, body, motion, pins }
    }

    /// The point that the roots' motion turns about \[m\]: in a checked scene that of their body, if they have one,
    /// else the centre of their shape, or the origin of their groom file.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        let patch = || self.as_drawn()?.roots.patch().map(|patch| DVec3::from_array(patch.center));
        self.motion.center.or_else(patch).unwrap_or_default()
    }

    /// Name of the body whose motion the roots take part in: that of `body`, or of the mesh that they are on.
    #[must_use]
    pub fn body(&self) -> Option<&str> {
        let of_roots = || match &self.as_drawn()?.roots {
            Roots::Mesh(scalp) => Some(&*scalp.body),
            _ => None,
        };
        self.body.as_deref().or_else(of_roots)
    }
}

impl GroomFile {
    /// A file whose curves are taken as they are.
    #[must_use]
    pub fn new(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            scale: None,
            up: Up::Y,
            rest: RestShape::Hanging,
            file_radius: true,
            file_guides: true,
            points_per_strand: None,
            strands: None,
            points: None,
        }
    }
}

impl Fibre {
    /// Why an aspect is refused with stiffnesses that are given directly: those are a round strand's.
    const ROUND: &str = "stiffnesses are given: expected youngs_modulus with an aspect, or 1";

    pub(crate) fn check(&self, at: &At<'_>) {
        if self.aspect != 1.0 && matches!(self.stiffness, Stiffness::Direct { .. }) {
            at.fault("aspect", Self::ROUND);
        }
    }
}
