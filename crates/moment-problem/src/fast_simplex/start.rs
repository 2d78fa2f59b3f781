//! Where the primal method starts: near another basis's optimum, or at the distribution itself.

use super::engine::Engine;
use super::lanes::Lanes;
use super::pricing::dot;
use super::support::{LANES, SupportDistribution};
use super::vertex::{ARTIFICIAL, Vertex, largest_product};

/// A start may have weights that are negative by this times the size of their row: they are set to 0, which is less than
/// the perturbation changes.
const START_TOLERANCE: f64 = 1e-11;

/// How often a guess is corrected before it is given up.
const MAX_SHIFTS: usize = 5;

/// Weight of artificial columns, and gain by replacing one, that is rounding.
const REDUCED: f64 = 1e-13;

impl<V: Lanes, const R: usize, const K: usize> Engine<'_, V, R, K> {
    /// A basis near a guess whose weights are not negative.
    ///
    /// A point of contact between two neighbouring depths shows as a pair of columns. If one of its weights is
    /// negative, their centre of mass says where the pair would be right (Newton's method for the point).
    #[inline(always)]
    pub(super) fn shifted(&mut self, guess: &[u16], b: &[f64; R]) -> Option<Vertex<V, R, K>> {
        let mut vertex = Vertex::artificial(b);
        vertex.index.copy_from_slice(guess.get(..R)?);
        for attempt in 0..MAX_SHIFTS {
            vertex.invert(self.columns)?;
            let weights = vertex.solve(b);
            if vertex.negative_row(&weights, START_TOLERANCE).is_none() {
                return Some(vertex);
            }
            let mut entry = [[0.0; LANES]; K];
            for k in 0..K {
                weights[k].store(&mut entry[k]);
            }
            if attempt + 1 < MAX_SHIFTS {
                self.shift(&mut vertex.index, entry.as_flattened())?;
                self.pivots += 1;
            }
        }
        None
    }

    /// Moves pairs to their centres of mass; `None` if that is impossible.
    #[inline(always)]
    fn shift(&self, index: &mut [u16; R], weights: &[f64]) -> Option<()> {
        let last = self.columns.depths() as i32 - 1;
        let step = i32::from(self.step);
        let mut moved = false;
        let mut wrong = None;
        let mut before = -1;
        let mut r = 0;
        while r < R {
            let j = i32::from(index[r]);
            let paired = r + 1 < R && i32::from(index[r + 1]) == j + 1 && j != step && j + 1 != step;
            // Columns must not meet.
            if j <= before && !paired {
                return None;
            }
            if !paired {
                before = j;
                r += 1;
                continue;
            }
            let (first, second) = (weights[r], weights[r + 1]);
            let mut to = j;
            if first < 0.0 || second < 0.0 {
                let mass = first + second;
                if mass > 0.0 {
                    let (low, high) = if j < step { (0, step - 2) } else { (step + 1, last - 1) };
                    if low > high {
                        return None;
                    }
                    to = ((f64::from(j) + second / mass).floor() as i32).clamp(low, high);
                    moved |= to != j;
                } else if wrong.replace(r).is_some() {
                    return None;
                }
            }
            if to <= before {
                return None;
            }
            index[r] = to as u16;
            index[r + 1] = to as u16 + 1;
            before = to + 1;
            r += 2;
        }
        if let Some(r) = wrong {
            // A point of contact without mass has left the interval: contact at both its ends takes its place.
            if index[0] == 0 || i32::from(index[R - 1]) == last {
                return None;
            }
            index.copy_within(0..r, 1);
            index.copy_within(r + 2..R, r + 1);
            index[0] = 0;
            index[R - 1] = last as u16;
            moved = true;
        }
        moved.then_some(())
    }

    /// At most R depths of the distribution that have its moments (Caratheodory), by the primal method from artificial
    /// columns over its own; depths of any kind make up the number.
    #[inline(always)]
    pub(super) fn reduced(&mut self, kernel: &SupportDistribution, b: &[f64; R]) -> Option<Vertex<V, R, K>> {
        let indices = kernel.indices();
        self.own.clear();
        for group in indices.chunks(LANES) {
            let mut columns = [[0.0; LANES]; R];
            for lane in 0..LANES {
                let column = self.columns.column(usize::from(group[lane.min(group.len() - 1)]));
                for i in 0..R {
                    columns[i][lane] = column[i];
                }
            }
            self.own.push(columns);
        }
        let mut vertex = Vertex::artificial(b);
        let mut weights = vertex.solve(b);
        for _ in 0..4 * R {
            // Cost 1 for artificial columns, 0 for the others: the dual vector sums the rows of the former.
            let y = vertex.rows_where(|index| index == ARTIFICIAL);
            if dot(&y, b) <= REDUCED {
                break;
            }
            let (gain, place) = largest_product::<V, R>(&self.own, &y);
            if gain <= REDUCED {
                break;
            }
            self.pivots += 1;
            let entering = usize::from(indices[place.min(indices.len() - 1)]);
            self.enter(&mut vertex, &mut weights, entering, 0.0)?;
        }
        for row in 0..R {
            if vertex.index[row] == ARTIFICIAL {
                self.pivots += 1;
                let entering = self.largest_entry(&vertex.row(row));
                let direction = vertex.solve(self.columns.column(entering));
                vertex.replace(row, entering, &direction, 0.0)?;
            }
        }
        Some(vertex)
    }
}
