// Sums what it reads.
#pragma once

#include "plain_reader_ports.hpp"

namespace stator::apps::plain_reader {

class PlainReader {
  public:
    void step(PlainReaderPorts& ports) {
        if (ports.sample) sum_ += ports.sample->values[1];
    }
    uint32_t sum() const { return sum_; }

  private:
    uint32_t sum_ = 0;
};

}  // namespace stator::apps::plain_reader
