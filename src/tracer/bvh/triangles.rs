//! Which triangles of a leaf a ray may meet: eight at a time, in single precision, with room for
//! its rounding errors. Whether it does meet them: one by one, in double precision.

use glam::{DVec3, Vec3};

use super::lanes::Lanes;
use super::tree::{Child, WIDTH};

/// Greatest error of a sheared corner in single precision, as a share of the greatest coordinate of
/// the ray's origin and the mesh: 32 units of the last place.
///
/// A corner relative to the origin errs by 3 units (the origin's rounding, and that of a difference
/// of up to twice the coordinate). The sheared one errs by 3 + 3 of these, 8 of the factor's own
/// rounding, 2 of the product's and 4 of the difference's. The products in `Cull::meet` add 8.
const ROUNDING: f32 = 1.0 / (1 << 19) as f32;

/// Up to eight triangles, by corner and coordinate.
#[repr(C, align(32))]
pub struct Block {
    corners: [[[f32; WIDTH]; 3]; 3],
    /// Their numbers in the mesh.
    numbers: [u32; WIDTH],
}

impl Block {
    /// Of the triangles with these numbers, whose corners `corners` gives.
    pub fn new(numbers: &[u32], corners: impl Fn(u32) -> [Vec3; 3]) -> Self {
        let mut block = Self { corners: [[[0.0; WIDTH]; 3]; 3], numbers: [0; WIDTH] };
        for (slot, &number) in numbers.iter().enumerate() {
            block.numbers[slot] = number;
            for (i, corner) in corners(number).into_iter().enumerate() {
                for axis in 0..3 {
                    block.corners[i][axis][slot] = corner[axis];
                }
            }
        }
        block
    }

    /// Number in the mesh.
    #[inline(always)]
    pub fn number(&self, slot: usize) -> usize {
        self.numbers[slot] as usize
    }

    /// Corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, slot: usize) -> [Vec3; 3] {
        self.corners.map(|corner| Vec3::from(corner.map(|of_axis| of_axis[slot])))
    }

    #[inline(always)]
    pub fn coordinate(&self, corner: usize, axis: usize, slot: usize) -> f64 {
        self.corners[corner][axis.min(2)][slot].into()
    }
}

/// A ray in single precision, to find the triangles that it cannot meet.
pub struct Cull<L> {
    axes: [usize; 3],
    origin: [L; 3],
    shear: [L; 3],
    /// The rounding of a sheared corner; of a distance along the ray.
    room: L,
    along: f32,
}

impl<L: Lanes> Cull<L> {
    /// For the part of the ray from `origin` on. The coordinates of triangles and origin are at
    /// most
    /// `reach`.
    #[inline(always)]
    pub fn new(ray: &Ray, origin: DVec3, reach: f32) -> Self {
        let (origin, shear) = (origin.as_vec3(), ray.shear.as_vec3());
        let [x, y, z] = ray.axes;
        let room = reach * ROUNDING;
        Self {
            axes: ray.axes,
            origin: [L::splat(origin[x]), L::splat(origin[y]), L::splat(origin[z])],
            shear: [L::splat(shear.x), L::splat(shear.y), L::splat(shear.z)],
            room: L::splat(room),
            along: room * shear.z.abs(),
        }
    }

    /// A bit for each triangle of the leaf that the ray may meet, from either side, up to `t_max`.
    ///
    /// After Woop, Benthin and Wald, "Watertight ray/triangle intersection", J. Comput. Graph.
    /// Tech. 2(1), 2013. The edges' signs count only where they are certain.
    #[inline(always)]
    pub fn meet(&self, block: &Block, leaf: Child, t_max: f32) -> u32 {
        let a = self.sheared(&block.corners[0]);
        let b = self.sheared(&block.corners[1]);
        let c = self.sheared(&block.corners[2]);
        let (u, v, w) = (side(c, b), side(a, c), side(b, a));
        let sizes = size(a).add(size(b)).add(size(c)).add(self.room).add(self.room);
        let error = self.room.mul(sizes);
        let least = u.min(v).min(w);
        let most = u.max(v).max(w);
        let zero = L::splat(0.0);
        let inside = zero.sub(error).at_most(least) | most.at_most(error);
        let nearest = a[2].min(b[2]).min(c[2]).at_most(L::splat(t_max + self.along));
        let farthest = L::splat(-self.along).at_most(a[2].max(b[2]).max(c[2]));
        inside & nearest & farthest & leaf.held()
    }

