//! A scene written out in full.

use std::fmt::Write as _;

use toml_edit::Value;

use crate::{
    body::{Body, Shape},
    keys::Key,
    motion::Motion,
    scene::*,
};

impl Scene {
    /// The scene as TOML with every key resolved, as it stands: [`Scene::parse`] of it is an equal scene.
    ///
    /// A key that this version refuses is left out; its value is the default that parsing gives it again.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = Writer::default();
        text.pair("title", self.title.as_str());
        text.pair("method", self.method.word());
        text.vector("gravity", self.gravity);
        text.pair("seed", i64::try_from(self.seed).unwrap_or(i64::MAX));
        text.heading("[time]", "time");
        text.number("step", self.time.step);
        text.count("substeps", self.time.substeps);
        text.number("duration", self.time.duration);
        text.number("frame_rate", self.time.frame_rate);
        for hair in &self.hair {
            text.hair(hair);
        }
        if let Some(air) = &self.air {
            text.air(air);
        }
        text.heading("[interaction]", "interaction");
        text.pair("model", self.model.word());
        text.number("lift", self.lift);
        text.heading("[fluid]", "fluid");
        text.count("iterations", self.fluid.iterations);
        text.number("relaxation", self.fluid.relaxation);
        text.number("tension", self.fluid.tension);
        text.turbulence(&self.turbulence);
        text.heading("[viscosity]", "viscosity");
        text.number("hair", self.viscosity.hair);
        text.number("air", self.viscosity.air);
        text.pair("form", self.viscosity.form.word());
        text.heading("[rods]", "rods");
        text.pair("solver", self.rods.solver.word());
        text.pair("integrator", self.rods.integrator.word());
        text.count("iterations", self.rods.iterations);
        text.count("newton", self.rods.newton);
        text.pair("inextensible", self.rods.inextensible);
        text.number("damping", self.rods.damping);
        text.pair("sleep", self.rods.sleep);
        for body in &self.bodies {
            text.body(body);
        }
        text.heading("[camera]", "camera");
        if let Some(look_at) = self.camera.look_at {
            text.vector("eye", look_at.eye);
            text.vector("target", look_at.target);
        }
        text.number("fov", self.camera.fov);
        text.count("width", self.camera.width);
        text.count("height", self.camera.height);
        text.heading("[picture]", "picture");
        text.count("hairs", self.picture.hairs);
        text.pair("air", self.picture.air.word());
        text.out
    }
}

/// As short as reads back to the same bits: 1.46e-7, not 0.000000146.
fn number(x: f64) -> Value {
    format!("{x:?}").parse().unwrap_or_else(|_| x.into())
}

#[derive(Default)]
struct Writer {
    out: String,
    /// Of the table that is being written, without indices.
    path: &'static str,
}

