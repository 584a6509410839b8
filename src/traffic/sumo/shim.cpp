// C interface over libsumo. Lanes, signals and vehicles are numbers here; a vehicle's number is given when it is added or departs, and
// never again. One call makes a step and reads everything into columns that stand until the next. Every function returns 0, or 1 with a
// message in cs_error(); no exception leaves this file. Metres, m/s, compass degrees. Used by one thread at a time
// (src/traffic/sumo/shim.rs). `shim_data.hpp` has the data that pass, `shim_state.hpp` what is known from step to step.
#include "shim_state.hpp"

#include <cmath>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#define API extern "C" __attribute__((visibility("default")))

namespace {

thread_local std::string error_text;

// Runs `body`; no exception leaves it.
template <class F>
int guard(F body) noexcept {
    try {
        body();
        return 0;
    } catch (const std::exception& e) {
        error_text = e.what();
    } catch (...) {
        error_text = "unknown C++ exception";
    }
    return 1;
}

// Edges with a blank between them; they stand until the next call.
const char* tell_route(const std::vector<std::string>& edges) {
    route_edges.clear();
    for (const std::string& edge : edges) route_edges += (route_edges.empty() ? "" : " ") + edge;
    return route_edges.c_str();
}

std::vector<std::string> strings(const char* const* items, size_t n) { return {items, items + n}; }

}  // namespace

API void cs_interface(Interface* out) {
    *out = {INTERFACE, sizeof(Command), sizeof(Record), sizeof(Departure), sizeof(VehicleType)};
}

API const char* cs_error() { return error_text.c_str(); }

// Begins a simulation with the options of the command line; argv[0] is ignored.
API int cs_start(const char* const* argv, size_t n) {
    return guard([&] {
        forget();
        sim::Simulation::start(strings(argv, n));
    });
}

API int cs_close() {
    return guard([] {
        forget();
        sim::Simulation::close();
    });
}

API int cs_version(const char** value) {
    return guard([&] {
        answer = sim::Simulation::getVersion().second;
        *value = answer.c_str();
    });
}

// Numbers lanes and signals; after cs_start.
API int cs_number(const char* const* lane_ids, size_t lane_count, const char* const* signal_ids, size_t signal_count, const Reading* how) {
    return guard([&] {
        reading = *how;
        next_number = how->first_number;
        for (const std::string& id : strings(lane_ids, lane_count)) {
            const size_t mark = id.rfind('_');
            if (mark == std::string::npos) throw std::invalid_argument("lane '" + id + "' is of no edge");
            lane_numbers.emplace(id, static_cast<int32_t>(lanes.size()));
            lanes.push_back(Lane{id, id.substr(0, mark), std::stoi(id.substr(mark + 1)), length(id)});
        }
        signals = strings(signal_ids, signal_count);
        for (const std::string& id : signals) programmes.push_back(sim::TrafficLight::getProgram(id));
    });
}

// Length and speed limit of a lane as SUMO has them.
API int cs_lane(size_t lane, double* length, double* speed) {
    return guard([&] {
        *length = sim::Lane::getLength(lanes.at(lane).id);
        *speed = sim::Lane::getMaxSpeed(lanes.at(lane).id);
    });
}

// How many lanes SUMO has, with those inside junctions.
API int cs_lane_count(size_t* count) {
    return guard([&] { *count = static_cast<size_t>(sim::Lane::getIDCount()); });
}

// Classes that may not use a lane, a blank between them, and then a line for each of its connections: the lane that it leads to, the lane
// inside the junction, the direction, a tab between them. The text stands until the next call.
API int cs_lane_text(size_t lane, const char** text) {
    return guard([&] {
        const std::string& id = lanes.at(lane).id;
        answer.clear();
        for (const std::string& name : sim::Lane::getDisallowed(id)) answer += (answer.empty() ? "" : " ") + name;
        for (const auto& link : sim::Lane::getLinks(id))
            answer += "\n" + link.approachedLane + "\t" + link.approachedInternal + "\t" + link.direction;
        *text = answer.c_str();
    });
}

