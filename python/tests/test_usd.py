"""USD: what USD's own library writes becomes a groom, what we write comes back, and followers go with the strands."""

import subprocess
import sys
import warnings

import numpy as np
import pytest

import windswept as ws

usd = pytest.importorskip("pxr.Usd", reason="usd-core is for CPython 3.11 or later")
from pxr import Gf, Sdf, UsdGeom, Vt  # noqa: E402


def stage_of(path, points, counts, **more):
    """A stage of one prim as a script would write it: centimetres, Z up, moved and scaled."""
    stage = usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    above = UsdGeom.Xform.Define(stage, "/Head")
    above.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    above.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
    curves = UsdGeom.BasisCurves.Define(stage, "/Head/Hair")
    curves.GetCurveVertexCountsAttr().Set(counts)
    curves.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    for name, value in {"type": "cubic", "basis": "catmullRom", "wrap": "pinned", **more}.items():
        curves.GetPrim().GetAttribute(name).Set(value)
    api = UsdGeom.PrimvarsAPI(curves)
    for name, kind, values in [("groom_id", Sdf.ValueTypeNames.IntArray, [9, 4]), ("groom_guide", Sdf.ValueTypeNames.IntArray, [0, 1])]:
        api.CreatePrimvar(name, kind, UsdGeom.Tokens.uniform).Set(values)
    stage.GetRootLayer().Save()
    return stage


def test_a_stage_becomes_a_groom(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usdc", points, [4, 7])
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Head/Hair"))
    curves.GetWidthsAttr().Set([0.004, 0.006])
    curves.SetWidthsInterpolation(UsdGeom.Tokens.uniform)
    stage.GetRootLayer().Save()
    assert ws.usd.to_npz(tmp_path / "groom.usdc", tmp_path / "groom.npz") == 2
    with np.load(tmp_path / "groom.npz") as file:
        placed = 2 * points + [1, 2, 3]
        # Float32 in the file.
        np.testing.assert_allclose(file["points"], placed[:, [0, 2, 1]] * [1, 1, -1], rtol=0, atol=1e-5)
        assert file["ids"].tolist() == [9, 4] and file["guides"].tolist() == [0, 1] and file["meters_per_unit"] == 0.01
        np.testing.assert_allclose(file["radius"], np.repeat([0.004, 0.006], [4, 7]), rtol=1e-6)
    with pytest.warns(UserWarning, match="the radius that"):
        groom = ws.Groom.load(tmp_path / "groom.npz")
    # Only the marked one is simulated.
    assert groom.ids.tolist() == [9, 4] and groom.guides.tolist() == [False, True]
    assert abs(groom.points - 0.01 * (placed[:, [0, 2, 1]] * [1, 1, -1])).max() < 1e-7


def loaded(path):
    """The arrays of what becomes of a stage."""
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def test_curves_of_every_basis_are_evaluated(tmp_path):
    # A cubic in t through every basis: a curve that its own vertices lie on for none of them but two.
    rng = np.random.default_rng(3)
    a = rng.normal(size=(4, 3))

    def cubic(t, derivative=0):
        t = np.asarray(t, float)[:, None]
        powers = [np.ones_like(t), t, t**2, t**3] if derivative == 0 else [0 * t, np.ones_like(t), 2 * t, 3 * t**2]
        return sum(c * power for c, power in zip(a, powers))

    k = np.arange(-1.0, 5.0)
    # The vertices of a uniform B-spline that is the cubic: its blossom at (k - 1, k, k + 1).
    blossom = a[0] + np.outer(k, a[1]) + np.outer(k**2 - 1 / 3, a[2]) + np.outer(k**3 - k, a[3])
    control = np.concatenate([[cubic([i])[0], cubic([i])[0] + cubic([i], 1)[0] / 3, cubic([i + 1])[0] - cubic([i + 1], 1)[0] / 3] for i in range(3)] + [cubic([3])])
    thirds = np.arange(10) / 3
    cases = [
        ("bspline", "nonperiodic", blossom, cubic(range(4))),
        ("bspline", "pinned", blossom, np.concatenate([blossom[:1], cubic(range(4)), blossom[-1:]])),
        ("catmullRom", "nonperiodic", cubic(k), cubic(range(4))),
        ("catmullRom", "pinned", cubic(k), cubic(k)),
        ("bezier", "nonperiodic", control, cubic(thirds)),
    ]
    for basis, wrap, vertices, expected in cases:
        path = tmp_path / f"{basis}_{wrap}.usda"
        stage_of(path, np.concatenate([vertices, vertices + 1]), [len(vertices)] * 2, basis=basis, wrap=wrap)
        assert ws.usd.to_npz(path, tmp_path / "groom.npz") == 2
        made = loaded(tmp_path / "groom.npz")
        placed = 2 * np.concatenate([expected, expected + 1]) + [1, 2, 3]
        np.testing.assert_allclose(made["points"], placed[:, [0, 2, 1]] * [1, 1, -1], rtol=0, atol=1e-4, err_msg=basis + wrap)
    stage = usd.Stage.CreateNew(str(tmp_path / "others.usda"))
    hermite = UsdGeom.HermiteCurves.Define(stage, "/Hermite")
    hermite.GetCurveVertexCountsAttr().Set([4])
    hermite.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(cubic(range(4)).astype(np.float32)))
    hermite.GetTangentsAttr().Set(Vt.Vec3fArray.FromNumpy(cubic(range(4), 1).astype(np.float32)))
    # Half of the unit circle: the points of the square about it, by a rational curve of the second degree.
    circle = UsdGeom.NurbsCurves.Define(stage, "/Circle")
    circle.GetCurveVertexCountsAttr().Set([5])
    circle.GetPointsAttr().Set([(1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 1, 0), (-1, 0, 0)])
    circle.GetOrderAttr().Set([3])
    circle.GetKnotsAttr().Set([0, 0, 0, 1, 1, 2, 2, 2])
    circle.GetPointWeightsAttr().Set([1, 0.5**0.5, 1, 0.5**0.5, 1])
    stage.GetRootLayer().Save()
    assert ws.usd.to_npz(tmp_path / "others.usda", tmp_path / "groom.npz") == 2
    made = loaded(tmp_path / "groom.npz")
    assert made["offsets"].tolist() == [0, 10, 15]
    np.testing.assert_allclose(made["points"][:10], cubic(thirds), rtol=0, atol=1e-4)
    half = made["points"][10:]
    np.testing.assert_allclose(np.hypot(*half[:, :2].T), 1, rtol=0, atol=1e-6)
    np.testing.assert_allclose(half[[0, 2, 4]], [(1, 0, 0), (0, 1, 0), (-1, 0, 0)], rtol=0, atol=1e-6)


