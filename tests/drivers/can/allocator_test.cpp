// What gives ids to parts on the bus, called with their messages.
#include "allocator.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace stator::apps::dronecan_node {
namespace {

using NodeStatus = dronecan::protocol::NodeStatus;

constexpr uint64_t kSecond_us = 1'000'000;

// The id that a part is given; 0: none.
uint8_t allocate(Allocator& allocator, uint8_t seed, const BusNodes& nodes = {},
                 uint64_t now_us = kSecond_us) {
    uint8_t node = 0;
    for (const auto& [first, count] : {std::pair{0, 6}, {6, 6}, {12, 4}}) {
        Allocator::Message request{.first_part_of_unique_id = first == 0};
        request.unique_id.count = static_cast<uint16_t>(count);
        for (int i = 0; i < count; ++i) {
            request.unique_id.items[static_cast<unsigned>(i)] =
                static_cast<uint8_t>(seed + first + i);
        }
        const auto answer = allocator.answer(request, nodes, now_us += 1000);
        if (answer) node = answer->node_id;
    }
    return node;
}

TEST(DronecanAllocator, gives_the_same_part_the_same_id_even_without_its_table) {
    Allocator one;
    Allocator other;
    one.set_range(50, 125);
    other.set_range(50, 125);
    const uint8_t a = allocate(one, 1);
    const uint8_t b = allocate(one, 2);
    EXPECT_NE(a, 0);
    EXPECT_NE(b, 0);
    EXPECT_NE(a, b);
    EXPECT_EQ(allocate(one, 1), a);
    EXPECT_EQ(allocate(other, 2), b);

    Allocator full;
    full.set_range(50, 51);
    full.note_taken(50);
    EXPECT_EQ(allocate(full, 1), 51);
    EXPECT_FALSE(full.is_full());
    EXPECT_EQ(allocate(full, 2), 0) << "no id is left";
    EXPECT_TRUE(full.is_full());
    EXPECT_EQ(allocate(full, 1), 51) << "which is its own";
}

TEST(DronecanAllocator, remembers_only_what_can_be_an_id) {
    Allocator allocator;
    allocator.set_range(60, 60);
    const Allocator::UniqueId part{1};
    allocator.remember(0, part);
    allocator.remember(128, part);
    allocator.remember(UINT32_MAX, part);
    allocator.remember(60, std::span(part).first(15));
    EXPECT_EQ(allocate(allocator, 1), 60) << "it is free";
    Allocator other;
    other.set_range(60, 60);
    other.remember(60, part);
    EXPECT_EQ(allocate(other, 2), 0);
}

// A part that was given an id, and what is heard of that id on the bus since.
struct GivenId : ::testing::Test {
    GivenId() {
        allocator.set_range(50, 125);
        given = allocate(allocator, 1);
    }
    void hear(uint64_t time_us, uint32_t uptime_s = 0, uint8_t mode = 0) {
        allocator.note_taken(given);
        ASSERT_TRUE(nodes.hear(given, NodeStatus{.uptime_sec = uptime_s, .mode = mode}, time_us));
    }
    uint8_t ask(uint64_t time_us) { return allocate(allocator, 1, nodes, time_us); }

