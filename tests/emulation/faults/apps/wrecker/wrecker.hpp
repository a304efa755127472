// Does what no node may do.
#pragma once

#include "wrecker_ports.hpp"

namespace stator::apps::wrecker {

// True if the word stands on the command line that the emulator gives the firmware.
bool was_told(const char* word);

class Wrecker {
  public:
    void step(WreckerPorts& ports);
};

}  // namespace stator::apps::wrecker
