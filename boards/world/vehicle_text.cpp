// The vehicle of a flight as text.
#include "world/vehicle_text.hpp"

#include <array>
#include <charconv>
#include <cstdlib>
#include <optional>

namespace stator::world {

namespace {

constexpr unsigned kMostValues = 16;
using Values = std::array<double, kMostValues>;

struct Line {
    std::string_view key;
    Values values{};
    unsigned count = 0;
};

std::optional<Line> split(std::string_view text) {
    Line line{.key = text.substr(0, text.find(' '))};
    text.remove_prefix(line.key.size());
    while (!text.empty()) {
        text.remove_prefix(1);
        if (line.count == kMostValues) return {};
        const char* const end = text.data() + text.size();
        const auto read = std::from_chars(text.data(), end, line.values[line.count++]);
        if (read.ec != std::errc{} || (read.ptr != end && *read.ptr != ' ')) return {};
        text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
    }
    return line;
}

Vector3 point(const Line& line) {
    return {line.values[0], line.values[1], line.values[2]};
}

Lateral lateral(const Values& v) {
    return {.beta = v[0], .roll_rate = v[1], .yaw_rate = v[2]};
}

Surface surface(const Values& v) {
    return {.least = v[0],
            .most = v[1],
            .rate = v[2],
            .time_constant = v[3],
            .lift = v[4],
            .drag = v[5],
            .drag2 = v[6],
            .side = v[7],
            .roll = v[8],
            .pitch = v[9],
            .yaw = v[10],
            .fades = {v[11], v[12], v[13]}};
}

Propeller propeller(const Line& line) {
    const Values& v = line.values;
    const auto turned = math::sincos(v[3]);
    const auto raised = math::sincos(v[4]);
    return {.place_B = point(line),
            .axis_B = Vector3(turned.cos * raised.cos, turned.sin * raised.cos, -raised.sin),
            .turns_cw = v[5],
            .diameter = v[6],
            .inertia = v[7],
            .most_advance = v[8],
            .efficiency = v[9]};
}

Wheel wheel(const Line& line) {
    const Values& v = line.values;
    return {.place_B = point(line),
            .stiffness = v[3],
            .damping = v[4],
            .rolling = v[5],
            .brake = v[6],
            .steered_by = math::saturate<int>(v[7]),
            .steering = v[8]};
}

// Of the propeller that came last.
bool take_polynomial(const Line& line, std::vector<Propeller>& propellers) {
    if (propellers.empty() || line.count == 0) return false;
    const std::vector<double> values(line.values.begin(), line.values.begin() + line.count);
    if (line.key == "propeller_thrust") {
        propellers.back().thrust = values;
    } else if (line.key == "propeller_power") {
        propellers.back().power = values;
    } else if (line.key == "shaft_power") {
        propellers.back().shaft_power = values;
    } else {
        return false;
    }
    return true;
}

bool take_derivatives(const Line& line, Wing& wing) {
    const Values& v = line.values;
    if (line.key == "wing_drag" && line.count == 7) {
        wing.drag_zero = v[0];
        wing.drag_alpha = v[1];
        wing.drag_alpha2 = v[2];
        wing.drag_beta = v[3];
        wing.drag_beta2 = v[4];
        wing.drag_lift2 = v[5];
        wing.drag_least_lift = v[6];
        return true;
    }
    if (line.count != 3) return false;
    if (line.key == "wing_lift") {
        wing.lift_zero = v[0];
        wing.lift_alpha = v[1];
        wing.lift_pitch_rate = v[2];
    } else if (line.key == "wing_pitch") {
        wing.pitch_zero = v[0];
        wing.pitch_alpha = v[1];
        wing.pitch_pitch_rate = v[2];
    } else if (line.key == "wing_side") {
        wing.side = lateral(v);
    } else if (line.key == "wing_roll") {
        wing.roll = lateral(v);
    } else if (line.key == "wing_yaw") {
        wing.yaw = lateral(v);
    } else if (line.key == "roll_damping") {
        wing.roll_damping = {v[0], v[1], v[2]};
    } else {
        return false;
    }
    return true;
}

bool take_wing(const Line& line, Wing& wing) {
    const Values& v = line.values;
    if (line.key == "wing" && line.count == 6) {
        wing.area = v[0];
        wing.span = v[1];
        wing.chord = v[2];
        wing.reference_B = Vector3(v[3], v[4], v[5]);
    } else if (line.key == "stall" && line.count == 2) {
        wing.stall_begins = v[0];
        wing.stall_blend = v[1];
    } else if (line.key == "stall_point" && line.count == 4) {
        wing.curve.push_back({.alpha = v[0], .lift = v[1], .drag = v[2], .pitch = v[3]});
    } else if (line.key == "surface" && line.count == 14 && wing.surfaces.size() < kMaxSurfaces) {
        wing.surfaces.push_back(surface(v));
    } else {
        return take_derivatives(line, wing);
    }
    return true;
}

struct Number {
    std::string_view key;
    double* place;
};

bool take_number(const Line& line, Vehicle& vehicle) {
    Airframe& body = vehicle.airframe;
    const std::array numbers{Number{"mass", &body.mass},
                             Number{"thrust_per_speed2", &body.thrust_per_speed2},
                             Number{"torque_per_thrust", &body.torque_per_thrust},
                             Number{"max_speed", &body.most_rotor_speed},
                             Number{"rise_time", &body.rise_time_constant},
                             Number{"fall_time", &body.fall_time_constant},
                             Number{"disc_area", &body.disc_area},
                             Number{"efficiency", &body.power_efficiency},
                             Number{"inflow_pitch", &body.inflow_pitch},
                             Number{"drag", &body.rotor_drag},
                             Number{"rolling_moment", &body.rolling_moment},
                             Number{"stiffness", &body.ground.stiffness},
                             Number{"damping", &body.ground.damping},
                             Number{"friction", &body.ground.friction},
                             Number{"nominal_voltage", &body.nominal_voltage},
                             Number{"avionics_power", &body.avionics_power},
                             Number{"cells", &vehicle.battery.cells},
                             Number{"capacity", &vehicle.battery.capacity_c},
                             Number{"resistance", &vehicle.battery.resistance}};
    for (const Number& number : numbers) {
        if (number.key != line.key || line.count != 1) continue;
        *number.place = line.values[0];
        return true;
    }
    return false;
}

bool take(const Line& line, Vehicle& vehicle) {
    Airframe& body = vehicle.airframe;
    GroundParameters& ground = body.ground;
    const Values& v = line.values;
    if (line.key == "inertia" && line.count == 4) {
        body.inertia = {.xx = v[0], .yy = v[1], .zz = v[2], .xz = v[3]};
    } else if (line.key == "drag_area" && line.count == 3) {
        body.drag_area_B = point(line);
    } else if (line.key == "rotor" && line.count == 5 && body.rotors.size() < kMaxRotors) {
        body.rotors.push_back({.place_B = point(line), .turns_ccw = v[3], .in_wake = v[4]});
    } else if ((line.key == "foot" || line.key == "hull") && line.count == 3 &&
               ground.points_B.size() < kMaxContactPoints) {
        ground.points_B.push_back(point(line));
        ground.feet += line.key == "foot" ? 1 : 0;
    } else if (line.key == "wheel" && line.count == 9 && ground.wheels.size() < kMaxWheels) {
        ground.wheels.push_back(wheel(line));
    } else if (line.key == "propeller" && line.count == 10 &&
               body.propellers.size() < kMaxPropellers) {
        body.propellers.push_back(propeller(line));
    } else {
        return take_wing(line, body.wing) || take_polynomial(line, body.propellers) ||
               take_number(line, vehicle);
    }
    return true;
}

}  // namespace

std::string read_vehicle(std::string_view text, Vehicle& vehicle) {
    while (!text.empty()) {
        const std::string_view row = text.substr(0, text.find('\n'));
        text.remove_prefix(row.size() == text.size() ? row.size() : row.size() + 1);
        const auto line = split(row);
        if (!line || !take(*line, vehicle)) {
            return "expected a key of a vehicle and its numbers, found '" + std::string(row) + "'";
        }
    }
    const Airframe& body = vehicle.airframe;
    const bool is_lifted = body.has_wing() || !body.rotors.empty();
    const bool stands = body.ground.feet + body.ground.wheels.size() != 0;
    if (!(body.mass > 0.0) || !is_lifted || !stands) {
        return "expected a mass, rotors or a wing, and feet or wheels, found a vehicle without";
    }
    for (const Propeller& each : body.propellers) {
        if (each.thrust.empty() || each.power.empty() || each.shaft_power.empty()) {
            return "expected the curves of a propeller, found one without";
        }
    }
    if (body.has_wing() && body.wing.curve.size() < 2) {
        return "expected the curve of a stalled wing, found a wing without";
    }
    return "";
}

Vehicle vehicle_of(std::string_view text) {
    Vehicle vehicle;
    const std::string wrong = read_vehicle(text, vehicle);
    if (!wrong.empty()) std::abort();
    return vehicle;
}

}  // namespace stator::world
