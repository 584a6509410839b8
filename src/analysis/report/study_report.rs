//! Report of an analysis. In: analysed drives. Out: HTML that opens off-line, with style and figures inside, and the methods as
//! plain text. Quantities have their titles; column names occur only in the data dictionary.

use super::{
    by_condition,
    dictionary::dictionary,
    drive_section, drivers_section, every_drive,
    methods::{self, SLOW_SHARE},
    models_section,
    page::ReportPage,
    participant_flow::ParticipantFlow,
    scores_section::scores,
    sickness_section,
};
use crate::analysis::{
    data::StudyParticipants,
    drivers::ParticipantDriver,
    drives::{AnalysedRecording, conditions, is_of_several_people, participants},
    error::AnalysisError,
    measures::index,
    models::planned::PlannedAnalysis,
    text::{count, on_one_line},
};
use crate::plot::escaped;

/// Page of a report with its methods and figures.
pub struct StudyReport {
    /// Page as one HTML text.
    pub html: String,
    /// Methods as plain text.
    pub methods: String,
    /// File names and SVG texts of the figures.
    pub figures: Vec<(String, String)>,
}

/// Agreement of the analysed files with their checksums, and with a signature.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileProof {
    /// Sentences on files that have changed or are not in their place.
    pub changed: Vec<String>,
    /// Sentence on the signer of the files, or on a missing signature; `None` if parts have changed.
    pub signature: Option<String>,
}

/// Makes the page.
///
/// # Errors
/// A recording whose figures are drawn cannot be read.
pub fn report(
    title: &str,
    drives: &[AnalysedRecording],
    study_participants: &StudyParticipants,
    proof: &FileProof,
    drivers: &[ParticipantDriver],
    planned: Option<&PlannedAnalysis>,
) -> Result<StudyReport, AnalysisError> {
    let mut page = ReportPage::titled(title);
    let all: Vec<&AnalysedRecording> = drives.iter().collect();
    let is_study = is_of_several_people(drives);
    let of = if is_study { format!(" of {} participants", participants(&all)) } else { String::new() };
    page.paragraph(
        "note",
        &format!(
            "{}{of}, analysed with codrive {}. The <a href=\"#methods\">methods</a> are ready to copy. The <a \
             href=\"#data-dictionary\">data dictionary</a> defines every quantity.",
            count(drives.len()),
            env!("CARGO_PKG_VERSION")
        ),
    );
    if !proof.changed.is_empty() {
        page.put(
            "<p class=\"warning\"><b>Files that were changed, are missing or are out of place (analysed \
             nevertheless, except those of participants who are left out):</b></p><ul>",
        );
        proof.changed.iter().for_each(|what| page.put(&format!("<li>{}</li>", escaped(what))));
        page.put("</ul>");
    }
    if let Some(signature) = &proof.signature {
        page.paragraph("note", &format!("Files: {}.", escaped(signature)));
    }
    took_part(&mut page, study_participants);
    faults(&mut page, drives);
    let flow = ParticipantFlow::of(study_participants, drives, planned);
    if let Some(flow) = &flow {
        flow.section(&mut page);
    }
    let sample = methods::sample(&all, study_participants);
    if !sample.is_empty() {
        page.paragraph("", &escaped(&sample));
    }
    if let Some(planned) = planned {
        models_section::section(&mut page, planned);
    }
    let is_compared = is_study && !conditions(drives).is_empty();
    if is_compared {
        by_condition::study(&mut page, drives);
    }
    drive_section::one_by_one(&mut page, drives, is_compared)?;
    scores(&mut page, study_participants);
    sickness_section::section(&mut page, study_participants);
    drivers_section::section(&mut page, drivers);
    every_drive::every(&mut page, drives);
    let mut methods = methods::paragraphs(drives, study_participants, drivers);
    methods.extend(planned.map(models_section::paragraph));
    if let Some(flow) = &flow {
        // After the paragraph on who took part.
        methods.insert(1.min(methods.len()), flow.paragraph());
    }
    // Answers, reasons and descriptions of questionnaires may contain control characters.
    methods.iter_mut().for_each(|text| *text = on_one_line(text));
    page.put("<section id=\"methods\">\n<h2>Methods (to copy)</h2>");
    page.paragraph("note lead", "The file methods.txt beside this page has the same text, and the measures as a table; here the data dictionary defines them.");
    methods.iter().for_each(|text| page.put(&format!("<p>{}</p>", escaped(text))));
    page.put("</section>");
    dictionary(&mut page, drives);
    page.put("</body></html>");
    Ok(StudyReport { html: page.html, methods: methods::text(&methods, drives), figures: page.figures })
}

/// Adds a paragraph on the participants by state, with a warning about simulated ones.
pub(super) fn took_part(page: &mut ReportPage, people: &StudyParticipants) {
    if people.is_rehearsal() {
        page.put("<p class=\"warning\"><b>A rehearsal: all participants are simulated; no person drove.</b></p>");
    }
    if !people.all.is_empty() {
        let left_out = people.all.iter().any(|person| person.is_excluded());
        let left_out = if left_out { "; drives and answers of excluded participants are left out" } else { "" };
        page.paragraph("note", &format!("Participants: {}{left_out}.", escaped(&people.to_string())));
    }
}

/// Adds a warning that names the drives with contacts with other vehicles, and one that names those seen in slow motion.
pub(super) fn faults(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    let contacts = index("contact_count");
    let count_of = |drive: &AnalysedRecording| drive.measures.values[contacts].filter(|count| *count > 0.0);
    named(page, drives, "Contacts with other vehicles", |drive| Some(format!("{:.0}", count_of(drive)?)));
    let slow = |drive: &AnalysedRecording| (drive.dropped_share() > SLOW_SHARE).then(|| 100.0 * drive.dropped_share());
    let title = "Pictures came too late, and more than 1 % of the time was seen in slow motion";
    named(page, drives, title, |drive| Some(format!("{:.0} %", slow(drive)?)));
}

/// Adds a warning that names the drives with a value; nothing if there is none.
fn named(
    page: &mut ReportPage,
    drives: &[AnalysedRecording],
    title: &str,
    value: impl Fn(&AnalysedRecording) -> Option<String>,
) {
    const MOST: usize = 20;
    let hit: Vec<String> = drives
        .iter()
        .filter_map(|drive| Some(format!("{} ({})", escaped(&drive.found.title()), value(drive)?)))
        .collect();
    if hit.is_empty() {
        return;
    }
    let more = if hit.len() > MOST { format!(" and {} more", hit.len() - MOST) } else { String::new() };
    page.paragraph(
        "warning",
        &format!(
            "{title} in {} of {}: {}{more}.",
            hit.len(),
            count(drives.len()),
            hit[..hit.len().min(MOST)].join(", ")
        ),
    );
}
