//! Tests of towns by numbers: light of street lamps on the ground, lit windows, cost of buildings.

use super::{
    daylight::{LUMINANCE, light_at},
    place::*,
};
use codrive::{
    map::RoadMap,
    render::{OFFSCREEN, Quality, Renderer, render_to_image, sky::atmosphere::Sky},
    scene::{self, Camera, Lens, Material, Mesh, StaticScene, Vertex, ViewKind, ViewOptions},
    sim::Snapshot,
};
use glam::Vec3;
use std::sync::OnceLock;

/// Returns the grid of streets, without trees and lamps, which would hide walls or light them.
fn grid() -> &'static StaticScene {
    static STAGE: OnceLock<StaticScene> = OnceLock::new();
    STAGE.get_or_init(|| {
        let map = RoadMap::load("grid").expect("a map that is shipped");
        StaticScene { posts: Mesh::default(), street_lamps: Vec::new(), ..StaticScene::with_trees(&map, 1, 0) }
    })
}

#[test]
fn a_street_lamp_lights_the_ground_by_the_inverse_square_of_its_distance() {
    const GREY: f32 = 0.18;
    // A level sheet far from the ego's beams, under a lamp at 6 m.
    let middle = Vec3::new(300.0, 300.0, 1.0);
    let mut sheet = Mesh::default();
    for (x, y) in [(-20.0, -20.0), (20.0, -20.0), (20.0, 20.0), (-20.0, 20.0)] {
        sheet.vertices.push(Vertex {
            position: (middle + Vec3::new(x, y, 0.0)).to_array(),
            normal: [0.0, 0.0, 1.0],
            colour: [GREY; 3],
            material: Material::Matt as u32,
            ..Default::default()
        });
    }
    sheet.indices.extend([0, 1, 2, 0, 2, 3]);
    let dark = StaticScene { posts: sheet, land: Mesh::default(), ..static_scene(false).clone() };
    let lit = StaticScene { street_lamps: vec![middle + Vec3::Z * 6.0], ..dark.clone() };
    let mut view = view(&snapshot(Vec::new()), ViewKind::Chase, &ViewOptions::default().at_hour(22.0));
    let lens = Lens::Perspective { fov_x_rad: 1.2 };
    view.camera = Camera { eye: middle + Vec3::Z * 25.0, forward: Vec3::NEG_Z, up: Vec3::Y, lens };
    let sky = Sky::new(view.to_sun, view.visibility_m, false);
    let places = [0.0, 3.0, 6.0, 9.0, 12.0].map(|off_m| middle + Vec3::X * off_m);
    let [dark, lit] = [&dark, &lit].map(|scene| {
        let mut renderer = Renderer::new(gpu(), scene, OFFSCREEN, Quality::LOW);
        let image = draw_with(&mut renderer, &view, [640, 360]);
        places.map(|place| light_at(&image, &view, place, 1).dot(LUMINANCE))
    });
    for (k, off_m) in [0.0f32, 3.0, 6.0, 9.0, 12.0].into_iter().enumerate() {
        let lux = (lit[k] - dark[k]) / (GREY * sky.exposure * sky.one_lux);
        // 900 cd from 6 m: 25 lx below the lamp, and a sixteenth of 12 m's square with the cosine further out.
        let wanted = 900.0 * 6.0 / (36.0 + off_m * off_m).powf(1.5);
        // Steps of 8 bits in picture and texture, and what a sheet mirrors.
        assert!((lux / wanted - 1.0).abs() < 0.2, "{lux} lx at {off_m} m instead of {wanted}");
    }
}

