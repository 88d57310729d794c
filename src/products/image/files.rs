//! The cubes of an image on their way to files, some lines at a time: a cube of many bands need not fit into memory.

use std::path::{Path, PathBuf};

use crate::products::cube::ImageHeader;
use crate::support::output::{self, Beside, OutputError};

/// Lines of an image, band by band.
pub(super) struct Block {
    pub first_line: usize,
    pub lines: usize,
    pub samples: usize,
    pub data: Vec<f32>,
}

impl Block {
    /// Of pixels line by line, each with a value in each band.
    pub(super) fn new<'a>(
        [first_line, lines, samples]: [usize; 3],
        bands: usize,
        pixels: impl Iterator<Item = &'a [f32]>,
    ) -> Self {
        let mut data = vec![f32::NAN; lines * samples * bands];
        for (pixel, values) in pixels.enumerate() {
            for (band, &value) in values.iter().enumerate() {
                data[band * lines * samples + pixel] = value;
            }
        }
        Self { first_line, lines, samples, data }
    }

    /// One line of all bands, band by band.
    pub(super) fn line(&self, line: usize) -> Vec<f32> {
        self.data
            .chunks_exact(self.lines * self.samples)
            .flat_map(|band| &band[line * self.samples..][..self.samples])
            .copied()
            .collect()
    }
}

/// An ENVI image under way.
pub(super) struct EnviFile {
    data: Beside,
    header: (PathBuf, String),
    lines: usize,
}

impl EnviFile {
    pub(super) fn new(path: &Path, header: &ImageHeader) -> Result<Self, OutputError> {
        let data = Beside::new(path)?;
        let text = header.text();
        Ok(Self { data, header: (path.with_extension("hdr"), text), lines: header.lines })
    }

    pub(super) fn write(&self, block: &Block) -> Result<(), OutputError> {
        let size = block.lines * block.samples;
        for (band, values) in block.data.chunks_exact(size).enumerate() {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            let place = (band * self.lines + block.first_line) * block.samples * size_of::<f32>();
            self.data.write_at(&bytes, place as u64)?;
        }
        Ok(())
    }

    /// Puts data and header in their places.
    pub(super) fn done(self) -> Result<(), OutputError> {
        self.data.done()?;
        output::bytes(&self.header.0, self.header.1.as_bytes())
    }
}