    Allocator allocator;
    BusNodes nodes;
    uint8_t given = 0;
};

TEST_F(GivenId, one_that_another_node_uses_is_exchanged_for_a_free_one) {
    hear(20 * kSecond_us);
    EXPECT_EQ(ask(20'500'000), 0) << "it may have been the part, before it restarted";
    hear(21 * kSecond_us, 1);
    const uint8_t other = ask(21'500'000);
    EXPECT_NE(other, 0);
    EXPECT_NE(other, given);
    EXPECT_EQ(allocator.replaced(), given);
    // For good: also if the intruder is silent, and for other parts.
    EXPECT_EQ(ask(40 * kSecond_us), other);
    EXPECT_EQ(allocator.replaced(), 0);
    EXPECT_NE(allocate(allocator, 2, nodes, 40 * kSecond_us), given);
}

TEST_F(GivenId, a_part_that_restarts_quickly_keeps_its_id) {
    hear(20 * kSecond_us, 15);
    EXPECT_EQ(ask(20'500'000), 0);
    EXPECT_EQ(ask(21'500'000), 0);
    EXPECT_EQ(ask(22'500'000), 0);
    EXPECT_EQ(ask(23'500'000), given) << "nothing was heard since it asked";
    EXPECT_EQ(allocator.replaced(), 0);
    // And once more: what it sent in between is not another's.
    hear(25 * kSecond_us, 1);
    EXPECT_EQ(ask(25'500'000), 0);
    EXPECT_EQ(ask(28'500'000), given);
}

TEST_F(GivenId, a_part_that_signed_off_has_it_at_once) {
    hear(20 * kSecond_us, 15, NodeStatus::kModeOffline);
    EXPECT_EQ(ask(20'500'000), given);
}

TEST_F(GivenId, several_parts_that_restart_at_once_keep_theirs) {
    const uint8_t second = allocate(allocator, 2);
    hear(20 * kSecond_us, 15);
    EXPECT_TRUE(nodes.hear(second, NodeStatus{.uptime_sec = 15}, 20 * kSecond_us));
    EXPECT_EQ(ask(20'500'000), 0);
    EXPECT_EQ(allocate(allocator, 2, nodes, 20'600'000), 0);
    EXPECT_EQ(allocate(allocator, 2, nodes, 23'600'000), second);
    EXPECT_EQ(ask(23'700'000), given);
}

TEST_F(GivenId, without_another_one_that_is_free_the_table_stays) {
    allocator.set_range(given, given);
    hear(20 * kSecond_us);
    EXPECT_EQ(ask(20'500'000), 0);
    hear(21 * kSecond_us, 1);
    EXPECT_EQ(ask(21'500'000), 0);
    EXPECT_TRUE(allocator.is_full());
    EXPECT_EQ(ask(30 * kSecond_us), given) << "the other one is gone";
}

TEST(DronecanAllocator, gives_its_own_id_to_no_part_whatever_it_remembers) {
    Allocator allocator;
    allocator.set_range(50, 125);
    Allocator::UniqueId part;
    for (unsigned i = 0; i < part.size(); ++i) part[i] = static_cast<uint8_t>(1 + i);
    allocator.remember(77, part);
    allocator.set_own_id(77);
    const uint8_t other = allocate(allocator, 1);
    EXPECT_NE(other, 77);
    EXPECT_NE(other, 0);
    EXPECT_EQ(allocator.replaced(), 77);
}

TEST(DronecanAllocator, remembers_an_id_that_another_node_took) {
    Allocator allocator;
    allocator.set_range(60, 60);
    allocator.remember(60, Allocator::UniqueId{});
    EXPECT_EQ(allocate(allocator, 1), 0);
}

TEST(BusNodes, are_online_until_they_are_silent_or_sign_off) {
    BusNodes nodes;
    EXPECT_FALSE(nodes.is_online(20, kSecond_us));
    EXPECT_TRUE(nodes.hear(20, {}, kSecond_us));
    EXPECT_TRUE(nodes.is_online(20, 4 * kSecond_us));
    EXPECT_FALSE(nodes.is_online(20, 4 * kSecond_us + 1));
    EXPECT_TRUE(nodes.hear(20, {.mode = NodeStatus::kModeOffline}, 5 * kSecond_us));
    EXPECT_FALSE(nodes.is_online(20, 5 * kSecond_us));
}

TEST(BusNodes, two_of_one_id_are_told_from_one_that_restarts) {
    BusNodes nodes;
    const auto hear = [&](uint64_t time_us, uint32_t uptime_s) {
        return nodes.hear(20, NodeStatus{.uptime_sec = uptime_s}, time_us);
    };
    EXPECT_TRUE(hear(10 * kSecond_us, 100)) << "the first one may be of any age";
    EXPECT_TRUE(hear(11 * kSecond_us, 101));
    EXPECT_TRUE(hear(12 * kSecond_us, 0)) << "a restart";
    EXPECT_TRUE(hear(13 * kSecond_us, 1));
    EXPECT_TRUE(hear(14 * kSecond_us, 5)) << "its clock is four times as fast";
    EXPECT_FALSE(hear(14'500'000, 104)) << "this one did not restart";
    EXPECT_TRUE(hear(15 * kSecond_us, 6));
    EXPECT_FALSE(hear(15'500'000, 105));
}

TEST(DronecanAllocator, a_piece_that_comes_late_or_out_of_turn_is_no_continuation) {
    Allocator allocator;
    const BusNodes nodes;
    allocator.set_range(50, 125);
    Allocator::Message piece;
    piece.unique_id.count = 6;
    EXPECT_FALSE(allocator.answer(piece, nodes, 1000));
    piece.first_part_of_unique_id = true;
    EXPECT_TRUE(allocator.answer(piece, nodes, 2000));
    piece.first_part_of_unique_id = false;
    EXPECT_FALSE(allocator.answer(piece, nodes, 2000 + 500'001));
    piece.first_part_of_unique_id = true;
    EXPECT_TRUE(allocator.answer(piece, nodes, 600'000));
    piece.first_part_of_unique_id = false;
    piece.unique_id.count = 5;
    EXPECT_FALSE(allocator.answer(piece, nodes, 601'000));
}

}  // namespace
}  // namespace stator::apps::dronecan_node
