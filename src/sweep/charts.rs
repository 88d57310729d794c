//! Small charts of a study: the windows over an axis, and the spectra.

use serde_json::Value;

use super::points::{Dimension, Points};
use super::results::{PointResult, Results, shown};
use super::study::Study;
use crate::draw::plot::{Drawing, Series, SmallChart, SmallCharts, small_charts_svg};

/// The emissivity of each window over an axis.
pub(super) const CHART: &str = "chart";
/// The emissivity over wavelength.
const SPECTRA: &str = "spectra";

/// Charts beside each other.
const MOST_COLUMNS: usize = 4;
/// Curves of one chart: there are as many colours.
const MOST_CURVES: usize = 7;

const MEANING: &str = "Bars and bands: total uncertainty at 95 %.";

/// The charts of a study, by their names.
pub(super) fn of(
    study: &Study,
    points: &Points,
    results: &Results,
    um: &[f64],
) -> Vec<(&'static str, String)> {
    if results.windows.is_empty() {
        return Vec::new();
    }
    let charts = Charts { study, points, results, um };
    let chart = (CHART, small_charts_svg(&charts.over_axes()));
    let spectra = charts.spectra().map(|of| (SPECTRA, small_charts_svg(&of)));
    [Some(chart), spectra].into_iter().flatten().collect()
}

struct Charts<'a> {
    study: &'a Study,
    points: &'a Points,
    results: &'a Results,
    um: &'a [f64],
}

/// An axis over which something is drawn.
struct Over {
    name: String,
    axis: usize,
    dimension: usize,
}

