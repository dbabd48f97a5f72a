//! Unstructured grids and time series of them in VTK's XML format, uncompressed, for ParaView.

use std::fmt::Write;

/// A field on the points or on the cells of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name.
    pub name: String,
    /// Components of a value: 1, or 3 for a vector.
    pub components: usize,
    /// The values, point after point or cell after cell.
    pub values: Vec<f64>,
}

impl Field {
    /// One value a point or cell.
    pub fn scalar(name: &str, values: Vec<f64>) -> Self {
        Self { name: name.to_owned(), components: 1, values }
    }

    /// A plane vector at each point or cell.
    pub fn vector(name: &str, values: impl Iterator<Item = [f64; 2]>) -> Self {
        let values = values.flat_map(|[x, y]| [x, y, 0.0]).collect();
        Self { name: name.to_owned(), components: 3, values }
    }
}

/// An unstructured grid in the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Points, m.
    pub points: Vec<[f64; 2]>,
    /// The points of each cell in order: one for a vertex, two for a line, three for a triangle, four for a
    /// quadrilateral.
    pub cells: Vec<Vec<usize>>,
    /// Fields on the points.
    pub point_data: Vec<Field>,
    /// Fields on the cells.
    pub cell_data: Vec<Field>,
    /// Numbers that belong to the grid as a whole, by name.
    pub field_data: Vec<(String, Vec<f64>)>,
}

const HEAD: &str = "<?xml version=\"1.0\"?>\n";

impl Grid {
    /// The text of its `.vtu` file.
    pub fn vtu(&self) -> String {
        let mut text = String::from(HEAD);
        text += "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
        text += "<UnstructuredGrid>\n";
        if !self.field_data.is_empty() {
            text += "<FieldData>\n";
            for (name, values) in &self.field_data {
                array(&mut text, "Float64", name, ("NumberOfTuples", values.len()), values.iter());
            }
            text += "</FieldData>\n";
        }
        // Writing to a string cannot fail.
        let (points, cells) = (self.points.len(), self.cells.len());
        let _ = writeln!(text, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
        for (part, fields) in [("PointData", &self.point_data), ("CellData", &self.cell_data)] {
            let _ = writeln!(text, "<{part}>");
            for Field { name, components, values } in fields {
                let size = ("NumberOfComponents", *components);
                array(&mut text, "Float64", name, size, values.iter());
            }
            let _ = writeln!(text, "</{part}>");
        }
        text += "<Points>\n";
        let size = |components| ("NumberOfComponents", components);
        array(&mut text, "Float64", "points", size(3), self.points.iter().flat_map(|[x, y]| [*x, *y, 0.0]));
        text += "</Points>\n<Cells>\n";
        array(&mut text, "Int64", "connectivity", size(1), self.cells.iter().flatten());
        let ends = self.cells.iter().scan(0, |end, cell| {
            *end += cell.len();
            Some(*end)
        });
        array(&mut text, "Int64", "offsets", size(1), ends);
        // VTK's numbers of vertex, line, triangle, quadrilateral
        let kinds = self.cells.iter().map(|cell| [1, 3, 5, 9][cell.len().clamp(1, 4) - 1]);
        array(&mut text, "UInt8", "types", size(1), kinds);
        text + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
    }
}

fn array(
    text: &mut String,
    kind: &str,
    name: &str,
    (size, number): (&str, usize),
    values: impl Iterator<Item = impl std::fmt::Display>,
) {
    let _ =
        writeln!(text, "<DataArray type=\"{kind}\" Name=\"{name}\" {size}=\"{number}\" format=\"ascii\">");
    for value in values {
        let _ = writeln!(text, "{value}");
    }
    *text += "</DataArray>\n";
}

/// The text of a `.pvd` file: at each time (s) the files of its parts.
pub fn series(files: &[(f64, Vec<String>)]) -> String {
    let mut text = String::from(HEAD);
    text += "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
    for (time, parts) in files {
        for (part, file) in parts.iter().enumerate() {
            let _ = writeln!(text, "<DataSet timestep=\"{time}\" part=\"{part}\" file=\"{file}\"/>");
        }
    }
    text + "</Collection>\n</VTKFile>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use quick_xml::Reader;
    use quick_xml::events::Event;
    use std::collections::BTreeMap;

    /// The arrays of a file by name, and the numbers of points and cells that it announces.
    fn read(text: &str) -> (BTreeMap<String, Vec<f64>>, [usize; 2]) {
        let mut reader = Reader::from_str(text);
        let (mut arrays, mut sizes, mut name) = (BTreeMap::new(), [0; 2], None::<String>);
        loop {
            match reader.read_event().expect("well-formed XML") {
                Event::Start(start) => {
                    let attribute = |key: &str| {
                        let found = start.try_get_attribute(key).expect("attributes");
                        found.map(|a| a.value.into_owned())
                    };
                    if let (Some(points), Some(cells)) =
                        (attribute("NumberOfPoints"), attribute("NumberOfCells"))
                    {
                        sizes = [points, cells].map(|n| n.parse().expect("a number"));
                    }
                    name = attribute("Name");
                }
                Event::Text(content) => {
                    if let Some(name) = name.take() {
                        let numbers = content.split_whitespace().map(|n| n.parse().expect("a number"));
                        arrays.insert(name, numbers.collect());
                    }
                }
                Event::Eof => return (arrays, sizes),
                _ => {}
            }
        }
    }

    #[test]
    fn what_is_written_is_read_back_bit_for_bit() {
        let points: Vec<[f64; 2]> =
            (0..6).map(|i| [f64::from(i % 3) / 3.0 - 1e-7, f64::from(i / 3) * 1e5]).collect();
        let values: Vec<f64> = (0..6).map(|i| f64::from(i).exp()).collect();
        let grid = Grid {
            cells: vec![vec![0, 1, 4, 3], vec![1, 2, 5], vec![2, 5], vec![0]],
            point_data: vec![
                Field::scalar("pressure", values.clone()),
                Field::vector("displacement", values.iter().map(|v| [*v, -1e-12 * v])),
            ],
            cell_data: vec![Field::scalar("stress", values[..4].to_vec())],
            field_data: vec![("frequency [rad/s]".to_owned(), vec![0.1, 1.0 / 3.0])],
            points,
        };
        let (arrays, sizes) = read(&grid.vtu());
        assert_eq!(sizes, [6, 4]);
        let flat: Vec<f64> = grid.points.iter().flat_map(|[x, y]| [*x, *y, 0.0]).collect();
        assert_eq!(arrays["points"], flat);
        for field in grid.point_data.iter().chain(&grid.cell_data) {
            assert_eq!(arrays[&field.name], field.values, "{}", field.name);
        }
        assert_eq!(arrays["frequency [rad/s]"], grid.field_data[0].1);
        assert_eq!(arrays["connectivity"], [0.0, 1.0, 4.0, 3.0, 1.0, 2.0, 5.0, 2.0, 5.0, 0.0]);
        assert_eq!(arrays["offsets"], [4.0, 7.0, 9.0, 10.0]);
        assert_eq!(arrays["types"], [9.0, 5.0, 3.0, 1.0]);
    }

    #[test]
    fn a_series_names_every_part_at_its_time() {
        let text = series(&[(0.25, vec!["a.vtu".to_owned(), "b.vtu".to_owned()])]);
        assert!(text.contains("<DataSet timestep=\"0.25\" part=\"1\" file=\"b.vtu\"/>"), "{text}");
    }
}
