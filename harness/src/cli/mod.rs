//! The command line: `tracebench doctor | list | run | sweep | pareto | need | frames | reproduce | table | compare | merge | report |
//! stability | attack | explain | rays | judge`.
//!
//! Exit status 0 only when all went well; 2 for arguments; 1 for files, devices, memory.

mod arguments;
mod doctor;
mod judge;
mod list;
mod names;
mod output;
mod records;
mod renames;
mod reproduce;
mod stop;
mod studies;
mod sweep;
mod table;
mod work;

use std::process::ExitCode;
use std::sync::Arc;

use clap::{Parser, Subcommand};
use tracebench_api::{AdapterChoice, Gpu, TracerError};

use arguments::DeviceArguments;

use crate::exchange::ExchangeError;
use crate::files::FileError;
use crate::measure::RunError;
use crate::plan::TracerRequest;
use crate::progress::{self, Progress};
use crate::registry::{self, Device, Registration};
use crate::report::ReportError;

/// Comparative benchmark of image-space ray tracers: speed and accuracy of the same rays, side by side.
#[derive(Parser)]
#[command(name = "tracebench", version, max_term_width = 100)]
struct CommandLine {
    /// Show no progress.
    #[arg(long, global = true)]
    quiet: bool,
    /// End when standard input does, which who starts this process holds open.
    #[arg(long, global = true, hide = true)]
    until_stdin_ends: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Tell what this machine is, which graphics adapters it has, within which limits, and what it lacks; or try its clock.
    #[command(mut_args(doctor::options))]
    Doctor(doctor::DoctorArguments),
    /// List tracers (with their parameters), scenes, ray sets, cases or tables.
    List(list::ListArguments),
    /// Trace rays, judge them against the truth, and write run.json, tables and charts.
    Run(studies::StudyArguments),
    /// Measure one tracer over values of its parameters and over resolutions: memory, build, trace and error; or show what the choice of a
    /// parameter costs.
    Sweep(sweep::SweepArguments),
    /// Measure the same number of points of every tracer, over parameters and resolutions: who is fastest, smallest and quickest to build
    /// at which agreement.
    Pareto(studies::ParetoArguments),
    /// Shrink structures until answers get worse: bytes needed beside bytes stored and touched.
    #[command(
        mut_arg("tracer", |arg| arg.help("Tracers: NAME or NAME:PRESET with commas, or all. Methods with nothing to shrink stand there with what they store and touch")),
        mut_arg("rays", |arg| arg.default_value("diffuse,ao")),
    )]
    Need(studies::StudyArguments),
    /// Follow moving scenes frame by frame: update structures, trace or render every frame, and tell time, error and flicker.
    Frames(studies::FramesArguments),
    /// Measure all that matters in order of weight within a time that is given, into one folder with one report.
    Reproduce(reproduce::ReproduceArguments),
    /// Measure tracers of one family side by side, or what a paper's table or figure shows, and write a table of it; or set all that a
    /// paper claims beside what was measured, with a verdict on every claim.
    Table(arguments::TableArguments),
    /// Compare two runs: what got slower or less accurate, what changed, what only one has.
    Compare(records::CompareArguments),
    /// Join the shards of a run that was spread over machines by --shard.
    Merge(records::MergeArguments),
    /// Make every file that derives from a run.json, of whatever verb, again; or one page, or one table, of several records; or check what
    /// is handed in.
    Report(records::ReportArguments),
    /// Run minimal scenes of one difficulty each and compare what tracers get wrong with what is expected of them.
    Stability(studies::StabilityArguments),
    /// Search for the poses at which tracers are wrong the most, and make what is wrong there small.
    Attack(studies::AttackArguments),
    /// Tell why a tracer's rays are wrong, by taking its known weaknesses away one after the other.
    #[command(
        mut_arg("scene", |arg| arg.default_value("all")),
        mut_arg("tracer", |arg| arg.default_value(registry::first(studies::explainable).map(Registration::name)).help("The tracer, NAME or NAME:PRESET: one whose weaknesses can be taken away")),
    )]
    Explain(studies::StudyArguments),
    /// Write rays with their truth, and the scene, as arrays that any program reads.
    #[command(mut_arg("adapter", |arg| arg.hide(true)), mut_arg("limits", |arg| arg.hide(true)))]
    Rays(judge::RaysArguments),
    /// Judge what any program answered to rays that `rays` wrote, as tracers here are.
    Judge(judge::JudgeArguments),
}

