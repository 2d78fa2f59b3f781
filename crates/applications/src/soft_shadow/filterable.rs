//! Soft shadows from two queries to a filtered field: moment soft shadow mapping (BHS16 section 3) and, with two
//! moments, variance soft shadow mapping (Yang et al. 2010).

use moment_problem::arithmetic::Real;
use quantization::QuantizationError;

use super::penumbra::Penumbra;
use super::reconstruction::Reconstruction;
use super::{BlockerSearch, Blockers, Filter, Fragment};
use crate::field::MomentField;

/// Shadow intensity of a fragment: moments of the search region, blockers from the extremal distribution, moments of
/// the filter region, the bound.
///
/// # Errors
/// [`QuantizationError::Parameter`] if a region exceeds what the field can sum.
pub fn filterable_soft_shadow<R: Real>(
    field: &impl MomentField<R>,
    technique: &Reconstruction<R>,
    penumbra: &Penumbra<R>,
    search: &BlockerSearch<R>,
    filter: &Filter<R>,
    fragment: &Fragment<R>,
) -> Result<R, QuantizationError> {
    let blockers = filterable_blockers(field, technique, penumbra, search, fragment)?;
    if search.is_umbra(&blockers) {
        return Ok(R::one());
    }
    let widths = search.widths(penumbra, fragment.depth, &blockers);
    filtered_hard_shadow(field, technique, widths, filter, fragment)
}

/// What the blocker search finds: the extremal distribution in front of the receiver.
///
/// # Errors
/// As [`filterable_soft_shadow`].
pub fn filterable_blockers<R: Real>(
    field: &impl MomentField<R>,
    technique: &Reconstruction<R>,
    penumbra: &Penumbra<R>,
    search: &BlockerSearch<R>,
    fragment: &Fragment<R>,
) -> Result<Blockers<R>, QuantizationError> {
    let (region, compared) = search.applied(penumbra, fragment);
    Ok(technique.blockers(&field.means(&region, search.fit)?, compared))
}

/// The cheap alternative: hard shadows filtered over a region of fixed full widths in texels.
///
/// # Errors
/// As [`filterable_soft_shadow`].
pub fn filtered_hard_shadow<R: Real>(
    field: &impl MomentField<R>,
    technique: &Reconstruction<R>,
    widths: [R; 2],
    filter: &Filter<R>,
    fragment: &Fragment<R>,
) -> Result<R, QuantizationError> {
    let (region, compared) = filter.applied(fragment, widths);
    Ok(technique.intensity(&field.means(&region, filter.fit)?, compared))
}
