//! Scene on the CPU. In: a map once ([`StaticScene`]), a [`Snapshot`](crate::sim::Snapshot) each frame ([`View`]). Out: meshes,
//! placements, cameras; no GPU. World axes, metres from a local origin ([`StaticScene::origin`]), `f32`; colours are linear RGB.

mod buildings;
pub mod camera;
pub mod car;
pub mod cockpit;
mod colours;
#[cfg(test)]
mod fixed_object_tests;
pub mod headlamps;
mod land;
mod mesh;
mod mesh_simplification;
mod mirror_options;
mod mirrored_lamps;
mod network;
mod options;
mod point_key;
mod scenario_options;
mod spray;
mod static_scene;
mod traffic_parts;
mod trees;
mod vehicle_lamps;
mod vehicles;
mod view;

pub use cockpit::instrument_cluster::{CLUSTER_M, CLUSTER_RADIUS_M};
pub use cockpit::mirrors::MirrorPane;
pub use cockpit::wipers::WiperMotion;
pub use cockpit::{BONNET_EDGE, Cockpit};
pub use headlamps::Headlamps;
pub use mirror_options::MirrorOptions;
pub use mirrored_lamps::MirroredLamp;
pub use network::signals::SignalHead;
pub use network::street_lamps::STREET_LAMP_M;
pub use options::ViewOptions;
pub use scenario_options::view_options;
pub use spray::SprayPuff;
pub use view::view;

use crate::hud::Palette;
use crate::snapshot::TaskPicture;
use glam::{DVec3, Quat, Vec2, Vec3};
use std::sync::Arc;

/// A corner of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// Position in the mesh's own frame, metres.
    pub position: [f32; 3],
    /// Unit normal in the mesh's own frame.
    pub normal: [f32; 3],
    /// Linear albedo; multiplied by the instance's colour where the material is paint.
    pub colour: [f32; 3],
    /// Texture coordinates. On the road metres along (`s_m`) and across (`offset_m`); on leaf cards the position, 0..1, plus
    /// twice the numbers of cut and variant (`leaf_cards`).
    pub uv: [f32; 2],
    /// Number of a [`Material`] in the lowest eight bits.
    pub material: u32,
}

/// Material of a surface; the shader selects by its number.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// Rough, in the vertex's colour.
    Matt = 0,
    /// Car paint in the instance's colour.
    Paint = 1,
    /// Dark, reflecting glass of windows.
    Glass = 2,
    /// Brake lamp; its brightness is the instance's brake value.
    BrakeLamp = 3,
    /// Polished or painted metal in the vertex's colour.
    Metal = 4,
    /// Rubber; in the cockpit leather and grained plastic.
    Tyre = 5,
    /// Asphalt of the road; grain from `uv`.
    Asphalt = 6,
    Marking = 7,
    Grass = 8,
    Bark = 9,
    /// Leaves, with light shining through them.
    Leaves = 10,
    /// Glass of lamps, and glossy black plastic.
    Lamp = 11,
    /// Number plate: surface and signs, drawn in their mean colour where the signs are too small to be read.
    Plate = 12,
    /// Gravel with grass; in place of blue the grass cover, from about -0.5 for bare gravel to 1 for grass.
    Verge = 13,
    /// Lit lamp: shines in the instance's colour.
    SignalLamp = 14,
    /// Retroreflecting sheeting of signs and posts.
    Reflector = 15,
    /// Head lamp; red is the lens's albedo, green and blue are its shares in the light by day and with dipped beams.
    HeadLamp = 16,
    /// Wall of a building; the bits above the number describe its openings (`buildings`). `uv` is along and above the ground floor, metres.
    Wall = 17,
    /// Tiled roof; `uv` is along the eaves and up the slope, metres.
    Roof = 18,
    /// Leaves of a hedge.
    Hedge = 19,
}

/// Triangles with shared corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    pub vertices: Vec<Vertex>,
    /// Three indices per triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

/// Placement of a tree or a tuft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreePlace {
    /// Foot of the plant in world axes, metres.
    pub position: Vec3,
    /// Rotation around the trunk, radians.
    pub yaw_rad: f32,
    /// Scale; 1 is the size of the model.
    pub scale: f32,
    /// Factor on the leaves' colour, per channel.
    pub tint: [f32; 3],
    /// Index into [`StaticScene::trees`]; 0 for tufts.
    pub kind: usize,
}

