//! What machine this is, and which program.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use tracebench_api::{AdapterInfo, DeviceLimits, Gpu, Rasterizer};

/// The machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Processor.
    pub cpu: String,
    /// Hardware threads that the program may use.
    pub threads: usize,
    /// Main memory, bytes; `None` if unknown.
    pub memory_bytes: Option<u64>,
    /// Operating system.
    pub os: String,
    /// Compiler that built the program.
    pub rustc: String,
    /// The adapter used; `None` if no tracer needed one.
    pub adapter: Option<AdapterInfo>,
    /// What its rasterizer was found to do; `None` without an adapter, and in records that are older than this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rasterizer: Option<Rasterizer>,
}

impl Machine {
    /// The machine in one line, for captions.
    pub fn label(&self) -> String {
        let adapter = match &self.adapter {
            None => "no adapter".to_owned(),
            Some(adapter) => {
                let software = adapter.kind == "software";
                let software = if software { " (software adapter: times say little of hardware)" } else { "" };
                let limits = match adapter.limits {
                    DeviceLimits::Adapter => "",
                    DeviceLimits::Webgpu => ", within WebGPU's default limits",
                };
                format!("{}{software}{limits}", adapter.name)
            }
        };
        format!("{}, {} threads; {adapter}", self.cpu, self.threads)
    }
}

/// Commit that the program was built from, or "unknown".
pub const COMMIT: &str = env!("TRACEBENCH_COMMIT");

/// What stands for every control in [`fingerprint`].
pub const CONTROLS: &str = "controls";

/// What a tracer's rows are made by, or a control's: a hash of its sources and of those of rays, truth and judge, without comments and
/// tests (harness/build/fingerprint.rs). None of a tracer that this program does not have.
pub fn fingerprint(name: &str) -> Option<&'static str> {
    let module = name.replace('-', "_");
    let all = env!("TRACEBENCH_FINGERPRINTS").split(' ').filter_map(|each| each.split_once('='));
    all.into_iter().find_map(|(of, hash)| (of == module).then_some(hash))
}

/// Whether the tree had changes when the program was built.
pub fn dirty() -> Option<bool> {
    env!("TRACEBENCH_DIRTY").parse().ok()
}

/// What tells this machine from others of its kind: a hash of what the system says of itself; empty where it says nothing.
pub fn machine_id() -> String {
    let id =
        ["/etc/machine-id", "/proc/sys/kernel/hostname"].map(|path| std::fs::read_to_string(path).unwrap_or_default());
    let id = id.concat();
    if id.is_empty() { id } else { crate::hash::sha256_of(id.as_bytes())[..16].to_owned() }
}

/// Hash of the running program's file; empty if it cannot be read.
pub fn program_sha256() -> String {
    let program = std::env::current_exe().ok();
    program.and_then(|path| crate::hash::sha256_of_file(&path)).unwrap_or_default()
}

/// Looks at this machine, and at the device that is used.
pub fn this_machine(gpu: Option<&Gpu>) -> Machine {
    Machine {
        cpu: field("/proc/cpuinfo", "model name")
            .unwrap_or_else(|| format!("unknown {} processor", std::env::consts::ARCH)),
        threads: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        memory_bytes: memory_bytes(),
        os: os_name(),
        rustc: env!("TRACEBENCH_RUSTC").to_owned(),
        adapter: gpu.map(|gpu| gpu.listing.clone()),
        rasterizer: gpu.and_then(|gpu| tracebench_kit::rasterizer(gpu).ok()),
    }
}

/// The value of the first line of a `key : value` file whose key matches.
fn field(path: &str, key: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let value = text.lines().find_map(|line| line.split_once(':').filter(|(name, _)| name.trim() == key))?.1;
    Some(value.trim().to_owned()).filter(|value| !value.is_empty())
}

fn memory_bytes() -> Option<u64> {
    let kibibytes = field("/proc/meminfo", "MemTotal")?;
    kibibytes.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

fn os_name() -> String {
    let release = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
    let pretty = release.lines().find_map(|line| line.strip_prefix("PRETTY_NAME="));
    pretty.map_or_else(|| std::env::consts::OS.to_owned(), |name| name.trim_matches('"').to_owned())
}

/// Now, UTC, as ISO 8601 to the second.
pub fn utc_now() -> String {
    iso_8601(SystemTime::now())
}

/// A time as ISO 8601 to the second; of a clock that is set before 1970 or after 9999 the nearest that can be written.
fn iso_8601(time: SystemTime) -> String {
    const LAST_S: u64 = 253_402_300_799;
    let seconds = time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs().min(LAST_S);
    humantime::format_rfc3339_seconds(UNIX_EPOCH + Duration::from_secs(seconds)).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clocks that are set wrong are no reason to end without a record.
    #[test]
    fn any_clock_gives_a_time() {
        let at = |seconds: u64| UNIX_EPOCH + Duration::from_secs(seconds);
        for (time, text) in [
            (at(0), "1970-01-01T00:00:00Z"),
            (at(1_000_000_000), "2001-09-09T01:46:40Z"),
            (UNIX_EPOCH - Duration::from_secs(1), "1970-01-01T00:00:00Z"),
            (UNIX_EPOCH - Duration::from_secs(1 << 40), "1970-01-01T00:00:00Z"),
            (at(253_402_300_799), "9999-12-31T23:59:59Z"),
            (at(253_402_300_800), "9999-12-31T23:59:59Z"),
            (at(1 << 50), "9999-12-31T23:59:59Z"),
        ] {
            assert_eq!(iso_8601(time), text);
        }
    }
}
