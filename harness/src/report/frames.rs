//! Frames: `frames.md`, a row a frame in `frames.csv`, and charts over frames.

use std::collections::BTreeSet;

use itertools::Itertools as _;
use tracebench_api::Update;

use super::beside::from_to;
use super::chart::series::{Errors, Series, SeriesChart, SeriesPanel, errors, series};
use super::document::{Document, Of};
use super::format::{self, significant};
use super::markdown::literal;
use super::metrics::{BUILD_PEAK, FIRST_BUILD, STRUCTURE};
use super::sheet::{Cell, Sheet, Table};
use super::{Report, summary};
use crate::registry;
use crate::results::{
    COVERAGE, FramePictures, FrameRow, FrameSeries, FramesRecord, ImageRow, ROUNDED_ORACLE, Record, Rule, TracerRecord,
    WaveRow, WorkRow, gathered, of_rounds,
};
use crate::statistics::{median, percentile, rank_correlation};
use crate::studies::frames::is_exact;

/// A row a frame.
const FRAMES_TABLE: &str = "frames.csv";

/// What the names of its charts begin with.
pub(super) const STEM: &str = "frames_";

/// A tracer or a control with one of the works.
#[derive(Clone, Copy)]
pub(in crate::report) struct Shown<'a> {
    section: &'a FramesRecord,
    pub series: &'a FrameSeries,
    work: &'a str,
}

/// A frame of it.
struct ShownFrame<'a> {
    shown: Shown<'a>,
    number: u64,
    row: &'a FrameRow,
    work: Option<&'a WorkRow>,
}

impl<'a> Shown<'a> {
    fn rows(&self) -> impl Iterator<Item = (&'a FrameRow, &'a WorkRow)> {
        let work = self.work;
        self.series.frames.iter().filter_map(move |row| Some((row, row.works.get(work)?)))
    }

    fn images(&self) -> impl Iterator<Item = &'a ImageRow> {
        self.rows().filter_map(|(_, work)| work.image.as_ref())
    }

    /// Milliseconds of every frame after the first, whose structure is built afresh; of a single frame of it.
    pub(in crate::report) fn ms(&self) -> Vec<f64> {
        let skipped = usize::from(self.series.frames.len() > 1);
        self.series.frames.iter().skip(skipped).filter_map(|row| row.ms(self.work)).collect()
    }

    /// The share of rays that are right by the rule of a place, of the first wave or of all; those of a wave that are judged stand for all of it.
    pub(in crate::report) fn right(&self, rule: usize, first: bool) -> Option<f64> {
        let waves = self.rows().flat_map(|(_, work)| work.waves.iter().take(if first { 1 } else { usize::MAX }));
        let [right, rays] = waves.filter(|wave| wave.judged > 0).fold([0.0; 2], |[right, rays], wave| {
            let all = wave.rays as f64;
            [right + all * wave.right[rule] as f64 / wave.judged as f64, rays + all]
        });
        (rays > 0.0).then(|| right / rays)
    }

    /// The share of pairs of surface points that turned.
    fn turned(&self) -> Option<f64> {
        share(self.series.frames.iter().filter_map(|row| row.turned))
    }

    /// A figure of images.
    pub(in crate::report) fn of_images(&self, of: fn(&ImageRow) -> Option<f64>) -> Vec<f64> {
        self.images().filter_map(of).collect()
    }
}

fn share(pairs: impl Iterator<Item = [u64; 2]>) -> Option<f64> {
    let [all, turned] = pairs.fold([0, 0], |sum, [all, turned]| [sum[0] + all, sum[1] + turned]);
    (all > 0).then(|| turned as f64 / all as f64)
}

/// Median, 95th percentile and worst.
fn spread(values: &[f64], digits: usize) -> Cell {
    let worst = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let three =
        || [median(values), percentile(values, 95.0).unwrap_or(worst), worst].map(|value| significant(value, digits));
    if values.is_empty() { Cell::Absent } else { three().join(" / ").into() }
}

/// The 95th percentile of times over their median.
fn jitter(ms: &[f64]) -> Option<f64> {
    percentile(ms, 95.0).filter(|_| ms.len() > 1).map(|most| most / median(ms)).filter(|jitter| jitter.is_finite())
}

