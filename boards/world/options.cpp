// The command line of a simulated flight.
#include "world/options.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

#include "stator/scalar.hpp"
#include "world/vehicle_text.hpp"

namespace stator::world {

namespace {

constexpr double kLongest_s = 1e6;  // 11 days
constexpr double kFastest = 1e4;
constexpr double kStrongest = 50.0;  // m/s, a wind in which nothing flies

bool refuse(const char* option, const char* value, const char* expected) {
    std::fprintf(stderr, "error: %s: expected %s, found '%s'\n", option, expected, value);
    return false;
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && end == text.data() + text.size();
}

bool read_duration(const char* text, std::uint64_t& duration_us) {
    double seconds = 0.0;
    if (!read_number(text, seconds) || !(seconds > 0.0 && seconds <= kLongest_s)) {
        return refuse("--duration", text, "seconds above 0 and up to 1000000");
    }
    duration_us = math::saturate<std::uint64_t>(math::round(seconds * 1e6));
    return true;
}

bool read_speed(const char* text, double& speed) {
    if (read_number(text, speed) && speed > 0.0 && speed <= kFastest) return true;
    return refuse("--speed", text, "a factor above 0 and up to 10000");
}

bool read_times(const char* text, bool& random_times) {
    const std::string_view value = text;
    if (value != "zero" && value != "random") {
        return refuse("--times", text, "zero or random");
    }
    random_times = value == "random";
    return true;
}

bool read_path(const char* option, const char* value, const char*& path) {
    path = value;
    return *value != '\0' || refuse(option, value, "a path");
}

bool add_mavlink(const char* place, Options& options) {
    if (options.mavlink_count == options.mavlink.size()) {
        return refuse("--mavlink", place, "at most 2 lines");
    }
    options.mavlink[options.mavlink_count++] = place;
    options.conditions.is_endless = true;
    return true;
}

// Empty, or what is wrong.
std::string read_file(const char* path, std::string& text) {
    std::FILE* const file = std::fopen(path, "rb");
    if (file == nullptr) return std::strerror(errno);
    std::array<char, 4096> part;
    std::size_t size = 0;
    while ((size = std::fread(part.data(), 1, part.size(), file)) != 0) {
        text.append(part.data(), size);
    }
    const bool is_read = std::ferror(file) == 0;
    std::fclose(file);
    return is_read ? "" : "cannot read the file";
}

// `follow`: takes the text; empty, or what is wrong with it.
template <class Follow>
bool read_text(const char* option, const char* path, Follow follow) {
    std::string text;
    std::string wrong = read_file(path, text);
    if (wrong.empty()) wrong = follow(text);
    if (wrong.empty()) return true;
    std::fprintf(stderr, "error: %s '%s': %s\n", option, path, wrong.c_str());
    return false;
}

bool read_pilot(const char* path, Pilot& pilot) {
    return read_text("--pilot", path, [&](const std::string& text) { return pilot.follow(text); });
}

bool read_vehicle_file(const char* path, Vehicle& vehicle) {
    vehicle = {};
    return read_text("--vehicle", path,
                     [&](const std::string& text) { return read_vehicle(text, vehicle); });
}

bool add_fault(const char* text, Faults& faults) {
    if (const auto fault = read_fault(text)) {
        if (faults.add(*fault)) return true;
        return refuse("--fail", text, "at most 16 failures");
    }
    std::fprintf(stderr,
                 "error: --fail: expected WHAT@SECONDS or WHAT@SECONDS+SECONDS, found '%s'\n"
                 "hint: WHAT is one of %s\n",
                 text, kFaultNames);
    return false;
}

bool read_vary(const char* text, bool& vary) {
    const std::string_view value = text;
    if (value != "no" && value != "yes") return refuse("--vary", text, "no or yes");
    vary = value == "yes";
    return true;
}

bool read_wind(const char* text, double& speed) {
    return (read_number(text, speed) && speed >= 0.0 && speed <= kStrongest) ||
           refuse("--wind", text, "m/s from 0 to 50");
}

bool read_direction(const char* text, double& from) {
    double degrees = 0.0;
    if (!read_number(text, degrees) || !(degrees >= -360.0 && degrees <= 360.0)) {
        return refuse("--wind-from", text, "degrees from -360 to 360");
    }
    from = degrees * (math::kPi<double> / 180.0);
    return true;
}

// LATITUDE,LONGITUDE or LATITUDE,LONGITUDE,HEIGHT in degrees and metres above mean sea level.
bool read_origin(const char* text, Earth& earth) {
    constexpr double kLowest = -500.0;  // m; below the Dead Sea
    constexpr double kHighest = 9000.0;
    const std::string_view all = text;
    const std::size_t first = all.find(',');
    const std::size_t second = all.find(',', first == all.npos ? all.npos : first + 1);
    bool is_good = first != all.npos && read_number(all.substr(0, first), earth.latitude_deg) &&
                   read_number(all.substr(first + 1, second - first - 1), earth.longitude_deg);
    if (is_good && second != all.npos) {
        is_good = read_number(all.substr(second + 1), earth.altitude_msl);
    }
    is_good = is_good && math::abs(earth.latitude_deg) < 90.0 &&
              math::abs(earth.longitude_deg) <= 180.0 && earth.altitude_msl >= kLowest &&
              earth.altitude_msl <= kHighest;
    return is_good || refuse("--origin", text, "LATITUDE,LONGITUDE or LATITUDE,LONGITUDE,HEIGHT");
}

bool read_gusts(const char* text, Gusts& gusts) {
    constexpr std::array<std::string_view, 4> kNames{"none", "light", "moderate", "severe"};
    const auto* const found = std::find(kNames.begin(), kNames.end(), text);
    if (found == kNames.end()) {
        return refuse("--gusts", text, "none, light, moderate or severe");
    }
    gusts = static_cast<Gusts>(found - kNames.begin());
    return true;
}

bool read_launch(const char* text, Launch& launch) {
    constexpr std::array<std::string_view, 3> kNames{"ground", "catapult", "hand"};
    const auto* const found = std::find(kNames.begin(), kNames.end(), text);
    if (found == kNames.end()) return refuse("--launch", text, "ground, catapult or hand");
    launch = static_cast<Launch>(found - kNames.begin());
    return true;
}

bool read_value(std::string_view option, const char* value, Options& options) {
    if (option == "--log") return read_path("--log", value, options.log);
    if (option == "--truth") return read_path("--truth", value, options.truth);
    if (option == "--mission") return read_path("--mission", value, options.mission);
    if (option == "--mavlink") return add_mavlink(value, options);
    if (option == "--signing-key") return read_path("--signing-key", value, options.signing_key);
    if (option == "--lockstep") return read_path("--lockstep", value, options.lockstep);
    if (option == "--hil") return read_path("--hil", value, options.hil);
    if (option == "--speed") return read_speed(value, options.speed);
    if (option == "--pilot") return read_pilot(value, options.conditions.pilot);
    if (option == "--vehicle") return read_vehicle_file(value, options.vehicle);
    if (option == "--seed") {
        return read_number(value, options.conditions.seed) ||
               refuse("--seed", value, "a whole number from 0 to 18446744073709551615");
    }
    if (option == "--duration") return read_duration(value, options.duration_us);
    if (option == "--times") return read_times(value, options.random_times);
    if (option == "--budgets") return read_path("--budgets", value, options.budgets);
    if (option == "--vary") return read_vary(value, options.conditions.vary);
    if (option == "--wind") return read_wind(value, options.conditions.wind.speed);
    if (option == "--wind-from") return read_direction(value, options.conditions.wind.from);
    if (option == "--origin") return read_origin(value, options.conditions.earth);
    if (option == "--gusts") return read_gusts(value, options.conditions.wind.gusts);
    if (option == "--launch") return read_launch(value, options.conditions.launch);
    if (option == "--fail") return add_fault(value, options.conditions.faults);
    std::fprintf(stderr,
                 "error: unknown option '%s'\nhint: known: --log FILE, --truth FILE, --seed N, "
                 "--duration SECONDS, --times zero|random, --budgets TASK=US,..., --vary no|yes, "
                 "--wind M_S, "
                 "--wind-from DEGREES, --gusts none|light|moderate|severe, --launch "
                 "ground|catapult|hand, --fail WHAT@SECONDS, "
                 "--pilot FILE, --vehicle FILE, --mission FILE, --origin "
                 "LATITUDE,LONGITUDE[,HEIGHT], --speed FACTOR, "
                 "--mavlink PLACE, --signing-key FILE, --hil PLACE, --lockstep SOCKET\n",
                 option.data());
    return false;
}

}  // namespace

bool parse(int count, const char* const* arguments, Options& options) {
    bool has_pilot = false;
    for (int i = 1; i < count; i += 2) {
        // The element behind the last argument is a null pointer.
        const char* const value = i + 1 < count ? arguments[i + 1] : "";
        if (!read_value(arguments[i], value, options)) return false;
        has_pilot = has_pilot || arguments[i] == std::string_view("--pilot");
    }
    if (options.mavlink_count != 0 && !has_pilot) options.conditions.pilot.leave_alone();
    return true;
}

}  // namespace stator::world
