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
        let mut lines = text.lines();
        let names = lines.next().ok_or("is empty")?.split(',').map(|name| name.trim().into());
        let names: Vec<String> = names.collect();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (index, line) in lines.enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let row =
                numbers(line.split(',')).map_err(|text| format!("line {}: {text}", index + 2))?;
            let columns = rows.first().map_or(row.len(), Vec::len);
            if row.len() != columns {
                return Err(format!(
                    "line {} has {} columns, the first row {columns}",
                    index + 2,
                    row.len()
                ));
            }
            rows.push(row);
        }
        if rows.is_empty() { Err("has no rows".into()) } else { Ok(Self { names, rows }) }
    }
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
