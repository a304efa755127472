// Streams of a recording.
#include "stator/recording.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace stator {
namespace {

// What the logger would find in the stream.
std::vector<uint8_t> drain(RecordStream& stream) {
    std::vector<uint8_t> bytes;
    while (const uint32_t left = stream.available()) {
        const auto part = stream.peek(left);
        bytes.insert(bytes.end(), part.begin(), part.end());
        stream.take(static_cast<uint32_t>(part.size()));
    }
    return bytes;
}

TEST(record_stream, writes_numbers_of_seven_bits_a_byte) {
    std::array<uint8_t, 64> bytes{};
    RecordStream stream(bytes.data(), bytes.size());
    uint64_t previous_us = 1'000;
    stream.begin(3);
    stream.number(1);
    stream.number(127);
    stream.number(128);
    stream.number(UINT32_MAX);
    EXPECT_EQ(stream.available(), 0U) << "seen before its end";
    RecordStream::Part(stream).conclude(5, 1'300, previous_us);
    stream.end();
    EXPECT_EQ(previous_us, 1'300U);
    EXPECT_EQ(drain(stream), (std::vector<uint8_t>{3, 1, 127, 0x80, 1, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F,
                                                   0, 5, 0xAC, 2}));
}

TEST(record_stream, writes_what_a_port_took_and_published) {
    std::array<uint8_t, 64> bytes{};
    RecordStream stream(bytes.data(), bytes.size());
    stream.begin(3);
    stream.take(1, 200);
    RecordStream::Part(stream).bytes("\x02\x07", 2);
    stream.end();
    EXPECT_EQ(drain(stream), (std::vector<uint8_t>{3, 1, 0xC8, 1, 2, 7}));
}

TEST(record_stream, a_record_that_is_not_ended_leaves_no_trace) {
    std::array<uint8_t, 64> bytes{};
    RecordStream stream(bytes.data(), bytes.size());
    stream.begin(1);
    stream.number(9);
    stream.begin(2);
    stream.end();
    EXPECT_EQ(drain(stream), std::vector<uint8_t>{2});
}

TEST(record_stream, goes_round_its_memory_without_a_seam) {
    std::array<uint8_t, 32> bytes{};
    RecordStream stream(bytes.data(), bytes.size());
    for (uint8_t i = 0; i < 100; ++i) {
        const std::array<uint8_t, 5> content{2, 3, 4, 5, 6};
        stream.begin(1);
        stream.take(i, 1);
        RecordStream::Part(stream).bytes(content.data(), content.size());
        stream.end();
        EXPECT_EQ(drain(stream), (std::vector<uint8_t>{1, i, 1, 2, 3, 4, 5, 6}));
    }
    EXPECT_EQ(stream.lost(), 0U);
}

TEST(record_stream, counts_what_finds_no_room_and_stays_silent_from_there_on) {
    std::array<uint8_t, 32> bytes{};
    RecordStream stream(bytes.data(), bytes.size());
    const std::array<uint8_t, 12> content{};
    const auto record = [&] {
        stream.begin(1);
        if (stream.has_room(content.size())) {
            RecordStream::Part(stream).bytes(content.data(), content.size());
        }
        stream.end();
    };
    record();
    record();
    EXPECT_EQ(stream.lost(), 0U);
    record();  // 13 bytes more than there are
    EXPECT_EQ(stream.lost(), 1U);
    EXPECT_EQ(drain(stream).size(), 26U);
    record();  // there would be room again
    EXPECT_EQ(stream.lost(), 2U);
    EXPECT_EQ(stream.available(), 0U);
}

TEST(record_stream, counts_who_comes_in_while_another_one_is_in_its_node) {
    std::array<uint8_t, 32> bytes{};
    RecordStream low(bytes.data(), bytes.size());
    RecordStream high(bytes.data(), bytes.size());
    high.leave(high.enter());
    RecordStream* const outside = low.enter();
    high.leave(high.enter());
    high.leave(high.enter());
    low.leave(outside);
    high.leave(high.enter());
    EXPECT_EQ(low.preemptions(), 0U);
    EXPECT_EQ(high.preemptions(), 2U);
}

}  // namespace
}  // namespace stator
