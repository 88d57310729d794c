//! The numbers of an ENVI file.

use std::fs;

use super::header::Header;
use crate::support::file_error::FileError;

/// The numbers of a data file.
pub(crate) struct Numbers {
    /// Values are divided by it.
    pub scale: f64,
    /// Little-endian.
    bytes: Vec<u8>,
    of: Type,
    ignored: Option<f64>,
}

/// The type of a file's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Type {
    Byte,
    Signed(usize),
    Unsigned(usize),
    Single,
    Double,
}

impl Type {
    /// By its number in a header.
    fn new(number: usize) -> Option<Self> {
        Some(match number {
            1 => Self::Byte,
            2 => Self::Signed(2),
            3 => Self::Signed(4),
            4 => Self::Single,
            5 => Self::Double,
            12 => Self::Unsigned(2),
            13 => Self::Unsigned(4),
            14 => Self::Signed(8),
            15 => Self::Unsigned(8),
            _ => return None,
        })
    }

    /// Bytes of a number.
    fn size(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Signed(size) | Self::Unsigned(size) => size,
            Self::Single => 4,
            Self::Double => 8,
        }
    }

    /// The number of little-endian bytes.
    fn number(self, bytes: &[u8]) -> f64 {
        let fill = if matches!(self, Self::Signed(_)) && bytes[bytes.len() - 1] >= 0x80 {
            0xff
        } else {
            0
        };
        let mut all = [fill; 8];
        all[..bytes.len()].copy_from_slice(bytes);
        match self {
            Self::Byte | Self::Unsigned(_) => u64::from_le_bytes(all) as f64,
            Self::Signed(_) => i64::from_le_bytes(all) as f64,
            Self::Single => f64::from(f32::from_bits(u64::from_le_bytes(all) as u32)),
            Self::Double => f64::from_le_bytes(all),
        }
    }
}

impl Numbers {
    /// A number by its place in the file; `None` where the header says to ignore it.
    pub(crate) fn get(&self, place: usize) -> Option<f64> {
        let size = self.of.size();
        let number = self.of.number(&self.bytes[place * size..][..size]);
        let is = |ignored: f64| ignored == number || (ignored.is_nan() && number.is_nan());
        (!self.ignored.is_some_and(is)).then_some(number)
    }
}

impl Header {
    /// The numbers of the data file, which must hold exactly as many as the shape has.
    pub(crate) fn data(&self, [a, b, c]: [usize; 3]) -> Result<Numbers, FileError> {
        let number = self.count("data type", None)?;
        let Some(of) = Type::new(number) else {
            let problem = format!("data type {number} is not a type of real numbers");
            return Err(self.wrong(problem));
        };
        let size = of.size();
        let offset = self.count("header offset", Some(0))?;
        let needed = [a, b, c, size].iter().try_fold(1, |n: usize, &m| n.checked_mul(m));
        let there = fs::metadata(&self.data).map_err(FileError::read(&self.data))?.len();
        if needed.and_then(|n| n.checked_add(offset)) != usize::try_from(there).ok()
            || a * b * c == 0
        {
            return Err(self.wrong(format!(
                "{a} x {b} x {c} numbers of {size} bytes do not make the {there} bytes of {}",
                self.data.display()
            )));
        }
        let mut bytes = fs::read(&self.data).map_err(FileError::read(&self.data))?;
        if bytes.len() as u64 != there {
            return Err(FileError::wrong(&self.data, "it changed while it was read"));
        }
        bytes.drain(..offset);
        match self.count("byte order", Some(0))? {
            0 => {}
            1 => bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse),
            other => return Err(self.wrong(format!("byte order {other} is not 0 or 1"))),
        }
        let as_held = |n: f64| if of == Type::Single { f64::from(n as f32) } else { n };
        let ignored = self.number("data ignore value")?.map(as_held);
        let scale = self.number("reflectance scale factor")?.unwrap_or(1.0);
        Ok(Numbers { scale, bytes, of, ignored })
    }
}