// Closes a lane to the vehicles of this drive: SUMO's own choose a lane where one leads to several.
API int cs_close_lane(size_t lane) {
    return guard([&] {
        const std::vector<std::string> classes = {"passenger"};
        sim::Lane::setDisallowed(lanes.at(lane).id, classes);
    });
}

API int cs_type(const char* base, const char* name, const VehicleType* v) {
    return guard([&] {
        using Type = sim::VehicleType;
        // SUMO's IDM computes sqrt(accel decel) when it is made, and the setters leave that number as it was: a copy of
        // the finished draft is made from the new values. (Test: cars_of_other_parameters_move_alike_in_both_engines.)
        const std::string draft = std::string(name) + ".draft";
        Type::copy(base, draft);
        Type::setLength(draft, v->length);
        Type::setWidth(draft, v->width);
        Type::setAccel(draft, v->accel);
        Type::setDecel(draft, v->decel);
        Type::setEmergencyDecel(draft, v->emergency_decel);
        Type::setApparentDecel(draft, v->decel);
        Type::setTau(draft, v->time_gap);
        Type::setMinGap(draft, v->min_gap);
        Type::setMaxSpeed(draft, v->max_speed);
        Type::setSpeedFactor(draft, 1.);
        Type::setSpeedDeviation(draft, 0.);
        Type::copy(draft, name);
    });
}

// Gives a vehicle the numbers of its driver, in a type of its own made from the one that it has, which may be that of another driver.
API int cs_person(uint32_t number, double accel, double decel, double time_gap, double min_gap) {
    return guard([&] {
        using Type = sim::VehicleType;
        const std::string& id = vehicle(number).id;
        const std::string own = sim::Vehicle::getTypeID(id), prefix = "codrive.person.";
        const std::string name = own.rfind(prefix, 0) == 0 ? own + ".next" : prefix + std::to_string(number);
        const std::string draft = name + ".draft";
        Type::copy(own, draft);
        Type::setAccel(draft, accel);
        Type::setDecel(draft, decel);
        Type::setEmergencyDecel(draft, std::max(decel, Type::getEmergencyDecel(draft)));
        Type::setApparentDecel(draft, decel);
        Type::setTau(draft, time_gap);
        Type::setMinGap(draft, min_gap);
        Type::copy(draft, name);
        sim::Vehicle::setType(id, name);
    });
}

// The leader of a vehicle within `reach`: its number, its speed and the gap between the bumpers; an infinite gap without one.
API int cs_leader(uint32_t number, double reach, uint32_t* leader_number, double* gap, double* speed) {
    return guard([&] {
        const Mobile& v = vehicle(number);
        const std::string& id = v.id;
        *gap = INFINITY, *speed = 0.;
        if (v.is_person) return;
        const auto leader = sim::Vehicle::getLeader(id, reach);
        if (leader.first.empty()) return;
        const auto known = numbers.find(leader.first);
        if (known == numbers.end()) return;  // it departs in this step
        *leader_number = known->second;
        // SUMO's own gap is that beyond the smallest one.
        *gap = leader.second + sim::Vehicle::getMinGap(id);
        *speed = sim::Vehicle::getSpeed(leader.first);
    });
}

API int cs_route(const char* id, const char* const* edges, size_t n) {
    return guard([&] { sim::Route::add(id, strings(edges, n)); });
}

