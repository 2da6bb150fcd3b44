//! `halfdome validate`: exact answers as JSON.

use serde_json::Value;

use crate::Desk;

/// The lines of JSON on standard output.
fn lines(stdout: &str) -> Vec<Value> {
    stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn all_experiments_pass() {
    let desk = Desk::new();
    let outcome = desk.run("validate --quick --json --plots figures");
    let lines = lines(&outcome.stdout);
    let failed: Vec<_> = lines.iter().filter(|line| line["pass"] != true).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    let list = desk.run("validate --list").stdout;
    for line in &lines {
        let name = line["name"].as_str().unwrap();
        assert!(list.contains(&format!("  {name} ")), "{name}");
        let [measured, expected, tolerance] =
            ["measured", "expected", "tolerance"].map(|key| line[key].as_f64().unwrap_or_else(|| panic!("{line}")));
        assert!((measured - expected).abs() <= tolerance, "{line}");
    }
    let experiments = list.lines().filter(|line| line.starts_with("  ")).count();
    assert!(experiments > 20 && lines.len() == experiments, "{} of {experiments}", lines.len());
    // What the formulas give, so that the program is not its own judge.
    let expected = |name: &str| lines.iter().find(|line| line["name"] == name).unwrap()["expected"].as_f64();
    assert_eq!(expected("furnace-sphere"), Some(2.0));
    assert_eq!(expected("convergence-ao-random"), Some(-0.5));

    for name in ["furnace-bounces", "furnace-survival", "furnace-variance", "convergence-ao", "lights-sphere"] {
        let text = |extension| {
            std::fs::read_to_string(desk.folder.path().join(format!("figures/{name}.{extension}"))).unwrap()
        };
        let (svg, csv) = (text("svg"), text("csv"));
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && svg.len() < 100_000, "{name}");
        let mut words = svg.split(|c: char| !c.is_alphanumeric());
        assert!(words.all(|word| word != "NaN" && word != "inf"), "{name}");
        for row in csv.lines().skip(1) {
            let numbers = row.rsplit_once('"').unwrap().1.trim_start_matches(',').split(',');
            assert_eq!(numbers.filter(|number| number.parse::<f64>().is_ok_and(f64::is_finite)).count(), 3, "{row}");
        }
    }
}

#[test]
fn experiments_depend_on_the_seed_and_not_on_threads_or_company() {
    let desk = Desk::new();
    let run = |options: &str| desk.run(&format!("validate --quick --json {options}")).stdout;
    let alone = run("furnace-box --threads 1");
    assert_eq!(lines(&alone).len(), 1);
    assert!(run("furnace-tetrahedron furnace-box --threads 3").ends_with(&alone));
    let other = run("furnace-box --seed 1");
    assert_ne!(lines(&alone)[0]["measured"], lines(&other)[0]["measured"]);
}

#[test]
fn tables_are_for_people() {
    let outcome = Desk::new().run("validate --quick furnace-box");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    let lines: Vec<_> = outcome.stdout.lines().collect();
    assert!(lines[0].contains("measured") && lines[1].starts_with("pass  furnace-box "), "{lines:?}");
    assert_eq!(lines[2..], ["1 experiment passed"]);
}

#[test]
fn unknown_names_and_folders_are_refused() {
    let desk = Desk::new();
    desk.refuses("validate furnace glass", 1, &["no experiment \"glass\"", "furnace, lights, convergence, materials"]);
    desk.refuses("validate --plots t.obj furnace-box", 1, &["t.obj", "name another folder"]);
    assert_eq!(desk.run("validate --list --quick").code, Some(1));
}
