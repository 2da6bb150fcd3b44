//! `halfdome validate`: experiments whose results are known, with tables, lines of JSON and figures.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::error::{CliError, EXIT_DONE, EXIT_FAILED, EXIT_INTERRUPTED};
use crate::cli::interrupt;
use crate::cli::print::print;
use crate::output::plot::{Figure, csv, svg};
use crate::output::{OutputError, OutputFile};
use crate::scene::count;
use crate::validate::{self, Effort, Experiment, Row, Runner};
use crate::watch::Watch;

#[derive(Args, Clone, Debug)]
pub(crate) struct ValidateArguments {
    /// Families or experiments to run [default: all]
    #[arg(value_name = "NAME")]
    names: Vec<String>,

    /// Write each figure as SVG and its points as CSV into this folder; it is made if it does not exist
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,

    /// Print one line of JSON per experiment instead of a table
    #[arg(long)]
    json: bool,

    /// List the experiments without running them
    #[arg(long, conflicts_with_all = ["plots", "json", "quick"])]
    list: bool,

    /// Run with fewer samples, in a quarter of the time
    #[arg(long)]
    quick: bool,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value = "0", allow_hyphen_values = true)]
    seed: u64,

    /// Number of threads; results are the same for any number [default: one per core]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Runs the experiments; the exit code says whether all passed.
pub(crate) fn run(arguments: &ValidateArguments) -> Result<u8, CliError> {
    let experiments = validate::select(&arguments.names)?;
    if arguments.list {
        return print(&validate::list()).map(|()| EXIT_DONE);
    }
    if let Some(folder) = &arguments.plots {
        prepare(folder)?;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads.map_or(0, usize::from)).build();
    let pool = pool.map_err(|error| CliError::System(format!("cannot start threads: {error}")))?;
    interrupt::catch()?;

    let rows = Row::for_table(&experiments);
    let progress = Progress::start(experiments.len());
    if !arguments.json {
        print(&rows.head())?;
    }
    let effort = if arguments.quick { Effort::Quick } else { Effort::Full };
    let mut figures: BTreeMap<&str, Figure> = BTreeMap::new();
    let mut failed = Vec::new();
    let mut done = 0;
    for experiment in &experiments {
        progress.begin(experiment);
        let outcome = pool.install(|| experiment.run(&Runner::new(effort, arguments.seed, &progress)));
        let Ok(outcome) = outcome else { break };
        let line =
            if arguments.json { validate::json(experiment, &outcome) } else { rows.outcome(experiment, &outcome) };
        progress.print(&line)?;
        if !outcome.pass() {
            failed.push(experiment.name);
        }
        done += 1;
        if let Some(figure) = outcome.figure {
            match figures.get_mut(figure.name) {
                Some(known) => known.extend(figure),
                None => drop(figures.insert(figure.name, figure)),
            }
        }
    }
    progress.end();
    if let Some(folder) = &arguments.plots {
        figures.values().try_for_each(|figure| write(folder, figure)).map_err(CliError::system)?;
    }
    if !arguments.json {
        print(&summary(experiments.len(), done, &failed))?;
    }
    Ok(match (done == experiments.len(), failed.is_empty()) {
        (false, _) => EXIT_INTERRUPTED,
        (true, true) => EXIT_DONE,
        (true, false) => EXIT_FAILED,
    })
}

/// The table's last line.
fn summary(all: usize, done: usize, failed: &[&str]) -> String {
    let ran = count(done, "experiment", "experiments");
    let stopped = if done < all { format!(", interrupted with {} to go", all - done) } else { String::new() };
    match failed {
        [] => format!("{ran} passed{stopped}\n"),
        failed => format!("{} of {ran} failed{stopped}: {}\n", failed.len(), failed.join(", ")),
    }
}

/// Makes the folder for figures, and sees that they can be written.
fn prepare(folder: &Path) -> Result<(), CliError> {
    let unusable = |error| {
        let folder = folder.display();
        CliError::Input(format!(
            "{folder}: the folder cannot be made: {error}\n  help: name another folder for --plots"
        ))
    };
    fs::create_dir_all(folder).map_err(unusable)?;
    OutputFile::check(&folder.join("validate.svg")).map_err(CliError::input).map(drop)
}

/// Writes the figure's two files.
fn write(folder: &Path, figure: &Figure) -> Result<(), OutputError> {
    for (extension, text) in [("svg", svg(figure)), ("csv", csv(figure))] {
        OutputFile::check(&folder.join(figure.name).with_extension(extension))?.write(text.as_bytes())?;
    }
    Ok(())
}

/// Shows on a terminal which experiment is under way, and lets Ctrl-C stop it.
struct Progress {
    bar: ProgressBar,
}

impl Progress {
    fn start(experiments: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(experiments as u64), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{elapsed_precise} [{bar:30}] {pos} of {len}  {msg}");
        bar.set_style(style.expect("the template is valid").progress_chars("=> "));
        Self { bar }
    }

    fn begin(&self, experiment: &Experiment) {
        self.bar.set_message(experiment.name);
    }

    /// Prints an experiment's line above the bar.
    fn print(&self, line: &str) -> Result<(), CliError> {
        self.bar.suspend(|| print(line))?;
        self.bar.inc(1);
        Ok(())
    }

    fn end(&self) {
        self.bar.finish_and_clear();
    }
}

impl Watch for Progress {
    fn advance(&self, _: u64, _: u64) {
        // Limits how often it draws by itself.
        self.bar.tick();
    }

    fn stop(&self) -> bool {
        interrupt::requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_says_what_failed() {
        assert_eq!(summary(3, 3, &[]), "3 experiments passed\n");
        assert_eq!(summary(3, 3, &["a", "b"]), "2 of 3 experiments failed: a, b\n");
        assert_eq!(summary(3, 1, &[]), "1 experiment passed, interrupted with 2 to go\n");
    }
}
