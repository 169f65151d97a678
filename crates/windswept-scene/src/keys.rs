//! Every key of a scene file, in one table: type, default, unit, meaning. The reader checks against it, `explain` prints
//! it, and a piece that is not built yet is marked here and nowhere else.

use Fallback::{Absent, Method, Needed, Value};
use Kind::{
    Bool, Choice, Count, Direction, Fraction, Length, NonNegative, Positive, Share, Table, Tables, Text, Vector,
};

/// What a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A string.
    Text,
    /// `true` or `false`.
    Bool,
    /// A whole number of at least the first, at most the second.
    Count(u32, u32),
    /// A length in metres greater than 0.
    Length,
    /// A number greater than 0.
    Positive,
    /// A number of at least 0.
    NonNegative,
    /// A number from 0 to below 1.
    Fraction,
    /// A number above 0, at most 1.
    Share,
    /// Three numbers.
    Vector,
    /// Three numbers, not all 0.
    Direction,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A table.
    Table,
    /// An array of tables.
    Tables,
}

/// What a key is when the file does not say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fallback {
    /// The file must say.
    Needed,
    /// This TOML value.
    Value(&'static str),
    /// From the method: accurate, published; the best of them that is built.
    Method(&'static str, &'static str),
    /// Nothing; the text says what then happens.
    Absent(&'static str),
}

/// A key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// Dotted, without indices and names: `turbulence.bands.scale`.
    pub path: &'static str,
    /// What it takes.
    pub kind: Kind,
    /// Without it.
    pub default: Fallback,
    /// Unit; empty for none.
    pub unit: &'static str,
    /// One line.
    pub help: &'static str,
}

/// `(key, value)` pairs that a scene may name but this version has not built; an empty value is any value.
/// When a piece lands, its line goes.
pub const NOT_BUILT: &[(&str, &str)] = &[("rods.internal_damping", ""), ("air.margin", ""), ("hair.file", "")];

const fn key(path: &'static str, kind: Kind, default: Fallback, unit: &'static str, help: &'static str) -> Key {
    Key { path, kind, default, unit, help }
}

/// As many as 32 bits count.
const ANY: u32 = u32::MAX;
/// Of a strand, which one lane walks along; software adapters end long loops (ARCHITECTURE.md).
pub(crate) const MOST_POINTS: u32 = 16_384;
/// Of what repeats within a step, each time with dispatches of its own: seconds a step.
const MOST_REPEATS: u32 = 10_000;

