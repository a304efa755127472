// What the bxCAN port does with its mailboxes and FIFOs, against a model of the controller's
// registers. No chip has run it.
#include "bxcan_fixture.hpp"

namespace stator::drivers::can::bxcan {
namespace {

using testing::Bxcan;
using testing::BxcanModel;

constexpr uint32_t kRemote = 1U << 1;  // of an identifier's register

// --- sending ---

TEST_F(Bxcan, sends_what_it_was_given) {
    start();
    ASSERT_EQ(send(0x1ABCDEF), CanSend::kSent);
    const auto sent = model.transmit();
    ASSERT_TRUE(sent);
    EXPECT_EQ(sent->identifier, 0x1ABCDEFU << 3 | 1U << 2);
    EXPECT_EQ(sent->length, 8U);
    EXPECT_EQ(sent->words, (std::array<uint32_t, 2>{0x04030200, 0x08070605}));
    CanFrame shorter{.timestamp = now_us, .id = 0x123, .length = 2, .data = {0xAA, 0xBB}};
    run();
    ASSERT_EQ(port.send(shorter), CanSend::kSent);
    EXPECT_EQ(model.transmit()->identifier, 0x123U << 21) << "a standard one";
}

TEST_F(Bxcan, frames_of_one_identifier_keep_their_order) {
    start();
    // Mailbox 0 comes free while 1 waits: the next frame must not overtake.
    ASSERT_EQ(send(5, 1), CanSend::kSent);
    ASSERT_EQ(send(4, 9), CanSend::kSent);
    ASSERT_EQ(model.transmit()->words[0] & 0xFF, 9U);
    run();
    ASSERT_EQ(send(5, 2), CanSend::kSent);
    EXPECT_EQ(model.transmit()->words[0] & 0xFF, 1U);
    run();
    EXPECT_EQ(send(5, 3), CanSend::kSent);
    EXPECT_EQ(model.transmit()->words[0] & 0xFF, 2U);
    EXPECT_EQ(model.transmit()->words[0] & 0xFF, 3U);
}

TEST_F(Bxcan, the_last_mailbox_is_for_what_is_most_urgent) {
    start();
    EXPECT_EQ(send(100), CanSend::kSent);
    EXPECT_EQ(send(90), CanSend::kSent);
    EXPECT_EQ(send(95), CanSend::kFull);
    EXPECT_EQ(send(10), CanSend::kSent);
    EXPECT_EQ(send(11), CanSend::kFull);
    EXPECT_EQ(transmit_all(), (std::vector<uint32_t>{10, 90, 100}));
    run();
    EXPECT_EQ(send(95), CanSend::kSent);
}

TEST_F(Bxcan, a_more_urgent_frame_takes_the_place_of_the_least_urgent) {
    start();
    for (const uint32_t id : {90U, 100U, 10U}) ASSERT_EQ(send(id, uint8_t(id)), CanSend::kSent);
    EXPECT_EQ(send(1), CanSend::kFull);
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{100});
    EXPECT_EQ(send(1), CanSend::kSent);
    EXPECT_EQ(transmit_all(), (std::vector<uint32_t>{1, 10, 90}));
}

TEST_F(Bxcan, of_equal_ones_the_last_makes_room) {
    start();
    ASSERT_EQ(send(100, 1), CanSend::kSent);
    ASSERT_EQ(send(100, 2), CanSend::kSent);
    ASSERT_EQ(send(10, 3), CanSend::kSent);
    EXPECT_EQ(send(1), CanSend::kFull);
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{2});
}

TEST_F(Bxcan, a_frame_that_is_being_sent_is_not_sent_twice) {
    start();
    ASSERT_EQ(send(100, 1), CanSend::kSent);
    model.begin_transmission();
    ASSERT_EQ(send(90), CanSend::kSent);
    ASSERT_EQ(send(10), CanSend::kSent);
    EXPECT_EQ(send(1), CanSend::kFull);
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{}) << "nobody knows yet";
    EXPECT_EQ(send(1), CanSend::kFull);
    EXPECT_EQ(model.end_transmission()->words[0] & 0xFF, 1U);
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{});
    EXPECT_EQ(send(1), CanSend::kSent);
}

TEST_F(Bxcan, an_aborted_frame_that_lost_the_arbitration_comes_back) {
    start();
    ASSERT_EQ(send(100, 1), CanSend::kSent);
    model.begin_transmission();
    ASSERT_EQ(send(90), CanSend::kSent);
    ASSERT_EQ(send(10), CanSend::kSent);
    EXPECT_EQ(send(1), CanSend::kFull);
    model.lose_arbitration();
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{1});
}

