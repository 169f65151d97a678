//! A film whose every number is different, and the numbers of a file.

#![allow(dead_code, clippy::unwrap_used)] // each test program uses a part of it, and may panic

use std::path::Path;

use windswept_engine::{AirFrame, Frame, HairFrame};
use windswept_export::{Kind, Provenance, VtkHdfReader, VtkHdfWriter};

pub(crate) const KINDS: [Kind; 2] = [Kind::Hair, Kind::Air];

pub(crate) const PROVENANCE: Provenance<'_> = Provenance {
    scene: "title = \"wind, 3 m/s — ρ₀\"\nseed = 18446744073709551615\n",
    version: "0.1.0",
    adapter: "llvmpipe (LLVM 15.0.6, 256 bits) é",
    seed: u64::MAX,
};

/// Strands of 2, 5 and 3 points and 7 air particles; -0.0, the smallest subnormal and the largest f32 among the
/// numbers.
pub(crate) fn frame(k: usize) -> Frame {
    let mut state = k as u32 + 1;
    let mut number = move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / 1e6 - 8.0
    };
    let mut rows = move |n: usize| (0..n).map(|_| [number(), number(), number()]).collect::<Vec<_>>();
    let mut velocities = rows(10);
    velocities[3] = [-0.0, f32::from_bits(1), f32::MAX];
    Frame {
        step: 12 * k as u64,
        time: 12.0 * 1.38e-3 * k as f64,
        hair: HairFrame {
            offsets: vec![0, 2, 7, 10],
            ids: vec![5, 0, 9],
            positions: rows(10),
            velocities,
            orientations: rows(7).iter().map(|&[x, y, z]| [x, y, z, x + y]).collect(),
            root_frames: rows(3).iter().map(|&[x, y, z]| [x, y, z, x - y]).collect(),
            radius: (0..10).map(|i| 4e-5 - 1e-6 * i as f32).collect(),
            fibres: vec![1.0, 180.5, 7.0],
            groups: vec![0, 3, 3],
            root_uvs: vec![[0.5, 0.25], [-0.0, 1.0], [0.1, 7.5]],
            guides: Vec::new(),
        },
        air: AirFrame {
            positions: rows(7),
            velocities: rows(7),
            vorticity: rows(7).iter().map(|row| row[0]).collect(),
            band_energy: rows(7).iter().map(|row| row[1]).collect(),
        },
        bodies: Vec::new(),
    }
}

pub(crate) fn film(frames: usize) -> Vec<Frame> {
    (0..frames).map(frame).collect()
}

