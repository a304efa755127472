// Arguments of a run in real time.
#include "run_options.hpp"

#include <charconv>
#include <cstdio>
#include <string_view>
#include <system_error>

namespace stator::board {

namespace {

bool refuse(std::string_view name, std::string_view value, const char* expected) {
    std::fprintf(stderr, "error: %.*s: expected %s, found '%.*s'\n", static_cast<int>(name.size()),
                 name.data(), expected, static_cast<int>(value.size()), value.data());
    return false;
}

bool take_speed(std::string_view value, double& speed) {
    const char* const end = value.data() + value.size();
    const auto [stop, error] = std::from_chars(value.data(), end, speed);
    return (error == std::errc{} && stop == end && speed > 0.0 && speed <= 1.0) ||
           refuse("--speed", value, "a factor above 0 and up to 1 (real time)");
}

bool take_cpus(std::string_view value, uint64_t& cpus) {
    const char* const end = value.data() + value.size();
    const auto [stop, error] = std::from_chars(value.data(), end, cpus, 16);
    return (error == std::errc{} && stop == end && cpus != 0) ||
           refuse("--cpus", value, "a mask of processors, for example 3 for the first two");
}

}  // namespace

bool take_run_options(int& count, char** arguments, RunOptions& options) {
    int kept = 1;
    for (int i = 1; i < count; i += 2) {
        const std::string_view name = arguments[i];
        const char* const value = i + 1 < count ? arguments[i + 1] : "";
        bool is_valid = true;
        if (name == "--can") {
            options.can_interface = value;
        } else if (name == "--can-parts") {
            options.can_parts = value;
        } else if (name == "--nonvolatile") {
            options.nonvolatile = value;
        } else if (name == "--link") {
            options.link = value;
        } else if (name == "--speed") {
            is_valid = take_speed(value, options.settings.speed);
        } else if (name == "--cpus") {
            is_valid = take_cpus(value, options.settings.cpus);
        } else {
            arguments[kept++] = arguments[i];
            if (i + 1 < count) arguments[kept++] = arguments[i + 1];
        }
        if (!is_valid) return false;
    }
    count = kept;
    return true;
}

}  // namespace stator::board
