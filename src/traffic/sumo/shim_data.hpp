// Data that pass between shim.cpp and this program, in the layout of shim_data.rs. In: commands and settings. Out: columns of what a step has
// changed. Metres, m/s, compass degrees.
#pragma once

#include <cstddef>
#include <cstdint>

namespace {

// What both sides have to agree on before anything else is called: the number of this interface, raised with every change of a function or
// of a structure here, and the sizes of those. Same layout as `Interface` in shim.rs.
struct Interface {
    uint32_t number, command_bytes, record_bytes, departure_bytes, vehicle_type_bytes;
};
constexpr uint32_t INTERFACE = 13;

// Same layout as in shim_data.rs.
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

}  // namespace