/// Every work in every scene.
pub(super) fn works(section: &FramesRecord) -> impl Iterator<Item = (usize, &String)> {
    (0..section.scenes.len()).cartesian_product(&section.works)
}

/// All series of a scene with a work, controls first.
pub(in crate::report) fn shown<'a>(section: &'a FramesRecord, scene: usize, work: &'a str) -> Vec<Shown<'a>> {
    let of_scene = section.rows.iter().filter(|row| row.scene as usize == scene);
    let all = of_scene.map(|series| Shown { section, series, work });
    all.filter(|shown| shown.rows().next().is_some()).collect()
}

/// What is made of frames.
pub(super) fn report(record: &Record) -> Option<Report> {
    let section = record.frames.as_ref()?;
    let page = Report::of_page("frames.md", page(record, section));
    Some(Report { tables: vec![(FRAMES_TABLE.to_owned(), every_frame(section))], ..page })
}

fn page(record: &Record, section: &FramesRecord) -> Document {
    let FramesRecord { frames, fps, size: [width, height], spp, moves, update, paths, .. } = section;
    let what = match (section.fixed_rays, section.effects) {
        (true, _) => "Every frame has the world rays of the first, judged from its eye.".to_owned(),
        (false, true) => {
            let samples = if *spp == 1 { "one sample".to_owned() } else { format!("{spp} samples") };
            format!("Effects are rendered at {width}x{height} with {samples} a pixel; paths go on from {paths} hits.")
        }
        (false, false) => "Ray sets are traced anew in every frame.".to_owned(),
    };
    let cut = section.cut.map_or_else(String::new, |cut| format!(" The camera jumps in frame {cut}."));
    let page = summary::head(record, "Frames of moving scenes").paragraph(format!(
        "{frames} frames at {fps} a second; what moves: {moves}; structures: {update}.{cut} {what} A round is a frame, after one pass to \
         warm up. Frame time is that of the update and of the traces of all waves by the host's clock, without shading and uploads; of several \
         frames the first, which builds, is not counted. Of all waves each counts by its rays. Three figures are median / 95th percentile / worst of the frames; jitter is the 95th percentile \
         over the median. *Shortest*: by ratios frame by frame, undecided where one's 99.9 % interval holds 1. *Turned*: of pairs of successive frames in which a surface point is seen, those whose answer along a direction \
         fixed in its triangle turns from right to wrong or back. The controls score what they must, else there would be no page."
    ));
    let scenes = section.scenes.iter().enumerate().map(|(place, scene)| {
        let head = Document::default().scene(2, &scene.scene, "").paragraph(format!(
            "Camera: {}. {} surface points.",
            literal(&scene.path),
            format::thousands(scene.points)
        ));
        let notes = scene.notes.iter().map(|note| literal(note));
        head.paragraphs(notes).and(section.works.iter().map(|work| of_work(record, section, place, work)))
    });
    page.and(over_all(section)).and(scenes).and(ranked(section)).and(summary::skipped(&record.skipped))
}

/// What a tracer comes to with a work in a scene.
struct Placed<'a> {
    shown: Shown<'a>,
    place: String,
    /// Its frames over the shortest.
    over: Option<f64>,
    /// The greatest interval of its frames over those of another that rebuilds, frame by frame, if it does.
    over_rebuilt: Option<[f64; 2]>,
}

impl Shown<'_> {
    fn rebuilds(&self) -> bool {
        let later = self.series.frames.get(1..).unwrap_or_default();
        !later.is_empty() && later.iter().all(|row| row.update == Update::Rebuild.name())
    }
}

fn placed<'a>(section: &'a FramesRecord, scene: usize, work: &'a str) -> Vec<(String, Placed<'a>)> {
    let of_tracers = shown(section, scene, work).into_iter().filter(|shown| !shown.series.is_control());
    let all: Vec<(Shown<'_>, Option<f64>)> = of_tracers.map(|shown| (shown, some_median(&shown.ms()))).collect();
    let least = all.iter().filter_map(|(_, ms)| *ms).reduce(f64::min);
    let over_rebuilt = |of: Shown<'_>| {
        let peers = all.iter().filter(|(peer, _)| peer.rebuilds() && !std::ptr::eq(peer.series, of.series));
        let ratios = peers.filter_map(|(peer, _)| Some(of_rounds(&of.ms(), &peer.ms(), COVERAGE)?.interval));
        ratios.filter(|_| of.rebuilds()).reduce(|[low, high], ratio| [low.max(ratio[0]), high.max(ratio[1])])
    };
    let place = format!("{}, {}", literal(&section.scenes[scene].scene.name), literal(work));
    let placed = |(shown, ms): &(Shown<'a>, Option<f64>)| Placed {
        shown: *shown,
        place: place.clone(),
        over: ms.zip(least).map(|(ms, least)| ms / least),
        over_rebuilt: over_rebuilt(*shown),
    };
    all.iter().map(|each| (each.0.series.tracer.label(), placed(each))).collect()
}

