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
    /// Rows of a tracer with values of parameters; any where none is said.
    Rows {
        tracer: Box<Self>,
        alike: bool,
        values: Vec<(String, Option<Self>)>,
    },
    /// A sign between two.
    Sign(String, Box<[Self; 2]>),
    /// A function, by a name or by a variable that holds one.
    Call(String, Vec<Self>),
    Over(Over),
}

/// Something of everything that steps lead to.
#[derive(Debug)]
pub(super) struct Over {
    /// What makes one of all.
    pub name: String,
    /// Whether what misses something is left out.
    pub lenient: bool,
    pub steps: Vec<Step>,
    pub results: Vec<Expression>,
}

/// A step on the way to what is told.
#[derive(Debug)]
pub(super) enum Step {
    Each(Vec<String>, Expression),
    Let(String, Expression),
    If(Expression),
    At(Expression),
}

/// Signs, from those that bind least.
const SIGNS: [&[&str]; 3] = [&["<", "<=", ">", ">=", "=="], &["+", "-"], &["*", "/"]];

/// Steps alone, that lead to rows of a table, lines or charts.
#[derive(Debug, Default, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct Steps(pub Vec<Step>);

impl TryFrom<String> for Steps {
    type Error = String;

    /// As [`Expression`]'s.
    fn try_from(text: String) -> Result<Self, String> {
        let mut reader = Reader { tokens: tokens(&text)?, next: 0 };
        let mut steps = Vec::new();
        while let Some(step) = reader.step()? {
            steps.push(step);
            if !reader.take(",") {
                break;
            }
        }
        if reader.next < reader.tokens.len() { reader.fails("a step") } else { Ok(Self(steps)) }
    }
}

impl TryFrom<String> for Expression {
    type Error = String;

    /// Reads what is told; an error names the place.
    fn try_from(text: String) -> Result<Self, String> {
        let mut reader = Reader { tokens: tokens(&text)?, next: 0 };
        let read = reader.list()?;
        if reader.next < reader.tokens.len() { reader.fails("an end") } else { Ok(read) }
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
        let mut values = Vec::new();
        while !self.take("]") {
            let name = self.word()?;
            self.expect("=")?;
            values.push((name, if self.take("*") { None } else { Some(self.value()?) }));
            if !self.take(",") && self.ahead(0) != "]" {
                return self.fails("]");
            }
        }
        Ok(Expression::Rows { tracer: Box::new(tracer), alike, values })
    }

    /// A tracer, or a parameter's value: as it is written, or what a variable holds.
    fn value(&mut self) -> Result<Expression, String> {
        if self.ahead(0).starts_with('$') { self.single() } else { self.word().map(Expression::Text) }
    }

    fn call(&mut self, name: String) -> Result<Expression, String> {
        let lenient = self.take("?");
        self.expect("(")?;
        let mut steps = Vec::new();
        while let Some(step) = self.step()? {
            steps.push(step);
            if !self.take(",") {
                self.expect(":")?;
                break;
            }
        }
        let mut results = Vec::new();
        while !self.take(")") {
            results.push(self.list()?);
            if !self.take(",") && self.ahead(0) != ")" {
                return self.fails(")");
            }
        }
        let is_call = steps.is_empty() && !lenient;
        Ok(if is_call {
            Expression::Call(name, results)
        } else {
            Expression::Over(Over { name, lenient, steps, results })
        })
    }

    fn step(&mut self) -> Result<Option<Step>, String> {
        if self.take("if") {
            return self.list().map(|condition| Some(Step::If(condition)));
        }
        if self.take("at") {
            return self.list().map(|scenes| Some(Step::At(scenes)));
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
                    return self.list().map(|value| Some(Step::Let(names.remove(0), value)));
                }
                _ => break,
            }
        }
        Ok(None)
    }
}
