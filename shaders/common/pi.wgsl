// The number pi, to f32.
const PI: f32 = 3.14159265;
