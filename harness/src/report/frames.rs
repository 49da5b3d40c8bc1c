//! Frames: `frames.md`, a row a frame in `frames.csv`, and charts over frames.

use super::chart::series::{Series, SeriesChart, SeriesPanel, series};
use super::chart::{Drawing, scatter};
use super::document::{Document, Of};
use super::format::{self, significant};
use super::markdown::literal;
use super::sheet::{Cell, Sheet, Table};
use super::{Report, ReportError, Tables, summary};
use crate::registry;
use crate::results::{FrameRow, FrameSeries, FramesRecord, ImageRow, ROUNDED_ORACLE, Record, Rule, WaveRow, WorkRow};
use crate::statistics::{median, percentile, rank_correlation};

/// The page.
pub const FRAMES_PAGE: &str = "frames.md";

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
struct ShownFrame<'a>(Shown<'a>, usize);

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

    /// The share of rays that are right by the rule of a place, of the first wave or of all.
    pub(in crate::report) fn right(&self, rule: usize, first: bool) -> Option<f64> {
        let waves = self.rows().flat_map(|(_, work)| work.waves.iter().take(if first { 1 } else { usize::MAX }));
        let [right, judged] = waves.fold([0, 0], |sum, wave| [sum[0] + wave.right[rule], sum[1] + wave.judged]);
        (judged > 0).then(|| right as f64 / judged as f64)
    }

    /// The share of pairs of surface points that turned.
    pub(in crate::report) fn turned(&self) -> Option<f64> {
        share(self.series.frames.iter().filter_map(|row| row.turned))
    }

    pub(in crate::report) fn flip(&self) -> Vec<f64> {
        self.images().filter_map(|image| image.flip).collect()
    }

    pub(in crate::report) fn psnr(&self) -> Vec<f64> {
        self.images().filter_map(|image| image.psnr_db).collect()
    }

    pub(in crate::report) fn flicker(&self) -> Vec<f64> {
        self.images().filter_map(|image| image.flicker).collect()
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

/// All series of a scene with a work, controls first.
pub(in crate::report) fn shown<'a>(section: &'a FramesRecord, scene: usize, work: &'a str) -> Vec<Shown<'a>> {
    let of_scene = section.rows.iter().filter(|row| row.scene as usize == scene);
    let all = of_scene.map(|series| Shown { section, series, work });
    all.filter(|shown| shown.rows().next().is_some()).collect()
}

/// What is made of frames.
pub(super) fn report(record: &Record, _: Tables) -> Result<Report, ReportError> {
    let Some(section) = &record.frames else { return Ok(Report::default()) };
    let page = Report::of_page(FRAMES_PAGE, page(record, section));
    Ok(Report { tables: vec![(FRAMES_TABLE.to_owned(), every_frame(section))], ..page })
}

fn page(record: &Record, section: &FramesRecord) -> Document {
    let FramesRecord { frames, fps, size: [width, height], spp, moves, update, paths, .. } = section;
    let what = match section.effects {
        true => format!(
            "Effects are rendered at {width}x{height} with {spp} samples a pixel; paths go on from {paths} hits."
        ),
        false => "Ray sets are traced anew in every frame.".to_owned(),
    };
    let what = if section.fixed_rays {
        "Every frame has the world rays of the first, judged from its eye.".to_owned()
    } else {
        what
    };
    let cut = section.cut.map_or_else(String::new, |cut| format!(" The camera jumps in frame {cut}."));
    let page = summary::head(record, "Frames of moving scenes").paragraph(format!(
        "{frames} frames at {fps} a second; what moves: {moves}; structures: {update}.{cut} {what} A round is a frame, after one pass to \
         warm up. Frame time is the update by the host's clock and the traces of all waves, without shading and uploads; of the first frame, \
         which builds, it is not counted. Three figures are median / 95th percentile / worst of the frames; jitter is the 95th percentile \
         over the median. *Turned*: of pairs of successive frames in which a surface point is seen, those whose answer along a direction \
         fixed in its triangle turns from right to wrong or back. The controls score what they must, else there would be no page."
    ));
    let scenes = section.scenes.iter().enumerate().map(|(place, scene)| {
        let head = Document::default().scene(2, &scene.scene, "").paragraph(format!(
            "Camera: {}. {} surface points.",
            literal(&scene.path),
            format::thousands(scene.points)
        ));
        let notes = scene.notes.iter().map(|note| Document::of(literal(note)));
        head.and(notes).and(section.works.iter().map(|work| of_work(record, section, place, work)))
    });
    page.and(scenes).and(ranked(section)).and(summary::skipped(&record.skipped))
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
    let page =
        if section.effects { page } else { page.below("Structures and answers of the last frame:", last(&tracers)) };
    if section.frames < 2 {
        return page;
    }
    let name = &section.scenes[scene].scene.name;
    let stem = format!("{STEM}{}_{}", format::file_stem(name), format::file_stem(work));
    let alt = format!("Frame time, wrong rays and errors of {work} in {name} over the frames");
    let page = page.chart(stem.clone(), alt, series(record, over_frames(section, name, work, &tracers, stem.clone())));
    let points = |of: &dyn Fn(&Shown<'_>) -> Vec<f64>| {
        let place = |shown: &Shown<'_>| {
            let (ms, errors) = (shown.ms(), of(shown));
            let label = shown.series.tracer.label();
            (!ms.is_empty() && !errors.is_empty()).then(|| (label, median(&ms), median(&errors)))
        };
        tracers.iter().filter_map(place).collect::<Vec<_>>()
    };
    let turned = ("turned (share)", points(&|shown| shown.turned().into_iter().collect()));
    let of_images = [("FLIP", points(&|shown| shown.flip())), ("flicker of images", points(&|shown| shown.flicker()))];
    let errors: Vec<scatter::Errors<'_>> =
        of_images.into_iter().filter(|(_, points)| !points.is_empty()).chain([turned]).collect();
    let titles = [
        format!("Frame time against errors: {work} in {name}"),
        "Medians of the frames; what is left and low is better".to_owned(),
    ];
    let chart = scatter::chart(record, titles, "frame time (ms)", &errors);
    page.chart(
        format!("{stem}_front"),
        format!("Frame time against errors of {work} in {name}"),
        Drawing::Panels(chart),
    )
}