/// Body style without wheels: x forward, y left, z up, origin on the ground under the centre.
#[derive(Clone, Debug, PartialEq)]
pub struct CarModel {
    /// Meshes by level: near and mid without windows, far with opaque windows. Levels may share a mesh.
    pub levels: [Arc<Mesh>; 3],
    /// Windows of near and mid, drawn over the scene behind them.
    pub glass: [Mesh; 2],
    /// Body for pictures from above in which a car is a few pixels long, and for shadows in them: with opaque windows, without an
    /// underside. It covers the wheels' places.
    pub plan: Arc<Mesh>,
    /// Body for shadows where a texel of the shadow map is too coarse for the far level. It lies inside the far level, so that it
    /// does not shade the body, and has no underside.
    pub shade: Arc<Mesh>,
    /// Styles of the next phase of the gait and of the standing posture of a person, whose meshes have the same triangles at each level. `None` for
    /// vehicles.
    pub postures: Option<[usize; 2]>,
}

/// Static part of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticScene {
    /// Position of the picture's local origin in the world, metres. All drawn positions are relative to it, because single
    /// precision has steps of half a metre at 5,000 km. It is 0 for most maps ([`ORIGIN_STEP_M`](crate::roadside::ORIGIN_STEP_M)).
    pub origin: DVec3,
    /// Road: asphalt, lines, shoulder; world axes.
    pub road: Mesh,
    /// Line on the road along the ego's path, in the order of the path; empty without one. World axes.
    pub route_line: Mesh,
    /// Meadow and far ground; world axes.
    pub land: Mesh,
    /// Tree models, foot at the origin.
    pub trees: Vec<Mesh>,
    /// Tree models with about a quarter of the triangles, for trees further away.
    pub trees_mid: Vec<Mesh>,
    /// Solid tree models for shadows.
    pub trees_shade: Vec<Mesh>,
    /// Placements of the trees.
    pub tree_places: Vec<TreePlace>,
    /// Unit normals of the ground under the trees.
    pub tree_grounds: Vec<Vec3>,
    /// Placements of trees on the horizon, far enough to be drawn as flat pictures.
    pub far_tree_places: Vec<TreePlace>,
    /// Tuft of grass, foot at the origin.
    pub tuft: Mesh,
    /// Placements of tufts; their `kind` is 0.
    pub tuft_places: Vec<TreePlace>,
    /// Objects beside the road: reflector posts, signals; world axes.
    pub posts: Mesh,
    /// Heads of street lamps; their posts are in `posts`.
    pub street_lamps: Vec<Vec3>,
    /// Cars parked beside houses.
    pub parked_cars: Vec<CarInstance>,
    /// Buildings along the streets of towns; world axes.
    pub buildings: Mesh,
    pub signal_heads: Vec<SignalHead>,
    /// Lit lamp of radius 1, shining along x.
    pub lit_lamp: Mesh,
    /// Body styles, indexed by [`CarInstance::style`].
    pub cars: Vec<CarModel>,
    /// Ego as seen by its driver.
    pub cockpit: Cockpit,
    /// Wheel, near, mid and far: axle along y through the origin, outer side towards +y.
    pub wheels: [Mesh; 3],
    /// Hubs of the four wheels in the body's frame at rest: front left, front right, rear left, rear right.
    pub hubs: [Vec3; 4],
    /// Middle of the road network in the local frame, metres, for the bird's-eye view.
    pub centre: Vec2,
    /// Radius around `centre` that contains the whole road network, metres.
    pub radius_m: f32,
    /// Common height of all roads, m; `None` if heights differ.
    pub level_m: Option<f32>,
    /// Height of the highest road, m.
    pub highest_m: f32,
    /// Roads in the local frame, with their heights and signals.
    pub network: Arc<crate::map::network::Network>,
}

/// Vehicle in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarInstance {
    /// Body's origin (on the ground under the centre), world axes.
    pub position: Vec3,
    /// Rotation from the body's frame to the world's.
    pub rotation: Quat,
    /// Linear colour of the paint.
    pub colour: [f32; 3],
    /// Brake lamps, 0 dark to 1 lit.
    pub brake: f32,
    /// Scale of the model's body, along its axes.
    pub scale: Vec3,
    /// Hub of each wheel in the body's frame, metres.
    pub hubs: [Vec3; 4],
    /// Scale of the model's wheel, along its axes; y is the axle.
    pub wheel_scale: Vec3,
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f32,
    /// Rolled angle of the wheels, radians.
    pub spin_rad: f32,
    /// Index of the body style in [`StaticScene::cars`].
    pub style: usize,
    /// Number on its plates, see [`car::number_plate`]; of a person, the shares of [`CarModel::postures`]
    /// (`shaders/posture.wgsl`).
    pub plate: u16,
    /// True for a car without a driver beside a house: all its lamps are dark.
    pub is_parked: bool,
    /// True for the participant's own car, which is not drawn in the driver's view or the mirror, because the eye is inside it.
    pub is_ego: bool,
}