impl Writer {
    fn heading(&mut self, heading: &str, path: &'static str) {
        self.path = path;
        self.line(format_args!("\n{heading}"));
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.out, "{line}");
    }

    fn pair(&mut self, name: &str, value: impl Into<Value>) {
        let value = value.into();
        let path = if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) };
        let word = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        if !Key::not_built(&path, &word) {
            self.line(format_args!("{name} = {value}"));
        }
    }

    fn number(&mut self, name: &str, x: f64) {
        self.pair(name, number(x));
    }

    fn count(&mut self, name: &str, count: u32) {
        self.pair(name, i64::from(count));
    }

    fn vector(&mut self, name: &str, v: [f64; 3]) {
        self.pair(name, Value::from_iter(v.map(number)));
    }

    fn maybe(&mut self, name: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.number(name, value);
        }
    }

    fn hair(&mut self, hair: &Hair) {
        self.heading("[[hair]]", "hair");
        self.pair("name", hair.name.as_str());
        self.count("strands", hair.strands);
        self.count("points", hair.points);
        self.number("length", hair.length);
        self.number("length_variation", hair.length_variation);
        self.number("radius", hair.radius);
        self.number("taper", hair.taper);
        self.number("aspect", hair.aspect);
        self.number("density", hair.density);
        self.number("fibres_per_strand", hair.fibres_per_strand);
        let ratio = match hair.stiffness {
            Stiffness::Moduli { youngs_modulus, poissons_ratio } => {
                self.number("youngs_modulus", youngs_modulus);
                poissons_ratio
            }
            Stiffness::Direct { stretch, bend, twist, poissons_ratio } => {
                self.number("stretch_stiffness", stretch);
                self.number("bend_stiffness", bend);
                self.number("twist_stiffness", twist);
                poissons_ratio
            }
        };
        self.number("poissons_ratio", ratio);
        self.maybe("point_mass", hair.point_mass);
        self.pair("root", hair.root.word());
        self.pair("tip", hair.tip.word());
        if let Some(curl) = hair.curl {
            self.number("curl_phase", curl.phase);
            self.heading("[hair.curl]", "hair.curl");
            self.number("radius", curl.radius);
            self.number("pitch", curl.pitch);
        }
        self.heading("[hair.roots]", "hair.roots");
        self.pair("shape", hair.roots.shape.word());
        self.vector("center", hair.roots.center);
        self.number("radius", hair.roots.radius);
        self.vector("direction", hair.roots.direction);
        if hair.roots.normal != hair.roots.direction {
            self.vector("normal", hair.roots.normal);
        }
        self.motion("hair.motion", &hair.motion);
    }

    fn body(&mut self, body: &Body) {
        self.heading("[[body]]", "body");
        self.pair("name", body.name.as_str());
        self.pair("shape", body.shape.word());
        match body.shape {
            Shape::Sphere { center, radius } => {
                self.vector("center", center);
                self.number("radius", radius);
            }
            Shape::Capsule { start, end, radius } => {
                self.vector("start", start);
                self.vector("end", end);
                self.number("radius", radius);
            }
        }
        self.number("friction", body.friction);
        self.motion("body.motion", &body.motion);
    }

    fn motion(&mut self, path: &'static str, motion: &Motion) {
        for keyframe in motion.keyframes.iter().filter(|_| !Key::not_built(path, "")) {
            self.heading(&format!("[[{path}]]"), path);
            self.number("time", keyframe.time);
            self.vector("translation", keyframe.translation);
            self.vector("rotation", keyframe.rotation);
        }
    }

    fn air(&mut self, air: &Air) {
        self.heading("[air]", "air");
        self.number("rest_density", air.rest_density);
        self.number("particle_mass", air.particle_mass);
        self.number("kernel_radius", air.kernel_radius);
        self.vector("wind", air.wind);
        self.number("fringe", air.fringe);
        self.number("ramp", air.ramp);
        self.maybe("margin", air.margin);
        self.number("kinematic_viscosity", air.kinematic_viscosity);
        if let Some(bounds) = air.bounds {
            self.heading("[air.box]", "air.box");
            self.vector("min", bounds.min);
            self.vector("max", bounds.max);
        }
        if let Some(inflow) = air.inflow {
            self.heading("[air.inflow]", "air.inflow");
            self.number("intensity", inflow.intensity);
            self.number("scale", inflow.scale);
            self.pair("seed", i64::try_from(inflow.seed).unwrap_or(i64::MAX));
        }
        for gust in &air.gust {
            self.heading("[[air.gust]]", "air.gust");
            self.number("time", gust.time);
            self.vector("velocity", gust.velocity);
        }
    }

    fn turbulence(&mut self, turbulence: &Turbulence) {
        self.heading("[turbulence]", "turbulence");
        self.number("speed", turbulence.speed);
        self.pair("law", turbulence.law.word());
        self.pair("filter", turbulence.filter.word());
        self.pair("order", turbulence.order.word());
        self.number("spacing", turbulence.spacing);
        self.number("cutoff", turbulence.cutoff);
        self.pair("normalise", turbulence.normalise);
        self.pair("conserve_momentum", turbulence.conserve_momentum);
        for band in &turbulence.bands {
            self.heading("[[turbulence.bands]]", "turbulence.bands");
            self.number("scale", band.scale);
            self.number("strength", band.strength);
            self.number("intensity", band.intensity);
        }
    }
}
