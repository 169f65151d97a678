// Time integration of rods: BDF2 or implicit Euler, one form for both. With d the last step's move,
//
//   move without the rod's forces = carry d + h (v + h a)/(1 + c h)      v = (4 v_n - v_(n-1))/3, h = 2/3 dt, carry = 1/3
//   v_(n+1) = (move - carry d)/h                                    Euler: v = v_n,               h = dt,     carry = 0
//
// A force f moves a point by w f h^2/(1 + c h), w its inverse mass: `response`.
import package::common::params::params;

// h of what was put somewhere instead of moved: no velocity, nothing carried.
const PUT: f32 = 1e30;

fn bdf2_step() -> f32 {
    return params.step * (2.0 / 3.0);
}

fn carry(h: f32) -> f32 {
    return select(0.0, 1.0 / 3.0, h < params.step);
}

fn weighted(now: vec3f, before: vec3f, h: f32) -> vec3f {
    return select(now, (4.0 * now - before) / 3.0, h < params.step);
}

// The move, or turn, without the rod's forces.
fn free_move(now: vec3f, before: vec3f, carried: vec3f, acceleration: vec3f, h: f32) -> vec3f {
    return carry(h) * carried + h * (weighted(now, before, h) + h * acceleration) / (1.0 + params.damping * h);
}

fn rate(shift: vec3f, carried: vec3f, h: f32) -> vec3f {
    return select((shift - carry(h) * carried) / h, vec3f(0.0), h == PUT);
}

fn response(h: f32) -> f32 {
    return h * h / (1.0 + params.damping * h);
}
