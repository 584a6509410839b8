//! The table of participants, `participants.tsv`. In: the logs of all sessions. Out: one row per participant: number, kind, order, state, and
//! the parameters of simulated participants.

use super::{
    Completion,
    bids::{self, TsvColumn, TsvTable},
    session_log::{ParticipantKind, SessionLog},
};

/// Returns the table, in the order of the logs.
pub(super) fn participants(logs: &[SessionLog]) -> TsvTable {
    let levels = |words: &[(&str, &str)]| words.iter().map(|(w, t)| ((*w).into(), (*t).into())).collect::<Vec<_>>();
    let mut table = TsvTable::new(vec![
        TsvColumn::new("participant_id", "code of the participant", ""),
        TsvColumn::new("number", "number in the study, from 1; it determines the order of conditions", ""),
        TsvColumn::new("frames_per_s", "frames per second that the computer drew before the first page", "1/s"),
        TsvColumn::new("kind", "kind of driver", "")
            .with(levels(&[("person", "a person"), ("simulated", "a simulated participant of a rehearsal")])),
        TsvColumn::new("order", "conditions in this participant's order, joined by commas", ""),
        TsvColumn::new("state", "progress of the session", "")
            .with(Completion::ALL.map(|state| (state.to_string(), state.meaning().into()))),
    ]);
    let mut traits: Vec<&String> = logs.iter().flat_map(|log| log.traits.keys()).collect();
    traits.sort();
    traits.dedup();
    for name in &traits {
        let unit = if name.ends_with("_mps") {
            "m/s"
        } else if name.ends_with("_s") {
            "s"
        } else {
            ""
        };
        table.columns.push(TsvColumn::new(&format!("true_{name}"), "number of the simulated participant", unit));
    }
    for log in logs {
        let kind = if log.kind == ParticipantKind::Person { "person" } else { "simulated" };
        let mut row = vec![
            log.participant.subject(),
            (log.index + 1).to_string(),
            bids::number(log.frames_per_s),
            kind.into(),
            log.order.join(","),
            Completion::of(log).to_string(),
        ];
        row.extend(traits.iter().map(|name| bids::number(log.traits.get(*name).copied())));
        table.rows.push(row);
    }
    table
}
