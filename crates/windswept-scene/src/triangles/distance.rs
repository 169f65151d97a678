//! Signed distance from a closed surface at the nodes of a grid, and between them.

use std::{
    num::NonZero,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    thread,
};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::{
    Triangles,
    tree::{Looks, Tree},
};
use crate::{error::SceneError, limits::MAX_GRID_VALUES, solid};

/// Reach of distances that are measured from triangles \[spacings\]. Beyond it a node takes the point of the surface
/// that is nearest to a node beside it: that is quicker, and the farther away the surface is, the less it matters which
/// of its points is taken.
const BAND: f64 = 8.0;
/// Most that is looked at for a node, on average \[nodes of the tree\]: eight times as much as for a ball of 260 000
/// triangles, which takes the most, 146, of all meshes that tests have; a ball of [`crate::limits::MAX_TRIANGLES`]
/// would take four times as much as that.
const MAX_LOOKS: u64 = 1200;
/// Nodes along an axis, of which one is tried before all are filled.
const TRIED: usize = 8;
/// Fewest cells between the surface and the sides of the grid.
const MARGIN: f64 = 2.0;
/// Spacing of a grid that is not said otherwise \[m\]: on a ball of 90 mm it is off by 11 µm.
const SPACING: f64 = 0.002;
/// Depth of a node that is on the surface, by rounding \[spacings\].
const ROUNDING: f64 = 1e-6;
/// Fewest cells along the longest side of such a grid's surface.
const CELLS: f64 = 128.0;

/// Limit on the looks for some nodes of a grid, all rows together.
struct Patience {
    spent: AtomicU64,
    most: u64,
}

impl Patience {
    /// Looks after which a row adds its own to those of all.
    const SHARE: u64 = 1 << 12;

    fn new(nodes: usize) -> Self {
        Self { spent: AtomicU64::new(0), most: MAX_LOOKS * nodes as u64 }
    }

    /// Whether it is too much, once what a row has looked at is worth adding.
    fn ends(&self, looks: &mut Looks) -> bool {
        looks.0 >= Self::SHARE && self.spend(looks) > self.most
    }

    /// Adds what a row has looked at to that of all, and says how much that is.
    fn spend(&self, looks: &mut Looks) -> u64 {
        let looked = std::mem::take(&mut looks.0);
        self.spent.fetch_add(looked, Ordering::Relaxed) + looked
    }

    /// An error where it was too much.
    fn check(&self) -> Result<(), SceneError> {
        if self.spent.load(Ordering::Relaxed) <= self.most {
            return Ok(());
        }
        let words =
            "so many triangles lie close to one another that their distances would take very long: expected a surface";
        Err(SceneError::new(words).with_help("leave out what is inside, or lies upon others").at("surface", None))
    }
}

/// What is known of the surface at a node.
#[derive(Clone, Copy)]
pub(super) struct Near {
    pub(super) distance: f32,
    /// The nearest point, and the index of its triangle, where that is kept.
    pub(super) point: Vec3,
    pub(super) face: u32,
}

impl Near {
    pub(super) const NONE: Self = Self { distance: f32::INFINITY, point: Vec3::INFINITY, face: u32::MAX };
}

/// Runs over things on all cores.
pub(super) fn share<T: Send>(things: impl Iterator<Item = T> + Send, run: impl Fn(T) + Sync) {
    let most = things.size_hint().0.max(1);
    let waiting = Mutex::new(things);
    let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some(thing) = next() {
            run(thing);
        }
    };
    let threads = thread::available_parallelism().map_or(1, NonZero::get).min(most);
    thread::scope(|scope| {
        // Without another thread this one does all.
        (1..threads).map_while(|_| thread::Builder::new().spawn_scoped(scope, work).ok()).for_each(drop);
        work();
    });
}

