//! Heading 2: the passes that sort particles into cells and list who is near whom. Every pass takes what the engine's pass
//! before it left; who is near whom is held against the twin.

use glam::{DVec3, IVec3, Vec3};
use windswept::internals::{Engine, Plan, Recorder, Setup, status, step};
use windswept_reference::{Parameters, neighbours, step::Scratch};
use windswept_scene::{InitialState, Model};
use windswept_shaders::{self as shaders, common::params::Params};

use crate::{
    stage::xyz,
    steps::{CROWDED, Fault, PARTICLES},
    support::{self, Layout, RADIUS, SIZES},
    walk::{Same, Walk, differing, largest},
};

/// Distance that rounding may move a particle across the face of a cell \[m\].
const EDGE: f32 = 2e-7;

/// Cells of the neighbour search, as `shaders/common/cells.wgsl` numbers them.
struct Cells(Params);

impl Cells {
    fn len(&self) -> usize {
        (self.0.box_cells + self.0.hashed_cells) as usize
    }

    fn of(&self, i: usize, x: Vec3) -> usize {
        let (size, cells) = (Vec3::from_array(self.0.box_size), IVec3::from_array(self.0.cells));
        let cell = |x: Vec3| (x / Vec3::from_array(self.0.cell_size)).floor().as_ivec3();
        let in_box = |cell: IVec3| (cell.x + cells.x * (cell.y + cells.y * cell.z)) as usize;
        if i >= self.0.hair_points as usize {
            return in_box(cell(x - size * (x / size).floor()).clamp(IVec3::ZERO, cells - 1));
        }
        let cell = cell(x);
        if cell.cmpge(IVec3::ZERO).all() && cell.cmplt(cells).all() {
            return in_box(cell);
        }
        let [x, y, z] = cell.to_array().map(|k| k as u32);
        let mixed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
        (self.0.box_cells + (mixed & (self.0.hashed_cells - 1))) as usize
    }

    /// Cells that a particle may be in: more than one where it stands at a face.
    fn around(&self, i: usize, x: Vec3) -> Vec<usize> {
        let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) * 2.0 - 1.0;
        let mut cells: Vec<usize> = (0..8).map(|k| self.of(i, x + EDGE * corner(k))).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}

impl Walk<'_> {
    pub fn neighbours(&mut self, w: &mut Scratch) -> Same {
        let stage = self.stage;
        let (state, engine) = (stage.engine.state(), &stage.engine);
        let mut passes = stage.passes(step::neighbours::record);
        neighbours::run(w, self.p());
        if !passes.through("grid/clear") {
            return Ok(());
        }
        let cells = Cells(engine.read(&state.params).unwrap()[0]);
        let counts = || -> Vec<u32> { engine.read(&state.cell_count).unwrap()[..cells.len()].to_vec() };
        let none = vec![0; cells.len()];
        self.same("grid/clear", differing(&counts(), &none), 0.0)?;

        assert!(passes.through("grid/count"));
        let position = engine.read(&state.predicted).unwrap();
        let position: Vec<Vec3> = position.iter().map(|x| Vec3::new(x[0], x[1], x[2])).collect();
        let around: Vec<Vec<usize>> = position.iter().enumerate().map(|(i, x)| cells.around(i, *x)).collect();
        let (mut least, mut most) = (none.clone(), none.clone());
        for cells in &around {
            cells.iter().for_each(|cell| most[*cell] += 1);
            if let [cell] = cells[..] {
                least[cell] += 1;
            }
        }
        let counted = counts();
        let between = |cell: &usize| (least[*cell]..=most[*cell]).contains(&counted[*cell]);
        let outside = (0..cells.len()).filter(|cell| !between(cell)).count();
        self.same("grid/count", outside as f64, 0.0)?;
        let all = counted.iter().sum::<u32>() as f64;
        self.same("grid/count", (all - position.len() as f64).abs(), 0.0)?;

        assert!(passes.through("grid/scan"));
        let sums = counted.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        });
        let wanted: Vec<u32> = std::iter::once(0).chain(sums).collect();
        let start = engine.read(&state.cell_start).unwrap()[..=cells.len()].to_vec();
        self.same("grid/scan", differing(&start, &wanted), 0.0)?;
        self.same("grid/scan", differing(&counts(), &none), 0.0)?;

        assert!(passes.through("grid/scatter"));
        let mut scattered = engine.read(&state.scattered).unwrap();
        let ranges = || start.windows(2).map(|ends| ends[0] as usize..ends[1] as usize).enumerate();
        let strays = |entries: &[u32], cell: usize| {
            entries.iter().filter(|i| !around.get(**i as usize).is_some_and(|cells| cells.contains(&cell))).count()
        };
        let astray: usize = ranges().map(|(cell, range)| strays(&scattered[range], cell)).sum();
        self.same("grid/scatter", astray as f64, 0.0)?;
        // Ordered by cell, then by index: what `order` is to leave.
        ranges().for_each(|(_, range)| scattered[range].sort_unstable());
        let mut once = scattered.clone();
        once.sort_unstable();
        self.same("grid/scatter", differing(&once, &(0..once.len() as u32).collect::<Vec<_>>()), 0.0)?;

        assert!(passes.through("grid/order"));
        self.same("grid/order", differing(&engine.read(&state.sorted).unwrap(), &scattered), 0.0)?;
        let places = engine.read(&state.sorted_position).unwrap();
        let wanted: Vec<_> = scattered.iter().map(|i| w.predicted[*i as usize]).collect();
        let gaps = places.iter().zip(scattered.iter().zip(&wanted)).map(|(got, (i, x))| {
            let air = self.p().is_air(*i as usize);
            let gap = self.places(&[xyz(&got[..3])], &[*x], *i as usize);
            if got[3] == f32::from(air) { gap } else { f64::INFINITY }
        });
        let gap = largest(gaps);
        self.same("grid/order", gap, self.bounds.length)?;

        assert!(passes.through("grid/neighbours"));
        let off = self.pairs_apart(w);
        self.same("grid/neighbours", off, 2.0 * self.bounds.length)?;
        passes.finish();
        Ok(())
    }

    /// Largest distance from the kernel radius of a pair that only engine or only twin lists \[m\]: of pairs at the radius itself
    /// rounding decides.
    fn pairs_apart(&self, w: &Scratch) -> f64 {
        let (engine, p) = (&self.stage.engine, self.p());
        let ranges = engine.read(&engine.state().neighbour_range).unwrap();
        let list = engine.read(&engine.state().neighbour_list).unwrap();
        let mut off = 0.0_f64;
        for (i, near) in ranges.into_iter().enumerate() {
            let kinds = [(near.first, near.apart), (near.apart, near.middle), (near.middle, near.end)]
                .map(|(from, to)| &list[from as usize..to as usize]);
            if !sorted_by_kind(p, i, kinds) {
                return f64::INFINITY;
            }
            let mut got: Vec<usize> =
                list[near.first as usize..near.end as usize].iter().map(|&j| j as usize).collect();
            got.sort_unstable();
            if got.windows(2).any(|pair| pair[0] == pair[1]) {
                return f64::INFINITY;
            }
            let extra = got.iter().filter(|j| !w.near.of(i).any(|k| k == **j)).copied();
            let missing = w.near.of(i).filter(|j| got.binary_search(j).is_err());
            let x = &w.predicted;
            let from_edge = |j: usize| p.separation(i, j, x[i], x[j]).length() - p.kernel_radius;
            off = extra.chain(missing).map(|j| from_edge(j).abs()).fold(off, f64::max);
        }
        off
    }
}

