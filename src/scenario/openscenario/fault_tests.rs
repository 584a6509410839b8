//! Parts of OpenSCENARIO files that codrive does not have, and faults: each is named with its file and line.

use super::{
    ParticipantChoice,
    tests::{CATALOG, Scene, action, brakes, condition, event, group, imported, maneuver, of_ego, starts, time},
};
use crate::scenario::Scenario;

#[test]
fn all_that_codrive_does_not_have_is_listed_with_its_line() {
    let on_time = group(&condition(0.0, &time(4.0)));
    let with_action = |inner: &str| maneuver(&event("e", &action(inner), &on_time));
    let with_condition = |inner: &str| maneuver(&event("e", &brakes(), &group(&condition(0.0, inner))));
    let of_group = [
        (with_action("<VisibilityAction graphics=\"false\"/>"), "VisibilityAction", "stays visible"),
        (
            with_action("<LongitudinalAction><SpeedProfileAction/></LongitudinalAction>"),
            "SpeedProfileAction",
            "keeps its speed",
        ),
        (
            with_action("<LongitudinalAction><LongitudinalDistanceAction/></LongitudinalAction>"),
            "LongitudinalDistanceAction",
            "keeps its speed",
        ),
        (
            with_action("<LateralAction><LateralDistanceAction/></LateralAction>"),
            "LateralDistanceAction",
            "keeps its lane",
        ),
        (
            with_action("<RoutingAction><AcquirePositionAction/></RoutingAction>"),
            "AcquirePositionAction",
            "along its lane",
        ),
        (with_action("<AppearanceAction/>"), "AppearanceAction", "lamps"),
        (
            with_action(
                "<TeleportAction><Position><RelativeLanePosition entityRef=\"Ego\" dLane=\"0\" ds=\"9\"/></Position></TeleportAction>",
            ),
            "TeleportAction",
            "beside entities at the start only",
        ),
        (
            with_action("<TeleportAction><Position><GeoPosition/></Position></TeleportAction>"),
            "GeoPosition",
            "does not know the place",
        ),
        (with_condition(&of_ego("<CollisionCondition/>")), "CollisionCondition", "never comes true"),
        (
            with_condition(&of_ego("<SpeedCondition value=\"1\" rule=\"equalTo\"/>")),
            "SpeedCondition rule",
            "above and below",
        ),
        (
            with_condition(&of_ego(
                "<RelativeDistanceCondition entityRef=\"Other\" value=\"1\" freespace=\"true\" relativeDistanceType=\"lateral\" rule=\"lessThan\"/>",
            )),
            "RelativeDistanceCondition relativeDistanceType",
            "along the road",
        ),
        (
            with_condition(
                "<ByValueCondition><SimulationTimeCondition value=\"1\" rule=\"lessThan\"/></ByValueCondition>",
            ),
            "SimulationTimeCondition rule",
            "above a time only",
        ),
        (
            with_condition(&time(4.0)).replace("\"rising\"", "\"falling\""),
            "Condition conditionEdge",
            "rising conditions only",
        ),
        (
            with_condition(&time(4.0)).replace("priority=\"override\"", "priority=\"skip\""),
            "Event priority",
            "beside others",
        ),
        (
            with_condition(&time(4.0)).replace("priority=", "colour=\"red\" priority="),
            "Event colour",
            "the attribute has no effect",
        ),
        (
            maneuver(&event(
                "e",
                "<Action name=\"does\"><GlobalAction>\n<EnvironmentAction/></GlobalAction></Action>",
                &on_time,
            )),
            "EnvironmentAction",
            "weather and daylight",
        ),
        (
            maneuver(&event(
                "e",
                "<Action name=\"does\"><ParameterDeclarations><ParameterDeclaration name=\"a\" value=\"1\"/></ParameterDeclarations><GlobalAction>\
                 <ParameterAction parameterRef=\"a\">\n<ModifyAction/></ParameterAction></GlobalAction></Action>",
                &on_time,
            )),
            "ModifyAction",
            "it stays as it is",
        ),
    ];
    for (text, element, meaning) in &of_group {
        assert_listed(&Scene { group: text, ..Scene::default() }, element, meaning);
    }
    let train =
        "<ScenarioObject name=\"T\">\n<CatalogReference catalogName=\"cars\" entryName=\"train\"/></ScenarioObject>";
    assert_listed(
        &Scene { entities: train, ..Scene::default() },
        "Vehicle",
        "T is of a kind that codrive does not have",
    );
    let thing = "<ScenarioObject name=\"T\">\n<MiscObject/></ScenarioObject>";
    assert_listed(&Scene { entities: thing, ..Scene::default() }, "MiscObject", "the object is not there");
    let stop = "<StopTrigger><ConditionGroup>\n<Else/></ConditionGroup></StopTrigger>";
    assert_listed(&Scene { stop, ..Scene::default() }, "Else", "it has no effect");
    let act = format!("<StopTrigger>\n{on_time}</StopTrigger>");
    assert_listed(&Scene { act: &act, ..Scene::default() }, "StopTrigger", "the act goes on");
    let init = "<GlobalAction>\n<InfrastructureAction><TrafficSignalAction><TrafficSignalStateAction name=\"light\" state=\"blinking\"/></TrafficSignalAction></InfrastructureAction></GlobalAction>";
    assert_listed(&Scene { init, ..Scene::default() }, "TrafficSignalStateAction state", "no light \"blinking\"");
}