def test_widths_of_bezier_curves_vary(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7], basis="bezier", wrap="nonperiodic")
    # One for each end of a segment.
    UsdGeom.BasisCurves(stage.GetPrimAtPath("/Head/Hair")).GetWidthsAttr().Set([1, 4, 1, 7, 1])
    stage.GetRootLayer().Save()
    assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 2
    # The stage scales by 2, a radius is half a width.
    np.testing.assert_allclose(loaded(tmp_path / "groom.npz")["radius"], [1, 2, 3, 4, 1, 3, 5, 7, 5, 3, 1], rtol=1e-6)


def test_periodic_curves_are_left_out_by_name(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7])
    Sdf.CopySpec(stage.GetRootLayer(), "/Head/Hair", stage.GetRootLayer(), "/Head/Ring")
    UsdGeom.BasisCurves(stage.GetPrimAtPath("/Head/Ring")).GetWrapAttr().Set("periodic")
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning, match="groom.usda: /Head/Ring is periodic, and is left out"):
        assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 2
    (tmp_path / "empty.usda").write_text("#usda 1.0\n")
    with pytest.raises(ValueError, match="curves with points, found none$"):
        ws.usd.to_npz(tmp_path / "empty.usda", tmp_path / "no.npz")


def test_guides_are_marked_and_invisible_prims_left_out(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7])
    stage.GetPrimAtPath("/Head/Hair").RemoveProperty("primvars:groom_guide")
    for name in ("Guides", "Hidden", "Proxy"):
        Sdf.CopySpec(stage.GetRootLayer(), "/Head/Hair", stage.GetRootLayer(), f"/Head/{name}")
    for name, purpose in [("Guides", "guide"), ("Proxy", "proxy")]:
        UsdGeom.Imageable(stage.GetPrimAtPath(f"/Head/{name}")).GetPurposeAttr().Set(purpose)
    UsdGeom.Imageable(stage.GetPrimAtPath("/Head/Hidden")).MakeInvisible()
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning) as said:
        assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 4
    words = [str(warning.message) for warning in said]
    assert any("/Head/Hidden is invisible, and is left out" in word for word in words)
    assert any("/Head/Proxy is a stand-in, of purpose proxy, and is left out" in word for word in words)
    # The stage keeps the order in which its prims were made.
    assert loaded(tmp_path / "groom.npz")["guides"].tolist() == [False, False, True, True]


