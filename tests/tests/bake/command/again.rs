//! Bakes of levels that were baked before, or in part.

use super::*;

#[test]
fn an_unchanged_level_is_up_to_date_and_a_changed_one_says_what_changed() {
    in_folder(|program| {
        let talk = |options: &str| {
            let line = format!("bake level.gltf -o out.gltf {SMALL} {options}").replace("none", "json");
            let outcome = program.run_line(&line);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            outcome.stderr
        };
        assert!(!talk("").contains("up to date"));
        let before = program.files();
        assert!(talk("").contains("out.gltf is up to date"));
        assert!(talk("--threads 2").contains("up to date"), "threads do not matter");
        assert!(program.files() == before);
        // A changed map is made again.
        fs::write(program.folder.join("out-0.exr"), "not a map").unwrap();
        assert!(talk("").contains("out-0.exr was changed since it was written"));
        assert!(program.files() == before);
        // A report is one more file, and no reason to bake again once it is there.
        let told = talk("--report out.html");
        assert!(
            told.contains("out.html is missing, so the whole level is baked again") && !told.contains("options"),
            "{told}"
        );
        assert!(talk("--report out.html").contains("up to date") && talk("").contains("up to date"));
        assert!(talk("--seed 5").contains("the options changed"));
        let mut moved = level();
        moved["nodes"][1]["translation"] = json!([0.6, 0, 0.5]);
        program.put("level.gltf", moved.to_string());
        let told = talk("--seed 5");
        assert!(
            told.contains("mesh \\\"crate one\\\" changed") && told.contains("the whole level is baked again"),
            "{told}"
        );
    });
}

#[test]
fn what_was_killed_leaves_nothing_half_written_and_goes_on() {
    in_folder(|program| {
        let long = "bake level.gltf -o out.gltf --size 512 --spp 256 --record-rays 1024 --progress json --threads 1";
        let arguments: Vec<&str> = long.split(' ').collect();
        for signal in ["INT", "KILL"] {
            let mut child = program.command(&arguments).spawn().unwrap();
            // Until it is at work.
            let lines = BufReader::new(child.stderr.take().unwrap()).lines();
            let at_work = lines
                .map_while(Result::ok)
                .find(|line| line.contains("\"event\":\"progress\"") && line.contains("\"texels\":"));
            assert!(at_work.is_some());
            let kill = std::process::Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status();
            assert!(kill.unwrap().success());
            let status = child.wait().unwrap();
            let files = program.names();
            if signal == "INT" {
                assert_eq!(status.code(), Some(3));
                assert!(files.contains(&"out.gltf.state".to_owned()), "{files:?}");
            } else {
                assert_eq!(status.code(), None);
            }
            // The file of a lock stays when its run is killed, without the lock.
            let may_be = |file: &str| file == "out.gltf.state" || signal == "KILL" && file == "out.json.lock";
            assert!(!files.iter().any(|file| file.starts_with("out") && !may_be(file)), "{files:?}");
        }
        let small = "bake level.gltf -o out.gltf --size 64 --spp 8 --record-rays 64 --progress none";
        let other = program.run_line(&format!("{small} --resume"));
        assert_eq!(other.code, Some(1), "the state is of other options");
        assert!(other.stderr.contains("out.gltf.state: belongs to another level"), "{}", other.stderr);
        succeed(&program.run_line(small));
        assert!(!program.names().iter().any(|file| file.ends_with(".state") || file.ends_with(".lock")));
    });
}
