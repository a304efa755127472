// The USART port alone, with the model of its registers.
#include "usart_port.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "usart_model.hpp"

namespace stator::testing {
namespace {

using drivers::serial::usart::UsartPort;
using Port = UsartPort<UsartWire>;

struct Usart : ::testing::Test {
    Usart() {
        port.start({&model}, 42'000'000, 57'600);
        model.on_interrupt = [this] { port.interrupt(); };
    }
    void come(const std::vector<uint8_t>& bytes) {
        for (const uint8_t byte : bytes) {
            model.receive(byte);
            model.interrupt();
        }
    }
    std::vector<uint8_t> taken(std::size_t most = 4096) {
        std::vector<uint8_t> bytes(most);
        bytes.resize(port.take(bytes));
        return bytes;
    }

    UsartModel model;
    Port port;
};

std::vector<uint8_t> counted(std::size_t count, uint8_t first = 0) {
    std::vector<uint8_t> bytes(count);
    std::iota(bytes.begin(), bytes.end(), first);
    return bytes;
}

TEST_F(Usart, is_set_to_its_rate_and_8n1) {
    EXPECT_EQ(model.plain[0x08], 729U);  // 42 MHz / 57600 = 729.2
    EXPECT_EQ(model.plain[0x0C], 1U << 13 | 1U << 5 | 1U << 3 | 1U << 2);
    EXPECT_EQ(model.plain[0x10], 0U);
    EXPECT_EQ(model.plain[0x14], 0U);
    port.start({&model}, 42'000'000, 921'600);
    EXPECT_EQ(model.plain[0x08], 46U);  // 45.6: 0.9 % slow
}

TEST_F(Usart, what_comes_is_taken_in_its_order) {
    come({1, 2, 3});
    EXPECT_EQ(taken(2), (std::vector<uint8_t>{1, 2}));
    come({4});
    EXPECT_EQ(taken(), (std::vector<uint8_t>{3, 4}));
    EXPECT_EQ(taken(), std::vector<uint8_t>{});
    EXPECT_EQ(port.lost(), 0U);
}

TEST_F(Usart, goes_around_its_rings) {
    for (uint8_t round = 0; round < 20; ++round) {
        const auto bytes = counted(300, round);
        come(bytes);
        EXPECT_EQ(taken(), bytes);
        ASSERT_TRUE(port.add(bytes));
        port.commit();
        model.wire.clear();
        model.interrupt();
        EXPECT_EQ(model.wire, bytes);
    }
}

TEST_F(Usart, what_finds_no_room_is_lost_and_counted) {
    come(counted(Port::kReceivedBytes + 5));
    EXPECT_EQ(port.lost(), 5U);
    EXPECT_EQ(taken(), counted(Port::kReceivedBytes));
    come({7});
    EXPECT_EQ(taken(), std::vector<uint8_t>{7});
}

TEST_F(Usart, an_overrun_is_counted_and_ends) {
    model.receive(1);
    model.receive(2);
    model.receive(3);
    EXPECT_LT(model.interrupt(), 3U);
    EXPECT_EQ(port.lost(), 1U) << "at least one";
    EXPECT_EQ(taken(), std::vector<uint8_t>{1});
    come({4});
    EXPECT_EQ(taken(), std::vector<uint8_t>{4});
}

// One that begins between the reads of status and data.
TEST_F(Usart, an_overrun_without_a_byte_gives_none) {
    model.overrun();
    EXPECT_EQ(model.interrupt(), 1U);
    EXPECT_EQ(taken(), std::vector<uint8_t>{});
    EXPECT_EQ(port.lost(), 1U);
}

TEST_F(Usart, damaged_bytes_are_dropped_and_counted) {
    for (const uint32_t error : {UsartModel::kFramingError, UsartModel::kNoise}) {
        model.receive(9, error);
        model.interrupt();
    }
    come({1});
    EXPECT_EQ(taken(), std::vector<uint8_t>{1});
    EXPECT_EQ(port.lost(), 2U);
}

TEST_F(Usart, nothing_goes_out_before_it_is_committed) {
    ASSERT_TRUE(port.add(counted(10)));
    EXPECT_EQ(model.interrupt(), 0U);
    port.commit();
    model.interrupt();
    EXPECT_EQ(model.wire, counted(10));
    EXPECT_EQ(model.plain[0x0C] & 1U << 7, 0U) << "no interrupt without bytes";
}

TEST_F(Usart, what_is_dropped_leaves_what_waits) {
    ASSERT_TRUE(port.add(counted(10)));
    port.commit();
    ASSERT_TRUE(port.add(counted(20)));
    port.drop();
    ASSERT_TRUE(port.add(counted(5, 50)));
    port.commit();
    model.interrupt();
    auto expected = counted(10);
    for (const uint8_t byte : counted(5, 50)) expected.push_back(byte);
    EXPECT_EQ(model.wire, expected);
}

TEST_F(Usart, takes_no_more_than_its_ring_holds) {
    EXPECT_TRUE(port.add(counted(Port::kSentBytes - 1)));
    EXPECT_FALSE(port.add(counted(2)));
    EXPECT_TRUE(port.add(counted(1)));
    port.commit();
    EXPECT_FALSE(port.add(counted(1)));
    port.interrupt();
    EXPECT_TRUE(port.add(counted(1)));
}

// Both in one interrupt: none waits for the other.
TEST_F(Usart, sends_while_it_receives) {
    ASSERT_TRUE(port.add(counted(2)));
    port.commit();
    model.receive(7);
    port.interrupt();
    model.send();
    EXPECT_EQ(model.wire, counted(1));
    EXPECT_EQ(taken(), std::vector<uint8_t>{7});
}

}  // namespace
}  // namespace stator::testing
