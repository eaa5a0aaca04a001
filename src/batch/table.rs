//! `cells.csv`, `cells.parquet` and `columns.csv`: the same rows twice, and what their columns mean.
//!
//! A row for each body along each path, cells in order and paths by rank; a cell without a scored path has
//! one row that says why. No time, date or place is written, so that the same cells give the same bytes.

use super::columns::{AFTER, Kind, OF_CELL, Value, columns};
use super::manifest::{Finished, PlannedFactor};
use super::record::PathRow;
use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::sync::Arc;
use thiserror::Error;

/// A table could not be made.
#[derive(Debug, Error)]
pub enum TableError {
    /// As CSV.
    #[error("table: {0}")]
    Csv(#[from] csv::Error),
    /// As Parquet.
    #[error("Parquet: {0}")]
    Parquet(#[from] ParquetError),
}

/// A column with its values in all rows.
struct Filled {
    name: String,
    kind: Kind,
    unit: String,
    about: String,
    values: Vec<Value>,
}

/// The three files, as (name, bytes).
///
/// # Errors
/// None but of the machine.
pub fn tables(finished: &Finished) -> Result<Vec<(String, Vec<u8>)>, TableError> {
    let filled = filled(finished);
    Ok(vec![
        ("cells.csv".to_owned(), csv(&filled)?),
        ("cells.parquet".to_owned(), parquet(&filled)?),
        ("columns.csv".to_owned(), described(&filled)?),
    ])
}

/// Every row by cell: its number from 0, and the body along a path if there is one.
fn rows(finished: &Finished) -> Vec<(usize, Option<&PathRow>)> {
    let mut all = Vec::new();
    for (k, record) in finished.records.iter().enumerate() {
        if record.rows.is_empty() {
            all.push((k, None));
        }
        all.extend(record.rows.iter().map(|r| (k, Some(r))));
    }
    all
}

fn filled(finished: &Finished) -> Vec<Filled> {
    let rows = rows(finished);
    let (plan, records) = (&finished.plan, &finished.records);
    let column = |name: &str, about: &str, kind: Kind, of: &dyn Fn(usize) -> Value| Filled {
        name: name.to_owned(),
        kind,
        unit: String::new(),
        about: about.to_owned(),
        values: rows.iter().map(|(k, _)| of(*k)).collect(),
    };
    let text = |t: &str| Value::Text(t.to_owned());
    let [cell, state, reason] = OF_CELL;
    let mut all = vec![column(cell.0, cell.1, Kind::Whole, &|k| (k + 1).into())];
    for (f, factor) in plan.factors.iter().enumerate() {
        let level = |k: usize| plan.cells[k].levels[f];
        let (kind, of): (Kind, Box<dyn Fn(usize) -> Value>) = match &factor.numbers {
            Some(numbers) => (Kind::Number, Box::new(move |k| numbers[level(k)].into())),
            None => (Kind::Text, Box::new(move |k| text(&factor.levels[level(k)]))),
        };
        all.push(column(&factor.name, &about(factor), kind, &of));
    }
    all.push(column(state.0, state.1, Kind::Text, &|k| records[k].state.name().into()));
    all.push(column(reason.0, reason.1, Kind::Text, &|k| records[k].reason.as_deref().into()));
    for (i, c) in columns().iter().enumerate() {
        let value = |row: Option<&PathRow>| row.and_then(|r| r.values.get(i).cloned());
        all.push(Filled {
            name: c.name.to_owned(),
            kind: c.kind,
            unit: c.unit.to_owned(),
            about: c.about.to_owned(),
            values: rows.iter().map(|(_, r)| value(*r).unwrap_or(Value::None)).collect(),
        });
    }
    let [version, key] = AFTER;
    all.push(column(version.0, version.1, Kind::Text, &|k| {
        records[k].program_version.as_str().into()
    }));
    all.push(column(key.0, key.1, Kind::Text, &|k| records[k].key.as_str().into()));
    all
}

fn about(factor: &PlannedFactor) -> String {
    use super::matrix::FactorKind as K;
    match factor.kind {
        K::Scenario => "Factor: the scenario file.".to_owned(),
        K::Field => format!("Factor: the field `{}` of the scenario.", factor.name),
        K::Variant => {
            format!("Factor: the variant of `{}`, fields that are set together.", factor.name)
        }
        K::Planner => "Factor: the planner.".to_owned(),
        K::Seed => "Factor: the seed of all randomness.".to_owned(),
    }
}

fn shown(value: &Value) -> String {
    match value {
        Value::None => String::new(),
        Value::Flag(v) => v.to_string(),
        Value::Whole(v) => v.to_string(),
        Value::Number(v) => v.to_string(),
        Value::Text(v) => v.clone(),
    }
}

fn csv(filled: &[Filled]) -> Result<Vec<u8>, TableError> {
    let mut table = ::csv::Writer::from_writer(Vec::new());
    table.write_record(filled.iter().map(|c| &c.name))?;
    let count = filled.first().map_or(0, |c| c.values.len());
    for k in 0..count {
        table.write_record(filled.iter().map(|c| shown(&c.values[k])))?;
    }
    finish(table)
}

fn described(filled: &[Filled]) -> Result<Vec<u8>, TableError> {
    let mut table = ::csv::Writer::from_writer(Vec::new());
    table.write_record(["column", "unit", "type", "meaning"])?;
    for c in filled {
        let kind = match c.kind {
            Kind::Flag => "yes or no",
            Kind::Whole => "whole number",
            Kind::Number => "number",
            Kind::Text => "text",
        };
        table.write_record([c.name.as_str(), &c.unit, kind, &c.about])?;
    }
    finish(table)
}

fn finish(table: ::csv::Writer<Vec<u8>>) -> Result<Vec<u8>, TableError> {
    table.into_inner().map_err(|e| TableError::Csv(e.into_error().into()))
}

fn parquet(filled: &[Filled]) -> Result<Vec<u8>, TableError> {
    let fields = filled.iter().map(|c| {
        let field = Type::primitive_type_builder(&c.name, physical(c.kind));
        let field = field.with_repetition(Repetition::OPTIONAL);
        let field = if c.kind == Kind::Text {
            field
                .with_logical_type(Some(LogicalType::String))
                .with_converted_type(ConvertedType::UTF8)
        } else {
            field
        };
        field.build().map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("cells").with_fields(fields).build()?);
    // What each column means goes with the file.
    let about = filled.iter().map(|c| KeyValue::new(c.name.clone(), c.about.clone())).collect();
    let properties = WriterProperties::builder().set_key_value_metadata(Some(about)).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for c in filled {
        write_column(&mut group, c)?;
    }
    group.close()?;
    Ok(writer.into_inner()?)
}

fn physical(kind: Kind) -> Physical {
    match kind {
        Kind::Flag => Physical::BOOLEAN,
        Kind::Whole => Physical::INT64,
        Kind::Number => Physical::DOUBLE,
        Kind::Text => Physical::BYTE_ARRAY,
    }
}

fn write_column(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    column: &Filled,
) -> Result<(), ParquetError> {
    let Some(mut writer) = group.next_column()? else { return Ok(()) };
    /// Levels of definition (0 where there is no value), and the values that there are.
    macro_rules! write {
        ($kind:ty, $pick:expr) => {{
            let values: Vec<Option<_>> = column.values.iter().map($pick).collect();
            let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_some())).collect();
            let values: Vec<_> = values.into_iter().flatten().collect();
            writer.typed::<$kind>().write_batch(&values, Some(&levels), None)?;
        }};
    }
    match column.kind {
        Kind::Flag => write!(BoolType, |v| if let Value::Flag(b) = v { Some(*b) } else { None }),
        Kind::Whole => write!(Int64Type, |v| if let Value::Whole(n) = v { Some(*n) } else { None }),
        Kind::Number => write!(DoubleType, Value::number),
        Kind::Text => write!(ByteArrayType, |v| match v {
            Value::Text(text) => Some(ByteArray::from(text.as_str())),
            _ => None,
        }),
    }
    writer.close()
}
