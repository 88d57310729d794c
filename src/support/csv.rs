//! CSV files as results are written.

/// CSV text with a line of headings.
pub(crate) struct Csv(csv::Writer<Vec<u8>>);

impl Csv {
    pub(crate) fn new(headings: &[&str]) -> Self {
        let mut csv = Self(csv::Writer::from_writer(Vec::new()));
        csv.row(headings);
        csv
    }

    /// Adds a row, with as many fields as there are headings.
    pub(crate) fn row(&mut self, fields: impl IntoIterator<Item = impl AsRef<[u8]>>) {
        self.0.write_record(fields).expect("rows are of one length");
    }

    pub(crate) fn text(self) -> String {
        let bytes = self.0.into_inner().expect("writing to memory does not fail");
        String::from_utf8(bytes).expect("fields are text")
    }
}

/// A field of seven decimals; empty without a number.
pub(crate) fn decimals(number: impl Into<Option<f64>>) -> String {
    number.into().map_or_else(String::new, |number| format!("{number:.7}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_must_be_and_empty_without_a_number() {
        let mut csv = Csv::new(&["name", "x", "y"]);
        csv.row(["a, \"b\"".into(), decimals(0.25), decimals(None)]);
        assert_eq!(csv.text(), "name,x,y\n\"a, \"\"b\"\"\",0.2500000,\n");
    }
}