def test_the_first_sample_is_taken_where_there_are_samples(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7], type="linear")
    attribute = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Head/Hair")).GetPointsAttr()
    for time in (3, 8):
        attribute.Set(Vt.Vec3fArray.FromNumpy((points + time).astype(np.float32)), time)
    stage.GetRootLayer().Save()
    for time, shift in [(None, 3), (3, 3), (8, 8), (5.5, 5.5)]:
        ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz", time=time)
        placed = 2 * (points + shift) + [1, 2, 3]
        np.testing.assert_allclose(loaded(tmp_path / "groom.npz")["points"], placed[:, [0, 2, 1]] * [1, 1, -1], rtol=0, atol=1e-4)


def test_instances_of_point_instancers_are_there(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage_of(tmp_path / "tuft.usda", points, [4, 7])
    stage = usd.Stage.CreateNew(str(tmp_path / "field.usda"))
    field = UsdGeom.PointInstancer.Define(stage, "/Field")
    field.AddTranslateOp().Set(Gf.Vec3d(0, 0, 50))
    tuft = UsdGeom.Xform.Define(stage, "/Field/Tuft")
    tuft.GetPrim().GetReferences().AddReference("./tuft.usda", "/Head")
    field.CreatePrototypesRel().SetTargets([tuft.GetPath()])
    field.CreateProtoIndicesAttr().Set([0, 0, 0, 0])
    field.CreatePositionsAttr().Set([(0, 0, 0), (10, 0, 0), (20, 0, 0), (30, 0, 0)])
    # A quarter about z: (x, y, z) becomes (-y, x, z).
    turn = Gf.Quath(0.5**0.5, Gf.Vec3h(0, 0, 0.5**0.5))
    field.CreateOrientationsAttr().Set([Gf.Quath(1), turn, Gf.Quath(1), Gf.Quath(1)])
    field.CreateInvisibleIdsAttr().Set([2])
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning, match="4 of 6 curves have the groom_id"):
        assert ws.usd.to_npz(tmp_path / "field.usda", tmp_path / "field.npz") == 6
    first, second, last = np.split(loaded(tmp_path / "field.npz")["points"], 3)
    placed = 2 * points + [1, 2, 3]
    np.testing.assert_allclose(first, placed + [0, 0, 50], rtol=0, atol=1e-4)
    # Quaternions have half precision.
    np.testing.assert_allclose(second, placed[:, [1, 0, 2]] * [-1, 1, 1] + [10, 0, 50], rtol=0, atol=0.03)
    np.testing.assert_allclose(last, placed + [30, 0, 50], rtol=0, atol=1e-4)


def test_primvars_are_inherited(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7])
    above = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Head"))
    above.CreatePrimvar("groom_group_id", Sdf.ValueTypeNames.Int, UsdGeom.Tokens.constant).Set(5)
    stage.GetRootLayer().Save()
    assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 2
    assert loaded(tmp_path / "groom.npz")["groups"].tolist() == [5, 5]


