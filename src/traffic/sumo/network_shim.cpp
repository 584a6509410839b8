// C interface over libsumo for roads that vehicles enter and leave. Lanes, signals and vehicles have numbers here; a vehicle gets its
// number when it departs, and no number is used twice. One call makes a step and reads everything into columns that are valid until the
// next call. As in shim.cpp, every function returns 0, or 1 with a message in cs_error(). Metres, m/s, compass degrees.
#include "shim.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

using shim::guard;
using shim::strings;

namespace {

// Same layout as in network_shim.rs.
struct Command {
    uint32_t vehicle, kind;
    int32_t lane;  // lane to move to, because SUMO's own choice may be a crossing lane; -1: SUMO's choice
    double a, b, c;
};
struct Record {
    double x, y, z;  // front bumper
    double angle_deg, speed, lane_pos, lateral;
    uint32_t number;
    int32_t lane;  // -1: on none of them
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
    const char* signals;            // states of all signals in sequence
    const uint32_t* signal_starts;  // start of each signal, with the total length as the last entry
    size_t record_count, departure_count, arrival_count, signal_count;
};
enum Kind : uint32_t { MOVE_TO_XY = 0, PREVIOUS_SPEED = 1, SPEED = 2, SPEED_MODE = 3, MAX_SPEED = 4, LAMPS = 5, LANE_CHANGES = 6 };

struct Lane {
    std::string id, edge;
    int index;
    double length;  // 0: unknown
};
struct Mobile {
    std::string id;
    Record last;    // last state read
    bool is_known;  // `last` is the state after the step before
    bool is_ego;    // externally driven
    std::vector<std::string> path;  // of an ego: ids of the edges of the expected route
    size_t path_at;                 // index in `path` of the last known edge
};
struct Birth {
    std::string id, kind, type;
};

std::vector<Lane> lanes;
std::unordered_map<std::string, int32_t> lane_numbers;
std::vector<std::string> signals;
// By ascending number: a vehicle that departs later has a higher number.
std::vector<Mobile> vehicles;
std::unordered_map<std::string, uint32_t> numbers;
uint32_t next_number = 0;
bool changes_take_time = false;
// True while SUMO's sum of position and distance equals ours to the bit, as in shim.cpp.
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

// Restores the route of an ego. moveToXY gives a vehicle that it finds on another lane, as where lanes cross inside a junction, a route of
// one or two edges. Other vehicles would not give way to it at the next junction. The new route has the present edges and the rest of the
// path.
void restore_path(Mobile& v) {
    const std::vector<std::string> route = sim::Vehicle::getRoute(v.id);
    const int index = sim::Vehicle::getRouteIndex(v.id);
    if (v.path.empty() || index < 0 || static_cast<size_t>(index) >= route.size()) return;
    if (route.back() == v.path.back()) {
        v.path_at = v.path.size() - std::min(v.path.size(), route.size() - index);
        return;
    }
    const auto there = std::find(v.path.begin() + static_cast<std::ptrdiff_t>(v.path_at), v.path.end(), route.back());
    if (there == v.path.end()) return;  // the vehicle has left its path
    std::vector<std::string> edges(route.begin() + index, route.end());
    edges.insert(edges.end(), there + 1, v.path.end());
    try {
        sim::Vehicle::setRoute(v.id, edges);
    } catch (const sim::TraCIException&) {
        // SUMO refuses this inside some junctions; the next step tries again.
    }
}

void obey(const Command& c) {
    Mobile& v = vehicle(c.vehicle);
    const std::string& id = v.id;
    switch (c.kind) {
        case MOVE_TO_XY: {
            restore_path(v);
            const bool hinted = c.lane >= 0;
            const Lane none{"", "", -1, 0.};
            const Lane& lane = hinted ? lanes.at(c.lane) : none;
            sim::Vehicle::moveToXY(id, lane.edge, lane.index, c.a, c.b, c.c, 2, 20.);
            break;
        }
        case PREVIOUS_SPEED: sim::Vehicle::setPreviousSpeed(id, c.a); break;
        case SPEED: sim::Vehicle::setSpeed(id, c.a); break;
        case SPEED_MODE: sim::Vehicle::setSpeedMode(id, static_cast<int>(c.a)); break;
        case MAX_SPEED: sim::Vehicle::setMaxSpeed(id, c.a); break;
        case LAMPS: sim::Vehicle::setSignals(id, static_cast<int>(c.a)); break;
        case LANE_CHANGES: sim::Vehicle::setLaneChangeMode(id, static_cast<int>(c.a)); break;
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
    vehicles.push_back(Mobile{id, fresh(number), false, false, {}, 0});
    births.push_back(Birth{id, sim::Vehicle::getVehicleClass(id), sim::Vehicle::getTypeID(id)});
    departures.push_back(Departure{sim::Vehicle::getLength(id), sim::Vehicle::getWidth(id), sim::Vehicle::getHeight(id), number, nullptr,
                                   nullptr, nullptr});
}

// Reads all vehicles after a step with few getters: a getter costs a look-up by name, some 80 ns among a thousand vehicles. A stopped
// vehicle keeps its place. A vehicle that moved by speed times step is still on its lane. Only a vehicle that changes lanes, with an
// indicator lit, is off the centre line. The position of a vehicle that is not near the end of its lane is computed, not read, except for
// one vehicle per step, in turn.
void read(double step_s) {
    constexpr uint32_t INDICATORS = 7;
    constexpr double NEAR_END = 1e-3;
    const size_t checked = vehicles.empty() ? 0 : next_to_check++ % vehicles.size();
    records.clear();
    for (size_t i = 0; i < vehicles.size(); i++) {
        Mobile& v = vehicles[i];
        Record& r = v.last;
        const double speed = sim::Vehicle::getSpeed(v.id);
        const auto lamps = static_cast<uint32_t>(sim::Vehicle::getSignals(v.id));
        bool is_steady = v.is_known && !v.is_ego && ((lamps | r.lamps) & INDICATORS) == 0 && r.lateral == 0.;
        double pos = r.lane_pos + speed * step_s;
        const bool is_followed = is_steady && is_sum_exact && r.lane >= 0 && pos < lanes[r.lane].length - NEAR_END;
        if (!is_followed || i == checked) {
            const double found = sim::Vehicle::getLanePosition(v.id);
            if (is_followed && found != pos) is_sum_exact = false;
            is_steady = is_steady && std::abs(found - pos) < 1e-6;
            pos = found;
        }
        if (!is_steady || speed != 0.) {
            const auto place = sim::Vehicle::getPosition3D(v.id);
            if (place.x == sim::INVALID_DOUBLE_VALUE) {
                v.is_known = false;  // without a position: SUMO is moving it to another place
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
            r.lateral = changes_take_time || v.is_ego ? sim::Vehicle::getLateralLanePosition(v.id) : 0.;
        }
        r.speed = speed, r.lane_pos = pos, r.lamps = lamps;
        v.is_known = true;
        records.push_back(r);
    }
}

void look(double step_s) {
    births.clear();
    departures.clear();
    arrivals.clear();
    for (const std::string& id : sim::Simulation::getDepartedIDList()) depart(id);
    for (const std::string& id : sim::Simulation::getArrivedIDList()) {
        const auto found = numbers.find(id);
        if (found != numbers.end()) arrivals.push_back(found->second);
    }
    if (!arrivals.empty()) {
        std::sort(arrivals.begin(), arrivals.end());
        const auto is_over = [](const Mobile& v) { return std::binary_search(arrivals.begin(), arrivals.end(), v.last.number); };
        for (const Mobile& v : vehicles) {
            if (is_over(v)) numbers.erase(v.id);
        }
        vehicles.erase(std::remove_if(vehicles.begin(), vehicles.end(), is_over), vehicles.end());
    }
    for (size_t i = 0; i < births.size(); i++) {
        departures[i].id = births[i].id.c_str();
        departures[i].kind = births[i].kind.c_str();
        departures[i].type = births[i].type.c_str();
    }
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

}  // namespace

// Prepares a network; called after cs_start. `lateral`: lane changes take time, so that vehicles may be off the centre line. `first`:
// number of the first vehicle.
API int cs_network_begin(const char* const* lane_ids, size_t lane_count, const char* const* signal_ids, size_t signal_count, int lateral,
                         uint32_t first) {
    return guard([&] {
        vehicles.clear();
        numbers.clear();
        lanes.clear();
        lane_numbers.clear();
        next_number = first;
        next_to_check = 0;
        is_sum_exact = true;
        changes_take_time = lateral != 0;
        for (const std::string& id : strings(lane_ids, lane_count)) {
            const size_t mark = id.rfind('_');
            if (mark == std::string::npos) throw std::invalid_argument("lane '" + id + "' is of no edge");
            lane_numbers.emplace(id, static_cast<int32_t>(lanes.size()));
            lanes.push_back(Lane{id, id.substr(0, mark), std::stoi(id.substr(mark + 1)), length(id)});
        }
        signals = strings(signal_ids, signal_count);
    });
}

// Puts a vehicle on a lane at once, without SUMO's insertion checks. Its route must exist.
API int cs_network_add(const char* id, const char* route, const char* type, size_t lane, double pos, double speed, uint32_t* number) {
    return guard([&] {
        // Departs on the first lane that it may use: the outermost lane may be a pavement or a parking lane.
        sim::Vehicle::add(id, route, type, "now", "first", "0", "0");
        sim::Vehicle::moveTo(id, lanes.at(lane).id, pos);
        sim::Vehicle::setPreviousSpeed(id, speed, 0.);
        numbers.emplace(id, next_number);
        vehicles.push_back(Mobile{id, fresh(next_number), false, true, sim::Route::getEdges(route), 0});
        *number = next_number++;
    });
}

// Makes a vehicle of the demand externally driven. `edges`: ids of the edges of its route, separated by blanks, valid until the next call.
API int cs_network_take(uint32_t number, const char** edges) {
    return guard([&] {
        Mobile& v = vehicle(number);
        v.is_ego = true;
        v.path = sim::Vehicle::getRoute(v.id);
        v.path_at = 0;
        route_edges.clear();
        for (const std::string& edge : v.path) route_edges += (route_edges.empty() ? "" : " ") + edge;
        *edges = route_edges.c_str();
    });
}

// Executes the commands and one step, and returns the new state.
API int cs_network_step(const Command* commands, size_t n, double step_s, Step* out) {
    return guard([&] {
        for (size_t i = 0; i < n; i++) obey(commands[i]);
        sim::Simulation::step();
        look(step_s);
        tell(out);
    });
}

// Returns the present state, without a step.
API int cs_network_look(Step* out) {
    return guard([&] {
        for (Mobile& v : vehicles) v.is_known = false;
        look(0.);
        tell(out);
    });
}

// Removes all vehicles and signals at the end of the simulation.
API void cs_network_end() {
    vehicles.clear();
    numbers.clear();
    signals.clear();
}
