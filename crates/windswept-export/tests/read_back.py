"""Reads FOLDER/film.vtkhdf with VTK and h5py and compares it with the plain dumps beside it.

Usage: read_back.py hair|air FOLDER VERSION ADAPTER SEED; prints the number of steps found.
"""

import pathlib
import sys

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader

kind, folder, version, adapter, seed = sys.argv[1:]
folder = pathlib.Path(folder)
path = folder / "film.vtkhdf"

times = np.fromfile(folder / "times.f64")
steps = len(times)
offsets = np.fromfile(folder / "offsets.u32", np.uint32).astype(np.int64)
of_kind = "air_" if kind == "air" else ""
positions = np.fromfile(folder / f"{of_kind}positions.f32", np.float32).reshape(steps, -1, 3)
velocities = np.fromfile(folder / f"{of_kind}velocities.f32", np.float32).reshape(steps, -1, 3)
points = positions.shape[1]
if kind == "air":
    scalars = {
        name: np.fromfile(folder / file, np.float32).reshape(steps, -1)
        for name, file in [("Vorticity", "vorticity.f32"), ("BandEnergy", "band_energy.f32")]
    }
if kind == "hair":
    segments = np.fromfile(folder / "orientations.f32", np.float32).reshape(steps, -1, 4)
    # Segment of each point: its own, the last one for the tip; written here in another way than in the crate.
    of_point = [p - s - (p == last - 1) for s, (first, last) in enumerate(zip(offsets, offsets[1:])) for p in range(first, last)]
    orientations = segments[:, of_point]
    root_frames = np.fromfile(folder / "root_frames.f32", np.float32).reshape(steps, -1, 4)
    radius = np.fromfile(folder / "radius.f32", np.float32)
    of_strands = {
        "StrandId": np.fromfile(folder / "ids.u32", np.uint32).astype(np.int32),
        "GroupId": np.fromfile(folder / "groups.u32", np.uint32).astype(np.int32),
        "FibresPerStrand": np.fromfile(folder / "fibres.f32", np.float32),
        "RootUv": np.fromfile(folder / "root_uvs.f32", np.float32).reshape(-1, 2),
    }


def equal(found, expected, what):
    """Ends the program unless `found` has the shape, type and bits of `expected`."""
    found = np.ascontiguousarray(found)
    if found.shape != expected.shape or found.dtype != expected.dtype or found.tobytes() != expected.tobytes():
        sys.exit(f"{what}: found {found.dtype}{found.shape}\n{found}\nexpected {expected.dtype}{expected.shape}\n{expected}")


def check_cells(polydata, what):
    """Strands are polylines root to tip, air particles are vertices, and there is nothing else."""
    own = polydata.GetLines() if kind == "hair" else polydata.GetVerts()
    expected = offsets if kind == "hair" else np.arange(points + 1)
    equal(vtk_to_numpy(own.GetOffsetsArray()), expected, f"{what}, cell offsets")
    equal(vtk_to_numpy(own.GetConnectivityArray()), np.arange(points), f"{what}, connectivity")
    if polydata.GetNumberOfCells() != len(expected) - 1:
        sys.exit(f"{what}: {polydata.GetNumberOfCells()} cells, expected {len(expected) - 1}")


def check_vtk():
    """Every step by its time: forwards, backwards, and the first again."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    equal(np.array(reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())), times, "times in VTK")
    for k in [*range(steps), *reversed(range(steps)), 0]:
        what = f"VTK, step {k}"
        reader.UpdateTimeStep(times[k])
        polydata = reader.GetOutputDataObject(0)
        data = polydata.GetPointData()
        equal(vtk_to_numpy(polydata.GetPoints().GetData()), positions[k], f"{what}, points")
        equal(vtk_to_numpy(data.GetArray("Velocity")), velocities[k], f"{what}, Velocity")
        check_cells(polydata, what)
        if kind == "air":
            for name, expected in scalars.items():
                equal(vtk_to_numpy(data.GetArray(name)), expected[k], f"{what}, {name}")
        if kind == "hair":
            equal(vtk_to_numpy(data.GetArray("Orientation")), orientations[k], f"{what}, Orientation")
            equal(vtk_to_numpy(data.GetArray("Radius")), radius, f"{what}, Radius")
            cells = polydata.GetCellData()
            for name, expected in {**of_strands, "RootFrame": root_frames[k]}.items():
                equal(vtk_to_numpy(cells.GetArray(name)), expected, f"{what}, {name}")


def check_h5py():
    """The format's fixed points and what says where the file comes from."""
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        kind_of_type = root.attrs.get_id("Type").get_type()
        if root.attrs["Type"] != b"PolyData" or kind_of_type.is_variable_str() or kind_of_type.get_cset() != h5py.h5t.CSET_ASCII:
            sys.exit(f"Type is {root.attrs['Type']!r}, expected a fixed-length ASCII string")
        equal(root.attrs["Version"], np.array([2, 0]), "Version")
        if root["Steps"].attrs["NSteps"] != steps:
            sys.exit(f"NSteps is {root['Steps'].attrs['NSteps']}, expected {steps}")
        # Not one more: VTK crashes on those.
        equal(root["Steps/Values"][:], times, "times in h5py")
        # A kill must not come between the two, so they lie side by side: HDF5 then writes them at once.
        header = h5py.h5o.get_info(root["Steps/Values"].id).addr
        if steps.to_bytes(8, "little") not in path.read_bytes()[header - 16 : header]:
            sys.exit("NSteps does not lie right before the header of Values")
        equal(root["Points"][: steps * points], positions.reshape(-1, 3), "points in h5py")
        for name in ["CellOffsets", "ConnectivityIdOffsets"]:
            equal(root["Steps"][name][:steps], np.zeros((steps, 4), np.int64), name)
        equal(root["Steps/PartOffsets"][:steps], np.zeros(steps, np.int64), "PartOffsets")
        equal(root["Steps/NumberOfParts"][:steps], np.ones(steps, np.int64), "NumberOfParts")
        for group in ["Vertices", "Lines", "Strips", "Polygons"]:
            for name in ["NumberOfCells", "NumberOfConnectivityIds", "Offsets", "Connectivity"]:
                if root[group][name].dtype != np.int64:
                    sys.exit(f"{group}/{name} is {root[group][name].dtype}")

        def early_and_contiguous(name, item):
            if isinstance(item, h5py.Dataset) and item.size and name not in ["windswept/scene", "VTKHDF/Steps/Values"]:
                plan = item.id.get_create_plist()
                if item.chunks or plan.get_alloc_time() != h5py.h5d.ALLOC_TIME_EARLY or item.id.get_offset() is None:
                    sys.exit(f"{name} is not contiguous or has no place in the file yet")

        file.visititems(early_and_contiguous)
        source = file["windswept"]
        found = (source.attrs["version"], source.attrs["adapter"], source.attrs["seed"], source["scene"].asstr()[()])
        expected = (version, adapter, int(seed), (folder / "scene.toml").read_text("utf-8"))
        if found != expected:
            sys.exit(f"provenance: found {found}, expected {expected}")


check_vtk()
check_h5py()
print(steps, "steps")
