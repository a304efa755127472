// The bxCAN driver against a model of the controller's registers. No chip has run it.
#include <gtest/gtest.h>

#include <vector>

#include "bxcan_model.hpp"

namespace stator {
namespace {

using testing::BxcanModel;
using State = CanInterfaceStatus::State;

// What the port is given in place of the chip's registers.
struct Wire {
    BxcanModel* model;
    uint32_t read(uint32_t offset) const { return model->read(offset); }
    void write(uint32_t offset, uint32_t value) const { model->write(offset, value); }
};

CanFrame frame(uint32_t id, uint8_t first = 0) {
    return {.id = id, .extended = true, .length = 8, .data = {first, 2, 3, 4, 5, 6, 7, 8}};
}
BxcanModel::Message message(uint32_t id) {
    return {(id << bxcan::kExtendedShift) | bxcan::kExtended, 8, {0x04030201, 0x08070605}};
}

struct Bxcan : ::testing::Test {
    void start() {
        for (int i = 0; i < 4; ++i) run();
    }
    void run(uint64_t step_us = 1000) { port.begin(now_us += step_us); }
    CanInterfaceStatus counts() const {
        CanInterfaceStatus status{};
        port.count(status);
        return status;
    }
    std::vector<uint32_t> transmit_all() {
        std::vector<uint32_t> ids;
        while (const auto sent = model.transmit()) {
            ids.push_back(sent->identifier >> bxcan::kExtendedShift);
        }
        return ids;
    }