/// Whether the list of a particle has its own kind first, of that the other strands first, and the other kind behind it. With
/// `particles` all are one kind.
fn sorted_by_kind(p: &Parameters, i: usize, kinds: [&[u32]; 3]) -> bool {
    let kind = |j: usize| match (p.is_air(i), p.is_air(j)) {
        _ if p.model != Model::TwoWay => 0,
        (false, false) => usize::from(p.strand_of[i] == p.strand_of[j]),
        (own, other) => 2 * usize::from(own != other),
    };
    (0..3).all(|k| kinds[k].iter().all(|&j| kind(j as usize) == k))
}

/// Planted faults of the passes of this heading.
pub const FAULTS: &[Fault] = &[
    (&shaders::grid::CLEAR, "cell_count[bucket] = 0u", "cell_count[bucket] = 1u", PARTICLES),
    (&shaders::grid::COUNT, "predicted[i].xyz)], 1u", "predicted[i].xyz)], 2u", PARTICLES),
    (&shaders::grid::SCAN, "running += cell_count[b]", "running += cell_count[b] + u32(b == 9u)", PARTICLES),
    (&shaders::grid::SCATTER, "1u)] = i", "1u)] = max(i, 1u)", PARTICLES),
    (&shaders::grid::ORDER, "scattered[e] < i", "scattered[e] > i", PARTICLES),
    (
        &shaders::grid::NEIGHBOURS,
        "Near(first, places.y, places.z, first + total)",
        "Near(first + min(found.x, 1u), places.y, places.z, first + total)",
        PARTICLES,
    ),
    (&shaders::grid::NEIGHBOURS, "j < strand.y", "j + 1u < strand.y", CROWDED),
];

/// Neighbours that heading 2 lists of the initial positions; the list grows as the simulation would grow it.
fn lists(initial: &InitialState) -> Vec<Vec<u32>> {
    let scene = support::scene();
    let setup = Setup::new(&scene, initial);
    let mut engine = Engine::new(&support::gpu(), &setup).unwrap();
    let recording = Recorder::record(engine.state(), |r| step::neighbours::record(r, &Plan::new(&setup)));
    engine.copy_state_to_scratch().unwrap();
    engine.replay(&recording).unwrap();
    let mut state = engine.status().unwrap();
    if state.neighbours > engine.sizes().neighbours {
        engine.grow_neighbours(state.neighbours).unwrap();
        engine.set_status(&status::thawed(&state)).unwrap();
        engine.replay(&recording).unwrap();
        state = engine.status().unwrap();
    }
    assert!(state.neighbours <= engine.sizes().neighbours, "needed {} again", state.neighbours);
    let ranges = engine.read(&engine.state().neighbour_range).unwrap();
    let list = engine.read(&engine.state().neighbour_list).unwrap();
    let lists = ranges.iter().map(|near| list[near.first as usize..near.end as usize].to_vec());
    lists.collect()
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
    for n in SIZES {
        let spread =
            [(0, Layout::Random), (n / 3, Layout::Random), (n / 3, Layout::Lattice), (n / 4, Layout::Clustered)];
        // The largest size in one cell would be 2e8 pairs.
        let crowded = [(0, Layout::OneCell), (n / 3, Layout::OneCell)].into_iter().filter(|_| n < 1000);
        for (hair, layout) in spread.into_iter().chain(crowded) {
            let initial = support::particles(n, hair, layout, n as u64);
            assert_same_pairs(&initial, &lists(&initial), &format!("{n} particles, {hair} of hair, {layout:?}"));
        }
    }
}