/// What every tracer comes to over several scenes or works.
fn over_all(section: &FramesRecord) -> Document {
    type Row<'a> = (String, Vec<Placed<'a>>);
    let rows: Vec<Row<'_>> = gathered(works(section).flat_map(|(scene, work)| placed(section, scene, work)));
    if section.scenes.len() * section.works.len() < 2 {
        return Document::default();
    }
    fn ends(all: &[Placed<'_>], of: impl Fn(&Placed<'_>) -> Option<f64>, digits: usize) -> Cell {
        let told = |value| (value, significant(value, digits), String::new());
        let all = all.iter().filter_map(|placed| Some((told(of(placed)?), placed.place.clone())));
        from_to(all).map_or(Cell::Absent, Cell::from)
    }
    let leads = |all: &[Placed<'_>]| {
        let over: Vec<[f64; 2]> = all.iter().filter_map(|placed| placed.over_rebuilt).collect();
        let count = |of: fn(&[f64; 2]) -> bool| over.iter().filter(|over| of(over)).count();
        let (leads, open) = (count(|[_, high]| *high < 1.0), count(|[low, high]| *low <= 1.0 && *high >= 1.0));
        let open = if open > 0 { format!(", undecided {open}") } else { String::new() };
        if over.is_empty() { Cell::None } else { format!("{leads} of {}{open}", over.len()).into() }
    };
    let sheet = Sheet::<Row<'_>>::new()
        .column("tracer", |(label, _)| label.clone())
        .column("updates", |(_, all)| all.iter().map(|placed| updates(placed.shown.series)).unique().join("; "))
        .column("frame over the shortest ↓", |(_, all)| ends(all, |placed| placed.over, 3))
        .column("shortest of those that rebuild", move |(_, all)| leads(all))
        .column("right within the footprint, all waves (%) ↑", |(_, all)| {
            ends(all, |placed| Some(100.0 * placed.shown.right(2, false)?), 4)
        })
        .column("FLIP, median ↓", |(_, all)| {
            ends(all, |placed| some_median(&placed.shown.of_images(|image| image.flip)), 3)
        });
    Document::default().heading(2, "Over all scenes and effects").table(sheet.table(&rows))
}

/// A work in a scene.
fn of_work(record: &Record, section: &FramesRecord, scene: usize, work: &str) -> Document {
    let all = shown(section, scene, work);
    let Some(first) = all.first() else { return Document::default() };
    let rays: u64 = first.rows().next().map_or(0, |(_, work)| work.waves.iter().map(|wave| wave.rays).sum());
    let heading = format!("{work}: {} rays in the first frame", format::thousands(rays));
    let tracers: Vec<Shown<'_>> = all.iter().copied().filter(|shown| !shown.series.is_control()).collect();
    let page =
        Document::default().headed(3, heading, Of { scene: None, rays: Some(work.to_owned()) }).table(overall(&all));
    let invalid = all.iter().find_map(|shown| shown.series.invalid.as_ref());
    let invalid = invalid.map(|why| format!("**Traces have no times**: their clock failed its control, as {why}."));
    let page = page.paragraphs(floors(&all).into_iter().chain(invalid));
    let page =
        if section.effects { page } else { page.below("Structures and answers of the last frame:", last(&tracers)) };
    if section.frames < 2 {
        return page;
    }
    let name = &section.scenes[scene].scene.name;
    let stem = format!("{STEM}{}_{}", format::file_stem(name), format::file_stem(work));
    let alt = format!("Frame time, wrong rays and errors of {work} in {name} over the frames");
    let page = page.chart(stem.clone(), alt, series(record, over_frames(section, name, work, &tracers)));
    let points = |of: &dyn Fn(&Shown<'_>) -> Vec<f64>| {
        let place = |shown: &Shown<'_>| {
            let (ms, errors) = (shown.ms(), of(shown));
            let label = shown.series.tracer.label();
            (!ms.is_empty() && !errors.is_empty()).then(|| (label, median(&ms), median(&errors)))
        };
        tracers.iter().filter_map(place).collect::<Vec<_>>()
    };
    let turned = ("turned (share)", points(&|shown| shown.turned().into_iter().collect()));
    let flip = ("FLIP", points(&|shown| shown.of_images(|image| image.flip)));
    let flicker = ("flicker of images", points(&|shown| shown.of_images(|image| image.flicker)));
    let of_images = [flip, flicker].into_iter().filter(|(_, points)| !points.is_empty());
    let all: Vec<Errors<'_>> = of_images.chain([turned]).collect();
    let titles = [
        format!("Frame time against errors: {work} in {name}"),
        "Medians of the frames; what is left and low is better".to_owned(),
    ];
    let alt = format!("Frame time against errors of {work} in {name}");
    page.chart(format!("{stem}_front"), alt, errors(record, titles, "frame time (ms)", &all))
}

