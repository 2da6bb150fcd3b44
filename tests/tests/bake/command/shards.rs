//! Bakes in shards.

use super::*;

/// Any shards, one of them killed and gone on with, give the files of a single run.
#[test]
fn shards_make_the_bytes_of_a_single_run() {
    for options in ["", "--mode ao", "--mode direct --directional sh1", "--brute --denoise"] {
        let mut whole = None;
        in_folder(|program| {
            succeed(&bake(program, options));
            whole = Some(program.files());
        });
        for (count, threads) in [(2, 1), (3, 2)] {
            in_folder(|program| {
                let mut parts = Vec::new();
                // In any order.
                for number in (1..=count).rev() {
                    let part = format!("part{number}.state");
                    let options = format!("{options} --shard {number}/{count} --threads {threads}");
                    let line = format!("bake level.gltf {SMALL} {options} -o {part}");
                    succeed(&program.run_reproducibly(&line));
                    parts.push(part);
                }
                let merge = program.run_line(&format!("merge {} -o out.gltf.state", parts.join(" ")));
                assert_eq!((merge.code, merge.stderr.as_str()), (Some(0), ""));
                succeed(&bake(program, &format!("{options} --resume")));
                for part in &parts {
                    fs::remove_file(program.folder.join(part)).unwrap();
                }
                assert!(Some(program.files()) == whole, "{options}, {count} shards");
            });
        }
    }
}

#[test]
fn shards_that_do_not_belong_together_are_named() {
    in_folder(|program| {
        let shard = |name: &str, options: &str| {
            program.run_reproducibly(&format!("bake level.gltf {SMALL} --mode direct -o {name} {options}"))
        };
        succeed(&shard("1.state", "--shard 1/2"));
        succeed(&shard("2.state", "--shard 2/2"));
        succeed(&shard("third.state", "--shard 2/3"));
        succeed(&shard("other.state", "--shard 2/2 --seed 5"));
        let whole = fs::read(program.folder.join("2.state")).unwrap();
        fs::write(program.folder.join("cut.state"), &whole[..whole.len() / 2]).unwrap();
        for (parts, problem) in [
            ("1.state", "the shard 2/2 is missing"),
            ("1.state 1.state 2.state", "1.state and 1.state both are shard 1/2"),
            ("1.state third.state", "1.state is one of 2 shards, and third.state one of 3"),
            ("1.state other.state", "other.state belongs to another level or to other options than 1.state"),
            ("1.state cut.state", "cut.state is not the state of a bake, or is damaged"),
            ("1.state level.gltf", "level.gltf is not the state of a bake, or is damaged"),
            ("1.state gone.state", "gone.state: cannot be read"),
        ] {
            let outcome = program.run_line(&format!("merge {parts} -o out.gltf.state"));
            assert_eq!(outcome.code, Some(1), "{parts}");
            assert!(outcome.stderr.contains(problem), "{parts}: {}", outcome.stderr);
        }
        for (line, problem) in [
            ("merge 1.state 2.state -o out.exr", "out.exr: these parts make no such file"),
            ("bake level.gltf -o out.gltf --shard 1/2", "out.gltf: a shard is no model"),
            (
                "bake level.gltf -o 1.state --shard 2/2 --mode direct --resume --size 64 --spp 8 --record-rays 64",
                "1.state is of the shard 1/2",
            ),
            ("bake level.gltf -o x.state --shard 1/2 --mode indirect --cache-bounces 1", "which no machines can share"),
            ("bake level.gltf -o x.state --shard 3/2", "expected K/N"),
        ] {
            let outcome = program.run_line(line);
            assert_eq!(outcome.code, Some(1), "{line}: {}", outcome.stderr);
            assert!(outcome.stderr.contains(problem), "{line}: {}", outcome.stderr);
        }
        assert!(!program.names().iter().any(|name| name.starts_with("out")), "nothing is written");
    });
}
