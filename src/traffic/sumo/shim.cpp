// C interface over libsumo. Vehicles and lanes have numbers here; their names are passed once. Every function returns 0, or 1 with a
// message in cs_error(); no exception leaves this file. Metres, m/s, compass degrees. Used by one thread at a time
// (src/traffic/sumo/shim.rs).
#include "shim.h"

#include <cmath>

using shim::guard;
using shim::strings;

namespace {

// Version and structure sizes of the interface, which both sides must share before any other call. The number is raised with every
// change of a function or of a structure here and in network_shim.cpp; the sizes are those of this file. Same layout as `Interface` in
// shim.rs.
struct Interface {
    uint32_t number, command_bytes, record_bytes, vehicle_type_bytes;
};
constexpr uint32_t INTERFACE = 5;

// Same layout as `Command`, `Record` and `VehicleType` in shim.rs.
struct Command {
    uint32_t car, kind;
    double a, b, c;
};
struct Record {
    double speed, lane_pos;
    int32_t lane;      // index in the table of lanes, -1: on none of them
    uint32_t present;  // 0: the vehicle is no longer in the simulation
};
struct VehicleType {
    double length, width, accel, decel, emergency_decel, time_gap, min_gap, max_speed;
};
enum Kind : uint32_t { MOVE_TO_XY = 0, PREVIOUS_SPEED = 1, SPEED = 2, SPEED_MODE = 3, MAX_SPEED = 4 };
struct Car {
    std::string id;
    int32_t lane;        // last known lane
    double lane_pos;     // last known position on the lane
    bool is_moved;       // was placed by a command, now or before: did not move by speed times step
    bool is_read_anew;   // last position is unknown
};

thread_local std::string answer;
std::vector<Car> cars;
std::vector<std::string> lanes;
std::vector<double> lane_lengths;  // 0: not known
// True while SUMO's sum of position and distance equals ours to the bit. A compiler that fuses one of the two sums may change it.
bool is_sum_exact = true;
size_t next_to_check = 0;

int32_t lane_number(const std::string& id, int32_t guess) {
    const auto n = static_cast<int32_t>(lanes.size());
    for (int32_t k = 0; k < n; k++) {
        const int32_t i = (guess < 0 ? k : guess + k) % n;
        if (lanes[i] == id) return i;
    }
    return -1;
}

void obey(const Command& c) {
    Car& car = cars.at(c.car);
    const std::string& id = car.id;
    switch (c.kind) {
        case MOVE_TO_XY:
            car.is_moved = true;
            sim::Vehicle::moveToXY(id, "", -1, c.a, c.b, c.c, 2, 20.);
            break;
        case PREVIOUS_SPEED: sim::Vehicle::setPreviousSpeed(id, c.a); break;
        case SPEED: sim::Vehicle::setSpeed(id, c.a); break;
        case SPEED_MODE: sim::Vehicle::setSpeedMode(id, static_cast<int>(c.a)); break;
        case MAX_SPEED: sim::Vehicle::setMaxSpeed(id, c.a); break;
        default: throw std::invalid_argument("unknown command");
    }
}

void read_anew() {
    for (Car& car : cars) car.is_read_anew = true;
}

// In process, a getter costs 25 ns (a look-up by name), and a subscription copies maps. SUMO moves a vehicle by speed times step
// (MSVehicle::updateState). The position of a vehicle that stays on its lane by this sum is therefore computed, not read, except for one
// vehicle per step, in turn. A vehicle read at the computed position is still on its last lane, so its lane is not read.
void read(Record* out, double step_s) {
    constexpr double NEAR_END = 1e-3, SAME = 1e-6;
    const size_t checked = cars.empty() ? 0 : next_to_check++ % cars.size();
    for (size_t i = 0; i < cars.size(); i++) {
        Car& car = cars[i];
        const double speed = sim::Vehicle::getSpeed(car.id);
        double pos = car.lane_pos + speed * step_s;
        const bool is_followed = is_sum_exact && !car.is_moved && !car.is_read_anew && car.lane >= 0 &&
                                 pos < lane_lengths[car.lane] - NEAR_END;
        if (!is_followed || i == checked) {
            const double found = sim::Vehicle::getLanePosition(car.id);
            if (car.is_read_anew || std::abs(found - pos) > SAME) car.lane = lane_number(sim::Vehicle::getLaneID(car.id), car.lane);
            if (is_followed && found != pos) is_sum_exact = false;
            pos = found;
        }
        car.lane_pos = pos;
        car.is_read_anew = false;
        out[i] = Record{speed, pos, car.lane, 1};
    }
}

}  // namespace

