//! The vocabulary that SUMO may be given: elements, their parents, their attributes and the keys of their parameters.
//! In: names. Out: whether they pass. Compiled by hand from SUMO 1.28's schemas (net_file.xsd, routes_file.xsd,
//! additional_file.xsd), without anything that writes, opens, runs or connects.

use std::{collections::BTreeMap, sync::LazyLock};

/// Row of a table: element, possible parents, attributes, and keys of parameters. Words are separated by spaces.
type Row = (&'static str, &'static str, &'static str, &'static str);

/// Rule of an allowed element.
#[derive(Debug)]
pub struct Rule {
    /// Name of the element.
    pub name: &'static str,
    parents: Vec<&'static str>,
    attributes: Vec<&'static str>,
    keys: Vec<&'static str>,
}

impl Rule {
    /// Checks whether the element may have this parent; the root's parent is `""`.
    pub fn may_stand_in(&self, parent: &str) -> bool {
        self.parents.contains(&parent)
    }

    /// Checks whether an attribute passes.
    pub fn has_attribute(&self, name: &str) -> bool {
        self.attributes.binary_search(&name).is_ok()
    }

    /// Checks whether a parameter passes. The part after a colon is the id of a lane.
    pub fn has_key(&self, key: &str) -> bool {
        self.keys.contains(&key.split_once(':').map_or(key, |(name, _)| name))
    }

    /// Returns the possible parents of the element; `""` for the root.
    pub fn parents(&self) -> &[&'static str] {
        &self.parents
    }

    /// Returns the keys of the allowed parameters.
    pub fn keys(&self) -> &[&'static str] {
        &self.keys
    }

    /// Returns the allowed attributes, sorted.
    pub fn attributes(&self) -> &[&'static str] {
        &self.attributes
    }
}

/// Name of the parameter element, which every other element may hold.
pub const PARAMETER: &str = "param";

/// Allowed elements of a kind of file.
pub struct Vocabulary {
    /// Name of the kind of file, for messages.
    pub title: &'static str,
    /// Name of the outermost element.
    pub root: &'static str,
    /// Other names that SUMO's own files may have for the outermost element.
    pub other_roots: &'static [&'static str],
    /// Names of the elements within the outermost one that are left out with all that they hold, because they only write.
    omitted: &'static str,
    rules: BTreeMap<&'static str, Rule>,
}

impl Vocabulary {
    fn new(title: &'static str, root: &'static str, others: &'static [&'static str], rows: &[Row]) -> Self {
        let words = |text: &'static str| text.split_whitespace().collect::<Vec<_>>();
        let rule = |&(name, parents, attributes, keys): &Row| {
            let mut attributes = words(attributes);
            attributes.sort_unstable();
            let parents = if parents.is_empty() { vec![""] } else { words(parents) };
            (name, Rule { name, parents, attributes, keys: words(keys) })
        };
        Self { title, root, other_roots: others, omitted: "", rules: rows.iter().map(rule).collect() }
    }

    /// Returns true for an element that is left out with all that it holds.
    pub fn omits(&self, name: &str) -> bool {
        self.omitted.split_whitespace().any(|omitted| omitted == name)
    }

    /// Returns the rule of an element.
    pub fn rule(&self, name: &str) -> Option<&Rule> {
        self.rules.get(name)
    }

    /// Returns all rules, sorted by name.
    pub fn rules(&self) -> impl Iterator<Item = &Rule> {
        self.rules.values()
    }

    /// Returns the names of the elements that an element may hold.
    pub fn within(&self, parent: &str) -> Vec<&'static str> {
        self.rules().filter(|rule| rule.may_stand_in(parent)).map(|rule| rule.name).collect()
    }
}

/// Returns the vocabulary of road networks (`net.xml`).
pub fn network() -> &'static Vocabulary {
    static NETWORK: LazyLock<Vocabulary> = LazyLock::new(|| Vocabulary::new("a network", "net", &[], NETWORK_ROWS));
    &NETWORK
}

