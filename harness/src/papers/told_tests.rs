//! What papers' data tells by expressions: its functions are known, it takes no times that are not there, and it is read as it is written.

use super::*;

/// The data of a file, `vvp16/pages` or `pages`.
fn data(file: &str) -> serde_json::Value {
    let path = format!("{}/src/papers/{file}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// Every function that a paper's data takes is one of its own or of all papers' ([`functions`]), with as many arguments as its own takes, and
/// what makes one of several is known; a misspelled one is found so.
#[test]
fn told_functions_are_known() {
    use expression::{Expression, Step};

    const MADE_ONE: [&str; 13] = [
        "list",
        "count",
        "one",
        "sum",
        "mean",
        "median",
        "least",
        "greatest",
        "farthest",
        "at_least",
        "at_greatest",
        "rank",
        "rank_beyond_chance",
    ];
    fn calls(of: &Expression, found: &mut Vec<(String, Option<usize>)>) {
        match of {
            Expression::Number(_) | Expression::Text(_) | Expression::Variable(_) => {}
            Expression::List(all) => all.iter().for_each(|each| calls(each, found)),
            Expression::Rows { tracer, values, .. } => {
                calls(tracer, found);
                values.iter().for_each(|(_, value)| calls(value, found));
            }
            Expression::Sign(_, sides) => sides.iter().for_each(|each| calls(each, found)),
            Expression::Call { name, steps, lenient, arguments } => {
                found.push((name.clone(), (steps.is_empty() && !lenient).then_some(arguments.len())));
                for Step::Each(_, is) | Step::If(is) in steps {
                    calls(is, found);
                }
                arguments.iter().for_each(|each| calls(each, found));
            }
        }
    }
    let unknown = |paper: &Paper, text: &str| -> Vec<String> {
        let mut found = Vec::new();
        calls(&Expression::try_from(text.to_owned()).unwrap(), &mut found);
        let is_known = |(name, arguments): &(String, Option<usize>)| match (paper.function(name), arguments) {
            (Some((own, _)), Some(count)) => own.iter().filter(|argument| argument.len() > 1).count() == *count,
            (None, Some(_)) => {
                let known = functions::FUNCTIONS.iter().any(|(own, _)| own == name);
                known || name.starts_with('$') || MADE_ONE.contains(&&**name) || ["either", "words"].contains(&&**name)
            }
            (_, None) => MADE_ONE.contains(&&**name),
        };
        found.into_iter().filter(|call| !is_known(call)).map(|(name, _)| name).collect()
    };
    for paper in PAPERS {
        for file in [format!("{}/quantities", paper.name), format!("{}/pages", paper.name), "pages".to_owned()] {
            let told = data(&file);
            let functions = told["functions"].as_object().into_iter().flatten().map(|(_, is)| is);
            let quantities = told["quantities"].as_array().into_iter().flatten().map(|quantity| &quantity["is"]);
            let tables = told["tables"].as_object().into_iter().flatten();
            let of_table = |table: &serde_json::Value| -> Vec<serde_json::Value> {
                let further = table["columns_of"][1].as_array().into_iter().flatten();
                table["columns"].as_array().unwrap().iter().chain(further).map(|column| column[1].clone()).collect()
            };
            let columns: Vec<_> = tables.flat_map(|(_, table)| of_table(table)).collect();
            let charts = told["charts"].as_object().into_iter().flatten();
            let values = charts.flat_map(|(_, chart)| chart["panels"].as_array().unwrap()).map(|panel| &panel[2]);
            for text in functions.chain(quantities).chain(&columns).chain(values) {
                let text = text.as_str().unwrap();
                assert_eq!(unknown(paper, text), Vec::<String>::new(), "{}: {text}", paper.name);
            }
        }
    }
    assert_eq!(
        unknown(PAPERS[0], "least($row in dirt[]: byte($row)) + leastt($a in 1: 2) + bytes(dirt[])"),
        ["byte", "leastt"]
    );
    assert_eq!(unknown(PAPERS[0], "references(dirt[], 2)"), ["references"]);
}

/// Nothing that decides a claim of an experiment about traces alone, or stands in a table or chart of its own, is told by times of builds, which it
/// does not take.
#[test]
fn traces_alone_need_no_builds() {
    // Functions may be passed by name, so every word counts.
    let times_builds = |text: String, functions: &[(String, String)]| {
        let (mut texts, mut seen) = (vec![text], std::collections::BTreeSet::new());
        while let Some(text) = texts.pop() {
            if ["build(", "phase_ms(", "median_time("].iter().any(|call| text.contains(call)) {
                return true;
            }
            let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
            let called = functions.iter().filter(|(name, _)| words.contains(&&**name) && seen.insert(name));
            texts.extend(called.map(|(_, is)| is.clone()));
        }
        false
    };
    let mut of_builds = 0;
    for paper in PAPERS {
        let (told, pages) = (data(&format!("{}/quantities", paper.name)), data(&format!("{}/pages", paper.name)));
        let of_other = told["takes_from"].as_str().map(|other| data(&format!("{other}/quantities")));
        let all = [Some(&told), of_other.as_ref()].into_iter().flatten().flat_map(|told| told["functions"].as_object());
        let own_name = |head: &String| head.split('(').next().unwrap_or_default().to_owned();
        let functions: Vec<_> = all.flatten().map(|(head, is)| (own_name(head), is.to_string())).collect();
        let quantity_times = |name: &str| {
            let is_its = |quantity: &&serde_json::Value| quantity["name"] == name;
            let quantity = told["quantities"].as_array().into_iter().flatten().find(is_its).unwrap();
            times_builds(quantity["is"].to_string(), &functions)
        };
        for experiment in paper.experiments.iter() {
            let quantities = paper.claims.iter().filter_map(|claim| match &claim.test {
                Test::Measured { table, quantity, either, .. } if table == experiment.name => {
                    Some(std::iter::once(quantity).chain(either))
                }
                _ => None,
            });
            let shown = [("tables", &experiment.sections), ("charts", &experiment.charts)];
            let shown = shown.iter().flat_map(|(kind, names)| names.iter().map(|name| pages[*kind][*name].to_string()));
            let claims = quantities.flatten().any(|name| quantity_times(name));
            let needed = claims || shown.into_iter().any(|shown| times_builds(shown, &functions));
            assert!(!needed || !experiment.traces_alone, "{} has builds to time", experiment.name);
            of_builds += u32::from(needed);
        }
    }
    assert!(of_builds >= 12, "{of_builds}");
}

/// What cannot be read says what is wanted, and where; steps leave out or refuse what is missing, as they are told.
#[test]
fn expressions_are_read_and_followed() {
    use evaluate::{Evaluation, Value};
    use expression::Expression;

    for (text, said) in [
        ("1 + ", "a name is wanted after `1 +`"),
        ("least($row in dirt[]", ": is wanted after"),
        ("dirt[tile_size 2]", "= is wanted after `dirt [ tile_size`"),
        ("(1", ") is wanted"),
        ("'open", "no end of"),
        ("1 2", "an end is wanted after `1`"),
    ] {
        let error = Expression::try_from(text.to_owned()).unwrap_err();
        assert!(error.contains(said), "{text}: {error}");
    }
    let record = run_of(vec![
        dirt("a", json!({ "tile_size": "1", "buckets": 4 }), &[("references", 6.0)]),
        dirt("a", json!({ "tile_size": "2", "buckets": 4 }), &[("parts", 2.0)]),
    ]);
    let rows = Rows::of(&record);
    let found = |text: &str| {
        let expression = Expression::try_from(text.to_owned()).unwrap();
        let mut at = Evaluation::new(PAPERS[0], &rows.scenes, &rows.scenes[0]);
        at.value(&expression)
            .and_then(|value| if let Value::Number(number) = value { Some(number.value) } else { None })
    };
    assert_eq!(found("1 + 2 * 3 - 4 / 2"), Some(5.0));
    assert_eq!(found("(1 + 2) * (3 <= 3) + (2 == 3)"), Some(3.0));
    assert_eq!(found("sum($row in dirt[]: told($row, references))"), None);
    assert_eq!(found("sum?($row in dirt[]: told($row, references))"), Some(6.0));
    assert_eq!(found("either(told(dirt[tile_size=2], references), 7)"), Some(7.0));
    assert_eq!(found("value(~dirt[tile_size=*], buckets)"), Some(4.0));
    assert_eq!(found("count($row in ~dirt[]: $row) + 10 * count($row in ~dirt[tile_size=*]: $row)"), Some(21.0));
    assert_eq!(found("sum($few, $many in steps(1 | 2 | 4), if $few > 1: $many)"), Some(4.0));
    assert_eq!(found("$unbound"), None);
    assert_eq!(found("no_such(1)"), None);
}
