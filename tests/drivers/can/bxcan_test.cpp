// The bxCAN driver against a model of the controller's registers. No chip has run it. Tests of the
// port alone; bxcan_driver_test.cpp has those of the whole node.
#include <gtest/gtest.h>

#include <vector>

#include "bxcan_model.hpp"
#include "bxcan_wire.hpp"

namespace stator {
namespace {

using testing::BxcanModel;
using testing::BxcanWire;
using State = CanInterfaceStatus::State;

// Registers and bits, as RM0090 has them.
constexpr uint32_t kMcr = 0x000;
constexpr uint32_t kIer = 0x014;
constexpr uint32_t kBtr = 0x01C;
constexpr uint32_t kFmr = 0x200;
constexpr uint32_t kRemote = 1U << 1;

struct Bxcan : ::testing::Test {
    ~Bxcan() override { EXPECT_EQ(model.violations(), 0U) << "written while it was protected"; }

    // With a bus that is idle.
    void start() {
        for (int i = 0; i < 5; ++i) {
            run();
            model.recessive(1);
        }
        ASSERT_EQ(port.state(), State::kErrorActive);
    }
    void run(uint64_t step_us = 1000) { port.begin(now_us += step_us); }
    CanSend send(uint32_t id, uint8_t first = 0) {
        return port.send(testing::frame(id, now_us, first));
    }
    CanInterfaceStatus counts() const {
        CanInterfaceStatus status{};
        port.count(status);
        return status;
    }
    std::vector<uint32_t> transmit_all() {
        std::vector<uint32_t> ids;
        while (const auto sent = model.transmit()) ids.push_back(sent->identifier >> 3);
        return ids;
    }
    std::vector<uint32_t> taken_back() {
        std::vector<uint32_t> firsts;
        for (CanFrame f; port.take_back(f);) firsts.push_back(f.data[0]);
        return firsts;
    }
    std::vector<CanFrame> received() {
        std::vector<CanFrame> frames;
        for (CanFrame f; port.receive(f, now_us);) frames.push_back(f);
        return frames;
    }