/// Lamp that is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitLamp {
    /// Middle of its front, world axes.
    pub position: Vec3,
    /// Unit direction in which it shines.
    pub facing: Vec3,
    /// Radius of the lamp's front, metres.
    pub radius_m: f32,
    /// Linear colour of the light; 1 is a white sheet in daylight.
    pub light: [f32; 3],
}

/// Position, orientation and lens of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye, world axes, metres.
    pub eye: Vec3,
    /// Unit direction of the optical axis.
    pub forward: Vec3,
    /// Unit direction that is up in the picture.
    pub up: Vec3,
    /// Projection of the lens.
    pub lens: Lens,
}

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Perspective; **horizontal** angle of view, radians (it follows from the screen's width and the eye's distance).
    Perspective {
        /// Full horizontal angle, radians.
        fov_x_rad: f32,
    },
    /// Parallel; the smaller side of the picture shows twice this many metres.
    Parallel {
        /// Half of the smaller side, metres.
        half_extent_m: f32,
    },
}

/// The four views of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ViewKind {
    /// View from the driver's eye, mirror inset at the top, speedometer at the bottom.
    Driver,
    /// View in the rear-view mirror alone, a mirror image.
    Mirror,
    /// View from above, north up: ego red, others green.
    Birdseye,
    /// View from behind and above the ego.
    Chase,
}

impl ViewKind {
    /// All views with their names on the command line.
    pub const NAMED: [(&str, Self); 4] =
        [("driver", Self::Driver), ("mirror", Self::Mirror), ("birdseye", Self::Birdseye), ("chase", Self::Chase)];

    /// Checks whether the view shows the speedometer: true for views of the road; in the other views it would only hide cars.
    pub fn has_dial(self) -> bool {
        matches!(self, Self::Driver | Self::Chase)
    }
}

/// Complete description of one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    pub kind: ViewKind,
    /// The camera of the main picture.
    pub camera: Camera,
    /// Camera of the mirror inset, if the view has one. It looks backwards; the renderer flips its picture left to right.
    pub mirror: Option<Camera>,
    /// All vehicles, the ego first.
    pub cars: Vec<CarInstance>,
    /// Indices of the visible part of [`StaticScene::route_line`].
    pub route_line: std::ops::Range<u32>,
    /// Lit lamps of signals, and indicators of vehicles.
    pub lamps: Vec<LitLamp>,
    /// Lamps that a wet road mirrors; empty on a dry one.
    pub mirrored_lamps: Vec<MirroredLamp>,
    /// Headlamps, the ego's first; empty while they are off.
    pub headlamps: Vec<Headlamps>,
    /// Ego around the driver's eye, in the driver's view only.
    pub seat: Option<DriverSeat>,
    /// Unit direction **towards** the sun, which may have set.
    pub to_sun: Vec3,
    /// Distance at which air and rain leave 2 % of a contrast, metres.
    pub visibility_m: f32,
    /// Intensity of the rain, mm/h; 0 is dry.
    pub rain_mmph: f32,
    /// Velocity of the camera, m/s: drops fall past it.
    pub velocity_mps: Vec3,
    /// Spray behind vehicles on a wet road.
    pub spray: Vec<SprayPuff>,
    /// Time since the start of the drive, for wind, seconds; starts again at 0 every ten hours.
    pub time_s: f32,
    /// Wind speed, m/s; at 0 no plant moves.
    pub wind_mps: f32,
    /// Speedometer, if the view has one.
    pub dial: Option<crate::hud::DialView>,
    /// Colours of the speedometer.
    pub palette: Palette,
    /// Square for a photodiode in the upper left corner: `None` without one, `Some(true)` if it is white.
    pub patch: Option<bool>,
    /// Secondary task in the picture.
    pub task: TaskPicture,
    /// Curvature of the mirror, see [`MirrorOptions::bend`]; 0 is flat.
    pub mirror_bend: f32,
}

/// Ego as its driver sees it, drawn with [`StaticScene::cockpit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriverSeat {
    /// Body with the camera's reduced pitch and roll.
    pub car: CarInstance,
    /// Driver's camera in the body's frame, in which it is constant.
    pub look: Camera,
    /// Angle of the steering wheel, radians, positive to the left; `None` shows the bonnet alone.
    pub steering_wheel_rad: Option<f32>,
    /// Angle of the wipers over their rest, radians; `None` on a dry day.
    pub wiper_rad: Option<f32>,
    /// Rear-view, left and right mirror, if they are drawn in the cockpit; the picture then has no inset.
    pub mirrors: Option<[MirrorPane; 3]>,
}
