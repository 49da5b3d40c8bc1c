//! One place measured: its contenders in windows, each race kept as it ends.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracebench_api::TracerError;

use super::controls::Control;
use super::place::{Measured, Place, Placed, Refusal, Told};
use super::race::{Built, Outcome, Race, Setting};
use super::run::Context;
use super::{RunError, records};
use crate::plan::{Resolution, TracerRequest};
use crate::results::{RaceRecord, SceneRecord, Skipped, TraceRecord, TracerRun, ViewpointRecord};

/// Structures of contenders that are there at a time.
pub const WINDOW: usize = 32;

/// What is known of a place from its preparation on.
#[derive(Clone, Serialize, Deserialize)]
struct Head {
    scene: SceneRecord,
    viewpoint: ViewpointRecord,
    strength: Option<f64>,
    sets: Vec<String>,
    skipped: Vec<Skipped>,
    told: Value,
}

/// The race of the builds, as it is kept.
#[derive(Default, Serialize, Deserialize)]
struct BuildsRace {
    lanes: Vec<Outcome<Built>>,
    races: Vec<RaceRecord>,
}

/// The race of a ray set, as it is kept.
#[derive(Serialize, Deserialize)]
struct RaysRace {
    rays: String,
    lanes: Vec<Outcome<TraceRecord>>,
    void: Option<String>,
    hooked: Value,
    race: Option<RaceRecord>,
}

/// A place while it is measured.
struct Here<'a> {
    place: &'a Place<'a>,
    context: &'a Context<'a>,
    placed: Option<Placed>,
    head: Head,
    void: Option<String>,
    hooked: Vec<Value>,
    races: Vec<RaceRecord>,
}

/// One window, measured: the controls' rows, then those of its requests in order.
struct Window {
    controls: Vec<Result<TracerRun, Refusal>>,
    rows: Vec<(usize, Result<TracerRun, Refusal>)>,
}

/// Measures a place, but for the races that the journal has.
///
/// # Errors
/// [`RunError`] as its variants say; the races that ended are kept.
pub(crate) fn measure(place: &Place<'_>, context: &Context<'_>) -> Result<Measured, RunError> {
    let mut here = Here::enter(place, context)?;
    // Requests by structure, in the order of the first of each.
    let mut stalls: Vec<Vec<usize>> = Vec::new();
    for (index, request) in place.requests.iter().enumerate() {
        match stalls.iter_mut().find(|stall| place.requests[stall[0]].shares_with(request)) {
            Some(stall) => stall.push(index),
            None => stalls.push(vec![index]),
        }
    }
    let mut found = Measured {
        scene: here.head.scene.clone(),
        viewpoint: here.head.viewpoint.clone(),
        controls: Vec::new(),
        rows: Vec::new(),
        anchors: Vec::new(),
        races: Vec::new(),
        skipped: here.head.skipped.clone(),
        told: here.head.told.clone(),
        hooked: Vec::new(),
        void: None,
    };
    let mut rows: Vec<Option<Result<TracerRun, Refusal>>> = place.requests.iter().map(|_| None).collect();
    // A window's stalls, and whether the first of them is there as the anchor.
    let first = stalls.len().min(WINDOW);
    let mut windows: Vec<(Vec<usize>, bool)> = vec![((0..first).collect(), false)];
    let further: Vec<usize> = (first..stalls.len()).collect();
    windows.extend(further.chunks(WINDOW - 1).map(|chunk| ([&[0], chunk].concat(), true)));
    let mut number = 0;
    while number < windows.len() {
        let (members, anchored) = windows[number].clone();
        let requests: Vec<&[usize]> = members
            .iter()
            .enumerate()
            .map(|(at, stall)| if at == 0 && anchored { &stalls[*stall][..1] } else { &stalls[*stall][..] })
            .collect();
        let window = here.window(number, &requests)?;
        let controls = here.controls(window.controls)?;
        if number == 0 {
            found.controls = controls;
        }
        let mut left = Vec::new();
        for (at, (request, row)) in window.rows.into_iter().enumerate() {
            if anchored && at == 0 {
                found.anchors.extend(row.ok());
                continue;
            }
            // Alone with the anchor, then alone: that others took the room is no reason to go without a row. What a study
            // looks at across rows hangs together.
            let again = members.len() > 1 && !place.effort.lenient && place.hook.is_none();
            if again && row.as_ref().is_err_and(|refusal| refusal.for_room) {
                let stall = stalls.iter().position(|stall| stall.contains(&request)).unwrap_or_default();
                if !left.contains(&stall) {
                    left.push(stall);
                }
            }
            rows[request] = Some(row);
        }
        let with_anchor = members.len() > 2;
        windows.extend(left.into_iter().map(|stall| match stall {
            0 => (vec![0], false),
            stall if with_anchor => (vec![0, stall], true),
            stall => (vec![stall], false),
        }));
        number += 1;
    }
    let none = || Err(Refusal::of(&TracerError::Failed("not measured".to_owned()), false));
    found.rows = rows.into_iter().map(|row| row.unwrap_or_else(none)).collect();
    (found.hooked, found.void, found.races) = (here.hooked, here.void, here.races);
    Ok(found)
}

