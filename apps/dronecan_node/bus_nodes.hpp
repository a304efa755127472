// Which nodes are on the bus, by their NodeStatus.
#pragma once

#include <array>

#include "dronecan/protocol/node_status.hpp"
#include "stator/dronecan/frame.hpp"

namespace stator::apps::dronecan_node {

class BusNodes {
  public:
    using NodeStatus = dronecan::protocol::NodeStatus;

    // Takes a status, in the order of time. False if it cannot be of the node that was heard before
    // under this id, but of a second one: the uptime grew much faster than time. An uptime that
    // goes back is a restart. Two nodes that started within some ten seconds are not told apart.
    [[nodiscard]] bool hear(uint8_t node, const NodeStatus& status, uint64_t now_us);
    // Heard within the protocol's timeout, and did not sign off.
    bool is_online(uint8_t node, uint64_t now_us) const;
    // 0: never.
    uint64_t heard_us(uint8_t node) const { return nodes_[node].heard_us; }

  private:
    struct Node {
        uint64_t heard_us = 0;
        uint32_t uptime_s = 0;
        bool is_off = false;
    };
    std::array<Node, dronecan::kMaxNodeId + 1> nodes_{};
};

}  // namespace stator::apps::dronecan_node
