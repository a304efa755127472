// Calibrations of a vehicle in a person's hands: its sensors have known errors.
#include "calibration.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <string>
#include <vector>

#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::apps::calibration {
namespace {

using Action = CalibrationRequest::Action;
using Matrix = math::Matrix3<float>;

constexpr float kG = SixSides::kGravity;

// The vehicle, its sensors, and the node with all parameters.
class CalibrationTest : public ::testing::Test {
  protected:
    CalibrationTest() { status_.arming_state = VehicleStatus::ArmingState::kDisarmed; }

    Vector noise(float sigma) {
        const float x = random_.gaussian_float();
        const float y = random_.gaussian_float();
        const float z = random_.gaussian_float();
        return sigma * Vector(x, y, z);
    }
    // What the driver makes of it.
    Vector corrected(const Vector& raw, const std::array<float, 3>& offset, const Vector& scale) {
        Matrix rotation;
        for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = imu_.rotation[static_cast<size_t>(i)];
        return rotation * scale.cwiseProduct(raw - math::vector(offset));
    }
    void step() {
        now_us_ += 10'000;
        // In the frame of the sensors, which are turned in the vehicle.
        const Matrix to_sensors = (q_NB_.toRotationMatrix() * mounting_).transpose();
        const Vector force = to_sensors * Vector(0.0F, 0.0F, -kG);
        const Vector raw_accel = force.cwiseQuotient(true_scale_) + true_accel_ + noise(0.088F);
        const Vector raw_gyro = rate_B_ + true_gyro_ + noise(0.002F);
        const Vector raw_mag = to_sensors * Vector(0.21F, 0.01F, 0.43F) + true_mag_ + noise(0.003F);
        gyro_.xyz = math::to_array(corrected(raw_gyro, imu_.gyro_offset, Vector::Ones()));
        accel_.xyz =
            math::to_array(corrected(raw_accel, imu_.accel_offset, math::vector(imu_.accel_scale)));
        mag_.xyz = math::to_array(corrected(raw_mag, magnetometer_.offset, Vector::Ones()));
        CalibrationPorts ports{.now = now_us_,
                               .request = request_ ? Input(*request_) : Input<CalibrationRequest>(),
                               .gyro = Input(gyro_),
                               .accel = Input(accel_),
                               .mag = Input(mag_),
                               .status = Input(status_),
                               .value = value_ ? Input(*value_) : Input<ParameterValue>(),
                               .params = Input(params_, are_params_new_)};
        stator::testing::Probe imu(ports.imu, now_us_, 2);
        stator::testing::Probe mag(ports.mag_calibration, now_us_, 2);
        stator::testing::Probe running(ports.running, now_us_, 2);
        stator::testing::Probe set(ports.set, now_us_, 1);
        // A probe keeps the newest line of a step.
        stator::testing::Probe text(ports.text, now_us_, 4);
        node_.step(ports);
        request_.reset();
        value_.reset();
        are_params_new_ = false;
        if (imu.count() != 0) imu_ = imu.newest();
        if (mag.count() != 0) magnetometer_ = mag.newest();
        if (running.count() != 0) is_running_ = running.newest().is_running;
        if (text.count() != 0) {
            said_.emplace_back(reinterpret_cast<const char*>(text.newest().text.data()));
        }
        if (set.count() != 0) answer(set.newest());
    }
    void answer(const ParameterRequest& request) {
        const std::string id(reinterpret_cast<const char*>(request.name.data()));
        const std::map<std::string, float*> floats{{"CAL_GYRO0_XOFF", &params_.gyro_offset_x},
                                                   {"CAL_GYRO0_YOFF", &params_.gyro_offset_y},
                                                   {"CAL_GYRO0_ZOFF", &params_.gyro_offset_z},
                                                   {"CAL_ACC0_XOFF", &params_.accel_offset_x},
                                                   {"CAL_ACC0_YOFF", &params_.accel_offset_y},
                                                   {"CAL_ACC0_ZOFF", &params_.accel_offset_z},
                                                   {"CAL_ACC0_XSCALE", &params_.accel_scale_x},
                                                   {"CAL_ACC0_YSCALE", &params_.accel_scale_y},
                                                   {"CAL_ACC0_ZSCALE", &params_.accel_scale_z},
                                                   {"CAL_MAG0_XOFF", &params_.mag_offset_x},
                                                   {"CAL_MAG0_YOFF", &params_.mag_offset_y},
                                                   {"CAL_MAG0_ZOFF", &params_.mag_offset_z},
                                                   {"SENS_LEVEL_ROLL", &params_.level_roll},
                                                   {"SENS_LEVEL_PITCH", &params_.level_pitch}};
        const std::map<std::string, int32_t*> wholes{{"CAL_GYRO0_ID", &params_.gyro_done},
                                                     {"CAL_ACC0_ID", &params_.accel_done},
                                                     {"CAL_MAG0_ID", &params_.mag_done}};
        value_ =
            ParameterValue{.requester = static_cast<ParameterValue::Requester>(request.requester),
                           .tag = request.tag,
                           .result = result_};
        EXPECT_EQ(request.action, ParameterRequest::Action::kSet);
        if (result_ != ParameterValue::Result::kWritten) return;
        are_params_new_ = true;
        if (request.type == ParameterRequest::Type::kInt32) {
            ASSERT_TRUE(wholes.contains(id)) << id;
            *wholes.at(id) = request.int_value;
        } else {
            ASSERT_TRUE(floats.contains(id)) << id;
            *floats.at(id) = request.float_value;
        }
    }
    void run(double seconds) {
        for (unsigned i = 0; i < static_cast<unsigned>(seconds * 100.0); ++i) step();
    }
    void begin(Action action) {
        request_ = CalibrationRequest{.action = action};
        step();
    }
    void turn(float roll, float pitch, float yaw = 0.0F) {
        q_NB_ = math::from_euler(math::EulerAngles<float>{roll, pitch, yaw});
    }
    bool has_said(const std::string& text) const {
        return std::find(said_.begin(), said_.end(), text) != said_.end();
    }
    // All six, as a person does it.
    void show_six_sides() {
        constexpr float kQuarter = math::kHalfPi<float>;
        const std::pair<float, float> turns[] = {{0.0F, 0.0F},      {kQuarter, 0.0F},
                                                 {-kQuarter, 0.0F}, {0.0F, kQuarter},
                                                 {0.0F, -kQuarter}, {2.0F * kQuarter, 0.0F}};
        for (const auto& [roll, pitch] : turns) {
            turn(roll + 0.05F, pitch - 0.04F);
            run(2.0);
            rate_B_ = Vector(1.0F, 0.5F, 0.0F);  // on the way to the next one
            run(0.5);
            rate_B_ = Vector::Zero();
        }
    }

