//! The bytes that hold the tables of all fields: the same in memory and in a file.

use std::{fmt, ops::Range};

use bytemuck::Pod;

use super::{
    metric::{Knight, Metric, Octile},
    table::{Table, TableMut},
};
use crate::moves::MoveSet;

/// Bytes that tables are kept in: owned, or a file that is mapped so that writing changes the memory and
/// not the file.
pub trait Memory: AsRef<[u8]> + AsMut<[u8]> + Send + Sync {}

impl<T: AsRef<[u8]> + AsMut<[u8]> + Send + Sync> Memory for T {}

/// Owned bytes, aligned for all tables.
struct Owned(Vec<u64>);

impl AsRef<[u8]> for Owned {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }
}

impl AsMut<[u8]> for Owned {
    fn as_mut(&mut self) -> &mut [u8] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}

/// How much precedes the tables.
pub(super) const HEADER_BYTES: usize = 64;

/// Where in the bytes each table is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub targets: usize,
    pub distances: Range<usize>,
    pub runs: Range<usize>,
}

impl Layout {
    pub fn of(moves: MoveSet, cells: usize, targets: usize) -> Self {
        let distance = match moves {
            MoveSet::Eight => size_of::<<Octile as Metric>::Distance>(),
            MoveSet::Sixteen => size_of::<<Knight as Metric>::Distance>(),
        };
        let entries = cells * targets;
        let runs = HEADER_BYTES + entries * distance;
        Self { targets, distances: HEADER_BYTES..runs, runs: runs..runs + entries }
    }

    /// The bytes of header and tables, rounded up to whole words.
    pub fn bytes(&self) -> usize {
        self.runs.end.next_multiple_of(8)
    }
}

/// The tables of all fields.
pub(super) struct Image {
    pub layout: Layout,
    pub memory: Box<dyn Memory>,
}

impl fmt::Debug for Image {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Image").field("layout", &self.layout).finish_non_exhaustive()
    }
}

impl Clone for Image {
    fn clone(&self) -> Self {
        Self::copy_of(self.layout.clone(), self.memory.as_ref().as_ref())
    }
}

impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        self.layout == other.layout && self.tables() == other.tables()
    }
}

impl Eq for Image {}

impl Image {
    /// The bytes of the tables, without header.
    fn tables(&self) -> &[u8] {
        let bytes = self.memory.as_ref().as_ref();
        &bytes[self.layout.distances.start..self.layout.runs.end]
    }

    /// Bytes of 0.
    pub fn blank(layout: Layout) -> Self {
        let words = vec![0; layout.bytes() / 8];
        Self { layout, memory: Box::new(Owned(words)) }
    }

    /// A copy of tables in bytes that may be more.
    pub fn copy_of(layout: Layout, bytes: &[u8]) -> Self {
        let mut copy = Self::blank(layout);
        for (to, &from) in copy.memory.as_mut().as_mut().iter_mut().zip(bytes) {
            *to = from;
        }
        copy
    }

    #[inline]
    pub fn table<M: Metric>(&self) -> Table<'_, M> {
        let bytes = self.memory.as_ref().as_ref();
        Table {
            distances: cast(&bytes[self.layout.distances.clone()]),
            runs: &bytes[self.layout.runs.clone()],
            targets: self.layout.targets,
        }
    }

    pub fn table_mut<M: Metric>(&mut self) -> TableMut<'_, M> {
        let Layout { distances, runs, targets } = &self.layout;
        let bytes = self.memory.as_mut().as_mut();
        let (before, after) = bytes.split_at_mut(runs.start);
        let distances = bytemuck::cast_slice_mut(&mut before[distances.clone()]);
        TableMut { distances, runs: &mut after[..runs.len()], targets: *targets }
    }
}

/// The numbers that the bytes are.
#[inline]
fn cast<T: Pod>(bytes: &[u8]) -> &[T] {
    bytemuck::cast_slice(bytes)
}
