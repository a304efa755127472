// Sums what it reads.
#pragma once

#include "latest_reader_ports.hpp"

namespace stator::apps::latest_reader {

class LatestReader {
  public:
    void step(LatestReaderPorts& ports) {
        if (ports.sample) sum_ += ports.sample->values[1];
        if (ports.setpoint) sum_ += ports.setpoint->values[0];
    }
    uint32_t sum() const { return sum_; }

  private:
    uint32_t sum_ = 0;
};

}  // namespace stator::apps::latest_reader
