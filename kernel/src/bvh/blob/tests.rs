//! Valid blobs are traced in place; invalid ones give their errors.

use alloc::vec::Vec;

use glam::{Vec3, vec3};

use super::*;
use crate::bvh::blob_header::checksum;
use crate::bvh::{Bvh, Child};
use crate::{BuildOptions, Hit, Ray, Triangle};

/// What is in `triangle.bvh`.
const TRIANGLE: Triangle = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)];

fn build(triangles: &[Triangle]) -> Bvh {
    Bvh::build(triangles, &BuildOptions::default()).unwrap().0
}

/// Triangles along a spiral, in a tree of several nodes.
fn spiral(count: usize) -> Bvh {
    let triangles: Vec<Triangle> = (0..count)
        .map(|i| {
            let (sin, cos) = libm::sincosf(i as f32);
            TRIANGLE.map(|p| p + vec3(3.0 * cos, 3.0 * sin, i as f32))
        })
        .collect();
    build(&triangles)
}

/// A header's field.
fn put(blob: &mut Blob, offset: usize, value: u32) {
    blob[offset..offset + 4].copy_from_slice(&value.to_ne_bytes());
}

/// Puts the right checksum to a blob that was changed.
fn sign(mut blob: Blob) -> Blob {
    let sum = checksum(&blob);
    put(&mut blob, 60, sum);
    blob
}

fn error(bytes: &[u8]) -> Error {
    let (borrowed, owned) = (BvhView::from_bytes(bytes).err(), Bvh::from_bytes(bytes).err());
    assert_eq!(borrowed, owned);
    borrowed.expect("it is wrong")
}

#[test]
fn trees_come_back_as_they_were() {
    for count in [0, 1, 8, 9, if cfg!(miri) { 20 } else { 300 }] {
        let bvh = spiral(count);
        let blob = bvh.to_bytes();
        let (borrowed, owned) = (BvhView::from_bytes(&blob).unwrap(), Bvh::from_bytes(&blob).unwrap());
        assert_eq!(owned.statistics(), bvh.statistics());
        assert_eq!(owned.to_bytes(), blob);
        assert_eq!(borrowed.nodes(), bvh.view().nodes());
        assert_eq!(borrowed.nodes().as_ptr().addr(), blob.as_ptr().addr() + 64, "in place");
        assert_eq!(borrowed.bounds(), bvh.view().bounds());
        for i in 0..count {
            let ray = Ray::new(vec3(0.0, 0.0, i as f32 + 0.5), vec3(1.0, 0.3 * i as f32, 0.1));
            assert_eq!(borrowed.intersect(&ray), bvh.view().intersect(&ray));
        }
    }
}

/// Which of 0 and -0 is the lesser is not the same on all machines, and these have no other coordinate.
#[test]
fn zeros_have_no_sign_in_the_header() {
    for zero in [0.0, -0.0] {
        let blob = build(&[TRIANGLE.map(|p| p.with_z(zero)), TRIANGLE.map(|p| p.with_z(-zero))]).to_bytes();
        assert_eq!([&blob[40..44], &blob[52..56]], [[0; 4]; 2]);
        assert_eq!(Bvh::from_bytes(&blob).unwrap().to_bytes(), blob);
        assert_eq!(BvhView::from_bytes(&blob).unwrap().bounds().min.z, 0.0);
    }
}

/// A file that was written once: should it differ, the version must be another.
#[test]
#[cfg(target_endian = "little")]
fn the_format_is_what_it_was() {
    let file = crate::include_blob!("triangle.bvh");
    assert_eq!(file, &build(&[TRIANGLE]).to_bytes()[..]);
    let hit = BvhView::from_bytes(file).unwrap().intersect(&Ray::new(Vec3::Z, Vec3::NEG_Z)).unwrap();
    assert_eq!(hit, Hit { t: 1.0, u: 0.25, v: 0.5, prim_id: 0 });
}

#[test]
fn every_flipped_bit_is_noticed() {
    let mut blob = spiral(20).to_bytes();
    for byte in (0..blob.len()).step_by(if cfg!(miri) { 101 } else { 1 }) {
        for bit in 0..8 {
            blob[byte] ^= 1 << bit;
            let error = error(&blob);
            match (byte, error) {
                (0..8, Error::NotABlob)
                | (8..12, Error::BadHeader { field: "byte order" })
                | (12..16, Error::UnsupportedVersion { .. })
                | (24..32, Error::Truncated { .. } | Error::TrailingBytes { .. })
                | (16..24 | 32.., Error::Damaged { .. }) => {}
                _ => panic!("bit {bit} of byte {byte}: {error:?}"),
            }
            blob[byte] ^= 1 << bit;
        }
    }
    assert!(BvhView::from_bytes(&blob).is_ok());
}

