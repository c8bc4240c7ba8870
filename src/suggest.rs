//! "Did you mean ...?" for misspelt names.

/// Names in a list of what is known.
const MOST_LISTED: usize = 15;

/// `; did you mean 'name'?` with the most similar of `known`, or their list when none is close.
pub(crate) fn similar<'a>(given: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let nearest = known.clone().map(|name| (distance(given, name), name)).min();
    match nearest {
        Some((edits, name)) if edits <= (given.chars().count() / 3).max(2) => {
            format!("; did you mean '{name}'?")
        }
        Some(_) => {
            let mut list = String::from("; known are");
            for (place, name) in known.clone().take(MOST_LISTED).enumerate() {
                list.push_str(if place == 0 { " " } else { ", " });
                list.push_str(name);
            }
            if known.count() > MOST_LISTED {
                list.push_str(", ...");
            }
            list
        }
        None => String::new(),
    }
}

/// Edits (insert, delete, replace, swap of neighbours, case for nothing) from one name to the other.
fn distance(from: &str, to: &str) -> usize {
    const LONGEST: usize = 64;
    let lower = |text: &str| {
        let mut letters = ['\0'; LONGEST];
        let mut count = 0;
        for letter in text.chars().flat_map(char::to_lowercase).take(LONGEST) {
            letters[count] = letter;
            count += 1;
        }
        (letters, count)
    };
    let ((from, rows), (to, columns)) = (lower(from), lower(to));
    let mut table = [[0_usize; LONGEST + 1]; LONGEST + 1];
    for row in 0..=rows {
        for column in 0..=columns {
            table[row][column] = if row == 0 || column == 0 {
                row + column
            } else {
                let differs = usize::from(from[row - 1] != to[column - 1]);
                let swapped = row > 1
                    && column > 1
                    && from[row - 1] == to[column - 2]
                    && from[row - 2] == to[column - 1];
                let best = (table[row - 1][column] + 1)
                    .min(table[row][column - 1] + 1)
                    .min(table[row - 1][column - 1] + differs);
                if swapped { best.min(table[row - 2][column - 2] + 1) } else { best }
            };
        }
    }
    table[rows][columns]
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [&str; 3] = ["youngs_modulus", "density", "horizon"];

    #[test]
    fn a_misspelt_name_is_put_right() {
        assert_eq!(similar("yongs_modulus", KEYS.into_iter()), "; did you mean 'youngs_modulus'?");
        assert_eq!(similar("Denisty", KEYS.into_iter()), "; did you mean 'density'?");
    }

    #[test]
    fn a_name_like_no_other_lists_them() {
        assert_eq!(
            similar("temperature", KEYS.into_iter()),
            "; known are youngs_modulus, density, horizon"
        );
    }

    #[test]
    fn endless_names_are_cut() {
        let endless = "x".repeat(100_000);
        assert!(similar(&endless, KEYS.into_iter()).contains("did you mean"));
    }
}
