//! Reports of renders, and help on options.

use std::fs;

use serde_json::Value;

use crate::Desk;

impl Desk {
    /// A file's text.
    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.folder.path().join(name)).unwrap()
    }

    fn statistics(&self, line: &str) -> Value {
        let outcome = self.program().run_reproducibly(&format!("{line} --stats-json stats.json"));
        assert!(matches!(outcome.code, Some(0 | 4)), "{line}: {}", outcome.stderr);
        serde_json::from_str(&self.text("stats.json")).unwrap()
    }
}

#[test]
fn statistics_are_the_render_s() {
    let desk = Desk::new();
    let line = "render cornell --size 40x30 --spp 64 --seed 5 --progress none -o a.exr";
    let [one, two] = [1, 2].map(|threads| desk.statistics(&format!("{line} --threads {threads}")));
    assert_eq!((&one["threads"], &two["threads"]), (&1.into(), &2.into()));
    for equal in ["picture_hash", "scene", "rays", "camera_samples", "error", "options"] {
        assert_eq!(one[equal], two[equal], "{equal}");
    }
    assert_eq!(
        (&one["camera_samples"], &one["least_samples"], &one["end"]),
        (&76_800.into(), &64.into(), &"done".into())
    );
    assert_eq!(one["rays_by_kind"], two["rays_by_kind"]);
    assert_eq!(one["scene"]["triangles"], 32);
    assert_eq!((&one["options"]["sampler"], &one["options"]["seed"]), (&"sobol".into(), &5.into()));
    assert_eq!(one["files"], serde_json::json!(["a.exr"]));
    let history = one["history"].as_array().unwrap();
    let errors: Vec<f64> = history.iter().filter_map(|moment| moment["error"].as_f64()).collect();
    assert!(errors.len() >= 2 && errors.last() == one["error"].as_f64().as_ref(), "{errors:?}");
    assert!(errors.last() < errors.first(), "{errors:?}");
    // A limit ends it, and another seed gives another picture.
    let other = desk.statistics("render cornell --size 40x30 --spp 32 --noise 0.1% --progress none -o a.exr");
    assert_eq!((&other["end"], &other["options"]["target"]), (&"limit".into(), &0.001.into()));
    assert_ne!(one["picture_hash"], other["picture_hash"]);
}

/// Of the rays of simple integrators it is known how many of each kind there are.
#[test]
fn rays_are_counted_by_kind() {
    let desk = Desk::new();
    let counts = |options: &str| {
        let line = format!("render cornell --size 16x12 --spp 4 --progress none -o a.exr {options}");
        let statistics = desk.statistics(&line);
        let kinds = ["preparation", "camera", "bounce", "shadow"];
        let counts = kinds.map(|kind| statistics["rays_by_kind"][kind].as_u64().unwrap());
        assert_eq!(counts.iter().sum::<u64>(), statistics["rays"].as_u64().unwrap(), "{options}");
        counts
    };
    let samples = 16 * 12 * 4;
    assert_eq!(counts("--integrator albedo"), [0, samples, 0, 0]);
    // Inside of the box every camera ray meets a wall.
    let [preparation, camera, bounce, shadow] =
        counts("--integrator ao --rays 8 --eye 0.278,0.273,0.05 --target 0.278,0.273,0.5");
    assert_eq!((preparation, camera, bounce, shadow), (0, samples, 0, 8 * samples));
    let [preparation, camera, bounce, shadow] = counts("--integrator path --max-depth 2");
    assert_eq!((preparation, camera), (0, samples));
    assert!(bounce > 0 && bounce <= samples && shadow > 0 && shadow <= samples, "{bounce} {shadow}");
    let [preparation, camera, _, shadow] = counts("--integrator cached");
    assert!(preparation > 0 && camera == samples && shadow > 0, "{preparation} {shadow}");
}

#[test]
fn a_report_is_one_file_with_all_in_it() {
    let desk = Desk::new();
    let line = "render cornell --size 64x64 --spp 1024 --noise 8% --progress none -o a.png --report a.html";
    let outcome = desk.run(line);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let html = desk.text("a.html");
    // The picture, and where the error is.
    assert!(html.matches("data:image/png;base64,").count() >= 2, "{html}");
    for text in ["<h1>cornell</h1>", "Target</th><td>8.00%", "Error against time", "<svg", "--noise 8%", "a.png"] {
        assert!(html.contains(text), "{text}");
    }
    assert!(!html.contains("http://") || html.matches("http://").count() == html.matches("http://www.w3.org").count());
}

#[test]
fn reports_that_cannot_be_written_stop_a_render_before_it_begins() {
    let desk = Desk::new();
    desk.refuses("render cornell --size 8x8 --spp 1 -o a.png --report no/a.html", 1, &["no/a.html"]);
    desk.refuses("render cornell --size 8x8 --spp 1 -o a.png --stats-json a.png", 1, &["a.png is given twice"]);
    desk.refuses("render cornell --size 8x8 --spp 1 -o a.png --stats-json b --report ./b", 1, &["b is given twice"]);
}

#[test]
fn manuals_and_completions_know_all_options() {
    let desk = Desk::new();
    fs::create_dir(desk.folder.path().join("man")).unwrap();
    assert_eq!(desk.run("man man").code, Some(0));
    let mut pages: Vec<String> = fs::read_dir(desk.folder.path().join("man"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    pages.sort();
    for page in ["halfdome.1", "halfdome-render.1", "halfdome-bake.1", "halfdome-cache-build.1"] {
        assert!(pages.iter().any(|it| it == page), "{page}: {pages:?}");
    }
    let page = desk.text("man/halfdome-render.1");
    assert!(page.contains(".TH") && page.contains("spp") && page.contains("noise"), "{page}");
    assert!(desk.run("man").stdout.contains(".TH halfdome"));
    assert_eq!(desk.run("man nowhere").code, Some(1));
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = desk.run(&format!("completions {shell}"));
        assert!(script.code == Some(0) && script.stdout.contains("stats-json"), "{shell}");
    }
    assert_eq!(desk.run("completions dos").code, Some(1));
}
