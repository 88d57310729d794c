//! How many grains of each size class a bed has, so that it has the shares of a soil.

/// Largest deviation of a share that more grains are not taken for.
const CLOSE: f64 = 0.01;

/// Most grains that the program chooses by itself: a bed of them drops within minutes.
const MOST: u32 = 400;

/// A size class that is wanted.
pub(super) struct Wanted {
    /// The number of its component.
    pub component: usize,
    /// Its share of mass or volume among all grains.
    pub share: f64,
    /// Mass or volume of one grain, in a unit that all classes have in common.
    pub of_one: f64,
    /// Diameter with dust on both sides, um.
    pub dusty_um: f64,
}

/// Most grains where `least` are asked for.
pub(super) fn most(least: u32) -> u32 {
    least.max(MOST)
}

/// The counts of all classes: the fewest grains, `least` or more, with which every share of a
/// class and of a component is within 0.01 of what is wanted. Where no number of grains is, that
/// which comes closest.
///
/// # Errors
/// A class would have no grain: its number.
pub(super) fn choose(wanted: &[Wanted], least: u32) -> Result<Vec<u32>, usize> {
    let numbers: Vec<f64> = wanted.iter().map(|class| class.share / class.of_one).collect();
    let all: f64 = numbers.iter().sum();
    let mut best: Option<(f64, Vec<u32>)> = None;
    for grains in least..=most(least) {
        let scale = f64::from(grains) / all;
        let counts: Vec<u32> = numbers.iter().map(|n| (n * scale).round() as u32).collect();
        if counts.contains(&0) {
            continue;
        }
        let off = deviation(wanted, &counts);
        if best.as_ref().is_none_or(|(least, _)| off < *least) {
            best = Some((off, counts));
        }
        if off <= CLOSE {
            break;
        }
    }
    best.map(|(_, counts)| counts).ok_or_else(|| {
        let rarest = numbers.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        rarest.map_or(0, |(class, _)| class)
    })
}

/// The largest deviation of a share from the wanted one, of classes and of components.
fn deviation(wanted: &[Wanted], counts: &[u32]) -> f64 {
    let amounts: Vec<f64> =
        wanted.iter().zip(counts).map(|(class, &n)| f64::from(n) * class.of_one).collect();
    let total: f64 = amounts.iter().sum();
    let mut off: Vec<f64> = vec![0.0; wanted.len()];
    let mut largest: f64 = 0.0;
    for (class, amount) in wanted.iter().zip(&amounts) {
        let by = amount / total - class.share;
        largest = largest.max(by.abs());
        off[class.component] += by;
    }
    off.into_iter().fold(largest, |most, by| most.max(by.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(classes: &[(usize, f64, f64)]) -> Vec<Wanted> {
        let class = |&(component, share, um): &(usize, f64, f64)| Wanted {
            component,
            share,
            of_one: um.powi(3),
            dusty_um: um,
        };
        classes.iter().map(class).collect()
    }

    #[test]
    fn shares_are_reached_to_the_rounding_of_whole_grains() {
        for classes in [
            vec![(0, 0.7, 640.0), (1, 0.3, 300.0)],
            vec![(0, 0.25, 400.0), (0, 0.25, 520.0), (0, 0.25, 680.0), (1, 0.25, 850.0)],
            vec![(0, 0.05, 500.0), (1, 0.95, 450.0)],
        ] {
            let wanted = wanted(&classes);
            let counts = choose(&wanted, 72).expect("reached");
            let grains: u32 = counts.iter().sum();
            assert!((70..=400).contains(&grains), "{counts:?}");
            assert!(deviation(&wanted, &counts) <= CLOSE, "{counts:?}");
        }
        assert_eq!(choose(&wanted(&[(0, 1.0, 500.0)]), 40), Ok(vec![40]));
    }

    /// One grain of 2000 um weighs as much as 8000 of 100 um.
    #[test]
    fn sizes_too_wide_for_a_bed_name_the_rarest_class() {
        let wanted = wanted(&[(0, 0.5, 100.0), (0, 0.5, 2000.0)]);
        assert_eq!(choose(&wanted, 72), Err(1));
        assert!(choose(&wanted, 8100).is_ok());
    }
}
