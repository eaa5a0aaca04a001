//! From factors to cells: every combination, without those that are excluded, and those that are included.

use super::file::BatchFile;
use super::matrix::{Factor, FactorKind, Level, Reader, label, stem};
use super::places::{Step, leaves};
use crate::files::{InputError, suggest};
use crate::planner::Preset;
use std::ops::Range;
use toml::{Table, Value};

/// More cells than any batch is planned for: a slip in the file would fill a disk.
const MOST_CELLS: usize = 100_000;

/// Cells that have one of these levels in each of these factors.
type Rule = Vec<(usize, Vec<usize>)>;

impl Reader<'_> {
    pub(super) fn product(&self, factors: &[Factor]) -> Result<Vec<Vec<usize>>, InputError> {
        let counts = factors.iter().map(|f| f.levels.len());
        let count = counts.clone().try_fold(1usize, usize::checked_mul);
        if count.is_none_or(|n| n > MOST_CELLS) {
            let each: Vec<String> = counts.map(|n| n.to_string()).collect();
            let message = format!("{} are more than {MOST_CELLS} cells", each.join(" x "));
            return Err(InputError::new(self.path, message).remedy("split the batch"));
        }
        let mut cells: Vec<Vec<usize>> = vec![Vec::new()];
        for factor in factors {
            let longer = |cell: &Vec<usize>| {
                let cell = cell.clone();
                (0..factor.levels.len()).map(move |l| [&cell[..], &[l]].concat())
            };
            cells = cells.iter().flat_map(longer).collect();
        }
        Ok(cells)
    }

    pub(super) fn excluded(
        &self,
        file: &BatchFile,
        factors: &[Factor],
    ) -> Result<Vec<Rule>, InputError> {
        let mut rules = Vec::new();
        for (k, entry) in file.exclude.iter().enumerate() {
            let mut rule = Vec::new();
            for (way, value) in leaves(entry) {
                let (f, at) = self.named_factor(("exclude", k), &way, factors)?;
                let one = |v: &Value| factors[f].level(v);
                let levels = match (one(value), value) {
                    (Some(level), _) => Some(vec![level]),
                    (None, Value::Array(all)) => all.iter().map(one).collect(),
                    _ => None,
                };
                let levels = levels.ok_or_else(|| self.no_level(&factors[f], value, at))?;
                rule.push((f, levels));
            }
            rules.push(rule);
        }
        Ok(rules)
    }

    fn no_level(&self, factor: &Factor, value: &Value, at: Range<usize>) -> InputError {
        let names: Vec<&str> = factor.levels.iter().map(|l| l.label.as_str()).collect();
        let known = format!("levels of `{}`: {}", factor.name, names.join(", "));
        let help = suggest(&label(value), names.iter().copied()).unwrap_or(known);
        let message = format!("`{}` has no level {value}", factor.name);
        self.error(at, message).remedy(help)
    }

    /// The factor that an entry names, and where its value stands.
    fn named_factor(
        &self,
        (list, k): (&str, usize),
        way: &[String],
        factors: &[Factor],
    ) -> Result<(usize, Range<usize>), InputError> {
        let mut steps = vec![Step::Key(list), Step::Index(k)];
        steps.extend(way.iter().map(|s| Step::Key(s)));
        let (at, name) = (self.place(&steps), way.join("."));
        let found = factors.iter().position(|f| f.name == name);
        let f = found.ok_or_else(|| {
            let names: Vec<&str> = factors.iter().map(|f| f.name.as_str()).collect();
            let known = format!("factors: {}", names.join(", "));
            let help = suggest(&name, names.iter().copied()).unwrap_or(known);
            self.error(at.clone(), format!("`{name}` is no factor of this batch")).remedy(help)
        })?;
        Ok((f, at))
    }

    pub(super) fn included(
        &self,
        (k, entry): (usize, &Table),
        factors: &mut [Factor],
        presets: &mut Vec<Preset>,
    ) -> Result<Vec<usize>, InputError> {
        let mut cell = vec![0; factors.len()];
        for (way, value) in leaves(entry) {
            let (f, at) = self.named_factor(("include", k), &way, factors)?;
            let factor = &mut factors[f];
            cell[f] = match (factor.level(value), factor.kind, value) {
                (Some(level), _, _) => level,
                (None, FactorKind::Field, _) => {
                    factor.levels.push(Level::of_field(&factor.name, value, at));
                    factor.levels.len() - 1
                }
                (None, FactorKind::Planner, Value::String(name)) => {
                    self.add_planner(factor, presets, name, at)?;
                    factor.levels.len() - 1
                }
                (None, FactorKind::Scenario, Value::String(name)) => {
                    factor.levels.push(Level::new(stem(name), value.clone(), at));
                    factor.levels.len() - 1
                }
                (None, FactorKind::Seed, Value::Integer(n)) if *n >= 0 => {
                    factor.levels.push(Level::of_field("seed", value, at));
                    factor.levels.len() - 1
                }
                _ => return Err(self.no_level(factor, value, at)),
            };
            self.refuse_twice(&factors[f])?;
        }
        Ok(cell)
    }
}
