//! What is made when it is first asked for, and kept.

use std::collections::BTreeMap;
use std::sync::Mutex;

use tracebench_api::TracerError;

/// Things by key, each made once. Made things are cheap to clone, as pipelines are.
#[derive(Debug)]
pub struct OnDemand<Key, Made> {
    made: Mutex<BTreeMap<Key, Made>>,
}

impl<Key, Made> Default for OnDemand<Key, Made> {
    fn default() -> Self {
        Self { made: Mutex::default() }
    }
}

impl<Key: Ord, Made: Clone> OnDemand<Key, Made> {
    /// That of a key.
    ///
    /// # Errors
    /// Those of `make`, which is asked again the next time.
    pub fn of(&self, key: Key, make: impl FnOnce() -> Result<Made, TracerError>) -> Result<Made, TracerError> {
        let made = self.made.lock();
        let mut made = made.map_err(|_| TracerError::Failed("a pipeline was left half made".to_owned()))?;
        if let Some(there) = made.get(&key) {
            return Ok(there.clone());
        }
        let new = make()?;
        made.insert(key, new.clone());
        Ok(new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A key's thing is made once, another key's on its own, and a failure is not kept.
    #[test]
    fn a_thing_is_made_once() {
        let things = OnDemand::default();
        let mut made = 0;
        let mut of = |key: u32, fails: bool| {
            things.of(key, || {
                made += 1;
                if fails { Err(TracerError::Failed("refused".to_owned())) } else { Ok(made) }
            })
        };
        assert!(of(1, true).is_err());
        assert_eq!([of(1, false), of(1, false), of(2, false), of(1, true)].map(Result::unwrap), [2, 2, 3, 2]);
    }
}
