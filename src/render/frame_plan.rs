//! Plan of a frame: one pass for each camera whose picture is drawn. In: a [`View`], the size of the target and the quality. Out: cameras,
//! sizes in pixels, and the places of the mirrors' pictures.

use super::{
    Quality,
    device::timing::TimedPass,
    post::tonemap::{FramedMirror, MirrorGlass, MirrorPlace, hidden_by_mirror, mirror_rect},
    scene_pass::EgoVisibility,
    view_projection::ViewFrustum,
};
use crate::scene::{Camera, MirrorPane, View, ViewKind};
use std::ops::Range;

/// Picture of one camera.
pub(super) struct ViewPass {
    pub frustum: ViewFrustum,
    /// Size of the drawn picture, pixels.
    pub size: [u32; 2],
    pub ego: EgoVisibility,
    /// Area that a mirror hides: left, top, width and height in pixels.
    pub hidden: Option<[u32; 4]>,
    pub timed: TimedPass,
}

/// Cameras of a frame.
pub(super) struct FramePlan {
    /// Passes of the main camera, the rear-view mirror, and the left and right mirror.
    pub passes: [Option<ViewPass>; 4],
    /// Places of the mirrors' pictures in the main picture.
    pub mirrors: [Option<FramedMirror>; 3],
    /// Glass of the mirror that is the whole picture, if one is.
    pub alone: Option<MirrorGlass>,
}

impl FramePlan {
    /// Plans a picture of `size` pixels.
    pub fn new(view: &View, size: [u32; 2], quality: &Quality) -> Self {
        let is_alone = view.kind == ViewKind::Mirror;
        let camera = if is_alone { view.mirror.as_ref().unwrap_or(&view.camera) } else { &view.camera };
        let alone = is_alone.then(|| MirrorGlass::new(camera, view.mirror_bend, aspect(size)));
        let back = view.mirror.filter(|_| !is_alone);
        let panes = view.seat.and_then(|seat| seat.mirrors).filter(|_| back.is_some());
        let drawn = quality.drawn_size(size, is_alone);
        let main = ViewPass {
            frustum: ViewFrustum::new(&alone.map_or(*camera, |glass| glass.behind(camera)), size),
            size: drawn,
            ego: match view.kind {
                ViewKind::Birdseye | ViewKind::Chase => EgoVisibility::Outside,
                _ => EgoVisibility::Inside,
            },
            hidden: back.filter(|_| panes.is_none()).and_then(|_| hidden_by_mirror(size, drawn)),
            timed: TimedPass::Main,
        };
        let scaled = |side: u32| ((side as f32 * quality.mirror_scale).round() as u32).max(1);
        let mirror = |camera: &Camera, glass: MirrorGlass, size, ego| {
            let frustum = ViewFrustum::new(&glass.behind(camera), size);
            ViewPass { frustum, size, ego, hidden: None, timed: TimedPass::Mirror }
        };
        let glass_px = |pane: &MirrorPane| [1.0, pane.aspect].map(|over| pane.width_share * size[0] as f32 / over);
        let pane_px = |pane: &MirrorPane| glass_px(pane).map(|side| scaled(side.round() as u32));
        let [_, _, width, height] = mirror_rect(size);
        let inset = panes.map_or([width, height].map(scaled), |panes| pane_px(&panes[0]));
        let rear = back.map(|camera| (camera, MirrorGlass::new(&camera, view.mirror_bend, aspect(inset))));
        let clip = camera.view_proj(aspect(size));
        let framed = |pane: &MirrorPane| FramedMirror {
            glass: MirrorGlass::new(&pane.camera, pane.bend, pane.aspect),
            place: MirrorPlace::InWorld(pane.corners.map(|corner| clip * corner.extend(1.0)), glass_px(pane)),
        };
        let mirrors = match &panes {
            Some(panes) => panes.each_ref().map(|pane| Some(framed(pane))),
            None => [rear.map(|(_, glass)| FramedMirror { glass, place: MirrorPlace::Inset }), None, None],
        };
        // Both door mirrors show the ego's flank at the edge.
        let side = |k: usize| {
            let (pane, framed) = (&panes.as_ref()?[k], mirrors[k]?);
            Some(mirror(&pane.camera, framed.glass, pane_px(pane), EgoVisibility::Outside))
        };
        let rear = rear.map(|(camera, glass)| mirror(&camera, glass, inset, EgoVisibility::Nowhere));
        Self { passes: [Some(main), rear, side(1), side(2)], mirrors, alone }
    }

    /// Returns the pass of the main camera.
    pub fn main(&self) -> &ViewPass {
        self.passes[0].as_ref().expect("planned for every frame")
    }

    /// Returns true for the first and for the last of the passes that are timed together with pass `k`.
    pub fn bounds_time(&self, k: usize) -> [bool; 2] {
        let timed = |k: usize| self.passes[k].as_ref().map(|pass| pass.timed);
        let has = |mut others: Range<usize>| others.any(|other| timed(other) == timed(k));
        [!has(0..k), !has(k + 1..self.passes.len())]
    }
}

fn aspect([width, height]: [u32; 2]) -> f32 {
    width as f32 / height.max(1) as f32
}