/// Runs over rows of nodes along x on all cores: with a row's indices along y and z, and what is at its nodes.
pub(super) fn rows_of<T: Send>(nodes: &mut [T], counts: [usize; 3], run: impl Fn([usize; 2], &mut [T]) + Sync) {
    let rows = nodes.chunks_exact_mut(counts[0]).enumerate();
    share(rows, |(row, nodes)| run([row % counts[1], row / counts[1]], nodes));
}

/// Goes over all nodes in each of the 8 diagonal directions, and gives each the point of the surface that a node before
/// it has, if that is nearer (Danielsson 1980, Euclidean distance mapping).
pub(super) fn spread(nodes: &mut [Near], [nx, ny, nz]: [usize; 3], spacing: f32) {
    for way in 0..8 {
        let seat = |k: usize, count: usize, bit: u32| if way & bit == 0 { k } else { count - 1 - k };
        for (k, j) in (0..nz).flat_map(|k| (0..ny).map(move |j| (k, j))) {
            let (z, y) = (seat(k, nz, 4), seat(j, ny, 2));
            for i in 0..nx {
                let x = seat(i, nx, 1);
                let own = (z * ny + y) * nx + x;
                let place = spacing * Vec3::new(x as f32, y as f32, z as f32);
                for (first, stride, bit) in [(i == 0, 1, 1), (j == 0, nx, 2), (k == 0, nx * ny, 4)] {
                    if first {
                        continue;
                    }
                    let other = nodes[if way & bit == 0 { own - stride } else { own + stride }];
                    let distance = place.distance(other.point);
                    if distance < nodes[own].distance {
                        nodes[own] = Near { distance, ..other };
                    }
                }
            }
        }
    }
}

/// Signed distance from a closed surface, negative inside, at the nodes of a grid of cubes.
///
/// Between nodes the distance is trilinear: next to a surface with the radius of curvature R it is off by up to h²/(4
/// R), h being the spacing, and its gradient is continuous in a cell only. Farther than eight spacings from the surface
/// a node may have a distance that is too large by up to a quarter of a spacing, as measured on balls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DistanceGrid {
    /// First node \[m\].
    pub origin: DVec3,
    /// Distance between nodes along an axis \[m\].
    pub spacing: f64,
    /// Number of nodes along x, y and z.
    pub counts: [u32; 3],
    /// Distance at each node \[m\], x running fastest, then y.
    pub values: Vec<f32>,
}

/// Cells of a grid along each side of a surface \[m\].
fn cells(size: DVec3, margin: f64, spacing: f64) -> DVec3 {
    ((size + 2.0 * margin) / spacing).ceil()
}

impl DistanceGrid {
    /// The default spacing for a surface in a box of these corners \[m\]: 2 mm, or so much less that its longest side
    /// has 128 cells, or for a side of up to 2 m so much more, in tenths of a millimetre, that the grid of a mesh's
    /// [`Solid`](crate::Solid) has at most [`MAX_GRID_VALUES`] nodes.
    #[must_use]
    pub fn spacing_for(bounds: [DVec3; 2]) -> f64 {
        Self::spacing_within(bounds, MAX_GRID_VALUES as f64)
    }

    /// As [`Self::spacing_for`], of a grid that has at most so many nodes.
    pub(crate) fn spacing_within([low, high]: [DVec3; 2], most: f64) -> f64 {
        let size = high - low;
        let mut spacing = SPACING.min(size.max_element() / CELLS);
        let fits = |spacing: f64| (cells(size, solid::MARGIN * spacing, spacing) + 1.0).element_product() <= most;
        while size.max_element() <= *solid::LIKELY.end() && !fits(spacing) {
            spacing = (1e4 * spacing + 1.0).round() / 1e4;
        }
        spacing
    }

