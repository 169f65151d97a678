//! `windswept export`: films of a run for other programs. On the software adapter.

use crate::support::{self, folder, listing, run, windswept};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The interpreter that `cargo xtask test` names, else the one it installs.
fn python() -> PathBuf {
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/venv/bin/python");
    std::env::var_os("WINDSWEPT_PYTHON").map_or(installed, PathBuf::from)
}

fn export(folder: &Path, more: &[&str]) -> Output {
    let mut command = windswept(folder, &["export", "out", "--format"]);
    command.args(more).env("WINDSWEPT_PYTHON", python()).output().expect("the program starts")
}

/// Lets Python say what is in the films of a run.
fn asked(folder: &Path, program: &str) -> String {
    let asked = Command::new(python()).current_dir(folder).args(["-c", program]).output().expect("Python starts");
    assert!(asked.status.success(), "{}", String::from_utf8_lossy(&asked.stderr));
    String::from_utf8_lossy(&asked.stdout).trim().to_owned()
}

/// Whether USD's own library is there: not for Python 3.10.
fn has_usd() -> bool {
    asked(Path::new("."), "import sys; print(sys.version_info >= (3, 11))") == "True"
}

/// Groom of 40 strands, three of which bend another way, of which 9 are simulated; the others follow.
fn groom(folder: &Path) {
    asked(
        folder,
        "
import numpy as np
angle = np.arange(40)[:, None] * 2.4
root = np.concatenate([np.cos(angle), 0 * angle, np.sin(angle)], 1) * np.sqrt(np.arange(40) / 40)[:, None] * 0.01 + [0.01, 0.02, 0.02]
along = np.arange(7)[None, :, None] * np.array([0.004, 0.0, 0.0])
points = (root[:, None] + along).astype('f4')
points[::13, :, 1] += 0.0005 * np.arange(7, dtype='f4') ** 2
uv = np.stack([np.arange(40) / 40, 1 - np.arange(40) / 40], 1).astype('f4')
np.savez('groom.npz', positions=points, root_uv=uv, groups=np.arange(40) % 3, ids=np.arange(40) + 100, meters_per_unit=1.0)
",
    );
    let scene = fs::read_to_string(folder.join("scene.toml")).expect("the scene");
    let before = scene.split("[hair.roots]").next().expect("a part").replace("points = 6\nlength = 0.03\n", "");
    let after = scene.split("[air]").nth(1).expect("a part");
    let before = before.replace("strands = 4", "file = \"groom.npz\"\nstrands = 9");
    fs::write(folder.join("scene.toml"), format!("{before}[air]{after}")).expect("a scene");
}