/// What ends the program early.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// An argument is wrong.
    #[error("{0}")]
    Argument(String),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// Rays or answers could not be read or written.
    #[error(transparent)]
    Exchange(#[from] ExchangeError),
    /// A record could not be read, or what derives from it not be made.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A device could not be had.
    #[error(transparent)]
    Device(#[from] TracerError),
    /// Something that is not worth a type.
    #[error("{0}")]
    Other(String),
}

/// Ends the program for an argument that is wrong.
fn refuse<T>(why: impl Into<String>) -> Result<T, CliError> {
    Err(CliError::Argument(why.into()))
}

/// Ends the program for something else that is not worth a type.
fn fail<T>(why: impl Into<String>) -> Result<T, CliError> {
    Err(CliError::Other(why.into()))
}

/// Ends the program for all that went wrong, if anything did: what is said of so many, listed with a separator.
fn fail_for(wrong: &[String], separator: &str, said: impl FnOnce(String) -> String) -> Result<(), CliError> {
    if wrong.is_empty() { Ok(()) } else { fail(said(wrong.join(separator))) }
}

impl CliError {
    fn exit_code(&self) -> ExitCode {
        let argument = match self {
            Self::Argument(_) => true,
            Self::Run(error) => error.is_argument(),
            _ => false,
        };
        ExitCode::from(if argument { 2 } else { 1 })
    }
}

/// What is wrong with the words of a command line, without the program's name and a folder to write to.
fn parses(words: &str) -> Result<(), String> {
    let line = ["tracebench"].into_iter().chain(words.split(' '));
    let wrong = CommandLine::try_parse_from(line).err();
    wrong.map_or(Ok(()), |error| Err(error.to_string().lines().next().unwrap_or_default().replace("error: ", "")))
}

/// Runs the program.
pub fn main() -> ExitCode {
    let command_line = match CommandLine::try_parse() {
        Ok(command_line) => command_line,
        Err(error) => {
            let words: Vec<String> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
            // Help and version come this way too; clap knows which stream and status each needs.
            match renames::answer(&error, &words) {
                Some(answer) => progress::to_stderr(&answer),
                None => drop(error.print()),
            }
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    if let Some(is) = renames::variable() {
        progress::to_stderr(&format!("error: {is}"));
        return ExitCode::from(2);
    }
    let progress = Progress::new(command_line.quiet);
    stop::watch(command_line.until_stdin_ends);
    let outcome = match &command_line.verb {
        Verb::Doctor(arguments) => doctor::doctor(arguments, &progress),
        Verb::List(arguments) => list::list(arguments),
        Verb::Run(arguments) => studies::run(arguments, &progress),
        Verb::Sweep(arguments) => sweep::sweep(arguments, &progress),
        Verb::Pareto(arguments) => studies::pareto(arguments, &progress),
        Verb::Need(arguments) => studies::need(arguments, &progress),
        Verb::Frames(arguments) => studies::frames(arguments, &progress),
        Verb::Reproduce(arguments) => reproduce::reproduce(arguments, &progress),
        Verb::Table(arguments) => table::table(arguments, &progress),
        Verb::Compare(arguments) => records::compare(arguments),
        Verb::Merge(arguments) => records::merge_shards(arguments),
        Verb::Report(arguments) => records::report(arguments, &progress),
        Verb::Stability(arguments) => studies::stability(arguments, &progress),
        Verb::Attack(arguments) => studies::attack(arguments, &progress),
        Verb::Explain(arguments) => studies::explain(arguments, &progress),
        Verb::Rays(arguments) => judge::rays(arguments, &progress),
        Verb::Judge(arguments) => judge::judge(arguments, &progress),
    };
    // The last hold on a folder of results: it is closed.
    stop::keeps(None);
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            progress::to_stderr(&format!("error: {error}"));
            error.exit_code()
        }
    }
}

/// Opens the device if any tracer that is asked for can use it; else, and if there is none, says why. An adapter that is named (by
/// `--adapter` or by `WGPU_ADAPTER_NAME`) and a tracer that must have one make not getting one an error.
fn open_device(arguments: &DeviceArguments, requests: &[TracerRequest]) -> Result<Device, CliError> {
    let wanted = arguments.adapter.as_deref();
    if wanted.is_none() && !requests.iter().any(|request| request.registration.needs_device()) {
        return Ok(Err(TracerError::Unavailable("no tracer of this run uses a graphics adapter".to_owned())));
    }
    let choice = AdapterChoice::from_environment(wanted, arguments.limits)?;
    let required = choice.wanted.is_some() || requests.iter().any(TracerRequest::must_have_device);
    match Gpu::open(&choice) {
        Ok(gpu) => Ok(Ok(Arc::new(gpu))),
        Err(error) if required => Err(error.into()),
        Err(error) => Ok(Err(error)),
    }
}