/// How an error that is seen is told of a series: its name, itself, and whether more of it is worse.
type Seen = (&'static str, fn(&Shown<'_>) -> Option<f64>);

const SEEN: [Seen; 4] = [
    ("FLIP", |shown| some_median(&shown.flip())),
    ("PSNR", |shown| some_median(&shown.psnr()).map(|psnr| -psnr)),
    ("flicker of images", |shown| some_median(&shown.flicker())),
    ("flicker of answers", |shown| shown.turned()),
];

fn some_median(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| median(values))
}

/// Whether the share of wrong rays by a rule ranks tracers as an error that is seen does: by scene and effect, exact tracers left out.
struct Ranking {
    seen: &'static str,
    rule: &'static str,
    /// By scene and effect.
    correlations: Vec<f64>,
}

fn rankings(section: &FramesRecord) -> Vec<Ranking> {
    let is_sampled = |shown: &Shown<'_>| {
        let known = registry::find(&shown.series.tracer.name);
        !shown.series.is_control() && known.is_none_or(|registration| !registration.is_analytic())
    };
    let mut rankings = Vec::new();
    for (seen, error) in SEEN {
        for (place, rule) in Rule::ALL.into_iter().enumerate() {
            let all = (0..section.scenes.len())
                .flat_map(|scene| section.works.iter().map(move |work| shown(section, scene, work)));
            let correlation = |shown: Vec<Shown<'_>>| {
                let pairs: Vec<[f64; 2]> = shown
                    .iter()
                    .filter(|shown| is_sampled(shown))
                    .filter_map(|shown| Some([1.0 - shown.right(place, false)?, error(shown)?]))
                    .collect();
                rank_correlation(&pairs)
            };
            rankings.push(Ranking { seen, rule: rule.name(), correlations: all.filter_map(correlation).collect() });
        }
    }
    rankings.retain(|ranking| !ranking.correlations.is_empty());
    rankings
}

