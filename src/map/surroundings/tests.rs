//! Tests of what is read of a map's surroundings.

use super::*;
use BuildingUse::{Flats, House, Outbuilding};

fn of(elements: &str) -> Result<Surroundings, String> {
    parse(Path::new("surroundings.xml"), &format!("<additional>\n{elements}\n</additional>")).map_err(|e| e.to_string())
}

#[test]
fn buildings_are_read_with_their_use_height_and_outline() {
    // By SUMO's polyconvert 1.28 from OpenStreetMap's tags, the first one without its repeated corner.
    let found = of(
        r#"<poly id="200" type="building.house" layer="-1.00" shape="71.89,18.59 86.22,18.40 86.37,29.52 72.04,29.71 71.89,18.59">
               <param key="building:levels" value="2"/>
           </poly>
           <poly id="201" type="building.yes" height="11.50" shape="0,0 0,20 20,20 20,0"/>
           <poly id="202" type="amenity.bench" shape="0,0 9,0 9,9"/>
           <poly id="203" type="building" shape="0,0 9,0 9,0.1"/>
           <poly id="204" type="building.garage" shape="0,0,5 4,0,5 4,6,5 0,6,5"><param key="building:levels" value="1-2"/></poly>"#,
    )
    .expect("polygons");
    let looks = found.buildings.iter().map(|f| (f.kind, f.height_m, f.outline.len(), f.area_m2().round()));
    assert_eq!(
        looks.collect::<Vec<_>>(),
        [(House, Some(6.0), 4, 159.0), (Flats, Some(11.5), 4, 400.0), (Outbuilding, None, 4, 24.0)],
        "other polygons and thin ones are left out"
    );
    assert!(found.buildings.iter().all(|of| doubled_area_m2(&of.outline) > 0.0), "counter-clockwise");
    assert!(found.areas.is_empty() && found.trees.is_empty());
}

#[test]
fn land_and_trees_are_read_and_written_alike() {
    let found = of(r#"<poly id="1" type="landuse.forest" shape="0,0 90,0 90,90"/>
           <poly id="2" type="leisure.park" shape="0,0 0,20 20,20 20,0 0,0"/>
           <poly id="3" type="landuse.unheard_of" shape="0,0 9,0 9,9"/>
           <poi id="4" type="natural.tree" color="140,196,107" layer="1.00" x="190.13" y="340.52">
               <param key="leaf_type" value="needleleaved"/>
           </poi>
           <poi id="5" type="natural.tree" x="7" y="8"><param key="leaf_type" value="broadleaved"/></poi>
           <poi id="6" type="amenity.bench" x="7" y="NaN"/>
           <poi id="8" type="traffic_sign.DE:274-30" x="5" y="6" angle="90"/>
           <poi id="9" type="traffic_sign.DE:206" x="9" y="6"/>
           <poi id="10" type="traffic_sign.DE:274" x="9" y="6"/>
           <poi id="11" type="traffic_sign.DE:283" x="9" y="6"/>
           <poly id="7" type="natural.tree_row" shape="0,0 17,0"/>"#)
    .expect("surroundings");
    let land: Vec<_> = found.areas.iter().map(|area| (area.land_use, area.area_m2())).collect();
    assert_eq!(land, [(LandUse::Wood, 4050.0), (LandUse::Park, 400.0)]);
    let trees: Vec<_> = found.trees.iter().map(|tree| (tree.position.to_array(), tree.is_conifer)).collect();
    // The row is 17 m long: two steps of 8.5 m.
    let row = [([0.0, 0.0], false), ([8.5, 0.0], false), ([17.0, 0.0], false)];
    assert_eq!(trees[..2], [([190.13, 340.52], true), ([7.0, 8.0], false)]);
    assert_eq!(trees[2..], row);
    // It faces east, the second one north; a limit without a number and a sign of another kind are left out.
    let signs: Vec<_> = found.signs.iter().map(|s| (s.position.to_array(), s.facing_rad, s.kind)).collect();
    let east_and_north = [0.0, std::f64::consts::FRAC_PI_2];
    let expected = [
        ([5.0, 6.0], east_and_north[0], StatedSignKind::SpeedLimit(30)),
        ([9.0, 6.0], east_and_north[1], StatedSignKind::Stop),
    ];
    assert_eq!(signs, expected);
    let every = [
        LandUse::Wood,
        LandUse::Scrub,
        LandUse::Park,
        LandUse::Grass,
        LandUse::Field,
        LandUse::Residential,
        LandUse::Commercial,
        LandUse::Paved,
        LandUse::Water,
    ];
    assert_eq!(every.map(|kind| LandUse::of(kind.key_value())), every.map(Some));
    assert_eq!(parse(Path::new("x"), &found.text()).expect("its own file"), found);
}

#[test]
fn an_outline_of_very_many_corners_is_made_coarser() {
    let circle = |corners: u32| {
        let at = |k: u32| 100.0 * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / f64::from(corners));
        (0..corners).map(|k| format!("{},{} ", at(k).x, at(k).y)).collect::<String>()
    };
    for (kind, corners) in [("building", 200), ("natural.water", 2000)] {
        let found = of(&format!("<poly type=\"{kind}\" shape=\"{}\"/>", circle(6000))).expect("surroundings");
        let outlines = found.buildings.iter().map(|of| &of.outline).chain(found.areas.iter().map(|of| &of.outline));
        let [outline] = outlines.collect::<Vec<_>>()[..] else { panic!("one outline") };
        let area_m2 = doubled_area_m2(outline) / 2.0;
        assert!(outline.len() == corners && (area_m2 / 31_415.9 - 1.0).abs() < 0.001, "{} {area_m2}", outline.len());
    }
}

#[test]
fn a_fault_names_file_line_and_value() {
    let shape = of("<poly id=\"7\" type=\"building\" shape=\"0,0 x,1\"/>").unwrap_err();
    let angle = of("<poi id=\"8\" type=\"traffic_sign.DE:206\" x=\"1\" y=\"1\" angle=\"400\"/>").unwrap_err();
    assert!(
        angle.starts_with("surroundings.xml:2: poi \"8\": angle is \"400\"; allowed: degrees clockwise"),
        "{angle}"
    );
    assert!(shape.starts_with("surroundings.xml:2: poly \"7\": shape is \"0,0 x,1\"; allowed: points x,y"), "{shape}");
    assert!(of("<poly id=\"7\" type=\"building\" shape=\"NaN,0 9,0 9,9\"/>").is_err());
    let tree = of("<poi id=\"7\" type=\"natural.tree\" x=\"3\"/>").unwrap_err();
    assert!(tree.contains("poi \"7\": x,y is \"3,\"; allowed: points"), "{tree}");
    let height = of("<poly id=\"7\" type=\"building\" height=\"-3\" shape=\"0,0 9,0 9,9\"/>").unwrap_err();
    assert!(height.contains("height is \"-3\"; allowed: metres above 0"), "{height}");
    assert!(of("<poly").unwrap_err().starts_with("surroundings.xml:"));
}
