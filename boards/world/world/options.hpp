// The command line of a simulated flight.
#pragma once

#include <array>
#include <cstdint>

#include "world/conditions.hpp"
#include "world/variation.hpp"

namespace stator::world {

struct Options {
    const char* log = nullptr;                // file for the flight log; none: no log
    const char* truth = nullptr;              // file for the true flight; none: no truth
    const char* mission = nullptr;            // file of the mission device; none: it is empty
    std::uint64_t duration_us = 120'000'000;  // at most
    double speed = 0.0;  // at most so many times real time; 0: as fast as it goes
    // Where MAVLink goes, of each line; a flight with one has a pilot who leaves all alone, and no
    // end of its own.
    std::array<const char*, 2> mavlink{};
    unsigned mavlink_count = 0;
    const char* signing_key = nullptr;  // file with the key of these lines; none: no key yet
    const char* hil = nullptr;  // the other side of a link with HIL messages; none: no such link
    // Socket of a program that says when the flight goes on; none: it goes on by itself.
    const char* lockstep = nullptr;
    bool random_times = false;
    const char* budgets = nullptr;  // TASK=MICROSECONDS, with commas; none: activations take none
    Conditions conditions{};
    Vehicle vehicle{};  // `--vehicle` replaces it
};

// False after one line on the standard error output that says what is wrong.
[[nodiscard]] bool parse(int count, const char* const* arguments, Options& options);

}  // namespace stator::world