/// The table.
#[rustfmt::skip] // a key a line
pub const KEYS: &[Key] = &[
    key("title", Text, Value("\"\""), "", "free text, shown in reports"),
    key("method", Choice(&["accurate", "published"]), Value("\"accurate\""), "", "sets the defaults of six keys: rods.solver, rods.integrator, turbulence.law, .filter, .cutoff, viscosity.form"),
    key("gravity", Vector, Value("[0.0, -9.81, 0.0]"), "m/s²", "on hair only"),
    key("seed", Count(0, ANY), Value("1"), "", "draws root positions, length variation, curl phase, inflow turbulence"),
    key("time", Table, Needed, "", "step, duration, frames"),
    key("time.step", Positive, Needed, "s", "Δt"),
    key("time.substeps", Count(1, MOST_REPEATS), Value("1"), "", "whole steps of Δt/n per Δt; more where strands of very short segments need them"),
    key("time.duration", Positive, Needed, "s", "length of the run"),
    key("time.frame_rate", Positive, Value("60.0"), "1/s", "exported frames per second"),
    key("hair", Tables, Absent("no hair: a groom must be given"), "", "a group of strands; several as [[hair]], each with a name"),
    key("hair.name", Text, Value("\"hair\""), "", "for dotted keys and reports"),
    key("hair.strands", Count(1, ANY), Needed, "", "number of strands"),
    key("hair.points", Count(2, MOST_POINTS), Needed, "", "per strand, root included"),
    key("hair.length", Length, Needed, "m", "of a strand, along its curl"),
    key("hair.length_variation", Fraction, Value("0.0"), "", "strands are shorter by up to this fraction, at random"),
    key("hair.radius", Length, Value("4.0e-5"), "m", "of a fibre, at the root"),
    key("hair.taper", Fraction, Value("0.0"), "", "the tip's radius is radius (1 - taper)"),
    key("hair.aspect", Share, Value("1.0"), "", "semi-minor over semi-major axis of a fibre's cross-section; the radius is the semi-major one, a curl bends the flat way"),
    key("hair.density", Positive, Value("1320.0"), "kg/m³", "of a fibre"),
    key("hair.fibres_per_strand", Positive, Value("1.0"), "", "real hairs that a strand stands for"),
    key("hair.youngs_modulus", Positive, Value("4.0e9"), "Pa", "E of the fibre; not with the three stiffnesses"),
    key("hair.poissons_ratio", Fraction, Value("0.38"), "", "G = E/(2 (1 + ν)), GA = EA/(2 (1 + ν))"),
    key("hair.stretch_stiffness", Positive, Absent("from youngs_modulus"), "N", "EA of the strand; the three stiffnesses go together"),
    key("hair.bend_stiffness", Positive, Absent("from youngs_modulus"), "N m²", "EI of the strand"),
    key("hair.twist_stiffness", Positive, Absent("from youngs_modulus"), "N m²", "GJ of the strand"),
    key("hair.point_mass", Positive, Absent("half of each adjoining segment's mass"), "kg", "of every point; the paper: 1.46e-7"),
    key("hair.curl", Table, Absent("straight"), "", "helical rest shape, right-handed about the strand's axis"),
    key("hair.curl.radius", Length, Needed, "m", "of the helix"),
    key("hair.curl.pitch", Length, Needed, "m", "advance per turn"),
    key("hair.curl_phase", NonNegative, Value("1.0"), "turns", "spread of the helices' phases over the strands"),
    key("hair.root", Choice(&["clamped", "pinned", "free"]), Value("\"clamped\""), "", "held in place and direction, in place, not at all"),
    key("hair.tip", Choice(&["clamped", "pinned", "free"]), Value("\"free\""), "", "the same; clamped: with rods.solver = \"direct\""),
    key("hair.roots", Table, Needed, "", "where the strands are rooted"),
    key("hair.roots.shape", Choice(&["disc", "sphere_cap", "line"]), Value("\"disc\""), "", "roots are drawn on it"),
    key("hair.roots.center", Vector, Needed, "m", "of the shape"),
    key("hair.roots.radius", Length, Needed, "m", "of the disc or cap; half length of the line"),
    key("hair.roots.direction", Direction, Value("[0.0, -1.0, 0.0]"), "", "strands start along it"),
    key("hair.roots.normal", Direction, Absent("direction"), "", "of the disc, or the line: strands lean where it is not the direction"),
    key("hair.file", Text, Absent("strands are drawn"), "", "a groom from a file"),
    key("hair.motion", Tables, Absent("roots rest"), "", "keyframes of the roots"),
    key("hair.motion.time", NonNegative, Needed, "s", "of the keyframe; each later than the one before"),
    key("hair.motion.translation", Vector, Value("[0.0, 0.0, 0.0]"), "m", "of all roots, from where they are drawn; tips that are held stay"),
    key("hair.motion.rotation", Vector, Value("[0.0, 0.0, 0.0]"), "rad", "rotation vector, axis times angle, about roots.center"),
    key("body", Tables, Absent("no bodies"), "", "hair and air stay out of it; several as [[body]], each with a name"),
    key("body.name", Text, Value("\"body\""), "", "for dotted keys and errors"),
    key("body.shape", Choice(&["sphere", "capsule"]), Value("\"sphere\""), "", "with center, or with start and end"),
    key("body.center", Vector, Absent("needed with shape sphere"), "m", "of the sphere"),
    key("body.start", Vector, Absent("needed with shape capsule"), "m", "of the capsule's axis"),
    key("body.end", Vector, Absent("needed with shape capsule"), "m", "of the capsule's axis"),
    key("body.radius", Length, Needed, "m", "of the sphere; about the capsule's axis"),
    key("body.friction", NonNegative, Value("0.3"), "", "Coulomb's coefficient of hair on it"),
    key("body.motion", Tables, Absent("it rests"), "", "keyframes"),
    key("body.motion.time", NonNegative, Needed, "s", "of the keyframe; each later than the one before"),
    key("body.motion.translation", Vector, Value("[0.0, 0.0, 0.0]"), "m", "from where it is written"),
    key("body.motion.rotation", Vector, Value("[0.0, 0.0, 0.0]"), "rad", "rotation vector, axis times angle, about its centre"),
    key("air", Table, Absent("with model none only"), "", "wind and air particles"),
    key("air.box", Table, Absent("needed with model particles"), "", "periodic box of air"),
    key("air.box.min", Vector, Needed, "m", "lower corner"),
    key("air.box.max", Vector, Needed, "m", "upper corner"),
    key("air.rest_density", Positive, Value("1.29"), "kg/m³", "ρ0"),
    key("air.particle_mass", Positive, Value("1.46e-7"), "kg", "the count is rounded, and this adjusted so that the mean density is exact"),
    key("air.kernel_radius", Length, Value("9.3e-3"), "m", "h"),
    key("air.wind", Vector, Absent("needed with models particles and drag"), "m/s", "mean wind U"),
    key("air.fringe", NonNegative, Absent("4 kernel radii"), "m", "thickness in which entering air is conditioned; 0: none"),
    key("air.ramp", NonNegative, Value("0.05"), "s", "the wind rises over this; 0: at once"),
    key("air.margin", Length, Absent("the whole box"), "m", "cut the box to the hair's reach plus this"),
    key("air.kinematic_viscosity", Positive, Value("1.5e-5"), "m²/s", "ν of the drag on segments; real air"),
    key("air.gust", Tables, Absent("no gusts"), "", "keyframes of what is added to the wind: linear between them, held before and after"),
    key("air.gust.time", NonNegative, Needed, "s", "of the keyframe; each later than the one before"),
    key("air.gust.velocity", Vector, Needed, "m/s", "added to air.wind"),
    key("air.inflow", Table, Absent("smooth wind"), "", "turbulence that enters with the wind"),
    key("air.inflow.intensity", NonNegative, Needed, "", "rms of a velocity component over the wind's speed"),
    key("air.inflow.scale", Length, Needed, "m", "size of its eddies, s of a band"),
    key("air.inflow.seed", Count(0, ANY), Absent("seed"), "", "draws its waves"),
    key("interaction", Table, Absent("model particles"), "", "how hair and air meet"),
    key("interaction.model", Choice(&["particles", "two-way", "drag", "none"]), Value("\"particles\""), "", "one fluid of particles; hair and air particles that exchange drag; lift and drag; hair alone"),
    key("interaction.lift", NonNegative, Value("0.0"), "", "C_l, lift coefficient of a segment across the wind"),
    key("fluid", Table, Absent("its defaults"), "", "density constraint (eq. 1)"),
    key("fluid.iterations", Count(0, MOST_REPEATS), Value("2"), "", "Jacobi iterations"),
    key("fluid.relaxation", Positive, Value("0.5"), "", "fraction of a Jacobi step"),
    key("fluid.tension", NonNegative, Value("0.0"), "", "share of negative C let through"),
    key("turbulence", Table, Absent("no confinement"), "", "vorticity confinement (eqs. 2-6)"),
    key("turbulence.bands", Tables, Absent("no confinement"), "", "bands to strengthen"),
    key("turbulence.bands.scale", Length, Needed, "m", "s of the Mexican hat"),
    key("turbulence.bands.strength", NonNegative, Value("3.0"), "", "S of the band law; the published law has a strength of its own. 0 leaves the band out"),
    key("turbulence.bands.intensity", Positive, Value("0.3"), "", "I of the band law: the band's largest speed over turbulence.speed"),
    key("turbulence.speed", NonNegative, Absent("the largest wind"), "m/s", "U of the law"),
    key("turbulence.law", Choice(&["band", "published"]), Method("\"band\"", "\"published\""), "", "the confinement law"),
    key("turbulence.filter", Choice(&["grid", "direct"]), Method("\"grid\"", "\"direct\""), "", "how the band velocity is found; law published takes direct only"),
    key("turbulence.order", Choice(&["cic", "tsc", "cubic"]), Value("\"cubic\""), "", "of the grid filter's B-spline: linear, quadratic, cubic"),
    key("turbulence.spacing", Positive, Value("0.55"), "", "of the grid filter's nodes, in units of the scale, at most 1; never more than a kernel radius"),
    key("turbulence.cutoff", Positive, Method("4.5", "3.0"), "", "of the direct filter, in units of the scale"),
    key("turbulence.normalise", Bool, Value("false"), "", "divide by the smoothed volume fraction, for air with holes; grid filter only"),
    key("turbulence.conserve_momentum", Bool, Absent("true with law band, false with published"), "", "take the mean change of the air out"),
    key("viscosity", Table, Absent("its defaults"), "", "XSPH (eqs. 7, 8)"),
    key("viscosity.hair", NonNegative, Value("1.4"), "", "c of hair, per step as written"),
    key("viscosity.air", NonNegative, Value("0.014"), "", "c of air, per step as written"),
    key("viscosity.kinematic_hair", NonNegative, Absent("from viscosity.hair"), "m²/s", "instead of hair: c = 22 ν Δt/h²"),
    key("viscosity.kinematic_air", NonNegative, Absent("from viscosity.air"), "m²/s", "instead of air: c = 22 ν Δt/h²"),
    key("viscosity.form", Choice(&["limited", "published"]), Method("\"limited\"", "\"published\""), "", "with or without the symmetric limiter"),
    key("rods", Table, Absent("its defaults"), "", "Cosserat rods"),
    key("rods.solver", Choice(&["direct", "gauss-seidel"]), Method("\"direct\"", "\"gauss-seidel\""), "", "the solver"),
    key("rods.integrator", Choice(&["bdf2", "euler"]), Method("\"bdf2\"", "\"euler\""), "", "the time integration"),
    key("rods.iterations", Count(1, MOST_REPEATS), Value("10"), "", "sweeps; gauss-seidel only"),
    key("rods.newton", Count(1, 100), Value("4"), "", "Newton steps at most; direct only: a strand stops when its segments fit within 1e-5"),
    key("rods.inextensible", Bool, Value("false"), "", "no stretch compliance"),
    key("rods.damping", NonNegative, Value("0.0"), "1/s", "of absolute linear and angular velocity"),
    key("rods.internal_damping", NonNegative, Absent("0"), "s", "Kelvin-Voigt"),
    key("rods.sleep", Bool, Value("true"), "", "strands at rest that nothing pushes are left alone (error below 1e-4 of their length)"),
    key("camera", Table, Absent("its defaults"), "", "where pictures are taken from"),
    key("camera.eye", Vector, Absent("frames the hair"), "m", "where it stands; eye and target go together"),
    key("camera.target", Vector, Absent("frames the hair"), "m", "what it looks at"),
    key("camera.fov", Positive, Value("26.0"), "°", "vertical field of view, below 180"),
    key("camera.width", Count(16, ANY), Value("960"), "px", "of a picture"),
    key("camera.height", Count(16, ANY), Value("540"), "px", "of a picture"),
    key("picture", Table, Absent("its defaults"), "", "what pictures show"),
    key("picture.hairs", Count(1, ANY), Value("20000"), "", "hairs drawn in all, interpolated from the strands"),
    key("picture.air", Choice(&["none", "vorticity", "band_energy"]), Value("\"none\""), "", "air particles, coloured by what"),
];