/// A groom file's strands, of which some are simulated, come back as one film each of USD and of arrays: all of them,
/// in their order, in their shapes at the start, with numbers, groups and places; the same with each format.
#[test]
fn a_groom_comes_back_with_its_followers() {
    let folder = folder();
    let folder = folder.path();
    groom(folder);
    let ran = run(folder, &["--steps", "30", "--formats", "vtkhdf,usd", "--set", "air.wind=[0, 3, 0]"]);
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
    let all = [("usd", "usda"), ("npz", "npz"), ("usdc", "usdc")];
    for (format, ending) in &all[..if has_usd() { 3 } else { 2 }] {
        for (more, out) in [(&[][..], format!("out/film.{ending}")), (&["--followers"], format!("all.{ending}"))] {
            let done = export(folder, &[&[*format, "--out", &out], more].concat());
            assert_eq!(done.status.code(), Some(0), "{done:?}");
            let (said, hairs) =
                (String::from_utf8_lossy(&done.stdout), if more.is_empty() { "" } else { "40 hairs of " });
            assert!(said.contains(&format!("{out}: {hairs}9 strands, 3 frames")), "{said}");
        }
    }
    assert!(!listing(&folder.join("out")).iter().any(|name| name.contains("part") || name.starts_with('.')));
    let program = "
import numpy as np
given, film, few = np.load('groom.npz'), np.load('all.npz'), np.load('out/film.npz')
assert film['positions'].shape == (3, 280, 3) and few['positions'].shape == (3, 63, 3)
for name in ['ids', 'groups', 'root_uv']:
    assert np.array_equal(film[name], given[name]), name
assert np.abs(film['positions'][0] - given['positions'].reshape(-1, 3)).max() < 1e-8
# Strands that are simulated are themselves, and all others have moved no farther than those.
simulated = film['guides'] == 1
assert simulated.sum() == 9 and np.array_equal(film['ids'][simulated], few['ids'])
by_hair = film['positions'].reshape(3, 40, 7, 3)
assert np.array_equal(by_hair[:, simulated].reshape(3, 63, 3), few['positions'])
moved = by_hair[2] - by_hair[0]
tips = np.linalg.norm(moved[:, -1], axis=1)
assert tips[simulated].min() > 1e-5, tips
low, high = moved[simulated].min(axis=(0, 1)), moved[simulated].max(axis=(0, 1))
assert (moved >= low - 1e-7).all() and (moved <= high + 1e-7).all()
print('arrays')
";
    assert_eq!(asked(folder, program), "arrays");
    if has_usd() {
        let program = "
import numpy as np
from pxr import Usd, UsdGeom
for name, film in [('all.usda', 'all.npz'), ('all.usdc', 'all.npz'), ('out/film.usda', 'out/film.npz'),
                   ('out/film.usdc', 'out/film.npz'), ('out/hair.usda', 'out/film.npz')]:
    film = np.load(film)
    stage = Usd.Stage.Open(name)
    curves = UsdGeom.BasisCurves(stage.GetDefaultPrim().GetChild('Hair'))
    codes = curves.GetPointsAttr().GetTimeSamples()
    assert np.allclose(np.array(codes) / 60, film['times'], rtol=1e-9), (name, codes)
    assert np.array_equal([curves.GetPointsAttr().Get(code) for code in codes], film['positions']), name
    assert np.array_equal([curves.GetVelocitiesAttr().Get(code) for code in codes], film['velocities']), name
    assert np.array_equal(curves.GetWidthsAttr().Get(), 2 * film['radius']), name
    assert np.array_equal(curves.GetCurveVertexCountsAttr().Get(), np.diff(film['offsets'])), name
    of = UsdGeom.PrimvarsAPI(curves).GetPrimvar
    assert np.array_equal(of('groom_id').Get(), film['ids']) and np.array_equal(of('groom_group_id').Get(), film['groups'])
    assert np.array_equal(of('groom_root_uv').Get(), film['root_uv'])
    if 'guides' in film:
        assert np.array_equal(of('groom_guide').Get(), film['guides'])
print('curves')
";
        assert_eq!(asked(folder, program), "curves");
    }
    // Films in centimetres, z up, are the same films.
    for (format, ending) in &all[..if has_usd() { 3 } else { 2 }] {
        let done = export(folder, &[format, "--up", "z", "--scale", "0.01", "--out", &format!("cm.{ending}")]);
        assert_eq!(done.status.code(), Some(0), "{done:?}");
    }
    let program = "
import numpy as np
cm, film = np.load('cm.npz'), np.load('out/film.npz')
turned = lambda v: 100 * np.stack([v[..., 0], -v[..., 2], v[..., 1]], -1)
for name in ['positions', 'velocities']:
    assert np.allclose(cm[name], turned(film[name]), rtol=1e-6, atol=0), name
assert np.allclose(cm['radius'], 100 * film['radius']) and cm['meters_per_unit'] == 0.01
try:
    from pxr import Usd, UsdGeom
except ImportError:
    names = []
else:
    names = ['cm.usda', 'cm.usdc']
for name in names:
    stage = Usd.Stage.Open(name)
    curves = UsdGeom.BasisCurves(stage.GetDefaultPrim().GetChild('Hair'))
    assert UsdGeom.GetStageUpAxis(stage) == 'Z' and UsdGeom.GetStageMetersPerUnit(stage) == 0.01, name
    assert np.array_equal(curves.GetPointsAttr().Get(0), cm['positions'][0]), name
    assert np.array_equal(curves.GetWidthsAttr().Get(), 2 * cm['radius']), name
print('units')
";
    assert_eq!(asked(folder, program), "units");
    // Drawn strands have as many followers as they have fibres.
    let drawn = support::folder();
    assert_eq!(run(drawn.path(), &["--steps", "12", "--formats", "vtkhdf"]).status.code(), Some(0));
    let done = export(drawn.path(), &["npz", "--followers"]);
    assert!(String::from_utf8_lossy(&done.stdout).contains("film.npz: 400 hairs of 4 strands, 2 frames"), "{done:?}");
}

