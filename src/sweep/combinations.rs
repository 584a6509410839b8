//! Combinations of the varied settings of a plan's table. In: its lists and its fixed settings, as TOML. Out: all combinations, with the
//! key of each setting for messages.

use serde_json::{Map, Value};

/// Settings of one combination by name, with their keys in the plan.
pub(super) struct Combination {
    /// Name, value and key in the plan, fixed settings first.
    pub settings: Vec<(String, Value, String)>,
    /// Varied settings of this combination.
    pub varied: Map<String, Value>,
}

impl Combination {
    /// Removes a setting and returns its value and key.
    pub fn take(&mut self, name: &str) -> Option<(Value, String)> {
        let at = self.settings.iter().position(|setting| setting.0 == name)?;
        let (_, value, key) = self.settings.remove(at);
        Some((value, key))
    }
}

/// Returns all combinations of the lists in `each` for the table at key `at`, the last name changing fastest, each with `settings`; fails
/// if there are more than `most`.
///
/// # Errors
/// The key of the faulty entry and the reason.
pub(super) fn combinations(
    at: &str,
    settings: &toml::Table,
    each: &toml::Table,
    most: usize,
) -> Result<Vec<Combination>, (String, String)> {
    let fixed = flat(settings, "");
    let mut lists: Vec<(String, Vec<Value>, String)> = Vec::new();
    for (name, value) in flat(each, "") {
        let key = format!("{at}.each.{name}");
        let values = listed(&value, most).map_err(|fault| (key.clone(), format!("{name} {fault}")))?;
        if let Some(fixed) = fixed.iter().find(|fixed| fixed.0 == name) {
            let text = format!("{} is also given in settings; give it once", fixed.0);
            return Err((key, text));
        }
        lists.push((name, values, key));
    }
    let product = lists.iter().try_fold(1_usize, |product, list| product.checked_mul(list.1.len()));
    let count = product.filter(|count| *count <= most).ok_or_else(|| {
        (format!("{at}.each"), format!("the table makes more than {most} runs; split it into several plans"))
    })?;
    let fixed = fixed.into_iter().map(|(name, value)| {
        let key = format!("{at}.settings.{name}");
        (name, json(&value), key)
    });
    let fixed: Vec<(String, Value, String)> = fixed.collect();
    let combination = |mut number: usize| {
        let mut chosen: Vec<(String, Value, String)> = Vec::new();
        for (name, values, key) in lists.iter().rev() {
            chosen.push((name.clone(), values[number % values.len()].clone(), key.clone()));
            number /= values.len();
        }
        chosen.reverse();
        let varied = chosen.iter().map(|(name, value, _)| (name.clone(), value.clone())).collect();
        Combination { settings: fixed.iter().cloned().chain(chosen).collect(), varied }
    };
    Ok((0..count).map(combination).collect())
}

/// Returns the settings of nested tables as dotted names in alphabetical order.
fn flat(table: &toml::Table, before: &str) -> Vec<(String, toml::Value)> {
    let mut settings = Vec::new();
    for (name, value) in table {
        let name = format!("{before}{name}");
        match value {
            toml::Value::Table(inner) => settings.extend(flat(inner, &format!("{name}."))),
            value => settings.push((name, value.clone())),
        }
    }
    settings.sort_by(|a, b| a.0.cmp(&b.0));
    settings
}

/// Returns the values of a list, or of a range such as `"1-20"`.
fn listed(value: &toml::Value, most: usize) -> Result<Vec<Value>, String> {
    let range = |text: &str| {
        let (from, to) = text.split_once('-')?;
        let (from, to): (u64, u64) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
        (from <= to && to - from < most as u64).then(|| (from..=to).map(Value::from).collect())
    };
    match value {
        toml::Value::Array(values) if !values.is_empty() => Ok(values.iter().map(json).collect()),
        toml::Value::String(text) => {
            range(text).ok_or_else(|| format!("is \"{text}\"; allowed: a list, or a range such as \"1-20\""))
        }
        value => Err(format!("is {value}; allowed: a list of one value or more, or a range such as \"1-20\"")),
    }
}

fn json(value: &toml::Value) -> Value {
    serde_json::to_value(value).unwrap_or_default()
}
