//! What a recording says of its circumstances. In: the world, who drives, the graphics device. Out: a [`Manifest`].

use crate::{
    policy,
    record::{Manifest, manifest::Hashed},
    render::Gpu,
    sim::World,
};

/// The facts of a drive that begins now.
pub fn manifest(world: &World, driver: String, gpu: Option<&Gpu>) -> Manifest {
    let scenario = world.scenario();
    let policy = policy::meant(&scenario.policy, &scenario.map);
    Manifest {
        program: concat!("codrive ", env!("CARGO_PKG_VERSION")).into(),
        build: if cfg!(debug_assertions) { "dev" } else { "release" }.into(),
        traffic: world.traffic_engine(),
        seed: scenario.seed,
        map: Hashed::of(&scenario.map, Some(&world.map().net_file)),
        policy: Hashed::of(&policy, policy::file_of(&policy).as_deref()),
        driver,
        participant: None,
        began: now(),
        machine: machine(),
        graphics: gpu.map(Gpu::description),
        display_m: [scenario.screen_width_m, scenario.eye_distance_m],
        screen: None,
        state: None,
        ended: None,
        hash: None,
        checksums: None,
        sha256: None,
    }
}

/// The time, UTC.
pub fn now() -> String {
    jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

/// Operating system and processor.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    format!("{} {}, {}, {cores} cores", std::env::consts::OS, std::env::consts::ARCH, model.unwrap_or_default())
}
