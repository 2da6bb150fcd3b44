//! Stopped or killed runs leave no files.
#![cfg(unix)]

use std::io::{BufRead as _, BufReader};

use crate::in_folder;

#[test]
fn what_was_stopped_writes_nothing() {
    for line in [
        "cubemap cornell --at 0.278,0.3,0.279 --size 512 --spp 4096 -o a.ktx2 --print-lookup wgsl",
        "probes cornell --grid 64x64x64 --rays 65536 -o a.ktx2 -o a.json",
    ] {
        for signal in ["INT", "KILL"] {
            in_folder(|program| {
                let arguments: Vec<&str> = line.split(' ').chain(["--progress", "json", "--threads", "1"]).collect();
                let mut child = program.command(&arguments).spawn().unwrap();
                let lines = BufReader::new(child.stderr.take().unwrap()).lines();
                let mut lines = lines.map_while(Result::ok);
                assert!(lines.any(|line| line.contains("\"event\":\"progress\"")), "it is at work");
                let id = child.id().to_string();
                assert!(
                    std::process::Command::new("kill").args([format!("-{signal}"), id]).status().unwrap().success()
                );
                let status = child.wait().unwrap();
                assert_eq!(status.code(), (signal == "INT").then_some(3), "{line}");
                assert!(program.names().is_empty(), "{line}: {:?}", program.names());
            });
        }
    }
}
