//! Repairs files for an import. In: the text of an OpenDRIVE document. Out: the same text without signals, signs and objects, which
//! netconvert may fail to read and would not import anyway, and with arcs of zero curvature as straight lines. For a network that
//! netconvert made: lanes with a speed limit of 0 get netconvert's default.

/// Returns the repaired text and a list of the repairs; `None` if there is nothing to repair.
pub(super) fn repair(text: &str) -> Option<(String, Vec<String>)> {
    let (text, signals) = without_elements(text, "signals");
    let (text, objects) = without_elements(&text, "objects");
    let (text, arcs) = with_lines_for_flat_arcs(&text);
    let mut done = Vec::new();
    if signals > 0 {
        done.push(format!("signals and signs of {signals} roads removed"));
    }
    if objects > 0 {
        done.push(format!("objects of {objects} roads removed"));
    }
    if arcs > 0 {
        done.push(format!("{arcs} arcs without curvature replaced by lines"));
    }
    (!done.is_empty()).then_some((text, done))
}

/// Returns the text without the elements of this name, and their number. The elements must not be nested.
fn without_elements(text: &str, name: &str) -> (String, usize) {
    let (begin, end) = (format!("<{name}"), format!("</{name}>"));
    let (mut kept, mut rest, mut n) = (String::with_capacity(text.len()), text, 0);
    while let Some(at) = find_tag(rest, &begin) {
        let Some(close) = rest[at..].find('>').map(|k| at + k) else { break };
        let after = match rest[..close].ends_with('/') {
            true => Some(close + 1),
            false => rest[close..].find(&end).map(|k| close + k + end.len()),
        };
        let Some(after) = after else { break };
        kept.push_str(&rest[..at]);
        rest = &rest[after..];
        n += 1;
    }
    kept.push_str(rest);
    (kept, n)
}

/// Replaces arcs of zero curvature by lines and returns their number: netconvert divides by the curvature.
fn with_lines_for_flat_arcs(text: &str) -> (String, usize) {
    let (mut kept, mut rest, mut n) = (String::with_capacity(text.len()), text, 0);
    while let Some(at) = find_tag(rest, "<arc") {
        let Some(close) = rest[at..].find('>').map(|k| at + k) else { break };
        let tag = &rest[at..close];
        let value = tag.split_once("curvature=").and_then(|(_, value)| value.get(1..)?.split(['"', '\'']).next());
        let is_flat = value.and_then(|value| value.trim().parse().ok()).is_some_and(|bend: f64| bend == 0.0);
        if is_flat && tag.ends_with('/') {
            kept.push_str(&rest[..at]);
            kept.push_str("<line/>");
            n += 1;
        } else {
            kept.push_str(&rest[..=close]);
        }
        rest = &rest[close + 1..];
    }
    kept.push_str(rest);
    (kept, n)
}

/// Default speed limit of netconvert for roads without one, as a network writes it, m/s, and as text. OpenDRIVE files write 0 or -1 for
/// an unknown limit, and netconvert turns both into 0, at which no vehicle could drive.
const DEFAULT_LIMIT: (&str, &str) = ("13.89", "50 km/h");

/// Returns the text of a network with a positive speed limit for each lane, and a sentence on the number of lanes changed; `None` if all
/// lanes have one.
pub(super) fn with_default_limits(text: &str) -> Option<(String, String)> {
    let (mut kept, mut rest, mut n) = (String::new(), text, 0);
    while let Some(at) = find_tag(rest, "<lane") {
        let Some(close) = rest[at..].find('>').map(|k| at + k) else { break };
        let value = rest[at..close].find(" speed=\"").map(|k| at + k + 8);
        let value = value.and_then(|begin| Some((begin, begin + rest[begin..close].find('"')?)));
        match value.filter(|(begin, end)| rest[*begin..*end].parse().is_ok_and(|limit: f64| limit <= 0.0)) {
            Some((begin, end)) => {
                kept.push_str(&rest[..begin]);
                kept.push_str(DEFAULT_LIMIT.0);
                rest = &rest[end..];
                n += 1;
            }
            None => {
                kept.push_str(&rest[..close]);
                rest = &rest[close..];
            }
        }
    }
    kept.push_str(rest);
    let lanes = if n == 1 { "1 lane that has".to_owned() } else { format!("{n} lanes that have") };
    (n > 0).then(|| (kept, format!("{} for {lanes} a speed limit of 0", DEFAULT_LIMIT.1)))
}

/// Returns the position of the first tag with exactly this name.
fn find_tag(text: &str, begin: &str) -> Option<usize> {
    let ends =
        |at: &usize| text[at + begin.len()..].starts_with(|c: char| c.is_ascii_whitespace() || ['>', '/'].contains(&c));
    text.match_indices(begin).map(|(at, _)| at).find(ends)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_are_removed_flat_arcs_become_lines_and_all_else_stays() {
        let text = "<OpenDRIVE><road><geometry s=\"0\"><arc curvature=\"0.00\"/></geometry><geometry s=\"9\"><arc \
                    curvature='-0.02'/></geometry><signals a=\"1\"><signal type=\"\"/></signals></road><road><signals/><signalsX/>\
                    <objects>x</objects></road></OpenDRIVE>";
        let (mended, done) = repair(text).unwrap();
        assert_eq!(
            mended,
            "<OpenDRIVE><road><geometry s=\"0\"><line/></geometry><geometry s=\"9\"><arc curvature='-0.02'/></geometry></road>\
             <road><signalsX/></road></OpenDRIVE>"
        );
        assert_eq!(
            done,
            [
                "signals and signs of 2 roads removed",
                "objects of 1 roads removed",
                "1 arcs without curvature replaced by lines"
            ]
        );
        assert_eq!(repair("<OpenDRIVE><road/></OpenDRIVE>"), None);
        assert_eq!(repair("<OpenDRIVE><signals>"), None, "cut off");
    }

    #[test]
    fn lanes_with_a_limit_of_0_get_the_default_and_others_stay() {
        let text = "<net><edge speed=\"0\"><lane id=\"a\" speed=\"0.000000\" length=\"9\"/><lane id=\"b\" speed=\"0.50\"/><lane speed=\"-1\"/>\
                    <lanes speed=\"0\"/></edge></net>";
        let (mended, done) = with_default_limits(text).unwrap();
        assert_eq!(
            mended,
            "<net><edge speed=\"0\"><lane id=\"a\" speed=\"13.89\" length=\"9\"/><lane id=\"b\" speed=\"0.50\"/><lane speed=\"13.89\"/>\
             <lanes speed=\"0\"/></edge></net>"
        );
        assert_eq!(done, "50 km/h for 2 lanes that have a speed limit of 0");
        assert_eq!(with_default_limits("<net><lane speed=\"9\"/></net>"), None);
    }
}