    /// A corner across and along the ray. Both coordinates across it change sign, which changes no
    /// product of two.
    #[inline(always)]
    fn sheared(&self, corner: &[[f32; WIDTH]; 3]) -> [L; 3] {
        let [x, y, z] = self.axes;
        let px = L::load(&corner[x.min(2)]).sub(self.origin[0]);
        let py = L::load(&corner[y.min(2)]).sub(self.origin[1]);
        let pz = L::load(&corner[z.min(2)]).sub(self.origin[2]);
        [pz.mul_sub(self.shear[0], px), pz.mul_sub(self.shear[1], py), pz.mul(self.shear[2])]
    }
}

#[inline(always)]
fn side<L: Lanes>(p: [L; 3], q: [L; 3]) -> L {
    p[0].mul_sub(q[1], p[1].mul(q[0]))
}

#[inline(always)]
fn size<L: Lanes>(p: [L; 3]) -> L {
    p[0].abs().add(p[1].abs())
}

/// A ray in double precision, and the shear that turns its direction into the z axis: the test of
/// Woop, Benthin and Wald.
pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
    /// The last is that along which the ray goes most; the others keep the orientation.
    axes: [usize; 3],
    shear: DVec3,
    /// The origin along these axes.
    turned: DVec3,
}

/// Where a ray meets a triangle: the distance, and twice the areas that give the corners' weights.
pub struct Met {
    pub t: f64,
    v: f64,
    w: f64,
    sum: f64,
}

impl Met {
    /// Weights of the second and third corner.
    pub fn weights(&self) -> [f64; 2] {
        [self.v / self.sum, self.w / self.sum]
    }
}

impl Ray {
    #[inline(always)]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let most = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let [x, y] = [[1, 2], [2, 0], [0, 1]][most];
        let axes = if direction[most] < 0.0 { [y, x, most] } else { [x, y, most] };
        let scale = 1.0 / direction[most];
        let shear = DVec3::new(direction[axes[0]] * scale, direction[axes[1]] * scale, scale);
        let turned = DVec3::new(origin[axes[0]], origin[axes[1]], origin[axes[2]]);
        Self { origin, direction, axes, shear, turned }
    }

    /// Where the ray meets the triangle, from either side, at 0 or farther. No ray passes between
    /// two triangles that share an edge: both compute the same product for it except for the sign,
    /// and a ray on it meets both. `coordinate` gives that of a corner along an axis.
    #[inline(always)]
    pub fn meet(&self, coordinate: impl Fn(usize, usize) -> f64) -> Option<Met> {
        let corner = |number| self.sheared(self.axes.map(|axis| coordinate(number, axis)));
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let (u, v, w) = (b.y * c.x - b.x * c.y, c.y * a.x - c.x * a.y, a.y * b.x - a.x * b.y);
        if u.min(v).min(w) < 0.0 && u.max(v).max(w) > 0.0 {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let t = (u * a.z + v * b.z + w * c.z) / sum;
        (t >= 0.0).then_some(Met { t, v, w, sum })
    }

    /// A corner along the ray's axes, relative to the origin, across and along the ray.
    #[inline(always)]
    fn sheared(&self, corner: [f64; 3]) -> DVec3 {
        let p = DVec3::from(corner) - self.turned;
        DVec3::new(p.x - self.shear.x * p.z, p.y - self.shear.y * p.z, self.shear.z * p.z)
    }
}
