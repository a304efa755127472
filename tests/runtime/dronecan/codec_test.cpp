// Every generated codec, and the cutting into frames, against another implementation, byte for
// byte.
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

#include "every_type.hpp"
#include "stator/dronecan/receiver.hpp"
#include "stator/dronecan/sender.hpp"

namespace stator::dronecan {
namespace {

// How vectors.inc numbers what it sends.
Header header_of(const DataType& type, int number) {
    const bool service = type.kind != DataType::Kind::kMessage;
    return {.kind = type.kind,
            .priority = static_cast<uint8_t>(number * 6),
            .type_id = type.id,
            .source = static_cast<uint8_t>(1 + number * 25),
            .destination = static_cast<uint8_t>(service ? 127 - number : 0)};
}

template <class Message>
void check_codec(const Message& value, const std::vector<uint8_t>& payload) {
    std::array<uint8_t, Message::kType.most_bytes> bytes;
    const std::size_t length = encode(value, bytes);
    EXPECT_EQ(std::vector<uint8_t>(bytes.begin(), bytes.begin() + length), payload);
    Message read;
    ASSERT_TRUE(decode(payload, read));
    EXPECT_TRUE(read == value);
    for (std::size_t cut = 0; cut < payload.size(); ++cut) {
        static_cast<void>(decode(std::span(payload).first(cut), read));  // ends, whatever it says
    }
}

template <class Message>
void check(const Message& value, const std::vector<uint8_t>& payload,
           const std::vector<Frame>& frames, int number) {
    check_codec(value, payload);
    const Header header = header_of(Message::kType, number);
    const auto transfer_id = static_cast<uint8_t>(number * 7 % kTransferIds);

    Sender<Message::kType.most_bytes> sender;
    sender.begin(header, transfer_id, value);
    std::vector<Frame> sent;
    for (Frame frame; sender.next(frame);) sent.push_back(frame);
    EXPECT_EQ(sent, frames);

    const Wanted wanted = want<Message>(1000);
    Receiver<1, Message::kType.most_bytes> receiver({&wanted, 1});
    NodeSet all;
    all.add_range(0, kMaxNodeId);
    receiver.allow(all);
    receiver.set_own_id(header.destination);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        ASSERT_EQ(receiver.accept(frames[i], 1000 * i), i + 1 == frames.size()) << "frame " << i;
    }
    EXPECT_EQ(receiver.header(), header);
    EXPECT_EQ(receiver.transfer_id(), transfer_id);
    const auto got = receiver.payload();
    EXPECT_EQ(std::vector<uint8_t>(got.begin(), got.end()), payload);
    EXPECT_EQ(receiver.counters().rejected(), 0U);
}

#include "vectors.inc"

TEST(DroneCanCodec, clamps_what_does_not_fit) {
    equipment::esc::RawCommand command;
    command.cmd.assign(std::array<int16_t, 3>{8191, 32767, -32768});
    std::array<uint8_t, equipment::esc::RawCommand::kType.most_bytes> bytes;
    const std::size_t length = encode(command, bytes);
    equipment::esc::RawCommand read;
    ASSERT_TRUE(decode(std::span(bytes).first(length), read));
    EXPECT_EQ(read.cmd.count, 3);
    EXPECT_EQ(read.cmd.items[1], 8191);
    EXPECT_EQ(read.cmd.items[2], -8192);
}

// Expected: `f16_from_f32(cast(value))` of dronecan.transport.
TEST(DroneCanCodec, rounds_to_16_bits_as_others_do) {
    const std::pair<float, uint16_t> rows[] = {
        {0x1.54fdf40000000p-2F, 0x3554},   {0x1.0020000000000p+11F, 0x6801},
        {0x1.0060000000000p+11F, 0x6802},  {0x1.ffde000000000p+15F, 0x7BFF},
        {-0x1.1170000000000p+16F, 0xFBFF}, {0x1.ffb4800000000p-15F, 0x03FF},
        {0x1.fff5ca0000000p-25F, 0x0001},  {0x1.f2375a0000000p-26F, 0x0000},
        {0x1.0a49b80000000p-25F, 0x0001},  {0x1.b7cdfe0000000p-34F, 0x0000},
        {0x1.0020000000000p+0F, 0x3C01},   {0x1.0040000000000p+0F, 0x3C01},
        {-0x1.99999a0000000p-4F, 0xAE66}};
    for (const auto& [value, bits] : rows) EXPECT_EQ(to_float16(value), bits) << value;
}

// What a sender may put into any field of 16 bits arrives as it is: the nodes judge it.
TEST(DroneCanCodec, reads_infinite_numbers_and_such_as_are_none) {
    EXPECT_EQ(from_float16(0x7C00), std::numeric_limits<float>::infinity());
    EXPECT_EQ(from_float16(0xFC00), -std::numeric_limits<float>::infinity());
    for (const uint16_t bits : std::array<uint16_t, 3>{0x7C01, 0x7FFF, 0xFE00}) {
        const float value = from_float16(bits);
        EXPECT_NE(value, value);
    }
}

TEST(DroneCanCodec, writes_no_infinite_number) {
    std::array<uint8_t, equipment::gnss::Fix2::kType.most_bytes> bytes;
    equipment::gnss::Fix2 fix;
    fix.ned_velocity = {std::numeric_limits<float>::infinity(),
                        -std::numeric_limits<float>::infinity(),
                        std::numeric_limits<float>::quiet_NaN()};
    equipment::gnss::Fix2 read;
    ASSERT_TRUE(decode(std::span(bytes).first(encode(fix, bytes)), read));
    EXPECT_EQ(read.ned_velocity[0], std::numeric_limits<float>::max());
    EXPECT_EQ(read.ned_velocity[1], -std::numeric_limits<float>::max());
    EXPECT_NE(read.ned_velocity[2], read.ned_velocity[2]);
}

TEST(DroneCanCodec, refuses_bytes_too_many_and_too_few) {
    std::array<uint8_t, 8> bytes{};
    protocol::NodeStatus status;
    EXPECT_TRUE(decode(std::span(bytes).first(7), status));
    EXPECT_FALSE(decode(std::span(bytes).first(6), status));
    EXPECT_FALSE(decode(std::span(bytes).first(8), status));
}

TEST(DroneCanCodec, refuses_a_union_of_no_kind_and_an_array_too_long) {
    protocol::param::GetSet::Request request;
    EXPECT_TRUE(decode(std::array<uint8_t, 2>{0, 0}, request));
    EXPECT_FALSE(decode(std::array<uint8_t, 2>{0, 0x07}, request));  // tag 7 of 5
    // A string of 200 characters where 128 fit.
    std::array<uint8_t, 210> text{0, 0x04, 200};
    EXPECT_FALSE(decode(text, request));
    text[2] = 128;
    EXPECT_TRUE(decode(std::span(text).first(3 + 128), request));
    // The name takes what is left, at most 92 characters.
    std::array<uint8_t, 2 + 93> name{};
    EXPECT_TRUE(decode(std::span(name).first(2 + 92), request));
    EXPECT_EQ(request.name.count, 92);
    EXPECT_FALSE(decode(name, request));
    // Within another type an array has its length: 36 covariances where 127 are said to be.
    std::array<uint8_t, equipment::gnss::Fix2::kType.most_bytes> bytes{};
    EXPECT_FALSE(decode(std::span(bytes).first(20), *std::make_unique<equipment::gnss::Fix2>()));
}

}  // namespace
}  // namespace stator::dronecan
