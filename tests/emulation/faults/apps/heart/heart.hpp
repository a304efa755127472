// Does nothing but live.
#pragma once

#include "heart_ports.hpp"

namespace stator::apps::heart {

struct Heart {
    void step(HeartPorts&) {}
};

}  // namespace stator::apps::heart
