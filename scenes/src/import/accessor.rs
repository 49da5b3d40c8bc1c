//! Bounds-checked reading of accessors: where the bytes are is checked once, then elements are read one by one.
//!
//! Nothing is decoded ahead, so an accessor costs no memory beyond its buffer, whatever count it claims.

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, buffer};

use super::buffers::Buffers;

/// Most elements of an accessor that has no data: such an accessor is all zeros and can claim any count.
const MAX_ELEMENTS_WITHOUT_DATA: u64 = 50_000_000;

/// Elements of one accessor.
pub(super) struct Elements<'a> {
    /// From the first byte of the first element; none if every element is zero.
    data: Option<&'a [u8]>,
    stride: usize,
    component: ComponentType,
    normalized: bool,
    count: usize,
    sparse: Option<Sparse<'a>>,
}

struct Sparse<'a> {
    /// Strictly increasing element indices.
    indices: Vec<u32>,
    values: &'a [u8],
    element_size: usize,
}

/// What kind of elements is asked for.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// Vertex positions: three components of any type but u32.
    Position,
    /// Indices: one unsigned component.
    Index,
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

impl<'a> Elements<'a> {
    /// Checks accessor `index` of `root` against its views and buffers, which must be loaded.
    pub(super) fn open(root: &Root, buffers: &'a Buffers<'_>, index: usize, kind: Kind) -> Result<Self, String> {
        let accessor = root.accessors.get(index).ok_or_else(|| format!("there is no accessor {index}"))?;
        let (Checked::Valid(component), Checked::Valid(shape)) = (accessor.component_type, accessor.type_) else {
            return Err(format!("accessor {index} has an unknown type"));
        };
        let component = component.0;
        let fits = match kind {
            Kind::Position => shape == Type::Vec3 && component != ComponentType::U32,
            Kind::Index => {
                shape == Type::Scalar
                    && matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
            }
        };
        if !fits {
            return Err(match kind {
                Kind::Position => {
                    format!("accessor {index} holds {component:?} {shape:?}, not positions")
                }
                Kind::Index => {
                    format!("accessor {index} holds {component:?} {shape:?}, not indices")
                }
            });
        }
        let element_size = component.size() * shape.multiplicity();
        let claimed = accessor.count.0;
        let (data, stride) = match accessor.buffer_view {
            Some(view) => {
                let span = span(root, buffers, view, accessor.byte_offset.unwrap_or_default().0, claimed, element_size)
                    .map_err(|problem| format!("accessor {index} {problem}"))?;
                (Some(span.0), span.1)
            }
            None if claimed > MAX_ELEMENTS_WITHOUT_DATA => {
                return Err(format!(
                    "accessor {index} claims {claimed} elements without data, more than {MAX_ELEMENTS_WITHOUT_DATA}"
                ));
            }
            None => (None, element_size),
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(
                open_sparse(root, buffers, sparse, claimed, element_size)
                    .map_err(|problem| format!("the sparse part of accessor {index} {problem}"))?,
            ),
            None => None,
        };
        Ok(Self {
            data,
            stride,
            component,
            normalized: accessor.normalized,
            count: usize::try_from(claimed).map_err(|_| format!("accessor {index} claims {claimed} elements"))?,
            sparse,
        })
    }

    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The index at `at`; 0 beyond the end.
    pub(super) fn index(&self, at: usize) -> u32 {
        let Some((bytes, start)) = self.locate(at) else {
            return 0;
        };
        read_unsigned(bytes, start, self.component)
    }

    /// The position at `at`, exact; zero beyond the end.
    pub(super) fn position(&self, at: usize) -> [f64; 3] {
        let Some((bytes, start)) = self.locate(at) else {
            return [0.0; 3];
        };
        let size = self.component.size();
        [0, 1, 2].map(|axis| self.component_at(bytes, start + axis * size))
    }

    fn component_at(&self, bytes: &[u8], at: usize) -> f64 {
        let (value, full) = match self.component {
            ComponentType::F32 => return f64::from(f32::from_le_bytes(read(bytes, at))),
            ComponentType::I8 => (f64::from(i8::from_le_bytes(read(bytes, at))), 127.0),
            ComponentType::I16 => (f64::from(i16::from_le_bytes(read(bytes, at))), 32_767.0),
            ComponentType::U8 => (f64::from(u8::from_le_bytes(read(bytes, at))), 255.0),
            ComponentType::U16 => (f64::from(u16::from_le_bytes(read(bytes, at))), 65_535.0),
            ComponentType::U32 => (f64::from(u32::from_le_bytes(read(bytes, at))), 1.0),
        };
        if self.normalized {
            // The most negative integer lies just beyond -1 and is clamped, as the specification says.
            (value / full).max(-1.0)
        } else {
            value
        }
    }

