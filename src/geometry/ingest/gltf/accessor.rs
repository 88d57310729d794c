//! Numbers of a glTF file, out of its buffers.

use std::path::Path;

use super::file::{Accessor, COMPRESSED, Gltf, View};
use crate::support::file_error::FileError;

/// A file and its buffers, those that it has.
pub(super) struct Data<'a> {
    pub path: &'a Path,
    pub file: &'a Gltf,
    pub buffers: &'a [Option<&'a [u8]>],
}

/// What is wrong with an accessor.
enum Fault {
    /// It is compressed.
    Compressed(&'static str),
    Wrong(String),
}

impl From<&str> for Fault {
    fn from(problem: &str) -> Self {
        Self::Wrong(problem.into())
    }
}

impl Data<'_> {
    pub fn accessor(&self, number: usize) -> Result<&Accessor, FileError> {
        self.file.accessors.get(number).ok_or_else(|| {
            FileError::wrong_at(self.path, format!("accessor {number}"), "there is none")
        })
    }

    /// The elements of an accessor of N numbers each. Normalised integers are 0 to 1, or -1 to 1.
    ///
    /// # Errors
    /// There is no such accessor, its elements have another shape, or its bytes are not all there.
    pub fn elements<const N: usize>(&self, number: usize) -> Result<Vec<[f64; N]>, FileError> {
        let accessor = self.accessor(number)?;
        self.read(accessor).map_err(|fault| {
            let place = format!("accessor {number}");
            match fault {
                Fault::Wrong(problem) => FileError::wrong_at(self.path, place, problem),
                Fault::Compressed(extension) => {
                    let problem = format!("its numbers are compressed by {extension}");
                    FileError::wrong_at(self.path, place, problem).with_hint(COMPRESSED)
                }
            }
        })
    }

    /// The vertices that triangles name.
    ///
    /// # Errors
    /// As of [`Data::elements`], or they are not whole numbers.
    pub fn indices(&self, number: usize) -> Result<Vec<u32>, FileError> {
        let accessor = self.accessor(number)?;
        if !matches!(accessor.component_type, 5121 | 5123 | 5125) || accessor.normalized {
            let place = format!("accessor {number}");
            return Err(FileError::wrong_at(self.path, place, "its indices are not whole numbers"));
        }
        let elements = self.elements(number)?;
        Ok(elements.into_iter().map(|[index]: [f64; 1]| index as u32).collect())
    }

    fn read<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f64; N]>, Fault> {
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        if accessor.shape != shape {
            return Err(Fault::Wrong(format!("it holds {}, not {shape}", accessor.shape)));
        }
        let number = Number::new(accessor.component_type, accessor.normalized)?;
        let element = |bytes: &[u8]| {
            std::array::from_fn(|i| number.decode(&bytes[i * number.size()..]))
        };
        let size = N * number.size();
        let mut elements: Vec<[f64; N]> = match accessor.buffer_view {
            Some(view) => {
                let bytes = self.strided(view, accessor.byte_offset, accessor.count, size)?;
                bytes.map(element).collect()
            }
            None => {
                // They are zeros. What uses them is somewhere in the buffers.
                let most = self.buffers.iter().flatten().map(|bytes| bytes.len()).sum();
                if accessor.count > most {
                    return Err("it has more elements than the buffers have bytes".into());
                }
                vec![[0.0; N]; accessor.count]
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let kind = Number::new(sparse.indices.component_type.unwrap_or_default(), false)?;
            let (places, values) = (&sparse.indices, &sparse.values);
            let places =
                self.strided(places.buffer_view, places.byte_offset, sparse.count, kind.size())?;
            let values = self.strided(values.buffer_view, values.byte_offset, sparse.count, size)?;
            for (place, value) in places.zip(values) {
                let place = kind.decode(place) as usize;
                *elements.get_mut(place).ok_or("a sparse index is too large")? = element(value);
            }
        }
        Ok(elements)
    }

    /// The bytes of so many elements of a view, `size` bytes each.
    fn strided(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &[u8]>, Fault> {
        let view = self.file.buffer_views.get(view).ok_or("it names a view that is not there")?;
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err("its elements overlap".into());
        }
        let needed = match count.checked_sub(1) {
            None => Some(0),
            Some(others) => stride.checked_mul(others).and_then(|bytes| bytes.checked_add(size)),
        };
        let bytes = self.bytes(view)?.get(offset..);
        let bytes = bytes.filter(|bytes| needed.is_some_and(|needed| needed <= bytes.len()));
        let bytes = bytes.ok_or("it is longer than its view of the buffer")?;
        Ok((0..count).map(move |i| &bytes[i * stride..][..size]))
    }

    fn bytes(&self, view: &View) -> Result<&[u8], Fault> {
        let number = view.buffer;
        let buffer = self.buffers.get(number).ok_or("its view names a buffer that is not there")?;
        let Some(buffer) = buffer else {
            return Err(match view.extensions.compression() {
                Some(extension) => Fault::Compressed(extension),
                None => Fault::Wrong(format!("buffer {number} is missing")),
            });
        };
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end));
        bytes.ok_or_else(|| "its view is longer than the buffer".into())
    }
}

/// How a number is written.
#[derive(Clone, Copy)]
struct Number {
    kind: Kind,
    is_normalized: bool,
}

#[derive(Clone, Copy)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Number {
    fn new(component_type: u32, is_normalized: bool) -> Result<Self, Fault> {
        let kind = match component_type {
            5120 => Kind::I8,
            5121 => Kind::U8,
            5122 => Kind::I16,
            5123 => Kind::U16,
            5125 => Kind::U32,
            5126 => Kind::F32,
            other => return Err(Fault::Wrong(format!("its componentType {other} is not known"))),
        };
        Ok(Self { kind, is_normalized })
    }

    fn size(self) -> usize {
        match self.kind {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::U32 | Kind::F32 => 4,
        }
    }

    /// The number at the start of the bytes.
    fn decode(self, bytes: &[u8]) -> f64 {
        let two = || [bytes[0], bytes[1]];
        let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
        let (value, greatest) = match self.kind {
            Kind::F32 => return f64::from(f32::from_le_bytes(four())),
            Kind::I8 => (f64::from(bytes[0] as i8), f64::from(i8::MAX)),
            Kind::U8 => (f64::from(bytes[0]), f64::from(u8::MAX)),
            Kind::I16 => (f64::from(i16::from_le_bytes(two())), f64::from(i16::MAX)),
            Kind::U16 => (f64::from(u16::from_le_bytes(two())), f64::from(u16::MAX)),
            Kind::U32 => (f64::from(u32::from_le_bytes(four())), f64::from(u32::MAX)),
        };
        if self.is_normalized { (value / greatest).max(-1.0) } else { value }
    }
}
