//! OpenEXR files, ours and others', through [`read_exr`]; ours also through the `exr` library.

use chiaro_basis::{Error, random};
use chiaro_image::Plane;
use chiaro_image::codec::{ExrChannel, ExrImage, Limits, read_exr, write_exr};
use exr::prelude::*;
use std::collections::BTreeMap;

fn floats(seed: u64, width: usize, height: usize) -> Plane<f32> {
    Plane::from_fn(width, height, |x, y| random::unit(seed, (y * width + x) as u64) * 20.0 - 4.0)
}

fn ours(width: usize, height: usize) -> ExrImage {
    let ids = Plane::from_fn(width, height, |x, y| (x / 3 * 70_000 + y) as u32);
    let recipe = ("chiaro".to_owned(), "version = \"0.1\"\nsize = 7".to_owned());
    let note = ("comments".to_owned(), "ein Bild für alle".to_owned());
    ExrImage {
        size: (width, height),
        layers: vec![
            ("object.ID".into(), ExrChannel::U32(ids)),
            ("depth.Z".into(), ExrChannel::F32(floats(1, width, height))),
            ("A".into(), ExrChannel::F32(floats(2, width, height))),
        ],
        attributes: BTreeMap::from([recipe, note]),
    }
}

fn sorted(mut image: ExrImage) -> ExrImage {
    image.layers.sort_by(|a, b| a.0.cmp(&b.0));
    image
}

fn read(bytes: &[u8]) -> ExrImage {
    read_exr(bytes, "a.exr", &Limits::default()).expect("a whole file")
}

#[test]
fn what_is_written_comes_back_sorted() {
    for size in [(1, 1), (5, 16), (33, 17), (64, 100)] {
        let image = ours(size.0, size.1);
        assert_eq!(read(&write_exr(&image).unwrap()), sorted(image));
    }
}

#[test]
fn special_floats_come_back_bit_for_bit() {
    let odd = [f32::NAN, f32::INFINITY, -0.0, f32::MIN_POSITIVE / 8.0, f32::MAX, -1e-30];
    let plane = Plane::from_pixels(6, 1, odd.to_vec());
    let layers = vec![("Y".into(), ExrChannel::F32(plane))];
    let image = ExrImage { size: (6, 1), layers, ..ExrImage::default() };
    let back = read(&write_exr(&image).unwrap());
    let bits = |p: &[f32]| p.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(back.f32("Y").unwrap().pixels()), bits(&odd));
}

#[test]
fn other_programs_can_read_what_is_written() {
    let image = sorted(ours(33, 40));
    let bytes = write_exr(&image).unwrap();
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level();
    let theirs = reader
        .all_channels()
        .all_layers()
        .all_attributes()
        .pedantic()
        .from_buffered(std::io::Cursor::new(&bytes))
        .unwrap();
    let layer = &theirs.layer_data[0];
    assert_eq!(layer.size, Vec2(33, 40));
    assert_eq!(layer.encoding.compression, Compression::ZIP16);
    let names: Vec<String> =
        layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["A", "depth.Z", "object.ID"]);
    match &layer.channel_data.list[1].sample_data {
        FlatSamples::F32(values) => assert_eq!(values, image.f32("depth.Z").unwrap().pixels()),
        other => panic!("floats expected, not {other:?}"),
    }
    match &layer.channel_data.list[2].sample_data {
        FlatSamples::U32(values) => assert_eq!(values, image.u32("object.ID").unwrap().pixels()),
        other => panic!("whole numbers expected, not {other:?}"),
    }
    let recipe = &layer.attributes.other[&Text::from("chiaro")];
    assert_eq!(*recipe, AttributeValue::Text(Text::from("version = \"0.1\"\nsize = 7")));
}

#[test]
fn equal_images_give_equal_bytes_on_any_number_of_threads() {
    let image = ours(50, 70);
    let mut shuffled = image.clone();
    shuffled.layers.reverse();
    let on = |threads: usize, image: &ExrImage| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| write_exr(image).unwrap())
    };
    assert_eq!(on(1, &image), on(3, &shuffled));
}

#[test]
fn images_that_the_format_cannot_hold_are_refused() {
    let refused = |image: &ExrImage| matches!(write_exr(image), Err(Error::Setting { .. }));
    let good = ours(4, 4);
    let with_layer = |name: &str, width: usize| {
        let mut image = good.clone();
        image.layers.push((name.into(), ExrChannel::F32(floats(0, width, 4))));
        image
    };
    assert!(!refused(&good) && !refused(&with_layer("Z", 4)));
    assert!(refused(&ExrImage::default()));
    assert!(refused(&ExrImage { size: (4, 4), ..ExrImage::default() }));
    assert!(refused(&with_layer("A", 4)));
    assert!(refused(&with_layer("Z", 5)));
    assert!(refused(&with_layer("", 4)));
    assert!(refused(&with_layer(&"n".repeat(256), 4)));
    let mut image = good.clone();
    image.attributes.insert("dataWindow".into(), "no".into());
    assert!(refused(&image));
}

#[test]
fn long_names_survive() {
    let mut image = ours(4, 4);
    image.layers[0].0 = "ViewLayer.a_rather_long_name_for_a_channel.Z".into();
    assert_eq!(read(&write_exr(&image).unwrap()), sorted(image));
}

/// A layer as another program writes it: half, single and whole numbers.
fn foreign_layer(
    name: &str,
    compression: Compression,
    blocks: Blocks,
) -> Layer<AnyChannels<FlatSamples>> {
    let size = Vec2(45, 37);
    let pixels = || (0..size.area()).map(|i| (i as f32 / 90.0).sin());
    let halves = FlatSamples::F16(pixels().map(f16::from_f32).collect());
    let singles = FlatSamples::F32(pixels().collect());
    let numbers = FlatSamples::U32((0..size.area() as u32).collect());
    let channels = AnyChannels::sort(
        [("R", halves), ("depth.Z", singles), ("id", numbers)]
            .map(|(name, samples)| AnyChannel::new(name, samples))
            .into_iter()
            .collect(),
    );
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    Layer::new(size, LayerAttributes::named(name), encoding, channels)
}