    math::Random random_{7, 0};
    Vector true_gyro_{0.02F, -0.05F, 0.011F};
    Vector true_accel_{0.4F, -0.2F, 0.3F};
    Vector true_scale_{1.02F, 0.985F, 1.01F};
    Vector true_mag_{0.15F, -0.3F, 0.08F};
    Matrix mounting_ = Matrix::Identity();  // from the sensors to B
    math::Quaternion<float> q_NB_ = math::Quaternion<float>::Identity();
    Vector rate_B_ = Vector::Zero();
    SensorGyro gyro_{};
    SensorAccel accel_{};
    SensorMag mag_{};
    VehicleStatus status_{};
    CalibrationParams params_{};
    bool are_params_new_ = true;
    ImuCalibration imu_{.accel_scale = {1.0F, 1.0F, 1.0F},
                        .rotation = {1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F}};
    MagCalibration magnetometer_{};
    std::optional<CalibrationRequest> request_;
    std::optional<ParameterValue> value_;
    ParameterValue::Result result_ = ParameterValue::Result::kWritten;
    bool is_running_ = false;
    std::vector<std::string> said_;
    uint64_t now_us_ = 0;
    Calibration node_;
};

void expect_near(const std::array<float, 3>& found, const Vector& expected, float most) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(found[static_cast<size_t>(i)], expected[i], most) << i;
}

TEST_F(CalibrationTest, tells_the_drivers_what_counts_and_again_when_it_changes) {
    params_.gyro_offset_y = 0.25F;
    step();
    EXPECT_EQ(imu_.gyro_offset[1], 0.25F);
    EXPECT_EQ(imu_.rotation[0], 1.0F);
    params_.mag_offset_z = 0.5F;
    are_params_new_ = true;
    step();
    EXPECT_EQ(magnetometer_.offset[2], 0.5F);
}

