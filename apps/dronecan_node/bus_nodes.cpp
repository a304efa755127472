// Which nodes are on the bus, by their NodeStatus.
#include "bus_nodes.hpp"

namespace stator::apps::dronecan_node {

namespace {

constexpr uint64_t kOffline_us = uint64_t{1000} * BusNodes::NodeStatus::kOfflineTimeoutMs;
// A node's clock may be faster than ours: with --speed ours is slowed down. Whole seconds are sent.
constexpr uint64_t kFastestClock = 10;
constexpr uint64_t kMargin_s = 3;

}  // namespace

bool BusNodes::hear(uint8_t node, const NodeStatus& status, uint64_t now_us) {
    Node& known = nodes_[node];
    const uint64_t passed_us = now_us - known.heard_us;
    const uint64_t max_s = known.uptime_s + kFastestClock * passed_us / 1'000'000 + kMargin_s;
    const bool is_same = known.heard_us == 0 || status.uptime_sec <= max_s;
    known = {.heard_us = now_us,
             .uptime_s = status.uptime_sec,
             .is_off = status.mode == NodeStatus::kModeOffline};
    return is_same;
}

bool BusNodes::is_online(uint8_t node, uint64_t now_us) const {
    const Node& known = nodes_[node];
    return known.heard_us != 0 && !known.is_off && now_us <= known.heard_us + kOffline_us;
}

}  // namespace stator::apps::dronecan_node
