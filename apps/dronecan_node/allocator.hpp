// Gives ids to parts on the bus that have none.
//
// A part sends its unique id in pieces of 6, 6 and 4 bytes, in frames without a sender; after each
// piece, the allocator answers with what it has so far, and after the last with the id. The first
// id that is tried for a part comes from its unique id, so that a part is given the same id again
// even if the table is lost, unless that id is taken.
//
// A part that asks has no id. So what is heard under its old id after it began to ask is another
// node's, and the part gets another id. What was heard just before may be of the part itself, which
// has restarted: until that is older than the protocol's timeout, the last piece has no answer, and
// the part asks again.
#pragma once

#include <optional>
#include <span>

#include "bus_nodes.hpp"
#include "dronecan/protocol/dynamic_node_id/allocation.hpp"
#include "stator/dronecan/receiver.hpp"

namespace stator::apps::dronecan_node {

class Allocator {
  public:
    using Message = dronecan::protocol::dynamic_node_id::Allocation;
    static constexpr unsigned kUniqueIdBytes = 16;
    using UniqueId = std::array<uint8_t, kUniqueIdBytes>;

    // The ids to give away, and the allocator's own, which is never given.
    void set_range(int32_t first, int32_t last);
    void set_own_id(uint8_t own);
    // A node that is on the bus already.
    void note_taken(uint8_t node) { taken_.add(node); }
    // An id that was given away before a restart; with a unique id of zeros, one that is taken by a
    // node that needs none. Nothing for what cannot be one.
    void remember(uint32_t node, std::span<const uint8_t> unique_id);
    // The answer to a part's message, if there is one. The id is given away if `node_id` of it is
    // not 0.
    std::optional<Message> answer(const Message& request, const BusNodes& nodes, uint64_t now_us);
    const UniqueId& unique_id() const { return collected_; }
    // The id that the newest answer replaces, as another node uses it; 0: none.
    uint8_t replaced() const { return replaced_; }
    // A part got no id, as all were taken.
    bool is_full() const { return is_full_; }

  private:
    // Of an id, by others than the part that it was given to. Unclear: maybe by the part itself,
    // before it restarted.
    enum class Use : uint8_t { kNone, kUnclear, kByAnother };

    bool collect(const Message& request, uint64_t now_us);
    uint8_t find_given() const;
    uint8_t find_free(uint8_t preferred) const;
    Use use_of(uint8_t given, const BusNodes& nodes, uint64_t now_us);

    // Which part has an id, if any: none is all zeros.
    std::array<UniqueId, dronecan::kMaxNodeId + 1> owners_{};
    // Since when that part asks for it while it may be in use; 0: it does not.
    std::array<uint64_t, dronecan::kMaxNodeId + 1> asks_since_us_{};
    dronecan::NodeSet taken_;
    UniqueId collected_{};
    uint64_t collected_us_ = 0;
    unsigned count_ = 0;  // bytes of it
    int32_t first_ = 1;
    int32_t last_ = 0;
    uint8_t own_ = 0;
    uint8_t replaced_ = 0;
    bool is_full_ = false;
};

}  // namespace stator::apps::dronecan_node
