//! [`Accessor`]: typed, bounds-checked columns of numbers in a document's bytes (glTF 2.0, 3.6.2).
//!
//! An accessor checks its extent against its view once, before anything is decoded; afterwards
//! elements are read at will. What is decoded is charged to the [`Context`] first, so that a count
//! of a billion in a short file is refused. Normalized integers become floats as section 3.11 says.

use super::buffers::{Buffers, View};
use super::context::{Context, Place};
use super::json::Value;
use chiaro_basis::Result;
use std::cell::RefCell;
use std::collections::BTreeSet;

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: usize) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Rows and columns of an element, by the name of its type.
fn shape(kind: &str) -> Option<(usize, usize)> {
    Some(match kind {
        "SCALAR" => (1, 1),
        "VEC2" => (2, 1),
        "VEC3" => (3, 1),
        "VEC4" => (4, 1),
        "MAT2" => (2, 2),
        "MAT3" => (3, 3),
        "MAT4" => (4, 4),
        _ => return None,
    })
}

/// Numbers of a document, `width` an element.
#[derive(Clone)]
pub(super) struct Accessor<'b> {
    place: Place,
    count: usize,
    width: usize,
    component: Component,
    normalized: bool,
    /// From the first element on; empty for one that starts as zeros.
    bytes: &'b [u8],
    stride: usize,
    sparse: Option<Sparse<'b>>,
}

/// Elements that replace others.
#[derive(Clone)]
struct Sparse<'b> {
    count: usize,
    indices: &'b [u8],
    index: Component,
    values: &'b [u8],
}

/// All accessors of a document, checked when they are asked for.
pub(super) struct Accessors<'r, 'b> {
    items: &'r [Value<'r>],
    views: &'r [Value<'r>],
    buffers: &'b Buffers<'b>,
    /// Accessors whose sparse indices are known to rise.
    rising: RefCell<BTreeSet<usize>>,
}

impl<'r, 'b> Accessors<'r, 'b> {
    pub(super) fn new(root: &'r Value<'r>, buffers: &'b Buffers<'b>) -> Self {
        Self {
            items: root.list("accessors"),
            views: root.list("bufferViews"),
            buffers,
            rising: RefCell::default(),
        }
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.items.len()
    }

    /// How many elements accessor `index` says it has, unchecked.
    pub(super) fn count(&self, index: usize) -> usize {
        self.items.get(index).and_then(|i| i.get("count").as_whole()).unwrap_or(0)
    }

    /// Whether accessor `index` has bytes of its own.
    pub(super) fn has_data(&self, index: usize) -> bool {
        let item = self.items.get(index);
        item.is_some_and(|i| {
            i.get("bufferView").as_whole().is_some() || i.get("sparse").is_object()
        })
    }

