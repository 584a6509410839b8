//! Tests of the graphics interfaces: pictures by OpenGL beside those by Vulkan, both of Mesa's software rendering. In: the environment's
//! variables. Out: picture files, messages.

use super::cli::codrive;
use image::RgbImage;

const SIZE: &str = "160x90";

/// Largest mean difference per channel, of 255, and largest share of pixels that differ clearly. Mesa rasterises and filters alike through
/// every interface; only rounding differs, which moves single samples at the edges of leaves and letters. Trees without gaps between their
/// leaves, a picture upside down or without shadows differ clearly in a tenth of the pixels and more.
const MEAN: f64 = 0.1;
const CLEARLY: f64 = 0.002;

/// Draws a picture through a graphics interface.
fn drawn(interface: &str, view: &str, quality: &str) -> RgbImage {
    drawn_with(&[("WGPU_BACKEND", interface)], view, quality)
}

/// Draws a picture with these variables of the environment.
fn drawn_with(variables: &[(&str, &str)], view: &str, quality: &str) -> RgbImage {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.png");
    let mut command = codrive(&["render", "--traffic", "native", "--at", "2", "--size", SIZE, "--out"]);
    command.arg(&file).args(["--view", view, "--quality", quality]).envs(variables.iter().copied());
    let output = command.output().unwrap();
    assert!(output.status.success(), "{variables:?} {view}: {}", String::from_utf8_lossy(&output.stderr));
    image::open(&file).unwrap().into_rgb8()
}

/// Returns the mean difference per channel, of 255, and the share of pixels with a channel that differs by more than 32.
fn difference(a: &RgbImage, b: &RgbImage) -> [f64; 2] {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = || a.pixels().zip(b.pixels()).map(|(a, b)| [0, 1, 2].map(|k| f64::from(a[k].abs_diff(b[k]))));
    let count = f64::from(a.width() * a.height());
    let sum: f64 = pairs().flatten().sum();
    [sum / (3.0 * count), pairs().filter(|channels| channels.iter().any(|by| *by > 32.0)).count() as f64 / count]
}

#[test]
fn every_view_on_opengl_looks_as_on_vulkan() {
    for view in ["driver", "mirror", "birdseye", "chase"] {
        for quality in ["low", "high"] {
            let [mean, clearly] = difference(&drawn("gl", view, quality), &drawn("vulkan", view, quality));
            println!("{view} {quality}: mean {mean:.4} of 255, {:.3} % of pixels differ clearly", 100.0 * clearly);
            assert!(mean < MEAN && clearly < CLEARLY, "{view} {quality}: {mean} of 255, {clearly} of the pixels");
        }
    }
}

#[test]
fn opengl_4_2_without_compute_shaders_draws_as_vulkan() {
    let old = [("WGPU_BACKEND", "gl"), ("MESA_GL_VERSION_OVERRIDE", "4.2"), ("MESA_GLSL_VERSION_OVERRIDE", "420")];
    let [mean, clearly] = difference(&drawn_with(&old, "driver", "high"), &drawn("vulkan", "driver", "high"));
    println!("OpenGL 4.2: mean {mean:.4} of 255, {:.3} % of pixels differ clearly", 100.0 * clearly);
    assert!(mean < MEAN && clearly < CLEARLY, "{mean} of 255, {clearly} of the pixels");
}

#[test]
fn opengl_that_is_too_old_is_refused_with_another_interface() {
    for (version, shown) in [("4.1", "not 4.1 "), ("3.3", "not 3.3 "), ("2.1", "not OpenGL ES ")] {
        let mut command =
            codrive(&["render", "--traffic", "native", "--at", "0", "--size", "64x36", "--out", "/nonexistent/a.png"]);
        let output = command.env("WGPU_BACKEND", "gl").env("MESA_GL_VERSION_OVERRIDE", version).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{text}");
        let [message, remedy] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
        assert!(message.contains("OpenGL 4.2 or later is needed") && message.contains(shown), "{text}");
        assert!(remedy.contains("choose another with WGPU_BACKEND: vulkan (") && !remedy.contains("gl ("), "{text}");
    }
}

#[test]
fn a_bench_of_the_card_measures_nothing_where_the_processor_draws() {
    let bench = |more: &[&str]| {
        let output = codrive(&["bench", "--gpu"]).args(more).env("WGPU_ADAPTER_NAME", "llvmpipe").output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = bench(&[]);
    let [adapter, result] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
    assert!(adapter.starts_with("llvmpipe (") && adapter.contains("Cpu, Vulkan, llvmpipe Mesa "), "{text}");
    assert_eq!(result, "graphics card: not measured: the processor draws, not a graphics card");
    let report: serde_json::Value = serde_json::from_str(&bench(&["--json"])).unwrap();
    assert!(report["card"]["not_measured"].is_string() && report["card"]["rows"] == serde_json::json!([]), "{report}");
}
