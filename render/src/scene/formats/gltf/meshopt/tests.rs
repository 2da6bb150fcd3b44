//! Streams that meshoptimizer's own encoder (1.x, its JavaScript build) made, and its decoder's output.

use super::stream::CUT;
use super::*;
use crate::scene::fnv;

fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
    digits.chunks(2).map(|pair| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap()).collect()
}

fn compression(mode: Mode, count: usize, byte_stride: usize, filter: Filter) -> Compression {
    Compression { buffer: 0, byte_offset: 0, byte_length: 0, byte_stride, count, mode, filter }
}

const ATTRIBUTES: &str = "\
    a0152aaaaaaaaaaaaaaaaaaa00001f00f06db11f03a3ba37bde4a16cc826bf3186d95c13821fb6c4ba564c58d18ae1ffff0000a8\
    2178d349ca2276002a0644a608682866848284a680c282c0666c66086a000000002a0c1f5fff68df3afb121414101c1ef7ffcff4\
    6fa0c6881c16160f1c16f2f5fc45000000001e101c1530003c001c403f0f0003c00f10c7c800f00000908f152186606660660420\
    0001000015155555555555555555550000000000000000000000000000000000000000000000000000007e07030bfb00ff";

const TRIANGLES: &str = "\
    e1fe1e100e100e100e100efe1e190e180e170e160eff1e160e160e160e160eff1e160e160e160e160eff1e160e160e160e160eff\
    ffffff9c0f0c9f025f090c5f090c5f090cf14522ff1b0101ff4e0202fffc0ec50fc40f007687566778a9866589689801690000";

#[test]
fn attributes_are_differences_of_bytes() {
    let it = compression(Mode::Attributes, 40, 8, Filter::None);
    let decoded = decode(&it, &bytes(ATTRIBUTES)).unwrap();
    assert_eq!((decoded.len(), fnv(&decoded)), (320, 0xb05bed7fc1f56a3));
    // The first byte counts vertices, the last one backwards.
    assert!((0..40).all(|vertex| (decoded[8 * vertex], decoded[8 * vertex + 7]) == (vertex as u8, 255 - vertex as u8)));
}

#[test]
fn triangles_share_edges() {
    let decoded = decode(&compression(Mode::Triangles, 165, 4, Filter::None), &bytes(TRIANGLES)).unwrap();
    assert_eq!(fnv(&decoded), 0xecc2b31a1ef71ec8);
    let short = decode(&compression(Mode::Triangles, 165, 2, Filter::None), &bytes(TRIANGLES)).unwrap();
    assert!(decoded.chunks(4).zip(short.chunks(2)).all(|(long, short)| long[..2] == *short));
}

#[test]
fn sequences_have_two_places_to_go_on_from() {
    let decoded = decode(
        &compression(Mode::Indices, 13, 4, Filter::None),
        &bytes("d10004049103050404050504e58ef401040400000000"),
    )
    .unwrap();
    let indices: Vec<u32> = decoded.as_chunks::<4>().0.iter().map(|it| u32::from_le_bytes(*it)).collect();
    assert_eq!(indices, [0, 1, 2, 100, 101, 3, 4, 102, 103, 5, 1_000_000, 6, 7]);
}

#[test]
fn filters() {
    for (filter, stride, from, to) in [
        (Filter::Octahedral, 4, "00007f0036b77f00ab557f007f007f00", "00007f004c9a0000b749b6007f000000"),
        (
            Filter::Octahedral,
            8,
            "00000000ff0700006d036efbff070000abfa5505ff070000ff070000ff070000",
            "00000000ff7f0000c54c95990000000023b6dd4907b60000ff7f000000000000",
        ),
        (
            Filter::Quaternion,
            8,
            "000000000000ff0759faa705a705fc07000037f90000fd07",
            "000000000000ff7f0f4006c0fa3ffa3f00006566000033b3",
        ),
        (
            Filter::Exponential,
            8,
            "000000f3002000f300d8fff4040000f4093d000600000006",
            "000000000000803f000020c00000803a0024744900000000",
        ),
    ] {
        let mut data = bytes(from);
        filter.apply(&mut data, stride).unwrap();
        assert_eq!(data, bytes(to), "{filter:?} {stride}");
    }
    assert!(Filter::Octahedral.apply(&mut [0; 12], 12).is_err());
}

#[test]
fn damaged_streams_are_told_and_give_no_panic() {
    for (mode, count, hex) in [(Mode::Attributes, 40, ATTRIBUTES), (Mode::Triangles, 165, TRIANGLES)] {
        let (data, stride) = (bytes(hex), if mode == Mode::Attributes { 8 } else { 4 });
        let it = compression(mode, count, stride, Filter::None);
        for end in 0..data.len() {
            // A stream of triangles may end early and still be one, since its table is at the end.
            let told = decode(&it, &data[..end]);
            assert!(told.is_err() || mode == Mode::Triangles, "{mode:?} {end}");
        }
        for place in 0..data.len() {
            let mut changed = data.clone();
            changed[place] ^= 0x55;
            let _ = decode(&it, &changed);
        }
        let huge = compression(mode, 3 << 40, stride, Filter::None);
        assert_eq!(decode(&huge, &data), Err(CUT.to_owned()));
        assert!(decode(&it, &[0x12; 100]).unwrap_err().contains("begins with 0x12"));
    }
    assert!(decode(&compression(Mode::Attributes, 4, 6, Filter::None), &[]).is_err());
    assert!(decode(&compression(Mode::Triangles, 4, 4, Filter::None), &[]).is_err());
    assert!(decode(&compression(Mode::Indices, 4, 3, Filter::None), &[0xd1, 0, 0, 0, 0]).is_err());
}
