//! The output: a table, or one JSON object a line.

use halfdome_benches::measure::{Answers, Difference, Timing};
use serde_json::{Value, json};

use crate::judge::Tally;

/// The peers' columns, in order; those of Embree come first.
const COLUMNS: [&str; 5] = ["embree_x1", "embree_x8", "embree_x16", "tinybvh", "obvhs"];
const EMBREE: &str = "embree";

/// Our entry point that traces one ray a call, and Embree's.
const SINGLE: &str = "single";
const EMBREE_SINGLE: &str = "embree_x1";

/// Time and memory that a tree took.
pub(crate) struct Build {
    pub(crate) name: &'static str,
    pub(crate) seconds: f64,
    /// `None` if the builder does not say.
    pub(crate) bytes: Option<usize>,
}

/// A tracer's name and its timing.
pub(crate) type Named = (&'static str, Timing);

/// The timings of all tracers on rays of one kind; of ours there is at least one.
pub(crate) struct Comparison<'a> {
    pub(crate) scene: &'a str,
    pub(crate) kind: &'static str,
    pub(crate) ours: &'a [Named],
    pub(crate) peers: &'a [Named],
    /// Who is right where Embree finds something else.
    pub(crate) judged: Tally,
}

impl<'a> Comparison<'a> {
    /// The fastest of our entry points.
    fn best(&self) -> &'a Named {
        fastest(self.ours.iter()).expect("the kernel has entry points")
    }

    fn peer(&self, name: &str) -> Option<&'a Timing> {
        self.peers.iter().find(|(peer, _)| *peer == name).map(|(_, timing)| timing)
    }

    /// Our timing of one ray a call.
    fn single(&self) -> Option<&'a Timing> {
        self.ours.iter().find(|(entry, _)| *entry == SINGLE).map(|(_, timing)| timing)
    }

    /// How many times as fast as Embree we are at one ray a call.
    fn single_ratio(&self) -> Option<f64> {
        Some(self.single()?.ratio(self.peer(EMBREE_SINGLE)?))
    }

    /// How many times as fast as the fastest of Embree's methods ours is.
    fn ratio(&self) -> Option<f64> {
        let (_, embree) = fastest(self.peers.iter().filter(|(name, _)| name.starts_with(EMBREE)))?;
        Some(self.best().1.ratio(embree))
    }

    /// Embree's answers, which are the same for all its methods.
    pub(crate) fn embree(&self) -> Option<&'a Answers> {
        self.peers.iter().find(|(name, _)| name.starts_with(EMBREE)).map(|(_, timing)| &timing.answers)
    }

    /// Whether Embree finds what the kernel finds; `None` without Embree.
    fn hits_equal(&self) -> Option<bool> {
        self.embree().map(|embree| self.best().1.answers.agrees_with(embree))
    }

    /// The line of machines.
    pub(crate) fn json(&self) -> Value {
        let (entry, ours) = self.best();
        let mut line = json!({
            "scene": self.scene,
            "kind": self.kind,
            "entry": entry,
            "ours": rounded(ours.rate()),
            "ratio": self.ratio().map(rounded),
            "single": self.single().map(|timing| rounded(timing.rate())),
            "single_ratio": self.single_ratio().map(rounded),
            "hits_equal": self.hits_equal(),
            "rays": ours.answers.len(),
            "hits": ours.answers.hits(),
        });
        for column in COLUMNS {
            line[column] = json!(self.peer(column).map(|timing| rounded(timing.rate())));
        }
        line["entries"] = self.ours.iter().map(|(name, timing)| (*name, json!(rounded(timing.rate())))).collect();
        let differing = |(name, timing): &Named| {
            let Difference { missed, extra, apart } = ours.answers.difference(&timing.answers);
            (*name, json!({ "missed": missed, "extra": extra, "apart": apart }))
        };
        let Tally { ours, embree, neither, edge } = self.judged;
        line["judged"] = json!({ "ours": ours, "embree": embree, "neither": neither, "edge": edge });
        line["differing"] = self.peers.iter().map(differing).collect();
        line
    }

    /// The line of people, under [`heading`].
    pub(crate) fn text(&self) -> String {
        let (entry, ours) = self.best();
        let cell = |rate: Option<f64>| rate.map_or_else(|| format!("{:>11}", "-"), |rate| format!("{rate:11.2}"));
        let peers: String = COLUMNS.map(|column| cell(self.peer(column).map(Timing::rate))).concat();
        let equal = match self.embree() {
            Some(embree) if ours.answers.agrees_with(embree) => "equal".to_owned(),
            Some(embree) => format!("{} differ", ours.answers.difference(embree).rays()),
            None => "-".to_owned(),
        };
        let Tally { ours: right, embree, neither, edge } = self.judged;
        let judged = match right + embree + neither + edge {
            0 => String::new(),
            _ => format!("  (right: ours {right}, Embree {embree}, neither {neither}; edges {edge})"),
        };
        let single = [cell(self.single().map(Timing::rate)), cell(self.single_ratio())].concat();
        let (ours, ratio) = (ours.rate(), cell(self.ratio()));
        format!("{:8}{entry:>9}{ours:9.2}{peers}{ratio}{single}{equal:>14}{judged}", self.kind)
    }
}

