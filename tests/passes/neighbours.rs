//! Stage `neighbours`: the passes that sort particles into cells and list neighbours. Every pass takes the results
//! of the engine's pass before it; the neighbours are compared with the reference.

use std::ops::Range;

use glam::{DVec3, IVec3, Vec3};
use windswept::{
    Gpu, RunError, ShaderVariant,
    internals::{
        Engine, Plan, Setup,
        clusters::{self, Cluster, Seen},
        step, with_sources, with_variant,
    },
};
use windswept_reference::Parameters;
use windswept_scene::{InitialState, Model};
use windswept_shaders::{
    self as shaders,
    common::{lanes::LANES, params::Params, row::Row as RowOfCells},
};

use crate::{
    fixture::xyz,
    steps::{CROWDED, Fault, PARTICLES},
    support::{self, Layout, RADIUS, SIZES},
    walk::{Both, EXACT, LENGTH, Row, differing, largest},
};

/// Distance that rounding may move a particle across the face of a cell \[m\].
const EDGE: f32 = 2e-7;

/// Cells of the neighbour search, as `shaders/common/cells.wgsl` numbers them.
struct Cells(Params);

impl Cells {
    fn len(&self) -> usize {
        self.0.box_cells as usize * if self.0.hair_points > 0 { 2 } else { 1 }
    }

    /// Cells of a row along x.
    fn in_row(&self) -> usize {
        self.0.cells[0] as usize
    }

    /// Entries of each row, from those of each cell.
    fn in_rows(&self, counts: &[u32]) -> Vec<u32> {
        counts.chunks(self.in_row()).map(|row| row.iter().sum()).collect()
    }

    fn of(&self, i: usize, x: Vec3) -> usize {
        let (size, cells) = (Vec3::from_array(self.0.box_size), IVec3::from_array(self.0.cells));
        let inside = x - size * (x / size).floor();
        let cell = (inside / Vec3::from_array(self.0.cell_size)).floor().as_ivec3().clamp(IVec3::ZERO, cells - 1);
        let hair = i < self.0.hair_points as usize;
        (cell.x + cells.x * (cell.y + cells.y * cell.z)) as usize + if hair { self.0.box_cells as usize } else { 0 }
    }

    /// Cells that a particle may be in: more than one where it stands at a face.
    fn around(&self, i: usize, x: Vec3) -> Vec<usize> {
        let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) * 2.0 - 1.0;
        let mut cells: Vec<usize> = (0..8).map(|k| self.of(i, x + EDGE * corner(k))).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// Clusters of rows with so many entries: of each its first entry, and their end; hair's first.
    fn members(&self, in_row: &[u32]) -> Vec<[u32; 2]> {
        let mut members = vec![[0; 2]; self.0.clusters as usize];
        let of_air = self.0.box_cells as usize / self.in_row();
        let (mut entry, mut next) = (0, self.0.hair_clusters as usize);
        for (row, entries) in in_row.iter().enumerate() {
            if row == of_air {
                next = 0;
            }
            let end = entry + entries;
            while entry < end {
                members[next] = [entry, end.min(entry + LANES)];
                (entry, next) = (members[next][1], next + 1);
            }
        }
        members
    }
}

