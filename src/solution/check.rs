//! Whether the parts of a network that was read fit each other and the scene, so that no pass can read
//! outside of them or make a NaN of them. Each check names the first thing wrong.

use crate::layout::{Link, Material, Node, NodeLight, Plane, TWIN};
use crate::scene::Geometry;
use crate::twin::jacobi::System;

type Checked = Result<(), &'static str>;

/// How far a node may lie outside the unit box, and its normal's length off 1: rounding.
const SLACK: f32 = 1e-3;

/// Whether all are finite.
pub(crate) fn finite(numbers: &[f32]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// Nodes lie in the scene, on its planes and materials.
pub(crate) fn nodes(geometry: &Geometry, nodes: &[Node]) -> Checked {
    let materials = geometry.materials.len() as u32;
    let node = |n: &Node| {
        let length = n.n.iter().map(|x| x * x).sum::<f32>();
        n.material < materials
            && n.plane & !TWIN < geometry.pieces
            && n.p.iter().all(|x| x.abs() < 1.0 + SLACK)
            && (length - 1.0).abs() < SLACK
            && finite(&n.mean)
    };
    if nodes.iter().all(node) { Ok(()) } else { Err("section 'nodes' holds a node that cannot be") }
}

/// A finite light for each of `nodes` nodes.
pub(crate) fn light(light: &[NodeLight], nodes: usize) -> Checked {
    if light.len() != nodes {
        return Err("sections 'nodes' and 'light' do not belong together");
    }
    let lit = |l: &NodeLight| finite(&l.h) && finite(&l.g0) && finite(&l.g1);
    if light.iter().all(lit) { Ok(()) } else { Err("section 'light' or 'node_source' holds a number that is not finite") }
}

/// A system over `nodes` nodes.
pub(crate) fn system(geometry: &Geometry, system: &System, nodes: usize) -> Checked {
    if [system.planes.len(), system.node_source.len()] != [nodes; 2] {
        return Err("sections 'nodes', 'planes' and 'node_source' do not belong together");
    }
    light(&system.node_source, nodes)?;
    if !finite(system.source.as_flattened()) {
        return Err("section 'source' holds a number that is not finite");
    }
    let possible = |m: &Material| m.rho.iter().all(|r| (0.0..1.0).contains(r));
    if ![0, nodes].contains(&system.materials.len()) || !system.materials.iter().all(possible) {
        return Err("section 'node_materials' does not fit the nodes");
    }
    let plane = |p: &Plane| (p.material as usize) < geometry.materials.len() && finite(&[p.i11, p.i12, p.i22]);
    if !system.planes.iter().all(plane) {
        return Err("section 'planes' holds a fit that cannot be");
    }
    let rows = |offsets: &[u32], links: &[Link], rows: usize, others: usize| {
        offsets.len() == rows + 1
            && offsets[0] == 0
            && offsets.is_sorted()
            && offsets[rows] as usize == links.len()
            && links.iter().all(|l| (l.other as usize) < others && finite(&[l.value, l.first, l.second]))
    };
    let cells = system.source.len();
    if !rows(&system.cell_offsets, &system.cell_links, cells, nodes)
        || !rows(&system.node_offsets, &system.node_links, nodes, cells)
    {
        return Err("the coefficients do not fit the network");
    }
    Ok(())
}

/// Cells that a system of `cells` cells speaks of.
pub(crate) fn cells(features: &[crate::twin::winner::Feature], cells: usize) -> Checked {
    if features.len() > cells {
        return Err("sections 'cells' and 'source' do not belong together");
    }
    if finite(features.as_flattened()) { Ok(()) } else { Err("section 'cells' holds a number that is not finite") }
}
