//! Follows what a paper's data says is told of rows ([`super::expression`]).

use super::estimate::Estimate;
use super::expression::{ANY, Expression, HERE, Step, Steps};
use super::functions::{Arguments, FUNCTIONS};
use super::page::Page;
use super::quantity::{rank_chance, rank_correlation, sign};
use super::rows::{SceneRows, has};
use super::{Paper, times};
use crate::report::format::NONE;
use crate::report::sheet::Cell;
use crate::results::{Row, Timed};
use crate::statistics::median;

/// Something that is told.
#[derive(Clone)]
pub(super) enum Value<'a> {
    Number(Estimate),
    Time(Timed<'a>),
    Text(&'a str),
    Row(&'a Row),
    Scene(SceneRows<'a>),
    /// As it stands in a table, with its number.
    Shown(Cell, f64),
    List(Vec<Self>),
}

impl From<f64> for Value<'_> {
    fn from(number: f64) -> Self {
        Self::Number(number.into())
    }
}

impl From<bool> for Value<'_> {
    fn from(is: bool) -> Self {
        f64::from(u8::from(is)).into()
    }
}

impl<'a> Value<'a> {
    pub(super) fn number(&self) -> Option<Estimate> {
        match self {
            Self::Number(number) => Some(number.clone()),
            Self::Shown(_, number) if !number.is_nan() => Some((*number).into()),
            _ => None,
        }
    }

    /// A row, of several the first.
    pub(super) fn row(&self) -> Option<&'a Row> {
        match self {
            Self::Row(row) => Some(row),
            Self::List(all) => all.first()?.row(),
            _ => None,
        }
    }

    /// A name, or a number as it is written.
    pub(super) fn text(&self) -> Option<String> {
        match self {
            Self::Text(text) => Some((*text).to_owned()),
            Self::Number(number) => Some(number.value.to_string()),
            Self::Shown(cell, _) => Some(cell.describe()),
            _ => None,
        }
    }

    /// All of a list; what is none stands alone.
    pub(super) fn items(self) -> Vec<Self> {
        if let Self::List(all) = self { all } else { vec![self] }
    }
}

/// Where something is told: of a scene, some of its rows or several scenes.
pub(super) struct Evaluation<'a> {
    pub paper: &'a Paper,
    pub scenes: &'a [SceneRows<'a>],
    /// The page that it stands on, if it is of one.
    pub page: Option<&'a Page<'a>>,
    pub variables: Vec<(&'a str, Value<'a>)>,
}

