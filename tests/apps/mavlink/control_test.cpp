// Sticks, setpoints of the mode offboard, and heartbeats of stations.
#include "control.hpp"

#include "harness.hpp"
#include "stator/random.hpp"

namespace stator::apps::mavlink {
namespace {

constexpr float kNan = math::canonical_nan<float>();
constexpr uint16_t kVelocityAndYaw = 0x9C7;
constexpr uint16_t kPositionAndYaw = 0x9F8;
constexpr uint8_t kLocal = mav::mav_frame::kLocalNed;
constexpr mav::Address kOther{77, 5};

class ControlTest : public MavlinkTest {
  protected:
    static mav::SetPositionTargetLocalNed target(uint16_t mask, uint8_t frame = kLocal) {
        return {.x = 1.0F,
                .y = 2.0F,
                .z = -3.0F,
                .vx = 4.0F,
                .vy = 5.0F,
                .vz = -6.0F,
                .yaw = 0.5F,
                .type_mask = mask,
                .target_system = 1,
                .target_component = 1,
                .coordinate_frame = frame};
    }
    // What is passed on; none: it was refused.
    template <class Message>
    std::optional<OffboardSetpoint> sent(const Message& message) {
        setpoints_.clear();
        send(message);
        run(0.05);
        EXPECT_LE(setpoints_.size(), 1U);
        if (setpoints_.empty()) return {};
        return setpoints_.front();
    }
};

TEST_F(ControlTest, AStationsHeartbeatIsPassedOnAndNoOthers) {
    send(mav::Heartbeat{.type = mav::mav_type::kOnboardController});
    run(0.1);
    EXPECT_TRUE(beats_.empty());
    send(mav::Heartbeat{.type = mav::mav_type::kGcs});
    run(0.1);
    ASSERT_EQ(beats_.size(), 1U);
    EXPECT_EQ(beats_[0].system_id, kGround.system);
    EXPECT_EQ(beats_[0].line, 1);
}

TEST_F(ControlTest, SticksAreScaled) {
    send(mav::ManualControl{.x = 1000, .y = -500, .z = 500, .r = 250, .target = 1});
    run(0.05);
    ASSERT_EQ(station_sticks_.size(), 1U);
    const auto& sticks = station_sticks_[0];
    EXPECT_TRUE(sticks.valid);
    EXPECT_EQ(sticks.pitch, 1.0F);
    EXPECT_EQ(sticks.roll, -0.5F);
    EXPECT_EQ(sticks.throttle, 0.0F);
    EXPECT_EQ(sticks.yaw, 0.25F);
}

TEST_F(ControlTest, SticksOfAnotherVehicleOrBeyondTheirEndAreNotTaken) {
    send(mav::ManualControl{.z = 500, .target = 2});
    send(mav::ManualControl{.x = INT16_MAX, .z = 500, .target = 1});
    send(mav::ManualControl{.z = -1, .target = 1});
    run(0.1);
    EXPECT_TRUE(station_sticks_.empty());
}

TEST_F(ControlTest, TwoSendersDoNotTakeTurns) {
    for (int i = 0; i < 10; ++i) {
        send(mav::ManualControl{.x = 100, .z = 500, .target = 1});
        run(0.02);
        send(mav::ManualControl{.x = -100, .z = 500, .target = 1}, 0, kOther);
        run(0.02);
    }
    ASSERT_EQ(station_sticks_.size(), 10U);
    for (const auto& sticks : station_sticks_) EXPECT_EQ(sticks.pitch, 0.1F);
    run(0.6);
    send(mav::ManualControl{.x = -100, .z = 500, .target = 1}, 0, kOther);
    run(0.05);
    EXPECT_EQ(station_sticks_.back().pitch, -0.1F);
}

TEST_F(ControlTest, AMaskLeavesOutWhatIsNotGiven) {
    const auto velocity = sent(target(kVelocityAndYaw));
    ASSERT_TRUE(velocity);
    EXPECT_EQ(velocity->kind, OffboardSetpoint::Kind::kMotion);
    EXPECT_TRUE(math::is_nan(velocity->position[0]));
    EXPECT_EQ(velocity->velocity[1], 5.0F);
    EXPECT_TRUE(math::is_nan(velocity->acceleration[2]));
    EXPECT_EQ(velocity->yaw, 0.5F);
    EXPECT_TRUE(math::is_nan(velocity->yawspeed));
    const auto position = sent(target(kPositionAndYaw));
    ASSERT_TRUE(position);
    EXPECT_EQ(position->position[2], -3.0F);
    EXPECT_TRUE(math::is_nan(position->velocity[0]));
}

TEST_F(ControlTest, WhatCannotBeFlownIsRefused) {
    auto bad = target(kPositionAndYaw);
    bad.y = kNan;
    EXPECT_FALSE(sent(bad));
    bad = target(kPositionAndYaw);
    bad.yaw = kNan;
    EXPECT_FALSE(sent(bad));
    bad = target(kVelocityAndYaw);
    bad.vx = 1e30F;
    EXPECT_FALSE(sent(bad));
    EXPECT_FALSE(sent(target(0xFFF)));                  // nothing is given
    EXPECT_FALSE(sent(target(kPositionAndYaw | 4)));    // no height
    EXPECT_FALSE(sent(target(kVelocityAndYaw | 512)));  // a force
    EXPECT_FALSE(sent(target(kPositionAndYaw, mav::mav_frame::kMission)));
    EXPECT_FALSE(sent(target(kPositionAndYaw, mav::mav_frame::kBodyNed)));
    bad = target(kPositionAndYaw);
    bad.target_system = 9;
    EXPECT_FALSE(sent(bad));
}

TEST_F(ControlTest, SpeedsOfTheBodyAreTurned) {
    position_.heading = math::kPi<float> / 2.0F;
    const auto wanted = sent(target(kVelocityAndYaw, mav::mav_frame::kBodyNed));
    ASSERT_TRUE(wanted);
    EXPECT_NEAR(wanted->velocity[0], -5.0F, 1e-5F);
    EXPECT_NEAR(wanted->velocity[1], 4.0F, 1e-5F);
    EXPECT_EQ(wanted->velocity[2], -6.0F);
}

TEST_F(ControlTest, AGlobalPlaceBecomesOneOfN) {
    mav::SetPositionTargetGlobalInt message{.lat_int = 474'000'000,
                                            .lon_int = 85'000'000,
                                            .alt = 510.0F,
                                            .type_mask = 0xDF8,
                                            .target_system = 1,
                                            .target_component = 1,
                                            .coordinate_frame = mav::mav_frame::kGlobalInt};
    auto wanted = sent(message);
    ASSERT_TRUE(wanted);
    EXPECT_NEAR(wanted->position[0], 0.0F, 0.01F);
    EXPECT_NEAR(wanted->position[1], 0.0F, 0.01F);
    EXPECT_EQ(wanted->position[2], -10.0F);
    message.coordinate_frame = mav::mav_frame::kGlobalRelativeAltInt;
    message.alt = 10.0F;
    wanted = sent(message);
    ASSERT_TRUE(wanted);
    EXPECT_EQ(wanted->position[2], -13.0F);  // disarmed, home is here: 3 m up
}

TEST_F(ControlTest, AttitudesAndRates) {
    mav::SetAttitudeTarget message{.q = {2.0F * 0.5F, 0.0F, 0.0F, 0.1F},
                                   .body_roll_rate = 0.1F,
                                   .body_pitch_rate = 0.2F,
                                   .body_yaw_rate = 0.3F,
                                   .thrust = 0.6F,
                                   .target_system = 1,
                                   .target_component = 1,
                                   .type_mask = 0b111};
    auto wanted = sent(message);
    ASSERT_TRUE(wanted);
    EXPECT_EQ(wanted->kind, OffboardSetpoint::Kind::kAttitude);
    const auto& q = wanted->q_d;
    EXPECT_NEAR(q[0] * q[0] + q[3] * q[3], 1.0F, 1e-6F);
    EXPECT_EQ(wanted->thrust, 0.6F);
    EXPECT_EQ(wanted->yawspeed, 0.0F);
    message.type_mask = 128;
    wanted = sent(message);
    ASSERT_TRUE(wanted);
    EXPECT_EQ(wanted->kind, OffboardSetpoint::Kind::kRates);
    EXPECT_EQ(wanted->rates[2], 0.3F);
    message.type_mask = 128 | 1;  // one rate is missing
    EXPECT_FALSE(sent(message));
    message.type_mask = 64;  // no thrust
    EXPECT_FALSE(sent(message));
    message.type_mask = 7;
    message.thrust = 1.1F;
    EXPECT_FALSE(sent(message));
    message.thrust = 0.5F;
    message.q = {};
    EXPECT_FALSE(sent(message));
    message.q = {1.0F, kNan, 0.0F, 0.0F};
    EXPECT_FALSE(sent(message));
}

// Whatever bytes a frame has, each number that is passed on is one, or is free.
TEST_F(ControlTest, AnyPayloadEndsInUsableNumbers) {
    math::Random random(1);
    for (int i = 0; i < 3000; ++i) {
        auto motion = target(static_cast<uint16_t>(random.word()), kLocal);
        std::array<float*, 8> fields{&motion.x,   &motion.y,  &motion.z,   &motion.vx,
                                     &motion.afx, &motion.vz, &motion.yaw, &motion.yaw_rate};
        for (float* const field : fields) {
            const auto bits = static_cast<uint32_t>(random.word());
            if ((bits & 3U) == 0) *field = std::bit_cast<float>(bits);
        }
        const auto wanted = sent(motion);
        if (!wanted) continue;
        for (unsigned axis = 0; axis < 3; ++axis) {
            for (const float v : {wanted->position[axis], wanted->velocity[axis],
                                  wanted->acceleration[axis], wanted->yaw, wanted->yawspeed}) {
                EXPECT_TRUE(math::is_nan(v) || math::abs(v) < 1e6F);
            }
        }
    }
}

}  // namespace
}  // namespace stator::apps::mavlink
