// The queue in front of a CAN controller.
#include <gtest/gtest.h>

#include <vector>

#include "../../../drivers/can/can_queue.hpp"
#include "can_ports.hpp"

namespace stator::drivers::can {
namespace {

using Queue = CanQueue<CanFrame, 4>;

CanFrame item(uint32_t id, uint64_t timestamp = 0, bool extended = true) {
    return {.timestamp = timestamp, .id = id, .extended = extended};
}

std::vector<uint64_t> times(Queue queue) {
    std::vector<uint64_t> result;
    for (; !queue.is_empty(); queue.remove_first()) result.push_back(queue.first().timestamp);
    return result;
}

TEST(CanQueue, is_in_the_order_of_the_bus) {
    Queue queue;
    for (const auto& [id, time] : {std::pair{9U, 1U}, {3U, 2U}, {9U, 3U}, {3U, 4U}}) {
        EXPECT_TRUE(queue.add(item(id, time)));
    }
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{2, 4, 1, 3}));
}

TEST(CanQueue, short_identifiers_win_over_long_ones_that_begin_alike) {
    Queue queue;
    EXPECT_TRUE(queue.add(item(0x123U << 18, 1)));
    EXPECT_TRUE(queue.add(item(0x123, 2, false)));
    EXPECT_TRUE(queue.add(item(0x122U << 18 | 0x3FFFF, 3)));
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{3, 2, 1}));
}

TEST(CanQueue, gives_up_the_least_urgent_when_full) {
    Queue queue;
    for (uint32_t id = 1; id <= 4; ++id) EXPECT_TRUE(queue.add(item(10 * id, id)));
    EXPECT_FALSE(queue.add(item(50, 5)));
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{1, 2, 3, 4}));
    EXPECT_FALSE(queue.add(item(5, 6)));
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{6, 1, 2, 3}));
}

TEST(CanQueue, what_is_put_back_goes_before_its_equals) {
    Queue queue;
    for (const auto& [id, time] : {std::pair{9U, 1U}, {3U, 2U}}) {
        EXPECT_TRUE(queue.add(item(id, time)));
    }
    EXPECT_TRUE(queue.put_back(item(9, 3)));
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{2, 3, 1}));
    EXPECT_TRUE(queue.put_back(item(3, 4)));
    EXPECT_FALSE(queue.put_back(item(9, 5)));
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{4, 2, 5, 3}));
    EXPECT_FALSE(queue.put_back(item(10, 6)));
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{4, 2, 5, 3}));
}

TEST(CanQueue, gives_up_what_is_old) {
    Queue queue;
    for (uint32_t id = 1; id <= 4; ++id) EXPECT_TRUE(queue.add(item(id, 10 * (5 - id))));
    EXPECT_EQ(queue.remove_older(25), 2U);
    EXPECT_EQ(times(queue), (std::vector<uint64_t>{40, 30}));
}

}  // namespace
}  // namespace stator::drivers::can
