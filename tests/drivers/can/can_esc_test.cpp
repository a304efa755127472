// The node for motor controllers on a CAN bus, called with frames.
#include "can_esc.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "frames.hpp"
#include "stator/dronecan/crc.hpp"
#include "stator/dronecan/float16.hpp"
#include "stator/math/bits.hpp"
#include "stator/testing.hpp"

namespace stator::apps::can_esc {
namespace {

using dronecan::equipment::esc::RawCommand;
using dronecan::equipment::esc::Status;

// Replaces a field's 16 bits, which stand in whole bytes, and mends the checksum.
template <class Message>
void patch(std::vector<CanFrame>& frames, uint16_t from, uint16_t to) {
    std::vector<uint8_t*> payload;
    for (CanFrame& frame : frames) {
        for (unsigned i = 0; i + 1U < frame.length; ++i) payload.push_back(&frame.data[i]);
    }
    for (std::size_t i = 2; i + 1 < payload.size(); ++i) {
        if (*payload[i] != (from & 0xFF) || *payload[i + 1] != from >> 8) continue;
        *payload[i] = static_cast<uint8_t>(to);
        *payload[i + 1] = static_cast<uint8_t>(to >> 8);
        break;
    }
    uint16_t crc = Message::kType.crc_seed;
    for (std::size_t i = 2; i < payload.size(); ++i) crc = dronecan::crc16(crc, *payload[i]);
    *payload[0] = static_cast<uint8_t>(crc);
    *payload[1] = static_cast<uint8_t>(crc >> 8);
}

struct Esc : ::testing::Test {
    // One activation for each frame, and the newest report.
    void feed(const std::vector<CanFrame>& frames) {
        for (const CanFrame& frame : frames) step(&frame, nullptr);
    }
    void step(const CanFrame* frame, const ActuatorMotors* motors) {
        CanEscPorts ports{.now = now_us,
                          .motors = motors == nullptr ? Input<ActuatorMotors>() : Input(*motors),
                          .can = frame == nullptr ? Input<CanFrame>() : Input(*frame),
                          .params = Input(params, is_first)};
        is_first = false;
        stator::testing::Probe sent(ports.frames, now_us);
        stator::testing::Probe reported(ports.report, now_us);
        node.step(ports);
        commands += sent.count();
        if (sent.count() != 0) newest = sent.newest();
        if (reported.count() != 0) report = reported.newest();
    }
    EscStatus report_now() {
        now_us += 100'000;
        step(nullptr, nullptr);
        return report;
    }
    static Status status(uint8_t index) {
        return {.voltage = 12.0F, .temperature = 300.0F, .rpm = 5000, .esc_index = index};
    }

