//! Bounds-checked accessors: where the bytes are is checked once, then elements are read one by one.
//!
//! Nothing is decoded ahead, so an accessor costs no memory beyond its buffer, whatever count it claims.

use std::cell::Cell;

use gltf::json::accessor::ComponentType::{self, F32, I8, I16, U8, U16, U32};
use gltf::json::accessor::Type;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, buffer};

use super::buffers::Bytes;

/// Most elements of an accessor that has no data: such an accessor is all zeros and can claim any count.
const MAX_ELEMENTS_WITHOUT_DATA: u64 = 10_000_000;

/// Most elements that are read only to be checked, over all accessors: many may share the same bytes.
const MAX_CHECKED: u64 = 200_000_000;

/// An accessor whose elements are known to lie within their buffers.
pub(super) struct Accessor {
    /// None if every element is zero.
    data: Option<Span>,
    component: ComponentType,
    normalized: bool,
    count: usize,
    /// Components of an element, at least 1.
    width: usize,
    sparse: Option<Sparse>,
}

/// Where elements lie: from byte `start` of a buffer on.
struct Span {
    bytes: Bytes,
    start: usize,
    stride: usize,
}

/// Elements that replace others, whose numbers strictly increase.
struct Sparse {
    indices: Span,
    component: ComponentType,
    count: usize,
    /// The replacements, without gaps.
    values: Span,
}

/// A kind of elements: its plural, the shape of an element, the types that its components may have.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Kind(&'static str, Type, &'static [ComponentType]);

const QUANTIZED: &[ComponentType] = &[F32, I8, I16, U8, U16];

impl Kind {
    /// Also displacements of positions.
    pub(super) const POSITION: Self = Self("positions", Type::Vec3, QUANTIZED);
    pub(super) const INDEX: Self = Self("indices", Type::Scalar, &[U8, U16, U32]);
    pub(super) const JOINTS: Self = Self("joints", Type::Vec4, &[U8, U16]);
    pub(super) const JOINT_WEIGHTS: Self = Self("weights of joints", Type::Vec4, &[F32, U8, U16]);
    pub(super) const MATRIX: Self = Self("matrices", Type::Mat4, &[F32]);
    pub(super) const TIME: Self = Self("times", Type::Scalar, &[F32]);
    pub(super) const VECTOR: Self = Self("translations or scales", Type::Vec3, &[F32]);
    pub(super) const ROTATION: Self = Self("rotations", Type::Vec4, QUANTIZED);
    pub(super) const MORPH_WEIGHT: Self = Self("weights of morph targets", Type::Scalar, QUANTIZED);
}

/// Buffers that accessor `index` reads.
pub(super) fn buffers_of(root: &Root, index: usize) -> Vec<usize> {
    let Some(accessor) = root.accessors.get(index) else {
        return Vec::new();
    };
    let mut views: Vec<_> = accessor.buffer_view.iter().collect();
    if let Some(sparse) = &accessor.sparse {
        views.push(&sparse.indices.buffer_view);
        views.push(&sparse.values.buffer_view);
    }
    views.into_iter().filter_map(|view| root.get(*view)).map(|view| view.buffer.value()).collect()
}

/// Opens the accessors of a document whose buffers are loaded.
pub(super) struct Accessors<'a> {
    pub(super) root: &'a Root,
    buffers: Vec<Bytes>,
    checked: Cell<u64>,
}

impl<'a> Accessors<'a> {
    /// Nothing is checked yet.
    pub(super) fn new(root: &'a Root, buffers: Vec<Bytes>) -> Self {
        Self { root, buffers, checked: Cell::new(0) }
    }

    /// Notes that `elements` are about to be read to check them; refuses where that gets out of hand.
    pub(super) fn charge(&self, elements: u64) -> Result<(), String> {
        self.checked.set(self.checked.get().saturating_add(elements));
        if self.checked.get() > MAX_CHECKED {
            return Err(format!(
                "its sparse parts and keys come to more than {MAX_CHECKED} over all accessors, which is too much"
            ));
        }
        Ok(())
    }

