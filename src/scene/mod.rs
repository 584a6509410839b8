//! The scene on the CPU: what is to be seen. In: a map once ([`StaticScene`]), a [`Snapshot`](crate::sim::Snapshot) each
//! frame ([`View`]). Out: meshes, placements, cameras; no GPU. World axes, metres
//! from a local origin ([`StaticScene::origin`]), `f32`; colours are linear RGB.

pub mod camera;
pub mod car;
pub mod cockpit;
mod land;
mod mesh;
mod mesh_simplification;
mod network;
mod options;
mod point_key;
mod scenario_options;
mod static_scene;
mod trees;
mod vehicles;
mod view;

pub use cockpit::instrument_cluster::{CLUSTER_M, CLUSTER_RADIUS_M};
pub use cockpit::mirrors::MirrorPane;
pub use cockpit::{BONNET_EDGE, Cockpit};
pub use network::signals::SignalHead;
pub use options::{MirrorOptions, ViewOptions};
pub use scenario_options::view_options;
pub use view::view;

use crate::hud::Palette;
use glam::{DVec3, Quat, Vec2, Vec3};

/// A corner of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Vertex {
    /// Metres, in the mesh's own frame.
    pub position: [f32; 3],
    /// Unit normal.
    pub normal: [f32; 3],
    /// Linear albedo; multiplied by the instance's colour where the material is paint.
    pub colour: [f32; 3],
    /// Texture coordinates, metres on the road: along (`s_m`) and across (`offset_m`); on leaf
    /// cards the place, 0..1, plus twice the numbers of cut and variant (`foliage`).
    pub uv: [f32; 2],
    /// A [`Material`] as a number.
    pub material: u32,
}

/// How a surface answers light; the number is what the shader switches on.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// Rough, in the vertex's colour.
    Matt = 0,
    /// Car paint in the instance's colour.
    Paint = 1,
    /// Dark, reflecting glass.
    Glass = 2,
    /// Brake lamp: glows by the instance's brake value.
    BrakeLamp = 3,
    /// Polished or painted metal in the vertex's colour.
    Metal = 4,
    /// Rubber.
    Tyre = 5,
    /// The road's asphalt; grain from `uv`.
    Asphalt = 6,
    /// Road marking.
    Marking = 7,
    /// Meadow.
    Grass = 8,
    /// Tree bark.
    Bark = 9,
    /// Leaves, lit through.
    Leaves = 10,
    /// Head lamp glass.
    Lamp = 11,
    /// A number plate: surface and signs, which turn into their mean where they are too small to be read.
    Plate = 12,
    /// Gravel with grass growing into it: how far, from about -0.5 for bare gravel to 1 for grass, stands in place of blue.
    Verge = 13,
    /// A lamp that is lit: shines in the instance's colour.
    SignalLamp = 14,
}

/// Triangles with shared corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<Vertex>,
    /// Three indices a triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

/// A tree's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreePlace {
    /// Foot of the trunk.
    pub position: Vec3,
    /// Turn around the trunk, radians.
    pub yaw_rad: f32,
    /// Size, 1 as modelled.
    pub scale: f32,
    /// Tint, multiplied with the leaves' colour.
    pub tint: [f32; 3],
    /// Index into [`StaticScene::trees`].
    pub kind: usize,
}

/// A body style without wheels: x forward, y left, z up, origin on the ground under the centre.
#[derive(Clone, Debug, PartialEq)]
pub struct CarModel {
    /// Near and mid, without windows; far, with windows that are not seen through.
    pub levels: [Mesh; 3],
    /// The windows of near and mid, to be drawn over what is behind them.
    pub glass: [Mesh; 2],
    /// For pictures from above in which a car is a few pixels, and for shadows in them: with windows that are not seen
    /// through and without an underside. What wheels would show is hidden.
    pub plan: Mesh,
    /// Throws the shadow where a texel of the map is too wide for more: lies within the far level, so that it does not shade
    /// the body, and has no underside.
    pub shade: Mesh,
}

/// Step of the picture's local origin, metres.
pub const ORIGIN_STEP_M: f64 = 2000.0;

/// Everything that stands still during a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticScene {
    /// Where the picture's origin is in the world, metres: all that is drawn is counted from there, as single precision has steps of half
    /// a metre at 5,000 km. A multiple of [`ORIGIN_STEP_M`] near the middle of the roads, so that most places have 0.
    pub origin: DVec3,
    /// Road: asphalt, lines, shoulder; world axes.
    pub road: Mesh,
    /// Meadow and far ground; world axes.
    pub land: Mesh,
    /// Tree models, foot at the origin.
    pub trees: Vec<Mesh>,
    /// The same models with about a quarter of the triangles, for trees some way off.
    pub trees_mid: Vec<Mesh>,
    /// Solid, for their shadows.
    pub trees_shade: Vec<Mesh>,
    /// Where trees stand.
    pub tree_places: Vec<TreePlace>,
    /// Unit normals of the ground under them.
    pub tree_grounds: Vec<Vec3>,
    /// Where trees stand on the horizon, too far away to be more than a picture.
    pub far_tree_places: Vec<TreePlace>,
    /// A tuft of grass, foot at the origin.
    pub tuft: Mesh,
    /// Where tufts stand; their `kind` is 0.
    pub tuft_places: Vec<TreePlace>,
    /// What stands beside the road: reflector posts, signals; world axes.
    pub posts: Mesh,
    /// Heads of signals.
    pub signal_heads: Vec<SignalHead>,
    /// A lamp that is lit, of radius 1, shining along x.
    pub lit_lamp: Mesh,
    /// Body styles; [`CarInstance::style`] is an index into them.
    pub cars: Vec<CarModel>,
    /// What the driver sees of the own car.
    pub cockpit: Cockpit,
    /// One wheel, near, mid and far: axle along y through the origin, outer side towards +y.
    pub wheels: [Mesh; 3],
    /// Hubs of the four wheels in the body's frame at rest: front left, front right, rear left, rear right.
    pub hubs: [Vec3; 4],
    /// Middle of the road network and the radius that holds all of it, for the bird's-eye view.
    pub centre: Vec2,
    /// See `centre`.
    pub radius_m: f32,
    /// Height of all roads, m, if it is one.
    pub level_m: Option<f32>,
    /// Height of the highest road, m.
    pub highest_m: f32,
    /// The roads, counted from the local origin: heights, and what signals show.
    pub network: std::sync::Arc<crate::map::network::Network>,
}

