//! Tables as data: a column has its names, its heading and its value in one place, and every format has one writer.

use itertools::Itertools as _;

use super::ReportError;
use super::format::{NONE, optional, percent, percent_with_interval, significant, statistic, thousands, with_interval};
use super::markdown::{inline, literal};
use crate::results::{Accuracy, Percentiles, Ratio, Times};
use crate::studies::pareto::Amount;

/// What a row has in a column. Programs read all digits, people those that matter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    None,
    /// What such a row cannot have: a column of nothing else is left out.
    Absent,
    Text(String),
    /// A name that users give, in which nothing is markup.
    Name(String),
    /// Words for programs, and for people.
    Named(String, String),
    Flag(bool),
    Count(u64),
    /// Bytes; people read MiB.
    Bytes(f64),
    /// What a structure says of itself.
    Statistic(f64),
    /// A number, to so many digits.
    Number(f64, usize),
    /// A number with its interval, to so many digits.
    Measured(f64, Option<[f64; 2]>, usize),
    /// A share of so many rays with its interval, if it has one; people read percent.
    Share(f64, Option<[f64; 2]>, u64),
    /// A share of any number with its interval; people read percent, to three digits.
    Percent(f64, [f64; 2]),
    /// How often answers are right.
    Accuracy(Accuracy),
    /// Three shares of so many rays.
    Shares([Option<f64>; 3], u64),
    /// Median, 95th and 99th percentile.
    Percentiles(Percentiles),
    /// Parts of a whole: name, share, colour.
    Parts(Vec<(String, f64, String)>),
}

impl Cell {
    /// A number to so many digits, where there is one.
    pub(crate) fn number(value: impl Into<Option<f64>>, digits: usize) -> Self {
        value.into().map_or(Self::None, |value| Self::Number(value, digits))
    }

    /// The number, if it is one: of a number with an interval itself, of percentiles the median.
    pub(crate) fn value(&self) -> Option<f64> {
        match self {
            Self::Count(count) => Some(*count as f64),
            Self::Bytes(value)
            | Self::Statistic(value)
            | Self::Number(value, _)
            | Self::Measured(value, ..)
            | Self::Share(value, ..)
            | Self::Percent(value, _) => Some(*value),
            Self::Accuracy(accuracy) => accuracy.share,
            Self::Percentiles(percentiles) => percentiles.p50,
            _ => None,
        }
    }

