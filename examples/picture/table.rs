//! Reads `.csv` files: a line of names, then rows of numbers.

use std::fs;

pub struct Table {
    pub names: Vec<String>,
    /// All of one length, and at least one.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    pub fn read(path: &str) -> Result<Self, String> {
        let text =
            fs::read_to_string(path).map_err(|reason| format!("cannot be read: {reason}"))?;
        let (names, lines) = rows_of(&text)?;
        let names = names.into_iter().map(str::to_owned).collect();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (line, row) in lines {
            let row = numbers(row.into_iter()).map_err(|text| format!("line {line}: {text}"))?;
            let columns = rows.first().map_or(row.len(), Vec::len);
            if row.len() != columns {
                return Err(format!(
                    "line {line} has {} columns, the first row {columns}",
                    row.len()
                ));
            }
            rows.push(row);
        }
        if rows.is_empty() { Err("has no rows".into()) } else { Ok(Self { names, rows }) }
    }
}

/// Texts in the columns of a line.
type Columns<'a> = Vec<&'a str>;

/// The names in the first line, and what stands in the others that are not blank, with their numbers.
pub fn rows_of(
    text: &str,
) -> Result<(Columns<'_>, impl Iterator<Item = (usize, Columns<'_>)>), String> {
    fn columns(line: &str) -> Columns<'_> {
        line.split(',').map(str::trim).collect()
    }
    let mut lines = text.lines().zip(1..);
    let (names, _) = lines.next().ok_or("is empty")?;
    let rows = lines.filter(|(line, _)| !line.trim().is_empty());
    Ok((columns(names), rows.map(|(line, number)| (number, columns(line)))))
}

/// Numbers, all of them finite.
pub fn numbers<'a>(texts: impl Iterator<Item = &'a str>) -> Result<Vec<f64>, String> {
    let number = |text: &str| {
        let value = text.trim().parse().ok().filter(|value: &f64| value.is_finite());
        value.ok_or(format!("'{text}' is no finite number"))
    };
    texts.map(number).collect()
}

/// The least and the greatest of some numbers.
pub fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    })
}