def test_a_file_that_usd_cannot_read_is_a_value_error(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage_of(tmp_path / "whole.usdc", points, [4, 7])
    whole = (tmp_path / "whole.usdc").read_bytes()
    (tmp_path / "cut.usdc").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "words.usda").write_text("#usda 1.0\n(\nno\n")
    for name, reason in [("none.usdc", "there is no such file"), ("cut.usdc", "corrupt"), ("words.usda", "words.usda:")]:
        with pytest.raises(ValueError, match=f"{name}: expected a USD file: .*{reason}") as raised:
            ws.usd.to_npz(tmp_path / name, tmp_path / "no.npz")
        # Nothing of the place in USD's own code.
        assert "pxrInternal" not in str(raised.value)
    assert not (tmp_path / "no.npz").exists()


def test_a_damaged_part_of_a_file_is_a_value_error(tmp_path):
    curves = 'def BasisCurves "Hair" {\n int[] curveVertexCounts = [2]\n %s\n uniform token type = "linear"\n %s\n}\n'
    points = "point3f[] points = [(0, 0, 0), (1, 0, 0)]"
    # A binary file can hold text that is not UTF-8, where the text format refuses it.
    (tmp_path / "words.usda").write_text("#usda 1.0\n" + curves % (points, 'string[] primvars:groom_id = ["Quxxyz"]'))
    assert usd.Stage.Open(str(tmp_path / "words.usda")).GetRootLayer().Export(str(tmp_path / "binary.usdc"))
    binary = (tmp_path / "binary.usdc").read_bytes()
    assert binary.count(b"Quxxyz") == 1
    files = {
        # USD quotes the byte in its error.
        "quoted.usda": (b"#usda 1.0\n" + (curves % (points, "")).encode().replace(b"BasisCurves", b"Basis\xf2urves"), r"USD file: .*Basis\\xf2urves"),
        # A value that USD hands over.
        "value.usdc": (binary.replace(b"Quxxyz", b"Qux\xedyz"), r"USD file: its text is not UTF-8: Qux\\xedyz"),
        # What is read after the curves.
        "axis.usda": (b"#usda 1.0\n(\n upAxis = {}\n)\n" + (curves % (points, "")).encode(), "USD file: .*VtDictionary"),
        "unit.usda": (b"#usda 1.0\n(\n metersPerUnit = {}\n)\n" + (curves % (points, "")).encode(), "USD file: .*VtDictionary"),
        "points.usda": (b"#usda 1.0\n" + (curves % ("int points = 3", "")).encode(), r"/Hair: points: expected point3f\[\], found 1 of type"),
        "kind.usda": (b"#usda 1.0\n" + (curves % (points, "")).encode().replace(b'"linear"', b'"lunear"'), "/Hair: expected curves .*lunear"),
    }
    for name, (content, words) in files.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match=f"{name}: .*{words}") as raised:
            ws.usd.to_npz(tmp_path / name, tmp_path / "no.npz")
        assert type(raised.value) is ValueError, name
    assert not (tmp_path / "no.npz").exists()


def test_only_errors_of_usd_become_value_errors(tmp_path, monkeypatch):
    stage_of(tmp_path / "groom.usda", np.zeros((4, 3)), [4])
    for error in (MemoryError, KeyboardInterrupt, AssertionError):
        monkeypatch.setattr(UsdGeom, "GetStageUpAxis", lambda stage, error=error: (_ for _ in ()).throw(error()))
        with pytest.raises(error):
            ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "no.npz")


def test_prims_without_points_are_left_out_by_name(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7])
    UsdGeom.BasisCurves.Define(stage, "/Head/Bald")
    UsdGeom.BasisCurves.Define(stage, "/Head/Cut").GetCurveVertexCountsAttr().Set([3])
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning, match="groom.usda: /Head/Bald, /Head/Cut has no points, and is left out"):
        assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 2
    stage.RemovePrim("/Head/Hair")
    stage.GetRootLayer().Save()
    with pytest.raises(ValueError, match="curves with points, found none: /Head/Bald, /Head/Cut has no points"):
        ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "no.npz")