    /// As programs read it: its parts, each with what it adds to its column's name. A number has the ends of its interval, too.
    fn fields(&self) -> Vec<(&'static str, String)> {
        let one = |text: String| vec![("", text)];
        let three =
            |ends: [&'static str; 3], values: [Option<f64>; 3]| ends.into_iter().zip(values.map(number)).collect();
        let interval = match self {
            Self::Measured(_, interval, _) | Self::Share(_, interval, _) => *interval,
            Self::Percent(_, interval) => Some(*interval),
            Self::Accuracy(accuracy) => accuracy.interval,
            _ => None,
        };
        match self {
            Self::None | Self::Absent => Vec::new(),
            Self::Text(text) | Self::Name(text) | Self::Named(text, _) => one(text.clone()),
            Self::Flag(flag) => one(flag.to_string()),
            Self::Count(count) => one(count.to_string()),
            Self::Parts(_) => one(self.describe()),
            Self::Percentiles(Percentiles { p50, p95, p99 }) => three(["_p50", "_p95", "_p99"], [*p50, *p95, *p99]),
            Self::Shares(shares, _) => three(["_hit_miss", "_tight", "_footprint"], *shares),
            other => match interval {
                Some([low, high]) => three(["", "_low", "_high"], [other.value(), Some(low), Some(high)]),
                None => one(number(other.value())),
            },
        }
    }

    /// As people read it.
    pub(crate) fn describe(&self) -> String {
        match self {
            Self::None | Self::Absent => NONE.to_owned(),
            Self::Text(text) | Self::Name(text) | Self::Named(_, text) => text.clone(),
            Self::Flag(flag) => if *flag { "yes" } else { "no" }.to_owned(),
            Self::Count(count) => thousands(*count),
            Self::Bytes(bytes) => significant(bytes / f64::from(1 << 20), 4),
            Self::Statistic(value) => statistic(*value),
            Self::Number(value, digits) => significant(*value, *digits),
            Self::Measured(value, interval, digits) => with_interval(*value, interval.unwrap_or([*value; 2]), *digits),
            Self::Share(share, interval, trials) => percent_with_interval(*share, *interval, *trials),
            Self::Percent(value, interval) => with_interval(value * 100.0, interval.map(|end| end * 100.0), 3),
            Self::Accuracy(Accuracy { share: None, one_sided: None, .. }) => "every ray is ambiguous".to_owned(),
            Self::Accuracy(Accuracy { share, interval, wrong, trials, one_sided }) => {
                let right = |share: &f64| percent_with_interval(*share, *interval, *trials);
                let right = one_sided.map(str::to_owned).or(share.as_ref().map(right)).unwrap_or_default();
                format!("{right}; {} wrong of {}", thousands(*wrong), thousands(*trials))
            }
            Self::Parts(parts) => {
                let told = |(name, share, _): &(String, f64, String)| format!("{name} {:.1} %", share * 100.0);
                parts.iter().map(told).join(", ")
            }
            Self::Shares(shares, trials) => {
                let told = |share: Option<f64>| share.map_or_else(|| NONE.to_owned(), |share| percent(share, *trials));
                format!("{} %", shares.map(told).join(" / "))
            }
            Self::Percentiles(Percentiles { p50, p95, p99 }) => {
                [p50, p95, p99].map(|percentile| optional(*percentile, 3)).join(" / ")
            }
        }
    }
}

/// How values of a type stand in cells.
macro_rules! cell_from {
    ($($from:ty: $pattern:pat => $cell:expr;)+) => {$(
        impl From<$from> for Cell {
            fn from($pattern: $from) -> Self {
                $cell
            }
        }
    )+};
}

cell_from! {
    String: text => Self::Text(text);
    &str: text => Self::Text(text.to_owned());
    bool: flag => Self::Flag(flag);
    u32: count => Self::Count(count.into());
    u64: count => Self::Count(count);
    f64: value => Self::Number(value, 4);
    Percentiles: percentiles => Self::Percentiles(percentiles);
    Amount: amount => Self::Measured(amount.value, Some(amount.interval), 4);
    Ratio: ratio => Self::Measured(ratio.value, Some(ratio.interval), 3);
    // A median with its interval, where anything was timed.
    &Times: times => match times.samples_ms.is_empty() {
        true => Self::None,
        false => Self::Measured(times.median_ms, Some(times.interval_ms), 4),
    };
}

impl<C: Into<Cell>> From<Option<C>> for Cell {
    fn from(cell: Option<C>) -> Self {
        cell.map_or(Self::None, Into::into)
    }
}

/// A column over rows of a kind.
pub(crate) struct Column<'a, R> {
    /// Its name in tables for programs, with the unit at its end.
    name: Option<String>,
    /// What it is called on pages.
    heading: Option<String>,
    cell: Box<dyn Fn(&R) -> Cell + 'a>,
}

impl<'a, R> Column<'a, R> {
    /// A column for programs.
    pub(crate) fn csv<C: Into<Cell>>(name: impl Into<String>, cell: impl Fn(&R) -> C + 'a) -> Self {
        Self { name: Some(name.into()), heading: None, cell: Box::new(move |row| cell(row).into()) }
    }

    /// A column for people.
    pub(crate) fn new<C: Into<Cell>>(heading: impl Into<String>, cell: impl Fn(&R) -> C + 'a) -> Self {
        Self { name: None, heading: Some(heading.into()), cell: Box::new(move |row| cell(row).into()) }
    }

    /// For people too.
    pub(crate) fn headed(self, heading: impl Into<String>) -> Self {
        Self { heading: Some(heading.into()), ..self }
    }