// Puts a vehicle on a lane at once, whatever SUMO's checks on insertion say. Its route is one of edges that was made before. `keeps_lane`:
// SUMO's model drives it and never changes its lane; otherwise a driver outside SUMO moves it along that route.
API int cs_add(const char* id, const char* route, const char* type, size_t lane, double pos, double speed, int keeps_lane,
               uint32_t* number) {
    return guard([&] {
        // The first lane that it may use: the outermost can be a pavement or a place to park.
        sim::Vehicle::add(id, route, type, "now", "first", "0", "0");
        sim::Vehicle::moveTo(id, lanes.at(lane).id, pos);
        sim::Vehicle::setPreviousSpeed(id, speed, 0.);
        Mobile added{id, false, fresh(next_number), false, keeps_lane == 0, {}, 0};
        if (keeps_lane) {
            sim::Vehicle::setLaneChangeMode(id, 0);
        } else {
            added.path = sim::Route::getEdges(route);
        }
        numbers.emplace(id, next_number);
        vehicles.push_back(added);
        *number = next_number++;
    });
}

// From now on a driver outside SUMO moves a vehicle of the demand. The edges of its route, a blank between them, stand until the next call.
API int cs_take(uint32_t number, const char** edges) {
    return guard([&] {
        Mobile& v = vehicle(number);
        if (v.is_person) throw std::invalid_argument("a person is no vehicle");
        v.is_moved = true;
        v.path = sim::Vehicle::getRoute(v.id);
        v.path_at = 0;
        *edges = tell_route(v.path);
    });
}

// From now on a driver outside SUMO has the pedals of a vehicle of the demand, and SUMO the wheel. Its edges as of cs_take.
API int cs_take_pedals(uint32_t number, const char** edges) {
    return guard([&] {
        const Mobile& v = vehicle(number);
        if (v.is_person) throw std::invalid_argument("a person is no vehicle");
        // Safe distance, right of way and red lights count; the limits of acceleration are those of the driver's car.
        sim::Vehicle::setSpeedMode(v.id, 1 + 8 + 16);
        *edges = tell_route(sim::Vehicle::getRoute(v.id));
    });
}

// Changes a vehicle's lane by this many to the left, and gives it no other way to change lanes any more: by order, into gaps that are safe or, without
// `keeps_gaps`, in which it touches none at once.
API int cs_change_lane(uint32_t number, int to_the_left, double duration, bool keeps_gaps) {
    return guard([&] {
        const Mobile& v = vehicle(number);
        if (v.is_person) throw std::invalid_argument("a person has no lane");
        constexpr int INTO_SAFE_GAPS = 512;
        constexpr int WITHOUT_TOUCH = 256;
        sim::Vehicle::setLaneChangeMode(v.id, keeps_gaps ? INTO_SAFE_GAPS : WITHOUT_TOUCH);
        const std::string edge = sim::Vehicle::getRoadID(v.id);
        if (edge.empty() || edge[0] == ':') return;
        const int lane = sim::Vehicle::getLaneIndex(v.id) + to_the_left;
        if (lane < 0 || lane >= sim::Edge::getLaneNumber(edge)) return;
        sim::Vehicle::changeLane(v.id, lane, duration);
    });
}

// Gives a vehicle a route from the edge where it is.
API int cs_set_route(uint32_t number, const char* const* edges, size_t n) {
    return guard([&] {
        const Mobile& v = vehicle(number);
        if (v.is_person) throw std::invalid_argument("a person has no route");
        sim::Vehicle::setRoute(v.id, strings(edges, n));
    });
}

// Begins a phase of a signal's programme, to which a held signal returns.
API int cs_set_phase(size_t signal, uint32_t phase) {
    return guard([&] {
        const std::string& id = signals.at(signal);
        if (sim::TrafficLight::getProgram(id) == "online") sim::TrafficLight::setProgram(id, programmes.at(signal));
        sim::TrafficLight::setPhase(id, static_cast<int>(phase));
    });
}

// Holds a signal at these letters, as many as it has links.
API int cs_set_state(size_t signal, const char* letters) {
    return guard([&] {
        const std::string& id = signals.at(signal);
        const size_t links = sim::TrafficLight::getRedYellowGreenState(id).size();
        if (std::string(letters).size() != links)
            throw std::invalid_argument("a signal with " + std::to_string(links) + " links takes as many letters");
        sim::TrafficLight::setRedYellowGreenState(id, letters);
    });
}

