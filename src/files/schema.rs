//! JSON Schemas of TOML files, from the types that read them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// JSON Schema (draft 7, which editors of TOML know) of a file that is read as a `T`.
pub fn toml_schema<T: JsonSchema>() -> Value {
    let mut schema: Value =
        SchemaSettings::draft07().into_generator().into_root_schema_for::<T>().into();
    without_null(&mut schema);
    schema
}

/// TOML has no null: what may be left out is left out.
fn without_null(value: &mut Value) {
    match value {
        Value::Object(map) => {
            if map.get("default").is_some_and(Value::is_null) {
                map.remove("default");
            }
            if let Some(Value::Array(types)) = map.get_mut("type") {
                types.retain(|t| t != "null");
                if let [only] = &types[..] {
                    let only = only.clone();
                    map.insert("type".to_owned(), only);
                }
            }
            let is_null = |v: &Value| v["type"] == "null";
            if let Some(Value::Array(any)) = map.get_mut("anyOf") {
                any.retain(|v| !is_null(v));
            }
            map.values_mut().for_each(without_null);
        }
        Value::Array(all) => all.iter_mut().for_each(without_null),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(JsonSchema)]
    #[expect(dead_code, reason = "only its schema is of interest")]
    struct File {
        /// How long, m.
        #[serde(default)]
        length_m: Option<f64>,
        inner: Option<Inner>,
    }

    #[derive(JsonSchema)]
    #[expect(dead_code, reason = "only its schema is of interest")]
    struct Inner {
        name: String,
    }

    #[test]
    fn nothing_is_null_and_words_stay() {
        let schema = toml_schema::<File>();
        assert!(!schema.to_string().contains("null"), "{schema}");
        let length = &schema["properties"]["length_m"];
        assert_eq!(
            (&length["type"], &length["description"]),
            (&"number".into(), &"How long, m.".into())
        );
        assert!(schema["required"].as_array().is_none_or(Vec::is_empty));
        assert_eq!(schema["properties"]["inner"]["anyOf"].as_array().map(Vec::len), Some(1));
    }
}