    /// The same over rows some of which have such a row.
    fn of<S: 'a>(self, row: impl Fn(&S) -> Option<&R> + 'a) -> Column<'a, S>
    where
        R: 'a,
    {
        let Self { name, heading, cell } = self;
        Column { name, heading, cell: Box::new(move |of| row(of).map_or(Cell::None, &cell)) }
    }
}

/// Columns that go together.
pub(crate) type Columns<'a, R> = Vec<Column<'a, R>>;

/// A table: each format shows the columns that have a name there.
pub(crate) struct Sheet<'a, R> {
    columns: Columns<'a, R>,
}

impl<'a, R> Sheet<'a, R> {
    /// A table without columns.
    pub(crate) fn new() -> Self {
        Self { columns: Vec::new() }
    }

    /// With further columns.
    pub(crate) fn with(mut self, columns: Columns<'a, R>) -> Self {
        self.columns.extend(columns);
        self
    }

    /// With a further column.
    pub(crate) fn and(mut self, column: Column<'a, R>) -> Self {
        self.columns.push(column);
        self
    }

    /// With a column for programs.
    pub(crate) fn csv_column<C: Into<Cell>>(self, name: &str, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.and(Column::csv(name, cell))
    }

    /// With what another tells of those of its rows that some of these have.
    pub(crate) fn columns_of<S: 'a>(self, other: Sheet<'a, S>, row: impl Fn(&R) -> Option<&S> + Copy + 'a) -> Self
    where
        R: 'a,
    {
        self.with(other.columns.into_iter().map(|column| column.of(row)).collect())
    }

    /// With a column for people.
    pub(crate) fn column<C: Into<Cell>>(self, heading: impl Into<String>, cell: impl Fn(&R) -> C + 'a) -> Self {
        self.and(Column::new(heading, cell))
    }

    /// The table over some rows, without the columns that none of them can have.
    pub(crate) fn table(&self, rows: &[R]) -> Table {
        let mut columns = Vec::new();
        let mut cells: Vec<Vec<Cell>> = rows.iter().map(|_| Vec::new()).collect();
        for Column { name, heading, cell } in &self.columns {
            let own: Vec<Cell> = rows.iter().map(cell).collect();
            let is_there = own.iter().any(|cell| !matches!(cell, Cell::None | Cell::Absent));
            if is_there || !own.contains(&Cell::Absent) {
                columns.push((name.clone(), heading.clone()));
                cells.iter_mut().zip(own).for_each(|(row, cell)| row.push(cell));
            }
        }
        Table { columns, rows: cells }
    }
}

/// A table as data.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    /// Of each column its name for programs, and what it is called on pages.
    columns: Vec<(Option<String>, Option<String>)>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Whether it has no rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Headings of the columns for people.
    pub(crate) fn headings(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().filter_map(|(_, heading)| heading.as_deref())
    }

    /// The cells of each row below these.
    pub(crate) fn rows(&self) -> impl Iterator<Item = impl Iterator<Item = &Cell>> {
        self.rows
            .iter()
            .map(|row| row.iter().zip(&self.columns).filter_map(|(cell, (_, heading))| heading.as_ref().map(|_| cell)))
    }

    /// As CSV, for the file of a name.
    ///
    /// # Errors
    /// If two columns have the same name.
    pub(crate) fn csv(&self, file: &str) -> Result<Vec<u8>, ReportError> {
        // A column has the parts of the cell that has most of them.
        let named = self.columns.iter().enumerate().filter_map(|(place, (name, _))| Some((place, name.as_ref()?)));
        let ends = |place: usize| -> Vec<&str> {
            let most =
                self.rows.iter().map(|row| row[place].fields()).max_by_key(Vec::len).filter(|all| !all.is_empty());
            most.map_or_else(|| vec![""], |all| all.into_iter().map(|(end, _)| end).collect())
        };
        let shown: Vec<(usize, &String, Vec<&str>)> = named.map(|(place, name)| (place, name, ends(place))).collect();
        let header = || shown.iter().flat_map(|(_, name, ends)| ends.iter().map(move |end| format!("{name}{end}")));
        if let Some(twice) = header().duplicates().next() {
            return Err(ReportError::NotMade(file.to_owned(), format!("two columns are called {twice}")));
        }
        let part =
            |cell: &Cell, end: &str| cell.fields().into_iter().find(|(own, _)| *own == end).map(|(_, text)| text);
        let row = |row: &Vec<Cell>| -> Vec<String> {
            let fields = shown.iter().flat_map(|(place, _, ends)| ends.iter().map(|end| part(&row[*place], end)));
            fields.map(Option::unwrap_or_default).collect()
        };
        csv(file, std::iter::once(header().collect()).chain(self.rows.iter().map(row)))
    }

    /// In Markdown.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: &mut dyn Iterator<Item = String>| {
            cells.map(|cell| format!("| {cell} ")).collect::<String>() + "|\n"
        };
        let told = |cell: &Cell| match cell {
            Cell::Name(name) => literal(name),
            other => inline(&other.describe()),
        };
        let mut text = line(&mut self.headings().map(inline));
        text += &format!("|{}\n", " --- |".repeat(self.headings().count()));
        text.extend(self.rows().map(|row| line(&mut row.map(told))));
        text
    }
}