/// Returns the vocabulary of demand files (`rou.xml`).
pub fn demand() -> &'static Vocabulary {
    static DEMAND: LazyLock<Vocabulary> =
        LazyLock::new(|| Vocabulary::new("a demand", "routes", &["additional", "route-alternatives"], DEMAND_ROWS));
    &DEMAND
}

/// Returns the vocabulary of additional files (`add.xml`): that of demands, with stopping places, rerouters, calibrators, speed signs and
/// programs of signals. Detectors and other elements that only write, and drawings, are left out.
pub fn additional() -> &'static Vocabulary {
    static ADDITIONAL: LazyLock<Vocabulary> = LazyLock::new(|| {
        let roots = &["additionals", "add", "routes"];
        let mut words = Vocabulary::new("an additional file", "additional", roots, ADDITIONAL_ROWS);
        for (name, rule) in &demand().rules {
            let none = || Rule { name, parents: Vec::new(), attributes: Vec::new(), keys: Vec::new() };
            let row = words.rules.entry(name).or_insert_with(none);
            // A list of routes may also stand within an additional file.
            let is_at_top = rule.parents.iter().any(|parent| matches!(*parent, "routes" | ""));
            // An interval belongs to a rerouter here, and flows stand outside of intervals, so that the nesting is limited.
            row.parents.extend(rule.parents.iter().filter(|parent| !matches!(**parent, "" | "interval")));
            row.parents.extend(is_at_top.then_some("additional"));
            row.attributes.extend(&rule.attributes);
            row.attributes.sort_unstable();
            row.attributes.dedup();
            row.keys.extend(&rule.keys);
        }
        words.omitted = OMITTED;
        words
    });
    &ADDITIONAL
}

/// Allowed types of signal programs: without "off", on which SUMO 1.28 crashes, and without the research types that write logs (sotl,
/// swarm).
pub const SIGNAL_TYPES: &str = "static actuated delay_based NEMA railSignal railCrossing";

/// Keys of actuated, delay-based and NEMA signals. `file`, `freq` and `whetherOutputState` cause output, so they are
/// absent.
const SIGNAL_KEYS: &str = "max-gap min-gap jam-threshold passing-time detector-gap inactive-threshold detectorRange minTimeLoss extendMaxDur \
     detector-length detector-length-leftTurnLane total-cycle-length ring1 ring2 barrierPhases barrier2Phases coordinatePhases minRecall maxRecall \
     fixForceOff controllerType cabinetType";

const NETWORK_ROWS: &[Row] = &[
    (
        "net",
        "",
        "version junctionCornerDetail junctionLinkDetail lefthand rectangularLaneCut walkingareas limitTurnSpeed checkLaneFoesAll \
         checkLaneFoesRoundabout tlsIgnoreInternalJunctionJam spreadType avoidOverlap junctionHigherSpeed internalJunctionsVehicleWidth \
         junctionsMinimalShape junctionsEndpointShape",
        "",
    ),
    ("location", "net", "netOffset convBoundary origBoundary projParameter", ""),
    (
        "type",
        "net",
        "id priority numLanes speed friction allow disallow discard oneway width widthResolution maxWidth minWidth sidewalkWidth \
         bikeLaneWidth spreadType",
        "",
    ),
    ("restriction", "type laneType", "vClass speed", ""),
    (
        "meso",
        "type",
        "tauff taufj taujf taujj jamThreshold junctionControl tlsPenalty tlsFlowPenalty minorPenalty overtaking edgeLength",
        "",
    ),
    ("laneType", "type", "index allow disallow speed width", ""),
    (
        "edge",
        "net",
        "id function from to name priority length bidi type routingType shape distance spreadType crossingEdges",
        "",
    ),
    (
        "lane",
        "edge",
        "id index allow disallow prefer speed friction length endOffset width acceleration shape customShape type changeRight changeLeft \
         outlineShape",
        "",
    ),
    ("neigh", "lane", "lane", ""),
    ("stopOffset", "edge lane", "value vClasses exceptions", ""),
    ("tlLogic", "net", "id type programID offset nodes pos", SIGNAL_KEYS),
    ("phase", "tlLogic", "duration state minDur maxDur earliestEnd latestEnd yellow red vehext next name", ""),
    (
        "junction",
        "net",
        "id x y z type incLanes intLanes shape name radius customShape rightOfWay fringe roundabout",
        "",
    ),
    ("request", "junction", "index response foes cont", ""),
    (
        "connection",
        "net",
        "from to fromLane toLane pass keepClear contPos visibility allow disallow speed length shape uncontrolled via tl linkIndex \
         linkIndex2 changeRight changeLeft indirect type dir state",
        "",
    ),
    ("conflict", "connection", "from to fromLane toLane startPos endPos", ""),
    ("prohibition", "net", "prohibitor prohibited", ""),
    ("roundabout", "net", "nodes edges", ""),
    ("taz", "net", "id edges shape center name", ""),
    ("tazSource", "taz", "id weight", ""),
    ("tazSink", "taz", "id weight", ""),
];