// A vehicle's name in the demand, and after a line feed that of its type; the text stands until the next call.
API int cs_names(uint32_t number, const char** text) {
    return guard([&] {
        const Mobile& v = vehicle(number);
        answer = v.id + "\n" + (v.is_person ? sim::Person::getTypeID(v.id) : sim::Vehicle::getTypeID(v.id));
        *text = answer.c_str();
    });
}

// The name by which SUMO knows a vehicle that its model drives.
static const std::string& driven(uint32_t number) {
    const Mobile& v = vehicle(number);
    if (v.is_person) throw std::invalid_argument("a person has no such speed");
    return v.id;
}

// Changes a vehicle's speed evenly within `duration`, in one step at least; its checks hold.
API int cs_set_speed(uint32_t number, double speed, double duration) {
    constexpr double NEXT_STEP = 1e-3;
    return guard([&] { sim::Vehicle::slowDown(driven(number), speed, std::max(duration, NEXT_STEP)); });
}

// The highest speed of a vehicle, with its model.
API int cs_set_max_speed(uint32_t number, double speed) {
    return guard([&] { sim::Vehicle::setMaxSpeed(driven(number), speed); });
}

// The checks that a vehicle obeys, by SUMO's bits.
API int cs_set_speed_mode(uint32_t number, uint32_t mode) {
    return guard([&] { sim::Vehicle::setSpeedMode(driven(number), static_cast<int>(mode)); });
}

// A vehicle of the demand that an event moves: it keeps its lane, and its speeds are limited by safe distances, right of way and signals alone.
API int cs_take_over(uint32_t number) {
    return guard([&] {
        constexpr int KEEPS_LANE = 512;
        constexpr int WITHOUT_OWN_LIMITS = 1 + 8 + 16;
        const std::string id = driven(number);
        Mobile& v = vehicle(number);
        if (v.lane_changes < 0) v.lane_changes = sim::Vehicle::getLaneChangeMode(id);
        sim::Vehicle::setLaneChangeMode(id, KEEPS_LANE);
        sim::Vehicle::setSpeedMode(id, WITHOUT_OWN_LIMITS);
    });
}

// The vehicle's own model has speed and lane again, with all checks.
API int cs_give_back(uint32_t number) {
    return guard([&] {
        constexpr double NO_ORDER = -1.;
        constexpr int ALL_CHECKS = 31;
        const std::string id = driven(number);
        Mobile& v = vehicle(number);
        sim::Vehicle::setSpeed(id, NO_ORDER);
        sim::Vehicle::setSpeedMode(id, ALL_CHECKS);
        if (v.lane_changes >= 0) sim::Vehicle::setLaneChangeMode(id, v.lane_changes);
        v.lane_changes = -1;
    });
}

// The commands, one step, and everything that it changed.
API int cs_step(const Command* commands, size_t n, double step_s, Step* out) {
    return guard([&] {
        for (size_t i = 0; i < n; i++) obey(commands[i]);
        sim::Simulation::step();
        look(step_s);
        tell(out);
    });
}

// Everything as it is, without a step.
API int cs_look(Step* out) {
    return guard([&] {
        read_anew();
        look(0.);
        tell(out);
    });
}

// A step and nothing else, to measure against.
API int cs_bare_step() {
    return guard([] {
        read_anew();
        sim::Simulation::step();
    });
}

// Where SUMO itself draws a vehicle: front bumper and compass degrees.
API int cs_pose(uint32_t number, double* x, double* y, double* angle_deg) {
    return guard([&] {
        const std::string& id = vehicle(number).id;
        const auto p = sim::Vehicle::getPosition(id);
        *x = p.x;
        *y = p.y;
        *angle_deg = sim::Vehicle::getAngle(id);
    });
}
