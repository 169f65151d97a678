//! The spatial hash against O(n²).

use glam::DVec3;
use windswept::internals::{Engine, Plan, Recorder, Setup, status, step};
use windswept_scene::InitialState;

use crate::support::{self, Layout, RADIUS, SIZES};

/// Runs headings 2 of the step over the initial positions; grows the list as the simulation would.
fn neighbours(initial: &InitialState) -> Vec<Vec<u32>> {
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

/// Pairs are the same but for those whose distance is the radius to f32.
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
            assert_same_pairs(&initial, &neighbours(&initial), &format!("{n} particles, {hair} of hair, {layout:?}"));
        }
    }
}
