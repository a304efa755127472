// Notes when it begins.
#pragma once

#include "../../../counting.hpp"
#include "probe_ports.hpp"

namespace stator::drivers::probe::counted {

class ProbeCounted {
  public:
    struct Device {
        uint32_t value = 0;
    };

    explicit ProbeCounted(Device& device) : device_(device) {}
    void step(ProbePorts& ports) {
        counting::reach_exactly(counting::Place::kDriver);
        const uint32_t value = device_.value;
        ports.event.publish([&] {
            return Block{.values = {value, value, value, value, value, value}};
        });
    }

  private:
    Device& device_;
};

}  // namespace stator::drivers::probe::counted
