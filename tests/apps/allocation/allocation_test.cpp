// Control allocation: known mixers, what yields under saturation, and when motors stop.
#include "allocation.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::apps::allocation {
namespace {

using math::Vector3;

// PX4's Gazebo Iris: iris.sdf.jinja, rotors in PX4's order.
constexpr std::array<Rotor, 4> kIris{{{0.13F, 0.22F, 0.06F},
                                      {-0.13F, -0.20F, 0.06F},
                                      {0.13F, -0.22F, -0.06F},
                                      {-0.13F, 0.20F, -0.06F}}};
// In units of one rotor's most thrust: half the sum of all lever arms, and all rotors.
constexpr float kMaxRoll = 0.42F;
constexpr float kMaxPitch = 0.26F;
constexpr float kMaxYaw = 0.12F;
constexpr float kMaxThrust = 4.0F;

class AllocationTest : public ::testing::Test {
  protected:
    AllocationTest() {
        set_rotors(kIris);
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
    }

    void set_rotors(std::span<const Rotor> rotors) {
        params_.rotor_count = static_cast<int32_t>(rotors.size());
        // Three parameters a rotor, in order, from rotor0_x on.
        float* param = &params_.rotor0_x;
        for (const Rotor& rotor : rotors) {
            *param++ = rotor.x;
            *param++ = rotor.y;
            *param++ = rotor.moment;
        }
    }

    const std::array<float, 12>& allocate(float roll, float pitch, float yaw, float thrust) {
        torque_.xyz = {roll, pitch, yaw};
        thrust_.xyz = {0.0F, 0.0F, -thrust};
        AllocationPorts ports{
            .torque = Input(torque_),
            .thrust = has_thrust_ ? Input(thrust_) : Input<VehicleThrustSetpoint>(),
            .status = has_status_ ? Input(status_) : Input<VehicleStatus>(),
            .params = Input(params_)};
        testing::Probe motors(ports.motors, 0);
        node_.step(ports);
        motors_ = motors.newest();
        return motors_.control;
    }

    // Torque and thrust that the Iris makes of the newest commands, in shares of its most.
    Vector3<float> torque() const {
        Vector3<float> sum = Vector3<float>::Zero();
        for (unsigned i = 0; i < 4; ++i) {
            const Rotor& r = kIris[i];
            sum += Vector3<float>(-r.y, r.x, r.moment) * motors_.control[i];
        }
        return sum.cwiseQuotient(Vector3<float>(kMaxRoll, kMaxPitch, kMaxYaw));
    }
    float thrust() const {
        float sum = 0.0F;
        for (unsigned i = 0; i < 4; ++i) sum += motors_.control[i];
        return sum / kMaxThrust;
    }
    bool all_in_range(unsigned count, float idle = 0.0F) const {
        for (unsigned i = 0; i < count; ++i) {
            if (!(motors_.control[i] >= idle && motors_.control[i] <= 1.0F)) return false;
        }
        return true;
    }
    bool all_stopped() const {
        for (const float control : motors_.control) {
            if (!math::is_nan(control)) return false;
        }
        return true;
    }

