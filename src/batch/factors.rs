//! The factors of a batch file: scenarios, fields, variants, planners and seeds, each with its levels.

use super::columns::is_taken;
use super::file::BatchFile;
use super::matrix::{Factor, FactorKind, Level, Reader, label, stem, tell_apart};
use super::places::{Step, leaves};
use crate::files::{InputError, is_formula};
use crate::planner::{Preset, load_preset, preset_names};
use std::ops::Range;
use std::path::PathBuf;
use toml::{Table, Value};

/// Key of a variant that takes fields away.
const REMOVE: &str = "remove";

impl Reader<'_> {
    pub(super) fn factors(
        &self,
        file: &BatchFile,
    ) -> Result<(Vec<Factor>, Vec<Preset>), InputError> {
        let mut presets = Vec::new();
        let mut scenarios = Vec::new();
        for s in &file.scenarios {
            let value = Value::String(s.get_ref().clone());
            scenarios.push(Level::new(stem(s.get_ref()), value, s.span()));
        }
        if scenarios.is_empty() {
            let at = self.place(&[Step::Key("scenarios")]);
            return Err(self.error(at, "names no scenario").remedy("name at least one file"));
        }
        tell_apart(&mut scenarios);
        let scenario = Factor::new("scenario", FactorKind::Scenario, scenarios);
        let mut inner = self.fields(file)?;
        inner.extend(self.variants(file)?);
        inner.sort_by_key(|f| f.levels.first().map_or(0, |l| l.at.start));
        self.refuse_shared(&inner)?;
        let mut planner = Factor::new("planner", FactorKind::Planner, Vec::new());
        for p in &file.planners {
            self.add_planner(&mut planner, &mut presets, p.get_ref(), p.span())?;
        }
        if planner.levels.is_empty() {
            self.add_planner(&mut planner, &mut presets, "default", 0..0)?;
        }
        tell_apart(&mut planner.levels);
        let seeds = file.seeds.iter().map(|s| {
            let value = Value::Integer(i64::try_from(*s.get_ref()).unwrap_or(i64::MAX));
            let set = vec![("seed".to_owned(), value.clone())];
            Level { set, ..Level::new(label(&value), value, s.span()) }
        });
        let seed = Factor::new("seed", FactorKind::Seed, seeds.collect());
        let mut all = vec![scenario];
        all.extend(inner);
        all.push(planner);
        all.extend(Some(seed).filter(|s| !s.levels.is_empty()));
        for factor in &all {
            self.refuse_twice(factor)?;
        }
        Ok((all, presets))
    }

    pub(super) fn add_planner(
        &self,
        factor: &mut Factor,
        presets: &mut Vec<Preset>,
        name: &str,
        at: Range<usize>,
    ) -> Result<(), InputError> {
        let is_name = preset_names().contains(&name) || !name.contains(['/', '.']);
        let place = if is_name { PathBuf::from(name) } else { self.folder.join(name) };
        let preset = load_preset(&place.to_string_lossy());
        presets.push(preset.map_err(|e| e.named_in(self.path, "planners", self.text, at.clone()))?);
        let shown = if is_name { name.to_owned() } else { stem(name) };
        factor.levels.push(Level::new(shown, Value::String(name.to_owned()), at));
        Ok(())
    }

    fn fields(&self, file: &BatchFile) -> Result<Vec<Factor>, InputError> {
        let mut all = Vec::new();
        for (way, value) in leaves(&file.matrix) {
            let name = way.join(".");
            let steps: Vec<Step> = std::iter::once("matrix")
                .chain(way.iter().map(String::as_str))
                .map(Step::Key)
                .collect();
            let at = self.place(&steps);
            let levels = value.as_array().filter(|a| !a.is_empty()).ok_or_else(|| {
                self.error(at.clone(), format!("`{name}` needs a list of values"))
                    .remedy(format!("{name} = [{value}, ...]"))
            })?;
            self.refuse_name(&name, at)?;
            let levels = levels.iter().enumerate().map(|(k, v)| {
                let at = self.place(&[&steps[..], &[Step::Index(k)]].concat());
                Level::of_field(&name, v, at)
            });
            all.push(Factor::new(&name, FactorKind::Field, levels.collect()));
        }
        Ok(all)
    }

    fn variants(&self, file: &BatchFile) -> Result<Vec<Factor>, InputError> {
        let mut all = Vec::new();
        for (factor, variants) in &file.variant {
            let way = |inner: &[Step<'_>]| {
                self.place(&[&[Step::Key("variant"), Step::Key(factor)], inner].concat())
            };
            self.refuse_name(factor, way(&[]))?;
            let mut levels = Vec::new();
            for (name, fields) in variants {
                let at = way(&[Step::Key(name)]);
                levels.push(self.variant(name, fields, at)?);
            }
            levels.sort_by_key(|l| l.at.start);
            if levels.is_empty() {
                return Err(self.error(way(&[]), format!("`{factor}` has no variants")));
            }
            all.push(Factor::new(factor, FactorKind::Variant, levels));
        }
        Ok(all)
    }

    fn variant(&self, name: &str, fields: &Table, at: Range<usize>) -> Result<Level, InputError> {
        let mut fields = fields.clone();
        let mut remove = Vec::new();
        if let Some(value) = fields.remove(REMOVE) {
            let names = value.as_array().map(|a| a.iter().map(Value::as_str).collect());
            let Some(Some::<Vec<&str>>(names)) = names else {
                let message = format!("`{REMOVE}` is not a list of fields");
                return Err(self.error(at, message).remedy("remove = [\"robot.preset\"]"));
            };
            remove = names.into_iter().map(str::to_owned).collect();
        }
        let set = leaves(&fields).into_iter().map(|(way, v)| (way.join("."), v.clone())).collect();
        self.refuse_formula(name, at.clone())?;
        let value = Value::String(name.to_owned());
        Ok(Level { remove, set, ..Level::new(name.to_owned(), value, at) })
    }

    /// Names of factors and variants stand in tables that spreadsheets open.
    fn refuse_formula(&self, name: &str, at: Range<usize>) -> Result<(), InputError> {
        if !is_formula(name) {
            return Ok(());
        }
        let message =
            format!("the name `{name}` begins as a formula does, which a spreadsheet would run");
        Err(self.error(at, message).remedy("begin it with a letter or a digit"))
    }

    /// Names of factors are columns of the table, among others.
    fn refuse_name(&self, name: &str, at: Range<usize>) -> Result<(), InputError> {
        let own = ["scenario", "planner", "seed"];
        self.refuse_formula(name, at.clone())?;
        if name == "seed" {
            return Err(self.error(at, "`seed` is not set here").remedy("write seeds = [1, 2]"));
        }
        if own.contains(&name) || is_taken(name) || name.trim().is_empty() {
            let message = format!(
                "`{name}` cannot be the name of a factor: the table of results has such a column"
            );
            return Err(self.error(at, message).remedy("choose another name"));
        }
        Ok(())
    }

    /// Two factors that set the same field: one of them would do nothing.
    fn refuse_shared(&self, factors: &[Factor]) -> Result<(), InputError> {
        let overlap = |a: &str, b: &str| {
            let inside = |a: &str, b: &str| a.strip_prefix(b).is_some_and(|r| r.starts_with('.'));
            a == b || inside(a, b) || inside(b, a)
        };
        for (k, factor) in factors.iter().enumerate() {
            for before in &factors[..k] {
                let sets = |f: &Factor| -> Vec<(String, Range<usize>)> {
                    let of = |l: &Level| {
                        l.set.iter().map(|(n, _)| (n.clone(), l.at.clone())).collect::<Vec<_>>()
                    };
                    f.levels.iter().flat_map(of).collect()
                };
                let earlier = sets(before);
                if before.name == factor.name {
                    let at = factor.levels.first().map_or(0..0, |l| l.at.clone());
                    return Err(
                        self.error(at, format!("there are two factors named `{}`", factor.name))
                    );
                }
                for (field, at) in sets(factor) {
                    if earlier.iter().any(|(other, _)| overlap(other, &field)) {
                        let message = format!("`{field}` is set by `{}` as well", before.name);
                        return Err(self.error(at, message).remedy(
                            "let one factor set a field; a variant can set several together",
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    pub(super) fn refuse_twice(&self, factor: &Factor) -> Result<(), InputError> {
        for (k, level) in factor.levels.iter().enumerate() {
            if factor.levels[..k].iter().any(|l| l.label == level.label) {
                let message = format!("`{}` is there twice", level.label);
                return Err(self.error(level.at.clone(), message).remedy("name each value once"));
            }
        }
        Ok(())
    }
}