impl Key {
    /// The key of a dotted path without indices and names.
    #[must_use]
    pub fn find(path: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.path == path)
    }

    /// Whether this version has not built what the value asks for.
    #[must_use]
    pub fn not_built(path: &str, value: &str) -> bool {
        NOT_BUILT.iter().any(|(key, unbuilt)| *key == path && (unbuilt.is_empty() || *unbuilt == value))
    }

    /// The TOML value that a file without the key has; `None` where there is none. Of the two methods' defaults the
    /// accurate one gives way to the published while it is not built.
    #[must_use]
    pub fn default_of(&self, accurate: bool) -> Option<&'static str> {
        match self.default {
            Needed | Absent(_) => None,
            Value(text) => Some(text),
            Method(best, _) if accurate && !self.lacks(best.trim_matches('"')) => Some(best),
            Method(_, published) => Some(published),
        }
    }

    /// Whether just this value is not built.
    fn lacks(&self, value: &str) -> bool {
        NOT_BUILT.contains(&(self.path, value))
    }

    /// What was expected, for an error.
    #[must_use]
    pub fn expected(&self) -> String {
        let expected = self.kind.expected();
        // A length says that it is in metres.
        if self.unit.is_empty() || self.kind == Length { expected } else { format!("{expected} [{}]", self.unit) }
    }
}

