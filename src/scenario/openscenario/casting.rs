//! Road users that stand for the entities of an OpenSCENARIO file. In: the entities, their places on the path and their speeds at the start. Out: a
//! [`Cast`]: the list `[[road_user]]`, and the names by which events call the entities.

use super::{
    OpenScenario, ParticipantChoice,
    actions::{Deed, Extent, SpeedTarget},
    document::Place,
    entities::Entity,
    fault::{OpenScenarioError, Problems, Unsupported},
    scene::{PathPlace, Scene},
};
use crate::{
    scenario::{
        RoadUser,
        scripted_event::{EGO_NAME, MOST_LANES, PLACES},
    },
    toml_text::did_you_mean,
};
use std::collections::BTreeMap;

/// Longest name of a road user or an event, letters.
const NAME_LETTERS: usize = 40;

/// Entity with its name in the scenario.
#[derive(Clone, Debug)]
pub(super) struct Role {
    pub entity: Entity,
    pub name: String,
    /// Place of the reference point at the start.
    pub place: PathPlace,
    pub speed_mps: f64,
}

impl Role {
    /// Returns the place on the path of the front while the reference point is at a place, m.
    pub fn front_at_m(&self, s_m: f64) -> f64 {
        if self.place.is_against { s_m - self.entity.front_m() } else { s_m + self.entity.front_m() }
    }
}

/// Entities of a scene with their roles.
#[derive(Debug, Default)]
pub(super) struct Cast {
    roles: BTreeMap<String, Role>,
    pub users: Vec<RoadUser>,
    /// Entity whose place the participant takes.
    pub participant: Option<String>,
    /// Names of all entities of the file.
    known: Vec<String>,
}

/// Returns the name of the entity whose path is that of the scene, and whether the participant takes its place.
///
/// # Errors
/// The choice names no entity, or there is none.
pub(super) fn lead(scenario: &OpenScenario, choice: &ParticipantChoice) -> Result<(String, bool), OpenScenarioError> {
    let fault = |message: String| OpenScenarioError { file: scenario.file.clone(), line: 0, message };
    let names: Vec<&str> = scenario.entities.iter().map(|entity| entity.name.as_str()).collect();
    let ego = names.iter().find(|name| name.eq_ignore_ascii_case(EGO_NAME));
    match choice {
        ParticipantChoice::Named(name) => match names.contains(&name.as_str()) {
            true => Ok((name.clone(), true)),
            false => Err(fault(format!(
                "--participant is \"{name}\"{}; allowed: none, {}",
                did_you_mean(name, &names),
                names.join(", ")
            ))),
        },
        ParticipantChoice::Ego | ParticipantChoice::None => {
            let is_driven = *choice == ParticipantChoice::Ego && ego.is_some();
            let first = ego.or(names.first());
            first
                .map(|name| ((*name).to_owned(), is_driven))
                .ok_or_else(|| fault("it has no vehicles or people".into()))
        }
    }
}

impl Cast {
    /// Gives all entities their roles.
    pub fn new(scenario: &OpenScenario, scene: &Scene, participant: Option<&str>, problems: &mut Problems) -> Self {
        let mut cast = Self {
            participant: participant.map(str::to_owned),
            known: scenario.reader.entity_names.clone(),
            ..Self::default()
        };
        for entity in &scenario.entities {
            let (mut speed_mps, mut line) = (0.0, entity.place.clone());
            for action in scenario.storyboard.init.iter().filter(|action| action.entity.as_ref() == Some(&entity.name))
            {
                match &action.deed {
                    Deed::Speed(dynamics, SpeedTarget::Absolute(to_mps)) if dynamics.extent == Extent::Step => {
                        speed_mps = *to_mps;
                    }
                    Deed::Teleport(placement) => line = placement.place.clone(),
                    _ => {}
                }
            }
            let is_participant = participant == Some(entity.name.as_str());
            match cast.role(entity, scene, (speed_mps, is_participant)) {
                Ok(role) => {
                    if !is_participant {
                        cast.users.push(user(&role, scene));
                    }
                    cast.roles.insert(entity.name.clone(), role);
                }
                Err(meaning) => problems.add(Unsupported {
                    file: line.file.to_path_buf(),
                    line: line.line,
                    element: format!("ScenarioObject {}", entity.name),
                    meaning,
                }),
            }
        }
        cast
    }

