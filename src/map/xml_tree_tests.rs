//! Compares the compact tree with roxmltree, a general-purpose parser: both read the same elements and values from valid texts, and
//! accept the same texts. They differ by design in the declaration, in references to half a character (`&#xD800;`), and in tags whose
//! names begin with a colon.

use super::xml_tree::{Element, XmlTree};
use crate::rng;
use roxmltree::{Document, Node};
use std::{fs, path::Path};

/// Returns all data of an element that readers of networks use, as text.
fn ours(element: Element) -> String {
    let attributes: Vec<_> = element.attributes().collect();
    let children: Vec<_> = element.children().map(Element::name).collect();
    let id = element.attribute("id");
    format!("{} {attributes:?} {id:?} {children:?}", element.name())
}

/// Returns the same data of a roxmltree node.
fn theirs(node: Node) -> String {
    let own = node.attributes().filter(|attribute| attribute.namespace().is_none());
    let attributes: Vec<_> = own.map(|attribute| (attribute.name(), attribute.value())).collect();
    let children: Vec<_> = node.children().filter(Node::is_element).map(|child| child.tag_name().name()).collect();
    let id = attributes.iter().find(|(name, _)| *name == "id").map(|(_, value)| *value);
    format!("{} {attributes:?} {id:?} {children:?}", node.tag_name().name())
}

/// Returns true if both parsers accept the text, false if neither does.
fn both_read(text: &str) -> bool {
    let (tree, document) = (XmlTree::parse(text), Document::parse(text));
    let (tree, document) = match (tree, document) {
        (Ok(tree), Ok(document)) => (tree, document),
        (Err(_), Err(_)) => return false,
        (tree, document) => panic!("{text}\nours: {:?}\nroxmltree: {:?}", tree.err(), document.err()),
    };
    let mut elements = tree.root().descendants();
    for node in document.descendants().filter(Node::is_element) {
        let element = elements.next().unwrap_or_else(|| panic!("{text}\nends before {node:?}"));
        assert_eq!(ours(element), theirs(node), "{text}");
        // Both count lines from the start.
        if text.len() < 10_000 {
            assert_eq!(element.line(), document.text_pos_at(node.range().start).row, "{text}");
        }
    }
    assert!(elements.next().is_none(), "{text}\nhas more elements than roxmltree finds");
    true
}

#[test]
fn networks_have_the_elements_and_values_of_a_general_parser() {
    let root = Path::new(env!("CODRIVE_ROOT"));
    let files = |folder: &str| fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let networks = files("tests/data").chain(files("tests/data/networks"));
    let networks: Vec<_> = networks.filter(|file| file.to_string_lossy().ends_with(".net.xml")).collect();
    assert_eq!(networks.len(), 19);
    for file in networks {
        assert!(both_read(&fs::read_to_string(&file).unwrap()), "{}", file.display());
    }
}

#[test]
fn an_attribute_with_a_prefix_is_not_the_attribute_of_that_name() {
    let tree = XmlTree::parse("<net xmlns:x=\"u\"><a x:id=\"other\" id=\"own\" x:b=\"1\"/></net>").ok().unwrap();
    let element = tree.root().children().next().unwrap();
    assert_eq!((element.attribute("id"), element.has_attribute("b")), (Some("own"), false));
}

const SMALL: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- a comment -->\n<net version=\"1.20\" \
                     xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:noNamespaceSchemaLocation=\"x.xsd\">\n  <a \
                     id=\"1\" b='2 &lt; 3 &#10; \"'>words &amp; more<b c=\"d\"/></a >\n  <e id=\"x&amp;lt;y\"\n     \
                     f=\"a\tb\r\nc\"/><![CDATA[ <c> ]]>\n  <?pi here?>\n</net>\n";

#[test]
fn mutated_texts_are_accepted_or_refused_as_by_a_general_parser() {
    const PIECES: [&str; 40] = [
        "<",
        ">",
        "/",
        "\"",
        "'",
        "=",
        " ",
        "&",
        ";",
        "&lt;",
        "&#10;",
        "&#x0;",
        "&#xFFFF;",
        "&none;",
        "<!--",
        "-->",
        "--",
        "<![CDATA[",
        "]]>",
        "<?xml version=\"1.0\"?>",
        "<?p q?>",
        "?>",
        "<!DOCTYPE a>",
        "\n",
        "\r\n",
        "\t",
        "xmlns:a=\"b\"",
        "a:b",
        "xmlns",
        "x",
        "\u{1}",
        "\u{fffe}",
        "é",
        "1",
        "-",
        ".",
        "<a/>",
        "</a>",
        "<b c=\"d\">",
        "&amp;lt;",
    ];
    let mut stream = rng::stream(1, "xml");
    let declaration = SMALL.find('\n').unwrap();
    let ends: Vec<usize> = (declaration..=SMALL.len()).collect();
    let mut taken = 0;
    for _ in 0..20_000 {
        let at = ends[stream.index(ends.len())];
        let gone = stream.index(4).min(SMALL.len() - at);
        let piece = if stream.index(3) == 0 { "" } else { PIECES[stream.index(PIECES.len())] };
        taken += usize::from(both_read(&format!("{}{piece}{}", &SMALL[..at], &SMALL[at + gone..])));
    }
    assert!((1000..19_000).contains(&taken), "{taken} of 20000 were taken: too few of one kind");
}

#[test]
fn a_fault_has_its_position_in_the_text() {
    for (text, at, expected) in [
        ("<net>\n<a b=\"1\" b=\"2\"/></net>", 15, "the attribute \"b\" is given twice"),
        ("<net a=\"x<y\"/>", 9, "< in a value"),
        ("<net a=\"1\"b=\"2\"/>", 10, "a space is missing"),
        ("<net>\u{7}</net>", 5, "a character that XML does not allow"),
        ("<net></net><net/>", 11, "a second outermost element"),
        ("<!DOCTYPE net><net/>", 0, "a document type"),
        ("<net><x:a/></net>", 5, "the prefix \"x\" is not declared"),
        ("<net>\n  <a b=\"1\"\n</net>", 17, "a tag begins before the previous tag is closed"),
        ("<net>\n</nut>", 6, "expected `</net>`"),
        ("<net><a>", 8, "the text ends before </a>"),
        ("<net a=\"&none;\"/>", 8, "none"),
        ("", 0, "the document has no element"),
    ] {
        let fault = XmlTree::parse(text).err().unwrap_or_else(|| panic!("{text} is taken"));
        assert!(fault.message.contains(expected), "{text}: {}", fault.message);
        assert_eq!(fault.at, at, "{text}: {}", fault.message);
    }
}