impl Kind {
    /// What was expected, for an error.
    #[must_use]
    pub fn expected(self) -> String {
        match self {
            Text => "a string".to_owned(),
            Bool => "true or false".to_owned(),
            Count(least, most) => format!("a whole number of at least {least}, at most {most}"),
            Length => "a length in metres greater than 0".to_owned(),
            Positive => "a number greater than 0".to_owned(),
            NonNegative => "a number of at least 0".to_owned(),
            Fraction => "a number from 0 to below 1".to_owned(),
            Share => "a number above 0, at most 1".to_owned(),
            Vector => "three numbers, [x, y, z]".to_owned(),
            Direction => "three numbers, [x, y, z], not all 0".to_owned(),
            Choice(words) => {
                format!("one of {}", words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", "))
            }
            Table => "a table".to_owned(),
            Tables => "a table or an array of tables".to_owned(),
        }
    }
}

/// Every key: type and unit, default, meaning, and what of it this version has not built.
#[must_use]
pub fn explain() -> String {
    KEYS.iter().map(explained).collect()
}

fn explained(key: &Key) -> String {
    let default = match key.default {
        Needed => "needed".to_owned(),
        Value(value) => format!("default {value}"),
        Absent(without) => format!("without it: {without}"),
        Method(accurate, published) => {
            let by_method = format!("default {accurate} (accurate), {published} (published)");
            match key.default_of(true) {
                Some(now) if now != accurate => format!("{by_method}; now {now}"),
                _ => by_method,
            }
        }
    };
    let unbuilt: Vec<_> = NOT_BUILT.iter().filter(|(path, _)| *path == key.path).map(|(_, value)| *value).collect();
    let unbuilt = match unbuilt[..] {
        [] => String::new(),
        [""] => "; not in this version".to_owned(),
        _ => format!("; not in this version: {}", unbuilt.join(", ")),
    };
    match key.kind {
        Table | Tables => format!("\n{:<27} {}; {default}{unbuilt}\n", format!("[{}]", key.path), key.help),
        _ => format!("{:<27} {}; {default}{unbuilt}\n{:<29} {}\n", key.path, key.expected(), "", key.help),
    }
}
