// What shim.cpp knows of a simulation from step to step. In: commands for vehicles. Out: the columns of a step: who has come and gone, where
// they are, what signals show. Metres, m/s, compass degrees.
#pragma once

#include "shim_data.hpp"

#include <libsumo/libsumo.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

namespace sim = libsumo;

namespace {

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
    int lane_changes = -1;          // its lane change mode before an event of the scenario moved it; -1 while none does
};
struct Birth {
    std::string id, kind, type;
};

thread_local std::string answer;
Reading reading;
std::vector<Lane> lanes;
std::unordered_map<std::string, int32_t> lane_numbers;
std::vector<std::string> signals;
std::vector<std::string> programmes;  // of each signal, from the start
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
        // A negative speed ends the order.
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
    programmes.clear();
    is_sum_exact = true;
    next_to_check = 0;
}

}  // namespace
