//! Numbers that JSON cannot hold: what is not finite is written as `null`.

use serde::{Deserialize, Deserializer};

/// Reads a number; `null`, which is how JSON writes an infinite number or none at all, becomes NaN.
/// For `#[serde(deserialize_with = "null_as_nan")]`.
pub fn null_as_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Serialize, Deserialize)]
    struct Value {
        #[serde(deserialize_with = "null_as_nan")]
        v: f64,
    }

    #[test]
    fn what_is_not_finite_is_read_as_no_number() {
        for v in [f64::INFINITY, f64::NAN] {
            let text = serde_json::to_string(&Value { v }).unwrap();
            let back: Value = serde_json::from_str(&text).unwrap();
            assert!(back.v.is_nan());
            // Written again, it is the same.
            assert_eq!(serde_json::to_string(&back).unwrap(), text);
        }
        let back: Value = serde_json::from_str("{\"v\": 1.5}").unwrap();
        assert_eq!(back.v, 1.5);
    }
}
