// C interface over libsumo. Lanes, signals and vehicles are numbers here; a vehicle's number is given when it is added or departs, and
// never again. One call makes a step and reads everything into columns that stand until the next. Every function returns 0, or 1 with a
// message in cs_error(); no exception leaves this file. Metres, m/s, compass degrees. Used by one thread at a time
// (src/traffic/sumo/shim.rs).
#include <libsumo/libsumo.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

namespace sim = libsumo;
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

std::vector<std::string> strings(const char* const* items, size_t n) { return {items, items + n}; }

// What both sides have to agree on before anything else is called: the number of this interface, raised with every change of a function or
// of a structure here, and the sizes of those. Same layout as `Interface` in shim.rs.
struct Interface {
    uint32_t number, command_bytes, record_bytes, departure_bytes, vehicle_type_bytes;
};
constexpr uint32_t INTERFACE = 9;

// Same layout as in shim.rs.
struct Command {
    uint32_t vehicle, kind;
    int32_t lane;  // where it is to be, as SUMO's own guess may be a lane that crosses; -1: anywhere
    double a, b, c;
};
struct Record {
    double x, y, z;  // front bumper
    double angle_deg, speed, lane_pos, lateral;
    uint32_t number;
    int32_t lane;  // -1: none
    uint32_t lamps;
};
struct Departure {
    double length, width, height;
    uint32_t number;
    const char *id, *kind, *type;
};
struct Step {
    const Record* records;
    const Departure* departures;
    const uint32_t* arrivals;
    const char* signals;            // the states of all signals, one after the other
    const uint32_t* signal_starts;  // where each begins; one more at the end
    size_t record_count, departure_count, arrival_count, signal_count;
};
struct VehicleType {
    double length, width, accel, decel, emergency_decel, time_gap, min_gap, max_speed;
};
// How a simulation is read.
struct Reading {
    uint32_t first_number;  // of the first vehicle
    uint32_t is_fixed;      // none come or go, and all keep to the middle of their lanes: speeds and places along lanes are all there is
    uint32_t lateral;       // changes of lanes take time, so that vehicles stand beside the middle of a lane
};
enum Kind : uint32_t { MOVE_TO_XY = 0, PREVIOUS_SPEED = 1, SPEED = 2, MAX_SPEED = 3, LAMPS = 4, WANTED_SPEED = 5 };

struct Lane {
    std::string id, edge;
    int index;
    double length;  // 0: not known
};
struct Mobile {
    std::string id;
    bool is_person;
    Record last;    // what was read of it last
    bool is_known;  // there was a step before, on a lane
    bool is_moved;  // by a driver outside SUMO, now or before: not by speed times step
    std::vector<std::string> path;  // of one that is moved: the edges that it is expected to drive
    size_t path_at;                 // which of them it was on last
};
struct Birth {
    std::string id, kind, type;
};

thread_local std::string answer;
Reading reading;
std::vector<Lane> lanes;
std::unordered_map<std::string, int32_t> lane_numbers;
std::vector<std::string> signals;
// By ascending number: those that came later stand behind.
std::vector<Mobile> vehicles;
std::unordered_map<std::string, uint32_t> numbers;
std::unordered_map<std::string, uint32_t> person_numbers;
uint32_t next_number = 0;
// SUMO's sum of position and way is ours to the bit. A compiler that fuses one of them may make it another.
bool is_sum_exact = true;
size_t next_to_check = 0;

std::vector<Record> records;
std::vector<Departure> departures;
std::vector<Birth> births;
std::vector<uint32_t> arrivals;
std::string signal_states;
std::vector<uint32_t> signal_starts;
std::string route_edges;

Mobile& vehicle(uint32_t number) {
    const auto found = std::lower_bound(vehicles.begin(), vehicles.end(), number,
                                        [](const Mobile& v, uint32_t n) { return v.last.number < n; });
    if (found == vehicles.end() || found->last.number != number) throw std::invalid_argument("a vehicle is no longer there");
    return *found;
}

// moveToXY gives a vehicle that it finds on another lane a route of one or two edges, as where lanes cross inside a junction. Others would
// not give way to it at the next: from the edges where it is, its path goes on.
void restore_path(Mobile& v) {
    if (v.path.empty()) return;
    const std::vector<std::string> route = sim::Vehicle::getRoute(v.id);
    const int index = sim::Vehicle::getRouteIndex(v.id);
    if (index < 0 || static_cast<size_t>(index) >= route.size()) return;
    if (route.back() == v.path.back()) {
        v.path_at = v.path.size() - std::min(v.path.size(), route.size() - index);
        return;
    }
    const auto there = std::find(v.path.begin() + static_cast<std::ptrdiff_t>(v.path_at), v.path.end(), route.back());
    if (there == v.path.end()) return;  // it has left its path
    std::vector<std::string> edges(route.begin() + index, route.end());
    edges.insert(edges.end(), there + 1, v.path.end());
    try {
        sim::Vehicle::setRoute(v.id, edges);
    } catch (const sim::TraCIException&) {
        // Refused in the midst of some junctions: the next step tries again.
    }
}