/// Checks that an element is listed with the line at which the text has it, or that of its catalog.
fn assert_listed(scene: &Scene, element: &str, meaning: &str) {
    let text = scene.text();
    let found = imported(&text, &ParticipantChoice::Ego).unwrap_or_else(|fault| panic!("{element}: {fault}"));
    let part = found.unsupported.iter().find(|part| part.element == element);
    let part = part.unwrap_or_else(|| panic!("{element} is not among {:?}", found.unsupported));
    let tag = format!("<{}", element.split(' ').next().unwrap_or_default());
    let is_in_catalog = part.file.ends_with("cars.xosc");
    let line = if is_in_catalog { CATALOG } else { &text }.lines().nth(part.line as usize - 1).unwrap_or_default();
    assert!(line.contains(&tag), "{element}: line {} is {line}", part.line);
    assert!(part.meaning.contains(meaning), "{element}: {}", part.meaning);
    // The rest is a scenario, and its head has the list.
    let written = found.to_toml("a.xosc");
    assert!(written.lines().any(|line| line.starts_with('#') && line.contains(&format!("<{element}>"))), "{written}");
    Scenario::from_toml(&written, "a.toml").unwrap_or_else(|fault| panic!("{element}: {fault}\n{written}"));
}

#[test]
fn faults_name_file_line_value_and_what_is_allowed() {
    let on_time = group(&condition(0.0, &time(4.0)));
    let plain = Scene { group: &maneuver(&event("e", &brakes(), &on_time)), ..Scene::default() }.text();
    let cases = [
        (
            "entityRef=\"Other\"/></Actors>",
            "entityRef=\"Othr\"/></Actors>",
            "a.xosc:15: no entity is named \"Othr\" (did you mean Other?); allowed: Ego, Other",
        ),
        ("s=\"100\"", "s=\"far\"", "a.xosc:10: <LanePosition>: s is \"far\"; allowed: a number"),
        ("s=\"100\"", "s=\"600\"", "a.xosc:10: s is 600 on road 7; allowed: 0 to 500.00 m"),
        (
            "laneId=\"-1\" s=\"100\"",
            "laneId=\"-4\" s=\"100\"",
            "a.xosc:10: road 7 has no lane -4 at 100 m; it has 1, -1, -2",
        ),
        (
            "roadId=\"7\" laneId=\"-1\" s=\"100\"",
            "roadId=\"8\" laneId=\"-1\" s=\"100\"",
            "a.xosc:10: the road file has no road \"8\"",
        ),
        ("laneId=\"-1\" s=\"100\"", "s=\"100\"", "a.xosc:10: <LanePosition>: the attribute laneId is missing"),
        ("value=\"-3\"", "value=\"$rate\"", "a.xosc:16: <SpeedActionDynamics>: value: no parameter $rate is declared"),
        (
            "dynamicsShape=\"linear\"",
            "dynamicsShape=\"linar\"",
            "a.xosc:16: <SpeedActionDynamics>: dynamicsShape is \"linar\" (did you mean linear?); allowed: linear,",
        ),
        (
            "<AbsoluteTargetSpeed value=\"5\"/>",
            "<AbsoluteTargetSpeed value=\"-5\"/>",
            "value is -5; allowed: 0 m/s or more",
        ),
        (
            "<AbsoluteTargetSpeed value=\"5\"/>",
            "<RelativeTargetSpeed entityRef=\"X\" value=\"1\" speedTargetValueType=\"delta\"/>",
            "a.xosc:15: no entity is named \"X\"",
        ),
        (
            "entryName=\"small\"",
            "entryName=\"smal\"",
            "a.xosc:6: <CatalogReference>: catalog \"cars\" has no entry \"smal\" (did you mean small?)",
        ),
        (
            "catalogName=\"cars\" entryName=\"small\"",
            "catalogName=\"vans\" entryName=\"small\"",
            "a.xosc:6: <CatalogReference>: no catalog \"vans\"",
        ),
        ("path=\"catalogs\"", "path=\"none\"", "the folder of catalogs none cannot be read"),
        ("filepath=\"road.xodr\"", "filepath=\"raod.xodr\"", "a.xosc:4: <LogicFile>: raod.xodr"),
        ("name=\"Other\"><Cat", "name=\"Ego\"><Cat", "a.xosc:7: <ScenarioObject>: another entity is named \"Ego\""),
        ("delay=\"0\"", "delay=\"-1\"", "delay is -1; allowed: 0 s or more"),
        (
            "priority=\"override\"",
            "maximumExecutionCount=\"0\" priority=\"override\"",
            "a.xosc:15: <Event>: maximumExecutionCount is 0; allowed: a whole number from 1 on",
        ),
        (
            "<SimulationTimeCondition value=\"4\" rule=\"greaterThan\"/>",
            "<ParameterCondition parameterRef=\"a\" value=\"4\" rule=\"greaterThan\"/>",
            "<ParameterCondition>: no parameter $a is declared",
        ),
    ];
    for (from, to, wanted) in cases {
        assert!(plain.contains(from), "{from}");
        let fault = imported(&plain.replacen(from, to, 1), &ParticipantChoice::Ego).expect_err(to);
        assert!(fault.contains(wanted), "{fault}\n{wanted}");
    }
}

