// Does nothing but live.
#pragma once

#include "heart_ports.hpp"

namespace stator {

struct Heart {
    void step(HeartPorts&) {}
};

}  // namespace stator