/// One car in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarInstance {
    /// Body's origin (on the ground under the centre), world axes.
    pub position: Vec3,
    /// Body to world.
    pub rotation: Quat,
    /// Linear paint colour.
    pub colour: [f32; 3],
    /// Brake lamps, 0 dark to 1 lit.
    pub brake: f32,
    /// Size of the body over that of the model, along its axes.
    pub scale: Vec3,
    /// Per wheel: hub in the body's frame, metres.
    pub hubs: [Vec3; 4],
    /// Size of a wheel over that of the model, along its axes; y is the axle.
    pub wheel_scale: Vec3,
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f32,
    /// Rolled angle of the wheels, radians.
    pub spin_rad: f32,
    /// Index into [`StaticScene::cars`].
    pub style: usize,
    /// Number on its plates, see [`car::number_plate`].
    pub plate: u16,
    /// True for the participant's own car: not drawn in the driver's view or the mirror, where the eye sits inside it.
    pub is_ego: bool,
}

/// A lamp that is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitLamp {
    /// Middle of its front, world axes.
    pub position: Vec3,
    /// Unit direction in which it shines.
    pub facing: Vec3,
    /// Radius, metres.
    pub radius_m: f32,
    /// Its light, linear; 1 is that of a white sheet in daylight.
    pub light: [f32; 3],
}

/// Where a picture is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye, world axes, metres.
    pub eye: Vec3,
    /// Unit direction of the optical axis.
    pub forward: Vec3,
    /// Unit direction that is up in the picture.
    pub up: Vec3,
    /// What the lens does.
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
    /// From the driver's eye, mirror inset at the top, speedometer at the bottom.
    Driver,
    /// The rear-view mirror alone, a mirror image.
    Mirror,
    /// From above, north up: ego red, others green.
    Birdseye,
    /// From behind and above the ego.
    Chase,
}

impl ViewKind {
    /// All of them by the names that a command line has for them.
    pub const NAMED: [(&str, Self); 4] =
        [("driver", Self::Driver), ("mirror", Self::Mirror), ("birdseye", Self::Birdseye), ("chase", Self::Chase)];

    /// True for views of the road, which carry the speedometer; from above and in the mirror alone it would only hide cars.
    pub fn has_dial(self) -> bool {
        matches!(self, Self::Driver | Self::Chase)
    }
}

/// One picture, complete.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Which view.
    pub kind: ViewKind,
    /// The camera of the main picture.
    pub camera: Camera,
    /// The camera behind the mirror inset, if the view has one. It looks backwards; the renderer flips its picture left to right.
    pub mirror: Option<Camera>,
    /// All cars, the ego among them.
    pub cars: Vec<CarInstance>,
    /// Lamps that are lit: of signals, and indicators of vehicles.
    pub lamps: Vec<LitLamp>,
    /// The own car around the driver's eye.
    pub seat: Option<DriverSeat>,
    /// Unit direction **towards** the sun.
    pub to_sun: Vec3,
    /// Distance at which haze leaves 2 % of a contrast, metres.
    pub visibility_m: f32,
    /// Seconds since the start of the drive, for wind; anew every ten hours.
    pub time_s: f32,
    /// Speed of the wind, m/s; at 0 nothing sways.
    pub wind_mps: f32,
    /// The speedometer, if the view has one.
    pub dial: Option<crate::hud::DialView>,
    /// The speedometer's colours.
    pub palette: Palette,
    /// A square in the upper left corner for a photodiode: `None` without one, else whether it is white.
    pub patch: Option<bool>,
    /// How strongly the mirror is curved, see [`MirrorOptions::bend`]; 0 is flat.
    pub mirror_bend: f32,
}

/// The own car as its driver sees it, drawn with [`StaticScene::cockpit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriverSeat {
    /// The body, steadied as the camera is.
    pub car: CarInstance,
    /// The driver's camera in the body's frame, where it is the same in every picture.
    pub look: Camera,
    /// Angle of the steering wheel, radians, positive to the left; `None` shows the bonnet alone.
    pub steering_wheel_rad: Option<f32>,
    /// The rear-view mirror, the left and the right one, if they hang in the car; then the picture has no inset.
    pub mirrors: Option<[MirrorPane; 3]>,
}
