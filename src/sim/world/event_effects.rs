//! Effects of the scenario's events and of the secondary task on the world. In: the state of the events. Out: what the participant sees and feels and is
//! asked, people on the road, and contacts that end the drive.

use super::World;
use crate::{
    controls::TaskButton,
    scenario::OnContact,
    sim::event::{PERSON_TOUCHED, ScriptedState},
    snapshot::EventStimuli,
    time::Tick,
};
use std::sync::Arc;

impl World {
    /// Lets events of the scenario act on the participant and the car in the step that begins.
    pub(super) fn apply_events(&mut self) {
        if let Some(participant) = self.observer.participant_mut() {
            let effects = self.script.effects(participant.view.tick);
            participant.view.message = effects.message;
            let has_stimuli = effects.stimuli != EventStimuli::default();
            participant.view.stimuli = has_stimuli.then(|| Arc::new(effects.stimuli));
            participant.hides_advice = effects.hides_advice;
            participant.view.weather = effects.weather;
            participant.disturb(effects.disturbance);
        }
    }

    /// Adds the people of events and the road users to the view and to what the ego can touch, where they are `ticks` after the view's tick. Switches the hazard
    /// lights of vehicles on that have broken down.
    pub(super) fn show_moved_by_events(&mut self, ticks: u64) {
        let view = self.observer.view_mut();
        self.script.switch_hazard_lights(&mut view.cars);
        let now = Tick(view.tick.0 + ticks);
        let map = self.drive.map();
        self.script.users.tick(ticks, view, map);
        let people = self.script.people.at(now, ticks, &map.route);
        people.chain(self.script.users.now()).for_each(|user| self.traffic.add(view, user));
    }

    /// Passes the button that was pressed to the question that is shown, else to the secondary task, and shows both.
    pub(super) fn ask_participant(&mut self, pressed: TaskButton) {
        let (tick, is_automated) = (self.observer.view().tick, self.observer.view().automation.mode.drives());
        let button = self.script.questions.tick(tick, pressed, is_automated, self.observer.events_mut());
        self.observer.view_mut().question = self.script.questions.shown();
        if let Some(task) = &mut self.task {
            let display = task.tick(tick, button, self.observer.events_mut());
            self.observer.view_mut().task = display;
        }
    }

    /// Moves all agents by one tick. Returns true if the participant's vehicle has begun a contact that ends the drive. A text says so after one
    /// with a person.
    pub(super) fn move_to_contact(&mut self) -> bool {
        let has_touched = self.move_agents();
        let touches_person = self.observer.events().iter().any(|event| event.kind.touches_person());
        if touches_person {
            self.observer.view_mut().message = Some(PERSON_TOUCHED.into());
        }
        touches_person || (has_touched && self.scenario().contact == OnContact::End)
    }

    /// Returns the names of the scenario's events with what they are at, in the order of the scenario.
    pub fn scripted_events(&self) -> impl ExactSizeIterator<Item = (&str, ScriptedState)> {
        self.script.states()
    }

    /// Begins an event by hand where the next step begins, if it still waits. The recording has it, and a replay begins it there, too.
    pub fn begin_event(&mut self, event: usize) {
        self.script.ask(event);
    }
}
