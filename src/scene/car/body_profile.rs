//! Profiles of the bodies: width and height of each part along x. All styles have the same front, up to the doors. Metres in the
//! body's frame. Our own drawing of a common mid-size car; smooth between the listed stations (monotone cubic, which does not
//! overshoot).

use glam::{Vec2, Vec3};

/// Foot of the windscreen, x in metres.
pub(in crate::scene) const CABIN_FRONT_M: f32 = 1.12;

type ProfileTable = &'static [(f32, f32)];

/// Lines that differ between body styles: all behind the doors.
#[derive(Debug)]
pub(in crate::scene) struct BodyLines {
    /// Foot of the rear window, x in metres.
    pub cabin_rear_m: f32,
    /// Rear and front end of the rear window along x, metres.
    pub rear_glass: [f32; 2],
    /// Distance by which the middle of the rear window's foot stands out behind its corners, metres.
    rear_bow_m: f32,
    /// Upper and rear edge of the side windows as (x, z), from the foot of the windscreen to the rear end of the belt.
    pub side_glass: &'static [(f32, f32)],
    boot: ProfileTable,
    top: ProfileTable,
    roof_z: ProfileTable,
    roof_y: ProfileTable,
}

const SALOON_GLASS: [(f32, f32); 10] = [
    (0.90, 0.932),
    (0.60, 1.138),
    (0.34, 1.262),
    (0.10, 1.316),
    (-0.20, 1.341),
    (-0.55, 1.341),
    (-0.85, 1.318),
    (-1.12, 1.238),
    (-1.34, 1.115),
    (-1.46, 0.995),
];
const ESTATE_GLASS: [(f32, f32); 10] = [
    (0.90, 0.932),
    (0.60, 1.138),
    (0.34, 1.262),
    (0.10, 1.320),
    (-0.20, 1.345),
    (-0.90, 1.348),
    (-1.50, 1.330),
    (-1.90, 1.300),
    (-2.06, 1.200),
    (-2.13, 1.010),
];
const LIFTBACK_GLASS: [(f32, f32); 10] = [
    (0.90, 0.932),
    (0.60, 1.138),
    (0.34, 1.262),
    (0.10, 1.318),
    (-0.20, 1.341),
    (-0.55, 1.340),
    (-0.95, 1.308),
    (-1.35, 1.215),
    (-1.68, 1.095),
    (-1.82, 1.000),
];

/// Saloon: separate boxes for engine, cabin and boot.
const SALOON: BodyLines = BodyLines {
    cabin_rear_m: -1.80,
    rear_glass: [-1.77, -0.93],
    rear_bow_m: 0.09,
    side_glass: &SALOON_GLASS,
    boot: BOOT,
    top: TOP,
    roof_z: ROOF_Z,
    roof_y: ROOF_Y,
};

/// Estate: roof to the end, steep tail.
const ESTATE: BodyLines = BodyLines {
    cabin_rear_m: -2.40,
    rear_glass: [-2.37, -2.16],
    rear_bow_m: 0.0,
    side_glass: &ESTATE_GLASS,
    boot: &[(-2.5, 0.915), (-2.47, 0.985), (-2.43, 1.030), (-2.40, 1.055)],
    top: &[
        (-2.40, 1.055),
        (-2.30, 1.200),
        (-2.18, 1.345),
        (-2.05, 1.392),
        (-1.60, 1.425),
        (-0.90, 1.446),
        (-0.40, 1.450),
        (-0.10, 1.443),
        (0.25, 1.395),
        (0.65, 1.210),
        (1.12, 0.970),
    ],
    roof_z: &[
        (-2.40, 1.015),
        (-2.30, 1.150),
        (-2.18, 1.290),
        (-2.05, 1.333),
        (-1.60, 1.364),
        (-0.90, 1.384),
        (-0.40, 1.388),
        (-0.10, 1.380),
        (0.25, 1.330),
        (0.65, 1.160),
        (1.12, 0.921),
    ],
    roof_y: &[
        (-2.40, 0.700),
        (-2.18, 0.650),
        (-1.90, 0.625),
        (-1.00, 0.608),
        (-0.40, 0.600),
        (0.25, 0.615),
        (0.65, 0.665),
        (1.12, 0.735),
    ],
};

