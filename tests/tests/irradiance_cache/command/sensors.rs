//! `halfdome irradiance`: light at sensors, at once and in shards.

use super::*;

#[test]
fn sensors_are_answered_in_order() {
    in_folder(|program| {
        let points = "# a sensor that looks at the lamp, one that sees nothing of the room, one at the wall\n\
                      0.278 0.3 0.28 0 1 0\n\n0.278 0.3 -10 0 0 -5\n0.278 0.2 0.5592 0 0 -1\n";
        program.put("points.txt", points);
        let found =
            program.run_line("irradiance cornell --points points.txt --spp 256 --record-rays 8192 --progress none");
        succeed(&found);
        let found = numbers(&found.stdout);
        let brute = program.run_line("irradiance cornell --points points.txt --brute --spp 4096 --progress none");
        succeed(&brute);
        let brute = numbers(&brute.stdout);
        assert_eq!((found.len(), brute.len()), (3, 3));
        assert_eq!(found[1], [0.0; 3]);
        assert_eq!(brute[1], [0.0; 3]);
        for (found, brute) in [(&found[0], &brute[0]), (&found[2], &brute[2])] {
            for (found, brute) in found.iter().zip(brute) {
                assert!((found / brute - 1.0).abs() < 0.05, "{found}, by paths {brute}");
            }
        }

        // The same from a pipe, and into a file.
        let arguments = ["irradiance", "cornell", "--points", "-", "--brute", "--spp", "4096", "-o", "e.txt"];
        let mut command = program.command(&arguments);
        let mut child = command.arg("--progress=none").stdin(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(points.as_bytes()).unwrap();
        assert!(child.wait().unwrap().success());
        assert_eq!(numbers(&fs::read_to_string(program.folder.join("e.txt")).unwrap()), brute);
    });
}

/// What a scene file says of the cache holds for its sensors as for its pictures, and the command line wins over it.
#[test]
fn sensors_use_the_options_of_the_scene_file() {
    in_folder(|program| {
        program.put(
            "room.obj",
            "mtllib room.mtl\nv 0 0 0\nv 0 0 4\nv 4 0 4\nv 4 0 0\nv 1 3 1\nv 2 3 1\nv 2 3 2\nv 1 3 2\n\
            usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n",
        );
        program.put("room.mtl", "newmtl floor\nKd 0.7 0.7 0.7\nnewmtl lamp\nKd 0 0 0\nKe 5 5 5\n");
        let scene = "[scene]\nfile = \"room.obj\"\n[camera]\neye = [2, 1, 9]\ntarget = [2, 0, 2]\n[render]\n\
            integrator = \"cached\"\ncache_error = 0.5\nrecord_rays = 64\nmetric = \"bounded\"\nseed = 5\n";
        program.put("room.toml", scene);
        program.put("points.txt", "1 0 1 0 1 0\n3 0 3 0 1 0\n1.5 1 1.5 0 -1 0\n");
        succeed(&program.run_line("cache build room.toml -o room.cache --size 48x40 --progress none"));
        let sensors = |options: &str| {
            let line = format!("irradiance room.toml --points points.txt --indirect --progress none {options}");
            program.run_line(&line)
        };
        succeed(&sensors("--cache room.cache"));
        let by_file = sensors("");
        succeed(&by_file);
        let given = sensors("--cache-error 0.5 --record-rays 64 --metric bounded --seed 5");
        assert_eq!(given.stdout, by_file.stdout);
        assert_ne!(sensors("--record-rays 256").stdout, by_file.stdout);
        let other = sensors("--cache room.cache --record-rays 256");
        assert!(other.stderr.contains("built with --record-rays 64, not 256"), "{}", other.stderr);
    });
}

/// Sensors all over the box, and one outside, where no record is.
fn sensors() -> String {
    let sensor = |i: u32| {
        let at = |step: f32| 0.02 + (i as f32 * step).fract() * 0.5;
        format!("{} {} {} {} 1 0.3\n", at(0.618), at(0.414), at(0.732), (i as f32).sin())
    };
    (0..23).map(sensor).collect::<String>() + "5 5 5 0 0 1\n"
}

#[test]
fn shards_of_sensors_make_the_bytes_of_a_single_run() {
    in_folder(|program| {
        program.put("sensors.txt", sensors());
        build(program, "cornell.cache", "");
        for options in ["", "--indirect", "--brute", "--cache cornell.cache"] {
            let small = if options == "--brute" { "--progress none" } else { SMALL };
            let line = format!("irradiance cornell --points sensors.txt {small} --spp 8 {options}");
            succeed(&program.run_line(&format!("{line} -o whole.txt")));
            for (count, threads) in [(1, 2), (2, 1), (5, 2), (40, 1)] {
                let part = |number: u32| format!("{number}.part");
                for number in 1..=count {
                    succeed(
                        &program.run_line(&format!(
                            "{line} --shard {number}/{count} --threads {threads} -o {}",
                            part(number)
                        )),
                    );
                }
                let parts: Vec<String> = (1..=count).rev().map(part).collect();
                succeed(&program.run_line(&format!("merge {} -o merged.txt", parts.join(" "))));
                let [whole, merged] =
                    ["whole.txt", "merged.txt"].map(|name| fs::read(program.folder.join(name)).unwrap());
                assert!(whole == merged, "{options}, {count} shards");
            }
        }
    });
}

#[test]
fn shards_of_sensors_that_do_not_belong_together_are_named() {
    in_folder(|program| {
        program.put("sensors.txt", sensors());
        program.put("others.txt", sensors().lines().skip(1).collect::<Vec<_>>().join("\n"));
        let shard = |name: &str, options: &str| {
            succeed(
                &program.run_line(&format!("irradiance cornell --brute --spp 1 --progress none -o {name} {options}")),
            );
        };
        shard("1.part", "--points sensors.txt --shard 1/2");
        shard("2.part", "--points sensors.txt --shard 2/2");
        shard("seed.part", "--points sensors.txt --shard 2/2 --seed 4");
        shard("points.part", "--points others.txt --shard 2/2");
        shard("third.part", "--points sensors.txt --shard 2/3");
        let text = fs::read_to_string(program.folder.join("2.part")).unwrap();
        program.put("cut.part", &text[..text.len() - 3]);
        let foreign = "is of another scene than 1.part, or of other sensors or options";
        for (parts, problem) in [
            ("1.part", "the shard 2/2 is missing"),
            ("1.part 2.part 2.part", "2.part and 2.part both are shard 2/2"),
            ("1.part third.part", "1.part is one of 2 shards, and third.part one of 3"),
            ("1.part seed.part", &format!("seed.part {foreign}")),
            ("1.part points.part", &format!("points.part {foreign}")),
            ("1.part cut.part", "cut.part is cut off or damaged"),
        ] {
            let outcome = program.run_line(&format!("merge {parts} -o merged.txt"));
            assert_eq!(outcome.code, Some(1), "{parts}");
            assert!(outcome.stderr.contains(problem), "{parts}: {}", outcome.stderr);
        }
        for (line, problem) in [
            ("merge 1.part 2.part -o merged.exr", "these parts make no such file"),
            ("merge 1.part 2.part -o a.txt -o b.txt", "there are several outputs"),
            ("irradiance cornell --points sensors.txt --shard 1/2", "--output"),
        ] {
            let outcome = program.run_line(line);
            assert_eq!(outcome.code, Some(1), "{line}: {}", outcome.stderr);
            assert!(outcome.stderr.contains(problem), "{line}: {}", outcome.stderr);
        }
        assert!(!program.folder.join("merged.txt").exists());
    });
}
