//! Damage without end to documents of JSON, and what an execution of it costs: for readers of files from strangers.
//!
//! Execution `n` is the same file on every machine, so that a finding is a number.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;
use serde_json::{Map, Value, json};

/// SplitMix64: every seed is as good as any other, so that runs can be numbered.
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// The numbers of an execution.
    pub fn of_execution(number: u64) -> Self {
        Self(number.wrapping_mul(0x2545_f491_4f6c_dd1d))
    }

    /// A number below `end`; 0 if that is 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % (end.max(1) as u64)) as usize
    }

    /// True once in `times`.
    pub fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    /// One of a list that is not empty.
    pub fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

/// What a format's documents are made of: what is put where it makes sense, and where it makes none.
pub struct Vocabulary {
    /// Numbers at which something ends.
    pub numbers: &'static [f64],
    /// Texts.
    pub words: &'static [&'static str],
    /// Keys with values that make sense somewhere, in JSON.
    pub keys: &'static [(&'static str, &'static str)],
    /// How often something in a list may be repeated.
    pub repeats: &'static [usize],
}

impl Vocabulary {
    /// Damages one place of a tree, with pieces of `donor`.
    pub fn mutate(&self, random: &mut Random, json: &mut Value, donor: &Value) {
        let pointer = nth(json, random.below(count(json)), String::new());
        if random.once_in(6) {
            // Something from elsewhere that stands under the same key.
            let key = pointer.rsplit('/').next().unwrap_or_default();
            let source = if random.once_in(2) { donor } else { &*json };
            // A tree itself stands under no key.
            let mut others: Vec<&Value> = pointer.is_empty().then_some(source).into_iter().collect();
            under(source, key, &mut others);
            if others.is_empty() {
                return;
            }
            let graft = others[random.below(others.len())].clone();
            if let Some(value) = json.pointer_mut(&pointer) {
                *value = graft;
            }
            return;
        }
        let Some(value) = json.pointer_mut(&pointer) else {
            return;
        };
        if random.once_in(30) {
            *value = self.any_value(random);
            return;
        }
        match value {
            Value::Object(object) => self.mutate_object(random, object),
            Value::Array(items) => self.mutate_array(random, items),
            Value::String(text) => *text = (*random.pick(self.words)).to_owned(),
            Value::Number(number) => {
                let old = number.as_f64().unwrap_or(0.0);
                *value = match random.below(4) {
                    0 => self.any_number(random),
                    1 => whole(old + 1.0),
                    2 => whole(old - 1.0),
                    _ => json!(random.below(12)),
                };
            }
            _ => *value = self.any_value(random),
        }
    }

    fn mutate_object(&self, random: &mut Random, object: &mut Map<String, Value>) {
        let keys: Vec<String> = object.keys().cloned().collect();
        if random.once_in(2) || keys.is_empty() {
            let (key, value) = *random.pick(self.keys);
            object.insert(key.to_owned(), serde_json::from_str(value).expect("the list is JSON"));
        } else {
            let removed = object.remove(random.pick(&keys)).unwrap_or_default();
            if random.once_in(3) {
                object.insert(random.pick(self.keys).0.to_owned(), removed);
            }
        }
    }

    fn mutate_array(&self, random: &mut Random, items: &mut Vec<Value>) {
        let at = random.below(items.len());
        match random.below(6) {
            0 => items.truncate(at),
            1 if !items.is_empty() => drop(items.remove(at)),
            2 if !items.is_empty() => {
                let times = *random.pick(self.repeats);
                let item = items[at].clone();
                items.splice(at..at, std::iter::repeat_n(item, times));
            }
            3 if !items.is_empty() => {
                let other = random.below(items.len());
                items.swap(at, other);
            }
            4 => items.push(self.any_value(random)),
            _ => items.reverse(),
        }
    }

    fn any_value(&self, random: &mut Random) -> Value {
        match random.below(7) {
            0 => Value::Null,
            1 => json!(random.once_in(2)),
            2 => json!(*random.pick(self.words)),
            3 => json!([]),
            4 => json!({}),
            _ => self.any_number(random),
        }
    }

    fn any_number(&self, random: &mut Random) -> Value {
        whole(*random.pick(self.numbers))
    }

    /// Puts a key into an object that may hold it already, which no tree of values can.
    pub fn duplicate_key(&self, random: &mut Random, text: &mut Vec<u8>) {
        let opens: Vec<usize> = (0..text.len()).filter(|&at| text[at] == b'{').collect();
        if opens.is_empty() {
            return;
        }
        let at = *random.pick(&opens) + 1;
        let (key, value) = *random.pick(self.keys);
        let comma = if text.get(at) == Some(&b'}') { "" } else { "," };
        text.splice(at..at, format!("\"{key}\":{value}{comma}").into_bytes());
    }
}

/// How many places a tree has.
fn count(value: &Value) -> usize {
    match value {
        Value::Array(items) => 1 + items.iter().map(count).sum::<usize>(),
        Value::Object(object) => 1 + object.values().map(count).sum::<usize>(),
        _ => 1,
    }
}

/// The pointer to a place by its number, the tree itself first.
fn nth(value: &Value, mut left: usize, here: String) -> String {
    let below: Box<dyn Iterator<Item = (String, &Value)>> = match value {
        _ if left == 0 => return here,
        Value::Array(items) => Box::new(items.iter().enumerate().map(|(index, item)| (index.to_string(), item))),
        Value::Object(object) => Box::new(object.iter().map(|(key, item)| (key.clone(), item))),
        _ => return here,
    };
    left -= 1;
    for (key, item) in below {
        match left.checked_sub(count(item)) {
            Some(rest) => left = rest,
            None => return nth(item, left, format!("{here}/{key}")),
        }
    }
    here
}