/// How an error that is seen is told of a series: its name, itself, and whether more of it is worse.
type Seen = (&'static str, fn(&Shown<'_>) -> Option<f64>);

const SEEN: [Seen; 4] = [
    ("FLIP", |shown| some_median(&shown.of_images(|image| image.flip))),
    ("PSNR", |shown| some_median(&shown.of_images(|image| image.psnr_db)).map(|psnr| -psnr)),
    ("flicker of images", |shown| some_median(&shown.of_images(|image| image.flicker))),
    ("flicker of answers", |shown| shown.turned()),
];

fn some_median(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| median(values))
}

/// An error that is seen, a rule, and whether the share of wrong rays by it ranks tracers as that does: by scene, effect by effect, exact
/// tracers left out.
type Ranking<'a> = (&'static str, &'static str, Vec<(&'a str, f64)>);

fn rankings(section: &FramesRecord) -> Vec<Ranking<'_>> {
    let is_sampled = |shown: &Shown<'_>| {
        let TracerRecord { name, preset, changed, .. } = &shown.series.tracer;
        let improved = preset == "improved" && changed.is_empty();
        !shown.series.is_control() && registry::find(name).is_none_or(|known| !is_exact(known, improved))
    };
    let ranking = |((seen, error), (place, rule)): (Seen, (usize, Rule))| {
        let correlation = |(scene, work): (usize, &String)| {
            let all = shown(section, scene, work).into_iter().filter(is_sampled);
            let pairs = all.filter_map(|shown| Some([1.0 - shown.right(place, false)?, error(&shown)?]));
            Some((section.scenes[scene].scene.name.as_str(), rank_correlation(&pairs.collect_vec())?))
        };
        (seen, rule.name(), works(section).filter_map(correlation).collect_vec())
    };
    let errors = SEEN.into_iter().cartesian_product(Rule::ALL.into_iter().enumerate());
    errors.map(ranking).filter(|(.., each)| !each.is_empty()).collect()
}

fn ranked(section: &FramesRecord) -> Document {
    let values = |each: &[(&str, f64)]| each.iter().map(|(_, value)| *value).collect::<Vec<_>>();
    let scenes = |each: &[(&str, f64)]| {
        let of = |scene: &[(&str, f64)]| {
            format!("{}: {}", scene[0].0, scene.iter().map(|(_, value)| significant(*value, 2)).join(", "))
        };
        each.chunk_by(|one, next| one.0 == next.0).map(of).join("; ")
    };
    let sheet = Sheet::<Ranking<'_>>::new()
        .column("error", |(seen, ..)| *seen)
        .column("rule", |(_, rule, _)| *rule)
        .column("scenes and effects", |(.., each)| each.len() as u64)
        .column("rank correlation, median ↑", move |(.., each)| Cell::number(median(&values(each)), 2))
        .column("least", move |(.., each)| Cell::number(values(each).into_iter().reduce(f64::min), 2))
        .column("greatest", move |(.., each)| Cell::number(values(each).into_iter().reduce(f64::max), 2))
        .column("of effects", move |(.., each)| scenes(each));
    let rankings = rankings(section);
    if rankings.is_empty() {
        return Document::default();
    }
    Document::default()
        .heading(2, "Which errors are seen")
        .paragraph(
            "Spearman's rank correlation, across tracers that are not exact, of the share of wrong rays under each rule with what one would \
             see: 1 where the rule ranks them as the eye does.",
        )
        .table(sheet.table(&rankings))
}