/// Attributes of car-following models, in a type or in an element of its own.
macro_rules! following {
    () => {
        "accel decel emergencyDecel apparentDecel maxAccelProfile desAccelProfile sigma sigmaStep tau delta stepping adaptTime adaptFactor \
         tmp1 tmp2 tmp3 tmp4 tmp5 tauLast apProb k phi security estimation speedControlGain speedControlMinGap gapClosingControlGainSpeed \
         gapClosingControlGainSpace gapControlGainSpeed gapControlGainSpace collisionAvoidanceGainSpeed collisionAvoidanceGainSpace \
         collisionAvoidanceOverride tauCACCToACC applyDriverState cc1 cc2 cc3 cc4 cc5 cc6 cc7 cc8 cc9 c1 ccDecel constSpacing kp lambda \
         omegaN tauEngine xi lanesCount ccAccel ploegKp ploegKd ploegH flatbedKa flatbedKv flatbedKp flatbedD flatbedH \
         collisionMinGapFactor speedControlGainCACC gapClosingControlGainGap gapClosingControlGainGapDot gapControlGainGap \
         gapControlGainGapDot collisionAvoidanceGainGap collisionAvoidanceGainGapDot tPersDrive tpreview treaction tPersEstimate ccoolness \
         sigmaleader sigmagap sigmaerror jerkmax epsilonacc taccmax Mflatness Mbegin vehdynamics maxvehpreview startupDelay "
    };
}
/// Attributes that vehicles, trips and flows share.
macro_rules! departure {
    () => {
        "id route reroute fromTaz toTaz via type color departLane departPos departSpeed departEdge arrivalEdge arrivalLane arrivalPos \
         arrivalSpeed departPosLat arrivalPosLat line personNumber containerNumber speedFactor insertionChecks parkingBadges "
    };
}
/// Attributes of the origin and the destination of a trip.
macro_rules! ends {
    () => {
        "from to fromTaz toTaz fromXY toXY fromLonLat toLonLat fromJunction toJunction viaJunctions busStop trainStop parkingArea containerStop \
         chargingStation arrivalPos "
    };
}
/// Attributes of persons and containers.
macro_rules! plan {
    () => {
        "id arrival type departPos arrivalPos color modes vTypes speedFactor "
    };
}
/// Attributes of flows, for the number and the rate of vehicles.
macro_rules! rate {
    () => {
        "begin end period perHour probability number "
    };
}

const FOLLOWING: &str = following!();

