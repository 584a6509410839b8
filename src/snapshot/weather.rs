//! Weather and daylight of a moment, where events of the scenario change them. In: two of them, and a share. Out: the weather between. km, mm/h, h.

/// Weather and daylight of a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weather {
    /// Range of sight, km; below 1 km there is fog.
    pub visibility_km: f64,
    /// Intensity of the rain, mm/h; 0 is dry.
    pub rain_mmph: f64,
    /// Solar time of day, h.
    pub time_h: f64,
}

impl Weather {
    /// Returns the weather at a share of the change from this one to another. Sight changes evenly in the density of the air, 1/km, as fog comes in.
    #[must_use]
    pub fn towards(&self, to: &Self, share: f64) -> Self {
        let mix = |from: f64, to: f64| from + (to - from) * share;
        Self {
            visibility_km: 1.0 / mix(1.0 / self.visibility_km, 1.0 / to.visibility_km),
            rain_mmph: mix(self.rain_mmph, to.rain_mmph),
            time_h: mix(self.time_h, to.time_h),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fog_comes_in_by_the_density_of_the_air() {
        let clear = Weather { visibility_km: 10.0, rain_mmph: 0.0, time_h: 12.0 };
        let fog = Weather { visibility_km: 0.1, rain_mmph: 4.0, time_h: 14.0 };
        // By hand: half of 0.1 and 10 1/km is 5.05 1/km.
        let half = clear.towards(&fog, 0.5);
        assert!((half.visibility_km - 1.0 / 5.05).abs() < 1e-12, "{half:?}");
        assert_eq!((half.rain_mmph, half.time_h), (2.0, 13.0));
        assert_eq!([clear.towards(&fog, 0.0).rain_mmph, clear.towards(&fog, 1.0).time_h], [0.0, 14.0]);
    }
}