    /// Bytes and start of element `at`; none where it is zero.
    fn locate(&self, at: usize) -> Option<(&'a [u8], usize)> {
        if at >= self.count {
            return None;
        }
        if let Some(sparse) = &self.sparse
            && let Ok(narrow) = u32::try_from(at)
            && let Ok(slot) = sparse.indices.binary_search(&narrow)
        {
            return Some((sparse.values, slot * sparse.element_size));
        }
        Some((self.data?, at * self.stride))
    }
}

/// Bytes from the first of `count` elements on, and the stride between them.
fn span<'a>(
    root: &Root,
    buffers: &'a Buffers<'_>,
    view: Index<buffer::View>,
    offset: u64,
    count: u64,
    element_size: usize,
) -> Result<(&'a [u8], usize), String> {
    let number = view.value();
    let view = root.get(view).ok_or_else(|| format!("names buffer view {number}, which does not exist"))?;
    let stride = view.byte_stride.map_or(element_size, |stride| stride.0);
    if stride < element_size {
        return Err(format!("has elements of {element_size} bytes and buffer view {number} a stride of {stride}"));
    }
    let buffer = buffers.bytes(view.buffer.value());
    let view_start = view.byte_offset.unwrap_or_default().0;
    let view_bytes = view_start
        .checked_add(view.byte_length.0)
        .and_then(|end| buffer.get(usize::try_from(view_start).ok()?..usize::try_from(end).ok()?))
        .ok_or_else(|| {
            format!(
                "reads buffer view {number}, which needs {} bytes from byte {view_start} on, and buffer {} has {}",
                view.byte_length.0,
                view.buffer,
                buffer.len()
            )
        })?;
    let needed = if count == 0 {
        Some(0)
    } else {
        (count - 1)
            .checked_mul(stride as u64)
            .and_then(|bytes| bytes.checked_add(element_size as u64))
            .and_then(|bytes| bytes.checked_add(offset))
    };
    match needed {
        Some(needed) if needed <= view_bytes.len() as u64 => {
            let start = usize::try_from(offset).unwrap_or(usize::MAX);
            Ok((view_bytes.get(start..).unwrap_or(&[]), stride))
        }
        _ => Err(format!(
            "has {count} elements of {element_size} bytes at offset {offset} with stride {stride}, and buffer view {number} has {} bytes",
            view_bytes.len()
        )),
    }
}

fn open_sparse<'a>(
    root: &Root,
    buffers: &'a Buffers<'_>,
    sparse: &gltf::json::accessor::sparse::Sparse,
    claimed: u64,
    element_size: usize,
) -> Result<Sparse<'a>, String> {
    let count = sparse.count.0;
    if count > claimed {
        return Err(format!("replaces {count} elements, and there are {claimed}"));
    }
    let Checked::Valid(component) = sparse.indices.component_type else {
        return Err("has indices of an unknown type".to_owned());
    };
    let component = component.0;
    let (index_bytes, index_stride) =
        span(root, buffers, sparse.indices.buffer_view, sparse.indices.byte_offset.0, count, component.size())?;
    let (values, _) = span(root, buffers, sparse.values.buffer_view, sparse.values.byte_offset.0, count, element_size)?;
    // Both spans fit their buffers, so `count` is bounded by bytes that exist.
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    let indices: Vec<u32> = (0..count).map(|slot| read_unsigned(index_bytes, slot * index_stride, component)).collect();
    if !indices.is_sorted_by(|a, b| a < b) {
        return Err("has indices that do not increase".to_owned());
    }
    if let Some(&last) = indices.last()
        && u64::from(last) >= claimed
    {
        return Err(format!("replaces element {last}, and there are {claimed}"));
    }
    Ok(Sparse { indices, values, element_size })
}

fn read_unsigned(bytes: &[u8], at: usize, component: ComponentType) -> u32 {
    match component {
        ComponentType::U8 => u32::from(u8::from_le_bytes(read(bytes, at))),
        ComponentType::U16 => u32::from(u16::from_le_bytes(read(bytes, at))),
        _ => u32::from_le_bytes(read(bytes, at)),
    }
}

/// `N` bytes at `at`; zeros beyond the end, which the checks at opening exclude.
fn read<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    bytes.get(at..).and_then(|tail| tail.first_chunk::<N>()).copied().unwrap_or([0; N])
}