TEST_F(Bxcan, no_frame_overtakes_an_aborted_one_of_its_identifier) {
    start();
    ASSERT_EQ(send(5, 1), CanSend::kSent);
    ASSERT_EQ(send(5, 2), CanSend::kSent);
    model.begin_transmission();
    run(kMaxCanWait_us + 1);
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{2}) << "the first is on its way";
    EXPECT_EQ(send(5, 2), CanSend::kFull);
    model.fail_transmission(BxcanModel::kAckError);
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{1});
    EXPECT_EQ(send(5, 1), CanSend::kSent);
}

TEST_F(Bxcan, several_come_back_the_last_of_an_identifier_first) {
    start();
    ASSERT_EQ(send(5, 1), CanSend::kSent);
    ASSERT_EQ(send(5, 2), CanSend::kSent);
    run(kMaxCanWait_us + 1);
    run();
    EXPECT_EQ(taken_back(), (std::vector<uint32_t>{2, 1}));
}

TEST_F(Bxcan, what_is_younger_stays_in_its_mailbox) {
    start();
    ASSERT_EQ(send(6, 1), CanSend::kSent);
    run(kMaxCanWait_us / 2);
    ASSERT_EQ(send(5, 2), CanSend::kSent);
    run(kMaxCanWait_us / 2 + 1);
    run();
    EXPECT_EQ(taken_back(), std::vector<uint32_t>{1});
    EXPECT_EQ(transmit_all(), std::vector<uint32_t>{5});
}

// --- receiving ---

TEST_F(Bxcan, receives_from_both_fifos) {
    start();
    model.receive(testing::message(0x100));         // a message
    model.receive(testing::message(0x100 | 0x80));  // a service
    model.receive({0x123U << 21, 2, {0xBBAA, 0}});
    const auto got = received();
    ASSERT_EQ(got.size(), 3U);
    EXPECT_EQ(got[0].id, 0x180U);
    EXPECT_EQ(got[1].id, 0x100U);
    EXPECT_EQ(got[1].data, (std::array<uint8_t, 8>{1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(got[2].id, 0x123U);
    EXPECT_FALSE(got[2].extended);
    EXPECT_EQ(got[2].length, 2);
}

TEST_F(Bxcan, every_bit_of_an_identifier_arrives) {
    start();
    for (unsigned bit = 0; bit < 29; ++bit) {
        model.receive(testing::message(1U << bit));
        const auto got = received();
        ASSERT_EQ(got.size(), 1U);
        EXPECT_EQ(got[0].id, 1U << bit);
        EXPECT_TRUE(got[0].extended);
    }
}

TEST_F(Bxcan, an_overrun_of_one_fifo_is_counted_and_spares_the_other) {
    start();
    for (int i = 0; i < 5; ++i) model.receive(testing::message(0x100));
    model.receive(testing::message(0x180));
    EXPECT_EQ(received().size(), 4U);
    EXPECT_EQ(counts().rx_lost, 1U);
    model.receive(testing::message(0x100));
    EXPECT_EQ(received().size(), 1U);
    EXPECT_EQ(counts().rx_lost, 1U);
}

TEST_F(Bxcan, a_full_fifo_is_no_overrun) {
    start();
    for (uint32_t i = 0; i < 3; ++i) model.receive(testing::message(0x100 + i));
    const auto got = received();
    ASSERT_EQ(got.size(), 3U);
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(got[i].id, 0x100 + i) << "in their order";
    EXPECT_EQ(counts().rx_lost, 0U);
}

TEST_F(Bxcan, a_frame_whose_release_takes_time_is_not_read_twice) {
    start();
    model.set_slow_release(true);
    model.receive(testing::message(0x100));
    model.receive(testing::message(0x101));
    EXPECT_EQ(received().size(), 1U);
    EXPECT_EQ(received().size(), 0U);
    model.finish_release();
    const auto got = received();
    ASSERT_EQ(got.size(), 1U);
    EXPECT_EQ(got[0].id, 0x101U);
}

TEST_F(Bxcan, an_impossible_length_is_at_most_8) {
    start();
    auto longer = testing::message(0x100);
    longer.length = 0xF | 0xFFFF0000;  // DLC of up to 15 means 8 bytes; a time stamp is above it
    model.receive(longer);
    const auto got = received();
    ASSERT_EQ(got.size(), 1U);
    EXPECT_EQ(got[0].length, 8);
}

TEST_F(Bxcan, remote_frames_do_not_pass_the_filter) {
    start();
    for (const uint32_t id : {0x100U, 0x180U}) {
        model.receive({testing::message(id).identifier | kRemote, 8, {}});
    }
    model.receive({0x123U << 21 | kRemote, 8, {}});
    EXPECT_EQ(received().size(), 0U);
    EXPECT_EQ(counts().rx_ignored, 0U) << "they would take the place of others in a FIFO";
}

}  // namespace
}  // namespace stator::drivers::can::bxcan
