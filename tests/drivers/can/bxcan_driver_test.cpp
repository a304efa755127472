// The whole CAN driver of STM32F4 chips, as an image runs it: activations with ports, and the
// registers' model for the chip's. No chip has run it.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "bxcan_wire.hpp"
#include "can_bxcan.hpp"
#include "stator/testing.hpp"

namespace stator::drivers::can::bxcan {
namespace {

using testing::BxcanModel;
using testing::BxcanWire;
using State = CanInterfaceStatus::State;

struct BxcanDriver : ::testing::Test {
    void SetUp() override {
        for (int i = 0; i < 5; ++i) {
            step();
            model.recessive(1);
        }
        ASSERT_EQ(status.state, State::kErrorActive);
    }
    void step(const CanFrame* sent = nullptr) {
        now_us += 1000;
        CanPorts ports{.now = now_us, .send = sent == nullptr ? Input<CanFrame>() : Input(*sent)};
        ports.fired.timers = 1;
        stator::testing::Probe told(ports.status, now_us);
        driver.step(ports);
        if (told.count() != 0) status = told.newest();
    }
    void send(uint32_t id, uint8_t first = 0) {
        const CanFrame frame = testing::frame(id, now_us, first);
        step(&frame);
    }
    // What others see: first byte of each frame, with an activation after each one.
    std::vector<uint32_t> seen() {
        std::vector<uint32_t> firsts;
        while (const auto message = model.transmit()) {
            firsts.push_back(message->words[0] & 0xFF);
            step();
        }
        return firsts;
    }

    BxcanModel model;
    CanDriver<BxcanPort<BxcanWire>> driver{
        BxcanPort<BxcanWire>({&model}, bxcan::bit_timing(42'000'000, 1'000'000))};
    CanInterfaceStatus status{};
    uint64_t now_us = 1'000'000;
};

// On bare metal, objects are made before the board starts its devices.
TEST(CanBxcan, takes_what_the_board_filled_in_after_it_was_made) {
    std::array<uint32_t, 160> registers{};
    CanBxcan::Device device{};
    CanBxcan driver(device);
    device = {.base = reinterpret_cast<uintptr_t>(registers.data()),
              .clock_hz = 42'000'000,
              .bit_rate = 1'000'000};
    CanPorts ports{.now = 1000};
    driver.step(ports);
    EXPECT_EQ(registers[0], kInitRequest);
}

TEST_F(BxcanDriver, each_activation_ends_with_open_lines) {
    model.receive(testing::message(0x100));
    ASSERT_TRUE(model.raises_received(0));
    EXPECT_TRUE(bxcan::take_line(BxcanWire{&model}, bxcan::kFifoNotEmpty));
    step();
    EXPECT_FALSE(model.raises_received(0)) << "it was read";
    model.receive(testing::message(0x100));
    EXPECT_TRUE(model.raises_received(0));
}

TEST_F(BxcanDriver, urgent_frames_go_first_whatever_fills_the_mailboxes) {
    // Another node keeps the bus busy: nothing of ours goes out meanwhile.
    for (uint8_t i = 0; i < 4; ++i) send(1000, i);
    for (uint8_t i = 0; i < 4; ++i) send(500, static_cast<uint8_t>(10 + i));
    send(100, 20);
    send(50, 30);
    step();
    EXPECT_EQ(seen(), (std::vector<uint32_t>{30, 20, 10, 11, 12, 13, 0, 1, 2, 3}));
    step();
    EXPECT_EQ(status.frames_tx, 10U) << "each is counted once, however often it was in a mailbox";
    EXPECT_EQ(status.tx_lost, 0U);
}

TEST_F(BxcanDriver, an_urgent_frame_waits_for_the_one_on_the_bus_and_no_longer) {
    send(1000, 1);
    model.begin_transmission();
    send(900, 2);
    send(800, 3);
    send(700, 4);
    send(5, 5);
    model.end_transmission();
    step();
    step();
    EXPECT_EQ(model.transmit()->words[0] & 0xFF, 5U);
}

TEST_F(BxcanDriver, without_anybody_to_acknowledge_frames_are_given_up_and_counted) {
    for (uint8_t i = 0; i < 5; ++i) send(100 + i, i);
    for (uint64_t t = 0; t < kMaxCanWait_us + 10'000; t += 1000) {
        model.begin_transmission();
        model.fail_transmission(BxcanModel::kAckError);
        step();
    }
    EXPECT_EQ(model.waiting(), 0U) << "an old motor command is worse than none";
    EXPECT_EQ(status.tx_lost, 5U);
    EXPECT_EQ(status.frames_tx, 0U);
    EXPECT_EQ(status.state, State::kErrorPassive);
    send(7, 77);
    EXPECT_EQ(seen(), std::vector<uint32_t>{77});
}

TEST_F(BxcanDriver, after_bus_off_only_new_frames_go_out) {
    for (uint8_t i = 0; i < 3; ++i) send(100, i);
    model.begin_transmission();
    model.count_errors(256);
    step();
    EXPECT_EQ(status.state, State::kBusOff);
    for (int i = 0; i < 110; ++i) step();
    model.recessive(128);
    step();
    EXPECT_EQ(status.state, State::kErrorActive);
    EXPECT_EQ(status.tx_lost, 3U);
    send(100, 9);
    EXPECT_EQ(seen(), std::vector<uint32_t>{9});
    EXPECT_EQ(status.frames_tx, 1U);
}

// A bus that is now free, now another's, now disturbed: each frame goes out once or is counted as
// lost, and those of an identifier keep their order.
TEST_F(BxcanDriver, no_frame_is_lost_unseen_doubled_or_out_of_order) {
    uint32_t random = 12345;
    const auto draw = [&](uint32_t count) {
        random = random * 1664525 + 1013904223;
        return (random >> 16) % count;
    };
    uint8_t given = 0;  // in this round, as the number in each frame
    uint64_t all = 0;
    uint64_t sent = 0;
    std::array<int, 4> last{};
    const auto note = [&](const std::optional<BxcanModel::Message>& message) {
        if (!message) return;
        ++sent;
        const uint32_t kind = (message->identifier >> 3) / 100;
        const int number = static_cast<int>(message->words[0] & 0xFF);
        EXPECT_GT(number, last[kind]) << "kind " << kind;
        last[kind] = number;
    };
    for (int round = 0; round < 200; ++round) {
        last = {-1, -1, -1, -1};
        given = 0;
        for (int i = 0; i < 200; ++i) {
            if (draw(5) == 0) {
                send(100 * draw(4), given++);
                ++all;
            } else {
                step();
            }
            if (draw(2) == 0) model.begin_transmission();
            const uint32_t event = draw(20);
            if (event < 7) note(model.end_transmission());
            if (event == 7) model.fail_transmission(BxcanModel::kAckError);
            if (event > 17) model.lose_arbitration();
        }
        for (int i = 0; i < 60; ++i) {
            note(model.transmit());
            step();
        }
    }
    EXPECT_EQ(status.frames_tx, sent);
    EXPECT_EQ(status.frames_tx + status.tx_lost, all);
    EXPECT_GT(sent, all / 2);
    EXPECT_GT(status.tx_lost, 0U);
    EXPECT_EQ(model.violations(), 0U);
}

}  // namespace
}  // namespace stator::drivers::can::bxcan
