//! The same picture on this machine, by every instruction set that it has: what the firmware is compared with.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use halfdome_cortex_m::{CORNELL, draw};
use halfdome_kernel::{BvhView, Isa, Level};

fn main() -> ExitCode {
    let tree = BvhView::from_bytes(CORNELL).expect("the blob is valid");
    let pictures = Level::ALL.into_iter().filter_map(Isa::new).map(|isa| {
        let mut picture = String::new();
        draw(&tree.with_isa(isa), &mut picture, || 0).expect("strings take everything");
        (isa.level(), picture)
    });
    let pictures: Vec<_> = pictures.collect();
    let (_, first) = &pictures[0];
    print!("{first}");
    for (level, picture) in &pictures {
        if picture != first {
            eprintln!("{level} draws another picture:\n{picture}");
            return ExitCode::from(5);
        }
    }
    ExitCode::SUCCESS
}
