//! The vertices of a part of a glTF mesh, and the triangles that name them.

use glam::{DVec3, Vec3};

use super::Shape;
use super::accessor::{Data, FLOAT, SIGNED_OR_FLOAT, UNSIGNED};
use super::file::{Attributes, COMPRESSED, Primitive};
use crate::support::file_error::FileError;

/// Numbers without decimals.
const WHOLE: [u32; 5] = [5120, 5121, 5122, 5123, 5125];

/// The vertices of a primitive, whose accessors are all there.
pub(super) struct Vertices<'a> {
    data: &'a Data<'a>,
    primitive: &'a Primitive,
    count: usize,
    position: usize,
    /// If there are such, and every morph target changes them too.
    normal: Option<usize>,
    /// The morph targets that have a weight.
    targets: Vec<(f64, &'a Attributes)>,
}

impl<'a> Vertices<'a> {
    /// Looks at all accessors of a primitive's triangles.
    ///
    /// # Errors
    /// It has no positions, they are compressed or rounded, or an accessor is not as it has to be.
    pub fn checked(
        data: &'a Data<'a>,
        mesh: &str,
        primitive: &'a Primitive,
        shape: &Shape,
    ) -> Result<Self, FileError> {
        let wrong = |problem: &str| FileError::wrong_at(data.path, mesh, problem);
        let Attributes { position, normal } = primitive.attributes;
        let accessor = position.map(|number| data.accessor(number)).transpose()?;
        let is_elsewhere = accessor.is_none_or(|of| of.buffer_view.is_none());
        if is_elsewhere && primitive.extensions.draco.is_some() {
            let problem = "its triangles are compressed by KHR_draco_mesh_compression";
            return Err(wrong(problem).with_hint(COMPRESSED));
        }
        let position = position.ok_or_else(|| wrong("there are no vertex positions"))?;
        if accessor.is_some_and(|of| WHOLE.contains(&of.component_type)) {
            let problem = "its vertices are rounded to whole numbers, by KHR_mesh_quantization";
            return Err(wrong(problem).with_hint(COMPRESSED));
        }
        let count = data.check(position, "VEC3", FLOAT)?;
        if let Some(number) = primitive.indices {
            data.check(number, "SCALAR", UNSIGNED)?;
        }
        let same_count = |number: usize, numbers| {
            if data.check(number, "VEC3", numbers)? == count {
                return Ok(());
            }
            Err(wrong(&format!("accessor {number} has not as many elements as there are vertices")))
        };
        if shape.weights().count() > primitive.targets.len() {
            return Err(wrong("it has more weights than morph targets"));
        }
        let targets = shape.weights().zip(&primitive.targets).filter(|&(weight, _)| weight != 0.0);
        let targets: Vec<(f64, &Attributes)> = targets.collect();
        for number in targets.iter().filter_map(|(_, target)| target.position) {
            same_count(number, FLOAT)?;
        }
        let normals = targets.iter().filter_map(|(_, target)| target.normal);
        let normals: Vec<usize> = normal.into_iter().chain(normals).collect();
        let mut are_whole = normals.len() == 1 + targets.len();
        for number in normals {
            same_count(number, SIGNED_OR_FLOAT)?;
            // Normals that are rounded say less than the facets.
            are_whole &= FLOAT.contains(&data.accessor(number)?.component_type);
        }
        let normal = normal.filter(|_| are_whole);
        Ok(Self { data, primitive, count, position, normal, targets })
    }

    /// Where they are, in the file's unit.
    pub fn positions(&self) -> Vec<DVec3> {
        self.changed(self.position, |target| target.position)
    }

    /// Their normals, if they have such.
    pub fn normals(&self) -> Option<Vec<DVec3>> {
        self.normal.map(|normal| self.changed(normal, |target| target.normal))
    }

    /// The vertices that triangles name.
    pub fn indices(&self) -> Vec<u32> {
        let all = || (0..self.count as u32).collect();
        self.primitive.indices.map_or_else(all, |number| self.data.indices(number))
    }

    /// The vectors of an accessor, with what the morph targets change.
    fn changed(&self, number: usize, of: impl Fn(&Attributes) -> Option<usize>) -> Vec<DVec3> {
        let read = |number| {
            let vectors = self.data.elements(number).into_iter();
            vectors.map(|vector: [f32; 3]| Vec3::from_array(vector).as_dvec3())
        };
        let mut vectors: Vec<DVec3> = read(number).collect();
        for &(weight, target) in &self.targets {
            for (vector, change) in vectors.iter_mut().zip(of(target).into_iter().flat_map(read)) {
                *vector += weight * change;
            }
        }
        vectors
    }
}