#[test]
fn some_windows_are_lit_at_night_and_dark_by_day() {
    let mut renderer = Renderer::new(gpu(), grid(), OFFSCREEN, Quality::LOW);
    // Walls as high as four storeys, seen from before their middle.
    let corner = |index: u32| Vec3::from(grid().buildings.vertices[index as usize].position);
    let walls = grid().buildings.indices.chunks(6).filter(|quad| {
        let vertex = grid().buildings.vertices[quad[0] as usize];
        let has_windows = vertex.material >> 20 & 3 != 3;
        let high_m = corner(quad[2]).z - corner(quad[0]).z;
        vertex.material & 255 == Material::Wall as u32 && has_windows && high_m > 12.0
    });
    let walls: Vec<(Vec3, Vec3)> = walls
        .map(|quad| {
            let normal = Vec3::from(grid().buildings.vertices[quad[0] as usize].normal);
            ((corner(quad[0]) + corner(quad[1])).with_z(12.0) / 2.0, normal)
        })
        .collect();
    assert!(walls.len() > 40, "{}", walls.len());
    let mut lit_walls = 0;
    for (middle, normal) in walls.iter().step_by(walls.len() / 12).take(12) {
        let shares = [12.0, 22.0].map(|hour| {
            let options = ViewOptions::default().at_hour(hour);
            let mut view = scene::view(&Snapshot::default(), 1.0, ViewKind::Chase, &options, grid());
            let eye = middle.with_z(6.0) + normal * 9.0;
            view.camera = Camera { eye, forward: -*normal, up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: 0.9 } };
            let image = render_to_image(gpu(), &mut renderer, &view, [160, 120]).unwrap_or_else(|e| panic!("{e}"));
            let mut light: Vec<u32> = image.pixels().map(|p| p.0[..3].iter().map(|c| u32::from(*c)).sum()).collect();
            light.sort_unstable();
            let median = light[light.len() / 2];
            light.iter().filter(|light| **light > 3 * median + 120).count() as f32 / light.len() as f32
        });
        assert!(shares[0] < 0.01, "windows shine by day: {shares:?}");
        lit_walls += u32::from(shares[1] > 0.01);
    }
    // Four of ten windows are lit, so that a wall with a dozen of them has at least one.
    assert!(lit_walls >= 9, "{lit_walls} of 12 walls have a lit window");
}

#[test]
fn buildings_take_at_most_a_quarter_of_a_pictures_triangles() {
    // Of the 300,000 that are promised at low (`costs`), as one hundred buildings are in sight and several hundred in the town.
    // Nothing else is in the scene, as walls hide other things, which saves more than buildings cost.
    let bare = StaticScene {
        buildings: Mesh::default(),
        road: Mesh::default(),
        land: Mesh::default(),
        posts: Mesh::default(),
        tree_places: vec![],
        tree_grounds: vec![],
        far_tree_places: vec![],
        tuft_places: vec![],
        parked_cars: vec![],
        ..grid().clone()
    };
    let built = StaticScene { buildings: grid().buildings.clone(), ..bare.clone() };
    let costs = [&built, &bare].map(|scene| {
        let mut renderer = Renderer::new(gpu(), scene, OFFSCREEN, Quality::LOW);
        let mut view = scene::view(&Snapshot::default(), 1.0, ViewKind::Chase, &ViewOptions::default(), scene);
        let lens = Lens::Perspective { fov_x_rad: ViewOptions::default().fov_x_rad() };
        // In the first street, with all nine crossings ahead.
        view.camera = Camera { eye: Vec3::new(20.0, 398.4, 1.2), forward: Vec3::X, up: Vec3::Z, lens };
        // The second picture, as the first draws all shadows.
        for _ in 0..2 {
            render_to_image(gpu(), &mut renderer, &view, [320, 180]).unwrap_or_else(|e| panic!("{e}"));
        }
        renderer.cost().total()
    });
    let [triangles, draws] = [costs[0].triangles - costs[1].triangles, costs[0].draws - costs[1].draws];
    println!("{triangles} triangles, {draws} draws; {} triangles of all buildings", grid().buildings.triangles());
    assert!((1_000..=75_000).contains(&triangles) && draws <= 60, "{triangles} triangles, {draws} draws");
}
