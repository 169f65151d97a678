// The air that a hair point is dragged by.

struct Sampled {
    position: vec3f,   // m, y: where hair drifted to
    filled: f32,       // theta: the part of the kernel that air particles fill
    wind: vec3f,       // m/s, u
    give: f32,         // 1/kg, G: change of u by a unit impulse on each hair point near it
}

const THIN: f32 = 0.5;   // theta below which u approaches the mean wind in proportion to theta