/// What a tracer's frames come to.
fn overall(all: &[Shown<'_>]) -> Table {
    let right = |first: bool| {
        move |shown: &Shown<'_>| {
            let shares: Option<Vec<f64>> = (0..3).map(|rule| shown.right(rule, first)).collect();
            shares.map(|shares| shares.iter().map(|share| significant(100.0 * share, 4)).join(" / "))
        }
    };
    let waves = all.iter().flat_map(|shown| shown.rows()).map(|(_, work)| work.waves.len()).max().unwrap_or(0);
    let floor = all.iter().find(|shown| shown.series.tracer.name == ROUNDED_ORACLE).copied();
    let mut sheet = Sheet::<Shown<'_>>::new()
        .column("tracer", |shown| shown.series.tracer.label())
        .column("updates", |shown| updates(shown.series))
        .column("frame (ms) ↓", |shown| spread(&shown.ms(), 3))
        .column("jitter ↓", |shown| Cell::number(jitter(&shown.ms()), 3))
        .column(FIRST_BUILD.heading(), |shown| {
            Cell::number(shown.series.frames.first().and_then(|row| row.update_ms), 3)
        })
        .column("structure, begin / end / most, peak of builds (MiB) ↓", |shown| bytes(shown.series))
        .column("right, first wave (%): hit_miss / tight / footprint ↑", right(true));
    if waves > 1 {
        sheet = sheet.column("right, all waves (%) ↑", right(false));
    }
    if all.iter().any(|shown| shown.images().next().is_some()) {
        sheet = sheet
            .column("MSE ↓", |shown| spread(&shown.of_images(|image| Some(image.mse)), 3))
            .column("PSNR (dB), median ↑", |shown| {
                Cell::number(some_median(&shown.of_images(|image| image.psnr_db)), 4)
            })
            .column("SSIM, least ↑", |shown| Cell::number(shown.images().map(|image| image.ssim).reduce(f64::min), 5))
            .column("FLIP ↓", |shown| spread(&shown.of_images(|image| image.flip), 3))
            .column("pixels beyond 1/255 ↓", move |shown| beyond(shown, floor))
            .column("flicker of images ↓", |shown| spread(&shown.of_images(|image| image.flicker), 3));
    }
    if all.iter().any(|shown| !shown.series.changing.is_empty()) {
        sheet =
            sheet.column("rays right in some frames alone ↓", |shown| shown.series.changing.get(shown.work).copied());
    }
    sheet = sheet.column("turned (%) ↓", |shown| Cell::number(shown.turned().map(|share| 100.0 * share), 3));
    if all.iter().any(|shown| shown.series.pictures.contains_key(shown.work)) {
        let files = |of: &FramePictures| format!("{}, {}", of.sheet, of.animation);
        sheet =
            sheet.column("pictures/: sheet, animation", move |shown| shown.series.pictures.get(shown.work).map(files));
    }
    sheet.table(all)
}

/// The most pixels of a frame that differ visibly; of an exact tracer marked with the waves where more do than rounding explains: twice those
/// of the oracle with t in f32, and 0.02 % of all.
fn beyond(shown: &Shown<'_>, floor: Option<Shown<'_>>) -> Cell {
    let Some(most) = shown.images().map(|image| image.beyond).max() else { return Cell::None };
    let is_broken = shown.series.floor_holds == Some(false);
    let pairs = floor.iter().flat_map(|floor| shown.images().zip(floor.images()));
    let beyond = pairs.filter(|(image, floor)| is_broken && image.is_beyond(floor, shown.section.size));
    let waves: BTreeSet<&String> = beyond.flat_map(|(image, _)| image.beyond_by_wave.keys()).collect();
    let count = format::thousands(most);
    let marked = || format!("{count}, **beyond rounding**: {}", waves.iter().join(", "));
    if waves.is_empty() { count.as_str().into() } else { marked().into() }
}