/// A film of the strands needs the run's own files only; followers stay out of bodies, and need the mesh.
#[test]
fn a_film_of_strands_needs_no_mesh() {
    let folder = folder();
    let folder = folder.path();
    let scene = fs::read_to_string(folder.join("scene.toml")).expect("the scene");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.join("wedge.obj"), mesh).expect("a mesh");
    let body = "[[body]]\nshape = \"mesh\"\nfile = \"wedge.obj\"\nscale = 0.01\nmotion = [{ time = 0.0, translation = [0, -1, 0] }]\n";
    fs::write(folder.join("scene.toml"), format!("{scene}\n{body}")).expect("a scene");
    assert_eq!(run(folder, &["--steps", "1", "--formats", "vtkhdf"]).status.code(), Some(0));
    fs::remove_file(folder.join("wedge.obj")).expect("the mesh");
    let refused = export(folder, &["usd"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && said.contains("--hair-only"), "{said}");
    let done = export(folder, &["usd", "--hair-only"]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let film = fs::read_to_string(folder.join("out/film.usda")).expect("a film");
    assert!(
        !film.contains("def Mesh")
            && !film.contains("def Camera")
            && film.contains("wedge.obj")
            && film.contains("framesPerSecond")
    );
    let refused = export(folder, &["npz", "--followers"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && said.contains("wedge.obj: cannot be read"), "{said}");
}

/// Hair, body and camera of a film are in one unit and one axis up, and at one time: the body where its keyframes have
/// it, in the stage that a run wrote and in an export, in metres and in centimetres.
#[test]
fn bodies_and_cameras_go_with_the_hair() {
    let folder = folder();
    let folder = folder.path();
    let scene = fs::read_to_string(folder.join("scene.toml")).expect("the scene");
    let body = "[[body]]\nname = \"ball\"\ncenter = [0.01, 0.02, 0.06]\nradius = 0.004\nmotion = [{ time = 0.0 }, \
                { time = 0.1, translation = [0.02, 0.01, 0.03], rotation = [0, 1.5, 0] }]\n";
    let camera = "[camera]\neye = [0.1, 0.2, 0.3]\ntarget = [0.02, 0.02, 0.02]\nfov = 40\n";
    fs::write(folder.join("scene.toml"), format!("{scene}\n{body}\n{camera}")).expect("a scene");
    let ran =
        run(folder, &["--formats", "vtkhdf,usd", "--set", "interaction.model=none", "--set", "time.frame_rate=70"]);
    let note = |output: &Output| String::from_utf8_lossy(&output.stderr).contains("puts them at whole ones");
    assert!(ran.status.code() == Some(0) && note(&ran), "{ran:?}");
    for more in [&["--out", "m.usda"][..], &["--up", "z", "--scale", "0.01", "--out", "cm.usda"]] {
        let done = export(folder, &[&["usd"], more].concat());
        assert!(done.status.code() == Some(0) && note(&done), "{done:?}");
    }
    if !has_usd() {
        return;
    }
    let program = "
import numpy as np
from pxr import Usd, UsdGeom
swap = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # rows: x, y, z of windswept in a film with z up
found = []
for name, to, unit in [('out/hair.usda', np.eye(3), 1), ('m.usda', np.eye(3), 1), ('cm.usda', swap, 0.01)]:
    stage = Usd.Stage.Open(name)
    film = stage.GetDefaultPrim()
    hair, ball, camera = (film.GetChild(child) for child in ['Hair', 'ball', 'camera'])
    points = UsdGeom.BasisCurves(hair).GetPointsAttr()
    own = np.array(UsdGeom.Mesh(ball).GetPointsAttr().Get())
    assert np.abs(np.linalg.norm(own, axis=1) * unit - 0.004).max() < 1e-8
    codes = points.GetTimeSamples()
    transforms = UsdGeom.Xformable(ball).GetOrderedXformOps()[0].GetAttr()
    assert transforms.GetTimeSamples() == codes and len(codes) == 8 and codes[1] != 1
    for code in codes:
        world = np.array(UsdGeom.XformCache(code).GetLocalToWorldTransform(ball))
        part = min(code / 70 / 0.1, 1)
        place = np.array([0.01, 0.02, 0.06]) + part * np.array([0.02, 0.01, 0.03])
        assert np.allclose(world[3, :3] * unit, place @ to, atol=1e-9), (name, code)
        s, c = np.sin(1.5 * part), np.cos(1.5 * part)
        turn = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])  # rows
        assert np.allclose(world[:3, :3], to.T @ turn @ to, atol=1e-9), (name, code)
    lens = UsdGeom.Camera(camera).GetCamera(0)
    eye, forward = (np.array(v) for v in [lens.frustum.position, lens.frustum.ComputeViewDirection()])
    assert np.allclose(eye * unit, np.array([0.1, 0.2, 0.3]) @ to, atol=1e-9)
    aim = np.array([-0.08, -0.18, -0.28]) @ to
    assert np.allclose(forward, aim / np.linalg.norm(aim), atol=1e-9)
    assert np.isclose(lens.GetFieldOfView(lens.FOVVertical), 40) and np.isclose(lens.aspectRatio, 960 / 540)
    # Lengths of a camera are in tenths of a unit: 36 mm of film.
    assert np.isclose(lens.horizontalAperture * unit / 10, 0.036)
    found.append(np.array([points.Get(code) for code in codes]) * unit @ to.T)
assert all(np.allclose(one, found[0], atol=1e-8) for one in found)
print('together')
";
    assert_eq!(asked(folder, program), "together");
    // A step that fits gives whole time codes, and no word about them.
    let ran = run(folder, &["--formats", "vtkhdf,usd", "--overwrite", "--set", "time.step=0.00166667"]);
    assert!(ran.status.code() == Some(0) && !note(&ran), "{ran:?}");
    let program = "
from pxr import Usd
stage = Usd.Stage.Open('out/hair.usda')
print(stage.GetPrimAtPath('/Film/Hair').GetAttribute('points').GetTimeSamples())
";
    assert_eq!(asked(folder, program), "[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]");
    assert_eq!(listing(&folder.join("out/bodies")), ["0000.usda"]);
    // What a run left goes with it, and what is another's stays.
    fs::write(folder.join("out/bodies/0001.usda"), "mine").expect("a file");
    let ran = run(folder, &["--steps", "1", "--formats", "none", "--overwrite"]);
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
    assert_eq!(listing(&folder.join("out/bodies")), ["0001.usda"]);
}