TEST_F(CalibrationTest, finds_the_offset_of_the_gyro) {
    begin(Action::kGyro);
    EXPECT_EQ(said_.at(0), "[cal] calibration started: 2 gyro");
    EXPECT_TRUE(is_running_);
    run(6.0);
    EXPECT_TRUE(has_said("[cal] progress <50>"));
    EXPECT_EQ(said_.back(), "[cal] calibration done: gyro");
    EXPECT_FALSE(is_running_);
    expect_near(imu_.gyro_offset, true_gyro_, 5e-4F);
    EXPECT_EQ(params_.gyro_done, 1);
    // Again, with other errors: the new one replaces the old one.
    true_gyro_ = Vector(-0.03F, 0.0F, 0.2F);
    begin(Action::kGyro);
    run(6.0);
    expect_near(imu_.gyro_offset, true_gyro_, 5e-4F);
}

TEST_F(CalibrationTest, a_gyro_that_is_moved_begins_again_and_one_that_never_rests_fails) {
    begin(Action::kGyro);
    run(3.0);
    rate_B_ = Vector(0.3F, 0.0F, 0.0F);
    run(0.3);
    rate_B_ = Vector::Zero();
    run(4.0);
    EXPECT_TRUE(is_running_);
    run(2.0);
    EXPECT_EQ(said_.back(), "[cal] calibration done: gyro");
    expect_near(imu_.gyro_offset, true_gyro_, 5e-4F);
    begin(Action::kGyro);
    for (int i = 0; i < 130; ++i) {
        rate_B_ = Vector(0.0F, i % 2 == 0 ? 0.3F : 0.0F, 0.0F);
        run(1.0);
    }
    EXPECT_EQ(said_.back(), "[cal] calibration failed: it took too long");
    EXPECT_FALSE(is_running_);
    expect_near(imu_.gyro_offset, true_gyro_, 5e-4F);
}

TEST_F(CalibrationTest, finds_offsets_and_factors_of_the_accelerometer_from_six_sides) {
    begin(Action::kAccel);
    show_six_sides();
    EXPECT_TRUE(has_said("[cal] down orientation detected"));
    EXPECT_TRUE(has_said("[cal] right side done, rotate to a different side"));
    EXPECT_EQ(said_.back(), "[cal] calibration done: accel");
    // A side that leans by 0.05 rad shows 0.2 % less of gravity.
    expect_near(imu_.accel_offset, true_accel_, 0.03F);
    expect_near(imu_.accel_scale, true_scale_, 0.005F);
    EXPECT_EQ(params_.accel_done, 1);
}

TEST_F(CalibrationTest, a_side_counts_once_and_sides_are_named_as_ground_stations_do) {
    begin(Action::kAccel);
    run(2.0);
    EXPECT_TRUE(has_said("[cal] down side done, rotate to a different side"));
    turn(0.0F, -math::kHalfPi<float>);  // nose down
    rate_B_ = Vector(0.0F, -1.0F, 0.0F);
    run(0.5);
    rate_B_ = Vector::Zero();
    run(2.0);
    EXPECT_TRUE(has_said("[cal] front orientation detected"));
    turn(-math::kHalfPi<float>, 0.0F);  // left side down
    run(2.0);
    EXPECT_TRUE(has_said("[cal] left side done, rotate to a different side"));
    turn(0.0F, 0.0F);
    run(2.0);
    EXPECT_TRUE(has_said("[cal] down side already completed"));
    EXPECT_TRUE(is_running_);
}

TEST_F(CalibrationTest, finds_the_offset_of_the_magnetometer_while_it_is_turned) {
    begin(Action::kMag);
    for (int i = 0; i < 4000 && is_running_; ++i) {
        const float t = 0.01F * static_cast<float>(i);
        turn(1.1F * t, 0.7F * t, 0.3F * t);
        step();
    }
    EXPECT_EQ(said_.back(), "[cal] calibration done: mag");
    step();
    expect_near(magnetometer_.offset, true_mag_, 0.01F);
    EXPECT_EQ(params_.mag_done, 1);
}

