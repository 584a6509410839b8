//! Reading of an event device without a device: kernel events as values of evdev's own type.

use super::{super::profiles, *};

// Event types of linux/input-event-codes.h: EV_SYN, EV_KEY, EV_ABS.
const SYN: u16 = 0;
const KEY: u16 = 1;
const ABS: u16 = 3;
const HORN: u16 = 289;

fn g29() -> WheelProfile {
    profiles::named("g29").unwrap()
}

/// A movement of an axis, or a button and whether it is down.
#[derive(Clone, Debug, PartialEq)]
enum Heads {
    Axis(u16, i32),
    Button(u16, bool),
}

fn plain(messages: Vec<WheelMessage>) -> Vec<Heads> {
    let plain = |message| match message {
        WheelMessage::Axis { code, raw, .. } => Some(Heads::Axis(code, raw)),
        WheelMessage::Button { code, down, .. } => Some(Heads::Button(code, down)),
        _ => None,
    };
    messages.into_iter().filter_map(plain).collect()
}

/// Returns the messages of these events, and the number of requests for the device's state.
fn apply_event(heard: &mut WheelEvents, events: &[(u16, u16, i32)]) -> (Vec<Heads>, usize) {
    let mut messages = Vec::new();
    let apply_event = |(kind, code, value): &(u16, u16, i32)| {
        heard.apply_event(&InputEvent::new(*kind, *code, *value), None, &mut messages)
    };
    let asked = events.iter().map(apply_event).filter(|asked| *asked).count();
    (plain(messages), asked)
}

#[test]
fn axes_and_buttons_are_reported_and_key_repetitions_are_not() {
    let mut heard = WheelEvents::default();
    let events =
        [(ABS, 2, 100), (KEY, HORN, 1), (SYN, 0, 0), (KEY, HORN, 2), (SYN, 0, 1), (KEY, HORN, 0), (4, 4, 589_825)];
    let (messages, asked) = apply_event(&mut heard, &events);
    assert_eq!(messages, [Heads::Axis(2, 100), Heads::Button(HORN, true), Heads::Button(HORN, false)]);
    assert_eq!(asked, 0, "nothing was lost");
}

#[test]
fn after_an_overflow_the_packet_is_dropped_and_the_state_queried_once() {
    let mut heard = WheelEvents::default();
    let events = [(ABS, 2, 100), (SYN, 3, 0), (ABS, 2, 7), (KEY, HORN, 1), (SYN, 0, 0), (ABS, 2, 90), (SYN, 0, 0)];
    let (messages, asked) = apply_event(&mut heard, &events);
    assert_eq!((messages, asked), (vec![Heads::Axis(2, 100), Heads::Axis(2, 90)], 1));
}

#[test]
fn after_lost_events_the_state_and_missed_button_changes_are_reported() {
    let mut heard = WheelEvents::default();
    apply_event(&mut heard, &[(KEY, HORN, 1), (KEY, 292, 1), (KEY, 296, 1), (KEY, 296, 0)]);
    let mut messages = Vec::new();
    heard.catch_up(vec![(0, 40_000), (5, 30)], &[292, 297].into(), None, &mut messages);
    let buttons = [Heads::Button(HORN, false), Heads::Button(297, true)];
    assert_eq!(plain(messages), [vec![Heads::Axis(0, 40_000), Heads::Axis(5, 30)], buttons.into()].concat());
    let mut again = Vec::new();
    heard.catch_up(Vec::new(), &[292, 297].into(), None, &mut again);
    assert!(again.is_empty(), "it is known now");
}

#[test]
fn the_angle_follows_the_steering_axis_alone() {
    let mut heard = WheelEvents { profile: Some(g29()), ..WheelEvents::default() };
    apply_event(&mut heard, &[(ABS, 0, 0)]);
    // Full left of 900 degrees from end to end.
    assert_eq!(heard.angle.get(), 450.0_f64.to_radians());
    apply_event(&mut heard, &[(ABS, 2, 255), (ABS, 5, 255)]);
    assert_eq!(heard.angle.get(), 450.0_f64.to_radians());
    apply_event(&mut heard, &[(ABS, 0, 65_535)]);
    assert_eq!(heard.angle.get(), -450.0_f64.to_radians());
}

#[test]
fn a_device_is_gone_when_it_fails_with_no_events_left_to_read() {
    use PollFlags as F;
    assert!(gone(F::POLLHUP) && gone(F::POLLERR) && gone(F::POLLHUP | F::POLLERR));
    assert!(!gone(F::POLLIN) && !gone(F::POLLIN | F::POLLHUP | F::POLLERR) && !gone(F::empty()));
}

#[test]
fn events_of_either_clock_keep_their_age() {
    let now = TimeStamp(Duration::from_millis(50_000));
    let at = |ms| UNIX_EPOCH + Duration::from_millis(ms);
    assert_eq!(stamp(at(49_990), now, None), Some(TimeStamp(Duration::from_millis(49_990))));
    assert_eq!(stamp(at(1_700_000_000_000), now, None), None, "a time of the day on the monotonic clock");
    // By the clock of the day the event is 30 ms old, so it is 30 ms old on the monotonic clock too.
    let day = Some(Duration::from_millis(1_700_000_000_030));
    assert_eq!(stamp(at(1_700_000_000_000), now, day), Some(TimeStamp(Duration::from_millis(49_970))));
    assert_eq!(stamp(at(1_700_000_000_031), now, day), None, "later than now");
    // The modification time of a new file is the clock of the day.
    let written = tempfile::tempfile().unwrap().metadata().unwrap().modified().unwrap();
    let real = written.duration_since(UNIX_EPOCH).unwrap();
    assert!(now_real().abs_diff(real) < Duration::from_secs(60));
}
