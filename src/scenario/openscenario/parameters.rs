//! Parameters of OpenSCENARIO and the elements that use them. In: elements with `ParameterDeclarations`. Out: [`Node`]s, whose attributes have
//! the values of the parameters that are declared around them. Parameters are constants here: actions that
//! change them matter to conditions on them alone.

use super::{
    document::{Element, Place},
    expression::evaluate,
    fault::OpenScenarioError,
};
use crate::toml_text::did_you_mean;
use std::{collections::BTreeMap, rc::Rc};

/// Names of elements that only describe, draw or limit, and are read over.
const DECORATION: [&str; 9] = [
    "FileHeader",
    "ParameterDeclarations",
    "Properties",
    "Performance",
    "Axles",
    "SceneGraphFile",
    "TrailerHitch",
    "TrailerCoupler",
    "License",
];

/// Largest number of parameters of one level of which each needs the next.
const LONGEST_CHAIN: usize = 100;

/// Parameters that are declared at one level, and those around it.
#[derive(Debug, Default)]
pub(super) struct Scope {
    around: Option<Rc<Scope>>,
    values: BTreeMap<String, String>,
}

impl Scope {
    /// Reads the declarations of an element; `given` are values that replace the declared ones, as names and values.
    ///
    /// # Errors
    /// A parameter has no name or no value, names an unknown one, or is declared by itself.
    pub fn of(element: &Element, around: &Rc<Self>, given: &[(String, String)]) -> Result<Rc<Self>, OpenScenarioError> {
        let Some(list) = element.child("ParameterDeclarations") else {
            return Ok(Rc::clone(around));
        };
        let declared = list.children.iter().filter(|child| child.name == "ParameterDeclaration");
        let mut raw = BTreeMap::new();
        for declaration in declared {
            let part = |name: &str| {
                let missing = || declaration.place.fault(format!("<ParameterDeclaration> has no {name}"));
                declaration.attribute(name).ok_or_else(missing)
            };
            raw.insert(part("name")?.trim_start_matches('$').to_owned(), (part("value")?, &declaration.place));
        }
        let mut scope = Self { around: Some(Rc::clone(around)), values: given.iter().cloned().collect() };
        for (name, (_, place)) in &raw {
            scope.settle(name, &raw, &mut Vec::new()).map_err(|why| place.fault(format!("parameter {name}: {why}")))?;
        }
        Ok(Rc::new(scope))
    }

    /// Finds the value of a parameter of this level, which may use others of it. `open` are those that wait for it.
    fn settle(
        &mut self,
        name: &str,
        raw: &BTreeMap<String, (&str, &Place)>,
        open: &mut Vec<String>,
    ) -> Result<String, String> {
        if let Some(known) = self.values.get(name) {
            return Ok(known.clone());
        }
        if open.iter().any(|waits| waits == name) {
            let circle = open.join(" → ");
            return Err(format!("its value needs itself: {circle} → {name}\n  remedy: give one of them a number"));
        }
        if open.len() > LONGEST_CHAIN {
            return Err(format!("more than {LONGEST_CHAIN} parameters need each other; allowed: fewer"));
        }
        let Some((text, _)) = raw.get(name) else { return self.value(name) };
        open.push(name.to_owned());
        let value = resolved(text, &mut |other| self.settle(other, raw, open))?;
        open.pop();
        self.values.insert(name.to_owned(), value.clone());
        Ok(value)
    }

    fn value(&self, name: &str) -> Result<String, String> {
        let mut scope = Some(self);
        let mut known = Vec::new();
        while let Some(here) = scope {
            if let Some(value) = here.values.get(name) {
                return Ok(value.clone());
            }
            known.extend(here.values.keys().map(String::as_str));
            scope = here.around.as_deref();
        }
        Err(format!("no parameter ${name} is declared{}", did_you_mean(name, &known)))
    }
}

/// Returns a text with its parameter or its expression replaced by the value.
fn resolved(text: &str, value_of: &mut dyn FnMut(&str) -> Result<String, String>) -> Result<String, String> {
    let trimmed = text.trim();
    if let Some(inner) = trimmed.strip_prefix("${").and_then(|inner| inner.strip_suffix('}')) {
        return evaluate(inner, value_of)
            .map(|value| value.text())
            .map_err(|why| format!("the expression \"{trimmed}\" has no value: {why}"));
    }
    match trimmed.strip_prefix('$') {
        Some(name) => value_of(name),
        None => Ok(text.to_owned()),
    }
}