TEST_F(CalibrationTest, a_magnetometer_that_is_turned_about_one_axis_is_not_calibrated) {
    begin(Action::kMag);
    for (int i = 0; i < 6000; ++i) {
        turn(0.0F, 0.0F, 0.01F * static_cast<float>(i));
        step();
    }
    EXPECT_TRUE(is_running_);
    EXPECT_EQ(params_.mag_done, 0);
}

TEST_F(CalibrationTest, finds_how_the_sensors_are_turned_in_the_vehicle) {
    true_accel_ = Vector::Zero();
    true_scale_ = Vector::Ones();
    const auto turned = math::from_euler(math::EulerAngles<float>{0.06F, -0.09F, 0.0F});
    mounting_ = turned.toRotationMatrix();
    begin(Action::kLevel);
    run(3.0);
    EXPECT_EQ(said_.back(), "[cal] calibration done: level");
    EXPECT_NEAR(params_.level_roll, 0.06F, 2e-3F);
    EXPECT_NEAR(params_.level_pitch, -0.09F, 2e-3F);
    Vector mean = Vector::Zero();
    for (int i = 0; i < 200; ++i) {
        step();
        mean += math::vector(accel_.xyz) / 200.0F;
    }
    EXPECT_NEAR(mean.x(), 0.0F, 0.03F);
    EXPECT_NEAR(mean.y(), 0.0F, 0.03F);
    // What is level already stays so.
    begin(Action::kLevel);
    run(3.0);
    EXPECT_NEAR(params_.level_roll, 0.06F, 2e-3F);
    turn(0.4F, 0.0F);
    begin(Action::kLevel);
    run(3.0);
    EXPECT_EQ(said_.back(), "[cal] calibration failed: it is not level");
    EXPECT_NEAR(params_.level_roll, 0.06F, 2e-3F);
}

TEST_F(CalibrationTest, a_command_or_arming_ends_it_and_nothing_has_changed) {
    begin(Action::kGyro);
    run(2.0);
    begin(Action::kCancel);
    EXPECT_EQ(said_.back(), "[cal] calibration cancelled");
    EXPECT_FALSE(is_running_);
    begin(Action::kAccel);
    run(1.0);
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    step();
    EXPECT_EQ(said_.back(), "[cal] calibration cancelled");
    run(10.0);
    begin(Action::kGyro);
    run(10.0);
    EXPECT_EQ(params_.gyro_offset_x, 0.0F) << "not while it is armed";
    EXPECT_FALSE(is_running_);
}

TEST_F(CalibrationTest, a_second_request_does_not_disturb_the_first) {
    begin(Action::kGyro);
    run(2.0);
    begin(Action::kMag);
    run(4.0);
    EXPECT_EQ(said_.back(), "[cal] calibration done: gyro");
}

TEST_F(CalibrationTest, a_part_that_is_broken_is_refused) {
    true_gyro_ = Vector(0.0F, 0.45F, 0.0F);
    begin(Action::kGyro);
    run(6.0);
    EXPECT_EQ(said_.back(), "[cal] calibration failed: the gyro turns by itself");
    true_scale_ = Vector(1.0F, 0.7F, 1.0F);
    begin(Action::kAccel);
    show_six_sides();
    EXPECT_EQ(said_.back(), "[cal] calibration failed: accelerometer far off");
    EXPECT_EQ(params_.accel_done, 0);
}

TEST_F(CalibrationTest, a_parameter_that_is_refused_ends_it) {
    result_ = ParameterValue::Result::kArmed;
    begin(Action::kGyro);
    run(6.0);
    EXPECT_EQ(said_.back(), "[cal] calibration failed: a parameter was refused");
}

TEST_F(CalibrationTest, samples_that_are_no_numbers_are_left_out) {
    begin(Action::kGyro);
    run(2.0);
    true_gyro_.x() = math::canonical_nan<float>();
    run(1.0);
    true_gyro_.x() = 0.02F;
    run(5.0);
    EXPECT_EQ(said_.back(), "[cal] calibration done: gyro");
    expect_near(imu_.gyro_offset, true_gyro_, 5e-4F);
}

}  // namespace
}  // namespace stator::apps::calibration
