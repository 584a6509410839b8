//! Scenes of OpenSCENARIO with events that repeat, durations, parameters and new places, with the values that the road gives by hand.

use super::{
    ParticipantChoice,
    conditions::VALUE_RULES,
    tests::{Scene, action, brakes, condition, event, events, group, imported, maneuver, of_ego, speed, time},
};
use serde_json::{Value, json};

/// Returns the events of a scene with this maneuver group, and what is left out.
fn scene(group: &str) -> (Value, Vec<String>) {
    let found = Scene { group, ..Scene::default() }.imported(&ParticipantChoice::None).expect("a scenario");
    (events(&found), found.unsupported.iter().map(|part| part.element.clone()).collect())
}

fn of_other(inner: &str) -> String {
    of_ego(inner).replace("\"Ego\"", "\"Other\"")
}

fn state(kind: &str, name: &str, state: &str) -> String {
    format!(
        "<ByValueCondition><StoryboardElementStateCondition storyboardElementType=\"{kind}\" storyboardElementRef=\"{name}\" state=\"{state}\"/>\
         </ByValueCondition>"
    )
}

#[test]
fn an_event_repeats_and_a_part_is_over_after_its_last_end() {
    let at_end = group(&condition(0.0, &of_other("<EndOfRoadCondition duration=\"2.5\"/>")));
    let to = "<TeleportAction><Position><LanePosition roadId=\"7\" laneId=\"1\" s=\"80\" offset=\"-0.5\"/></Position></TeleportAction>";
    let back = event("back", &action(to), &at_end).replace("priority=", "maximumExecutionCount=\"3\" priority=");
    let after =
        |name: &str, of: &str, word: &str| event(name, &brakes(), &group(&condition(1.0, &state("event", of, word))));
    let text = back + &after("one", "back", "endTransition") + &after("all", "back", "completeState");
    let (list, left_out) = scene(&maneuver(&text));
    assert_eq!(left_out, Vec::<String>::new());
    // The road is 500 m long.
    let reaches = json!({ "reaches": { "vehicle": "Other", "place_m": 499.5 } });
    let stands = json!({ "speed": { "vehicle": "Other", "below_mps": 0.05 } });
    assert_eq!(list[0]["trigger"], json!({ "all": [reaches, stands] }));
    assert_eq!(
        [&list[0]["holds_s"], &list[0]["repeats"], &list[0]["most_times"]],
        [&json!(2.5), &json!(true), &json!(3)]
    );
    // Lane 1 is the one to the left of the Ego's, and leads against it. The front is 7 m ahead of the reference point.
    let place = &list[0]["actions"][0]["teleport"];
    assert_eq!([&place["place_m"], &place["lanes_left"], &place["offset_m"]], [&json!(73.0), &json!(1), &json!(-0.5)]);
    assert_eq!(place["against"], json!(true));
    assert_eq!(list[1]["trigger"], json!({ "after": { "event": "back", "delay_s": 0.0 } }));
    assert_eq!(list[2]["trigger"], json!({ "after": { "event": "back", "delay_s": 0.0, "times": 3 } }));
    let of_group =
        maneuver(&event("e", &brakes(), &at_end).replace("priority=", "maximumExecutionCount=\"2\" priority="));
    let stop = format!("<StopTrigger>{}</StopTrigger>", group(&condition(0.0, &state("act", "act", "completeState"))));
    let found = Scene { group: &of_group, stop: &stop, ..Scene::default() }
        .imported(&ParticipantChoice::None)
        .expect("a scenario");
    assert_eq!(events(&found)[1]["trigger"], json!({ "after": { "event": "e", "delay_s": 0.0, "times": 2 } }));
}

#[test]
fn a_condition_off_the_road_lasts_and_counts_from_the_shoulder() {
    let off = of_other("<OffroadCondition duration=\"2\"/>");
    let (list, left_out) = scene(&maneuver(&event("e", &brakes(), &group(&condition(0.5, &off)))));
    assert_eq!(left_out, Vec::<String>::new());
    // The road has lanes for cars only.
    assert_eq!(list[0]["trigger"], json!({ "off_road": { "vehicle": "Other", "beyond_m": 0.0 } }));
    assert_eq!([&list[0]["holds_s"], &list[0]["delay_s"]], [&json!(2.0), &json!(0.5)]);
    // Together with another condition, a mark keeps the time.
    let both = condition(0.5, &off) + &condition(0.0, &time(3.0));
    let (list, _) = scene(&maneuver(&event("e", &brakes(), &group(&both))));
    assert_eq!(
        (&list[0]["name"], &list[0]["holds_s"], &list[0]["delay_s"]),
        (&json!("when"), &json!(2.0), &json!(0.5))
    );
    assert_eq!(
        list[1]["trigger"],
        json!({ "all": [{ "begun": { "event": "when", "delay_s": 0.0 } }, { "time_s": 3.0 }] })
    );
}

#[test]
fn accelerations_are_above_below_or_newly_equal() {
    let with = |value: &str, rule: &str| {
        let condition_of = format!("<AccelerationCondition value=\"{value}\" rule=\"{rule}\"/>");
        scene(&maneuver(&event("e", &brakes(), &group(&condition(0.0, &of_other(&condition_of)))))).0
    };
    let limit = |key: &str, value: f64| json!({ "acceleration": { "vehicle": "Other", key: value } });
    assert_eq!(with("-2", "lessThan")[0]["trigger"], limit("below_mps2", -2.0));
    assert_eq!(with("1", "greaterThan")[0]["trigger"], limit("above_mps2", 1.0));
    // An entity that keeps its speed has the acceleration 0 from the start: the condition waits for another one first.
    let equal = with("0", "equalTo");
    assert_eq!(equal[0]["trigger"], json!({ "any": [limit("below_mps2", -0.001), limit("above_mps2", 0.001)] }));
    let begun = json!({ "begun": { "event": "when", "delay_s": 0.0 } });
    assert_eq!(equal[1]["trigger"], json!({ "all": [begun, limit("above_mps2", -0.001), limit("below_mps2", 0.001)] }));
}