#[test]
fn every_truncation_is_noticed_and_so_is_what_follows() {
    let mut blob = spiral(20).to_bytes();
    let len = blob.len() as u64;
    for cut in (0..blob.len()).step_by(if cfg!(miri) { 211 } else { 1 }) {
        let needed = if cut < 64 { 64 } else { len };
        assert_eq!(error(&blob[..cut]), Error::Truncated { needed, found: cut as u64 });
    }
    put(&mut blob, 28, 0);
    let needed = 64 + 256 * u64::from(spiral(20).statistics().nodes as u32);
    assert_eq!(error(&blob), Error::TrailingBytes { needed, found: len });
    // More blocks than there is memory.
    put(&mut blob, 24, u32::MAX);
    put(&mut blob, 28, u32::MAX);
    assert_eq!(error(&blob), Error::Truncated { needed: 64 + 576 * u64::from(u32::MAX), found: len });
}

#[test]
fn bytes_of_other_kinds_and_machines_are_told_apart() {
    assert_eq!(error(b"ply\nformat"), Error::NotABlob);
    assert_eq!(error(&[0; 640]), Error::NotABlob);
    let original = spiral(20).to_bytes();
    let mut blob = original.clone();
    blob[8..].chunks_exact_mut(4).for_each(<[u8]>::reverse);
    assert_eq!(error(&blob), Error::WrongEndianness);
    for found in [0, BLOB_VERSION + 1, u32::MAX] {
        let mut blob = original.clone();
        put(&mut blob, 12, found);
        let error = error(&sign(blob));
        assert_eq!(error, Error::UnsupportedVersion { found, readable: BLOB_VERSION });
        let said = alloc::format!("{error}");
        let age = if found == 0 { "older" } else { "newer" };
        assert!(said.contains(&alloc::format!("version {found}, {age} than {BLOB_VERSION}")), "{said}");
    }
}

#[test]
fn where_it_cannot_be_traced_it_can_be_copied() {
    let bvh = spiral(20);
    let blob = bvh.to_bytes();
    let mut bytes = alloc::vec![0; blob.len() + 2 * BLOB_ALIGNMENT];
    let start = bytes.as_ptr().align_offset(BLOB_ALIGNMENT);
    for offset in [0, 1, 2, 4, 8, 16, 32, 63] {
        let bytes = &mut bytes[start + offset..][..blob.len()];
        bytes.copy_from_slice(&blob);
        let error = (offset != 0).then_some(Error::Misaligned { alignment: 64 });
        assert_eq!(BvhView::from_bytes(bytes).err(), error);
        assert_eq!(Bvh::from_bytes(bytes).unwrap().to_bytes(), blob);
    }
}

/// Checksums are no seal: what traversal relies on is checked for itself.
#[test]
fn forged_blobs_are_refused() {
    let original = spiral(20).to_bytes();
    let forge = |offset: usize, value: u32| {
        let mut blob = original.clone();
        put(&mut blob, offset, value);
        error(&sign(blob))
    };
    let header = |field| Error::BadHeader { field };
    assert_eq!(forge(16, 4), header("number of children a node"));
    assert_eq!(forge(20, 99), header("height of the stack"));
    assert_eq!(forge(32, f32::NAN.to_bits()), header("bounds"));
    assert_eq!(forge(52, 1e6f32.to_bits()), header("bounds"));
    // A zero with a sign where the header of a tree has one without: the box is the same, the blob would be another.
    let flat = build(&[TRIANGLE]).to_bytes();
    let mut signed = flat.clone();
    put(&mut signed, 40, (-0.0f32).to_bits());
    assert_eq!(flat[40..44], [0; 4]);
    assert_eq!(error(&sign(signed)), header("bounds"));
    assert_eq!(forge(56, f32::NAN.to_bits()), header("cost"));
    assert_eq!(forge(56, (-1.0f32).to_bits()), header("cost"));
    // The root's first child: the root itself, then a node behind the last one, then a block likewise.
    let child = 64 + 6 * 8 * 4;
    for value in [Child::Node(0), Child::Node(1 << 20), Child::Leaf { first: 1 << 20, count: 1 }] {
        assert_eq!(forge(child, value.pack()), InvalidTree::BadChild { node: 0, slot: 0 }.into());
    }
    // A plane of its box, and the order of its children.
    assert_eq!(forge(64, f32::NAN.to_bits()), InvalidTree::BadBox { node: 0, slot: 0 }.into());
    assert_eq!(forge(64 + 7 * 8 * 4, 0), InvalidTree::BadOrder { node: 0 }.into());
    // No nodes at all.
    let mut empty = build(&[]).to_bytes();
    put(&mut empty, 24, 0);
    let sum = checksum(&empty[..64]);
    put(&mut empty, 60, sum);
    assert_eq!(error(&empty[..64]), InvalidTree::NoRoot.into());
}
