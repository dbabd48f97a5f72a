//! Unstructured grids, sets and time series of them in VTK's XML format, uncompressed, for ParaView.

use quick_xml::Reader;
use quick_xml::events::Event;
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
    /// The points of each cell in order: one for a vertex, two for a line, three for a triangle, four for a quadrilateral, six for a
    /// quadratic triangle (corners, then the middles of the sides, the first between the first two corners).
    pub cells: Vec<Vec<usize>>,
    /// Fields on the points.
    pub point_data: Vec<Field>,
    /// Fields on the cells.
    pub cell_data: Vec<Field>,
    /// Numbers that belong to the grid as a whole, by name.
    pub field_data: Vec<(String, Vec<f64>)>,
}

/// An array of a file: its part, its name, its components, its numbers.
type Array = (String, String, usize, Vec<f64>);

const HEAD: &str = "<?xml version=\"1.0\"?>\n";

impl Grid {
    /// The values of a field on the points.
    pub fn point_field(&self, name: &str) -> Option<&[f64]> {
        self.point_data.iter().find(|field| field.name == name).map(|field| &field.values[..])
    }

    /// The grid in a `.vtu` file that [`vtu`](Self::vtu) wrote; none in any other text.
    pub fn of_vtu(text: &str) -> Option<Self> {
        let arrays = arrays(text)?;
        let of = |part: &str| -> Vec<Field> {
            let own = arrays.iter().filter(|(of, ..)| of == part);
            own.map(|(_, name, components, values)| Field {
                name: name.clone(),
                components: *components,
                values: values.clone(),
            })
            .collect()
        };
        let array = |part: &str, name: &str| {
            of(part).into_iter().find(|field| field.name == name).map(|field| field.values)
        };
        let points: Vec<[f64; 2]> =
            array("Points", "points")?.as_chunks::<3>().0.iter().map(|[x, y, _]| [*x, *y]).collect();
        let connectivity = array("Cells", "connectivity")?;
        let mut cells: Vec<Vec<usize>> = Vec::new();
        let mut first = 0;
        for end in array("Cells", "offsets")? {
            let cell: Vec<usize> =
                connectivity.get(first..end as usize)?.iter().map(|node| *node as usize).collect();
            if cell.iter().any(|node| *node >= points.len()) {
                return None;
            }
            cells.push(cell);
            first = end as usize;
        }
        let fits =
            |fields: &[Field], count: usize| fields.iter().all(|f| f.values.len() == f.components * count);
        let (point_data, cell_data) = (of("PointData"), of("CellData"));
        let field_data = of("FieldData").into_iter().map(|field| (field.name, field.values)).collect();
        let whole = fits(&point_data, points.len()) && fits(&cell_data, cells.len());
        whole.then_some(Self { points, cells, point_data, cell_data, field_data })
    }

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
        // VTK's numbers of vertex, line, triangle, quadrilateral and, for six, quadratic triangle
        let kinds = self.cells.iter().map(|cell| [1, 3, 5, 9, 9, 22][cell.len().clamp(1, 6) - 1]);
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

/// The arrays of a whole file; none if it is not well-formed, or something else than a number is in them.
fn arrays(text: &str) -> Option<Vec<Array>> {
    let mut reader = Reader::from_str(text);
    let (mut open, mut arrays) = (Vec::<String>::new(), Vec::<Array>::new());
    loop {
        match reader.read_event().ok()? {
            Event::Start(start) => {
                let attribute = |key: &str| Some(start.try_get_attribute(key).ok()??.value.into_owned());
                let name = start.name().as_ref().to_owned();
                if name == "DataArray" {
                    let components = attribute("NumberOfComponents").map_or(Some(1), |n| n.parse().ok())?;
                    arrays.push((open.last()?.clone(), attribute("Name")?, components, Vec::new()));
                }
                open.push(name);
            }
            Event::Text(content) => {
                if open.last().is_some_and(|name| name == "DataArray")
                    && let Some((_, _, _, values)) = arrays.last_mut()
                {
                    for number in content.split_whitespace() {
                        values.push(number.parse().ok()?);
                    }
                }
            }
            Event::End(_) => drop(open.pop()),
            Event::Eof => return open.is_empty().then_some(arrays),
            _ => {}
        }
    }
}

/// The text of a `.vtm` file: the files of parts by their names, as blocks.
pub fn blocks(parts: &[(&str, &str)]) -> String {
    let mut text = String::from(HEAD);
    text += "<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" byte_order=\"LittleEndian\">\n<vtkMultiBlockDataSet>\n";
    for (index, (name, file)) in parts.iter().enumerate() {
        let _ = writeln!(text, "<DataSet index=\"{index}\" name=\"{name}\" file=\"{file}\"/>");
    }
    text + "</vtkMultiBlockDataSet>\n</VTKFile>\n"
}

/// The text of a `.pvd` file: at each time (s) the names of its parts and their files.
pub fn series(files: &[(f64, Vec<(String, String)>)]) -> String {
    let mut text = String::from(HEAD);
    text += "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n";
    for (time, parts) in files {
        for (part, (name, file)) in parts.iter().enumerate() {
            let _ = writeln!(
                text,
                "<DataSet timestep=\"{time}\" group=\"\" part=\"{part}\" name=\"{name}\" file=\"{file}\"/>"
            );
        }
    }
    text + "</Collection>\n</VTKFile>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back_bit_for_bit() {
        let points: Vec<[f64; 2]> =
            (0..6).map(|i| [f64::from(i % 3) / 3.0 - 1e-7, f64::from(i / 3) * 1e5]).collect();
        let values: Vec<f64> = (0..6).map(|i| f64::from(i).exp()).collect();
        let grid = Grid {
            cells: vec![vec![0, 1, 4, 3], vec![1, 2, 5], vec![2, 5], vec![0], vec![0, 2, 3, 1, 5, 4]],
            point_data: vec![
                Field::scalar("pressure", values.clone()),
                Field::vector("displacement", values.iter().map(|v| [*v, -1e-12 * v])),
            ],
            cell_data: vec![Field::scalar("stress", values[..5].to_vec())],
            field_data: vec![("frequency [rad/s]".to_owned(), vec![0.1, 1.0 / 3.0])],
            points,
        };
        let text = grid.vtu();
        assert_eq!(Grid::of_vtu(&text), Some(grid.clone()));
        assert!(text.contains("<Piece NumberOfPoints=\"6\" NumberOfCells=\"5\">"), "{text}");
        let (_, types) = text.split_once("Name=\"types\"").expect("types");
        let types: Vec<&str> = types.split_whitespace().skip(2).take(5).collect();
        assert_eq!(
            types,
            ["9", "5", "3", "1", "22"],
            "quadrilateral, triangle, line, vertex, quadratic triangle"
        );
        for cut in [text.len() / 2, text.len() - 40] {
            assert_eq!(Grid::of_vtu(&text[..cut]), None, "a file that ends early");
        }
        assert_eq!(Grid::of_vtu(&text.replacen("Name=\"offsets\"", "Name=\"ends\"", 1)), None);
        assert_eq!(grid.point_field("pressure"), Some(&values[..]));
        assert_eq!(grid.point_field("temperature"), None);
    }

    #[test]
    fn a_series_and_a_set_name_every_part() {
        let parts = [("dam", "a.vtu"), ("cracks", "b.vtu")];
        let at = parts.map(|(name, file)| (name.to_owned(), file.to_owned())).to_vec();
        let text = series(&[(0.25, at)]);
        let named = "part=\"1\" name=\"cracks\" file=\"b.vtu\"/>";
        assert!(text.contains("timestep=\"0.25\"") && text.contains(named), "{text}");
        let text = blocks(&parts);
        assert!(text.contains("<DataSet index=\"1\" name=\"cracks\" file=\"b.vtu\"/>"), "{text}");
    }
}
