//! Keys that a scene gives and nothing reads.

use super::Warning;
use crate::{
    scene::{CheckedAir, CheckedScene, FluidSolver, Hair, Law, Model, Solver},
    strands::{End, Strands},
};

/// A key that a scene gives, with the scene and the group of strands that read it.
struct Given<'a> {
    scene: &'a CheckedScene,
    hair: &'a Strands,
    /// The group of strands that has the key.
    group: Option<&'a Hair>,
}

/// Reason why nothing reads a key; `None` where something does.
type Unread = fn(&Given<'_>) -> Option<&'static str>;

/// Tables and keys that some scenes do not read. Of several rows for a key the first that holds counts.
const UNREAD: &[(&[&str], Unread)] = &[
    (&["air", "force", "interaction.lift", "fluid", "turbulence", "viscosity"], |given| {
        (given.scene.interaction.model == Model::None).then_some("interaction.model is none: hair alone")
    }),
    (
        &[
            "air.box",
            "air.margin",
            "air.spacing",
            "air.kernel_radius",
            "air.fringe",
            "air.jitter",
            "air.seed",
            "air.inflow",
            "air.skin_friction",
            "force.uptake",
            "fluid",
            "turbulence",
            "viscosity",
        ],
        |given| (!given.scene.interaction.model.has_air()).then_some("interaction.model is drag: no air particles"),
    ),
    (
        &[
            "time.settle",
            "gravity",
            "rods",
            "interaction.lift",
            "viscosity.hair",
            "viscosity.kinematic_hair",
            "body.friction",
        ],
        |given| given.hair.is_empty().then_some("the scene has no hair"),
    ),
    (&["air.skin_friction"], |given| given.scene.bodies.is_empty().then_some("the scene has no bodies")),
    (&["fluid.pressure_iterations", "air.skin_friction"], |given| {
        (given.scene.fluid.solver == FluidSolver::Pbf).then_some("fluid.solver is pbf")
    }),
    (&["fluid.coarse"], |given| given.scene.why_never_coarse()),
    (&["fluid.iterations", "fluid.relaxation"], |given| {
        let pressure_alone = given.scene.fluid.solver == FluidSolver::Divergence;
        let one_fluid = given.scene.interaction.model == Model::Particles;
        (pressure_alone && one_fluid).then_some("a pressure acts on hair as on air")
    }),
    (&["fluid.iterations", "fluid.relaxation"], |given| {
        let alone = given.hair.is_empty() && given.scene.fluid.solver == FluidSolver::Divergence;
        alone.then_some("the scene has no hair, whose density the constraint keeps")
    }),
    (&["hair.motion", "hair.body"], |given| (given.group?.root == End::Free).then_some("the roots are free")),
    (&["fluid.relaxation"], |given| (given.scene.fluid.iterations == 0).then_some("fluid.iterations is 0")),
    (&["air.fringe", "air.ramp", "air.inflow"], |given| {
        given.scene.air.as_ref().is_some_and(CheckedAir::is_still).then_some("nothing enters while air.wind is zero")
    }),
    (&["turbulence.speed", "turbulence.law", "turbulence.conserve_momentum"], |given| {
        given.scene.turbulence.bands.is_empty().then_some("there is no band of eddies")
    }),
    (&["turbulence.speed", "turbulence.bands.intensity"], |given| {
        (given.scene.turbulence.law == Law::Published).then_some("turbulence.law is published, which has no speed")
    }),
    (&["viscosity.form"], |given| (!given.scene.viscosity.acts()).then_some("nothing is viscous")),
    (&["rods.iterations"], |given| (given.scene.rods.solver == Solver::Direct).then_some("rods.solver is direct")),
    (&["rods.newton"], |given| {
        (given.scene.rods.solver == Solver::GaussSeidel).then_some("rods.solver is gauss-seidel")
    }),
    (&["hair.density"], |given| given.group?.fibre.point_mass.map(|_| "hair.point_mass gives the mass")),
    (&["hair.curl_phase"], |given| given.group?.as_drawn()?.curl.is_none().then_some("the strands have no curl")),
    (&["hair.friction"], |given| given.scene.why_no_friction().filter(|_| given.group.is_some())),
];

/// A warning for each key or table that the scene gives and nothing reads.
pub(crate) fn of_unread(scene: &CheckedScene, hair: &Strands) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = Vec::new();
    for path in scene.scene().given() {
        let group =
            path.strip_prefix("hair.").and_then(|rest| scene.hair.get(rest.split('.').next()?.parse::<usize>().ok()?));
        let given = Given { scene, hair, group };
        let row = |(keys, why): &(&[&str], Unread)| {
            let table = keys.iter().find_map(|key| start_of(&path, key))?;
            Some((table, why(&given)?))
        };
        let Some((table, why)) = UNREAD.iter().find_map(row) else { continue };
        let key = scene.scene().by_name(table);
        if !warnings.iter().any(|warning| warning.key == key) {
            warnings.push(Warning::new("unread_key", &key, format!("does nothing: {why}")));
        }
    }
    warnings
}

/// The start of a real path (`force.0.strength`) that is the table or key of this name, with its index (`force.0`).
fn start_of<'a>(path: &'a str, key: &str) -> Option<&'a str> {
    let (mut end, mut names) = (0, key.split('.').peekable());
    for part in path.split('.') {
        let is_index = part.parse::<usize>().is_ok();
        match names.peek() {
            _ if is_index => {}
            Some(name) if *name == part => _ = names.next(),
            Some(_) => return None,
            None => break,
        }
        end += part.len() + 1;
    }
    names.peek().is_none().then(|| &path[..end - 1])
}