const DEMAND_ROWS: &[Row] = &[
    ("routes", "", "", ""),
    (
        "vType",
        "routes vTypeDistribution",
        concat!(
            "id refId length minGap maxSpeed desiredMaxSpeed probability speedFactor speedDev vClass maneuverAngleTimes guiShape width height \
             mass color parkingBadges personCapacity containerCapacity boardingDuration loadingDuration scale lcStrategic lcCooperative \
             lcSpeedGain lcKeepRight lcSublane lcOpposite lcPushy lcPushyGap lcStrategicLookahead lcAssertive lcLookaheadLeft \
             lcSpeedGainRight lcSpeedGainLookahead lcSpeedGainRemainTime lcSpeedGainUrgency lcCooperativeRoundabout lcCooperativeSpeed \
             lcCooperativeHelpTime lcCooperativeHelpThreshold lcCooperativeMinSpeed lcTurnAlignmentDistance lcImpatience \
             lcTimeToImpatience lcAccelLat lcMaxSpeedLatStanding lcMaxSpeedLatFactor lcMaxDistLatStanding lcOvertakeRight \
             lcLaneDiscipline lcSigma lcKeepRightAcceptanceTime lcOvertakeDeltaSpeedFactor lcContRight maxSpeedLat latAlignment \
             actionStepLength hasDriverState minGapLat jmCrossingGap jmDriveAfterYellowTime jmDriveAfterRedTime jmDriveRedSpeed \
             jmIgnoreKeepClearTime jmIgnoreFoeSpeed jmIgnoreFoeProb jmIgnoreJunctionFoeProb jmSigmaMinor jmStoplineGap \
             jmStoplineGapMinor jmTimegapMinor jmExtraGap jmAdvance jmStopSignWait jmAllwayStopWait impatience carFollowModel trainType \
             laneChangeModel timeToTeleport timeToTeleportBidi speedFactorPremature boardingFactor massFactor maxPower maxTraction \
             resCoef_constant resCoef_linear resCoef_quadratic curveResistance curveIntegration roeckl_sharp_radius roeckl_numerator \
             roeckl_numerator_sharp roeckl_offset roeckl_offset_sharp ",
            following!()
        ),
        "junctionModel.ignoreIDs junctionModel.ignoreTypes",
    ),
    ("carFollowing-IDM", "vType", FOLLOWING, ""),
    ("carFollowing-IDMM", "vType", FOLLOWING, ""),
    ("carFollowing-EIDM", "vType", FOLLOWING, ""),
    ("carFollowing-Krauss", "vType", FOLLOWING, ""),
    ("carFollowing-KraussPS", "vType", FOLLOWING, ""),
    ("carFollowing-KraussOrig1", "vType", FOLLOWING, ""),
    ("carFollowing-SmartSK", "vType", FOLLOWING, ""),
    ("carFollowing-Daniel1", "vType", FOLLOWING, ""),
    ("carFollowing-PWagner2009", "vType", FOLLOWING, ""),
    ("carFollowing-BKerner", "vType", FOLLOWING, ""),
    ("carFollowing-Wiedemann", "vType", FOLLOWING, ""),
    ("carFollowing-W99", "vType", FOLLOWING, ""),
    ("carFollowing-ACC", "vType", FOLLOWING, ""),
    ("carFollowing-CACC", "vType", FOLLOWING, ""),
    ("carFollowing-CC", "vType", FOLLOWING, ""),
    ("vTypeDistribution", "routes", "id vTypes probabilities deterministic", ""),
    ("routeDistribution", "routes vehicle flow", "id last routes probabilities", ""),
    (
        "route",
        "routes vehicle flow trip routeDistribution",
        "id refId edges color exitTimes cost savings repeat cycleTime probability routeLength",
        "",
    ),
    (
        "vehicle",
        "routes",
        concat!(departure!(), "depart arrival routeLength"),
        "junctionModel.ignoreIDs junctionModel.ignoreTypes",
    ),
    (
        "trip",
        "routes",
        concat!(
            departure!(),
            "depart from to fromLonLat toLonLat viaLonLat fromXY toXY viaXY fromJunction toJunction viaJunctions"
        ),
        "junctionModel.ignoreIDs junctionModel.ignoreTypes",
    ),
    (
        "flow",
        "routes interval",
        concat!(
            departure!(),
            rate!(),
            "vehsPerHour from to fromXY toXY viaXY fromLonLat toLonLat viaLonLat fromJunction toJunction viaJunctions"
        ),
        "junctionModel.ignoreIDs junctionModel.ignoreTypes",
    ),
    ("interval", "routes", "begin end", ""),
    (
        "stop",
        "vehicle flow trip route person personFlow container containerFlow",
        "lane edge lon lat x y busStop trainStop containerStop chargingStation parkingArea startPos endPos posLat friendlyPos arrival duration \
         until extension index parking triggered containerTriggered expected permitted expectedContainers actType tripId split join line \
         speed priorEdges priorEdgesLength started ended onDemand jump jumpUntil priority",
        "",
    ),
    ("person", "routes", concat!(plan!(), "depart"), ""),
    ("personFlow", "routes", concat!(plan!(), rate!(), "vehsPerHour personsPerHour"), ""),
    ("container", "routes", concat!(plan!(), "depart"), ""),
    ("containerFlow", "routes", concat!(plan!(), rate!(), "containersPerHour"), ""),
    (
        "personTrip",
        "person personFlow",
        concat!(ends!(), "modes vTypes departPos departPosLat walkFactor costs group lines"),
        "",
    ),
    ("ride", "person personFlow", concat!(ends!(), "lines cost intended depart routeLength group vehicle"), ""),
    (
        "walk",
        "person personFlow",
        concat!(ends!(), "route edges speed duration departPos departPosLat departLane cost routeLength exitTimes"),
        "",
    ),
    (
        "transport",
        "container containerFlow",
        concat!(ends!(), "lines cost intended depart routeLength group vehicle"),
        "",
    ),
    ("tranship", "container containerFlow", concat!(ends!(), "edges speed duration departPos"), ""),
];