#[test]
fn conditions_on_parameters_wait_for_the_events_that_set_them() {
    let declared = "<ParameterDeclarations><ParameterDeclaration name=\"count\" parameterType=\"double\" value=\"2\"/></ParameterDeclarations>";
    let on = |rule: &str, value: &str| {
        format!(
            "<ByValueCondition><ParameterCondition parameterRef=\"count\" value=\"{value}\" rule=\"{rule}\"/></ByValueCondition>"
        )
    };
    let set = |name: &str, value: &str, at_s: f64| {
        let action = format!(
            "<Action name=\"set\"><GlobalAction><ParameterAction parameterRef=\"count\"><SetAction value=\"{value}\"/></ParameterAction></GlobalAction></Action>"
        );
        event(name, &action, &group(&condition(0.0, &time(at_s))))
    };
    let trigger = |rule: &str, value: &str| {
        let text = event("e", &brakes(), &group(&condition(0.0, &on(rule, value))))
            + &set("more", "11", 3.0)
            + &set("less", "1", 6.0);
        let text = Scene { group: &maneuver(&text), ..Scene::default() }
            .text()
            .replace("<CatalogLocations>", &format!("{declared}<CatalogLocations>"));
        let found = imported(&text, &ParticipantChoice::None).expect("a scenario");
        let list = events(&found);
        let own = list
            .as_array()
            .expect("a list")
            .iter()
            .find(|event| event["name"] == "e")
            .map(|event| event["trigger"].clone());
        (own, found.unsupported.len(), list)
    };
    let begun = |name: &str| Some(json!({ "begun": { "event": name, "delay_s": 0.0 } }));
    let (own, left_out, list) = trigger("greaterThan", "10");
    assert_eq!((own, left_out), (begun("more"), 0));
    // The event that sets it has no other action, and begins at its time.
    assert_eq!((&list[1]["trigger"], &list[1]["actions"]), (&json!({ "time_s": 3.0 }), &json!([])));
    assert_eq!(trigger("lessOrEqual", "1").0, begun("less"));
    assert_eq!(trigger("equalTo", "11.0").0, begun("more"));
    // An action at the start gives it another value.
    let init = "<GlobalAction><ParameterAction parameterRef=\"count\"><SetAction value=\"7\"/></ParameterAction></GlobalAction>";
    let at_once = condition(0.0, &on("equalTo", "7")).replace("\"rising\"", "\"none\"");
    let text = maneuver(&event("e", &brakes(), &group(&at_once)));
    let text = Scene { group: &text, init, ..Scene::default() }.text();
    let text = text.replace("<CatalogLocations>", &format!("{declared}<CatalogLocations>"));
    let found = imported(&text, &ParticipantChoice::None).expect("a scenario");
    assert_eq!(events(&found)[0]["trigger"], json!({ "time_s": 0.0 }));
    // It is 2 from the start on, which is no rise.
    let (own, left_out, _) = trigger("equalTo", "2");
    assert_eq!((own, left_out), (None, 2), "the condition and its event");
}

#[test]
fn values_compare_as_numbers_or_as_texts() {
    let is_met = |rule: &str, value: &str, other: &str| {
        let (_, rule) = VALUE_RULES.iter().find(|(word, _)| *word == rule).expect("a rule");
        rule.is_met(value, other)
    };
    assert!(is_met("lessThan", "2", "10") && !is_met("lessThan", "10", "10") && is_met("lessOrEqual", "10", "10.0"));
    assert!(
        is_met("greaterThan", "11", "10") && is_met("greaterOrEqual", "10", "1e1") && !is_met("greaterThan", "9", "10")
    );
    assert!(
        is_met("equalTo", "red", "red") && !is_met("equalTo", "red", "blue") && is_met("notEqualTo", "red", "blue")
    );
    assert!(!is_met("notEqualTo", "red", "red") && !is_met("lessThan", "blue", "red"), "texts have no order");
}

#[test]
fn a_change_to_the_own_lane_leads_to_its_middle() {
    let change = |lane: i32| {
        action(&format!(
            "<LateralAction><LaneChangeAction><LaneChangeActionDynamics dynamicsShape=\"cubic\" dynamicsDimension=\"time\" value=\"3\"/>\
             <LaneChangeTarget><AbsoluteTargetLane value=\"{lane}\"/></LaneChangeTarget></LaneChangeAction></LateralAction>"
        ))
    };
    let faster =
        speed("dynamicsShape=\"linear\" dynamicsDimension=\"time\" value=\"2\"", "<AbsoluteTargetSpeed value=\"20\"/>");
    let on_time = group(&condition(0.0, &time(4.0)));
    let (list, _) = scene(&maneuver(&(event("own", &change(-2), &on_time) + &event("faster", &faster, &on_time))));
    // It begins 0.5 m beside the middle of lane -2.
    let change = &list[0]["actions"][0]["change_lane"];
    assert_eq!((&change["of"], &change["to_the_left"], &change["in_s"]), (&json!("Other"), &json!(0), &json!(3.0)));
}