impl<'a> Here<'a> {
    fn enter(place: &'a Place<'a>, context: &'a Context<'a>) -> Result<Self, RunError> {
        let name = format!("{:03}-place", place.index);
        let (head, placed) = match context.journal.read::<Head>(&name)? {
            Some(head) if place.scene_sha256.is_none_or(|known| known == head.scene.sha256) => (head, None),
            Some(head) => return Err(context.journal.other_scene(&head.scene.name).into()),
            None => {
                let placed = (place.prepare)()?;
                let head = Head {
                    scene: placed.scene.clone(),
                    viewpoint: placed.viewpoint.clone(),
                    strength: placed.strength,
                    sets: placed.session.rays.iter().map(|rays| rays.set.name.to_owned()).collect(),
                    skipped: placed.session.skipped.clone(),
                    told: placed.told.clone(),
                };
                context.journal.keep(&name, &head)?;
                (head, Some(placed))
            }
        };
        Ok(Self { place, context, placed, head, void: None, hooked: Vec::new(), races: Vec::new() })
    }

    /// Runs the races of a window, or takes them from the journal. `requests` by structure.
    fn window(&mut self, number: usize, requests: &[&[usize]]) -> Result<Window, RunError> {
        let index = self.place.index;
        let builds = format!("{index:03}-{number:02}-builds");
        let sets = self.head.sets.clone();
        let names: Vec<String> = (0..sets.len()).map(|set| format!("{index:03}-{number:02}-rays-{set:02}")).collect();
        let journal = self.context.journal;
        let mut kept_builds: Option<BuildsRace> = journal.read(&builds)?;
        let mut kept: Vec<Option<RaysRace>> = names.iter().map(|name| journal.read(name)).collect::<Result<_, _>>()?;
        if (kept_builds.is_none() || kept.iter().any(Option::is_none)) && self.placed.is_none() {
            self.placed = Some((self.place.prepare)()?);
        }
        if let Some(placed) = self.placed.as_ref().filter(|_| kept_builds.is_none() || kept.iter().any(Option::is_none))
        {
            let mut race = self.race(number, placed, requests)?;
            match &kept_builds {
                None => {
                    let built = race.build()?;
                    self.check_device()?;
                    let ended = BuildsRace { lanes: built.outcomes, races: built.races };
                    journal.keep(&builds, &ended)?;
                    kept_builds = Some(ended);
                }
                Some(ended) => {
                    take_out(&mut race, &ended.lanes);
                    race.restore()?;
                }
            }
            for ((rays, name), kept) in placed.session.rays.iter().zip(&names).zip(&mut kept) {
                if let Some(ended) = kept {
                    take_out(&mut race, &ended.lanes);
                    continue;
                }
                let answered = race.trace(rays)?;
                self.check_device()?;
                if let Some(what) = answered.void.as_ref().filter(|_| !self.place.effort.lenient) {
                    return Err(RunError::Control(what.clone()));
                }
                let hooked = match self.place.hook {
                    Some(hook) => hook(&placed.session, rays, &by_request(requests, self.place, answered.told))?,
                    None => Value::Null,
                };
                let rays = rays.set.name.to_owned();
                let ended =
                    RaysRace { rays, lanes: answered.outcomes, void: answered.void, hooked, race: answered.race };
                journal.keep(name, &ended)?;
                *kept = Some(ended);
            }
        }
        let builds = kept_builds.unwrap_or_default();
        Ok(self.rows(number, requests, builds, kept.into_iter().flatten().collect()))
    }

