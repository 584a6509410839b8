//! Expressions of OpenSCENARIO, such as `${$speed / 3.6}`. In: the text between the braces, and the values of parameters. Out: the value, or why it
//! has none.

/// Deepest nesting of parentheses and signs.
const DEEPEST: usize = 40;
/// Longest expression, letters.
const LONGEST: usize = 1000;

/// Value of an expression or a part of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Truth(bool),
    /// Value of a parameter that is neither a number nor a truth value.
    Text(String),
}

impl Value {
    /// Reads the value of a parameter.
    fn of(text: &str) -> Self {
        match text.trim() {
            "true" => Self::Truth(true),
            "false" => Self::Truth(false),
            other => match other.parse::<f64>() {
                Ok(number) if number.is_finite() => Self::Number(number),
                _ => Self::Text(text.to_owned()),
            },
        }
    }

    /// Returns the value as attributes have it.
    pub fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Truth(truth) => truth.to_string(),
            Self::Text(text) => text.clone(),
        }
    }

    fn number(&self) -> Result<f64, String> {
        match self {
            Self::Number(number) => Ok(*number),
            Self::Truth(_) | Self::Text(_) => Err(format!("\"{}\" is no number", self.text())),
        }
    }

    fn truth(&self) -> Result<bool, String> {
        match self {
            Self::Truth(truth) => Ok(*truth),
            Self::Number(_) | Self::Text(_) => Err(format!("\"{}\" is neither true nor false", self.text())),
        }
    }
}

/// Returns the value of an expression; `value_of` returns the value of a parameter.
///
/// # Errors
/// The expression is incomplete, names an unknown function or parameter, or has no finite value.
pub(super) fn evaluate(text: &str, value_of: &mut dyn FnMut(&str) -> Result<String, String>) -> Result<Value, String> {
    if text.len() > LONGEST {
        return Err(format!("it has {} letters; allowed: at most {LONGEST}", text.len()));
    }
    let mut parser = Parser { rest: text, value_of, depth: 0 };
    let value = parser.either()?;
    match parser.rest.trim_start() {
        "" => Ok(value),
        rest => Err(format!("\"{}\" does not belong there", beginning(rest))),
    }
}

fn beginning(text: &str) -> String {
    text.chars().take(20).collect()
}

struct Parser<'t, 'p> {
    rest: &'t str,
    value_of: &'p mut dyn FnMut(&str) -> Result<String, String>,
    depth: usize,
}

impl Parser<'_, '_> {
    /// Takes a sign if it comes next.
    fn takes(&mut self, sign: &str) -> bool {
        match self.rest.trim_start().strip_prefix(sign) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    /// Takes a word if it comes next and ends there.
    fn takes_word(&mut self, word: &str) -> bool {
        let after = self.rest.trim_start().strip_prefix(word);
        match after.filter(|after| !after.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_')) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn word(&mut self) -> &str {
        let text = self.rest.trim_start();
        let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.rest = rest;
        word
    }

    fn either(&mut self) -> Result<Value, String> {
        let mut value = self.both()?;
        while self.takes_word("or") {
            let other = self.both()?;
            value = Value::Truth(value.truth()? | other.truth()?);
        }
        Ok(value)
    }

    fn both(&mut self) -> Result<Value, String> {
        let mut value = self.sum()?;
        while self.takes_word("and") {
            let other = self.sum()?;
            value = Value::Truth(value.truth()? & other.truth()?);
        }
        Ok(value)
    }

    fn sum(&mut self) -> Result<Value, String> {
        let mut value = self.product()?;
        loop {
            let sign = if self.takes("+") {
                1.0
            } else if self.takes("-") {
                -1.0
            } else {
                return Ok(value);
            };
            value = finite(value.number()? + sign * self.product()?.number()?)?;
        }
    }

    fn product(&mut self) -> Result<Value, String> {
        let mut value = self.signed()?;
        loop {
            let operation: fn(f64, f64) -> f64 = if self.takes("*") {
                |a, b| a * b
            } else if self.takes("/") {
                |a, b| a / b
            } else if self.takes("%") {
                |a, b| a % b
            } else {
                return Ok(value);
            };
            value = finite(operation(value.number()?, self.signed()?.number()?))?;
        }
    }

    fn signed(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("parentheses and signs within others; allowed: at most {DEEPEST} deep"));
        }
        let value = if self.takes("-") {
            Value::Number(-self.signed()?.number()?)
        } else if self.takes("+") {
            Value::Number(self.signed()?.number()?)
        } else if self.takes_word("not") {
            Value::Truth(!self.signed()?.truth()?)
        } else {
            self.part()?
        };
        self.depth -= 1;
        Ok(value)
    }