#[test]
fn places_and_catalogs_that_refer_to_each_other_are_faults() {
    let by = |entity: &str, other: &str| {
        starts(entity, &format!("<RelativeLanePosition entityRef=\"{other}\" dLane=\"0\" ds=\"9\"/>"), 1.0)
    };
    let entities: String = ["A", "B"]
        .map(|name| format!("<ScenarioObject name=\"{name}\"><CatalogReference catalogName=\"cars\" entryName=\"small\"/></ScenarioObject>"))
        .concat();
    let init = by("A", "B") + &by("B", "A");
    let fault =
        Scene { entities: &entities, init: &init, ..Scene::default() }.imported(&ParticipantChoice::Ego).unwrap_err();
    assert!(fault.contains("the place depends on \"B\"") && fault.contains("remedy"), "{fault}");
    let route = "<Private entityRef=\"Ego\"><PrivateAction><RoutingAction><AssignRouteAction><CatalogReference catalogName=\"cars\" entryName=\"a\"/>\
        </AssignRouteAction></RoutingAction></PrivateAction></Private>";
    let fault = Scene { init: route, ..Scene::default() }.imported(&ParticipantChoice::Ego).unwrap_err();
    assert!(fault.contains("entries of catalogs refer to each other") && fault.contains("break the circle"), "{fault}");
}
