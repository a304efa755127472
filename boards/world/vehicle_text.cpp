// The vehicle of a flight as text.
#include "world/vehicle_text.hpp"

#include <array>
#include <charconv>
#include <cstdlib>
#include <optional>

namespace stator::world {

namespace {

constexpr unsigned kMostValues = 5;
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
    } else {
        return take_number(line, vehicle);
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
    if (!(body.mass > 0.0) || body.rotors.empty() || body.ground.feet == 0) {
        return "expected a mass, rotors and feet, found a vehicle without";
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
