//! Vectors of the tests that trace by themselves, and share no code with the tracer.

/// Three coordinates.
pub type V = [f64; 3];

pub fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn along(o: V, t: f64, d: V) -> V {
    [o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]]
}

pub fn unit(a: V) -> V {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}
