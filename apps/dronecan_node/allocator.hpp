// Gives ids to parts on the bus that have none.
//
// A part sends its unique id in pieces of 6, 6 and 4 bytes, in frames without a sender; after each
// piece, the allocator answers with what it has so far, and after the last with the id. The first
// id that is tried for a part comes from its unique id, so that a part is as a rule given the same
// id again even if the table is lost.
#pragma once

#include <optional>
#include <span>

#include "dronecan/protocol/dynamic_node_id/allocation.hpp"
#include "stator/dronecan/receiver.hpp"

namespace stator::apps::dronecan_node {

class Allocator {
  public:
    using Message = dronecan::protocol::dynamic_node_id::Allocation;
    static constexpr unsigned kUniqueIdBytes = 16;
    using UniqueId = std::array<uint8_t, kUniqueIdBytes>;

    // The ids to give away.
    void set_range(int32_t first, int32_t last);
    // A node that is on the bus already.
    void note_taken(uint8_t node) { taken_.add(node); }
    // An id that was given away before a restart. Nothing for what cannot be one.
    void remember(uint32_t node, std::span<const uint8_t> unique_id);
    // The answer to a part's message, if there is one. The id is given away if `node_id` of it is
    // not 0.
    std::optional<Message> answer(const Message& request, uint64_t now_us);
    const UniqueId& unique_id() const { return collected_; }
    // A part got no id, as all were taken.
    bool is_full() const { return is_full_; }

  private:
    bool collect(const Message& request, uint64_t now_us);
    uint8_t find(uint8_t preferred);

    // Which part has an id; none has 0 bytes only.
    std::array<UniqueId, dronecan::kMostNodeId + 1> owners_{};
    dronecan::NodeSet taken_;
    UniqueId collected_{};
    uint64_t collected_us_ = 0;
    unsigned count_ = 0;  // bytes of it
    int32_t first_ = 1;
    int32_t last_ = 0;
    bool is_full_ = false;
};

}  // namespace stator::apps::dronecan_node
