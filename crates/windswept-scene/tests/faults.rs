//! Each fault names its line and key and says what was expected.

use crate::common::{QUICK, load, parse, parse_with};
use windswept_scene::{Air, Body, CheckedScene, Hair, InitialState, Keyframe, Roots, Scene, SceneError, Time};

const SMALL: &str = "\
[time]
step = 1.38e-3
duration = 1.0
[hair]
strands = 3
points = 4
length = 0.1
[hair.roots]
center = [0.05, 0.05, 0.05]
radius = 0.01
[air]
box = { min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }
wind = [3.0, 0.0, 0.0]
";

/// Replaced text, its replacement, then line, key and words of the error.
#[rustfmt::skip] // a fault a line
const FAULTS: &[(&str, &str, usize, &str, &[&str])] = &[
    ("length = 0.1", "lenght = 0.1", 7, "hair.lenght", &["unknown key; did you mean hair.length?"]),
    ("[hair.roots]", "[hair.rots]", 8, "hair.rots", &["unknown key", "hair.roots"]),
    ("[time]", "[timing]", 1, "timing", &["unknown key"]),
    ("[air]", "[viscosity]\nair = -0.1\n[air]", 12, "viscosity.air", &["expected a number of at least 0, found -0.1"]),
    ("[time]", "banana = 1\n[time]", 1, "banana", &["unknown key", "--explain"]),
    ("[time]", "time.step = 1\n[time.step.more]", 2, "", &["not TOML"]),
    ("length = 0.1", "length = \"long\"", 7, "hair.length", &["expected a length in metres greater than 0, found \"long\""]),
    ("length = 0.1", "length = -0.1", 7, "hair.length", &["expected a length in metres greater than 0, found -0.1"]),
    ("length = 0.1", "length = 0.0", 7, "hair.length", &["greater than 0", "found 0.0"]),
    ("length = 0.1", "length = nan", 7, "hair.length", &["greater than 0", "found nan"]),
    ("length = 0.1", "length = -inf", 7, "hair.length", &["found -inf"]),
    ("length = 0.1", "length = 1e-300", 7, "hair.length", &["found 1e-300, a magnitude outside 1e-18 to 1e18"]),
    ("length = 0.1", "length = { m = 1 }", 7, "hair.length", &["found { m = 1 }"]),
    ("[hair.roots]", "[hair.radius]\n[hair.roots]", 8, "hair.radius", &["expected a length", "found a table"]),
    ("[hair.roots]", "[[hair.radius]]\n[hair.roots]", 8, "hair.radius", &["found an array of tables"]),
    ("[time]", "fluid = 3\n[time]", 1, "fluid", &["expected a table, found 3"]),
    ("[time]", "[[fluid]]\n[time]", 1, "fluid", &["expected a table, found an array of tables"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, nan, 0.0]", 13, "air.wind", &["expected three numbers, [x, y, z] [m/s]", "nan"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [1e20, 0, 0]", 13, "air.wind", &["three numbers, [x, y, z] [m/s], found in x 1e20, a magnitude outside 1e-18 to 1e18"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [0, 0, 9000000000000000000]", 13, "air.wind", &["found in z 9e18, a magnitude outside"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [0, 6000, -8001]", 13, "air.wind", &["expected at most 1e4 m/s, found 10000.8"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [0, 0, 0]\ngust = [{ time = 0, velocity = [0, 2e4, 0] }]", 14, "air.gust.0.velocity", &["expected at most 1e4 m/s, found 20000.0 m/s"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0, 0]\ninflow = { intensity = 1e18, scale = 0.05 }", 14, "air.inflow.intensity", &["expected at most 1e4 m/s, found 3e18 m/s"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0, 0]\ngust = [{ time = 1, velocity = [998, 0, 0] }]\ninflow = { intensity = 10, scale = 0.05 }", 15, "air.inflow.intensity", &["expected at most 1e4 m/s, found 10010.0 m/s"]),
    ("[air]", "[[force]]\nfield = \"point\"\norigin = [0, 0, 0]\nreach = 0.1\nstrength = -1e18\n[air]", 15, "force.strength", &["at most 1e4 m/s, found 1e18 m/s"]),
    ("[air]", "[[force]]\nfield = \"point\"\norigin = [0, 0, 0]\nreach = 0.1\nkeyframes = [{ time = 1, strength = 10001 }]\n[air]", 15, "force.keyframes.0.strength", &["at most 1e4 m/s, found 10001.0 m/s"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0.0]", 13, "air.wind", &["three numbers", "[3.0, 0.0]"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, \"a\", 0.0]", 13, "air.wind", &["three numbers", "found in y \"a\""]),
    ("wind = [3.0, 0.0, 0.0]", "", 11, "air.wind", &["is missing"]),
    ("box = {", "box2 = {", 12, "air.box2", &["did you mean air.box?"]),
    ("box = { min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }\n", "", 11, "air.box", &["is missing", "two-way"]),
    ("min = [0.0, 0.0, 0.0], ", "", 12, "air.box.min", &["is missing", "three numbers"]),
    ("points = 4", "points = 1", 6, "hair.points", &["whole number of at least 2", "found 1"]),
    ("points = 4", "points = 16385", 6, "hair.points", &["at least 2, at most 16384, found 16385"]),
    ("[air]", "[rods]\niterations = 10001\n[air]", 12, "rods.iterations", &["at most 10000"]),
    ("[air]", "[fluid]\niterations = 10001\n[air]", 12, "fluid.iterations", &["at most 10000"]),
    ("duration = 1.0", "duration = 1.0\nsubsteps = 10001", 4, "time.substeps", &["at most 10000"]),
    ("duration = 1.0", "duration = 1e4\nsubsteps = 1000", 3, "time.duration", &["7.246e9 steps, substeps included"]),
    ("points = 4", "points = 4.5", 6, "hair.points", &["whole number", "4.5"]),
    ("points = 4", "", 4, "hair.points", &["is missing", "whole number"]),
    ("strands = 3", "strands = 0", 5, "hair.strands", &["at least 1"]),
    ("strands = 3", "strands = 99999999999", 5, "hair.strands", &["whole number", "at most 16777216"]),
    ("strands = 3", "strands = 16000000", 5, "hair.strands", &["makes 64000000 hair points", "at most 16777216"]),
    ("[hair.roots]\ncenter = [0.05, 0.05, 0.05]\nradius = 0.01\n", "", 4, "hair.roots.center", &["is missing"]),
    ("max = [0.1, 0.1, 0.1]", "max = [0.1, 0.02, 0.1]", 12, "air.box", &["at least 3 kernel radii", "0.02 m in y"]),
    ("max = [0.1, 0.1, 0.1]", "max = [0.1, -0.1, 0.1]", 12, "air.box", &["max above min", "in y"]),
    ("max = [0.1, 0.1, 0.1]", "max = [100.0, 100.0, 100.0]", 12, "air.box", &["would hold 8.836e12 particles", "at most 50000000, with a spacing of at least"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0.0, 0.0]\nkernel_radius = 9.3e-3\nspacing = 0.0919", 12, "air.box", &["would hold 1.28841 particles", "at least 27, with a spacing of at most 0.0333333 m"]),
    ("max = [0.1, 0.1, 0.1]", "max = [0.1, 0.0278, 0.1]", 12, "air.box", &["at least 3 kernel radii, 0.0279 m; found 0.0278 m in y"]),
    // A grid that wraps or cannot be summed; a kernel that reaches no neighbour.
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0.0, 0.0]\nkernel_radius = 1e-6", 14, "air.kernel_radius", &["makes 1.000e15 cells of the box", "at most 8e6"]),
    ("wind = [3.0, 0.0, 0.0]", "kernel_radius = 4.9e-4\nspacing = 2.756e-4\nwind = [3.0, 0.0, 0.0]", 13, "air.kernel_radius", &["makes 8.490e6 cells", "at most 8e6, about 0.0004998 m"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0.0, 0.0]\nkernel_radius = 5.8e-3", 14, "air.kernel_radius", &["is 1.199 of the particle spacing, 0.00483713 m", "at least 1.2 of it, 0.00580456 m"]),
    ("step = 1.38e-3", "", 1, "time.step", &["is missing", "greater than 0 [s]"]),
    ("duration = 1.0", "duration = true", 3, "time.duration", &["greater than 0", "true"]),
    ("duration = 1.0", "duration = 2026-01-01", 3, "time.duration", &["a date"]),
    ("duration = 1.0", "duration = 1e9", 3, "time.duration", &["7.246e11 steps", "at most"]),
    ("duration = 1.0", "duration = 1.0\nframe_rate = 1e12", 4, "time.frame_rate", &["1.000e12 frames", "at most"]),
    ("duration = 1.0", "duration = 1.0\nsubsteps = 0", 4, "time.substeps", &["at least 1"]),
    ("step = 1.38e-3", "step = ", 2, "", &["not TOML"]),
    ("duration = 1.0", "step = 2.0", 3, "", &["not TOML", "duplicate"]),
    ("radius = 0.01", "radius = 0.01\ndirection = [0, 0, 0]", 11, "hair.roots.direction", &["not all 0"]),
    ("radius = 0.01", "radius = 0.01\nnormal = [0, 0, 0]", 11, "hair.roots.normal", &["not all 0"]),
    ("radius = 0.01", "radius = 0.01\nshape = \"sphere_cap\"\nnormal = [0, 0, 1]", 12, "hair.roots.normal", &["goes with shape \"disc\": expected no such key with shape \"sphere_cap\""]),
    ("radius = 0.01", "radius = 0.01\nshape = \"square\"", 11, "hair.roots.shape", &["\"disc\", \"sphere_cap\", \"line\"", "square"]),
    ("length = 0.1", "length = 0.1\ntaper = 1.0", 8, "hair.taper", &["from 0 to below 1"]),
    ("length = 0.1", "length = 0.1\nlength_variation = -0.1", 8, "hair.length_variation", &["from 0 to below 1"]),
    ("length = 0.1", "length = 0.1\naspect = 1.5", 8, "hair.aspect", &["above 0, at most 1", "found 1.5"]),
    ("length = 0.1", "length = 0.1\naspect = 0.5\nstretch_stiffness = 20.0\nbend_stiffness = 1e-9\ntwist_stiffness = 1e-9", 8, "hair.aspect", &["stiffnesses are given"]),
    ("length = 0.1", "length = 0.1\nroot = \"glued\"", 8, "hair.root", &["\"clamped\", \"pinned\", \"free\""]),
    ("[hair]", "[rods]\nsolver = \"gauss-seidel\"\n[hair]\ntip = \"clamped\"", 7, "hair.tip", &["the direct solver"]),
    ("length = 0.1", "length = 0.1\nstretch_stiffness = 20.0", 4, "hair.bend_stiffness", &["is missing", "hair.twist_stiffness: is missing"]),
    ("length = 0.1", "length = 0.1\nyoungs_modulus = 4e9\nstretch_stiffness = 20.0", 8, "hair.youngs_modulus", &["goes with youngs_modulus: expected no such key with the three stiffnesses"]),
    ("length = 0.1", "length = 0.1\ncurl = { radius = 0.0, pitch = 0.1 }", 8, "hair.curl.radius", &["greater than 0"]),
    ("length = 0.1", "length = 0.1\ncurl = { radius = 0.1, pitch = -0.1 }", 8, "hair.curl.pitch", &["greater than 0"]),
    ("length = 0.1", "length = 0.1\ncurl = { radius = 0.1 }", 8, "hair.curl.pitch", &["is missing"]),
    ("[air]", "[viscosity]\nair = 0.1\nkinematic_air = 1e-5\n[air]", 13, "viscosity.kinematic_air", &["expected one of them"]),
    ("[air]", "[viscosity]\nsmagorinsky = 0.1\n[fluid]\nsolver = \"pbf\"\n[air]", 12, "viscosity.smagorinsky", &["expected 0: fluid.solver is \"pbf\""]),
    ("[air]", "[viscosity]\nkinematic_hair = 1e-5\nhair = 0.1\n[air]", 12, "viscosity.kinematic_hair", &["expected one of them"]),
    ("[air]", "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 190\n[air]", 14, "camera.0.fov", &["below 180"]),
    ("[air]", "[[camera]]\nname = \"a\"\n[[camera]]\nname = \"a\"\n[air]", 14, "camera.1.name", &["\"a\" a second time"]),
    ("[air]", "[camera]\neye = [0, 0, 1]\n[air]", 11, "camera.0.target", &["is missing"]),
    ("[air]", "[camera]\nwidth = 90\ntarget = [0, 0, 1]\n[air]", 11, "camera.0.eye", &["is missing"]),
    ("[air]", "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 1]\n[air]", 13, "camera.0.target", &["same point as camera.eye"]),
    ("[air]", "[picture]\nair = \"vorticity\"\n[interaction]\nmodel = \"drag\"\n[air]", 12, "picture.air", &["\"vorticity\" needs air particles"]),
    ("[air]", "[picture]\nair = \"vorticity\"\n[fluid]\niterations = 0\n[viscosity]\nhair = 0\nair = 0\n[air]", 12, "picture.air", &["needs particles that have neighbours"]),
    ("[air]", "[picture]\nair = \"band_energy\"\n[interaction]\nmodel = \"none\"\n[air]", 12, "picture.air", &["\"band_energy\" needs air particles"]),
    ("[air]", "[picture]\nair = \"band_energy\"\n[air]", 12, "picture.air", &["needs one of turbulence.bands strengthened"]),
    ("[air]", "[turbulence]\nbands = [{ scale = 0.01, strength = 0 }]\n[picture]\nair = \"band_energy\"\n[air]", 14, "picture.air", &["strengthened"]),
    ("[air]", "[turbulence]\nbands = [{ scale = 0.01 }]\nspeed = 0\n[picture]\nair = \"band_energy\"\n[air]", 15, "picture.air", &["a turbulence.speed"]),
    ("[air]", "[turbulence]\nbands = [{ scale = 0.01 }]\nscale = 0.02\n[air]", 13, "turbulence.scale", &["turbulence.bands is given too: expected one of them"]),
    ("[air]", "[turbulence]\nbands = [{ scale = 0.01 }]\nintensity = 1\n[air]", 13, "turbulence.intensity", &["expected turbulence.scale with it"]),
    ("[air]", "[turbulence]\ninflow = false\n[air]", 12, "turbulence.inflow", &["expected turbulence.scale with it"]),
    ("[air]", "[turbulence]\nscale = 0.02\nintensity = 1e18\n[air]", 13, "turbulence.intensity", &["expected at most 1e4 m/s"]),
    ("[air]", "[turbulence]\nscale = 1e-5\n[air]", 12, "turbulence.scale", &["can be sorted into"]),
    // Reserved, or asked for by name and not built.
    ("[air]", "[[hair.motion]]\ntime = -1\n[air]", 12, "hair.motion.0.time", &["at least 0 [s]"]),
    ("[air]", "[rods]\nnewton = 0\n[air]", 12, "rods.newton", &["at least 1, at most 100"]),
    // Force fields.
    ("[air]", "[[force]]\nfield = \"wind\"\n[air]", 12, "force.field", &["one of \"jet\", \"vortex\", \"point\""]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\nreach = 0.1\nstrength = 1\n[air]", 11, "force.axis", &["is missing: field \"jet\" has one"]),
    ("[air]", "[[force]]\nfield = \"point\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\nstrength = 1\n[air]", 14, "force.axis", &["expected no axis with field \"point\""]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [0, 0, 0]\n[air]", 14, "force.axis", &["not all 0"]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0\n[air]", 15, "force.reach", &["greater than 0, found 0"]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\nstrength = nan\n[air]", 16, "force.strength", &["expected a number [m/s], found nan"]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\n[air]", 11, "force.strength", &["is missing", "keyframes"]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\nstrength = 1\nkeyframes = [{ time = 0, strength = 1 }]\n[air]", 16, "force.strength", &["beside keyframes"]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\nkeyframes = [{ time = 2, strength = 1 }, { time = 1, strength = 2 }]\n[air]", 16, "force.keyframes.1.time", &["after that of the keyframe before, 2 s; found 1"]),
    ("[air]", "[[force]]\nfield = \"vortex\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\nradius = 0.06\nstrength = 1\n[air]", 16, "force.radius", &["at most half of reach, 0.05 m, with field \"vortex\"; found 0.06"]),
    ("[air]", "[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\nstrength = 1\n[[force]]\nfield = \"jet\"\norigin = [0, 0, 0]\naxis = [1, 0, 0]\nreach = 0.1\nstrength = 1\n[air]", 17, "force.1.name", &["a name of its own for each [[force]]"]),
    // Eddies and drag.
    ("[air]", "[interaction]\nlift = -2\n[air]", 12, "interaction.lift", &["at least 0, found -2"]),
    ("[air]", "[turbulence]\nbands = [{ scale = 0 }]\n[air]", 12, "turbulence.bands.0.scale", &["greater than 0"]),
    ("[air]", "[[turbulence.bands]]\nstrength = 2\n[air]", 11, "turbulence.bands.0.scale", &["is missing"]),
    ("[air]", "[turbulence]\nbands = [{ scale = 1, intensity = 0 }]\n[air]", 12, "turbulence.bands.0.intensity", &["greater than 0"]),
    ("[air]", "[turbulence]\nfilter = \"direct\"\nbands = [{ scale = 0.5 }]\n[air]", 13, "turbulence.bands.0.scale", &["pairs a step", "expected at most about", "filter = \"grid\""]),
    ("[air]", "[turbulence]\nbands = [{ scale = 1e-4 }]\n[air]", 12, "turbulence.bands.0.scale", &["nodes, at most 8.4e6 can be sorted into", "expected at least about"]),
    ("[air]", "[turbulence]\nspacing = 1.5\n[air]", 12, "turbulence.spacing", &["at most 1 scales, found 1.5"]),
    ("[air]", "[turbulence]\nlaw = \"published\"\nfilter = \"grid\"\n[air]", 13, "turbulence.filter", &["expected \"direct\" with turbulence.law"]),
    ("[air]", "[turbulence]\ncutoff = nan\n[air]", 12, "turbulence.cutoff", &["found nan"]),
    ("[air]", "[turbulence]\nlaw = \"bands\"\n[air]", 12, "turbulence.law", &["\"band\", \"published\""]),
    ("[air]", "[turbulence]\nbands = [3]\n[air]", 12, "turbulence.bands", &["array of tables", "found 3 in it"]),
    ("[air]", "[air]\nmargin = -0.1", 12, "air.margin", &["at least 0", "found -0.1"]),
    ("[air]", "[[air.gust]]\nvelocity = [1, 0, 0]\n[air]", 11, "air.gust.0.time", &["is missing"]),
    ("[air]", "[air.inflow]\nscale = 0.01\n[air]", 11, "air.inflow.intensity", &["is missing"]),
    ("[air]", "[air.inflow]\nscale = 0\nintensity = 0.1\n[air]", 12, "air.inflow.scale", &["greater than 0"]),
    ("[air]", "[[air.gust]]\ntime = 1\nvelocity = [0, 0, 0]\n[[air.gust]]\ntime = 1\nvelocity = [0, 0, 0]\n[air]", 15, "air.gust.1.time", &["after that of the keyframe before, 1 s"]),
    ("[air]", "[camra]\nfov = 30\n[air]", 11, "camra", &["unknown key", "did you mean camera?"]),
    ("[air]", "[forces]\nfield = \"jet\"\n[air]", 11, "forces", &["unknown key", "did you mean force?"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0.0, 0.0]\nparticle_mass = 1e-7", 14, "air.particle_mass", &["unknown key", "air.spacing says how fine the air is"]),
    ("wind = [3.0, 0.0, 0.0]", "wind = [3.0, 0.0, 0.0]\nkernel_radius = 9.3e-3\nspacing = 4.8", 12, "air.box", &["would hold 0.00000904225 particles", "at most 0.0333333 m"]),
    // Bodies and their motion.
    ("[air]", "[[body]]\n[air]", 11, "body.center", &["is missing: expected three numbers", "body.radius: is missing"]),
    ("[air]", "[[body]]\nradius = 0.02\n[air]", 11, "body.center", &["is missing: expected three numbers"]),
    ("[air]", "[[body]]\nshape = \"cube\"\n[air]", 12, "body.shape", &["one of \"sphere\", ", ", found \"cube\""]),
    ("[air]", "[[body]]\nradius = 0\n[air]", 12, "body.radius", &["greater than 0"]),
    ("[air]", "[[body]]\nradius = 0.02\nshape = \"capsule\"\ncenter = [0, 0, 0]\n[air]", 14, "body.center", &["goes with shape \"sphere\": expected no such key with shape \"capsule\""]),
    ("[air]", "[[body]]\nradius = 0.02\ncenter = [0, 0, 0]\nend = [0, 0, 1]\n[air]", 14, "body.end", &["goes with shape \"capsule\": expected no such key with shape \"sphere\""]),
    ("[air]", "[[body]]\nradius = 0.02\nshape = \"capsule\"\nend = [0, 0, 1]\n[air]", 11, "body.start", &["is missing: expected three numbers"]),
    ("[air]", "[[body]]\nradius = 0.02\nshape = \"capsule\"\nstart = [0, 0, 1]\nend = [0, 0, 1]\n[air]", 15, "body.end", &["same point as start", "shape \"sphere\""]),
    ("[air]", "[[body]]\nshape = \"box\"\ncenter = [0, 0, 0]\nsize = [1, 0, 1]\n[air]", 14, "body.size", &["is [1.0, 0.0, 1.0]; expected three lengths in metres greater than 0"]),
    ("[air]", "[[body]]\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]\n[air]", 14, "body.normal", &["three numbers, [x, y, z], not all 0"]),
    ("[air]", "[[body]]\nradius = 0.02\ncenter = [0, 0, 0]\nfriction = -1\n[air]", 14, "body.friction", &["at least 0"]),
    ("[air]", "[[body]]\nradius = 0.06\ncenter = [0.05, 0.05, 0.05]\n[air]", 11, "body", &["block 96 % of air.box across x"]),
    ("[air]", "[[body]]\nradius = 0.01\ncenter = [0, 0, 0]\nmotion = [{ time = -1 }]\n[air]", 14, "body.motion.0.time", &["at least 0 [s]"]),
    ("[air]", "[[body]]\nradius = 0.01\ncenter = [0, 0, 0]\n[[body.motion]]\n[air]", 14, "body.motion.0.time", &["is missing"]),
    ("[air]", "[[body]]\nradius = 0.01\ncenter = [0, 0, 0]\nmotion = [{ time = 1 }, { time = 1 }]\n[air]", 14, "body.motion.1.time", &["after that of the keyframe before, 1 s; found 1"]),
    ("[air]", "[[body]]\nradius = 0.01\ncenter = [0, 0, 0]\n[[body.motion]]\ntime = 0\n[[body.motion]]\ntime = 1\nrotation = [0, 3.2, 0]\n[air]", 18, "body.motion.1.rotation", &["by 3.2000 rad", "less than half a turn"]),
];

#[test]
fn each_fault_names_its_line_and_key() {
    parse(SMALL).unwrap();
    for (old, new, line, key, words) in FAULTS {
        let text = SMALL.replacen(old, new, 1);
        assert_ne!(text, SMALL, "{old} is not in the scene");
        let error = parse_with("bad.toml", &text, &[]).expect_err(new);
        let shown = error.to_string();
        assert_eq!(error.line(), Some(*line), "{new}: {shown}");
        assert_eq!(error.key().unwrap_or_default(), *key, "{new}: {shown}");
        assert!(shown.starts_with(&format!("bad.toml:{line}: {key}")), "{shown}");
        for word in *words {
            assert!(shown.contains(word), "{new}: no \"{word}\" in: {shown}");
        }
        assert_eq!((error.source_name(), error.source_text()), ("bad.toml", text.as_str()));
        assert!(error.span().is_some_and(|span| text.get(span).is_some()), "{new}");
    }
}

/// No [air] at all: there is no line to point at.
#[test]
fn models_say_what_they_need() {
    let (airless, _) = SMALL.split_once("[air]").unwrap();
    let error = parse_with("bad.toml", airless, &[]).unwrap_err();
    assert_eq!((error.key(), error.line()), (Some("air"), None));
    assert!(error.to_string().contains("\"two-way\" needs air.box and air.wind"), "{error}");
    parse_with("s", airless, &["interaction.model=none".to_owned()]).unwrap();
}

/// `group` replaces [hair], and a second one stands before [air].
fn two_groups(first: &str, second: &str) -> Result<CheckedScene, SceneError> {
    let roots = "roots = { center = [0, 0, 0], radius = 0.1 }";
    let first = SMALL.replace("[hair]", &format!("[[hair]]\n{first}"));
    parse(&first.replace("[air]", &format!("[[hair]]\n{second}\npoints = 2\nlength = 0.1\n{roots}\n[air]")))
}

#[test]
fn groups_have_names_and_faults_of_their_own() {
    let scene = two_groups("name = \"a\"", "name = \"b\"\nstrands = 1").unwrap();
    assert_eq!(scene.hair.iter().map(|hair| hair.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    for (first, second, key, line, word) in [
        ("name = \"a\"", "name = \"a\"\nstrands = 1", "hair.1.name", 13, "\"a\" a second time"),
        ("", "strands = 1", "hair.1.name", 12, "a name of its own for each [[hair]]"),
        ("name = \"a\"", "name = \"b\"", "hair.b.strands", 12, "is missing"),
        ("name = \"a\"", "name = \"b\"\nstrand = 1", "hair.b.strand", 14, "did you mean hair.strands?"),
        ("radius = 0", "strands = 1", "hair.0.radius", 5, "greater than 0"),
    ] {
        let error = two_groups(first, second).unwrap_err();
        assert_eq!((error.key(), error.line()), (Some(key), Some(line)), "{error}");
        assert!(error.to_string().contains(word), "{error}");
    }
    // A name that is the index of the other group leads to its own.
    let text = two_groups("name = \"1\"", "name = \"fringe\"\nstrands = 1").unwrap().scene().text().to_owned();
    let error = parse(&text.replacen("length = 0.1\n", "", 1)).unwrap_err();
    assert_eq!((error.key(), error.line()), (Some("hair.1.length"), Some(4)), "{error}");
    // Two tables [hair] are two of [[hair]], which TOML does not say.
    let error = parse(&format!("{SMALL}\n[hair]\nstrands = 1\n")).unwrap_err().to_string();
    assert!(
        error.contains("duplicate key") && error.contains("several of them are [[hair]] each, with a name"),
        "{error}"
    );
    // A lone [[hair]] needs no index.
    let error = parse(&SMALL.replace("[hair]", "[[hair]]").replace("points = 4", "points = 1")).unwrap_err();
    assert_eq!(error.key(), Some("hair.points"));
}

fn set(text: &str, assignments: &[&str]) -> Result<CheckedScene, SceneError> {
    let assignments: Vec<String> = assignments.iter().map(|&set| set.to_owned()).collect();
    parse_with("quick.toml", text, &assignments)
}

#[test]
fn an_assignment_changes_its_key() {
    assert_eq!(set(QUICK, &["hair.length=0.2"]).unwrap().hair[0].as_drawn().unwrap().length, 0.2);
    assert_eq!(set(QUICK, &["hair.0.length = 0.2"]).unwrap().hair[0].as_drawn().unwrap().length, 0.2);
    assert_eq!(set(QUICK, &["hair.length=0.2", "hair.length=0.3"]).unwrap().hair[0].as_drawn().unwrap().length, 0.3);
    assert_eq!(set(QUICK, &["air.box.max=[0.2,0.12,0.07]"]).unwrap().air.as_ref().unwrap().bounds.unwrap().max[0], 0.2);
    assert_eq!(set(QUICK, &["method=published"]).unwrap().method, windswept_scene::Method::Published);
    assert_eq!(set(QUICK, &["title=\"a = b\""]).unwrap().title, "a = b");
    assert_eq!(set(QUICK, &["camera.eye=[0,0,1]", "camera.target=[0,0,0]"]).unwrap().cameras[0].width, 960);
    let text = set(QUICK, &["hair.length=0.2"]).unwrap().scene().text().to_owned();
    assert_eq!(text.lines().count(), QUICK.lines().count());
    assert!(text.contains("length = 0.2                       # m, along the curl"), "comments are kept: {text}");
}

#[test]
fn a_group_is_addressed_by_its_name() {
    let one = SMALL.replace("[hair]", "[[hair]]\nname = \"fringe\"");
    assert_eq!(set(&one, &["hair.fringe.radius=5e-5"]).unwrap().hair[0].fibre.radius, 5e-5);
    assert_eq!(set(&one, &["hair.radius=5e-5"]).unwrap().hair[0].fibre.radius, 5e-5);
    // A group without a name is called what the table of keys says.
    for text in [SMALL, &SMALL.replace("[hair]", "[[hair]]")] {
        assert_eq!(set(text, &["hair.hair.radius=1e-5"]).unwrap().hair[0].fibre.radius, 1e-5);
        assert!(set(text, &["hair.hair.roots.radius=0.002"]).unwrap().scene().to_toml().contains("radius = 0.002\n"));
    }
    let shown = set(&one, &["hair.hair.radius=1e-5"]).unwrap_err().to_string();
    assert!(shown.contains("hair.fringe.hair: unknown key"), "{shown}");
    let shown = set(SMALL, &["air.hair.wind=[1,0,0]"]).unwrap_err().to_string();
    assert!(shown.contains("air.hair: unknown key"), "{shown}");
    let two = two_groups("name = \"a\"", "name = \"b\"\nstrands = 1").unwrap().scene().text().to_owned();
    let scene = set(&two, &["hair.b.radius=5e-5", "hair.0.radius=6e-5"]).unwrap();
    assert_eq!(scene.hair.iter().map(|hair| hair.fibre.radius).collect::<Vec<_>>(), [6e-5, 5e-5]);
    let shown = set(&two, &["hair.radius=5e-5"]).unwrap_err().to_string();
    assert!(
        shown.contains("leads nowhere") && shown.contains("there are several [[hair]]: hair.a.radius or hair.b.radius"),
        "{shown}"
    );
    for (text, assignment) in
        [(&one, "hair.fringe.friction=-1"), (&two, "hair.b.friction=-1"), (&two, "hair.b.frition=1")]
    {
        let error = set(text, &[assignment]).unwrap_err();
        let key = assignment.split('=').next();
        assert_eq!(error.key(), key, "{error}");
        assert!(error.to_string().starts_with(&format!("--set {assignment}: {}: ", key.unwrap())), "{error}");
    }
}

/// A fault that comes with an assignment names the assignment; a fault in the file names the file.
#[test]
fn the_guilty_assignment_is_named() {
    let harmless = "title=x";
    for (guilty, words) in [
        ("hair.lenght=0.2", "hair.lenght: unknown key; did you mean hair.length?"),
        ("hair.length=-1", "greater than 0, found -1"),
        ("hair.length", "expected key=value"),
        ("=3", "expected a dotted key"),
        ("hair..radius=3", "expected a dotted key"),
        ("hair.length=[1,", "[1, is not a TOML value"),
        ("title=it's", "it's is not a TOML value"),
        ("method=exact", "one of \"accurate\", \"published\""),
        ("hair.nobody.radius=1e-5", "hair.nobody: unknown key"),
        ("hair.5.radius=1e-5", "hair.5: unknown key"),
        ("turbulence.bands.0.scale=-0.006", "greater than 0, found -0.006"),
        ("air.box.max.0=3", "leads nowhere"),
        // The key at fault is another than the one that was set.
        ("air.kernel_radius=0.1", "air.box: expected sides of at least 3 kernel radii"),
        ("air.spacing=9.19e-5", "air.box: would hold"),
        ("time.step=1e-12", "time.duration: would take"),
    ] {
        let error = set(QUICK, &[harmless, guilty, harmless]).unwrap_err();
        let shown = error.to_string();
        assert!(shown.starts_with(&format!("--set {guilty}: ")) && shown.contains(words), "{guilty}: {shown}");
        assert_eq!((error.line(), error.source_text()), (None, guilty), "{shown}");
        assert_eq!(error.span(), Some(0..guilty.len()));
    }
    let broken = QUICK.replace("points = 11", "points = 1");
    let line = broken.lines().position(|line| line.starts_with("points = 1 ")).unwrap() + 1;
    let shown = set(&broken, &[harmless, "hair.length=0.2"]).unwrap_err().to_string();
    assert!(shown.starts_with(&format!("quick.toml:{line}: hair.points: ")), "{shown}");
    let garbage = set("[time", &[harmless]).unwrap_err().to_string();
    assert!(garbage.starts_with("quick.toml:1: not TOML"), "{garbage}");
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = std::env::temp_dir().join(format!("windswept-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (binary, windows) = (folder.join("binary.toml"), folder.join("windows.toml"));
    std::fs::write(&binary, [0xff, 0xfe, 0x00]).unwrap();
    std::fs::write(&windows, format!("\u{feff}{}", SMALL.replace('\n', "\r\n"))).unwrap();
    for path in [&binary, &folder, &folder.join("absent.toml")] {
        let shown = load(path).unwrap_err().to_string();
        assert!(shown.starts_with(&format!("{}: cannot be read: ", path.display())), "{shown}");
    }
    assert_eq!(load(&windows).unwrap(), parse(SMALL).unwrap());
    let shown =
        Scene::load_with(&windows, &["points=3".to_owned()]).and_then(|scene| scene.check()).unwrap_err().to_string();
    assert!(shown.starts_with("--set points=3: points: unknown key"), "{shown}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_scene_without_hair_parses_and_one_with_nothing_cannot_start() {
    let (head, rest) = SMALL.split_once("[hair]").unwrap();
    let (_, air) = rest.split_once("[air]").unwrap();
    let bald = parse(&format!("{head}[air]{air}")).unwrap();
    assert!(InitialState::new(&bald).unwrap().hair.is_empty());
    let nothing = parse(&format!("interaction.model = \"none\"\n{head}")).unwrap();
    let error = InitialState::new(&nothing).unwrap_err();
    assert_eq!(error.key(), Some("hair"), "{error}");
}

/// A side of exactly three kernel radii is taken wherever the box stands, though max - min is rounded; so is the
/// smallest kernel.
#[test]
fn a_box_of_three_kernel_radii_will_do() {
    let sides = [("min", 0.0), ("min", 1.1), ("min", -7.3), ("min", 100.0)].map(|(_, min)| (min, min + 3.0 * 9.3e-3));
    assert!(sides.iter().any(|(min, max)| max - min < 3.0 * 9.3e-3), "none is rounded down");
    for (min, max) in sides {
        let bounds = format!("air.box={{min=[0,{min:?},0], max=[0.1,{max:?},0.1]}}");
        set(SMALL, &[&bounds]).unwrap_or_else(|error| panic!("{error}"));
    }
    set(SMALL, &["air.kernel_radius=0.00580456"]).unwrap();
    set(SMALL, &["air.kernel_radius=5.0e-4", "air.spacing=2.756e-4"]).unwrap();
}

/// More tables than there may be are refused by their number, before any of them is looked at: the fault in each is not
/// found.
#[test]
fn tables_are_counted_before_they_are_looked_at() {
    for (table, words) in [
        ("hair", "hair: expected at most 4096 groups of strands, found 5000"),
        ("body", "body: expected at most 1024 bodies, found 5000"),
        ("force", "force: expected at most 256 force fields, found 5000"),
        ("turbulence.bands", "turbulence.bands: expected at most 1024 bands, found 5000"),
    ] {
        let headed = format!("[[{table}]]\nbanana = 1\n").repeat(5000);
        let inline = format!("{table} = [{}]\n", "{ banana = 1 }, ".repeat(5000));
        for text in [headed, inline] {
            let shown = parse(&text).unwrap_err().to_string();
            assert!(shown.starts_with("scene:1: ") && shown.contains(words), "{shown}");
        }
    }
}

/// Keyframes that one invocation goes through are counted, those of all force fields together.
#[test]
fn keyframes_are_counted() {
    let keyframes = |count: usize, what: &str| (0..count).map(|k| format!("{{time={k},{what}}},")).collect::<String>();
    let field = |name, count| {
        let keyframes = keyframes(count, "strength=1.0");
        format!(
            "[[force]]\nname = \"{name}\"\nfield = \"point\"\norigin = [0, 0, 0]\nreach = 0.1\nkeyframes = [{keyframes}]\n"
        )
    };
    for (text, words) in [
        (
            field("a", 9000) + &field("b", 9000),
            "force.b.keyframes: makes 18000 keyframes of force fields; expected at most 16384",
        ),
        (
            format!("gust = [{}]\n", keyframes(17_000, "velocity=[1,0,0]")),
            "air.gust: expected at most 16384 gusts, found 17000",
        ),
    ] {
        let shown = parse(&(SMALL.to_owned() + &text)).unwrap_err().to_string();
        assert!(shown.contains(words), "{shown}");
    }
}

/// Control characters of a file are spelled where an error quotes them; other characters stay.
#[test]
fn control_characters_are_spelled() {
    let shown = |text: &str| parse_with("sc\u{1b}[2Jene", text, &[]).unwrap_err();
    for (text, words) in [
        ("\"\\u001b[31mevil\" = 1", "\\u{1b}[31mevil: unknown key"),
        ("\"a\\nerror: b\" = 1", "a\\nerror: b: unknown key"),
        ("method = \"\\u009b31m\"", "expected one of"),
        ("[[hair]]\nname = \"\\u0007ü\"\nradius = -1", "hair.\\u{7}ü.radius"),
        ("\"größe\" = 1", "größe: unknown key"),
        ("\u{1b}", "not TOML"),
    ] {
        let error = shown(text);
        let said = [error.to_string(), error.message().to_owned(), error.key().unwrap_or_default().to_owned()];
        assert!(said[0].starts_with("sc\\u{1b}[2Jene:") && said[0].contains(words), "{said:?}");
        assert!(!said.concat().replace('\n', "").contains(char::is_control), "{said:?}");
    }
    let shown = load("none\u{1b}[31m.toml").unwrap_err().to_string();
    assert!(shown.starts_with("none\\u{1b}[31m.toml: cannot be read"), "{shown}");
}

/// A pipe that has a name may never begin: it is refused, as it is where a groom or a mesh should be. A device is no
/// file either. A pipe that the process was given is read, as `windswept check /dev/stdin` is.
#[cfg(unix)]
#[test]
fn what_is_no_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.toml");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    for path in [pipe.as_path(), std::path::Path::new("/dev/zero")] {
        let shown = load(path).unwrap_err().to_string();
        assert_eq!(shown, format!("{}: expected a file", path.display()));
    }
    use std::{io::Write, os::fd::AsRawFd};
    let (reader, mut writer) = std::io::pipe().unwrap();
    writer.write_all(SMALL.as_bytes()).unwrap();
    drop(writer);
    assert_eq!(load(format!("/dev/fd/{}", reader.as_raw_fd())), parse(SMALL));
}

/// A scene in code is checked as one of a text: each wrong value is a fault of its key, and none is stepped.
#[test]
fn wrong_scenes_in_code_are_named() {
    let scene = || {
        let mut scene = Scene::new(Time::new(1e-3, 1.0));
        scene.hair.push(Hair::drawn(3, 5, 0.05, Roots::disc([0.05; 3], 0.01)));
        scene.air = Some(Air::filling([0.1; 3]).wind([1.0, 0.0, 0.0]));
        scene.bodies.push(Body::sphere([0.05, 0.09, 0.05], 0.005).named("ball"));
        scene
    };
    assert!(scene().check().is_ok());
    let keyframes = || [0.2, 0.1].map(Keyframe::new).into();
    type Change = fn(&mut Scene);
    let cases: [(&str, Change); 6] = [
        ("time.step", |scene| scene.time.step = -1.0),
        ("time.substeps", |scene| scene.time.substeps = 0),
        ("air", |scene| scene.air = None),
        ("body.ball.radius", |scene| scene.bodies[0] = Body::sphere([0.05; 3], -0.1).named("ball")),
        ("hair.points", |scene| scene.hair = vec![Hair::drawn(3, 1, 0.05, Roots::disc([0.05; 3], 0.01))]),
        ("gravity", |scene| scene.gravity[1] = f64::NAN),
    ];
    for (key, change) in cases {
        let mut wrong = scene();
        change(&mut wrong);
        let error = wrong.check().unwrap_err();
        assert_eq!(error.key(), Some(key), "{error}");
    }
    let mut back = scene();
    back.bodies[0].motion = keyframes();
    assert_eq!(back.check().unwrap_err().key(), Some("body.ball.motion.1.time"));
}
