//! Pass `winner`: the best-matching cell of each feature. Twin: [`crate::twin::winner::winner`].

use super::params;
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel};
use crate::twin::winner::Feature;
use bytemuck::{Pod, Zeroable};

/// Features an invocation serves.
const QUERIES: usize = 8;
/// Most cells in a block.
const BLOCK: usize = 16;
/// Most blocks in a dispatch: the loop budget.
const BLOCKS: usize = 1024;
/// Distances in a dispatch, at most: what keeps it short.
const WORK: usize = 1 << 28;
/// Where the receiver's place and normal stand in a feature.
const RECEIVER: std::ops::Range<usize> = 6..12;

params!(
    /// Parameters of `wgsl/winner.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Features to look at.
        features: u32,
        /// First block of the dispatch.
        first: u32,
        /// End of its blocks.
        end: u32,
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
    }
);

pub(super) const KERNEL: Kernel =
    Kernel::new("winner", &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write, Access::Write]);

/// A block of cells and the box around their receivers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Block {
    /// Lower corner of the places, y/L.
    pub low: [f32; 3],
    /// First cell.
    pub start: u32,
    /// Lower corner of the normals, lambda n_y.
    pub low_n: [f32; 3],
    /// End of the cells.
    pub end: u32,
    /// Upper corner of the places.
    pub high: [f32; 3],
    /// Padding.
    pub pad0: u32,
    /// Upper corner of the normals.
    pub high_n: [f32; 3],
    /// Padding.
    pub pad1: u32,
}

/// Cells on the device, in blocks of like receivers.
#[derive(Clone, Debug)]
pub struct CellBlocks {
    blocks: GpuVec<Block>,
    cells: GpuVec<Feature>,
}

impl CellBlocks {
    /// Sorts cells into blocks and uploads them.
    pub fn new(gpu: &Gpu, cells: &[Feature]) -> Result<CellBlocks> {
        let (blocks, order) = blocks(cells);
        // A cell carries its index along; a float holds integers exactly up to 2^24.
        let sorted: Vec<Feature> = order
            .iter()
            .map(|&c| {
                let mut cell = cells[c];
                cell[13] = c as f32;
                cell
            })
            .collect();
        Ok(CellBlocks { blocks: gpu.upload("blocks", &blocks)?, cells: gpu.upload("cells", &sorted)? })
    }
}

/// Halves the cells at the median of the widest of the receivers' dimensions until blocks are small.
/// Returns the blocks and the order of the cells.
fn blocks(cells: &[Feature]) -> (Vec<Block>, Vec<usize>) {
    let mut order: Vec<usize> = (0..cells.len()).collect();
    let mut blocks = Vec::new();
    let mut stack = Vec::from([(0, cells.len())]);
    while let Some((start, end)) = stack.pop() {
        let part = &mut order[start..end];
        let (mut low, mut high) = ([f32::MAX; 6], [f32::MIN; 6]);
        for &c in part.iter() {
            for k in 0..6 {
                low[k] = low[k].min(cells[c][RECEIVER.start + k]);
                high[k] = high[k].max(cells[c][RECEIVER.start + k]);
            }
        }
        if part.len() > BLOCK {
            let widest = (0..6).max_by(|&a, &b| (high[a] - low[a]).total_cmp(&(high[b] - low[b]))).unwrap_or(0);
            let key = |c: &usize| cells[*c][RECEIVER.start + widest];
            let middle = part.len() / 2;
            part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
            stack.extend([(start + middle, end), (start, start + middle)]);
        } else if !part.is_empty() {
            let three = |x: &[f32]| [x[0], x[1], x[2]];
            blocks.push(Block {
                low: three(&low),
                low_n: three(&low[3..]),
                high: three(&high),
                high_n: three(&high[3..]),
                start: start as u32,
                end: end as u32,
                ..Block::default()
            });
        }
    }
    (blocks, order)
}

/// Writes the cell nearest to each feature listed in `order`, ties to the lowest index, into the same places of
/// `winners`; [`crate::layout::NONE`] where there is no cell. It is fast where features near each other in `order` have like
/// receivers.
pub fn winner(
    gpu: &Gpu,
    features: &GpuVec<Feature>,
    order: &GpuVec<u32>,
    cells: &CellBlocks,
    winners: &GpuVec<u32>,
) -> Result<()> {
    // The best distances so far travel from one part of the cells to the next.
    let distances = gpu.alloc::<f32>("distances", order.len())?;
    let buffers = [
        features.buffer(),
        order.buffer(),
        cells.blocks.buffer(),
        cells.cells.buffer(),
        winners.buffer(),
        distances.buffer(),
        gpu.status(),
    ];
    let mut first = 0;
    loop {
        let end = (first + BLOCKS).min(cells.blocks.len());
        let params = Params {
            flag: gpu.flag(&KERNEL),
            features: order.len() as u32,
            first: first as u32,
            end: end as u32,
            ..Params::default()
        };
        let chunk = WORK / (QUERIES * BLOCK * (end - first).max(1));
        gpu.run(&KERNEL, &params, &buffers, order.len().div_ceil(QUERIES), chunk as u32)?;
        first = end;
        if first == cells.blocks.len() {
            return Ok(());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_hold_every_cell_once_within_their_boxes() {
        for n in [0usize, 1, 16, 17, 1000] {
            let cells: Vec<Feature> =
                (0..n).map(|i| std::array::from_fn(|k| (crate::twin::math::hash((16 * i + k) as u32) % 64) as f32)).collect();
            let (blocks, mut order) = blocks(&cells);
            for b in &blocks {
                assert!(b.start < b.end && (b.end - b.start) as usize <= BLOCK);
                for &c in &order[b.start as usize..b.end as usize] {
                    for k in 0..3 {
                        assert!(b.low[k] <= cells[c][6 + k] && cells[c][6 + k] <= b.high[k]);
                        assert!(b.low_n[k] <= cells[c][9 + k] && cells[c][9 + k] <= b.high_n[k]);
                    }
                }
            }
            assert_eq!(blocks.iter().map(|b| (b.end - b.start) as usize).sum::<usize>(), n);
            order.sort_unstable();
            assert_eq!(order, (0..n).collect::<Vec<_>>());
        }
    }
}
