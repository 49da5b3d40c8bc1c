//! Reading the elements of an accessor one by one.
//!
//! Nothing is decoded ahead, so an accessor costs no memory beyond its buffer, whatever count it claims.

use gltf::json::accessor::ComponentType;

/// Elements of one accessor; made by [`super::accessor::Accessor::view`], which knows that they are within their bytes.
pub(super) struct Elements<'b> {
    /// From the first byte of the first element; none if every element is zero.
    pub(super) data: Option<&'b [u8]>,
    pub(super) stride: usize,
    pub(super) component: ComponentType,
    pub(super) normalized: bool,
    pub(super) count: usize,
    /// Components of an element, at least 1.
    pub(super) width: usize,
    pub(super) sparse: Option<Sparse<'b>>,
}

/// Elements that replace others.
pub(super) struct Sparse<'b> {
    pub(super) indices: Indices<'b>,
    /// The replacements, without gaps.
    pub(super) values: &'b [u8],
}

/// Strictly increasing numbers of elements.
#[derive(Clone, Copy)]
pub(super) struct Indices<'b> {
    pub(super) bytes: &'b [u8],
    pub(super) stride: usize,
    pub(super) component: ComponentType,
    pub(super) count: usize,
}

impl Indices<'_> {
    /// The number at `slot`; 0 beyond the end.
    pub(super) fn get(&self, slot: usize) -> u32 {
        read_unsigned(self.bytes, slot * self.stride, self.component)
    }

    /// The slot that holds `number`.
    fn find(&self, number: usize) -> Option<usize> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match (self.get(middle) as usize).cmp(&number) {
                std::cmp::Ordering::Equal => return Some(middle),
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

impl<'b> Elements<'b> {
    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The unsigned integer at `at`; 0 beyond the end.
    pub(super) fn index(&self, at: usize) -> u32 {
        self.locate(at).map_or(0, |(bytes, start)| read_unsigned(bytes, start, self.component))
    }

    /// The first `N` components of the element at `at`, exact; zeros beyond the end and beyond the element.
    pub(super) fn vector<const N: usize>(&self, at: usize) -> [f64; N] {
        let mut vector = [0.0; N];
        if let Some((bytes, start)) = self.locate(at) {
            let size = self.component.size();
            for (slot, value) in vector.iter_mut().enumerate().take(self.width) {
                *value = self.component_at(bytes, start + slot * size);
            }
        }
        vector
    }

    /// Component `at` of all elements one after the other, exact; zero beyond the end.
    pub(super) fn value(&self, at: usize) -> f64 {
        self.locate(at / self.width)
            .map_or(0.0, |(bytes, start)| self.component_at(bytes, start + (at % self.width) * self.component.size()))
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
    fn locate(&self, at: usize) -> Option<(&'b [u8], usize)> {
        if at >= self.count {
            return None;
        }
        if let Some(sparse) = &self.sparse
            && let Some(slot) = sparse.indices.find(at)
        {
            return Some((sparse.values, slot * self.width * self.component.size()));
        }
        Some((self.data?, at * self.stride))
    }
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
