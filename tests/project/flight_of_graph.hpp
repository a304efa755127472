// For tests of graphs: flies one in the simulated world, for as long as a test says.
#pragma once

#include <cstdint>
#include <optional>

#include "flight.hpp"
#include "stator/port.hpp"
#include "stator/virtual.hpp"
#include "topics.hpp"
#include "world/vehicle_text.hpp"
#include "world_vehicle.hpp"

namespace stator::testing {

// A graph starts once in a process, and ctest runs each test in a process of its own.
class FlightOfGraph {
  public:
    // By default seed 1: take-off, hover, landing in calm air.
    explicit FlightOfGraph(const world::Conditions& conditions = {}) {
        board::prepare(conditions, world::vehicle_of(board::kWorldVehicle), nullptr, nullptr);
        start();
    }

    void run_for(std::uint64_t duration_us) {
        end_us_ += duration_us;
        run_until(end_us_);
    }
    const world::World& world() const { return board::world(); }
    // The newest sample of a topic: `newest<Tilt>(topics::tilt)`. None before the first one.
    template <class Message>
    std::optional<Message> newest(const Topic& topic) const {
        require(topic.sample_bytes == sizeof(Message), "newest: another message than the topic's");
        std::uint32_t seen = 0;
        Input<Message> input;
        input.take_latest(topic, seen, end_us_);
        return input ? std::optional<Message>(*input) : std::nullopt;
    }

  private:
    std::uint64_t end_us_ = 0;
};

}  // namespace stator::testing