    /// Accessor `index`, which must exist.
    pub(super) fn get(&self, index: usize, cx: &Context) -> Result<Accessor<'b>> {
        let item = &self.items[index];
        let place = Place::new("accessor", index);
        let wrong = |why: String| cx.wrong(place, why);
        let code = item.get("componentType").as_whole().unwrap_or(0);
        let component = Component::from_code(code)
            .ok_or_else(|| wrong(format!("its componentType {code} is none of glTF's")))?;
        let (rows, columns) = item
            .text("type")
            .and_then(shape)
            .ok_or_else(|| wrong("its type is none of glTF's".into()))?;
        let count = item
            .get("count")
            .as_whole()
            .ok_or_else(|| wrong("its count is no whole number from 0".into()))?;
        // Columns of matrices start at multiples of four bytes.
        let column = rows * component.size();
        let size = if columns > 1 { column.next_multiple_of(4) * columns } else { column };
        let mut accessor = Accessor {
            place,
            count,
            width: rows * columns,
            component,
            normalized: item.flag("normalized"),
            bytes: &[],
            stride: size,
            sparse: None,
        };
        if let Some(view) = item.index("bufferView", self.views.len()).map_err(wrong)? {
            let view = self.buffers.view(self.views, view, cx)?;
            let offset = item.whole("byteOffset", 0).map_err(wrong)?;
            accessor.stride = view.stride.unwrap_or(size);
            accessor.bytes = extent(view, offset, accessor.stride, size, count)
                .map_err(|why| cx.wrong(place, why))?;
        }
        let sparse = item.get("sparse");
        if sparse.is_object() {
            let sparse = self.sparse(sparse, place, size, cx)?;
            // Once is enough, however many parts share the accessor.
            if self.rising.borrow_mut().insert(index) && !sparse.rises_below(count) {
                let why = format!("its sparse indices do not rise, or reach its count of {count}");
                return Err(cx.wrong(place, why));
            }
            accessor.sparse = Some(sparse);
        }
        Ok(accessor)
    }

    /// The bytes of the view that `item` names.
    pub(super) fn view_bytes(&self, item: &Value, place: Place, cx: &Context) -> Result<&'b [u8]> {
        let view = item.get("bufferView").as_index("bufferView", self.views.len());
        let view = view.map_err(|why| cx.wrong(place, why))?;
        Ok(self.buffers.view(self.views, view, cx)?.bytes)
    }

    fn sparse(&self, item: &Value, place: Place, size: usize, cx: &Context) -> Result<Sparse<'b>> {
        let wrong = |why: String| cx.wrong(place, format!("of its sparse elements {why}"));
        let count =
            item.get("count").as_whole().ok_or_else(|| wrong("there is no count".into()))?;
        let code = item.get("indices").get("componentType").as_whole().unwrap_or(0);
        let index = Component::from_code(code)
            .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| wrong(format!("the indices have componentType {code}")))?;
        let part = |key: &str, size: usize| -> Result<&'b [u8]> {
            let item = item.get(key);
            let view = item.get("bufferView").as_index("bufferView", self.views.len());
            let view = self.buffers.view(self.views, view.map_err(wrong)?, cx)?;
            let offset = item.whole("byteOffset", 0).map_err(wrong)?;
            extent(view, offset, size, size, count).map_err(wrong)
        };
        let indices = part("indices", index.size())?;
        Ok(Sparse { count, indices, index, values: part("values", size)? })
    }
}

/// The bytes of `count` elements of `size` bytes, `stride` apart, from `offset` of a view.
fn extent(
    view: View<'_>,
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
) -> std::result::Result<&[u8], String> {
    if stride < size {
        return Err(format!("its elements of {size} bytes overlap, {stride} bytes apart"));
    }
    let Some(last) = count.checked_sub(1) else { return Ok(&[]) };
    let end = last
        .checked_mul(stride)
        .and_then(|n| n.checked_add(size))
        .and_then(|n| n.checked_add(offset));
    end.and_then(|end| view.bytes.get(offset..end)).ok_or_else(|| {
        let has = view.bytes.len();
        format!("its {count} elements from byte {offset} do not fit its view of {has} bytes")
    })
}

impl Sparse<'_> {
    /// Which element the `i`-th replaces.
    fn target(&self, i: usize) -> usize {
        let at = i * self.index.size();
        let bytes = &self.indices[at..at + self.index.size()];
        bytes.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b))
    }

    fn rises_below(&self, elements: usize) -> bool {
        (1..self.count).all(|i| self.target(i - 1) < self.target(i))
            && self.count.checked_sub(1).is_none_or(|last| self.target(last) < elements)
    }

    /// Where the replacement of element `element` is among the values, if it has one.
    fn find(&self, element: usize) -> Option<usize> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low.midpoint(high);
            if self.target(middle) < element { low = middle + 1 } else { high = middle }
        }
        (low < self.count && self.target(low) == element).then_some(low)
    }
}

impl<'b> Accessor<'b> {
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Numbers in an element.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// All elements as floats, in order: `width` numbers each.
    pub(super) fn flat(&self, cx: &mut Context) -> Result<Vec<f32>> {
        cx.hold::<f32>(self.place, self.count.saturating_mul(self.width))?;
        let mut numbers = Vec::with_capacity(self.count * self.width);
        for i in 0..self.count {
            let element = self.element(i);
            numbers.extend((0..self.width).map(|k| self.float(element, k)));
        }
        Ok(numbers)
    }

