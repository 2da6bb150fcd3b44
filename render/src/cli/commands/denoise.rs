//! `halfdome denoise`: from a noisy picture to a denoised one.

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use crate::cli::args::{CommonArguments, ToneArguments, denoiser};
use crate::cli::denoiser::{Denoiser, denoise};
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED, invalid};
use crate::cli::messages::{Style, print_line, print_text, warn};
use crate::cli::prepare::thread_pool;
use crate::cli::{inputs, interrupt, memory};
use crate::denoise::{DenoiseError, Method};
use crate::output;

/// The arguments of `halfdome denoise`.
#[derive(Args, Clone, Debug)]
pub(crate) struct DenoiseArguments {
    /// The noisy picture (.exr), best with the channels that `halfdome render --aov --aov-through` writes
    input: PathBuf,

    /// Picture to write: .exr (all channels, the noisy colours as Noisy.R, Noisy.G, Noisy.B) or .png (tone mapped); can
    /// be given several times
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,

    /// Denoise by oidn (Intel's Open Image Denoise 2) or nlm (built in) [default: oidn if it is installed, else nlm]
    #[arg(long = "with", value_name = "METHOD", value_parser = denoiser())]
    with: Option<Denoiser>,

    /// Options of PNG pictures.
    #[command(flatten)]
    tone: ToneArguments,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,
}

/// Denoises a picture and writes it.
pub(crate) fn run(arguments: &DenoiseArguments) -> Result<u8, CliError> {
    let DenoiseArguments { input, outputs, with, tone, common } = arguments;
    for path in outputs {
        output::check(path).map_err(CliError::input)?;
    }
    inputs::refuse(outputs, std::slice::from_ref(input))?;
    let method = match with {
        Some(denoiser) => denoiser.method()?,
        None => Denoiser::Oidn.method().or_else(|_| Denoiser::Nlm.method())?,
    };
    let style = common.progress.style(std::io::stderr().is_terminal());
    let picture = output::read_exr(input).map_err(CliError::input)?;
    let (width, height) = (picture.width, picture.height);
    if picture.metadata.integrator == "heat" {
        let problem = format!("{} has counts of the integrator heat, which are not denoised", input.display());
        return Err(invalid(problem, "give a picture of light"));
    }
    let what = format!("denoising a picture of {width}x{height}");
    memory::require(&what, method.bytes(width, height), "give a smaller picture")?;
    let failed = |error: DenoiseError| failure(&method, error, &input.display().to_string());
    let mut warnings = method.check(&picture).map_err(failed)?;
    match style {
        Style::Json => print_line(&json!({
            "event": "start", "picture": input.display().to_string(), "width": width, "height": height,
            "method": method.name(),
        })),
        _ => print_text(style, &format!("{}: {width}x{height}, by {method}", input.display())),
    }
    warn(style, &mut warnings);

    interrupt::catch()?;
    let pool = thread_pool(common)?;
    let picture = match denoise(&method, picture, &pool, style) {
        Err(DenoiseError::Stopped) => {
            print_text(style, "interrupted; nothing was written");
            return Ok(EXIT_INTERRUPTED);
        }
        result => result.map_err(failed)?,
    };
    let (written, failures) = super::render::write_all(outputs, &picture, &tone.mapping());
    super::render::refuse_failures(&written, failures)?;
    match style {
        Style::Json => print_line(&json!({
            "event": "end", "files": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        })),
        _ => written.iter().for_each(|path| print_text(style, &format!("wrote {}", path.display()))),
    }
    Ok(EXIT_DONE)
}

/// The error of the picture called `name`.
fn failure(method: &Method, error: DenoiseError, name: &str) -> CliError {
    match error {
        DenoiseError::Failed(_) => CliError::System(format!("{name}: {method}: {error}")),
        error => CliError::Input(format!("{name}: {}: {error}", method.name())),
    }
}