    /// A race that everyone has entered who can be created.
    fn race<'r>(&self, number: usize, placed: &'r Placed, requests: &[&[usize]]) -> Result<Race<'r>, RunError>
    where
        'a: 'r,
    {
        let film = placed.film.as_ref();
        let setting = Setting {
            scene: self.head.scene.name.clone(),
            viewpoint: self.head.viewpoint.name.clone(),
            window: number as u32,
            kernels: self.place.effort.timed.then(|| self.context.kernels()).transpose()?,
            turn: 0,
        };
        let mut race = Race::new(&placed.session, film, self.place.effort, self.context.progress, setting);
        let mut lane = Control::ALL.len();
        for stall in requests {
            let request = &self.place.requests[stall[0]];
            let created = self.context.crew.borrow_mut().contender(&request.tracer, self.context.device);
            let refusal = match created {
                Ok(contender) => {
                    race.enter(contender, Some(request), None);
                    None
                }
                Err(error)
                    if request.tracer.required && !self.place.effort.lenient && self.is_alone(&request.tracer) =>
                {
                    return Err(RunError::Tracer { tracer: request.tracer.name().to_owned(), error });
                }
                Err(error) => {
                    race.enter(self.context.absent(&request.tracer), Some(request), None);
                    Some(Refusal::of(&error, false))
                }
            };
            for further in &stall[1..] {
                race.join(Some(&self.place.requests[*further].tracer), None);
            }
            for _ in stall.iter() {
                if let Some(refusal) = &refusal {
                    race.take_out(lane, refusal.clone());
                }
                lane += 1;
            }
        }
        Ok(race)
    }

    /// Whether no other tracer is asked for: then there is nothing left that could be measured.
    fn is_alone(&self, tracer: &TracerRequest) -> bool {
        self.place.requests.iter().all(|other| other.tracer.name() == tracer.name())
    }

    /// A device that was lost ends the run: what it did not answer is no property of tracers.
    fn check_device(&self) -> Result<(), RunError> {
        match self.context.device {
            Ok(gpu) if gpu.is_lost() => Err(RunError::Device(TracerError::Failed("the device was lost".to_owned()))),
            _ => Ok(()),
        }
    }

    /// Puts the outcomes of a window's races together, lane by lane.
    fn rows(&mut self, number: usize, requests: &[&[usize]], builds: BuildsRace, races: Vec<RaysRace>) -> Window {
        let controls = Control::ALL.len();
        let order: Vec<usize> = requests.concat();
        let of_builds = self.races.len() as u32;
        self.races.extend(builds.races);
        let builds = builds.lanes;
        let mut lanes: Vec<Vec<Outcome<TraceRecord>>> = builds.iter().map(|_| Vec::new()).collect();
        for mut race in races {
            if let Some(record) = race.race.take() {
                for outcome in &mut race.lanes {
                    if let Outcome::Measured(trace) = outcome {
                        trace.times.race = Some(self.races.len() as u32);
                    }
                }
                self.races.push(record);
            }
            self.void = self.void.take().or(race.void);
            if number == 0 {
                self.hooked.push(race.hooked);
            }
            for (lane, outcome) in lanes.iter_mut().zip(race.lanes) {
                lane.push(outcome);
            }
        }
        let mut window = Window { controls: Vec::new(), rows: Vec::new() };
        for (lane, (mut built, traced)) in builds.into_iter().zip(lanes).enumerate() {
            if let Outcome::Measured(Built { build, .. }) = &mut built {
                build.all_mut().for_each(|times| times.race = times.race.map(|race| race + of_builds));
            }
            let request = order.get(lane.wrapping_sub(controls)).copied();
            let row = self.row(number, lane, request, built, traced);
            match request {
                None => window.controls.push(row),
                Some(request) => window.rows.push((request, row)),
            }
        }
        window
    }

    fn row(
        &self,
        number: usize,
        lane: usize,
        request: Option<usize>,
        built: Outcome<Built>,
        traced: Vec<Outcome<TraceRecord>>,
    ) -> Result<TracerRun, Refusal> {
        let Built { memory, structure_statistics, build } = measured(built)?;
        let mut viewpoint = self.head.viewpoint.clone();
        let tracer = match request.map(|request| &self.place.requests[request].tracer) {
            None => records::control_record(Control::ALL[lane]),
            Some(request) => {
                if let Some(Resolution { frame, face }) = request.resolution {
                    (viewpoint.frame, viewpoint.face) = (frame, face);
                }
                records::request_record(request)
            }
        };
        Ok(TracerRun {
            scene: self.head.scene.clone(),
            viewpoint,
            tracer,
            way: None,
            strength: self.head.strength,
            window: number as u32,
            machine: 0,
            memory,
            structure_statistics,
            build,
            traces: traced.into_iter().map(measured).collect::<Result<_, _>>()?,
        })
    }

    /// Controls go the way of every contender, and one that cannot voids what was measured.
    fn controls(&mut self, rows: Vec<Result<TracerRun, Refusal>>) -> Result<Vec<TracerRun>, RunError> {
        let mut controls = Vec::new();
        for (row, control) in rows.into_iter().zip(Control::ALL) {
            match row {
                Ok(row) => controls.push(row),
                Err(refusal) if self.place.effort.lenient => {
                    self.void.get_or_insert(refusal.reason);
                }
                Err(refusal) => {
                    let tracer = control.description().name.to_owned();
                    return Err(RunError::Tracer { tracer, error: TracerError::Failed(refusal.reason) });
                }
            }
        }
        Ok(controls)
    }
}

fn measured<T>(outcome: Outcome<T>) -> Result<T, Refusal> {
    match outcome {
        Outcome::Measured(found) => Ok(found),
        Outcome::Out(refusal) => Err(refusal),
        Outcome::Absent => Err(Refusal::of(&TracerError::Failed("it was taken out before".to_owned()), false)),
    }
}

/// Takes out of a race who was taken out of the one that is kept.
fn take_out<T>(race: &mut Race<'_>, lanes: &[Outcome<T>]) {
    for (lane, outcome) in lanes.iter().enumerate() {
        if let Outcome::Out(refusal) = outcome {
            race.take_out(lane, refusal.clone());
        }
    }
}

/// Answers in the order of the place's requests.
fn by_request(requests: &[&[usize]], place: &Place<'_>, told: Vec<Option<Told>>) -> Vec<Option<Told>> {
    let mut sorted: Vec<Option<Told>> = place.requests.iter().map(|_| None).collect();
    for (request, told) in requests.concat().into_iter().zip(told.into_iter().skip(Control::ALL.len())) {
        sorted[request] = told;
    }
    sorted
}