/// Element with the parameters around it.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub element: Rc<Element>,
    pub scope: Rc<Scope>,
}

impl Node {
    /// Returns an element with the parameters around it and its own.
    ///
    /// # Errors
    /// As [`Scope::of`].
    pub fn new(element: &Rc<Element>, around: &Rc<Scope>) -> Result<Self, OpenScenarioError> {
        Ok(Self { element: Rc::clone(element), scope: Scope::of(element, around, &[])? })
    }

    pub fn name(&self) -> &str {
        &self.element.name
    }

    pub fn place(&self) -> &Place {
        &self.element.place
    }

    /// Returns an error at this element, which its name begins.
    pub fn fault(&self, message: impl std::fmt::Display) -> OpenScenarioError {
        self.place().fault(format!("<{}>: {message}", self.name()))
    }

    /// Returns all children but those that only describe.
    pub fn children(&self) -> Result<Vec<Self>, OpenScenarioError> {
        let shown = self.element.children.iter().filter(|child| !DECORATION.contains(&child.name.as_str()));
        shown.map(|child| Self::new(child, &self.scope)).collect()
    }

    /// Returns the children with this name.
    pub fn all(&self, name: &str) -> Result<Vec<Self>, OpenScenarioError> {
        let named = self.element.children.iter().filter(|child| child.name == name);
        named.map(|child| Self::new(child, &self.scope)).collect()
    }

    /// Returns the first child with this name.
    pub fn find(&self, name: &str) -> Result<Option<Self>, OpenScenarioError> {
        self.element.child(name).map(|child| Self::new(child, &self.scope)).transpose()
    }

    /// Returns the child with this name, which the element must have.
    pub fn child(&self, name: &str) -> Result<Self, OpenScenarioError> {
        self.find(name)?.ok_or_else(|| self.fault(format!("<{name}> is missing")))
    }

    /// Returns the only child that says what kind of thing the element is.
    pub fn only(&self) -> Result<Self, OpenScenarioError> {
        self.children()?.into_iter().next().ok_or_else(|| self.fault("it is empty"))
    }

    /// Returns the declared value of a parameter.
    ///
    /// # Errors
    /// No parameter of this name is declared here.
    pub fn declared(&self, parameter: &str) -> Result<String, OpenScenarioError> {
        self.scope.value(parameter).map_err(|why| self.fault(why))
    }

    /// Returns the value of an attribute.
    pub fn find_text(&self, name: &str) -> Result<Option<String>, OpenScenarioError> {
        let Some(raw) = self.element.attribute(name) else { return Ok(None) };
        let value = resolved(raw, &mut |parameter| self.scope.value(parameter));
        value.map(Some).map_err(|why| self.fault(format!("{name}: {why}")))
    }

    /// Returns the value of an attribute, which the element must have.
    pub fn text(&self, name: &str) -> Result<String, OpenScenarioError> {
        self.find_text(name)?.ok_or_else(|| self.fault(format!("the attribute {name} is missing")))
    }

    /// Returns the name that an element gives itself; as it is written where it is no expression of this standard, as only messages have it.
    pub fn title(&self) -> String {
        let named = self.find_text("name").ok().flatten();
        named.or_else(|| self.element.attribute("name").map(str::to_owned)).unwrap_or_default()
    }

    /// Returns a finite number.
    pub fn find_number(&self, name: &str) -> Result<Option<f64>, OpenScenarioError> {
        let Some(text) = self.find_text(name)? else { return Ok(None) };
        match text.trim().parse::<f64>() {
            Ok(number) if number.abs() <= 1e9 => Ok(Some(number)),
            _ => Err(self.fault(format!("{name} is \"{text}\"; allowed: a number within 1,000,000,000"))),
        }
    }

    /// Returns a finite number, which the element must have.
    pub fn number(&self, name: &str) -> Result<f64, OpenScenarioError> {
        self.find_number(name)?.ok_or_else(|| self.fault(format!("the attribute {name} is missing")))
    }

    /// Returns a whole number, which the element must have.
    pub fn whole(&self, name: &str) -> Result<i32, OpenScenarioError> {
        let number = self.number(name)?;
        match number.fract() == 0.0 && number.abs() < 1e6 {
            true => Ok(number as i32),
            false => Err(self.fault(format!("{name} is {number}; allowed: a whole number"))),
        }
    }

