//! What the last scene was counted to need: the same question is not asked the device twice.

use std::sync::{Arc, Mutex, Weak};

use tracebench_api::{Geometry, TracerError};

/// A count, remembered with what it is of: a scene's vertices and triangles, and how they are stored.
#[derive(Debug)]
pub struct LastCount<Key, Count> {
    last: Mutex<Option<Counted<Key, Count>>>,
}

#[derive(Debug)]
struct Counted<Key, Count> {
    positions: Weak<Vec<[f32; 3]>>,
    triangles: Weak<Vec<[u32; 3]>>,
    key: Key,
    count: Count,
}

impl<Key, Count> Default for LastCount<Key, Count> {
    fn default() -> Self {
        Self { last: Mutex::new(None) }
    }
}

impl<Key: PartialEq, Count: Clone> LastCount<Key, Count> {
    /// The count of the last call if it was of the same, else that of `count`.
    ///
    /// # Errors
    /// Those of `count`.
    pub fn of(
        &self,
        geometry: &Geometry,
        key: Key,
        count: impl FnOnce() -> Result<Count, TracerError>,
    ) -> Result<Count, TracerError> {
        let mut last = self.last.lock().map_err(|_| TracerError::Failed("a count was left open".to_owned()))?;
        let same = |counted: &&Counted<Key, Count>| {
            let scene = counted.positions.upgrade().zip(counted.triangles.upgrade());
            scene.is_some_and(|(positions, triangles)| {
                Arc::ptr_eq(&positions, &geometry.positions) && Arc::ptr_eq(&triangles, &geometry.triangles)
            }) && counted.key == key
        };
        if let Some(counted) = last.as_ref().filter(same) {
            return Ok(counted.count.clone());
        }
        let count = count()?;
        let (positions, triangles) = (Arc::downgrade(&geometry.positions), Arc::downgrade(&geometry.triangles));
        *last = Some(Counted { positions, triangles, key, count: count.clone() });
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same scene and key are counted once; another key, moved vertices or a failure before are counted anew.
    #[test]
    fn the_same_is_counted_once() {
        let geometry = Geometry::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]], None).unwrap();
        let moved = geometry.clone().moved_to(vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]], None).unwrap();
        let last = LastCount::default();
        let mut asked = 0;
        let mut count = |geometry: &Geometry, key: u32| {
            let counted = last.of(geometry, key, || {
                asked += 1;
                Ok(asked)
            });
            counted.unwrap()
        };
        assert_eq!([count(&geometry, 1), count(&geometry, 1), count(&geometry.clone(), 1)], [1, 1, 1]);
        assert_eq!([count(&geometry, 2), count(&moved, 2), count(&moved, 2)], [2, 3, 3]);
        let last = LastCount::<u32, u32>::default();
        assert!(last.of(&geometry, 1, || Err(TracerError::Failed(String::new()))).is_err());
        assert_eq!(last.of(&geometry, 1, || Ok(7)).unwrap(), 7);
    }
}
