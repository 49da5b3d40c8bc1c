//! The structure's buffers: one of a kind for all views, or one a view where one binding does not hold all.

use std::ops::Range;

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_kit::{EmptyTarget, PrefixSum, PrefixSumPlan, RasterBackend, ReadSlot, storage_buffer};

use crate::layout::{Layout, PAYLOAD_WORDS, Placed};

pub(crate) const HINT: &str =
    "--face-size, --frame-size or fragment-abuffer.buckets, or choose fewer fragment-abuffer.views or layers";

/// What ledgers call the buffers.
const IDS: &str = "id buffer";
const PAYLOADS: &str = "data buffer";
const TAKEN: &str = "fragment counts";
const PYRAMID: &str = "depth pyramid";
const TARGETS: [&str; 2] = ["attachment of the camera's view", "attachment of the faces"];

/// The buffers of some views.
#[derive(Clone)]
pub(crate) struct Part {
    /// The views.
    pub views: Range<usize>,
    /// First pixel of each of them.
    pub first_pixels: Vec<u32>,
    pub pixel_count: u32,
    /// Words of pixels.
    pub pixels: Buffer,
    /// Nodes.
    pub ids: Buffer,
    /// What shading needs of fragments; none where nodes have it.
    pub payloads: Option<Buffer>,
    /// Fragments, lists that could not be ordered.
    pub taken: Buffer,
    /// Of the s-buffer, the prefix sum over where pixels' pieces begin.
    pub begins: Option<PrefixSumPlan>,
    /// Nodes that there is room for.
    pub capacity: u32,
    suffix: String,
}

/// What a build left in a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Taken {
    /// Fragments that were drawn.
    pub fragments: u32,
    /// Lists that the driver did not let be ordered.
    pub unordered: u32,
}

/// All buffers.
#[derive(Clone)]
pub(crate) struct Parts {
    pub parts: Vec<Part>,
    /// Depth bounds above the pixels', every view; none without Hi-Z.
    pub pyramid: Option<Buffer>,
    targets: Vec<EmptyTarget>,
}

fn storage(gpu: &Gpu, name: &str, bytes: u64) -> Result<Buffer, TracerError> {
    storage_buffer(gpu, name, bytes, HINT)
}

impl Part {
    fn new(
        gpu: &Gpu,
        sums: &PrefixSum,
        layout: &Layout,
        views: Range<usize>,
        capacity: u32,
    ) -> Result<Self, TracerError> {
        let whole = views.len() == layout.views.len();
        let suffix = if whole { String::new() } else { view_suffix(views.start) };
        let mut first_pixels = Vec::with_capacity(views.len());
        let mut pixel_count = 0_u64;
        for view in views.clone() {
            first_pixels.push(pixel_count as u32);
            pixel_count += layout.pixels_of(view);
        }
        let bytes = pixel_count * u64::from(layout.pixel_words()) * 4;
        let pixels = storage(gpu, &format!("{}{suffix}", layout.pixels_name()), bytes)?;
        let pixel_count = pixel_count as u32;
        let begins = match layout.kind.is_contiguous() {
            true => Some(sums.plan(gpu, &pixels, pixel_count, None)?),
            false => None,
        };
        let (ids, payloads) = nodes(gpu, layout, &suffix, capacity)?;
        let taken = storage(gpu, &format!("{TAKEN}{suffix}"), 8)?;
        Ok(Self { views, first_pixels, pixel_count, pixels, ids, payloads, taken, begins, capacity, suffix })
    }

    /// What the last build left.
    pub(crate) fn taken(&self, gpu: &Gpu) -> Result<Taken, TracerError> {
        let read: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&self.taken, 8)?);
        Ok(Taken { fragments: read[0], unordered: read[1] })
    }

    /// Where what shading needs of fragments is read.
    pub(crate) fn data(&self) -> &Buffer {
        self.payloads.as_ref().unwrap_or(&self.ids)
    }
}

/// What the names of a view's own buffers end with.
pub(crate) fn view_suffix(view: usize) -> String {
    format!(", view {}", view + 1)
}

/// Whether the device can bind so many nodes at once, and what shading needs of them.
pub(crate) fn check_nodes(gpu: &Gpu, layout: &Layout, suffix: &str, count: u32) -> Result<(), TracerError> {
    let bytes = |words: u32| u64::from(count.max(1)) * u64::from(words) * 4;
    gpu.check_storage_binding(&format!("{IDS}{suffix}"), bytes(layout.node_words()), HINT)?;
    let data = if layout.decoupled { bytes(PAYLOAD_WORDS) } else { 0 };
    gpu.check_storage_binding(&format!("{PAYLOADS}{suffix}"), data, HINT)
}

/// Buffers for so many nodes.
fn nodes(gpu: &Gpu, layout: &Layout, suffix: &str, capacity: u32) -> Result<(Buffer, Option<Buffer>), TracerError> {
    let nodes = u64::from(capacity.max(1));
    let ids = storage(gpu, &format!("{IDS}{suffix}"), nodes * u64::from(layout.node_words()) * 4)?;
    let payloads = match layout.decoupled {
        true => Some(storage(gpu, &format!("{PAYLOADS}{suffix}"), nodes * u64::from(PAYLOAD_WORDS) * 4)?),
        false => None,
    };
    Ok((ids, payloads))
}

