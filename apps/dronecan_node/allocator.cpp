// Gives ids to parts on the bus that have none.
#include "allocator.hpp"

#include <algorithm>

#include "stator/dronecan/crc.hpp"

namespace stator::apps::dronecan_node {

namespace {

constexpr uint64_t kFollowUp_us = uint64_t{1000} * Allocator::Message::kFollowupTimeoutMs;

}  // namespace

void Allocator::set_range(int32_t first, int32_t last) {
    first_ = first;
    last_ = last;
}

void Allocator::set_own_id(uint8_t own) {
    own_ = own;
    note_taken(own);
}

// Adds a piece to what is collected; false if it does not continue that.
bool Allocator::collect(const Message& request, uint64_t now_us) {
    if (now_us - collected_us_ > kFollowUp_us) count_ = 0;
    if (request.first_part_of_unique_id) count_ = 0;
    const unsigned left = kUniqueIdBytes - count_;
    const unsigned most = Message::kMaxLengthOfUniqueIdInRequest;
    const bool in_turn = request.first_part_of_unique_id || count_ != 0;
    if (!in_turn || request.unique_id.count != (left < most ? left : most)) return false;
    for (const uint8_t byte : request.unique_id.view()) collected_[count_++] = byte;
    collected_us_ = now_us;
    return true;
}

// The id that was given to the part whose unique id is collected; 0: none.
uint8_t Allocator::find_given() const {
    for (int32_t id = first_; id <= last_; ++id) {
        if (owners_[static_cast<unsigned>(id)] == collected_) return static_cast<uint8_t>(id);
    }
    return 0;
}

// The id that a part prefers if that is free, or the next free one from where its unique id points.
// 0 if all are taken.
uint8_t Allocator::find_free(uint8_t preferred) const {
    if (preferred >= first_ && preferred <= last_ && !taken_.has(preferred)) return preferred;
    const int32_t count = last_ - first_ + 1;
    if (count <= 0) return 0;
    const int32_t start = dronecan::crc16(0xFFFF, collected_) % count;
    for (int32_t i = 0; i < count; ++i) {
        const auto id = static_cast<uint8_t>(first_ + (start + i) % count);
        if (!taken_.has(id)) return id;
    }
    return 0;
}

void Allocator::remember(uint32_t node, std::span<const uint8_t> unique_id) {
    if (node == 0 || node > dronecan::kMaxNodeId || unique_id.size() != kUniqueIdBytes) return;
    std::copy(unique_id.begin(), unique_id.end(), owners_[node].begin());
    taken_.add(static_cast<uint8_t>(node));
}

// Whether the part may have the id that it was given before.
Allocator::Use Allocator::use_of(uint8_t given, const BusNodes& nodes, uint64_t now_us) {
    if (given == own_) return Use::kByAnother;
    if (!nodes.is_online(given, now_us)) return Use::kNone;
    uint64_t& since_us = asks_since_us_[given];
    if (since_us == 0) since_us = now_us;
    return nodes.heard_us(given) > since_us ? Use::kByAnother : Use::kUnclear;
}

std::optional<Allocator::Message> Allocator::answer(const Message& request, const BusNodes& nodes,
                                                    uint64_t now_us) {
    replaced_ = 0;
    if (!collect(request, now_us)) return std::nullopt;
    Message answer;
    answer.unique_id.assign(std::span(collected_).first(count_));
    if (count_ < kUniqueIdBytes) return answer;
    count_ = 0;
    if (collected_ == UniqueId{}) return std::nullopt;
    const uint8_t given = find_given();
    const Use use = given == 0 ? Use::kNone : use_of(given, nodes, now_us);
    if (use == Use::kUnclear) return std::nullopt;
    const bool keeps = given != 0 && use == Use::kNone;
    answer.node_id = keeps ? given : find_free(request.node_id);
    is_full_ = answer.node_id == 0;
    if (is_full_) return std::nullopt;
    if (use == Use::kByAnother) {
        replaced_ = given;
        owners_[given] = {};
    }
    asks_since_us_[given] = 0;
    owners_[answer.node_id] = collected_;
    taken_.add(answer.node_id);
    return answer;
}

}  // namespace stator::apps::dronecan_node
