//! Blobs that are damaged, cut short, of other kinds or forged.

use super::*;

fn error(bytes: &[u8]) -> Error {
    let (borrowed, owned) = (in_place(bytes, |_| ()).err(), Scene::from_bytes(bytes).err());
    assert_eq!((&borrowed, Scene::over_bytes(bytes).err()), (&owned, owned));
    borrowed.expect("it is wrong")
}

/// A word.
fn put(blob: &mut [u8], offset: usize, value: u32) {
    blob[offset..offset + 4].copy_from_slice(&value.to_ne_bytes());
}

/// Puts the right checksum to a blob that was changed.
fn sign(mut blob: Blob) -> Blob {
    let sum = checksum(&blob);
    put(&mut blob, 60, sum);
    blob
}

/// Where each section begins, in their order.
fn sections(blob: &Blob) -> [usize; 10] {
    let header: Header = bytemuck::pod_read_unaligned(&blob[..HEADER]);
    let sizes = [
        header.nodes as usize * 256,
        header.blocks as usize * 320,
        header.scene_nodes as usize * 256,
        header.block_parts as usize * 32,
        header.transforms as usize * 64,
        header.meshes as usize * 24,
        header.scenes as usize * 32,
        header.items as usize * 20,
        header.parts as usize * 8,
    ];
    let mut at = [HEADER; 10];
    for (i, size) in sizes.into_iter().enumerate() {
        at[i + 1] = at[i] + size;
    }
    at
}

#[test]
fn every_flipped_bit_is_noticed() {
    let mut blob = town().to_bytes().unwrap();
    // In the trees, whose bytes are but summed up, some bits will do; all in the header and in the records.
    let records = sections(&blob)[4];
    let step = |byte: usize| {
        if cfg!(miri) {
            997
        } else if (HEADER..records).contains(&byte) {
            13
        } else {
            1
        }
    };
    let mut byte = 0;
    while byte < blob.len() {
        for bit in 0..8 {
            blob[byte] ^= 1 << bit;
            match (byte, error(&blob)) {
                (0..8, Error::NotAScene)
                | (8..12, Error::BadHeader { field: "byte order" })
                | (12..16, Error::UnsupportedVersion { .. })
                | (16..52 | 56..60, Error::Truncated { .. } | Error::TrailingBytes { .. } | Error::Damaged { .. })
                | (52.., Error::Damaged { .. }) => {}
                (_, error) => panic!("bit {bit} of byte {byte}: {error:?}"),
            }
            blob[byte] ^= 1 << bit;
        }
        byte += step(byte);
    }
    assert!(in_place(&blob, |_| ()).is_ok());
}

#[test]
fn every_truncation_is_noticed_and_so_is_what_follows() {
    let blob = town().to_bytes().unwrap();
    for cut in (0..blob.len()).step_by(if cfg!(miri) { 997 } else { 7 }) {
        let needed = if cut < 64 { 64 } else { blob.len() as u64 };
        assert_eq!(error(&blob[..cut]), Error::Truncated { needed, found: cut as u64 });
    }
    let mut longer = Blob::zeroed(blob.len() + 64);
    longer[..blob.len()].copy_from_slice(&blob);
    let (needed, found) = (blob.len() as u64, blob.len() as u64 + 64);
    assert_eq!(error(&longer), Error::TrailingBytes { needed, found });
    // More than there is memory.
    let mut huge = blob.clone();
    (16..52).step_by(4).for_each(|place| put(&mut huge, place, u32::MAX));
    assert!(matches!(error(&huge), Error::Truncated { .. }));
}

#[test]
fn bytes_of_other_kinds_and_machines_are_told_apart() {
    let tree = bvh(3, 1).to_bytes();
    assert_eq!(error(&tree), Error::NotAScene);
    assert_eq!(error(b"ply\nformat"), Error::NotAScene);
    let blob = inner().to_bytes().unwrap();
    assert_eq!(Bvh::from_bytes(&blob).err(), Some(Error::NotABlob));
    let mut turned = blob.clone();
    turned[8..].chunks_exact_mut(4).for_each(<[u8]>::reverse);
    assert_eq!(error(&turned), Error::WrongEndianness);
    let mut newer = blob.clone();
    put(&mut newer, 12, 7);
    assert_eq!(error(&sign(newer)), Error::UnsupportedVersion { found: 7, readable: SCENE_BLOB_VERSION });
}

