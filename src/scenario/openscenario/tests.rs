//! Scenes of OpenSCENARIO on a straight road, with the values that its lanes and the bodies give by hand.

use super::{ImportedScenario, OpenScenario, ParticipantChoice};
use crate::scenario::Scenario;
use serde_json::{Value, json};
use std::path::Path;

/// Road of 500 m along x with the lanes 1, -1 and -2, all 3.5 m wide.
fn road() -> String {
    let lane = |id: i32| {
        format!("<lane id=\"{id}\" type=\"driving\"><width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/></lane>")
    };
    format!(
        "<OpenDRIVE><road id=\"7\" length=\"500\"><planView><geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"500\"><line/></geometry>\
         </planView><lanes><laneSection s=\"0\"><left>{}</left><right>{}{}</right></laneSection></lanes><signals>\
         <signal id=\"light\" s=\"200\" t=\"-8\" type=\"1000001\" orientation=\"+\"/></signals></road></OpenDRIVE>",
        lane(1),
        lane(-1),
        lane(-2)
    )
}

/// Network of that road, moved by (10, 20).
const NET: &str = "<net><location netOffset=\"10,20\"/>\
    <edge id=\"-7\"><lane id=\"-7_0\" index=\"0\" speed=\"14\" width=\"3.5\" length=\"500\" shape=\"10,14.75 510,14.75\"/>\
    <lane id=\"-7_1\" index=\"1\" speed=\"14\" width=\"3.5\" length=\"500\" shape=\"10,18.25 510,18.25\"/></edge>\
    <edge id=\"7\"><lane id=\"7_0\" index=\"0\" speed=\"14\" width=\"3.5\" length=\"500\" shape=\"510,21.75 10,21.75\"/></edge></net>";

/// Vehicles of a catalog: 4 m long with the reference point 1 m before the rear, and 10 m long with it 3 m before the rear.
pub(super) const CATALOG: &str = "<OpenSCENARIO><Catalog name=\"cars\">\
    <Vehicle name=\"small\" vehicleCategory=\"car\"><ParameterDeclarations><ParameterDeclaration name=\"length\" parameterType=\"double\" value=\"4\"/>\
    </ParameterDeclarations><BoundingBox><Center x=\"1\" y=\"0\" z=\"0\"/><Dimensions length=\"$length\" width=\"1.8\" height=\"1.5\"/></BoundingBox></Vehicle>\
    <Vehicle name=\"long\" vehicleCategory=\"truck\"><BoundingBox><Center x=\"2\" y=\"0\" z=\"0\"/><Dimensions length=\"10\" width=\"2.5\" height=\"3.5\"/>\
    </BoundingBox></Vehicle>\
    <Vehicle name=\"train\" vehicleCategory=\"train\"/>\
    <Route name=\"a\"><Waypoint routeStrategy=\"shortest\"><Position><RoutePosition><RouteRef><CatalogReference catalogName=\"cars\" entryName=\"a\"/>\
    </RouteRef><InRoutePosition><FromLaneCoordinates pathS=\"0\" laneId=\"-1\"/></InRoutePosition></RoutePosition></Position></Waypoint></Route>\
    <Maneuver name=\"slow\"><ParameterDeclarations><ParameterDeclaration name=\"to\" parameterType=\"double\" value=\"1\"/></ParameterDeclarations>\
    <Event name=\"slows\" priority=\"override\"><Action name=\"brakes\"><PrivateAction><LongitudinalAction><SpeedAction>\
    <SpeedActionDynamics dynamicsShape=\"linear\" dynamicsDimension=\"rate\" value=\"2\"/><SpeedActionTarget><AbsoluteTargetSpeed value=\"${$to + 1}\"/>\
    </SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction></Action></Event></Maneuver></Catalog></OpenSCENARIO>";

/// Parts of a scene that differ between tests.
#[derive(Default)]
pub(super) struct Scene<'t> {
    pub entities: &'t str,
    pub init: &'t str,
    /// Children of a maneuver group of the entity Other.
    pub group: &'t str,
    /// Triggers of the act.
    pub act: &'t str,
    pub stop: &'t str,
}