/// Liftback: long sloping tail with a large rear window.
const LIFTBACK: BodyLines = BodyLines {
    cabin_rear_m: -2.28,
    rear_glass: [-2.20, -1.05],
    rear_bow_m: 0.0,
    side_glass: &LIFTBACK_GLASS,
    boot: &[(-2.5, 0.915), (-2.47, 0.980), (-2.40, 1.030), (-2.28, 1.062)],
    top: &[
        (-2.28, 1.062),
        (-1.90, 1.180),
        (-1.45, 1.305),
        (-1.00, 1.398),
        (-0.65, 1.438),
        (-0.40, 1.450),
        (-0.10, 1.443),
        (0.25, 1.395),
        (0.65, 1.210),
        (1.12, 0.970),
    ],
    roof_z: &[
        (-2.28, 1.025),
        (-1.90, 1.135),
        (-1.45, 1.252),
        (-1.00, 1.340),
        (-0.65, 1.378),
        (-0.40, 1.388),
        (-0.10, 1.380),
        (0.25, 1.330),
        (0.65, 1.160),
        (1.12, 0.921),
    ],
    roof_y: &[
        (-2.28, 0.700),
        (-1.45, 0.635),
        (-0.95, 0.605),
        (-0.40, 0.600),
        (0.25, 0.615),
        (0.65, 0.665),
        (1.12, 0.735),
    ],
};

/// Body styles; the first is the ego's.
pub(in crate::scene) const STYLES: [&BodyLines; 3] = [&SALOON, &ESTATE, &LIFTBACK];

/// Dimensions of one cross-section, metres.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct SectionMeasures {
    /// Half the width at the widest point of the side.
    pub half_width: f32,
    /// Height of the underside.
    pub sill_z: f32,
    /// Edge under the side windows, and along bonnet and boot.
    pub belt_y: f32,
    /// Height of the edge described at `belt_y`.
    pub belt_z: f32,
    /// Edge of the roof, line of the pillars; on bonnet and boot a line on their crowned top.
    pub roof_y: f32,
    /// Height of the edge described at `roof_y`.
    pub roof_z: f32,
    /// Height of the top in the middle.
    pub top_z: f32,
    /// Height of the bonnet's middle above its two creases.
    bulge_m: f32,
    /// True in the cabin, false on bonnet and boot.
    pub cabin: bool,
}

impl SectionMeasures {
    /// Returns a point (y, z) of the side between sill (0) and belt (1): a sill that turns under, full doors, a hollow, and above
    /// it the shoulder line from lamp to lamp.
    pub fn side(&self, t: f32) -> Vec2 {
        const INSET: &[(f32, f32)] = &[
            (0.0, 0.050),
            (0.05, 0.026),
            (0.16, 0.010),
            (0.34, 0.0),
            (0.50, 0.003),
            (0.64, 0.0115),
            (0.73, 0.0145),
            (0.79, 0.006),
            (0.84, 0.0055),
            (0.90, 0.020),
            (0.95, 0.036),
        ];
        let z = self.sill_z + (self.belt_z - self.sill_z) * t;
        let top = (0.95, 0.036);
        let inset = if t > top.0 {
            top.1 + (self.half_width - self.belt_y - top.1) * (t - top.0) / (1.0 - top.0)
        } else {
            curve(INSET, t)
        };
        Vec2::new(self.half_width - inset, z)
    }

    /// Returns the height of bonnet or boot at the distance `y` from the middle.
    pub fn crown(&self, y: f32) -> f32 {
        let y = y / self.belt_y;
        dome(y, self.belt_z, self.top_z) + self.bulge_m * smooth((BULGE[1] - y.abs()) / (BULGE[1] - BULGE[0]))
    }

    /// Returns a point (y, z) between belt (0) and roof edge (1).
    pub fn shoulder(&self, t: f32) -> Vec2 {
        let (belt, roof) = (Vec2::new(self.belt_y, self.belt_z), Vec2::new(self.roof_y, self.roof_z));
        let straight = belt.lerp(roof, t);
        if self.cabin {
            // Side glass is barrelled by 2 cm.
            straight + Vec2::new(0.02 * 4.0 * t * (1.0 - t) * ((self.roof_z - self.belt_z) / 0.4).min(1.0), 0.0)
        } else {
            let y = straight.x;
            Vec2::new(y, self.crown(y))
        }
    }
}

