//! The words by which a paper's data says what is told of rows, read here and followed in [`super::evaluate`].
//!
//! | words | what they are |
//! | --- | --- |
//! | `0.5`, `diffuse`, `'depth bounds'`, `a \| b` | numbers, names, names with blanks, lists |
//! | `dirt[tile_size=1, views=$v]` | all rows of a tracer with these values; where one row is wanted, the first |
//! | `~dirt[tile_size=1, tree=*]` | those alike the tracer's first row but for these values; `*` is any, `first` the first row's own |
//! | `$a + 1`, `$a / $b`, `$a <= 2` | arithmetic, of times too; a comparison is 1 or 0. Blanks stand around `-` |
//! | `name(a, b)` | a function: the paper's own, or one of [`super::functions`] |
//! | `least($r in dirt[], if a < b: c)` | `c` for every row that the steps lead to, made one by `least` |
//!
//! A step is `$x in LIST` (`$a, $b in LIST` of lists), `$x = VALUE`, `if CONDITION`, or `at SCENES`, in whose rows the rest is looked for.
//! Where something is missing there is no value; with `least?(...)` what misses something is left out instead.

use serde::Deserialize;

/// What is told.
#[derive(Debug, Deserialize)]
#[serde(try_from = "String")]
pub(super) enum Expression {
    Number(f64),
    Text(String),
    Variable(String),
    List(Vec<Self>),
    /// Rows of a tracer with values of parameters.
    Rows {
        tracer: Box<Self>,
        alike: bool,
        values: Vec<(String, Self)>,
    },
    /// A sign between two.
    Sign(String, Box<[Self; 2]>),
    /// A function, by a name or by a variable that holds one.
    Call {
        name: String,
        /// What leads to its arguments, of which it then makes one of all.
        steps: Vec<Step>,
        /// Whether what misses something is left out.
        lenient: bool,
        arguments: Vec<Self>,
    },
}

/// A step on the way to what is told.
#[derive(Debug)]
pub(super) enum Step {
    /// Variables that stand for one after the other of a list, or [`HERE`].
    Each(Vec<String>, Expression),
    If(Expression),
}

/// Stands for any value of a parameter.
pub(super) const ANY: &str = "*";
/// What holds the scene in whose rows something is looked for.
pub(super) const HERE: &str = "here";

/// Signs, from those that bind least.
const SIGNS: [&[&str]; 3] = [&["<", "<=", ">", ">=", "=="], &["+", "-"], &["*", "/"]];

/// Steps alone, that lead to rows of a table, lines or charts.
#[derive(Debug, Default, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct Steps(pub Vec<Step>);

impl TryFrom<String> for Steps {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Reader::read(&text, Reader::steps, "a step").map(Self)
    }
}

impl TryFrom<String> for Expression {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Reader::read(&text, Reader::list, "an end")
    }
}

fn tokens(text: &str) -> Result<Vec<String>, String> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let in_word = |letter: char| letter.is_ascii_alphanumeric() || "_.-".contains(letter);
        let length = match first {
            '\'' => 2 + rest[1..].find('\'').ok_or_else(|| format!("no end of {rest}"))?,
            '$' => 1 + rest[1..].find(|letter| !in_word(letter)).unwrap_or(rest.len() - 1),
            first if first.is_ascii_alphanumeric() => rest.find(|letter| !in_word(letter)).unwrap_or(rest.len()),
            _ if ["<=", ">=", "=="].iter().any(|sign| rest.starts_with(sign)) => 2,
            other => other.len_utf8(),
        };
        tokens.push(rest[..length].to_owned());
        rest = rest[length..].trim_start();
    }
    Ok(tokens)
}

struct Reader {
    tokens: Vec<String>,
    next: usize,
}

impl Reader {
    /// Reads what is told, all of it; an error names the place.
    fn read<T>(text: &str, what: fn(&mut Self) -> Result<T, String>, wanted: &str) -> Result<T, String> {
        let mut reader = Self { tokens: tokens(text)?, next: 0 };
        let read = what(&mut reader)?;
        if reader.next < reader.tokens.len() { reader.fails(wanted) } else { Ok(read) }
    }

    fn ahead(&self, by: usize) -> &str {
        self.tokens.get(self.next + by).map_or("", String::as_str)
    }

    fn take(&mut self, token: &str) -> bool {
        let is_next = self.ahead(0) == token;
        self.next += usize::from(is_next);
        is_next
    }

    fn fails<T>(&self, wanted: &str) -> Result<T, String> {
        Err(format!("{wanted} is wanted after `{}`", self.tokens[..self.next].join(" ")))
    }

    fn expect(&mut self, token: &str) -> Result<(), String> {
        if self.take(token) { Ok(()) } else { self.fails(token) }
    }