/// Beside a film in USD's binary form no file changes, whether it is made or not: the parts of a film in the making
/// have names of their own.
#[cfg(unix)]
#[test]
fn a_film_costs_nothing_beside_it() {
    let folder = folder();
    let folder = folder.path();
    assert_eq!(run(folder, &["--steps", "1", "--formats", "vtkhdf"]).status.code(), Some(0));
    let mine = ["film.text.usda", "film.part.usdc", "film.usda", "film.usdc.part"];
    mine.iter().for_each(|name| fs::write(folder.join(name), "mine").expect("a file"));
    let listed = listing(folder);
    let untouched = |name: &&str| fs::read_to_string(folder.join(name)).is_ok_and(|text| text == "mine");
    // A Python that has USD's library, as it says, and then makes nothing.
    let false_python = folder.join("out/python");
    let text = "#!/bin/sh\ncase \"$2\" in *Export*) echo no room >&2; exit 1;; esac\n";
    fs::write(&false_python, text).expect("a program");
    fs::set_permissions(&false_python, std::os::unix::fs::PermissionsExt::from_mode(0o755)).expect("a program");
    let mut failed = windswept(folder, &["export", "out", "--format", "usdc", "--out", "film.usdc"]);
    let failed = failed.env("WINDSWEPT_PYTHON", &false_python).output().expect("the program starts");
    let said = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert!(failed.status.code() == Some(1) && said.contains("film.usdc: could not be written: no room"), "{said}");
    assert_eq!(listing(folder), listed);
    assert!(mine.iter().all(untouched));
    if has_usd() {
        let done = export(folder, &["usdc", "--out", "film.usdc"]);
        assert_eq!(done.status.code(), Some(0), "{done:?}");
        assert!(fs::read(folder.join("film.usdc")).expect("a film").starts_with(b"PXR-USDC"));
        fs::remove_file(folder.join("film.usdc")).expect("a film");
        assert_eq!(listing(folder), listed);
        assert!(mine.iter().all(untouched));
    }
}