impl Charts<'_> {
    /// The axes that are x of a chart: all sampled ones, else the first of numbers that has
    /// several, else the longest.
    fn over(&self) -> Vec<Over> {
        let dims = &self.points.dimensions;
        let over = |dimension: usize, axis: usize| Over {
            name: self.study.axes[axis].name.clone(),
            axis,
            dimension,
        };
        if let Some(d) = dims.iter().position(|d| self.study.axes[d.axes[0]].is_sampled()) {
            return dims[d].axes.iter().map(|&axis| over(d, axis)).collect();
        }
        let is_numbers = |d: &Dimension| self.numbers(d.axes[0]).is_some();
        let of_numbers = dims.iter().position(|d| d.len > 1 && is_numbers(d));
        let longest = || (0..dims.len()).max_by_key(|&d| (dims[d].len, dims.len() - d));
        let chosen = of_numbers.or_else(longest);
        chosen.map(|d| over(d, dims[d].axes[0])).into_iter().collect()
    }

    fn numbers(&self, axis: usize) -> Option<Vec<f64>> {
        let places = &self.points.axes[axis];
        places.iter().map(|place| place.value.as_f64()).collect()
    }

    fn words(&self, axis: usize) -> Vec<String> {
        // Ranges have numbers of twelve digits.
        let word = |value: &Value| match value.as_f64() {
            Some(number) => format!("{number:.4e}").parse::<f64>().expect("a number").to_string(),
            None => shown(value),
        };
        self.points.axes[axis].iter().map(|place| word(&place.value)).collect()
    }

    /// The point at some places, one for each dimension.
    fn point(&self, places: &[usize]) -> usize {
        let dims = &self.points.dimensions;
        dims.iter().zip(places).fold(0, |point, (dim, place)| point * dim.len + place)
    }

    /// The dimension that is told by colours, and those that are told by columns.
    fn others(&self, x: usize) -> (Option<usize>, Vec<usize>) {
        let is_other = |d: &usize| *d != x && self.points.dimensions[*d].len > 1;
        let mut others = (0..self.points.dimensions.len()).filter(is_other);
        (others.next(), others.collect())
    }

    /// Places of the dimensions in columns, with what they are.
    fn columns(&self, dimensions: &[usize]) -> Vec<(Vec<(usize, usize)>, String)> {
        let mut columns = vec![(Vec::new(), Vec::<String>::new())];
        for &d in dimensions {
            let axis = self.points.dimensions[d].axes[0];
            let (name, words) = (&self.study.axes[axis].name, self.words(axis));
            let with = |(places, texts): &(Vec<(usize, usize)>, Vec<String>), place: usize| {
                let places = [&places[..], &[(d, place)]].concat();
                (places, [&texts[..], &[format!("{name} {}", words[place])]].concat())
            };
            let all =
                columns.iter().flat_map(|c| (0..words.len()).map(move |place| with(c, place)));
            columns = all.collect();
        }
        let shown = chosen(columns.len(), MOST_COLUMNS).into_iter().map(|i| &columns[i]);
        shown.map(|(places, texts)| (places.clone(), texts.join(", "))).collect()
    }

    /// Labels of the colours.
    fn labels(&self, colours: Option<usize>) -> Vec<String> {
        let Some(d) = colours else { return Vec::new() };
        let axis = self.points.dimensions[d].axes[0];
        let name = &self.study.axes[axis].name;
        let words = self.words(axis);
        let shown = chosen(words.len(), MOST_CURVES).into_iter();
        shown.map(|place| format!("{name} {}", words[place])).collect()
    }

    fn caption(&self, colours: Option<usize>, columns: &[usize]) -> Vec<String> {
        let dims = &self.points.dimensions;
        let wanted: usize = columns.iter().map(|&d| dims[d].len).product();
        let mut caption = vec![MEANING.to_owned()];
        if wanted > MOST_COLUMNS || colours.is_some_and(|d| dims[d].len > MOST_CURVES) {
            caption.push("Not all points are shown; results.csv has them.".into());
        }
        caption
    }

    fn over_axes(&self) -> SmallCharts {
        let all = self.over();
        let Some(first) = all.first() else { return self.without_axes() };
        let (colours, in_columns) = self.others(first.dimension);
        let of_colours =
            colours.map_or(vec![0], |d| chosen(self.points.dimensions[d].len, MOST_CURVES));
        let row = |(w, window): (usize, &String)| {
            let quantity = format!("Emissivity, {}", window.replace('_', " "));
            let charts = all.iter().take(MOST_COLUMNS).flat_map(|over| {
                let of = |(fixed, title): (Vec<(usize, usize)>, String)| SmallChart {
                    title,
                    names: [over.name.clone(), quantity.clone()],
                    log: self.study.axes[over.axis].range.is_some_and(|range| range.log),
                    words: match self.numbers(over.axis) {
                        Some(_) => Vec::new(),
                        None => self.words(over.axis),
                    },
                    series: (0..of_colours.len())
                        .map(|colour| {
                            let place = colours.map(|d| (d, of_colours[colour]));
                            self.series(over, &[&fixed[..], place.as_slice()].concat(), colour, w)
                        })
                        .collect(),
                };
                let columns = if all.len() > 1 { vec![] } else { in_columns.clone() };
                self.columns(&columns).into_iter().map(of).collect::<Vec<_>>()
            });
            charts.collect()
        };
        SmallCharts {
            title: self.study.title().to_owned(),
            caption: self.caption(colours, &in_columns),
            labels: self.labels(colours),
            rows: self.results.windows.iter().enumerate().map(row).collect(),
        }
    }

    /// Of a study of one point.
    fn without_axes(&self) -> SmallCharts {
        SmallCharts {
            title: self.study.title().to_owned(),
            caption: vec![MEANING.into()],
            labels: Vec::new(),
            rows: Vec::new(),
        }
    }

    fn series(
        &self,
        over: &Over,
        fixed: &[(usize, usize)],
        colour: usize,
        window: usize,
    ) -> Series {
        let mut places = vec![0; self.points.dimensions.len()];
        for &(d, place) in fixed {
            places[d] = place;
        }
        let numbers = self.numbers(over.axis);
        let mut points: Vec<[f64; 3]> = Vec::new();
        for place in 0..self.points.dimensions[over.dimension].len {
            places[over.dimension] = place;
            let Some(result) = &self.results.points[self.point(&places)] else { continue };
            let x = numbers.as_ref().map_or(place as f64, |numbers| numbers[place]);
            let window = &result.windows[window];
            points.push([x, window.emissivity, window.half_width_95]);
        }
        let is_sampled = self.study.axes[over.axis].is_sampled();
        let drawn = if is_sampled || numbers.is_none() {
            Drawing::Bars
        } else {
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            Drawing::JoinedBars
        };
        Series { colour, points, drawn }
    }

    /// The curves; none of sampled points, which have no order.
    fn spectra(&self) -> Option<SmallCharts> {
        let over = self.over().into_iter().next();
        let dims = &self.points.dimensions;
        if self.um.len() < 3 || dims.iter().any(|d| d.axes.len() > 1) {
            return None;
        }
        let (x, labels) = match &over {
            Some(over) if self.study.axes[over.axis].is_sampled() => return None,
            Some(over) => (over.dimension, self.labels(Some(over.dimension))),
            None => (0, Vec::new()),
        };
        let (first, others) = self.others(x);
        let in_columns: Vec<usize> = first.into_iter().chain(others).collect();
        let of_colours = over.as_ref().map_or(vec![0], |_| chosen(dims[x].len, MOST_CURVES));
        let curve = |fixed: &[(usize, usize)], colour: usize| {
            let mut places = vec![0; dims.len()];
            for &(d, place) in fixed {
                places[d] = place;
            }
            if over.is_some() {
                places[x] = of_colours[colour];
            }
            let result = self.results.points[self.point(&places)].as_ref()?;
            Some(Series { colour, points: self.curve(result), drawn: Drawing::Curve })
        };
        let chart = |(fixed, title): (Vec<(usize, usize)>, String)| SmallChart {
            title,
            names: ["Wavelength (µm)".into(), "Emissivity".into()],
            log: false,
            words: Vec::new(),
            series: (0..of_colours.len()).filter_map(|colour| curve(&fixed, colour)).collect(),
        };
        let columns = self.columns(&in_columns).into_iter().map(chart).collect::<Vec<_>>();
        Some(SmallCharts {
            title: self.study.title().to_owned(),
            caption: self.caption(over.map(|_| x), &in_columns),
            labels,
            rows: columns.chunks(2).map(<[SmallChart]>::to_vec).collect(),
        })
    }

    fn curve(&self, result: &PointResult) -> Vec<[f64; 3]> {
        let values = result.emissivity.iter().zip(&result.half_width_95);
        self.um.iter().zip(values).map(|(&um, (&e, &h))| [um, e, h]).collect()
    }
}

/// As many of some places as are shown, equally spaced from the first to the last.
fn chosen(number: usize, most: usize) -> Vec<usize> {
    if number <= most {
        return (0..number).collect();
    }
    (0..most).map(|i| (2 * i * (number - 1) + most - 1) / (2 * (most - 1))).collect()
}

/// Values as a list in a text.
pub(super) fn listed(values: impl Iterator<Item = Value>) -> String {
    let all: Vec<String> = values.map(|value| shown(&value)).collect();
    match all.len() {
        0..=8 => all.join(", "),
        n => format!("{}, ..., {} ({n})", all[..3].join(", "), all[n - 1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_that_are_shown_lie_over_the_whole_axis() {
        assert_eq!(chosen(3, 7), [0, 1, 2]);
        assert_eq!(chosen(7, 7), [0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(chosen(8, 7), [0, 1, 2, 4, 5, 6, 7]);
        assert_eq!(chosen(40, 7), [0, 7, 13, 20, 26, 33, 39]);
    }
}
