//! Report section and paragraph of the methods on sickness while driving (fast motion sickness scale). In: the ratings of each
//! participant. Out: a table and a figure of each participant over the session, and text.

use super::page::{ReportFigure, ReportPage, TableCells, short};
use crate::analysis::{
    data::{SicknessRating, StudyParticipants},
    text::people as participants,
};
use crate::plot::{Axis, COLOURS, Chart, LineStyle, PlotLine, picture};

/// Largest number of participants with lines in colours of their own; with more, all lines are grey.
const NAMED: usize = COLOURS.len();
/// Upper end of the scale.
const HIGHEST: f64 = 20.0;

/// Groups the ratings by participant, in order.
fn by_participant(people: &StudyParticipants) -> Vec<(&str, Vec<&SicknessRating>)> {
    let mut list: Vec<(&str, Vec<&SicknessRating>)> = Vec::new();
    for rating in &people.ratings {
        match list.iter_mut().find(|(participant, _)| *participant == rating.participant) {
            Some((_, of)) => of.push(rating),
            None => list.push((&rating.participant, vec![rating])),
        }
    }
    list
}

/// Adds the section of the page; none without questions.
pub(super) fn section(page: &mut ReportPage, people: &StudyParticipants) {
    let list = by_participant(people);
    if list.is_empty() {
        return;
    }
    page.put("<h2>Sickness while driving</h2>");
    page.paragraph(
        "lead",
        &format!(
            "{} gives the ratings of each participant, and {} shows them over the session. The file fms.csv has every \
             rating.",
            page.table_links(1),
            page.figure_links(0, 1)
        ),
    );
    let row = |(participant, of): &(&str, Vec<&SicknessRating>)| {
        let values: Vec<f64> = of.iter().filter_map(|rating| rating.value).collect();
        let highest = values.iter().copied().reduce(f64::max);
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
        let number = |value: Option<f64>| value.map_or("–".into(), short);
        let counts = [of.len(), values.len()].map(|n| n.to_string());
        let [asked, answered] = counts;
        // Ratings are whole numbers; their mean is not.
        let whole = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.0}"));
        vec![(*participant).to_owned(), asked, answered, number(mean), whole(highest), whole(values.last().copied())]
    };
    let head = ["Participant", "Asked", "Answered", "Mean", "Highest", "Last"].map(str::to_owned).to_vec();
    page.table(
        &format!(
            "Ratings of sickness while driving, 0 (no sickness at all) to 20 (frank sickness), including drives that \
             were broken off. N = {}.",
            participants(list.len())
        ),
        &head,
        &list.iter().map(row).collect::<Vec<TableCells>>(),
        &[],
    );
    page.figure(ReportFigure {
        name: "sickness".into(),
        svg: figure(&list),
        caption: format!(
            "Ratings of sickness while driving over the session, one line per participant, in the order of the \
             questions. A gap in a line is a question without an answer. N = {}.",
            participants(list.len())
        ),
    });
}

/// Draws a line for each stretch of answers without a gap.
fn figure(list: &[(&str, Vec<&SicknessRating>)]) -> String {
    let mut lines = Vec::new();
    for (i, (participant, of)) in list.iter().enumerate() {
        let is_named = list.len() <= NAMED;
        let colour = if is_named { COLOURS[i] } else { "#999999" };
        let style = LineStyle { width: 1.2, dots: true, ..LineStyle::solid(colour) };
        let points: Vec<Option<[f64; 2]>> =
            of.iter().enumerate().map(|(k, rating)| Some([k as f64 + 1.0, rating.value?])).collect();
        let stretches = points.split(Option::is_none).filter(|stretch| !stretch.is_empty());
        lines.extend(stretches.enumerate().map(|(k, stretch)| PlotLine {
            name: if is_named && k == 0 { (*participant).to_owned() } else { String::new() },
            style,
            points: stretch.iter().flatten().copied().collect(),
            band: Vec::new(),
        }));
    }
    let most = list.iter().map(|(_, of)| of.len()).max().unwrap_or(1);
    let x = Axis::whole("question in the session", [0.5, most as f64 + 0.5]);
    let y = Axis::whole("rating of sickness, 0 to 20", [0.0, HIGHEST]);
    picture(&[Chart { lines, ..Chart::new("", x, y, 180.0) }], "")
}

/// Returns the paragraph of the methods; empty without questions.
pub(super) fn paragraph(people: &StudyParticipants) -> String {
    if people.ratings.is_empty() {
        return String::new();
    }
    let answered = people.ratings.iter().filter(|rating| rating.value.is_some()).count();
    format!(
        "While driving, participants rated their sickness on the fast motion sickness scale (Keshavarz and Hecht, \
         2011, Human Factors 53(4), 415–426) from 0 (no sickness at all) to 20 (frank sickness), with keys or with \
         buttons of the wheel. A question was shown for up to 15 s. {answered} of {} questions were answered.",
        people.ratings.len()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{data::sickness_ratings::ratings, error::AnalysisError, tables};

    const TABLE: &str = "recording\tsegment\tplace\tcondition\tonset\tvalue\tresponse_time\n\
                         trial-1-a\ttrial\t1\ta\t60\t0\t2.5\ntrial-1-a\ttrial\t1\ta\t120\tn/a\tn/a\n\
                         trial-2-b\ttrial\t2\tb\t60\t11\t4.1\n";

    fn read(table: &str) -> Result<Vec<SicknessRating>, AnalysisError> {
        let root = tempfile::tempdir().unwrap();
        let beh = root.path().join("sub-P03/beh");
        std::fs::create_dir_all(&beh).unwrap();
        std::fs::write(beh.join("sub-P03_task-fmsRatings_beh.tsv"), table).unwrap();
        ratings(root.path(), "sub-P03")
    }

    #[test]
    fn each_question_is_a_row_and_one_without_an_answer_has_no_value() {
        let people = StudyParticipants { ratings: read(TABLE).unwrap(), ..StudyParticipants::default() };
        assert_eq!(
            tables::sickness(&people),
            "participant,segment,place,condition,recording,time_s,value,answer_s\n\
             sub-P03,trial,1,a,trial-1-a,60,0,2.5\nsub-P03,trial,1,a,trial-1-a,120,,\nsub-P03,trial,2,b,trial-2-b,60,11,4.1\n"
        );
        let mut page = ReportPage::default();
        section(&mut page, &people);
        // Asked 3, answered 2: mean 5.5, highest and last 11.
        assert!(page.html.contains("<td>3</td><td>2</td><td>5.50</td><td>11</td><td>11</td>"), "{}", page.html);
        assert_eq!(page.figures.len(), 1);
        assert!(page.figures[0].1.contains("sub-P03"), "its line has a name: {}", page.figures[0].1);
        assert!(paragraph(&people).contains("2 of 3 questions were answered"));
        let none = StudyParticipants::default();
        let mut page = ReportPage::default();
        section(&mut page, &none);
        assert_eq!((page.html.as_str(), paragraph(&none).as_str()), ("", ""));
    }

    #[test]
    fn a_table_that_is_not_as_written_is_refused_with_its_line() {
        let message = read(&TABLE.replace("\t11\t", "\thigh\t")).unwrap_err().to_string();
        assert!(message.ends_with("line 4: value is \"high\"; allowed: a number"), "{message}");
        let message = read(&TABLE.replace("\tvalue\t", "\tvalues\t")).unwrap_err().to_string();
        assert!(message.contains("there is no column \"value\""), "{message}");
    }
}
