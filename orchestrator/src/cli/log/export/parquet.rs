//! Tables of numbers from CSV to Parquet.

use crate::cli::log::Failure;
use csv::Reader;
use parquet::basic::{Compression, Type};
use parquet::data_type::{BoolType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type as Column;
use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows that are held and written at a time.
const ROWS: usize = 8192;

/// Writes the table `path` as Parquet beside it, and removes it.
///
/// Columns keep their names. Counts are whole numbers, yes and no Booleans, all others double.
pub fn convert(path: &Path) -> Result<PathBuf, Failure> {
    let target = path.with_extension("parquet");
    write(path, &target).map_err(|cause| Failure::Write { path: target.clone(), cause })?;
    std::fs::remove_file(path).map_err(|cause| Failure::write(path, cause))?;
    Ok(target)
}

/// The type of a column, by its name without unit.
fn kind(name: &str) -> Type {
    match name.split(" [").next() {
        Some("step" | "iteration" | "attempt" | "iterations") => Type::INT64,
        Some("accepted" | "converged") => Type::BOOLEAN,
        _ => Type::DOUBLE,
    }
}

fn write(path: &Path, target: &Path) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut reader = Reader::from_path(path)?;
    let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let column = |name: &String| {
        let repetition = parquet::basic::Repetition::REQUIRED;
        Ok(Arc::new(Column::primitive_type_builder(name, kind(name)).with_repetition(repetition).build()?))
    };
    let columns = names.iter().map(column).collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Arc::new(Column::group_type_builder("table").with_fields(columns).build()?);
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(File::create_new(target)?, schema, Arc::new(properties))?;
    let mut held: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    for record in reader.records() {
        for (column, field) in held.iter_mut().zip(&record?) {
            column.push(field.parse()?);
        }
        if held.first().is_some_and(|column| column.len() == ROWS) {
            write_rows(&mut writer, &names, &mut held)?;
        }
    }
    write_rows(&mut writer, &names, &mut held)?;
    writer.close()?;
    Ok(())
}

fn write_rows(
    writer: &mut SerializedFileWriter<File>,
    names: &[String],
    held: &mut [Vec<f64>],
) -> Result<(), ParquetError> {
    if held.first().is_none_or(Vec::is_empty) {
        return Ok(());
    }
    let mut group = writer.next_row_group()?;
    for (name, values) in names.iter().zip(held) {
        let Some(mut column) = group.next_column()? else { break };
        match kind(name) {
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
        column.close()?;
        values.clear();
    }
    group.close()?;
    Ok(())
}