/// Comparisons of the passes of this stage. Each takes what the engine's pass before it left.
pub const ROWS: &[Row] = &[
    ("sort/clear", |b| Sorted::of(b).counts.iter().filter(|count| **count != 0).count() as f64, EXACT),
    (
        "sort/count",
        |b| {
            let Sorted { around, counts, .. } = Sorted::of(b);
            let (mut least, mut most) = (vec![0; counts.len()], vec![0; counts.len()]);
            for cells in &around {
                cells.iter().for_each(|cell| most[*cell] += 1);
                least[cells[0]] += u32::from(cells.len() == 1);
            }
            let outside = (0..counts.len()).filter(|cell| !(least[*cell]..=most[*cell]).contains(&counts[*cell]));
            outside.count() as f64 + (f64::from(counts.iter().sum::<u32>()) - around.len() as f64).abs()
        },
        EXACT,
    ),
    ("sort/total", |b| rows_differ(b, &Sorted::of(b).rows()), EXACT),
    (
        "sort/scan",
        |b| {
            let before = Sorted::of(b).rows().into_iter().scan(RowOfCells::default(), |sum, row| {
                let before = *sum;
                *sum = RowOfCells { entries: sum.entries + row.entries, clusters: sum.clusters + row.clusters };
                Some(before)
            });
            rows_differ(b, &before.collect::<Vec<_>>())
        },
        EXACT,
    ),
    (
        "sort/start",
        |b| {
            let Sorted { cells, counts, starts, .. } = &Sorted::of(b);
            let wanted: Vec<u32> = (0..=counts.len()).map(|cell| counts[..cell].iter().sum()).collect();
            differing(starts, &wanted) + differing(&b.read(&b.state().members), &cells.members(&cells.in_rows(counts)))
        },
        EXACT,
    ),
    (
        "sort/scatter",
        |b| {
            let (sorted, mut once) = (Sorted::of(b), Sorted::of(b).scattered(b));
            let strays = |(cell, range): (usize, Range<usize>)| {
                let of_cell = |i: &u32| sorted.around.get(*i as usize).is_some_and(|cells| cells.contains(&cell));
                once[range].iter().filter(|i| !of_cell(i)).count()
            };
            let astray: usize = sorted.ranges().map(strays).sum();
            once.sort_unstable();
            astray as f64 + differing(&once, &(0..once.len() as u32).collect::<Vec<_>>())
        },
        EXACT,
    ),
    ("sort/order", |b| differing(&b.read(&b.state().sorted), &Sorted::of(b).scattered(b)), EXACT),
    (
        "sort/order",
        |b| {
            let places = b.read(&b.state().sorted_position);
            largest(places.iter().zip(Sorted::of(b).scattered(b)).map(|(got, i)| {
                let i = i as usize;
                let gap = b.places(&[xyz(&got[..3])], &[b.w.predicted[i]], i);
                if got[3] == f32::from(b.p().is_air(i)) { gap } else { f64::INFINITY }
            }))
        },
        LENGTH,
    ),
    ("neighbours/list", |b| 0.5 * b.pairs_apart(), LENGTH),
];

/// State of the engine's sort.
struct Sorted {
    cells: Cells,
    /// Cells that each particle may be in.
    around: Vec<Vec<usize>>,
    /// Entries of each cell.
    counts: Vec<u32>,
    /// First entry of each cell, and the end of the last.
    starts: Vec<u32>,
}

impl Sorted {
    fn of(b: &Both<'_>) -> Self {
        let (state, cells) = (b.state(), Cells(b.read(&b.state().params)[0]));
        let around = |(i, x): (usize, &[f32; 4])| cells.around(i, Vec3::new(x[0], x[1], x[2]));
        let around = b.read(&state.predicted).iter().enumerate().map(around).collect();
        let counts = b.read(&state.cell_count)[..cells.len()].to_vec();
        let starts = b.read(&state.cell_start)[..=cells.len()].to_vec();
        Self { cells, around, counts, starts }
    }

    fn rows(&self) -> Vec<RowOfCells> {
        let row = |entries: u32| RowOfCells { entries, clusters: entries.div_ceil(LANES) };
        self.cells.in_rows(&self.counts).into_iter().map(row).collect()
    }

    /// Entries of each cell.
    fn ranges(&self) -> impl Iterator<Item = (usize, Range<usize>)> {
        self.starts.windows(2).map(|ends| ends[0] as usize..ends[1] as usize).enumerate()
    }

    /// Particles by cell, then by index, as the pass that orders them is to leave them.
    fn scattered(&self, b: &Both<'_>) -> Vec<u32> {
        let mut scattered = b.read(&b.state().scattered);
        self.ranges().for_each(|(_, range)| scattered[range].sort_unstable());
        scattered
    }
}

fn rows_differ(b: &Both<'_>, wanted: &[RowOfCells]) -> f64 {
    differing(&b.read(&b.state().cell_rows)[..wanted.len()], wanted)
}