/// What stands above the lines of [`Comparison::text`].
pub(crate) fn heading() -> String {
    let columns = COLUMNS.map(|column| format!("{column:>11}")).concat();
    let [ratio, single, to_x1] = ["ratio", "our single", "to x1"].map(|column| format!("{column:>11}"));
    format!("{:8}{:>9}{:>9}{columns}{ratio}{single}{to_x1}{:>14}", "Mrays/s", "entry", "ours", "hits")
}

/// The builds of a scene as a line for machines.
pub(crate) fn builds_json(scene: &str, triangles: usize, builds: &[Build]) -> Value {
    let seconds: Value = builds.iter().map(|build| (build.name, json!(rounded(build.seconds)))).collect();
    let bytes: Value = builds.iter().map(|build| (build.name, json!(build.bytes))).collect();
    json!({ "scene": scene, "triangles": triangles, "build_seconds": seconds, "bytes": bytes })
}

/// The builds of a scene for people.
pub(crate) fn builds_text(scene: &str, triangles: usize, builds: &[Build]) -> String {
    let build = |build: &Build| {
        let memory = build.bytes.map(|bytes| format!(", {:.1} MiB", bytes as f64 / (1 << 20) as f64));
        format!("\n  {:9}{:8.2} s{}", build.name, build.seconds, memory.unwrap_or_default())
    };
    format!("{scene}: {triangles} triangles{}", builds.iter().map(build).collect::<String>())
}

fn fastest<'a>(timings: impl Iterator<Item = &'a Named>) -> Option<&'a Named> {
    timings.max_by(|(_, a), (_, b)| a.rate().total_cmp(&b.rate()))
}

/// To a thousandth: more is noise.
fn rounded(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(rates: &[f64], occluded: &[bool]) -> Timing {
        Timing { rates: rates.to_vec(), answers: Answers::Any(occluded.to_vec()) }
    }

    #[test]
    fn the_best_entry_is_held_against_the_best_of_embree() {
        let hits = [true, false];
        let ours = [("single", timing(&[5.0], &hits)), ("batch", timing(&[6.0], &hits))];
        let peers = [
            ("embree_x1", timing(&[2.0], &hits)),
            ("embree_x8", timing(&[4.0], &hits)),
            ("tinybvh", timing(&[12.0], &hits)),
        ];
        let line =
            Comparison { scene: "cornell", kind: "shadow", ours: &ours, peers: &peers, judged: Tally::default() }
                .json();
        let none = json!({ "missed": 0, "extra": 0, "apart": 0 });
        let expected = json!({
            "scene": "cornell", "kind": "shadow", "entry": "batch", "ours": 6.0, "ratio": 1.5, "hits_equal": true,
            "single": 5.0, "single_ratio": 2.5,
            "rays": 2, "hits": 1, "embree_x1": 2.0, "embree_x8": 4.0, "embree_x16": null, "tinybvh": 12.0,
            "obvhs": null, "entries": { "single": 5.0, "batch": 6.0 },
            "differing": { "embree_x1": none, "embree_x8": none, "tinybvh": none },
            "judged": { "ours": 0, "embree": 0, "neither": 0, "edge": 0 },
        });
        assert_eq!(line, expected);
    }

    #[test]
    fn a_peer_that_finds_something_else_is_told() {
        let ours = [("single", timing(&[5.0], &[true, false]))];
        let other = |name| [(name, timing(&[2.0], &[true, true]))];
        let [embree, obvhs] = [other("embree_x1"), other("obvhs")];
        let judged = Tally { embree: 1, ..Tally::default() };
        let comparison = Comparison { scene: "cornell", kind: "shadow", ours: &ours, peers: &embree, judged };
        let line = comparison.json();
        assert_eq!((&line["hits_equal"], &line["differing"]["embree_x1"]["extra"]), (&json!(false), &json!(1)));
        let text = comparison.text();
        let (columns, judged) = text.split_at(heading().len());
        assert!(columns.ends_with("  1 differ"));
        assert_eq!(judged, "  (right: ours 0, Embree 1, neither 0; edges 0)");
        assert_eq!(line["judged"]["embree"], json!(1));
        // The ratio and the verdict are of Embree alone.
        let line = Comparison { peers: &obvhs, ..comparison }.json();
        assert_eq!((&line["hits_equal"], &line["differing"]["obvhs"]["extra"]), (&Value::Null, &json!(1)));
        assert_eq!(line["ratio"], Value::Null);
    }

    #[test]
    fn without_peers_there_is_nothing_to_compare() {
        let ours = [("single", timing(&[5.0], &[true]))];
        let line =
            Comparison { scene: "cornell", kind: "shadow", ours: &ours, peers: &[], judged: Tally::default() }.json();
        assert_eq!((&line["ratio"], &line["hits_equal"]), (&Value::Null, &Value::Null));
        assert_eq!((&line["embree_x1"], &line["ours"]), (&Value::Null, &json!(5.0)));
    }

    #[test]
    fn builds_say_time_and_memory() {
        let builds = [
            Build { name: "halfdome", seconds: 0.25, bytes: Some(3 << 20) },
            Build { name: "tinybvh", seconds: 1.5, bytes: None },
        ];
        let line = builds_json("blob", 9, &builds);
        assert_eq!(line["build_seconds"], json!({ "halfdome": 0.25, "tinybvh": 1.5 }));
        assert_eq!(line["bytes"], json!({ "halfdome": 3 << 20, "tinybvh": null }));
        let text = builds_text("blob", 9, &builds);
        assert_eq!(text, "blob: 9 triangles\n  halfdome     0.25 s, 3.0 MiB\n  tinybvh      1.50 s");
    }
}