/// A run that cannot be exported is refused, with the reason, and nothing is written.
#[test]
fn what_cannot_be_exported_is_refused() {
    let folder = folder();
    let folder = folder.path();
    let refused = |more: &[&str], words: &str| {
        let before = folder.join("out").exists().then(|| listing(&folder.join("out")));
        let refused = export(folder, more);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && said.contains(words), "{words:?} is missing: {refused:?}");
        assert_eq!(before, folder.join("out").exists().then(|| listing(&folder.join("out"))));
    };
    refused(&["usd"], "out: no such folder");
    assert_eq!(run(folder, &["--steps", "1", "--formats", "usd"]).status.code(), Some(0));
    refused(&["usd"], "hair.vtkhdf: is missing; a run with `--formats vtkhdf` writes it");
    assert_eq!(run(folder, &["--steps", "1", "--formats", "vtkhdf,usd", "--overwrite"]).status.code(), Some(0));
    refused(&["usd", "--out", "out/hair.usda"], "belongs to the run");
    refused(&["npz", "--out", "film.usda"], "ends in .npz");
    refused(&["npz", "--out", "none/film.npz"], "a folder that is there");
    refused(&["vtkhdf"], "expected one of usd, usdc, npz");
    refused(&["mov"], "expected one of usd, usdc, npz");
    // The way to Alembic is the one that the page says, which was run.
    let page = include_str!("../../../docs/how-to/films.md");
    let way = page.split("blender --background").find(|part| part.contains("alembic_export")).expect("a way");
    let commands: Vec<&str> =
        way.split("```").next().expect("a block").lines().filter(|l| !l.contains("usd_import")).collect();
    assert!(commands.len() == 3, "{commands:?}");
    for line in commands {
        refused(&["abc"], line);
        refused(&["Alembic"], line);
    }
    assert_eq!(export(folder, &["usd"]).status.code(), Some(0));
    refused(&["usd"], "film.usda: is there already; --overwrite");
    assert_eq!(export(folder, &["usd", "--overwrite"]).status.code(), Some(0));
    // A program that is not there, and one that is no Python with usd-core.
    for (program, words) in [("/no/python", "/no/python: cannot be started"), ("false", "false: has no usd-core")] {
        let bare = windswept(folder, &["export", "out", "--format", "usdc"]).env("WINDSWEPT_PYTHON", program).output();
        let said = String::from_utf8_lossy(&bare.expect("the program starts").stderr).into_owned();
        assert!(said.contains(words), "{said}");
    }
    // A run that is repeated takes the film of the one before along.
    assert_eq!(run(folder, &["--steps", "1", "--formats", "none", "--overwrite"]).status.code(), Some(0));
    assert_eq!(listing(&folder.join("out")), ["report.json", "scene.toml"]);
}
