use super::Weights;
use crate::time_domain::{Memory, TimeDomain};
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner};
use std::sync::{Arc, OnceLock};

/// Steps in a block.
pub(crate) const BLOCK: usize = 128;
/// Frequencies kept of a real transform of two blocks.
const BINS: usize = BLOCK + 1;

/// `p_n = Σ_{j=1}^{n} W_{n−j} v_j` in uniform partitions (overlap-save).
///
/// Complete blocks of [`BLOCK`] steps are *frozen*: their spectra are kept, and their
/// contribution to the next block is summed once, in the frequency domain. Lags inside the
/// open block are summed directly.
pub(crate) struct Convolution {
    rows: usize,
    columns: usize,
    /// `W_n` for n < BLOCK, row-major.
    direct: Vec<Vec<f64>>,
    /// Entry (i, j) at `i * columns + j`: spectra of the lags `[(d − 1)B, (d + 1)B)`, d = 1, 2, ….
    partitions: Vec<Vec<Complex64>>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

/// The velocities of all steps of a convolution: an append-only list shared by reference.
///
/// A clone copies at most one block. The contribution of the history to the next step is
/// evaluated once and shared by all clones.
#[derive(Clone)]
pub(crate) struct History {
    frozen: Option<Arc<FrozenBlock>>,
    /// Contribution of the frozen blocks to the open one, `BLOCK` × rows.
    inherited: Arc<Vec<f64>>,
    /// Velocities of the open block, step by step.
    open: Vec<f64>,
    next: Arc<OnceLock<Next>>,
}

/// Contribution of a history to the next step.
struct Next {
    pressure: Vec<f64>,
    /// The open block, frozen, and the contribution of all frozen blocks, if it was complete.
    block: Option<(Arc<FrozenBlock>, Arc<Vec<f64>>)>,
}

struct FrozenBlock {
    velocities: Vec<f64>,
    /// Spectra of the zero-padded block, `BINS` per component.
    spectra: Vec<Complex64>,
    previous: Option<Arc<FrozenBlock>>,
}

impl Drop for FrozenBlock {
    /// Drops the list in a loop, because it may be too long for recursion.
    fn drop(&mut self) {
        let mut previous = self.previous.take();
        while let Some(mut block) = previous.and_then(Arc::into_inner) {
            previous = block.previous.take();
        }
    }
}

fn blocks(newest: &Option<Arc<FrozenBlock>>) -> impl Iterator<Item = &FrozenBlock> {
    std::iter::successors(newest.as_deref(), |block| block.previous.as_deref())
}

impl History {
    /// All velocities, step by step.
    pub fn velocities(&self) -> Vec<f64> {
        let mut frozen: Vec<_> = blocks(&self.frozen).map(|block| &block.velocities).collect();
        frozen.reverse();
        frozen.into_iter().chain([&self.open]).flatten().copied().collect()
    }

    /// Number of values that a clone copies; the rest is shared.
    #[cfg(test)]
    pub fn copied(&self) -> usize {
        self.open.len()
    }
}

impl Convolution {
    /// Prepares the partitions on the current rayon pool.
    pub fn new(weights: Weights) -> Self {
        let Weights { rows, columns, entries } = weights;
        let steps = entries.first().map_or(0, Vec::len);
        let mut planner = FftPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(2 * BLOCK), planner.plan_fft_inverse(2 * BLOCK));
        let at = |entry: &[f64], lag: usize| entry.get(lag).copied().unwrap_or(0.0);
        let direct = (0..BLOCK).map(|lag| entries.iter().map(|e| at(e, lag)).collect()).collect();
        let count = steps.saturating_sub(1).div_ceil(BLOCK);
        let partitions = entries
            .par_iter()
            .map(|entry| {
                let window = |d: usize| (0..2 * BLOCK).map(move |lag| at(entry, (d - 1) * BLOCK + lag));
                (1..=count).flat_map(|d| spectrum(&forward, window(d))).collect()
            })
            .collect();
        Self { rows, columns, direct, partitions, forward, inverse }
    }

    /// The history before the first step.
    fn start(&self) -> History {
        History {
            frozen: None,
            inherited: Arc::new(vec![0.0; BLOCK * self.rows]),
            open: Vec::new(),
            next: Arc::default(),
        }
    }