impl Parts {
    /// Buffers without room for fragments, one of a kind or one a view.
    pub(crate) fn new(gpu: &Gpu, sums: &PrefixSum, layout: &Layout, by_view: bool) -> Result<Self, TracerError> {
        let views = layout.views.len();
        let ranges: Vec<Range<usize>> = match by_view {
            true => (0..views).map(|view| view..view + 1).collect(),
            false => std::iter::once(0..views).collect(),
        };
        let parts = ranges.into_iter().map(|views| Part::new(gpu, sums, layout, views, 0));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        let pyramid = match layout.pyramid_bytes() {
            0 => None,
            bytes => Some(storage(gpu, PYRAMID, bytes)?),
        };
        let mut targets = Vec::new();
        for (view, name) in [(0, TARGETS[usize::from(!layout.has_camera)]), (1, TARGETS[1])] {
            let is_drawn = view < views && (view == 0 || layout.has_camera);
            if is_drawn && layout.raster_backend == RasterBackend::Raster {
                targets.push(EmptyTarget::new(gpu, name, layout.views[view].size)?);
            }
        }
        Ok(Self { parts, pyramid, targets })
    }

    /// Makes room for so many nodes in every part.
    pub(crate) fn set_capacities(&mut self, gpu: &Gpu, layout: &Layout, nodes_of: &[u32]) -> Result<(), TracerError> {
        let made: Result<Vec<_>, _> =
            self.parts.iter().zip(nodes_of).map(|(part, count)| nodes(gpu, layout, &part.suffix, *count)).collect();
        for ((part, count), (ids, payloads)) in self.parts.iter_mut().zip(nodes_of).zip(made?) {
            (part.ids, part.payloads, part.capacity) = (ids, payloads, *count);
        }
        Ok(())
    }

    /// What the last build left in every part.
    pub(crate) fn taken(&self, gpu: &Gpu) -> Result<Vec<Taken>, TracerError> {
        self.parts.iter().map(|part| part.taken(gpu)).collect()
    }

    /// Whether views have buffers of their own.
    pub(crate) fn is_by_view(&self) -> bool {
        self.parts.len() > 1
    }

    /// The part of a view.
    pub(crate) fn of_view(&self, view: usize) -> &Part {
        &self.parts[view.min(self.parts.len() - 1)]
    }

    /// Where every view lies.
    pub(crate) fn placed(&self) -> Vec<Placed> {
        let mut placed = Vec::new();
        let mut first_node = 0;
        let first_words = |buffer: &dyn Fn(&Part) -> &Buffer| {
            ReadSlot::Words0.first_records(self.parts.iter().map(|part| buffer(part).size()))
        };
        let begins =
            [first_words(&|part| &part.pixels), first_words(&|part| &part.ids), first_words(&|part| part.data())];
        for (number, part) in self.parts.iter().enumerate() {
            let [pixels, ids, data] = begins.each_ref().map(|words| words[number]);
            let of_view = |first_pixel: &u32| Placed {
                first_pixel: *first_pixel,
                first_node,
                pixel_count: part.pixel_count,
                node_capacity: part.capacity,
                begins: [pixels, ids, data, 0],
            };
            placed.extend(part.first_pixels.iter().map(of_view));
            first_node += part.capacity;
        }
        placed
    }

    /// Nodes that there is room for in all.
    pub(crate) fn capacity(&self) -> u64 {
        self.parts.iter().map(|part| u64::from(part.capacity)).sum()
    }

    /// The attachment of a view's passes; none where there is no rasterizer.
    pub(crate) fn target(&self, view: usize) -> Option<&EmptyTarget> {
        self.targets.get(view).or(self.targets.last())
    }

    /// Enters every part; `taken` is what the last build left.
    pub(crate) fn enter(&self, layout: &Layout, taken: &[Taken], ledger: &mut Ledger) {
        for (part, taken) in self.parts.iter().zip(taken) {
            let used = u64::from(taken.fragments.min(part.capacity));
            let mut keep = |name: &str, buffer: &Buffer, used_bytes: u64| {
                ledger.keep(&format!("{name}{}", part.suffix), buffer.size(), used_bytes);
            };
            keep(&layout.pixels_name(), &part.pixels, part.pixels.size());
            keep(IDS, &part.ids, used * u64::from(layout.node_words()) * 4);
            if let Some(payloads) = &part.payloads {
                keep(PAYLOADS, payloads, used * u64::from(PAYLOAD_WORDS) * 4);
            }
            keep(TAKEN, &part.taken, part.taken.size());
            if let Some(begins) = &part.begins {
                begins.enter(ledger);
            }
        }
        if let Some(pyramid) = &self.pyramid {
            ledger.keep(PYRAMID, pyramid.size(), pyramid.size());
        }
        for target in &self.targets {
            target.enter(ledger);
        }
    }
}