/// Elements of additional files that only write, draw or describe.
const OMITTED: &str = "edgeData laneData timedEvent e1Detector inductionLoop e2Detector laneAreaDetector e3Detector entryExitDetector \
                       instantInductionLoop vTypeProbe routeProbe poly poi location metadata vaporizer deadlock";

/// Attributes that all stopping places share.
macro_rules! stopping {
    () => {
        "id name color lane startPos endPos angle friendlyPos lines parkingLength "
    };
}
/// Elements that may stand in an additional file, and in a list of routes within one.
const TOP: &str = "additional routes";

const ADDITIONAL_ROWS: &[Row] = &[
    ("additional", "", "", ""),
    ("busStop", TOP, concat!(stopping!(), "personCapacity"), ""),
    ("trainStop", TOP, concat!(stopping!(), "personCapacity"), ""),
    ("containerStop", TOP, concat!(stopping!(), "containerCapacity"), ""),
    (
        "chargingStation",
        TOP,
        concat!(
            stopping!(),
            "power totalPower efficiency chargeInTransit chargeDelay chargeType waitingTime parkingArea"
        ),
        "",
    ),
    (
        "parkingArea",
        TOP,
        concat!(stopping!(), "roadsideCapacity onRoad width length departPos lefthand acceptedBadges reservable"),
        "",
    ),
    ("space", "parkingArea", "x y z name width length angle slope", ""),
    ("access", "busStop trainStop containerStop chargingStation parkingArea", "lane pos friendlyPos length doors", ""),
    ("rerouter", TOP, "id edges probability vTypes timeThreshold pos radius name visible off optional", ""),
    ("interval", "rerouter", "begin end", ""),
    ("closingReroute", "interval", "id allow disallow until", ""),
    ("closingLaneReroute", "interval", "id allow disallow", ""),
    ("destProbReroute", "interval", "id probability", ""),
    ("routeProbReroute", "interval", "id probability", ""),
    ("viaProbReroute", "interval", "id probability", ""),
    ("parkingAreaReroute", "interval", "id probability visible", ""),
    ("stationReroute", "interval", "id minSaving", ""),
    ("calibrator", "additional", "id edge lane node pos friendlyPos local period jamThreshold vTypes name", ""),
    ("flow", "calibrator", "speed", ""),
    ("route", "calibrator", "", ""),
    ("variableSpeedSign", TOP, "id lanes vTypes pos name", ""),
    ("step", "variableSpeedSign", "time speed", ""),
    ("tlLogic", TOP, "id type programID offset", SIGNAL_KEYS),
    ("phase", "tlLogic", "duration state minDur maxDur earliestEnd latestEnd yellow red vehext next name", ""),
    ("WAUT", TOP, "id refTime startProg period", ""),
    ("wautSwitch", "WAUT", "time to", ""),
    ("wautJunction", TOP, "wautID junctionID procedure synchron", ""),
    ("taz", TOP, "id edges shape center name", ""),
    ("tazSource", "taz", "id weight", ""),
    ("tazSink", "taz", "id weight", ""),
];
