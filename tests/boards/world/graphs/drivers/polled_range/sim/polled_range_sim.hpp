// The range finder of a simulated board that has no line: publishes what it says when asked.
#pragma once

#include "polled_range_ports.hpp"
#include "polled_range_sim_sample.hpp"
#include "stator/newest.hpp"

namespace stator::drivers::polled_range::sim {

class PolledRangeSim {
  public:
    // What it says now, which the board writes.
    using Device = Newest<PolledRangeSimSample>;

    explicit PolledRangeSim(Device& device) : device_(device) {}
    void step(PolledRangePorts& ports) {
        const float distance = device_.get().value.distance;
        ports.distance.publish([&] { return DistanceSensor{.current_distance = distance}; });
    }

  private:
    Device& device_;
};

}  // namespace stator::drivers::polled_range::sim