def test_ids_of_several_prims_are_made_unique(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7])
    Sdf.CopySpec(stage.GetRootLayer(), "/Head/Hair", stage.GetRootLayer(), "/Head/Lashes")
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning, match="2 of 4 curves have the groom_id of a curve before them, and get ids from 10 on"):
        assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 4
    with np.load(tmp_path / "groom.npz") as file:
        assert file["ids"].tolist() == [9, 4, 10, 11]


def test_what_only_some_prims_have_is_left_out_by_name(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7])
    Sdf.CopySpec(stage.GetRootLayer(), "/Head/Hair", stage.GetRootLayer(), "/Head/Lashes")
    lashes = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Head/Lashes"))
    lashes.GetPrim().RemoveProperty("primvars:groom_id")
    lashes.GetWidthsAttr().Set([0.004, 0.006])
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning) as said:
        assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 4
    assert sorted(str(warning.message).split("groom.usda: ")[1] for warning in said) == [
        "/Head/Hair has no usable widths, which is left out of the other prims too",
        "/Head/Lashes has no usable groom_id, which is left out of the other prims too",
    ]
    with np.load(tmp_path / "groom.npz") as file:
        assert sorted(file.files) == ["guides", "meters_per_unit", "offsets", "points"]


@pytest.mark.parametrize(
    ("primvar", "kind", "value", "words"),
    [
        ("groom_id", "int[]", [7], r"expected 2 numbers, one for each curve, found 1 of type int\[\]"),
        ("groom_group_id", "int[]", [1, 2, 3], r"expected 2 numbers, one for each curve, found 3 of type int\[\]"),
        ("groom_guide", "int[]", [1, 2, 3], r"expected 2 numbers, one for each curve, found 3 of type int\[\]"),
        ("groom_guide", "string", "x", "expected 2 numbers, one for each curve, found 1 of type string"),
        ("groom_root_uv", "float3[]", [(0, 0, 0)] * 2, r"expected 2 pairs of numbers, one for each curve, found 2 of type float3\[\]"),
        ("surface_uv_coordinate", "float2[]", [(0, 0)] * 11, r"expected 2 pairs of numbers, .*, found 11 of type float2\[\]"),
        ("widths", "float[]", [0.1, 0.2, 0.3], r"expected 11, 11, 2 or 1 numbers, for each point, each end of a segment, each curve or all, found 3 of type float\[\]"),
    ],
)
def test_what_is_not_one_for_each_curve_is_left_out_by_name(tmp_path, primvar, kind, value, words):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage = stage_of(tmp_path / "groom.usda", points, [4, 7])
    hair = UsdGeom.BasisCurves(stage.GetPrimAtPath("/Head/Hair"))
    for name in ("groom_id", "groom_guide"):
        hair.GetPrim().RemoveProperty(f"primvars:{name}")
    if primvar == "widths":
        hair.GetWidthsAttr().Set(value)
    else:
        UsdGeom.PrimvarsAPI(hair).CreatePrimvar(primvar, Sdf.ValueTypeNames.Find(kind), UsdGeom.Tokens.uniform).Set(value)
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning, match=rf"groom.usda: {primvar} is not taken from /Head/Hair \({words}\)$") as said:
        assert ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz") == 2
    assert len(said) == 1
    with np.load(tmp_path / "groom.npz") as file:
        assert sorted(file.files) == ["meters_per_unit", "offsets", "points"]