/// Returns the cross-section at `x`.
pub(in crate::scene) fn at(lines: &BodyLines, x: f32) -> SectionMeasures {
    let half_width = curve(WIDTH, x);
    let belt_y = half_width - curve(BELT_INSET, x);
    let belt_z = curve(BELT, x);
    let cabin = (lines.cabin_rear_m..=CABIN_FRONT_M).contains(&x);
    let (roof_y, roof_z, top_z) = if cabin {
        (curve(lines.roof_y, x), curve(lines.roof_z, x), curve(lines.top, x))
    } else {
        let top_z = curve(if x > 0.0 { BONNET } else { lines.boot }, x);
        let roof_y = belt_y * 0.86;
        (roof_y, dome(0.86, belt_z, top_z), top_z)
    };
    let sill_z = curve(FLOOR, x);
    // The bulge ends before the windscreen and above the grille.
    let bulge_m = if x > 0.0 && !cabin { 0.016 * smooth((x - 1.20) / 0.22) * smooth((2.44 - x) / 0.36) } else { 0.0 };
    SectionMeasures { half_width, sill_z, belt_y, belt_z, roof_y, roof_z, top_z, bulge_m, cabin }
}

/// Bends a body made of flat cross-sections: nose and tail are curved, and the feet of windscreen and rear window stand out in
/// the middle. Wheel arches, doors and the bumpers at y = 0 do not move.
pub(in crate::scene) fn bend(lines: &BodyLines, p: Vec3) -> Vec3 {
    /// Distance of nose and tail behind the bumper, by height, metres.
    const NOSE: &[(f32, f32)] = &[
        (0.18, 0.10),
        (0.25, 0.060),
        (0.33, 0.012),
        (0.42, 0.0),
        (0.50, 0.0),
        (0.58, 0.012),
        (0.66, 0.030),
        (0.74, 0.060),
        (0.82, 0.085),
    ];
    const TAIL: &[(f32, f32)] = &[
        (0.20, 0.14),
        (0.30, 0.085),
        (0.40, 0.018),
        (0.46, 0.0),
        (0.57, 0.0),
        (0.615, 0.010),
        (0.65, 0.042),
        (0.76, 0.052),
        (0.88, 0.034),
        (0.95, 0.014),
        (1.05, 0.020),
    ];
    let side = (p.y.abs() / 0.8).min(1.1);
    let end = smooth((p.x.abs() - 1.84) / (2.5 - 1.84));
    let (table, sweep) = if p.x > 0.0 { (NOSE, 0.17) } else { (TAIL, 0.115) };
    let clamped = p.z.clamp(table[0].0, table[table.len() - 1].0);
    let back = (sweep * side.powf(2.3) + curve(table, clamped)) * end;
    let bow = |middle: f32, [rear, front]: [f32; 2], most: f32| {
        let along = if p.x < middle { (p.x - rear) / (middle - rear) } else { (front - p.x) / (front - middle) };
        let across = (1.0 - side * side).max(0.0);
        most * smooth(along) * across * across
    };
    let bows = bow(CABIN_FRONT_M, [0.2, 2.0], 0.12) - bow(lines.cabin_rear_m, [-2.46, -0.95], lines.rear_bow_m);
    let high = smooth((p.z - 0.6) / 0.2);
    Vec3::new(p.x - back * p.x.signum() + bows * high, p.y, p.z)
}

pub(in crate::scene) fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Foot and top of the crease beside the bonnet's raised middle, as shares of the belt's half width.
const BULGE: [f32; 2] = [0.49, 0.63];

/// Returns the height of a crowned panel at the fraction `y` of its half width.
fn dome(y: f32, edge_z: f32, middle_z: f32) -> f32 {
    edge_z + (middle_z - edge_z) * (1.0 - y.abs().powf(2.5))
}

/// Evaluates a smooth curve through `(x, value)` with x ascending: cubic Hermite with the harmonic mean of neighbouring slopes
/// (Fritsch and Butland 1984), monotone where the points are.
fn curve(points: &[(f32, f32)], x: f32) -> f32 {
    let last = points.len() - 2;
    let i = points.partition_point(|p| p.0 <= x).saturating_sub(1).min(last);
    let slope = |k: usize| (points[k + 1].1 - points[k].1) / (points[k + 1].0 - points[k].0);
    let tangent = |k: usize| match k {
        0 => slope(0),
        k if k > last => slope(last),
        k if slope(k - 1) * slope(k) <= 0.0 => 0.0,
        k => 2.0 * slope(k - 1) * slope(k) / (slope(k - 1) + slope(k)),
    };
    let width = points[i + 1].0 - points[i].0;
    let t = ((x - points[i].0) / width).clamp(0.0, 1.0);
    let (t2, t3) = (t * t, t * t * t);
    points[i].1 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + points[i + 1].1 * (3.0 * t2 - 2.0 * t3)
        + width * (tangent(i) * (t3 - 2.0 * t2 + t) + tangent(i + 1) * (t3 - t2))
}

