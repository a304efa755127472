// The bxCAN driver against a model of the controller's registers. No chip has run it. This is
// about start, errors and lines; bxcan_frames_test.cpp about frames, bxcan_driver_test.cpp about
// the whole node.
#include "bxcan_fixture.hpp"

namespace stator::drivers::can::bxcan {
namespace {

using testing::Bxcan;
using testing::BxcanModel;
using testing::BxcanWire;
using State = CanInterfaceStatus::State;

// Registers and bits, as RM0090 has them.
constexpr uint32_t kMcr = 0x000;
constexpr uint32_t kIer = 0x014;
constexpr uint32_t kBtr = 0x01C;
constexpr uint32_t kFmr = 0x200;

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
    run(BxcanPort<BxcanWire>::kMaxLeave_us);
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
}  // namespace stator::drivers::can::bxcan