API void cs_interface(Interface* out) { *out = {INTERFACE, sizeof(Command), sizeof(Record), sizeof(VehicleType)}; }

API const char* cs_error() { return shim::error_text.c_str(); }

// Starts a simulation with the options of the command line; argv[0] is ignored.
API int cs_start(const char* const* argv, size_t n) {
    return guard([&] {
        cars.clear();
        is_sum_exact = true;
        next_to_check = 0;
        sim::Simulation::start(strings(argv, n));
    });
}

API int cs_close() {
    return guard([] {
        cars.clear();
        lanes.clear();
        sim::Simulation::close();
    });
}

API int cs_version(const char** value) {
    return guard([&] {
        answer = sim::Simulation::getVersion().second;
        *value = answer.c_str();
    });
}

API int cs_lanes(const char* const* ids, size_t n) {
    return guard([&] {
        lanes = strings(ids, n);
        lane_lengths.assign(n, 0.);
    });
}

API int cs_lane(size_t lane, double* length, double* speed) {
    return guard([&] {
        *length = lane_lengths.at(lane) = sim::Lane::getLength(lanes.at(lane));
        *speed = sim::Lane::getMaxSpeed(lanes.at(lane));
    });
}

// Closes lanes to passenger cars in this simulation: where a lane leads to several lanes, SUMO's vehicles choose one themselves.
API int cs_close_lanes(const char* const* ids, size_t n) {
    return guard([&] {
        const std::vector<std::string> classes = {"passenger"};
        for (const std::string& id : strings(ids, n)) sim::Lane::setDisallowed(id, classes);
    });
}

API int cs_type(const char* base, const char* name, const VehicleType* v) {
    return guard([&] {
        using Type = sim::VehicleType;
        // SUMO's IDM computes sqrt(accel decel) at its creation, and the setters do not update that number. A copy of the finished
        // draft is created from the new values. (Test: cars_of_other_parameters_move_alike_in_both_engines.)
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

API int cs_route(const char* id, const char* const* edges, size_t n) {
    return guard([&] { sim::Route::add(id, strings(edges, n)); });
}

// Puts a vehicle on the road at once, without SUMO's insertion checks.
API int cs_add(const char* id, const char* route, const char* type, size_t lane, double pos, double speed) {
    return guard([&] {
        // Departs on the first lane that cars may use, until it is moved: the outermost lane may be a pavement.
        sim::Vehicle::add(id, route, type, "now", "first", "0", "0");
        sim::Vehicle::moveTo(id, lanes.at(lane), pos);
        sim::Vehicle::setPreviousSpeed(id, speed, 0.);
        sim::Vehicle::setLaneChangeMode(id, 0);
        cars.push_back(Car{id, static_cast<int32_t>(lane), pos, false, true});
    });
}

// Executes the commands and one step, and reads all vehicles in the order in which they were added.
API int cs_frame(const Command* commands, size_t n, double step_s, Record* out) {
    return guard([&] {
        for (size_t i = 0; i < n; i++) obey(commands[i]);
        sim::Simulation::step();
        read(out, step_s);
    });
}

// Runs a step without commands and without reading, as a reference for measurements.
API int cs_bare_step() {
    return guard([] {
        read_anew();
        sim::Simulation::step();
    });
}

// Reads all vehicles without a step.
API int cs_read(Record* out) {
    return guard([&] {
        read_anew();
        read(out, 0.);
    });
}

// Returns the pose at which SUMO draws a vehicle: front bumper and compass degrees.
API int cs_pose(uint32_t car, double* x, double* y, double* angle_deg) {
    return guard([&] {
        const auto p = sim::Vehicle::getPosition(cars.at(car).id);
        *x = p.x;
        *y = p.y;
        *angle_deg = sim::Vehicle::getAngle(cars.at(car).id);
    });
}