def test_curves_of_a_wrong_number_of_vertices_are_refused(tmp_path):
    expected = r"3 k \+ 1 vertices \(4, 7, 10 and so on\) of a Bézier curve"
    for wrong in 2, 3, 6:
        path = tmp_path / f"{wrong}.usda"
        stage_of(path, np.ones((4 + wrong, 3)), [4, wrong], type="cubic", basis="bezier")
        with pytest.raises(ValueError, match=rf"{wrong}.usda: /Head/Hair: curve 1, counted from 0: expected {expected}, found {wrong}$"):
            ws.usd.to_npz(path, tmp_path / "no.npz")
    # A curve of one vertex or none is left out where the groom is loaded, as from any other file.
    for k, (kind, basis, few) in enumerate([("cubic", "bezier", 1), ("cubic", "bezier", 0), ("linear", "bezier", 1)]):
        path = tmp_path / f"few{k}.usda"
        stage_of(path, np.cumsum(np.ones((4 + few, 3)), axis=0), [4, few], type=kind, basis=basis)
        assert ws.usd.to_npz(path, tmp_path / "groom.npz") == 2
        with pytest.warns(UserWarning, match="1 of fewer than two points"):
            assert ws.Groom.load(tmp_path / "groom.npz", file_guides=False).ids.tolist() == [9]
    for kind, basis, counts in [("cubic", "bezier", [4, 10]), ("cubic", "catmullRom", [2, 3]), ("linear", "bezier", [2, 6])]:
        path = tmp_path / f"{kind}_{basis}.usda"
        stage_of(path, np.ones((sum(counts), 3)), counts, type=kind, basis=basis)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert ws.usd.to_npz(path, tmp_path / "groom.npz") == 2


def test_curves_of_instances_are_found(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    stage_of(tmp_path / "head.usda", points, [4, 7])
    stage = usd.Stage.CreateNew(str(tmp_path / "crowd.usda"))
    for k in range(2):
        head = UsdGeom.Xform.Define(stage, f"/Head{k}")
        head.AddTranslateOp().Set(Gf.Vec3d(100 * k, 0, 0))
        head.GetPrim().GetReferences().AddReference("./head.usda", "/Head")
        head.GetPrim().SetInstanceable(True)
    stage.GetRootLayer().Save()
    with pytest.warns(UserWarning, match="2 of 4 curves"):
        assert ws.usd.to_npz(tmp_path / "crowd.usda", tmp_path / "crowd.npz") == 4
    with np.load(tmp_path / "crowd.npz") as file:
        here, there = np.split(file["points"], 2)
        np.testing.assert_allclose(there - here, np.broadcast_to([100, 0, 0], here.shape), rtol=0, atol=1e-9)


def test_counts_below_zero_are_refused(tmp_path):
    points = np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0)
    for counts, words in [([14, -3], "curve 1, counted from 0: expected a number of vertices, found -3"), ([4, 6], "11 points are not the 10 of its curves")]:
        (tmp_path / "groom.usda").unlink(missing_ok=True)
        stage_of(tmp_path / "groom.usda", points, counts)
        with pytest.raises(ValueError, match=rf"groom.usda: .*: {words}"):
            ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.npz")
    assert not (tmp_path / "groom.npz").exists()


def test_the_groom_file_has_the_name_that_was_asked_for(tmp_path):
    stage_of(tmp_path / "groom.usda", np.cumsum(np.random.default_rng(3).normal(size=(11, 3)), axis=0), [4, 7])
    ws.usd.to_npz(tmp_path / "groom.usda", tmp_path / "groom.partial")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["groom.partial", "groom.usda"]


def test_a_film_is_a_groom_again(scene, tmp_path):
    sim = ws.Simulation(scene)
    with ws.Writer(tmp_path / "out", sim, formats=["usd"]) as writer:
        writer.append(sim)
        for _ in sim.frames(2):
            writer.append(sim)
    code = sim.time * 60
    assert ws.usd.to_npz(tmp_path / "out/hair.usda", tmp_path / "last.npz", time=code) == 8
    groom = ws.Groom.load(tmp_path / "last.npz", radius=4e-5)
    np.testing.assert_array_equal(groom.points.astype(np.float32), sim.hair.positions)
    np.testing.assert_array_equal(groom.offsets, sim.hair.offsets)