    /// The distances of a surface without holes ([`Triangles::closed`]) in metres, with nodes `spacing` \[m\] apart
    /// that reach at least `margin` \[m\] beyond it. Points that the surface winds about, either way, are inside.
    ///
    /// Rows of nodes are shared out to the machine's cores; the values do not depend on how many there are.
    ///
    /// # Errors
    /// [`SceneError`] where the spacing is not above 0, the grid would have too many nodes, or no node is inside; and
    /// where so many triangles lie close to one another, or across, that their distances would take very long.
    /// Triangles with the same corners cost no more than one. Its key is the argument that is at fault, where it is one
    /// alone.
    pub fn bake(surface: &Triangles, spacing: f64, margin: f64) -> Result<Self, SceneError> {
        if spacing.is_nan() || spacing <= 0.0 {
            return Err(SceneError::new(format!("expected a spacing above 0, found {spacing} m")));
        }
        let [low, high] = surface.bounds().ok_or_else(|| SceneError::new("expected a triangle").at("surface", None))?;
        let margin = margin.max(MARGIN * spacing);
        let cells = cells(high - low, margin, spacing);
        let nodes = (cells + 1.0).element_product();
        if nodes.is_nan() || nodes > MAX_GRID_VALUES as f64 {
            let size = high - low;
            let words = format!(
                "a grid of {} m about {:.3} x {:.3} x {:.3} m has {nodes:.2e} nodes and takes {:.2e} bytes; expected at most \
                 {MAX_GRID_VALUES} nodes",
                spacing as f32,
                size.x,
                size.y,
                size.z,
                4.0 * nodes,
            );
            return Err(SceneError::new(words).with_help("a larger resolution has fewer nodes").at("spacing", None));
        }
        let hollow = || {
            let words =
                format!("the triangles enclose no node of a grid of {} m: expected a closed surface", spacing as f32);
            let help = format!(
                "a body has an inside: give a flat mesh a thickness of {} m or more, or a thin one a smaller resolution",
                2.0 * spacing as f32
            );
            SceneError::new(words).with_help(help)
        };
        // A flat one needs no grid to tell, which takes seconds.
        if surface.thickness() <= ROUNDING * spacing {
            return Err(hollow());
        }
        let counts = (cells + 1.0).to_array().map(|count| count as u32);
        let origin = 0.5 * (low + high - spacing * cells);
        let mut grid = Self { origin, spacing, counts, values: vec![0.0; nodes as usize] };
        grid.fill(&Tree::new(surface))?;
        if grid.inradius() <= ROUNDING * spacing {
            return Err(hollow());
        }
        Ok(grid)
    }

    /// Distances near the surface from the triangles, beyond from the points of the surface that neighbours are nearest
    /// to, and signs last.
    fn fill(&mut self, tree: &Tree) -> Result<(), SceneError> {
        let (origin, spacing) = (self.origin, self.spacing);
        self.try_some(tree)?;
        let patience = Patience::new(self.values.len());
        let mut nodes = vec![Near::NONE; self.values.len()];
        self.each_row(&mut nodes, |start, row| {
            let mut looks = Looks::default();
            for (i, node) in row.iter_mut().enumerate() {
                let x = start + spacing * i as f64 * DVec3::X;
                if let Some(near) = tree.nearest(x, BAND * spacing, &mut looks) {
                    *node = Near { distance: x.distance(near) as f32, point: (near - origin).as_vec3(), ..Near::NONE };
                }
                if patience.ends(&mut looks) {
                    return;
                }
            }
            patience.spend(&mut looks);
        });
        patience.check()?;
        spread(&mut nodes, self.counts.map(|count| count as usize), spacing as f32);
        let mut values: Vec<_> = nodes.into_iter().map(|node| node.distance).collect();
        self.each_row(&mut values, |start, row| {
            let (mut looks, mut within) = (Looks::default(), None);
            for (i, value) in row.iter_mut().enumerate() {
                let x = start + spacing * i as f64 * DVec3::X;
                let away = *value;
                if *within.get_or_insert_with(|| tree.winding(x, &mut looks).abs() > 0.5) {
                    *value = -away;
                }
                // A node that is farther from the surface than a spacing has the next one on its side.
                if away <= 1.001 * spacing as f32 {
                    within = None;
                }
                if patience.ends(&mut looks) {
                    return;
                }
            }
            patience.spend(&mut looks);
        });
        patience.check()?;
        self.values = values;
        Ok(())
    }

