//! The numbers of a glTF file, and whether all of them are there.

use std::path::Path;

use super::file::{Accessor, COMPRESSED, Gltf, Sparse, SparsePart, View};
use crate::support::file_error::FileError;

/// Values of `componentType`.
pub(super) const FLOAT: &[u32] = &[5126];
pub(super) const UNSIGNED: &[u32] = &[5121, 5123, 5125];
pub(super) const SIGNED_OR_FLOAT: &[u32] = &[5120, 5122, 5126];

/// A file, and those of its buffers that there are.
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
        let place = || format!("accessor {number}");
        let of = self.file.accessors.get(number);
        of.ok_or_else(|| FileError::wrong_at(self.path, place(), "the file has no such accessor"))
    }

    /// The number of elements of an accessor, if they have this type and all of them are there.
    pub fn check(&self, number: usize, kind: &str, numbers: &[u32]) -> Result<usize, FileError> {
        let accessor = self.accessor(number)?;
        self.try_check(accessor, kind, numbers).map_err(|fault| {
            let place = format!("accessor {number}");
            match fault {
                Fault::Wrong(problem) => FileError::wrong_at(self.path, place, problem),
                Fault::Compressed(extension) => {
                    let problem = format!("its numbers are compressed by {extension}");
                    FileError::wrong_at(self.path, place, problem).with_hint(COMPRESSED)
                }
            }
        })?;
        Ok(accessor.count)
    }

    /// The numbers of an accessor that was checked, element by element; zeros if it stands in no
    /// buffer.
    pub fn numbers<'b>(&'b self, number: usize) -> Vec<f64> {
        let Some(accessor) = self.file.accessors.get(number) else { return Vec::new() };
        let Accessor { byte_offset, component_type, count, .. } = *accessor;
        let (width, size) = (width(&accessor.kind), bytes_of_number(component_type));
        let element = move |bytes: &'b [u8]| {
            (0..width).map(move |i| value(&bytes[i * size..][..size], component_type))
        };
        let of = |view: Option<usize>, offset, count| {
            view.and_then(|view| self.strided(view, offset, count, width * size).ok())
        };
        let mut all = match of(accessor.buffer_view, byte_offset, count) {
            Some((bytes, stride)) => bytes.chunks(stride).take(count).flat_map(element).collect(),
            None => vec![0.0; width * count],
        };
        if let Some(Sparse { count, indices, values }) = accessor.sparse()
            && let Some((values, stride)) = of(Some(values.buffer_view), values.byte_offset, *count)
            && let Ok(places) = self.places(*count, indices)
        {
            for (place, bytes) in places.into_iter().zip(values.chunks(stride)) {
                let own = all[width * place..].iter_mut();
                own.zip(element(bytes)).for_each(|(own, value)| *own = value);
            }
        }
        all
    }

    fn try_check(&self, accessor: &Accessor, kind: &str, numbers: &[u32]) -> Result<(), Fault> {
        let Accessor { count, component_type, .. } = *accessor;
        if accessor.kind != kind {
            return Err(Fault::Wrong(format!("its type is {}, not {kind}", accessor.kind)));
        }
        if !numbers.contains(&component_type) {
            let problem = format!("its componentType is {component_type}, not one of {numbers:?}");
            return Err(Fault::Wrong(problem));
        }
        let size = width(kind) * bytes_of_number(component_type);
        if count == 0 {
            return Err("it is empty".into());
        }
        if let Some(view) = accessor.buffer_view {
            self.strided(view, accessor.byte_offset, count, size)?;
        } else if count > self.buffers.iter().flatten().map(|bytes| bytes.len()).sum() {
            // Zeros; but what uses them is somewhere in the buffers.
            return Err("it has more elements than the buffers have bytes".into());
        }
        accessor.sparse().map_or(Ok(()), |sparse| self.check_sparse(sparse, count, size))
    }

    /// Whether a sparse accessor names elements that are there, in their order.
    fn check_sparse(&self, sparse: &Sparse, count: usize, size: usize) -> Result<(), Fault> {
        let Sparse { count: own, indices, values } = sparse;
        self.strided(values.buffer_view, values.byte_offset, *own, size)?;
        let mut least = 0;
        for place in self.places(*own, indices)? {
            if place < least || place >= count {
                return Err("its sparse indices are out of order or too large".into());
            }
            least = place + 1;
        }
        Ok(())
    }

    /// The places of the elements that a sparse accessor names.
    fn places(&self, count: usize, indices: &SparsePart) -> Result<Vec<usize>, Fault> {
        let kind = indices.component_type.filter(|kind| UNSIGNED.contains(kind));
        let kind = kind.ok_or("its sparse indices are not whole numbers")?;
        let width = bytes_of_number(kind);
        let (bytes, stride) =
            self.strided(indices.buffer_view, indices.byte_offset, count, width)?;
        let place = |bytes: &[u8]| value(&bytes[..width], kind) as usize;
        Ok(bytes.chunks(stride).take(count).map(place).collect())
    }

    /// The bytes of so many elements of a view, `size` bytes each, and from one to the next.
    fn strided(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<(&[u8], usize), Fault> {
        let view = self.file.buffer_views.get(view).ok_or("the file has no such bufferView")?;
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err("its elements overlap".into());
        }
        let needed = stride.checked_mul(count - 1).and_then(|bytes| bytes.checked_add(size));
        let bytes = self.bytes(view)?.get(offset..);
        let bytes = bytes.filter(|bytes| needed.is_some_and(|needed| needed <= bytes.len()));
        Ok((bytes.ok_or("it is longer than its bufferView")?, stride))
    }

    fn bytes(&self, view: &View) -> Result<&[u8], Fault> {
        let number = view.buffer;
        let buffer = self.buffers.get(number).ok_or("the file has no such buffer")?;
        let Some(buffer) = buffer else {
            return Err(match view.extensions.compression() {
                Some(extension) => Fault::Compressed(extension),
                None => Fault::Wrong(format!("buffer {number} is missing")),
            });
        };
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end));
        bytes.ok_or_else(|| "its bufferView is longer than the buffer".into())
    }
}

fn bytes_of_number(component_type: u32) -> usize {
    match component_type {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        _ => 4,
    }
}

/// Numbers of an element.
fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC3" => 3,
        _ => 4,
    }
}

/// A number by its bytes, the least first.
fn value(bytes: &[u8], component_type: u32) -> f64 {
    let whole = bytes.iter().rev().fold(0_u32, |sum, &byte| sum << 8 | u32::from(byte));
    match component_type {
        5120 => (whole as u8 as i8).into(),
        5122 => (whole as u16 as i16).into(),
        5126 => f32::from_bits(whole).into(),
        _ => whole.into(),
    }
}