/// Returns the speed of an entity at the start, as its actions.
pub(super) fn starts(entity: &str, position: &str, speed_mps: f64) -> String {
    format!(
        "<Private entityRef=\"{entity}\"><PrivateAction><TeleportAction><Position>{position}</Position></TeleportAction></PrivateAction>\
         <PrivateAction><LongitudinalAction><SpeedAction><SpeedActionDynamics dynamicsShape=\"step\" dynamicsDimension=\"time\" value=\"0\"/>\
         <SpeedActionTarget><AbsoluteTargetSpeed value=\"{speed_mps}\"/></SpeedActionTarget></SpeedAction></LongitudinalAction>\
         </PrivateAction></Private>\n"
    )
}

impl Scene<'_> {
    pub fn text(&self) -> String {
        let ego = starts("Ego", "<LanePosition roadId=\"7\" laneId=\"-1\" s=\"100\"/>", 20.0);
        let other = starts("Other", "<LanePosition roadId=\"7\" laneId=\"-2\" s=\"150\" offset=\"0.5\"/>", 15.0);
        format!(
            "<OpenSCENARIO>\n<FileHeader revMajor=\"1\" revMinor=\"2\"/>\n<CatalogLocations><VehicleCatalog><Directory path=\"catalogs\"/>\
             </VehicleCatalog></CatalogLocations>\n<RoadNetwork><LogicFile filepath=\"road.xodr\"/></RoadNetwork>\n<Entities>\n\
             <ScenarioObject name=\"Ego\"><CatalogReference catalogName=\"cars\" entryName=\"small\"/></ScenarioObject>\n\
             <ScenarioObject name=\"Other\"><CatalogReference catalogName=\"cars\" entryName=\"long\"/></ScenarioObject>\n{}</Entities>\n\
             <Storyboard><Init><Actions>\n{ego}{other}{}</Actions></Init>\n<Story name=\"story\"><Act name=\"act\">\n\
             <ManeuverGroup name=\"group\" maximumExecutionCount=\"1\"><Actors selectTriggeringEntities=\"false\"><EntityRef entityRef=\"Other\"/></Actors>\n\
             {}</ManeuverGroup>\n{}</Act></Story>\n{}</Storyboard></OpenSCENARIO>",
            self.entities, self.init, self.group, self.act, self.stop
        )
    }

    pub fn imported(&self, choice: &ParticipantChoice) -> Result<ImportedScenario, String> {
        imported(&self.text(), choice)
    }
}

pub fn imported(text: &str, choice: &ParticipantChoice) -> Result<ImportedScenario, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    std::fs::create_dir(folder.path().join("catalogs")).expect("a folder");
    write("catalogs/cars.xosc", CATALOG);
    write("road.xodr", &road());
    write("net.xml", NET);
    write("a.xosc", text);
    let here = format!("{}/", folder.path().display());
    let found = OpenScenario::read(&folder.path().join("a.xosc"))
        .and_then(|scenario| scenario.on(&folder.path().join("net.xml").to_string_lossy(), choice));
    found.map_err(|error| error.to_string().replace(&here, ""))
}

pub fn event(name: &str, actions: &str, trigger: &str) -> String {
    format!("<Event name=\"{name}\" priority=\"override\">{actions}<StartTrigger>{trigger}</StartTrigger></Event>\n")
}

pub fn action(inner: &str) -> String {
    format!("<Action name=\"does\"><PrivateAction>\n{inner}</PrivateAction></Action>")
}

pub fn speed(dynamics: &str, target: &str) -> String {
    action(&format!(
        "<LongitudinalAction><SpeedAction><SpeedActionDynamics {dynamics}/><SpeedActionTarget>{target}</SpeedActionTarget></SpeedAction>\
         </LongitudinalAction>"
    ))
}

pub fn brakes() -> String {
    speed("dynamicsShape=\"linear\" dynamicsDimension=\"rate\" value=\"-3\"", "<AbsoluteTargetSpeed value=\"5\"/>")
}

pub fn condition(delay_s: f64, inner: &str) -> String {
    format!("<Condition name=\"when\" delay=\"{delay_s}\" conditionEdge=\"rising\">\n{inner}</Condition>")
}

pub fn group(conditions: &str) -> String {
    format!("<ConditionGroup>{conditions}</ConditionGroup>")
}

pub fn time(time_s: f64) -> String {
    format!("<ByValueCondition><SimulationTimeCondition value=\"{time_s}\" rule=\"greaterThan\"/></ByValueCondition>")
}

