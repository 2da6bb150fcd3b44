//! The header equals cbindgen's output for the source.
//!
//! After a change, `HALFDOME_HEADER=write cargo test -p halfdome-c --test header` rewrites it.

use std::path::Path;

#[test]
fn header_is_current() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut made = Vec::new();
    cbindgen::generate(package).unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = package.join("include/halfdome.h");
    if std::env::var("HALFDOME_HEADER").is_ok_and(|what| what == "write") {
        std::fs::write(path, made).unwrap();
    } else {
        let kept = std::fs::read_to_string(&path).unwrap();
        assert!(kept == made, "{} is not what src makes: see how to write it in {}", path.display(), file!());
    }
}