    BxcanModel model;
    BxcanPort<Wire> port{Wire{&model}, bxcan::bit_timing(42'000'000, 1'000'000)};
    uint64_t now_us = 0;
};

TEST(BxcanTiming, makes_the_bit_rate_and_samples_late) {
    for (const uint32_t bit_rate : {1'000'000U, 500'000U, 250'000U, 125'000U}) {
        const uint32_t value = bxcan::bit_timing(42'000'000, bit_rate);
        const uint32_t prescaler = (value & 0x3FF) + 1;
        const uint32_t segment1 = ((value >> 16) & 0xF) + 1;
        const uint32_t segment2 = ((value >> 20) & 0x7) + 1;
        EXPECT_EQ(42'000'000U, bit_rate * prescaler * (1 + segment1 + segment2));
        EXPECT_GE(100 * (1 + segment1), 75 * (1 + segment1 + segment2));
    }
    EXPECT_EQ(bxcan::bit_timing(42'000'000, 999'983), 0U);
    EXPECT_EQ(bxcan::bit_timing(42'000'000, 0), 0U);
}

TEST_F(Bxcan, starts_in_steps_and_is_down_until_then) {
    EXPECT_EQ(port.send(frame(1)), CanSend::kFull);
    EXPECT_EQ(port.state(), State::kDown);
    start();
    EXPECT_EQ(port.state(), State::kErrorActive);
    EXPECT_EQ(model.plain(bxcan::kBitTiming), bxcan::bit_timing(42'000'000, 1'000'000));
    EXPECT_EQ(model.plain(bxcan::kFilterMaster) & bxcan::kFilterInit, 0U);
}

TEST_F(Bxcan, a_controller_that_does_not_answer_is_asked_again) {
    model.set_answering(false);
    for (int i = 0; i < 5; ++i) run(60'000);
    EXPECT_EQ(port.state(), State::kDown);
    EXPECT_GE(counts().io_errors, 1U);
}

TEST_F(Bxcan, a_controller_that_does_not_leave_its_reset_is_reset_again) {
    run();
    model.set_answering(false);  // initialising now, and for ever
    run();
    run(500'000);
    EXPECT_EQ(counts().io_errors, 0U);
    run();
    EXPECT_EQ(counts().io_errors, 1U);
    EXPECT_EQ(port.state(), State::kDown);
    model.set_answering(true);
    start();
    EXPECT_EQ(port.state(), State::kErrorActive);
    EXPECT_EQ(counts().io_errors, 1U);
}

TEST_F(Bxcan, sends_what_it_was_given) {
    start();
    ASSERT_EQ(port.send(frame(0x1ABCDEF)), CanSend::kSent);
    const auto sent = model.transmit();
    ASSERT_TRUE(sent);
    EXPECT_EQ(sent->identifier, (0x1ABCDEFU << 3) | bxcan::kExtended);
    EXPECT_EQ(sent->length, 8U);
    EXPECT_EQ(sent->words, (std::array<uint32_t, 2>{0x04030200, 0x08070605}));
}

TEST_F(Bxcan, frames_of_one_identifier_keep_their_order) {
    start();
    // Mailbox 0 comes free while 1 waits: the next frame must not overtake.
    ASSERT_EQ(port.send(frame(5, 1)), CanSend::kSent);
    ASSERT_EQ(port.send(frame(4, 9)), CanSend::kSent);
    ASSERT_EQ(model.transmit()->words[0] & 0xFF, 9U);
    run();
    ASSERT_EQ(port.send(frame(5, 2)), CanSend::kSent);
    EXPECT_EQ(model.transmit()->words[0] & 0xFF, 1U);
    run();
    EXPECT_EQ(port.send(frame(5, 3)), CanSend::kSent);
    EXPECT_EQ(model.transmit()->words[0] & 0xFF, 2U);
    EXPECT_EQ(model.transmit()->words[0] & 0xFF, 3U);
}

TEST_F(Bxcan, the_last_mailbox_is_for_what_is_most_urgent) {
    start();
    EXPECT_EQ(port.send(frame(100)), CanSend::kSent);
    EXPECT_EQ(port.send(frame(90)), CanSend::kSent);
    EXPECT_EQ(port.send(frame(95)), CanSend::kFull);
    EXPECT_EQ(port.send(frame(10)), CanSend::kSent);
    EXPECT_EQ(port.send(frame(1)), CanSend::kFull);
    EXPECT_EQ(transmit_all(), (std::vector<uint32_t>{10, 90, 100}));
    run();
    EXPECT_EQ(port.send(frame(95)), CanSend::kSent);
}

TEST_F(Bxcan, receives_from_both_fifos) {
    start();
    model.receive(message(0x100));         // a message
    model.receive(message(0x100 | 0x80));  // a service
    model.receive({0x123U << bxcan::kStandardShift, 2, {0xBBAA, 0}});
    std::vector<CanFrame> got;
    for (CanFrame f; port.receive(f, now_us);) got.push_back(f);
    ASSERT_EQ(got.size(), 3U);
    EXPECT_EQ(got[0].id, 0x180U);
    EXPECT_EQ(got[1].id, 0x100U);
    EXPECT_EQ(got[1].data, (std::array<uint8_t, 8>{1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(got[2].id, 0x123U);
    EXPECT_FALSE(got[2].extended);
    EXPECT_EQ(got[2].length, 2);
}

TEST_F(Bxcan, an_overrun_of_one_fifo_is_counted_and_spares_the_other) {
    start();
    for (int i = 0; i < 5; ++i) model.receive(message(0x100));
    model.receive(message(0x180));
    unsigned count = 0;
    for (CanFrame f; port.receive(f, now_us);) ++count;
    EXPECT_EQ(count, 4U);
    EXPECT_EQ(counts().rx_lost, 1U);
    model.receive(message(0x100));
    CanFrame f;
    EXPECT_TRUE(port.receive(f, now_us));
}

TEST_F(Bxcan, remote_frames_do_not_pass_the_filter) {
    start();
    model.receive({message(0x100).identifier | bxcan::kRemote, 8, {}});
    CanFrame f;
    EXPECT_FALSE(port.receive(f, now_us));
}

TEST_F(Bxcan, tells_the_state_of_the_controller) {
    start();
    model.set_errors(bxcan::kErrorWarning);
    run();
    EXPECT_EQ(port.state(), State::kErrorWarning);
    model.set_errors(bxcan::kErrorWarning | bxcan::kErrorPassive);
    run();
    EXPECT_EQ(port.state(), State::kErrorPassive);
    model.set_errors(0);
    run();
    EXPECT_EQ(port.state(), State::kErrorActive);
}

TEST_F(Bxcan, comes_back_from_bus_off_after_a_pause) {
    start();
    ASSERT_EQ(port.send(frame(5)), CanSend::kSent);
    model.set_errors(bxcan::kBusOff | bxcan::kErrorPassive);
    run();
    EXPECT_EQ(port.state(), State::kBusOff);
    EXPECT_EQ(counts().bus_off_count, 1U);
    EXPECT_EQ(port.send(frame(6)), CanSend::kFull);
    run(BxcanPort<Wire>::kBusOffPause_us / 2);
    EXPECT_EQ(port.state(), State::kBusOff);
    run(BxcanPort<Wire>::kBusOffPause_us);
    start();
    EXPECT_EQ(port.state(), State::kErrorActive);
    EXPECT_EQ(model.waiting(), 0U) << "nothing old goes out";
    EXPECT_EQ(port.send(frame(6)), CanSend::kSent);
    EXPECT_EQ(counts().bus_off_count, 1U);
}

}  // namespace
}  // namespace stator