pub fn of_ego(inner: &str) -> String {
    format!(
        "<ByEntityCondition><TriggeringEntities triggeringEntitiesRule=\"any\"><EntityRef entityRef=\"Ego\"/></TriggeringEntities>\
         <EntityCondition>{inner}</EntityCondition></ByEntityCondition>"
    )
}

pub fn maneuver(events: &str) -> String {
    format!("<Maneuver name=\"maneuver\">{events}</Maneuver>")
}

pub fn events(found: &ImportedScenario) -> Value {
    serde_json::to_value(&found.scenario.events).expect("values")
}

#[test]
fn entities_stand_where_their_lanes_and_bodies_put_them() {
    let entities = "<ScenarioObject name=\"Oncoming\"><CatalogReference catalogName=\"cars\" entryName=\"small\"><ParameterAssignments>\
        <ParameterAssignment parameterRef=\"$length\" value=\"6\"/></ParameterAssignments></CatalogReference></ScenarioObject>\n";
    let init = starts("Oncoming", "<RelativeLanePosition entityRef=\"Ego\" dLane=\"1\" ds=\"300\"/>", 12.0);
    let scene = Scene { entities, init: &init, ..Scene::default() };
    let found = scene.imported(&ParticipantChoice::Ego).expect("a scenario");
    assert!(found.unsupported.is_empty(), "{:?}", found.unsupported);
    let scenario = &found.scenario;
    // The ego's front is 1 + 4 / 2 = 3 m before its reference point, which is 100 m along lane -1, the inner one.
    assert_eq!((scenario.path.as_str(), scenario.participant), ("-7_1", true));
    assert_eq!((scenario.path_start_m, scenario.start_speed_mps), (103.0, 20.0));
    let users: Vec<_> = scenario
        .road_users
        .iter()
        .map(|user| (user.name.as_str(), user.place_m, user.lanes_left, user.offset_m, user.against, user.speed_mps))
        .collect();
    // The truck's front is 2 + 10 / 2 = 7 m before its reference point, the oncoming car's 1 + 6 / 2 = 4 m, towards the ego.
    assert_eq!(users, [("Other", 157.0, -1, 0.5, false, 15.0), ("Oncoming", 396.0, 1, 0.0, true, 12.0)]);
    assert_eq!(scenario.road_users[1].length_m, Some(6.0));
    assert_eq!(scenario.road_users[0].rear_axle_m, Some(7.0));
}

#[test]
fn without_a_participant_all_entities_are_road_users() {
    let found = Scene::default().imported(&ParticipantChoice::None).expect("a scenario");
    assert!(!found.scenario.participant && found.scenario.path == "-7_1");
    let names: Vec<&str> = found.scenario.road_users.iter().map(|user| user.name.as_str()).collect();
    assert_eq!(names, ["Ego", "Other"]);
    let named = Scene::default().imported(&ParticipantChoice::Named("Other".into())).expect("a scenario");
    assert_eq!((named.scenario.path.as_str(), named.scenario.path_start_m), ("-7_0", 157.0));
    let unknown = Scene::default().imported(&ParticipantChoice::Named("Othr".into())).unwrap_err();
    assert!(
        unknown.contains("--participant is \"Othr\" (did you mean Other?); allowed: none, Ego, Other"),
        "{unknown}"
    );
}

#[test]
fn distances_count_between_the_points_that_the_file_means() {
    let ahead = |freespace: bool| {
        of_ego(&format!(
            "<TimeHeadwayCondition entityRef=\"Other\" value=\"2\" freespace=\"{freespace}\" rule=\"lessThan\"/>"
        ))
    };
    let both = group(&condition(0.0, &ahead(false))) + &group(&condition(0.0, &ahead(true)));
    let text = maneuver(&event("e", &brakes(), &both));
    let found = Scene { group: &text, ..Scene::default() }.imported(&ParticipantChoice::Ego).expect("a scenario");
    // From the ego's reference point to its front 3 m, and from the truck's to its rear 10 / 2 - 2 = 3 m.
    let trigger = json!({ "any": [{ "time_gap": { "to": "Other", "below_s": 2.0, "plus_m": 6.0 } }, { "time_gap": { "to": "Other", "below_s": 2.0 } }] });
    assert_eq!(events(&found)[0]["trigger"], trigger);
    let speed = &events(&found)[0]["actions"][0]["speed"];
    assert_eq!((&speed["rate_mps2"], &speed["to_mps"], &speed["vehicle"]), (&json!(3.0), &json!(5.0), &json!("Other")));
}