    fn part(&mut self) -> Result<Value, String> {
        if self.takes("(") {
            let value = self.either()?;
            return if self.takes(")") { Ok(value) } else { Err("a closing parenthesis is missing".into()) };
        }
        if self.takes("$") {
            let name = self.word().to_owned();
            return (self.value_of)(&name).map(|value| Value::of(&value));
        }
        if self.rest.trim_start().starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return self.number();
        }
        let before = beginning(self.rest.trim_start());
        match self.word().to_owned().as_str() {
            "" if before.is_empty() => Err("the expression is incomplete".into()),
            "" => Err(format!("\"{before}\" does not belong there")),
            "true" => Ok(Value::Truth(true)),
            "false" => Ok(Value::Truth(false)),
            name => self.function(name),
        }
    }

    fn number(&mut self) -> Result<Value, String> {
        let text = self.rest.trim_start();
        let is_part = |(at, c): (usize, char)| {
            let after_exponent = at > 0 && matches!(text.as_bytes()[at - 1], b'e' | b'E');
            c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E') || (after_exponent && matches!(c, '+' | '-'))
        };
        let end = text.char_indices().find(|found| !is_part(*found)).map_or(text.len(), |(at, _)| at);
        let (number, rest) = text.split_at(end);
        self.rest = rest;
        finite(number.parse().map_err(|_| format!("\"{number}\" is no number"))?)
    }

    fn function(&mut self, name: &str) -> Result<Value, String> {
        let one: Option<fn(f64) -> f64> = match name {
            "round" => Some(f64::round),
            "floor" => Some(f64::floor),
            "ceil" => Some(f64::ceil),
            "sqrt" => Some(f64::sqrt),
            "abs" => Some(f64::abs),
            _ => None,
        };
        let two: Option<fn(f64, f64) -> f64> = match name {
            "pow" => Some(f64::powf),
            "max" => Some(f64::max),
            "min" => Some(f64::min),
            _ => None,
        };
        if one.is_none() && two.is_none() {
            let known = "round, floor, ceil, sqrt, abs, pow, max, min";
            return Err(format!("\"{name}\" is no function; allowed: {known}"));
        }
        let missing = |sign: &str| Err(format!("\"{sign}\" is missing after {name}"));
        if !self.takes("(") {
            return missing("(");
        }
        let first = self.either()?.number()?;
        let value = match (one, two) {
            (Some(one), _) => one(first),
            (None, Some(two)) => {
                if !self.takes(",") {
                    return missing(",");
                }
                two(first, self.either()?.number()?)
            }
            (None, None) => first,
        };
        if self.takes(")") { finite(value) } else { missing(")") }
    }
}

fn finite(number: f64) -> Result<Value, String> {
    if number.is_finite() { Ok(Value::Number(number)) } else { Err("its value is no finite number".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<String, String> {
        let mut parameter = |name: &str| match name {
            "a" => Ok("6".to_owned()),
            "b" => Ok("-2.5".to_owned()),
            "yes" => Ok("true".to_owned()),
            "car" => Ok("car_white".to_owned()),
            _ => Err(format!("no parameter {name}")),
        };
        evaluate(text, &mut parameter).map(|value| value.text())
    }

    #[test]
    fn expressions_have_the_values_of_arithmetic() {
        let cases = [
            ("1 + 2 * 3", "7"),
            ("(1 + 2) * 3", "9"),
            ("7 - 2 - 1", "4"),
            ("12 / 4 / 3", "1"),
            ("-7 % 4", "-3"),
            ("$a/4", "1.5"),
            ("$a*$b", "-15"),
            ("- -$a", "6"),
            ("2.5e-1 + 1E2", "100.25"),
            ("round(2.5)", "3"),
            ("floor(-2.5)+ceil(2.1)", "0"),
            ("sqrt(abs($b - 13.5))", "4"),
            ("pow(2, 10)", "1024"),
            ("max(1, min($a, 4))", "4"),
            ("not false and $yes", "true"),
            ("false or not $yes", "false"),
            ("$car", "car_white"),
        ];
        for (text, wanted) in cases {
            assert_eq!(value(text).as_deref(), Ok(wanted), "{text}");
        }
    }

    #[test]
    fn faulty_expressions_say_what_is_wrong() {
        let cases = [
            ("1 +", "incomplete"),
            ("", "incomplete"),
            ("1 2", "\"2\" does not belong there"),
            ("(1", "closing parenthesis"),
            ("1 / 0", "no finite number"),
            ("sqrt(-1)", "no finite number"),
            ("sin(1)", "\"sin\" is no function; allowed: round"),
            ("pow(2)", "\",\" is missing after pow"),
            ("$c", "no parameter c"),
            ("$car + 1", "\"car_white\" is no number"),
            ("not 1", "neither true nor false"),
            ("1 + ü", "does not belong there"),
            ("1..2", "is no number"),
        ];
        for (text, wanted) in cases {
            let fault = value(text).expect_err(text);
            assert!(fault.contains(wanted), "{text}: {fault}");
        }
        assert!(value(&"(".repeat(500)).unwrap_err().contains("at most 40 deep"));
        assert!(value(&"-".repeat(500)).unwrap_err().contains("at most 40 deep"));
        assert!(value(&"1+".repeat(600)).unwrap_err().contains("at most 1000"));
    }
}