    /// A name, or the text of a number.
    fn word(&mut self) -> Result<String, String> {
        if !self.ahead(0).starts_with(|first: char| first.is_ascii_alphanumeric()) {
            return self.fails("a name");
        }
        self.next += 1;
        Ok(self.tokens[self.next - 1].clone())
    }

    fn list(&mut self) -> Result<Expression, String> {
        let mut all = vec![self.signed(0)?];
        while self.take("|") {
            all.push(self.signed(0)?);
        }
        Ok(if all.len() > 1 { Expression::List(all) } else { all.remove(0) })
    }

    fn signed(&mut self, level: usize) -> Result<Expression, String> {
        let Some(signs) = SIGNS.get(level) else { return self.single() };
        let mut left = self.signed(level + 1)?;
        while signs.contains(&self.ahead(0)) {
            let sign = self.ahead(0).to_owned();
            self.next += 1;
            left = Expression::Sign(sign, Box::new([left, self.signed(level + 1)?]));
        }
        Ok(left)
    }

    fn single(&mut self) -> Result<Expression, String> {
        if self.take("(") {
            let inner = self.list()?;
            return self.expect(")").map(|()| inner);
        }
        if self.take("~") {
            let tracer = self.value()?;
            return self.rows(tracer, true);
        }
        let token = self.ahead(0).to_owned();
        if let Some(quoted) = token.strip_prefix('\'') {
            self.next += 1;
            return Ok(Expression::Text(quoted.trim_end_matches('\'').to_owned()));
        }
        if token.starts_with('$') {
            self.next += 1;
            return if self.ahead(0) == "(" { self.call(token) } else { Ok(Expression::Variable(token)) };
        }
        let word = self.word()?;
        match (self.ahead(0), word.parse::<f64>()) {
            ("[", _) => self.rows(Expression::Text(word), false),
            (_, Ok(number)) => Ok(Expression::Number(number)),
            ("(" | "?", _) => self.call(word),
            _ => Ok(Expression::Text(word)),
        }
    }

    fn rows(&mut self, tracer: Expression, alike: bool) -> Result<Expression, String> {
        self.expect("[")?;
        let value = |reader: &mut Self| {
            let name = reader.word()?;
            reader.expect("=")?;
            Ok((name, reader.value()?))
        };
        Ok(Expression::Rows { tracer: Box::new(tracer), alike, values: self.up_to("]", value)? })
    }

    /// A tracer, or a parameter's value: as it is written, or what a variable holds; `*` is any.
    fn value(&mut self) -> Result<Expression, String> {
        if self.take(ANY) {
            return Ok(Expression::Text(ANY.to_owned()));
        }
        if self.ahead(0).starts_with('$') { self.single() } else { self.word().map(Expression::Text) }
    }

    /// All up to a bracket, with commas between them.
    fn up_to<T>(&mut self, end: &str, each: impl Fn(&mut Self) -> Result<T, String>) -> Result<Vec<T>, String> {
        let mut all = Vec::new();
        while !self.take(end) {
            all.push(each(self)?);
            if !self.take(",") && self.ahead(0) != end {
                return self.fails(end);
            }
        }
        Ok(all)
    }

    fn call(&mut self, name: String) -> Result<Expression, String> {
        let lenient = self.take("?");
        self.expect("(")?;
        let steps = self.steps()?;
        if !steps.is_empty() {
            self.expect(":")?;
        }
        let arguments = self.up_to(")", Self::list)?;
        Ok(Expression::Call { name, steps, lenient, arguments })
    }

    fn steps(&mut self) -> Result<Vec<Step>, String> {
        let mut steps = Vec::new();
        while let Some(step) = self.step()? {
            steps.push(step);
            if !self.take(",") {
                break;
            }
        }
        Ok(steps)
    }

    fn step(&mut self) -> Result<Option<Step>, String> {
        if self.take("if") {
            return self.list().map(|condition| Some(Step::If(condition)));
        }
        if self.take("at") {
            return self.list().map(|scenes| Some(Step::Each(vec![HERE.to_owned()], scenes)));
        }
        let mut names = Vec::new();
        while self.ahead(2 * names.len()).starts_with('$') {
            names.push(self.ahead(2 * names.len()).to_owned());
            match self.ahead(2 * names.len() - 1) {
                "," => {}
                "in" => {
                    self.next += 2 * names.len();
                    return self.list().map(|all| Some(Step::Each(names, all)));
                }
                "=" if names.len() == 1 => {
                    self.next += 2;
                    return self.list().map(|value| Some(Step::Each(names, Expression::List(vec![value]))));
                }
                _ => break,
            }
        }
        Ok(None)
    }
}