#[test]
fn a_relative_distance_counts_whichever_vehicle_is_ahead() {
    let inner = of_ego(
        "<RelativeDistanceCondition entityRef=\"Other\" value=\"9\" freespace=\"false\" relativeDistanceType=\"longitudinal\" rule=\"lessThan\"/>",
    );
    let text = maneuver(&event("e", &brakes(), &group(&condition(0.0, &inner))));
    let found = Scene { group: &text, ..Scene::default() }.imported(&ParticipantChoice::None).expect("a scenario");
    // From the truck's reference point to its front 7 m, and from the car's to its rear 4 / 2 - 1 = 1 m.
    let [there, back] = [("Ego", "Other", 6.0), ("Other", "Ego", 8.0)]
        .map(|(of, to, plus_m)| json!({ "distance": { "of": of, "to": to, "below_m": 9.0, "plus_m": plus_m } }));
    assert_eq!(events(&found)[0]["trigger"], json!({ "any": [there, back] }));
}

#[test]
fn places_are_reached_by_the_front_that_belongs_to_the_reference_point() {
    let at = "<Position><LanePosition roadId=\"7\" laneId=\"-1\" s=\"200\"/></Position>";
    let reach = of_ego(&format!("<ReachPositionCondition tolerance=\"2\">{at}</ReachPositionCondition>"));
    let near = of_ego(&format!(
        "<DistanceCondition value=\"50\" freespace=\"true\" rule=\"lessThan\">{at}</DistanceCondition>"
    ));
    let trigger = group(&(condition(0.0, &reach) + &condition(0.0, &near)));
    let text = maneuver(&event("e", &brakes(), &trigger));
    let found = Scene { group: &text, ..Scene::default() }.imported(&ParticipantChoice::Ego).expect("a scenario");
    // 200 - 2 + 3 m, and 200 - 50 m from the front.
    let places = [201.0, 150.0].map(|place_m| json!({ "reaches": { "vehicle": "ego", "place_m": place_m } }));
    assert_eq!(events(&found)[0]["trigger"], json!({ "all": places }));
}

#[test]
fn delays_acts_and_states_become_marks_and_begins() {
    let state = |part: &str, name: &str, state: &str| {
        format!(
            "<ByValueCondition><StoryboardElementStateCondition storyboardElementType=\"{part}\" storyboardElementRef=\"{name}\" state=\"{state}\"/></ByValueCondition>"
        )
    };
    let slow = of_ego("<SpeedCondition value=\"9\" rule=\"lessThan\"/>");
    let text = maneuver(
        &(event("first", &brakes(), &group(&condition(1.5, &time(4.0))))
            + &event(
                "second",
                &brakes(),
                &group(&(condition(2.0, &state("event", "first", "endTransition")) + &condition(0.0, &slow))),
            )
            + &event("third", &brakes(), &group(&condition(0.0, &state("maneuver", "maneuver", "completeState"))))),
    );
    let act = format!(
        "<StartTrigger>{}</StartTrigger>",
        group(&condition(0.0, &of_ego("<TraveledDistanceCondition value=\"30\"/>")))
    );
    let stop = format!(
        "<StopTrigger>{}{}</StopTrigger>",
        group(&condition(1.0, &time(60.0))),
        group(&condition(0.0, &state("act", "act", "startTransition")))
    );
    let waits_for_itself =
        Scene { group: &text, act: &act, stop: &stop, ..Scene::default() }.imported(&ParticipantChoice::Ego);
    assert!(waits_for_itself.unwrap_err().contains("waits for"), "the third event waits for the end of its maneuver");
    let text =
        text.replace("\"maneuver\" storyboardElementRef=\"maneuver\"", "\"event\" storyboardElementRef=\"a::first\"");
    let found = Scene { group: &text, act: &act, stop: &stop, ..Scene::default() }
        .imported(&ParticipantChoice::Ego)
        .expect("a scenario");
    let begun = |event: &str| json!({ "begun": { "event": event, "delay_s": 0.0 } });
    let after = |event: &str| json!({ "after": { "event": event, "delay_s": 0.0 } });
    let list = events(&found);
    let named =
        |name: &str| list.as_array().expect("a list").iter().find(|event| event["name"] == name).expect(name).clone();
    assert_eq!(named("act")["trigger"], json!({ "driven": { "vehicle": "ego", "above_m": 30.0 } }));
    assert_eq!(named("first")["trigger"], json!({ "all": [begun("act"), { "time_s": 4.0 }] }));
    assert_eq!(named("first")["delay_s"], 1.5);
    assert_eq!((&named("when")["trigger"], &named("when")["delay_s"]), (&after("first"), &json!(2.0)));
    let slow = json!({ "speed": { "vehicle": "ego", "below_mps": 9.0 } });
    assert_eq!(named("second")["trigger"], json!({ "all": [begun("act"), begun("when"), slow] }));
    let end = named("the scene ends");
    assert_eq!((&end["trigger"], &end["actions"]), (&begun("act"), &json!(["end_drive"])));
    assert_eq!(found.scenario.duration_s, 61.0);
}

