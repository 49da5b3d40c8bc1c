//! What can be swept: any parameter of a tracer, and the resolution of what it takes its views from.

use tracebench_api::{Domain, ParameterDescription, Value};

use super::SweepError;
use crate::plan::{LARGEST_EDGE, LARGEST_FACE, Resolution, RunPreset, TracerRequest};
use crate::results::AxisRecord;

/// The name of the axis that is no parameter of the tracer.
pub const RESOLUTION: &str = "resolution";

/// Multiples of the resolution that are swept where none are given.
const RESOLUTIONS: [&str; 4] = ["1/4", "1/2", "1", "2"];

/// The most values of one axis: as many as a chart has room for.
pub const MAX_VALUES: usize = 16;

/// The greatest factor, and the greatest divisor.
const MAX_TIMES: u32 = 64;

/// A multiple or a whole part of a resolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multiple {
    times: u32,
    over: u32,
}

impl Multiple {
    /// The resolution itself.
    pub const ONE: Self = Self { times: 1, over: 1 };

    /// Reads `N` or `1/N`.
    pub fn parse(text: &str) -> Option<Self> {
        let whole = |text: &str| text.parse().ok().filter(|number| (1..=MAX_TIMES).contains(number));
        match text.split_once('/') {
            None => Some(Self { times: whole(text)?, over: 1 }),
            Some(("1", over)) => Some(Self { times: 1, over: whole(over)? }),
            Some(_) => None,
        }
    }

    fn of(self, edge: u32, largest: u32) -> Option<u32> {
        let edge = edge.checked_mul(self.times)?;
        (edge.is_multiple_of(self.over) && edge / self.over <= largest).then_some(edge / self.over)
    }

    /// A preset with frame and faces of so many times the edge. The rays stay.
    ///
    /// # Errors
    /// [`SweepError::Resolution`] if an edge would be no whole number of pixels, or larger than any that is served.
    pub fn scale(self, preset: RunPreset) -> Result<RunPreset, SweepError> {
        let frame = preset.frame.map(|edge| self.of(edge, LARGEST_EDGE));
        match (frame, self.of(preset.face, LARGEST_FACE)) {
            ([Some(width), Some(height)], Some(face)) => Ok(RunPreset { frame: [width, height], face, ..preset }),
            _ => Err(SweepError::Resolution(self.to_string(), preset.frame, preset.face)),
        }
    }
}

impl std::fmt::Display for Multiple {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.over == 1 { write!(f, "{}", self.times) } else { write!(f, "{}/{}", self.times, self.over) }
    }
}

/// A tracer with other values, at the resolution that they name: not being able to measure it is no error.
///
/// # Errors
/// [`SweepError`] for a value that a parameter does not take, or edges that would be no whole pixels.
pub fn with_values<'v>(
    request: &TracerRequest,
    preset: RunPreset,
    values: impl IntoIterator<Item = (&'v String, &'v String)>,
) -> Result<(TracerRequest, Resolution), SweepError> {
    let mut changed = TracerRequest { required: false, ..request.clone() };
    let RunPreset { mut frame, mut face, .. } = preset;
    for (name, value) in values {
        if name == RESOLUTION {
            let multiple = Multiple::parse(value).ok_or_else(|| SweepError::Multiple(value.clone()))?;
            RunPreset { frame, face, .. } = multiple.scale(preset)?;
        } else {
            changed.set(name, value).map_err(SweepError::Parameter)?;
        }
    }
    let resolution = Resolution { frame, face };
    changed.resolution = Some(resolution);
    Ok((changed, resolution))
}

/// The axis of resolutions.
///
/// # Errors
/// [`SweepError`] for what is no multiple, and for too many.
pub fn resolution_axis(values: Option<&[String]>) -> Result<AxisRecord, SweepError> {
    let given: Vec<&str> = values.map_or(RESOLUTIONS.to_vec(), |values| values.iter().map(String::as_str).collect());
    let read = |text: &str| Multiple::parse(text).ok_or_else(|| SweepError::Multiple(text.to_owned()));
    let mut multiples = given.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    multiples.push(Multiple::ONE);
    multiples.sort_by_key(|multiple| u64::from(multiple.times) * 1_000_000 / u64::from(multiple.over));
    multiples.dedup();
    whole(AxisRecord {
        name: RESOLUTION.to_owned(),
        unit: "× the preset's edges".to_owned(),
        effect: "edges of the viewpoint's frame and faces, as multiples of the preset's".to_owned(),
        own: Multiple::ONE.to_string(),
        values: multiples.iter().map(Multiple::to_string).collect(),
    })
}

