// Time integration of rods: BDF2 or implicit Euler, one form for both. With d the last step's move,
//
//   move without the rod's forces = carry d + h (v + h a)/(1 + c h)
//       v = (4 v_n - v_(n-1))/3, h = 2/3 dt, carry = 1/3
//   v_(n+1) = (move - carry d)/h                                    Euler: v = v_n,               h = dt,     carry = 0
//
// A force f moves a point by w f h^2/(1 + c h), w its inverse mass: `response`. c is the scene's damping, and for a
// point every resistance to its velocity as well.
import package::common::params::params;

// How a point or a segment goes through a step: by implicit Euler, by BDF2, put somewhere with no velocity, or asleep
// where it is.
const EULER: u32 = 0u;
const BDF2: u32 = 1u;
const KINEMATIC: u32 = 2u;
const HOLD: u32 = 3u;

// h, in seconds.
fn step_of(scheme: u32) -> f32 {
    return select(params.step, params.step * (2.0 / 3.0), scheme == BDF2);
}

fn carry(scheme: u32) -> f32 {
    return select(0.0, 1.0 / 3.0, scheme == BDF2);
}

// Written as a change: of v itself an inexact third would take the same share in each step.
fn weighted(now: vec3f, before: vec3f, scheme: u32) -> vec3f {
    return now + select(vec3f(0.0), (now - before) / 3.0, scheme == BDF2);
}

// The move, or turn, without the rod's forces.
fn free_move(
    now: vec3f, before: vec3f, previous_move: vec3f, acceleration: vec3f, damping: f32, scheme: u32,
) -> vec3f {
    let h = step_of(scheme);
    return carry(scheme) * previous_move + h * (weighted(now, before, scheme) + h * acceleration) / (1.0 + damping * h);
}

// The velocity, or spin, that a move, or turn, leaves.
fn rate(shift: vec3f, previous_move: vec3f, scheme: u32) -> vec3f {
    return select(over(shift - carry(scheme) * previous_move, step_of(scheme)), vec3f(0.0), scheme >= KINEMATIC);
}

// A GPU's quotient may be off by two units in the last place, by the same share for all that is divided by one number:
// in thousands of steps strands would gain or lose momentum. The remainder is divided again. Mesa's software
// driver divides exactly, and its fma rounds twice.
@if(!software)
fn over(way: vec3f, h: f32) -> vec3f {
    let quotient = way / h;
    return quotient + fma(-quotient, vec3f(h), way) / h;
}
@if(software)
fn over(way: vec3f, h: f32) -> vec3f {
    return way / h;
}

fn response(damping: f32, scheme: u32) -> f32 {
    let h = step_of(scheme);
    return h * h / (1.0 + damping * h);
}
