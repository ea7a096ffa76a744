//! Textures: whose texture each line of a film shows, and after how much of u it begins anew.

use super::net::Net;
use chiaro_basis::Sets;
use std::collections::BTreeMap;

/// The period of each line's texture where links lead to lines that close: its own where it closes, else that of
/// the closed lines to which the heaviest links that are trusted lead, from frame to frame. A loop that something
/// opens for some frames so keeps its texture, whatever other loops it is joined to.
pub(super) fn carried(net: &Net, trust: &[f64], period: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut weights: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for (link, trust) in net.links.iter().zip(trust) {
        *weights.entry(link.lines).or_insert(0.0) += trust * link.weight;
    }
    let mut bundles: Vec<([u32; 2], f64)> = weights.into_iter().filter(|b| b.1 > 0.0).collect();
    bundles.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut sets = Sets::new(period.len());
    let mut of = period.to_vec();
    for (lines, _) in bundles {
        let [a, b] = lines.map(|l| sets.root(l as usize));
        if of[a].is_none() || of[b].is_none() || of[a] == of[b] {
            let joined = of[a].or(of[b]);
            sets.join(a, b);
            of[a.min(b)] = joined;
        }
    }
    (0..period.len()).map(|l| of[sets.root(l)]).collect()
}

/// For each line the component whose texture it shows, and that texture's period: what links carried to it, else
/// that of most of the component's lines.
pub(super) fn shown(components: &[u32], period: &[Option<f64>]) -> Vec<(u32, Option<f64>)> {
    let mut found: BTreeMap<u32, BTreeMap<u64, usize>> = BTreeMap::new();
    for (component, period) in components.iter().zip(period) {
        if let Some(period) = period {
            *found.entry(*component).or_default().entry(period.to_bits()).or_insert(0) += 1;
        }
    }
    let most = |component: &u32| {
        let counts = found.get(component)?.iter();
        counts.max_by_key(|(bits, count)| (**count, **bits)).map(|(bits, _)| f64::from_bits(*bits))
    };
    let texture = |(line, component): (usize, &u32)| (*component, period[line].or(most(component)));
    components.iter().enumerate().map(texture).collect()
}

#[cfg(test)]
mod tests {
    use super::super::net::{Line, Link};
    use super::*;

    #[test]
    fn a_loop_that_opens_for_a_frame_keeps_its_period() {
        // A long loop and a short one; between them the long one is open, and touches the short one.
        let line = |frame, count: u32, closed| Line {
            frame,
            first: 0,
            count,
            closed,
            length: (0..=count).map(f64::from).collect(),
        };
        let lines = vec![
            line(0, 100, true),
            line(0, 30, true),
            line(1, 90, false),
            line(1, 30, true),
            line(2, 100, true),
        ];
        let link =
            |lines, weight| Link { from: 0, to: [0, 1], share: 0.5, around: false, lines, weight };
        let links =
            vec![link([0, 2], 80.0), link([1, 2], 10.0), link([1, 3], 30.0), link([2, 4], 85.0)];
        let net = Net { lines, frames: vec![0, 2, 4, 5], links, unknowns: 0 };
        let own = [Some(4.0), Some(1.0), None, Some(1.0), Some(4.0)];
        let all = carried(&net, &[1.0; 4], &own);
        assert_eq!(all, [Some(4.0), Some(1.0), Some(4.0), Some(1.0), Some(4.0)]);
        // Of a component whose other loops are shorter and more.
        assert_eq!(shown(&[0, 0, 0, 0, 0, 0], &[&all[..], &[None]].concat())[5].1, Some(4.0));
        assert_eq!(carried(&net, &[0.0; 4], &own)[2], None);
    }
}