/// Checksums are no seal: what tracing relies on is checked for itself.
#[test]
fn forged_blobs_are_refused() {
    let original = town().to_bytes().unwrap();
    let [nodes, _, scene_nodes, rounds, transforms, meshes, scenes, items, parts, numbers] = sections(&original);
    let forge = |changes: &[(usize, u32)]| {
        let mut blob = original.clone();
        changes.iter().for_each(|&(offset, value)| put(&mut blob, offset, value));
        error(&sign(blob))
    };
    let header = |field| Error::BadHeader { field };
    let record = |record, index| Error::from(InvalidScene::BadRecord { record, index });
    assert_eq!(forge(&[(52, 4 | 1 << 16)]), header("number of children a node"));
    assert_eq!(forge(&[(52, 8 | 3 << 16)]), header("quality"));
    assert_eq!(forge(&[(numbers, 99)]), InvalidTree::BadItem { place: 0 }.into());

    // The inner scene is the first: its items are 0 to 2, those of the town 3 to 10, of which 3, 6 and 8 are that
    // scene.
    let item = |index: usize, field: usize| items + 20 * index + 4 * field;
    let scene = |index: usize, field: usize| scenes + 32 * index + 4 * field;
    // In itself, in one after it, of no mesh, of no kind, nothing that is something.
    assert_eq!(forge(&[(item(0, 0), SCENE), (item(0, 1), 0)]), record("item", 0));
    assert_eq!(forge(&[(item(3, 1), 1)]), record("item", 3));
    assert_eq!(forge(&[(item(3, 1), 7)]), record("item", 3));
    assert_eq!(forge(&[(item(5, 1), 5)]), record("item", 5));
    assert_eq!(forge(&[(item(5, 0), 3)]), record("item", 5));
    assert_eq!(forge(&[(item(4, 1), 1)]), record("item", 4));
    // Transforms of another item; fewer than there are.
    assert_eq!(forge(&[(item(2, 3), 0)]), record("item", 2));
    assert_eq!(forge(&[(item(10, 4), 0)]), header("table of counts"));
    for field in [0, 2, 4, 6] {
        assert_eq!(forge(&[(scene(1, field), 1)]), record("scene", 1));
    }
    assert_eq!(forge(&[(scene(1, 1), u32::MAX)]), record("scene", 1));
    assert_eq!(forge(&[(scene(1, 3), 0)]), header("table of counts"));
    assert_eq!(forge(&[(meshes + 24, 9)]), record("mesh", 1));
    assert_eq!(forge(&[(meshes + 4, u32::MAX)]), record("mesh", 0));
    // More keys than a tree has, and a number of keys that does not divide it.
    assert_eq!(forge(&[(meshes + 16, 7)]), InvalidTree::BadKeys { keys: 7 }.into());
    // Of no kind; spheres that are no whole number of curves, or that move; one whose radius is less than zero.
    assert_eq!(forge(&[(meshes + 20, 9)]), record("mesh", 0));
    assert_eq!(forge(&[(meshes + 24 * 3 + 20, 4)]), record("mesh", 3));
    assert_eq!(forge(&[(meshes + 24 * 3 + 16, 1)]), record("mesh", 3));
    let radius = rounds + 3 * 32;
    assert_eq!(forge(&[(radius, (-1f32).to_bits())]), InvalidTree::BadPrimitive { block: 0, lane: 0 }.into());

    // Trees: a plane that is no number, a child that is the root itself; of a mesh, and of the town.
    for (nodes, of_boxes) in [(nodes, false), (scene_nodes, true)] {
        let bad_box = forge(&[(nodes, f32::NAN.to_bits())]);
        assert_eq!(bad_box, InvalidTree::BadBox { node: 0, slot: 0 }.into(), "{of_boxes}");
        let cyclic = forge(&[(nodes + 6 * 8 * 4, Child::Node(0).pack())]);
        assert_eq!(cyclic, InvalidTree::BadChild { node: 0, slot: 0 }.into(), "{of_boxes}");
    }
    // A box that does not enclose its item any more, as that was moved away.
    let far = forge(&[(transforms + 48, 1e6f32.to_bits())]);
    assert!(matches!(far, Error::InvalidTree(InvalidTree::BadBox { .. })), "{far:?}");
    assert_eq!(forge(&[(transforms, f32::NAN.to_bits())]), InvalidScene::NotFinite { key: 0 }.into());
    assert_eq!(forge(&[(transforms, 1e-5f32.to_bits())]), InvalidScene::Singular { key: 0 }.into());
    // What is between the numbers.
    assert_eq!(forge(&[(transforms + 12, 1)]), header("padding"));
    assert_eq!(forge(&[(original.len() - 4, 1)]), header("padding"));
    // Parts of items that there are not, and of a primitive that there is not.
    assert!(matches!(forge(&[(parts, 77)]), Error::InvalidTree(InvalidTree::BadItem { .. })));
    assert!(matches!(forge(&[(parts + 4, 1)]), Error::InvalidTree(InvalidTree::BadItem { .. })));
}

/// Boxes of a scene in another that are larger than they need be hide what the outer tree encloses no more.
#[test]
fn what_is_refused_in_place_is_not_loaded() {
    let original = town().to_bytes().unwrap();
    let [_, _, scene_nodes, ..] = sections(&original);
    let (mut refused, mut accepted) = (0, 0);
    // The planes of the inner scene's root.
    for word in 0..48 {
        for value in [1e3f32, -1e3] {
            let mut blob = original.clone();
            put(&mut blob, scene_nodes + 4 * word, value.to_bits());
            let blob = sign(blob);
            let (borrowed, owned) = (in_place(&blob, |_| ()).err(), Scene::from_bytes(&blob).err());
            assert_eq!(borrowed, owned, "word {word}, {value}");
            *(if borrowed.is_some() { &mut refused } else { &mut accepted }) += 1;
        }
    }
    assert!(refused > 0, "{refused} refused, {accepted} accepted");
}
