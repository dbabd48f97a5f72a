//! Tables from CSV to Parquet.

use csv::Reader;
use parquet::basic::LogicalType;
use parquet::basic::{Compression, Type};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type as Column;
use std::error::Error;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// Rows that are held and written at a time.
const ROWS: usize = 8192;

/// The type of a column, by its name without unit; those named in `text` are text.
fn kind(name: &str, text: &[&str]) -> Type {
    match name.split(" [").next() {
        _ if text.contains(&name) => Type::BYTE_ARRAY,
        Some("step" | "iteration" | "attempt" | "iterations") => Type::INT64,
        Some("accepted" | "converged") => Type::BOOLEAN,
        _ => Type::DOUBLE,
    }
}

/// Columns, buffered for a part of the rows.
enum Held {
    Numbers(Vec<f64>),
    Words(Vec<ByteArray>),
}

/// Writes the table `path` as Parquet to `target`.
///
/// Columns keep their names. Those named in `text` are text, counts are whole numbers, yes and no Booleans, all others double; a number that is
/// missing is NaN.
pub fn write(path: &Path, target: &Path, text: &[&str]) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut reader = Reader::from_path(path)?;
    let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let kinds: Vec<Type> = names.iter().map(|name| kind(name, text)).collect();
    let column = |(name, kind): (&String, &Type)| {
        let repetition = parquet::basic::Repetition::REQUIRED;
        let builder = Column::primitive_type_builder(name, *kind).with_repetition(repetition);
        let logical = (*kind == Type::BYTE_ARRAY).then_some(LogicalType::String);
        Ok(Arc::new(builder.with_logical_type(logical).build()?))
    };
    let columns = names.iter().zip(&kinds).map(column).collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Arc::new(Column::group_type_builder("table").with_fields(columns).build()?);
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(File::create(target)?, schema, Arc::new(properties))?;
    let empty = |kind: &Type| match *kind {
        Type::BYTE_ARRAY => Held::Words(Vec::new()),
        _ => Held::Numbers(Vec::new()),
    };
    let mut held: Vec<Held> = kinds.iter().map(empty).collect();
    let mut rows = 0;
    for record in reader.records() {
        for (column, field) in held.iter_mut().zip(&record?) {
            match column {
                Held::Numbers(values) if field.is_empty() => values.push(f64::NAN),
                Held::Numbers(values) => values.push(field.parse()?),
                Held::Words(words) => words.push(field.into()),
            }
        }
        rows += 1;
        if rows % ROWS == 0 {
            write_rows(&mut writer, &kinds, &mut held)?;
        }
    }
    if rows % ROWS != 0 {
        write_rows(&mut writer, &kinds, &mut held)?;
    }
    writer.close()?;
    Ok(())
}

fn write_rows(
    writer: &mut SerializedFileWriter<File>,
    kinds: &[Type],
    held: &mut [Held],
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for (kind, held) in kinds.iter().zip(held) {
        let Some(mut column) = group.next_column()? else { break };
        match (*kind, held) {
            (_, Held::Words(words)) => {
                column.typed::<ByteArrayType>().write_batch(words, None, None)?;
                words.clear();
            }
            (kind, Held::Numbers(values)) => {
                match kind {
                    Type::INT64 => {
                        let values: Vec<i64> = values.iter().map(|value| *value as i64).collect();
                        column.typed::<Int64Type>().write_batch(&values, None, None)?;
                    }
                    Type::BOOLEAN => {
                        let values: Vec<bool> = values.iter().map(|value| *value != 0.0).collect();
                        column.typed::<BoolType>().write_batch(&values, None, None)?;
                    }
                    _ => drop(column.typed::<DoubleType>().write_batch(values, None, None)?),
                }
                values.clear();
            }
        }
        column.close()?;
    }
    group.close()?;
    Ok(())
}
