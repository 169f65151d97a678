//! Tests of `grid::neighbours`.

use crate::support::{Crowd, RADIUS, SIMPLE, lattice};
use glam::DVec3;

/// Within 1.92 spacings a simple cubic lattice has 6 + 12 + 8 neighbours, through the periodic faces as well.
#[test]
fn a_periodic_lattice_has_26_neighbours_everywhere() {
    let (size, positions) = lattice([5, 6, 7], &SIMPLE);
    let crowd = Crowd::new(size, positions);
    let near = crowd.neighbours();
    for i in 0..crowd.positions.len() {
        let list: Vec<usize> = near.of(i).collect();
        assert_eq!((list.len(), near.count(i)), (26, 26), "particle {i}");
        assert!(list.is_sorted(), "particle {i}: {list:?}");
        assert!(list.iter().all(|&j| j != i && near.of(j).any(|k| k == i)), "particle {i} is listed one way");
    }
}

/// Air meets air through the faces; hair meets nothing there.
#[test]
fn hair_has_no_images() {
    let size = DVec3::splat(5.0 * RADIUS);
    let opposite = |gap: f64| vec![DVec3::new(0.5 * gap, 0.01, 0.01), DVec3::new(size.x - 0.5 * gap, 0.01, 0.01)];
    for (hair, meet) in [(0, true), (1, false), (2, false)] {
        let mut crowd = Crowd::new(size, opposite(0.9 * RADIUS));
        crowd.parameters.hair_points = hair;
        assert_eq!(crowd.neighbours().count(0) == 1, meet, "{hair} of 2 are hair");
    }
    assert_eq!(Crowd::new(size, opposite(1.01 * RADIUS)).neighbours().count(0), 0, "too far apart");
}

/// The largest of the awkward sizes that passes are compared on.
#[test]
fn fifteen_thousand_particles_are_listed() {
    let (size, mut positions) = lattice([25, 25, 25], &SIMPLE);
    positions.truncate(15_071);
    let crowd = Crowd::new(size, positions);
    let near = crowd.neighbours();
    let pairs: usize = (0..15_071).map(|i| near.count(i)).sum();
    // The lattice less its last 554: each of them would have been in 26 lists and had 26.
    assert!(pairs < 26 * 15_071 && pairs > 26 * 15_071 - 26 * 554, "{pairs}");
}

/// No near pair is left out: hair and air at random, some of it not wrapped into the box.
#[test]
fn lists_are_those_of_the_distances() {
    let mut crowd = Crowd::mixed(900, 5);
    let (p, n) = (crowd.parameters.clone(), crowd.positions.len());
    for x in crowd.positions.iter_mut().step_by(3) {
        *x += DVec3::new(0.3, -0.2, 0.1) * p.box_size;
    }
    let (x, near) = (&crowd.positions, crowd.neighbours());
    let mut pairs = 0;
    for i in 0..n {
        let meets = |&j: &usize| j != i && p.separation(i, j, x[i], x[j]).length() < RADIUS;
        let wanted: Vec<usize> = (0..n).filter(meets).collect();
        assert!(near.of(i).eq(wanted.iter().copied()), "particle {i}");
        pairs += wanted.len();
    }
    assert!(pairs > 10 * n, "{pairs} pairs test little");
}