fn foreign(layers: Vec<Layer<AnyChannels<FlatSamples>>>) -> Vec<u8> {
    let attributes = ImageAttributes::with_size(Vec2(45, 37));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layers(attributes, layers)
        .write()
        .to_buffered(&mut bytes)
        .expect("the library writes it");
    bytes.into_inner()
}

const EVERY_COMPRESSION: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

#[test]
fn every_compression_is_read_in_lines_and_tiles() {
    for compression in EVERY_COMPRESSION {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 11))] {
            let image = read(&foreign(vec![foreign_layer("one", compression, blocks)]));
            assert_eq!(image.size, (45, 37));
            for i in [0, 700, 45 * 37 - 1] {
                let wanted = (i as f32 / 90.0).sin();
                let (half, single) = (image.f32("R").unwrap(), image.f32("depth.Z").unwrap());
                assert!((half.pixels()[i] - wanted).abs() < 0.02, "{compression:?} {i}");
                assert!((single.pixels()[i] - wanted).abs() < 0.02, "{compression:?} {i}");
                assert_eq!(image.u32("id").unwrap().pixels()[i], i as u32, "{compression:?}");
            }
        }
    }
}

#[test]
fn channels_of_several_parts_get_full_names() {
    let lines = |name| foreign_layer(name, Compression::ZIP16, Blocks::ScanLines);
    let tiles = foreign_layer("ViewLayer.Two", Compression::PIZ, Blocks::Tiles(Vec2(8, 8)));
    let image = read(&foreign(vec![lines("ViewLayer"), tiles]));
    let names: Vec<&str> = image.layers.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "ViewLayer.R",
            "ViewLayer.depth.Z",
            "ViewLayer.id",
            "ViewLayer.Two.R",
            "ViewLayer.Two.depth.Z",
            "ViewLayer.Two.id"
        ]
    );
    assert_eq!(image.u32("ViewLayer.Two.id").unwrap()[(44, 36)], 45 * 37 - 1);
}

#[test]
fn a_cropped_layer_lands_at_its_place_on_the_display_window() {
    let mut layer = foreign_layer("crop", Compression::ZIP16, Blocks::ScanLines);
    layer.attributes.layer_position = Vec2(-5, 10);
    let image = read(&foreign(vec![layer]));
    let ids = image.u32("id").unwrap();
    assert_eq!(image.size, (45, 37));
    assert_eq!(ids[(0, 9)], 0);
    assert_eq!(ids[(0, 10)], 5);
    assert_eq!(ids[(39, 36)], 26 * 45 + 44);
    assert_eq!(ids[(40, 36)], 0);
}

#[test]
fn of_mip_maps_the_largest_is_read() {
    let size = Vec2(20, 13);
    let rounding_mode = exr::math::RoundingMode::Down;
    let level_data = exr::meta::mip_map_levels(rounding_mode, size)
        .map(|(level, size)| FlatSamples::F32(vec![level as f32 + 1.0; size.area()]))
        .collect();
    let samples = Levels::Mip { level_data, rounding_mode };
    let channels = AnyChannels::sort([AnyChannel::new("Y", samples)].into_iter().collect());
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::Tiles(Vec2(8, 8)),
        line_order: LineOrder::Unspecified,
    };
    let layer = Layer::new(size, LayerAttributes::named("mip"), encoding, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = Image::from_layers(ImageAttributes::with_size(size), vec![layer]);
    image.write().to_buffered(&mut bytes).unwrap();
    let plane = read(&bytes.into_inner());
    assert!(plane.f32("Y").unwrap().pixels().iter().all(|v| *v == 1.0));
}

#[test]
fn limits_hold_before_anything_is_unpacked() {
    let bytes = write_exr(&ours(40, 30)).unwrap();
    let tight = |pixels, bytes| Limits { pixels, bytes };
    let with = |limits: Limits| read_exr(&bytes, "a.exr", &limits);
    assert!(with(tight(1200, 1200 * 12)).is_ok());
    assert!(matches!(with(tight(1199, 1 << 30)), Err(Error::Limit { .. })));
    assert!(matches!(with(tight(1200, 1200 * 12 - 1)), Err(Error::Limit { .. })));
}

#[test]
fn a_forged_window_is_refused_by_the_length_of_the_file() {
    let mut bytes = write_exr(&ours(4, 4)).unwrap();
    let huge: Vec<u8> = [0, 0, 9999, 9999i32].iter().flat_map(|v| v.to_le_bytes()).collect();
    for name in [&b"dataWindow\0"[..], b"displayWindow\0"] {
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 10;
        bytes[at..at + 16].copy_from_slice(&huge);
    }
    let message = read_exr(&bytes, "a.exr", &Limits::default()).unwrap_err().to_string();
    assert!(message.starts_with("a.exr: ") && message.contains("cannot hold"), "{message}");
}

#[test]
fn what_is_not_read_is_said() {
    let message =
        |bytes: &[u8]| read_exr(bytes, "a.exr", &Limits::default()).unwrap_err().to_string();
    assert!(message(b"").contains("not an OpenEXR file"));
    let mut deep = write_exr(&ours(4, 4)).unwrap();
    deep[5] |= 0x08;
    assert!(message(&deep).contains("deep data"));
    let mut newer = write_exr(&ours(4, 4)).unwrap();
    newer[4] = 3;
    assert!(message(&newer).contains("version 3"));
}