impl Both<'_> {
    /// Largest distance from the kernel radius of a pair that only engine or only reference lists \[m\]: of pairs at
    /// the radius itself rounding decides. A list that does not hold to its layout is infinitely far off.
    fn pairs_apart(&self) -> f64 {
        let (engine, p, w) = (self.engine(), self.p(), self.w);
        let clusters = engine.clusters().unwrap();
        if !each_once(&clusters, w.predicted.len()) || !clusters.iter().all(|cluster| of_kinds(p, cluster)) {
            return f64::INFINITY;
        }
        let all = lists(engine);
        let mut off = self.images_apart(&clusters, &w.predicted);
        for (i, got) in all.iter().enumerate() {
            if got.windows(2).any(|pair| pair[0] == pair[1]) {
                return f64::INFINITY;
            }
            let extra = got.iter().map(|j| *j as usize).filter(|j| !w.near.of(i).any(|k| k == *j));
            let missing = w.near.of(i).filter(|j| got.binary_search(&(*j as u32)).is_err());
            let x = &w.predicted;
            let from_edge = |j: usize| p.separation(i, j, x[i], x[j]).length() - p.kernel_radius;
            off = extra.chain(missing).map(|j| from_edge(j).abs()).fold(off, f64::max);
        }
        off
    }

    /// Largest difference between where a particle sees another of its list, by the image that the entry names, and
    /// where the reference has the nearest one \[m\].
    fn images_apart(&self, clusters: &[Cluster], x: &[DVec3]) -> f64 {
        let p = self.p();
        let seen = clusters.iter().flat_map(|cluster| {
            let near = cluster.own_kind.iter().chain(&cluster.other_kind);
            near.flat_map(move |near| {
                cluster.particles.iter().enumerate().map(move |(lane, i)| (lane, *i as usize, near))
            })
        });
        let gaps = seen.filter(|(lane, _, near)| near.met_by >> lane & 1 == 1).map(|(_, i, near)| {
            let j = near.index as usize;
            let gap = x[i] - x[j] - near.image.as_dvec3() * p.box_size;
            (gap - p.separation(i, j, x[i], x[j])).length()
        });
        largest(gaps)
    }
}

/// Whether every particle is in one cluster.
fn each_once(clusters: &[Cluster], particles: usize) -> bool {
    let mut all: Vec<u32> = clusters.iter().flat_map(|cluster| cluster.particles.clone()).collect();
    all.sort_unstable();
    all == (0..particles as u32).collect::<Vec<_>>()
}

/// Whether a cluster is of one kind, and its list has those of its own kind first; unless the model is `two-way` all
/// are one kind there.
fn of_kinds(p: &Parameters, cluster: &Cluster) -> bool {
    let air = p.is_air(cluster.particles[0] as usize);
    let is = |near: &Seen, kind: bool| p.is_air(near.index as usize) == kind;
    let apart = p.interaction.model == Model::TwoWay;
    cluster.particles.iter().all(|i| p.is_air(*i as usize) == air)
        && cluster.own_kind.iter().all(|near| !apart || is(near, air))
        && cluster.other_kind.iter().all(|near| apart && is(near, !air))
}

/// Neighbours of each particle, as the engine's list has them.
fn lists(engine: &Engine) -> Vec<Vec<u32>> {
    clusters::neighbours(&engine.clusters().unwrap(), engine.params().particles)
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::sort::CLEAR, PARTICLES, &[12]),
    (&shaders::sort::COUNT, PARTICLES, &[9]),
    (&shaders::sort::TOTAL, PARTICLES, &[18]),
    (&shaders::sort::SCAN, PARTICLES, &[24]),
    (&shaders::sort::START, PARTICLES, &[26, 55]),
    (&shaders::sort::SCATTER, PARTICLES, &[11]),
    (&shaders::sort::ORDER, PARTICLES, &[19]),
    (&shaders::neighbours::LIST, PARTICLES, &[191]),
    (&shaders::neighbours::LIST, CROWDED, &[272, 304]),
];

