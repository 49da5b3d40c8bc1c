//! Bounds-checked accessors: where the bytes are is checked once, then elements are read one by one.

use std::cell::Cell;

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, buffer};

use super::buffers::Bytes;
use super::elements::{Elements, Indices, Sparse};

/// Most elements of an accessor that has no data: such an accessor is all zeros and can claim any count.
const MAX_ELEMENTS_WITHOUT_DATA: u64 = 10_000_000;

/// Most elements that are read only to be checked, over all accessors: many may share the same bytes.
const MAX_CHECKED: u64 = 200_000_000;

/// An accessor whose elements are known to lie within their buffers. It holds no bytes itself.
pub(super) struct Accessor {
    /// None if every element is zero.
    data: Option<Span>,
    component: ComponentType,
    normalized: bool,
    count: usize,
    width: usize,
    sparse: Option<SparsePart>,
}

/// Where elements lie: from byte `start` of a buffer on.
struct Span {
    buffer: usize,
    start: usize,
    stride: usize,
}

struct SparsePart {
    indices: Span,
    component: ComponentType,
    count: usize,
    values: Span,
}

/// What kind of elements is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// Vertex positions, or displacements of them: three components of any type but u32.
    Position,
    /// Indices: one unsigned component.
    Index,
    /// Joints of a vertex: four of u8 or u16.
    Joints,
    /// Weights of joints: four of f32, u8 or u16.
    JointWeights,
    /// Inverse bind matrices: 4 x 4 of f32.
    Matrix,
    /// Times of keys: one f32.
    Time,
    /// Translations or scales at keys: three f32.
    Vector,
    /// Rotations at keys: four components of any type but u32.
    Rotation,
    /// Weights of morph targets at keys: one component of any type but u32.
    MorphWeight,
}

impl Kind {
    fn fits(self, shape: Type, component: ComponentType) -> bool {
        use ComponentType::{F32, U8, U16, U32};
        match self {
            Self::Position => shape == Type::Vec3 && component != U32,
            Self::Index => shape == Type::Scalar && matches!(component, U8 | U16 | U32),
            Self::Joints => shape == Type::Vec4 && matches!(component, U8 | U16),
            Self::JointWeights => shape == Type::Vec4 && matches!(component, F32 | U8 | U16),
            Self::Matrix => shape == Type::Mat4 && component == F32,
            Self::Time => shape == Type::Scalar && component == F32,
            Self::Vector => shape == Type::Vec3 && component == F32,
            Self::Rotation => shape == Type::Vec4 && component != U32,
            Self::MorphWeight => shape == Type::Scalar && component != U32,
        }
    }

    fn plural(self) -> &'static str {
        match self {
            Self::Position => "positions",
            Self::Index => "indices",
            Self::Joints => "joints",
            Self::JointWeights => "weights of joints",
            Self::Matrix => "matrices",
            Self::Time => "times",
            Self::Vector => "translations or scales",
            Self::Rotation => "rotations",
            Self::MorphWeight => "weights of morph targets",
        }
    }
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
    root: &'a Root,
    bytes: &'a Bytes<'a>,
    checked: Cell<u64>,
}

impl<'a> Accessors<'a> {
    /// Nothing is checked yet.
    pub(super) fn new(root: &'a Root, bytes: &'a Bytes<'a>) -> Self {
        Self { root, bytes, checked: Cell::new(0) }
    }

    /// The document.
    pub(super) fn root(&self) -> &'a Root {
        self.root
    }

    /// The elements of an accessor that was opened here.
    pub(super) fn view(&self, accessor: &Accessor) -> Elements<'a> {
        accessor.view(self.bytes)
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
        if !kind.fits(shape, component) {
            return Err(format!("accessors[{index}] holds {component:?} {shape:?}, not {}", kind.plural()));
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
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(
                self.open_sparse(sparse, claimed, element_size)
                    .map_err(|problem| format!("the sparse part of accessors[{index}] {problem}"))?,
            ),
            None => None,
        };
        let count = usize::try_from(claimed).map_err(|_| format!("accessors[{index}] claims {claimed} elements"))?;
        Ok(Accessor { data, component, normalized: accessor.normalized, count, width, sparse })
    }

    /// Where `count` elements lie, all of them within their buffer.
    fn span(&self, view: Index<buffer::View>, offset: u64, count: u64, element_size: usize) -> Result<Span, String> {
        let number = view.value();
        let view = self.root.get(view).ok_or_else(|| format!("names bufferViews[{number}], which does not exist"))?;
        let stride = view.byte_stride.map_or(element_size, |stride| stride.0);
        if stride < element_size {
            return Err(format!("has elements of {element_size} bytes and bufferViews[{number}] a stride of {stride}"));
        }
        let buffer = self.bytes.of(view.buffer.value());
        let view_start = view.byte_offset.unwrap_or_default().0;
        let view_end = view_start.checked_add(view.byte_length.0);
        if view_end.is_none_or(|end| end > buffer.len() as u64) {
            return Err(format!(
                "reads bufferViews[{number}], which needs {} bytes from byte {view_start} on, and buffers[{}] has {}",
                view.byte_length.0,
                view.buffer,
                buffer.len()
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
        Ok(Span { buffer: view.buffer.value(), start, stride })
    }

    fn open_sparse(
        &self,
        sparse: &gltf::json::accessor::sparse::Sparse,
        claimed: u64,
        element_size: usize,
    ) -> Result<SparsePart, String> {
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
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        let part = SparsePart { indices, component, count, values };
        let indices = part.view(self.bytes).indices;
        let mut previous = None;
        for slot in 0..count {
            let index = indices.get(slot);
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

impl Accessor {
    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The elements in `bytes`, which are those that the accessor was opened with, or a copy of them.
    pub(super) fn view<'b>(&self, bytes: &'b Bytes<'_>) -> Elements<'b> {
        Elements {
            data: self.data.as_ref().map(|span| span.view(bytes)),
            stride: self.data.as_ref().map_or(0, |span| span.stride),
            component: self.component,
            normalized: self.normalized,
            count: self.count,
            width: self.width,
            sparse: self.sparse.as_ref().map(|sparse| sparse.view(bytes)),
        }
    }
}

impl Span {
    fn view<'b>(&self, bytes: &'b Bytes<'_>) -> &'b [u8] {
        bytes.of(self.buffer).get(self.start..).unwrap_or(&[])
    }
}

impl SparsePart {
    fn view<'b>(&self, bytes: &'b Bytes<'_>) -> Sparse<'b> {
        let indices = Indices {
            bytes: self.indices.view(bytes),
            stride: self.indices.stride,
            component: self.component,
            count: self.count,
        };
        Sparse { indices, values: self.values.view(bytes) }
    }
}