    Allocation node_;
    VehicleTorqueSetpoint torque_{};
    VehicleThrustSetpoint thrust_{};
    VehicleStatus status_{};
    AllocationParams params_{.idle = 0.0F, .airmode = false};
    ActuatorMotors motors_{};
    bool has_thrust_ = true;
    bool has_status_ = true;
};

TEST_F(AllocationTest, motors_stop_unless_the_status_says_armed) {
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    allocate(0.1F, 0.1F, 0.1F, 0.5F);
    EXPECT_TRUE(all_stopped());
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    has_status_ = false;
    allocate(0.1F, 0.1F, 0.1F, 0.5F);
    EXPECT_TRUE(all_stopped());
}

TEST_F(AllocationTest, motors_that_do_not_exist_stay_stopped) {
    allocate(0.0F, 0.0F, 0.0F, 0.5F);
    EXPECT_TRUE(all_in_range(4));
    for (unsigned i = 4; i < 12; ++i) EXPECT_TRUE(math::is_nan(motors_.control[i])) << i;
}

TEST_F(AllocationTest, hover_is_the_same_on_every_motor_of_the_iris) {
    allocate(0.0F, 0.0F, 0.0F, 0.533F);
    for (unsigned i = 0; i < 4; ++i) EXPECT_NEAR(motors_.control[i], 0.533F, 1e-6F) << i;
}

// The textbook quadrotor in x: every motor takes the same part of each torque. Signs as in PX4's
// table of this airframe: front right, rear left, front left, rear right.
TEST_F(AllocationTest, a_square_quadrotor_has_the_textbook_mixer) {
    constexpr std::array<Rotor, 4> kSquare{
        {{0.2F, 0.2F, 0.05F}, {-0.2F, -0.2F, 0.05F}, {0.2F, -0.2F, -0.05F}, {-0.2F, 0.2F, -0.05F}}};
    constexpr std::array<std::array<float, 3>, 4> kSigns{
        {{-1, 1, 1}, {1, -1, 1}, {1, 1, -1}, {-1, -1, -1}}};
    set_rotors(kSquare);
    for (unsigned axis = 0; axis < 3; ++axis) {
        std::array<float, 3> t{};
        t[axis] = 0.2F;
        const auto& control = allocate(t[0], t[1], t[2], 0.5F);
        for (unsigned i = 0; i < 4; ++i) {
            EXPECT_NEAR(control[i], 0.5F + 0.5F * 0.2F * kSigns[i][axis], 1e-6F) << axis << i;
        }
    }
}

// Figures that PX4's allocation gives for a quadrotor of arms (+-1, +-1) and moment 1, motors front
// right, rear right, rear left, front left (ControlAllocationSequentialDesaturationTest.cpp, 2025).
// Its unit of torque about an axis is half of ours: 0.25 of each motor, here 0.5. Not taken over is
// its reserve of 15 % for yaw at full thrust; yaw yields first here.
TEST_F(AllocationTest, published_cases_of_a_square_quadrotor) {
    struct Case {
        float roll, pitch, yaw, thrust;
        bool airmode;
        std::array<float, 4> control;
    };
    constexpr std::array<Case, 18> kCases{{
        {0, 0, 0, 0.3F, false, {0.3F, 0.3F, 0.3F, 0.3F}},
        {0, 0, 0, 0.75F, false, {0.75F, 0.75F, 0.75F, 0.75F}},
        {1, 0, 0, 0.5F, false, {0.25F, 0.25F, 0.75F, 0.75F}},
        {-1, 0, 0, 0.5F, false, {0.75F, 0.75F, 0.25F, 0.25F}},
        {0, 1, 0, 0.5F, false, {0.75F, 0.25F, 0.25F, 0.75F}},
        {0, 0, 1, 0.5F, false, {0.75F, 0.25F, 0.75F, 0.25F}},
        {0, 0, -1, 0.5F, false, {0.25F, 0.75F, 0.25F, 0.75F}},
        {0, 0, 0.02F, 0.75F, false, {0.755F, 0.745F, 0.755F, 0.745F}},
        {0, 0, 1, 0.75F, false, {1.0F, 0.5F, 1.0F, 0.5F}},
        {0, 0.1F, 0, 0.75F, false, {0.775F, 0.725F, 0.725F, 0.775F}},
        {1, 0, 0, 1, false, {0.5F, 0.5F, 1, 1}},  // thrust yields
        {0, -1, 0, 1, false, {0.5F, 1, 1, 0.5F}},
        {0, 2, 0, 1, false, {1, 0, 0, 1}},
        {1, 0, 0, 0, false, {0, 0, 0, 0}},  // without thrust and airmode, nothing
        {0, 0, 1, 0, false, {0, 0, 0, 0}},
        {1, 0, 0, 0.1F, false, {0, 0, 0.2F, 0.2F}},
        {1, 0, 0, 0, true, {0, 0, 0.5F, 0.5F}},
        {0, -1, 0, 0.1F, true, {0, 0.5F, 0.5F, 0}},
    }};
    set_rotors(std::array<Rotor, 4>{{{1, 1, 1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, -1}}});
    for (std::size_t n = 0; n < kCases.size(); ++n) {
        const Case& c = kCases[n];
        params_.airmode = c.airmode;
        const auto& control = allocate(0.5F * c.roll, 0.5F * c.pitch, 0.5F * c.yaw, c.thrust);
        for (unsigned i = 0; i < 4; ++i) EXPECT_NEAR(control[i], c.control[i], 1e-6F) << n << i;
    }
}

// A regular hexagon: the pseudo-inverse divides a torque in proportion to the lever arms, so for
// roll the motors on the y axis take twice what the others take, and for pitch nothing.
TEST_F(AllocationTest, a_hexarotor_divides_torque_in_proportion_to_lever_arms) {
    constexpr float kCos30 = 0.8660254F;
    constexpr std::array<Rotor, 6> kHexagon{{{0.0F, 1.0F, -0.05F},
                                             {0.0F, -1.0F, 0.05F},
                                             {kCos30, -0.5F, -0.05F},
                                             {-kCos30, 0.5F, 0.05F},
                                             {kCos30, 0.5F, 0.05F},
                                             {-kCos30, -0.5F, -0.05F}}};
    set_rotors(kHexagon);
    // roll: 1/3 * most (2) / sum of squares (3) * arm
    const auto& control = allocate(0.3F, 0.0F, 0.0F, 0.5F);
    constexpr std::array<float, 6> kRoll{-0.2F, 0.2F, 0.1F, -0.1F, -0.1F, 0.1F};
    for (unsigned i = 0; i < 6; ++i) EXPECT_NEAR(control[i], 0.5F + kRoll[i], 1e-5F) << i;
    allocate(0.0F, 0.3F, 0.0F, 0.5F);
    EXPECT_NEAR(motors_.control[0], 0.5F, 1e-5F);
    EXPECT_NEAR(motors_.control[1], 0.5F, 1e-5F);
}

TEST_F(AllocationTest, makes_exactly_what_is_wanted_while_no_motor_is_at_its_end) {
    math::Random random(1);
    for (int trial = 0; trial < 200; ++trial) {
        Vector3<float> wanted;
        for (float& t : wanted) t = 0.6F * random.uniform_float() - 0.3F;
        allocate(wanted.x(), wanted.y(), wanted.z(), 0.5F);
        ASSERT_LT(math::norm(torque() - wanted), 1e-5F) << trial;
        ASSERT_NEAR(thrust(), 0.5F, 1e-6F) << trial;
    }
}

TEST_F(AllocationTest, yaw_yields_first) {
    allocate(0.3F, -0.1F, 1.0F, 0.6F);
    EXPECT_TRUE(all_in_range(4));
    EXPECT_NEAR(torque().x(), 0.3F, 1e-5F);
    EXPECT_NEAR(torque().y(), -0.1F, 1e-5F);
    EXPECT_NEAR(thrust(), 0.6F, 1e-6F);
    EXPECT_GT(torque().z(), 0.2F);  // what is left is used
    EXPECT_LT(torque().z(), 0.9F);
    EXPECT_NEAR(*std::max_element(motors_.control.begin(), motors_.control.begin() + 4), 1.0F,
                1e-6F);
}

TEST_F(AllocationTest, thrust_yields_to_roll_and_pitch) {
    allocate(0.3F, 0.2F, 0.0F, 1.0F);
    EXPECT_TRUE(all_in_range(4));
    EXPECT_NEAR(torque().x(), 0.3F, 1e-5F);
    EXPECT_NEAR(torque().y(), 0.2F, 1e-5F);
    EXPECT_LT(thrust(), 0.8F);
    EXPECT_GT(thrust(), 0.7F);
}

TEST_F(AllocationTest, without_airmode_thrust_never_rises) {
    allocate(0.6F, 0.3F, 0.0F, 0.1F);
    EXPECT_TRUE(all_in_range(4));
    EXPECT_NEAR(thrust(), 0.1F, 1e-6F);
    EXPECT_GT(torque().x(), 0.05F);
    EXPECT_NEAR(torque().x() / torque().y(), 2.0F, 1e-3F);  // the axis of the torque stays
}

TEST_F(AllocationTest, with_airmode_thrust_rises_for_roll_and_pitch) {
    params_.airmode = true;
    allocate(0.6F, 0.3F, 0.0F, 0.1F);
    EXPECT_TRUE(all_in_range(4));
    EXPECT_NEAR(torque().x(), 0.6F, 1e-5F);
    EXPECT_NEAR(torque().y(), 0.3F, 1e-5F);
    EXPECT_GT(thrust(), 0.4F);
}

TEST_F(AllocationTest, too_much_roll_and_pitch_shrink_together) {
    allocate(1.0F, -1.0F, 0.0F, 0.5F);
    EXPECT_TRUE(all_in_range(4));
    EXPECT_NEAR(torque().x() / torque().y(), -1.0F, 1e-3F);
    EXPECT_GT(torque().x(), 0.45F);
}

TEST_F(AllocationTest, commands_stay_in_range_whatever_is_wanted) {
    params_.idle = 0.02F;
    math::Random random(2);
    for (int trial = 0; trial < 2000; ++trial) {
        std::array<float, 4> wanted;
        for (float& w : wanted) w = 4.0F * random.uniform_float() - 2.0F;
        params_.airmode = trial % 2 == 0;
        allocate(wanted[0], wanted[1], wanted[2], wanted[3]);
        ASSERT_TRUE(all_in_range(4, 0.02F)) << trial;
    }
}

TEST_F(AllocationTest, an_armed_motor_idles) {
    params_.idle = 0.05F;
    allocate(0.0F, 0.0F, 0.0F, 0.0F);
    for (unsigned i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(motors_.control[i], 0.05F);
}

TEST_F(AllocationTest, twelve_rotors_fly) {
    std::array<Rotor, 12> rotors;
    for (unsigned i = 0; i < 12; ++i) {
        const math::SinCos<float> angle = math::sincos(0.5F * static_cast<float>(i));
        rotors[i] = {angle.cos, angle.sin, i % 2 == 0 ? 0.05F : -0.05F};
    }
    set_rotors(rotors);
    allocate(0.1F, 0.1F, 0.1F, 0.5F);
    EXPECT_TRUE(all_in_range(12));
}

TEST_F(AllocationTest, rotors_that_cannot_steer_stay_stopped) {
    std::array<Rotor, 4> one_way = kIris;
    for (Rotor& rotor : one_way) rotor.moment = 0.06F;  // yaw is lift
    set_rotors(one_way);
    allocate(0.0F, 0.0F, 0.0F, 0.5F);
    EXPECT_TRUE(all_stopped());
    // All but on one line through the centre: roll is pitch.
    set_rotors(std::array<Rotor, 4>{{{0.2F, 0.2F, 0.06F},
                                     {-0.2F, -0.2F, 0.06F},
                                     {0.1F, 0.101F, -0.06F},
                                     {-0.1F, -0.101F, -0.06F}}});
    allocate(0.0F, 0.0F, 0.0F, 0.5F);
    EXPECT_TRUE(all_stopped());
    std::array<Rotor, 4> in_line = kIris;
    for (Rotor& rotor : in_line) rotor.y = 0.0F;
    set_rotors(in_line);
    allocate(0.0F, 0.0F, 0.0F, 0.5F);
    EXPECT_TRUE(all_stopped());
}

TEST_F(AllocationTest, what_is_absent_or_no_number_reads_as_zero) {
    constexpr float kNaN = math::canonical_nan<float>();
    allocate(kNaN, 0.1F, kNaN, 0.5F);
    EXPECT_LT(math::norm(torque() - Vector3<float>(0.0F, 0.1F, 0.0F)), 1e-5F);
    allocate(0.0F, 0.0F, 0.0F, kNaN);
    EXPECT_EQ(thrust(), 0.0F);
    has_thrust_ = false;
    allocate(0.0F, 0.0F, 0.0F, 0.5F);
    EXPECT_EQ(thrust(), 0.0F);
}

TEST_F(AllocationTest, passes_the_time_of_the_gyro_sample_on) {
    torque_.timestamp_sample = 123;
    allocate(0.0F, 0.0F, 0.0F, 0.5F);
    EXPECT_EQ(motors_.timestamp_sample, 123U);
}

// What made the torque is silent: the motors would go on for ever.
TEST_F(AllocationTest, stops_without_a_torque_once_disarmed) {
    const auto step = [this](uint64_t now_us, bool has_torque) {
        AllocationPorts ports{
            .now = now_us,
            .torque = has_torque ? Input(torque_) : Input<VehicleTorqueSetpoint>(),
            .thrust = Input(thrust_),
            .status = Input(status_),
            .params = Input(params_)};
        testing::Probe motors(ports.motors, now_us);
        node_.step(ports);
        if (motors.count() != 0) motors_ = motors.newest();
        return motors.count();
    };
    EXPECT_EQ(step(1'000'000, true), 1U);
    EXPECT_EQ(step(1'100'000, false), 0U);  // armed, it keeps its command
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    EXPECT_EQ(step(1'110'000, false), 1U);
    EXPECT_TRUE(math::is_nan(motors_.control[0]));
    EXPECT_EQ(step(1'120'000, true), 1U);
    EXPECT_EQ(step(1'125'000, false), 0U);  // the torque itself comes
}

// A motor that is tested, on a vehicle that rate_control keeps waking.
class MotorTestTest : public AllocationTest {
  protected:
    MotorTestTest() { status_.arming_state = VehicleStatus::ArmingState::kDisarmed; }
    const std::array<float, 12>& step(uint64_t now_us, const MotorTest& test) {
        AllocationPorts ports{.now = now_us,
                              .torque = Input(torque_),
                              .thrust = Input(thrust_),
                              .status = Input(status_),
                              .test = Input(test),
                              .params = Input(params_, is_first_)};
        testing::Probe motors(ports.motors, now_us);
        testing::Probe allocation(ports.allocation, now_us);
        node_.step(ports);
        if (allocation.count() != 0) count_ = allocation.newest().motor_count;
        is_first_ = false;
        motors_ = motors.newest();
        return motors_.control;
    }
    bool is_first_ = true;
    int count_ = -1;
};

TEST_F(MotorTestTest, one_motor_turns_and_the_others_stand) {
    const auto& control = step(1'000'000, {.timestamp = 990'000, .motor = 2, .thrust = 0.15F});
    EXPECT_EQ(count_, 4);
    for (unsigned i = 0; i < control.size(); ++i) {
        EXPECT_EQ(math::is_nan(control.at(i)), i != 2) << i;
    }
    EXPECT_EQ(control[2], 0.15F);
    step(1'010'000, {.timestamp = 1'010'000, .motor = 2, .thrust = 7.0F});
    EXPECT_EQ(motors_.control[2], 1.0F);
}

TEST_F(MotorTestTest, it_ends_with_its_last_word_or_without_a_word) {
    const MotorTest test{.timestamp = 1'000'000, .motor = 0, .thrust = 0.2F};
    step(1'100'000, test);
    EXPECT_EQ(motors_.control[0], 0.2F);
    step(1'101'000, test);
    EXPECT_TRUE(all_stopped());
    step(1'102'000, {.timestamp = 1'102'000, .thrust = math::canonical_nan<float>()});
    EXPECT_TRUE(all_stopped());
}

TEST_F(MotorTestTest, armed_it_changes_nothing_and_a_motor_that_is_not_there_does_not_turn) {
    step(1'000'000, {.timestamp = 1'000'000, .motor = 4, .thrust = 0.2F});
    EXPECT_TRUE(all_stopped());
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    step(1'001'000, {.timestamp = 1'001'000, .motor = 0, .thrust = 0.9F});
    EXPECT_EQ(motors_.control[0], motors_.control[1]);
    EXPECT_LT(motors_.control[0], 0.1F);
}

TEST_F(MotorTestTest, rotors_that_cannot_steer_are_not_tested) {
    std::array<Rotor, 4> in_line = kIris;
    for (Rotor& rotor : in_line) rotor.y = 0.0F;
    set_rotors(in_line);
    step(1'000'000, {.timestamp = 1'000'000, .motor = 0, .thrust = 0.2F});
    EXPECT_TRUE(all_stopped());
    EXPECT_EQ(count_, 0);
}

}  // namespace
}  // namespace stator::apps::allocation