fn ranked(section: &FramesRecord) -> Document {
    let sheet = Sheet::<Ranking>::new()
        .column("error", |ranking| ranking.seen)
        .column("rule", |ranking| ranking.rule)
        .column("scenes and effects", |ranking| ranking.correlations.len() as u64)
        .column("rank correlation, median ↑", |ranking| Cell::number(median(&ranking.correlations), 2))
        .column("least", |ranking| Cell::number(ranking.correlations.iter().copied().reduce(f64::min), 2))
        .column("greatest", |ranking| Cell::number(ranking.correlations.iter().copied().reduce(f64::max), 2))
        .column("each", |ranking| {
            ranking.correlations.iter().map(|one| significant(*one, 2)).collect::<Vec<_>>().join(", ")
        });
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
            shares
                .map(|shares| shares.iter().map(|share| significant(100.0 * share, 4)).collect::<Vec<_>>().join(" / "))
        }
    };
    let waves = all.iter().flat_map(|shown| shown.rows()).map(|(_, work)| work.waves.len()).max().unwrap_or(0);
    let floor = all.iter().find(|shown| shown.series.tracer.name == ROUNDED_ORACLE).copied();
    let mut sheet = Sheet::<Shown<'_>>::new()
        .column("tracer", |shown| shown.series.tracer.label())
        .column("updates", |shown| updates(shown.series))
        .column("clock", |shown| shown.series.clock.map_or("", format::clock).to_owned())
        .column("frame (ms) ↓", |shown| spread(&shown.ms(), 3))
        .column("jitter ↓", |shown| Cell::number(jitter(&shown.ms()), 3))
        .column(super::metrics::FIRST_BUILD.heading(), |shown| {
            Cell::number(shown.series.frames.first().and_then(|row| row.update_ms), 3)
        })
        .column("structure, begin / end / most, peak of builds (MiB) ↓", |shown| bytes(shown.series))
        .column("right, first wave (%): hit_miss / tight / footprint ↑", right(true));
    if waves > 1 {
        sheet = sheet.column("right, all waves (%) ↑", right(false));
    }
    if all.iter().any(|shown| shown.images().next().is_some()) {
        sheet = sheet
            .column("MSE ↓", |shown| spread(&shown.images().map(|image| image.mse).collect::<Vec<_>>(), 3))
            .column("PSNR (dB), median ↑", |shown| {
                Cell::number((!shown.psnr().is_empty()).then(|| median(&shown.psnr())), 4)
            })
            .column("SSIM, least ↑", |shown| Cell::number(shown.images().map(|image| image.ssim).reduce(f64::min), 5))
            .column("FLIP ↓", |shown| spread(&shown.flip(), 3))
            .column("pixels beyond 1/255 ↓", move |shown| beyond(shown, floor))
            .column("flicker of images ↓", |shown| spread(&shown.flicker(), 3));
    }
    if all.iter().any(|shown| !shown.series.changing.is_empty()) {
        sheet =
            sheet.column("rays right in some frames alone ↓", |shown| shown.series.changing.get(shown.work).copied());
    }
    sheet = sheet.column("turned (%) ↓", |shown| Cell::number(shown.turned().map(|share| 100.0 * share), 3));
    sheet.table(all)
}

