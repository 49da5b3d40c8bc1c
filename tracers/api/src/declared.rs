//! Parameters by type: each is declared once, and what describes it and what reads its value are made from that.

use std::marker::PhantomData;
use std::ops::RangeInclusive;

use crate::{Domain, ParameterDescription, ParameterError, ParameterScope, Parameters, Value};

/// A type of parameters' values.
pub trait ParameterType: Copy {
    /// The value as data.
    fn to_value(self) -> Value;

    /// From data; `None` for a value of another kind.
    fn from_value(value: &Value) -> Option<Self>;
}

impl ParameterType for u32 {
    fn to_value(self) -> Value {
        Value::Integer(self.into())
    }

    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Integer(value) = value { Self::try_from(*value).ok() } else { None }
    }
}

impl ParameterType for f64 {
    fn to_value(self) -> Value {
        Value::Real(self)
    }

    fn from_value(value: &Value) -> Option<Self> {
        if let Value::Real(value) = value { Some(*value) } else { None }
    }
}

/// A parameter's named values, as variants; made by [`choice!`](crate::choice).
pub trait Choice: Copy + 'static {
    /// The variants, in the order of lists.
    const ALL: &'static [Self];
    /// Their names.
    const NAMES: &'static [&'static str];

    /// The variant's name.
    fn name(self) -> &'static str;
}

impl<C: Choice> ParameterType for C {
    fn to_value(self) -> Value {
        Value::Choice(self.name().to_owned())
    }

    fn from_value(value: &Value) -> Option<Self> {
        let Value::Choice(name) = value else { return None };
        Self::ALL.iter().copied().find(|each| each.name() == name)
    }
}