#[test]
fn a_light_that_is_on_from_the_start_does_not_come_on() {
    let light = |state: &str| {
        let signal = format!("<TrafficSignalStateAction name=\"light\" state=\"{state}\"/>");
        format!(
            "<GlobalAction><InfrastructureAction><TrafficSignalAction>{signal}</TrafficSignalAction></InfrastructureAction></GlobalAction>"
        )
    };
    let green = "off;off;on";
    let is_green =
        format!("<ByValueCondition><TrafficSignalCondition name=\"light\" state=\"{green}\"/></ByValueCondition>");
    let again = format!("<Action name=\"does\">{}</Action>", light(green));
    let waits = event("waits", &brakes(), &group(&condition(0.5, &is_green)));
    let text = maneuver(&(event("again", &again, &group(&condition(0.0, &time(9.0)))) + &waits));
    // The light is not on the path; an action that is carried out keeps the event at the start.
    let private = brakes().replace("<Action name=\"does\">", "").replace("</Action>", "");
    let init = format!("{}<Private entityRef=\"Other\">{private}</Private>", light(green));
    let trigger = |text: &str| {
        let scene = Scene { group: text, init: &init, ..Scene::default() };
        let found = scene.imported(&ParticipantChoice::Ego).expect("a scenario");
        let list = events(&found);
        list.as_array().expect("a list").iter().find(|event| event["name"] == "waits").expect("it waits")["trigger"]
            .clone()
    };
    let begun = |event: &str| json!({ "begun": { "event": event, "delay_s": 0.0 } });
    assert_eq!(trigger(&text), begun("again"));
    let level = text.replace(&waits, &waits.replace("rising", "none"));
    assert_eq!(trigger(&level), json!({ "any": [begun("at the start"), begun("again")] }));
}

#[test]
fn a_relative_speed_is_that_of_the_triggering_entity_less_the_other() {
    let inner = of_ego("<RelativeSpeedCondition entityRef=\"Other\" value=\"-2\" rule=\"lessThan\"/>");
    let text = maneuver(&event("e", &brakes(), &group(&condition(0.0, &inner))));
    let found = Scene { group: &text, ..Scene::default() }.imported(&ParticipantChoice::Ego).expect("a scenario");
    let trigger = json!({ "speed": { "vehicle": "ego", "than": "Other", "below_mps": -2.0 } });
    assert_eq!(events(&found)[0]["trigger"], trigger);
}