    /// The history after `velocities`, step by step, equal bit for bit to pushing them.
    fn resume_from(&self, velocities: &[f64]) -> History {
        let mut history = self.start();
        let frozen = (velocities.len() / self.columns).saturating_sub(1) / BLOCK * BLOCK * self.columns;
        for block in velocities[..frozen].chunks(BLOCK * self.columns) {
            history.frozen = Some(self.freeze(&history.frozen, block));
        }
        history.inherited = self.inherited(&history.frozen);
        history.open = velocities[frozen..].to_vec();
        history
    }

    /// Pressure (Pa) at the end of the step after `history` if the velocity there is `velocity` (m/s).
    fn pressure_after(&self, history: &History, velocity: &[f64]) -> Vec<f64> {
        let mut pressure = self.next(history).pressure.clone();
        self.add_lag(0, velocity, &mut pressure);
        pressure
    }

    /// Appends a velocity: the history after the step.
    fn pushed(&self, history: &History, velocity: &[f64]) -> History {
        let (frozen, inherited, mut open) = match &self.next(history).block {
            Some((block, inherited)) => (Some(block.clone()), inherited.clone(), Vec::new()),
            None => (history.frozen.clone(), history.inherited.clone(), history.open.clone()),
        };
        open.extend_from_slice(velocity);
        History { frozen, inherited, open, next: Arc::default() }
    }

    fn next<'a>(&self, history: &'a History) -> &'a Next {
        history.next.get_or_init(|| {
            let (rows, columns) = (self.rows, self.columns);
            if history.open.len() == BLOCK * columns {
                let frozen = self.freeze(&history.frozen, &history.open);
                let inherited = self.inherited(&Some(frozen.clone()));
                return Next { pressure: inherited[..rows].to_vec(), block: Some((frozen, inherited)) };
            }
            let step = history.open.len() / columns;
            let mut pressure = history.inherited[step * rows..][..rows].to_vec();
            for (index, velocity) in history.open.chunks(columns).enumerate() {
                self.add_lag(step - index, velocity, &mut pressure);
            }
            Next { pressure, block: None }
        })
    }

    fn add_lag(&self, lag: usize, velocity: &[f64], pressure: &mut [f64]) {
        for (p, row) in pressure.iter_mut().zip(self.direct[lag].chunks(self.columns)) {
            *p += row.iter().zip(velocity).map(|(w, v)| w * v).sum::<f64>();
        }
    }

    fn freeze(&self, previous: &Option<Arc<FrozenBlock>>, velocities: &[f64]) -> Arc<FrozenBlock> {
        let component = |j: usize| velocities.iter().skip(j).step_by(self.columns).copied();
        let spectra = (0..self.columns).flat_map(|j| spectrum(&self.forward, component(j))).collect();
        Arc::new(FrozenBlock { velocities: velocities.to_vec(), spectra, previous: previous.clone() })
    }

    /// Contribution of the frozen blocks to the block after them, `BLOCK` × rows.
    fn inherited(&self, newest: &Option<Arc<FrozenBlock>>) -> Arc<Vec<f64>> {
        let mut contribution = vec![0.0; BLOCK * self.rows];
        for i in 0..self.rows {
            let mut sum = vec![Complex64::ZERO; BINS];
            for j in 0..self.columns {
                let partitions = self.partitions[i * self.columns + j].chunks(BINS);
                for (partition, block) in partitions.zip(blocks(newest)) {
                    let spectrum = &block.spectra[j * BINS..][..BINS];
                    for ((sum, w), v) in sum.iter_mut().zip(partition).zip(spectrum) {
                        *sum += w * v;
                    }
                }
            }
            let mirrored = sum[1..BLOCK].iter().rev().map(|z| z.conj()).collect::<Vec<_>>();
            sum.extend(mirrored);
            self.inverse.process(&mut sum);
            for step in 0..BLOCK {
                contribution[step * self.rows + i] = sum[BLOCK + step].re / (2 * BLOCK) as f64;
            }
        }
        Arc::new(contribution)
    }
}

impl TimeDomain for Convolution {
    fn at_rest(&self) -> Memory {
        Memory::of(self.start())
    }

