//! `chiaro mincut`: a DIMACS maximum-flow problem, its flow and its minimal cut.

use crate::disk;
use crate::record::Record;
use crate::write;
use chiaro_basis::{Error, Result, Run};
use chiaro_mincut::{MaxFlow, read_dimacs};
use std::path::{Path, PathBuf};

/// A maximum-flow job.
pub struct Job<'a> {
    /// The problem, a DIMACS file.
    pub file: &'a Path,
    /// Where the flow of each arc goes, if anywhere.
    pub output: Option<PathBuf>,
    /// Whether the solution is checked from the problem alone.
    pub verify: bool,
}

impl Job<'_> {
    /// Solves the problem and writes the flow if asked.
    pub fn run(&self, run: &Run) -> Result<Record> {
        let name = self.file.display().to_string();
        let wrong = |why: String| Error::input(&name, "", why);
        let problem = run.stage("load", 1, || -> Result<MaxFlow> {
            let bytes = disk::read(self.file)?;
            read_dimacs(&bytes).map_err(|e| wrong(e.to_string()))
        })?;
        run.check()?;
        let arcs = problem.arcs.len() as u64;
        let solution = run.stage("cut", arcs, || problem.solve());
        let solution = solution.map_err(|e| wrong(e.to_string()))?;
        run.check()?;
        let mut record = Record::new("mincut");
        record.setting("input", name.as_str());
        record.count("nodes", problem.nodes);
        record.count("arcs", arcs);
        record.count("flow", solution.flow);
        record.count("cut", solution.cut);
        record.count("source_side", solution.side.iter().filter(|s| **s).count());
        if self.verify {
            let verified = run.stage("verify", arcs, || problem.verify(&solution));
            verified.map_err(|e| wrong(format!("{e}; this is an error of chiaro, report it")))?;
            record.count("verified", true);
        }
        if let Some(path) = &self.output {
            let text = problem.solution_to_dimacs(&solution);
            let output = run.stage("write", 1, || write::whole(path, text.as_bytes()))?;
            record.outputs.push(output);
        }
        Ok(record)
    }
}

/// Flow, cut and time, for people.
pub fn text(record: &Record) -> String {
    let count = |name: &str| record.counts.get(name).map(ToString::to_string).unwrap_or_default();
    let cut = record.stages.iter().find(|s| s.name == "cut");
    let seconds = cut.map_or(0.0, |s| s.seconds);
    let lines = ["nodes", "arcs", "flow", "cut"].map(|n| format!("{n:<8} {}\n", count(n)));
    format!("{}time     {seconds:.3} s\n", lines.concat())
}