/// Whose images are as near to the truth as rounding lets them be, of exact tracers in records that tell.
fn floors(all: &[Shown<'_>]) -> Option<String> {
    let [near, beyond] = [true, false].map(|holds| {
        let of = all.iter().filter(|shown| shown.series.floor_holds == Some(holds));
        of.map(|shown| shown.series.tracer.label()).join(", ")
    });
    let floor = format!(
        "at most twice the pixels beyond 1/255 of {ROUNDED_ORACLE}, and 0.02 % of all, wherever no structure is stale"
    );
    let beyond = (!beyond.is_empty()).then(|| format!("**Exact tracers without {floor}**: {beyond}."));
    let near = (!near.is_empty()).then(|| format!("Exact tracers with {floor}: {near}."));
    [beyond, near].into_iter().flatten().reduce(|beyond, near| format!("{beyond} {near}"))
}

/// How often a structure was brought up to date in which way, and by what it was stale.
fn updates(series: &FrameSeries) -> String {
    let updates = series.frames.iter().map(|row| (&row.update, ())).filter(|(update, ())| !update.is_empty());
    let told = gathered(updates).into_iter().map(|(update, times)| format!("{} {update}", times.len()));
    let stale: BTreeSet<&String> = series.frames.iter().flat_map(|row| &row.stale_by).collect();
    let moved = (!stale.is_empty()).then(|| format!("**stale**: moved {}", literal(&stale.iter().join(", "))));
    told.chain(moved).join("; ")
}

fn bytes(series: &FrameSeries) -> Cell {
    let ends = (series.frames.first(), series.frames.last(), series.is_control());
    let (Some(first), Some(last), false) = ends else { return Cell::Absent };
    let most = |of: fn(&FrameRow) -> u64| series.frames.iter().map(of).max().unwrap_or(0);
    let [most, peak] = [most(|row| row.structure_bytes), most(|row| row.build_peak_bytes)];
    let parts = [first.structure_bytes, last.structure_bytes, most].map(format::mib);
    format!("{}, {}", parts.join(" / "), format::mib(peak)).into()
}

/// Hashes and counts of the last frame.
fn last(tracers: &[Shown<'_>]) -> Table {
    let wave = |shown: &Shown<'_>| shown.rows().last().and_then(|(_, work)| work.waves.first().cloned());
    let counts = move |shown: &Shown<'_>| {
        let answers = wave(shown)?.answers?;
        Some(answers.counters.iter().map(|(name, total)| format!("{name} {total}")).join(", "))
    };
    let sheet = Sheet::<Shown<'_>>::new()
        .column("tracer", |shown| shown.series.tracer.label())
        .column("SAH cost ↓", |shown| Cell::number(shown.series.frames.last().and_then(|row| row.sah_cost), 5))
        .column("hits", move |shown| wave(shown).and_then(|wave| Some(format::hash_prefix(&wave.answers?.hits_sha256))))
        .column("counts", counts);
    sheet.table(tracers)
}

/// Time and errors over the frames.
fn over_frames(section: &FramesRecord, scene: &str, work: &str, tracers: &[Shown<'_>]) -> SeriesChart {
    let steps: Vec<String> = (0..section.frames).map(|frame| frame.to_string()).collect();
    let frames = section.frames as usize;
    let panel = |title: &str, quantity: &str, of: &dyn Fn(&FrameRow, &WorkRow) -> Option<f64>| {
        let line = |shown: &Shown<'_>| {
            let at = |frame: usize| {
                let row = shown.series.frames.get(frame)?;
                of(row, row.works.get(work)?)
            };
            Series { label: shown.series.tracer.label(), values: (0..frames).map(at).collect(), dashed: false }
        };
        SeriesPanel {
            title: title.to_owned(),
            setting: "frame".to_owned(),
            steps: steps.clone(),
            quantity: quantity.to_owned(),
            series: tracers.iter().map(line).collect(),
        }
    };
    let wrong = |_: &FrameRow, work: &WorkRow| {
        let wave = work.waves.first()?;
        (wave.judged > 0).then(|| 100.0 * (wave.judged - wave.right[2]) as f64 / wave.judged as f64)
    };
    let mut panels = vec![
        panel("frame time", "update and traces (ms)", &|row, _| row.ms(work)),
        panel("wrong rays", "wrong by footprint, first wave (%)", &wrong),
        panel("flicker of answers", "turned (%)", &|row, _| share(row.turned.into_iter()).map(|share| 100.0 * share)),
    ];
    if tracers.iter().any(|shown| shown.images().next().is_some()) {
        panels.push(panel("error", "FLIP", &|_, work| work.image.as_ref()?.flip));
        panels.push(panel("flicker of images", "mean change of the error", &|_, work| work.image.as_ref()?.flicker));
    }
    let title = format!("{work} over the frames of {scene}");
    SeriesChart { title, subtitle: "The first frame builds".to_owned(), key: None, panels }
}

impl ShownFrame<'_> {
    fn image(&self, of: fn(&ImageRow) -> Option<f64>) -> Option<f64> {
        of(self.work?.image.as_ref()?)
    }

    fn first_wave(&self, of: fn(&WaveRow) -> u64) -> Option<u64> {
        self.work?.waves.first().map(of)
    }

    fn all_waves(&self, of: fn(&WaveRow) -> u64) -> u64 {
        self.work.map_or(0, |work| work.waves.iter().map(of).sum())
    }
}

