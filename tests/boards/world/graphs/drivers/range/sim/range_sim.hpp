// The range finder of a simulated board: publishes what the board measured.
#pragma once

#include "range_ports.hpp"
#include "range_sim_sample.hpp"

namespace stator::drivers::range::sim {

class RangeSim {
  public:
    // The newest sample. The board writes it, then raises data_ready.
    using Device = RangeSimSample;

    explicit RangeSim(Device& device) : device_(device) {}
    void step(RangePorts& ports) {
        if (!ports.fired.data_ready) return;
        const Device sample = device_;
        ports.distance.publish([&] {
            return DistanceSensor{.timestamp_sample = sample.timestamp_sample,
                                  .current_distance = sample.distance};
        });
    }

  private:
    Device& device_;
};

}  // namespace stator::drivers::range::sim
