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
    number
        .into()
        .filter(|number| !number.is_nan())
        .map_or_else(String::new, |number| format!("{number:.7}"))
}

/// Below this radiance of a black body seven decimals lose the radiances beside it, W m-2 sr-1 um-1.
const FAINT: f64 = 0.1;

/// A field of radiance; in powers of ten where a black body is faint.
pub(crate) fn radiance(l: impl Into<Option<f64>>, l_blackbody: f64) -> String {
    match l.into() {
        Some(l) if l_blackbody < FAINT && l != 0.0 => format!("{l:.7e}"),
        l => decimals(l),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_must_be_and_empty_without_a_number() {
        let mut csv = Csv::new(&["name", "x", "y"]);
        assert_eq!(decimals(f64::NAN), "");
        csv.row(["a, \"b\"".into(), decimals(0.25), decimals(None)]);
        assert_eq!(
            [0.25, 2e-9, 0.0].map(|l| radiance(l, 1.0)),
            ["0.2500000", "0.0000000", "0.0000000"]
        );
        assert_eq!([2e-9, 0.0].map(|l| radiance(l, 2e-9)), ["2.0000000e-9", "0.0000000"]);
        assert_eq!(csv.text(), "name,x,y\n\"a, \"\"b\"\"\",0.2500000,\n");
    }
}
