// The air that a hair point is dragged by.

struct Sampled {
    position: vec3f,   // m, y: where hair drifted to
    filled: f32,       // theta: the part of the kernel that air particles fill
    wind: vec3f,       // m/s, u
    give: f32,         // 1/kg, G: what an impulse on each hair point near it changes u by
}

const THIN: f32 = 0.5;   // rho/rho_0 below which air counts by what is there, and the mean wind takes over