    CanEsc node;
    CanEscParams params{.node_id = kOwnId,
                        .esc_count = 4,
                        .command_interval = 2500,
                        .first_node = 20,
                        .last_node = 23,
                        .offline_timeout = 1.0F};
    bool is_first = true;
    uint64_t now_us = 1'000'000;
    uint32_t commands = 0;
    CanFrame newest{};
    EscStatus report{};
};

TEST_F(Esc, commands_go_out_and_a_stopped_motor_is_zero) {
    ActuatorMotors motors{.timestamp_sample = 7};
    motors.control.fill(math::canonical_nan<float>());
    motors.control[0] = 0.5F;
    motors.control[1] = 0.0F;  // turns, as slowly as it can
    motors.control[2] = 1.5F;
    step(nullptr, &motors);
    const auto command = decoded<RawCommand>(newest);
    ASSERT_EQ(command.cmd.count, 4);
    EXPECT_EQ(command.cmd.items[0], 4096);
    EXPECT_EQ(command.cmd.items[1], 1);
    EXPECT_EQ(command.cmd.items[2], 8191);
    EXPECT_EQ(command.cmd.items[3], 0);
    EXPECT_EQ(newest.timestamp_sample, 7U);
}

TEST_F(Esc, the_first_sample_of_each_interval_goes_out) {
    for (const uint64_t sample_us : {0, 1000, 2000, 3000, 4000, 5000, 6000, 7000, 8000, 10'000}) {
        ActuatorMotors motors{.timestamp = 1'000'000 + sample_us, .timestamp_sample = sample_us};
        step(nullptr, &motors);
        now_us += 1000;
    }
    EXPECT_EQ(commands, 5U) << "0, 3, 5, 8, 10 ms, as min_interval has it";
    EXPECT_EQ(newest.timestamp_sample, 10'000U);
}

TEST_F(Esc, without_commands_all_are_told_to_stop) {
    step(nullptr, nullptr);
    const auto command = decoded<RawCommand>(newest);
    ASSERT_EQ(command.cmd.count, 4);
    for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(command.cmd.items[i], 0);
    now_us += 5'000;
    step(nullptr, nullptr);
    EXPECT_EQ(commands, 1U) << "50 times a second is enough";
}

TEST_F(Esc, reports_are_collected_and_get_old) {
    feed(frames_of(status(2), 21, now_us));
    EscStatus now = report_now();
    EXPECT_EQ(now.esc_online_flags, 0b100);
    EXPECT_EQ(now.esc_rpm[2], 5000);
    EXPECT_EQ(now.esc_address[2], 21);
    EXPECT_NEAR(now.esc_temperature[2], 26.85F, 0.13F);  // binary16 has steps of 0.25 K there
    now_us += 1'000'000;
    now = report_now();
    EXPECT_EQ(now.esc_online_flags, 0);
    EXPECT_EQ(now.esc_rpm[2], 0);
}

TEST_F(Esc, a_controller_that_reports_after_a_late_release_is_online) {
    now_us += 100'000;  // of the release, which is served when the frames are there
    const auto frames = frames_of(status(1), 21, now_us + 300);
    feed({frames[0], frames[1]});
    now_us += 100'000;
    CanFrame last = frames[2];
    last.timestamp = now_us + 300;
    feed({last});
    EXPECT_EQ(report.esc_online_flags, 0b0010);
}

TEST_F(Esc, a_controller_speaks_for_itself_only) {
    feed(frames_of(status(1), 20, now_us));
    feed(frames_of(status(1), 21, now_us));
    EXPECT_EQ(report_now().esc_address[1], 20);
    EXPECT_EQ(report.rejected, 1U);
}

TEST_F(Esc, impossible_values_and_strangers_are_counted) {
    Status hot = status(0);
    hot.temperature = 5000.0F;
    Status reversed = status(0);
    reversed.voltage = -1.0F;
    feed(frames_of(hot, 20, now_us, 0));
    feed(frames_of(reversed, 20, now_us, 1));
    feed(frames_of(status(4), 20, now_us, 2));
    feed(frames_of(status(0), 24, now_us, 3));
    EXPECT_EQ(report_now().esc_online_flags, 0);
    EXPECT_EQ(report.rejected, 3U + 3U) << "three transfers, and the stranger's three frames";
}

TEST_F(Esc, a_field_that_a_controller_does_not_measure_is_nan_and_the_others_count) {
    Status report_0 = status(0);
    report_0.voltage = math::canonical_nan<float>();
    Status report_1 = status(1);
    report_1.current = math::canonical_nan<float>();
    Status report_2 = status(2);
    report_2.temperature = math::canonical_nan<float>();
    Status report_3{.rpm = 5000, .esc_index = 3};
    report_3.voltage = report_3.current = report_3.temperature = math::canonical_nan<float>();
    feed(frames_of(report_0, 20, now_us));
    feed(frames_of(report_1, 21, now_us));
    feed(frames_of(report_2, 22, now_us));
    feed(frames_of(report_3, 23, now_us));
    const EscStatus now = report_now();
    EXPECT_EQ(now.esc_online_flags, 0b1111);
    EXPECT_EQ(now.rejected, 0U);
    for (unsigned i = 0; i < 4; ++i) {
        EXPECT_EQ(now.esc_rpm[i], 5000);
        EXPECT_EQ(math::is_nan(now.esc_voltage[i]), i == 0 || i == 3);
        EXPECT_EQ(math::is_nan(now.esc_current[i]), i == 1 || i == 3);
        EXPECT_EQ(math::is_nan(now.esc_temperature[i]), i == 2 || i == 3);
    }
    EXPECT_EQ(now.esc_voltage[1], 12.0F);
}

TEST_F(Esc, an_infinite_field_is_refused_and_any_nan_is_unknown) {
    using Field = float Status::*;
    uint8_t transfer_id = 0;
    for (const Field field : {&Status::voltage, &Status::current, &Status::temperature}) {
        // Infinite numbers are not sent; so as bits of a frame.
        for (const uint16_t bits : std::array<uint16_t, 2>{0x7C00, 0xFC00}) {
            Status bad = status(0);
            bad.*field = 1.0F;
            auto frames = frames_of(bad, 20, now_us, transfer_id++);
            patch<Status>(frames, dronecan::to_float16(1.0F), bits);
            feed(frames);
        }
    }
    EXPECT_EQ(report_now().esc_online_flags, 0);
    EXPECT_EQ(report.rejected, 6U);
    for (const uint16_t bits : std::array<uint16_t, 4>{0x7E00, 0x7FFF, 0x7C01, 0xFE00}) {
        Status unknown = status(0);
        unknown.current = 1.0F;
        auto frames = frames_of(unknown, 20, now_us, transfer_id++);
        patch<Status>(frames, dronecan::to_float16(1.0F), bits);
        feed(frames);
        EXPECT_TRUE(math::is_nan(report_now().esc_current[0]));
    }
    EXPECT_EQ(report.rejected, 6U);
}

TEST_F(Esc, frames_that_are_none_of_the_protocol_count_for_nothing) {
    auto frames = frames_of(status(0), 20, now_us);
    for (CanFrame& frame : frames) frame.extended = false;
    feed(frames);
    EXPECT_EQ(report_now().rejected, 0U) << "11 bits are another protocol's";
    frames = frames_of(status(0), 20, now_us);
    for (CanFrame& frame : frames) frame.length = 64;
    feed(frames);
    EXPECT_EQ(report_now().rejected, 3U);
    EXPECT_EQ(report.esc_online_flags, 0);
}

}  // namespace
}  // namespace stator::apps::can_esc
