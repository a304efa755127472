// Publishes, and counts instructions by a timer that the emulator drives.
#pragma once

#include <cstdint>

#include "source_ports.hpp"

namespace stator {

// Least and most of a count.
struct Range {
    uint32_t least = UINT32_MAX;
    uint32_t most = 0;
    void add(uint32_t count) {
        least = count < least ? count : least;
        most = count > most ? count : most;
    }
};

class Source {
  public:
    void step(SourcePorts& ports);

  private:
    uint32_t runs_ = 0;
    Range reading_;  // of two readings of the counter, one behind the other
    Range publish_to_step_;
    Range publish_;
};

}  // namespace stator
