// The driver of a serial line: pieces in, pieces out, and what it says of itself.
#include "serial_usart.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "stator/testing.hpp"

namespace stator::drivers::serial::usart {
namespace {

// Memory in place of the registers: no byte moves by itself.
struct Line : ::testing::Test {
    Line() {
        device.base = reinterpret_cast<uintptr_t>(registers.data());
        device.clock_hz = 42'000'000;
        device.baud = 57'600;
    }
    uint32_t& at(uint32_t offset) { return registers[offset / 4]; }
    // One activation.
    void step(const SerialBytes* piece = nullptr, uint32_t lost = 0) {
        SerialPorts ports{
            .now = now_us,
            .send = piece == nullptr ? Input<SerialBytes>() : Input(*piece, true, lost)};
        stator::testing::Probe received(ports.received, ports.now);
        stator::testing::Probe told(ports.status, ports.now);
        driver.step(ports);
        pieces = received.count();
        EXPECT_LE(pieces, 2U) << "the burst of the interface";
        if (pieces != 0) newest = received.newest();
        if (told.count() != 0) status = told.newest();
        now_us += 10'000;
    }
    void send(uint8_t length, bool ends, uint32_t lost = 0) {
        SerialBytes piece{.length = length, .ends = ends};
        std::ranges::fill(piece.data, next_byte);
        ++next_byte;
        step(&piece, lost);
    }
    void come(unsigned count) {
        for (unsigned i = 0; i < count; ++i) {
            at(0x00) = 1U << 5;
            at(0x04) = i;
            device.interrupt();
        }
        at(0x00) = 0;
    }
    // What goes out now, until no byte waits.
    std::vector<uint32_t> sent() {
        std::vector<uint32_t> bytes;
        at(0x00) = 1U << 7;
        while ((at(0x0C) & 1U << 7) != 0) {
            at(0x04) = kNothing;
            device.interrupt();
            if (at(0x04) != kNothing) bytes.push_back(at(0x04));
        }
        return bytes;
    }
    void tell() {
        now_us += 1'000'000;
        step();
    }

    static constexpr uint32_t kNothing = 0xFFFF;
    std::array<uint32_t, 8> registers{};
    SerialUsart::Device device{};
    SerialUsart driver{device};
    SerialBytes newest{};
    SerialStatus status{};
    uint32_t pieces = 0;
    uint8_t next_byte = 1;
    uint64_t now_us = 1000;
};

TEST_F(Line, starts_with_its_first_activation_and_says_what_it_carries) {
    device.interrupt();
    EXPECT_EQ(at(0x0C), 0U) << "no graph, no line";
    step();
    EXPECT_EQ(at(0x08), 729U);
    EXPECT_EQ(status.bytes_per_s, 5760U);
}

TEST_F(Line, passes_on_two_pieces_an_activation) {
    step();
    come(150);
    step();
    EXPECT_EQ(pieces, 2U);
    EXPECT_EQ(newest.length, 64);
    EXPECT_EQ(newest.data[0], 64);
    step();
    EXPECT_EQ(pieces, 1U);
    EXPECT_EQ(newest.length, 150 - 128);
    step();
    EXPECT_EQ(pieces, 0U);
    tell();
    EXPECT_EQ(status.received, 150U);
    EXPECT_EQ(status.rx_lost, 0U);
}

TEST_F(Line, counts_what_comes_too_fast) {
    step();
    come(600);
    tell();
    EXPECT_EQ(status.rx_lost, 600U - 512U);
}

TEST_F(Line, sends_a_datagram_at_its_end) {
    send(64, false);
    EXPECT_EQ(sent().size(), 0U);
    send(3, true);
    const auto bytes = sent();
    ASSERT_EQ(bytes.size(), 67U);
    EXPECT_EQ(bytes[63], 1U);
    EXPECT_EQ(bytes[66], 2U);
    tell();
    EXPECT_EQ(status.sent, 67U);
    EXPECT_EQ(status.tx_lost, 0U);
}

TEST_F(Line, a_datagram_without_room_is_lost_as_a_whole) {
    for (unsigned i = 0; i < 15; ++i) send(64, true);
    send(64, false);
    send(64, true);
    send(10, true);
    EXPECT_EQ(sent().size(), 15U * 64U + 10U);
    tell();
    EXPECT_EQ(status.sent, 15U * 64U + 10U);
    EXPECT_EQ(status.tx_lost, 128U);
    send(64, true);
    EXPECT_EQ(sent().size(), 64U);
}

TEST_F(Line, a_datagram_of_which_a_piece_was_lost_does_not_go_out) {
    send(64, false);
    send(64, true, 1);
    EXPECT_EQ(sent().size(), 0U);
    send(5, true);
    EXPECT_EQ(sent().size(), 5U);
    tell();
    EXPECT_EQ(status.tx_lost, 128U);
}

TEST_F(Line, a_piece_that_claims_too_much_gives_what_it_has) {
    send(255, true);
    EXPECT_EQ(sent().size(), 64U);
}

}  // namespace
}  // namespace stator::drivers::serial::usart
