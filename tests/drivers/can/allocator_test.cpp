// What gives ids to parts on the bus, called with their messages.
#include "allocator.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace stator::apps::dronecan_node {
namespace {

// The id that a part is given; 0: none.
uint8_t allocate(Allocator& allocator, uint8_t seed) {
    uint8_t node = 0;
    uint64_t now_us = 1'000'000;
    for (const auto& [first, count] : {std::pair{0, 6}, {6, 6}, {12, 4}}) {
        Allocator::Message request{.first_part_of_unique_id = first == 0};
        request.unique_id.count = static_cast<uint16_t>(count);
        for (int i = 0; i < count; ++i) {
            request.unique_id.items[static_cast<unsigned>(i)] =
                static_cast<uint8_t>(seed + first + i);
        }
        const auto answer = allocator.answer(request, now_us += 1000);
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

TEST(DronecanAllocator, a_piece_that_comes_late_or_out_of_turn_is_no_continuation) {
    Allocator allocator;
    allocator.set_range(50, 125);
    Allocator::Message piece;
    piece.unique_id.count = 6;
    EXPECT_FALSE(allocator.answer(piece, 1000));
    piece.first_part_of_unique_id = true;
    EXPECT_TRUE(allocator.answer(piece, 2000));
    piece.first_part_of_unique_id = false;
    EXPECT_FALSE(allocator.answer(piece, 2000 + 500'001));
    piece.first_part_of_unique_id = true;
    EXPECT_TRUE(allocator.answer(piece, 600'000));
    piece.first_part_of_unique_id = false;
    piece.unique_id.count = 5;
    EXPECT_FALSE(allocator.answer(piece, 601'000));
}

}  // namespace
}  // namespace stator::apps::dronecan_node
