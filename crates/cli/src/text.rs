//! How results are written: tables and numbers for people, JSON for programs.

use std::fmt::Write;

use serde::Serialize;

/// Appends aligned columns under their heads: the last is of any width, and the columns of numbers end together.
pub(crate) fn push_table<const N: usize>(
    text: &mut String,
    heads: [&str; N],
    is_number: [bool; N],
    rows: &[[String; N]],
) {
    let heads = heads.map(str::to_owned);
    let lines = || std::iter::once(&heads).chain(rows);
    let widths: [usize; N] =
        std::array::from_fn(|column| lines().map(|line| line[column].chars().count()).max().unwrap_or(0));
    for line in lines() {
        let mut padded = String::new();
        for ((cell, width), is_number) in line.iter().zip(widths).zip(is_number) {
            let _ = if is_number {
                write!(padded, "{cell:>width$}  ")
            } else {
                write!(padded, "{cell:<width$}  ")
            };
        }
        text.push_str(padded.trim_end());
        text.push('\n');
    }
}

/// A count with a comma before every three digits. What is in words, as where nobody can count, stays as it is.
pub(crate) fn grouped(count: impl ToString) -> String {
    let digits = count.to_string();
    if !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return digits;
    }
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A count with commas, or its order of magnitude if that is long.
pub(crate) fn short(count: impl ToString) -> String {
    let digits = count.to_string();
    if digits.len() <= 30 { grouped(digits) } else { format!("about 10^{}", digits.len() - 1) }
}

/// A time to three digits.
pub(crate) fn seconds(seconds: f64) -> String {
    if seconds < 1e-3 {
        format!("{:.0} µs", seconds * 1e6)
    } else if seconds < 1.0 {
        format!("{:.1} ms", seconds * 1e3)
    } else {
        format!("{seconds:.2} s")
    }
}

/// A report for programs.
pub(crate) fn json(report: &impl Serialize) -> String {
    serde_json::to_string_pretty(report).expect("a report has only strings and numbers") + "\n"
}