/// Declares named values: enums that are a [`Choice`] each, every variant with its name on the command line and in results.
///
/// ```
/// use tracebench_api::{Choice, choice};
///
/// choice! {
///     /// Where a hit is placed.
///     enum HitPoint { Step = "step", Depth = "depth" }
///     /// Whether something is done.
///     enum Switch { Off = "off", On = "on" }
/// }
/// assert_eq!(HitPoint::Depth.name(), "depth");
/// assert_eq!(HitPoint::NAMES, ["step", "depth"]);
/// ```
#[macro_export]
macro_rules! choice {
    ($($(#[$attribute:meta])* $vis:vis enum $Name:ident {
        $($(#[$of_variant:meta])* $Variant:ident = $name:literal),+ $(,)?
    })+) => {$(
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $vis enum $Name {
            $($(#[$of_variant])* #[doc = concat!("`", $name, "`.")] $Variant),+
        }

        impl $crate::Choice for $Name {
            const ALL: &'static [Self] = &[$(Self::$Variant),+];
            const NAMES: &'static [&'static str] = &[$($name),+];

            fn name(self) -> &'static str {
                match self { $(Self::$Variant => $name),+ }
            }
        }
    )+};
}

/// Declares an enum whose variants have names in results, in tables or on the command line, with `ALL` of them in order and `name`. The
/// code of one with `repr(u32)` is its place.
#[macro_export]
macro_rules! named {
    ($(#[$attribute:meta])* $vis:vis enum $Name:ident {
        $($(#[$of_variant:meta])* $Variant:ident = $name:literal),+ $(,)?
    }) => {
        $(#[$attribute])*
        $vis enum $Name {
            $($(#[$of_variant])* $Variant),+
        }

        impl $Name {
            /// Every one, in order.
            $vis const ALL: [Self; [$($name),+].len()] = [$(Self::$Variant),+];

            /// Its name.
            $vis fn name(self) -> &'static str {
                match self { $(Self::$Variant => $name),+ }
            }
        }
    };
}

/// A parameter as it is declared; its name is that of the field that it is declared for.
#[derive(Clone, Debug)]
pub struct Parameter<T> {
    description: ParameterDescription,
    of_type: PhantomData<T>,
}

impl<T: ParameterType> Parameter<T> {
    fn new(scope: ParameterScope, domain: Domain, published: T) -> Self {
        let published = published.to_value();
        let improved = published.clone();
        let (effect, sweep) = ("", Vec::new());
        let description =
            ParameterDescription { name: "", unit: "", scope, domain, published, improved, effect, sweep };
        Self { description, of_type: PhantomData }
    }

    /// With an effect, for a parameter that several tracers declare; one's own is the doc comment of its field.
    #[must_use]
    pub fn effect(mut self, effect: &'static str) -> Self {
        self.description.effect = effect;
        self
    }

    /// With a unit.
    #[must_use]
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.description.unit = unit;
        self
    }

    /// With a value in the preset `improved` other than the published one.
    #[must_use]
    pub fn improved(mut self, value: T) -> Self {
        self.description.improved = value.to_value();
        self
    }

    /// With values worth sweeping.
    #[must_use]
    pub fn sweep<const COUNT: usize>(mut self, values: [T; COUNT]) -> Self {
        self.description.sweep = values.map(T::to_value).to_vec();
        self
    }

    /// As data, under the name and with the doc comment of its field.
    #[must_use]
    pub fn documented(self, name: &'static str, comment: &'static str) -> ParameterDescription {
        // Every line of a doc comment begins with a blank.
        match comment.trim_start() {
            "" => self.described(name),
            effect => self.effect(effect).described(name),
        }
    }

    fn described(self, name: &'static str) -> ParameterDescription {
        ParameterDescription { name, ..self.description }
    }

    /// Its value among others, by its name.
    ///
    /// # Errors
    /// [`ParameterError::Missing`] if there is none, [`ParameterError::Value`] for one that it cannot have.
    pub fn read(self, name: &'static str, parameters: &Parameters) -> Result<T, ParameterError> {
        let value = parameters.value(name).ok_or(ParameterError::Missing { name })?;
        let description = self.described(name);
        let allowed = T::from_value(value).filter(|_| description.allows(value));
        allowed.ok_or_else(|| description.refusal(&value.to_string()))
    }
}

impl Parameter<u32> {
    /// A whole number.
    #[must_use]
    pub fn integer(scope: ParameterScope, range: RangeInclusive<u32>, published: u32) -> Self {
        let (least, greatest) = (i64::from(*range.start()), i64::from(*range.end()));
        Self::new(scope, Domain::Integer { least, greatest }, published)
    }
}

impl Parameter<f64> {
    /// A real number.
    #[must_use]
    pub fn real(scope: ParameterScope, range: RangeInclusive<f64>, published: f64) -> Self {
        Self::new(scope, Domain::Real { least: *range.start(), greatest: *range.end() }, published)
    }
}

impl<C: Choice> Parameter<C> {
    /// One of named values, all of which are worth sweeping.
    #[must_use]
    pub fn choice(scope: ParameterScope, published: C) -> Self {
        let mut made = Self::new(scope, Domain::Choice(C::NAMES), published);
        made.description.sweep = C::ALL.iter().map(|each| each.to_value()).collect();
        made
    }
}

/// Declares what a tracer is told: a struct with a field a parameter, whose doc comment says what effect its values have. `describe()`
/// gives the parameters as data, in order; `try_from(&Parameters)` reads their values, and refuses [`Parameters`] that are not just these.
///
/// ```
/// use tracebench_api::{Parameter, ParameterScope, Parameters, Preset, parameters};
///
/// parameters! {
///     /// What a tracer is told.
///     struct Told {
///         /// pixels between samples
///         stride: u32 = Parameter::integer(ParameterScope::Trace, 1..=64, 1).unit("pixels"),
///     }
/// }
/// let told = Told::try_from(&Parameters::preset(&Told::describe(), Preset::Published)).unwrap();
/// assert_eq!(told.stride, 1);
/// ```
///
/// A parameter that is not declared cannot be asked for:
///
/// ```compile_fail,E0609
/// use tracebench_api::{Parameter, ParameterScope, Parameters, Preset, parameters};
///
/// parameters! {
///     /// What a tracer is told.
///     struct Told {
///         /// pixels between samples
///         stride: u32 = Parameter::integer(ParameterScope::Trace, 1..=64, 1).unit("pixels"),
///     }
/// }
/// let told = Told::try_from(&Parameters::preset(&Told::describe(), Preset::Published)).unwrap();
/// assert_eq!(told.strife, 1);
/// ```
#[macro_export]
macro_rules! parameters {
    ($(#[$attribute:meta])* $vis:vis struct $Name:ident {
        $($(#[doc = $effect:literal])* $field:ident: $Type:ty = $parameter:expr),+ $(,)?
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        $vis struct $Name {
            $(#[doc = concat!("The value of `", stringify!($field), "`:")] $(#[doc = $effect])* $vis $field: $Type),+
        }

        impl $Name {
            /// Every parameter as data, in the order of lists.
            $vis fn describe() -> Vec<$crate::ParameterDescription> {
                vec![$(
                    $crate::Parameter::<$Type>::documented($parameter, stringify!($field), concat!($($effect),*))
                ),+]
            }
        }

        impl TryFrom<&$crate::Parameters> for $Name {
            type Error = $crate::ParameterError;

            fn try_from(parameters: &$crate::Parameters) -> Result<Self, Self::Error> {
                parameters.has_only(&[$(stringify!($field)),+])?;
                Ok(Self {
                    $($field: $crate::Parameter::<$Type>::read($parameter, stringify!($field), parameters)?),+
                })
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;

    crate::choice! {
        /// Sizes.
        enum Size { Small = "small", Large = "large" }
    }

    crate::parameters! {
        /// What is told.
        struct Told {
            size: Size = Parameter::choice(ParameterScope::Build, Size::Large).effect("how large"),
            /// how far,
            /// at the most
            stride: u32 = Parameter::integer(ParameterScope::Trace, 1..=64, 1).improved(2).sweep([1, 8]),
            /// how near
            bias: f64 = Parameter::real(ParameterScope::Trace, 0.0..=4.0, 0.5).unit("pixels"),
        }
    }

    fn told(settings: &[(&str, &str)]) -> Told {
        let mut parameters = Parameters::preset(&Told::describe(), Preset::Published);
        for (name, value) in settings {
            parameters.set(&Told::describe(), name, value).unwrap();
        }
        Told::try_from(&parameters).unwrap()
    }

    /// What is declared is what is described, and what is set is what is read, of every type. Effects are the fields' comments, in one
    /// line, or the parameter's own where there is none.
    #[test]
    fn declared_once_described_and_read() {
        let described = Told::describe();
        assert_eq!(described.iter().map(|each| each.name).collect::<Vec<_>>(), ["size", "stride", "bias"]);
        let effects: Vec<_> = described.iter().map(|each| each.effect).collect();
        assert_eq!(effects, ["how large", "how far, at the most", "how near"]);
        assert_eq!(described[0].domain, Domain::Choice(&["small", "large"]));
        assert_eq!(described[0].sweep, ["small", "large"].map(|name| Value::Choice(name.to_owned())));
        assert_eq!((&described[1].published, &described[1].improved), (&Value::Integer(1), &Value::Integer(2)));
        assert_eq!(
            (described[1].domain, described[1].scope),
            (Domain::Integer { least: 1, greatest: 64 }, ParameterScope::Trace)
        );
        assert_eq!(
            (described[2].unit, &described[2].improved, described[2].sweep.len()),
            ("pixels", &Value::Real(0.5), 0)
        );
        assert_eq!(told(&[]), Told { size: Size::Large, stride: 1, bias: 0.5 });
        let set = told(&[("size", "small"), ("stride", "64"), ("bias", "4")]);
        assert_eq!(set, Told { size: Size::Small, stride: 64, bias: 4.0 });
    }

    /// Values that are not just those declared are refused by the parameter's name: too few, too many, of another range, of
    /// another kind, of another choice.
    #[test]
    fn foreign_values_are_refused() {
        let refused = |change: &dyn Fn(&mut Vec<ParameterDescription>)| {
            let mut described = Told::describe();
            change(&mut described);
            let error = Told::try_from(&Parameters::preset(&described, Preset::Published)).unwrap_err();
            error.to_string()
        };
        assert!(refused(&|described| drop(described.remove(1))).contains("'stride'"));
        assert!(refused(&|described| described[1].name = "strife").contains("'strife'; there are: size, stride, bias"));
        assert!(refused(&|described| described[1].published = Value::Integer(65)).contains("stride = '65'"));
        assert!(refused(&|described| described[1].published = Value::Integer(-1)).contains("stride = '-1'"));
        assert!(refused(&|described| described[2].published = Value::Integer(1)).contains("bias = '1'"));
        assert!(refused(&|described| described[2].published = Value::Real(f64::NAN)).contains("bias = 'NaN'"));
        assert!(
            refused(&|described| described[0].published = Value::Choice("medium".to_owned())).contains("small, large")
        );
        // Of the presets that fit none is refused.
        assert!(Preset::ALL.iter().all(|each| Told::try_from(&Parameters::preset(&Told::describe(), *each)).is_ok()));
    }
}