const WIDTH: &[(f32, f32)] = &[
    (-2.5, 0.760),
    (-2.47, 0.800),
    (-2.40, 0.838),
    (-2.25, 0.866),
    (-1.8, 0.892),
    (-1.2, 0.90),
    (1.2, 0.90),
    (1.8, 0.890),
    (2.1, 0.868),
    (2.3, 0.832),
    (2.42, 0.790),
    (2.48, 0.745),
    (2.5, 0.700),
];
const FLOOR: &[(f32, f32)] = &[
    (-2.5, 0.30),
    (-2.46, 0.265),
    (-2.35, 0.235),
    (-2.0, 0.215),
    (-1.5, 0.20),
    (1.5, 0.185),
    (2.1, 0.185),
    (2.35, 0.195),
    (2.45, 0.215),
    (2.5, 0.245),
];
const BELT_INSET: &[(f32, f32)] =
    &[(-2.5, 0.06), (-2.2, 0.075), (-1.0, 0.055), (0.9, 0.052), (1.6, 0.075), (2.5, 0.07)];
const BELT: &[(f32, f32)] = &[
    (-2.5, 0.885),
    (-2.47, 0.93),
    (-2.38, 0.965),
    (-2.2, 0.978),
    (-1.8, 0.98),
    (-1.0, 0.962),
    (0.0, 0.935),
    (1.0, 0.905),
    (1.6, 0.866),
    (2.0, 0.826),
    (2.25, 0.786),
    (2.4, 0.744),
    (2.47, 0.712),
    (2.5, 0.675),
];
const BONNET: &[(f32, f32)] =
    &[(1.12, 0.970), (1.6, 0.938), (2.0, 0.890), (2.25, 0.842), (2.4, 0.790), (2.47, 0.746), (2.5, 0.700)];
const BOOT: &[(f32, f32)] =
    &[(-2.5, 0.915), (-2.47, 0.97), (-2.40, 1.012), (-2.28, 1.032), (-2.0, 1.040), (-1.8, 1.045)];
const TOP: &[(f32, f32)] = &[
    (-1.80, 1.045),
    (-1.40, 1.225),
    (-0.95, 1.385),
    (-0.70, 1.428),
    (-0.40, 1.450),
    (-0.10, 1.443),
    (0.25, 1.395),
    (0.65, 1.210),
    (1.12, 0.970),
];
const ROOF_Z: &[(f32, f32)] = &[
    (-1.80, 1.010),
    (-1.40, 1.170),
    (-0.95, 1.325),
    (-0.70, 1.368),
    (-0.40, 1.388),
    (-0.10, 1.380),
    (0.25, 1.330),
    (0.65, 1.160),
    (1.12, 0.921),
];
const ROOF_Y: &[(f32, f32)] =
    &[(-1.80, 0.695), (-1.40, 0.640), (-0.95, 0.605), (-0.40, 0.600), (0.25, 0.615), (0.65, 0.665), (1.12, 0.735)];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_go_through_their_points_and_stay_between_them() {
        let styles = STYLES.iter().flat_map(|l| [l.boot, l.top, l.roof_y, l.roof_z]);
        for table in [WIDTH, FLOOR, BELT, BONNET].into_iter().chain(styles) {
            for pair in table.windows(2) {
                assert!(pair[0].0 < pair[1].0, "stations ascend");
                assert!((curve(table, pair[0].0) - pair[0].1).abs() < 1e-5);
                let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
                for i in 0..=20 {
                    let x = pair[0].0 + (pair[1].0 - pair[0].0) * i as f32 / 20.0;
                    assert!((low - 1e-5..=high + 1e-5).contains(&curve(table, x)), "{x}");
                }
            }
        }
    }

    #[test]
    fn glass_and_sheet_meet_at_the_ends_of_the_cabin() {
        for lines in STYLES {
            let rear = lines.cabin_rear_m;
            for (inside, outside) in [(CABIN_FRONT_M, CABIN_FRONT_M + 1e-4), (rear, rear - 1e-4)] {
                let (a, b) = (at(lines, inside), at(lines, outside));
                assert!((a.top_z - b.top_z).abs() < 0.005 && (a.roof_z - b.roof_z).abs() < 0.03, "{a:?} {b:?}");
            }
        }
    }
}
