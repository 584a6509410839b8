//! Where the processor draws, a picture is drawn in parts, so that it works on two at a time.

use crate::{pixels::difference, place::*};
use codrive::{
    render::{Gpu, OFFSCREEN, Quality, Renderer},
    scene::ViewKind,
};

#[test]
fn a_picture_drawn_in_parts_is_the_one_drawn_at_once() {
    let there = gpu();
    let of = |device_type| Gpu {
        instance: there.instance.clone(),
        adapter: there.adapter.clone(),
        device: there.device.clone(),
        queue: there.queue.clone(),
        info: wgpu::AdapterInfo { device_type, ..there.info.clone() },
    };
    let [mut parts, mut whole] = [wgpu::DeviceType::Cpu, wgpu::DeviceType::DiscreteGpu]
        .map(|kind| Renderer::new(&of(kind), stage(true), OFFSCREEN, Quality::LOW));
    for kind in [ViewKind::Driver, ViewKind::Mirror, ViewKind::Birdseye, ViewKind::Chase] {
        let view = view(&full_ring(), kind, &marked());
        let [a, b] = [&mut parts, &mut whole].map(|renderer| draw_with(renderer, &view, [240, 135]));
        let differ = a.pixels().zip(b.pixels()).filter(|(a, b)| difference(a, b) > 1).count();
        assert_eq!(differ, 0, "{kind:?}");
        assert!(a.pixels().any(|p| p.0 != a.get_pixel(0, 0).0), "something is seen");
    }
}