/// The most pixels of a frame that differ visibly; of an exact tracer marked with the waves where more do than rounding explains: twice those
/// of the oracle with t in f32, and 0.02 % of all.
fn beyond(shown: &Shown<'_>, floor: Option<Shown<'_>>) -> Cell {
    let Some(most) = shown.images().map(|image| image.beyond).max() else { return Cell::None };
    let is_exact = registry::find(&shown.series.tracer.name).is_some_and(|registration| registration.is_analytic());
    let [width, height] = shown.section.size;
    let allowed = |floor: &ImageRow| 2.0 * floor.beyond as f64 + 2e-4 * f64::from(width) * f64::from(height);
    let pairs = floor.iter().flat_map(|floor| shown.images().zip(floor.images()));
    let mut waves: Vec<&str> = pairs
        .filter(|(image, floor)| is_exact && image.beyond as f64 > allowed(floor))
        .flat_map(|(image, _)| image.beyond_by_wave.keys().map(String::as_str))
        .collect();
    waves.sort_unstable();
    waves.dedup();
    let count = format::thousands(most);
    if waves.is_empty() { count.into() } else { format!("{count}, **beyond rounding**: {}", waves.join(", ")).into() }
}

/// How often a structure was brought up to date in which way, and by what it was stale.
fn updates(series: &FrameSeries) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for row in series.frames.iter().filter(|row| !row.update.is_empty()) {
        match counts.iter_mut().find(|(update, _)| *update == row.update) {
            Some((_, count)) => *count += 1,
            None => counts.push((&row.update, 1)),
        }
    }
    let mut told: Vec<String> = counts.into_iter().map(|(update, count)| format!("{count} {update}")).collect();
    let stale: std::collections::BTreeSet<&String> = series.frames.iter().flat_map(|row| &row.stale_by).collect();
    if !stale.is_empty() {
        let moved = stale.into_iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        told.push(format!("**stale**: moved {}", literal(&moved)));
    }
    told.join("; ")
}

fn bytes(series: &FrameSeries) -> Cell {
    let [Some(first), Some(last)] = [series.frames.first(), series.frames.last()] else { return Cell::Absent };
    let most = |of: fn(&FrameRow) -> u64| series.frames.iter().map(of).max().unwrap_or(0);
    let [most, peak] = [most(|row| row.structure_bytes), most(|row| row.build_peak_bytes)];
    if series.is_control() {
        return Cell::Absent;
    }
    let parts = [first.structure_bytes, last.structure_bytes, most].map(format::mib);
    format!("{}, {}", parts.join(" / "), format::mib(peak)).into()
}

/// Hashes and counts of the last frame.
fn last(tracers: &[Shown<'_>]) -> Table {
    let wave = |shown: &Shown<'_>| shown.rows().last().and_then(|(_, work)| work.waves.first().cloned());
    let counts = move |shown: &Shown<'_>| {
        let answers = wave(shown)?.answers?;
        Some(answers.counters.iter().map(|(name, total)| format!("{name} {total}")).collect::<Vec<_>>().join(", "))
    };
    let sheet = Sheet::<Shown<'_>>::new()
        .column("tracer", |shown| shown.series.tracer.label())
        .column("SAH cost ↓", |shown| Cell::number(shown.series.frames.last().and_then(|row| row.sah_cost), 5))
        .column("hits", move |shown| wave(shown).and_then(|wave| Some(format::hash_prefix(&wave.answers?.hits_sha256))))
        .column("counts", counts);
    sheet.table(tracers)
}

