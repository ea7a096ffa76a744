//! [`Tree`]: the node hierarchy, checked, with parents before children, and what of it is drawn.
//!
//! Children that do not exist, nodes with two parents and nodes that are their own ancestors are
//! errors. No recursion: a chain of a million nodes is as good as any.

use super::context::{Context, Place};
use super::json::Value;
use crate::NodeId;
use chiaro_basis::Result;

/// The node hierarchy of a document.
pub(super) struct Tree<'r> {
    /// The document's nodes.
    pub(super) items: &'r [Value<'r>],
    parents: Vec<Option<usize>>,
    /// The document's index of each node, parents first.
    order: Vec<usize>,
    /// Where each of the document's nodes is in `order`.
    position: Vec<usize>,
    drawn: Vec<bool>,
}

impl<'r> Tree<'r> {
    /// Checks and orders the nodes.
    pub(super) fn read(root: &'r Value<'r>, cx: &mut Context) -> Result<Self> {
        let items = root.list("nodes");
        cx.spend("nodes", |b| &mut b.nodes, items.len())?;
        let parents = parents(items, cx)?;
        let order = order(items, &parents, cx)?;
        let mut position = vec![0; items.len()];
        for (new, old) in order.iter().enumerate() {
            position[*old] = new;
        }
        let mut tree = Self { items, parents, order, position, drawn: Vec::new() };
        tree.drawn = tree.drawn(root, cx)?;
        Ok(tree)
    }

    /// The document's indices of the nodes, parents first.
    pub(super) fn order(&self) -> &[usize] {
        &self.order
    }

    /// The scene's id of one of the document's nodes.
    pub(super) fn id(&self, node: usize) -> NodeId {
        NodeId::new(self.position[node])
    }

    /// The scene's id of the parent of one of the document's nodes.
    pub(super) fn parent(&self, node: usize) -> Option<NodeId> {
        self.parents[node].map(|p| self.id(p))
    }

    /// Whether one of the document's nodes is in the default scene, and visible.
    pub(super) fn is_drawn(&self, node: usize) -> bool {
        self.drawn[node]
    }

    /// The document's indices of the nodes that are drawn, in its order.
    pub(super) fn drawn_nodes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.items.len()).filter(|n| self.drawn[*n])
    }

    fn drawn(&self, root: &Value, cx: &mut Context) -> Result<Vec<bool>> {
        let mut drawn = vec![false; self.items.len()];
        match default_scene(root, cx) {
            None => drawn.fill(true),
            Some(scene) => {
                let place = Place::new("scene", scene);
                for node in root.list("scenes")[scene].list("nodes") {
                    let node = node.as_index("node", self.items.len());
                    let node = node.map_err(|why| cx.wrong(place, why))?;
                    if let Some(parent) = self.parents[node] {
                        cx.note(
                            place,
                            format!("its node {node} is no root, but a child of {parent}"),
                        );
                    }
                    drawn[node] = true;
                }
            }
        }
        let mut hidden = vec![false; self.items.len()];
        for &node in &self.order {
            let visibility = self.items[node].extension("KHR_node_visibility").get("visible");
            let parent = self.parents[node];
            hidden[node] =
                matches!(visibility, Value::Flag(false)) || parent.is_some_and(|p| hidden[p]);
            drawn[node] |= parent.is_some_and(|p| drawn[p]);
        }
        drawn.iter_mut().zip(hidden).for_each(|(drawn, hidden)| *drawn &= !hidden);
        Ok(drawn)
    }
}

/// The scene to draw; `None` for everything.
fn default_scene(root: &Value, cx: &mut Context) -> Option<usize> {
    let scenes = root.list("scenes");
    if scenes.is_empty() {
        return None;
    }
    let scene = root.index("scene", scenes.len()).unwrap_or_else(|why| {
        cx.remark(format!("{why}; scene 0 is drawn"));
        None
    });
    let scene = scene.unwrap_or(0);
    if scenes.len() > 1 {
        let count = scenes.len();
        cx.note(Place::new("scene", scene), format!("this one of {count} scenes is drawn"));
    }
    Some(scene)
}

/// The parent of each node.
fn parents(items: &[Value], cx: &mut Context) -> Result<Vec<Option<usize>>> {
    let mut parents = vec![None; items.len()];
    for (node, item) in items.iter().enumerate() {
        let place = Place::new("node", node);
        for child in item.list("children") {
            let child = child.as_index("child", items.len()).map_err(|why| cx.wrong(place, why))?;
            match parents[child] {
                None => parents[child] = Some(node),
                Some(same) if same == node => cx.note(place, "it names a child twice"),
                Some(other) => {
                    let why = format!("it is a child of node {other} and of node {node}");
                    return Err(cx.wrong(Place::new("node", child), why));
                }
            }
        }
    }
    Ok(parents)
}

/// All nodes, each before its children, families together.
fn order(items: &[Value], parents: &[Option<usize>], cx: &Context) -> Result<Vec<usize>> {
    let mut order = Vec::with_capacity(items.len());
    let mut reached = vec![false; items.len()];
    let mut stack: Vec<usize> = (0..items.len()).rev().filter(|n| parents[*n].is_none()).collect();
    while let Some(node) = stack.pop() {
        if std::mem::replace(&mut reached[node], true) {
            continue;
        }
        order.push(node);
        stack.extend(items[node].list("children").iter().rev().filter_map(Value::as_whole));
    }
    match reached.iter().position(|r| !r) {
        None => Ok(order),
        // A node with one parent that no root leads to is on a cycle or below one.
        Some(node) => Err(cx.wrong(Place::new("node", node), "it is among its own ancestors")),
    }
}