    /// Checks accessor `index` against its views and buffers.
    pub(super) fn open(&self, index: usize, kind: Kind) -> Result<Accessor, String> {
        let accessor = self.root.accessors.get(index).ok_or_else(|| format!("there is no accessors[{index}]"))?;
        let (Checked::Valid(component), Checked::Valid(shape)) = (accessor.component_type, accessor.type_) else {
            return Err(format!("accessors[{index}] has an unknown type"));
        };
        let component = component.0;
        let Kind(plural, wanted, components) = kind;
        if shape != wanted || !components.contains(&component) {
            return Err(format!("accessors[{index}] holds {component:?} {shape:?}, not {plural}"));
        }
        let width = shape.multiplicity();
        let element_size = component.size() * width;
        let claimed = accessor.count.0;
        let data = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                let span = self.span(view, offset, claimed, element_size);
                Some(span.map_err(|problem| format!("accessors[{index}] {problem}"))?)
            }
            None if claimed > MAX_ELEMENTS_WITHOUT_DATA => {
                return Err(format!(
                    "accessors[{index}] claims {claimed} elements without data, more than {MAX_ELEMENTS_WITHOUT_DATA}"
                ));
            }
            None => None,
        };
        let sparse = accessor.sparse.as_ref().map(|sparse| self.open_sparse(sparse, claimed, element_size));
        let sparse =
            sparse.transpose().map_err(|problem| format!("the sparse part of accessors[{index}] {problem}"))?;
        let count = usize::try_from(claimed).map_err(|_| format!("accessors[{index}] claims {claimed} elements"))?;
        Ok(Accessor { data, component, normalized: accessor.normalized, count, width, sparse })
    }

    /// As [`Self::open`], of an accessor that need not be there.
    pub(super) fn open_some<T>(&self, index: Option<Index<T>>, kind: Kind) -> Result<Option<Accessor>, String> {
        index.map(|index| self.open(index.value(), kind)).transpose()
    }

    /// Where `count` elements lie, all of them within their buffer.
    fn span(&self, view: Index<buffer::View>, offset: u64, count: u64, element_size: usize) -> Result<Span, String> {
        let number = view.value();
        let view = self.root.get(view).ok_or_else(|| format!("names bufferViews[{number}], which does not exist"))?;
        let stride = view.byte_stride.map_or(element_size, |stride| stride.0);
        if stride < element_size {
            return Err(format!("has elements of {element_size} bytes and bufferViews[{number}] a stride of {stride}"));
        }
        let bytes = self.buffers.get(view.buffer.value()).cloned().unwrap_or_default();
        let view_start = view.byte_offset.unwrap_or_default().0;
        let view_end = view_start.checked_add(view.byte_length.0);
        if view_end.is_none_or(|end| end > bytes.len() as u64) {
            return Err(format!(
                "reads bufferViews[{number}], which needs {} bytes from byte {view_start} on, and buffers[{}] has {}",
                view.byte_length.0,
                view.buffer,
                bytes.len()
            ));
        }
        let needed = if count == 0 {
            Some(0)
        } else {
            (count - 1)
                .checked_mul(stride as u64)
                .and_then(|bytes| bytes.checked_add(element_size as u64))
                .and_then(|bytes| bytes.checked_add(offset))
        };
        if needed.is_none_or(|needed| needed > view.byte_length.0) {
            return Err(format!(
                "has {count} elements of {element_size} bytes at offset {offset} with stride {stride}, and bufferViews[{number}] has {} bytes",
                view.byte_length.0
            ));
        }
        let start = usize::try_from(view_start.saturating_add(offset)).unwrap_or(usize::MAX);
        Ok(Span { bytes, start, stride })
    }

    fn open_sparse(
        &self,
        sparse: &gltf::json::accessor::sparse::Sparse,
        claimed: u64,
        element_size: usize,
    ) -> Result<Sparse, String> {
        let count = sparse.count.0;
        if count > claimed {
            return Err(format!("replaces {count} elements, and there are {claimed}"));
        }
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err("has indices of an unknown type".to_owned());
        };
        let component = component.0;
        let indices = self.span(sparse.indices.buffer_view, sparse.indices.byte_offset.0, count, component.size())?;
        let values = self.span(sparse.values.buffer_view, sparse.values.byte_offset.0, count, element_size)?;
        self.charge(count)?;
        // Both spans fit their buffers, so `count` is bounded by bytes that exist.
        let part = Sparse { indices, component, count: usize::try_from(count).unwrap_or(usize::MAX), values };
        let mut previous = None;
        for slot in 0..part.count {
            let index = part.number(slot);
            if previous.is_some_and(|previous| index <= previous) {
                return Err("has indices that do not increase".to_owned());
            }
            previous = Some(index);
        }
        match previous {
            Some(last) if u64::from(last) >= claimed => {
                Err(format!("replaces element {last}, and there are {claimed}"))
            }
            _ => Ok(part),
        }
    }
}

