// Transfers on a bus that is not trusted: what is wrong ends as a counter, and the next good one is
// taken.
#include <gtest/gtest.h>

#include <vector>

#include "dronecan/equipment/esc/status.hpp"
#include "dronecan/protocol/dynamic_node_id/allocation.hpp"
#include "dronecan/protocol/node_status.hpp"
#include "dronecan/protocol/restart_node.hpp"
#include "stator/dronecan/crc.hpp"
#include "stator/dronecan/receiver.hpp"
#include "stator/dronecan/sender.hpp"

namespace stator::dronecan {
namespace {

using equipment::esc::Status;
using protocol::NodeStatus;
using protocol::RestartNode;
using protocol::dynamic_node_id::Allocation;

constexpr std::array kWanted{want<NodeStatus>(5), want<Status>(100),
                             want_anonymous<Allocation>(100), want<RestartNode::Request>(100)};
constexpr uint8_t kOwnId = 10;

template <class Message>
std::vector<Frame> cut(const Message& message, uint8_t source, uint8_t transfer_id = 0) {
    Sender<Message::kType.most_bytes> sender;
    sender.begin({.source = source, .destination = kOwnId, .discriminator = 77}, transfer_id,
                 message);
    std::vector<Frame> frames;
    for (Frame frame; sender.next(frame);) frames.push_back(frame);
    return frames;
}

struct Transfers : testing::Test {
    Transfers() {
        NodeSet nodes;
        nodes.add_range(0, 0);
        nodes.add_range(20, 29);
        receiver.allow(nodes);
        receiver.set_own_id(kOwnId);
    }
    // How many transfers these frames complete.
    unsigned feed(const std::vector<Frame>& frames) {
        unsigned complete = 0;
        for (const Frame& frame : frames) complete += receiver.accept(frame, now_us) ? 1 : 0;
        return complete;
    }
    const ReceiverCounters& counters() const { return receiver.counters(); }

