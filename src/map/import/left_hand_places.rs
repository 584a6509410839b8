//! Places with left-hand traffic. In: a latitude and a longitude, degrees. Out: true where traffic drives on the left. Borders on land are
//! accurate to about 3 km; coasts are drawn outwards (docs/references.md: sides).

use std::sync::LazyLock;

/// Rings of points `longitude,latitude` in hundredths of a degree, each ended by a semicolon.
const RINGS: &str = include_str!("left_hand_places.txt");

/// Closed line around an area, with its bounds; a ring within another cuts a hole.
struct Ring {
    points: Vec<[f64; 2]>,
    low: [f64; 2],
    high: [f64; 2],
}

static AREAS: LazyLock<Vec<Ring>> = LazyLock::new(|| {
    let number = |text: &str| text.parse::<f64>().ok().map(|hundredths| hundredths / 100.0);
    let point = |text: &str| text.split_once(',').and_then(|(x, y)| Some([number(x)?, number(y)?]));
    let rings = RINGS.split(';').map(|ring| ring.split_whitespace().filter_map(point).collect::<Vec<_>>());
    rings.filter(|points| !points.is_empty()).map(ring).collect()
});

fn ring(points: Vec<[f64; 2]>) -> Ring {
    let bound =
        |axis: usize, pick: fn(f64, f64) -> f64| points.iter().map(|point| point[axis]).reduce(pick).unwrap_or(0.0);
    let (low, high) = ([bound(0, f64::min), bound(1, f64::min)], [bound(0, f64::max), bound(1, f64::max)]);
    Ring { points, low, high }
}

impl Ring {
    fn contains(&self, x: f64, y: f64) -> bool {
        if x < self.low[0] || x > self.high[0] || y < self.low[1] || y > self.high[1] {
            return false;
        }
        let ends = self.points.iter().zip(self.points.iter().cycle().skip(1));
        // Sides that a ray to the east crosses: an odd number for a point inside.
        let crossed =
            ends.filter(|([x1, y1], [x2, y2])| (*y1 > y) != (*y2 > y) && x < x1 + (y - y1) / (y2 - y1) * (x2 - x1));
        crossed.count() % 2 == 1
    }
}

/// Returns true if traffic drives on the left at a place, degrees.
pub(super) fn is_left_hand(latitude: f64, longitude: f64) -> bool {
    AREAS.iter().filter(|ring| ring.contains(longitude, latitude)).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cities_on_either_side_of_borders_have_their_side() {
        let left = "London 51.51 -0.13, Dublin 53.35 -6.26, Belfast 54.6 -5.93, Valletta 35.9 14.51, Nicosia 35.17 33.36, Jersey 49.19 -2.11, \
                    Hong Kong 22.32 114.17, Macau 22.19 113.55, Singapore 1.35 103.82, Johor 1.49 103.74, Jakarta -6.2 106.8, \
                    Kota Kinabalu 5.98 116.07, Dili -8.56 125.57, Port Moresby -9.44 147.18, Nong Khai 17.87 102.74, \
                    Bangkok 13.75 100.5, Delhi 28.6 77.2, Kathmandu 27.7 85.32, Thimphu 27.47 89.64, Dhaka 23.8 90.4, Chittagong 22.36 91.8, \
                    Lahore 31.55 74.34, Quetta 30.18 67.0, Colombo 6.93 79.85, Male 4.18 73.5, Tokyo 35.68 139.7, Tsushima 34.2 129.29, \
                    Perth -31.95 115.86, Hobart -42.88 147.33, Auckland -36.85 174.76, Nairobi -1.29 36.82, Kampala 0.35 32.58, \
                    Lusaka -15.4 28.3, Ndola -12.97 28.64, Windhoek -22.56 17.07, Gaborone -24.65 25.9, Maputo -25.97 32.57, \
                    Cape Town -33.92 18.42, Maseru -29.3 27.5, Port Louis -20.16 57.5, Georgetown 6.8 -58.16, Paramaribo 5.85 -55.2, \
                    Kingston 17.98 -76.8, Nassau 25.05 -77.35, Port of Spain 10.65 -61.5, Bridgetown 13.1 -59.6, Saint Thomas 18.34 -64.93, \
                    The Valley 18.217 -63.057, Hamilton 32.3 -64.78, Stanley -51.7 -57.85, Suva -18.14 178.44, Apia -13.83 -171.77, \
                    Nuku'alofa -21.14 -175.2";
        let right = "Calais 50.95 1.85, Saint-Malo 48.65 -2.02, Gibraltar 36.14 -5.35, Shenzhen 22.55 114.06, Zhuhai 22.28 113.53, \
                     Vientiane 17.97 102.6, Phnom Penh 11.57 104.92, Yangon 16.84 96.17, Tawang River 29.65 91.1, Kabul 34.53 69.17, \
                     Zahedan 29.5 60.86, Seoul 37.57 126.98, Busan 35.18 129.08, Manila 14.6 120.98, Zamboanga 6.92 122.08, Addis Ababa 9.03 38.74, \
                     Kigali -1.95 30.06, Bujumbura -3.38 29.36, Goma -1.66 29.22, Lubumbashi -11.66 27.48, Luanda -8.84 13.23, \
                     Antananarivo -18.88 47.5, Cayenne 4.92 -52.31, Boa Vista 2.82 -60.67, Havana 23.11 -82.37, Miami 25.76 -80.19, \
                     San Juan 18.47 -66.1, Marigot 18.07 -63.08, Fort-de-France 14.6 -61.07, Guiria 10.57 -62.3, Pago Pago -14.28 -170.7, \
                     Noumea -22.27 166.45, Berlin 52.52 13.4, New York 40.7 -74.0, Sao Paulo -23.5 -46.6, Lagos 6.5 3.4, Cairo 30.0 31.2";
        for (cities, expected) in [(left, true), (right, false)] {
            for city in cities.split(", ") {
                let mut words = city.rsplitn(3, ' ');
                let mut number = || words.next().unwrap().trim().parse::<f64>().unwrap();
                let (longitude, latitude) = (number(), number());
                assert_eq!(is_left_hand(latitude, longitude), expected, "{city}");
            }
        }
    }
}
