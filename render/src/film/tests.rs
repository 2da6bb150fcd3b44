//! Films as bytes, and samples that are not numbers.

use glam::Vec3;

use super::{Film, FilmHeader, FilterSample, FirstHit, MatteLayer, Merger, NO_NAME};

fn film(aov: bool, halves: bool) -> Film {
    let layer = |name: &str| MatteLayer::new(name, 3, ["a", "b"].map(str::to_owned).into_iter());
    let cryptomatte = if aov { vec![layer("CryptoObject"), layer("CryptoMaterial")] } else { Vec::new() };
    let level = Some(0.1 + 0.2);
    Film::new(FilmHeader { width: 40, height: 35, aov, halves, level, cryptomatte, ..FilmHeader::default() })
}

/// Adds a sample to every pixel of the tiles that are meant.
fn sample(film: &mut Film, number: u32, has: impl Fn(usize) -> bool) {
    for (i, tile) in film.tiles.iter_mut().enumerate().filter(|(i, _)| has(*i)) {
        if tile.samples.is_empty() {
            tile.samples = number..number;
        }
        for (pixel, (x, y)) in tile.pixels().enumerate() {
            let filter = FilterSample { offset: [0.0; 2], weight: if number.is_multiple_of(3) { -0.25 } else { 1.0 } };
            let value = Vec3::new(x as f32 + 0.1, 1.0 / (1 + y) as f32, 1e-7 * (number + 1) as f32);
            tile.add(pixel, number, &filter, value);
            if !tile.first_hits.is_empty() && x.is_multiple_of(3) {
                tile.add_hit(
                    pixel,
                    FirstHit {
                        sample: number,
                        depth: number as f32 + 0.5,
                        ids: [x, y, number, x + 1],
                        motion: [x as f32, -0.5],
                    },
                );
            }
            for layer in 0..tile.mattes.len() {
                // Pixels have up to five names, and some samples none.
                let name = number % (1 + x % 5) * 1000 + layer as u32;
                tile.add_name(layer, pixel, &filter, if y.is_multiple_of(7) { NO_NAME } else { name });
            }
            if i == 0 && pixel == 0 {
                tile.add_uncovered(pixel, number, &filter);
            }
        }
        tile.samples.end += 1;
    }
}

#[test]
fn films_are_read_as_they_were_written() {
    for (aov, halves) in [(false, false), (true, false), (true, true)] {
        let mut film = film(aov, halves);
        (0..9).for_each(|number| sample(&mut film, number, |tile| tile != 2));
        film.seconds = 2.5;
        let bytes = film.encode();
        assert_eq!(Film::decode(&bytes).unwrap(), film);
        for end in [0, 7, 8, 11, 100, bytes.len() - 1] {
            assert!(Film::decode(&bytes[..end]).is_err(), "{end}");
        }
        for place in [20, bytes.len() / 2, bytes.len() - 3] {
            let mut damaged = bytes.clone();
            damaged[place] ^= 4;
            assert!(Film::decode(&damaged).unwrap_err().to_string().contains("damaged"), "{place}");
        }
    }
}

#[test]
fn parts_add_up_in_any_order() {
    let mut whole = film(true, true);
    (0..20).for_each(|number| sample(&mut whole, number, |_| true));
    let mut parts = [film(true, true), film(true, true), film(true, true)];
    (0..20).for_each(|number| sample(&mut parts[0], number, |tile| tile == 1));
    (0..7).for_each(|number| sample(&mut parts[1], number, |tile| tile != 1));
    (7..20).for_each(|number| sample(&mut parts[2], number, |tile| tile != 1));
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let mut merger = Merger::default();
        for (i, part) in order.into_iter().enumerate() {
            merger.add(i.to_string(), parts[part].clone()).unwrap();
        }
        let (sum, missing) = merger.finish().unwrap();
        assert_eq!((missing.tiles, missing.first), (0, None));
        assert!(sum == whole && sum.picture() == whole.picture(), "{order:?}");
    }
    let mut merger = Merger::default();
    merger.add("late".to_owned(), parts[2].clone()).unwrap();
    merger.add("other".to_owned(), parts[0].clone()).unwrap();
    assert!(
        merger.add("again".to_owned(), parts[0].clone()).unwrap_err().to_string().starts_with("other and again both")
    );
    let (_, missing) = merger.finish().unwrap();
    assert_eq!((missing.tiles, missing.of, missing.first), (3, 4, Some((0..32, 0..32))), "samples 0 to 7");
}

#[test]
fn samples_that_are_not_numbers_are_counted_and_located() {
    let mut film = film(false, false);
    let filter = FilterSample { offset: [0.0; 2], weight: 1.0 };
    for (tile, pixel, value) in [(3, 5, f32::NAN), (1, 9, f32::INFINITY), (0, 40, f32::NEG_INFINITY), (0, 41, 2.0)] {
        film.tiles[tile].add(pixel, 0, &filter, Vec3::new(1.0, value, 0.0));
    }
    film.tiles.iter_mut().for_each(|tile| tile.samples = 0..1);
    let bad = film.bad_samples();
    // Tile 1 has 8 columns from column 32 on: pixel 9 is in the second row. So is pixel 40 of tile 0.
    assert_eq!((bad.count, bad.first), (3, Some((1, 8))));
    assert_eq!(Film::decode(&film.encode()).unwrap().bad_samples(), bad);
    let picture = film.picture();
    assert!(picture.channels.iter().all(|channel| channel.values.iter().all(|value| value.is_finite())));
}
