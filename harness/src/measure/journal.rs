//! What has ended while more is measured: a folder with the plan and a file an interleaved set, each written whole.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::files::{self, FileError, OutputFolder};
use crate::machine::{self, Machine};
use crate::results::LaunchRecord;

/// What the names of its files begin with: a folder below that of the results.
const FOLDER: &str = "interleaved_sets/";
/// The file with the plan.
const PLAN: &str = "interleaved_sets/plan.json";

/// Why what has ended cannot be kept or gone on with.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// Something else was begun in a folder: what differs.
    #[error("{path} holds a run that was begun {1}; finish it as it was begun, or choose another folder", path = .0.display())]
    Other(PathBuf, String),
    /// The plan of what was begun cannot be read from its file, and why.
    #[error("{path} cannot be read ({1}): what was begun there cannot be gone on with; remove its folder", path = .0.display())]
    Unreadable(PathBuf, String),
    /// A run that was broken off is in the way in a folder.
    #[error("{path} holds a run that was broken off; go on with it by --resume, choose another folder, or remove its {FOLDER}", path = .0.display())]
    InTheWay(PathBuf),
}

/// Who began what, and where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Begun {
    commit: String,
    program_sha256: String,
    machine: Machine,
    /// Tells machines of one kind apart; empty where the system has none.
    machine_id: String,
    plan: Value,
    /// How searches read and are launched where nothing is set: a run that is gone on with takes these, whatever a probe says by then.
    launch: Option<LaunchRecord>,
    started: String,
    resumed: Vec<String>,
}

/// An interleaved set that has ended, with what it is of: one of another plan, or under another name, is none.
#[derive(Serialize, Deserialize)]
struct Ended<T> {
    plan_sha256: String,
    name: String,
    ended: T,
}

/// The journal of a run; one without a folder keeps nothing.
#[derive(Debug, Default)]
pub struct Journal {
    /// The folder of results that it keeps what has ended in.
    folder: Option<Arc<OutputFolder>>,
    plan_sha256: String,
    resumed: Vec<String>,
    started: Option<String>,
    /// The end of the names of what stays.
    staying: OnceLock<&'static str>,
}

impl Journal {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// The folder of results that it keeps what has ended for.
    pub fn results(&self) -> Option<&OutputFolder> {
        self.folder.as_deref()
    }

    /// Begins in a folder of results: the plan is there before anything is measured.
    ///
    /// # Errors
    /// If a run that was broken off is there, or the plan cannot be written.
    pub fn begin(
        results: &Arc<OutputFolder>,
        plan: &Value,
        machine: &Machine,
        launch: Option<&LaunchRecord>,
    ) -> Result<Self, JournalError> {
        if Self::is_in(results.path()) {
            return Err(JournalError::InTheWay(results.path().to_owned()));
        }
        // Interleaved sets without a plan are left of nothing that could be gone on with.
        Self::take_away(results);
        Self::of(results, Begun { launch: launch.cloned(), ..Begun::now(plan, machine) })
    }

    /// Keeps what was begun, and all that ends from now on.
    fn of(results: &Arc<OutputFolder>, begun: Begun) -> Result<Self, JournalError> {
        results.write(PLAN, &files::json(PLAN, &begun)?)?;
        let Begun { plan, started, resumed, .. } = begun;
        let plan_sha256 = crate::hash::sha256_of(plan.to_string().as_bytes());
        Ok(Self { folder: Some(results.clone()), plan_sha256, resumed, started: Some(started), ..Self::default() })
    }

    /// Goes on with what is in a folder of results, if it is the same plan by the same program on the same machine.
    ///
    /// # Errors
    /// If there is nothing, or something else was begun.
    pub fn resume(results: &Arc<OutputFolder>, plan: &Value, machine: &Machine) -> Result<Self, JournalError> {
        let unreadable = |reason: String| JournalError::Unreadable(results.path().join(PLAN), reason);
        let text = fs::read(results.path().join(PLAN)).map_err(|error| unreadable(error.to_string()))?;
        let mut begun: Begun = serde_json::from_slice(&text).map_err(|error| unreadable(error.to_string()))?;
        let now = Begun::now(plan, machine);
        let other = |what: &str| JournalError::Other(results.path().to_owned(), what.to_owned());
        if begun.plan != now.plan {
            return Err(other(&format!("with another plan ({})", first_difference(&begun.plan, &now.plan, ""))));
        }
        if (&begun.commit, &begun.program_sha256) != (&now.commit, &now.program_sha256) {
            let what = if begun.commit == now.commit { ", built otherwise" } else { "" };
            let commits = format!("of commit {}, this is of {}{what}", begun.commit, now.commit);
            return Err(other(&format!("by another program ({commits})")));
        }
        // How much memory a system leaves differs by a few pages from start to start.
        let kind = |machine: &Machine| Machine { memory_bytes: None, ..machine.clone() };
        if (&begun.machine_id, kind(&begun.machine)) != (&now.machine_id, kind(&now.machine)) {
            let (theirs, ours) = (begun.machine.label(), now.machine.label());
            return Err(other(&format!("on another machine ({theirs}; this is {ours})")));
        }
        begun.resumed.push(now.started);
        Self::of(results, begun)
    }

    /// Whether a run that was broken off is in a folder of results.
    pub fn is_in(results: &Path) -> bool {
        results.join(PLAN).is_file()
    }