/// The axis of a parameter: the values given, else those of its description.
///
/// # Errors
/// [`SweepError::Parameter`] for a value that the parameter does not take, others as they say.
pub fn parameter_axis(
    request: &TracerRequest,
    described: &ParameterDescription,
    values: Option<&[String]>,
) -> Result<AxisRecord, SweepError> {
    let own = request.parameters.value(described.name).unwrap_or(&described.published).clone();
    let read = |text: &String| described.parse(text).map_err(SweepError::Parameter);
    let mut all = match values {
        Some(values) => values.iter().map(read).collect::<Result<Vec<_>, _>>()?,
        None => described.sweep.clone(),
    };
    if all.is_empty() {
        return Err(SweepError::NothingToSweep(described.name.to_owned()));
    }
    all.push(own.clone());
    all.sort_by(|a, b| place(described, a).total_cmp(&place(described, b)));
    all.dedup();
    whole(AxisRecord {
        name: described.name.to_owned(),
        unit: described.unit.to_owned(),
        effect: described.effect.to_owned(),
        own: own.to_string(),
        values: all.iter().map(Value::to_string).collect(),
    })
}

/// Where a value stands: numbers by size, choices as the description has them.
pub fn place(described: &ParameterDescription, value: &Value) -> f64 {
    match (value, described.domain) {
        (Value::Integer(number), _) => *number as f64,
        (Value::Real(number), _) => *number,
        (Value::Choice(name), Domain::Choice(names)) => {
            names.iter().position(|each| each == name).map_or(f64::MAX, |place| place as f64)
        }
        (Value::Choice(_), _) => f64::MAX,
    }
}

fn whole(axis: AxisRecord) -> Result<AxisRecord, SweepError> {
    if axis.values.len() > MAX_VALUES {
        return Err(SweepError::TooManyValues(axis.name, axis.values.len()));
    }
    Ok(axis)
}

#[cfg(test)]
mod tests {
    use tracebench_api::Preset;

    use super::*;
    use crate::registry;

    /// Whole multiples and parts are read and written as they were, everything else is refused; edges that are no whole
    /// pixels or beyond what is served are refused.
    #[test]
    fn multiples_scale_edges() {
        for text in ["1", "2", "1/4", "64", "1/64"] {
            assert_eq!(Multiple::parse(text).unwrap().to_string(), text);
        }
        for text in ["", "0", "65", "2/3", "1/0", "1/", "/2", "-1", "0.5", "1e3", "99999999999"] {
            assert_eq!(Multiple::parse(text), None, "{text}");
        }
        let preset = RunPreset::named("smoke").unwrap();
        let scaled = |text: &str| Multiple::parse(text).unwrap().scale(preset);
        let half = scaled("1/2").unwrap();
        assert_eq!((half.frame, half.face, half.ray_image), ([64, 32], 32, preset.ray_image));
        assert_eq!(scaled("2").unwrap().frame, [256, 128]);
        let narrow = RunPreset { frame: [127, 64], ..preset };
        assert!(Multiple::parse("1/2").unwrap().scale(narrow).unwrap_err().to_string().contains("127x64"));
        let small = RunPreset { face: 2, ..preset };
        assert!(Multiple::parse("1/4").unwrap().scale(small).is_err());
        let large = RunPreset { face: LARGEST_FACE, ..preset };
        assert!(Multiple::parse("2").unwrap().scale(large).is_err());
    }

    /// Values are in order, each once, the tracer's own among them, whatever is given.
    #[test]
    fn axes_are_in_order() {
        let mut request = TracerRequest::of(registry::find("dirt").unwrap(), Preset::Published);
        let described = request.registration.describe().parameters;
        let axis = |request: &TracerRequest, name: &str, values: &[&str]| {
            let values: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
            let described = described.iter().find(|each| each.name == name).unwrap();
            parameter_axis(request, described, (!values.is_empty()).then_some(&values[..]))
        };
        let buckets = axis(&request, "buckets", &["40", "4", "040"]).unwrap();
        assert_eq!((buckets.values.join(" ").as_str(), buckets.own.as_str()), ("4 24 40", "24"));
        assert_eq!(axis(&request, "clip", &["plane"]).unwrap().values, ["polygon", "plane"]);
        assert_eq!(axis(&request, "tile_size", &[]).unwrap().values, ["1", "2", "4", "8"]);
        request.set("buckets", "3").unwrap();
        assert_eq!(axis(&request, "buckets", &["4"]).unwrap().values, ["3", "4"]);
        assert!(axis(&request, "buckets", &["0"]).unwrap_err().to_string().contains("1 to 256"));
        let many: Vec<String> = (1..40).map(|value: u32| value.to_string()).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert!(axis(&request, "buckets", &many).unwrap_err().to_string().contains("16"));
        assert_eq!(resolution_axis(None).unwrap().values, ["1/4", "1/2", "1", "2"]);
        let given = ["3".to_owned(), "1/16".to_owned(), "1/8".to_owned()];
        assert_eq!(resolution_axis(Some(&given)).unwrap().values, ["1/16", "1/8", "1", "3"]);
    }
}
