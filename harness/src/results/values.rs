//! What numbers, lists and texts of a record may be, wherever they stand: looked at by the names of their fields while the document is
//! read, so that nothing of it is kept.

use std::collections::BTreeSet;
use std::fmt::{self, Display, Write as _};

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

/// Fields whose numbers may lie below zero. All others, and all below them, count or measure something.
const SIGNED: &str =
    "eye forward up origin direction change deviations structure_statistics difficulty_level time_s times_s ssim";
/// Fields whose numbers are shares, and all below them.
const SHARES: &str = "agreement interval identity within_common_texel within_own_texel balanced_accuracy balanced_accuracy_interval \
                      material normal position interval_coverage featured min_featured most_wrong least_wrong max_lost_share";
/// Lists that are never written empty.
const FILLED: &str =
    "control_names curve axes points wrong_by_remedy times_s viewpoints difficulty_levels rays_per_pixel";
/// Fields with values of any kind: those of parameters.
const FREE: &str = "parameters ray_parameters values seed";
/// The largest whole number that JSON's readers hold exactly, 2^53.
const MAX_WHOLE: u64 = 1 << 53;

/// A value of a document with its path. It is read and not kept.
pub(super) struct Checked<'p> {
    path: &'p mut String,
    field: Field,
}

/// What the fields say that a value is in.
#[derive(Clone, Copy, Default)]
struct Field {
    signed: bool,
    share: bool,
    filled: bool,
    free: bool,
}

impl<'p> Checked<'p> {
    /// A whole document.
    pub(super) fn document(path: &'p mut String) -> Self {
        Self { path, field: Field::default() }
    }

    fn is_not<E: Error>(&self, found: impl Display, must: &str) -> E {
        E::custom(format!("`{}` is {found} and must be {must}", self.path))
    }

    fn number<E: Error>(self, number: f64, found: impl Display) -> Result<(), E> {
        match self.field {
            Field { free: true, .. } => Ok(()),
            Field { share: true, .. } if !(0.0..=1.0).contains(&number) => {
                Err(self.is_not(found, "a share, from 0 to 1"))
            }
            Field { signed: false, .. } if number < 0.0 => Err(self.is_not(found, "0 or more")),
            _ if number.abs() > f64::from(f32::MAX) => Err(self.is_not(found, "a number that f32 holds")),
            _ => Ok(()),
        }
    }
}

impl Field {
    fn below(self, name: &str) -> Self {
        let is_of = |names: &str| names.split(' ').any(|each| each == name);
        Self {
            signed: self.signed || is_of(SIGNED),
            share: self.share || is_of(SHARES),
            filled: is_of(FILLED),
            free: self.free || is_of(FREE),
        }
    }
}

impl<'de> DeserializeSeed<'de> for Checked<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Checked<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<(), E> {
        if number > MAX_WHOLE && !self.field.free {
            return Err(self.is_not(number, "a whole number up to 2^53"));
        }
        self.number(number as f64, number)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<(), E> {
        self.number(number as f64, number)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<(), E> {
        self.number(number, format_args!("{number:?}"))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        let (length, mut index) = (self.path.len(), 0);
        loop {
            let _ = write!(self.path, "[{index}]");
            let field = Field { filled: false, ..self.field };
            let item = list.next_element_seed(Checked { path: self.path, field })?;
            self.path.truncate(length);
            match (item, index) {
                (None, 0) if self.field.filled => return Err(self.is_not("empty", "filled")),
                (None, _) => return Ok(()),
                _ => index += 1,
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let length = self.path.len();
        let mut names = BTreeSet::new();
        while let Some(name) = map.next_key::<String>()? {
            let dot = if length == 0 { "" } else { "." };
            let _ = write!(self.path, "{dot}{name}");
            let field = self.field.below(&name);
            if !names.insert(name) {
                map.next_value::<IgnoredAny>()?;
                return Err(self.is_not("there twice", "there once"));
            }
            map.next_value_seed(Checked { path: self.path, field })?;
            self.path.truncate(length);
        }
        Ok(())
    }
}
