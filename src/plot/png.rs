//! SVG to PNG, the same on every machine: no system fonts are used; text is set in the sans-serif font of the program's panels
//! (Ubuntu Light, from egui). In: SVG text of this program. Out: bytes of a PNG file on white.

use image::{
    ExtendedColorType, ImageEncoder,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};
use resvg::{
    tiny_skia::{Color, Pixmap, Transform},
    usvg::{ImageHrefResolver, Options, Tree, fontdb},
};
use std::sync::{Arc, OnceLock};

/// Reason why an SVG cannot become a PNG.
#[derive(Debug, thiserror::Error)]
pub enum PngError {
    /// The text is not SVG, or its size is zero.
    #[error(transparent)]
    Svg(#[from] resvg::usvg::Error),
    /// The picture is empty, or too large for memory.
    #[error("a picture of {width}x{height} pixels")]
    Size {
        /// Width of the PNG in pixels.
        width: u32,
        /// Height of the PNG in pixels.
        height: u32,
    },
    /// The pixels cannot be written as PNG.
    #[error(transparent)]
    Encoding(#[from] image::ImageError),
}

/// Pixels per pixel of CSS (1/96 inch): 300 dots per inch in print.
pub const PNG_SCALE: f32 = 3.125;

/// Renders an SVG as PNG, at 300 dots per inch of the size that it names.
///
/// # Errors
/// The text is not SVG, or the picture is empty or too large for memory.
pub fn png(svg: &str) -> Result<Vec<u8>, PngError> {
    let tree = Tree::from_str(svg, options())?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|side| (side * PNG_SCALE).ceil() as u32);
    let mut pixels = Pixmap::new(width, height).ok_or(PngError::Size { width, height })?;
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(PNG_SCALE, PNG_SCALE), &mut pixels.as_mut());
    // On white nothing is transparent. Filters are for photographs: areas of one colour become larger with them.
    let colours: Vec<u8> =
        pixels.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Level(4), FilterType::NoFilter).write_image(
        &colours,
        width,
        height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(file)
}

/// Returns the options of text: one font family replaces every family that an SVG names.
fn options() -> &'static Options<'static> {
    static OPTIONS: OnceLock<Options<'static>> = OnceLock::new();
    OPTIONS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        let own = egui::FontDefinitions::default();
        for name in own.families.get(&egui::FontFamily::Proportional).into_iter().flatten() {
            if let Some(data) = own.font_data.get(name) {
                fonts.load_font_data((*data.font).as_ref().to_vec());
            }
        }
        let family = fonts.faces().next().and_then(|face| Some(face.families.first()?.0.clone())).unwrap_or_default();
        fonts.set_sans_serif_family(&family);
        // Figures contain no images, and text that became an image tag must not open a file.
        let image_href_resolver =
            ImageHrefResolver { resolve_data: Box::new(|_, _, _| None), resolve_string: Box::new(|_, _| None) };
        Options { font_family: family, fontdb: Arc::new(fonts), image_href_resolver, ..Options::default() }
    })
}

/// Returns every text of a picture with its left, upper, right and lower end in pixels of CSS, and the picture's size.
#[cfg(test)]
pub fn texts(svg: &str) -> (Vec<(String, [f32; 4])>, [f32; 2]) {
    use resvg::usvg::{Group, Node};
    fn walk(group: &Group, found: &mut Vec<(String, [f32; 4])>) {
        for node in group.children() {
            match node {
                Node::Group(group) => walk(group, found),
                Node::Text(text) => {
                    let ends = text.abs_bounding_box();
                    let words: String = text.chunks().iter().map(|chunk| chunk.text()).collect();
                    found.push((words, [ends.left(), ends.top(), ends.right(), ends.bottom()]));
                }
                _ => {}
            }
        }
    }
    let tree = Tree::from_str(svg, options()).expect("a picture");
    let mut found = Vec::new();
    walk(tree.root(), &mut found);
    (found, [tree.size().width(), tree.size().height()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(svg: &str) -> image::RgbaImage {
        image::load_from_memory(&png(svg).unwrap()).unwrap().to_rgba8()
    }

    #[test]
    fn lines_and_text_are_drawn_on_white_at_300_dots_an_inch() {
        let svg = |inside: &str| {
            format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 40\" width=\"100\" height=\"40\" \
                 font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#222\">{inside}</svg>"
            )
        };
        let empty = pixels(&svg(""));
        assert_eq!(empty.dimensions(), (313, 125));
        assert!(empty.pixels().all(|pixel| pixel.0 == [255; 4]));
        let line = pixels(&svg("<path d=\"M0 20h100\" stroke=\"#d55e00\" stroke-width=\"2\"/>"));
        assert_eq!(line.get_pixel(100, 62).0, [0xd5, 0x5e, 0x00, 255]);
        // Text, also with special signs of figures; without a font nothing would be drawn.
        for text in ["speed", "m/s²", "±–·", "−"] {
            let words = pixels(&svg(&format!("<text x=\"5\" y=\"20\">{text}</text>")));
            let dark = words.pixels().filter(|pixel| pixel.0[0] < 128).count();
            assert!(dark > 8, "{text}: {dark} dark pixels");
        }
    }

    #[test]
    fn text_that_is_not_svg_and_empty_pictures_are_errors() {
        assert!(png("no picture").is_err());
        assert!(png("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"0\" height=\"5\"/>").is_err());
    }

    #[test]
    fn a_figure_opens_no_picture_of_the_disk() {
        let folder = tempfile::tempdir().unwrap();
        let red = folder.path().join("red.svg");
        let head = "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"9\" height=\"9\">";
        std::fs::write(&red, format!("{head}<rect width=\"9\" height=\"9\" fill=\"red\"/></svg>")).unwrap();
        let named = |place: &str| format!("{head}<image width=\"9\" height=\"9\" xlink:href=\"{place}\"/></svg>");
        let inside = "data:image/svg+xml;utf8,<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'><rect width='9' height='9' fill='red'/></svg>";
        for place in [red.to_str().unwrap(), inside] {
            let drawn = pixels(&named(&place.replace('<', "&lt;")));
            assert!(drawn.pixels().all(|pixel| pixel.0 == [255; 4]), "{place}");
        }
    }
}
