// What a flight program says of the flight when it is over.
#include "world/flight_facts.hpp"

#include <cstdio>

namespace stator::world {

namespace {

double seconds(std::uint64_t time_us) {
    return static_cast<double>(time_us) * 1e-6;
}

const char* ending(const World& world, bool restarts) {
    if (restarts) return "restart";
    return world.is_over() ? "motors_stopped" : "time_limit";
}

}  // namespace

void print_flight_facts(std::FILE* out, const World& world, double wall_s, bool restarts) {
    std::fprintf(out, "\"ended\": \"%s\", \"simulated_s\": %0.6F, \"wall_s\": %0.6F",
                 ending(world, restarts), seconds(world.plant().time_us()), wall_s);
    if (const auto take_off_us = world.watch().take_off_us()) {
        std::fprintf(out, ", \"take_off_s\": %0.6F", seconds(*take_off_us));
    }
    if (const auto touchdown = world.watch().touchdown()) {
        std::fprintf(out, ", \"touchdown_s\": %0.6F, \"touchdown_m_s\": %0.6F",
                     seconds(touchdown->time_us), touchdown->speed);
    }
}

}  // namespace stator::world
