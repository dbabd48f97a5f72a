//! Unstructured grids as VTK's XML, readable without compression.

use super::grid::Grid;
use reservoir::Complex64;
use std::fmt::Write;

/// VTK's number of a quadrilateral.
const QUADRILATERAL: u8 = 9;

/// The file of `grid` with the `name`d complex field as point data: real part, imaginary part and modulus.
pub fn written(grid: &Grid, name: &str, field: &[Complex64]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n",
    );
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        grid.points.len(),
        grid.cells.len()
    );
    let _ = writeln!(text, "<PointData Scalars=\"{name}_modulus\">");
    let mut part = |part: &str, of: fn(&Complex64) -> f64| {
        array(&mut text, "Float64", &format!("{name}_{part}"), 1, field.iter().map(|z| of(z).to_string()));
    };
    part("real", |z| z.re);
    part("imaginary", |z| z.im);
    part("modulus", |z| z.norm());
    text += "</PointData>\n<Points>\n";
    array(&mut text, "Float64", "points", 3, grid.points.iter().map(|[x, y]| format!("{x} {y} 0")));
    text += "</Points>\n<Cells>\n";
    let corners = grid.cells.iter().map(|[a, b, c, d]| format!("{a} {b} {c} {d}"));
    array(&mut text, "Int64", "connectivity", 1, corners);
    array(&mut text, "Int64", "offsets", 1, (1..=grid.cells.len()).map(|cell| (4 * cell).to_string()));
    array(&mut text, "UInt8", "types", 1, grid.cells.iter().map(|_| QUADRILATERAL.to_string()));
    text + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
}

fn array(text: &mut String, kind: &str, name: &str, components: u8, values: impl Iterator<Item = String>) {
    let _ = writeln!(
        text,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">"
    );
    for value in values {
        *text += &value;
        text.push('\n');
    }
    *text += "</DataArray>\n";
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
        let grid = Grid { points, cells: vec![[0, 1, 4, 3], [1, 2, 5, 4]] };
        let field: Vec<Complex64> =
            (0..6).map(|i| Complex64::new(f64::from(i).exp(), -1e-12 * f64::from(i))).collect();
        let (arrays, sizes) = read(&written(&grid, "pressure", &field));
        assert_eq!(sizes, [6, 2]);
        let flat: Vec<f64> = grid.points.iter().flat_map(|[x, y]| [*x, *y, 0.0]).collect();
        assert_eq!(arrays["points"], flat);
        assert_eq!(arrays["pressure_real"], field.iter().map(|z| z.re).collect::<Vec<_>>());
        assert_eq!(arrays["pressure_imaginary"], field.iter().map(|z| z.im).collect::<Vec<_>>());
        assert_eq!(arrays["pressure_modulus"], field.iter().map(|z| z.norm()).collect::<Vec<_>>());
        assert_eq!(arrays["connectivity"], [0.0, 1.0, 4.0, 3.0, 1.0, 2.0, 5.0, 4.0]);
        assert_eq!((arrays["offsets"].clone(), arrays["types"].clone()), (vec![4.0, 8.0], vec![9.0, 9.0]));
    }
}