#[test]
fn rates_and_accelerations_become_durations() {
    let change = |target: &str, dynamics: &str| {
        action(&format!(
            "<LateralAction><LaneChangeAction><LaneChangeActionDynamics {dynamics}/><LaneChangeTarget>{target}</LaneChangeTarget></LaneChangeAction></LateralAction>"
        ))
    };
    let to_left = change(
        "<RelativeTargetLane entityRef=\"Other\" value=\"1\"/>",
        "dynamicsShape=\"sinusoidal\" dynamicsDimension=\"rate\" value=\"2\"",
    );
    let to_lane = change(
        "<AbsoluteTargetLane value=\"1\"/>",
        "dynamicsShape=\"cubic\" dynamicsDimension=\"distance\" value=\"40\"",
    );
    let offset = action(
        "<LateralAction><LaneOffsetAction continuous=\"false\"><LaneOffsetActionDynamics dynamicsShape=\"cubic\" maxLateralAcc=\"1.5\"/><LaneOffsetTarget><AbsoluteTargetLaneOffset value=\"1\"/></LaneOffsetTarget></LaneOffsetAction></LateralAction>",
    );
    let at = |time_s: f64| group(&condition(0.0, &time(time_s)));
    let text =
        maneuver(&(event("a", &to_left, &at(1.0)) + &event("b", &to_lane, &at(9.0)) + &event("c", &offset, &at(18.0))));
    let found = Scene { group: &text, ..Scene::default() }.imported(&ParticipantChoice::Ego).expect("a scenario");
    let list = events(&found);
    // Half a cosine over 3.5 m is steepest with pi / 2 · 3.5 / T.
    let first = &list[0]["actions"][0]["change_lane"];
    assert_eq!((&first["to_the_left"], &first["in_s"], &first["of"]), (&json!(1), &json!(2.7489), &Value::Null));
    // It is on lane -1 by then; lane 1 is next to it.
    let second = &list[1]["actions"][0]["change_lane"];
    assert_eq!((&second["to_the_left"], &second["in_m"]), (&json!(1), &json!(40.0)));
    // A cubic over 1 m has the acceleration 6 / T² = 1.5 m/s2.
    let third = &list[2]["actions"][0]["offset"];
    assert_eq!((&third["to_m"], &third["in_s"]), (&json!(1.0), &json!(2.0)));
}

#[test]
fn maneuvers_of_catalogs_have_the_values_that_are_given() {
    let text = "<CatalogReference catalogName=\"cars\" entryName=\"slow\"><ParameterAssignments><ParameterAssignment parameterRef=\"to\" value=\"6\"/>\
        </ParameterAssignments></CatalogReference>\n";
    let found = Scene { group: text, ..Scene::default() }.imported(&ParticipantChoice::Ego).expect("a scenario");
    assert_eq!(
        (&events(&found)[0]["trigger"], &events(&found)[0]["actions"][0]["speed"]["to_mps"]),
        (&json!({ "time_s": 0.0 }), &json!(7.0))
    );
}

#[test]
fn what_the_ego_does_is_up_to_the_participant() {
    let text = maneuver(&event("e", &brakes(), &group(&condition(0.0, &time(4.0)))));
    let text = Scene { group: &text, ..Scene::default() }
        .text()
        .replace("<EntityRef entityRef=\"Other\"/></Actors>", "<EntityRef entityRef=\"Ego\"/></Actors>");
    let found = imported(&text, &ParticipantChoice::Ego).expect("a scenario");
    assert!(found.scenario.events.is_empty() && found.unsupported.is_empty());
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("a.xosc:15: an action of Ego has no effect: the participant drives it")),
        "{:?}",
        found.notes
    );
}

#[test]
fn an_event_with_conditions_that_never_come_true_is_left_out() {
    let never = of_ego("<CollisionCondition/>");
    let one = group(&(condition(0.0, &never) + &condition(0.0, &time(3.0))));
    let text = maneuver(
        &(event("never", &brakes(), &one)
            + &event("late", &brakes(), &(one.clone() + &group(&condition(0.0, &time(5.0)))))),
    );
    let found = Scene { group: &text, ..Scene::default() }.imported(&ParticipantChoice::Ego).expect("a scenario");
    assert_eq!(events(&found).as_array().map(Vec::len), Some(1));
    assert_eq!(events(&found)[0]["trigger"], json!({ "time_s": 5.0 }));
    assert!(found.unsupported.iter().any(|part| part.element == "Event never" && part.meaning == "it never begins"));
}

#[test]
fn a_written_scenario_reads_back_as_it_is() {
    let text = maneuver(&event("e", &brakes(), &group(&condition(0.5, &time(4.0)))));
    let found = Scene { group: &text, ..Scene::default() }.imported(&ParticipantChoice::Ego).expect("a scenario");
    let written = found.to_toml("a.xosc");
    let read = Scenario::from_toml(&written, "a.toml").unwrap_or_else(|fault| panic!("{fault}\n{written}"));
    assert_eq!(read, found.scenario);
    assert!(written.starts_with("# Imported from a.xosc") && !Path::new(&written).is_absolute());
}