/// Time and errors over the frames.
fn over_frames(section: &FramesRecord, scene: &str, work: &str, tracers: &[Shown<'_>], stem: String) -> SeriesChart {
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
            of: None,
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
    SeriesChart { stem, title, subtitle: "The first frame builds".to_owned(), key: None, panels }
}

/// Every frame of every series.
fn every_frame(section: &FramesRecord) -> Table {
    let all = (0..section.scenes.len())
        .flat_map(|scene| section.works.iter().flat_map(move |work| shown(section, scene, work)));
    let rows: Vec<ShownFrame<'_>> =
        all.flat_map(|shown| (0..shown.series.frames.len()).map(move |frame| ShownFrame(shown, frame))).collect();
    fn row<'a>(frame: &ShownFrame<'a>) -> &'a FrameRow {
        &frame.0.series.frames[frame.1]
    }
    fn work<'a>(frame: &ShownFrame<'a>) -> Option<&'a WorkRow> {
        row(frame).works.get(frame.0.work)
    }
    fn image(frame: &ShownFrame<'_>, of: fn(&ImageRow) -> Option<f64>) -> Option<f64> {
        work(frame)?.image.as_ref().and_then(of)
    }
    fn all_waves(frame: &ShownFrame<'_>, of: fn(&WaveRow) -> u64) -> u64 {
        work(frame).map_or(0, |work| work.waves.iter().map(of).sum())
    }
    let first = |frame: &ShownFrame<'_>, of: fn(&WaveRow) -> u64| work(frame)?.waves.first().map(of);
    let sheet = Sheet::<ShownFrame<'_>>::new()
        .csv_column("scene", |frame| frame.0.section.scenes[frame.0.series.scene as usize].scene.name.clone())
        .csv_column("work", |frame| frame.0.work.to_owned())
        .csv_column("tracer", |frame| frame.0.series.tracer.label())
        .csv_column("frame", |frame| frame.1 as u64)
        .csv_column("update", |frame| row(frame).update.clone())
        .csv_column("stale_by", |frame| row(frame).stale_by.join(" "))
        .csv_column("update_ms", |frame| row(frame).update_ms)
        .csv_column("grown", |frame| u64::from(row(frame).grown))
        .csv_column("trace_ms", |frame| {
            let waves = &work(frame)?.waves;
            waves.iter().map(|wave| wave.trace_ms).sum::<Option<f64>>()
        })
        .csv_column("trace_ms_by_wave", |frame| {
            let told = |wave: &WaveRow| Some(format!("{}={}", wave.name, wave.trace_ms?));
            work(frame)
                .map_or_else(String::new, |work| work.waves.iter().filter_map(told).collect::<Vec<_>>().join(" "))
        })
        .csv_column(super::metrics::STRUCTURE.name, |frame| row(frame).structure_bytes)
        .csv_column(super::metrics::BUILD_PEAK.name, |frame| row(frame).build_peak_bytes)
        .csv_column("sah_cost", |frame| row(frame).sah_cost)
        .csv_column("judged_first_wave", move |frame| first(frame, |wave| wave.judged))
        .csv_column("hit_miss_first_wave", move |frame| first(frame, |wave| wave.right[0]))
        .csv_column("tight_first_wave", move |frame| first(frame, |wave| wave.right[1]))
        .csv_column("footprint_first_wave", move |frame| first(frame, |wave| wave.right[2]))
        .csv_column("judged", |frame| all_waves(frame, |wave| wave.judged))
        .csv_column("hit_miss", |frame| all_waves(frame, |wave| wave.right[0]))
        .csv_column("tight", |frame| all_waves(frame, |wave| wave.right[1]))
        .csv_column("footprint", |frame| all_waves(frame, |wave| wave.right[2]))
        .csv_column("pairs", |frame| row(frame).turned.map(|[pairs, _]| pairs))
        .csv_column("turned", |frame| row(frame).turned.map(|[_, turned]| turned))
        .csv_column("mse", |frame| image(frame, |image| Some(image.mse)))
        .csv_column("psnr_db", |frame| image(frame, |image| image.psnr_db))
        .csv_column("ssim", |frame| image(frame, |image| Some(image.ssim)))
        .csv_column("flip", |frame| image(frame, |image| image.flip))
        .csv_column("pixels_beyond", |frame| work(frame)?.image.as_ref().map(|image| image.beyond))
        .csv_column("flicker", |frame| image(frame, |image| image.flicker));
    sheet.table(&rows)
}
