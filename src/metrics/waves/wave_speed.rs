//! Speed of the waves on a ring. In: a window of positions and speeds. Out: the speed of a frame of reference in which the pattern of
//! speeds along the ring stands best, and the share of the variance that stands in it.
//!
//! At each half second the speeds are interpolated along the ring between the vehicles, their mean over the ring is subtracted, and the
//! rest is a sum of Fourier modes. Moving the frame turns the phases of the modes; a pattern that stands in the frame keeps them.

use super::VehicleSample;
use std::f64::consts::TAU;

/// Time between samples of the pattern, s.
const SAMPLE_S: f64 = 0.5;
/// Length of a cell of the pattern, m, and the largest number of cells.
const CELL_M: f64 = 5.0;
const MOST_CELLS: usize = 200;
/// Largest speed of a wave, m/s, in either direction; and the resolution.
const MOST_MPS: f64 = 10.0;
const RESOLUTION_MPS: f64 = 0.25;
/// Smallest variance of a pattern, (m/s)²; below it there is no wave.
const LEAST_VARIANCE: f64 = 1e-6;

/// Waves of one window, or the median over windows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingWave {
    /// Speed in the road's frame, m/s, in steps of 0.25 m/s; negative against the direction of travel.
    pub speed_mps: f64,
    /// Share of the variance of speed along the ring and over the window that moves with the wave, 0 to 1.
    pub share: f64,
}

/// Fourier modes of the speeds along the ring at one moment, real and imaginary parts; the first has one wave on the ring.
type Modes = Vec<[f64; 2]>;

impl RingWave {
    /// Finds the wave of a window; `None` if positions are unknown, or speeds do not differ along the ring.
    pub(super) fn of(window: &[Vec<VehicleSample>], step_s: f64, ring_m: f64) -> Option<Self> {
        let known = |row: &Vec<VehicleSample>| row.iter().all(|vehicle| vehicle.position_m.is_finite());
        if !window.iter().all(known) || window[0].len() < 2 {
            return None;
        }
        let stride = super::steps_in(SAMPLE_S, step_s);
        let cells = ((ring_m / CELL_M).round() as usize).clamp(8, MOST_CELLS);
        let pattern = Pattern::new(cells);
        let moments: Vec<Modes> =
            window.iter().step_by(stride).map(|row| pattern.modes(&speeds_along(row, ring_m, cells))).collect();
        let square = |[re, im]: &[f64; 2]| re * re + im * im;
        let variance = moments.iter().flatten().map(square).sum::<f64>() / moments.len() as f64;
        if variance < LEAST_VARIANCE {
            return None;
        }
        let sample_s = stride as f64 * step_s;
        let candidates = (2.0 * MOST_MPS / RESOLUTION_MPS) as usize;
        let wave = |i: usize| {
            let speed_mps = i as f64 * RESOLUTION_MPS - MOST_MPS;
            Self { speed_mps, share: standing(&moments, TAU * speed_mps * sample_s / ring_m) / variance }
        };
        (0..=candidates).map(wave).max_by(|a, b| a.share.total_cmp(&b.share))
    }
}

/// Returns the variance of the mean pattern in a frame that moves by `angle_rad` of the ring from one moment to the next.
fn standing(moments: &[Modes], angle_rad: f64) -> f64 {
    // All modes side by side, as each turn of a phase waits for the one before it.
    let turns: Vec<(f64, f64)> = (0..moments[0].len()).map(|k| (angle_rad * (k + 1) as f64).sin_cos()).collect();
    let mut sums = vec![([0.0; 2], [1.0, 0.0]); turns.len()];
    for modes in moments {
        for (((sum, phase), turn), [re, im]) in sums.iter_mut().zip(&turns).zip(modes) {
            *sum = [sum[0] + re * phase[0] - im * phase[1], sum[1] + re * phase[1] + im * phase[0]];
            *phase = [phase[0] * turn.1 - phase[1] * turn.0, phase[0] * turn.0 + phase[1] * turn.1];
        }
    }
    sums.iter().map(|(sum, _)| (sum[0] * sum[0] + sum[1] * sum[1]) / (moments.len() as f64).powi(2)).sum()
}

/// Cosines and sines for the modes of a number of cells.
struct Pattern {
    cells: usize,
    circle: Vec<[f64; 2]>,
}

impl Pattern {
    fn new(cells: usize) -> Self {
        let at = |i: usize| {
            let (sin, cos) = (TAU * i as f64 / cells as f64).sin_cos();
            [cos, -sin]
        };
        Self { cells, circle: (0..cells).map(at).collect() }
    }

    fn modes(&self, speeds_mps: &[f64]) -> Modes {
        let mode = |k: usize| {
            let sum = speeds_mps.iter().enumerate().fold([0.0; 2], |[re, im], (i, speed)| {
                let [cos, sin] = self.circle[i * k % self.cells];
                [re + speed * cos, im + speed * sin]
            });
            sum.map(|part| part / self.cells as f64)
        };
        (1..=(self.cells - 1) / 2).map(mode).collect()
    }
}

/// Returns the indices of the vehicles in the order of their positions on the ring.
pub(super) fn order_on_ring(row: &[VehicleSample], ring_m: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..row.len()).collect();
    let at_m = |i: usize| row[i].position_m.rem_euclid(ring_m);
    order.sort_by(|a, b| at_m(*a).total_cmp(&at_m(*b)));
    order
}

/// Returns the speed at the start of each cell, interpolated between the vehicles before and behind.
fn speeds_along(row: &[VehicleSample], ring_m: f64, cells: usize) -> Vec<f64> {
    let of = |vehicle: &VehicleSample| (vehicle.position_m.rem_euclid(ring_m), vehicle.speed_mps);
    let mut vehicles: Vec<(f64, f64)> = row.iter().map(of).collect();
    vehicles.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The first vehicle again, a round further.
    vehicles.push((vehicles[0].0 + ring_m, vehicles[0].1));
    let at = |cell: usize| {
        let place_m = cell as f64 * ring_m / cells as f64;
        let place_m = if place_m < vehicles[0].0 { place_m + ring_m } else { place_m };
        let ahead = vehicles.partition_point(|vehicle| vehicle.0 <= place_m).clamp(1, vehicles.len() - 1);
        let [(back_m, back_mps), (ahead_m, ahead_mps)] = [vehicles[ahead - 1], vehicles[ahead]];
        let share = ((place_m - back_m) / (ahead_m - back_m).max(1e-9)).clamp(0.0, 1.0);
        back_mps + share * (ahead_mps - back_mps)
    };
    (0..cells).map(at).collect()
}
