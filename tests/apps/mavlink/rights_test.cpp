// What each line is, and what systems on it may do.
#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

namespace cmd = mav::mav_cmd;
constexpr uint16_t kVelocityAndYaw = 0x9C7;

int32_t bit(Right right) {
    return 1 << static_cast<int>(right);
}

// The first line has every right but one, the second one has them all.
class RightsTest : public MavlinkTest {
  protected:
    RightsTest() { is_open_ = {true, true}; }
    void take(Right right) { params_.allows1 &= ~bit(right); }
    int result_of(uint16_t command, std::array<float, 7> p, unsigned line = 0) {
        forget();
        commands_.clear();
        send_command(command, p, line);
        run(0.1);
        const auto found = heard<mav::CommandAck>(line);
        EXPECT_EQ(found.size(), 1U);
        return found.empty() ? -1 : found.front().result;
    }
    void expect_denied(uint16_t command, std::array<float, 7> p) {
        EXPECT_EQ(result_of(command, p), mav::mav_result::kDenied) << command;
        EXPECT_TRUE(commands_.empty()) << command;
        EXPECT_NE(result_of(command, p, 1), mav::mav_result::kDenied) << command;
    }
};

TEST_F(RightsTest, who_may_not_fly_changes_no_mode) {
    take(Right::kFly);
    for (const auto command :
         {cmd::kComponentArmDisarm, cmd::kNavTakeoff, cmd::kNavLand, cmd::kNavReturnToLaunch,
          cmd::kMissionStart, cmd::kDoReposition, cmd::kDoOrbit, cmd::kDoSetMissionCurrent}) {
        expect_denied(static_cast<uint16_t>(command), {1, 1});
    }
    expect_denied(cmd::kDoSetMode, {1, 4, 3});
    commands_.clear();
    send(mav::SetMode{.custom_mode = 4U << 16, .target_system = 1, .base_mode = 1});
    run(0.1);
    EXPECT_TRUE(commands_.empty());
    EXPECT_EQ(result_of(cmd::kRequestMessage, {148}), mav::mav_result::kAccepted) << "asks on";
    EXPECT_EQ(result_of(60'000, {}), mav::mav_result::kUnsupported);
    EXPECT_EQ(result_of(cmd::kDoFlighttermination, {1}), mav::mav_result::kAccepted);
}

TEST_F(RightsTest, who_may_not_kill_stops_no_motor_in_the_air) {
    take(Right::kKill);
    expect_denied(cmd::kComponentArmDisarm, {0, 21196});
    expect_denied(cmd::kDoFlighttermination, {1});
    EXPECT_EQ(result_of(cmd::kComponentArmDisarm, {0}), mav::mav_result::kAccepted);
}

TEST_F(RightsTest, who_may_not_service_restarts_and_turns_nothing) {
    take(Right::kService);
    expect_denied(cmd::kPreflightRebootShutdown, {1});
    EXPECT_EQ(restarts_, 1U) << "the second line";
    expect_denied(cmd::kPreflightCalibration, {1});
    expect_denied(cmd::kDoMotorTest, {1, 0, 10, 1});
    expect_denied(cmd::kActuatorTest, {0.1F, 1, 0, 0, 1});
}

TEST_F(RightsTest, who_may_not_steer_is_not_heard) {
    take(Right::kSteer);
    const mav::ManualControl sticks{.x = 100, .z = 500, .target = 1};
    const mav::SetPositionTargetLocalNed target{.vx = 1.0F,
                                                .type_mask = kVelocityAndYaw,
                                                .target_system = 1,
                                                .target_component = 1,
                                                .coordinate_frame = mav::mav_frame::kLocalNed};
    send(sticks);
    send(target);
    run(0.1);
    EXPECT_TRUE(station_sticks_.empty());
    EXPECT_TRUE(setpoints_.empty());
    send(sticks, 1);
    send(target, 1);
    run(0.1);
    EXPECT_EQ(station_sticks_.size(), 1U) << "and has not kept the others out";
    EXPECT_EQ(setpoints_.size(), 1U);
}

TEST_F(RightsTest, who_may_not_plan_reads_plans_only) {
    take(Right::kPlan);
    send(mav::MissionCount{.count = 3, .target_system = 1, .target_component = 1});
    send(mav::MissionClearAll{.target_system = 1, .target_component = 1});
    run(0.1);
    const auto acks = heard<mav::MissionAck>();
    ASSERT_EQ(acks.size(), 2U);
    EXPECT_EQ(acks[0].type, mav::mav_mission_result::kDenied);
    EXPECT_EQ(acks[1].type, mav::mav_mission_result::kDenied);
    EXPECT_TRUE(heard<mav::MissionRequestInt>().empty());
    send(mav::MissionRequestList{.target_system = 1, .target_component = 1});
    run(0.1);
    EXPECT_EQ(heard<mav::MissionCount>().size(), 1U);
}

TEST_F(RightsTest, who_may_not_tune_reads_parameters_only) {
    take(Right::kTune);
    parameters_ = {{"A", ParameterValue::Type::kFloat, 1.5F, 0}};
    mav::ParamSet set{.param_value = 2.0F, .target_system = 1, .target_component = 1};
    set.param_id[0] = 'A';
    set.param_type = mav::mav_param_type::kReal32;
    send(set);
    run(0.1);
    const auto errors = heard<mav::ParamError>();
    ASSERT_EQ(errors.size(), 1U);
    EXPECT_EQ(errors[0].error, mav::mav_param_error::kPermissionDenied);
    EXPECT_EQ(parameters_[0].real, 1.5F);
    send(mav::ParamRequestList{.target_system = 1, .target_component = 1});
    run(0.2);
    EXPECT_FALSE(heard<mav::ParamValue>().empty());
    send(set, 1);
    run(0.1);
    EXPECT_EQ(parameters_[0].real, 2.0F);
}

TEST_F(RightsTest, who_has_no_console_is_told_so) {
    take(Right::kConsole);
    mav::SerialControl typed{.device = 10, .flags = mav::serial_control_flag::kRespond, .count = 1};
    send(typed);
    run(0.1);
    EXPECT_EQ(heard<mav::SerialControl>().size(), 1U);
    EXPECT_EQ(new_consoles_, 0U);
}

TEST_F(RightsTest, frames_of_a_line_without_the_right_stay_there) {
    constexpr mav::Address kOther{77, 1};
    take(Right::kForward);
    send(mav::Heartbeat{}, 0, kOther);
    send(mav::Heartbeat{}, 1, kGround);
    run(0.1);
    const auto is_from = [](mav::Address address) {
        return [=](const Heard& message) { return message.from == address; };
    };
    EXPECT_EQ(std::ranges::count_if(stations_[1].heard, is_from(kOther)), 0);
    EXPECT_EQ(std::ranges::count_if(stations_[0].heard, is_from(kGround)), 1);
}

TEST_F(RightsTest, a_line_sends_no_more_than_its_rate) {
    params_.rate1 = 500;
    run(20.0);
    EXPECT_LT(stations_[0].received_bytes, 20U * 500U + 300U);
    EXPECT_GT(stations_[0].received_bytes, 20U * 400U);
    EXPECT_GT(stations_[1].received_bytes, 2 * stations_[0].received_bytes);
}

TEST_F(RightsTest, a_radio_whose_buffer_is_full_gets_less) {
    params_.role1 = static_cast<int32_t>(Role::kRadio);
    line_.bytes_per_s = 5760;
    const auto bytes_in_5s = [this](uint8_t free_pct) {
        stations_[0].received_bytes = 0;
        for (int i = 0; i < 50; ++i) {
            const auto status = mav::RadioStatus{.txbuf = free_pct};
            send(status, 0, {51, 68});
            send(status, 1, {51, 68});  // no radio: not heard
            run(0.1);
        }
        return stations_[0].received_bytes;
    };
    const auto usual = bytes_in_5s(100);
    EXPECT_LT(bytes_in_5s(10), usual / 2);
    EXPECT_LT(bytes_in_5s(40), usual / 2) << "as it is";
    bytes_in_5s(100);
    bytes_in_5s(100);
    EXPECT_GT(bytes_in_5s(100), usual * 9 / 10);
    bytes_in_5s(10);
    run(20.0);
    stations_[0].received_bytes = 0;
    run(5.0);
    EXPECT_GT(stations_[0].received_bytes, usual * 9 / 10) << "a radio that is gone";
}

}  // namespace
}  // namespace stator::apps::mavlink