    /// The means that the run in a folder of results was begun with; none where nothing tells them.
    pub fn launch_of(results: &Path) -> Option<LaunchRecord> {
        let text = fs::read(results.join(PLAN)).ok()?;
        serde_json::from_slice::<Begun>(&text).ok()?.launch
    }

    /// The error of a scene that is another one now.
    pub(super) fn other_scene(&self, name: &str) -> JournalError {
        let path = self.results().map(OutputFolder::path).unwrap_or(Path::new("")).to_owned();
        JournalError::Other(path, format!("with another scene of the name {name}"))
    }

    /// When the run was begun and gone on with.
    pub fn times(&self) -> (Option<&str>, &[String]) {
        (self.started.as_deref(), &self.resumed)
    }

    /// What was kept under a name; `None` if there is nothing, or no whole document of the kind.
    pub(crate) fn read<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, JournalError> {
        let file = format!("{FOLDER}{name}.json");
        let Some(folder) = self.folder.as_ref().filter(|folder| folder.holds(&file)) else { return Ok(None) };
        let path = folder.path().join(&file);
        let text = fs::read(&path).map_err(|error| JournalError::Unreadable(path, error.to_string()))?;
        // An interleaved set that cannot be read, or is another one, is run again.
        let ended = serde_json::from_slice::<Ended<T>>(&text).ok();
        let own = ended.filter(|ended| ended.plan_sha256 == self.plan_sha256 && ended.name == name);
        Ok(own.map(|ended| ended.ended))
    }

    /// Keeps what has ended.
    pub(crate) fn keep(&self, name: &str, ended: &impl Serialize) -> Result<(), JournalError> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let (file, plan_sha256) = (format!("{FOLDER}{name}.json"), self.plan_sha256.clone());
        let ended = Ended { plan_sha256, name: name.to_owned(), ended };
        folder.write(&file, &files::json(&file, &ended)?)?;
        Ok(())
    }

    /// Lets what has names with this end stay when there is a record: not all that was asked for was done.
    pub(crate) fn stay(&self, end: &'static str) {
        self.staying.get_or_init(|| end);
    }

    /// Takes away what is in the record now; tells whether anything stays.
    pub fn recorded(&self) -> bool {
        let (Some(results), Some(end)) = (self.results(), self.staying.get()) else {
            self.finish();
            return false;
        };
        let rest = Self::listed(results).into_iter().filter(|name| !name.ends_with(&format!("{end}.json")));
        rest.for_each(|name| results.remove(&name));
        true
    }

    /// Takes it away: everything is in the record now.
    pub fn finish(&self) {
        self.results().into_iter().for_each(Self::take_away);
    }

    /// Takes away what is in a folder of results.
    pub fn take_away(results: &OutputFolder) {
        // The plan first: nobody takes what is left for a run that was broken off.
        results.remove(PLAN);
        Self::listed(results).iter().for_each(|name| results.remove(name));
    }

    /// Whether any interleaved set has ended.
    pub fn holds(&self) -> bool {
        self.results().is_some_and(Self::holds_in)
    }

    /// Whether any interleaved set has ended in a folder of results: of places alone nothing was measured.
    pub fn holds_in(results: &OutputFolder) -> bool {
        Self::listed(results).iter().any(|name| !name.ends_with("-place.json") && results.path().join(name).exists())
    }

    /// The files of what has ended that a folder of results lists.
    fn listed(results: &OutputFolder) -> Vec<String> {
        results.listed().into_iter().filter(|name| name.starts_with(FOLDER) && name != PLAN).collect()
    }

    /// Takes it away if no interleaved set has ended yet.
    pub fn abandon(&self) {
        if !self.holds() {
            self.finish();
        }
    }
}

impl Begun {
    fn now(plan: &Value, machine: &Machine) -> Self {
        Self {
            commit: machine::COMMIT.to_owned(),
            program_sha256: machine::program_sha256(),
            machine: machine.clone(),
            machine_id: machine::machine_id(),
            plan: plan.clone(),
            launch: None,
            started: machine::utc_now(),
            resumed: Vec::new(),
        }
    }
}

/// Where two plans differ first, in words.
fn first_difference(theirs: &Value, ours: &Value, path: &str) -> String {
    match (theirs, ours) {
        (Value::Object(theirs), Value::Object(ours)) => {
            let differs = |name: &&String| theirs.get(*name) != ours.get(*name);
            // The verb first: everything else follows from it.
            let verb = "verb".to_owned();
            let names = std::iter::once(&verb).chain(theirs.keys()).chain(ours.keys());
            let name = names.into_iter().find(differs).cloned().unwrap_or_default();
            let of = |side: &serde_json::Map<String, Value>| side.get(&name).cloned().unwrap_or_default();
            first_difference(&of(theirs), &of(ours), format!("{path} {name}").trim_start())
        }
        (Value::Array(theirs), Value::Array(ours)) if theirs.len() == ours.len() => {
            let place = theirs.iter().zip(ours).position(|(one, other)| one != other).unwrap_or_default();
            first_difference(&theirs[place], &ours[place], path)
        }
        _ => {
            let short = |value: &Value| value.to_string().chars().take(80).collect::<String>();
            format!("{path} was {}, is {}", short(theirs), short(ours))
        }
    }
}