/// Lines of CSV, for the file of a name.
pub(super) fn csv(file: &str, mut lines: impl Iterator<Item = Vec<String>>) -> Result<Vec<u8>, ReportError> {
    let mut bytes = Vec::new();
    let mut writer = csv::Writer::from_writer(&mut bytes);
    let written = lines.try_for_each(|line| writer.write_record(line)).and_then(|()| Ok(writer.flush()?));
    drop(writer);
    written.map_err(|error| ReportError::NotMade(file.to_owned(), error.to_string()))?;
    Ok(bytes)
}

/// The shortest text that reads back as the same number; whole numbers without a point.
fn number(value: Option<f64>) -> String {
    match value {
        Some(value) if value.fract() == 0.0 && value.abs() < 1e15 => format!("{value:.0}"),
        Some(value) if value.is_finite() => format!("{value:?}"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column is in every format under the name that it has there, its value written as that format's readers want it; what has no
    /// name in a format is left out of it, and two columns of one name are refused.
    #[test]
    fn a_column_stands_in_every_format() {
        let rows = [Some(0.5), None];
        let share = |row: &Option<f64>| row.map(|share| Cell::Share(share, Some([0.25, 0.75]), 100));
        let sheet = Sheet::new()
            .and(Column::csv("share", share).headed("share ↑"))
            .csv_column("bytes", |row| row.map(|_| Cell::Bytes(f64::from(3 << 20))))
            .column("is | there", Option::is_some);
        let csv = String::from_utf8(sheet.table(&rows).csv("a.csv").unwrap()).unwrap();
        assert_eq!(csv, "share,share_low,share_high,bytes\n0.5,0.25,0.75,3145728\n,,,\n");
        let markdown = "| share ↑ | is \\| there |\n| --- | --- |\n| 50.00 % [25.000, 75.000] | yes |\n| – | no |\n";
        assert_eq!(sheet.table(&rows).markdown(), markdown);
        // What none of the rows can have is no column; one that some can have is, and one that all could have.
        let absent = |row: &Option<f64>| if row.is_some() { Cell::Absent } else { Cell::None };
        let sheet =
            Sheet::new().column("is there", Option::is_some).and(Column::csv("absent", absent).headed("absent"));
        assert_eq!(sheet.table(&rows).markdown(), "| is there |\n| --- |\n| yes |\n| no |\n");
        let csv = |rows: &[Option<f64>]| String::from_utf8(sheet.table(rows).csv("a.csv").unwrap()).unwrap();
        assert!(sheet.table(&[None]).markdown().contains("absent") && csv(&[None]).contains("absent"));
        assert!(!csv(&rows).contains("absent"));
        let twice = Sheet::new().csv_column("share_low", |_| 1_u64);
        let error = twice.csv_column("share_low", |_| 1_u64).table(&rows).csv("a.csv").unwrap_err();
        assert!(error.to_string().contains("share_low"), "{error}");
    }
}