/// Every frame of every series.
fn every_frame(section: &FramesRecord) -> Table {
    let rows = works(section).flat_map(|(scene, work)| shown(section, scene, work)).flat_map(|shown| {
        let frames = (0..).zip(&shown.series.frames);
        frames.map(move |(number, row)| ShownFrame { shown, number, row, work: row.works.get(shown.work) })
    });
    let by_wave = |work: &WorkRow| {
        let told = |wave: &WaveRow| Some(format!("{}={}", wave.name, wave.trace_ms?));
        work.waves.iter().filter_map(told).join(" ")
    };
    let sheet = Sheet::<ShownFrame<'_>>::new()
        .csv_column("scene", |frame| section.scenes[frame.shown.series.scene as usize].scene.name.clone())
        .csv_column("work", |frame| frame.shown.work.to_owned())
        .csv_column("tracer", |frame| frame.shown.series.tracer.label())
        .csv_column("frame", |frame| frame.number)
        .csv_column("update", |frame| frame.row.update.clone())
        .csv_column("stale_by", |frame| frame.row.stale_by.join(" "))
        .csv_column("update_ms", |frame| frame.row.update_ms)
        .csv_column("grown", |frame| u64::from(frame.row.grown))
        .csv_column("trace_ms", |frame| frame.work?.waves.iter().map(|wave| wave.trace_ms).sum::<Option<f64>>())
        .csv_column("trace_ms_by_wave", move |frame| frame.work.map(by_wave).unwrap_or_default())
        .csv_column(STRUCTURE.name, |frame| frame.row.structure_bytes)
        .csv_column(BUILD_PEAK.name, |frame| frame.row.build_peak_bytes)
        .csv_column("sah_cost", |frame| frame.row.sah_cost)
        .csv_column("judged_first_wave", |frame| frame.first_wave(|wave| wave.judged))
        .csv_column("hit_miss_first_wave", |frame| frame.first_wave(|wave| wave.right[0]))
        .csv_column("tight_first_wave", |frame| frame.first_wave(|wave| wave.right[1]))
        .csv_column("footprint_first_wave", |frame| frame.first_wave(|wave| wave.right[2]))
        .csv_column("judged", |frame| frame.all_waves(|wave| wave.judged))
        .csv_column("hit_miss", |frame| frame.all_waves(|wave| wave.right[0]))
        .csv_column("tight", |frame| frame.all_waves(|wave| wave.right[1]))
        .csv_column("footprint", |frame| frame.all_waves(|wave| wave.right[2]))
        .csv_column("pairs", |frame| frame.row.turned.map(|[pairs, _]| pairs))
        .csv_column("turned", |frame| frame.row.turned.map(|[_, turned]| turned))
        .csv_column("mse", |frame| frame.image(|image| Some(image.mse)))
        .csv_column("psnr_db", |frame| frame.image(|image| image.psnr_db))
        .csv_column("ssim", |frame| frame.image(|image| Some(image.ssim)))
        .csv_column("flip", |frame| frame.image(|image| image.flip))
        .csv_column("pixels_beyond", |frame| Some(frame.work?.image.as_ref()?.beyond))
        .csv_column("flicker", |frame| frame.image(|image| image.flicker));
    sheet.table(&rows.collect_vec())
}
