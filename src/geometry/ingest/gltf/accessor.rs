//! Whether the numbers of a glTF file are all there. The gltf crate leaves out or panics over those
//! that are not.

use std::iter;
use std::path::Path;

use gltf::accessor::{self, DataType, Item};
use gltf::{Buffer, Document};

use super::file::{Accessor, COMPRESSED, Gltf, Sparse, View};
use crate::support::file_error::FileError;

/// Values of `componentType`.
pub(super) const FLOAT: &[u32] = &[5126];
pub(super) const UNSIGNED: &[u32] = &[5121, 5123, 5125];
pub(super) const SIGNED_OR_FLOAT: &[u32] = &[5120, 5122, 5126];

/// A file, the same as the gltf crate has it, and those of its buffers that there are.
pub(super) struct Data<'a> {
    pub path: &'a Path,
    pub file: &'a Gltf,
    pub document: &'a Document,
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

impl<'a> Data<'a> {
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

    /// The elements of an accessor that was checked; zeros if it stands in no buffer.
    pub fn elements<T: Item + 'a>(&self, number: usize) -> Vec<T> {
        let Some(accessor) = self.document.accessors().nth(number) else { return Vec::new() };
        let count = accessor.count();
        match accessor::Iter::new(accessor, |buffer: Buffer| self.buffers[buffer.index()]) {
            Some(elements) => elements.collect(),
            None => iter::repeat_with(T::zero).take(count).collect(),
        }
    }

    /// The same of whole numbers without a sign.
    pub fn indices(&self, number: usize) -> Vec<u32> {
        match self.document.accessors().nth(number).map(|accessor| accessor.data_type()) {
            Some(DataType::U8) => self.elements::<u8>(number).into_iter().map(u32::from).collect(),
            Some(DataType::U16) => {
                self.elements::<u16>(number).into_iter().map(u32::from).collect()
            }
            _ => self.elements(number),
        }
    }

    /// The same of four numbers each, singles or whole numbers with a sign.
    pub fn fours(&self, number: usize) -> Vec<[f32; 4]> {
        match self.document.accessors().nth(number).map(|accessor| accessor.data_type()) {
            Some(DataType::I8) => {
                self.elements(number).into_iter().map(|four: [i8; 4]| four.map(f32::from)).collect()
            }
            Some(DataType::I16) => self
                .elements(number)
                .into_iter()
                .map(|four: [i16; 4]| four.map(f32::from))
                .collect(),
            _ => self.elements(number),
        }
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
        let width = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            _ => 4,
        };
        let size = width * bytes_of_number(component_type);
        if count == 0 {
            return Err("it is empty".into());
        }
        if let Some(view) = accessor.buffer_view {
            self.strided(view, accessor.byte_offset, count, size)?;
        } else if count > self.buffers.iter().flatten().map(|bytes| bytes.len()).sum() {
            // Zeros; but what uses them is somewhere in the buffers.
            return Err("it has more elements than the buffers have bytes".into());
        }
        match &accessor.sparse {
            Some(sparse) if sparse.count > 0 => self.check_sparse(sparse, count, size),
            _ => Ok(()),
        }
    }

    /// Whether a sparse accessor names elements that are there, in their order.
    fn check_sparse(&self, sparse: &Sparse, count: usize, size: usize) -> Result<(), Fault> {
        let Sparse { count: own, indices, values } = sparse;
        let kind = indices.component_type.filter(|kind| UNSIGNED.contains(kind));
        let width = bytes_of_number(kind.ok_or("its sparse indices are not whole numbers")?);
        self.strided(values.buffer_view, values.byte_offset, *own, size)?;
        let (places, stride) =
            self.strided(indices.buffer_view, indices.byte_offset, *own, width)?;
        let place = |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, &b| sum << 8 | usize::from(b));
        let mut least = 0;
        for place in places.chunks(stride).take(*own).map(|bytes| place(&bytes[..width])) {
            if place < least || place >= count {
                return Err("its sparse indices are out of order or too large".into());
            }
            least = place + 1;
        }
        Ok(())
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