    /// The picked elements as floats. Every pick is below the count, and an element has `N` numbers.
    pub(super) fn floats<const N: usize>(
        &self,
        picks: &[u32],
        cx: &mut Context,
    ) -> Result<Vec<[f32; N]>> {
        self.has_width(N, cx)?;
        cx.hold::<[f32; N]>(self.place, picks.len())?;
        let row = |pick: &u32| {
            let element = self.element(*pick as usize);
            std::array::from_fn(|k| self.float(element, k))
        };
        Ok(picks.iter().map(row).collect())
    }

    /// The picked elements as unsigned integers, as joints are.
    pub(super) fn wholes<const N: usize>(
        &self,
        picks: &[u32],
        cx: &mut Context,
    ) -> Result<Vec<[u32; N]>> {
        self.has_width(N, cx)?;
        self.is_unsigned(cx)?;
        cx.hold::<[u32; N]>(self.place, picks.len())?;
        let row = |pick: &u32| {
            let element = self.element(*pick as usize);
            std::array::from_fn(|k| self.whole(element, k))
        };
        Ok(picks.iter().map(row).collect())
    }

    /// All elements as vertex indices.
    pub(super) fn indices(&self, cx: &mut Context) -> Result<Vec<u32>> {
        self.has_width(1, cx)?;
        self.is_unsigned(cx)?;
        cx.hold::<u32>(self.place, self.count)?;
        Ok((0..self.count).map(|i| self.whole(self.element(i), 0)).collect())
    }

    fn has_width(&self, width: usize, cx: &Context) -> Result<()> {
        if self.width == width {
            return Ok(());
        }
        let why = format!("its elements have {} numbers where {width} belong", self.width);
        Err(cx.wrong(self.place, why))
    }

    fn is_unsigned(&self, cx: &Context) -> Result<()> {
        if matches!(self.component, Component::U8 | Component::U16 | Component::U32) {
            return Ok(());
        }
        Err(cx.wrong(self.place, "its numbers are no unsigned integers, as indices are"))
    }

    /// The bytes of an element; none where it is zero.
    fn element(&self, i: usize) -> &'b [u8] {
        if let Some(sparse) = &self.sparse
            && let Some(at) = sparse.find(i)
        {
            let size = sparse.values.len() / sparse.count;
            return &sparse.values[at * size..];
        }
        self.bytes.get(i * self.stride..).unwrap_or_default()
    }

    /// The `k`-th number of an element.
    fn float(&self, element: &[u8], k: usize) -> f32 {
        let at = |size: usize| element.get(k * size..(k + 1) * size);
        match self.component {
            Component::F32 => at(4).map_or(0.0, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Component::I8 | Component::I16 => {
                let (value, most) = match self.component {
                    Component::I8 => (at(1).map_or(0, |b| i16::from(b[0] as i8)), 127.0),
                    _ => (at(2).map_or(0, |b| i16::from_le_bytes([b[0], b[1]])), 32767.0),
                };
                let value = f32::from(value);
                if self.normalized { (value / most).max(-1.0) } else { value }
            }
            _ => {
                let value = f64::from(self.whole(element, k));
                let most = match self.component {
                    Component::U8 => 255.0,
                    Component::U16 => 65535.0,
                    _ => f64::from(u32::MAX),
                };
                (if self.normalized { value / most } else { value }) as f32
            }
        }
    }

    fn whole(&self, element: &[u8], k: usize) -> u32 {
        let size = self.component.size();
        let bytes = element.get(k * size..(k + 1) * size).unwrap_or_default();
        bytes.iter().rev().fold(0, |n, b| n << 8 | u32::from(*b))
    }
}

/// The accessor that `item` names by `key`; `None` where it names none.
pub(super) fn named<'b>(
    item: &Value,
    key: &str,
    place: Place,
    accessors: &Accessors<'_, 'b>,
    cx: &Context,
) -> Result<Option<Accessor<'b>>> {
    let index = item.index(key, accessors.len()).map_err(|why| cx.wrong(place, why))?;
    index.map(|i| accessors.get(i, cx)).transpose()
}
