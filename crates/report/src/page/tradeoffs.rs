//! What error costs in each application: one chart over all runs.

use serde::Serialize;

/// Error against cost of an application's techniques.
#[derive(Clone, Debug)]
pub(crate) struct Tradeoffs {
    pub(crate) application: &'static str,
    /// What the cost is, with its unit.
    pub(crate) cost: &'static str,
    /// What the error is.
    pub(crate) error: String,
    pub(crate) techniques: Vec<Tradeoff>,
}

/// A technique in an application, over all its receivers.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Tradeoff {
    pub(crate) name: String,
    /// Of the [`Family`](crate::drawing::Family) that gives it its colour.
    pub(crate) family: &'static str,
    /// Side of the map where several were measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) size: Option<u32>,
    pub(crate) bits: usize,
    /// Above 0.
    pub(crate) cost: f64,
    pub(crate) error: f64,
    /// Two standard errors.
    pub(crate) margin: f64,
    /// Whether it takes part in the front; what is the truth itself does not.
    pub(crate) competes: bool,
    /// How the stability experiment calls its bound with its format, and its moment bias.
    #[serde(skip)]
    pub(crate) stored: Option<(String, Option<f64>)>,
    /// Share of fragments of scenes on which its bound breaks or has no number; nothing where nobody measured it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) breaks: Option<f64>,
}

/// Share of fragments that makes a technique unstable.
pub(crate) const UNSTABLE: f64 = 1e-4;

impl Tradeoff {
    pub(crate) fn is_unstable(&self) -> bool {
        self.breaks.is_some_and(|share| share > UNSTABLE)
    }
}

/// On which share of fragments of scenes a bound in a format breaks, by moment bias.
#[derive(Clone, Debug)]
pub(crate) struct Breaks {
    /// As in [`Tradeoff::stored`].
    pub(crate) method: String,
    pub(crate) recommended: f64,
    /// (alpha, share).
    pub(crate) shares: Vec<(f64, f64)>,
}

impl Breaks {
    /// At the measured bias that is nearest to this one, or to the recommended one without it.
    pub(crate) fn share(&self, alpha: Option<f64>) -> Option<f64> {
        let wanted = alpha.filter(|alpha| *alpha > 0.0).unwrap_or(self.recommended);
        let distance = |alpha: f64| (alpha.max(f64::MIN_POSITIVE) / wanted).ln().abs();
        let nearest = self.shares.iter().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
        nearest.map(|(_, share)| *share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_that_of_the_nearest_bias() {
        let breaks = Breaks {
            method: "Hamburger 4, unorm16".to_owned(),
            recommended: 3e-5,
            shares: vec![(0.0, 0.5), (3e-5, 2e-4), (6e-5, 0.0)],
        };
        assert_eq!(breaks.share(None), Some(2e-4));
        assert_eq!(breaks.share(Some(5.5e-5)), Some(0.0));
        assert_eq!(breaks.share(Some(0.0)), Some(2e-4));
    }
}