    Receiver<3, 18> receiver{kWanted};
    uint64_t now_us = 5'000'000;
};

TEST_F(Transfers, a_node_outside_the_allow_list_is_refused) {
    EXPECT_EQ(feed(cut(NodeStatus{}, 19)), 0U);
    EXPECT_EQ(feed(cut(NodeStatus{}, 30)), 0U);
    EXPECT_EQ(counters().refused, 2U);
    EXPECT_EQ(feed(cut(NodeStatus{}, 29)), 1U);
}

TEST_F(Transfers, frames_beyond_the_rate_are_dropped_until_the_next_second) {
    for (uint8_t id = 0; id < 12; ++id) feed(cut(NodeStatus{}, 20, id));
    EXPECT_EQ(counters().transfers, 5U);
    EXPECT_EQ(counters().over_rate, 7U);
    EXPECT_EQ(feed(cut(NodeStatus{}, 21)), 1U) << "another node's rate is its own";
    now_us += 1'000'000;
    EXPECT_EQ(feed(cut(NodeStatus{}, 20, 12)), 1U);
}

TEST_F(Transfers, a_lost_frame_costs_its_transfer_only) {
    auto frames = cut(Status{}, 20, 3);
    ASSERT_EQ(frames.size(), 3U);
    frames.erase(frames.begin() + 1);
    EXPECT_EQ(feed(frames), 0U);
    EXPECT_EQ(feed(cut(Status{}, 20, 4)), 1U);
    EXPECT_EQ(counters().rejected(), 1U);
}

TEST_F(Transfers, a_frame_that_comes_twice_is_taken_once) {
    auto frames = cut(Status{.error_count = 7}, 20);
    frames.insert(frames.begin() + 1, frames[1]);
    frames.insert(frames.begin() + 1, frames[1]);
    EXPECT_EQ(feed(frames), 1U);
    Status status;
    ASSERT_TRUE(decode(receiver.payload(), status));
    EXPECT_EQ(status.error_count, 7U);
}

TEST_F(Transfers, a_transfer_that_comes_twice_is_taken_once) {
    EXPECT_EQ(feed(cut(NodeStatus{}, 20, 9)), 1U);
    EXPECT_EQ(feed(cut(NodeStatus{}, 20, 9)), 0U);
    EXPECT_EQ(counters().repeated, 1U);
    now_us += ReceiverCore::kTransferTimeout_us + 1;
    EXPECT_EQ(feed(cut(NodeStatus{}, 20, 9)), 1U) << "a node that restarted begins anew";
}

TEST_F(Transfers, a_wrong_byte_fails_the_checksum) {
    auto frames = cut(Status{}, 20);
    frames[1].data[3] ^= 0x10;
    EXPECT_EQ(feed(frames), 0U);
    EXPECT_EQ(counters().wrong_crc, 1U);
}

TEST_F(Transfers, a_transfer_left_open_for_long_is_broken_off) {
    auto frames = cut(Status{}, 20);
    EXPECT_EQ(feed({frames[0]}), 0U);
    now_us += ReceiverCore::kTransferTimeout_us + 1;
    EXPECT_EQ(feed({frames[1], frames[2]}), 0U);
    EXPECT_EQ(counters().broken_off, 1U);
    EXPECT_EQ(feed(cut(Status{}, 20, 1)), 1U);
}

TEST_F(Transfers, senders_interleave) {
    const auto a = cut(Status{.error_count = 1}, 20);
    const auto b = cut(Status{.error_count = 2}, 21);
    EXPECT_EQ(feed({a[0], b[0], b[1], a[1], a[2], b[2]}), 2U);
}

TEST_F(Transfers, longer_than_the_type_is_refused) {
    auto frames = cut(Status{}, 20);
    frames.back().data[frames.back().length - 1] &= static_cast<uint8_t>(~Tail::kEnd);
    feed(frames);
    Frame more{.id = frames[0].id, .length = 8};
    for (unsigned i = 0; i < 200; ++i) {
        more.data[7] = i % 2 == 0 ? Tail::kToggle : 0;
        EXPECT_FALSE(receiver.accept(more, now_us));
    }
    EXPECT_GE(counters().malformed, 1U);
    EXPECT_EQ(counters().transfers, 0U);
}

TEST_F(Transfers, sessions_are_few_and_come_free_with_time) {
    for (uint8_t node = 20; node < 25; ++node) feed(cut(NodeStatus{}, node));
    EXPECT_EQ(counters().transfers, 3U);
    EXPECT_EQ(counters().no_room, 2U);
    now_us += ReceiverCore::kTransferTimeout_us + 1;
    EXPECT_EQ(feed(cut(NodeStatus{}, 24)), 1U);
}

TEST_F(Transfers, a_request_for_another_node_is_not_ours) {
    auto frames = cut(RestartNode::Request{}, 20);
    frames[0].id ^= 0x100;
    EXPECT_EQ(feed(frames), 0U);
    EXPECT_EQ(counters().rejected(), 0U);
    EXPECT_EQ(feed(cut(RestartNode::Request{}, 20)), 1U);
}

TEST_F(Transfers, a_node_without_id_has_one_frame_and_no_count) {
    Allocation request;
    request.unique_id.count = 6;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(feed(cut(request, 0)), 1U);
    EXPECT_EQ(receiver.header().discriminator, 77);
    EXPECT_TRUE(receiver.is<Allocation>());
    EXPECT_FALSE(receiver.is<NodeStatus>()) << "though its type ends in the same two bits";
    request.unique_id.count = 16;
    EXPECT_EQ(feed(cut(request, 0)), 0U);
    EXPECT_GT(counters().malformed, 0U);
}

TEST_F(Transfers, frames_of_no_length_and_of_impossible_length_are_refused) {
    Frame frame{.id = cut(NodeStatus{}, 20)[0].id, .length = 0};
    EXPECT_FALSE(receiver.accept(frame, now_us));
    frame.length = 255;
    EXPECT_FALSE(receiver.accept(frame, now_us));
    EXPECT_EQ(counters().malformed, 2U);
}

TEST_F(Transfers, one_in_progress_survives_a_flood_of_others) {
    const auto ours = cut(Status{.error_count = 5}, 20);
    EXPECT_EQ(feed({ours[0]}), 0U);
    for (uint8_t round = 0; round < 20; ++round) {
        for (uint8_t node = 21; node < 30; ++node) {
            feed({cut(Status{}, node, round)[0]});
            feed(cut(NodeStatus{}, node, round));
        }
    }
    EXPECT_GT(counters().no_room, 100U);
    EXPECT_EQ(feed({ours[1], ours[2]}), 1U);
    EXPECT_EQ(feed(cut(Status{}, 20, 1)), 1U) << "and so does its next one";
}

TEST_F(Transfers, of_one_sender_two_types_interleave) {
    const auto frames = cut(Status{}, 20);
    EXPECT_EQ(feed({frames[0], frames[1]}), 0U);
    EXPECT_EQ(feed(cut(NodeStatus{}, 20)), 1U);
    EXPECT_EQ(feed({frames[2]}), 1U);
}

TEST_F(Transfers, of_one_sender_and_type_the_newer_counts) {
    const auto first = cut(Status{.error_count = 1}, 20, 1);
    const auto second = cut(Status{.error_count = 2}, 20, 2);
    EXPECT_EQ(feed({first[0], first[1], second[0], first[2], second[1], second[2]}), 1U);
    EXPECT_EQ(receiver.transfer_id(), 2);
    EXPECT_EQ(counters().broken_off, 1U);
    EXPECT_EQ(counters().malformed, 1U) << "the first one's end is out of place";
}

TEST_F(Transfers, a_first_frame_that_comes_twice_begins_anew) {
    auto frames = cut(Status{}, 20);
    frames.insert(frames.begin(), frames[0]);
    EXPECT_EQ(feed(frames), 1U);
}

TEST_F(Transfers, the_toggle_begins_at_0) {
    auto several = cut(Status{}, 20);
    several[0].data[7] |= Tail::kToggle;
    EXPECT_EQ(feed(several), 0U);
    auto single = cut(NodeStatus{}, 20);
    single[0].data[7] |= Tail::kToggle;
    EXPECT_EQ(feed(single), 0U);
    EXPECT_EQ(counters().malformed, 4U) << "three frames and one";
    EXPECT_EQ(feed(cut(NodeStatus{}, 20)), 1U);
}

TEST_F(Transfers, only_the_last_frame_may_be_short) {
    for (const unsigned at : {0U, 1U}) {
        auto frames = cut(Status{}, 20, static_cast<uint8_t>(at));
        frames[at].data[4] = frames[at].data[7];
        frames[at].length = 5;
        EXPECT_EQ(feed(frames), 0U);
    }
    EXPECT_EQ(counters().transfers, 0U);
    EXPECT_EQ(counters().wrong_crc, 0U) << "known before the checksum";
    EXPECT_EQ(feed(cut(Status{}, 20, 2)), 1U);
}

TEST_F(Transfers, a_first_frame_of_its_tail_alone_is_none_of_several) {
    Frame frame{.id = cut(Status{}, 20)[0].id, .length = 1, .data = {Tail::kStart}};
    EXPECT_FALSE(receiver.accept(frame, now_us));
    EXPECT_EQ(counters().malformed, 1U);
}

TEST_F(Transfers, the_checksum_is_that_of_the_type) {
    auto frames = cut(Status{}, 20);
    uint16_t crc = 0;
    std::vector<uint8_t> payload;
    for (const Frame& frame : frames) {
        payload.insert(payload.end(), frame.data.begin(), frame.data.begin() + frame.length - 1);
    }
    payload.erase(payload.begin(), payload.begin() + 2);
    crc = crc16(crc_seed(0), payload);  // as a node reckons that knows another type by this id
    frames[0].data[0] = static_cast<uint8_t>(crc);
    frames[0].data[1] = static_cast<uint8_t>(crc >> 8);
    EXPECT_EQ(feed(frames), 0U);
    EXPECT_EQ(counters().wrong_crc, 1U);
}

TEST_F(Transfers, ids_go_round) {
    for (const uint8_t id : std::array<uint8_t, 3>{31, 0, 1})
        EXPECT_EQ(feed(cut(Status{}, 20, id)), 1U);
}

TEST_F(Transfers, a_short_type_in_a_long_frame_is_refused) {
    Frame frame = cut(RestartNode::Request{}, 20)[0];
    ASSERT_EQ(frame.length, 6);
    frame.data[6] = frame.data[5];
    frame.length = 7;
    EXPECT_FALSE(receiver.accept(frame, now_us));
    EXPECT_EQ(counters().malformed, 1U);
}

TEST_F(Transfers, ids_of_nodes_at_the_edges) {
    NodeSet nodes;
    nodes.add_range(-5, 500);
    EXPECT_EQ(nodes.size(), 128U);
    EXPECT_FALSE(nodes.has(128));
    receiver.allow(nodes);
    EXPECT_EQ(feed(cut(NodeStatus{}, 1)), 1U);
    EXPECT_EQ(feed(cut(NodeStatus{}, 127)), 1U);
    const Frame other{
        .id = to_id({.type_id = 2, .discriminator = 77}), .length = 1, .data = {0xC0}};
    EXPECT_FALSE(receiver.accept(other, now_us)) << "a node without id may not say this";
    Frame request = cut(RestartNode::Request{}, 20)[0];
    const auto to = [&](uint32_t destination) {
        request.id = (request.id & ~0x7F00U) | destination << 8;
        return receiver.accept(request, now_us);
    };
    EXPECT_FALSE(to(0)) << "nobody asks all";
    EXPECT_FALSE(to(127));
    EXPECT_TRUE(to(kOwnId));
}

TEST_F(Transfers, a_node_without_id_asks_nothing_and_answers_nothing) {
    EXPECT_EQ(feed(cut(RestartNode::Request{}, 0)), 0U);
    EXPECT_EQ(feed(cut(RestartNode::Response{}, 20)), 0U) << "nobody asked";
    EXPECT_EQ(counters().rejected(), 0U) << "others' business";
}

TEST(DroneCanFrame, identifiers_go_there_and_back) {
    for (uint32_t id = 0; id < (1U << 29); id += 12'345) {
        EXPECT_EQ(to_id(from_id(id)), id);
    }
}

}  // namespace
}  // namespace stator::dronecan
