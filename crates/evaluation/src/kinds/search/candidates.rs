//! All m-subsets of a family.

use moment_problem::{BasisFunction, FunctionKind};

/// n over k.
pub(crate) fn binomial(n: usize, k: usize) -> u64 {
    // Each partial product is a binomial coefficient itself, so that the division is exact.
    (0..k.min(n)).fold(1u64, |product, i| product.saturating_mul((n - i) as u64) / (i as u64 + 1))
        * u64::from(k <= n)
}

/// Subsets of one size in lexicographic order of their ascending members.
#[derive(Clone, Debug)]
pub(crate) struct Subsets {
    members: usize,
    order: usize,
}

impl Subsets {
    pub(crate) fn new(members: usize, order: usize) -> Self {
        Self { members, order }
    }

    pub(crate) fn len(&self) -> usize {
        binomial(self.members, self.order) as usize
    }

    pub(crate) fn order(&self) -> usize {
        self.order
    }

    /// The subset of a number below [`Subsets::len`].
    pub(crate) fn subset(&self, number: usize) -> Vec<usize> {
        let mut rest = number as u64;
        let mut next = 0;
        let mut subset = Vec::with_capacity(self.order);
        for place in 0..self.order {
            loop {
                let after = binomial(self.members - next - 1, self.order - place - 1);
                if rest < after {
                    break;
                }
                rest -= after;
                next += 1;
            }
            subset.push(next);
            next += 1;
        }
        subset
    }

    /// The number of a subset, given by ascending members.
    pub(crate) fn number(&self, subset: &[usize]) -> usize {
        let mut number = 0;
        let mut next = 0;
        for (place, &member) in subset.iter().enumerate() {
            for skipped in next..member {
                number += binomial(self.members - skipped - 1, self.order - place - 1);
            }
            next = member + 1;
        }
        number as usize
    }
}

/// The class of a candidate: that of its functions, or mixed.
pub(crate) fn class(functions: &[&BasisFunction]) -> &'static str {
    let first = functions[0].kind();
    if functions.iter().any(|function| function.kind() != first) {
        return "mixed";
    }
    match first {
        FunctionKind::Polynomial => "polynomial",
        FunctionKind::Rational => "rational",
        FunctionKind::Radical => "radical",
        FunctionKind::Exponential => "exponential",
        FunctionKind::Logarithmic => "logarithmic",
        FunctionKind::Trigonometric => "trigonometric",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subsets_are_numbered_in_order_and_back() {
        assert_eq!(binomial(37, 4), 66_045);
        assert_eq!((binomial(5, 6), binomial(6, 6), binomial(6, 0)), (0, 1, 1));
        let subsets = Subsets::new(7, 3);
        let all: Vec<Vec<usize>> = (0..subsets.len()).map(|number| subsets.subset(number)).collect();
        assert_eq!((all.len(), &all[0], &all[34]), (35, &vec![0, 1, 2], &vec![4, 5, 6]));
        assert!(all.windows(2).all(|w| w[0] < w[1]));
        assert!(all.iter().enumerate().all(|(number, subset)| subsets.number(subset) == number));
    }

    #[test]
    fn classes_need_all_functions_alike() {
        let functions: Vec<BasisFunction> =
            ["z", "z^3", "1/(1+z)", "exp(-2z)", "sin(2pi z)", "ln(1+z)"].map(|f| f.parse().unwrap()).into();
        let class = |members: &[usize]| class(&members.iter().map(|&i| &functions[i]).collect::<Vec<_>>());
        assert_eq!([class(&[0, 1]), class(&[2]), class(&[0, 2])], ["polynomial", "rational", "mixed"]);
        assert_eq!([class(&[3]), class(&[4]), class(&[5])], ["exponential", "trigonometric", "logarithmic"]);
    }
}