impl Sparse {
    /// Which element is replaced by that of a slot; 0 beyond the end.
    fn number(&self, slot: usize) -> u32 {
        self.indices.unsigned(self.indices.start + slot * self.indices.stride, self.component)
    }

    /// The slot that holds `number`.
    fn find(&self, number: usize) -> Option<usize> {
        let slot = partition_point(self.count, |slot| (self.number(slot) as usize) < number);
        (slot < self.count && self.number(slot) as usize == number).then_some(slot)
    }
}

impl Accessor {
    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Number of components of all elements.
    pub(super) fn numbers(&self) -> Option<usize> {
        self.count.checked_mul(self.width)
    }

    /// The unsigned integer at `at`; 0 beyond the end.
    pub(super) fn index(&self, at: usize) -> u32 {
        self.locate(at).map_or(0, |(span, start)| span.unsigned(start, self.component))
    }

    /// The first `N` components of the element at `at`, exact; zeros beyond the end and beyond the element.
    pub(super) fn vector<const N: usize>(&self, at: usize) -> [f64; N] {
        let mut vector = [0.0; N];
        if let Some((span, start)) = self.locate(at) {
            let size = self.component.size();
            for (slot, value) in vector.iter_mut().enumerate().take(self.width) {
                *value = self.component_at(span, start + slot * size);
            }
        }
        vector
    }

    /// Component `at` of all elements one after the other, exact; zero beyond the end.
    pub(super) fn value(&self, at: usize) -> f64 {
        self.locate(at / self.width)
            .map_or(0.0, |(span, start)| self.component_at(span, start + (at % self.width) * self.component.size()))
    }

    fn component_at(&self, span: &Span, at: usize) -> f64 {
        let (value, full) = match self.component {
            F32 => return f64::from(f32::from_le_bytes(span.read(at))),
            I8 => (f64::from(i8::from_le_bytes(span.read(at))), 127.0),
            I16 => (f64::from(i16::from_le_bytes(span.read(at))), 32_767.0),
            U8 => (f64::from(u8::from_le_bytes(span.read(at))), 255.0),
            U16 => (f64::from(u16::from_le_bytes(span.read(at))), 65_535.0),
            U32 => (f64::from(u32::from_le_bytes(span.read(at))), 1.0),
        };
        if self.normalized {
            // The most negative integer lies just beyond -1 and is clamped, as the specification says.
            (value / full).max(-1.0)
        } else {
            value
        }
    }

    /// Where element `at` is, and from which byte on; none where it is zero.
    fn locate(&self, at: usize) -> Option<(&Span, usize)> {
        if at >= self.count {
            return None;
        }
        if let Some(sparse) = &self.sparse
            && let Some(slot) = sparse.find(at)
        {
            return Some((&sparse.values, sparse.values.start + slot * self.width * self.component.size()));
        }
        self.data.as_ref().map(|data| (data, data.start + at * data.stride))
    }
}

impl Span {
    fn unsigned(&self, at: usize, component: ComponentType) -> u32 {
        match component {
            U8 => u32::from(u8::from_le_bytes(self.read(at))),
            U16 => u32::from(u16::from_le_bytes(self.read(at))),
            _ => u32::from_le_bytes(self.read(at)),
        }
    }

    /// `N` bytes at `at`; zeros beyond the end, which the checks at opening exclude.
    fn read<const N: usize>(&self, at: usize) -> [u8; N] {
        self.bytes.get(at..).and_then(|tail| tail.first_chunk::<N>()).copied().unwrap_or([0; N])
    }
}

/// The first of `count` numbers for which `before` is false, as it is for all after it.
pub(super) fn partition_point(count: usize, before: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = low + (high - low) / 2;
        if before(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}
