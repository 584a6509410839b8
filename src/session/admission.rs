//! Checks before a session begins: whether the participant can be led here and now. In: options, files of the data set, the participant's window. Out:
//! an open session, or the reason against it.

use super::window::SessionOptions;
use crate::{
    desktop::DriverWindow,
    doctor,
    drive_loop::{RunError, baselines, recording_manifest},
    scenario::Scenario,
    sim::World,
    study::{
        DataSet, PlanItem, Session, SessionError, Study, lock,
        session::{self, ParticipantKind, SessionLog},
    },
};
use std::io::Write;

/// Opens the session of the participant.
pub(super) fn open_session(options: &SessionOptions, data: &DataSet) -> Result<Session, RunError> {
    let index = data.next_index()?;
    Ok(Session::open(data, &options.study, &options.code, ParticipantKind::Person, index, &recording_manifest::now())?)
}

/// Refuses the data set of a rehearsal. Makes missing baselines of a session that is over, which happens if its window was closed while
/// they were driven; such a session is then refused.
pub(super) fn look_ahead(options: &SessionOptions, data: &DataSet) -> Result<(), RunError> {
    if let Some(log) = data.logs()?.iter().find(|log| log.kind == ParticipantKind::Simulated) {
        return Err(SessionError::Refused(format!(
            "{} holds a rehearsal ({}); sessions with people need another folder",
            data.root().display(),
            log.participant
        ))
        .into());
    }
    let folder = data.source(&options.code);
    let path = folder.join(session::FILE);
    if !path.exists() || SessionLog::load(&path)?.end.is_none() {
        return Ok(());
    }
    let lock = lock::lock(&folder, &options.code)?;
    let [made, missing] = baselines::make_up(data, &options.study, &options.code, &options.stop, &|_| ())?;
    if missing > 0 {
        let of = if made < missing { format!("{made} of {missing}") } else { made.to_string() };
        let were = if missing == 1 { "baseline was" } else { "baselines were" };
        let rest = if made < missing { ": run the same command to make the rest" } else { "" };
        let text = format!("{of} missing {were} made for participant {}{rest}", options.code);
        // The session continues even if standard output is closed.
        let _ = writeln!(std::io::stdout(), "{text}");
    }
    drop(lock);
    open_session(options, data).map(drop)
}

/// Refuses a session whose first drive this computer draws less often than the study asks for: a participant would drive in slow motion.
pub(super) fn check_frame_rate(study: &Study, session: &mut Session, picture: &DriverWindow) -> Result<(), RunError> {
    let asked = study.file.least_frames_per_s;
    let first_drive = scenarios(session).next().cloned();
    let Some(scenario) = first_drive.filter(|_| asked > 0.0) else { return Ok(()) };
    let [width, height] = picture.size();
    let frames_per_s = doctor::frames_per_s(picture.gpu(), &World::without_sumo(&scenario)?, [width, height])?;
    session.set_frames_per_s(frames_per_s)?;
    if frames_per_s >= asked {
        return Ok(());
    }
    Err(SessionError::Refused(format!(
        "this computer draws {frames_per_s:.1} frames a second at {width}x{height}; the study asks for {asked} \
         (least_frames_per_s)\n  remedy: a computer with a faster graphics card, a smaller window (--size), or quality = \
         \"low\" in the study's [base]; no page was shown, and the same command goes on with participant {}",
        session.log().participant
    ))
    .into())
}

/// Returns the scenarios of the session's drives, in order.
pub(super) fn scenarios(session: &Session) -> impl Iterator<Item = &Scenario> {
    session.plan().items.iter().filter_map(|planned| match &planned.item {
        PlanItem::Drive { scenario, .. } => Some(&**scenario),
        _ => None,
    })
}