    BxcanModel model;
    BxcanPort<BxcanWire> port{{&model}, bxcan::bit_timing(42'000'000, 1'000'000)};
    uint64_t now_us = 1'000'000;
};

TEST(BxcanTiming, makes_the_bit_rate_and_samples_late) {
    for (const uint32_t bit_rate : {1'000'000U, 500'000U, 250'000U, 125'000U}) {
        const uint32_t value = bxcan::bit_timing(42'000'000, bit_rate);
        const uint32_t prescaler = (value & 0x3FF) + 1;
        const uint32_t segment1 = ((value >> 16) & 0xF) + 1;
        const uint32_t segment2 = ((value >> 20) & 0x7) + 1;
        const uint32_t jump = ((value >> 24) & 0x3) + 1;
        EXPECT_EQ(42'000'000U, bit_rate * prescaler * (1 + segment1 + segment2));
        EXPECT_GE(100 * (1 + segment1), 75 * (1 + segment1 + segment2));
        EXPECT_LE(jump, segment2) << "the manual's bound";
        EXPECT_EQ(value >> 26, 0U) << "neither silent nor loop-back";
    }
    // 32.7.7 by hand: 3 * (1 + 10 + 3) / 42 MHz = 1 us, sampled at 11 of 14, jumps of 3.
    EXPECT_EQ(bxcan::bit_timing(42'000'000, 1'000'000), 0x02290002U);
    EXPECT_EQ(bxcan::bit_timing(42'000'000, 999'983), 0U);
    EXPECT_EQ(bxcan::bit_timing(42'000'000, 0), 0U);
}

// --- start ---

TEST_F(Bxcan, starts_in_steps_and_is_down_until_then) {
    EXPECT_EQ(send(1), CanSend::kFull);
    EXPECT_EQ(port.state(), State::kDown);
    start();
    EXPECT_EQ(model.plain(kBtr), 0x02290002U);
    EXPECT_EQ(model.plain(kFmr), 0x2A1C0E00U) << "filters on; those of CAN2 where they were";
}

TEST_F(Bxcan, all_control_bits_are_off_and_so_is_the_freeze_by_a_debugger) {
    start();
    EXPECT_EQ(model.plain(kMcr), 0U);
}

TEST_F(Bxcan, without_a_bit_timing_it_stays_down) {
    BxcanPort<BxcanWire> other{{&model}, 0};
    for (int i = 0; i < 9; ++i) other.begin(now_us += 1000);
    EXPECT_EQ(other.state(), State::kDown);
    EXPECT_EQ(other.send(testing::frame(1, now_us)), CanSend::kFull);
}

TEST_F(Bxcan, a_controller_that_does_not_answer_is_asked_again) {
    model.set_answering(false);
    for (int i = 0; i < 5; ++i) run(60'000);
    EXPECT_EQ(port.state(), State::kDown);
    EXPECT_GE(counts().io_errors, 1U);
}

TEST_F(Bxcan, a_bus_that_is_never_idle_keeps_it_down_and_it_tries_again) {
    for (int i = 0; i < 2; ++i) run();
    run(BxcanPort<BxcanWire>::kMostLeave_us);
    EXPECT_EQ(counts().io_errors, 0U);
    run();
    EXPECT_EQ(counts().io_errors, 1U);
    EXPECT_EQ(port.state(), State::kDown);
    start();
    EXPECT_EQ(counts().io_errors, 1U);
}

TEST_F(Bxcan, nothing_that_an_earlier_run_left_in_a_mailbox_goes_out) {
    start();
    ASSERT_EQ(send(5), CanSend::kSent);
    BxcanPort<BxcanWire> next{{&model}, bxcan::bit_timing(42'000'000, 1'000'000)};
    for (int i = 0; i < 5; ++i) {
        next.begin(now_us += 1000);
        model.recessive(1);
    }
    EXPECT_EQ(next.state(), State::kErrorActive);
    EXPECT_EQ(model.waiting(), 0U);
}

TEST_F(Bxcan, a_mailbox_that_does_not_come_free_keeps_it_off_the_bus) {
    start();
    ASSERT_EQ(send(5), CanSend::kSent);
    model.set_heeding_aborts(false);
    model.count_errors(256);
    for (int i = 0; i < 4; ++i) {
        run(BxcanPort<BxcanWire>::kBusOffPause_us);
        model.recessive(128);
    }
    EXPECT_EQ(port.state(), State::kBusOff);
    EXPECT_EQ(send(6), CanSend::kFull) << "whose mailbox would it be";
}

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
    run(kMostCanWait_us + 1);
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
    run(kMostCanWait_us + 1);
    run();
    EXPECT_EQ(taken_back(), (std::vector<uint32_t>{2, 1}));
}

TEST_F(Bxcan, what_is_younger_stays_in_its_mailbox) {
    start();
    ASSERT_EQ(send(6, 1), CanSend::kSent);
    run(kMostCanWait_us / 2);
    ASSERT_EQ(send(5, 2), CanSend::kSent);
    run(kMostCanWait_us / 2 + 1);
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

// --- errors ---

TEST_F(Bxcan, tells_the_state_of_the_controller) {
    start();
    for (const auto& [errors, state] : {std::pair{96U, State::kErrorWarning},
                                        {127U, State::kErrorWarning},
                                        {128U, State::kErrorPassive},
                                        {95U, State::kErrorActive}}) {
        model.count_errors(errors);
        run();
        EXPECT_EQ(port.state(), state) << errors;
    }
}

TEST_F(Bxcan, alone_on_the_bus_it_is_passive_and_not_off) {
    start();
    ASSERT_EQ(send(5), CanSend::kSent);
    for (int i = 0; i < 100; ++i) {
        model.begin_transmission();
        model.fail_transmission(BxcanModel::kAckError);
        run(100);
    }
    EXPECT_EQ(port.state(), State::kErrorPassive);
    EXPECT_EQ(counts().io_errors, 100U) << "each is seen once";
    run();
    EXPECT_EQ(counts().io_errors, 100U);
    EXPECT_EQ(transmit_all(), std::vector<uint32_t>{5}) << "somebody is there now";
}

TEST_F(Bxcan, comes_back_from_bus_off_after_a_pause_and_128_idle_sequences) {
    start();
    ASSERT_EQ(send(5, 1), CanSend::kSent);
    ASSERT_EQ(send(5, 2), CanSend::kSent);
    model.begin_transmission();
    model.count_errors(256);
    run();
    EXPECT_EQ(port.state(), State::kBusOff);
    EXPECT_EQ(counts().bus_off_count, 1U);
    EXPECT_EQ(send(6), CanSend::kFull);
    run();
    EXPECT_EQ(taken_back(), (std::vector<uint32_t>{2, 1})) << "nothing is lost unseen";
    run(BxcanPort<BxcanWire>::kBusOffPause_us / 2);
    model.recessive(200);
    EXPECT_EQ(port.state(), State::kBusOff) << "not by itself";
    run(BxcanPort<BxcanWire>::kBusOffPause_us);
    run();
    model.recessive(127);
    run();
    EXPECT_EQ(port.state(), State::kBusOff);
    model.recessive(1);
    run();
    EXPECT_EQ(port.state(), State::kErrorActive);
    EXPECT_EQ(model.waiting(), 0U) << "nothing old goes out";
    EXPECT_EQ(send(6), CanSend::kSent);
    EXPECT_EQ(counts().bus_off_count, 1U);
}

TEST_F(Bxcan, a_bus_that_stays_disturbed_keeps_it_off) {
    start();
    model.count_errors(256);
    run();
    for (int i = 0; i < 20; ++i) run(60'000);
    EXPECT_EQ(port.state(), State::kBusOff);
    EXPECT_EQ(counts().bus_off_count, 1U);
    EXPECT_GE(counts().io_errors, 1U) << "it gave up and began anew";
}

// --- lines ---

TEST_F(Bxcan, a_line_that_was_taken_is_out_until_the_driver_has_run) {
    start();
    port.end();
    model.receive(testing::message(0x180));
    ASSERT_TRUE(model.raises_received(1));
    const BxcanWire wire{&model};
    EXPECT_TRUE(bxcan::take_line(wire, bxcan::kFifoNotEmpty));
    EXPECT_FALSE(model.raises_received(1));
    EXPECT_FALSE(bxcan::take_line(wire, bxcan::kFifoNotEmpty)) << "the other FIFO's vector";
    run();
    EXPECT_EQ(received().size(), 1U);
    port.end();
    EXPECT_FALSE(model.raises_received(1));
    model.receive(testing::message(0x100));
    EXPECT_TRUE(model.raises_received(0));
}

TEST_F(Bxcan, a_sent_frame_and_an_aborted_one_raise_sent) {
    start();
    ASSERT_EQ(send(5), CanSend::kSent);
    port.end();
    EXPECT_FALSE(model.raises_sent());
    model.transmit();
    EXPECT_TRUE(model.raises_sent());
    run();
    EXPECT_FALSE(model.raises_sent());
    for (const uint32_t id : {90U, 100U, 10U, 1U}) static_cast<void>(send(id));
    port.end();
    EXPECT_TRUE(model.raises_sent());
}

TEST_F(Bxcan, each_worse_state_raises_changed_once) {
    start();
    for (const unsigned errors : {96U, 128U, 256U}) {
        port.end();
        model.count_errors(errors);
        EXPECT_TRUE(model.raises_changed()) << errors;
        run();
        port.end();
        EXPECT_FALSE(model.raises_changed()) << errors;
    }
}

TEST_F(Bxcan, nothing_is_raised_that_no_activation_would_take_away) {
    start();
    model.count_errors(256);
    model.receive(testing::message(0x100));
    run();
    port.end();
    EXPECT_EQ(model.plain(kIer), 0U) << "it pauses, and reads no FIFO";
}

}  // namespace
}  // namespace stator
