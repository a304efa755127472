// The sequence: from waiting to disarmed, the smoothness of its setpoints, and a position that goes
// bad.
#include "sequence.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::sequence {
namespace {

using Arming = VehicleStatus::ArmingState;
using Nav = VehicleStatus::NavState;

class SequenceTest : public ::testing::Test {
  protected:
    SequenceTest() {
        params_.start_delay = 2.0F;
        params_.spool_up_time = 1.0F;
        params_.north = 3.0F;
        params_.east = -4.0F;
        params_.height = 2.0F;
        params_.heading = 1.0F;
        params_.hover_time = 5.0F;
        params_.takeoff_rate = 0.5F;
        params_.landing_rate = 0.4F;
        params_.speed = 1.0F;
        params_.acceleration = 0.5F;
        params_.yaw_rate = 0.5F;
        position_.xy_valid = position_.z_valid = position_.v_xy_valid = position_.v_z_valid = true;
    }

    // 20 ms of a vehicle that follows its setpoint exactly, down to the ground.
    void step() {
        now_us_ += 20'000;
        if (position_updates_) position_.timestamp_sample = now_us_ - 15'000;
        SequencePorts ports{
            .now = now_us_,
            .position = has_position_ ? Input(position_) : Input<VehicleLocalPosition>(),
            .escs = has_escs_ ? Input(escs_) : Input<EscStatus>(),
            .params = Input(params_)};
        testing::Probe setpoint(ports.setpoint, now_us_);
        testing::Probe status(ports.status, now_us_);
        node_.step(ports);
        setpoint_ = setpoint.newest();
        status_ = status.newest();
        if (follows_) follow();
    }
    void run(double seconds) {
        const uint64_t end_us = now_us_ + static_cast<uint64_t>(seconds * 1e6);
        while (now_us_ < end_us) step();
    }
    // Seconds until the vehicle is in this state; 100 if it never is.
    double run_until(Arming arming, Nav nav) {
        const uint64_t start_us = now_us_;
        while (status_.arming_state != arming || status_.nav_state != nav) {
            if (now_us_ - start_us >= 100'000'000) break;
            step();
        }
        return static_cast<double>(now_us_ - start_us) * 1e-6;
    }
    bool is_armed() const { return status_.arming_state == Arming::kArmed; }

    Sequence node_;
    SequenceParams params_{};
    VehicleLocalPosition position_{};
    TrajectorySetpoint setpoint_{};
    VehicleStatus status_{};
    EscStatus escs_{.esc_online_flags = 0b1111, .esc_count = 4};
    uint64_t now_us_ = 0;
    bool has_escs_ = false;
    bool has_position_ = true;
    bool position_updates_ = true;
    bool follows_ = true;