/// Every value that stands under a key, in the order of places.
fn under<'v>(value: &'v Value, key: &str, out: &mut Vec<&'v Value>) {
    let place = key.parse().ok();
    let mut add = |is_it: bool, item: &'v Value| {
        out.extend(is_it.then_some(item));
        under(item, key, out);
    };
    match value {
        Value::Array(items) => items.iter().enumerate().for_each(|(index, item)| add(place == Some(index), item)),
        Value::Object(object) => object.iter().for_each(|(name, item)| add(name == key, item)),
        _ => {}
    }
}

/// A whole number as such: formats tell 3 from 3.0.
fn whole(number: f64) -> Value {
    if number.fract() == 0.0 && (0.0..1.9e19).contains(&number) {
        json!(number as u64)
    } else if number.fract() == 0.0 && (-9e18..0.0).contains(&number) {
        json!(number as i64)
    } else {
        json!(number)
    }
}

/// What an execution cost and came to.
pub struct Execution<T> {
    /// What came of it, or what promise was broken.
    pub outcome: Result<T, String>,
    /// Processor time.
    pub time: Duration,
    /// The most memory that was held at once, bytes.
    pub bytes: usize,
}

/// Processor time of this process, where the system tells it: Linux, in the hundredths of a second of proc_pid_stat(5).
pub fn processor_time() -> Option<Duration> {
    let text = fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program, which may hold anything, ends with the last bracket; user and system time are fields 14 and 15.
    let mut fields = text.rsplit(')').next()?.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (ticks()? + ticks()?)))
}

/// Executes something within limits of processor time and memory: a panic, or more than them, is a broken promise.
pub fn execute<T>(
    allocator: &PeakAlloc,
    max_time: Duration,
    max_bytes: usize,
    work: impl FnOnce() -> Result<T, String>,
) -> Execution<T> {
    let before = allocator.current_usage();
    allocator.reset_peak_usage();
    let start = processor_time();
    let outcome = catch_unwind(AssertUnwindSafe(work));
    let time = processor_time().zip(start).map(|(end, start)| end.saturating_sub(start)).unwrap_or_default();
    let bytes = allocator.peak_usage().saturating_sub(before);
    let outcome = match outcome {
        Err(_) => Err("it panicked".to_owned()),
        Ok(_) if time > max_time => Err(format!("it took {time:?} of processor time")),
        Ok(_) if bytes > max_bytes => Err(format!("it took {bytes} bytes")),
        Ok(outcome) => outcome,
    };
    Execution { outcome, time, bytes }
}

/// What became of executions.
#[derive(Debug)]
pub struct Tally<T> {
    /// How many came to what.
    pub counts: BTreeMap<T, u64>,
    /// Those that broke a promise.
    pub findings: Vec<u64>,
    slowest: (Duration, u64),
    largest: (usize, u64),
}

impl<T> Default for Tally<T> {
    fn default() -> Self {
        Self { counts: BTreeMap::new(), findings: Vec::new(), slowest: Default::default(), largest: Default::default() }
    }
}

impl<T: Ord + Debug> Tally<T> {
    /// Takes an execution in.
    pub fn add(&mut self, number: u64, execution: Execution<T>) {
        match execution.outcome {
            Ok(outcome) => *self.counts.entry(outcome).or_default() += 1,
            Err(problem) => {
                println!("execution {number}: {problem}");
                self.findings.push(number);
            }
        }
        self.slowest = self.slowest.max((execution.time, number));
        self.largest = self.largest.max((execution.bytes, number));
    }

    /// How many came to something.
    pub fn count(&self, outcome: &T) -> u64 {
        self.counts.get(outcome).copied().unwrap_or(0)
    }

    fn print(&self, next: u64, start: Instant) {
        println!(
            "next {next}, {:.0} s: {:?}, {} findings; slowest {:?} ({}), largest {:.1} MiB ({})",
            start.elapsed().as_secs_f64(),
            self.counts,
            self.findings.len(),
            self.slowest.0,
            self.slowest.1,
            self.largest.0 as f64 / f64::from(1 << 20),
            self.largest.1,
        );
    }
}

/// Executes numbers in turn, each by its file, and says every few seconds how far it is. What breaks a promise is written to the folder
/// for temporary files.
pub fn run<T: Ord + Debug>(
    numbers: Range<u64>,
    file: impl Fn(u64) -> Vec<u8>,
    execute: impl Fn(&[u8]) -> Execution<T>,
) -> Tally<T> {
    let (start, mut told) = (Instant::now(), Instant::now());
    let (mut tally, end) = (Tally::default(), numbers.end);
    for number in numbers {
        let file = file(number);
        let execution = execute(&file);
        if execution.outcome.is_err() {
            let path = std::env::temp_dir().join(format!("tracebench-finding-{number}.bin"));
            fs::write(path, &file).expect("the folder for temporary files can be written");
        }
        tally.add(number, execution);
        if told.elapsed() > Duration::from_secs(5) {
            tally.print(number + 1, start);
            told = Instant::now();
        }
    }
    tally.print(end, start);
    tally
}

/// The numbers of a long run: as many as FUZZ_EXECUTIONS says, from FUZZ_FROM (0) on.
pub fn numbers(executions: u64) -> Range<u64> {
    let number = |name: &str, default: u64| {
        std::env::var(name).map_or(default, |value| value.parse().expect("a whole number of executions"))
    };
    let from = number("FUZZ_FROM", 0);
    from..from + number("FUZZ_EXECUTIONS", executions)
}