def test_ten_thousand_strands_come_back_with_their_followers(tmp_path):
    rng = np.random.default_rng(7)
    roots = rng.normal(size=(10_001, 3)) * [1, 0.3, 1]
    roots *= 0.1 / np.linalg.norm(roots, axis=1, keepdims=True)
    points = roots[:, None] * (1 + 0.06 * np.arange(6)[:, None])
    np.savez(tmp_path / "groom.npz", points=points.astype(np.float32), ids=rng.permutation(10_001), meters_per_unit=1.0)
    (tmp_path / "scene.toml").write_text(
        'time = { step = 1.38e-3, duration = 0.01 }\ninteraction.model = "drag"\n[hair]\nfile = "groom.npz"\nstrands = 200\n'
        "[air]\nwind = [4, 0, 0]\n"
    )
    command = [sys.executable, "-m", "windswept"]
    run = [*command, "run", tmp_path / "scene.toml", "--out", tmp_path / "out", "--formats", "vtkhdf"]
    export = [*command, "export", tmp_path / "out", "--format", "usdc", "--followers"]
    for words in (run, export):
        done = subprocess.run(words, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    stage = usd.Stage.Open(str(tmp_path / "out/film.usdc"))
    curves = UsdGeom.BasisCurves(stage.GetDefaultPrim().GetChild("Hair"))
    with np.load(tmp_path / "groom.npz") as given:
        first = np.array(curves.GetPointsAttr().Get(0)).reshape(10_001, 6, 3)
        np.testing.assert_allclose(first, given["points"], rtol=0, atol=1e-6)
        np.testing.assert_array_equal(UsdGeom.PrimvarsAPI(curves).GetPrimvar("groom_id").Get(), given["ids"])
        # The film is the same groom again: 200 guides, and all others with them.
        ws.usd.to_npz(tmp_path / "out/film.usdc", tmp_path / "film.npz", time=0)
        with pytest.warns(UserWarning, match="marks 200 of its 10001 strands"):
            groom = ws.Groom.load(tmp_path / "film.npz")
        assert groom.guides.sum() == 200
        np.testing.assert_array_equal(groom.ids, given["ids"])
        np.testing.assert_allclose(groom.points.reshape(10_001, 6, 3), given["points"], rtol=0, atol=1e-6)
    assert sum(UsdGeom.PrimvarsAPI(curves).GetPrimvar("groom_guide").Get()) == 200


def test_followers_that_cannot_be_are_refused(scene, bare):
    many = ws.Simulation(scene.replace(**{"hair.fibres_per_strand": 1e9}))
    with pytest.raises(ws.ExportError, match="8000000000 hairs; expected at most"):
        _ = many.followers
    grooms = ws.Simulation(bare, groom=ws.Groom([[[0, 0, 0], [0.01, 0, 0]], [[0, 0, 1], [0.01, 0, 1]]], fibres_per_strand=[1, 3]))
    assert len(grooms.followers.ids) == 4 and grooms.followers.guides[3].tolist() == [1, 0, 0]


def test_followers_go_with_their_strands(scene):
    sim = ws.Simulation(scene.replace(**{"hair.fibres_per_strand": 25}))
    sim.step(20)
    followers, hair = sim.followers, sim.hair
    assert len(followers.ids) == 200 and "200 hairs" in repr(followers)
    assert followers.positions.shape == followers.velocities.shape == (1200, 3)
    # The strands themselves come first.
    np.testing.assert_array_equal(followers.positions[:48], hair.positions)
    np.testing.assert_array_equal(followers.velocities[:48], hair.velocities)
    np.testing.assert_allclose(followers.weights.sum(axis=1), 1, rtol=1e-6)
    # Points of a follower are where its strands' points and its offset from them at the start say, laid anew with the
    # lengths that its segments have at the start: nothing turns here.
    start = ws.Simulation(sim.scene).followers
    now, then = (np.asarray(x).reshape(-1, 6, 3) for x in (hair.positions, start.positions[:48]))
    moved = np.einsum("hj,hjpx->hpx", followers.weights, (now - then)[followers.guides])
    first = start.positions.reshape(-1, 6, 3)
    ways = np.diff((first + moved).astype(np.float64), axis=1)
    lengths = np.linalg.norm(np.diff(first.astype(np.float64), axis=1), axis=2, keepdims=True)
    ways *= lengths / np.linalg.norm(ways, axis=2, keepdims=True)
    meant = np.cumsum(np.concatenate([(first + moved)[:, :1], ways], axis=1), axis=1)
    # Round-off of single precision. The strands are as they are simulated.
    np.testing.assert_allclose(followers.positions.reshape(-1, 6, 3)[8:], meant[8:], rtol=0, atol=2e-8)
