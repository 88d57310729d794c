//! NetCDF files made in memory: what they hold, then their bytes.

use std::cell::RefCell;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::rc::Rc;

use netcdf3::{DataSet, FileWriter, Version};

pub(crate) const WAVELENGTH: &str = "wavelength";

/// NetCDF's own value for what is missing. NaN is not equal to itself, which its writer needs.
pub(crate) const FILL: f64 = 9.969_209_968_386_869e36;

/// Names and sizes are this crate's own.
pub(crate) const VALID: &str = "names and sizes are valid, and memory does not fail";

/// A file in the making. Dimensions come before the variables that have them.
#[derive(Default)]
pub(crate) struct NetCdf {
    set: DataSet,
    values: Vec<(String, Values)>,
}

enum Values {
    Numbers(Vec<f64>),
    Letters(Vec<u8>),
}

impl NetCdf {
    pub(crate) fn dimension(&mut self, name: &str, len: usize) {
        self.set.add_fixed_dim(name, len).expect(VALID);
    }

    /// An attribute of the whole file.
    pub(crate) fn text(&mut self, key: &str, text: &str) {
        self.set.add_global_attr_string(key, text).expect(VALID);
    }

    /// The same with a number.
    pub(crate) fn number(&mut self, key: &str, number: f64) {
        self.set.add_global_attr_f64(key, vec![number]).expect(VALID);
    }

    /// A variable with its attributes. Missing values may be [`FILL`].
    pub(crate) fn variable(
        &mut self,
        name: &str,
        dimensions: &[&str],
        attributes: &[(&str, &str)],
        values: Vec<f64>,
    ) {
        self.set.add_var_f64(name, dimensions).expect(VALID);
        for (key, text) in attributes {
            self.attribute(name, key, text);
        }
        self.values.push((name.to_owned(), Values::Numbers(values)));
    }

    /// A further attribute of a variable.
    pub(crate) fn attribute(&mut self, name: &str, key: &str, text: &str) {
        self.set.add_var_attr_string(name, key, text).expect(VALID);
    }

    /// The same with numbers.
    pub(crate) fn numbers(&mut self, name: &str, key: &str, numbers: Vec<f64>) {
        self.set.add_var_attr_f64(name, key, numbers).expect(VALID);
    }

    /// A variable of words, with a dimension for their letters.
    pub(crate) fn words(&mut self, name: &str, [of, letters]: [&str; 2], words: &[&str]) {
        let width = words.iter().map(|word| word.len()).max().unwrap_or(0).max(1);
        self.dimension(letters, width);
        self.set.add_var_u8(name, &[of, letters]).expect(VALID);
        let padding = |word: &str| std::iter::repeat_n(0, width - word.len());
        let padded = words.iter().flat_map(|word| word.bytes().chain(padding(word))).collect();
        self.values.push((name.to_owned(), Values::Letters(padded)));
    }

    pub(crate) fn bytes(self, version: Version) -> Vec<u8> {
        let memory = Shared::new(Cursor::new(Vec::new()));
        let mut writer =
            FileWriter::open_seek_write("memory", Box::new(memory.clone())).expect(VALID);
        writer.set_def(&self.set, version, 0).expect(VALID);
        for (name, values) in &self.values {
            match values {
                Values::Numbers(values) => writer.write_var_f64(name, values),
                Values::Letters(letters) => writer.write_var_u8(name, letters),
            }
            .expect(VALID);
        }
        writer.close().expect(VALID);
        memory.0.take().into_inner()
    }
}

/// What is written to and outlives its writer.
pub(crate) struct Shared<W>(Rc<RefCell<W>>);

impl<W> Shared<W> {
    pub(crate) fn new(inner: W) -> Self {
        Self(Rc::new(RefCell::new(inner)))
    }
}

impl<W> Clone for Shared<W> {
    fn clone(&self) -> Self {
        Self(Rc::clone(&self.0))
    }
}

impl<W: Write> Write for Shared<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.borrow_mut().flush()
    }
}

impl<W: Seek> Seek for Shared<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.borrow_mut().seek(to)
    }
}