void obey(const Command& c) {
    Mobile& v = vehicle(c.vehicle);
    const std::string& id = v.id;
    switch (c.kind) {
        case MOVE_TO_XY: {
            v.is_moved = true;
            restore_path(v);
            const Lane none{"", "", -1, 0.};
            const Lane& lane = c.lane >= 0 ? lanes.at(c.lane) : none;
            sim::Vehicle::moveToXY(id, lane.edge, lane.index, c.a, c.b, c.c, 2, 20.);
            break;
        }
        case PREVIOUS_SPEED: sim::Vehicle::setPreviousSpeed(id, c.a); break;
        case SPEED:
            // Speed mode 0 drops every check; 31 is SUMO's default. A negative speed ends the order.
            sim::Vehicle::setSpeedMode(id, c.a < 0. ? 31 : 0);
            sim::Vehicle::setSpeed(id, c.a);
            break;
        case MAX_SPEED: sim::Vehicle::setMaxSpeed(id, c.a); break;
        case WANTED_SPEED: sim::Vehicle::setSpeed(id, c.a); break;
        case LAMPS: sim::Vehicle::setSignals(id, static_cast<int>(c.a)); break;
        default: throw std::invalid_argument("unknown command");
    }
}

double length(const std::string& lane) {
    try {
        return sim::Lane::getLength(lane);
    } catch (const sim::TraCIException&) {
        return 0.;
    }
}

Record fresh(uint32_t number) {
    Record record{};
    record.number = number;
    record.lane = -1;
    return record;
}

void depart(const std::string& id) {
    if (numbers.count(id)) return;
    const uint32_t number = next_number++;
    numbers.emplace(id, number);
    vehicles.push_back(Mobile{id, false, fresh(number), false, false, {}, 0});
    births.push_back(Birth{id, sim::Vehicle::getVehicleClass(id), sim::Vehicle::getTypeID(id)});
    departures.push_back(Departure{sim::Vehicle::getLength(id), sim::Vehicle::getWidth(id), sim::Vehicle::getHeight(id), number, nullptr,
                                   nullptr, nullptr});
}

void depart_person(const std::string& id) {
    if (person_numbers.count(id)) return;
    const uint32_t number = next_number++;
    person_numbers.emplace(id, number);
    vehicles.push_back(Mobile{id, true, fresh(number), false, false, {}, 0});
    const std::string type = sim::Person::getTypeID(id);
    births.push_back(Birth{id, sim::VehicleType::getVehicleClass(type), type});
    departures.push_back(Departure{sim::Person::getLength(id), sim::Person::getWidth(id), sim::VehicleType::getHeight(type), number,
                                   nullptr, nullptr, nullptr});
}

// Reads a person; false in a vehicle. A person has no lane: the shape of an area for walking is no line to follow.
bool read_person(Mobile& v) {
    if (!sim::Person::getVehicle(v.id).empty()) return false;
    const auto place = sim::Person::getPosition3D(v.id);
    if (place.x == sim::INVALID_DOUBLE_VALUE) return false;
    Record& r = v.last;
    r.x = place.x, r.y = place.y, r.z = place.z;
    r.angle_deg = sim::Person::getAngle(v.id);
    r.speed = sim::Person::getSpeed(v.id);
    return true;
}

