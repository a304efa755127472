// DO_MOTOR_TEST and ACTUATOR_TEST.
#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

namespace cmd = mav::mav_cmd;
namespace result = mav::mav_result;
constexpr float kNan = math::canonical_nan<float>();

class MotorTestTest : public MavlinkTest {
  protected:
    int ask(uint16_t number, std::array<float, 7> p) {
        forget();
        commands_.clear();
        send_command(number, p);
        run(0.1);
        const auto found = results(number);
        EXPECT_EQ(found.size(), 1U) << "one answer";
        return found.empty() ? -1 : found.front();
    }
    void expect_test(unsigned motor, float thrust, float duration) {
        ASSERT_EQ(commands_.size(), 1U);
        EXPECT_EQ(commands_[0].action, VehicleCommand::Action::kTestMotor);
        EXPECT_EQ(commands_[0].motor, motor);
        EXPECT_FLOAT_EQ(commands_[0].thrust, thrust);
        EXPECT_EQ(commands_[0].duration, duration);
    }
};

TEST_F(MotorTestTest, motors_are_counted_from_1_and_thrust_in_percent) {
    EXPECT_EQ(ask(cmd::kDoMotorTest, {3, 0, 15, 2, 1}), result::kAccepted);
    expect_test(2, 0.15F, 2.0F);
    EXPECT_EQ(ask(cmd::kDoMotorTest, {1, 0, 100, 0.5F, kNan, kNan, kNan}), result::kAccepted);
    expect_test(0, 1.0F, 0.5F);
}

TEST_F(MotorTestTest, an_output_that_is_a_motor_is_tested) {
    EXPECT_EQ(ask(cmd::kActuatorTest, {0.25F, 1, 0, 0, 4}), result::kAccepted);
    expect_test(3, 0.25F, 1.0F);
    EXPECT_EQ(ask(cmd::kActuatorTest, {kNan, 0, 0, 0, 4}), result::kAccepted);
    ASSERT_EQ(commands_.size(), 1U);
    EXPECT_TRUE(math::is_nan(commands_[0].thrust));
}

TEST_F(MotorTestTest, what_there_is_not_is_unsupported_and_reaches_nobody) {
    const std::array<float, 7> motor_tests[] = {
        {1, 1, 1500, 1}, {1, 0, 10, 1, 4}, {1, 0, 10, 1, 1, 1}, {1, kNan, 10, 1}};
    for (const auto& p : motor_tests) {
        EXPECT_EQ(ask(cmd::kDoMotorTest, p), result::kUnsupported);
        EXPECT_TRUE(commands_.empty());
    }
    for (const float output : {0.0F, 33.0F, kNan}) {
        EXPECT_EQ(ask(cmd::kActuatorTest, {0.1F, 1, 0, 0, output}), result::kUnsupported);
        EXPECT_TRUE(commands_.empty());
    }
    for (const float motor : {0.0F, -1.0F, kNan}) {
        EXPECT_EQ(ask(cmd::kDoMotorTest, {motor, 0, 10, 1}), result::kDenied);
        EXPECT_TRUE(commands_.empty());
    }
}

TEST_F(MotorTestTest, the_vehicle_decides) {
    result_of_commands_ = VehicleCommandAck::Result::kTemporarilyRejected;
    EXPECT_EQ(ask(cmd::kDoMotorTest, {1, 0, 10, 1}), result::kTemporarilyRejected);
}

}  // namespace
}  // namespace stator::apps::mavlink