    fn role(&self, entity: &Entity, scene: &Scene, (speed_mps, is_participant): (f64, bool)) -> Result<Role, String> {
        let name = &entity.name;
        let spot = scene.spots.get(name).ok_or(format!("{name} has no place at the start, and is not there"))?;
        let place = scene.place(spot).ok_or(format!("{name} stands far from the path of the ego, and is not there"))?;
        let taken: Vec<&str> = self.users.iter().map(|user| user.name.as_str()).collect();
        let own = if is_participant { EGO_NAME.to_owned() } else { plain_name(name, &taken) };
        let role = Role { entity: entity.clone(), name: own, place, speed_mps };
        let front_m = role.front_at_m(place.s_m);
        if front_m < 0.0 || place.s_m > scene.map.route.length_m() {
            return Err(format!(
                "{name} stands before the begin or beyond the end of the path of the ego, and is not there"
            ));
        }
        Ok(role)
    }

    /// Returns the role of an entity; `None` for one that is not there.
    ///
    /// # Errors
    /// The file has no such entity.
    pub fn role_of(&self, name: &str, place: &Place) -> Result<Option<&Role>, OpenScenarioError> {
        match self.known.iter().any(|known| known == name) {
            true => Ok(self.roles.get(name)),
            false => {
                let near = did_you_mean(name, &self.known);
                Err(place.fault(format!("no entity is named \"{name}\"{near}; allowed: {}", self.known.join(", "))))
            }
        }
    }

    /// Returns true for the entity whose place the participant takes.
    pub fn is_participant(&self, name: &str) -> bool {
        self.participant.as_deref() == Some(name)
    }
}

fn user(role: &Role, scene: &Scene) -> RoadUser {
    let (entity, place) = (&role.entity, role.place);
    let (lanes_left, offset_m) = place.lane(scene);
    RoadUser {
        name: role.name.clone(),
        kind: entity.kind,
        place_m: rounded(role.front_at_m(place.s_m)),
        lanes_left,
        offset_m,
        against: place.is_against,
        speed_mps: rounded(role.speed_mps),
        length_m: Some(entity.length_m),
        width_m: Some(entity.width_m),
        height_m: Some(entity.height_m),
        rear_axle_m: Some(rounded(entity.front_m())),
        most_accel_mps2: entity.most_mps2[0],
        most_decel_mps2: entity.most_mps2[1],
    }
}

impl PathPlace {
    /// Returns the lane whose middle is nearest, counted to the left from that of the path, and the offset from its middle, m.
    pub fn lane(&self, scene: &Scene) -> (i32, f64) {
        let middle_m = |lanes: i32| scene.map.lane_middle_m(self.s_m, lanes);
        let aside_m = |lanes: &i32| (middle_m(*lanes) - self.offset_m).abs();
        let lanes_left =
            (-MOST_LANES..=MOST_LANES).min_by(|a, b| aside_m(a).total_cmp(&aside_m(b))).unwrap_or_default();
        (lanes_left, rounded(self.offset_m - middle_m(lanes_left)))
    }
}

/// Returns a number to a tenth of a millimetre.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}

/// Returns a name that a scenario allows: of at most 40 letters, none that means another vehicle, and different from those that are taken.
fn plain_name(name: &str, taken: &[&str]) -> String {
    let means_another =
        name.trim().is_empty() || name.parse::<u32>().is_ok() || name == EGO_NAME || PLACES.contains(&name);
    let name = if means_another { format!("entity {name}") } else { name.to_owned() };
    unique_name(&name, taken)
}

/// Returns a name of at most 40 letters that is not taken.
pub(super) fn unique_name(name: &str, taken: &[&str]) -> String {
    let cut = |letters: usize| name.trim().chars().take(letters).collect::<String>();
    let numbered = (2..).map(|k| {
        let end = format!(" {k}");
        cut(NAME_LETTERS - end.len()) + &end
    });
    let mut names = std::iter::once(cut(NAME_LETTERS)).chain(numbered);
    names.find(|name| !taken.contains(&name.as_str())).unwrap_or_default()
}