    /// Returns true or false; `false` without the attribute.
    pub fn truth(&self, name: &str) -> Result<bool, OpenScenarioError> {
        match self.find_text(name)?.as_deref().map(str::trim) {
            None | Some("false" | "0") => Ok(false),
            Some("true" | "1") => Ok(true),
            Some(other) => Err(self.fault(format!("{name} is \"{other}\"; allowed: true, false"))),
        }
    }

    /// Returns one of several words, by its value.
    pub fn choice<T: Copy>(&self, name: &str, allowed: &[(&str, T)]) -> Result<T, OpenScenarioError> {
        let text = self.text(name)?;
        let found = allowed.iter().find(|(word, _)| *word == text.trim());
        found.map(|(_, value)| *value).ok_or_else(|| {
            let words: Vec<&str> = allowed.iter().map(|(word, _)| *word).collect();
            let near = did_you_mean(&text, &words);
            self.fault(format!("{name} is \"{text}\"{near}; allowed: {}", words.join(", ")))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::openscenario::document;

    fn root(text: &str) -> Result<Node, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.xosc");
        std::fs::write(&file, format!("<OpenSCENARIO>\n{text}</OpenSCENARIO>")).expect("written");
        let root = document::read(&file).expect("XML");
        Node::new(&root, &Rc::default())
            .map_err(|error| error.to_string().replace(&folder.path().display().to_string(), ""))
    }

    fn declared(parameters: &[(&str, &str)]) -> String {
        let one = |(name, value): &(&str, &str)| {
            format!("<ParameterDeclaration name=\"{name}\" parameterType=\"double\" value=\"{value}\"/>\n")
        };
        format!("<ParameterDeclarations>\n{}</ParameterDeclarations>", parameters.iter().map(one).collect::<String>())
    }

    #[test]
    fn attributes_have_the_values_of_the_nearest_parameters() {
        let inner = format!("<Story x=\"$v\" y=\"${{$w + 1}}\">{}</Story>", declared(&[("v", "3")]));
        let text = declared(&[("w", "${$v * 2}"), ("v", "5"), ("word", "car")]);
        let node = root(&(text + "<A x=\"$v\" y=\"$w\" z=\"$word\" n=\"1e9\"/>" + &inner)).expect("a node");
        let a = node.child("A").expect("a child");
        assert_eq!([a.number("x"), a.number("y"), a.number("n")].map(Result::unwrap), [5.0, 10.0, 1e9]);
        assert_eq!(a.text("z").unwrap(), "car");
        let story = node.child("Story").expect("a child");
        assert_eq!([story.number("x"), story.number("y")].map(Result::unwrap), [3.0, 11.0]);
    }

    #[test]
    fn given_values_replace_declared_ones() {
        let node = root(&format!("<M>{}</M>", declared(&[("a", "1"), ("b", "${$a + 1}")]))).expect("a node");
        let scope = Scope::of(&node.element.children[0], &node.scope, &[("a".into(), "7".into())]).expect("a scope");
        assert_eq!(scope.value("b").as_deref(), Ok("8"));
    }

    #[test]
    fn faulty_parameters_and_values_are_named_with_their_line() {
        let circle = root(&declared(&[("a", "$b"), ("b", "${$c + 1}"), ("c", "$a")])).unwrap_err();
        assert!(circle.starts_with("/a.xosc:3: parameter a: ") && circle.contains("a → b → c → a"), "{circle}");
        let unknown = root(&declared(&[("speed", "$sped")])).unwrap_err();
        assert!(unknown.starts_with("/a.xosc:3: parameter speed: no parameter $sped is declared"), "{unknown}");
        let node = root("<A x=\"fast\"\n y=\"$speed\" z=\"1.5\" w=\"nan\" v=\"${1 / 0}\"/>").expect("a node");
        let a = node.child("A").expect("a child");
        let fault = |found: Result<f64, OpenScenarioError>| found.unwrap_err().message;
        assert_eq!(fault(a.number("x")), "<A>: x is \"fast\"; allowed: a number within 1,000,000,000");
        assert!(fault(a.number("y")).starts_with("<A>: y: no parameter $speed is declared"));
        assert_eq!(fault(a.whole("z").map(f64::from)), "<A>: z is 1.5; allowed: a whole number");
        assert!(a.number("w").is_err() && fault(a.number("v")).contains("no finite number"));
        assert_eq!(fault(a.number("u")), "<A>: the attribute u is missing");
        assert!(a.choice("x", &[("fat", 1), ("slow", 2)]).unwrap_err().message.contains("did you mean fat?"));
        assert_eq!(a.place().line, 2);
    }
}
