// Whose sticks count.
#include "manual_control.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "stator/testing.hpp"

namespace stator::apps::manual_control {
namespace {

using Nav = VehicleStatus::NavState;

class ManualControlTest : public ::testing::Test {
  protected:
    ManualControlTest() {
        radio_ = ManualControlSetpoint{.valid = true, .roll = 0.1F};
        switches_.mode_slot = 4;
        params_.source = 2;
        params_.takeover = 0.3F;
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        status_.nav_state = Nav::kMission;
        step();
    }

    // The sticks that count.
    ManualControlSetpoint step() {
        now_us_ += 20'000;
        ManualControlPorts ports{
            .now = now_us_,
            .radio = radio_ ? Input(*radio_) : Input<ManualControlSetpoint>(),
            .station = station_ ? Input(*station_) : Input<ManualControlSetpoint>(),
            .switches = Input(switches_),
            .status = Input(status_),
            .command = command_ ? Input(*command_) : Input<VehicleCommand>(),
            .params = Input(params_)};
        testing::Probe sticks(ports.sticks, now_us_);
        node_.step(ports);
        command_.reset();
        if (sticks.count() != 0) newest_ = sticks.newest();
        return newest_;
    }
    void choose(Nav mode) {
        command_ = VehicleCommand{.action = VehicleCommand::Action::kSetMode,
                                  .nav_state = static_cast<uint8_t>(mode)};
        status_.nav_state = mode;
    }
    void station_flies() {
        station_ = ManualControlSetpoint{.valid = true, .roll = -0.5F};
        choose(Nav::kPosition);
        ASSERT_EQ(step().roll, -0.5F);
    }

    std::optional<ManualControlSetpoint> radio_;
    std::optional<ManualControlSetpoint> station_;
    ManualControlSwitches switches_{};
    VehicleStatus status_{};
    std::optional<VehicleCommand> command_;
    ManualControlParams params_{};
    ManualControlSetpoint newest_{};
    uint64_t now_us_ = 0;
    ManualControl node_;
};

TEST_F(ManualControlTest, the_radio_counts_and_a_station_where_it_is_not_heard) {
    station_ = ManualControlSetpoint{.valid = true, .roll = -0.5F};
    EXPECT_EQ(step().roll, 0.1F);
    radio_->valid = false;
    EXPECT_EQ(step().roll, -0.5F);
    radio_.reset();
    EXPECT_TRUE(step().valid);
    station_.reset();
    EXPECT_FALSE(step().valid);
}

TEST_F(ManualControlTest, a_station_takes_over_by_choosing_a_mode_of_sticks) {
    station_ = ManualControlSetpoint{.valid = true, .roll = -0.5F};
    choose(Nav::kHold);
    EXPECT_EQ(step().roll, 0.1F);
    station_flies();
}

TEST_F(ManualControlTest, a_station_without_sticks_does_not_take_over) {
    choose(Nav::kPosition);
    EXPECT_EQ(step().roll, 0.1F);
}

TEST_F(ManualControlTest, a_station_that_flies_and_falls_silent_is_lost_until_sticks_fly_no_more) {
    station_flies();
    station_.reset();
    EXPECT_FALSE(step().valid);
    EXPECT_FALSE(step().valid);
    status_.nav_state = Nav::kReturn;
    EXPECT_TRUE(step().valid);
}

TEST_F(ManualControlTest, a_radio_that_flies_and_is_lost_is_not_replaced) {
    status_.nav_state = Nav::kAltitude;
    step();
    station_ = ManualControlSetpoint{.valid = true, .throttle = -1.0F};
    radio_->valid = false;
    EXPECT_FALSE(step().valid);
}

TEST_F(ManualControlTest, the_radio_takes_over_with_a_stick_or_a_switch_that_moves) {
    station_flies();
    radio_->roll = 0.3F;  // not far enough
    EXPECT_EQ(step().roll, -0.5F);
    radio_->roll = 0.45F;
    EXPECT_EQ(step().roll, 0.45F);
    station_flies();
    switches_.mode_slot = 5;
    EXPECT_EQ(step().roll, 0.45F);
}

TEST_F(ManualControlTest, a_parameter_allows_one_alone) {
    station_ = ManualControlSetpoint{.valid = true, .roll = -0.5F};
    params_.source = 1;
    EXPECT_EQ(step().roll, -0.5F);
    params_.source = 0;
    choose(Nav::kPosition);
    EXPECT_EQ(step().roll, 0.1F);
}

}  // namespace
}  // namespace stator::apps::manual_control