/// Writes every number of a film into plain files of a folder, and the scene of [`PROVENANCE`].
pub(crate) fn dump(folder: &Path, film: &[Frame]) {
    let dump = |name: &str, bytes: Vec<u8>| std::fs::write(folder.join(name), bytes).unwrap();
    let bytes = |floats: &[f32]| floats.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let whole = |numbers: &[u32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let floats = |rows: fn(&Frame) -> &[f32]| film.iter().flat_map(|frame| bytes(rows(frame))).collect();
    let still = &film[0].hair;
    dump("times.f64", film.iter().flat_map(|f| f.time.to_le_bytes()).collect());
    dump("offsets.u32", whole(&still.offsets));
    dump("ids.u32", whole(&still.ids));
    dump("groups.u32", whole(&still.groups));
    dump("root_uvs.f32", bytes(still.root_uvs.as_flattened()));
    dump("fibres.f32", bytes(&still.fibres));
    dump("radius.f32", bytes(&still.radius));
    dump("positions.f32", floats(|f| f.hair.positions.as_flattened()));
    dump("velocities.f32", floats(|f| f.hair.velocities.as_flattened()));
    dump("orientations.f32", floats(|f| f.hair.orientations.as_flattened()));
    dump("root_frames.f32", floats(|f| f.hair.root_frames.as_flattened()));
    dump("air_positions.f32", floats(|f| f.air.positions.as_flattened()));
    dump("air_velocities.f32", floats(|f| f.air.velocities.as_flattened()));
    dump("vorticity.f32", floats(|f| &f.air.vorticity));
    dump("band_energy.f32", floats(|f| &f.air.band_energy));
    dump("scene.toml", PROVENANCE.scene.into());
}

/// Writes these frames into a file laid out for `announced`.
pub(crate) fn write(path: &Path, kind: Kind, film: &[Frame], announced: usize) {
    let mut writer = VtkHdfWriter::create(path, kind, &film[0], announced, &PROVENANCE).unwrap();
    for frame in film {
        writer.append(frame).unwrap();
    }
    writer.finish().unwrap();
}

/// How many frames the file shows.
pub(crate) fn finished(path: &Path) -> usize {
    let steps = hdf5::File::open(path).unwrap().group("VTKHDF/Steps").unwrap();
    steps.attr("NSteps").unwrap().read_scalar::<i64>().unwrap() as usize
}

/// Asserts that the file shows exactly these frames, bit by bit, to HDF5 and to our own reader.
pub(crate) fn assert_holds(path: &Path, kind: Kind, film: &[Frame]) {
    assert_reads(path, kind, film);
    assert_eq!(finished(path), film.len(), "frames in {}", path.display());
    let root = hdf5::File::open(path).unwrap().group("VTKHDF").unwrap();
    let start = |name: &str, k: usize| {
        let offsets = root.dataset(&format!("Steps/{name}")).unwrap();
        offsets.read_slice_1d::<i64, _>(k..k + 1).unwrap()[0] as usize
    };
    // Not one more than NSteps, or VTK crashes; a row before there is a frame does no harm.
    assert_eq!(root.dataset("Steps/Values").unwrap().size(), film.len().max(1));
    for (k, frame) in film.iter().enumerate() {
        let time = root.dataset("Steps/Values").unwrap().read_slice_1d::<f64, _>(k..k + 1).unwrap()[0];
        assert_eq!(time.to_bits(), frame.time.to_bits(), "time of frame {k}");
        let (positions, velocities) = match kind {
            Kind::Hair => (&frame.hair.positions, &frame.hair.velocities),
            Kind::Air => (&frame.air.positions, &frame.air.velocities),
        };
        for (name, start, expected) in [
            ("Points", start("PointOffsets", k), positions),
            ("PointData/Velocity", start("PointDataOffsets/Velocity", k), velocities),
        ] {
            let rows = (start..start + expected.len(), ..);
            let found = root.dataset(name).unwrap().read_slice_2d::<f32, _>(rows).unwrap();
            assert!(same_bits(found.as_slice().unwrap(), expected.as_flattened()), "{name} of frame {k}");
        }
    }
}

fn assert_reads(path: &Path, kind: Kind, film: &[Frame]) {
    let reader = VtkHdfReader::open(path).unwrap();
    assert_eq!(reader.kind(), kind);
    assert!(reader.times().iter().map(|t| t.to_bits()).eq(film.iter().map(|f| f.time.to_bits())));
    // Backwards, as frames can be read in any order.
    for (k, expected) in film.iter().enumerate().rev() {
        let found = reader.frame(k).unwrap();
        assert_eq!(found.time.to_bits(), expected.time.to_bits());
        let bits = |frame: &Frame| {
            let rows = match kind {
                Kind::Hair => {
                    let hair = &frame.hair;
                    [
                        hair.positions.as_flattened(),
                        hair.velocities.as_flattened(),
                        hair.orientations.as_flattened(),
                        hair.root_frames.as_flattened(),
                    ]
                }
                Kind::Air => {
                    let air = &frame.air;
                    [air.positions.as_flattened(), air.velocities.as_flattened(), &air.vorticity[..], &air.band_energy]
                }
            };
            rows.map(|row| row.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
        };
        assert!(bits(&found) == bits(expected), "frame {k} as read");
        if kind == Kind::Hair {
            let still = |hair: &HairFrame| {
                let HairFrame { offsets, ids, groups, fibres, radius, root_uvs, .. } = hair.clone();
                (offsets, ids, groups, fibres, radius, root_uvs)
            };
            assert_eq!(still(&found.hair), still(&expected.hair));
        }
    }
    assert!(reader.frame(film.len()).is_err());
}

pub(crate) fn same_bits(a: &[f32], b: &[f32]) -> bool {
    a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()))
}
