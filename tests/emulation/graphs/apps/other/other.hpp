// Publishes from above.
#pragma once

#include "other_ports.hpp"

namespace stator::apps::other {

class Other {
  public:
    void step(OtherPorts& ports) {
        const auto block = [] { return Block{.values = {1, 2, 3, 4, 5, 6}}; };
        ports.setpoint.publish(block);
        ports.shared.publish(block);
        ports.queue.publish(block);
    }
};

}  // namespace stator::apps::other
