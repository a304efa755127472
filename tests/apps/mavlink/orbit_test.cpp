// DO_ORBIT, its status, and the channels of the radio.
#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

namespace cmd = mav::mav_cmd;
namespace result = mav::mav_result;
constexpr float kNan = math::canonical_nan<float>();

class OrbitTest : public MavlinkTest {
  protected:
    // Round the origin, 510 m above the sea.
    int ask(std::array<float, 4> p) {
        forget();
        commands_.clear();
        send(mav::CommandInt{.param1 = p[0],
                             .param2 = p[1],
                             .param3 = p[2],
                             .param4 = p[3],
                             .x = 474'000'000,
                             .y = 85'000'000,
                             .z = 510.0F,
                             .command = cmd::kDoOrbit,
                             .target_system = 1,
                             .target_component = 1,
                             .frame = mav::mav_frame::kGlobal});
        run(0.1);
        const auto found = results(cmd::kDoOrbit);
        EXPECT_EQ(found.size(), 1U) << "one answer";
        return found.empty() ? -1 : found.front();
    }
};

TEST_F(OrbitTest, is_a_wish_of_the_vehicle) {
    EXPECT_EQ(ask({-15.0F, 4.0F, 0.0F, kNan}), result::kAccepted);
    ASSERT_EQ(commands_.size(), 1U);
    const VehicleCommand& wish = commands_[0];
    EXPECT_EQ(wish.action, VehicleCommand::Action::kOrbit);
    EXPECT_EQ(wish.radius, -15.0F);
    EXPECT_EQ(wish.speed, 4.0F);
    EXPECT_TRUE(wish.faces_centre);
    EXPECT_NEAR(wish.position[0], 0.0F, 0.01F);
    EXPECT_EQ(wish.position[2], -10.0F);
    EXPECT_EQ(ask({kNan, kNan, 5.0F, 0.0F}), result::kAccepted);
    EXPECT_EQ(commands_.at(0).radius, 10.0F);
    EXPECT_FALSE(commands_.at(0).faces_centre);
}

TEST_F(OrbitTest, what_it_cannot_fly_is_refused) {
    EXPECT_EQ(ask({0.5F, 1.0F, 0.0F, 0.0F}), result::kDenied);
    EXPECT_EQ(ask({10.0F, -1.0F, 0.0F, 0.0F}), result::kDenied);
    EXPECT_EQ(ask({10.0F, 1.0F, 3.0F, 0.0F}), result::kUnsupported) << "along the circle";
    EXPECT_EQ(ask({10.0F, 1.0F, 0.0F, 6.3F}), result::kUnsupported) << "one turn";
    EXPECT_TRUE(commands_.empty());
}

TEST_F(OrbitTest, its_circle_is_told_while_it_is_flown) {
    goal_ = {.kind = GotoSetpoint::Kind::kCircle,
             .position = {0.0F, 0.0F, -10.0F},
             .length = 15.0F,
             .laps = -50.0F};
    run(5.0);
    EXPECT_TRUE(heard<mav::OrbitExecutionStatus>().empty()) << "disarmed";
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    run(5.0);
    const auto told = heard<mav::OrbitExecutionStatus>();
    ASSERT_FALSE(told.empty());
    EXPECT_EQ(told[0].radius, -15.0F);
    EXPECT_NEAR(told[0].x, 474'000'000, 1);
    EXPECT_EQ(told[0].z, 510.0F);
}

TEST_F(OrbitTest, the_radio_has_channels_where_there_is_one) {
    run(3.0);
    EXPECT_TRUE(heard<mav::RcChannels>().empty());
    has_radio_ = true;
    radio_ = {.valid = true, .roll = 1.0F, .pitch = -0.5F, .throttle = -1.0F};
    switches_.mode_slot = 6;
    switches_.arm_switch = ManualControlSwitches::ArmSwitch::kOn;
    run(3.0);
    const auto told = heard<mav::RcChannels>();
    ASSERT_FALSE(told.empty());
    EXPECT_EQ(told[0].chancount, 8);
    EXPECT_EQ(told[0].chan1_raw, 2000);
    EXPECT_EQ(told[0].chan2_raw, 1250);
    EXPECT_EQ(told[0].chan3_raw, 1000);
    EXPECT_EQ(told[0].chan4_raw, 1500);
    EXPECT_EQ(told[0].chan5_raw, 1890);
    EXPECT_EQ(told[0].chan6_raw, 2000);
    EXPECT_EQ(told[0].chan7_raw, 1000);
    EXPECT_EQ(told[0].chan9_raw, UINT16_MAX);
    EXPECT_EQ(told[0].rssi, 254);
    radio_.valid = false;
    forget();
    run(3.0);
    EXPECT_EQ(heard<mav::RcChannels>().at(0).rssi, 0);
}

}  // namespace
}  // namespace stator::apps::mavlink
