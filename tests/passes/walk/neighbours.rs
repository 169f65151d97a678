//! Heading 2. Every pass takes what the engine's pass before it left; who is near whom is held against the twin.

use glam::{IVec3, Vec3};
use windswept::internals::step;
use windswept_reference::{
    Parameters,
    step::{self as twin, Scratch},
};
use windswept_scene::Model;
use windswept_shaders::common::params::Params;

use super::{Same, Walk, differing};
use crate::stage::xyz;

/// How far rounding may move a particle across the face of a cell \[m\].
const EDGE: f32 = 2e-7;

/// The cells of the neighbour search, as `shaders/common/cells.wgsl` numbers them.
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

    /// The cells that a particle may be in: more than one where it stands at a face.
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
        twin::neighbours(w, self.p());
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
        let gap = super::largest(gaps);
        self.same("grid/order", gap, self.bounds.length)?;

        assert!(passes.through("grid/neighbours"));
        let off = self.pairs_apart(w);
        self.same("grid/neighbours", off, 2.0 * self.bounds.length)?;
        passes.finish();
        Ok(())
    }

    /// How far from a kernel radius apart a pair may be that only one of the two lists: of pairs at the radius itself rounding
    /// decides \[m\].
    fn pairs_apart(&self, w: &Scratch) -> f64 {
        let (engine, p) = (&self.stage.engine, self.p());
        let ranges = engine.read(&engine.state().neighbour_range).unwrap();
        let list = engine.read(&engine.state().neighbour_list).unwrap();
        let mut off = 0.0_f64;
        for (i, near) in ranges.into_iter().enumerate() {
            let kinds =
                [&list[near.first as usize..near.middle as usize], &list[near.middle as usize..near.end as usize]];
            if p.model == Model::TwoWay && !sorted_by_kind(p, i, kinds) {
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

/// Whether the list of a particle has its own kind first, and the other behind it.
fn sorted_by_kind(p: &Parameters, i: usize, kinds: [&[u32]; 2]) -> bool {
    let own = |j: &u32| p.is_air(*j as usize) == p.is_air(i);
    kinds[0].iter().all(own) && !kinds[1].iter().any(own)
}