    /// Looks for the distances and signs of a few nodes, which are soon too many where those of all would take very
    /// long.
    fn try_some(&self, tree: &Tree) -> Result<(), SceneError> {
        let [columns, rows, layers] = self.counts.map(|count| (0..count).step_by(TRIED));
        let patience = Patience::new(columns.len() * rows.len() * layers.len());
        let mut looks = Looks::default();
        for (z, y) in layers.flat_map(|z| rows.clone().map(move |y| (z, y))) {
            for x in columns.clone() {
                let place = self.origin + self.spacing * DVec3::new(x.into(), y.into(), z.into());
                if tree.nearest(place, BAND * self.spacing, &mut looks).is_some() {
                    tree.winding(place, &mut looks);
                }
                if patience.ends(&mut looks) {
                    return patience.check();
                }
            }
        }
        Ok(())
    }

    /// Runs over rows of nodes along x on all cores: with the place of a row's first node \[m\], and what is at its
    /// nodes.
    fn each_row<T: Send>(&self, nodes: &mut [T], run: impl Fn(DVec3, &mut [T]) + Sync) {
        rows_of(nodes, self.counts.map(|count| count as usize), |[y, z], row| {
            run(self.origin + self.spacing * DVec3::new(0.0, y as f64, z as f64), row);
        });
    }

    /// Signed distance of `x` from the surface \[m\], negative inside, and the unit vector along its gradient, which
    /// leads out.
    ///
    /// Beyond the grid the distance is the least that the one at its side allows: it is no more than the true one, but
    /// for what nodes are off.
    #[must_use]
    pub fn signed_distance(&self, x: DVec3) -> (f64, DVec3) {
        let last = DVec3::from_array(self.counts.map(|count| f64::from(count - 1)));
        let inside = x.clamp(self.origin, self.origin + self.spacing * last);
        let (distance, gradient) = self.interpolated((inside - self.origin) / self.spacing, last);
        let normal = gradient.normalize_or(DVec3::Y);
        let beyond = x - inside;
        if beyond == DVec3::ZERO {
            return (distance, normal);
        }
        // The nearest point of the surface is on the other side of the plane through `inside`, across the way from
        // there.
        let along = DVec3::select(beyond.cmpeq(DVec3::ZERO), normal, DVec3::ZERO);
        (beyond.length().hypot(distance), (beyond + distance * along).normalize())
    }

    /// Trilinear distance \[m\] and its gradient at a place in the grid \[spacings\].
    fn interpolated(&self, place: DVec3, last: DVec3) -> (f64, DVec3) {
        let cell = place.floor().min(last - 1.0);
        let part = place - cell;
        let [columns, rows, _] = self.counts.map(|count| count as usize);
        let first = (cell.z as usize * rows + cell.y as usize) * columns + cell.x as usize;
        let at = |x: usize, y: usize, z: usize| f64::from(self.values[first + (z * rows + y) * columns + x]);
        let mix = |a: f64, b: f64, part: f64| a + part * (b - a);
        // Each is along one axis, then along two.
        let x = [0, 1].map(|z| [0, 1].map(|y| mix(at(0, y, z), at(1, y, z), part.x)));
        let y = x.map(|[near, far]| mix(near, far, part.y));
        let slope_x = [0, 1].map(|z| {
            let [near, far] = [0, 1].map(|y| at(1, y, z) - at(0, y, z));
            mix(near, far, part.y)
        });
        let gradient = DVec3::new(
            mix(slope_x[0], slope_x[1], part.z),
            mix(x[0][1] - x[0][0], x[1][1] - x[1][0], part.z),
            y[1] - y[0],
        );
        (mix(y[0], y[1], part.z), gradient / self.spacing)
    }

    /// Radius of the largest ball about a node that fits inside \[m\].
    #[must_use]
    pub fn inradius(&self) -> f64 {
        -f64::from(self.values.iter().copied().fold(0.0, f32::min))
    }
}