/// Neighbours that stage `neighbours` lists of the initial positions; the list grows as the simulation would grow it.
fn listed(gpu: &Gpu, initial: &InitialState) -> Vec<Vec<u32>> {
    let scene = support::scene().check().unwrap();
    let setup = Setup::new(&scene, initial);
    let mut engine = Engine::new(gpu, &setup).unwrap();
    engine.evaluate(|r| step::neighbours::record(r, &Plan::new(&setup))).unwrap();
    let state = engine.status().unwrap();
    assert!(state.neighbours <= engine.sizes().neighbours, "needed {} again", state.neighbours);
    lists(&engine)
}

/// Asserts that pairs are those of the pair test, but for those whose distance is the radius to f32.
fn assert_same_pairs(initial: &InitialState, lists: &[Vec<u32>], what: &str) {
    let hair = initial.hair.positions.len();
    let all: Vec<DVec3> = initial.hair.positions.iter().chain(&initial.air.positions).copied().collect();
    let side = initial.air.size;
    let distance = |i: usize, j: usize| {
        let mut gap = all[i] - all[j];
        if i >= hair && j >= hair {
            gap -= side * (gap / side).round();
        }
        gap.length()
    };
    assert_eq!(lists.len(), all.len());
    let mut pairs = 0;
    for (i, list) in lists.iter().enumerate() {
        let mut found = list.clone();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), list.len(), "{what}: particle {i} lists a neighbour twice");
        let mut next = found.iter().peekable();
        for j in 0..all.len() {
            let listed = next.next_if(|&&k| k as usize == j).is_some();
            let r = distance(i, j);
            // f32 positions of up to 0.3 m are good to 3e-8 m.
            let near = i != j && r < RADIUS;
            pairs += usize::from(near);
            assert!(listed == near || (r - RADIUS).abs() < 1e-7, "{what}: {i} and {j} at {r} m, listed: {listed}");
        }
    }
    println!("{what}: {} particles, {pairs} pairs", all.len());
}

#[test]
fn neighbours_are_those_of_the_pair_test() {
    pairs_on(&support::gpu(), &SIZES);
}

/// A device without subgroup operations has another variant of the passes.
#[test]
fn neighbours_are_the_same_without_subgroups() {
    pairs_on(&with_variant(&support::gpu(), ShaderVariant::Workgroup), &SIZES[..2]);
}

fn pairs_on(gpu: &Gpu, sizes: &[usize]) {
    for &n in sizes {
        let spread =
            [(0, Layout::Random), (n / 3, Layout::Random), (n / 3, Layout::Lattice), (n / 4, Layout::Clustered)];
        // The largest size in one cell would be 2e8 pairs.
        let crowded = [(0, Layout::OneCell), (n / 3, Layout::OneCell)].into_iter().filter(|_| n < 1000);
        for (hair, layout) in spread.into_iter().chain(crowded) {
            let initial = support::particles(n, hair, layout, n as u64);
            assert_same_pairs(&initial, &listed(gpu, &initial), &format!("{n} particles, {hair} of hair, {layout:?}"));
        }
    }
}

/// The place of a neighbour that the pass keeps counts up to 524288 particles of a row of cells. With more the step is
/// an error, and lists no particle in another's place.
#[test]
fn a_row_of_too_many_particles_is_an_error() {
    let pass = &shaders::neighbours::LIST;
    let (right, fewer) = ("PLACES: u32 = 524288u", "PLACES: u32 = 8u");
    assert!(pass.source.contains(right), "{}", pass.source);
    let gpu = with_sources(&support::gpu(), [(pass.name, pass.source.replace(right, fewer))]);
    let scene = support::scene().check().unwrap();
    let initial = support::particles(500, 0, Layout::OneCell, 1);
    let setup = Setup::new(&scene, &initial);
    let mut engine = Engine::new(&gpu, &setup).unwrap();
    let ended = engine.evaluate(|r| step::neighbours::record(r, &Plan::new(&setup)));
    assert!(matches!(ended, Err(RunError::TooManyNeighbours { needed, .. }) if needed > 1 << 32), "{ended:?}");
    // Only a measurement asked for so many: the next step does not stand still.
    assert_eq!(engine.status().unwrap().causes, 0);
}
