//! What was made of the same text before: a batch reads the same bodies, robots and models for many cells.

use super::text::sha256_hex;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// More texts than a batch usually names; beyond that each is read anew.
const MOST_KEPT: usize = 64;

/// Things by the texts from which they were made. It holds some tens of them and no more, so that memory
/// stays flat whatever is read.
#[derive(Debug)]
pub struct Memo<T> {
    kept: Mutex<BTreeMap<String, Arc<T>>>,
}

impl<T> Default for Memo<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Memo<T> {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self { kept: Mutex::new(BTreeMap::new()) }
    }
}

impl<T: Clone> Memo<T> {
    /// What `make` gives for these texts, which are all that it depends on; a failure is not kept.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn of<E>(&self, texts: &[&str], make: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let each: Vec<String> = texts.iter().map(|t| sha256_hex(t.as_bytes())).collect();
        let key = each.join(" ");
        let known = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&key).cloned();
        if let Some(found) = found {
            return Ok(T::clone(&found));
        }
        let made = make()?;
        let mut kept = known();
        if kept.len() < MOST_KEPT {
            kept.insert(key, Arc::new(made.clone()));
        }
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_texts_are_read_once_and_failures_again() {
        let memo: Memo<usize> = Memo::new();
        let mut calls = 0;
        let mut of = |texts: &[&str], value: Result<usize, ()>| {
            memo.of(texts, || {
                calls += 1;
                value
            })
        };
        assert_eq!(of(&["a", "b"], Err(())), Err(()));
        assert_eq!(of(&["a", "b"], Ok(1)), Ok(1));
        assert_eq!(of(&["a", "b"], Ok(2)), Ok(1), "from the first call");
        assert_eq!(of(&["ab", ""], Ok(3)), Ok(3), "other texts");
        assert_eq!(calls, 3);
        for k in 0..2 * MOST_KEPT {
            let text = k.to_string();
            assert_eq!(memo.of(&[&text], || Ok::<_, ()>(k)), Ok(k));
        }
        assert!(memo.kept.lock().unwrap().len() <= MOST_KEPT);
    }
}