  private:
    void follow() {
        if (!is_armed() || math::is_nan(setpoint_.position[0])) return;
        position_.x = setpoint_.position[0];
        position_.y = setpoint_.position[1];
        position_.z = math::min(setpoint_.position[2], 0.0F);
        position_.vz = position_.z < 0.0F ? setpoint_.velocity[2] : 0.0F;
        position_.heading = setpoint_.yaw;
    }
};

TEST_F(SequenceTest, waits_until_the_position_has_been_good_for_the_delay) {
    has_position_ = false;
    run(3.0);
    EXPECT_FALSE(is_armed());
    has_position_ = true;
    position_.v_z_valid = false;
    run(3.0);
    EXPECT_FALSE(is_armed());
    position_.v_z_valid = true;
    EXPECT_NEAR(run_until(Arming::kArmed, Nav::kTakeoff), 2.0, 0.1);
}

TEST_F(SequenceTest, spools_up_on_the_ground_before_it_climbs) {
    run_until(Arming::kArmed, Nav::kTakeoff);
    run(0.9);
    EXPECT_EQ(setpoint_.position[2], 0.0F);
    run(0.5);
    EXPECT_LT(setpoint_.position[2], 0.0F);
}

// Climb: 2 m at 0.5 m/s with 1 s of acceleration and 1 s of braking at 0.5 m/s^2: 5 s.
// Approach: 5 m at 1 m/s, 2 s each: 7 s; the turn by 1 rad takes less.
TEST_F(SequenceTest, flies_the_plan) {
    run_until(Arming::kArmed, Nav::kTakeoff);
    EXPECT_NEAR(run_until(Arming::kArmed, Nav::kHold), 1.0 + 5.0, 0.2);
    run(7.2);
    EXPECT_EQ(setpoint_.position, (std::array{3.0F, -4.0F, -2.0F}));
    EXPECT_EQ(setpoint_.velocity, (std::array{0.0F, 0.0F, 0.0F}));
    EXPECT_FLOAT_EQ(setpoint_.yaw, 1.0F);
    EXPECT_NEAR(run_until(Arming::kArmed, Nav::kLand), 5.0, 0.3);
    // 2 m at 0.4 m/s with 0.8 s of acceleration, then 0.2 s to be sure.
    EXPECT_NEAR(run_until(Arming::kDisarmed, Nav::kLand), 5.4 + 0.2, 0.1);
}

TEST_F(SequenceTest, setpoints_are_smooth) {
    run_until(Arming::kArmed, Nav::kTakeoff);
    TrajectorySetpoint before = setpoint_;
    while (is_armed()) {
        step();
        if (!is_armed()) break;
        for (unsigned i = 0; i < 3; ++i) {
            const float moved = setpoint_.position[i] - before.position[i];
            ASSERT_NEAR(moved, setpoint_.velocity[i] * 0.02F, 1e-3F);
            ASSERT_LT(math::abs(setpoint_.velocity[i] - before.velocity[i]), 0.0101F);
        }
        ASSERT_GE(setpoint_.velocity[2], -0.501F);
        ASSERT_LE(setpoint_.velocity[2], 0.401F);
        before = setpoint_;
    }
}

TEST_F(SequenceTest, stays_disarmed_after_the_landing) {
    run_until(Arming::kArmed, Nav::kLand);
    run_until(Arming::kDisarmed, Nav::kLand);
    run(20.0);
    EXPECT_FALSE(is_armed());
    EXPECT_EQ(status_.nav_state, Nav::kLand);
}

TEST_F(SequenceTest, starts_from_where_it_stands) {
    position_.x = 7.0F;
    position_.z = 0.3F;
    position_.heading = -1.0F;
    run_until(Arming::kArmed, Nav::kTakeoff);
    EXPECT_EQ(setpoint_.position, (std::array{7.0F, 0.0F, 0.3F}));
    EXPECT_EQ(setpoint_.yaw, -1.0F);
}

TEST_F(SequenceTest, turns_the_shorter_way) {
    params_.heading = -3.0F;
    position_.heading = 3.0F;
    run_until(Arming::kArmed, Nav::kHold);
    run(0.1);
    EXPECT_GT(setpoint_.yawspeed, 0.0F);
    run(2.0);
    EXPECT_FLOAT_EQ(setpoint_.yaw, -3.0F);
}

TEST_F(SequenceTest, on_the_ground_that_it_left_it_stops_at_once) {
    run_until(Arming::kArmed, Nav::kLand);
    follows_ = false;
    position_.vz = 0.05F;
    position_.z = -0.2F;  // a gust holds it, higher than a leaning vehicle stands
    run(0.45);
    EXPECT_TRUE(is_armed());
    position_.vz = 0.4F;
    step();
    position_.z = -0.1F;
    run(0.15);
    position_.vz = 0.05F;
    run(0.16);
    EXPECT_TRUE(is_armed());
    run(0.06);
    EXPECT_FALSE(is_armed());
}

TEST_F(SequenceTest, the_ground_is_where_it_stood_when_it_was_armed) {
    position_.z = -1.0F;
    run_until(Arming::kArmed, Nav::kTakeoff);
    follows_ = false;
    position_.z = -1.3F;  // lifted by a gust before it climbs
    run_until(Arming::kArmed, Nav::kHold);
    run(8.0);
    EXPECT_FLOAT_EQ(setpoint_.position[2], -1.0F - params_.height);
}

TEST_F(SequenceTest, something_that_blocks_the_descent_in_motion_is_no_touchdown) {
    run_until(Arming::kArmed, Nav::kLand);
    follows_ = false;
    for (int i = 0; i < 500; ++i) {  // bounces by 0.3 m/s, well above the setpoint
        position_.vz = i % 20 < 10 ? 0.3F : -0.3F;
        step();
    }
    EXPECT_TRUE(is_armed());
}

TEST_F(SequenceTest, on_the_ground_a_bad_position_disarms_and_starts_over) {
    run_until(Arming::kArmed, Nav::kTakeoff);
    position_.xy_valid = false;
    step();
    EXPECT_FALSE(is_armed());
    position_.xy_valid = true;
    EXPECT_NEAR(run_until(Arming::kArmed, Nav::kTakeoff), 2.0, 0.1);
}

TEST_F(SequenceTest, a_short_gap_in_flight_does_not_matter) {
    run_until(Arming::kArmed, Nav::kHold);
    run(1.0);
    has_position_ = false;
    run(0.4);
    has_position_ = true;
    run(1.0);
    EXPECT_EQ(status_.nav_state, Nav::kHold);
}

TEST_F(SequenceTest, without_position_in_flight_it_sinks_and_finally_disarms) {
    run_until(Arming::kArmed, Nav::kHold);
    position_.xy_valid = false;
    run(1.0);
    EXPECT_EQ(status_.nav_state, Nav::kLand);
    EXPECT_TRUE(is_armed());
    EXPECT_TRUE(math::is_nan(setpoint_.position[0]));
    EXPECT_FLOAT_EQ(setpoint_.velocity[2], 0.4F);
    // Twice 2 m at 0.4 m/s, and 5 s.
    EXPECT_NEAR(run_until(Arming::kDisarmed, Nav::kLand), 10.0 + 5.0 - 0.5, 0.3);
}

TEST_F(SequenceTest, waits_for_all_motor_controllers_that_it_is_told_of) {
    has_escs_ = true;
    escs_.esc_online_flags = 0b0111;
    run(10.0);
    EXPECT_FALSE(is_armed());
    escs_.esc_online_flags = 0b1111;
    step();
    EXPECT_TRUE(is_armed());
    escs_.esc_online_flags = 0b1110;
    step();
    EXPECT_FALSE(is_armed()) << "still on the ground";
    EXPECT_FALSE(status_.failsafe);
}

TEST_F(SequenceTest, more_motor_controllers_than_there_are_flags_are_as_many_as_flags) {
    has_escs_ = true;
    escs_ = {.esc_online_flags = 0xFFFF, .esc_count = 255};
    run(5.0);
    EXPECT_TRUE(is_armed());
}

TEST_F(SequenceTest, a_lost_motor_controller_in_flight_lands_it_for_good) {
    has_escs_ = true;
    run_until(Arming::kArmed, Nav::kHold);
    run(1.0);
    escs_.esc_online_flags = 0b1101;
    step();
    EXPECT_EQ(status_.nav_state, Nav::kLand);
    EXPECT_TRUE(status_.failsafe);
    EXPECT_EQ(status_.failsafe_event, VehicleStatus::FailsafeEvent::kMotorLost);
    escs_.esc_online_flags = 0b1111;
    EXPECT_LT(run_until(Arming::kDisarmed, Nav::kLand), 10.0);
    EXPECT_EQ(status_.failsafe_event, VehicleStatus::FailsafeEvent::kMotorLost);
}

TEST_F(SequenceTest, a_position_that_stands_still_in_time_is_bad) {
    run_until(Arming::kArmed, Nav::kHold);
    position_updates_ = false;
    run(1.0);
    EXPECT_EQ(status_.nav_state, Nav::kLand);
}

TEST_F(SequenceTest, a_landing_goes_on_from_where_the_position_comes_back) {
    run_until(Arming::kArmed, Nav::kHold);
    run(8.0);
    has_position_ = false;
    run(2.0);
    has_position_ = true;
    position_.x = 5.0F;
    position_.z = -1.0F;
    step();
    EXPECT_EQ(setpoint_.position[0], 5.0F);
    EXPECT_NEAR(setpoint_.position[2], -1.0F, 0.01F);
    EXPECT_LT(run_until(Arming::kDisarmed, Nav::kLand), 6.0);
}

}  // namespace
}  // namespace stator::apps::sequence
