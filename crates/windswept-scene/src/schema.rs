//! The JSON schema of a scene file, for editors that complete keys and underline mistakes.

use serde_json::{Map, Value, json};

use crate::keys::{Fallback, KEYS, Key, Kind};

/// The schema (draft 2020-12) of a scene file, from the declared keys. Rules across keys are not in it:
/// [`Scene::check`](crate::Scene::check) knows them.
#[must_use]
pub fn schema() -> Value {
    let mut root = table("", "A scene of windswept.");
    if let Some(root) = root.as_object_mut() {
        root.insert("$schema".to_owned(), json!("https://json-schema.org/draft/2020-12/schema"));
    }
    root
}

/// The schema of the table at a path.
fn table(path: &str, help: &str) -> Value {
    let inside = |key: &&Key| match key.path.rsplit_once('.') {
        Some((table, _)) => table == path,
        None => path.is_empty(),
    };
    let name = |key: &Key| key.path.rsplit('.').next().unwrap_or_default().to_owned();
    let keys: Vec<&Key> = KEYS.iter().filter(inside).collect();
    let properties: Map<String, Value> = keys.iter().map(|key| (name(key), of(key))).collect();
    let required: Vec<String> =
        keys.iter().filter(|key| key.default == Fallback::Required).map(|key| name(key)).collect();
    json!({
        "type": "object",
        "description": help,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// The schema of the values of a key.
fn of(key: &Key) -> Value {
    let unit = if key.unit.is_empty() { String::new() } else { format!(" [{}]", key.unit) };
    let without = match &key.default {
        Fallback::RequiredIf(case) => format!(" Needed {case}."),
        Fallback::Derived(text) if !text.is_empty() => format!(" Without it: {text}."),
        Fallback::Method(accurate, published) => format!(" Default {accurate}, or {published} with method published."),
        _ => String::new(),
    };
    let help = format!("{}{unit}.{without}", key.help);
    let mut schema = match key.kind {
        Kind::Text | Kind::Path => json!({ "type": "string" }),
        Kind::Bool => json!({ "type": "boolean" }),
        Kind::Count(least, most) => json!({ "type": "integer", "minimum": least, "maximum": most }),
        Kind::Number => json!({ "type": "number" }),
        Kind::Length | Kind::Positive => json!({ "type": "number", "exclusiveMinimum": 0 }),
        Kind::NonNegative => json!({ "type": "number", "minimum": 0 }),
        Kind::Fraction => json!({ "type": "number", "minimum": 0, "exclusiveMaximum": 1 }),
        Kind::Within(above, most) => json!({ "type": "number", "exclusiveMinimum": above, "maximum": most }),
        Kind::Vector | Kind::Direction => {
            json!({ "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 })
        }
        Kind::Profile => {
            let pair = json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 });
            json!({ "type": "array", "items": pair, "minItems": 1 })
        }
        Kind::Choice(words) => json!({ "enum": words }),
        Kind::Values => json!({ "type": "object" }),
        Kind::Table => return table(&key.path, &help),
        Kind::Tables => {
            let table = table(&key.path, &help);
            return json!({ "description": help, "anyOf": [table, { "type": "array", "items": table }] });
        }
    };
    if let Some(schema) = schema.as_object_mut() {
        schema.insert("description".to_owned(), json!(help));
        // Defaults are spelled as TOML, in which numbers, words and arrays are as in JSON.
        if let Some(default) = key.default_of(true).and_then(|text| serde_json::from_str::<Value>(text).ok()) {
            schema.insert("default".to_owned(), default);
        }
    }
    schema
}