    fn pressure(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Option<Vec<f64>> {
        memory.get().map(|history| self.pressure_after(history, velocity))
    }

    fn push(&self, memory: &Memory, velocity: &[f64], _length: f64) -> Option<Memory> {
        memory.get().map(|history| Memory::of(self.pushed(history, velocity)))
    }

    fn instantaneous(&self, _length: f64) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.rows, self.columns, &self.direct[0])
    }

    fn values(&self, memory: &Memory) -> Option<Vec<f64>> {
        memory.get().map(History::velocities)
    }

    fn resume(&self, values: &[f64], steps: usize) -> Option<Memory> {
        (values.len() == steps * self.columns).then(|| Memory::of(self.resume_from(values)))
    }
}

/// The first half of the transform of real `values`, padded with zeros to two blocks.
fn spectrum(transform: &Arc<dyn Fft<f64>>, values: impl Iterator<Item = f64>) -> Vec<Complex64> {
    let mut buffer: Vec<Complex64> = values.map(Complex64::from).collect();
    buffer.resize(2 * BLOCK, Complex64::ZERO);
    transform.process(&mut buffer);
    buffer.truncate(BINS);
    buffer
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence(count: usize) -> Vec<f64> {
        (0..count).map(|i| ((i * 7919 % 1009) as f64 / 504.5 - 1.0) * (0.01 * i as f64).cos()).collect()
    }

    fn convolution(steps: usize) -> (Convolution, Vec<Vec<f64>>) {
        let entries: Vec<Vec<f64>> = (0..4)
            .map(|e| (0..steps).map(|n| (0.3 * n as f64 + e as f64).cos() / (1.0 + n as f64)).collect())
            .collect();
        (Convolution::new(Weights { rows: 2, columns: 2, entries: entries.clone() }), entries)
    }

    #[test]
    fn partitioned_equals_direct_sum() {
        let steps = 5 * BLOCK + 17;
        let (convolution, w) = convolution(steps);
        let v = sequence(2 * steps);
        let mut history = convolution.start();
        let mut worst: f64 = 0.0;
        for n in 1..=steps {
            let velocity = &v[2 * (n - 1)..2 * n];
            let pressure = convolution.pressure_after(&history, velocity);
            for i in 0..2 {
                let naive: f64 = (1..=n)
                    .flat_map(|j| (0..2).map(move |c| (j, c)))
                    .map(|(j, c)| w[2 * i + c][n - j] * v[2 * (j - 1) + c])
                    .sum();
                worst = worst.max((pressure[i] - naive).abs());
            }
            history = convolution.pushed(&history, velocity);
        }
        println!("partitioned against direct convolution: largest difference {worst:.1e}");
        assert!(worst < 1e-13);
        assert_eq!(history.velocities(), v);
    }

    #[test]
    fn resumed_history_is_the_same_bit_for_bit() {
        let (convolution, _) = convolution(4 * BLOCK);
        let v = sequence(8 * BLOCK);
        let mut history = convolution.start();
        for velocity in v.chunks(2) {
            let resumed = convolution.resume_from(&history.velocities());
            assert_eq!(
                convolution.pressure_after(&history, velocity),
                convolution.pressure_after(&resumed, velocity)
            );
            history = convolution.pushed(&history, velocity);
        }
    }

    #[test]
    fn a_clone_shares_all_but_the_open_block() {
        let (convolution, _) = convolution(40 * BLOCK);
        let mut history = convolution.start();
        for velocity in sequence(2 * (37 * BLOCK + 5)).chunks(2) {
            history = convolution.pushed(&history, velocity);
        }
        let clone = history.clone();
        assert_eq!(clone.copied(), 2 * 5);
        for (a, b) in blocks(&history.frozen).zip(blocks(&clone.frozen)) {
            assert!(std::ptr::eq(a, b));
        }
        assert!(Arc::ptr_eq(&history.inherited, &clone.inherited));
    }

    #[test]
    fn a_long_list_is_dropped_without_recursion() {
        let convolution = Convolution::new(Weights { rows: 1, columns: 1, entries: vec![vec![0.0; 1]] });
        let mut frozen = None;
        for _ in 0..200_000 {
            frozen = Some(Arc::new(FrozenBlock { velocities: vec![], spectra: vec![], previous: frozen }));
        }
        drop(History { frozen, ..convolution.start() });
    }
}