// In process a getter costs 25 ns, some 80 ns among a thousand vehicles (a look-up by name), and a subscription copies maps. A vehicle that
// stands is where it stood, one that went on by speed times step (MSVehicle::updateState) is on its lane, and beside its middle are only
// those that change lanes, with an indicator lit. A vehicle that is not near the end of its lane goes on so, and is not asked where it is,
// but for one vehicle a step, in turn.
void read(double step_s) {
    constexpr uint32_t INDICATORS = 7;
    constexpr double NEAR_END = 1e-3, SAME = 1e-6;
    const size_t checked = vehicles.empty() ? 0 : next_to_check++ % vehicles.size();
    records.clear();
    for (size_t i = 0; i < vehicles.size(); i++) {
        Mobile& v = vehicles[i];
        if (v.is_person) {
            if (read_person(v)) records.push_back(v.last);
            continue;
        }
        Record& r = v.last;
        const double speed = sim::Vehicle::getSpeed(v.id);
        const auto lamps = reading.is_fixed ? 0u : static_cast<uint32_t>(sim::Vehicle::getSignals(v.id));
        bool is_steady = v.is_known && ((lamps | r.lamps) & INDICATORS) == 0 && r.lateral == 0. && (reading.is_fixed || !v.is_moved);
        double pos = r.lane_pos + speed * step_s;
        const bool is_followed = is_steady && is_sum_exact && !v.is_moved && r.lane >= 0 && pos < lanes[r.lane].length - NEAR_END;
        if (!is_followed || i == checked) {
            const double found = sim::Vehicle::getLanePosition(v.id);
            if (is_followed && found != pos) is_sum_exact = false;
            is_steady = is_steady && std::abs(found - pos) < SAME;
            pos = found;
        }
        if (!reading.is_fixed && (!is_steady || speed != 0.)) {
            const auto place = sim::Vehicle::getPosition3D(v.id);
            if (place.x == sim::INVALID_DOUBLE_VALUE) {
                v.is_known = false;  // neither on a lane nor beside one: it is on its way to elsewhere
                continue;
            }
            r.x = place.x, r.y = place.y, r.z = place.z;
            r.angle_deg = sim::Vehicle::getAngle(v.id);
        }
        if (!is_steady) {
            const std::string lane = sim::Vehicle::getLaneID(v.id);
            if (!v.is_known || r.lane < 0 || lanes[r.lane].id != lane) {
                const auto found = lane_numbers.find(lane);
                r.lane = found == lane_numbers.end() ? -1 : found->second;
            }
            const bool is_beside = !reading.is_fixed && (reading.lateral || v.is_moved);
            r.lateral = is_beside ? sim::Vehicle::getLateralLanePosition(v.id) : 0.;
        }
        r.speed = speed, r.lane_pos = pos, r.lamps = lamps;
        v.is_known = true;
        records.push_back(r);
    }
}

// Which vehicles have come and gone.
void count() {
    for (const std::string& id : sim::Simulation::getDepartedIDList()) depart(id);
    for (const std::string& id : sim::Simulation::getDepartedPersonIDList()) depart_person(id);
    const auto arrive = [](const std::vector<std::string>& ids, const std::unordered_map<std::string, uint32_t>& known) {
        for (const std::string& id : ids) {
            const auto found = known.find(id);
            if (found != known.end()) arrivals.push_back(found->second);
        }
    };
    arrive(sim::Simulation::getArrivedIDList(), numbers);
    arrive(sim::Simulation::getArrivedPersonIDList(), person_numbers);
    if (!arrivals.empty()) {
        std::sort(arrivals.begin(), arrivals.end());
        const auto is_over = [](const Mobile& v) { return std::binary_search(arrivals.begin(), arrivals.end(), v.last.number); };
        for (const Mobile& v : vehicles) {
            if (is_over(v)) (v.is_person ? person_numbers : numbers).erase(v.id);
        }
        vehicles.erase(std::remove_if(vehicles.begin(), vehicles.end(), is_over), vehicles.end());
    }
    for (size_t i = 0; i < births.size(); i++) {
        departures[i].id = births[i].id.c_str();
        departures[i].kind = births[i].kind.c_str();
        departures[i].type = births[i].type.c_str();
    }
}

void look(double step_s) {
    births.clear();
    departures.clear();
    arrivals.clear();
    if (!reading.is_fixed) count();
    read(step_s);
    signal_states.clear();
    signal_starts.assign(1, 0);
    for (const std::string& id : signals) {
        signal_states += sim::TrafficLight::getRedYellowGreenState(id);
        signal_starts.push_back(static_cast<uint32_t>(signal_states.size()));
    }
}

void tell(Step* out) {
    *out = {records.data(), departures.data(), arrivals.data(),   signal_states.data(), signal_starts.data(),
            records.size(), departures.size(), arrivals.size(), signals.size()};
}

void read_anew() {
    for (Mobile& v : vehicles) v.is_known = false;
}

void forget() {
    vehicles.clear();
    numbers.clear();
    person_numbers.clear();
    lanes.clear();
    lane_numbers.clear();
    signals.clear();
    is_sum_exact = true;
    next_to_check = 0;
}

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

// Gives a vehicle the numbers of its driver, in a type of its own made from the one that it has.
API int cs_person(uint32_t number, double accel, double decel, double time_gap, double min_gap) {
    return guard([&] {
        using Type = sim::VehicleType;
        const std::string& id = vehicle(number).id;
        const std::string name = "codrive.person." + std::to_string(number), draft = name + ".draft";
        Type::copy(sim::Vehicle::getTypeID(id), draft);
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

// The leader of a vehicle within `reach`: its speed and the gap between the bumpers; an infinite gap without one.
API int cs_leader(uint32_t number, double reach, double* gap, double* speed) {
    return guard([&] {
        const std::string& id = vehicle(number).id;
        const auto leader = sim::Vehicle::getLeader(id, reach);
        *gap = INFINITY, *speed = 0.;
        if (leader.first.empty()) return;
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
        route_edges.clear();
        for (const std::string& edge : v.path) route_edges += (route_edges.empty() ? "" : " ") + edge;
        *edges = route_edges.c_str();
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
