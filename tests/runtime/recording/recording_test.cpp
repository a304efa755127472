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

// A ring of `kSize` bytes, with what lies behind it.
template <size_t kSize>
struct Memory {
    std::array<uint8_t, kSize + RecordStream::spare_bytes(0, 0)> bytes{};
    RecordStream stream{bytes.data(), kSize};
};

TEST(record_stream, writes_numbers_of_seven_bits_a_byte) {
    Memory<64> memory;
    RecordStream& stream = memory.stream;
    uint64_t previous_us = 1'000;
    stream.begin(3);
    stream.number(1);
    stream.number(127);
    stream.number(128);
    stream.number(UINT32_MAX);
    EXPECT_EQ(stream.available(), 0U) << "seen before its end";
    ASSERT_TRUE(stream.has_room(RecordStream::conclude_bytes(0, 0)));
    RecordStream::Part(stream).conclude(5, 1'300, previous_us);
    stream.end();
    EXPECT_EQ(previous_us, 1'300U);
    EXPECT_EQ(drain(stream), (std::vector<uint8_t>{3, 1, 127, 0x80, 1, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F,
                                                   0, 5, 0xAC, 2}));
}

TEST(record_stream, writes_what_a_port_took_and_published) {
    Memory<64> memory;
    RecordStream& stream = memory.stream;
    stream.begin(3);
    stream.take(1, 200);
    stream.append("\x02\x07", 2);
    stream.end();
    EXPECT_EQ(drain(stream), (std::vector<uint8_t>{3, 1, 0xC8, 1, 2, 7}));
}

TEST(record_stream, a_record_that_is_only_begun_leaves_no_trace) {
    Memory<64> memory;
    RecordStream& stream = memory.stream;
    stream.begin(1);
    stream.begin(2);
    stream.end();
    EXPECT_EQ(drain(stream), std::vector<uint8_t>{2});
}

TEST(record_stream, writes_times_of_each_length) {
    for (const uint64_t later_us :
         {uint64_t{0x7F}, uint64_t{0x80}, uint64_t{0x3FFF}, uint64_t{0x4000}, UINT64_MAX}) {
        Memory<64> memory;
        uint64_t previous_us = 0;
        memory.stream.begin(0);
        ASSERT_TRUE(memory.stream.has_room(RecordStream::conclude_bytes(0, 0)));
        RecordStream::Part(memory.stream).conclude(0, later_us, previous_us);
        memory.stream.end();
        std::vector<uint8_t> expected{0, 0, 0};
        for (uint64_t left = later_us; expected.back() > 0x7F || expected.size() == 3; left >>= 7) {
            expected.push_back(static_cast<uint8_t>(left > 0x7F ? left | 0x80U : left));
        }
        EXPECT_EQ(drain(memory.stream), expected) << later_us;
    }
}

// Of all lengths, so that each kind of part meets the end of the ring at each of its bytes.
TEST(record_stream, goes_round_its_memory_without_a_seam) {
    Memory<64> memory;
    RecordStream& stream = memory.stream;
    for (uint8_t i = 0; i < 200; ++i) {
        const std::array<uint8_t, 20> content{2, 3, 4, 5, 6, 7, 8, 9};
        const uint32_t count = i % 19;
        std::vector<uint8_t> expected{1, i, 1};
        stream.begin(1);
        stream.take(i, 1);
        stream.append(content.data(), count);
        expected.insert(expected.end(), content.begin(), content.begin() + count);
        ASSERT_TRUE(stream.has_room(RecordStream::kTakeBytes + 8));
        RecordStream::Part(stream).bytes<8>(content.data());
        expected.insert(expected.end(), content.begin(), content.begin() + 8);
        stream.end();
        EXPECT_EQ(drain(stream), expected);
    }
    EXPECT_EQ(stream.lost(), 0U);
}

// Neither what is only begun nor what lies behind the ring may touch what the logger has not taken.
TEST(record_stream, keeps_what_waits_whatever_the_place_in_the_ring) {
    for (uint32_t place = 0; place < 32; ++place) {
        Memory<32> memory;
        RecordStream& stream = memory.stream;
        for (uint32_t i = 0; i < place; ++i) {
            stream.begin(1);
            stream.end();
        }
        EXPECT_EQ(drain(stream).size(), place);
        std::vector<uint8_t> expected;
        for (uint8_t i = 0; stream.lost() == 0 && i < 20; ++i) {
            stream.begin(i);
            stream.append("\x07\x08\x09", 3);
            stream.end();
            if (stream.lost() == 0) expected.insert(expected.end(), {i, 7, 8, 9});
            stream.begin(1000);
        }
        EXPECT_GE(expected.size(), 20U);
        EXPECT_EQ(drain(stream), expected) << place;
    }
}

TEST(record_stream, counts_what_finds_no_room_and_stays_silent_from_there_on) {
    Memory<32> memory;
    RecordStream& stream = memory.stream;
    const std::array<uint8_t, 12> content{};
    const auto record = [&] {
        stream.begin(1);
        stream.append(content.data(), content.size());
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