/// What is done where steps lead to, and whether it wants more; none where something is missing.
type End<'e, 'a> = dyn FnMut(&mut Evaluation<'a>) -> Option<bool> + 'e;

impl<'a> Evaluation<'a> {
    pub(super) fn new(paper: &'a Paper, scenes: &'a [SceneRows<'a>], scene: &SceneRows<'a>) -> Self {
        Self { paper, scenes, page: None, variables: vec![(HERE, Value::Scene(scene.clone()))] }
    }

    /// The scene in whose rows something is looked for.
    pub(super) fn scene(&self) -> &SceneRows<'a> {
        let here = self.variables.iter().rev().find_map(|(name, value)| match value {
            Value::Scene(scene) if *name == HERE => Some(scene),
            _ => None,
        });
        here.expect("it begins in one")
    }

    /// Of what a page shows, from its first scene; none without scenes.
    pub(super) fn of_page(page: &'a Page<'a>) -> Option<Self> {
        let scenes = &page.rows.scenes;
        Some(Self { page: Some(page), ..Self::new(page.paper, scenes, scenes.first()?) })
    }

    /// What is told; none where something for it is missing.
    pub(super) fn value(&mut self, what: &'a Expression) -> Option<Value<'a>> {
        Some(match what {
            Expression::Number(number) => (*number).into(),
            Expression::Text(text) => Value::Text(text),
            Expression::Variable(name) => self.variable(name)?,
            Expression::List(all) => Value::List(self.values(all)?),
            Expression::Rows { tracer, alike, values } => self.rows(tracer, *alike, values)?,
            Expression::Sign(sign, sides) => {
                let [left, right] = &**sides;
                let (left, right) = (self.value(left)?, self.value(right)?);
                self.signed(sign, left, right)?
            }
            Expression::Call { name, steps, lenient: false, arguments } if steps.is_empty() => {
                self.call(name, arguments)?
            }
            Expression::Call { name, steps, lenient, arguments } => {
                let mut found = Vec::new();
                self.follow(steps, *lenient, &mut |at| {
                    found.push(at.values(arguments)?);
                    // One is enough.
                    Some(name != "one")
                })?;
                self.made_one(name, found)?
            }
        })
    }

    /// What is told as it stands in a table.
    pub(super) fn cell(&mut self, what: &'a Expression) -> Cell {
        match self.value(what) {
            Some(Value::Shown(cell, _)) => cell,
            Some(Value::Number(number)) => number.value.into(),
            Some(Value::Text(text)) => text.into(),
            _ => Cell::None,
        }
    }

    /// Whether something holds.
    pub(super) fn holds(&mut self, what: &'a Expression) -> Option<bool> {
        Some(self.value(what)?.number()?.value != 0.0)
    }

    fn values(&mut self, all: &'a [Expression]) -> Option<Vec<Value<'a>>> {
        all.iter().map(|each| self.value(each)).collect()
    }

    pub(super) fn variable(&self, name: &str) -> Option<Value<'a>> {
        self.variables.iter().rev().find(|(own, _)| *own == name).map(|(_, value)| value.clone())
    }

    fn rows(&mut self, tracer: &'a Expression, alike: bool, values: &'a [(String, Expression)]) -> Option<Value<'a>> {
        let tracer = self.value(tracer)?.text()?;
        let said = values.iter().map(|(name, value)| Some((name.as_str(), self.value(value)?.text()?)));
        let mut said = said.collect::<Option<Vec<_>>>()?;
        said.retain(|(_, value)| value != "first");
        let names: Vec<&str> = said.iter().map(|(name, _)| *name).collect();
        let is = |row: &&Row| said.iter().all(|(name, value)| value == ANY || has(row, name, value));
        Some(Value::List(if alike {
            self.scene().differing_in(&tracer, &names).filter(is).map(Value::Row).collect()
        } else {
            self.scene().of_tracer(&tracer).filter(is).map(Value::Row).collect()
        }))
    }

    fn signed(&self, sign: &str, left: Value<'a>, right: Value<'a>) -> Option<Value<'a>> {
        Some(match (sign, left, right) {
            ("+", Value::Time(one), Value::Time(other)) => Value::Time(one.and(other)),
            ("/", Value::Time(one), Value::Time(other)) => {
                Value::Number(times::ratio(self.scene().record, &one, &other)?)
            }
            ("*", Value::Time(time), factor) => Value::Time(time.times(factor.number()?.value)),
            ("/", Value::Time(time), part) => Value::Time(time.times(1.0 / part.number()?.value)),
            ("==", one, other) => match (one.number(), other.number()) {
                (Some(one), Some(other)) => one.value == other.value,
                _ => one.text()? == other.text()?,
            }
            .into(),
            (sign, left, right) => {
                let (left, right) = (left.number()?, right.number()?);
                let (one, other) = (left.value, right.value);
                match sign {
                    "<" => (one < other).into(),
                    "<=" => (one <= other).into(),
                    ">" => (one > other).into(),
                    ">=" => (one >= other).into(),
                    // What is counted stays exact.
                    "/" if !left.timed && !right.timed => (one / other).into(),
                    "+" => Value::Number(left + right),
                    "-" => Value::Number(left - right),
                    "*" => Value::Number(left * right),
                    _ => Value::Number(left / right),
                }
            }
        })
    }

    fn call(&mut self, name: &'a str, arguments: &'a [Expression]) -> Option<Value<'a>> {
        if name == "either" {
            return arguments.iter().find_map(|each| self.value(each));
        }
        if name == "words" {
            let told = |value: Option<Value<'_>>| value.and_then(|value| value.text());
            let mut parts = arguments.iter().map(|each| told(self.value(each)).unwrap_or_else(|| NONE.to_owned()));
            let words = parts.next()?;
            let words = parts.fold(words, |words, part| words.replacen("{}", &part, 1));
            return Some(Value::Shown(Cell::Text(words), f64::NAN));
        }
        let name = if name.starts_with('$') { self.variable(name)?.text()? } else { name.to_owned() };
        let values = self.values(arguments)?;
        if let Some((arguments, is)) = self.paper.function(&name) {
            let known = self.variables.len();
            self.variables.extend(arguments.iter().map(String::as_str).zip(values));
            let value = self.value(is);
            self.variables.truncate(known);
            return value;
        }
        match FUNCTIONS.iter().find(|(own, _)| *own == name) {
            Some((_, function)) => function(self, Arguments(&values)),
            None => {
                self.made_one(&name, values.into_iter().next()?.items().into_iter().map(|each| vec![each]).collect())
            }
        }
    }

    /// Does something wherever steps lead to; what misses something is left out.
    pub(super) fn each(&mut self, steps: &'a Steps, end: &mut dyn FnMut(&mut Self)) {
        self.follow(&steps.0, true, &mut |at| {
            end(at);
            Some(true)
        });
    }

    /// Follows steps and does something wherever they lead to, as long as that wants more; none where something is missing and may not be.
    fn follow(&mut self, steps: &'a [Step], lenient: bool, end: &mut End<'_, 'a>) -> Option<bool> {
        let known = self.variables.len();
        let wants_more = self.follow_on(steps, lenient, end);
        self.variables.truncate(known);
        wants_more.or(lenient.then_some(true))
    }

    fn follow_on(&mut self, steps: &'a [Step], lenient: bool, end: &mut End<'_, 'a>) -> Option<bool> {
        let Some((step, rest)) = steps.split_first() else { return end(self) };
        let (names, all) = match step {
            Step::If(condition) if self.holds(condition)? => return self.follow(rest, lenient, end),
            Step::If(_) => return Some(true),
            Step::Each(names, all) => (names, self.value(all)?.items()),
        };
        let known = self.variables.len();
        for item in all {
            let parts = if names.len() > 1 { item.items() } else { vec![item] };
            self.variables.truncate(known);
            self.variables.extend(names.iter().map(String::as_str).zip(parts));
            if !self.follow(rest, lenient, end)? {
                return Some(false);
            }
        }
        Some(true)
    }

    /// What is made of all that steps led to.
    fn made_one(&self, name: &str, mut found: Vec<Vec<Value<'a>>>) -> Option<Value<'a>> {
        let alone = |mut each: Vec<Value<'a>>| if each.len() == 1 { each.remove(0) } else { Value::List(each) };
        let key = |each: &Vec<Value<'a>>| each.first().and_then(Value::number).map_or(f64::NAN, |number| number.value);
        match name {
            "list" => return Some(Value::List(found.into_iter().map(alone).collect())),
            "count" => return Some((found.len() as f64).into()),
            "one" => return found.drain(..).next()?.pop(),
            "at_least" => return found.into_iter().min_by(|one, other| key(one).total_cmp(&key(other)))?.pop(),
            "at_greatest" => return found.into_iter().max_by(|one, other| key(one).total_cmp(&key(other)))?.pop(),
            "rank" => return self.rank(&found).map(Value::Number),
            // With how often chance makes one as strong, which is doubted where that is more than one in twenty; none of too few, of which
            // hardly any order is more than chance.
            "rank_beyond_chance" => {
                let rank = self.rank(&found).filter(|_| found.len() >= 6)?;
                let chance = rank_chance(found.len(), rank.value);
                let note = Some(format!("exact p {chance:.4} over {} scenes", found.len()));
                let rank = if chance > 0.05 { rank.doubted("it may be chance".to_owned()) } else { rank };
                return Some(Value::Number(Estimate { note, ..rank }));
            }
            _ => {}
        }
        let all: Vec<Value<'a>> = found.into_iter().filter_map(|mut each| each.pop()).collect();
        if name == "sum" {
            let sum = all.into_iter().map(Some).reduce(|sum, next| self.signed("+", sum?, next?));
            return sum.unwrap_or_else(|| Some(0.0.into()));
        }
        let all: Vec<Estimate> = all.iter().map(Value::number).collect::<Option<_>>()?;
        let found = match name {
            "least" => Estimate::least(all),
            "greatest" => Estimate::greatest(all),
            "mean" => Estimate::mean(all),
            "median" => {
                let values: Vec<f64> = all.iter().map(|each| each.value).filter(|value| value.is_finite()).collect();
                Some(median(&values).into())
            }
            // Of ratios that which lies farthest from 1.
            "farthest" => {
                let [least, greatest] = [Estimate::least(all.clone())?, Estimate::greatest(all)?];
                Some(if least.value * greatest.value < 1.0 { least } else { greatest })
            }
            _ => None,
        };
        found.map(Value::Number)
    }

    /// How the second of pairs is ranked by the first.
    fn rank(&self, pairs: &[Vec<Value<'a>>]) -> Option<Estimate> {
        let points = pairs.iter().map(|pair| Some((pair.first()?.number()?.value, pair.get(1)?)));
        let order = |one: &&Value<'a>, other: &&Value<'a>| match (one, other) {
            // A pair whose order the times leave open counts for either.
            (Value::Time(one), Value::Time(other)) => {
                Some((times::ratio(self.scene().record, one, other)? - 1.0).rising(sign))
            }
            _ => Some(sign(one.number()?.value - other.number()?.value).into()),
        };
        rank_correlation(&points.collect::<Option<Vec<_>>>()?, order)
    }
}
